//! A run that several processes share. Each has a journal of its own and reads those of the others.
//!
//! The journals lie in a folder beside the output: `X.workers/3-of-64-MACHINE.journal`. A worker writes and locks only its own. It
//! does its share of each round (the tasks whose place is its number modulo the count of workers), and then tasks that
//! nobody has begun or whose worker is gone. Two workers that do the same task write the same record, so nothing depends on
//! locks or clocks but the time that is lost.

use std::collections::{BTreeMap, VecDeque};
use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::Journal;
use super::locks::{self, Lock};
use super::marks::{HEARTBEAT, Life, Mark, PATIENCE, Place, Tail, kernel, now};
use crate::store::error::StoreError;
use crate::store::machine::Machine;
use crate::topography::{self, JournalError, Phase, Round, Workers};

/// Reading the journals of others takes at most this share of a worker's time, while there are own tasks.
const SHARE_OF_READING: u32 = 20;
/// First and longest pause of a thread that waits for other workers.
const FIRST_PAUSE: Duration = Duration::from_millis(50);
const LONGEST_PAUSE: Duration = Duration::from_secs(1);
/// Records reach the disk, and so other machines, after this time at most.
const FLUSH: Duration = Duration::from_secs(1);

/// One of the processes that share a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Worker {
    /// Number of the worker, from 1 to `count`.
    pub number: usize,
    /// Number of workers.
    pub count: usize,
}

impl fmt::Display for Worker {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} of {}", self.number, self.count)
    }
}

/// The journal of one process of a run, and the journals of the others, which it reads.
pub struct WorkersJournal {
    own: Arc<Journal>,
    worker: Option<Worker>,
    folder: PathBuf,
    fingerprint: String,
    others: Mutex<Others>,
    rounds: AtomicU64,
    heart: Option<Heart>,
}

#[derive(Default)]
struct Others {
    tails: Vec<Tail>,
    /// The first record that was seen of each task.
    index: BTreeMap<String, (usize, Place)>,
    /// Records of tasks that are in the own journal too.
    twice: usize,
    /// When the journals were last read, and how long it took.
    read_at: Option<Instant>,
    reading: Duration,
}

impl WorkersJournal {
    /// Folder of the journals of the workers of a run that writes `output`.
    pub fn folder(output: &Path) -> PathBuf {
        let mut name = output.as_os_str().to_owned();
        name.push(".workers");
        PathBuf::from(name)
    }

    /// Opens the journal of a worker of the run that writes `output`. The records in the journal `plain` of an interrupted
    /// run without workers are read as well.
    ///
    /// # Errors
    /// If the worker is running already, a run without workers is at work, a journal belongs to another run, or the folder
    /// cannot be written.
    pub fn of_worker(
        output: &Path,
        plain: &Path,
        fingerprint: &str,
        worker: Worker,
    ) -> Result<Self, StoreError> {
        let folder = Self::folder(output);
        std::fs::create_dir_all(&folder).map_err(StoreError::io("create", &folder))?;
        let locks = locks::are_in(&folder).map_err(StoreError::io("lock files in", &folder))?;
        // Without locks a second process with this number may be at work, so each has a journal of its own.
        let process = (!locks).then(std::process::id);
        let path = folder.join(journal_name(worker, process));
        let own = Arc::new(open_patiently(&path, fingerprint)?);
        let mut others = Others::default();
        if plain.is_file() {
            if locks::of(plain) == Lock::Held {
                return Err(StoreError::InUse(plain.to_path_buf()));
            }
            others.tails.push(Tail::new(plain.to_path_buf()));
        }
        put_mark(&own, &Mark::Life(Life::begins(Some(worker))))?;
        let journal = Self {
            heart: Some(Heart::beating(own.clone())),
            own,
            worker: Some(worker),
            folder,
            fingerprint: fingerprint.to_owned(),
            others: Mutex::new(others),
            rounds: AtomicU64::new(0),
        };
        journal.refresh(Duration::ZERO)?;
        Ok(journal)
    }

