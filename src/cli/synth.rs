//! `landscape synth`: grasps of a hand on an object.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueHint};
use rayon::prelude::*;

use super::args::{Again, Common};
use super::experiment::Experiment;
use super::hands::expense;
use super::input::{self, within};
use super::origin::Origin;
use super::output::check_file;
use super::run::open_journal;
use super::{complain, print, progress};
use crate::evaluation::Diversity;
use crate::grasp::press::firmness;
use crate::grasp::spread::spread;
use crate::grasp::synthesis::{Given, Refinement, Synthesized, synthesize, synthesize_from};
use crate::grasp::{GraspEnergy, Judgement, judge};
use crate::limits::{CHAINS, PERTURBATION, STEPS};
use crate::optimize::QuenchSettings;
use crate::store::{GraspFile, GraspRow, Metadata, SCHEMA_VERSION, content_hash};

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
    /// Steps of each chain.
    #[arg(long, value_name = "N")]
    steps: Option<u32>,
    /// Number of contacts of a grasp.
    #[arg(long, value_name = "N")]
    contacts: Option<usize>,
    /// Seed of all random draws.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Energy and sampler: `default` (smooth, physical), `paper` (as printed) or `released` (as in the authors' code).
    #[arg(
        long,
        default_value = "default",
        value_name = "NAME",
        conflicts_with = "config"
    )]
    preset: String,
    /// Experiment file (TOML) with the sections [energy] and [synthesis]; see data/experiments.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Filter of the grasps to keep: the strict filter, the strict filter with firm pressing, the published filter (Eq.
    /// 11), or none.
    #[arg(long, value_enum, default_value_t = Keep::Strict)]
    keep: Keep,
    /// Keep at most N grasps, chosen so that they are spread evenly over the object.
    #[arg(long, value_name = "N")]
    spread: Option<usize>,
    /// The file to write.
    #[arg(long, short, default_value = "grasps.parquet", value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    again: Again,
}

/// Filter of the grasps to keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Keep {
    /// Grasps that a person could hold: contacts within 2 mm, nothing deeper than 2 mm, exact force closure, …
    Strict,
    /// Grasps whose hand, closed until it presses, passes the strict filter and holds firmly, so that it keeps the object
    /// in simulation. They are a millimetre or two away from minima of the energy.
    Firm,
    /// Grasps that pass Eq. 11 of the paper.
    Published,
    /// The ends of all chains.
    All,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape synth --object bottle_round -n 64              64 chains on a bottle that comes with the program
  landscape synth --object mug.obj -n 256 -o mug.parquet   your own mesh (metres, closed)
  landscape synth --object ball --preset paper --keep all  the published energy and sampler
  landscape synth --from mug.parquet -o better.parquet     refine given grasps
  landscape synth --from mug.parquet --perturb 10 -n 500 -o more.parquet
                                                           look around given grasps

An interrupted run continues where it stopped when the same command is given again; with --resume it must, with --fresh
it begins anew. The result is the same to the last byte.";

/// Default number of chains.
const DEFAULT_CHAINS: u64 = 64;

const ADVICE: &str = "\
note: strict grasps close and balance, but are not squeezed: many fall in the drop test. `landscape stability` tells which \
hold; `--keep firm` makes grasps that press.
";

