//! Figures 8a to 8c: the barrier graph of the minima of the committed grasps of the bottle, coloured by category and by the
//! shape that power grasps hold, and that of the ellipsoid, coloured by sphere grasps and their neighbours →
//! `figures/fig08a_categories`, `fig08b_power`, `fig08c_spheres`, each `.svg` and `.png`
//!
//! `cargo run --release --example fig08_barriers` makes missing maps first (ten minutes of CPU).

#[path = "finished_map.rs"]
mod finished_map;

/// The committed grasps of the ellipsoid, which is held as a sphere.
const ELLIPSOID: &str = "data/experiments/ellipsoid";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (grasps, colouring, stem) in [
        (finished_map::BOTTLE, "category", "fig08a_categories"),
        (finished_map::BOTTLE, "power", "fig08b_power"),
        (ELLIPSOID, "spheres", "fig08c_spheres"),
    ] {
        finished_map::draw(grasps, &["--colour", colouring], "barriers_minima", stem)?;
    }
    Ok(())
}
