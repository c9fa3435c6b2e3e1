//! Figure 2: what the relaxed force-closure test tells about the exact one → `figures/force_closure_estimate.png`,
//! `figures/force_closure_estimate.md`
//!
//! `cargo run --release --example force_closure_estimate`, well under a minute on two cores.

use descent::Descents;

mod descent;
mod fit;
#[path = "../line.rs"]
mod line;
mod picture;
mod quality;
mod report;
mod sets;

/// Random sets of three contacts, as many as in the paper.
const SETS: u64 = 500_000;
/// Sets that are optimised.
const DESCENTS: u64 = 20_000;
/// The same for more than three contacts, whose exact test is a cone programme.
const LARGER_DESCENTS: u64 = 2000;
/// Steps looked at: all of the first ones, so that the picture has a line.
const STEPS: usize = 40;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let threes = sets::threes(SETS);
    let descents = [
        Descents::of(3, DESCENTS, (0..=STEPS).collect()),
        Descents::of(4, LARGER_DESCENTS, vec![0]),
        Descents::of(5, LARGER_DESCENTS, vec![0]),
    ];
    let limit = fit::limit_with_slope(&threes, picture::PUBLISHED_SLOPE, [0.1, 3.0]);
    picture::draw(&threes, limit, &descents[0])?
        .save("figures/force_closure_estimate.png".as_ref())?;
    let text = report::text(&threes, limit, &descents);
    std::fs::write("figures/force_closure_estimate.md", text)?;
    Ok(())
}
