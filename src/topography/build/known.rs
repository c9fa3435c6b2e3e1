//! What a map knows: its best connections, their passes, and the minima that it met outside its list.

use rayon::prelude::*;

use super::{LandscapeBuilder, claim};
use crate::optimize::{Quench, StopReason};
use crate::topography::barrier::{Connection, rising_term};
use crate::topography::network::{Edge, Evidence, MinimumId};

impl LandscapeBuilder<'_> {
    /// Adds connections and the passes found on their paths, in order.
    pub(super) fn take_all(&mut self, found: Vec<Connection>) {
        let side_connections: Vec<Vec<Connection>> = found
            .par_iter()
            .with_max_len(1)
            .map(|connection| self.side_connections(connection))
            .collect();
        for (connection, side_connections) in found.into_iter().zip(&side_connections) {
            let pair = (connection.from.0, connection.to.0);
            let trial = self.trials.entry(pair).or_default();
            trial.add(&connection, side_connections);
            self.evaluations += connection.evaluations;
            self.collect_unlisted_minima(&connection);
            self.take(connection);
        }
        for connection in side_connections.into_iter().flatten() {
            self.take(connection);
        }
    }

    /// The passes of a connection as connections of the known minima they join.
    fn side_connections(&self, connection: &Connection) -> Vec<Connection> {
        let mut side_connections = Vec::new();
        for crossing in &connection.crossings {
            let (path, last) = (&crossing.path, crossing.path.images.len() - 1);
            let find = |k: usize| self.find(&path.images[k], path.energies[k]);
            let (Some(a), Some(b)) = (find(0), find(last)) else {
                continue;
            };
            if a == b || (a.min(b), a.max(b)) == (connection.from.0, connection.to.0) {
                continue;
            }
            let top = &path.images[crossing.pass];
            let invalid_reason = self.energy.invalid_reason(top);
            let evidence = match invalid_reason {
                Some(_) => Evidence::Chain,
                None => crossing.evidence,
            };
            let mut path = path.clone();
            if a > b {
                path = path.reversed();
            }
            path.unfold(self.energy.space());
            side_connections.push(Connection {
                from: MinimumId(a.min(b)),
                to: MinimumId(a.max(b)),
                edge: Edge {
                    height: crossing.path.energies[crossing.pass],
                    evidence,
                    term: rising_term(self.energy, top, (&self.minima[a], &self.minima[b])),
                    length: path.length(self.energy.space()),
                },
                path,
                forward: Vec::new(),
                backward: Vec::new(),
                start: None,
                straight: f64::INFINITY,
                invalid_reason,
                crossings: vec![crossing.clone()],
                evaluations: 0,
            });
        }
        side_connections
    }

    fn collect_unlisted_minima(&mut self, connection: &Connection) {
        for path in connection.crossings.iter().map(|crossing| &crossing.path) {
            for end in [0, path.images.len() - 1] {
                let (x, energy) = (&path.images[end], path.energies[end]);
                if self.find(x, energy).is_none() {
                    self.unlisted_minima.push(Quench {
                        x: x.clone(),
                        energy,
                        gradient_norm: 0.0,
                        evaluations: 0,
                        stop: StopReason::Converged,
                    });
                }
            }
        }
    }

    fn find(&self, x: &[f64], energy: f64) -> Option<usize> {
        let tolerance = self.settings.sameness.energy;
        let first = self
            .minima
            .partition_point(|m| m.energy < energy - tolerance);
        (first..self.minima.len())
            .take_while(|i| self.minima[*i].energy <= energy + tolerance)
            .find(|i| {
                self.settings
                    .sameness
                    .holds(self.energy.space(), x, energy, &self.minima[*i])
            })
    }

    /// Keeps the better of this connection and the known one, with the raw barriers of both.
    fn take(&mut self, new: Connection) {
        let pair = (new.from.0, new.to.0);
        let Some(known) = self.best.get_mut(&pair) else {
            self.best.insert(pair, new);
            return;
        };
        let floor = self.minima[pair.0].energy.max(self.minima[pair.1].energy);
        let tie = self.settings.sameness.energy;
        let slack = self.settings.path.height_tolerance * (known.edge.height - floor) + tie;
        let (mut better, mut other) = if claim(&new).beats(claim(known), tie, slack) {
            (new, known.clone())
        } else {
            (known.clone(), new)
        };
        // Raw barriers record all chains, whichever path was kept.
        better.forward.append(&mut other.forward);
        better.backward.append(&mut other.backward);
        better.evaluations += other.evaluations;
        *known = better;
    }
}
