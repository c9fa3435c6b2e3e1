//! Statistics of a landscape of grasps against the taxonomy: which types there are, and how well heights between minima agree
//! with what the minima are called.

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
    /// Permutations of labels behind each p-value.
    pub permutations: usize,
    /// Resamplings of minima behind each interval.
    pub bootstrap_draws: usize,
    /// Fewest minima of a class; of fewer nothing is said.
    pub least_per_class: usize,
    /// Level of significance.
    pub level: f64,
    /// Fewest and most clusters of the cuts of the tree.
    pub cuts: [usize; 2],
    /// A height that is not known, because no path joins two minima, counts as this many times the largest.
    pub censored_factor: f64,
    /// Draws of uncertain labels.
    pub label_draws: usize,
    /// Difference in score at which a label is drawn e times as rarely as the best one.
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
