//! `landscape report`: a page (HTML) on which a landscape, two landscapes or the grasps of a file are explored.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail, ensure};
use clap::Args;

use super::args::{Common, HandAndObject};
use super::diff::{Side, between, notes};
use super::input::{self, open_landscape};
use super::label::with_labeller;
use super::output::{check_file, given_or_beside};
use super::run::Watch;
use crate::cli::printing::{complain, tell_path};
use crate::evaluation::taxonomy::Rule;
use crate::store::{AtomicFolder, GraspFile, LandscapeFiles, read_attempts, write_atomic};
use crate::study::{
    PageGrasps, PageLandscape, WrittenLandscape, grasp_page, label_all, landscape_page, name_of,
};
use crate::topography::{Attempt, Attempts};

/// Name of the page in the folder of a landscape.
pub(super) const PAGE: &str = "report.html";

/// Write a page.
#[derive(Debug, Args)]
pub(super) struct Report {
    /// The landscape (a folder of `landscape build`, `surface` or `import`), or a file of grasps.
    #[arg(value_name = "FOLDER|FILE")]
    shown: PathBuf,
    /// A second landscape, to be shown face to face with the first one.
    #[arg(value_name = "FOLDER")]
    other: Option<PathBuf>,
    /// The file to write; by default the name of the landscape with the ending `.report.html`, or the name of the file of
    /// grasps with the ending `.grasps.html`.
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Open the page in the browser of the system.
    #[arg(long)]
    open: bool,
    /// Show which grasps of the landscape held in simulation, from the file that `landscape stability` wrote for the same
    /// grasps.
    #[arg(long, value_name = "FILE")]
    stability: Option<PathBuf>,
    /// Greatest distance of corresponding minima of two landscapes, as in `landscape diff`.
    #[arg(
        long,
        value_name = "LENGTH",
        requires = "other",
        allow_negative_numbers = true
    )]
    within: Option<f64>,
    /// A labeller that `landscape label --learn` wrote, which names the grasps of a file in place of the rule.
    #[arg(long, value_name = "FILE")]
    by: Option<PathBuf>,
    #[command(flatten)]
    of: HandAndObject,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape report grasps.landscape --open                 grasps.report.html: explore the landscape
  landscape report grasps.parquet                          grasps.grasps.html: look at the grasps, and label them
  landscape report warm.landscape cold.landscape           warm.report.html: two landscapes face to face
  landscape report grasps.landscape --stability grasps.stability.parquet

The page is one file that needs neither a network nor this program: open it with a double click, mail it, put it into the
supplement of a paper. It shows the tree, the graph, the hand in three dimensions, a table and the 33 grasp types, all
linked. Move over a leaf to see its grasp; click two to play the lowest way between them; drag the line in the tree to see
families, click a join to see only what hangs below it, and an entry of the legend to see only that colour. What is chosen
stands in the address of the page, so a copied link shows the same.

The page of a file of grasps places them by likeness and shows what is known of them. Its button `Label` starts labelling by
keyboard; it saves labels.csv, which `landscape label grasps.parquet --from labels.csv` reads. `landscape build`, `surface` and `import` write the page of a
landscape as report.html into its folder.";

pub(super) fn run(command: &Report, common: &Common) -> anyhow::Result<()> {
    let ending = if command.shown.is_dir() {
        "report.html"
    } else {
        "grasps.html"
    };
    let output = given_or_beside(command.output.as_ref(), &command.shown, ending)?;
    let mut inputs = vec![command.shown.as_path()];
    inputs.extend(command.other.as_deref());
    inputs.extend(command.stability.as_deref());
    inputs.extend(command.by.as_deref());
    check_file(&output, &inputs, common.force)?;
    let page = if command.shown.is_dir() {
        of_landscapes(command, common)?
    } else {
        of_grasps(command, common)?
    };
    write_atomic(&output, page.as_bytes())
        .with_context(|| format!("cannot write {}", output.display()))?;
    tell_path(common, &output)?;
    if command.open {
        open(&output)?;
    }
    Ok(())
}