    /// The journal `own` of a run without workers, together with those that workers of the same run have left. `waits` is
    /// told of a worker on another machine that may still be at work, which takes half a minute to see.
    ///
    /// # Errors
    /// If a worker is still at work, or a journal belongs to another run or cannot be read.
    pub fn joining(
        own: Journal,
        output: &Path,
        fingerprint: &str,
        waits: &dyn Fn(Worker),
    ) -> Result<Self, StoreError> {
        let journal = Self {
            own: Arc::new(own),
            worker: None,
            folder: Self::folder(output),
            fingerprint: fingerprint.to_owned(),
            others: Mutex::default(),
            rounds: AtomicU64::new(0),
            heart: None,
        };
        let (begun, mut told) = (Instant::now(), false);
        loop {
            journal.refresh(Duration::ZERO)?;
            let others = journal.others();
            let Some(tail) = others.tails.iter().find(|tail| tail.is_at_work()) else {
                break;
            };
            let worker = tail.life.as_ref().and_then(|life| life.worker);
            if tail.is_held() || begun.elapsed() > PATIENCE + HEARTBEAT {
                return Err(StoreError::WorkerAtWork {
                    path: tail.path.clone(),
                    host: tail
                        .life
                        .as_ref()
                        .map_or_else(String::new, |life| life.host.clone()),
                });
            }
            if let (Some(worker), false) = (worker, told) {
                waits(worker);
                told = true;
            }
            drop(others);
            std::thread::sleep(FLUSH);
        }
        Ok(journal)
    }

    /// Removes what workers have left of the run that writes `output`, whatever it is.
    ///
    /// # Errors
    /// If a worker is at work, or the folder holds files of others or cannot be removed.
    pub fn discard(output: &Path) -> Result<(), StoreError> {
        let folder = Self::folder(output);
        let journals = journals_in(&folder)?;
        for path in &journals {
            let mut tail = Tail::new(path.clone());
            if tail.read_on(None, |_, _| ()).is_ok() && tail.is_at_work() {
                return Err(StoreError::InUse(path.clone()));
            }
        }
        remove_journals(&folder, &journals)
    }

    /// Number of tasks that have a record in any of the journals.
    pub fn len(&self) -> usize {
        let others = self.others();
        self.own.len() + others.index.len() - others.twice
    }

    /// Whether no task is recorded.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of journals of others.
    pub fn journals_of_others(&self) -> usize {
        self.others().tails.len()
    }

    /// Whether a lock keeps other processes from the own journal; see [`Journal::has_lock`].
    pub fn has_lock(&self) -> bool {
        self.own.has_lock()
    }

    /// Number of bytes of a torn record that were dropped when the own journal was opened.
    pub fn dropped_bytes(&self) -> u64 {
        self.own.dropped_bytes()
    }

    /// Workers of another build of the program, each with what differs: the last bits of their results may differ. Other
    /// vector instructions of the processor matter for neural shapes only.
    pub fn other_builds(&self) -> Vec<(Worker, String)> {
        let here = Machine::here();
        let others = self.others();
        let lives = others.tails.iter().filter_map(|tail| tail.life.as_ref());
        let different = lives.filter(|life| !life.machine.is_of_build(&here));
        different
            .filter_map(|life| {
                let difference = format!("{} there, {here} here", life.machine);
                Some((life.worker?, difference))
            })
            .collect()
    }

    /// Marks that nothing is left for this worker.
    ///
    /// # Errors
    /// If the journal cannot be written.
    pub fn end(mut self) -> Result<(), StoreError> {
        self.heart = None;
        put_mark(&self.own, &Mark::End)?;
        self.own.sync()
    }

