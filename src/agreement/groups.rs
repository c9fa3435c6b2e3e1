//! Statistics of the separation of classes in a matrix of distances.

use super::pairs::{PairMatrix, median};
use super::test::sizes;

fn check(distances: &PairMatrix, labels: &[usize]) {
    assert_eq!(labels.len(), distances.size(), "one label a case");
}

/// R of the analysis of similarities: how much the ranks of distances between classes exceed those within.
///
/// ```text
/// R = (mean rank between − mean rank within)/(M/2),   M: number of pairs, N (N − 1)/2 where all are known
/// ```
///
/// 1 if every pair between classes is farther apart than every pair within, 0 by chance. K. R. Clarke, Aust. J. Ecol. 18,
/// 117 (1993). Sensitive to different spreads of the classes. Unknown pairs are left out. NaN without pairs of both kinds.
/// The ranks ([`PairMatrix::ranks`]) are the same for all permutations of the labels.
///
/// # Panics
/// If there is not one label per case.
pub fn anosim_of_ranks(ranks: &PairMatrix, labels: &[usize]) -> f64 {
    check(ranks, labels);
    let mut sums = [[0.0; 2]; 2];
    for (i, j, rank) in ranks.pairs().filter(|pair| !pair.2.is_nan()) {
        let own = &mut sums[usize::from(labels[i] == labels[j])];
        own[0] += rank;
        own[1] += 1.0;
    }
    let [between, within] = sums;
    let half = 0.5 * (between[1] + within[1]);
    (between[0] / between[1] - within[0] / within[1]) / half
}

/// Pseudo-F of the permutational analysis of variance: squared distances between classes against those within.
///
/// ```text
/// F = ((SS − SS_w)/(a − 1)) / (SS_w/(N − a)),   SS = Σ_{i<j} d²/N,   SS_w = Σ_classes Σ_{i<j in it} d²/n
/// ```
///
/// a: number of classes. M. J. Anderson, Austral Ecol. 26, 32 (2001). Also large if spreads differ: check [`permdisp`]. NaN
/// unless all pairs are known.
///
/// # Panics
/// If there is not one label per case.
pub fn permanova(distances: &PairMatrix, labels: &[usize]) -> f64 {
    check(distances, labels);
    let sizes = sizes(labels);
    let classes = sizes.iter().filter(|n| **n > 0).count() as f64;
    let count = labels.len() as f64;
    let (mut all, mut within) = (0.0, 0.0);
    for (i, j, distance) in distances.pairs() {
        let square = distance * distance;
        all += square / count;
        if labels[i] == labels[j] {
            within += square / sizes[labels[i]] as f64;
        }
    }
    ((all - within) / (classes - 1.0)) / (within / (count - classes))
}

/// Distance of each case from the centroid of its class, computed from distances alone.
///
/// ```text
/// zᵢ² = |Σ_{j in the class} dᵢⱼ²/n − Σ_{j<k in the class} dⱼₖ²/n²|
/// ```
///
/// M. J. Anderson, Biometrics 62, 245 (2006). Exact for Euclidean distances; other distances can give negative sums, hence
/// |·|.
///
/// # Panics
/// If there is not one label per case.
pub fn dispersions(distances: &PairMatrix, labels: &[usize]) -> Vec<f64> {
    check(distances, labels);
    let sizes = sizes(labels);
    let mut own = vec![0.0; labels.len()];
    let mut total = vec![0.0; sizes.len()];
    for (i, j, distance) in distances
        .pairs()
        .filter(|&(i, j, _)| labels[i] == labels[j])
    {
        let square = distance * distance;
        own[i] += square;
        own[j] += square;
        total[labels[i]] += square;
    }
    let centred = own.iter().zip(labels).map(|(own, &label)| {
        let n = sizes[label] as f64;
        (own / n - total[label] / (n * n)).abs().sqrt()
    });
    centred.collect()
}

