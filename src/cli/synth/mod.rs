//! `landscape synth`: grasps of a hand on an object.

mod answer;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use clap::{Args, ValueHint};
use serde_json::{Value, json};

use self::answer::{
    REMEDY, added_text, added_value, answer, diversity, hold, none_granted, none_passed,
    nothing_new, refused, value,
};
use super::args::{Again, Common, Lacking, within};
use super::hands::expense;
use super::input;
use super::output::check_file;
use super::run::{Watch, resumable};
use crate::cli::printing::{complain, explain_settings, print, print_json};
use crate::cli::text::text;
use crate::evaluation::stability::{Drop, Protocol};
use crate::grasp::GraspEnergy;
use crate::limits::{CHAINS, PERTURBATION, SHARE, STEPS};
use crate::store::{GraspFile, LandscapeFiles, Metadata, content_hash};
use crate::study::{
    Archive, Asked, Experiment, Keep, Origin, PopulationSettings, doubted_size, simulate_sample,
    synthesize_beyond, synthesize_population,
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
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath, required_unless_present_any = ["from", "beyond"])]
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
    /// Keep only grasps that a file of grasps or a landscape lacks, and look for them where the unseen is expected: beside
    /// rare minima and the tops of paths, with digits that touch nowhere in it, at places far from all contacts. With --from the given grasps are
    /// refined first, and those that pass are kept. Hand and object are those of --beyond, unless others are named.
    #[arg(long, value_name = "FILE|LANDSCAPE", value_hint = ValueHint::AnyPath, conflicts_with = "spread")]
    beyond: Option<PathBuf>,
    /// With --beyond: least distance of a new grasp from all others, in millimetres (root mean square movement of the hand's
    /// surface, modulo the symmetry of the object). The default is 5.
    #[arg(
        long,
        value_name = "MM",
        requires = "beyond",
        allow_negative_numbers = true
    )]
    apart: Option<f64>,
    /// With --beyond: end the search when one more end is new with less than this chance (Good–Turing). The default is 0.1.
    #[arg(
        long,
        value_name = "P",
        requires = "beyond",
        allow_negative_numbers = true
    )]
    chance: Option<f64>,
    /// Ask for grasp types of the GRASP taxonomy, by number (1 to 33) or name: `9,14` or `Tip Pinch`. Chains serve all wishes in
    /// turn, and an end counts only if it is what was asked for. The hand must be built like a human one.
    #[arg(long, value_name = "TYPES", value_delimiter = ',')]
    types: Vec<String>,
    /// Ask for cells of the taxonomy, such as `precision/pad/2/abducted`.
    #[arg(long, value_name = "CELLS", value_delimiter = ',')]
    cells: Vec<String>,
    /// Ask for sets of digits (and the palm) that touch, and no others: `thumb+index,thumb+index+middle`.
    #[arg(long, value_name = "SETS", value_delimiter = ',')]
    grips: Vec<String>,
    /// Ask for regions that touch, with no other digits than theirs: `thumb.distal.pad,index.distal.pad`. Give it again for
    /// another set.
    #[arg(long, value_name = "REGIONS")]
    regions: Vec<String>,
    /// Number of chains, at most a million; each gives one grasp if its end passes the filter. The default is 64, or one
    /// for each given grasp; with --beyond at most 256 after the given grasps.
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

/// Most chains of a search beyond a set, without `-n`.
const BEYOND_CHAINS: u64 = 256;

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape synth --object bottle_round -n 64              64 chains on a bottle that comes with the program
  landscape synth --object mug.obj -n 256 -o mug.parquet   your own mesh (metres, closed)
  landscape synth --object mug --config mine.toml          other settings (landscape config synth > mine.toml)
  landscape synth --from mug.parquet -o better.parquet     refine given grasps
  landscape synth --from mug.parquet --perturb 10 -n 500 -o more.parquet
                                                           find more grasps near given ones
  landscape synth --object ball --types 9,14,'Tip Pinch'   only these types of grasp
  landscape synth --object mug --grips thumb+index+middle  only grasps by these digits
  landscape synth --object mug --regions thumb.distal.pad,index.distal.radial
                                                           only grasps by these regions of the hand
  landscape synth --beyond mug.landscape -o new.parquet    only grasps that this landscape (or file) lacks
  landscape synth --from set.parquet --beyond set.parquet -o repaired.parquet
                                                           refine a set, and add what it lacks

An interrupted run continues where it stopped when the same command is given again; --resume demands this, and --fresh
starts over. The result is the same to the last byte.";

