//! Import of `min.data` and `ts.data` of PATHSAMPLE or topsearch as a landscape.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};

use super::arguments::Import;
use crate::cli::args::Common;
use crate::cli::output::{check_inputs, check_place};
use crate::cli::printing::{complain, print, print_landscapes};
use crate::cli::provenance::name_of;
use crate::cli::report;
use crate::store::{AtomicFolder, Source, content_hash};
use crate::study::ImportedLandscape;
use crate::topography::exchange::Database;

pub(super) fn run(command: &Import, common: &Common) -> anyhow::Result<()> {
    let texts = ["min.data", "ts.data"].map(|name| read(&command.path, name));
    let [minima, states] = texts;
    let (minima, states) = (minima?, states?);
    let read =
        Database::read(&minima, &states).with_context(|| command.path.display().to_string())?;
    let output = match &command.output {
        Some(output) => output.clone(),
        None => named_after(&command.path)?,
    };
    check_place(&output)?;
    check_inputs(&output, &[&command.path])?;
    let groups = command.groups.settings();
    let source = Source {
        name: name_of(&command.path),
        content_hash: content_hash(&[minima.as_bytes(), states.as_bytes()]),
    };
    let made_by = &common.provenance.command;
    let imported = ImportedLandscape::new(&read, &groups, source, made_by);
    let folder = AtomicFolder::open(&output, true)?;
    let text = imported.write(&folder)?;
    if !command.page.no_report {
        report::write_into(&folder, &BTreeMap::new(), common)?;
    }
    let finished = folder.finish()?;
    if !common.quiet {
        print(&text);
        complain(&format!("wrote {}", finished.display()));
    }
    print_landscapes(common, &[finished])
}

fn read(folder: &Path, name: &str) -> anyhow::Result<String> {
    ensure!(
        folder.is_dir(),
        "{} is no folder: min.data and ts.data are read from one",
        folder.display()
    );
    let path = folder.join(name);
    let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    String::from_utf8(bytes).with_context(|| format!("{} is not text", path.display()))
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
