//! `landscape stability`: simulates the grasps of a file in a physics engine.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use clap::{Args, ValueEnum};
use rayon::prelude::*;
use serde_json::json;

use super::args::{Again, Common, HandAndObject};
use super::input;
use super::output::check_file;
use super::run::open_journal;
use super::{complain, print, progress};
use crate::evaluation::stability::{
    Build, Drop, Outcome, Protocol, SixDirections, Solid, simulate,
};
use crate::hand::Hand;
use crate::store::{GraspFile, GraspRow, Population, content_hash};
use crate::study::tally;

/// Simulate grasps.
#[derive(Debug, Args)]
pub(super) struct Stability {
    /// The grasps: a file of `landscape synth`, or your own file with the same columns.
    #[arg(value_name = "FILE")]
    grasps: PathBuf,
    /// The test, see below.
    #[arg(long, value_enum, default_value_t = ProtocolName::Drop, conflicts_with = "settings")]
    protocol: ProtocolName,
    /// Your own protocol (TOML): `protocol = "drop"` or `"six-directions"` and any of its numbers.
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Write the protocol with all its numbers to standard output, and do nothing else.
    #[arg(long)]
    print_protocol: bool,
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

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape stability grasps.parquet                       grasps.stability.parquet: the same with a column `stable`
  landscape stability grasps.parquet --protocol six-directions -o held.parquet
  landscape stability grasps.parquet --print-protocol > mine.toml
  landscape stability grasps.parquet --settings mine.toml  a protocol of your own

Protocols (rigid bodies, Coulomb friction, the Rapier engine in its deterministic mode):
  drop                  The test of Liu et al. (2021): a rigid hand that does not move, gravity of 10 m/s² down the object's
                        z axis, 1000 steps of 1/60 s; stable if the object falls less than 0.3 m. Friction 0.25 in contact:
                        0.5 for each body, multiplied. The object first settles for a second without gravity; what presses
                        is what overlaps. An object at rest (10 µm in a quarter of a second) holds: the test ends.
  six-directions        The test in use today (DexGraspBench): no gravity, the object is given 0.1 kg and pushed with 1 N
                        along ±x, ±y and ±z, 2 s each; stable if it moves less than 5 cm and turns less than 15° in all six.
                        Friction 0.6. The joints squeeze: springs pull them toward the object.
  six-directions-rigid  The same with rigid joints.
In all of them more than 1 cm of overlap at the start fails.

Adds the columns stable, stable_reason (held, overlap, fell, moved, turned, lost), stable_displacement_m and
stable_turn_rad; the protocol with all its numbers goes into the file's metadata. Objects are cut into convex pieces; how
well these fit is told. An interrupted run continues where it stopped when the same command is given again.";

/// Version of the engine, recorded because results are bitwise equal only for the same version.
const ENGINE: &str = "rapier3d-f64 0.36";

pub(super) fn run(command: &Stability, common: &Common) -> anyhow::Result<()> {
    let protocol = protocol(command)?;
    if command.print_protocol {
        print(&toml::to_string(&protocol)?);
        return Ok(());
    }
    let output = command
        .output
        .clone()
        .unwrap_or_else(|| command.grasps.with_extension("stability.parquet"));
    let inputs = [Some(&command.grasps), command.settings.as_ref()];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    check_file(&output, &inputs, common)?;
    let (mut file, warnings) = input::read(
        &command.grasps,
        command.of.hand.as_deref(),
        command.of.object.as_deref(),
    )?;
    let inputs = common.provenance.sources()?;
    if !common.quiet {
        input::warn(&warnings);
    }

    let mut journal_path = output.as_os_str().to_owned();
    journal_path.push(".partial");
    let told = serde_json::to_string(&(&protocol, &file.metadata, ENGINE))?;
    let rows = format!("{:?}", file.grasps);
    let fingerprint = content_hash(&[told.as_bytes(), rows.as_bytes()]);
    let journal = open_journal(
        &PathBuf::from(journal_path),
        &fingerprint,
        &command.again,
        common.quiet,
    )?;

    let mut seconds = 0.0;
    let bar = progress::bar("grasps", file.grasps.len() as u64, common.quiet);
    let mut outcomes: Vec<(u64, Outcome)> = Vec::with_capacity(file.grasps.len());
    let mut fits = Vec::new();
    for population in file.landscapes() {
        let place = Place::new(&population)?;
        fits.push(place.fit());
        let started = Instant::now();
        let of_population: Vec<(u64, Outcome)> = population
            .grasps
            .par_iter()
            .map(|grasp| {
                let key = format!("grasp {}", grasp.id);
                let known = journal
                    .get(&key)
                    .and_then(|bytes| serde_json::from_slice(&bytes).ok());
                let outcome = if let Some(outcome) = known {
                    outcome
                } else {
                    let outcome = place.simulate(grasp, &protocol);
                    journal.put(&key, &serde_json::to_vec(&outcome)?)?;
                    outcome
                };
                bar.inc(1);
                Ok((grasp.id, outcome))
            })
            .collect::<anyhow::Result<_>>()?;
        seconds += started.elapsed().as_secs_f64();
        outcomes.extend(of_population);
    }
    bar.finish_and_clear();

    outcomes.sort_by_key(|(id, _)| *id);
    for grasp in &mut file.grasps {
        let place = outcomes.binary_search_by_key(&grasp.id, |(id, _)| *id);
        if let Ok(place) = place {
            record(grasp, &outcomes[place].1);
        }
    }
    file.metadata.remade_by(&common.provenance.command, inputs);
    file.metadata.stability = json!({
        "protocol": protocol,
        "engine": ENGINE,
        "program_version": env!("CARGO_PKG_VERSION"),
        "objects": fits,
    });
    file.write(&output)?;
    journal.remove()?;
    if !common.quiet {
        print(&summary(&file, &outcomes, seconds));
        complain(&format!("wrote {}", output.display()));
    }
    Ok(())
}

fn protocol(command: &Stability) -> anyhow::Result<Protocol> {
    let Some(path) = &command.settings else {
        return Ok(match command.protocol {
            ProtocolName::Drop => Protocol::Drop(Drop::default()),
            ProtocolName::SixDirections => Protocol::SixDirections(SixDirections::default()),
            ProtocolName::SixDirectionsRigid => Protocol::SixDirections(SixDirections::rigid()),
        });
    };
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("--settings: cannot read {}", path.display()))?;
    let protocol: Protocol = crate::formats::toml_text::parse(&text)
        .with_context(|| format!("{} is not a protocol", path.display()))?;
    protocol
        .validate()
        .with_context(|| path.display().to_string())?;
    Ok(protocol)
}

