//! Every command that writes files, stopped at any moment or without disk space. It is stopped at system calls that change
//! the disk (by a preloaded library, `stop.c`) and after random times.
//!
//! In all cases inputs stay unchanged, each output is absent or complete, and an error is one sentence. The same command,
//! given again, leaves the same bytes as an undisturbed run, and nothing else.
//!
//! The tests stop the quick commands a few times. `LANDSCAPE_STOPS=1000` stops all commands this often in total.
//! `LANDSCAPE_STOPS_SEED` chooses other moments, and `LANDSCAPE_STOPS_VERB=draw` selects one command.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use landscape::sample::{Task, stream};
use rand::RngExt;
use tempfile::TempDir;

use crate::desk::Desk;
use crate::diversity::plant;
use crate::table::rows;

use super::{BUILD, Files, SURFACE, SYNTH};

/// A command.
struct Verb {
    name: &'static str,
    line: String,
    inputs: Vec<&'static str>,
    quick: bool,
}

/// Name, command, files in the folder at the start, and whether it and the commands for its inputs take at most a second.
const VERBS: &str = "
    synth | {few} | none | quick
    build | build few.parquet | few.parquet | slow
    surface | {surface} | none | quick
    stability | stability few.parquet | few.parquet | slow
    label | label g.parquet | g.parquet | quick
    label --learn | label --learn named.parquet | named.parquet | slow
    join | join g.parquet few.parquet | g.parquet few.parquet | quick
    man | man pages | none | quick
    report of grasps | report few.parquet | few.parquet | slow
    report | report s.landscape | s.landscape | quick
    compare | compare g.landscape | g.landscape | slow
    diversity | diversity thirty.parquet | thirty.parquet | slow
    judge | judge few.parquet --tests drop --measures distinct | few.parquet | slow
    survey | survey g.parquet few.parquet --no-map -o all.survey | g.parquet few.parquet | slow
    import of grasps | import g.csv --hand human --object ball | g.csv | quick
    import of a landscape | import database | database | quick
    export csv | export g.parquet csv | g.parquet | quick
    export json | export g.parquet json | g.parquet | quick
    export dexgraspnet | export g.parquet dexgraspnet | g.parquet | quick
    export qpos | export g.parquet qpos -o g.npy | g.parquet | quick
    export isaac_grasp | export g.parquet isaac_grasp | g.parquet | quick
    export graspgen | export g.parquet graspgen | g.parquet | quick
    export roadmap | export g.landscape roadmap | g.landscape | slow
    export dexonomy | export few.parquet dexonomy | few.parquet | quick
    export mujoco | export few.parquet mujoco | few.parquet | quick
    export urdf | export few.parquet urdf | few.parquet | quick
    export usd | export few.parquet usd | few.parquet | quick
    export glb | export few.parquet glb | few.parquet | quick
    draw | draw s.landscape | s.landscape | quick
    thermodynamics | thermodynamics s.landscape | s.landscape | quick
    rates | rates s.landscape --from m1 --to m0 --temperature 20 -o rates | s.landscape | quick
    way | inspect g.landscape --path m0 m1 --pictures 2 | g.landscape | slow
    hands | hands inspect human --side-file human.json -o human.png --force | none | slow
    objects | objects inspect cube.obj --side-file found.json -o cube.png --force | cube.obj | slow
    bake | objects bake model.safetensors --specs specs.json --scale 0.1 --cells 40 -o baked.obj | model.safetensors specs.json | slow
";

fn verbs() -> impl Iterator<Item = Verb> {
    rows(VERBS).map(|row| Verb {
        name: row[0],
        line: row[1]
            .replace("{few}", FEW)
            .replace("{surface}", SURFACE.line),
        inputs: row[2].split(' ').collect(),
        quick: row[3] == "quick",
    })
}

const FEW: &str = "synth --object ball -n 2 --steps 1 --keep all --seed 1 -o few.parquet";

/// Folder for caches that may be lost; it is not an output.
const CACHE: &str = "cache";

