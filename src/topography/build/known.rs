//! What a map knows: its best connections, their passes, and the minima that it met outside its list.

use rayon::prelude::*;

use super::{LandscapeBuilder, claim};
use crate::optimize::Quench;
use crate::topography::barrier::{Connection, Start, rising_term};
use crate::topography::network::{Edge, Evidence, MinimumId};
use crate::topography::path::HEIGHT_TOLERANCE;
use crate::topography::support::Attempt;

impl LandscapeBuilder<'_> {
    /// Adds connections and the passes found on their paths, in order.
    pub(super) fn take_all(&mut self, found: Vec<Connection>) {
        let side_connections: Vec<Vec<Connection>> = found
            .par_iter()
            .with_max_len(1)
            .map(|connection| self.side_connections(connection))
            .collect();
        for connection in found {
            self.note(&connection);
            self.evaluations += connection.evaluations;
            self.collect_unlisted_minima(&connection);
            self.take(connection);
        }
        for connection in side_connections.into_iter().flatten() {
            self.take(connection);
        }
    }

    /// Adds the geodesic that led to a connection to the attempts.
    fn note(&mut self, connection: &Connection) {
        let start = connection.start;
        let Some(start) = start.filter(|start| !matches!(start, Start::Chain { .. })) else {
            return;
        };
        self.attempts.push(Attempt {
            from: connection.from,
            to: connection.to,
            start,
            law: None,
            free_temperature: None,
            barrier: None,
            height: Some(connection.edge.height).filter(|height| height.is_finite()),
        });
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
            let edge = Edge {
                term: rising_term(self.energy, top, (&self.minima[a], &self.minima[b])),
                length: path.length(self.energy.space()),
                ..Edge::bare(crossing.path.energies[crossing.pass], evidence)
            };
            let (from, to) = (MinimumId(a.min(b)), MinimumId(a.max(b)));
            side_connections.push(Connection {
                invalid_reason,
                crossings: vec![crossing.clone()],
                ..Connection::new(from, to, edge, path)
            });
        }
        side_connections
    }

    pub(super) fn collect_unlisted_minima(&mut self, connection: &Connection) {
        for path in connection.crossings.iter().map(|crossing| &crossing.path) {
            for end in [0, path.images.len() - 1] {
                let (x, energy) = (&path.images[end], path.energies[end]);
                if self.find(x, energy).is_none() {
                    self.unlisted_minima
                        .push(Quench::at_rest(x.clone(), energy));
                }
            }
        }
    }

    pub(super) fn find(&self, x: &[f64], energy: f64) -> Option<usize> {
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
    pub(super) fn take(&mut self, new: Connection) {
        let pair = (new.from.0, new.to.0);
        let Some(known) = self.best.get_mut(&pair) else {
            self.best.insert(pair, new);
            return;
        };
        let floor = self.minima[pair.0].energy.max(self.minima[pair.1].energy);
        let tie = self.settings.sameness.energy;
        let slack = HEIGHT_TOLERANCE * (known.edge.height - floor) + tie;
        let evaluations = known.evaluations + new.evaluations;
        if claim(&new).beats(claim(known), tie, slack) {
            *known = new;
        }
        known.evaluations = evaluations;
    }
}
