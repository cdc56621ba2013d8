//! The lobes of kernels/bsdf: samples follow the density, evaluation agrees with sampling, no light is made, nothing is
//! ever infinite.
//!
//! Every closure that is a lobe is called by its constructor, with the parameter sets of tests/src/bsdf/cases.rs. The
//! chi-squared test is that of Mitsuba 3 with a Sidak correction over all cases of a run; seeds are fixed.

use oslcl_compiler::builtins::{CLOSURES, ClosureRole};
use oslcl_runtime::precision::Precision;
use oslcl_tests::bsdf::statistics::{chi2_p_value, sidak};
use oslcl_tests::bsdf::{self, BINS, Case, Lab, Sample, cases, dot};
use oslcl_tests::hard_cases::is_full;

const REFLECT: i32 = 1;
const TRANSMIT: i32 = 2;
const DELTA: i32 = 4;

/// Probability that the chi-squared tests of a run fail though all is right; seeds are fixed, so a pass stays a pass.
const SIGNIFICANCE: f64 = 0.01;

/// Samples of a case; the fast part takes half.
const SAMPLES: usize = 64 * 1024;

/// Points per bin and direction of the quadrature, and of the finer one that decides when the first looks bad: near
/// critical angles and the horizon the density is not smooth.
const STEPS: [i32; 2] = [16, 64];

/// Part of the samples for which rounding may spoil an agreement: those in the far tails and at critical angles.
const OUTLIERS: f64 = 0.005;

/// What a case is up to: collects what it fails.
struct Examination<'a> {
    case: &'a Case,
    /// Relative error that rounding explains.
    tolerance: f64,
    failures: Vec<String>,
}

impl Examination<'_> {
    fn check(&mut self, holds: bool, what: impl FnOnce() -> String) {
        if !holds {
            self.failures.push(format!("{}: {:?}", what(), self.case));
        }
    }

    /// All but the outliers of the samples fulfil something.
    fn most<'s>(&mut self, samples: impl Iterator<Item = &'s Sample>, what: &str, holds: impl Fn(&Sample) -> bool) {
        let (mut count, mut broken, mut first) = (0usize, 0usize, None);
        for sample in samples {
            count += 1;
            if !holds(sample) {
                broken += 1;
                first = first.or(Some(*sample));
            }
        }
        let allowed = (OUTLIERS * count as f64) as usize;
        self.check(broken <= allowed, || format!("{what}: {broken} of {count} samples, first {first:?}"));
    }
}

/// Whether two numbers agree, as a part of the larger one.
fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * a.abs().max(b.abs()) + 1e-12
}

/// The relative error of f that the rounding of directions explains: microfacet normals are known to epsilon, against
/// the width of the lobe; refraction with nearly equal indices magnifies it once more.
fn tolerance(case: &Case, epsilon: f64) -> f64 {
    let width = match case.closure {
        3 => (case.a + 1.0).powf(-0.5),
        4 | 5 | 10 | 15 | 16 => case.a.min(case.b).max(1e-4),
        20 => 0.1,
        // Sheen's transform stretches directions by its roughness.
        19 => 0.1 * case.a,
        6 => case.a.max(1e-4),
        _ => 1.0,
    };
    let bend = match case.closure {
        5 | 6 | 15 | 16 if case.refract != 0 && case.eta > 0.0 => (case.eta - 1.0).abs().clamp(1e-3, 1.0),
        _ => 1.0,
    };
    let cos = dot(case.n, case.wo()).max(1e-3);
    256.0 * epsilon / (width * bend * cos)
}

/// Whether a film leaves hardly anything of a channel: a small difference of the other two then, with few digits.
fn faint(case: &Case, s: &Sample, channel: usize) -> bool {
    case.dist & 4 != 0 && s.value[channel] < 0.02 * s.value.iter().fold(0.0, |a: f64, b| a.max(*b))
}