    /// Removes the own journal and those of the workers, when the results of the run are complete and stored elsewhere.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn remove(self) -> Result<(), StoreError> {
        self.remove_others()?;
        std::fs::remove_file(&self.own.path).map_err(StoreError::io("remove", &self.own.path))
    }

    /// Removes the journals of the workers.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn remove_others(&self) -> Result<(), StoreError> {
        remove_journals(&self.folder, &journals_in(&self.folder)?)
    }

    fn others(&self) -> MutexGuard<'_, Others> {
        // What a panic leaves is a prefix of what was read.
        self.others.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads what others have written, unless this was done less than `pause` ago.
    fn refresh(&self, pause: Duration) -> Result<(), StoreError> {
        let mut others = self.others();
        if others.read_at.is_some_and(|at| at.elapsed() < pause) {
            return Ok(());
        }
        let begun = Instant::now();
        for path in journals_in(&self.folder)? {
            let known = others.tails.iter().any(|tail| tail.path == path);
            if path != self.own.path && !known {
                others.tails.push(Tail::new(path));
            }
        }
        let Others {
            tails,
            index,
            twice,
            read_at,
            reading,
        } = &mut *others;
        for (number, tail) in tails.iter_mut().enumerate() {
            tail.read_on(Some(&self.fingerprint), |key, place| {
                if !index.contains_key(key) {
                    *twice += usize::from(self.own.holds(key));
                    index.insert(key.to_owned(), (number, place));
                }
            })?;
        }
        *read_at = Some(Instant::now());
        *reading = begun.elapsed();
        Ok(())
    }

    fn get(&self, key: &str) -> Result<Option<Vec<u8>>, StoreError> {
        if let Some(record) = self.own.get(key) {
            return Ok(Some(record));
        }
        let others = self.others();
        let place = others.index.get(key).copied();
        place.map_or(Ok(None), |(tail, place)| others.tails[tail].payload(place))
    }

    fn put(&self, key: &str, record: &[u8]) -> Result<(), StoreError> {
        if !self.own.holds(key) {
            let mut others = self.others();
            others.twice += usize::from(others.index.contains_key(key));
        }
        self.own.put(key, record)
    }

    fn standing(&self, key: &str) -> Standing {
        let others = self.others();
        if self.own.holds(key) || others.index.contains_key(key) {
            return Standing::Recorded;
        }
        let mut begun = others.tails.iter().filter(|tail| tail.begun.contains(key));
        if begun.any(Tail::is_at_work) {
            Standing::AtWork
        } else {
            Standing::Free
        }
    }
}

/// How a task stands.
enum Standing {
    Recorded,
    /// Another process that still works has begun it.
    AtWork,
    Free,
}

impl topography::Journal for WorkersJournal {
    fn get(&self, key: &str) -> Option<Vec<u8>> {
        // A record that cannot be read is made again.
        self.get(key).ok().flatten()
    }

    fn put(&self, key: &str, record: &[u8]) -> Result<(), JournalError> {
        Ok(self.put(key, record).map_err(boxed)?)
    }
}

impl Workers for WorkersJournal {
    fn begin<'a>(&'a self, phase: Phase, keys: &'a [String]) -> Box<dyn Round + 'a> {
        let number = self.rounds.fetch_add(1, Ordering::Relaxed);
        let stage = Mark::Stage(super::marks::Stage {
            round: number,
            name: phase.name().to_owned(),
            tasks: keys.len(),
        });
        // For those who watch; a disk that is full is told with the first task.
        let _ = put_mark(&self.own, &stage);
        let recorded = |key: &&String| matches!(self.standing(key), Standing::Recorded);
        Box::new(SharedRound {
            journal: self,
            keys,
            number,
            recorded_at_begin: keys.iter().filter(recorded).count(),
            known_at_begin: self.len(),
            queue: Mutex::new(Queue {
                next: order(keys.len(), self.worker),
                own: self.worker.map_or(0, |worker| keys.len() / worker.count),
                waiting: Vec::new(),
            }),
        })
    }
}

/// The order in which a worker takes tasks: its own share, then the shares of the workers after it, each from its end,
/// where its worker comes last.
fn order(tasks: usize, worker: Option<Worker>) -> VecDeque<usize> {
    let Some(Worker { number, count }) = worker else {
        return (0..tasks).collect();
    };
    let share = |k: usize| ((number - 1 + k) % count..tasks).step_by(count);
    let others = (1..count).flat_map(|k| share(k).rev());
    share(0).chain(others).collect()
}

struct SharedRound<'a> {
    journal: &'a WorkersJournal,
    keys: &'a [String],
    number: u64,
    recorded_at_begin: usize,
    known_at_begin: usize,
    queue: Mutex<Queue>,
}

struct Queue {
    /// Tasks that this process has not looked at, in the order of its choice.
    next: VecDeque<usize>,
    /// About how many of them are of its own share.
    own: usize,
    /// Tasks that others work at.
    waiting: Vec<usize>,
}

impl SharedRound<'_> {
    /// The next task, or how many are left to wait for. Journals of others are read again after `pause` at the earliest.
    fn look(&self, pause: Duration) -> Result<Result<usize, usize>, StoreError> {
        let mut queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let begin = |task: usize| {
            let begin = Mark::Begin {
                key: self.keys[task].clone(),
                round: self.number,
            };
            put_mark(&self.journal.own, &begin)?;
            Ok(Ok(task))
        };
        let reading = self.journal.others().reading;
        let own_tasks = LONGEST_PAUSE.min(SHARE_OF_READING * reading);
        (self.journal).refresh(if queue.own > 0 { own_tasks } else { pause })?;
        while let Some(task) = queue.next.pop_front() {
            queue.own = queue.own.saturating_sub(1);
            match self.journal.standing(&self.keys[task]) {
                Standing::Recorded => {}
                Standing::AtWork => queue.waiting.push(task),
                Standing::Free => return begin(task),
            }
        }
        let mut place = 0;
        while let Some(task) = queue.waiting.get(place).copied() {
            match self.journal.standing(&self.keys[task]) {
                Standing::AtWork => place += 1,
                Standing::Recorded => drop(queue.waiting.swap_remove(place)),
                Standing::Free => {
                    queue.waiting.swap_remove(place);
                    return begin(task);
                }
            }
        }
        Ok(Err(queue.waiting.len()))
    }
}

