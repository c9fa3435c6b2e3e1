//! Figure 7: the disconnectivity graph of the committed grasps in the colours of their categories, with examples →
//! `figures/fig07_disconnectivity.svg` and `.png`
//!
//! `cargo run --release --example fig07_disconnectivity` makes the map first if it is missing (two minutes).

#[path = "finished_map.rs"]
mod finished_map;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    finished_map::draw(
        finished_map::BOTTLE,
        &["--colour", "category", "--examples", "8"],
        "disconnectivity",
        "fig07_disconnectivity",
    )
}