fn of_landscapes(command: &Report, common: &Common) -> anyhow::Result<String> {
    for (flag, given) in [("hand", &command.of.hand), ("object", &command.of.object)] {
        ensure!(
            given.is_none(),
            "--{flag}: the landscape describes its hand and object"
        );
    }
    ensure!(
        command.by.is_none(),
        "--by: the names of minima are those of the rule; show the file of grasps"
    );
    let held = match &command.stability {
        Some(path) => held(path)?,
        None => BTreeMap::new(),
    };
    let mut one = Opened::read(&command.shown)?;
    let made_by = &common.provenance.command;
    let Some(path) = &command.other else {
        return Ok(landscape_page(one.shown(&held), None, made_by)?);
    };
    ensure!(
        path.is_dir(),
        "{path}: a page of two needs two landscape folders, but this is a file; run `landscape build {path}` first, or show \
         its grasps alone: `landscape report {path}`",
        path = path.display()
    );
    let mut other = Opened::read(path)?;
    // Folders of one name are told apart by their paths.
    if one.name == other.name {
        one.name = command.shown.display().to_string();
        other.name = path.display().to_string();
    }
    let sides = [&one, &other].map(|opened| Side::of(opened.name.clone(), &opened.files));
    let [before, after] = sides;
    let (before, after) = (before?, after?);
    let (within, found) = between(&before, &after, command.within)?;
    if !common.quiet {
        for note in notes(&before, &after) {
            complain(&format!("note: {note}"));
        }
    }
    let other = (other.shown(&held), &found, within);
    Ok(landscape_page(one.shown(&held), Some(other), made_by)?)
}

/// A landscape that was read.
struct Opened {
    name: String,
    files: LandscapeFiles,
    attempts: Attempts,
}

impl Opened {
    fn read(folder: &Path) -> anyhow::Result<Self> {
        let files = open_landscape(folder)?;
        Ok(Self {
            name: name_of(folder),
            attempts: read_attempts(folder, &files)?,
            files,
        })
    }

    fn shown<'a>(&'a self, held: &'a BTreeMap<u64, bool>) -> PageLandscape<'a> {
        PageLandscape {
            name: &self.name,
            files: &self.files,
            attempts: &self.attempts,
            held,
            energy: None,
        }
    }
}

/// Whether each simulated grasp of a file held, by id.
pub(super) fn held(path: &Path) -> anyhow::Result<BTreeMap<u64, bool>> {
    let held = GraspFile::outcomes(path)?;
    ensure!(
        !held.is_empty(),
        "--stability {}: no grasp was simulated: run `landscape stability` on it first",
        path.display()
    );
    Ok(held)
}

fn of_grasps(command: &Report, common: &Common) -> anyhow::Result<String> {
    if let Some(other) = &command.other {
        bail!(
            "{shown}: a page of two needs two landscape folders, but this is a file; run `landscape build {shown}` first, and \
             show its landscape beside {}",
            other.display(),
            shown = command.shown.display()
        );
    }
    ensure!(
        command.stability.is_none(),
        "--stability: not needed, because the file of grasps already contains the outcomes"
    );
    let file = input::grasps(&command.shown, &command.of, common)?;
    let rule = with_labeller(Rule::standard().clone(), command.by.as_deref())?;
    let labels = Watch::over(common.quiet, |run| label_all(&file, &rule, |_| true, run))?;
    let grasps = PageGrasps {
        name: &name_of(&command.shown),
        file: &file,
        labels: &labels,
    };
    Ok(grasp_page(grasps, &common.provenance.command)?)
}

/// Writes the page of a landscape into its folder. The page does not tell the name of the folder, as its other files do not;
/// it takes that from its own address.
pub(super) fn write_into(
    folder: &AtomicFolder,
    landscape: PageLandscape<'_>,
    common: &Common,
) -> anyhow::Result<()> {
    let page = landscape_page(landscape, None, &common.provenance.command)?;
    folder.write(PAGE, page.as_bytes())?;
    Ok(())
}

/// The same of a landscape of a surface.
pub(super) fn write_surface(
    folder: &AtomicFolder,
    written: &WrittenLandscape,
    attempts: &[Attempt],
    common: &Common,
) -> anyhow::Result<()> {
    let landscape = PageLandscape {
        name: "",
        files: &written.files,
        attempts: &written.files.attempts(attempts.to_vec()),
        held: &BTreeMap::new(),
        energy: None,
    };
    write_into(folder, landscape, common)
}

/// Opens a file with the program that the system has for it.
fn open(page: &Path) -> anyhow::Result<()> {
    let (program, words): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("cmd", &["/c", "start", ""])
    } else {
        ("xdg-open", &[])
    };
    let opened = Command::new(program).args(words).arg(page).status();
    match opened {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => bail!(
            "--open: `{program}` ended with {status}: open {} yourself",
            page.display()
        ),
        Err(error) => bail!(
            "--open: cannot run `{program}` ({error}): open {} yourself",
            page.display()
        ),
    }
}
