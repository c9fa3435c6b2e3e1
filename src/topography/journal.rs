//! The journal of a long run, with which an interrupted run continues where it stopped.

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Observer, Phase, Tally};

/// Stores finished tasks by name. Records are opaque bytes that reproduce results bit for bit. They are valid only for the
/// energy, settings and input that made them.
pub trait Journal: Sync {
    /// The record of task `key`, if it was finished before.
    fn get(&self, key: &str) -> Option<Vec<u8>>;

    /// Stores the record of a finished task.
    ///
    /// # Errors
    /// If the record cannot or should not be stored. The run ends with this error.
    fn put(&self, key: &str, record: &[u8]) -> Result<(), JournalError>;
}

/// A run ended early because its journal could not store a record (for example on a full disk).
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct JournalError(#[from] Box<dyn Error + Send + Sync>);

/// Journal and progress observer of the long-running functions of this module. The default stores and reports nothing.
/// Tasks run on rayon's current thread pool; seeds belong to the settings.
///
/// ```
/// use landscape::topography::{MemoryJournal, Run};
///
/// let journal = MemoryJournal::default();
/// let observer = |news: landscape::topography::Progress| println!("{} of {}", news.done, news.total);
/// let run = Run { journal: &journal, observer: &observer, ..Run::default() };
/// let silent = Run { journal: &journal, ..Run::default() };
/// ```
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// Journal with the finished tasks, which are not done again.
    pub journal: &'a dyn Journal,
    /// Called after every task, from any thread.
    pub observer: &'a Observer<'a>,
    /// Asked between batches of tasks whether the given share of the time for the run is over, 1 being all of it. Then a
    /// search ends early, with what it has found. The result is that of a longer search up to a batch, but which batch that
    /// is depends on the clock if the answer does.
    pub enough: &'a (dyn Fn(f64) -> bool + Sync),
}

impl Default for Run<'_> {
    fn default() -> Self {
        Self {
            journal: &Forgetful,
            observer: &|_| (),
            enough: &|_| false,
        }
    }
}

impl std::fmt::Debug for Run<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Run").finish_non_exhaustive()
    }
}

impl Run<'_> {
    pub(crate) fn is_over(&self) -> bool {
        (self.enough)(1.0)
    }

    pub(crate) fn tally(&self, phase: Phase, total: usize) -> Tally<'_> {
        Tally::after(phase, 0, total, self.observer)
    }

    /// A tally of one round, from 0, of a phase of at most `most` rounds.
    pub(crate) fn tally_of_round(
        &self,
        phase: Phase,
        (round, most): (usize, usize),
        total: usize,
    ) -> Tally<'_> {
        Tally::of_round(phase, Some((round + 1, most)), (0, total), self.observer)
    }

    /// The outcomes of `tasks`, each of which has a key of its own: the stored ones, and the others by `work`, in parallel.
    /// They are begun in their order.
    pub(crate) fn each<K: Sync, T: Serialize + DeserializeOwned + Send>(
        &self,
        tally: &Tally<'_>,
        tasks: &[K],
        key: impl Fn(&K) -> String + Sync,
        work: impl Fn(&K) -> T + Sync,
    ) -> Result<Vec<T>, JournalError> {
        // Each thread takes the first task that nobody has begun, because tasks take different times.
        let next = AtomicUsize::new(0);
        let outcomes = (0..tasks.len()).into_par_iter().with_max_len(1).map(|_| {
            let task = next.fetch_add(1, Ordering::Relaxed);
            let outcome = self.remember(&key(&tasks[task]), || work(&tasks[task]))?;
            tally.tick();
            Ok((task, outcome))
        });
        let mut outcomes = outcomes.collect::<Result<Vec<(usize, T)>, JournalError>>()?;
        outcomes.sort_unstable_by_key(|(task, _)| *task);
        Ok(outcomes.into_iter().map(|(_, outcome)| outcome).collect())
    }

    /// The outcomes of `tasks` as [`Run::each`] has them, but one task after the other, each of which may use all threads
    /// itself. An error of a task ends the run and is not stored.
    #[cfg(feature = "cli")]
    pub(crate) fn in_turn<K, T: Serialize + DeserializeOwned, E: From<JournalError>>(
        &self,
        tasks: &[K],
        key: impl Fn(&K) -> String,
        mut work: impl FnMut(&K) -> Result<T, E>,
    ) -> Result<Vec<T>, E> {
        tasks
            .iter()
            .map(|task| self.try_remember(&key(task), || work(task)))
            .collect()
    }

    /// The stored outcome of task `key`, or else that of `work`, which is stored. Unreadable records are ignored.
    pub(crate) fn remember<T: Serialize + DeserializeOwned>(
        &self,
        key: &str,
        work: impl FnOnce() -> T,
    ) -> Result<T, JournalError> {
        self.try_remember(key, || Ok(work()))
    }

    fn try_remember<T: Serialize + DeserializeOwned, E: From<JournalError>>(
        &self,
        key: &str,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let known = self.journal.get(key);
        if let Some(value) = known.and_then(|record| serde_json::from_slice(&record).ok()) {
            return Ok(value);
        }
        let value = work()?;
        // The records of this module are plain structs of numbers, text and lists, which can always be written as JSON.
        if let Ok(record) = serde_json::to_vec(&value) {
            self.journal.put(key, &record)?;
        }
        Ok(value)
    }
}

/// A journal that stores nothing.
struct Forgetful;

impl Journal for Forgetful {
    fn get(&self, _key: &str) -> Option<Vec<u8>> {
        None
    }

    fn put(&self, _key: &str, _record: &[u8]) -> Result<(), JournalError> {
        Ok(())
    }
}