fn finite(sample: &Sample) -> bool {
    let vectors = [sample.wi, sample.value, sample.f, sample.swapped];
    let all = vectors.iter().flatten().chain([&sample.pdf, &sample.eval_pdf, &sample.albedo]);
    all.copied().all(f64::is_finite)
}

/// Everything but the chi-squared test, whose p-value is returned.
fn examine(lab: &Lab, case: &Case, samples: usize, seed: u32) -> (Vec<String>, Option<f64>) {
    // A lobe with one direction needs no statistics.
    let is_smooth = matches!(case.closure, 7 | 8 | 9 | 11 | 21) || (case.closure == 6 && case.a < 1e-4);
    let samples = if is_smooth { 1024 } else { samples };
    let drawn = lab.sample(case, samples, seed).expect("the lobe is sampled");
    let mut exam = Examination { case, tolerance: tolerance(case, lab.epsilon()), failures: Vec::new() };
    exam.check(drawn.iter().all(finite), || "not finite".into());
    let taken: Vec<Sample> = drawn.iter().filter(|s| s.flags != 0).copied().collect();
    directions(&mut exam, &taken, lab.epsilon());
    agreement(&mut exam, &taken);
    reciprocity(&mut exam, &taken);
    energy(&mut exam, &drawn);
    let is_delta = taken.iter().any(|s| s.flags & DELTA != 0);
    // At grazing incidence a lobe is too thin for the quadrature.
    let p = if is_delta || case.degrees > 85.0 { None } else { Some(quadrature(&mut exam, lab, &drawn)) };
    (exam.failures, p)
}

/// Directions are unit vectors on the side that the flags tell; delta lobes have one direction and no density.
fn directions(exam: &mut Examination, taken: &[Sample], epsilon: f64) {
    let case = exam.case;
    let unit = |s: &Sample| (dot(s.wi, s.wi) - 1.0).abs() < 32.0 * epsilon;
    exam.check(taken.iter().all(unit), || "a direction is not of unit length".into());
    let on_its_side = |s: &Sample| {
        let side = dot(case.n, s.wi);
        if s.flags & REFLECT != 0 { side > -4.0 * epsilon } else { side < 4.0 * epsilon }
    };
    exam.check(taken.iter().all(on_its_side), || "a direction is on the wrong side".into());
    let one_of_both = |s: &Sample| (s.flags & REFLECT != 0) != (s.flags & TRANSMIT != 0);
    exam.check(taken.iter().all(one_of_both), || "flags".into());
    let straight = matches!(case.closure, 11 | 21);
    let refracted = if straight { case.wo().map(|x| -x) } else { case.refracted(case.eta).0 };
    let exact = |s: &Sample| {
        let wanted = if s.flags & REFLECT != 0 { case.mirror() } else { refracted };
        let error = bsdf::add(s.wi, wanted, -1.0);
        s.pdf == 0.0 && s.eval_pdf == 0.0 && s.f == [0.0; 3] && dot(error, error).sqrt() < 64.0 * epsilon
    };
    exam.most(taken.iter().filter(|s| s.flags & DELTA != 0), "delta direction", exact);
}

/// Density and value of a sample are those of the evaluation.
fn agreement(exam: &mut Examination, taken: &[Sample]) {
    let (case, tolerance) = (exam.case, exam.tolerance);
    let rough = || taken.iter().filter(|s| s.flags & DELTA == 0);
    exam.most(rough(), "pdf of sample and eval", |s| s.pdf > 0.0 && close(s.pdf, s.eval_pdf, tolerance));
    exam.most(rough(), "value is not f / pdf", |s| {
        (0..3).all(|c| close(s.value[c], s.f[c] / s.eval_pdf, 2.0 * tolerance) || faint(case, s, c))
    });
    exam.check(taken.iter().all(|s| s.value.iter().all(|v| *v >= 0.0)), || "a negative value".into());
}

