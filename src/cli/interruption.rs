//! What happens when a person or a scheduler ends a run: it says what is kept and how to go on.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The journal of the run that this process is at.
static JOURNAL: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Remembers the journal whose tasks an interruption leaves.
pub(super) fn keeps(journal: &Path) {
    *JOURNAL.lock().unwrap_or_else(PoisonError::into_inner) = Some(journal.to_path_buf());
}

/// What is said to the person who interrupts.
#[cfg(unix)]
fn farewell() -> String {
    let journal = JOURNAL.lock().unwrap_or_else(PoisonError::into_inner);
    match journal.as_deref().filter(|path| path.exists()) {
        Some(journal) => format!(
            "interrupted: finished tasks are kept in {}; the same command goes on from there (with --fresh it begins anew)",
            journal.display()
        ),
        None => "interrupted: nothing was written".to_owned(),
    }
}

/// From now on SIGINT and SIGTERM end the process with a sentence and the exit code that shells expect, 128 + the
/// signal's number. What was told to be ignored (by `nohup`, or by a shell for a job in the background) stays ignored.
#[cfg(unix)]
pub(super) fn watch() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let ignored = ignored();
    let wanted = [SIGINT, SIGTERM]
        .into_iter()
        .filter(|signal| ignored >> (signal - 1) & 1 == 0);
    // Without the handler a signal ends the process as well, only without a word.
    let Ok(mut signals) = Signals::new(wanted) else {
        return;
    };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            super::progress::without_bars(|| {
                super::complain(&farewell());
                std::process::exit(128 + signal);
            });
        }
    });
}

/// Signals that this process was started to ignore, one bit each from the lowest, as Linux tells them; elsewhere none.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

/// Elsewhere signals do what they always do.
#[cfg(not(unix))]
pub(super) fn watch() {}
