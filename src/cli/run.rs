//! Common parts of long runs: a journal on disk, a progress bar, a stopwatch.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::args::Again;
use super::{interruption, progress};
use crate::cli::printing::{complain, explain, print};
use crate::printable::counted;
use crate::store::{AtomicFolder, Journal, Machine, Phase as Timing, StoreError, Timings};
use crate::topography::{self, GuardedJournal, Phase, Progress, Run};

/// The folder of a run with its journal.
pub(super) struct Unfinished {
    pub(super) folder: AtomicFolder,
    pub(super) journal: Journal,
}

impl Unfinished {
    /// Begins or continues the folder for `output`.
    pub(super) fn open(
        output: &Path,
        fingerprint: &str,
        again: &Again,
        quiet: bool,
    ) -> Result<Self, StoreError> {
        let folder = AtomicFolder::open(output, again.fresh)?;
        let path = folder.journal();
        match open(&path, fingerprint, again, quiet) {
            Ok(journal) => Ok(Self { folder, journal }),
            Err(error) => {
                // Without a journal nothing can be resumed.
                if !path.exists() {
                    let _ = folder.discard();
                }
                Err(error)
            }
        }
    }

    /// Writes the timings, gives the folder its final name, and shows what `told` makes of this name.
    pub(super) fn conclude(
        self,
        watch: Watch,
        told: impl FnOnce(&Path) -> String,
    ) -> anyhow::Result<()> {
        let quiet = watch.quiet;
        let finished = self.finish(watch)?;
        if !quiet {
            print(&told(&finished));
            complain(&format!("wrote {}", finished.display()));
        }
        Ok(())
    }

    /// Writes the timings and gives the folder its final name.
    pub(super) fn finish(self, watch: Watch) -> Result<PathBuf, StoreError> {
        watch.lap("write", 0);
        watch.timings().write(&self.folder)?;
        // The lock is held to the very end, except on Windows, where an open file prevents renaming its folder.
        let lock = (!cfg!(windows)).then_some(self.journal);
        let finished = self.folder.finish()?;
        drop(lock);
        Ok(finished)
    }

    /// Removes the folder and the journal.
    pub(super) fn discard(self) -> Result<(), StoreError> {
        self.journal.remove()?;
        self.folder.discard()
    }
}

/// With `--resume`, rejects a start if none of these folders has an interrupted run.
pub(super) fn check_resumable(again: &Again, outputs: &[PathBuf]) -> anyhow::Result<()> {
    let left = |output: &PathBuf| AtomicFolder::left_journal(output).is_some();
    anyhow::ensure!(
        !again.resume || outputs.iter().any(left),
        "--resume: no interrupted run has left a journal for {}: begin one without --resume",
        outputs
            .first()
            .map_or(Path::new("."), PathBuf::as_path)
            .display()
    );
    Ok(())
}

/// Path of the journal of a run that writes the file `output`, beside this file.
pub(super) fn journal_beside(output: &Path) -> PathBuf {
    let mut path = output.as_os_str().to_owned();
    path.push(".partial");
    path.into()
}

/// Does `work` with a run that keeps its finished tasks beside the file `output`, and shows its progress unless `quiet`. The
/// journal is to be removed when the output is written.
pub(super) fn resumable<T>(
    output: &Path,
    fingerprint: &str,
    again: &Again,
    quiet: bool,
    work: impl FnOnce(&Run<'_>) -> anyhow::Result<T>,
) -> anyhow::Result<(T, Journal)> {
    let journal = open_journal(output, fingerprint, again, quiet)?;
    let watch = Watch::new(quiet);
    let found = work(&Run {
        journal: &stoppable(&journal),
        observer: &|news| watch.see(news),
        ..Run::default()
    })?;
    watch.clear();
    Ok((found, journal))
}

/// Opens the journal of a run that writes the file `output`.
pub(super) fn open_journal(
    output: &Path,
    fingerprint: &str,
    again: &Again,
    quiet: bool,
) -> anyhow::Result<Journal> {
    let path = journal_beside(output);
    anyhow::ensure!(
        !again.resume || path.is_file(),
        "--resume: there is no {}, so no interrupted run: begin one without --resume",
        path.display()
    );
    Ok(open(&path, fingerprint, again, quiet)?)
}

/// Opens the journal at `path`.
fn open(path: &Path, fingerprint: &str, again: &Again, quiet: bool) -> Result<Journal, StoreError> {
    let journal = Journal::open(path, fingerprint, again.fresh)?;
    interruption::keeps(path);
    tell(&journal, path, quiet);
    Ok(journal)
}

/// Tells what the journal already contains.
fn tell(journal: &Journal, path: &Path, quiet: bool) {
    explain(|| {
        format!(
            "finished tasks are kept in {}, so that the same command continues after an interruption",
            path.display()
        )
    });
    if quiet {
        return;
    }
    let path = path.display();
    if !journal.is_empty() {
        complain(&format!(
            "continuing an interrupted run: {} finished tasks in {path}",
            journal.len()
        ));
    }
    if journal.dropped_bytes() > 0 {
        complain(&format!(
            "warning: the last {} bytes of {path} are torn or damaged: the tasks in them are done again",
            journal.dropped_bytes()
        ));
    }
}

/// The journal of a run that a caller may end ([`stop`](super::stop)).
pub(super) fn stoppable(journal: &dyn topography::Journal) -> GuardedJournal<'_> {
    GuardedJournal {
        journal,
        check: &interruption::check,
    }
}

/// What a bar counts: a phase, or one of its rounds.
type Stage = (Phase, Option<(usize, usize)>);

/// Progress bars of a run on standard error, and its stopwatch.
pub struct Watch {
    quiet: bool,
    bar: Mutex<Option<(Stage, progress::Bar)>>,
    started: Instant,
    phases: Mutex<Vec<Timing>>,
}