/// f(wo, wi) = f(wi, wo) of reflection.
fn reciprocity(exam: &mut Examination, taken: &[Sample]) {
    // Fitted and offset-dependent lobes are not reciprocal.
    if exam.case.closure == 20 || (exam.case.closure == 19 && exam.case.refract == 1) {
        return;
    }
    let case = exam.case;
    let (n, wo, tolerance) = (exam.case.n, exam.case.wo(), exam.tolerance);
    let reflected = taken.iter().filter(|s| s.flags & REFLECT != 0 && s.flags & DELTA == 0);
    exam.most(reflected, "reciprocity", |s| {
        let (ci, co) = (dot(n, s.wi), dot(n, wo));
        // Shallow directions have few digits in their cosine.
        let slack = 4.0 * tolerance * (1.0 + 0.01 / ci);
        (0..3).all(|c| close(s.f[c] * co, s.swapped[c] * ci, slack) || faint(case, s, c))
    });
}

/// No more light leaves than came; the albedo estimate is no zero where there is light.
fn energy(exam: &mut Examination, drawn: &[Sample]) {
    let count = drawn.len() as f64;
    let albedo = drawn.first().map_or(0.0, |s| s.albedo);
    exam.check((0.0..=1.0).contains(&albedo), || format!("albedo {albedo}"));
    for channel in 0..3 {
        let values = || drawn.iter().map(|s| if s.flags != 0 { s.value[channel] } else { 0.0 });
        let mean = values().sum::<f64>() / count;
        let variance = values().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
        let noise = 4.5 * (variance / count).sqrt() + 1e-5;
        exam.check(mean <= 1.0 + noise, || format!("energy {mean} +- {noise}"));
        exam.check(mean == 0.0 || albedo > 0.0, || format!("energy {mean} but albedo 0"));
        let layered = drawn.first().map_or(0.0, |s| s.albedo3[channel]);
        let bound = albedo_error(exam.case) + noise;
        exam.check((layered - mean).abs() <= bound, || {
            format!("energy {mean} +- {noise}, but albedo {layered} for layers")
        });
        if let Some(known) = known_energy(exam.case) {
            exam.check((mean - known).abs() <= noise + 2e-3, || format!("energy {mean}, not {known}"));
        }
    }
}

/// How far the albedo that layer() takes may be from the truth (docs/closures.md).
fn albedo_error(case: &Case) -> f64 {
    match case.closure {
        // Sheen's rational fit.
        19 if case.refract == 0 => 0.09,
        0 | 2 | 7 | 8 | 9 | 11 | 12 | 17..=21 => 2e-3,
        _ if case.degrees > 85.0 => 0.08,
        _ => 0.04,
    }
}

/// The share of light that a case scatters, where it is known.
fn known_energy(case: &Case) -> Option<f64> {
    match case.closure {
        0 | 2 | 8 | 11 | 12 | 17 | 18 | 21 => Some(1.0),
        13 if case.refract == 1 => Some(1.0),
        1 if case.a < 1e-6 => Some(1.0),
        // Few facets shade each other when they are hardly tilted.
        5 | 6 if case.refract == 2 && case.a <= 1e-3 && case.b <= 1e-3 && case.degrees < 70.0 => Some(1.0),
        _ => None,
    }
}

/// Samples against the integral of the density over bins; the energy of samples against that of f.
fn quadrature(exam: &mut Examination, lab: &Lab, drawn: &[Sample]) -> f64 {
    let case = exam.case;
    let grids = case.grids();
    let mut observed = vec![0.0; BINS];
    drawn.iter().filter(|s| s.flags != 0).for_each(|s| observed[case.bin(&grids, s.wi)] += 1.0);
    let count = drawn.len() as f64;
    let taken = observed.iter().sum::<f64>() / count;
    let noise = 4.5 * (taken * (1.0 - taken) / count).max(0.0).sqrt();
    let mean = mean_value(drawn);
    let squares = drawn.iter().filter(|s| s.flags != 0).map(|s| s.value[0] * s.value[0]).sum::<f64>() / count;
    let mean_noise = 4.5 * ((squares - mean * mean).max(0.0) / count).sqrt();
    for steps in STEPS {
        let (density, energy) = lab.integrate(case, steps).expect("the lobe is integrated");
        let (total, f) = (density.iter().sum::<f64>(), energy.iter().sum::<f64>());
        let expected: Vec<f64> = density.iter().map(|d| d * count).collect();
        let p = chi2_p_value(&observed, &expected);
        let totals_agree = (taken - total).abs() < noise + 4e-3;
        let energies_agree = (f - mean).abs() < mean_noise + 3e-3 * f.max(0.3);
        if p > 0.01 && totals_agree && energies_agree {
            return p;
        }
        if steps == STEPS[1] {
            exam.check(totals_agree, || format!("{taken} of the samples, but density of {total}"));
            exam.check(energies_agree, || format!("energy {mean} by samples, {f} by f"));
            return p;
        }
    }
    0.0
}

