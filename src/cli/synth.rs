//! `landscape synth`: grasps of a hand on an object.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use clap::{Args, ValueHint};
use serde_json::{Value, json};

use super::args::{Again, Common, within};
use super::hands::expense;
use super::input;
use super::output::check_file;
use super::run::{Watch, open_journal, stoppable};
use crate::cli::printing::{complain, explain_settings, print, print_json};
use crate::cli::text::text;
use crate::evaluation::Diversity;
use crate::evaluation::stability::{Drop, Protocol};
use crate::grasp::{GraspEnergy, Judgement};
use crate::limits::{CHAINS, PERTURBATION, STEPS};
use crate::printable::counted;
use crate::store::{GraspFile, Metadata};
use crate::study::{
    Experiment, Keep, Origin, PopulationSettings, Run, Synthesis, doubted_size, simulate_sample,
    synthesize_population, tally,
};

/// Synthesize grasps.
#[derive(Debug, Args)]
pub(super) struct Synth {
    /// The hand: the name of a built-in hand (`human` by default), or a URDF, MJCF or MANO (.npz) file.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) hand: Option<String>,
    /// The folder with all files that the hand's description refers to (meshes, included files); by default its own folder.
    /// Files elsewhere are refused.
    #[arg(long, value_name = "FOLDER", conflicts_with = "from")]
    pub(super) hand_folder: Option<PathBuf>,
    /// Use the hand's mirror image instead: a left hand from a right one.
    #[arg(long, conflicts_with = "from")]
    pub(super) mirror: bool,
    /// The object: the name of a built-in object, a mesh (OBJ, STL, PLY, glTF; in metres unless --scale is given), or a
    /// TOML file of shapes (see `landscape help objects inspect`).
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath, required_unless_present = "from")]
    pub(super) object: Option<String>,
    /// Name of the object in files and pictures, instead of the name of its file.
    #[arg(
        long,
        value_name = "NAME",
        requires = "object",
        conflicts_with = "from"
    )]
    pub(super) name: Option<String>,
    /// Metres per unit of the object's mesh (from a millionth to a million): 0.001 for millimetres, 0.1 for a mesh of unit size that is to be 10 cm in radius.
    #[arg(
        long,
        value_name = "FACTOR",
        conflicts_with = "from",
        allow_negative_numbers = true
    )]
    pub(super) scale: Option<f64>,
    /// Make open surfaces of the object's mesh, such as a sheet or a cup without walls, walls of this many millimetres (0.1 to 100).
    #[arg(
        long,
        value_name = "MM",
        requires = "object",
        conflicts_with = "from",
        allow_negative_numbers = true
    )]
    pub(super) thickness: Option<f64>,
    /// Start from the grasps of a file instead of random poses: chain i starts from row i, and after the last row from the
    /// first again. Hand and object are those of the file, unless others are named.
    #[arg(long, value_name = "FILE")]
    pub(super) from: Option<PathBuf>,
    /// Move each given grasp by this many millimetres in a random direction first (measured as the root mean square
    /// movement of the hand's surface).
    #[arg(
        long,
        value_name = "MM",
        requires = "from",
        allow_negative_numbers = true
    )]
    perturb: Option<f64>,
    /// Number of chains, at most a million; each gives one grasp if its end passes the filter. The default is 64, or one
    /// for each given grasp.
    #[arg(short = 'n', long, value_name = "N")]
    chains: Option<u64>,
    /// Greatest number of descents of each chain.
    #[arg(long, value_name = "N")]
    steps: Option<u32>,
    /// Seed of all random draws.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Experiment file (TOML) with the sections [energy] and [synthesis]; see data/experiments.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Filter of the grasps to keep: the strict filter, the published filter (Eq. 11), or none.
    #[arg(long, value_enum, default_value_t = KeepName::Strict)]
    keep: KeepName,
    /// Keep at most N grasps, chosen so that they are spread evenly over the object.
    #[arg(long, value_name = "N")]
    spread: Option<usize>,
    /// Drop N of the kept grasps, evenly chosen, in simulation at the end, and print how many hold (0: none). `landscape
    /// stability` drops all and stores the outcomes.
    #[arg(long, default_value_t = 32, value_name = "N")]
    drop: usize,
    /// The file to write.
    #[arg(long, short, default_value = "grasps.parquet", value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    again: Again,
}

