//! Progress on standard error: bars at a terminal, occasional lines elsewhere.

use std::io::IsTerminal;
use std::ops::Deref;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use crate::cli::printing::{complain, log, logs_json};

/// Time before the first line if standard error is a file or a pipe, and longest time between two lines. In between, the time
/// is this share of what has passed, so that a log of a long run stays short.
const FIRST: Duration = Duration::from_secs(5);
const LONGEST: Duration = Duration::from_mins(1);
const SHARE: f64 = 0.1;

/// All bars, so that they can be removed from the terminal.
static BARS: LazyLock<MultiProgress> = LazyLock::new(MultiProgress::new);

/// Whether bars are shown although nothing else is.
static WANTED: AtomicBool = AtomicBool::new(false);

/// Shows bars, or none, of a run that is quiet otherwise.
pub(super) fn want_bars(wanted: bool) {
    WANTED.store(wanted, Ordering::Relaxed);
}

/// Runs `work` while no bar is on the terminal and none can appear.
pub(super) fn without_bars<T>(work: impl FnOnce() -> T) -> T {
    BARS.suspend(work)
}

/// A progress bar. Without a terminal, it prints lines until it is finished or dropped.
pub(super) struct Bar {
    bar: ProgressBar,
    lines: Option<Lines>,
}

impl Deref for Bar {
    type Target = ProgressBar;

    fn deref(&self) -> &ProgressBar {
        &self.bar
    }
}

impl Bar {
    /// Removes the bar and ends its lines.
    pub(super) fn finish_and_clear(self) {
        self.bar.finish_and_clear();
    }
}

/// A bar for `total` items called `what`; hidden without a terminal.
pub(super) fn bar(what: &str, total: u64, quiet: bool) -> Bar {
    let quiet = quiet && !WANTED.load(Ordering::Relaxed);
    let bar = if quiet || logs_json() {
        ProgressBar::hidden()
    } else {
        BARS.add(ProgressBar::new(total))
    };
    let style =
        ProgressStyle::with_template("{msg:>24} {bar:32} {pos}/{len} in {elapsed}, {eta} left")
            .expect("the template is a constant")
            .progress_chars("━╸ ");
    bar.set_style(style);
    bar.set_length(total);
    bar.set_message(what.to_owned());
    let lines = (!quiet && (logs_json() || !std::io::stderr().is_terminal())).then(|| {
        Lines::start(FIRST, bar.clone(), |bar| {
            if logs_json() {
                log("progress", document(bar));
            } else {
                complain(&line(bar));
            }
        })
    });
    Bar { bar, lines }
}

pub(super) fn spinner(what: &str, quiet: bool) -> Bar {
    let quiet = quiet && !WANTED.load(Ordering::Relaxed);
    let bar = bar(what, 0, quiet);
    bar.set_style(
        ProgressStyle::with_template("{msg:>24} {spinner} {elapsed}")
            .expect("the template is a constant"),
    );
    if !quiet && bar.lines.is_none() {
        bar.enable_steady_tick(Duration::from_millis(200));
    }
    bar
}

/// A thread that prints the state of a bar until dropped.
struct Lines {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Lines {
    fn start(
        first: Duration,
        bar: ProgressBar,
        say: impl Fn(&ProgressBar) + Send + 'static,
    ) -> Self {
        let (stop, stopped) = channel();
        let thread = std::thread::spawn(move || {
            let mut period = first;
            while stopped.recv_timeout(period) == Err(RecvTimeoutError::Timeout) {
                say(&bar);
                period = bar.elapsed().mul_f64(SHARE).clamp(first, LONGEST);
            }
        });
        Self {
            stop: Some(stop),
            thread: Some(thread),
        }
    }
}

impl Drop for Lines {
    fn drop(&mut self) {
        // Dropping the sender wakes and ends the thread.
        self.stop.take();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// A line such as `chains: 12 of 64 in 3 minutes`.
pub(super) fn line(bar: &ProgressBar) -> String {
    let elapsed = HumanDuration(bar.elapsed());
    match bar.length() {
        Some(total @ 1..) => {
            format!(
                "{}: {} of {total} in {elapsed}",
                bar.message(),
                bar.position()
            )
        }
        _ => format!("{}: {elapsed} so far", bar.message()),
    }
}

/// The same as a JSON document.
fn document(bar: &ProgressBar) -> Value {
    let total = bar.length().filter(|total| *total > 0);
    let done = bar.position();
    let elapsed = bar.elapsed().as_secs_f64();
    let left = total.filter(|_| done > 0).map(|total| {
        let rate = done as f64 / elapsed;
        total.saturating_sub(done) as f64 / rate
    });
    json!({
        "what": bar.message(),
        "done": total.map(|_| done),
        "total": total,
        "elapsed_s": elapsed,
        "left_s": left,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn lines_are_told_until_the_work_is_done() {
        let bar = ProgressBar::hidden();
        bar.set_length(8);
        bar.set_message("grasps");
        bar.set_position(3);
        let (sender, told) = channel();
        let lines = Lines::start(Duration::from_millis(1), bar.clone(), move |bar| {
            let _ = sender.send((super::line(bar), document(bar)));
        });
        let (line, document) = told.recv().unwrap();
        assert!(line.starts_with("grasps: 3 of 8 in "), "{line}");
        assert_eq!(
            (&document["what"], &document["done"], &document["total"]),
            (&json!("grasps"), &json!(3), &json!(8))
        );
        assert!(document["left_s"].is_number(), "{document}");
        bar.set_position(4);
        assert!(
            told.iter()
                .any(|(line, _)| line.starts_with("grasps: 4 of 8 in "))
        );
        drop(lines);
        // The thread and its sender have ended.
        assert!(told.iter().all(|(line, _)| line.starts_with("grasps: ")));
        bar.set_length(0);
        assert!(super::line(&bar).ends_with("so far"));
    }
}
