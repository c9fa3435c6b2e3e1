//! `landscape import`: reads the files of other programs, grasps or a landscape.

mod arguments;
mod grasps;
mod landscape;

use std::path::Path;

use anyhow::ensure;

pub(super) use arguments::{EXAMPLES, Import};

use super::args::Common;
use crate::store::exchange::files_of;

pub(super) fn run(command: &Import, common: &Common) -> anyhow::Result<()> {
    let group_barrier = command.groups.checked()?;
    if holds_grasps(&command.path) {
        ensure!(
            group_barrier.is_none(),
            "--group-barrier is for min.data and ts.data: grasps have groups only once `landscape build` mapped them"
        );
        ensure!(
            !command.page.no_report,
            "--no-report is for min.data and ts.data: of grasps no page is written (`landscape report` writes one)"
        );
        return grasps::run(command, common);
    }
    ensure!(
        command.hand.is_none() && command.object.is_none(),
        "{}: --hand and --object are for grasps, but these files hold a landscape",
        command.path.display()
    );
    landscape::run(command, common)
}

/// Whether a path contains grasps rather than a landscape.
fn holds_grasps(path: &Path) -> bool {
    let kinds = ["npy", "csv", "json", "parquet"];
    let kind = path.extension().unwrap_or_default();
    path.is_file() && kinds.iter().any(|known| kind.eq_ignore_ascii_case(known))
        || (path.is_dir()
            && !path.join("min.data").exists()
            && !files_of(path).unwrap_or_default().is_empty())
}
