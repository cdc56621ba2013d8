//! Choosing one of many in proportion to weights, in constant time: Walker's alias method, built after Vose, "A Linear
//! Algorithm for Generating Random Numbers with a Given Distribution", 1991.
//!
//! In: weights, finite and not negative. Out: for each cell its probability, its own share, and who has the rest.

/// The table. All vectors have one element per weight.
#[derive(Clone, Debug, PartialEq)]
pub struct AliasTable {
    /// Probability of each, adding up to 1.
    pub probability: Vec<f64>,
    /// The part of its cell that is its own, 0..=1.
    pub share: Vec<f64>,
    /// Who has the rest of the cell.
    pub alias: Vec<u32>,
}

impl AliasTable {
    /// Builds a table. Without any positive weight all are alike.
    pub fn new(weights: &[f64]) -> AliasTable {
        let n = weights.len();
        let total: f64 = weights.iter().sum();
        let even = n > 0 && !(total > 0.0 && total.is_finite());
        let probability: Vec<f64> =
            if even { vec![1.0 / n as f64; n] } else { weights.iter().map(|w| w / total).collect() };
        let mut share: Vec<f64> = probability.iter().map(|p| p * n as f64).collect();
        let mut alias: Vec<u32> = (0..n as u32).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|i| share[*i] < 1.0);
        while let (Some(s), Some(&l)) = (small.pop(), large.last()) {
            alias[s] = l as u32;
            share[l] -= 1.0 - share[s];
            if share[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        // What is left missed 1 by rounding only.
        for i in small.into_iter().chain(large) {
            share[i] = 1.0;
            alias[i] = i as u32;
        }
        AliasTable { probability, share, alias }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_add_up_to_the_probabilities() {
        for weights in [vec![1.0], vec![0.0, 3.0, 1.0], vec![5.0; 7], vec![1e-12, 1e12, 3.0], vec![0.0, 0.0]] {
            let table = AliasTable::new(&weights);
            let n = weights.len();
            let mut got = vec![0.0; n];
            for cell in 0..n {
                got[cell] += table.share[cell] / n as f64;
                got[table.alias[cell] as usize] += (1.0 - table.share[cell]) / n as f64;
            }
            for (a, b) in got.iter().zip(&table.probability) {
                assert!((a - b).abs() < 1e-12, "{weights:?}: {got:?}");
            }
        }
    }
}
