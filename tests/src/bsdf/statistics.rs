//! The chi-squared test of samples against a density, as Mitsuba's chi2 tool does it (Pharr, Jakob, Humphreys, "Physically
//! Based Rendering", and Jakob's `chi2test`).
//!
//! In: counts and expected counts per bin. Out: p-values. It must not know what was sampled.

/// Bins that expect fewer samples are pooled: the distribution of the statistic holds for large counts only.
const MIN_EXPECTED: f64 = 5.0;

/// The probability of a deviation at least as large as the one observed, if the samples do follow the expectation.
/// 0 when there are samples where none can be.
pub fn chi2_p_value(observed: &[f64], expected: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|a, b| expected[*a].total_cmp(&expected[*b]));
    let (mut statistic, mut cells) = (0.0, 0u32);
    let (mut pooled_observed, mut pooled_expected) = (0.0, 0.0);
    let mut add = |o: f64, e: f64| {
        statistic += (o - e) * (o - e) / e;
        cells += 1;
    };
    for i in order {
        let small = expected[i] < MIN_EXPECTED || (pooled_expected > 0.0 && pooled_expected < MIN_EXPECTED);
        if small {
            pooled_observed += observed[i];
            pooled_expected += expected[i];
        } else {
            add(observed[i], expected[i]);
        }
    }
    if pooled_expected >= MIN_EXPECTED {
        add(pooled_observed, pooled_expected);
    } else if pooled_observed > MIN_EXPECTED * 4.0 {
        return 0.0;
    }
    if cells < 2 {
        return 1.0;
    }
    upper_gamma(f64::from(cells - 1) / 2.0, statistic / 2.0)
}

/// The significance of each of `count` tests such that all pass with probability `1 - significance` when all should.
pub fn sidak(significance: f64, count: usize) -> f64 {
    1.0 - (1.0 - significance).powf(1.0 / count.max(1) as f64)
}

/// The regularised upper incomplete gamma function Q(a, x). Press et al., "Numerical Recipes", sec. 6.2.
fn upper_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-15 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - sum * front;
    }
    // Lentz's continued fraction.
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut h = d;
    for i in 1..10_000 {
        let i = f64::from(i);
        let an = -i * (i - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    h * front
}

/// Lanczos' approximation, g = 5.
fn ln_gamma(x: f64) -> f64 {
    const C: [f64; 6] = [
        76.18009172947146,
        -86.50532032941677,
        24.01409824083091,
        -1.231739572450155,
        0.1208650973866179e-2,
        -0.5395239384953e-5,
    ];
    let base = x + 5.5;
    let series = C.iter().enumerate().fold(1.000000000190015, |s, (i, c)| s + c / (x + 1.0 + i as f64));
    (x + 0.5) * base.ln() - base + (2.5066282746310005 * series / x).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gamma_function_has_known_values() {
        // Q(1, x) = exp(-x); the 95 % point of chi-squared with 10 degrees of freedom is 18.307.
        assert!((upper_gamma(1.0, 2.0) - (-2.0f64).exp()).abs() < 1e-9);
        assert!((upper_gamma(5.0, 18.307 / 2.0) - 0.05).abs() < 1e-5);
    }

    #[test]
    fn a_wrong_density_is_found_and_a_right_one_passes() {
        let expected = vec![100.0; 50];
        let mut observed: Vec<f64> = (0..50).map(|i| if i % 2 == 0 { 108.0 } else { 92.0 }).collect();
        assert!(chi2_p_value(&observed, &expected) > 0.1);
        observed[0] = 190.0;
        assert!(chi2_p_value(&observed, &expected) < 1e-6);
    }
}
