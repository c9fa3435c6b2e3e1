//! Half two: maps any energy. Minima, paths between them, barriers, the tree.

mod adelm;
mod barrier;
mod journal;
mod minima;
mod network;
mod path;
mod progress;
mod tree;

pub use adelm::{Chain, ChainSettings, chain};
pub use barrier::{Connection, Connector, Crossing, Effort, Start};
pub use journal::{Journal, MemoryJournal, NoJournal};
pub use minima::{HoppingSettings, Rejected, Sameness, distinct, hop, quench_all};
pub use network::{Edge, Evidence, Minimum, MinimumId, Network};
pub use path::{Pass, Path, PathSettings};
use progress::Tally;
pub use progress::{Observer, Phase, Progress, silent};
pub use tree::{Node, NodeId, Tree, decisive};
