//! Marks in the journals of workers: who writes the journal, what it works at, and that it lives.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime};

use serde::{Deserialize, Serialize};

use super::locks::{self, Lock};
use super::record::{Found, Head, MARK, is_mark, records, split_head};
use super::workers::Worker;
use crate::store::error::StoreError;
use crate::store::machine::Machine;

/// A worker on another machine counts as gone if its journal has not grown for this long. Only the clock of the observer
/// is used.
pub(super) const PATIENCE: Duration = Duration::from_secs(30);
/// A worker marks at least this often that it lives.
pub(super) const HEARTBEAT: Duration = Duration::from_secs(5);

/// The mark with which a worker begins or continues its journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Life {
    pub(super) worker: Option<Worker>,
    /// Identifies a running kernel: locks of files are seen by all processes of one kernel.
    pub(super) kernel: String,
    pub(super) host: String,
    pub(super) process: u32,
    pub(super) machine: Machine,
    /// Seconds since 1970 by the worker's clock.
    pub(super) at: f64,
}

/// The mark of a new round.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Stage {
    pub(super) round: u64,
    /// What is being done.
    pub(super) name: String,
    pub(super) tasks: usize,
}

/// Kinds of marks.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mark {
    Life(Life),
    Stage(Stage),
    /// The worker begins a task of a round.
    Begin {
        key: String,
        round: u64,
    },
    /// The worker lives, at this time by its clock.
    Alive(f64),
    /// The worker ends, because nothing is left for it.
    End,
}

impl Mark {
    /// Key and payload of the record.
    pub(super) fn record(&self) -> (String, Vec<u8>) {
        match self {
            Self::Life(life) => (format!("{MARK}worker"), json(life)),
            Self::Stage(stage) => (format!("{MARK}round"), json(stage)),
            Self::Begin { key, round } => (format!("{MARK}begin {key}"), json(round)),
            Self::Alive(at) => (format!("{MARK}alive"), json(at)),
            Self::End => (format!("{MARK}end"), Vec::new()),
        }
    }

    fn read(found: &Found<'_>) -> Option<Self> {
        let name = found.key.strip_prefix(MARK)?;
        let payload = found.payload;
        Some(match name.split_once(' ') {
            Some(("begin", key)) => Self::Begin {
                key: key.to_owned(),
                round: serde_json::from_slice(payload).ok()?,
            },
            None if name == "worker" => Self::Life(serde_json::from_slice(payload).ok()?),
            None if name == "round" => Self::Stage(serde_json::from_slice(payload).ok()?),
            None if name == "alive" => Self::Alive(serde_json::from_slice(payload).ok()?),
            None if name == "end" => Self::End,
            _ => return None,
        })
    }
}

/// Plain data as JSON.
fn json(value: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec(value).expect("plain data is always JSON")
}

impl Life {
    pub(super) fn begins(worker: Option<Worker>) -> Self {
        Self {
            worker,
            kernel: kernel(),
            host: first_line("/proc/sys/kernel/hostname"),
            process: std::process::id(),
            machine: Machine::here(),
            at: now(),
        }
    }
}

/// Identifies the running kernel; empty if the system does not tell.
pub(super) fn kernel() -> String {
    first_line("/proc/sys/kernel/random/boot_id")
}

fn first_line(path: &str) -> String {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.lines().next().unwrap_or_default().to_owned()
}

/// Seconds since 1970.
pub(super) fn now() -> f64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0.0, |since| since.as_secs_f64())
}

/// Where a record lies in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) start: u64,
    pub(super) length: usize,
}

/// The journal of another process, which is read while it grows.
#[derive(Debug)]
pub(super) struct Tail {
    pub(super) path: PathBuf,
    /// What has been read.
    end: u64,
    /// When it was seen to have grown.
    grown_at: Instant,
    pub(super) life: Option<Life>,
    pub(super) ended: bool,
    /// Tasks that the process has begun and not finished.
    pub(super) begun: BTreeSet<String>,
    /// The latest round that the process has begun, and which tasks of it it has finished.
    pub(super) stage: Option<Stage>,
    pub(super) of_stage: BTreeSet<String>,
    /// The latest time by the clock of the process, and how many tasks it has finished since its life began.
    pub(super) seen: f64,
    pub(super) finished: usize,
    round_begun: BTreeSet<String>,
}

impl Tail {
    pub(super) fn new(path: PathBuf) -> Self {
        Self {
            path,
            end: 0,
            grown_at: Instant::now(),
            life: None,
            ended: false,
            begun: BTreeSet::new(),
            stage: None,
            of_stage: BTreeSet::new(),
            seen: 0.0,
            finished: 0,
            round_begun: BTreeSet::new(),
        }
    }

