//! `landscape import`: reads the files of other programs, grasps or a landscape.

mod arguments;
mod grasps;
mod landscape;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::ensure;

pub(super) use arguments::{EXAMPLES, Import};

use super::args::Common;
use crate::store::exchange::files_of;

pub(super) fn run(command: &Import, common: &Common) -> anyhow::Result<()> {
    let family_barrier = command.families.checked()?;
    if holds_grasps(&command.path) {
        ensure!(
            family_barrier.is_none(),
            "--family-barrier is for min.data and ts.data: grasps have families only once `landscape build` mapped them"
        );
        ensure!(
            !command.page.no_report,
            "--no-report is for min.data and ts.data: of grasps no page is written (`landscape report` writes one)"
        );
        return grasps::run(command, common);
    }
    let path = &command.path;
    ensure!(path.exists(), "{}: no such file or folder", path.display());
    ensure!(
        path.is_file() || path.join("min.data").exists(),
        "{}: contains neither .npy files of grasps nor min.data and ts.data of a landscape{}",
        path.display(),
        deeper(path).map_or(String::new(), |folder| format!(
            "; grasps lie deeper, for instance in {}: import each such folder",
            folder.display()
        ))
    );
    ensure!(
        command.hand.is_none() && command.object.is_none(),
        "{}: --hand and --object are for grasps, but these files contain a landscape",
        path.display()
    );
    landscape::run(command, common)
}

/// Whether a path contains grasps, or a file that may have been taken for such, rather than a landscape.
fn holds_grasps(path: &Path) -> bool {
    let of_landscape = ["min.data", "ts.data"].map(OsStr::new);
    path.is_file()
        && !of_landscape
            .iter()
            .any(|name| path.file_name() == Some(name))
        || (path.is_dir()
            && !path.join("min.data").exists()
            && !files_of(path).unwrap_or_default().is_empty())
}

/// A folder below `path`, at most three levels down, with .npy files.
fn deeper(path: &Path) -> Option<PathBuf> {
    let mut folders = vec![path.to_path_buf()];
    for _ in 0..3 {
        let entries = folders.iter().filter_map(|folder| folder.read_dir().ok());
        let mut below: Vec<PathBuf> = entries
            .flat_map(|entries| entries.flatten().map(|entry| entry.path()))
            .filter(|path| path.is_dir())
            .collect();
        below.sort();
        let holds = |folder: &&PathBuf| !files_of(folder).unwrap_or_default().is_empty();
        if let Some(folder) = below.iter().find(holds) {
            return Some(folder.clone());
        }
        folders = below;
    }
    None
}