pub(super) fn run(command: &Synth, common: &Common) -> anyhow::Result<()> {
    let experiment = experiment(command, common)?;
    let origin = Origin::read(command, common.quiet)?;
    let count = match command.chains {
        Some(count) => count,
        None if origin.given.is_empty() => DEFAULT_CHAINS,
        None => origin.given.len() as u64,
    };
    let hand = origin.hand.build()?;
    if let Some(note) = expense(&hand).filter(|_| !common.quiet) {
        input::warn(&[note]);
    }
    let energy = GraspEnergy::new(hand, origin.object.clone(), experiment.energy)?;

    let metadata = metadata(command, common, &experiment, &energy, &origin)?;
    let journal_path = journal_path(&command.output);
    // Chains do not depend on how many there are or which are kept, so the command may differ next time. The rest of the
    // metadata identifies the input files.
    let of_a_chain = Metadata {
        command: String::new(),
        inputs: Vec::new(),
        ..metadata.clone()
    };
    let given = format!("{:?} {:?}", command.perturb, origin.given);
    let of_a_chain = serde_json::to_string(&of_a_chain)?;
    let fingerprint = content_hash(&[of_a_chain.as_bytes(), given.as_bytes()]);
    let journal = open_journal(&journal_path, &fingerprint, &command.again, common.quiet)?;

    let started = Instant::now();
    let bar = progress::bar("chains", count, common.quiet);
    let chains: Vec<(Synthesized, Judgement)> = (0..count)
        .into_par_iter()
        .map(|chain| {
            let key = format!("chain {chain}");
            let done = journal
                .get(&key)
                .and_then(|bytes| serde_json::from_slice(&bytes).ok());
            let end: Synthesized = if let Some(end) = done {
                end
            } else {
                let end = work(command, &experiment, &energy, &origin, chain);
                journal.put(&key, &serde_json::to_vec(&end)?)?;
                end
            };
            bar.inc(1);
            let judgement = judge(&energy, &end.refined);
            Ok((end, judgement))
        })
        .collect::<anyhow::Result<_>>()?;
    bar.finish_and_clear();

    let mut passed: Vec<&(Synthesized, Judgement)> = chains
        .iter()
        .filter(|(end, judgement)| match command.keep {
            Keep::Strict => judgement.passes_strict(),
            Keep::Firm => is_firm(&energy, end, judgement),
            Keep::Published => judgement.passes_published(),
            Keep::All => true,
        })
        .collect();
    if let Some(limit) = command.spread {
        let (places, costs): (Vec<_>, Vec<_>) = passed
            .iter()
            .map(|(end, _)| {
                (
                    energy.contact_centre(&end.refined.pose, &end.refined.contacts),
                    end.energy,
                )
            })
            .unzip();
        let chosen = spread(&places, &costs, &energy.object().symmetry, limit);
        passed = chosen.into_iter().map(|i| passed[i]).collect();
    }
    let kept: Vec<GraspRow> = passed
        .iter()
        .map(|(end, judgement)| row(&energy, &metadata, command, &origin, end, judgement))
        .collect();
    if !common.quiet {
        let mut text = summary(
            &energy,
            &chains,
            kept.len(),
            started.elapsed().as_secs_f64(),
        );
        if command.keep == Keep::Strict {
            text += ADVICE;
        }
        print(&text);
    }
    anyhow::ensure!(
        !kept.is_empty(),
        "none of the {count} chains passed the filter: run more (-n) or longer ones (--steps with --fresh), or keep \
         others (--keep)"
    );
    let file = GraspFile {
        metadata,
        grasps: kept,
    };
    file.write(&command.output)?;
    journal.remove()?;
    if !common.quiet {
        complain(&format!("wrote {}", command.output.display()));
    }
    Ok(())
}

fn is_firm(energy: &GraspEnergy, end: &Synthesized, judgement: &Judgement) -> bool {
    judgement.passes_strict() && firmness(energy, &end.refined.pose).is_firm()
}

/// The settings selected by the flags; rejects invalid ones before any work.
fn experiment(command: &Synth, common: &Common) -> anyhow::Result<Experiment> {
    let mut experiment = match &command.config {
        Some(path) => Experiment::read(path)?,
        None => Experiment::preset(&command.preset)?,
    };
    if let Some(steps) = command.steps {
        within("--steps", STEPS, steps.into())?;
        // A shorter chain makes fewer attempts of the same length.
        let synthesis = &mut experiment.synthesis;
        let of_an_attempt = (synthesis.steps / synthesis.attempts.max(1)).max(1);
        synthesis.attempts = synthesis.attempts.min(steps / of_an_attempt).max(1);
        synthesis.steps = steps;
    }
    if command.keep == Keep::Firm {
        experiment.synthesis.refinement = Refinement::Pressed;
    }
    if let Some(contacts) = command.contacts {
        experiment.energy.contacts = contacts;
        experiment.energy.validate()?;
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
    check_file(&command.output, &inputs, common)?;
    Ok(experiment)
}

fn journal_path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".partial");
    PathBuf::from(name)
}

