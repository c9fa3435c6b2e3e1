//! The map of the committed grasps, made if it is missing, and pictures of it by `landscape draw`.

#[path = "command.rs"]
mod command;

use std::error::Error;
use std::fs;
use std::path::Path;

use command::landscape;

/// The committed grasps of the bottle, without the ending.
pub(crate) const BOTTLE: &str = "data/grasps";

/// Draws the map of these grasps into a temporary folder and copies one picture of it as SVG and PNG.
pub(crate) fn draw(
    grasps: &str,
    options: &[&str],
    picture: &str,
    stem: &str,
) -> Result<(), Box<dyn Error>> {
    let map = format!("{grasps}.landscape");
    if !Path::new(&map).exists() {
        landscape(&["build", &format!("{grasps}.parquet")])?;
    }
    let folder = format!("target/{stem}");
    landscape(&[&["draw", &map, "-q", "-o", &folder][..], options].concat())?;
    for ending in ["svg", "png"] {
        fs::copy(
            format!("{folder}/{picture}.{ending}"),
            format!("figures/{stem}.{ending}"),
        )?;
    }
    Ok(())
}
