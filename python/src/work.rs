//! Native work while Python's other threads run on.
//!
//! Work runs on a thread of its own, so that the caller's thread can ask for signals: Ctrl-C ends a call within a second,
//! whatever the work does. A panic becomes an exception. A process forked from one that has worked has none of its threads,
//! so that work would wait for them for ever: it is refused there.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::ThreadBuilder;

use crate::error::{Failure, panicked};

/// Time between two looks for signals.
const PERIOD: Duration = Duration::from_millis(50);
/// Time that interrupted work is given to end before the call returns without it.
const GRACE: Duration = Duration::from_millis(600);
/// Stack of the thread, as large as that of a program's first thread.
const STACK: usize = 8 << 20;

/// Interval of the checks whether threads have let the interpreter go.
const TICK: Duration = Duration::from_millis(5);
/// The process whose threads work.
static HOME: OnceLock<u32> = OnceLock::new();
/// Threads that are known to the interpreter and call functions.
static ATTACHED: AtomicUsize = AtomicUsize::new(0);
/// Whether the interpreter is about to end, so that nothing may call functions any more.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Refuses work in a process that was forked from one that has worked.
fn at_home() -> PyResult<()> {
    let here = std::process::id();
    if *HOME.get_or_init(|| here) == here {
        return Ok(());
    }
    Err(PyRuntimeError::new_err(
        "this process was forked from one that had used landscape, whose threads it lacks: start processes with \
         multiprocessing.get_context(\"spawn\")",
    ))
}

/// Whether the interpreter is about to end.
pub(crate) fn ending() -> bool {
    ENDING.load(Ordering::SeqCst)
}

/// Runs a thread of a pool that keeps its state of the interpreter between calls of a function: making one for each call
/// would cost more than the call. Without an interpreter the first call ends the search.
pub(crate) fn attached(thread: ThreadBuilder) {
    let mut thread = Some(thread);
    let mut run = || thread.take().map(ThreadBuilder::run);
    // Counted before the look, so that either this thread sees the end or `finish` sees this thread.
    ATTACHED.fetch_add(1, Ordering::SeqCst);
    if !ending() {
        let _ = Python::try_attach(|py| py.detach(&mut run));
    }
    run();
    ATTACHED.fetch_sub(1, Ordering::SeqCst);
}

/// Ends all searches that call functions and waits until their threads have ended, and so until the last call has returned.
/// The interpreter calls it before it ends: a thread that came back to an interpreter that has ended would end the process
/// by force. A forked process has none of these threads.
#[pyfunction]
pub(crate) fn finish(py: Python<'_>) -> PyResult<()> {
    if HOME.get().is_some_and(|home| *home != std::process::id()) {
        return Ok(());
    }
    ENDING.store(true, Ordering::SeqCst);
    while ATTACHED.load(Ordering::SeqCst) > 0 {
        py.detach(|| std::thread::sleep(TICK));
        py.check_signals()?;
    }
    Ok(())
}

/// Runs `work`. If a signal handler raises (Ctrl-C), `stop` is called and the exception returned. Work that does not end
/// soon after `stop` goes on unseen until it does; its result is dropped.
pub(crate) fn detached<T: Send + 'static>(
    py: Python<'_>,
    stop: impl Fn(),
    work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    at_home()?;
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

/// Runs short work without the interpreter, on this thread. A thread of a pool, which runs a function of the caller, lets
/// another one work: while it waited for parts of the work, it would take up another call of the same function. A panic
/// becomes an exception.
pub(crate) fn briefly<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    at_home()?;
    let run = || catch_unwind(AssertUnwindSafe(work));
    let done = py.detach(|| {
        if rayon::current_thread_index().is_none() {
            return run();
        }
        std::thread::scope(|scope| scope.spawn(run).join().unwrap_or_else(Err))
    });
    done.map_err(|payload| panicked(py, &*payload))
}
