//! `landscape stability`: simulates the grasps of a file in a physics engine.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use serde_json::{Value, json};

use super::args::{Again, Common, HandAndObject};
use super::input;
use super::output::check_file;
use super::run::resumable;
use crate::cli::printing::{explain_settings, tell_written};
use crate::evaluation::stability::{NAMED, Protocol, named};
use crate::study::{Simulation, simulate_all, simulation_fingerprint, tally};

/// Simulate grasps.
#[derive(Debug, Args)]
pub(super) struct Stability {
    /// The grasps: a file of `landscape synth`, or your own file with the same columns.
    #[arg(value_name = "FILE")]
    grasps: PathBuf,
    /// The protocol of the test; see below.
    #[arg(long, value_name = "NAME", value_parser = protocol_names(), default_value = "drop", conflicts_with = "settings")]
    protocol: String,
    /// Your own protocol (TOML): `protocol = "drop"` or another name, and any of its numbers.
    #[arg(long = "config", value_name = "FILE")]
    settings: Option<PathBuf>,
    /// The file to write; by default the name of the grasps with the ending `.stability.parquet`.
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    of: HandAndObject,
    #[command(flatten)]
    again: Again,
}

/// The names of the published tests, each with what it is.
pub(super) fn protocol_names() -> PossibleValuesParser {
    let values = NAMED
        .iter()
        .map(|test| PossibleValue::new(test.name.as_str()).help(test.title.as_str()));
    PossibleValuesParser::new(values)
}

/// The published test of one of [`protocol_names`].
pub(super) fn published(name: &str) -> anyhow::Result<Protocol> {
    named(name).with_context(|| format!("the protocol {name} is unknown"))
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape stability grasps.parquet                       grasps.stability.parquet: the same with a column `stable`
  landscape stability grasps.parquet --protocol dexgraspbench -o held.parquet
  landscape config stability > mine.toml                   the protocol with all its numbers
  landscape stability grasps.parquet --config mine.toml    a protocol of your own

Protocols (rigid bodies, Coulomb friction, the Rapier engine in its deterministic mode). Each is a published test with the
numbers of its source, which `landscape config stability --protocol NAME` prints:
  drop                The hand is rigid and does not move; gravity of 10 m/s² pulls the object down its z axis for 1000
                      steps of 1/60 s. A grasp holds if the object falls less than 0.3 m. The object first settles for a
                      second without gravity, in which only parts that overlap press.
  dexgraspbench       No gravity; the object weighs 0.1 kg and is pushed with 1 N along ±x, ±y and ±z, 2 s each, from the
                      closed hand. A grasp holds if it moves less than 5 cm and turns less than 15° in all six.
  dexgraspbench-hard  The same at half the friction, as Dexonomy has it.
  dexgraspnet         The weight acts along ±x, ±y and ±z. A grasp holds if the hand still touches at the end of each.
  graspqp             Pulls of 3 N on 0.2 kg along ±z, ±x, ±y. A grasp holds if it moves less than 3 cm along one axis.
  graspqp-all         The same along all axes.
  gendexgrasp         Joints close by 0.5 rad; six pushes follow each other. A grasp holds if it moves less than 2 cm in each.
  graspdatagen        Joints close to their limits; five tugs follow each other. A grasp holds if two digits still press.
Where the hand closes, springs pull its joints. Where a test needs squeezed joints and the file has none, they follow from
contact forces that balance; the summary counts these grasps (closed_by). A test ends early with an object at rest (it
moves less than 10 µm in a quarter of a second, or under a load less than 0.1 mm in a tenth of a second). In every
protocol, a grasp fails if hand and object overlap by more than 1 cm at the start.

Adds the columns stable, stable_reason (held, overlap, fell, moved, turned, released, lost), stable_displacement_m and
stable_turn_rad, and stores the protocol with all its numbers in the file's metadata. Objects are cut into convex
pieces; the summary says how well these fit. An interrupted run continues where it stopped when the same command is
given again.";

pub(super) fn run(command: &Stability, common: &Common) -> anyhow::Result<()> {
    let protocol = protocol(command)?;
    let output = command
        .output
        .clone()
        .unwrap_or_else(|| command.grasps.with_extension("stability.parquet"));
    let inputs = [Some(&command.grasps), command.settings.as_ref()];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    check_file(&output, &inputs, common.force)?;
    let mut file = input::grasps(&command.grasps, &command.of, common)?;
    let inputs = common.provenance.sources()?;

    let fingerprint = simulation_fingerprint(&file, &protocol)?;
    explain_settings(
        "each grasp is simulated by itself with this protocol",
        &protocol,
    );
    let quiet = common.quiet;
    let (found, journal) = resumable(&output, &fingerprint, &command.again, quiet, |run| {
        Ok(simulate_all(&file, &protocol, run)?)
    })?;
    file.metadata.remade_by(&common.provenance.command, inputs);
    found.record(&mut file, &protocol);
    file.write(&output)?;
    journal.remove()?;
    let report = value(&found, &protocol, &output);
    tell_written(common, &report, &output.display().to_string())
}

fn protocol(command: &Stability) -> anyhow::Result<Protocol> {
    let Some(path) = &command.settings else {
        return published(&command.protocol);
    };
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("--config: cannot read {}", path.display()))?;
    let protocol: Protocol = crate::study::protocol_of_text(&text)
        .with_context(|| format!("{} is not a protocol", path.display()))?;
    protocol
        .validate()
        .with_context(|| path.display().to_string())?;
    Ok(protocol)
}

/// The report.
fn value(found: &Simulation, protocol: &Protocol, output: &Path) -> Value {
    let reasons = found
        .outcomes
        .iter()
        .map(|(_, outcome)| outcome.reason.name());
    json!({
        "grasps": found.outcomes.len(),
        "stable": found.stable(),
        "reasons": BTreeMap::from_iter(tally(reasons)),
        "closed_by": found.closed_by(),
        "objects": found.fits,
        "protocol": protocol,
        "seconds": found.seconds,
        "preparation_seconds": found.preparation_seconds,
        "wrote": [output],
    })
}
