//! Native work while Python's other threads run on.
//!
//! Work runs on a thread of its own, so that the caller's thread can ask for signals: Ctrl-C ends a call within a second,
//! whatever the work does. A panic becomes an exception.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::error::{Failure, panicked};

/// Time between two looks for signals.
const PERIOD: Duration = Duration::from_millis(50);
/// Time that interrupted work is given to end before the call returns without it.
const GRACE: Duration = Duration::from_millis(600);
/// Stack of the thread, as large as that of a program's first thread.
const STACK: usize = 8 << 20;

/// Runs `work`. If a signal handler raises (Ctrl-C), `stop` is called and the exception returned. Work that does not end
/// soon after `stop` goes on unseen until it does; its result is dropped.
pub(crate) fn detached<T: Send + 'static>(
    py: Python<'_>,
    stop: impl Fn(),
    work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let (sender, mut receiver) = channel();
    let run = move || {
        // The receiver is gone if the call was interrupted.
        let _ = sender.send(catch_unwind(AssertUnwindSafe(work)));
    };
    std::thread::Builder::new()
        .name("landscape".to_owned())
        .stack_size(STACK)
        .spawn(run)
        .map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?;
    loop {
        let (back, answer) = py.detach(move || {
            let answer = receiver.recv_timeout(PERIOD);
            (receiver, answer)
        });
        receiver = back;
        match answer {
            Ok(Ok(done)) => return done.map_err(|failure| failure.raised(py)),
            Ok(Err(payload)) => return Err(panicked(py, &*payload)),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("the thread of the work is gone"));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        if let Err(interruption) = py.check_signals() {
            stop();
            py.detach(move || {
                let _ = receiver.recv_timeout(GRACE);
            });
            return Err(interruption);
        }
    }
}

/// Panics in work on a thread of its own, or on this thread: tests ask for it.
#[pyfunction]
pub(crate) fn panic(py: Python<'_>, words: String, aside: bool) -> PyResult<()> {
    if aside {
        detached(py, || (), move || panic!("{words}"))
    } else {
        briefly(py, || panic!("{words}"))
    }
}

/// Runs short work on this thread without the interpreter. A panic becomes an exception.
pub(crate) fn briefly<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    done.map_err(|payload| panicked(py, &*payload))
}
