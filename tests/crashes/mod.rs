//! Runs that are killed (SIGKILL) and whose journals are torn. Finished tasks are kept, and the final result is identical to
//! the last byte. `verbs` stops every command at any moment and takes its disk space away.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use landscape::store::Journal;

use crate::desk::{Desk, assert_says};
use crate::records::records;

mod verbs;

/// A command and its output.
struct Run {
    line: &'static str,
    output: &'static str,
    journal: &'static str,
}

const SYNTH: Run = Run {
    line: "synth --object ball -n 10 --steps 1 --keep all --drop 0 --seed 1 -o g.parquet",
    output: "g.parquet",
    journal: "g.parquet.partial",
};
const BUILD: Run = Run {
    line: "build g.parquet --first 4",
    output: "g.landscape",
    journal: "g.landscape.partial/journal",
};
const SURFACE: Run = Run {
    line: "surface three-hole --seed 2 -o s.landscape",
    output: "s.landscape",
    journal: "s.landscape.partial/journal",
};

/// Files by name.
type Files = BTreeMap<String, Vec<u8>>;

impl Run {
    /// The files of an uninterrupted run on one thread, made once for each command.
    fn whole(&self) -> &'static Files {
        static WHOLE: [OnceLock<Files>; 3] = [const { OnceLock::new() }; 3];
        let place = [SYNTH.output, BUILD.output, SURFACE.output]
            .iter()
            .position(|output| *output == self.output);
        WHOLE[place.unwrap()].get_or_init(|| {
            let desk = self.desk();
            assert!(self.start(&desk, 1).wait().unwrap().success());
            self.files(&desk)
        })
    }

    /// A folder with the inputs of the command.
    fn desk(&self) -> Desk {
        let desk = Desk::empty();
        if self.output == BUILD.output {
            desk.write(SYNTH.output, &SYNTH.whole()[SYNTH.output]);
        }
        desk
    }

    fn start(&self, desk: &Desk, threads: usize) -> Child {
        desk.command(&format!("{} -q --threads {threads}", self.line))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    }

    /// The finished files, except the only one that describes the run. There are none if they do not have their final name.
    fn files(&self, desk: &Desk) -> Files {
        let path = desk.path(self.output);
        let read = |path: PathBuf| (name(&path), fs::read(&path).unwrap());
        if path.is_file() {
            return [read(path)].into();
        }
        let entries = fs::read_dir(&path).into_iter().flatten();
        let files = entries.map(|entry| read(entry.unwrap().path()));
        files.filter(|(name, _)| name != "timings.json").collect()
    }

    /// Checks the remains of a kill: the journal begins with its previous content and has no duplicates. Under the final
    /// name there is nothing or everything.
    fn check_wreck(&self, desk: &Desk, before: &[(String, usize)]) {
        let mut files = self.files(desk);
        // Of the folder's last moments.
        let journal = files.remove("journal");
        files.remove(".unfinished");
        let complete = !files.is_empty();
        assert!(!complete || &files == self.whole(), "whole or absent");
        let after = records(&desk.path(self.journal));
        if journal.is_none() && !(complete && after.is_empty()) {
            assert!(after.starts_with(before), "{before:?} became {after:?}");
        }
        let keys: BTreeSet<_> = after.iter().map(|(key, _)| key).collect();
        assert_eq!(keys.len(), after.len(), "a task was done twice: {after:?}");
    }

    /// Makes a folder for a journal as an interrupted run leaves it.
    fn plant(&self, desk: &Desk) {
        if self.journal.ends_with("/journal") {
            let folder = desk.path(self.journal).with_file_name("");
            fs::create_dir_all(&folder).unwrap();
            fs::write(folder.join(".unfinished"), "").unwrap();
        }
    }

    /// Runs the command to its end and compares the results.
    fn finish(&self, desk: &Desk, flags: &str) {
        desk.succeed(&format!("{} {flags}", self.line));
        assert!(&self.files(desk) == self.whole(), "same bytes");
        let left: Vec<String> = fs::read_dir(desk.folder.path())
            .unwrap()
            .map(|entry| name(&entry.unwrap().path()))
            .filter(|name| name != SYNTH.output && name != self.output)
            .collect();
        assert_eq!(left, [""; 0], "nothing else is left");
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

/// Kills a process that may have ended in the meantime, and returns whether it had ended.
fn kill(mut child: Child) -> bool {
    child.kill().unwrap();
    child.wait().unwrap().success()
}

/// Kills the run as soon as some further records have appeared, alternately on one thread and on two, and spoils the end of
/// its journal.
fn killed_after_records(run: &Run) {
    let desk = run.desk();
    let journal = desk.path(run.journal);
    let (mut kills, mut ended) = (0, false);
    while !ended {
        let before = records(&journal);
        let mut child = run.start(&desk, 1 + kills % 2);
        while records(&journal).len() <= before.len() + 1 && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_micros(200));
        }
        ended = kill(child);
        run.check_wreck(&desk, &before);
        kills += usize::from(!ended);
        // What a power cut leaves behind the last record.
        if let Ok(mut torn) = fs::OpenOptions::new().append(true).open(&journal) {
            torn.write_all(b"torn!").unwrap();
        }
        assert!(kills <= 200, "every run finishes a task at least");
    }
    assert!(kills >= 1, "it ended before it was killed");
    assert!(&run.files(&desk) == run.whole(), "same bytes");
}

#[test]
fn killed_runs_go_on() {
    for run in [&SYNTH, &BUILD, &SURFACE] {
        killed_after_records(run);
    }
}

/// Journals of something else, and a wish to resume where there is nothing.
#[test]
fn journals_that_do_not_fit() {
    for run in [&SYNTH, &SURFACE] {
        let desk = run.desk();
        assert_says(
            &desk.mistake(&format!("{} --resume", run.line)),
            &["--resume: ", "interrupted run", "without --resume"],
        );
        assert_eq!(fs::read_dir(desk.folder.path()).unwrap().count(), 0);

        run.plant(&desk);
        let other = Journal::open(&desk.path(run.journal), "another program", false).unwrap();
        other.put("chain 0", b"{}").unwrap();
        drop(other);
        let before = desk.bytes(run.journal);
        for flag in ["", "--resume"] {
            assert_says(
                &desk.mistake(&format!("{} {flag}", run.line)),
                &[run.journal, "other input or settings", "--fresh"],
            );
            assert_eq!(desk.bytes(run.journal), before);
        }
        run.finish(&desk, "-q --fresh");
    }
}
