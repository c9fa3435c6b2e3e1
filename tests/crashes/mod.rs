//! Runs that are killed (SIGKILL) or whose journals are truncated. Finished tasks are kept, and the final result is identical to
//! the last byte. `verbs` stops every command at any moment and takes its disk space away.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
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

/// Bytes of a journal before its first record, with the 32 letters of a `content_hash`.
const HEAD: usize = 20 + 8 + 32;

/// Files by name.
type Files = BTreeMap<String, Vec<u8>>;

/// The files of an uninterrupted run on one thread, and its journal just before the end.
struct Whole {
    files: Files,
    journal: Vec<u8>,
}

impl Run {
    /// The uninterrupted run, made once for each command.
    fn whole(&self) -> &'static Whole {
        static WHOLE: [OnceLock<Whole>; 3] = [const { OnceLock::new() }; 3];
        let place = [SYNTH.output, BUILD.output, SURFACE.output]
            .iter()
            .position(|output| *output == self.output);
        WHOLE[place.unwrap()].get_or_init(|| {
            let desk = self.desk();
            let mut child = self.start(&desk, 1);
            // A second name keeps the journal, which is removed at the end.
            while fs::hard_link(desk.path(self.journal), desk.path("kept")).is_err() {
                assert_eq!(child.try_wait().unwrap(), None, "it has a journal");
                std::thread::sleep(Duration::from_micros(100));
            }
            assert!(child.wait().unwrap().success());
            Whole {
                files: self.files(&desk),
                journal: desk.bytes("kept"),
            }
        })
    }

    /// A folder with the inputs of the command.
    fn desk(&self) -> Desk {
        let desk = Desk::empty();
        if self.output == BUILD.output {
            desk.write(SYNTH.output, &SYNTH.whole().files[SYNTH.output]);
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
        assert!(!complete || files == self.whole().files, "whole or absent");
        let after = records(&desk.path(self.journal));
        if journal.is_none() && !(complete && after.is_empty()) {
            assert!(after.starts_with(before), "{before:?} became {after:?}");
        }
        let keys: BTreeSet<_> = after.iter().map(|(key, _)| key).collect();
        assert_eq!(keys.len(), after.len(), "a task was done twice: {after:?}");
    }

    /// Puts a journal at the place of one of an interrupted run.
    fn plant(&self, desk: &Desk, journal: &[u8]) {
        let path = desk.path(self.journal);
        if self.journal.ends_with("/journal") {
            let folder = path.parent().unwrap();
            fs::create_dir_all(folder).unwrap();
            fs::write(folder.join(".unfinished"), "").unwrap();
        }
        fs::write(path, journal).unwrap();
    }

    /// Runs the command to its end and compares the results.
    fn finish(&self, desk: &Desk, flags: &str) -> String {
        let output = desk.run(&format!("{} {flags}", self.line));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{} {flags}: {said}", self.line);
        assert!(self.files(desk) == self.whole().files, "same bytes");
        let left: Vec<String> = fs::read_dir(desk.folder.path())
            .unwrap()
            .map(|entry| name(&entry.unwrap().path()))
            .filter(|name| name != SYNTH.output && name != self.output && name != "kept")
            .collect();
        assert_eq!(left, [""; 0], "nothing else is left");
        said
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

/// Kills the run as soon as some further records have appeared, alternately on one thread and on two.
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
        assert!(kills <= 200, "every run finishes a task at least");
    }
    assert!(kills >= 1, "it ended before it was killed");
    assert!(run.files(&desk) == run.whole().files, "same bytes");
}

/// A journal truncated near the ends of its records, or damaged in the last one, keeps its earlier records.
fn cut_short(run: &Run, percent: &[usize]) {
    let whole = run.whole();
    let desk = run.desk();
    run.plant(&desk, &whole.journal);
    let all = records(&desk.path(run.journal));
    let last = all.len() - 1;
    let mut cases: Vec<(Vec<u8>, usize)> = vec![(whole.journal[..11].to_vec(), 0)];
    for (share, offset) in percent.iter().zip([-3_isize, 0, 5].iter().cycle()) {
        let record = share * last / 100;
        let cut = all[record].1.saturating_add_signed(*offset);
        let kept = all.iter().filter(|(_, end)| *end <= cut).count();
        let cut = cut.min(whole.journal.len());
        cases.push((whole.journal[..cut].to_vec(), kept));
    }
    let mut flipped = whole.journal.clone();
    flipped[all[last].1 - 2] ^= 0x10;
    cases.push((flipped, last));
    for (bytes, kept) in cases {
        run.plant(&desk, &bytes);
        let _ = fs::remove_file(desk.path("kept"));
        fs::hard_link(desk.path(run.journal), desk.path("kept")).unwrap();
        let said = run.finish(&desk, "--threads 2 --resume");
        let then = records(&desk.path("kept"));
        assert_eq!(then[..kept], all[..kept], "what was whole is kept");
        assert_eq!(then.len(), all.len(), "and the rest is done once more");
        if kept > 0 {
            assert_says(&said, &[&format!("{kept} finished task")]);
        }
        let whole_until = match kept {
            0 if bytes.len() < HEAD => 0,
            0 => HEAD,
            _ => all[kept - 1].1,
        };
        let torn = bytes.len() - whole_until;
        let warned = said.contains(&format!("the last {torn} bytes of"));
        assert_eq!(warned, torn > 0, "{torn} bytes are torn: {said}");
    }
}

#[test]
fn killed_runs_go_on() {
    for run in [&SYNTH, &BUILD, &SURFACE] {
        killed_after_records(run);
    }
}

#[test]
fn torn_journals() {
    cut_short(&SYNTH, &[20, 50, 100]);
    cut_short(&SURFACE, &[50]);
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

        run.plant(&desk, b"");
        fs::remove_file(desk.path(run.journal)).unwrap();
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
