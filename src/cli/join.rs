//! `landscape join`: several files of grasps as one.

use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use clap::Args;
use serde_json::{Value, json};

use super::args::{Common, HandAndObject};
use super::input;
use super::output::check_file;
use crate::cli::printing::{complain, tell_written};
use crate::store::{GraspFile, JoinedFile, Source};

/// Put files of grasps together.
#[derive(Debug, Args)]
pub(super) struct Join {
    /// The files, two or more.
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// The file to write; by default the name of the first file with the ending `.joined.parquet`.
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    of: HandAndObject,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape join monday.parquet tuesday.parquet -o mug.parquet      the grasps of both, for build, diversity and so on
  landscape join a.parquet b.parquet c.parquet                      a.joined.parquet

The grasps stand in the order of the files and have new ids from 0; the column `source` names file and id before
(`monday.parquet 12`). Every other value stays as it is. Hands and objects of one name must be the same ones. All files must
be of one energy, and of one protocol and one rule where they were simulated and labelled. Grasps that two files share,
bit for bit, are kept, with a warning: in statistics they count twice. Files with the same seed and settings share all grasps,
so make more grasps with another --seed.

A landscape contains its grasps, too: `landscape join one.landscape/grasps.parquet more.parquet`.";

pub(super) fn run(command: &Join, common: &Common) -> anyhow::Result<()> {
    ensure!(
        command.files.len() > 1,
        "{} is one file: name two or more to put together",
        command.files[0].display()
    );
    let output = match &command.output {
        Some(output) => output.clone(),
        None => command.files[0].with_extension("joined.parquet"),
    };
    let flags = [&command.of.hand, &command.of.object];
    let flags = flags.into_iter().flatten().map(Path::new);
    let inputs: Vec<&Path> = command
        .files
        .iter()
        .map(PathBuf::as_path)
        .chain(flags)
        .collect();
    check_file(&output, &inputs, common.force)?;
    let read = (command.files.iter())
        .map(|path| input::grasps(path, &command.of, common))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let mut sources = common.provenance.sources()?;
    // The files come first, then hand and object.
    let others = sources.split_off(read.len().min(sources.len()));
    ensure!(
        sources.len() == read.len(),
        "a file was removed while it was read: give the command again"
    );
    let files: Vec<(Source, GraspFile)> = sources.into_iter().zip(read).collect();
    let mut joined = GraspFile::join(&files, &common.provenance.command)?;
    joined.file.metadata.inputs.extend(others);
    joined
        .file
        .write(&output)
        .with_context(|| format!("cannot join into {}", output.display()))?;
    if !common.quiet {
        let notes = joined.notes.iter().cloned().chain(repeated(&joined));
        notes.for_each(|note| complain(&format!("note: {note}")));
    }
    let report = value(&files, &joined, &output);
    tell_written(common, &report, &output.display().to_string())
}

/// A note on grasps that are there twice.
fn repeated(joined: &JoinedFile) -> Option<String> {
    let [last, first] = joined.repeated.first()?;
    let of = |id: &u64| {
        let row = joined.file.grasps.iter().find(|row| row.id == *id);
        let source = row.map_or("", |row| row.source.as_str());
        // Without what the file itself had told.
        source.split_once(": ").map_or(source, |(place, _)| place)
    };
    Some(format!(
        "{} another one bit for bit (the first: {} is {}) and would count twice: leave out one of the files, or make more \
         grasps with another --seed",
        match joined.repeated.len() {
            1 => "1 grasp repeats".to_owned(),
            several => format!("{several} grasps repeat"),
        },
        of(last),
        of(first)
    ))
}

fn names<'a>(names: impl Iterator<Item = &'a String>) -> Vec<&'a str> {
    names.map(String::as_str).collect()
}

/// The report.
fn value(files: &[(Source, GraspFile)], joined: &JoinedFile, output: &Path) -> Value {
    let metadata = &joined.file.metadata;
    let files = files.iter().map(|(source, file)| {
        json!({ "name": source.name, "grasps": file.grasps.len(), "content_hash": source.content_hash })
    });
    json!({
        "grasps": joined.file.grasps.len(),
        "files": files.collect::<Vec<_>>(),
        "hands": names(metadata.hands.iter().map(|hand| &hand.name)),
        "objects": names(metadata.objects.iter().map(|object| &object.name)),
        "repeated": joined.repeated,
        "notes": joined.notes,
        "wrote": [output],
    })
}
