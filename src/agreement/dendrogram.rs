//! Trees of merges, and how well they keep classes together.

use super::pairs::PairMatrix;

/// A merge of several clusters at one height.
#[derive(Debug, Clone, PartialEq)]
struct Merge {
    height: f64,
    /// Clusters that are joined: cases 0 … n − 1, then earlier merges n, n + 1, …
    parts: Vec<usize>,
}

/// The tree of an ultrametric: the cases that are joined below each height.
///
/// For any other matrix it is the tree of single linkage, whose heights are minimax over paths. The same rule gives the
/// saddle heights of a network from its edges. Merges at equal heights are one merge of several clusters, so their order
/// does not matter. Unknown pairs (NaN) join nothing, so cases that only they connect stay apart.
///
/// # Examples
/// Two pairs that lie low, joined by a high saddle: the classes of the pairs are pure branches.
///
/// ```
/// use landscape::agreement::{Dendrogram, PairMatrix};
///
/// let heights = PairMatrix::from_fn(4, |i, j| if i / 2 == j / 2 { 1.0 } else { 5.0 });
/// let tree = Dendrogram::new(&heights);
/// assert_eq!(tree.joined().get(0, 3), 5.0);
/// assert_eq!(tree.purity(&[0, 0, 1, 1], &[1.0; 4]), 1.0);
/// assert!(tree.purity(&[0, 1, 0, 1], &[1.0; 4]) < 1.0);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Dendrogram {
    cases: usize,
    merges: Vec<Merge>,
}

impl Dendrogram {
    /// The tree of `heights`.
    pub fn new(heights: &PairMatrix) -> Self {
        let cases = heights.size();
        let known = heights.pairs().filter(|(_, _, height)| !height.is_nan());
        let mut edges: Vec<(usize, usize, f64)> = known.collect();
        edges.sort_by(|a, b| a.2.total_cmp(&b.2).then((a.0, a.1).cmp(&(b.0, b.1))));
        // The current cluster of each case.
        let mut cluster: Vec<usize> = (0..cases).collect();
        let mut merges: Vec<Merge> = Vec::new();
        for (i, j, height) in edges {
            let (a, b) = (cluster[i], cluster[j]);
            if a == b {
                continue;
            }
            let same = |c: usize| c >= cases && merges[c - cases].height.total_cmp(&height).is_eq();
            let parts = match (same(a), same(b)) {
                (false, false) => vec![a, b],
                // A merge at the same height takes over the parts of the other, which stays as an empty entry.
                (true, false) => [std::mem::take(&mut merges[a - cases].parts), vec![b]].concat(),
                (false, true) => [std::mem::take(&mut merges[b - cases].parts), vec![a]].concat(),
                (true, true) => {
                    let first = std::mem::take(&mut merges[a - cases].parts);
                    [first, std::mem::take(&mut merges[b - cases].parts)].concat()
                }
            };
            let new = cases + merges.len();
            merges.push(Merge { height, parts });
            for own in &mut cluster {
                if *own == a || *own == b {
                    *own = new;
                }
            }
        }
        Self { cases, merges }
    }

    /// Number of cases.
    pub fn cases(&self) -> usize {
        self.cases
    }

    /// Height at which each pair is joined, NaN if it never is.
    pub fn joined(&self) -> PairMatrix {
        let members = self.members();
        let mut heights = vec![f64::NAN; self.cases * self.cases];
        for merge in &self.merges {
            for (place, &a) in merge.parts.iter().enumerate() {
                for &b in &merge.parts[place + 1..] {
                    for &i in &members[a] {
                        for &j in &members[b] {
                            heights[i.min(j) * self.cases + i.max(j)] = merge.height;
                        }
                    }
                }
            }
        }
        PairMatrix::from_fn(self.cases, |i, j| heights[i * self.cases + j])
    }

    /// Cases below each cluster.
    fn members(&self) -> Vec<Vec<usize>> {
        let mut members: Vec<Vec<usize>> = (0..self.cases).map(|case| vec![case]).collect();
        for merge in &self.merges {
            members.push(
                merge
                    .parts
                    .iter()
                    .flat_map(|&part| members[part].clone())
                    .collect(),
            );
        }
        members
    }

    /// Dendrogram purity: at the merge that joins a case with another of its class, the share of that class.
    ///
    /// ```text
    /// DP = Σ_{pairs i, j of one class k} wᵢ wⱼ |k below LCA(i, j)| / |all below LCA(i, j)|  /  Σ_{the same pairs} wᵢ wⱼ
    /// ```
    ///
    /// Here |·| is the sum of the weights of the cases below the lowest merge that contains both. DP is 1 if every class is
    /// a branch of its own. The chance level depends on the tree and the sizes, so use permutations. K. A. Heller and Z.
    /// Ghahramani, ICML 2005, 297, as a mean over pairs by A. Kobren et al., KDD 2017, 255 (the former draws a case, then
    /// another of its class, which gives small classes more weight). Pairs that are never joined are left out. NaN without
    /// a pair of one class.
    ///
    /// # Panics
    /// If there is not one label and one weight per case.
    pub fn purity(&self, labels: &[usize], weights: &[f64]) -> f64 {
        assert_eq!(labels.len(), self.cases, "one label a case");
        assert_eq!(weights.len(), self.cases, "one weight a case");
        let classes = labels.iter().max().map_or(0, |most| most + 1);
        let mut counts: Vec<Vec<f64>> = Vec::with_capacity(self.cases + self.merges.len());
        for (&label, &weight) in labels.iter().zip(weights) {
            let mut own = vec![0.0; classes];
            own[label] = weight;
            counts.push(own);
        }
        let (mut pure, mut pairs) = (0.0, 0.0);
        for merge in &self.merges {
            let mut below = vec![0.0; classes];
            let mut squares = vec![0.0; classes];
            for &part in &merge.parts {
                for class in 0..classes {
                    below[class] += counts[part][class];
                    squares[class] += counts[part][class].powi(2);
                }
            }
            let all: f64 = below.iter().sum();
            for class in 0..classes {
                let joined = 0.5 * (below[class].powi(2) - squares[class]);
                if all > 0.0 {
                    pure += joined * below[class] / all;
                }
                pairs += joined;
            }
            counts.push(below);
        }
        if pairs > 0.0 { pure / pairs } else { f64::NAN }
    }

