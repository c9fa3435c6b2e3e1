//! `landscape stability`: simulates the grasps of a file in a physics engine.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use super::args::{Again, Common, HandAndObject};
use super::input;
use super::output::check_file;
use super::run::{Watch, open_journal, stoppable};
use crate::cli::printing::{explain_settings, tell_written};
use crate::evaluation::stability::{Drop, Protocol, SixDirections};
use crate::study::{Run, Simulation, simulate_all, simulation_fingerprint, tally};

/// Simulate grasps.
#[derive(Debug, Args)]
pub(super) struct Stability {
    /// The grasps: a file of `landscape synth`, or your own file with the same columns.
    #[arg(value_name = "FILE")]
    grasps: PathBuf,
    /// The protocol of the test; see below.
    #[arg(long, value_enum, default_value_t = ProtocolName::Drop, conflicts_with = "settings")]
    protocol: ProtocolName,
    /// Your own protocol (TOML): `protocol = "drop"` or `"six-directions"` and any of its numbers.
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

/// Tests of stability.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ProtocolName {
    /// Gravity on an object in a rigid hand.
    Drop,
    /// Pushes along six directions in a hand that squeezes.
    SixDirections,
    /// Pushes along six directions in a rigid hand.
    SixDirectionsRigid,
}

impl ProtocolName {
    /// The protocol with its standard numbers.
    pub(super) fn numbers(self) -> Protocol {
        match self {
            Self::Drop => Protocol::Drop(Drop::default()),
            Self::SixDirections => Protocol::SixDirections(SixDirections::default()),
            Self::SixDirectionsRigid => Protocol::SixDirections(SixDirections::rigid()),
        }
    }
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape stability grasps.parquet                       grasps.stability.parquet: the same with a column `stable`
  landscape stability grasps.parquet --protocol six-directions -o held.parquet
  landscape config stability > mine.toml                   the protocol with all its numbers
  landscape stability grasps.parquet --config mine.toml    a protocol of your own

Protocols (rigid bodies, Coulomb friction, the Rapier engine in its deterministic mode):
  drop                  The test of Liu et al. (2021). The hand is rigid and does not move; gravity of 10 m/s² pulls the
                        object down its z axis for 1000 steps of 1/60 s. A grasp is stable if the object falls less than
                        0.3 m. The friction in contact is 0.25. The object first settles for a second without gravity,
                        in which only parts that overlap press. The test ends early with a stable grasp if the object
                        rests (it moves less than 10 µm in a quarter of a second).
  six-directions        The test in use today (DexGraspBench). Gravity is off; the object weighs 0.1 kg and is pushed
                        with 1 N along ±x, ±y and ±z, 2 s each. A grasp is stable if the object moves less than 5 cm and
                        turns less than 15° in all six. The friction is 0.6. Springs pull the joints toward the object.
  six-directions-rigid  The same with rigid joints.
In every protocol, a grasp fails if hand and object overlap by more than 1 cm at the start.

Adds the columns stable, stable_reason (held, overlap, fell, moved, turned, lost), stable_displacement_m and
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
    let journal = open_journal(&output, &fingerprint, &command.again, common.quiet)?;
    explain_settings(
        "each grasp is simulated by itself with this protocol",
        &protocol,
    );
    let watch = Watch::new(common.quiet);
    let run = Run {
        journal: &stoppable(&journal),
        observer: &|news| watch.see(news),
        ..Run::default()
    };
    let found = simulate_all(&file, &protocol, &run)?;
    watch.clear();
    file.metadata.remade_by(&common.provenance.command, inputs);
    found.record(&mut file, &protocol);
    file.write(&output)?;
    journal.remove()?;
    let report = value(&found, &protocol, &output);
    tell_written(common, &report, &output.display().to_string())
}

fn protocol(command: &Stability) -> anyhow::Result<Protocol> {
    let Some(path) = &command.settings else {
        return Ok(command.protocol.numbers());
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
        "objects": found.fits,
        "protocol": protocol,
        "seconds": found.seconds,
        "preparation_seconds": found.preparation_seconds,
        "wrote": [output],
    })
}