/// Way to stop a command.
#[derive(Debug, Clone, Copy, PartialEq)]
enum How {
    /// Killed at a system call, named as in `stop.c`.
    Call(&'static str),
    /// Killed after a random time.
    Time,
    /// Disk error at a system call, named as in `stop.c`.
    Disk(&'static str),
}

const WAYS: [How; 8] = [
    How::Call("half"),
    How::Disk("full"),
    How::Call("before"),
    How::Time,
    How::Call("after"),
    How::Disk("broken"),
    How::Call("half"),
    How::Disk("denied"),
];

/// Results of an undisturbed run.
struct Whole {
    inputs: Files,
    files: Files,
    calls: u64,
    duration: Duration,
}

impl Verb {
    fn command(&self, desk: &Desk) -> Command {
        let mut command = desk.command(&format!("{} -q --threads 1", self.line));
        command
            .env("XDG_CACHE_HOME", desk.path(CACHE))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        command
    }

    fn desk(&self) -> Desk {
        let desk = Desk::empty();
        for (name, bytes) in materials() {
            let top = name.split('/').next().unwrap();
            if self.inputs.contains(&top) {
                let path = desk.path(name);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, bytes).unwrap();
            }
        }
        desk
    }

    fn whole(&self, library: &Path) -> Whole {
        let desk = self.desk();
        let inputs = files_in(&desk);
        let count = TempDir::new().unwrap();
        let count = count.path().join("count");
        let started = Instant::now();
        let output = self
            .command(&desk)
            .env("LD_PRELOAD", library)
            .env("STOP_COUNT", &count)
            .output()
            .unwrap();
        let duration = started.elapsed();
        assert!(output.status.success(), "{}: {}", self.line, said(&output));
        let calls = fs::read_to_string(count).unwrap();
        Whole {
            inputs,
            files: files_in(&desk),
            calls: calls.trim().parse().unwrap(),
            duration,
        }
    }

    /// Stops the command once and runs it again.
    fn stopped(&self, how: How, number: u64, whole: &Whole, lib: &Path) -> Result<(), String> {
        let mut rng = stream(number, Task::Start, 1);
        let desk = self.desk();
        // Once in three times over the results of a run before.
        if rng.random_range(0..3) == 0 {
            write_all(&desk, &whole.files);
        }
        let mut command = self.command(&desk);
        let at = rng.random_range(1..=whole.calls);
        if let How::Call(word) | How::Disk(word) = how {
            command
                .env("LD_PRELOAD", lib)
                .env("STOP_AT", at.to_string())
                .env("STOP_HOW", word);
        }
        let mut child = command.spawn().unwrap();
        if how == How::Time {
            std::thread::sleep(whole.duration.mul_f64(rng.random::<f64>()));
            child.kill().unwrap();
        }
        let output = child.wait_with_output().unwrap();
        let place = format!("{how:?} at {at} of {}", whole.calls);
        Self::judge(how, &desk, &output, whole)
            .and_then(|()| self.again(&desk, whole))
            .map_err(|fault| format!("{place}: {fault}: {}", said(&output).trim_end()))
    }

    /// Faults in the remains of a stopped run.
    fn judge(how: How, desk: &Desk, output: &Output, whole: &Whole) -> Result<(), String> {
        let said = said(output);
        let errors = said.lines().filter(|line| line.starts_with("error: "));
        let ended = match (output.status.code(), output.status.signal()) {
            (Some(0), _) => true,
            (Some(1), _) if matches!(how, How::Disk(_)) && errors.count() == 1 => false,
            (None, Some(9)) if !matches!(how, How::Disk(_)) => false,
            _ => return Err(format!("it ended with {}", output.status)),
        };
        if said.contains("panicked") {
            return Err("it panics".to_owned());
        }
        let left = files_in(desk);
        for (name, bytes) in &whole.inputs {
            if left.get(name) != Some(bytes) {
                return Err(format!("the input {name} is not what it was"));
            }
        }
        let outputs = whole
            .files
            .keys()
            .filter(|name| !whole.inputs.contains_key(*name));
        let units: BTreeSet<&str> = outputs.map(|name| unit(name)).collect();
        let mut lacking = Vec::new();
        for &unit in &units {
            let wanted = of_unit(&whole.files, unit);
            let mut found = of_unit(&left, unit);
            found.retain(|name, _| !is_of_last_moments(name));
            let may_lack = !ended || unit.starts_with(CACHE);
            if found != wanted && !(may_lack && found.is_empty()) {
                return Err(format!("{unit} is neither absent nor whole"));
            }
            if found.is_empty() && !unit.starts_with(CACHE) {
                lacking.push(unit);
            }
        }
        let outputs = units.iter().filter(|unit| !unit.starts_with(CACHE));
        if how == How::Disk("full") && ![0, outputs.count()].contains(&lacking.len()) {
            return Err(format!("only {} are absent", lacking.join(", ")));
        }
        // What did not fail to remove them leaves no temporary files.
        let kept =
            |name: &String| whole.files.contains_key(name) || whole.inputs.contains_key(name);
        let stray = left
            .keys()
            .find(|name| !kept(name) && !name.contains(".partial") && !is_of_last_moments(name));
        match stray {
            Some(name) => Err(format!("it leaves {name}")),
            None => Ok(()),
        }
    }

    /// Faults in the result of the same command given again.
    fn again(&self, desk: &Desk, whole: &Whole) -> Result<(), String> {
        let output = self.command(desk).output().unwrap();
        if !output.status.success() {
            return Err(format!(
                "given again it fails: {}",
                said(&output).trim_end()
            ));
        }
        let left = files_in(desk);
        let differs = |name: &&String| left.get(*name) != whole.files.get(*name);
        match left.keys().chain(whole.files.keys()).find(differs) {
            None => Ok(()),
            Some(name) if !whole.files.contains_key(name) => {
                Err(format!("given again it leaves {name}"))
            }
            Some(name) => Err(format!("given again it leaves another {name}")),
        }
    }
}

/// Whether a landscape keeps this file until the very end. A folder that is otherwise complete is finished by the next run.
fn is_of_last_moments(name: &str) -> bool {
    let (folder, name) = name.rsplit_once('/').unwrap_or_default();
    folder.ends_with(".landscape") && matches!(name, "journal" | ".unfinished")
}

/// The unit that appears at once: a landscape or a file.
fn unit(name: &str) -> &str {
    match name.split_once('/') {
        Some((folder, _)) if folder.ends_with(".landscape") => folder,
        _ => name,
    }
}

fn of_unit<'a>(files: &'a Files, wanted: &str) -> BTreeMap<&'a str, &'a [u8]> {
    let files = files
        .iter()
        .map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
    files.filter(|(name, _)| unit(name) == wanted).collect()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// All files of a folder, except those that describe the run.
fn files_in(desk: &Desk) -> Files {
    fn walk(folder: &Path, root: &Path, files: &mut Files) {
        for entry in fs::read_dir(folder).unwrap() {
            let path: PathBuf = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, root, files);
            } else if !path.ends_with("timings.json") {
                let name = path.strip_prefix(root).unwrap().to_str().unwrap();
                files.insert(name.to_owned(), fs::read(&path).unwrap());
            }
        }
    }
    let mut files = Files::new();
    walk(desk.folder.path(), desk.folder.path(), &mut files);
    files
}

