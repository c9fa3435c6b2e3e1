//! Statistics of a landscape of grasps against the taxonomy: its grasp types, and the agreement of heights between minima
//! with their labels.

mod basins;
mod comparison;
mod coverage;
mod table;

use serde::{Deserialize, Serialize};

pub use basins::{Basin, Basins, NamedLandscape, Part};
pub use comparison::{TaxonomyComparison, compare_with_taxonomy};
pub use coverage::{TypeComparison, compare_types};

use crate::agreement::Permutations;

/// Settings of the statistics.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(default)]
pub struct StatisticsSettings {
    /// Permutations of labels for each p-value.
    pub permutations: usize,
    /// Resamplings of minima for each interval.
    pub bootstrap_draws: usize,
    /// Least number of minima of a class. Smaller classes are not tested.
    pub least_per_class: usize,
    /// Level of significance.
    pub level: f64,
    /// Least and greatest number of clusters in cuts of the tree.
    pub cuts: [usize; 2],
    /// Factor on the largest height that replaces unknown heights between unconnected minima.
    pub censored_factor: f64,
    /// Draws of uncertain labels.
    pub label_draws: usize,
    /// Score difference that reduces the probability of a label by a factor of e.
    pub label_temperature: f64,
    /// Permutations for each draw of labels.
    pub label_permutations: usize,
}

impl Default for StatisticsSettings {
    fn default() -> Self {
        Self {
            permutations: 9999,
            bootstrap_draws: 1000,
            least_per_class: 5,
            level: 0.05,
            cuts: [2, 20],
            censored_factor: 1.1,
            label_draws: 200,
            label_temperature: 0.05,
            label_permutations: 199,
        }
    }
}

impl StatisticsSettings {
    /// The permutations of labels that follow `seed`.
    pub fn permutations(&self, seed: u64) -> Permutations {
        Permutations {
            count: self.permutations,
            seed,
            least_per_class: self.least_per_class,
        }
    }
}
