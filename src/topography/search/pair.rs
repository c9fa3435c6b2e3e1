//! Further searches between two minima, by attraction–diffusion.

use petgraph::graph::NodeIndex;

use super::census::{Census, Source};
use super::searcher::Searcher;
use super::task::PUSH;
use crate::energy::{Counted, Energy};
use crate::sample::Mala;
use crate::topography::barrier::Connection;
use crate::topography::build::{MapSettings, PairSearch, passes_between};
use crate::topography::journal::{JournalError, Run};
use crate::topography::network::{Evidence, MinimumId, Network};
use crate::topography::path::PathSettings;
use crate::topography::tree::Tree;

/// Two minima between which further searches were made.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchedPair {
    /// Their numbers when the search for everything had ended.
    pub asked: [MinimumId; 2],
    /// Their numbers among all minima.
    pub minima: [MinimumId; 2],
    /// Height at which saddles joined them before; `None` if none did.
    pub before: Option<f64>,
    /// Number of further searches.
    pub searches: usize,
    /// Heights of the ways that these found, one for each search that found one.
    pub heights: Vec<f64>,
}

impl Searcher<'_> {
    /// Searches between two minima and adds the passes on the ways to the census. Until the census is complete, the result has
    /// the numbers of its minima in place of the final ones. Without result, one of the minima does not exist.
    pub(super) fn connect(
        &self,
        pair: &PairSearch,
        census: &mut Census,
        energy: &dyn Energy,
        run: &Run<'_>,
    ) -> Result<Option<SearchedPair>, JournalError> {
        let order = census.order();
        let [a, b] = pair.minima.map(|minimum| order.get(minimum.0));
        let (Some(a), Some(b)) = (a, b) else {
            return Ok(None);
        };
        let numbers = [*a, *b].map(MinimumId);
        let minima = census.as_minima();
        let minima: Vec<_> = order.iter().map(|old| minima[*old].clone()).collect();
        let known = census.connections();
        let mut network = Network::default();
        for minimum in &minima {
            network.add_node(minimum.clone());
        }
        for Connection { from, to, edge, .. } in &known {
            let ends = [from, to].map(|end| NodeIndex::new(end.0));
            network.add_edge(ends[0], ends[1], edge.clone());
        }
        let tree = Tree::from_network(&network, Evidence::Chain);
        let counted = Counted::new(self.energy);
        let measured = MapSettings::for_minima(&counted, &minima);
        let settings = MapSettings {
            searches: 0,
            path: PathSettings {
                method: self.settings.paths,
                push: PUSH * self.settings.length,
                ..measured.path
            },
            quench: self.settings.quench.clone(),
            sameness: self.settings.sameness,
            seed: self.settings.seed,
            ..measured
        };
        let kernel = Mala::new(self.energy);
        let surface = (self.energy, &kernel as _);
        let found = passes_between(surface, (minima, known), pair, &settings, run)?;
        let measuring = usize::try_from(counted.evaluations()).unwrap_or(usize::MAX);
        census.spend(measuring.saturating_add(found.evaluations));
        for crossing in found.passes {
            census.meet(energy, crossing, Source::Path);
        }
        Ok(Some(SearchedPair {
            asked: pair.minima,
            minima: numbers,
            before: tree.minimax(pair.minima[0], pair.minima[1]),
            searches: pair.searches,
            heights: found.heights,
        }))
    }
}