/// A journal that ends the run once `check` fails, because later results are worthless or unwanted.
#[derive(Clone, Copy)]
pub struct GuardedJournal<'a> {
    /// The journal that keeps the records.
    pub journal: &'a dyn Journal,
    /// Asked before a record is stored; its error ends the run.
    pub check: &'a (dyn Fn() -> Result<(), JournalError> + Sync),
}

impl std::fmt::Debug for GuardedJournal<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (formatter.debug_struct("GuardedJournal")).finish_non_exhaustive()
    }
}

impl Journal for GuardedJournal<'_> {
    fn get(&self, key: &str) -> Option<Vec<u8>> {
        self.journal.get(key)
    }

    fn put(&self, key: &str, record: &[u8]) -> Result<(), JournalError> {
        (self.check)()?;
        self.journal.put(key, record)
    }
}

/// A journal whose keys have a prefix of their own, so that several rounds of the same tasks can share a journal.
pub(crate) struct Prefixed<'a> {
    pub(crate) journal: &'a dyn Journal,
    pub(crate) prefix: &'a str,
}

impl Journal for Prefixed<'_> {
    fn get(&self, key: &str) -> Option<Vec<u8>> {
        self.journal.get(&format!("{}{key}", self.prefix))
    }

    fn put(&self, key: &str, record: &[u8]) -> Result<(), JournalError> {
        self.journal.put(&format!("{}{key}", self.prefix), record)
    }
}

/// A journal in memory.
#[derive(Debug, Default)]
pub struct MemoryJournal {
    records: Mutex<BTreeMap<String, Vec<u8>>>,
}

impl MemoryJournal {
    /// Number of stored tasks.
    pub fn len(&self) -> usize {
        self.lock().len()
    }

    /// Whether the journal is empty.
    pub fn is_empty(&self) -> bool {
        self.lock().is_empty()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, Vec<u8>>> {
        // Inserts are atomic, so the map stays valid even if another thread panics.
        self.records.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Journal for MemoryJournal {
    fn get(&self, key: &str) -> Option<Vec<u8>> {
        self.lock().get(key).cloned()
    }

    fn put(&self, key: &str, record: &[u8]) -> Result<(), JournalError> {
        self.lock().insert(key.to_owned(), record.to_vec());
        Ok(())
    }
}

/// Stores numbers as integers with the same bits, because JSON has no infinity and readers may round.
pub(super) mod bits {
    pub(crate) mod number {
        use serde::{Deserialize, Deserializer, Serialize, Serializer};

        #[expect(
            clippy::trivially_copy_pass_by_ref,
            reason = "serde hands fields over by reference"
        )]
        pub(crate) fn serialize<S: Serializer>(
            value: &f64,
            serializer: S,
        ) -> Result<S::Ok, S::Error> {
            value.to_bits().serialize(serializer)
        }

        pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
            deserializer: D,
        ) -> Result<f64, D::Error> {
            u64::deserialize(deserializer).map(f64::from_bits)
        }
    }

    pub(crate) mod list {
        use serde::{Deserialize, Deserializer, Serialize, Serializer};

        pub(crate) fn serialize<S: Serializer>(
            values: &[f64],
            serializer: S,
        ) -> Result<S::Ok, S::Error> {
            let bits: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
            bits.serialize(serializer)
        }

        pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
            deserializer: D,
        ) -> Result<Vec<f64>, D::Error> {
            let bits = Vec::<u64>::deserialize(deserializer)?;
            Ok(bits.into_iter().map(f64::from_bits).collect())
        }
    }

    pub(crate) mod points {
        use serde::{Deserialize, Deserializer, Serialize, Serializer};

        pub(crate) fn serialize<S: Serializer>(
            points: &[Vec<f64>],
            serializer: S,
        ) -> Result<S::Ok, S::Error> {
            let bits = |point: &Vec<f64>| point.iter().map(|value| value.to_bits()).collect();
            let bits: Vec<Vec<u64>> = points.iter().map(bits).collect();
            bits.serialize(serializer)
        }

        pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
            deserializer: D,
        ) -> Result<Vec<Vec<f64>>, D::Error> {
            let bits = Vec::<Vec<u64>>::deserialize(deserializer)?;
            let point = |bits: Vec<u64>| bits.into_iter().map(f64::from_bits).collect();
            Ok(bits.into_iter().map(point).collect())
        }
    }

    pub(crate) mod options {
        use serde::{Deserialize, Deserializer, Serialize, Serializer};

        pub(crate) fn serialize<S: Serializer>(
            values: &[Option<f64>],
            serializer: S,
        ) -> Result<S::Ok, S::Error> {
            let bits: Vec<Option<u64>> = values.iter().map(|v| v.map(f64::to_bits)).collect();
            bits.serialize(serializer)
        }

        pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
            deserializer: D,
        ) -> Result<Vec<Option<f64>>, D::Error> {
            let bits = Vec::<Option<u64>>::deserialize(deserializer)?;
            Ok(bits.into_iter().map(|v| v.map(f64::from_bits)).collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Serialize, Deserialize)]
    struct Record {
        #[serde(with = "bits::number")]
        one: f64,
        #[serde(with = "bits::options")]
        some: Vec<Option<f64>>,
    }

    #[test]
    fn every_bit_survives() {
        let journal = MemoryJournal::default();
        let run = Run {
            journal: &journal,
            ..Run::default()
        };
        let work = || Record {
            one: f64::INFINITY,
            some: vec![None, Some(0.1 + 0.2)],
        };
        run.remember("a", work).unwrap();
        let again: Record = run
            .remember("a", || unreachable!("it is remembered"))
            .unwrap();
        assert!(again.one.is_infinite());
        assert_eq!(again.some, [None, Some(0.1 + 0.2)]);
    }
}
