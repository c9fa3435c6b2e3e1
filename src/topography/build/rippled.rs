//! Stages of a map on a surface with ripples, and of one whose minima are joined at a ceiling by definition.

use super::{LandscapeBuilder, growing};
use crate::topography::Phase;
use crate::topography::barrier::Connection;
use crate::topography::journal::JournalError;
use crate::topography::network::{Edge, Evidence, MinimumId};
use crate::topography::pairs::candidates;
use crate::topography::path::Path;
use crate::topography::ripples::{Parts, merged};
use crate::topography::tree::Tree;

impl LandscapeBuilder<'_> {
    /// Finds near minima that only ripples divide, by strings of a few iterations.
    pub(super) fn join_over_ripples(&mut self) -> Result<(), JournalError> {
        let settings = self.settings;
        if self.roughness() <= 0.0 {
            return Ok(());
        }
        let mut pairs = candidates(&self.distances, settings.neighbours);
        pairs.retain(|pair| !self.is_settled(*pair));
        let tally = self.run.tally(Phase::Ripple, pairs.len());
        for batch in growing(&pairs, settings.batch) {
            let known = Tree::from_network(&self.network(), Evidence::Path);
            let open: Vec<_> = (batch.iter().copied())
                .filter(|pair| !self.joined_at_the_bottom(&known, *pair))
                .collect();
            let mut found = self.each(&open, &tally, "ripple", &|connector, pair| {
                connector.connect_roughly(self.energy, pair)
            })?;
            let spent = |connection: &Connection| connection.evaluations;
            self.evaluations += found.iter().map(spent).sum::<usize>();
            found.retain(|connection| connection.edge.evidence <= Evidence::Path);
            for connection in &mut found {
                // They are counted already.
                connection.evaluations = 0;
            }
            self.take_all(found);
        }
        Ok(())
    }

    /// Replaces minima that only ripples divide by the lowest of them.
    pub(super) fn merge_over_ripples(&mut self) {
        if self.roughness() <= 0.0 {
            return;
        }
        let (network, basins) = (self.network(), self.basins());
        let parts = Parts {
            minima: std::mem::take(&mut self.minima),
            best: std::mem::take(&mut self.best),
            attempts: std::mem::take(&mut self.attempts),
        };
        let whole = merged(self.energy.space(), &network, parts, &basins);
        (self.minima, self.best, self.attempts) = (whole.minima, whole.best, whole.attempts);
    }

    /// Gives connections above the ceiling its height, and joins components that no path joins.
    pub(super) fn join_at_the_ceiling(&mut self) {
        let Some(ceiling) = self.settings.ceiling else {
            return;
        };
        for connection in self.best.values_mut() {
            if connection.edge.height >= ceiling {
                connection.edge.height = ceiling;
                connection.edge.evidence = Evidence::Path;
            }
        }
        let component = self.components();
        // Minima are sorted by energy, so minimum 0 is the lowest of the first component.
        let apart: Vec<usize> = (1..component.len())
            .filter(|i| component[*i] != component[0] && !component[..*i].contains(&component[*i]))
            .collect();
        for i in apart {
            let edge = Edge {
                length: (self.energy.space())
                    .distance(&self.minima[0].coordinates, &self.minima[i].coordinates),
                ..Edge::bare(ceiling, Evidence::Path)
            };
            let joined = Connection::new(MinimumId(0), MinimumId(i), edge, Path::default());
            self.best.insert((0, i), joined);
        }
    }
}
