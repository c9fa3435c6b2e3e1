//! More chains for the connections of the tree that only few chains have found.
//!
//! A path that began as a chain is found by luck, while a path that began as a straight line is found always. More chains,
//! each relaxed, show whether others lead to the same height, or to a lower one.

use super::LandscapeBuilder;
use crate::topography::Phase;
use crate::topography::journal::JournalError;

/// Number of chains that must have led to a connection of the tree, if no straight line did.
const ENOUGH: usize = 4;

impl LandscapeBuilder<'_> {
    /// Relaxes more chains between the pairs whose chains alone found a connection of the tree.
    pub(super) fn confirm(&mut self) -> Result<(), JournalError> {
        let most = self.settings.confirm_rounds;
        for round in 0..most {
            let pairs = self.unconfirmed();
            if pairs.is_empty() {
                break;
            }
            let tally = (self.run).tally_of_round(Phase::Confirm, (round, most), pairs.len());
            // Chains of the next attempt have new random streams.
            for pair in &pairs {
                *self.tried.entry(*pair).or_insert(0) += 1;
            }
            let found = self.each(&pairs, &tally, "confirm", &|connector, pair| {
                connector.replicate(self.energy, self.kernel, pair, 1, f64::INFINITY)
            })?;
            self.take_all(found);
        }
        Ok(())
    }

    /// The pairs whose chains alone found a connection of the tree, and fewer than enough of them.
    fn unconfirmed(&self) -> Vec<(usize, usize)> {
        let tolerance = self.settings.sameness.energy;
        let mut pairs: Vec<_> = (self.decisive(&self.network()).into_iter())
            .flat_map(|edge| {
                let height = self.best[&edge].edge.height + tolerance;
                let mut chains = 0;
                let mut finders = Vec::new();
                for (pair, trial) in &self.trials {
                    let Some(found) = trial.chains_that_found(*pair, edge, height) else {
                        return Vec::new();
                    };
                    if found > 0 {
                        chains += found;
                        finders.push(*pair);
                    }
                }
                if chains < ENOUGH { finders } else { Vec::new() }
            })
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }
}
