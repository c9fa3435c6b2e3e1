//! Correlations of numbers on pairs, of trees and of matrices.

use super::pairs::{PairMatrix, ranks};
use super::test::{Permutations, Tested, test_order};

/// Pearson's correlation over places where both numbers are known; NaN if one list does not vary.
///
/// # Panics
/// If the lists differ in length.
pub fn pearson(x: &[f64], y: &[f64]) -> f64 {
    assert_eq!(x.len(), y.len(), "numbers of the same pairs");
    let known = || x.iter().zip(y).filter(|(x, y)| !x.is_nan() && !y.is_nan());
    let count = known().count() as f64;
    let mean_x = known().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = known().map(|(_, y)| y).sum::<f64>() / count;
    let (mut both, mut of_x, mut of_y) = (0.0, 0.0, 0.0);
    for (x, y) in known() {
        both += (x - mean_x) * (y - mean_y);
        of_x += (x - mean_x).powi(2);
        of_y += (y - mean_y).powi(2);
    }
    // Variation within rounding counts as none.
    let varies = |squares: f64, mean: f64| squares > 1e-24 * count * mean * mean && squares > 0.0;
    if varies(of_x, mean_x) && varies(of_y, mean_y) {
        (both / (of_x * of_y).sqrt()).clamp(-1.0, 1.0)
    } else {
        f64::NAN
    }
}

/// Spearman's correlation: [`pearson`] of the ranks over places where both numbers are known; ties share their mean rank.
///
/// # Panics
/// If the lists differ in length.
pub fn spearman(x: &[f64], y: &[f64]) -> f64 {
    let masked = |own: &[f64], other: &[f64]| -> Vec<f64> {
        let pairs = own.iter().zip(other);
        pairs
            .map(|(a, b)| if b.is_nan() { f64::NAN } else { *a })
            .collect()
    };
    pearson(&ranks(&masked(x, y)), &ranks(&masked(y, x)))
}

/// [`spearman`] of x and y without the part that a third list explains, over places where all three are known.
///
/// ```text
/// ρ = (ρ_xy − ρ_xz ρ_yz)/√((1 − ρ_xz²)(1 − ρ_yz²))
/// ```
///
/// M. G. Kendall, Biometrika 32, 277 (1942), with Spearman's correlations. NaN if a list does not vary.
///
/// # Panics
/// If the lists differ in length.
pub fn partial_spearman(x: &[f64], y: &[f64], given: &[f64]) -> f64 {
    assert_eq!(x.len(), given.len(), "numbers of the same cases");
    let unknown: Vec<bool> = (x.iter().zip(y).zip(given))
        .map(|((x, y), z)| (x + y + z).is_nan())
        .collect();
    let known = |own: &[f64]| -> Vec<f64> {
        let pairs = own.iter().zip(&unknown);
        pairs
            .filter(|(_, unknown)| !**unknown)
            .map(|(value, _)| *value)
            .collect()
    };
    let (x, y, z) = (known(x), known(y), known(given));
    without(spearman(&x, &y), spearman(&x, &z), spearman(&y, &z))
}

/// The partial correlation of x and y given z.
fn without(xy: f64, xz: f64, yz: f64) -> f64 {
    (xy - xz * yz) / ((1.0 - xz * xz) * (1.0 - yz * yz)).sqrt()
}

/// Kind of correlation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Correlation {
    /// Of the numbers, see [`pearson`].
    Pearson,
    /// Of their ranks, taken once in each whole matrix.
    Spearman,
}

impl Correlation {
    fn prepared(self, matrix: &PairMatrix) -> PairMatrix {
        match self {
            Self::Pearson => matrix.clone(),
            Self::Spearman => matrix.ranks(),
        }
    }
}

/// The Mantel test: whether pairs that are far apart in one matrix are far apart in the other.
///
/// ```text
/// r = correlation over pairs of B and D;  p by the same permutation of rows and columns of B, within blocks
/// ```
///
/// N. Mantel, Cancer Res. 27, 209 (1967). One-sided: large if both rise together. Pairs unknown in either are left out,
/// anew in every permutation.
///
/// # Panics
/// If the matrices or the blocks have different cases.
pub fn mantel(
    first: &PairMatrix,
    second: &PairMatrix,
    correlation: Correlation,
    blocks: &[usize],
    settings: &Permutations,
) -> Tested {
    assert_eq!(first.size(), second.size(), "matrices of the same cases");
    let (first, second) = (correlation.prepared(first), correlation.prepared(second));
    test_order(first.size(), blocks, settings, |order| {
        pearson(first.chosen(order, f64::NAN).values(), second.values())
    })
}

/// The partial Mantel test: [`mantel`] without the part that a third matrix explains.
///
/// ```text
/// r = (r_BD − r_BZ r_DZ)/√((1 − r_BZ²)(1 − r_DZ²))
/// ```
///
/// P. E. Smouse, J. C. Long and R. R. Sokal, Syst. Zool. 35, 627 (1986); B is permuted. Z is a possible cause of a false
/// agreement: the energy gap, the distance of poses, the sizes of families. Pairs unknown in any matrix are left out.
///
/// # Panics
/// If the matrices or the blocks have different cases.
pub fn partial_mantel(
    first: &PairMatrix,
    second: &PairMatrix,
    given: &PairMatrix,
    correlation: Correlation,
    blocks: &[usize],
    settings: &Permutations,
) -> Tested {
    assert_eq!(first.size(), second.size(), "matrices of the same cases");
    assert_eq!(first.size(), given.size(), "matrices of the same cases");
    let [first, second, given] = [first, second, given].map(|m| correlation.prepared(m));
    test_order(first.size(), blocks, settings, |order| {
        let permuted = first.chosen(order, f64::NAN);
        let keep = |own: &PairMatrix| -> Vec<f64> {
            let all = own.values().iter().zip(permuted.values());
            let all = all.zip(second.values().iter().zip(given.values()));
            all.map(|((own, a), (b, c))| if (a + b + c).is_nan() { f64::NAN } else { *own })
                .collect()
        };
        let (b, d, z) = (keep(&permuted), keep(&second), keep(&given));
        without(pearson(&b, &d), pearson(&b, &z), pearson(&d, &z))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two lists that only follow a third one are unrelated without it, and a list is fully related to itself.
    #[test]
    fn a_third_list_explains_what_two_have_in_common() {
        let z: Vec<f64> = (0..40).map(f64::from).collect();
        let wave = |period: usize| {
            move |i: usize| {
                if (i / period).is_multiple_of(2) {
                    3.0
                } else {
                    -3.0
                }
            }
        };
        let moved = |by: &dyn Fn(usize) -> f64| -> Vec<f64> {
            z.iter().enumerate().map(|(i, z)| z + by(i)).collect()
        };
        let (x, y) = (moved(&wave(1)), moved(&wave(2)));
        assert!(spearman(&x, &y) > 0.9);
        assert!(partial_spearman(&x, &y, &z).abs() < 0.2);
        assert!((partial_spearman(&x, &x, &z) - 1.0).abs() < 1e-9);
        let mut lacking = x.clone();
        lacking[7] = f64::NAN;
        assert!(partial_spearman(&lacking, &y, &z).abs() < 0.25);
    }
}
