//! The output of a running program.

use std::io::{self, Read};
use std::process::ChildStdout;
use std::time::{Duration, Instant};

/// How long a thread asks again and again for an answer before it rests. To wake it from rest takes tens of microseconds on
/// some machines, which is longer than cheap answers take. A program that does not answer in this time is waited for at rest.
const AWAKE: Duration = Duration::from_micros(100);

/// Reads answers. While they come quickly, the thread that waits for them stays awake.
pub(super) struct Answers {
    output: ChildStdout,
    /// Whether the last answer took no longer than [`AWAKE`].
    are_quick: bool,
}

impl Answers {
    pub(super) const fn new(output: ChildStdout) -> Self {
        Self {
            output,
            are_quick: true,
        }
    }

    /// Returns as soon as there is something to read, or after [`AWAKE`].
    #[cfg(unix)]
    fn stay_awake(&self, began: Instant) {
        use rustix::event::{PollFd, PollFlags, Timespec, poll};
        while began.elapsed() <= AWAKE {
            let mut asked = [PollFd::new(&self.output, PollFlags::IN)];
            if poll(&mut asked, Some(&Timespec::default())) != Ok(0) {
                return;
            }
            // The program may be waiting for this core.
            std::thread::yield_now();
        }
    }

    #[cfg(not(unix))]
    fn stay_awake(&self, _: Instant) {}
}

impl Read for Answers {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let began = Instant::now();
        if self.are_quick {
            self.stay_awake(began);
        }
        let read = self.output.read(buffer);
        self.are_quick = began.elapsed() <= AWAKE;
        read
    }
}