/// Filter of the grasps to keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum KeepName {
    /// Grasps that a person could hold: contacts within 2 mm, nothing deeper than 1 mm, exact force closure, …
    Strict,
    /// Grasps that pass Eq. 11 of the paper.
    Published,
    /// The ends of all chains.
    All,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape synth --object bottle_round -n 64              64 chains on a bottle that comes with the program
  landscape synth --object mug.obj -n 256 -o mug.parquet   your own mesh (metres, closed)
  landscape synth --object mug --config mine.toml          other settings (landscape config synth > mine.toml)
  landscape synth --from mug.parquet -o better.parquet     refine given grasps
  landscape synth --from mug.parquet --perturb 10 -n 500 -o more.parquet
                                                           find more grasps near given ones

An interrupted run continues where it stopped when the same command is given again; --resume demands this, and --fresh
starts over. The result is the same to the last byte.";

pub(super) fn run(command: &Synth, common: &Common) -> anyhow::Result<()> {
    let mut settings = settings(command, common)?;
    let (origin, notes) = origin(command, common)?;
    if !origin.given.is_empty() && command.chains.is_none() {
        settings.chains = origin.given.len() as u64;
    }
    let energy = origin.energy(&settings)?;
    let doubt = doubted_size(energy.hand(), energy.object(), origin.scale);
    if let Some(doubt) = &doubt {
        anyhow::ensure!(!doubt.sure || settings.keep == Keep::All, "{}", doubt.doubt);
    }
    if !common.quiet {
        let of_size = doubt.iter().map(|doubt| doubt.doubt.to_string());
        input::warn(&of_size.collect::<Vec<_>>());
        warn_of_inputs(command, &energy, notes);
    }
    explain_settings("settings", &settings.experiment);
    let fingerprint = origin.fingerprint(&energy, &settings)?;
    let journal = open_journal(&command.output, &fingerprint, &command.again, common.quiet)?;
    let (started, watch) = (Instant::now(), Watch::new(common.quiet));
    let run = Run {
        journal: &stoppable(&journal),
        observer: &|news| watch.see(news),
        ..Run::default()
    };
    let found = synthesize_population(&energy, &origin, &settings, &run)?;
    watch.clear();
    let seconds = started.elapsed().as_secs_f64();
    let mut told = value(&found, seconds);
    let refused = refused(&found);
    anyhow::ensure!(
        !found.grasps.is_empty(),
        "{} the filter{}: {}",
        none_passed(found.chains.len()),
        refused.map_or(String::new(), |refused| format!(" ({refused})")),
        doubt.map_or_else(|| REMEDY.to_owned(), |doubt| doubt.doubt.to_string())
    );
    let mut answer = answer(&energy, &found, &settings, &command.output);
    if common.verbose {
        answer += &text(&told);
        answer += &text(&json!({ "diversity_of_strict_ones": diversity(&energy, &found) }));
    }
    let file = GraspFile {
        metadata: Metadata {
            command: common.provenance.command.clone(),
            inputs: common.provenance.sources()?,
            ..origin.metadata(&energy, &settings)?
        },
        grasps: found.grasps,
    };
    file.write(&command.output)?;
    journal.remove()?;
    if !common.quiet {
        print(&answer);
    }
    let dropped = if common.quiet && !common.json {
        None
    } else {
        drop_sample(&file, command.drop, common.quiet)
    };
    if common.json {
        told["dropped"] = dropped.map(|(dropped, _)| dropped).into();
        told["held"] = dropped.map(|(_, held)| held).into();
        told["wrote"] = json!([command.output]);
        print_json(&told)?;
    }
    Ok(())
}

