//! Local descent on a [`Space`](crate::space::Space).

mod lbfgs;
mod quench;

pub use lbfgs::{DescentSettings, lbfgs};
pub use quench::{Quench, QuenchSettings, quench};

use serde::{Deserialize, Serialize};

/// Why a search ended. Not converging is an outcome, not an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StopReason {
    /// The tolerance was met.
    Converged,
    /// The allowed evaluations or iterations were spent.
    Budget,
    /// No step lowers the energy any more (rounding, or a kink).
    Stalled,
}
