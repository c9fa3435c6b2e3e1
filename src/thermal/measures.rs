//! Measures of a whole landscape that are quoted in the literature.

use super::superposition::Superposition;
use crate::topography::{Evidence, MinimumId, Node, Tree};

/// Minima whose energies differ by at most this fraction of the range of energies have one energy, up to rounding.
pub const SAME: f64 = 1e-9;

/// The difference between the lowest minimum and the highest merge or minimum of a tree; 0 if it has no nodes.
pub fn range_of_energies(tree: &Tree) -> f64 {
    let energies = || tree.nodes.iter().map(|node| node.energy);
    let (low, high) = energies().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), energy| {
        (low.min(energy), high.max(energy))
    });
    (high - low).max(0.0)
}

/// Frustration of a landscape at a temperature:
///
/// ```text
/// f(T) = Σ_{i ≠ g} pᵢ/(1 − p_g) · (V‡ᵢ − V_g)/(Vᵢ − V_g)
/// ```
///
/// g: the lowest minimum; V‡ᵢ: the highest energy on the lowest path from i to g; p: equilibrium occupation. It is near 1
/// where no barrier keeps the system from the lowest minimum, and large for glassy landscapes. V. K. de Souza, J. D.
/// Stevenson, S. P. Niblett, J. D. Farrell and D. J. Wales, J. Chem. Phys. 146, 124103 (2017). Minima that are not connected
/// to the lowest one, or have its energy within 10⁻⁹ of the range of energies of the tree, are left out. `None` if no minimum
/// is left. O(n) for n minima, whatever the depth of the tree.
///
/// # Panics
/// If `wells` and `tree` are not of the same minima, numbered alike.
pub fn frustration(wells: &Superposition, tree: &Tree, temperature: f64) -> Option<f64> {
    let weights = wells.log_partition_functions(temperature);
    let leaves = weights.len();
    let energies: Vec<f64> = tree.nodes[..leaves]
        .iter()
        .map(|node| node.energy)
        .collect();
    let lowest = (0..leaves).min_by(|a, b| energies[*a].total_cmp(&energies[*b]))?;
    let same = SAME * range_of_energies(tree);
    let heights = tree.heights_to(MinimumId(lowest));
    let ratios: Vec<(f64, f64)> = (0..leaves)
        .filter_map(|i| {
            let height = heights[i]?;
            let above = energies[i] - energies[lowest];
            (above > same).then(|| (weights[i], (height - energies[lowest]) / above))
        })
        .collect();
    let top = ratios.iter().map(|(weight, _)| *weight);
    let top = top.fold(f64::NEG_INFINITY, f64::max);
    let share = |weight: f64| libm::exp(weight - top);
    let sum: f64 = ratios.iter().map(|(weight, _)| share(*weight)).sum();
    let weighted = ratios.iter().map(|(weight, ratio)| share(*weight) * ratio);
    (sum > 0.0).then(|| weighted.sum::<f64>() / sum)
}

/// The number of superbasins at an energy, as [`superbasins`] numbers them: the nodes of the tree at or below it whose parent
/// lies above it.
pub fn count_superbasins(tree: &Tree, energy: f64) -> usize {
    let below = |node: &Node| node.energy <= energy;
    let is_top = |node: &&Node| {
        below(node) && !(node.parent).is_some_and(|parent| below(&tree.nodes[parent.0]))
    };
    tree.nodes.iter().filter(is_top).count()
}

/// The superbasin of each minimum at an energy: sets of minima that are connected at or below it, numbered by their lowest
/// minimum. `None` for minima above the energy.
///
/// O. M. Becker and M. Karplus, J. Chem. Phys. 106, 1495 (1997).
pub fn superbasins(tree: &Tree, energy: f64) -> Vec<Option<usize>> {
    let below = |node: usize| tree.nodes[node].energy <= energy;
    // Parents have larger numbers than their children.
    let mut top: Vec<usize> = (0..tree.nodes.len()).collect();
    for node in (0..tree.nodes.len()).rev() {
        if let Some(parent) = tree.nodes[node].parent
            && below(parent.0)
        {
            top[node] = top[parent.0];
        }
    }
    let mut number = vec![None; tree.nodes.len()];
    let mut count = 0;
    let leaves = tree.nodes.iter().take_while(|node| node.minimum.is_some());
    let mut by_energy: Vec<usize> = (0..leaves.count()).collect();
    let mut found = vec![None; by_energy.len()];
    by_energy.sort_by(|a, b| {
        let energies = tree.nodes[*a].energy.total_cmp(&tree.nodes[*b].energy);
        energies.then(a.cmp(b))
    });
    for leaf in by_energy.into_iter().filter(|leaf| below(*leaf)) {
        let own = number[top[leaf]].get_or_insert_with(|| {
            count += 1;
            count - 1
        });
        found[leaf] = Some(*own);
    }
    found
}

