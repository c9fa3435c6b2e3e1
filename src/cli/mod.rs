//! The command line. Each subcommand reads, makes one library call, and writes. Data goes to files or standard output, and
//! progress to standard error. A user's mistake ends with one sentence and exit code 1.

use std::borrow::Cow;
use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};

use clap::{CommandFactory, FromArgMatches};
use serde::Serialize;

use crate::printable::{printable, printable_json};

mod args;
mod build;
mod compare;
mod diff;
mod draw;
mod export;
mod hands;
mod import;
mod import_grasps;
mod input;
mod inspect;
mod interruption;
mod label;
mod object_inspect;
mod objects;
mod output;
mod progress;
mod provenance;
mod run;
mod stability;
mod surface;
mod synth;

use args::{Arguments, Command};
use provenance::Provenance;

/// Runs the command line of this process.
pub fn run() -> ExitCode {
    interruption::watch();
    run_with(std::env::args_os())
}

/// Runs a command line, which begins with the program name.
pub fn run_with(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
    let arguments = match parse(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            // Coloured, unless the text quotes control sequences.
            let text = error.render().to_string();
            if matches!(printable(&text, OURS), Cow::Owned(_)) {
                complain(text.trim_end());
                return ExitCode::FAILURE;
            }
            let printed = error.print().and_then(|()| io::stdout().flush());
            if error.use_stderr() {
                return ExitCode::FAILURE;
            }
            note_failure(printed);
            return end(Ok(()));
        }
    };
    let result = arguments
        .common
        .threads()
        .and_then(|()| match &arguments.command {
            Command::Synth(command) => synth::run(command, &arguments.common),
            Command::Build(command) => build::run(command, &arguments.common),
            Command::Inspect(command) => inspect::run(command, &arguments.common),
            Command::Hands(command) => hands::run(&command.command, &arguments.common),
            Command::Stability(command) => stability::run(command, &arguments.common),
            Command::Label(command) => label::run(command, &arguments.common),
            Command::Objects(command) => objects::run(&command.command, &arguments.common),
            Command::Surface(command) => surface::run(command, &arguments.common),
            Command::Draw(command) => draw::run(command, &arguments.common),
            Command::Compare(command) => compare::run(command, &arguments.common),
            Command::Diff(command) => diff::run(command, &arguments.common),
            Command::Import(command) => import::run(command, &arguments.common),
            Command::Export(command) => export::run(command, &arguments.common),
        });
    end(result)
}

/// Exit code after the reader closed the pipe, as for SIGPIPE.
const PIPE_CLOSED: u8 = 141;

/// Prints the error, if any, and returns the exit code.
fn end(result: anyhow::Result<()>) -> ExitCode {
    let unprinted = UNPRINTED
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .take();
    let error = match (result, unprinted) {
        (Ok(()), None) => return ExitCode::SUCCESS,
        (Err(error), _) => error,
        // If the reader closed the pipe, it has read enough.
        (Ok(()), Some(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            return ExitCode::from(PIPE_CLOSED);
        }
        (Ok(()), Some(error)) => {
            anyhow::Error::new(error).context("cannot write to standard output")
        }
    };
    complain(&format!("error: {}", sentence(&error)));
    ExitCode::FAILURE
}

/// The definition of the command line: its subcommands, arguments and flags.
pub fn definition() -> clap::Command {
    let mut definition = Arguments::command();
    definition.build();
    definition
}

fn parse(
    arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>,
) -> Result<Arguments, clap::Error> {
    let mut definition = definition();
    let matches = definition.try_get_matches_from_mut(arguments)?;
    let mut parsed =
        Arguments::from_arg_matches(&matches).map_err(|error| error.format(&mut definition))?;
    parsed.common.provenance = Provenance::of(&definition, &matches);
    Ok(parsed)
}

/// Greatest length of a sentence, in characters.
const LONGEST: usize = 2000;

/// Control characters in the program's own text. All others come from files.
const OURS: &[char] = &['\n', '\t'];

/// An error and its causes without repetitions. Long quotations from files are cut.
fn sentence(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        let cause = cause.trim_end();
        if text.is_empty() {
            cause.clone_into(&mut text);
        } else if !text.ends_with(cause) {
            text.push_str(": ");
            text.push_str(cause);
        }
    }
    let mut short: String = text.chars().take(LONGEST).collect();
    if text.chars().nth(LONGEST).is_some() {
        short.push('…');
    }
    short
}

/// A text that may quote files, made safe for terminals.
fn shown(text: &str) -> String {
    printable(text, OURS).into_owned()
}

/// Writes a line to standard error. A closed terminal is ignored.
fn complain(line: &str) {
    let _ = writeln!(io::stderr(), "{}", printable(line, OURS));
}

/// The first error of standard output. It affects only the exit code, after all files are written.
static UNPRINTED: Mutex<Option<io::Error>> = Mutex::new(None);

fn note_failure(printed: io::Result<()>) {
    if let Err(error) = printed {
        let mut first = UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert(error);
    }
}

fn print(text: &str) {
    let mut output = io::stdout();
    let printed = writeln!(output, "{}", printable(text.trim_end(), OURS));
    note_failure(printed.and_then(|()| output.flush()));
}

/// Prints a JSON document to standard output.
fn print_json(document: &impl Serialize) -> anyhow::Result<()> {
    print(&printable_json(&serde_json::to_string_pretty(document)?));
    Ok(())
}

#[cfg(test)]
mod tests {
    /// A megabyte of a broken file, with a sequence that clears the screen.
    #[test]
    fn sentences_are_short_and_harmless() {
        let text = format!("no number: `\u{1b}[2J{}`", "0".repeat(1 << 20));
        let sentence = super::sentence(&anyhow::anyhow!(text));
        assert_eq!(sentence.chars().count(), 2001);
        let shown = super::printable(&sentence, super::OURS);
        assert!(shown.starts_with("no number: `\u{fffd}[2J000") && !shown.contains('\u{1b}'));
    }
}
