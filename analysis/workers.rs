//! How busy workers are that share a `build`, simulated from recorded times of tasks.
//!
//! `cargo run --release --example workers [GRASPS.parquet] [FIRST] [BATCH]` maps the grasps on one thread, records how long
//! each task takes and which tasks make a round, and prints the time and the busy share for several numbers of workers with
//! one thread each. The scheduling is that of `--worker`: each worker does its own share, then what others have not begun.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use landscape::store::{GraspFile, Overrides};
use landscape::study::{GraspMapSettings, Run, StudyRun, map_population};
use landscape::topography::{JournalError, Phase, Round, Workers};

/// A round of tasks.
struct Recorded {
    phase: Phase,
    /// Seconds of the sequential work before it.
    before: f64,
    /// Seconds of each task.
    tasks: Vec<f64>,
}

/// Does all tasks itself, in order, and records their times.
struct Recorder {
    rounds: Mutex<Vec<Recorded>>,
    last: Mutex<Instant>,
}

struct Recording<'a> {
    recorder: &'a Recorder,
    count: usize,
    next: Mutex<usize>,
}

fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Recorder {
    /// Seconds since the last call.
    fn lap(&self) -> f64 {
        let mut last = locked(&self.last);
        let seconds = last.elapsed().as_secs_f64();
        *last = Instant::now();
        seconds
    }
}

impl Workers for Recorder {
    fn begin<'a>(&'a self, phase: Phase, keys: &'a [String]) -> Box<dyn Round + 'a> {
        let before = self.lap();
        locked(&self.rounds).push(Recorded {
            phase,
            before,
            tasks: Vec::new(),
        });
        Box::new(Recording {
            recorder: self,
            count: keys.len(),
            next: Mutex::new(0),
        })
    }
}

impl Round for Recording<'_> {
    fn next(&self) -> Result<Option<usize>, JournalError> {
        let mut next = locked(&self.next);
        let seconds = self.recorder.lap();
        if let Some(round) = locked(&self.recorder.rounds).last_mut()
            && *next > 0
        {
            round.tasks.push(seconds);
        }
        if *next == self.count {
            return Ok(None);
        }
        *next += 1;
        Ok(Some(*next - 1))
    }

    fn finished(&self) -> usize {
        *locked(&self.next)
    }
}

/// Seconds in which `workers` do a round: each takes the next task of its own share, then the last ones of others' shares.
fn makespan(tasks: &[f64], workers: usize) -> f64 {
    let mut free = vec![0.0_f64; workers];
    let mut shares: Vec<std::collections::VecDeque<f64>> = (0..workers)
        .map(|worker| {
            tasks
                .iter()
                .skip(worker)
                .step_by(workers)
                .copied()
                .collect()
        })
        .collect();
    for _ in tasks {
        let worker = (0..workers)
            .min_by(|a, b| free[*a].total_cmp(&free[*b]))
            .unwrap_or(0);
        let taken = shares[worker].pop_front().or_else(|| {
            let mut others = (1..workers).map(|k| (worker + k) % workers);
            let other = others.find(|other| !shares[*other].is_empty())?;
            shares[other].pop_back()
        });
        free[worker] += taken.unwrap_or(0.0);
    }
    free.into_iter().fold(0.0, f64::max)
}

/// Least seconds that `workers` need for any division of the same tasks into rounds if phases follow each other: in each, the
/// time of the longest task or an equal share of all, whichever is longer.
fn without_rounds(rounds: &[Recorded], workers: usize) -> f64 {
    let mut phases: BTreeMap<Phase, (f64, f64)> = BTreeMap::new();
    for round in rounds {
        let (longest, sum) = phases.entry(round.phase).or_default();
        *longest = round.tasks.iter().copied().fold(*longest, f64::max);
        *sum += round.tasks.iter().sum::<f64>();
    }
    let share = |(longest, sum): &(f64, f64)| longest.max(sum / workers as f64);
    phases.values().map(share).sum()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let path = PathBuf::from(
        words
            .next()
            .unwrap_or_else(|| "data/grasps.parquet".to_owned()),
    );
    let first: usize = words.next().map_or(Ok(usize::MAX), |word| word.parse())?;
    let batch: Option<usize> = words.next().map(|word| word.parse()).transpose()?;
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()?;
    let (file, _) = GraspFile::read(&path, Overrides::default())?;
    for mut population in file.landscapes() {
        population.grasps.truncate(first);
        let energy = population.energy()?;
        let mut settings = GraspMapSettings::new(&energy);
        settings.map.batch = batch.unwrap_or(settings.map.batch);
        let recorder = Recorder {
            rounds: Mutex::default(),
            last: Mutex::new(Instant::now()),
        };
        let journal = landscape::topography::MemoryJournal::default();
        let run = StudyRun {
            run: Run {
                journal: &journal,
                workers: Some(&recorder),
                ..Run::default()
            },
            ..StudyRun::default()
        };
        let found = map_population(&population, &energy, &settings, &run)?;
        let after = recorder.lap();
        let rounds = recorder
            .rounds
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        println!(
            "{} grasps, {} minima, {} connections, {} evaluations",
            population.grasps.len(),
            found.landscape.network.node_count(),
            found.landscape.connections.len(),
            found.evaluations
        );
        println!(
            "| round | tasks | sequential before, s | tasks, s | longest, s |\n|---|---|---|---|---|"
        );
        for round in &rounds {
            println!(
                "| {} | {} | {:.2} | {:.2} | {:.2} |",
                round.phase.name(),
                round.tasks.len(),
                round.before,
                round.tasks.iter().sum::<f64>(),
                round.tasks.iter().copied().fold(0.0, f64::max)
            );
        }
        let sequential = after + rounds.iter().map(|round| round.before).sum::<f64>();
        let work: f64 = rounds.iter().flat_map(|round| &round.tasks).sum();
        println!(
            "{sequential:.1} s sequential, {work:.1} s of tasks in {} rounds\n",
            rounds.len()
        );
        println!(
            "| workers | time, s | speed-up | busy with tasks | busy at most, with one round for each phase |\n|---|---|---|---|---|"
        );
        let busy = |time: f64, workers: usize| 100.0 * work / (time * workers as f64);
        for workers in [1, 2, 4, 8, 16, 32, 64, 128, 256] {
            let spans = rounds.iter().map(|round| makespan(&round.tasks, workers));
            let time = sequential + spans.sum::<f64>();
            println!(
                "| {workers} | {time:.1} | {:.1} | {:.0} % | {:.0} % |",
                (sequential + work) / time,
                busy(time, workers),
                busy(sequential + without_rounds(&rounds, workers), workers)
            );
        }
    }
    Ok(())
}