/// What came out, in one sentence, and why the other chains gave nothing in another.
fn answer(
    energy: &GraspEnergy,
    found: &Synthesis,
    settings: &PopulationSettings,
    output: &Path,
) -> String {
    let (kept, chains) = (found.grasps.len(), found.chains.len());
    let mut text = format!(
        "wrote {} of the {} hand on {} from {} to {}",
        counted(kept, "grasp"),
        energy.hand().name,
        energy.object().name,
        counted(chains, "chain"),
        output.display()
    );
    // With another filter, what the strict one says is for the statistics.
    if settings.keep == Keep::Strict
        && let Some(refused) = refused(found)
    {
        let _ = write!(text, "; {refused}");
    }
    text.push('\n');
    text
}

/// How many ends of chains the strict filter refuses, and why: `refused: 3 (gives way under loads 2, hand in itself 1)`.
fn refused(found: &Synthesis) -> Option<String> {
    let reasons = reasons(found);
    let count: usize = reasons.iter().map(|(_, count)| count).sum();
    let told: Vec<String> = reasons
        .iter()
        .map(|(reason, count)| format!("{reason} {count}"))
        .collect();
    (count > 0).then(|| format!("refused: {count} ({})", told.join(", ")))
}

/// The outcome of the drop test of some of all grasps.
fn hold(held: usize, dropped: usize, all: usize) -> String {
    let held = match held {
        0 => format!("none of {dropped} holds"),
        1 => format!("1 of {dropped} holds"),
        held if held == dropped => format!("all {held} hold"),
        held => format!("{held} of {dropped} hold"),
    };
    let sample = if dropped < all {
        format!(" ({dropped} of {all} grasps were dropped)")
    } else {
        String::new()
    };
    format!("{held} when dropped in simulation{sample}\n")
}

/// Warns of what was noted of the object, and of a hand that makes chains slow.
fn warn_of_inputs(command: &Synth, energy: &GraspEnergy, mut notes: Vec<String>) {
    // A file of grasps was made with what is noted of its object.
    if command.from.is_none() {
        notes.extend(energy.object().notes.iter().cloned());
    }
    input::warn(&notes);
    input::warn(&expense(energy.hand(), energy.layer_balls()));
}

/// The beginning of the sentence that no chain passed the filter.
fn none_passed(chains: usize) -> String {
    match chains {
        1 => "the chain did not pass".to_owned(),
        chains => format!("none of the {chains} chains passed"),
    }
}

/// What to do if no chain passes the filter.
const REMEDY: &str = "run more (-n) or longer ones (--steps with --fresh), or keep others (--keep)";

/// Prints how many of at most `most` grasps hold in the drop test, and returns how many were dropped and how many of them
/// held. The file is written already, so nothing fails here.
fn drop_sample(file: &GraspFile, most: usize, quiet: bool) -> Option<(usize, usize)> {
    if most == 0 {
        return None;
    }
    let protocol = Protocol::Drop(Drop::default());
    let found = Watch::over(quiet, |run| simulate_sample(file, &protocol, most, run));
    match found {
        Ok(found) => {
            let (held, dropped) = (found.stable(), found.outcomes.len());
            print(&hold(held, dropped, file.grasps.len()));
            Some((dropped, held))
        }
        Err(error) => {
            complain(&format!("the grasps were not dropped: {error}"));
            None
        }
    }
}

/// Hand and object of the flags, or those of the given grasps; and what is to be said of them.
fn origin(command: &Synth, common: &Common) -> anyhow::Result<(Origin, Vec<String>)> {
    if let Some(path) = &command.from {
        let (hand, object) = (command.hand.as_deref(), command.object.as_deref());
        let (file, warnings) = input::read(path, hand, object)?;
        if !common.quiet {
            input::warn(&warnings);
        }
        let populations = file.landscapes();
        let [population] = populations.as_slice() else {
            anyhow::bail!(
                "--from {}: this file contains grasps of {} pairs of hand and object, but chains start from one pair only",
                path.display(),
                populations.len()
            );
        };
        let hand = population.hand();
        hand.with_context(|| path.display().to_string())?;
        return Ok((Origin::of_population(population), Vec::new()));
    }
    let object = command.object.as_deref();
    let object = object.context("--object: the object to be grasped must be named")?;
    let (mut object, notes) = input::object(object, command.scale, command.thickness)?;
    input::rename(&mut object, command.name.as_deref())?;
    let hand = command.hand.as_deref().unwrap_or("human");
    let hand = input::hand(hand, command.hand_folder.as_deref(), command.mirror)?;
    if !common.quiet {
        input::warn(&hand.warnings().collect::<Vec<_>>());
    }
    let origin = Origin {
        hand,
        object,
        scale: command.scale.unwrap_or(1.0),
        given: Vec::new(),
    };
    Ok((origin, notes))
}

