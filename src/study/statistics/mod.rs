//! Statistics of a landscape of grasps against the taxonomy: its grasp types, and the agreement of heights between minima
//! with their labels.

mod basins;
mod coverage;
mod table;

use serde::{Deserialize, Serialize};

pub use basins::NamedLandscape;
pub(super) use basins::{Basin, Basins, Part};
pub(super) use coverage::types;
pub use coverage::{TypeComparison, compare_types};
pub(super) use table::{Table, table};

use crate::agreement::Permutations;

/// Settings of the statistics.
#[derive(Debug, Clone, Serialize, Deserialize)]
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

impl StatisticsSettings {
    pub(super) fn permutations(&self, seed: u64) -> Permutations {
        Permutations {
            count: self.permutations,
            seed,
            least_per_class: self.least_per_class,
        }
    }
}
