//! The map of the committed grasps, made where it is missing, and pictures that `landscape draw` makes of it.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

/// The committed grasps.
pub(crate) const GRASPS: &str = "data/grasps.parquet";
const MAP: &str = "data/grasps.landscape";

/// Runs `landscape` with these arguments.
pub(crate) fn landscape(arguments: &[&str]) -> Result<(), Box<dyn Error>> {
    let code = landscape::cli::run_with([&["landscape"], arguments].concat());
    if code == ExitCode::SUCCESS {
        Ok(())
    } else {
        Err(format!("landscape {} failed", arguments.join(" ")).into())
    }
}

/// Draws the map into a folder of its own and copies one picture of it, as SVG and PNG.
#[allow(
    dead_code,
    reason = "one of the programs that share this draws nothing"
)]
pub(crate) fn draw(options: &[&str], picture: &str, stem: &str) -> Result<(), Box<dyn Error>> {
    if !Path::new(MAP).exists() {
        landscape(&["build", GRASPS])?;
    }
    let folder = format!("target/{stem}");
    landscape(&[&["draw", MAP, "-q", "-o", &folder], options].concat())?;
    for ending in ["svg", "png"] {
        fs::copy(
            format!("{folder}/{picture}.{ending}"),
            format!("figures/{stem}.{ending}"),
        )?;
    }
    Ok(())
}
