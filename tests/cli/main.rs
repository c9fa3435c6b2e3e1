//! The whole program as a user runs it: a tiny experiment, threads, interruptions, and the messages of all mistakes.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod asked;
mod cache;
mod diversity;
mod experiments;
mod flags;
mod given_grasps;
mod growing;
mod hand_notes;
mod interruptions;
mod join;
mod json;
mod judge;
mod manuals;
mod objects;
mod outputs;
mod provenance;
mod roadmap;
mod settings;
mod spoilt_grasps;
mod survey;

#[cfg(unix)]
#[path = "../crashes/mod.rs"]
mod crashes;
#[path = "../desk/mod.rs"]
mod desk;
#[path = "../folder/mod.rs"]
mod folder;
#[path = "../parts/mod.rs"]
mod parts;
#[path = "../records/mod.rs"]
mod records;
#[path = "../skipped/mod.rs"]
mod skipped;
#[path = "../table/mod.rs"]
mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use crate::desk::Desk;
use crate::folder::names;
use crate::parts::Parts;
use crate::records::records;

/// Lets a command keep what it caches below `folder`.
fn in_cache(command: &mut Command, folder: &Path) {
    for name in ["XDG_CACHE_HOME", "HOME", "LOCALAPPDATA"] {
        command.env(name, folder);
    }
}

impl Desk {
    fn with_grasps() -> Self {
        let desk = Self::empty();
        desk.write("g.parquet", grasps());
        desk
    }

    /// Another folder with the same files.
    fn copied(&self) -> Self {
        let desk = Self::empty();
        let from = self.folder.path();
        for (path, bytes) in contents(from) {
            let to = desk.folder.path().join(path.strip_prefix(from).unwrap());
            if path.is_dir() {
                fs::create_dir(to).unwrap();
            } else {
                fs::write(to, bytes).unwrap();
            }
        }
        desk
    }

    /// A folder with a copy of [`landscape`] of this name.
    fn add_landscape(&self, name: &str) {
        fs::create_dir(self.path(name)).unwrap();
        for (path, bytes) in contents(&landscape().path("g.landscape")) {
            fs::write(self.path(name).join(path.file_name().unwrap()), bytes).unwrap();
        }
    }

    /// A folder with `min.data` and `ts.data` of [`landscape`].
    fn add_database(&self, name: &str) {
        fs::create_dir(self.path(name)).unwrap();
        for file in ["min.data", "ts.data"] {
            let from = landscape().path("g.landscape").join(file);
            fs::copy(from, self.path(name).join(file)).unwrap();
        }
    }

    /// The message of a mistake that is found before anything is written.
    fn early_mistake(&self, line: &str) -> String {
        let before = contents(self.folder.path());
        let sentence = self.mistake(line);
        assert_eq!(contents(self.folder.path()), before, "landscape {line}");
        sentence
    }

    /// The message with which `build` refuses grasps spoilt in this way.
    fn refusal(spoil: impl FnOnce(Parts) -> Parts) -> String {
        let desk = Self::with_grasps();
        spoil(Parts::of(&desk.path("g.parquet"))).write(&desk.path("spoilt.parquet"));
        desk.early_mistake("build spoilt.parquet")
    }

    fn start(&self, line: &str) -> Child {
        self.command(line)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    }

    /// Starts a command and kills it as soon as its journal holds `least` records.
    fn interrupt(&self, line: &str, journal: &str, least: usize) {
        let mut child = self.start(line);
        while records(&self.path(journal)).len() < least {
            assert_eq!(
                child.try_wait().unwrap(),
                None,
                "ended before it was killed"
            );
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        assert!(!child.wait().unwrap().success());
    }

    /// Continues a command, which must not repeat tasks in its journal.
    fn resume(&self, line: &str, journal: &str) {
        let done = records(&self.path(journal));
        // A second name keeps the journal, which is removed at the end.
        fs::hard_link(self.path(journal), self.path("kept")).unwrap();
        self.succeed(line);
        let all = records(&self.path("kept"));
        fs::remove_file(self.path("kept")).unwrap();
        assert_eq!(all[..done.len()], done, "what was done is kept");
        assert!(all.len() > done.len(), "killed before the end");
        let keys: BTreeSet<_> = all.iter().map(|(key, _)| key).collect();
        assert_eq!(keys.len(), all.len(), "no task is done twice: {all:?}");
    }
}

/// Six ends of single descents; without `--quiet` some of them would be dropped in a simulation.
const SYNTH: &str = "synth --object ball -n 6 --steps 1 --keep all --seed 1 --quiet";
const LONG_SYNTH: &str = "synth --object ball -n 12 --steps 9 --keep all --seed 1 --threads 1 -q";
const BUILD: &str = "build g.parquet --first 3";

/// A slow protocol with a long time before gravity acts, so that there is time to kill the process. At its friction some
/// grasps hold and others do not.
const PATIENT: &str = "protocol = \"drop\"\nsettle_s = 20.0\nfriction = 0.01\n";
const STABILITY: &str = "stability g.parquet --config p.toml -q -o held.parquet";

/// `g.parquet` of [`SYNTH`], made once, on one thread.
fn grasps() -> &'static [u8] {
    static GRASPS: OnceLock<Vec<u8>> = OnceLock::new();
    GRASPS.get_or_init(|| {
        let desk = Desk::empty();
        desk.succeed(&format!("{SYNTH} --threads 1 -o g.parquet"));
        assert_eq!(names(desk.folder.path()), ["g.parquet"]);
        desk.bytes("g.parquet")
    })
}

/// `held.parquet` of [`STABILITY`], made once.
fn held_grasps() -> &'static [u8] {
    static HELD: OnceLock<Vec<u8>> = OnceLock::new();
    HELD.get_or_init(|| {
        let desk = Desk::with_grasps();
        desk.write("p.toml", PATIENT);
        desk.succeed(&format!("{STABILITY} --threads 1"));
        desk.bytes("held.parquet")
    })
}

/// Thirty ends of single descents, as many as a comparison of diversities needs, made once.
fn thirty_grasps() -> &'static [u8] {
    static THIRTY: OnceLock<Vec<u8>> = OnceLock::new();
    THIRTY.get_or_init(|| {
        let desk = Desk::empty();
        desk.succeed("synth --object ball -n 30 --steps 1 --keep all -q -o thirty.parquet");
        desk.bytes("thirty.parquet")
    })
}

/// The folder of [`BUILD`] and what the command printed, made once, on one thread.
fn built() -> &'static (Desk, String) {
    static BUILT: OnceLock<(Desk, String)> = OnceLock::new();
    BUILT.get_or_init(|| {
        let desk = Desk::with_grasps();
        let output = desk.run(&format!("{BUILD} --threads 1"));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        assert_eq!(names(desk.folder.path()), ["g.landscape", "g.parquet"]);
        (desk, String::from_utf8(output.stdout).unwrap())
    })
}

fn landscape() -> &'static Desk {
    &built().0
}

fn has_ending(name: &str, ending: &str) -> bool {
    Path::new(name)
        .extension()
        .is_some_and(|found| found == ending)
}

/// Every file below a folder.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for name in names(folder) {
        let path = folder.join(name);
        if path.is_dir() {
            files.insert(path.clone(), Vec::new());
            files.extend(contents(&path));
        } else {
            files.insert(path.clone(), fs::read(&path).unwrap());
        }
    }
    files
}

/// The files of a landscape folder that must not depend on threads and interruptions.
fn promised(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    names(folder)
        .into_iter()
        .filter(|name| name != "timings.json")
        .map(|name| (name.clone(), fs::read(folder.join(name)).unwrap()))
        .collect()
}
