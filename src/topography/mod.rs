//! Maps any energy: minima, paths between them, barriers and the tree.

mod adelm;
mod audit;
mod barrier;
mod build;
mod difference;
mod eigen;
pub mod exchange;
mod families;
mod follow;
mod journal;
mod landscape;
mod linkage;
mod merges;
mod minima;
mod network;
mod pairs;
mod path;
mod places;
mod progress;
mod rarefaction;
mod ripples;
mod scales;
mod search;
mod sequential;
mod support;
mod text;
mod tree;
mod trough;
mod tuning;
pub mod view;

pub use adelm::{Chain, ChainSettings, chain};
pub use audit::{Audit, AuditSettings, Verdict, audit};
pub use barrier::{Connection, Connector, Crossing, Pair, Start};
pub use build::{Addition, MapSettings, PairSearch, build_landscape, grow_landscape};
pub use difference::{Match, MergeChange, NEIGHBOUR_REACH, TooNear, TreeDifference};
pub use families::{Families, FamilySettings, Level};
#[cfg(feature = "cli")]
pub(crate) use journal::Prefixed;
pub use journal::{GuardedJournal, Journal, JournalError, MemoryJournal, Run};
pub use landscape::{Landscape, NoMinimum};
pub use merges::{Merge, minimax_path};
pub use minima::{MatchTolerance, Rejected, distinct, quench_all};
pub use network::{Edge, Evidence, Minimum, MinimumId, Network};
pub use path::{LoweringSettings, Pass, Path, PathSettings};
pub(crate) use progress::Tally;
pub use progress::{Observer, Phase, Progress};
pub use rarefaction::{Completeness, LEAST_MEMBERS, Rarefaction, Rarefied};
pub use scales::Scales;
#[cfg(feature = "cli")]
pub(crate) use scales::median;
#[cfg(feature = "cli")]
pub(crate) use search::mark_branches;
pub use search::{
    Coverage, Doubt, Draw, Exploration, Further, Limits, Refused, SearchEnd, SearchSettings,
    TransitionState, explore, explore_from, in_box,
};
#[cfg(feature = "chemistry")]
pub use search::{
    LowestReport, LowestSettings, LowestTrace, SizeProbe, explore_lowest, probe_size,
};
pub use sequential::{Sequential, SequentialSettings, sequential};
pub use support::{Attempt, Attempts, Searched, chance_of_lower};
pub use text::{dot, graphml, newick, tree_json};
pub use tree::{Ancestors, Node, NodeId, Tree, spanning_forest};
pub use tuning::{Tuning, TuningSettings, TuningTrial, log_grid, tune};