/// F of the analysis of variance of [`dispersions`]: whether the classes have different spreads.
///
/// ```text
/// F = (Σ n (z̄ₖ − z̄)²/(a − 1)) / (Σ (zᵢ − z̄ₖ)²/(N − a))
/// ```
///
/// A high F warns that [`permanova`] and [`anosim_of_ranks`] may reflect spread instead of location. M. J. Anderson, Biometrics 62,
/// 245 (2006), with centroids. NaN if a pair within a class is unknown.
///
/// # Panics
/// If there is not one label per case.
pub fn permdisp(distances: &PairMatrix, labels: &[usize]) -> f64 {
    let spread = dispersions(distances, labels);
    let sizes = sizes(labels);
    let count = spread.len() as f64;
    let classes = sizes.iter().filter(|n| **n > 0).count() as f64;
    let mut means = vec![0.0; sizes.len()];
    for (z, &label) in spread.iter().zip(labels) {
        means[label] += z / sizes[label] as f64;
    }
    let mean = spread.iter().sum::<f64>() / count;
    let (mut between, mut within) = (0.0, 0.0);
    for (z, &label) in spread.iter().zip(labels) {
        between += (means[label] - mean).powi(2);
        within += (z - means[label]).powi(2);
    }
    (between / (classes - 1.0)) / (within / (count - classes))
}

/// Silhouette of each case: how much nearer its own class is than the nearest other class.
///
/// ```text
/// s = (b − a)/max(a, b),   a: mean distance to its class, b: least mean distance to another
/// ```
///
/// P. J. Rousseeuw, J. Comput. Appl. Math. 20, 53 (1987). 0 for a case alone in its class. Unknown pairs are left out; NaN
/// if no distance to its own class, or none to another class, is known.
///
/// # Panics
/// If there is not one label per case.
pub fn silhouette(distances: &PairMatrix, labels: &[usize]) -> Vec<f64> {
    check(distances, labels);
    let sizes = sizes(labels);
    let mut sums = vec![vec![[0.0; 2]; sizes.len()]; labels.len()];
    for (i, j, distance) in distances.pairs().filter(|pair| !pair.2.is_nan()) {
        for (from, to) in [(i, j), (j, i)] {
            let own = &mut sums[from][labels[to]];
            own[0] += distance;
            own[1] += 1.0;
        }
    }
    let cases = sums.iter().zip(labels).map(|(sums, &label)| {
        if sizes[label] == 1 {
            return 0.0;
        }
        let mean = |[sum, count]: [f64; 2]| sum / count;
        let others = sums.iter().enumerate().filter(|(class, _)| *class != label);
        let nearest = others.map(|(_, own)| mean(*own)).fold(f64::NAN, f64::min);
        let own = mean(sums[label]);
        if own.is_nan() || nearest.is_nan() {
            f64::NAN
        } else if own.max(nearest) > 0.0 {
            (nearest - own) / own.max(nearest)
        } else {
            0.0
        }
    });
    cases.collect()
}

/// Barriers between two classes compared with those within them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarrierRatio {
    /// Median between the classes / median within either of them; NaN without pairs of both kinds.
    pub ratio: f64,
    /// Cliff's delta of the barriers between over those within, see [`cliffs_delta`].
    pub delta: f64,
    /// Number of pairs between.
    pub between: usize,
    /// Number of pairs within.
    pub within: usize,
}

/// Compares barriers between classes `a` and `b` with those within them; unknown pairs are left out.
///
/// # Panics
/// If there is not one label per case.
pub fn barrier_ratio(barriers: &PairMatrix, labels: &[usize], [a, b]: [usize; 2]) -> BarrierRatio {
    check(barriers, labels);
    let (mut between, mut within) = (Vec::new(), Vec::new());
    let known = barriers.pairs().filter(|pair| !pair.2.is_nan());
    for (i, j, barrier) in known {
        match (labels[i], labels[j]) {
            (x, y) if x == y && (x == a || x == b) => within.push(barrier),
            (x, y) if (x, y) == (a, b) || (x, y) == (b, a) => between.push(barrier),
            _ => {}
        }
    }
    BarrierRatio {
        delta: cliffs_delta(&between, &within),
        between: between.len(),
        within: within.len(),
        ratio: median(between) / median(within),
    }
}

/// Cliff's delta: P(x > y) − P(x < y) for one number of each list, −1 to 1.
///
/// N. Cliff, Psychol. Bull. 114, 494 (1993). NaN if a list is empty.
pub fn cliffs_delta(x: &[f64], y: &[f64]) -> f64 {
    let mut sorted = y.to_vec();
    sorted.sort_by(f64::total_cmp);
    let balance = x.iter().map(|x| {
        let below = sorted.partition_point(|y| y < x) as f64;
        let above = sorted.len() as f64 - sorted.partition_point(|y| y <= x) as f64;
        below - above
    });
    balance.sum::<f64>() / (x.len() as f64 * y.len() as f64)
}