fn write_all(desk: &Desk, files: &Files) {
    for (name, bytes) in files {
        let path = desk.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
}

/// Inputs of the commands, made by other commands.
fn materials() -> &'static Files {
    static MATERIALS: OnceLock<Files> = OnceLock::new();
    MATERIALS.get_or_init(|| {
        let desk = Desk::empty();
        let run = |line: &str| {
            let output = desk.run(&format!("{line} -q"));
            assert!(output.status.success(), "{line}: {}", said(&output));
        };
        run(SYNTH.line);
        run(FEW);
        run("export g.parquet csv");
        run(SURFACE.line);
        fs::create_dir(desk.path("database")).unwrap();
        for name in ["min.data", "ts.data"] {
            let from = desk.path(SURFACE.output).join(name);
            fs::copy(from, desk.path("database").join(name)).unwrap();
        }
        if budget().is_some() {
            run(BUILD.line);
            run("synth --object ball -n 30 --steps 1 --keep all -o thirty.parquet");
            plant(&desk, "named.parquet", 30, &["Ring", "Tripod"], false);
        }
        let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/deepsdf");
        for (from, to) in [
            ("small_model.safetensors", "model.safetensors"),
            ("small_specs.json", "specs.json"),
        ] {
            fs::copy(reference.join(from), desk.path(to)).unwrap();
        }
        desk.write("cube.obj", CUBE);
        files_in(&desk)
    })
}

const CUBE: &str = "v 0 0 0\nv 0.05 0 0\nv 0.05 0.05 0\nv 0 0.05 0\nv 0 0 0.05\nv 0.05 0 0.05\nv 0.05 0.05 0.05\nv 0 0.05 0.05\n\
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Requested total number of stops.
fn budget() -> Option<usize> {
    let count = std::env::var("LANDSCAPE_STOPS").ok()?;
    Some(count.parse().expect("LANDSCAPE_STOPS is a number"))
}

/// The library of `stop.c`; `None` if it cannot be built.
fn library(folder: &TempDir) -> Option<PathBuf> {
    let library = folder.path().join("stop.so");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/crashes/stop.c");
    let compiled = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-o"])
        .args([&library, &source])
        .arg("-ldl")
        .status();
    (cfg!(target_os = "linux") && compiled.is_ok_and(|status| status.success())).then_some(library)
}

#[test]
fn every_command_that_writes_may_be_stopped() {
    let folder = TempDir::new().unwrap();
    let Some(library) = library(&folder) else {
        crate::skipped::skipped("no C compiler on Linux");
        return;
    };
    let only = std::env::var("LANDSCAPE_STOPS_VERB").ok();
    let seed: u64 = std::env::var("LANDSCAPE_STOPS_SEED").map_or(0, |seed| seed.parse().unwrap());
    let verbs: Vec<Verb> = verbs()
        .filter(|verb| budget().is_some() || verb.quick)
        .filter(|verb| only.as_ref().is_none_or(|only| only == verb.name))
        .collect();
    let each = budget().map_or(3, |all| all.div_ceil(verbs.len()));
    let mut faults = Vec::new();
    for (place, verb) in verbs.iter().enumerate() {
        let whole = verb.whole(&library);
        for (at, number) in (1000 * seed..).take(each).enumerate() {
            // Commands that are stopped a few times only begin with different ways.
            let how = WAYS[(3 * place + at) % WAYS.len()];
            if let Err(fault) = verb.stopped(how, number, &whole, &library) {
                println!("{}: {fault}", verb.name);
                faults.push(format!("{}: {fault}", verb.name));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
