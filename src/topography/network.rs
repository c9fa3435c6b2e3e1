//! Minima and the connections between them.

use petgraph::graph::UnGraph;
use serde::{Deserialize, Serialize};

/// Number of a minimum in a [`Network`]; minima are sorted by energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct MinimumId(pub usize);

/// A local minimum and the input points that fell into it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Minimum {
    /// Coordinates of the minimum.
    pub coordinates: Vec<f64>,
    /// Energy of the minimum.
    pub energy: f64,
    /// Row numbers of the input points whose quench ended in it.
    pub members: Vec<usize>,
}

impl Minimum {
    /// A minimum without members.
    pub(crate) fn bare(coordinates: Vec<f64>, energy: f64) -> Self {
        let members = Vec::new();
        Self {
            coordinates,
            energy,
            members,
        }
    }
}

/// Evidence for a connection, from best to worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Evidence {
    /// Verified stationary point of index 1. Both descents from it end in the two minima.
    Saddle,
    /// Transition state of another program, not verified here.
    Given,
    /// Relaxed path: its perpendicular force is below the tolerance, and doubling the images does not change its height.
    Path,
    /// Upper bound from attraction–diffusion, or from a string that did not relax.
    Chain,
    /// The minima were not connected within the budget.
    None,
}

/// A connection of two minima.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Edge {
    /// Highest energy of the path; `f64::INFINITY` if `evidence` is [`Evidence::None`].
    pub height: f64,
    /// Evidence for the height.
    pub evidence: Evidence,
    /// Name of the energy term that dominates at the highest point, if the energy has terms.
    pub term: Option<String>,
    /// Length of the path in the metric of the space.
    pub length: f64,
}

impl Edge {
    /// A connection of unknown term and length.
    pub(crate) fn bare(height: f64, evidence: Evidence) -> Self {
        Self {
            height,
            evidence,
            term: None,
            length: 0.0,
        }
    }
}

/// Minima as nodes (node index = [`MinimumId`]), connections as edges.
pub type Network = UnGraph<Minimum, Edge>;

/// Properties that decide which of two paths between the same minima is better.
#[derive(Clone, Copy)]
pub(super) struct Claim {
    /// Whether the energy declares the highest point invalid.
    pub(super) invalid: bool,
    pub(super) height: f64,
    pub(super) evidence: Evidence,
}

impl Claim {
    /// Whether this path is better. Valid paths come first, then lower ones. If the heights differ by at most `tie` (or
    /// `slack`, if the lower path is a chain, whose true maximum may lie between samples), the better evidence wins.
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