impl Round for SharedRound<'_> {
    fn next(&self) -> Result<Option<usize>, JournalError> {
        let mut pause = FIRST_PAUSE;
        loop {
            match self.look(pause).map_err(boxed)? {
                Ok(task) => return Ok(Some(task)),
                Err(0) => return Ok(None),
                Err(_) => std::thread::sleep(pause),
            }
            pause = LONGEST_PAUSE.min(2 * pause);
        }
    }

    fn finished(&self) -> usize {
        let new = self.journal.len().saturating_sub(self.known_at_begin);
        (self.recorded_at_begin + new).min(self.keys.len())
    }
}

/// Marks that the process lives, and flushes its journal, until it is dropped.
struct Heart {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Heart {
    fn beating(own: Arc<Journal>) -> Self {
        let (stop, stopped) = channel();
        let beat = move || {
            let mut marked = Instant::now();
            while stopped.recv_timeout(FLUSH) == Err(RecvTimeoutError::Timeout) {
                if marked.elapsed() >= HEARTBEAT {
                    // A full disk is told with the next record.
                    let _ = put_mark(&own, &Mark::Alive(now()));
                    marked = Instant::now();
                }
                let _ = own.sync();
            }
        };
        Self {
            stop: Some(stop),
            thread: std::thread::Builder::new().spawn(beat).ok(),
        }
    }
}

impl Drop for Heart {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn put_mark(journal: &Journal, mark: &Mark) -> Result<(), StoreError> {
    let (key, payload) = mark.record();
    journal.mark(&key, &payload)
}

/// Name of a worker's journal. It is another on each machine, because the lock of a file may not be seen by all of them.
fn journal_name(Worker { number, count }: Worker, process: Option<u32>) -> String {
    let kernel: String = kernel().chars().take(8).collect();
    let process = process.map_or_else(String::new, |process| format!("-{process}"));
    format!("{number}-of-{count}-{kernel}{process}.journal")
}

/// Opens a journal; another process may hold its lock for a moment to see whether it is held.
fn open_patiently(path: &Path, fingerprint: &str) -> Result<Journal, StoreError> {
    let mut tries = 0;
    loop {
        match Journal::open(path, fingerprint, false) {
            Err(StoreError::InUse(_)) if tries < 10 => tries += 1,
            opened => return opened,
        }
        std::thread::sleep(FIRST_PAUSE);
    }
}

/// The journals in a folder of workers, in the order of their names. None if there is no folder.
pub(super) fn journals_in(folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(StoreError::io("read", folder)(error)),
    };
    let paths = entries.map(|entry| Ok(entry?.path()));
    let paths = paths.collect::<std::io::Result<Vec<PathBuf>>>();
    let mut paths = paths.map_err(StoreError::io("read", folder))?;
    paths.retain(|path| {
        path.extension()
            .is_some_and(|extension| extension == "journal")
    });
    paths.sort();
    Ok(paths)
}

fn remove_journals(folder: &Path, journals: &[PathBuf]) -> Result<(), StoreError> {
    for path in journals {
        std::fs::remove_file(path).map_err(StoreError::io("remove", path))?;
    }
    match std::fs::remove_dir(folder) {
        // The folder holds files of others, or there is none.
        Err(error)
            if !matches!(
                error.kind(),
                std::io::ErrorKind::NotFound | std::io::ErrorKind::DirectoryNotEmpty
            ) =>
        {
            Err(StoreError::io("remove", folder)(error))
        }
        _ => Ok(()),
    }
}

fn boxed(error: StoreError) -> Box<dyn Error + Send + Sync> {
    error.into()
}

impl fmt::Debug for WorkersJournal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("WorkersJournal")
            .field("folder", &self.folder)
            .field("worker", &self.worker)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