/// The two deepest funnels of a landscape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Funnels {
    /// Energy of the lowest known pass between them.
    pub pass: f64,
    /// Energies of their lowest minima, the lower first.
    pub bottoms: [f64; 2],
    /// How many minima each of them has.
    pub minima: [usize; 2],
    /// Evidence for the pass; with [`Evidence::Chain`] it is an upper bound.
    pub evidence: Evidence,
}

/// Smallest number of minima of a funnel, and their smallest share: a single minimum that is hard to leave is no funnel.
const LEAST: (f64, f64) = (2.0, 0.01);

impl Funnels {
    /// The branches of the deepest merge. The depth of a merge is its height above the lowest minimum of its shallower
    /// branch. A branch of a single minimum, or of fewer than 1 % of all minima, is no funnel unless there are no others.
    /// `None` if nothing merges.
    pub fn deepest(tree: &Tree) -> Option<Self> {
        let lowest = tree.fold(|node, branches: &[f64]| {
            let own = tree.nodes[node.0].energy;
            branches.iter().copied().fold(own, f64::min)
        });
        let leaves = tree.leaves_below();
        let minima = tree.nodes.iter().filter(|node| node.minimum.is_some());
        let least = (LEAST.1 * minima.count() as f64).max(LEAST.0);
        let at = |node: &Node| {
            let branches = node.children.iter();
            let mut branches: Vec<(f64, usize)> = branches
                .map(|child| (lowest[child.0], leaves[child.0]))
                .collect();
            // Where many branches merge at once, the lowest two large ones are the funnels.
            branches.sort_by(|a, b| {
                let small = |branch: &(f64, usize)| (branch.1 as f64) < least;
                small(a).cmp(&small(b)).then(a.0.total_cmp(&b.0))
            });
            let [first, second] = *branches.first_chunk()?;
            let [low, high] = if first.0 <= second.0 {
                [first, second]
            } else {
                [second, first]
            };
            Some(Self {
                pass: node.energy,
                bottoms: [low.0, high.0],
                minima: [low.1, high.1],
                evidence: node.evidence,
            })
        };
        tree.nodes.iter().filter_map(at).max_by(|a, b| {
            let wide = |merge: &Self| merge.minima.iter().all(|count| *count as f64 >= least);
            let depth = |merge: &Self| merge.pass - merge.bottoms[1];
            (wide(a).cmp(&wide(b)))
                .then(depth(a).total_cmp(&depth(b)))
                .then(b.pass.total_cmp(&a.pass))
        })
    }

    /// The highest energy at which the two funnels are apart.
    pub fn level(&self) -> f64 {
        self.pass.next_down()
    }