/// The settings that the flags ask for; refuses what makes no sense before any work is spent on it.
fn settings(command: &Synth, common: &Common) -> anyhow::Result<PopulationSettings> {
    let mut experiment = match &command.config {
        Some(path) => Experiment::read(path)?,
        None => Experiment::default(),
    };
    if let Some(steps) = command.steps {
        within("--steps", STEPS, steps.into())?;
        experiment.synthesis.steps = steps;
    }
    anyhow::ensure!(
        command.spread != Some(0),
        "--spread 0: at least one grasp is to be kept"
    );
    if let Some(chains) = command.chains {
        within("-n", CHAINS, chains as f64)?;
    }
    if let Some(perturb) = command.perturb {
        within("--perturb", PERTURBATION, perturb)?;
    }
    let inputs = [&command.from, &command.config];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    let named = [&command.object, &command.hand]
        .into_iter()
        .flatten()
        .map(Path::new);
    let inputs: Vec<&Path> = inputs.into_iter().chain(named).collect();
    check_file(&command.output, &inputs, common.force)?;
    let usual = PopulationSettings::default();
    Ok(PopulationSettings {
        experiment,
        seed: command.seed,
        chains: command.chains.unwrap_or(usual.chains),
        displacement_m: 1e-3 * command.perturb.unwrap_or(0.0),
        keep: match command.keep {
            KeepName::Strict => Keep::Strict,
            KeepName::Published => Keep::Published,
            KeepName::All => Keep::All,
        },
        at_most: command.spread,
    })
}

/// The JSON document without what is known only after the file is written.
fn value(found: &Synthesis, seconds: f64) -> Value {
    let chains = &found.chains;
    let count = |test: fn(&Judgement) -> bool| chains.iter().filter(|(_, j)| test(j)).count();
    json!({
        "chains": chains.len(),
        "strict": count(Judgement::passes_strict),
        "published": count(Judgement::passes_published),
        "released": count(Judgement::passes_released),
        "refused": BTreeMap::from_iter(reasons(found)),
        "kept": found.grasps.len(),
        "evaluations": chains.iter().map(|(end, _)| end.evaluations).sum::<u64>(),
        "seconds": seconds,
    })
}

/// Why chains fail the strict filter, with their numbers, most frequent first.
fn reasons(found: &Synthesis) -> Vec<(String, usize)> {
    let chains = found.chains.iter();
    tally(chains.filter_map(|(_, judgement)| judgement.strict_objection()))
}

/// How diverse the grasps are that pass the strict filter. One or two grasps are always on a line.
fn diversity(energy: &GraspEnergy, found: &Synthesis) -> Option<Diversity> {
    let chains = found.chains.iter();
    let strict = chains.filter(|(_, judgement)| judgement.passes_strict());
    let strict: Vec<_> = strict.map(|(end, _)| &end.refined).collect();
    let few = strict.len() < 3;
    Diversity::of(energy.hand(), energy.object(), strict.into_iter()).filter(|_| !few)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_of_drops_are_sentences() {
        for (held, dropped, all, told) in [
            (21, 21, 21, "all 21 hold when dropped in simulation"),
            (1, 1, 1, "1 of 1 holds when dropped in simulation"),
            (0, 2, 2, "none of 2 holds when dropped in simulation"),
            (19, 21, 21, "19 of 21 hold when dropped in simulation"),
            (
                32,
                32,
                60,
                "all 32 hold when dropped in simulation (32 of 60 grasps were dropped)",
            ),
        ] {
            assert_eq!(hold(held, dropped, all).trim_end(), told);
        }
    }
}
