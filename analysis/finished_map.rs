//! The map of the committed grasps, made if it is missing, and pictures of it by `landscape draw`.

#[path = "command.rs"]
mod command;

use std::error::Error;
use std::fs;
use std::path::Path;

use command::landscape;

/// The committed grasps.
const GRASPS: &str = "data/grasps.parquet";
const MAP: &str = "data/grasps.landscape";

/// Draws the map into a temporary folder and copies one picture of it as SVG and PNG.
pub(crate) fn draw(options: &[&str], picture: &str, stem: &str) -> Result<(), Box<dyn Error>> {
    if !Path::new(MAP).exists() {
        landscape(&["build", GRASPS])?;
    }
    let folder = format!("target/{stem}");
    landscape(&[&["draw", MAP, "-q", "-o", &folder][..], options].concat())?;
    for ending in ["svg", "png"] {
        fs::copy(
            format!("{folder}/{picture}.{ending}"),
            format!("figures/{stem}.{ending}"),
        )?;
    }
    Ok(())
}