    /// Reads what is new, and shows `take` each new task. The file is opened anew each time, because file systems of
    /// networks show then what others have written.
    pub(super) fn read_on(
        &mut self,
        fingerprint: Option<&str>,
        mut take: impl FnMut(&str, Place),
    ) -> Result<(), StoreError> {
        let mut bytes = Vec::new();
        let mut file = File::open(&self.path).map_err(StoreError::io("read", &self.path))?;
        file.seek(SeekFrom::Start(self.end))
            .and_then(|_| file.read_to_end(&mut bytes))
            .map_err(StoreError::io("read", &self.path))?;
        let mut start = 0;
        if self.end == 0 {
            match split_head(&bytes, fingerprint.unwrap_or_default()) {
                Head::Whole {
                    fingerprint: found, ..
                } if fingerprint.is_some_and(|wanted| wanted.as_bytes() != found) => {
                    return Err(StoreError::OtherRun(self.path.clone()));
                }
                Head::Whole { length, .. } => start = length,
                Head::Torn => return Ok(()),
                Head::Foreign => return Err(StoreError::NotAJournal(self.path.clone())),
            }
        }
        let mut end = start;
        for found in records(&bytes, start) {
            end = found.end;
            if is_mark(found.key) {
                self.take_mark(Mark::read(&found));
            } else {
                self.begun.remove(found.key);
                self.finished += 1;
                if self.round_begun.contains(found.key) {
                    self.of_stage.insert(found.key.to_owned());
                }
                let place = Place {
                    start: self.end + found.start as u64,
                    length: found.end - found.start,
                };
                take(found.key, place);
            }
        }
        if end > 0 {
            self.grown_at = Instant::now();
        }
        self.end += end as u64;
        Ok(())
    }

    fn take_mark(&mut self, mark: Option<Mark>) {
        match mark {
            Some(Mark::Life(life)) => {
                // What an earlier life has begun and not finished, nobody works at.
                self.begun.clear();
                (self.ended, self.finished, self.seen) = (false, 0, life.at);
                self.life = Some(life);
            }
            Some(Mark::Stage(stage)) => {
                if (self.stage.as_ref()).is_none_or(|known| known.round != stage.round) {
                    self.of_stage.clear();
                    self.round_begun.clear();
                }
                self.stage = Some(stage);
            }
            Some(Mark::Begin { key, round }) => {
                if self
                    .stage
                    .as_ref()
                    .is_some_and(|stage| stage.round == round)
                {
                    self.round_begun.insert(key.clone());
                }
                self.begun.insert(key);
            }
            Some(Mark::Alive(at)) => self.seen = at,
            Some(Mark::End) => self.ended = true,
            // A mark of a later version.
            None => {}
        }
    }

    /// Whether the process still works: by its lock if it runs under this kernel and the file system has locks, and else by
    /// whether its journal grows.
    pub(super) fn is_at_work(&self) -> bool {
        !self.ended
            && self
                .lock()
                .unwrap_or_else(|| self.grown_at.elapsed() < PATIENCE)
    }

    /// Whether a lock shows that the process works under this kernel.
    pub(super) fn is_held(&self) -> bool {
        self.lock() == Some(true)
    }

    /// Whether the lock of the journal is held; `None` if this cannot be seen from here.
    fn lock(&self) -> Option<bool> {
        // The journal of a run without workers has no life, nor has one whose first mark is not written yet.
        if let Some(life) = &self.life
            && (life.kernel.is_empty() || life.kernel != kernel())
        {
            return None;
        }
        match locks::of(&self.path) {
            Lock::Held => Some(true),
            Lock::Free => Some(false),
            Lock::Unknown => None,
        }
    }

    /// Makes the last growth seem so much longer ago.
    #[cfg(test)]
    pub(super) fn age(&mut self, by: Duration) {
        self.grown_at = self.grown_at.checked_sub(by).unwrap();
    }

    /// The record of a task.
    pub(super) fn payload(&self, place: Place) -> Result<Option<Vec<u8>>, StoreError> {
        let mut bytes = vec![0; place.length];
        let mut file = File::open(&self.path).map_err(StoreError::io("read", &self.path))?;
        file.seek(SeekFrom::Start(place.start))
            .and_then(|_| file.read_exact(&mut bytes))
            .map_err(StoreError::io("read", &self.path))?;
        let found = records(&bytes, 0).next();
        Ok(found.map(|found| found.payload.to_vec()))
    }
}