pub(super) fn run(command: &Synth, common: &Common) -> anyhow::Result<()> {
    let mut settings = settings(command, common)?;
    let (origin, notes) = origin(command, common)?;
    if command.chains.is_none() && command.beyond.is_some() {
        settings.chains = BEYOND_CHAINS;
    } else if !origin.given.is_empty() && command.chains.is_none() {
        settings.chains = origin.given.len() as u64;
    }
    let energy = origin.energy(&settings)?;
    settings.wishes(&energy)?;
    let archive = archive(command, &origin, &energy)?;
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
    let mut fingerprint = origin.fingerprint(&energy, &settings)?;
    if let Some(archive) = &archive {
        let archive = archive.fingerprint();
        fingerprint = content_hash(&[fingerprint.as_bytes(), archive.as_bytes()]);
    }
    let (started, quiet) = (Instant::now(), common.quiet);
    let (output, again) = (&command.output, &command.again);
    let ((found, added), journal) = resumable(output, &fingerprint, again, quiet, |run| {
        Ok(match &archive {
            None => (
                synthesize_population(&energy, &origin, &settings, run)?,
                None,
            ),
            Some(archive) => {
                let (found, added) = synthesize_beyond(&energy, &origin, &settings, archive, run)?;
                (found, Some(added))
            }
        })
    })?;
    let seconds = started.elapsed().as_secs_f64();
    let mut told = value(&found, seconds);
    told["beyond"] = added.as_ref().map_or(Value::Null, added_value);
    let refused = refused(&found);
    if let Some(added) = added.as_ref().filter(|_| found.grasps.is_empty()) {
        anyhow::bail!("{}", nothing_new(added));
    }
    if found.grasps.is_empty() && !found.wishes.is_empty() {
        anyhow::bail!("{}", none_granted(&found));
    }
    anyhow::ensure!(
        !found.grasps.is_empty(),
        "{} the filter{}: {}",
        none_passed(found.chains.len()),
        refused.map_or(String::new(), |refused| format!(" ({refused})")),
        doubt.map_or_else(|| REMEDY.to_owned(), |doubt| doubt.doubt.to_string())
    );
    let mut answer = answer(&energy, &found, &settings, &command.output);
    answer += &added.as_ref().map_or_else(String::new, added_text);
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

/// Warns of what was noted of the object, and of a hand that makes chains slow.
fn warn_of_inputs(command: &Synth, energy: &GraspEnergy, mut notes: Vec<String>) {
    // A file of grasps was made with what is noted of its object.
    if command.from.is_none() {
        notes.extend(energy.object().notes.iter().cloned());
    }
    input::warn(&notes);
    input::warn(&expense(energy.hand(), energy.layer_balls()));
}

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
    if let Some(path) = command.beyond.as_ref().filter(|_| command.object.is_none()) {
        let file = grasps_of(command, path)?;
        let populations = file.landscapes();
        let [population] = populations.as_slice() else {
            anyhow::bail!(
                "--beyond {}: this file contains grasps of {} pairs of hand and object: name the object with --object",
                path.display(),
                populations.len()
            );
        };
        let mut origin = Origin::of_population(population);
        origin.given.clear();
        return Ok((origin, Vec::new()));
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

/// The grasps of a file or of a landscape.
fn grasps_of(command: &Synth, path: &Path) -> anyhow::Result<GraspFile> {
    if path.is_dir() {
        let file = LandscapeFiles::grasps(path)?;
        return file.with_context(|| {
            format!(
                "--beyond {}: this landscape is not one of grasps; name another",
                path.display()
            )
        });
    }
    let lacking = Lacking {
        hand: command.hand.clone(),
        object: command.object.clone(),
    };
    let (file, _) = input::read_lacking(path, &lacking)?;
    Ok(file)
}

/// What is there already, if a flag names it.
fn archive(
    command: &Synth,
    origin: &Origin,
    energy: &GraspEnergy,
) -> anyhow::Result<Option<Archive>> {
    let Some(path) = &command.beyond else {
        return Ok(None);
    };
    let file = grasps_of(command, path)?;
    let populations = file.landscapes();
    let population = populations
        .iter()
        .find(|population| origin.is_of(population));
    let population = population.with_context(|| {
        format!(
            "--beyond {}: it has no grasps of the {} hand on {} at scale {}; name those that it has",
            path.display(),
            origin.hand.name,
            origin.object.name,
            origin.scale
        )
    })?;
    let archive = if path.is_dir() {
        Archive::of_landscape(path)?
    } else {
        Archive::of_population(energy, population)
    };
    Ok(Some(Archive {
        distance_m: command
            .apart
            .map_or(archive.distance_m, |apart_mm| 1e-3 * apart_mm),
        chance: command.chance.unwrap_or(archive.chance),
        ..archive
    }))
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
    if let Some(apart) = command.apart {
        within("--apart", PERTURBATION, apart)?;
    }
    if let Some(chance) = command.chance {
        within("--chance", SHARE, chance)?;
    }
    let inputs = [&command.from, &command.config, &command.beyond];
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
        asked: asked(command)?,
    })
}

/// What the flags ask for.
fn asked(command: &Synth) -> anyhow::Result<Vec<Asked>> {
    let set = |text: &str, separator: char| {
        let names = text.split(separator).map(str::trim);
        names
            .filter(|name| !name.is_empty())
            .map(str::to_owned)
            .collect()
    };
    let mut asked = Vec::new();
    for name in &command.types {
        asked.push(Asked::type_named(name).map_err(|error| anyhow::anyhow!("--types {error}"))?);
    }
    for name in &command.cells {
        asked.push(Asked::cell_named(name).map_err(|error| anyhow::anyhow!("--cells {error}"))?);
    }
    asked.extend(
        command
            .grips
            .iter()
            .map(|names| Asked::Digits(set(names, '+'))),
    );
    asked.extend(
        command
            .regions
            .iter()
            .map(|names| Asked::Regions(set(names, ','))),
    );
    Ok(asked)
}
