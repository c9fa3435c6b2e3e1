//! `landscape synth`: grasps of a hand on an object.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;

use super::args::{Common, Keep, Synth};
use super::experiment::Experiment;
use super::hands::expense;
use super::input::{self, coordinates, within};
use super::origin::Origin;
use super::output::check_file;
use super::run::open_journal;
use super::{complain, models, print, progress};
use crate::evaluation::Diversity;
use crate::grasp::press::firmness;
use crate::grasp::spread::spread;
use crate::grasp::synthesis::{Given, Refinement, Synthesized, synthesize, synthesize_from};
use crate::grasp::{GraspEnergy, Judgement, judge};
use crate::limits::{CHAINS, PERTURBATION, STEPS};
use crate::optimize::QuenchSettings;
use crate::store::{Grasp, GraspFile, Metadata, SCHEMA_VERSION, content_hash};

/// Chains unless told otherwise.
const DEFAULT_CHAINS: u64 = 64;

/// What is said of strict grasps.
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
    let hand = models::hand(&origin.hand)?;
    if let Some(note) = expense(&hand).filter(|_| !common.quiet) {
        input::warn(&[note]);
    }
    let energy = GraspEnergy::new(hand, origin.object.clone(), experiment.energy)?;

    let metadata = metadata(command, common, &experiment, &energy, &origin)?;
    let journal_path = journal_path(&command.output);
    // A chain does not depend on how many there are or which are kept, so the command may ask for others next time. What it
    // depends on of the files that the command names is told by the rest.
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
            let judgement = judge(&energy, &end.refined, &end.contacts);
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
                    energy.contact_centre(&end.refined, &end.contacts),
                    end.energy,
                )
            })
            .unzip();
        let chosen = spread(&places, &costs, &energy.object().symmetry, limit);
        passed = chosen.into_iter().map(|i| passed[i]).collect();
    }
    let kept: Vec<Grasp> = passed
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
    judgement.passes_strict() && firmness(energy, &end.refined).is_firm()
}

/// The settings that the flags ask for; refuses what makes no sense before any work is spent on it.
fn experiment(command: &Synth, common: &Common) -> anyhow::Result<Experiment> {
    let mut experiment = match &command.config {
        Some(path) => Experiment::read(path)?,
        None => Experiment::preset(&command.preset)?,
    };
    if let Some(steps) = command.steps {
        within("--steps", STEPS, steps.into())?;
        // A shorter chain makes fewer attempts, not shorter ones.
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

/// One chain.
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
        x: &coordinates(given),
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
) -> Grasp {
    let x = &end.refined;
    let terms = energy.terms_of(x, &end.contacts);
    Grasp {
        id: end.chain,
        object: metadata.objects[0].name.clone(),
        scale: origin.scale,
        hand: metadata.hands[0].name.clone(),
        translation_m: [x[0], x[1], x[2]],
        rotation_wxyz: [x[3], x[4], x[5], x[6]],
        joints_rad: x[7..].to_vec(),
        contacts: end.contacts.clone(),
        energy: end.energy,
        terms: terms.into_iter().map(|(_, value)| value).collect(),
        net_wrench: judgement.net_wrench,
        distance_squared: judgement.distance_squared,
        penetration: judgement.penetration,
        friction: judgement.least_friction,
        epsilon: Some(judgement.epsilon),
        stable: None,
        stable_reason: None,
        stable_displacement_m: None,
        stable_turn_rad: None,
        label: None,
        label_auto: None,
        label_score: None,
        label_best: None,
        label_category: None,
        label_source: None,
        source: match origin.given(end.chain) {
            None => format!("landscape {} synth", env!("CARGO_PKG_VERSION")),
            Some(given) => format!(
                "landscape {} synth from {}",
                env!("CARGO_PKG_VERSION"),
                given.id
            ),
        },
        chain_seed: command.seed,
        chain_step: end.steps,
    }
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
        .map(|(end, _)| (&*end.refined, &*end.contacts));
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