    /// All partitions by cuts at one height, from the fewest clusters to single cases: the cluster of each case, numbered
    /// by its first case.
    pub fn cuts(&self) -> Vec<Vec<usize>> {
        let members = self.members();
        let mut cuts = vec![(0..self.cases).collect::<Vec<usize>>()];
        let mut cluster: Vec<usize> = (0..self.cases).collect();
        let solid = self
            .merges
            .iter()
            .enumerate()
            .filter(|(_, merge)| !merge.parts.is_empty());
        let solid: Vec<(usize, f64)> = solid.map(|(m, merge)| (m, merge.height)).collect();
        for level in solid.chunk_by(|a, b| a.1.total_cmp(&b.1).is_eq()) {
            for (merge, _) in level {
                for &case in &members[self.cases + merge] {
                    cluster[case] = self.cases + merge;
                }
            }
            let mut names: Vec<usize> = Vec::new();
            let numbered = cluster.iter().map(|own| {
                names
                    .iter()
                    .position(|name| name == own)
                    .unwrap_or_else(|| {
                        names.push(*own);
                        names.len() - 1
                    })
            });
            cuts.push(numbered.collect());
        }
        cuts.reverse();
        cuts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ((0, 1) at 1, (2, 3) at 2) at 5; 4 joins at 6.
    fn five() -> PairMatrix {
        PairMatrix::from_fn(5, |i, j| match (i, j) {
            (0, 1) => 1.0,
            (2, 3) => 2.0,
            (_, 4) => 6.0,
            _ => 5.0,
        })
    }

    #[test]
    fn purity_by_hand() {
        let tree = Dendrogram::new(&five());
        assert_eq!(tree.joined(), five());
        let ones = [1.0; 5];
        // Both classes are branches (the case alone has no pair).
        assert!((tree.purity(&[0, 0, 1, 1, 2], &ones) - 1.0).abs() < 1e-15);
        // {0, 2, 4}: pairs 0–2 under a merge of four with two of them, 0–4 and 2–4 under all five with three;
        // {1, 3}: under the merge of four with two of them. (1/2 + 3/5 + 3/5 + 1/2)/4.
        assert!((tree.purity(&[0, 1, 0, 1, 0], &ones) - 0.55).abs() < 1e-15);
        assert!(tree.purity(&[0, 1, 2, 3, 4], &ones).is_nan());
        // Weights: case 0 counts double. Pairs 0–2 (weight 2): 3/5; 0–4 (2): 4/6; 2–4 (1): 4/6; 1–3 (1): 2/5.
        let weighted = tree.purity(&[0, 1, 0, 1, 0], &[2.0, 1.0, 1.0, 1.0, 1.0]);
        let by_hand = (2.0 * 0.6 + 2.0 * 4.0 / 6.0 + 4.0 / 6.0 + 0.4) / 6.0;
        assert!((weighted - by_hand).abs() < 1e-15);
    }

    #[test]
    fn a_tie_is_one_merge_whatever_the_order() {
        let all = Dendrogram::new(&PairMatrix::from_fn(6, |_, _| 3.0));
        assert_eq!(all.cuts().len(), 2);
        // Every pair has all six below its merge.
        assert!((all.purity(&[0, 0, 0, 1, 1, 1], &[1.0; 6]) - 0.5).abs() < 1e-15);
        let tied = PairMatrix::from_fn(4, |i, j| if j == i + 1 && i != 1 { 1.0 } else { 2.0 });
        let cuts = Dendrogram::new(&tied).cuts();
        assert_eq!(cuts, [vec![0, 0, 0, 0], vec![0, 0, 1, 1], vec![0, 1, 2, 3]]);
    }

    #[test]
    fn heights_of_a_network_become_minimax() {
        let chain = PairMatrix::from_fn(4, |i, j| if j == i + 1 { j as f64 } else { f64::NAN });
        let joined = Dendrogram::new(&chain).joined();
        for (i, j, height) in joined.pairs() {
            assert!((height - j as f64).abs() < 1e-15, "{i} {j} {height}");
        }
        let apart = PairMatrix::from_fn(4, |i, j| if i / 2 == j / 2 { 1.0 } else { f64::NAN });
        let tree = Dendrogram::new(&apart);
        assert_eq!(tree.joined().unknown(), 4);
        assert_eq!(tree.cuts()[0], [0, 0, 1, 1]);
    }
}
