//! `landscape hands can`: which grasp types a hand can do on some objects.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::ensure;
use clap::{Args, ValueHint};

use super::args::{Again, Common, within};
use super::hands::picture_named;
use super::input;
use super::output::{Report, check_report, write_report};
use super::run::resumable;
use crate::limits::CHAINS;
use crate::store::content_hash;
use crate::study::{Origin, hand_abilities, possible_types};

/// Which grasp types a hand can do on some objects.
#[derive(Debug, Args)]
pub(super) struct HandsCan {
    /// The hand: the name of a built-in hand, or a URDF, MJCF or MANO (.npz) file. It must be built like a human one.
    #[arg(value_name = "HAND", value_hint = ValueHint::FilePath)]
    hand: String,
    /// The objects: names of built-in objects, meshes or TOML files of shapes.
    #[arg(value_name = "OBJECTS", required = true, value_hint = ValueHint::FilePath)]
    objects: Vec<String>,
    /// The folder with all files that the hand's description refers to (meshes, included files); by default its own folder.
    /// Files elsewhere are refused.
    #[arg(long, value_name = "FOLDER")]
    hand_folder: Option<PathBuf>,
    /// Use the hand's mirror image instead.
    #[arg(long)]
    mirror: bool,
    /// Number of chains for each type on each object.
    #[arg(short = 'n', long, default_value_t = 12, value_name = "N")]
    chains: u64,
    /// Seed of all random draws.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Name of the files to write: NAME.md, .csv, .json, .svg and .png. By default the name of the hand with `.can`, in the
    /// current folder.
    #[arg(long, short, value_name = "NAME")]
    output: Option<PathBuf>,
    #[command(flatten)]
    again: Again,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape hands can human ball pen mug                   human.can.md, .csv, .json, .png, .svg
  landscape hands can shadow.xml mug.obj -n 32 -o shadow   more chains of a hand and an object of your own
  landscape synth --hand shadow.xml --object mug.obj --types 9,14
                                                           the grasps themselves

Each chain is asked for one type (see `landscape synth --types`): the table says how many found it, and how many of these
hold when dropped in simulation. A type that no chain finds may need other objects or more chains. One type on one object
takes some ten seconds of one core. An interrupted run continues when the same command is given again.";

pub(super) fn run(command: &HandsCan, common: &Common) -> anyhow::Result<()> {
    within("-n", CHAINS, command.chains as f64)?;
    let output = command.output.clone().unwrap_or_else(|| {
        let name = picture_named(None, &command.hand);
        name.with_extension("can")
    });
    let inputs: Vec<&Path> = command
        .objects
        .iter()
        .map(Path::new)
        .chain([Path::new(&command.hand)])
        .collect();
    check_report(&output, &["csv"], &inputs, common.force)?;
    let hand = input::hand(
        &command.hand,
        command.hand_folder.as_deref(),
        command.mirror,
    )?;
    let mut notes: Vec<String> = hand.warnings().collect();
    let mut origins = Vec::new();
    let mut names = BTreeSet::new();
    for object in &command.objects {
        let (object, of_object) = input::object(object, None, None)?;
        notes.extend(of_object);
        ensure!(
            names.insert(object.name.clone()),
            "{}: two objects have this name; rename the file of one",
            object.name
        );
        origins.push(Origin {
            hand: hand.clone(),
            object,
            scale: 1.0,
            given: Vec::new(),
        });
    }
    if !common.quiet {
        input::warn(&notes);
    }
    possible_types(&origins[0])?;
    let fingerprint = format!("{origins:?} {} {}", command.chains, command.seed);
    let fingerprint = content_hash(&[fingerprint.as_bytes()]);
    let (output, quiet) = (output.as_path(), common.quiet);
    let (found, journal) = resumable(output, &fingerprint, &command.again, quiet, |run| {
        Ok(hand_abilities(&origins, command.chains, command.seed, run)?)
    })?;
    let report = Report {
        text: found.markdown(),
        value: found.to_json(),
        chart: Some(found.chart()),
        tables: vec![("csv", found.csv())],
    };
    write_report(Some(output), report, common)?;
    journal.remove()?;
    Ok(())
}
