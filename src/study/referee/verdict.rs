//! Runs the tests on every set, and counts.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use rand::RngExt as _;

use super::measures::{Measure, Measured, MeasuredSet, Resampling, measure};
use crate::agreement::{Resampled, wilson};
use crate::evaluation::stability::{ClosingRule, NamedProtocol, Outcome, Protocol};
use crate::evaluation::taxonomy::Rule;
use crate::sample::{Task, stream};
use crate::store::{GraspFile, content_hash};
use crate::study::{Run, StudyError, simulate_all, simulation_fingerprint};
use crate::topography::Prefixed;

/// A set of grasps to be judged.
#[derive(Debug, Clone, Copy)]
pub struct JudgedSet<'a> {
    /// Name in tables and pictures.
    pub name: &'a str,
    /// Its grasps.
    pub file: &'a GraspFile,
}

/// What [`judge_sets`] runs.
#[derive(Debug, Clone)]
pub struct RefereeSettings {
    /// The tests, in the order of the table.
    pub tests: Vec<&'static NamedProtocol>,
    /// The measures, in the order of the table.
    pub measures: Vec<Measure>,
    /// How intervals are made.
    pub resampling: Resampling,
}

/// What one test says of one set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TestVerdict {
    /// Share of the grasps that hold, over all grasps.
    pub holds: f64,
    /// Its 95 % interval: over resampled objects and grasps, and at least Wilson's over grasps, because a resampling of grasps
    /// that all hold has no width.
    pub interval: [f64; 2],
    /// Number of objects of which at least one grasp holds.
    pub objects_held: usize,
    /// Number of grasps by reason.
    pub reasons: BTreeMap<&'static str, usize>,
    /// What the test needs and the file lacks, and how it was derived: a sentence without a full stop.
    pub derived: Option<String>,
    /// The outcome of each grasp, in the order of the file.
    #[serde(skip)]
    pub outcomes: Vec<Outcome>,
}

/// What all tests and measures say of one set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetVerdict {
    /// Name of the set.
    pub name: String,
    /// Number of grasps.
    pub grasps: usize,
    /// Number of objects; the same object at another scale is another one.
    pub objects: usize,
    /// The tests, in the order of the settings.
    pub tests: Vec<TestVerdict>,
    /// The measures, in the order of the settings.
    pub measures: Vec<Measured>,
}

/// What all tests and measures say of all sets.
#[derive(Debug, Clone)]
pub struct Verdicts {
    /// The sets, in their order.
    pub sets: Vec<SetVerdict>,
    /// For each two tests the share of all grasps of all sets on which they agree; the diagonal is 1.
    pub agreement: Vec<Vec<f64>>,
    /// The settings.
    pub settings: RefereeSettings,
}

impl RefereeSettings {
    /// The test whose grasps are counted by measures that count only those that hold: that of `DexGraspBench` if it is run,
    /// otherwise the first.
    pub fn deciding(&self) -> Option<usize> {
        let usual = self
            .tests
            .iter()
            .position(|test| test.name == "dexgraspbench");
        usual.or((!self.tests.is_empty()).then_some(0))
    }
}

