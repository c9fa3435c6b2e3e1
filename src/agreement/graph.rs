//! Statistics of classes among neighbours on a weighted graph.

use super::pairs::PairMatrix;

/// The edges, which are pairs with known, positive weights.
fn edges(weights: &PairMatrix) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
    weights.pairs().filter(|pair| pair.2 > 0.0)
}

/// Moran's I: whether neighbours are alike.
///
/// ```text
/// I = N/W · Σᵢⱼ wᵢⱼ zᵢ zⱼ / Σ zᵢ²,   z = x − x̄,   W = Σᵢⱼ wᵢⱼ
/// ```
///
/// P. A. P. Moran, Biometrika 37, 17 (1950). −1/(N − 1) by chance. For a class use its indicator ([`indicator`]). With wᵢⱼ
/// = exp(−barrier/T), near means easy to reach. Unknown weights are not edges. NaN if x does not vary or there are no
/// edges.
///
/// # Panics
/// If there is not one value per case.
pub fn morans_i(weights: &PairMatrix, values: &[f64]) -> f64 {
    assert_eq!(values.len(), weights.size(), "one value a case");
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    let (mut products, mut total) = (0.0, 0.0);
    for (i, j, weight) in edges(weights) {
        products += weight * (values[i] - mean) * (values[j] - mean);
        total += weight;
    }
    if squares > 0.0 && total > 0.0 {
        count / total * products / squares
    } else {
        f64::NAN
    }
}

/// 1 for the cases of a class, 0 for all others.
pub fn indicator(labels: &[usize], class: usize) -> Vec<f64> {
    labels
        .iter()
        .map(|&label| f64::from(u8::from(label == class)))
        .collect()
}

/// Newman's assortativity of classes on a weighted graph, and the contribution of each class.
///
/// ```text
/// r = (Σ eₖₖ − Σ aₖ²)/(1 − Σ aₖ²),   eₖₗ: share of the weight between classes k and l, aₖ = Σₗ eₖₗ
/// ```
///
/// M. E. J. Newman, Phys. Rev. E 67, 026126 (2003). 1 if edges join only cases of one class, 0 by chance given the weights
/// at each case. The terms (eₖₖ − aₖ²)/(1 − Σ aₖ²) sum to r. NaN if there are no edges or one class has all edges.
///
/// # Panics
/// If there is not one label per case.
pub fn assortativity(weights: &PairMatrix, labels: &[usize]) -> (f64, Vec<f64>) {
    assert_eq!(labels.len(), weights.size(), "one label a case");
    let classes = labels.iter().max().map_or(0, |most| most + 1);
    let (mut within, mut ends) = (vec![0.0; classes], vec![0.0; classes]);
    let mut total = 0.0;
    for (i, j, weight) in edges(weights) {
        total += 2.0 * weight;
        ends[labels[i]] += weight;
        ends[labels[j]] += weight;
        if labels[i] == labels[j] {
            within[labels[i]] += 2.0 * weight;
        }
    }
    let chance: f64 = ends.iter().map(|a| (a / total).powi(2)).sum();
    let term = |(e, a): (&f64, &f64)| {
        let rest = 1.0 - chance;
        if rest > 1e-12 {
            (e / total - (a / total).powi(2)) / rest
        } else {
            f64::NAN
        }
    };
    let terms: Vec<f64> = within.iter().zip(&ends).map(term).collect();
    (terms.iter().sum(), terms)
}
