//! The command line: each subcommand reads, makes one library call, writes.
//!
//! Data goes to files or standard output, progress to standard error; a user's mistake ends with one sentence and exit
//! code 1.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

mod args;
mod build;
mod experiment;
mod landscape;
mod models;
mod progress;
mod synth;

use args::{Arguments, Command};

/// Runs the command line of this process.
pub fn run() -> ExitCode {
    let arguments = Arguments::parse();
    let result = arguments
        .common
        .threads()
        .and_then(|()| match &arguments.command {
            Command::Synth(command) => synth::run(command, &arguments.common),
            Command::Build(command) => build::run(command, &arguments.common),
        });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&format!("error: {error:#}"));
            ExitCode::FAILURE
        }
    }
}

/// A line for the person at the terminal. A closed terminal is nobody's mistake.
fn complain(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Text the user asked for, on standard output.
fn print(text: &str) {
    let _ = writeln!(std::io::stdout(), "{}", text.trim_end());
}
