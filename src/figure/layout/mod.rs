//! Layout of trees and graphs: pure geometry without colours or files.

mod graph;
mod sheet;
mod tree;

pub use graph::{
    GraphLayout, components, majorise, pack, place_among, separate, shortest_paths, stress,
};
pub use sheet::place_in;
pub use tree::{TreeLayout, collapse, leaf_count, place};
