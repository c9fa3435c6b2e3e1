//! Widened fixtures and the errors of poses under which they are labelled, for the programs that judge or fit with them.

#[path = "../tests/taxonomy/fixture.rs"]
mod fixture;
#[expect(dead_code, reason = "tests need shares")]
#[path = "../tests/taxonomy/judge.rs"]
pub(crate) mod judge;
#[expect(
    dead_code,
    reason = "what only `pose_fixtures` calls makes widened fixtures"
)]
#[path = "../tests/taxonomy/widened.rs"]
mod widened;

use std::path::Path;

use crate::Failure;
use judge::{Case, Error, Noise, read, widened_cases};

const FOLDER: &str = "tests/taxonomy/fixtures";

/// The widened fixtures of a file that belong to the authored ones of these files. Only those on objects of one solid, which
/// need no field: the others would take hours.
pub(crate) fn scenes(file: &str, authored: &[&str]) -> Result<Vec<Case>, Failure> {
    let path = |name: &str| format!("{FOLDER}/{name}.json");
    let mut all = Vec::new();
    for name in authored {
        all.extend(read(Path::new(&path(name)))?);
    }
    all.retain(|fixture| fixture.object.len() == 1);
    widened_cases(Path::new(&path(file)), all)
}

/// No errors, errors of the joints, and errors of the hand's place and joints. The last two are like those of people who pose
/// by eye: their hands are 3 mm deep in the object in the median and 7 mm in the worst tenth.
pub(crate) fn conditions(seed: u64) -> [(&'static str, Noise); 5] {
    let of = |joints_rad, place_m| Noise {
        error: Error::Moved,
        joints_rad,
        place_m,
        copies: 1,
        seed,
    };
    [
        ("as posed", of(0.0, 0.0)),
        ("joints moved by 0.1 rad", of(0.1, 0.0)),
        (
            "hand moved by 3 mm along each axis, joints by 0.05 rad",
            of(0.05, 0.003),
        ),
        (
            "hand moved by 5 mm along each axis, joints by 0.15 rad",
            of(0.15, 0.005),
        ),
        (
            "hand moved by 8 mm along each axis, joints by 0.2 rad",
            of(0.2, 0.008),
        ),
    ]
}
