//! `landscape stability`: simulates the grasps of a file in a physics engine.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

use super::args::{Again, Common, HandAndObject};
use super::input;
use super::output::check_file;
use super::run::{Watch, open_journal, stoppable};
use crate::cli::printing::{complain, explain, print, print_json};
use crate::evaluation::stability::{Drop, Fit, Protocol, SixDirections};
use crate::printable::counted;
use crate::study::{
    ConfigurationFile, ObjectFit, Run, Simulation, simulate_all, simulation_fingerprint, tally,
};

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
    /// Write the protocol as a file for --config to standard output, and do nothing else.
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
  landscape stability grasps.parquet --print-protocol > mine.toml
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
    if command.print_protocol {
        let file = ConfigurationFile::Stability(protocol);
        if common.json {
            return print_json(&file.values());
        }
        print(&file.text());
        return Ok(());
    }
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
    explain(|| {
        let origin = match &command.settings {
            Some(path) => format!("from {}", path.display()),
            None => "with its standard numbers (--print-protocol lists them)".to_owned(),
        };
        format!("each grasp is simulated by itself with this protocol, {origin}: {protocol:?}")
    });
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
    if common.json {
        print_json(&value(&found, &protocol, &output))?;
    }
    if !common.quiet {
        print(&summary(&found));
        complain(&format!("wrote {}", output.display()));
    }
    Ok(())
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

/// The JSON document.
fn value(found: &Simulation, protocol: &Protocol, output: &Path) -> Value {
    let reasons = found.outcomes.iter();
    let reasons: Map<String, Value> = tally(reasons.map(|(_, outcome)| outcome.reason.name()))
        .into_iter()
        .map(|(reason, count)| (reason, count.into()))
        .collect();
    json!({
        "grasps": found.outcomes.len(),
        "stable": found.stable(),
        "reasons": reasons,
        "objects": found.fits,
        "protocol": protocol,
        "seconds": found.seconds,
        "preparation_seconds": found.preparation_seconds,
        "wrote": [output],
    })
}

fn summary(found: &Simulation) -> String {
    let outcomes = &found.outcomes;
    let total = outcomes.len();
    let stable = found.stable();
    let mut text = format!(
        "stable     {stable} of {total} ({:.1} %)\n",
        100.0 * stable as f64 / total as f64
    );
    let reasons = outcomes.iter().map(|(_, outcome)| outcome.reason.name());
    for (reason, count) in tally(reasons) {
        let _ = writeln!(text, "  {reason}: {count}");
    }
    for ObjectFit { object, fit, .. } in &found.fits {
        let _ = writeln!(text, "{object}: {}", fitted(fit));
    }
    let _ = writeln!(text, "{}", taken(found));
    text
}

/// How an object is simulated, and how far that is from its mesh.
fn fitted(fit: &Fit) -> String {
    // Rounded first, so that no 0.0 mm are filled and no 0.0 % are too much.
    let percent = (1e3 * fit.volume_error.abs()).round() / 10.0;
    let millimetres = |length_m: f64| (1e4 * length_m).round() / 10.0;
    let mut parts = vec![format!(
        "simulated as {}",
        counted(fit.pieces, "convex piece")
    )];
    if percent > 0.0 {
        let amount = if fit.volume_error > 0.0 {
            "too much"
        } else {
            "too little"
        };
        let decimals = usize::from(percent < 10.0);
        parts.push(format!("{percent:.decimals$} % {amount} volume"));
    }
    parts.push(match millimetres(fit.filled_m) {
        filled if filled > 0.0 => format!("hollows filled by up to {filled:.1} mm"),
        _ => "no hollows filled".to_owned(),
    });
    parts.push(match millimetres(fit.cut_m) {
        cut if cut > 0.0 => format!("up to {cut:.1} mm cut off"),
        _ => "nothing cut off".to_owned(),
    });
    let first = parts.remove(0);
    format!("{first}: {}", parts.join(", "))
}

/// The time that a simulation took, and the time before it if that was not short.
fn taken(found: &Simulation) -> String {
    let seconds = |seconds: f64| {
        if seconds < 10.0 {
            format!("{seconds:.1} s")
        } else {
            format!("{seconds:.0} s")
        }
    };
    let grasps = counted(found.outcomes.len(), "grasp");
    let mut text = format!("{grasps} in {}", seconds(found.seconds));
    if found.preparation_seconds >= 1.0 {
        let _ = write!(
            text,
            ", after {} of preparation",
            seconds(found.preparation_seconds)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_told_in_words() {
        let fit = |volume_error: f64, filled_m: f64, cut_m: f64| Fit {
            pieces: 43,
            volume_error,
            filled_m,
            cut_m,
        };
        assert_eq!(
            fitted(&fit(0.1183, 3.09e-3, 1e-6)),
            "simulated as 43 convex pieces: 12 % too much volume, hollows filled by up to 3.1 mm, nothing cut off"
        );
        assert_eq!(
            fitted(&fit(-0.0002, 0.0, 2.26e-3)),
            "simulated as 43 convex pieces: no hollows filled, up to 2.3 mm cut off"
        );
        let one = Fit {
            pieces: 1,
            ..fit(-0.01, 0.0, -1e-9)
        };
        assert_eq!(
            fitted(&one),
            "simulated as 1 convex piece: 1.0 % too little volume, no hollows filled, nothing cut off"
        );
    }

    #[test]
    fn preparation_is_told_apart() {
        let mut found = Simulation {
            outcomes: Vec::new(),
            fits: Vec::new(),
            seconds: 5.42,
            preparation_seconds: 57.3,
        };
        assert_eq!(
            taken(&found),
            "0 grasps in 5.4 s, after 57 s of preparation"
        );
        found.preparation_seconds = 0.2;
        assert_eq!(taken(&found), "0 grasps in 5.4 s");
    }
}
