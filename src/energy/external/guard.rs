//! Ends the processes that a run started when the run ends.

use std::io;
#[cfg(unix)]
use std::io::Write;
use std::process::{Child, Command};
#[cfg(unix)]
use std::process::{ChildStdin, Stdio};
#[cfg(unix)]
use std::sync::Mutex;

#[cfg(unix)]
use super::lock;

/// A shell that knows the process groups of all programs and reads from this process. Its input ends when this process ends
/// for any reason, including a signal that cannot be caught. Then the shell ends the groups, first with SIGTERM, then by
/// force.
#[cfg(unix)]
const SCRIPT: &str = r#"
groups=
while read -r word group; do
  case $word in
    start) groups="$groups -$group" ;;
    stop) kill -s KILL -- "-$group" ;;
    done) exit 0 ;;
  esac
done
[ -n "$groups" ] || exit 0
kill -s TERM -- $groups
sleep 2
kill -s KILL -- $groups
"#;

/// Keeps the processes of programs together and ends them with the run.
///
/// On Unix each program leads a process group of its own, which is ended as a whole. On other systems only the program
/// itself is ended, and processes that it started may stay.
pub(super) struct Guard {
    #[cfg(unix)]
    shell: Mutex<(Child, Option<ChildStdin>)>,
}

#[cfg(unix)]
impl Guard {
    pub(super) fn start() -> io::Result<Self> {
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(SCRIPT);
        shell.stdin(Stdio::piped());
        shell.stdout(Stdio::null()).stderr(Stdio::null());
        let mut shell = Self::apart(&mut shell).spawn()?;
        let input = shell.stdin.take();
        Ok(Self {
            shell: Mutex::new((shell, input)),
        })
    }

    /// Makes a command lead its own process group, so that keys of the terminal do not reach it.
    pub(super) fn apart(command: &mut Command) -> &mut Command {
        use std::os::unix::process::CommandExt;
        command.process_group(0)
    }

    /// From now on the group of `program` is ended with this process.
    pub(super) fn watch(&self, program: &Child) {
        self.tell(&format!("start {}", program.id()));
    }

    /// Ends the rest of the group of `program` at once.
    pub(super) fn stop(&self, program: &Child) {
        self.tell(&format!("stop {}", program.id()));
    }

    /// Errors are ignored: if the guard has ended, nothing depends on it while this process lives.
    fn tell(&self, line: &str) {
        if let (_, Some(input)) = &mut *lock(&self.shell) {
            let _ = writeln!(input, "{line}");
        }
    }
}

#[cfg(unix)]
impl Drop for Guard {
    /// The programs have ended by now. The guard finishes its commands and then ends.
    fn drop(&mut self) {
        self.tell("done");
        let (shell, input) = &mut *lock(&self.shell);
        *input = None;
        let _ = shell.wait();
    }
}

#[cfg(not(unix))]
impl Guard {
    pub(super) fn start() -> io::Result<Self> {
        Ok(Self {})
    }

    pub(super) fn apart(command: &mut Command) -> &mut Command {
        command
    }

    pub(super) fn watch(&self, _: &Child) {}

    pub(super) fn stop(&self, _: &Child) {}
}
