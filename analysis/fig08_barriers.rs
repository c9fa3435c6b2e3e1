//! Figures 8a to 8c: the barrier graph of the minima of the committed grasps, coloured by category, by the shape that power
//! grasps hold, and by sphere grasps and their neighbours → `figures/fig08a_categories`, `fig08b_power`, `fig08c_spheres`,
//! each `.svg` and `.png`
//!
//! `cargo run --release --example fig08_barriers` makes the map first if it is missing (two minutes).

#[path = "finished_map.rs"]
mod finished_map;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (colouring, stem) in [
        ("category", "fig08a_categories"),
        ("power", "fig08b_power"),
        ("spheres", "fig08c_spheres"),
    ] {
        finished_map::draw(&["--colour", colouring], "barriers_minima", stem)?;
    }
    Ok(())
}