    /// How much harder the deeper funnel is to leave: (B₁ − B₂)/(B₁ + B₂), where B are the heights of the pass above the
    /// two bottoms. It is 0 for funnels of equal depth, and near 1 where one of them is hardly a funnel. This is a measure
    /// of ours; the literature quotes both heights.
    pub fn asymmetry(&self) -> f64 {
        let [deeper, shallower] = self.bottoms.map(|bottom| self.pass - bottom);
        let sum = deeper + shallower;
        if sum > 0.0 {
            (deeper - shallower) / sum
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::exchange::Database;
    use std::fmt::Write;

    /// Two funnels (0, 1 and 2, 3) that merge at 5, and an island (4).
    fn tree() -> (Database, Tree) {
        let minima = "0.0 4 1 0 0 0\n1.0 3 1 0 0 0\n0.5 2 1 0 0 0\n1.5 1 1 0 0 0\n6.0 1 1 0 0 0\n";
        let states = "2.0 1 1 1 2 0 0 0\n3.0 1 1 3 4 0 0 0\n5.0 1 1 2 4 0 0 0\n";
        let (database, _) = Database::parse(minima, states).unwrap();
        let database = database.by_energy();
        let tree = Tree::from_network(&database.network(), crate::topography::Evidence::Chain);
        (database, tree)
    }

    #[test]
    fn superbasins_join_where_the_tree_merges() {
        let (_, tree) = tree();
        // In order of energy: 0, 0.5, 1, 1.5, 6.
        let at = |energy| superbasins(&tree, energy);
        assert_eq!(at(-1.0), vec![None; 5]);
        assert_eq!(at(0.7), [Some(0), Some(1), None, None, None]);
        assert_eq!(at(2.0), [Some(0), Some(1), Some(0), Some(2), None]);
        assert_eq!(at(4.0), [Some(0), Some(1), Some(0), Some(1), None]);
        assert_eq!(at(6.0), [Some(0), Some(0), Some(0), Some(0), Some(1)]);
        let counts = [-1.0, 0.7, 2.0, 4.0, 6.0].map(|energy| count_superbasins(&tree, energy));
        assert_eq!(counts, [0, 2, 3, 2, 2]);
        let funnels = Funnels::deepest(&tree).unwrap();
        assert_eq!(
            funnels,
            Funnels {
                pass: 5.0,
                bottoms: [0.0, 0.5],
                minima: [2, 2],
                evidence: Evidence::Given
            }
        );
        let level = funnels.level();
        assert!(level < 5.0 && level > 4.999_999, "{level}");
        approx::assert_relative_eq!(funnels.asymmetry(), 0.5 / 9.5);
    }

    /// A deep hole beside two funnels is not a funnel; beside two single minima it is.
    #[test]
    fn a_hole_is_no_funnel() {
        let with = |count: usize| {
            let (mut minima, mut states) = (String::new(), String::new());
            for i in 0..2 * count {
                let energy = 0.01 * i as f64;
                writeln!(minima, "{energy} 1 1 0 0 0").unwrap();
                // Each joins the one two before; the bottoms 0 and 1 join at 5.
                let (to, height) = if i < 2 {
                    (0, 5.0)
                } else {
                    (i - 2, energy + 0.5)
                };
                if i > 0 {
                    writeln!(states, "{height} 1 1 {} {} 0 0 0", i + 1, to + 1).unwrap();
                }
            }
            writeln!(minima, "-1.0 1 1 0 0 0").unwrap();
            writeln!(states, "20.0 1 1 1 {} 0 0 0", 2 * count + 1).unwrap();
            let (database, _) = Database::parse(&minima, &states).unwrap();
            let network = database.by_energy().network();
            let tree = Tree::from_network(&network, crate::topography::Evidence::Chain);
            Funnels::deepest(&tree).unwrap()
        };
        for count in [2, 150] {
            let two = with(count);
            assert_eq!((two.pass, two.minima), (5.0, [count, count]));
        }
        let few = with(1);
        assert_eq!((few.pass, few.bottoms), (20.0, [-1.0, 0.0]));
    }

    /// The minima of a symmetric surface differ by the rounding of their descents.
    #[test]
    fn rounding_is_no_frustration() {
        let frustration_of = |minima: &str| {
            let states = "1.0 1 1 1 2 0 0 0\n0.8 1 1 2 3 0 0 0\n";
            let (database, _) = Database::parse(minima, states).unwrap();
            let network = database.by_energy().network();
            let tree = Tree::from_network(&network, crate::topography::Evidence::Chain);
            let wells = Superposition::new(&database.by_energy()).unwrap();
            frustration(&wells, &tree, 0.3)
        };
        let two = "0.0 1 1 0 0 0\n1e-16 1 1 0 0 0\n";
        let exact = frustration_of(&format!("{}0.5 1 1 0 0 0\n", two.replace("1e-16", "0.0")));
        let rounded = frustration_of(&format!("{two}0.5 1 1 0 0 0\n"));
        approx::assert_relative_eq!(rounded.unwrap(), 2.0, max_relative = 1e-12);
        approx::assert_relative_eq!(rounded.unwrap(), exact.unwrap(), max_relative = 1e-12);
        assert_eq!(frustration_of(&format!("{two}2e-16 1 1 0 0 0\n")), None);
    }

    #[test]
    fn frustration_of_two_funnels() {
        let (database, tree) = tree();
        let wells = Superposition::new(&database).unwrap();
        let temperature = 0.8;
        let weights = wells.occupation(temperature);
        // Ratios (V‡ − V₀)/(V − V₀) of the minima 0.5, 1 and 1.5; the island is left out.
        let ratios = [(1, 5.0 / 0.5), (2, 2.0), (3, 5.0 / 1.5)];
        let sum: f64 = ratios.iter().map(|(i, _)| weights[*i]).sum();
        let expected: f64 = ratios
            .iter()
            .map(|(i, ratio)| weights[*i] / sum * ratio)
            .sum();
        let found = frustration(&wells, &tree, temperature).unwrap();
        approx::assert_relative_eq!(found, expected, max_relative = 1e-12);
    }
}
