//! Where things go: pure geometry, no colours and no files.

mod graph;
mod sheet;
mod tree;

pub use graph::{GraphLayout, components, majorise, pack, separate, shortest_paths, stress};
pub use sheet::place_in;
pub use tree::{LeafOrder, TreeLayout, collapse, leaf_count, place};