fn mean_value(drawn: &[Sample]) -> f64 {
    drawn.iter().filter(|s| s.flags != 0).map(|s| s.value[0]).sum::<f64>() / drawn.len() as f64
}

fn examine_all(precision: Precision, cases: &[Case], samples: usize) {
    let lab = Lab::new(precision).expect("the kernels build");
    let mut failures = Vec::new();
    let mut p_values = Vec::new();
    for (index, case) in cases.iter().enumerate() {
        let (broken, p) = examine(&lab, case, samples, 1 + index as u32);
        failures.extend(broken);
        p_values.extend(p.map(|p| (p, case)));
    }
    let threshold = sidak(SIGNIFICANCE, p_values.len());
    let unlikely = p_values.iter().filter(|(p, _)| *p < threshold);
    failures.extend(unlikely.map(|(p, case)| format!("chi-squared: p = {p:e}: {case:?}")));
    assert!(failures.is_empty(), "{} failures\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn every_lobe_has_cases() {
    let rows = CLOSURES.iter().filter(|r| matches!(r.role, ClosureRole::Lobe(_) | ClosureRole::Transparent));
    let mut wanted: Vec<String> = rows.map(|r| format!("{}({})", r.name, r.args)).collect();
    let mut tested: Vec<String> = bsdf::CLOSURES.map(str::to_owned).to_vec();
    wanted.sort();
    tested.sort();
    assert_eq!(wanted, tested);
    for cases in [cases::all(), cases::some(), part(cases::all(), 2), part(cases::some(), 3)] {
        for (index, name) in bsdf::CLOSURES.iter().enumerate() {
            assert!(cases.iter().any(|c| c.closure == index), "no case for {name}");
        }
    }
}

#[test]
fn lobes_in_f32() {
    let samples = if is_full() { SAMPLES } else { SAMPLES / 2 };
    examine_all(Precision::Standard, &part(cases::all(), 2), samples);
}

/// The fast part looks at one in so many cases of each closure.
fn part(cases: Vec<Case>, step: usize) -> Vec<Case> {
    let mut seen = [0_usize; bsdf::CLOSURES.len()];
    let mut counts = |case: &Case| {
        // Not every other one: what alternates from case to case would have one value only.
        let hash = (seen[case.closure].wrapping_mul(0x9e37_79b9) >> 16) & 0xffff;
        seen[case.closure] += 1;
        is_full() || hash % step == 0
    };
    cases.into_iter().filter(|case| counts(case)).collect()
}

#[test]
fn lobes_in_relaxed_f32() {
    examine_all(Precision::Fast, &part(cases::some(), 3), SAMPLES / 2);
}

#[test]
fn lobes_in_f64() {
    examine_all(Precision::Reference, &part(cases::some(), 3), SAMPLES / 2);
}

#[test]
fn smooth_reflection_and_refraction_share_the_light() {
    let lab = Lab::new(Precision::Standard).expect("the kernels build");
    for degrees in [0.0, 30.0, 60.0, 80.0, 89.9] {
        for eta in [1.5, 1.0 / 1.5, 1.0 + 2e-7, 1.0 - 2e-7] {
            let mean = |closure| {
                let case = Case { eta, ..cases::case(closure, degrees) };
                mean_value(&lab.sample(&Case { n: [0.0, 0.0, 1.0], ..case }, 32, 1).expect("the lobe is sampled"))
            };
            let sum = mean(7) + mean(9);
            assert!((sum - 1.0).abs() < 1e-6, "eta {eta} at {degrees}: {sum}");
        }
    }
}

#[test]
fn a_film_on_glass_is_one_on_a_metal_that_hardly_absorbs() {
    let lab = Lab::new(Precision::Standard).expect("the kernels build");
    for degrees in [0.0, 30.0, 60.0, 80.0, 89.0] {
        for eta in [1.2, 1.5, 3.0] {
            // The one sums the film's orders over real amplitudes, the other over complex ones.
            let mean = |closure| {
                let metal = Case { ior: [eta; 3], extinction: [1e-7; 3], eta, ..cases::case(closure, degrees) };
                let smooth = Case { dist: 4, refract: 0, a: 0.0, b: 0.0, n: [0.0, 0.0, 1.0], ..metal };
                mean_value(&lab.sample(&smooth, 32, 1).expect("the lobe is sampled"))
            };
            let (glass, metal) = (mean(15), mean(10));
            assert!(glass > 1e-3 && (glass - metal).abs() < 2e-5, "eta {eta} at {degrees}: {glass}, {metal}");
        }
    }
}

#[test]
fn the_mean_over_picks_is_the_sum_of_all() {
    let lab = Lab::new(Precision::Standard).expect("the kernels build");
    let case = Case { a: 0.2, b: 0.2, eta: 1.5, n: [0.0, 0.0, 1.0], ..cases::case(0, 40.0) };
    // Closure, its LOBE_ number (kernels/lobe.h), weight.
    let lobes = [
        (0, 1, [0.5, 0.25, 0.0]),
        (2, 3, [0.0, 1.5, 0.125]),
        (7, 7, [1.0, 1.0, 1.0]),
        (4, 5, [0.0, 0.0, 0.0]),
        (10, 10, [-0.25, 0.5, 0.0]),
        (11, 9, [1e-3, 0.0, 0.0]),
        (1, 2, [f64::NAN, 1.0, 1.0]),
        (3, 4, [f64::INFINITY, 1.0, 1.0]),
    ];
    const PICKS: usize = 1 << 20;
    for from in 0..lobes.len() {
        // Each is offered first once: then nothing is there to compare it with.
        let turned: Vec<_> = (0..lobes.len()).map(|i| lobes[(from + i) % lobes.len()]).collect();
        let offers: Vec<_> = turned.iter().map(|(closure, _, weight)| (*closure, *weight)).collect();
        let picks = lab.pick(&case, &offers, PICKS).expect("lobes are picked");
        for (_, kind, weight) in &lobes {
            let mine = || picks.iter().filter(|p| p.0 == *kind);
            for channel in 0..3 {
                let mean = mine().map(|p| p.1[channel]).sum::<f64>() / PICKS as f64;
                // What has no finite weight is never taken.
                let wanted = if weight.iter().all(|w| w.is_finite()) { weight[channel] } else { 0.0 };
                assert!((mean - wanted).abs() < 1e-3 * wanted.abs() + 1e-5, "lobe {kind}: {mean}, not {wanted}");
            }
        }
    }
    let nothing = lab.pick(&case, &[(4, [0.0; 3])], 32).expect("lobes are picked");
    assert!(nothing.iter().all(|p| *p == (0, [0.0; 3])));
}

#[test]
fn wild_parameters_give_finite_numbers() {
    for precision in [Precision::Standard, Precision::Reference] {
        let lab = Lab::new(precision).expect("the kernels build");
        let results = lab.wild(1 << 19, 7).expect("the lobes are asked");
        let mut wrong = std::collections::BTreeMap::new();
        results.iter().filter(|r| r.0 != 0).for_each(|r| *wrong.entry((r.0, r.1 % 32)).or_insert(0) += 1);
        assert!(wrong.is_empty(), "{precision:?}, (what, closure): count {wrong:?}");
    }
}
