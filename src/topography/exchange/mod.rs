//! The exchange formats `min.data` and `ts.data` for landscapes.
//!
//! Two programs write files of these names, with different columns:
//!
//! | program | `min.data`, a line a minimum | `ts.data`, a line a transition state |
//! | --- | --- | --- |
//! | PATHSAMPLE (D. J. Wales) | energy, ln-product, order, I₁, I₂, I₃ | energy, ln-product, order, a, b, I₁, I₂, I₃ |
//! | topsearch (L. Dicks and D. J. Wales) | number, energy | a, b, energy |
//!
//! * *ln-product*: sum of the logarithms of the positive (mass-weighted) Hessian eigenvalues;
//! * *order*: number of operations of the point group;
//! * *a*, *b*: the minima joined, counted from 1 by PATHSAMPLE, by their numbers in topsearch (from 0);
//! * *I*: the three principal moments of inertia by rising value.
//!
//! Coordinates lie beside them: PATHSAMPLE has `points.min` and `points.ts` ([`points()`]), topsearch the texts `min.coords`
//! and `ts.coords` ([`points_of_text`]).
//!
//! A reader tells the layouts apart by the number of columns: at least 6 and 8, or 2 and 3. Some programs write more
//! columns, which are ignored. Numbers are written without loss.
//!
//! Unknown values are written as placeholders: ln-product 0 (no Hessian), order 1, moments 0 (no atoms). A row is taken for
//! unknown only if it holds all of them. A known ln-product of exactly 0 (the saddle of a landscape with one coordinate has
//! no positive eigenvalues) is written as 1e-300 where the rest of the row holds the placeholders, too.

mod curvatures;
mod points;
mod read;
mod write;

use std::collections::BTreeMap;

pub use curvatures::curvatures;
use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;
pub use points::{PointsError, counted_points, points, points_of_text, read_points};
pub use read::{ExchangeError, Layout, NO_TRANSITION_STATES, Reading};

use super::network::{Edge, Evidence, Minimum, Network};
use super::search::Exploration;
use crate::space::{moments_of_inertia, point_group_order};

/// What PATHSAMPLE's files contain for a stationary point besides its energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vibrations {
    /// Σ ln λ over the positive Hessian eigenvalues λ, energy per length squared (with masses of 1 in files written here).
    pub log_product: f64,
    /// Number of operations of the point group that map the structure onto itself, including improper ones.
    pub point_group_order: u32,
    /// Principal moments of inertia, ascending.
    pub moments_of_inertia: [f64; 3],
    /// The negative Hessian eigenvalue of a transition state; `None` if it is unknown (the files do not hold it).
    pub negative_curvature: Option<f64>,
}

impl Vibrations {
    /// Whether files cannot tell these from the placeholders.
    fn looks_unknown(&self) -> bool {
        let negative_curvature = None;
        let written = Self {
            negative_curvature,
            ..*self
        };
        written == Self::default()
    }
}

impl Default for Vibrations {
    /// The placeholders.
    fn default() -> Self {
        Self {
            log_product: 0.0,
            point_group_order: 1,
            moments_of_inertia: [0.0; 3],
            negative_curvature: None,
        }
    }
}

/// A minimum of a [`Database`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MinimumEntry {
    /// Its energy.
    pub energy: f64,
    /// Vibrational data, if known.
    pub vibrations: Option<Vibrations>,
}

/// A transition state of a [`Database`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransitionStateEntry {
    /// Its energy.
    pub energy: f64,
    /// Rows of the minima it joins; both are the same for a degenerate rearrangement.
    pub ends: [usize; 2],
    /// Vibrational data, if known.
    pub vibrations: Option<Vibrations>,
}

/// The contents of a `min.data` and its `ts.data`, in their order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Database {
    /// Minima.
    pub minima: Vec<MinimumEntry>,
    /// Transition states.
    pub transition_states: Vec<TransitionStateEntry>,
    /// Number of positive Hessian eigenvalues of a minimum; `None` if it is unknown (the files do not hold it).
    pub vibrational_modes: Option<usize>,
}

/// Distance within which two atoms coincide, relative to the distance of the farthest atom from the centre. Stationary
/// points are accurate to about 10⁻⁸, and structures that are only nearly symmetric differ by more than this.
const SAME_PLACE: f64 = 1e-3;

