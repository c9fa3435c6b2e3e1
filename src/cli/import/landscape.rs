//! Import of `min.data` and `ts.data` of PATHSAMPLE or topsearch as a landscape.

use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};

use super::arguments::Import;
use crate::cli::args::Common;
use crate::cli::output::{check_inputs, check_place};
use crate::cli::printing::{complain, print, print_landscapes};
use crate::cli::report;
use crate::printable::counted;
use crate::store::{AtomicFolder, Source, content_hash};
use crate::study::{ImportedLandscape, StationaryCoordinates, name_of};
use crate::topography::exchange::{
    Database, Layout, NO_TRANSITION_STATES, Reading, counted_points, points_of_text,
};

pub(super) fn run(command: &Import, common: &Common) -> anyhow::Result<()> {
    let minima = read(&command.path, "min.data")?;
    let alone = !command.path.join("ts.data").exists();
    let states = if alone {
        String::new()
    } else {
        read(&command.path, "ts.data")?
    };
    let read =
        Database::read(&minima, &states).with_context(|| command.path.display().to_string())?;
    let output = match &command.output {
        Some(output) => output.clone(),
        None => named_after(&command.path)?,
    };
    check_place(&output)?;
    check_inputs(&output, &[&command.path])?;
    let families = command.families.settings();
    let source = Source {
        name: name_of(&command.path),
        content_hash: content_hash(&[minima.as_bytes(), states.as_bytes()]),
    };
    let made_by = &common.provenance.command;
    let (coordinates, note) = coordinates(&command.path, &read)?;
    let mut imported = ImportedLandscape::new(&read, coordinates, &families, source, made_by);
    if alone {
        imported = imported.noting(NO_TRANSITION_STATES.to_owned());
    }
    if let Some(note) = note {
        imported = imported.noting(note);
    }
    let folder = AtomicFolder::open(&output, true)?;
    let written = imported.write(&folder)?;
    if !command.page.no_report {
        report::write_surface(&folder, &written, &[], common)?;
    }
    let finished = folder.finish()?;
    if !common.quiet {
        print(&written.text);
        complain(&format!("wrote {}", finished.display()));
    }
    print_landscapes(common, &[finished])
}

fn read(folder: &Path, name: &str) -> anyhow::Result<String> {
    ensure!(
        folder.is_dir(),
        "{} is not a folder: name the folder that contains min.data and ts.data",
        folder.display()
    );
    let path = folder.join(name);
    let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    String::from_utf8(bytes).with_context(|| format!("{} is not text", path.display()))
}

/// The coordinates that lie beside `min.data` and `ts.data`, and a sentence about files that do not belong to these. Without
/// such a file they are unknown, which is no fault.
fn coordinates(
    folder: &Path,
    read: &Reading,
) -> anyhow::Result<(StationaryCoordinates, Option<String>)> {
    let names = match read.layout {
        Layout::Pathsample => ["points.min", "points.ts"],
        Layout::Topsearch => ["min.coords", "ts.coords"],
    };
    let counts = [
        read.database.minima.len(),
        read.database.transition_states.len(),
    ];
    let unknown = StationaryCoordinates::default();
    let mut points = [Vec::new(), Vec::new()];
    let mut width = None;
    for ((name, count), points) in names.into_iter().zip(counts).zip(&mut points) {
        let path = folder.join(name);
        if !path.is_file() {
            continue;
        }
        let bytes =
            std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let rows = match read.layout {
            Layout::Pathsample => counted_points(&bytes, count),
            Layout::Topsearch => points_of_text(&bytes).ok(),
        };
        let fits = |rows: &Vec<Vec<f64>>| {
            let mut widths = rows.iter().map(Vec::len);
            rows.len() == count && widths.all(|found| *width.get_or_insert(found) == found)
        };
        let Some(rows) = rows.filter(fits) else {
            let note = format!(
                "coordinates were not read: {name} does not contain as many coordinates for each of {}",
                counted(count, "point")
            );
            return Ok((unknown, Some(note)));
        };
        *points = rows;
    }
    let [minima, transition_states] = points;
    Ok((
        StationaryCoordinates {
            minima,
            transition_states,
        },
        None,
    ))
}

/// The output `folder.landscape` in the current directory.
fn named_after(folder: &Path) -> anyhow::Result<PathBuf> {
    let name = name_of(folder);
    ensure!(
        !name.is_empty(),
        "{}: name the folder to write with --output",
        folder.display()
    );
    Ok(PathBuf::from(format!("{name}.landscape")))
}