fn metadata(
    command: &Synth,
    common: &Common,
    experiment: &Experiment,
    energy: &GraspEnergy,
    origin: &Origin,
) -> anyhow::Result<Metadata> {
    Ok(Metadata {
        schema_version: SCHEMA_VERSION,
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        command: common.provenance.command.clone(),
        inputs: common.provenance.sources()?,
        seed: command.seed,
        hands: vec![origin.hand.clone()],
        objects: vec![origin.object_metadata.clone()],
        energy: serde_json::to_value(experiment.energy)?,
        settings: serde_json::to_value(experiment.synthesis)?,
        terms: energy.term_names(),
        ..Metadata::default()
    })
}

fn work(
    command: &Synth,
    experiment: &Experiment,
    energy: &GraspEnergy,
    origin: &Origin,
    chain: u64,
) -> Synthesized {
    let settings = &experiment.synthesis;
    let refine = QuenchSettings::default();
    let Some(given) = origin.given(chain) else {
        return synthesize(energy, settings, &refine, command.seed, chain);
    };
    let given = Given {
        x: &given.grasp.pose,
        displacement_m: 1e-3 * command.perturb.unwrap_or(0.0),
    };
    synthesize_from(energy, settings, &refine, command.seed, chain, &given)
}

fn row(
    energy: &GraspEnergy,
    metadata: &Metadata,
    command: &Synth,
    origin: &Origin,
    end: &Synthesized,
    judgement: &Judgement,
) -> GraspRow {
    let program = concat!("landscape ", env!("CARGO_PKG_VERSION"), " synth");
    let mut row = GraspRow {
        id: end.chain,
        object: metadata.objects[0].name.clone(),
        scale: origin.scale,
        hand: metadata.hands[0].name.clone(),
        grasp: end.refined.clone(),
        source: match origin.given(end.chain) {
            None => program.to_owned(),
            Some(given) => format!("{program} from {}", given.id),
        },
        chain_seed: command.seed,
        chain_step: end.steps,
        ..GraspRow::default()
    };
    row.set_measures(energy, &end.refined, judgement);
    row.energy = end.energy;
    row
}

fn summary(
    energy: &GraspEnergy,
    chains: &[(Synthesized, Judgement)],
    kept: usize,
    seconds: f64,
) -> String {
    let total = chains.len();
    let share = |count: usize| {
        format!(
            "{count} of {total} ({:.0} %)",
            100.0 * count as f64 / total as f64
        )
    };
    let count = |test: fn(&Judgement) -> bool| chains.iter().filter(|(_, j)| test(j)).count();
    let evaluations: u64 = chains.iter().map(|(end, _)| end.evaluations).sum();
    let mut text = format!(
        "strict filter        {}\nEq. 11 as printed    {}\nEq. 11 as released   {}\nkept                 {kept}\n\
         evaluations          {evaluations} in {seconds:.0} s ({:.1} µs each)\n",
        share(count(Judgement::passes_strict)),
        share(count(Judgement::passes_published)),
        share(count(Judgement::passes_released)),
        1e6 * seconds / evaluations as f64,
    );
    let mut reasons: Vec<(&str, usize)> = Vec::new();
    for reason in chains.iter().filter_map(|(_, j)| j.strict_objection()) {
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, count)) => *count += 1,
            None => reasons.push((reason, 1)),
        }
    }
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    for (reason, count) in reasons {
        let _ = writeln!(text, "  refused for {reason}: {count}");
    }
    let strict = chains
        .iter()
        .filter(|(_, judgement)| judgement.passes_strict())
        .map(|(end, _)| &end.refined);
    if let Some(diversity) = Diversity::of(energy.hand(), &energy.object().centroid, strict) {
        let [first, second, ..] = diversity.explained_variance;
        let rate = diversity.region_sets_per_hundred;
        let rate = rate.map_or(String::new(), |rate| {
            format!(" ({rate:.0} per hundred grasps)")
        });
        let _ = writeln!(
            text,
            "of the strict ones   {} sets of hand regions{rate}, entropy of joints {:.2} and of the pose {:.2} nats,\n\
             \x20                    {:.0} % of the variance in one principal component, {:.0} % in two",
            diversity.region_sets,
            diversity.joint_entropy,
            diversity.pose_entropy,
            100.0 * first,
            100.0 * second,
        );
    }
    text
}
