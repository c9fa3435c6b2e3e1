//! Handles interruptions of a run: tells what is kept and how to continue.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::topography::JournalError;

/// The journal of this process's current run.
static JOURNAL: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Whether the caller of [`call`](super::call) wants it to end.
static STOPPED: AtomicBool = AtomicBool::new(false);

/// Asks the current [`call`](super::call) to end, or lets the next one run.
pub(super) fn set_stopped(stopped: bool) {
    STOPPED.store(stopped, Ordering::Relaxed);
}

/// An error once the caller wants the run to end.
pub(super) fn check() -> Result<(), JournalError> {
    if STOPPED.load(Ordering::Relaxed) {
        let told: Box<dyn std::error::Error + Send + Sync> =
            "interrupted: finished tasks are kept, and the same call goes on from there".into();
        return Err(told.into());
    }
    Ok(())
}

/// Stores the journal that an interruption leaves behind.
pub(super) fn keeps(journal: &Path) {
    *JOURNAL.lock().unwrap_or_else(PoisonError::into_inner) = Some(journal.to_path_buf());
}

/// Exit code after SIGTERM if the same command goes on from the finished tasks: `EX_TEMPFAIL`, "try again". Schedulers of
/// clusters send this signal before they take the machine away, and can requeue a job that ends with this code.
#[cfg(unix)]
const RESUMABLE: i32 = 75;

/// Message to the user who interrupts, and whether the same command goes on from finished tasks.
#[cfg(unix)]
fn farewell() -> (String, bool) {
    let journal = JOURNAL.lock().unwrap_or_else(PoisonError::into_inner);
    match journal.as_deref().filter(|path| path.exists()) {
        Some(journal) => (
            format!(
                "interrupted: finished tasks are kept in {}; the same command goes on from there (--fresh starts over)",
                journal.display()
            ),
            true,
        ),
        None => ("interrupted: nothing was written".to_owned(), false),
    }
}

/// Makes SIGINT and SIGTERM end the process with a message. The exit code is the one that shells expect (128 + signal
/// number), except that SIGTERM ends a run that can be continued with 75.
/// Signals that were ignored at the start (by `nohup`, or for background jobs) stay ignored.
#[cfg(unix)]
pub(super) fn watch() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let ignored = ignored();
    let wanted = [SIGINT, SIGTERM]
        .into_iter()
        .filter(|signal| ignored >> (signal - 1) & 1 == 0);
    // Without the handler a signal ends the process without a message.
    let Ok(mut signals) = Signals::new(wanted) else {
        return;
    };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            super::progress::without_bars(|| {
                let (line, resumable) = farewell();
                super::printing::complain(&line);
                std::process::exit(if resumable && signal == SIGTERM {
                    RESUMABLE
                } else {
                    128 + signal
                });
            });
        }
    });
}

/// Bit mask of the signals that this process was started to ignore, lowest bit first, from Linux's procfs; 0 elsewhere.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

/// Other systems keep the default behaviour.
#[cfg(not(unix))]
pub(super) fn watch() {}