impl Database {
    /// The minima and finite connections of a network, without vibrational data.
    pub fn from_network(network: &Network) -> Self {
        let minima = network.node_weights().map(|minimum| MinimumEntry {
            energy: minimum.energy,
            vibrations: None,
        });
        let reached = network
            .edge_references()
            .filter(|edge| edge.weight().height.is_finite());
        let transition_states = reached.map(|edge| TransitionStateEntry {
            energy: edge.weight().height,
            ends: [edge.source().index(), edge.target().index()],
            vibrations: None,
        });
        Self {
            minima: minima.collect(),
            transition_states: transition_states.collect(),
            vibrational_modes: None,
        }
    }

    /// All minima and saddles of a search with their curvatures. With `kinds`, the coordinates are positions of atoms of
    /// mass 1, which also give point groups and moments of inertia; no kinds in it mean that all atoms are equal. Points
    /// whose audit has no curvatures (on a face of a box) have no vibrational data.
    pub fn from_exploration(found: &Exploration, kinds: Option<&[usize]>) -> Self {
        let vibrations = |coordinates: &[f64], curvatures: &[f64]| {
            // A single atom has no curvatures either, but they are known.
            if curvatures.is_empty() && kinds.is_none() && !coordinates.is_empty() {
                return None;
            }
            let positive = curvatures.iter().filter(|curvature| **curvature > 0.0);
            // The sum of no numbers is −0, which files would show.
            let log_product = 0.0 + positive.map(|curvature| libm::log(*curvature)).sum::<f64>();
            let plain = Vibrations {
                log_product,
                negative_curvature: curvatures.first().copied().filter(|lowest| *lowest < 0.0),
                ..Vibrations::default()
            };
            Some(if let Some(kinds) = kinds {
                Vibrations {
                    point_group_order: point_group_order(coordinates, kinds, SAME_PLACE),
                    moments_of_inertia: moments_of_inertia(coordinates),
                    ..plain
                }
            } else {
                plain
            })
        };
        let minima = found.minima.iter().zip(&found.audits);
        let minima = minima.map(|(minimum, audit)| MinimumEntry {
            energy: minimum.energy,
            vibrations: vibrations(&minimum.coordinates, &audit.curvatures),
        });
        let saddles = found.saddles.iter().map(|saddle| TransitionStateEntry {
            energy: saddle.energy,
            ends: saddle.ends.map(|end| end.0),
            vibrations: vibrations(&saddle.coordinates, &saddle.audit.curvatures),
        });
        Self {
            minima: minima.collect(),
            transition_states: saddles.collect(),
            vibrational_modes: (found.audits.iter())
                .map(|audit| audit.curvatures.len())
                .max(),
        }
    }

    /// The same with the minima in ascending order of energy (equal energies in their present order), as in a landscape.
    #[must_use]
    pub fn by_energy(&self) -> Self {
        let rows = self.rows_by_energy();
        let mut place = vec![0; rows.len()];
        for (new, old) in rows.iter().enumerate() {
            place[*old] = new;
        }
        Self {
            minima: rows.iter().map(|row| self.minima[*row]).collect(),
            transition_states: (self.transition_states.iter())
                .map(|state| TransitionStateEntry {
                    ends: state.ends.map(|end| place[end]),
                    ..*state
                })
                .collect(),
            vibrational_modes: self.vibrational_modes,
        }
    }

    /// The present row of each minimum of [`Database::by_energy`].
    pub fn rows_by_energy(&self) -> Vec<usize> {
        let mut rows: Vec<usize> = (0..self.minima.len()).collect();
        rows.sort_by(|a, b| {
            let [one, other] = [a, b].map(|row| self.minima[*row].energy);
            one.total_cmp(&other).then(a.cmp(b))
        });
        rows
    }

    /// The network of the minima, sorted by energy (`members` holds the row of each), with the lowest transition state of
    /// each pair, as [`Evidence::Given`]. Degenerate rearrangements are left out. Coordinates and lengths are unknown (empty and 0).
    pub fn network(&self) -> Network {
        let sorted = self.by_energy();
        let mut network = Network::default();
        for (minimum, row) in sorted.minima.iter().zip(self.rows_by_energy()) {
            network.add_node(Minimum {
                coordinates: Vec::new(),
                energy: minimum.energy,
                members: vec![row],
            });
        }
        let mut lowest: BTreeMap<[usize; 2], f64> = BTreeMap::new();
        for state in &sorted.transition_states {
            let [a, b] = state.ends;
            if a != b {
                let height = lowest.entry([a.min(b), a.max(b)]).or_insert(f64::INFINITY);
                *height = height.min(state.energy);
            }
        }
        for ([a, b], height) in lowest {
            let edge = Edge::bare(height, Evidence::Given);
            network.add_edge(NodeIndex::new(a), NodeIndex::new(b), edge);
        }
        network
    }
}

#[cfg(test)]
mod tests;
