//! Progress on standard error: bars at a terminal, occasional lines elsewhere.

use std::fmt::Write;
use std::io::IsTerminal;
use std::ops::Deref;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressState, ProgressStyle};
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
    let style = ProgressStyle::with_template("{msg:>24} {bar:32} {pos}/{len} in {spent}{left}")
        .expect("the template is a constant")
        .with_key("spent", |state: &ProgressState, text: &mut dyn Write| {
            let _ = text.write_str(&spelled(state.elapsed()));
        })
        .with_key("left", |state: &ProgressState, text: &mut dyn Write| {
            let left = left(state.pos(), state.len(), state.elapsed());
            let _ = text.write_str(&left.map_or(String::new(), told_left));
        })
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

/// A line such as `chains: 12 of 64 in 3 min 10 s, about 13 min 43 s left`.
pub(super) fn line(bar: &ProgressBar) -> String {
    let elapsed = bar.elapsed();
    match bar.length() {
        Some(total @ 1..) => {
            let left = left(bar.position(), Some(total), elapsed);
            format!(
                "{}: {} of {total} in {}{}",
                bar.message(),
                bar.position(),
                spelled(elapsed),
                left.map_or(String::new(), told_left)
            )
        }
        _ => format!("{}: {} so far", bar.message(), spelled(elapsed)),
    }
}

/// The time that is left at the rate so far, once something is done.
fn left(done: u64, total: Option<u64>, elapsed: Duration) -> Option<Duration> {
    let total = total.filter(|total| *total > 0 && done > 0)?;
    let seconds = elapsed.as_secs_f64() * total.saturating_sub(done) as f64 / done as f64;
    Duration::try_from_secs_f64(seconds).ok()
}

fn told_left(left: Duration) -> String {
    format!(", about {} left", spelled(left))
}

/// A duration in its two largest units: `42 s`, `1 min 40 s`, `3 h 12 min`, `2 d 3 h`.
pub(super) fn spelled(duration: Duration) -> String {
    let units = [(86_400, "d"), (3600, "h"), (60, "min"), (1, "s")];
    let seconds = duration.as_secs_f64().round();
    let seconds = Duration::try_from_secs_f64(seconds)
        .unwrap_or(duration)
        .as_secs();
    let first = units
        .iter()
        .position(|(unit, _)| seconds >= *unit)
        .unwrap_or(3);
    let mut rest = seconds;
    let mut parts = Vec::new();
    for (unit, name) in units.iter().skip(first).take(2) {
        let count = rest / unit;
        rest %= unit;
        if count > 0 || parts.is_empty() {
            parts.push(format!("{count} {name}"));
        }
    }
    parts.join(" ")
}

/// The same as a JSON document.
fn document(bar: &ProgressBar) -> Value {
    let total = bar.length().filter(|total| *total > 0);
    let done = bar.position();
    let elapsed = bar.elapsed();
    let left = left(done, total, elapsed).map(|left| left.as_secs_f64());
    json!({
        "what": bar.message(),
        "done": total.map(|_| done),
        "total": total,
        "elapsed_s": elapsed.as_secs_f64(),
        "left_s": left,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    /// Rounded to minutes, four lines in a row said the same.
    #[test]
    fn times_are_told_in_two_units() {
        for (seconds, text) in [
            (0.2, "0 s"),
            (42.4, "42 s"),
            (60.0, "1 min"),
            (100.0, "1 min 40 s"),
            (3600.0, "1 h"),
            (11_530.0, "3 h 12 min"),
            (183_700.0, "2 d 3 h"),
        ] {
            assert_eq!(spelled(Duration::from_secs_f64(seconds)), text);
        }
        let left = |done| left(done, Some(64), Duration::from_secs(100));
        assert_eq!(left(0), None);
        assert_eq!(told_left(left(16).unwrap()), ", about 5 min left");
        assert_eq!(left(64), Some(Duration::ZERO));
    }

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
