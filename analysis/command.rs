//! `landscape` as a function.

use std::error::Error;
use std::process::ExitCode;

/// Runs `landscape` with these arguments.
pub(crate) fn landscape(arguments: &[&str]) -> Result<(), Box<dyn Error>> {
    let code = landscape::cli::run_with([&["landscape"][..], arguments].concat());
    if code == ExitCode::SUCCESS {
        Ok(())
    } else {
        Err(format!("landscape {} failed", arguments.join(" ")).into())
    }
}
