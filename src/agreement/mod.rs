//! Statistics of agreement: of trees, distances and graphs with labels.
//!
//! A statistic is a function of labels: [`Dendrogram::purity`], [`anosim_of_ranks`], [`permanova`], [`morans_i`], … Its significance
//! comes from [`test_labels`], which permutes labels among the cases of a block; classes that are too small give
//! [`Outcome::Insufficient`]. [`bootstrap`] resamples cases, [`test_uncertain_labels`] resamples labels, and [`holm`]
//! corrects for many hypotheses. Pairs that are not known (no path was found) are NaN in a [`PairMatrix`]. Raise them above
//! all others ([`PairMatrix::raised`]), and repeat the analysis with them left out.

mod correlation;
mod dendrogram;
mod graph;
mod groups;
mod hill;
mod pairs;
mod partition;
mod share;
mod test;

pub use correlation::{Correlation, mantel, partial_mantel, partial_spearman, pearson, spearman};
pub use dendrogram::Dendrogram;
pub use graph::{assortativity, indicator, morans_i};
pub use groups::{
    BarrierRatio, anosim_of_ranks, barrier_ratio, cliffs_delta, dispersions, permanova, permdisp,
    silhouette,
};
pub use hill::{Estimated, HillNumbers, Ratio, rarefied_hill_numbers};
pub use pairs::PairMatrix;
#[cfg(feature = "topography")]
pub(crate) use partition::adjusted_rand_of_pairs;
pub use partition::{
    Comparison, adjusted_mutual_information, adjusted_rand, agreement_of_cuts, cuts_between,
    highest,
};
pub use share::{sign_test, wilson};
pub use test::{
    Outcome, Permutations, Resampled, Tested, UnderUncertainty, bootstrap, holm, test_labels,
    test_order, test_uncertain_labels,
};
