//! Who is not beaten by anybody in both time and error.

/// For each (time, error), whether nobody is at least as good in both and better in one. NaN is beaten by all.
pub fn pareto(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    points.iter().map(|p| !p.0.is_nan() && !p.1.is_nan() && !points.iter().any(|q| beats(q, p))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nobody_beats() {
        let points = [(1.0, 4.0), (2.0, 2.0), (2.0, 3.0), (4.0, 1.0), (3.0, 2.5), (1.0, 4.0), (f64::NAN, 0.0)];
        assert_eq!(pareto(&points), [true, true, false, true, false, true, false]);
        assert!(pareto(&[]).is_empty());
    }
}
