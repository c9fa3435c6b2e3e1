//! What all searches have in common.

use super::{Draw, SearchSettings};
use crate::energy::Energy;

/// The fixed inputs of all searches.
pub(super) struct Searcher<'a> {
    pub(super) energy: &'a dyn Energy,
    pub(super) draw: &'a Draw<'a>,
    pub(super) settings: &'a SearchSettings,
}
