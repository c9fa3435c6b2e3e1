//! What every long run needs: a journal on disk, a progress bar, a stopwatch.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use indicatif::ProgressBar;

use super::progress;
use crate::store::{Journal, Phase as Timing, StoreError, Timings};
use crate::topography::{self, Phase, Progress};

/// The journal on disk as the map sees it; the first failure to write is kept for the end.
pub(super) struct DiskJournal<'a> {
    journal: &'a Journal,
    failure: Mutex<Option<StoreError>>,
}

impl<'a> DiskJournal<'a> {
    pub(super) fn new(journal: &'a Journal) -> Self {
        Self {
            journal,
            failure: Mutex::new(None),
        }
    }

    /// The first failure to write, if there was one.
    pub(super) fn check(&self) -> Result<(), StoreError> {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.take().map_or(Ok(()), Err)
    }
}

impl topography::Journal for DiskJournal<'_> {
    fn get(&self, key: &str) -> Option<Vec<u8>> {
        self.journal.get(key)
    }

    fn put(&self, key: &str, record: &[u8]) {
        if let Err(error) = self.journal.put(key, record) {
            self.failure
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .get_or_insert(error);
        }
    }
}

/// Progress bar and stopwatch.
pub(super) struct Watch {
    quiet: bool,
    bar: Mutex<Option<(Phase, ProgressBar)>>,
    started: Instant,
    phases: Vec<Timing>,
}

impl Watch {
    pub(super) fn new(quiet: bool) -> Self {
        Self {
            quiet,
            bar: Mutex::new(None),
            started: Instant::now(),
            phases: Vec::new(),
        }
    }

    pub(super) fn see(&self, news: Progress) {
        let mut bar = self.bar.lock().unwrap_or_else(PoisonError::into_inner);
        let total = news.total as u64;
        let same = bar
            .as_ref()
            .is_some_and(|(phase, bar)| *phase == news.phase && bar.length() == Some(total));
        if !same {
            if let Some((_, old)) = bar.take() {
                old.finish_and_clear();
            }
            let what = match news.phase {
                Phase::Quench => "descending",
                Phase::Connect => "connecting pairs",
                Phase::Join => "joining components",
                Phase::Retry => "improving merges",
                Phase::Diagram => "measuring the diagram",
                Phase::Assign => "assigning minima",
                Phase::Replicate => "repeating chains",
                Phase::Search => "searching saddles",
                _ => "searching",
            };
            *bar = Some((news.phase, progress::bar(what, total, self.quiet)));
        }
        if let Some((_, bar)) = bar.as_ref() {
            bar.set_position(news.done as u64);
        }
    }

    pub(super) fn lap(&mut self, name: &str, evaluations: usize) {
        if let Some((_, bar)) = self
            .bar
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner)
            .take()
        {
            bar.finish_and_clear();
        }
        let before: f64 = self.phases.iter().map(|phase| phase.seconds).sum();
        self.phases.push(Timing {
            name: name.to_owned(),
            seconds: self.started.elapsed().as_secs_f64() - before,
            evaluations: evaluations as u64,
        });
    }

    pub(super) fn timings(self) -> Timings {
        Timings {
            threads: rayon::current_num_threads(),
            phases: self.phases,
        }
    }
}

/// How often each name occurs, most frequent first.
pub(super) fn tally<'a>(names: impl Iterator<Item = &'a str>) -> Vec<(String, usize)> {
    let mut counts = BTreeMap::new();
    for name in names {
        *counts.entry(name.to_owned()).or_insert(0) += 1;
    }
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
    counts
}
