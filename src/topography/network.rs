//! Minima and the connections between them.

use petgraph::graph::UnGraph;
use serde::{Deserialize, Serialize};

/// Number of a minimum in a [`Network`]; minima are sorted by energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct MinimumId(pub usize);

/// A local minimum and the input points that fell into it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Minimum {
    /// Where it is.
    pub coordinates: Vec<f64>,
    /// Its energy.
    pub energy: f64,
    /// The discrete choice realised there (a contact set); empty for smooth energies.
    pub choice: Vec<u32>,
    /// Input points (row numbers) that quenched into it.
    pub members: Vec<usize>,
}

/// What a connection is worth, from best to worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Evidence {
    /// Index-1 stationary point, verified; both descents land on the named minima.
    Saddle,
    /// Lowest point of a tie between two discrete choices; descents on both sides verified.
    Seam,
    /// Relaxed path: perpendicular force below tolerance and height stable under doubling of its images.
    Path,
    /// Attraction–diffusion upper bound, or a band that would not relax.
    Chain,
    /// Never reached with the budget spent.
    None,
}

/// A connection of two minima.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Edge {
    /// Highest energy met on the way; `f64::INFINITY` where `evidence` is [`Evidence::None`].
    pub height: f64,
    /// What the height is worth.
    pub evidence: Evidence,
    /// Name of the energy term that dominates the top, where the energy has terms.
    pub term: Option<String>,
    /// Length of the path in the metric of the space.
    pub length: f64,
}

/// Minima as nodes (node index = [`MinimumId`]), connections as edges.
pub type Network = UnGraph<Minimum, Edge>;

/// What decides between two paths of one pair.
#[derive(Clone, Copy)]
pub(super) struct Claim {
    /// Whether the energy objects to the top.
    pub(super) invalid: bool,
    pub(super) height: f64,
    pub(super) evidence: Evidence,
}

impl Claim {
    /// Legal paths first, then low ones. Heights within `tie` are equal and the better evidence wins; so they are within
    /// `slack` of a lower chain, whose true top may lie between its samples.
    pub(super) fn beats(self, other: Self, tie: f64, slack: f64) -> bool {
        if self.height.is_finite() && other.height.is_finite() && self.invalid != other.invalid {
            return other.invalid;
        }
        let lower = if self.height < other.height {
            self
        } else {
            other
        };
        let near = if lower.evidence < Evidence::Chain {
            tie
        } else {
            slack
        };
        if (self.height - other.height).abs() <= near && self.evidence != other.evidence {
            return self.evidence < other.evidence;
        }
        self.height < other.height
    }
}