impl std::fmt::Debug for Watch {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut shown = formatter.debug_struct("Watch");
        shown.field("quiet", &self.quiet).finish_non_exhaustive()
    }
}

impl Watch {
    /// Starts the stopwatch; nothing is shown if `quiet`.
    pub fn new(quiet: bool) -> Self {
        Self {
            quiet,
            bar: Mutex::new(None),
            started: Instant::now(),
            phases: Mutex::default(),
        }
    }

    /// Does `work` with a run that keeps nothing, and shows its progress unless `quiet`.
    pub(super) fn over<T>(quiet: bool, work: impl FnOnce(&Run<'_>) -> T) -> T {
        let watch = Self::new(quiet);
        let run = Run {
            observer: &|news| watch.see(news),
            ..Run::default()
        };
        let done = work(&run);
        watch.clear();
        done
    }

    /// Shows progress; called from any thread.
    pub fn see(&self, news: Progress) {
        let mut bar = self.bar.lock().unwrap_or_else(PoisonError::into_inner);
        let (total, stage) = (news.total as u64, (news.phase, news.round));
        // A total that grows, as that of a search, belongs to the same work. Another round of a phase begins again.
        let same = bar.as_ref().is_some_and(|(before, bar)| {
            let goes_on = news.done as u64 >= bar.position();
            *before == stage && (goes_on || bar.length() == Some(total))
        });
        if !same {
            if let Some((_, old)) = bar.take() {
                old.finish_and_clear();
            }
            let what = match news.round {
                Some((round, most @ 2..)) => {
                    format!("{}, round {round} of at most {most}", news.phase.name())
                }
                _ => news.phase.name().to_owned(),
            };
            let shown = if total == 0 {
                progress::spinner(&what, self.quiet)
            } else {
                explain(|| format!("{what}: {}", counted(news.total, "task")));
                progress::bar(&what, total, self.quiet)
            };
            *bar = Some((stage, shown));
        }
        if let Some((_, bar)) = bar.as_ref() {
            bar.set_length(total);
            bar.set_position(news.done as u64);
        }
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        let mut bar = self.bar.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, bar)) = bar.take() {
            bar.finish_and_clear();
        }
    }

    /// Ends a stage.
    pub fn lap(&self, name: &str, evaluations: usize) {
        self.clear();
        let mut phases = self.phases.lock().unwrap_or_else(PoisonError::into_inner);
        let before: f64 = phases.iter().map(|phase| phase.seconds).sum();
        let seconds = self.started.elapsed().as_secs_f64() - before;
        explain(|| {
            format!("stage {name} ended after {seconds:.1} s and {evaluations} evaluations")
        });
        phases.push(Timing {
            name: name.to_owned(),
            seconds,
            evaluations: evaluations as u64,
        });
    }

    /// The stages and their times.
    pub fn timings(self) -> Timings {
        Timings {
            threads: rayon::current_num_threads(),
            machine: Machine::here(),
            phases: (self.phases.into_inner()).unwrap_or_else(PoisonError::into_inner),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With a bar for each total, a long search in small rounds never printed a line.
    #[test]
    fn a_growing_total_keeps_the_bar() {
        let watch = Watch::new(true);
        let see = |phase, done, total| {
            watch.see(Progress {
                phase,
                done,
                total,
                round: None,
            });
        };
        let state = || {
            let bar = watch.bar.lock().unwrap();
            let (_, bar) = bar.as_ref().unwrap();
            (bar.message(), bar.position(), bar.length())
        };
        see(Phase::Search, 3, 10);
        watch
            .bar
            .lock()
            .unwrap()
            .as_ref()
            .unwrap()
            .1
            .set_message("the first bar");
        see(Phase::Search, 10, 40);
        assert_eq!(state(), ("the first bar".to_owned(), 10, Some(40)));
        // Another thread reports late.
        see(Phase::Search, 9, 40);
        assert_eq!(state().0, "the first bar");
        for (phase, done, total) in [(Phase::Search, 0, 8), (Phase::Retry, 0, 8)] {
            see(phase, done, total);
            assert_eq!(state(), (phase.name().to_owned(), 0, Some(8)));
        }
    }

    /// Rounds of one phase have totals of their own, and without their numbers no end can be guessed.
    #[test]
    fn a_bar_names_its_round_and_the_last_one() {
        let watch = Watch::new(true);
        let phase = Phase::Retry;
        for (round, done, total, message) in [
            ((1, 4), 3, 9, "improving merges, round 1 of at most 4"),
            ((2, 4), 3, 9, "improving merges, round 2 of at most 4"),
            ((1, 1), 5, 9, "improving merges"),
        ] {
            let round = Some(round);
            watch.see(Progress {
                phase,
                done,
                total,
                round,
            });
            let bar = watch.bar.lock().unwrap();
            assert_eq!(bar.as_ref().unwrap().1.message(), message);
        }
    }

    /// Cutting an object has no count; a bar of 0 would look like no progress.
    #[test]
    fn work_without_a_count_shows_its_time() {
        let watch = Watch::new(true);
        let see = |phase, done, total| {
            watch.see(Progress {
                phase,
                done,
                total,
                round: None,
            });
        };
        let shown = || {
            let bar = watch.bar.lock().unwrap();
            progress::line(&bar.as_ref().unwrap().1)
        };
        see(Phase::Simulate, 0, 21);
        see(Phase::Cut, 0, 0);
        let line = shown();
        assert!(
            line.starts_with("cutting the object into convex pieces, the first time only: ")
                && line.ends_with("so far"),
            "{line}"
        );
        see(Phase::Simulate, 1, 21);
        assert!(shown().starts_with("grasps: 1 of 21 in "));
    }
}
