//! What the command line prints: texts to standard output, lines for the person at the terminal to standard error.

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::Serialize;
use serde_json::{Value, json};

use super::args::{Common, LogFormat};
use crate::printable::{self, printable, printable_json};
use crate::store::LandscapeFiles;

/// Control characters in the program's own text. All others come from files.
pub(super) const OURS: &[char] = &['\n', '\t'];

/// An error and its causes without repetitions. Long quotations from files are cut.
pub(super) fn sentence(error: &anyhow::Error) -> String {
    printable::sentence(error.as_ref())
}

/// A text that may quote files, made safe for terminals.
pub(super) fn shown(text: &str) -> String {
    printable(text, OURS).into_owned()
}

/// Writes a line to standard error, or with `--log-format json` a JSON document. A closed terminal is ignored.
pub(super) fn complain(line: &str) {
    if SAID.iter().any(|level| line.starts_with(level)) {
        let mut given = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
        given.insert(line.to_owned());
    }
    if !LOG_AS_JSON.load(Ordering::Relaxed) {
        let _ = writeln!(io::stderr(), "{}", printable(line, OURS));
        return;
    }
    let (level, message) = ["error", "warning", "note"]
        .iter()
        .find_map(|level| Some((*level, line.strip_prefix(level)?.strip_prefix(": ")?)))
        .unwrap_or(("info", line));
    log(level, json!({ "message": shown(message) }));
}

/// Writes a JSON document of one line to standard error.
pub(super) fn log(level: &str, mut document: Value) {
    document["level"] = level.into();
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    document["unix_seconds"] = json!((1e3 * since.unwrap_or_default().as_secs_f64()).round() / 1e3);
    let _ = writeln!(io::stderr(), "{document}");
}

/// Whether lines on standard error are JSON documents (`--log-format json`).
static LOG_AS_JSON: AtomicBool = AtomicBool::new(false);

/// Whether lines on standard error are JSON documents.
pub(super) fn logs_json() -> bool {
    LOG_AS_JSON.load(Ordering::Relaxed)
}

/// Whether standard output holds one JSON document instead of texts (`--json`).
static AS_JSON: AtomicBool = AtomicBool::new(false);

/// Whether standard error also says what is done, and why (`--verbose`).
static VERBOSE: AtomicBool = AtomicBool::new(false);

/// Warnings of the present command, each of which is written once, and the lines that say them or a note.
static WARNINGS: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// Beginnings of lines that texts do not repeat.
const SAID: [&str; 2] = ["warning: ", "note: "];

/// Whether the present command did not give this warning before.
pub(super) fn is_new_warning(warning: &str) -> bool {
    let mut given = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
    given.insert(warning.to_owned())
}

/// Sets what is printed by the command that begins.
pub(super) fn begin(common: &Common) {
    let mut given = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
    given.clear();
    drop(given);
    AS_JSON.store(common.json, Ordering::Relaxed);
    VERBOSE.store(common.verbose, Ordering::Relaxed);
    LOG_AS_JSON.store(common.log_format == LogFormat::Json, Ordering::Relaxed);
}

/// Writes a line about what is being done to standard error, if the user wants to know (`--verbose`).
pub(super) fn explain(line: impl FnOnce() -> String) {
    if !VERBOSE.load(Ordering::Relaxed) {
        return;
    }
    if logs_json() {
        log("detail", json!({ "message": shown(&line()) }));
    } else {
        complain(&line());
    }
}

/// Says which settings hold, by the names that a file for `--config` has, if the user wants to know.
pub(super) fn explain_settings(what: &str, settings: &impl Serialize) {
    explain(|| {
        let settings = serde_json::to_string(settings).unwrap_or_default();
        format!("{what}: {settings}")
    });
}

/// The first error of standard output. It affects only the exit code, after all files are written.
static UNPRINTED: Mutex<Option<io::Error>> = Mutex::new(None);

pub(super) fn note_failure(printed: io::Result<()>) {
    if let Err(error) = printed {
        let mut first = UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert(error);
    }
}

/// What was printed for a caller inside this process, if one takes it instead of standard output.
static TAKEN: Mutex<Option<String>> = Mutex::new(None);

/// Runs `work`; returns what it printed in place of writing it to standard output. One call at a time.
pub(super) fn taking<T>(work: impl FnOnce() -> T) -> (T, String) {
    let taken = || TAKEN.lock().unwrap_or_else(PoisonError::into_inner);
    *taken() = Some(String::new());
    let done = work();
    let text = taken().take().unwrap_or_default();
    (done, text)
}

