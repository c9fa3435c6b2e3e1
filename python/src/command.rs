//! The command line: as that of the process, and as calls.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use landscape::cli;
use pyo3::prelude::*;

use crate::error::Failure;
use crate::work::detached;

/// Runs a command line as that of this process and returns its exit code. The first argument is the name of the program.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| cli::run_process(arguments))
}

/// Runs a command line, without the name of the program, and returns what it prints. Raises what it would end with.
#[pyfunction]
pub(crate) fn call(py: Python<'_>, arguments: Vec<OsString>, bars: bool) -> PyResult<String> {
    let mut line = vec![OsString::from("landscape")];
    line.extend(arguments);
    let stop = Arc::new(cli::Stop::default());
    let stopping = stop.clone();
    detached(
        py,
        move || stopping.stop(),
        move || Ok(cli::call(line, bars, &stop)?),
    )
}

/// Refuses an output file as every command does.
#[pyfunction]
pub(crate) fn check_output(py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
    cli::check_output(&path, force).map_err(|error| Failure::from(error).raised(py))
}
