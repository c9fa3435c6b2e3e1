//! What all searches have in common.

use super::{Draw, SearchSettings};
use crate::energy::Energy;

/// The fixed inputs of all searches.
pub(super) struct Searcher<'a> {
    pub(super) energy: &'a dyn Energy,
    pub(super) draw: &'a Draw<'a>,
    /// Points from which the first searches begin.
    pub(super) known: &'a [Vec<f64>],
    pub(super) settings: &'a SearchSettings,
}