/// A hash of all that the outcomes of tests depend on, for the journal.
///
/// # Errors
/// If the metadata cannot be stored.
pub fn referee_fingerprint(
    sets: &[JudgedSet<'_>],
    settings: &RefereeSettings,
) -> Result<String, serde_json::Error> {
    let mut parts = Vec::new();
    for set in sets {
        for test in &settings.tests {
            parts.push(simulation_fingerprint(set.file, &test.protocol)?);
        }
    }
    let parts: Vec<&[u8]> = parts.iter().map(String::as_bytes).collect();
    Ok(content_hash(&parts))
}

/// Simulates every grasp of every set by every test, and measures the sets. Finished grasps are kept in the journal of the
/// run.
///
/// Intervals (95 %) come from resampling: objects with replacement, then grasps within each drawn object; a set of one object
/// is resampled by grasps alone. Measures that count only grasps that hold take those of [`RefereeSettings::deciding`].
///
/// # Errors
/// If a hand or an object cannot be built, or the journal takes no record.
pub fn judge_sets(
    sets: &[JudgedSet<'_>],
    settings: &RefereeSettings,
    run: &Run<'_>,
) -> Result<Verdicts, StudyError> {
    let mut verdicts = Vec::new();
    for (number, set) in sets.iter().enumerate() {
        verdicts.push(judge_set(number, set, settings, run)?);
    }
    Ok(Verdicts {
        agreement: agreement(&verdicts, settings.tests.len()),
        sets: verdicts,
        settings: settings.clone(),
    })
}

fn judge_set(
    number: usize,
    set: &JudgedSet<'_>,
    settings: &RefereeSettings,
    run: &Run<'_>,
) -> Result<SetVerdict, StudyError> {
    let places: BTreeMap<u64, usize> = (set.file.grasps.iter().enumerate())
        .map(|(place, row)| (row.id, place))
        .collect();
    let objects: Vec<Vec<usize>> = (set.file.landscapes().iter())
        .map(|population| {
            population
                .grasps
                .iter()
                .map(|row| places[&row.id])
                .collect()
        })
        .collect();
    let mut tests = Vec::new();
    for test in &settings.tests {
        let prefix = format!("set {number}, {}: ", test.name);
        let journal = Prefixed {
            journal: run.journal,
            prefix: &prefix,
        };
        let run = Run {
            journal: &journal,
            ..*run
        };
        let found = simulate_all(set.file, &test.protocol, &run)?;
        let outcomes: BTreeMap<u64, Outcome> = found.outcomes.into_iter().collect();
        let outcomes = set.file.grasps.iter().map(|row| outcomes[&row.id]);
        let seed = settings.resampling.seed;
        tests.push(TestVerdict::of(
            test,
            outcomes.collect(),
            &objects,
            (seed, settings.resampling.count),
        ));
    }
    let held: Option<BTreeSet<u64>> = settings.deciding().map(|deciding| {
        let outcomes = tests[deciding].outcomes.iter().zip(&set.file.grasps);
        let held = outcomes.filter(|(outcome, _)| outcome.is_stable());
        held.map(|(_, row)| row.id).collect()
    });
    let measures = if settings.measures.is_empty() {
        Vec::new()
    } else {
        let measured = MeasuredSet::of(set.file, Rule::standard(), run)?;
        measure(
            &measured,
            held.as_ref(),
            &settings.measures,
            &settings.resampling,
        )
    };
    Ok(SetVerdict {
        name: set.name.to_owned(),
        grasps: set.file.grasps.len(),
        objects: objects.len(),
        tests,
        measures,
    })
}

impl TestVerdict {
    /// Counts outcomes, in the order of the file; `objects` has the places of the grasps of each object.
    fn of(
        test: &NamedProtocol,
        outcomes: Vec<Outcome>,
        objects: &[Vec<usize>],
        (seed, draws): (u64, usize),
    ) -> Self {
        let mut reasons = BTreeMap::new();
        for outcome in &outcomes {
            *reasons.entry(outcome.reason.name()).or_insert(0) += 1;
        }
        let stable: Vec<bool> = outcomes.iter().map(Outcome::is_stable).collect();
        let held = stable.iter().filter(|stable| **stable).count();
        let held_somewhere = |object: &&Vec<usize>| object.iter().any(|grasp| stable[*grasp]);
        let [low, high] = wilson(held as f64, stable.len() as f64);
        let [least, most] = resampled(&stable, objects, seed, draws).interval(0.95);
        Self {
            holds: held as f64 / stable.len() as f64,
            interval: [low.min(least), high.max(most)],
            objects_held: objects.iter().filter(held_somewhere).count(),
            reasons,
            derived: derived(test, &outcomes),
            outcomes,
        }
    }
}

/// The share of grasps that hold in resampled sets: objects with replacement, then as many grasps of each as it has.
fn resampled(stable: &[bool], objects: &[Vec<usize>], seed: u64, draws: usize) -> Resampled {
    let share = |draw: u64| {
        let mut rng = stream(seed, Task::Resampling, draw);
        let (mut held, mut all) = (0, 0);
        for _ in objects {
            let object = &objects[rng.random_range(0..objects.len())];
            for _ in object {
                held += usize::from(stable[object[rng.random_range(0..object.len())]]);
            }
            all += object.len();
        }
        held as f64 / all as f64
    };
    Resampled::new((0..draws as u64).map(share).collect())
}

/// What the test needed and the file lacked.
fn derived(test: &NamedProtocol, outcomes: &[Outcome]) -> Option<String> {
    let Protocol::Loads(loads) = &test.protocol else {
        return None;
    };
    let by = |rule| {
        outcomes
            .iter()
            .filter(|outcome| outcome.closed_by == rule)
            .count()
    };
    let given = loads.closing.rule == ClosingRule::Given;
    let squeezed = by(ClosingRule::Squeeze);
    (given && squeezed > 0).then(|| {
        format!(
            "the squeezed joints of {squeezed} of {} grasps follow from balanced forces on their contact sets, {} N each in the \
             mean",
            outcomes.len(),
            loads.closing.force_n.unwrap_or_default()
        )
    })
}

/// For each two tests the share of all grasps on which they agree.
fn agreement(sets: &[SetVerdict], tests: usize) -> Vec<Vec<f64>> {
    let total: usize = sets.iter().map(|set| set.grasps).sum();
    let agree = |a: usize, b: usize| {
        let of_set = |set: &SetVerdict| {
            let pairs = set.tests[a].outcomes.iter().zip(&set.tests[b].outcomes);
            pairs
                .filter(|(a, b)| a.is_stable() == b.is_stable())
                .count()
        };
        sets.iter().map(of_set).sum::<usize>() as f64 / total as f64
    };
    (0..tests)
        .map(|a| (0..tests).map(|b| agree(a, b)).collect())
        .collect()
}