/// Prints a text to standard output, unless this is to hold a JSON document.
pub(super) fn print(text: &str) {
    if !AS_JSON.load(Ordering::Relaxed) {
        put(text);
    }
}

fn put(text: &str) {
    let text = printable(text.trim_end(), OURS);
    if text.is_empty() {
        return;
    }
    if let Some(taken) = &mut *TAKEN.lock().unwrap_or_else(PoisonError::into_inner) {
        taken.push_str(&text);
        taken.push('\n');
        return;
    }
    let mut output = io::stdout();
    let printed = writeln!(output, "{text}");
    note_failure(printed.and_then(|()| output.flush()));
}

/// Why standard output could not be written, if it could not; asked once, at the end.
pub(super) fn take_failure() -> Option<io::Error> {
    let mut first = UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner);
    first.take()
}

/// Prints a JSON document to standard output. docs/scripts.md describes the documents of all commands.
pub(super) fn print_json(document: &impl Serialize) -> anyhow::Result<()> {
    put(&printable_json(&serde_json::to_string_pretty(document)?));
    Ok(())
}

/// Prints the report of a command: the JSON document, or a text made from it.
pub(super) fn tell(common: &Common, report: &impl Serialize) -> anyhow::Result<()> {
    if common.json {
        return print_json(report);
    }
    print(&text_of(serde_json::to_value(report)?));
    Ok(())
}

/// The text of a report, without what warnings and notes have said already.
fn text_of(mut report: Value) -> String {
    let given = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
    let unsaid = |value: &Value| {
        let said = |text: &str| {
            SAID.iter()
                .any(|level| given.contains(&format!("{level}{text}")))
        };
        !value.as_str().is_some_and(said)
    };
    if let Value::Object(entries) = &mut report {
        entries.retain(|_, value| unsaid(value));
        for items in entries.values_mut().filter_map(Value::as_array_mut) {
            items.retain(unsaid);
        }
    }
    super::text::text(&report)
}

/// Prints the report of a command that wrote `written`; a quiet one prints the JSON document only.
pub(super) fn tell_written(
    common: &Common,
    report: &impl Serialize,
    written: &str,
) -> anyhow::Result<()> {
    let report = serde_json::to_value(report)?;
    let text = text_of(report.clone());
    tell_text(common, (&text, &report), Some(written))
}

/// Prints a report with a text of its own: a quiet command prints the JSON document only. Says what was written.
pub(super) fn tell_text(
    common: &Common,
    (text, report): (&str, &Value),
    written: Option<&str>,
) -> anyhow::Result<()> {
    if common.json {
        print_json(report)?;
    }
    if !common.quiet {
        print(text);
        if let Some(written) = written {
            complain(&format!("wrote {written}"));
        }
    }
    Ok(())
}

/// Says what was written. The JSON document, if one is wanted, has the path.
pub(super) fn tell_path(common: &Common, path: &Path) -> anyhow::Result<()> {
    tell_written(
        common,
        &json!({ "wrote": [path] }),
        &path.display().to_string(),
    )
}

/// Prints what JSON documents tell of finished landscapes, if one is wanted. The rest is in their landscape.json.
pub(super) fn print_landscapes(common: &Common, folders: &[PathBuf]) -> anyhow::Result<()> {
    if !common.json {
        return Ok(());
    }
    let told = |folder: &PathBuf| {
        let manifest = LandscapeFiles::read(folder)?.manifest;
        Ok(json!({
            "folder": folder,
            "counts": manifest.counts,
            "evidence": manifest.evidence,
            "family_barrier": manifest.family_barrier,
            "letting_go": manifest.letting_go,
            "warnings": manifest.warnings,
        }))
    };
    let landscapes: Vec<Value> = folders.iter().map(told).collect::<anyhow::Result<_>>()?;
    print_json(&json!({ "landscapes": landscapes }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_do_not_repeat_warnings() {
        complain("warning: a hole was closed");
        complain("note: the left hand");
        let report = json!({
            "doubt": "the left hand",
            "notes": ["a hole was closed", "two pieces"],
            "pieces": 2,
        });
        assert_eq!(text_of(report), "pieces  2\nnotes   two pieces\n");
    }

    /// A megabyte of a broken file, with a sequence that clears the screen.
    #[test]
    fn sentences_are_short_and_harmless() {
        let text = format!("no number: `\u{1b}[2J{}`", "0".repeat(1 << 20));
        let sentence = sentence(&anyhow::anyhow!(text));
        assert_eq!(sentence.chars().count(), 2001);
        let shown = printable(&sentence, OURS);
        assert!(shown.starts_with("no number: `\u{fffd}[2J000") && !shown.contains('\u{1b}'));
    }
}
