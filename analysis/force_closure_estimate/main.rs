//! Figure 2: the relaxed force-closure test compared with the exact one → `figures/force_closure_estimate.png`,
//! `figures/force_closure_estimate.md`
//!
//! `cargo run --release --example force_closure_estimate` takes well under a minute on two cores.

use descent::Descents;

mod density;
mod descent;
mod fit;
#[path = "../line.rs"]
mod line;
mod picture;
mod quality;
#[expect(dead_code, reason = "other programs use all of it")]
#[path = "../relaxed.rs"]
mod relaxed;
mod report;
mod sets;

/// Number of random sets of three contacts, as in the paper.
const SETS: u64 = 500_000;
/// Number of optimised sets.
const DESCENTS: u64 = 20_000;
/// Number of optimised sets of more than three contacts, whose exact test is a cone programme.
const LARGER_DESCENTS: u64 = 2000;
/// Number of steps that are recorded; the picture shows all of them as a line.
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
