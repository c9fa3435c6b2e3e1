//! How far an unfinished run is and who works at it, from its journals.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::marks::{Stage, Tail};
use super::workers::{Worker, WorkersJournal, journals_in};
use crate::store::atomic::JOURNAL;
use crate::store::error::StoreError;

/// An unfinished run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunStatus {
    /// What the run will write.
    pub output: PathBuf,
    /// Number of tasks that have a record.
    pub finished_tasks: usize,
    /// The latest stage that a worker has begun.
    pub stage: Option<StageStatus>,
    /// Tasks that are being worked at.
    pub tasks_at_work: usize,
    /// Tasks per second of all workers at work, each measured by its own clock since it started.
    pub tasks_per_second: f64,
    /// Seconds until the tasks of the stage are finished at this rate.
    pub seconds_left_in_stage: Option<f64>,
    /// Whether a run without `--worker` is at work.
    pub plain_run_at_work: bool,
    /// The workers, by their journals.
    pub workers: Vec<WorkerStatus>,
}

/// Tasks that depend on no other of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageStatus {
    /// What is being done.
    pub name: String,
    /// Number of the round of tasks, from 1. Later rounds depend on earlier ones.
    pub round: u64,
    /// Number of tasks of this round.
    pub tasks: usize,
    /// How many of them are finished.
    pub finished: usize,
}

/// A worker of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WorkerStatus {
    /// Which one.
    pub worker: Worker,
    /// Whether it works.
    pub state: WorkerState,
    /// Its machine.
    pub host: String,
    /// Its process number there.
    pub process: u32,
    /// Tasks that it has finished since it started last.
    pub finished_tasks: usize,
    /// Tasks that it works at.
    pub tasks_at_work: usize,
    /// Seconds between its start and its last sign of life.
    pub seconds: f64,
}

/// Whether a worker works.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WorkerState {
    /// It works, or waits for others.
    AtWork,
    /// It has ended, because nothing was left.
    Ended,
    /// It was killed or has failed. It may be started again; others take over its tasks.
    Gone,
}

impl RunStatus {
    /// Reads the journals of the run that writes `output`. `None` if there are none.
    ///
    /// A worker on another machine counts as gone only after it has been watched for half a minute, so it is shown at work
    /// here.
    ///
    /// # Errors
    /// If a journal cannot be read.
    pub fn read(output: &Path) -> Result<Option<Self>, StoreError> {
        let mut partial = output.as_os_str().to_owned();
        partial.push(".partial");
        let partial = PathBuf::from(partial);
        let plain = [partial.join(JOURNAL), partial]
            .into_iter()
            .find(|path| path.is_file());
        let journals = journals_in(&WorkersJournal::folder(output))?;
        if plain.is_none() && journals.is_empty() {
            return Ok(None);
        }
        let mut keys = BTreeSet::new();
        let mut read = |path: PathBuf| {
            let mut tail = Tail::new(path);
            tail.read_on(None, |key, _| {
                keys.insert(key.to_owned());
            })?;
            Ok::<Tail, StoreError>(tail)
        };
        let plain = plain.map(&mut read).transpose()?;
        let tails = journals
            .into_iter()
            .map(read)
            .collect::<Result<Vec<_>, _>>()?;
        let workers: Vec<WorkerStatus> = tails.iter().filter_map(WorkerStatus::of).collect();
        let at_work = |status: &&WorkerStatus| status.state == WorkerState::AtWork;
        let rate = |status: &WorkerStatus| status.finished_tasks as f64 / status.seconds.max(1.0);
        // The sum of no numbers is -0.
        let tasks_per_second = workers.iter().filter(at_work).map(rate).sum::<f64>() + 0.0;
        let stage = stage(&tails);
        let left = stage.as_ref().map(|stage| stage.tasks - stage.finished);
        Ok(Some(Self {
            output: output.to_path_buf(),
            finished_tasks: keys.len(),
            seconds_left_in_stage: left
                .filter(|_| tasks_per_second > 0.0)
                .map(|left| left as f64 / tasks_per_second),
            stage,
            tasks_at_work: workers.iter().map(|worker| worker.tasks_at_work).sum(),
            tasks_per_second,
            plain_run_at_work: plain.as_ref().is_some_and(Tail::is_at_work),
            workers,
        }))
    }
}

impl WorkerStatus {
    fn of(tail: &Tail) -> Option<Self> {
        let life = tail.life.as_ref()?;
        let state = if tail.ended {
            WorkerState::Ended
        } else if tail.is_at_work() {
            WorkerState::AtWork
        } else {
            WorkerState::Gone
        };
        Some(Self {
            worker: life.worker?,
            state,
            host: life.host.clone(),
            process: life.process,
            finished_tasks: tail.finished,
            tasks_at_work: if state == WorkerState::AtWork {
                tail.begun.len()
            } else {
                0
            },
            seconds: (tail.seen - life.at).max(0.0),
        })
    }
}

/// The latest round of any worker.
fn stage(tails: &[Tail]) -> Option<StageStatus> {
    let stages = tails.iter().filter_map(|tail| tail.stage.as_ref());
    let Stage { round, name, tasks } = stages.max_by_key(|stage| stage.round)?;
    let of_it = tails.iter().filter(|tail| {
        tail.stage
            .as_ref()
            .is_some_and(|stage| stage.round == *round)
    });
    let finished: BTreeSet<&String> = of_it.flat_map(|tail| &tail.of_stage).collect();
    Some(StageStatus {
        name: name.clone(),
        round: round + 1,
        tasks: *tasks,
        finished: finished.len().min(*tasks),
    })
}
