//! A running program, with which lines are exchanged and which is always ended.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, Weak};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::answers::Answers;
use super::guard::Guard;
use super::lock;

/// Time that a program may take to end once its input is closed.
const PATIENCE: Duration = Duration::from_secs(2);
/// Interval of the checks for late answers.
const TICK: Duration = Duration::from_millis(50);

/// Starts programs, stops those whose answers are late, and ends all of them with the run.
pub(super) struct Supervisor {
    guard: Arc<Guard>,
    running: Arc<Mutex<Vec<Weak<Running>>>>,
    /// Closed when the clock thread must end.
    stop: Option<Sender<()>>,
    clock: Option<JoinHandle<()>>,
}

/// The part of a program that the clock thread uses.
struct Running {
    child: Mutex<Child>,
    /// Deadline of its answer; `None` while no question is open.
    due: Mutex<Option<Instant>>,
    late: AtomicBool,
}

/// A running program.
pub(super) struct Program {
    running: Arc<Running>,
    guard: Arc<Guard>,
    input: Option<ChildStdin>,
    output: BufReader<Answers>,
}

/// Why there is no answer.
pub(super) enum Silence {
    /// The program ended or closed its output.
    Ended,
    /// Its answer was late.
    Late,
    /// Its line was too long; contains the beginning.
    Long(Vec<u8>),
}

impl Supervisor {
    pub(super) fn start() -> io::Result<Self> {
        let guard = Arc::new(Guard::start()?);
        let running: Arc<Mutex<Vec<Weak<Running>>>> = Arc::default();
        let (stop, stopped) = channel::<()>();
        let (watched, keeper) = (Arc::clone(&running), Arc::clone(&guard));
        let watch = move || {
            while stopped.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                let now = Instant::now();
                for program in lock(&watched).iter().filter_map(Weak::upgrade) {
                    if lock(&program.due).is_some_and(|due| due <= now) {
                        program.late.store(true, Ordering::SeqCst);
                        program.kill(&keeper);
                    }
                }
            }
        };
        let clock = std::thread::Builder::new().name("answers".to_owned());
        Ok(Self {
            guard,
            running,
            stop: Some(stop),
            clock: Some(clock.spawn(watch)?),
        })
    }

    /// Starts `command` in the shell.
    pub(super) fn launch(&self, command: &str) -> io::Result<Program> {
        let mut shell = shell(command);
        shell.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = Guard::apart(&mut shell).spawn()?;
        self.guard.watch(&child);
        let pipes = child.stdin.take().zip(child.stdout.take());
        let (input, output) = pipes.expect("both ends were asked for");
        let running = Arc::new(Running {
            child: Mutex::new(child),
            due: Mutex::new(None),
            late: AtomicBool::new(false),
        });
        let mut list = lock(&self.running);
        list.retain(|program| program.strong_count() > 0);
        list.push(Arc::downgrade(&running));
        Ok(Program {
            running,
            guard: Arc::clone(&self.guard),
            input: Some(input),
            output: BufReader::new(Answers::new(output)),
        })
    }
}

impl Drop for Supervisor {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(clock) = self.clock.take() {
            let _ = clock.join();
        }
    }
}

impl Running {
    /// Ends the program and all processes it started, by force.
    fn kill(&self, guard: &Guard) {
        let mut child = lock(&self.child);
        guard.stop(&child);
        let _ = child.kill();
    }
}

impl Program {
    /// Sends a line and waits for an answer of at most `longest` bytes, no longer than `limit`.
    pub(super) fn exchange(
        &mut self,
        question: &str,
        limit: Duration,
        longest: u64,
    ) -> Result<Vec<u8>, Silence> {
        match self.in_time(limit, |program| program.converse(question, longest))? {
            Some(line) if line.ends_with(b"\n") => Ok(line),
            Some(line) if line.len() as u64 >= longest => {
                self.running.kill(&self.guard);
                Err(Silence::Long(line))
            }
            // The last line of a program may lack a line end.
            Some(line) if !line.is_empty() => Ok(line),
            _ => Err(Silence::Ended),
        }
    }

    /// Sends bytes and waits for as many bytes as `answer` has, no longer than `limit`.
    pub(super) fn exchange_bytes(
        &mut self,
        question: &[u8],
        answer: &mut [u8],
        limit: Duration,
    ) -> Result<(), Silence> {
        let read = self.in_time(limit, |program| {
            let input = program.input.as_mut()?;
            input
                .write_all(question)
                .and_then(|()| input.flush())
                .ok()?;
            program.output.read_exact(answer).ok()
        })?;
        read.ok_or(Silence::Ended)
    }

    /// What `ask` returns, unless it took longer than `limit`.
    fn in_time<T>(
        &mut self,
        limit: Duration,
        ask: impl FnOnce(&mut Self) -> Option<T>,
    ) -> Result<Option<T>, Silence> {
        // A limit beyond the range of the clock means no limit.
        *lock(&self.running.due) = Instant::now().checked_add(limit);
        let answer = ask(self);
        *lock(&self.running.due) = None;
        if self.running.late.load(Ordering::SeqCst) {
            return Err(Silence::Late);
        }
        Ok(answer)
    }

    /// Reads the answer line, up to `longest` bytes; `None` if the program has gone.
    fn converse(&mut self, question: &str, longest: u64) -> Option<Vec<u8>> {
        let input = self.input.as_mut()?;
        writeln!(input, "{question}")
            .and_then(|()| input.flush())
            .ok()?;
        let mut answer = Vec::new();
        let line = (&mut self.output)
            .take(longest)
            .read_until(b'\n', &mut answer);
        line.ok().map(|_| answer)
    }

    /// Closes the input, waits for the program to end, by force if need be, and returns how it ended. All processes that
    /// the program left behind end too.
    pub(super) fn end(&mut self) -> String {
        self.input = None;
        let deadline = Instant::now() + PATIENCE;
        let mut child = lock(&self.running.child);
        let told = loop {
            match child.try_wait() {
                Ok(Some(status)) => break Some(status.to_string()),
                Ok(None) if Instant::now() < deadline => {
                    std::thread::sleep(Duration::from_millis(2));
                }
                Ok(None) => break None,
                Err(error) => break Some(error.to_string()),
            }
        };
        self.guard.stop(&child);
        told.unwrap_or_else(|| {
            let killed = child.kill().and_then(|()| child.wait());
            killed.map_or_else(
                |error| error.to_string(),
                |_| "its output was closed, and it had to be stopped".to_owned(),
            )
        })
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.end();
    }
}

fn shell(command: &str) -> Command {
    let (shell, flag) = if cfg!(windows) {
        ("cmd", "/C")
    } else {
        ("sh", "-c")
    };
    let mut shell = Command::new(shell);
    shell.arg(flag).arg(command);
    shell
}