struct Place {
    hand: std::sync::Arc<Hand>,
    solid: Solid,
    object: String,
    scale: f64,
    mass_kg: f64,
}

impl Place {
    fn new(population: &Population<'_>) -> anyhow::Result<Self> {
        let hand = population.hand()?;
        let (mesh, mass_kg) = population.mesh()?;
        Ok(Self {
            hand,
            solid: Solid::new(&mesh, Build::Pieces),
            object: population.object.name.clone(),
            scale: population.scale,
            mass_kg,
        })
    }

    fn fit(&self) -> serde_json::Value {
        let fit = self.solid.fit();
        json!({
            "object": self.object,
            "scale": self.scale,
            "pieces": fit.pieces,
            "volume_error": fit.volume_error,
            "filled_m": fit.filled_m,
            "cut_m": fit.cut_m,
        })
    }

    fn simulate(&self, grasp: &GraspRow, protocol: &Protocol) -> Outcome {
        simulate(
            &self.hand,
            &grasp.grasp,
            &self.solid,
            self.mass_kg,
            protocol,
        )
    }
}

fn record(grasp: &mut GraspRow, outcome: &Outcome) {
    let finite = |value: f64| value.is_finite().then_some(value);
    grasp.stable = Some(outcome.is_stable());
    grasp.stable_reason = Some(outcome.reason.name().to_owned());
    grasp.stable_displacement_m = finite(outcome.displacement_m);
    grasp.stable_turn_rad = finite(outcome.turn_rad);
}

fn summary(file: &GraspFile, outcomes: &[(u64, Outcome)], seconds: f64) -> String {
    let total = outcomes.len();
    let stable = outcomes
        .iter()
        .filter(|(_, outcome)| outcome.is_stable())
        .count();
    let mut text = format!(
        "stable     {stable} of {total} ({:.1} %)\n",
        100.0 * stable as f64 / total as f64
    );
    let reasons = outcomes.iter().map(|(_, outcome)| outcome.reason.name());
    for (reason, count) in tally(reasons) {
        let _ = writeln!(text, "  {reason}: {count}");
    }
    for fit in file.metadata.stability["objects"]
        .as_array()
        .into_iter()
        .flatten()
    {
        let number = |key: &str| fit[key].as_f64().unwrap_or(f64::NAN);
        let _ = writeln!(
            text,
            "{}: {} convex pieces, volume {:+.1} %, surface between {:.2} mm filled and {:.2} mm cut off",
            fit["object"].as_str().unwrap_or_default(),
            fit["pieces"],
            100.0 * number("volume_error"),
            1e3 * number("filled_m"),
            1e3 * number("cut_m"),
        );
    }
    let _ = writeln!(
        text,
        "{:.1} grasps a second",
        total as f64 / seconds.max(1e-9)
    );
    text
}
