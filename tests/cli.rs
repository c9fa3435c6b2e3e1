//! The whole tool as a user runs it: a tiny experiment, threads, interruptions, and every mistake with its sentence.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt32Type};
use arrow_array::{ArrayRef, FixedSizeListArray, Float64Array, ListArray};
use desk::{Desk, assert_says};
use landscape::grasp::hand::Hand;
use landscape::grasp::object::Object;
use landscape::grasp::{EnergySettings, GraspEnergy, judge};
use landscape::space::{PoseSpace, Space, Symmetry};
use landscape::store::{Grasp, GraspFile, LandscapeFiles, Overrides};
use parts::Parts;
use records::records;
use serde_json::{Value, json};

mod desk;
mod parts;
mod records;

impl Desk {
    fn with_grasps() -> Self {
        let desk = Self::empty();
        fs::write(desk.path("g.parquet"), grasps()).unwrap();
        desk
    }

    /// Runs a command that must succeed and returns what it said on standard error.
    fn succeed(&self, line: &str) -> String {
        let output = self.run(line);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "landscape {line}: {said}");
        said
    }

    /// The sentence of a mistake that is found before anything is written.
    fn early_mistake(&self, line: &str) -> String {
        let before = contents(self.folder.path());
        let sentence = self.mistake(line);
        assert_eq!(contents(self.folder.path()), before, "landscape {line}");
        sentence
    }

    /// The sentence with which `build` refuses the grasps spoilt in this way.
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

    /// Continues a command, which must not do again what its journal holds.
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

const SYNTH: &str = "synth --object ball -n 6 --steps 400 --keep all --seed 1 --quiet";
const LONG_SYNTH: &str =
    "synth --object ball -n 12 --steps 2000 --keep all --seed 1 --threads 1 -q";
const BUILD: &str = "build g.parquet --first 3 --quiet";

/// `g.parquet` of [`SYNTH`], made once, on one thread.
fn grasps() -> &'static [u8] {
    static GRASPS: OnceLock<Vec<u8>> = OnceLock::new();
    GRASPS.get_or_init(|| {
        let desk = Desk::empty();
        desk.succeed(&format!("{SYNTH} --threads 1 -o g.parquet"));
        assert_eq!(names(desk.folder.path()), ["g.parquet"]);
        fs::read(desk.path("g.parquet")).unwrap()
    })
}

/// The folder of [`BUILD`], made once, on one thread.
fn landscape() -> &'static Desk {
    static LANDSCAPE: OnceLock<Desk> = OnceLock::new();
    LANDSCAPE.get_or_init(|| {
        let desk = Desk::with_grasps();
        desk.succeed(&format!("{BUILD} --threads 1"));
        assert_eq!(names(desk.folder.path()), ["g.landscape", "g.parquet"]);
        desk
    })
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
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

/// What of a landscape folder must not depend on threads and interruptions.
fn promised(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    names(folder)
        .into_iter()
        .filter(|name| name != "timings.json")
        .map(|name| (name.clone(), fs::read(folder.join(name)).unwrap()))
        .collect()
}

#[test]
fn a_tiny_experiment() {
    let folder = landscape().path("g.landscape");
    let found = names(&folder);
    let expected = [
        "barriers.graphml",
        "barriers.png",
        "barriers.svg",
        "disconnectivity.png",
        "disconnectivity.svg",
        "edges.parquet",
        "landscape.json",
        "minima.parquet",
        "paths.parquet",
        "rarefaction.svg",
        "summary.md",
        "timings.json",
        "tree.nwk",
    ];
    for name in expected {
        assert!(found.iter().any(|file| file == name), "{name} of {found:?}");
    }
    assert!(
        !found
            .iter()
            .any(|name| name.ends_with(".partial") || name == "journal")
    );
    let text = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    for name in found.iter().filter(|name| has_ending(name, "svg")) {
        let svg = text(name);
        assert!(svg.starts_with("<svg") && svg.contains("<text"), "{name}");
        assert_says(&svg, &["3 grasps, human hand on ball"]);
    }
    for name in found.iter().filter(|name| has_ending(name, "png")) {
        assert!(
            fs::read(folder.join(name))
                .unwrap()
                .starts_with(b"\x89PNG\r\n")
        );
    }

    let manifest: Value = serde_json::from_str(&text("landscape.json")).unwrap();
    assert_eq!(manifest["format"], "landscape");
    let files = LandscapeFiles::read(&folder).unwrap();
    let counts = &files.manifest.counts;
    assert_eq!(manifest["counts"]["minima"], counts.minima);
    assert_eq!(counts.grasps, 3);
    assert_eq!(counts.minima, files.minima.len() as u64);
    assert_eq!(counts.pairs, files.edges.len() as u64);
    assert!((2..=counts.grasps).contains(&counts.minima));
    assert!((1..=counts.minima).contains(&counts.groups));
    assert!((1..=counts.groups).contains(&counts.components));
    assert!(
        counts.pairs >= counts.minima - 1,
        "a spanning tree at least"
    );
    assert_eq!(files.manifest.evidence.values().sum::<u64>(), counts.pairs);
    let members: BTreeSet<u64> = files
        .minima
        .iter()
        .flat_map(|row| row.members.clone())
        .collect();
    assert_eq!(members.into_iter().collect::<Vec<_>>(), [0, 1, 2]);
    for edge in &files.edges {
        let floor = [edge.a, edge.b]
            .map(|id| files.minima[usize::try_from(id).unwrap()].energy)
            .into_iter()
            .fold(f64::NEG_INFINITY, f64::max);
        let height = edge.height.expect("every pair on a ball can be joined");
        assert!(
            height >= floor - 1e-9,
            "a pass lies above both of its minima"
        );
        let top = files
            .paths
            .iter()
            .filter(|row| (row.a, row.b) == (edge.a, edge.b))
            .map(|row| row.energy)
            .fold(f64::NEG_INFINITY, f64::max);
        assert!(
            top <= height + 1e-9,
            "the path {} {} passes below its height",
            edge.a,
            edge.b
        );
    }
    let tree = text("tree.nwk");
    for minimum in &files.minima {
        assert!(tree.contains(&format!("m{}", minimum.id)), "{tree}");
    }
    assert!(tree.trim_end().ends_with(';'));
    assert_says(
        &text("summary.md"),
        &["# 3 grasps of the human hand on ball", "minima"],
    );
    // The command that is written into the landscape makes the same one.
    let command = files.manifest.command.strip_prefix("landscape ").unwrap();
    let again = Desk::with_grasps();
    again.succeed(&format!("{command} --quiet --threads 2"));
    assert_eq!(
        promised(&again.path("g.landscape")),
        promised(&folder),
        "on two threads"
    );
}

#[test]
fn a_finished_landscape_is_drawn_compared_and_exchanged() {
    let desk = landscape();
    let out = Desk::empty();
    let folder = desk.path("g.landscape");
    let whole = out.path("whole");
    let line = format!("draw {} -o {}", folder.display(), whole.display());
    out.succeed(&line);
    let text = |path: &Path| fs::read_to_string(path).unwrap();
    // What the support of merges rests on.
    assert!(folder.join("resampled.parquet").is_file());
    // Nothing hidden, nothing changed.
    for name in ["tree.nwk", "tree.dot", "tree.json", "barriers.graphml"] {
        assert_eq!(text(&folder.join(name)), text(&whole.join(name)), "{name}");
    }
    for name in [
        "barriers.svg",
        "barriers_minima.svg",
        "disconnectivity.svg",
        "disconnectivity_minima.svg",
    ] {
        assert_eq!(text(&folder.join(name)), text(&whole.join(name)), "{name}");
    }
    let output = out.run(&format!("diff {0} {0} --json", folder.display()));
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    let files = LandscapeFiles::read(&folder).unwrap();
    assert_eq!(
        told["matches"].as_array().unwrap().len(),
        files.minima.len()
    );
    assert_eq!(told["likeness"]["largest_change"], 0.0);
    assert_eq!(told["within"], 0.005);
    fs::create_dir(out.path("data")).unwrap();
    for name in ["min.data", "ts.data"] {
        fs::copy(folder.join(name), out.path("data").join(name)).unwrap();
    }
    out.succeed("import data");
    let read = LandscapeFiles::read(&out.path("data.landscape")).unwrap();
    let energies = |files: &LandscapeFiles| -> Vec<u64> {
        files
            .minima
            .iter()
            .map(|row| row.energy.to_bits())
            .collect()
    };
    assert_eq!(energies(&read), energies(&files));
    assert_eq!(read.edges.len(), files.edges.len());
}

#[test]
fn grasps_do_not_depend_on_threads() {
    let desk = Desk::empty();
    desk.succeed(&format!("{SYNTH} --threads 2 -o other.parquet"));
    assert_eq!(fs::read(desk.path("other.parquet")).unwrap(), grasps());
    let (file, warnings) =
        GraspFile::read(&desk.path("other.parquet"), Overrides::default()).unwrap();
    assert_eq!(warnings, []);
    assert_eq!(
        file.grasps.iter().map(|grasp| grasp.id).collect::<Vec<_>>(),
        [0, 1, 2, 3, 4, 5]
    );
    assert!(
        file.metadata
            .command
            .starts_with("landscape synth --hand human --object ball -n 6 --steps 400")
    );
}

#[test]
fn an_interrupted_synthesis_continues() {
    let whole = Desk::empty();
    whole.succeed(LONG_SYNTH);
    let whole = fs::read(whole.path("grasps.parquet")).unwrap();

    let desk = Desk::empty();
    let journal = "grasps.parquet.partial";
    desk.interrupt(LONG_SYNTH, journal, 2);
    assert_eq!(names(desk.folder.path()), [journal]);

    // Other settings would give other chains: they neither mix nor destroy.
    let other = LONG_SYNTH.replace("--seed 1", "--seed 2");
    let sentence = desk.early_mistake(&other);
    assert_says(&sentence, &[journal, "other input or settings", "--fresh"]);

    desk.resume(LONG_SYNTH, journal);
    assert_eq!(names(desk.folder.path()), ["grasps.parquet"]);
    assert!(
        fs::read(desk.path("grasps.parquet")).unwrap() == whole,
        "same bytes"
    );

    desk.interrupt(LONG_SYNTH, journal, 1);
    desk.succeed(&format!(
        "{} --fresh",
        LONG_SYNTH
            .replace("-n 12", "-n 2")
            .replace("--seed 1", "--seed 2")
    ));
    let (file, _) = GraspFile::read(&desk.path("grasps.parquet"), Overrides::default()).unwrap();
    assert_eq!((file.metadata.seed, file.grasps.len()), (2, 2));
    assert_eq!(names(desk.folder.path()), ["grasps.parquet"]);
}

/// Chains from given grasps: one for each row unless told otherwise, near its grasp, the same on any number of threads.
#[test]
fn synthesis_from_given_grasps() {
    let desk = Desk::with_grasps();
    let read = |name: &str| {
        GraspFile::read(&desk.path(name), Overrides::default())
            .unwrap()
            .0
    };
    let given = read("g.parquet");
    let pose = |grasp: &Grasp| {
        let mut x = grasp.translation_m.to_vec();
        x.extend(grasp.rotation_wxyz);
        x.extend(&grasp.joints_rad);
        x
    };
    let space = PoseSpace::new(Hand::human().pose_metric(), Symmetry::None);
    let apart = |name: &str| -> Vec<f64> {
        let rows = read(name).grasps;
        rows.iter()
            .map(|row| {
                let from = &given.grasps[usize::try_from(row.id).unwrap() % given.grasps.len()];
                assert!(
                    row.source.ends_with(&format!("from {}", from.id)),
                    "{}",
                    row.source
                );
                space.distance(&pose(row), &pose(from))
            })
            .collect()
    };
    let line = "synth --from g.parquet --steps 60 --keep all --seed 3 -q";
    desk.succeed(&format!("{line} -o near.parquet --threads 1"));
    desk.succeed(&format!("{line} -o near2.parquet --threads 2"));
    assert_eq!(
        fs::read(desk.path("near.parquet")).unwrap(),
        fs::read(desk.path("near2.parquet")).unwrap()
    );
    let near = read("near.parquet");
    assert_eq!(near.grasps.len(), given.grasps.len());
    assert_eq!(
        (&near.metadata.hands, &near.metadata.objects),
        (&given.metadata.hands, &given.metadata.objects)
    );
    assert_says(
        &near.metadata.command,
        &["landscape synth --from g.parquet -n 6 --steps 60"],
    );
    // Not worse than what was given: as strict, and of lower energy where neither or both pass the strict filter.
    let hand = Arc::new(Hand::human());
    let ball = Arc::new(Object::named("ball").unwrap());
    let energy = GraspEnergy::new(hand, ball, EnergySettings::default()).unwrap();
    let strict = |grasp: &Grasp| judge(&energy, &pose(grasp), &grasp.contacts).passes_strict();
    let mut lower = 0;
    for (row, from) in near.grasps.iter().zip(&given.grasps) {
        let (before, after) = (strict(from), strict(row));
        assert!(
            after >= before,
            "row {} is no strict grasp any more",
            row.id
        );
        assert!(
            (after && !before) || row.energy <= from.energy + 1e-12,
            "row {}: {} from {}",
            row.id,
            row.energy,
            from.energy
        );
        lower += usize::from(row.energy < from.energy);
    }
    assert!(lower > 0, "nothing was refined");

    let mean = |lengths: Vec<f64>| lengths.iter().sum::<f64>() / lengths.len() as f64;
    let refined_m = mean(apart("near.parquet"));
    assert!(refined_m < 0.02, "refined {refined_m} m away");

    desk.succeed(&format!("{line} --perturb 60 -n 13 -o far.parquet"));
    let far = read("far.parquet").grasps;
    assert_eq!(
        far.iter().map(|row| row.id).collect::<Vec<_>>(),
        (0..13).collect::<Vec<_>>()
    );
    let perturbed_m = mean(apart("far.parquet"));
    assert!(
        perturbed_m > 2.0 * refined_m && perturbed_m < 0.1,
        "{refined_m} {perturbed_m}"
    );
    assert_ne!(
        pose(&far[0]),
        pose(&far[6]),
        "the same grasp, moved differently"
    );
    assert_says(
        &read("far.parquet").metadata.command,
        &["--from g.parquet --perturb 60 -n 13"],
    );
}

/// Hand and object are those in the file: neither the files they came from nor any flag is needed.
#[test]
fn given_grasps_bring_their_hand_and_object() {
    let desk = Desk::empty();
    let [urdf, side] = Hand::human_description();
    fs::write(desk.path("own.urdf"), urdf).unwrap();
    fs::write(desk.path("own.json"), side).unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/objects");
    let mesh = fs::read_to_string(data.join("ball.obj")).unwrap();
    fs::write(desk.path("globe.obj"), mesh).unwrap();
    let description = fs::read_to_string(data.join("ball.json")).unwrap();
    fs::write(
        desk.path("globe.json"),
        description.replace("\"ball\"", "\"globe\""),
    )
    .unwrap();
    let line = "--steps 60 --keep all --seed 3 -q";
    desk.succeed(&format!(
        "synth --hand own.urdf --object globe.obj -n 2 {line} -o g.parquet"
    ));
    for name in ["own.urdf", "own.json", "globe.obj", "globe.json"] {
        fs::remove_file(desk.path(name)).unwrap();
    }
    desk.succeed(&format!("synth --from g.parquet {line} -o refined.parquet"));
    let read = |name: &str| {
        GraspFile::read(&desk.path(name), Overrides::default())
            .unwrap()
            .0
    };
    let (given, refined) = (read("g.parquet"), read("refined.parquet"));
    let names = |file: &GraspFile| {
        (
            file.metadata.hands[0].name.clone(),
            file.metadata.objects[0].name.clone(),
        )
    };
    assert_eq!(names(&given), ("own".to_owned(), "globe".to_owned()));
    assert_eq!(names(&refined), names(&given));
    assert_eq!(refined.metadata.objects, given.metadata.objects);
    assert!(
        refined
            .grasps
            .iter()
            .all(|row| (&*row.hand, &*row.object) == ("own", "globe"))
    );
}

#[test]
fn mistakes_with_given_grasps() {
    let desk = Desk::with_grasps();
    let parts = Parts::of(&desk.path("g.parquet"));
    let mut scales = parts.floats("scale");
    scales[0] = 1.5;
    let mixed = parts.set("scale", Float64Array::from(scales));
    mixed.write(&desk.path("mixed.parquet"));
    fs::write(desk.path("text.parquet"), "no table").unwrap();
    let cases: [(&str, &[&str]); 8] = [
        ("synth --from absent.parquet", &["absent.parquet"]),
        ("synth --from text.parquet", &["text.parquet", "Parquet"]),
        (
            "synth --from mixed.parquet",
            &["--from mixed.parquet", "2 pairs of hand and object"],
        ),
        (
            "synth --from g.parquet --perturb -1",
            &["--perturb -1", "millimetres"],
        ),
        (
            "synth --from g.parquet --perturb nan",
            &["--perturb NaN", "millimetres"],
        ),
        ("synth --from g.parquet -n 0", &["-n 0"]),
        ("synth --object ball --perturb 3", &["--from"]),
        ("synth", &["--object"]),
    ];
    for (line, words) in cases {
        assert_says(&desk.early_mistake(line), words);
    }
}

/// The error advises to keep others or run more chains: that must then work, and use what was computed.
#[test]
fn chains_of_a_run_without_success_are_not_lost() {
    let desk = Desk::empty();
    let few = "synth --object ball --preset paper --steps 1 -n 1 -q";
    assert_says(
        &desk.mistake(few),
        &["none of the 1 chains passed", "--keep", "-n"],
    );
    assert_eq!(names(desk.folder.path()), ["grasps.parquet.partial"]);
    desk.resume(
        "synth --object ball --preset paper --steps 1 -n 2 --keep all -q",
        "grasps.parquet.partial",
    );
    let fresh = Desk::empty();
    fresh.succeed("synth --object ball --preset paper --steps 1 -n 2 --keep all -q");
    assert_eq!(contents_by_name(&desk), contents_by_name(&fresh));
}

fn contents_by_name(desk: &Desk) -> Vec<(String, Vec<u8>)> {
    let read = |name: String| (name.clone(), fs::read(desk.path(&name)).unwrap());
    names(desk.folder.path()).into_iter().map(read).collect()
}

#[test]
fn an_interrupted_build_continues() {
    let desk = Desk::with_grasps();
    let journal = "g.landscape.partial/journal";
    let one_thread = format!("{BUILD} --threads 1");
    desk.interrupt(&one_thread, journal, 2);
    assert_eq!(
        names(desk.folder.path()),
        ["g.landscape.partial", "g.parquet"]
    );

    let other = "build g.parquet --first 3 --seed 5 --quiet";
    let before = records(&desk.path(journal));
    assert_says(
        &desk.mistake(other),
        &[journal, "other input or settings", "--fresh"],
    );
    assert_eq!(records(&desk.path(journal)), before);

    desk.resume(BUILD, journal);
    assert_eq!(names(desk.folder.path()), ["g.landscape", "g.parquet"]);
    assert_eq!(
        promised(&desk.path("g.landscape")),
        promised(&landscape().path("g.landscape"))
    );

    // The finished landscape stays until the next one is complete.
    desk.interrupt(&format!("{other} --fresh"), journal, 1);
    assert_eq!(
        promised(&desk.path("g.landscape")),
        promised(&landscape().path("g.landscape"))
    );
    desk.succeed("build g.parquet --first 2 --quiet --fresh");
    let files = LandscapeFiles::read(&desk.path("g.landscape")).unwrap();
    assert_eq!(files.manifest.counts.grasps, 2);
    assert_eq!(names(desk.folder.path()), ["g.landscape", "g.parquet"]);
}

/// Every step of the drop is simulated, so that there is time to kill it. Friction that some hold by, and some do not.
const PATIENT: &str = "protocol = \"drop\"\nrest = { time_s = 1000.0 }\n\
                       friction = { hand = 0.3, object = 0.3, combine = \"multiply\" }\n";
const STABILITY: &str = "stability g.parquet --settings p.toml -q -o held.parquet";

#[test]
fn an_interrupted_simulation_continues() {
    let desk = Desk::with_grasps();
    fs::write(desk.path("p.toml"), PATIENT).unwrap();
    desk.succeed(&STABILITY.replace("held", "whole"));
    let whole = fs::read(desk.path("whole.parquet")).unwrap();
    let journal = "held.parquet.partial";
    for threads in [1, 2] {
        let line = format!("{STABILITY} --threads {threads}");
        desk.interrupt(&line, journal, 2);
        assert!(!desk.path("held.parquet").exists());

        let other = desk.early_mistake("stability g.parquet -o held.parquet");
        assert_says(&other, &[journal, "other input or settings", "--fresh"]);

        desk.resume(&format!("{line} --resume"), journal);
        let continued = fs::read(desk.path("held.parquet")).unwrap();
        assert!(continued == whole, "same bytes, {threads} threads");
        fs::remove_file(desk.path("held.parquet")).unwrap();
        let left = ["g.parquet", "p.toml", "whole.parquet"];
        assert_eq!(names(desk.folder.path()), left);
    }
    let nothing = desk.early_mistake(&format!("{STABILITY} --resume"));
    assert_says(&nothing, &[journal, "no interrupted run"]);
}

#[test]
fn what_held_in_simulation_is_mapped_and_marked() {
    let desk = Desk::with_grasps();
    let sentence = desk.early_mistake("build g.parquet --only-stable");
    assert_says(&sentence, &["--only-stable", "landscape stability"]);
    fs::write(desk.path("p.toml"), PATIENT).unwrap();
    desk.succeed(STABILITY);
    let (judged, _) = GraspFile::read(&desk.path("held.parquet"), Overrides::default()).unwrap();
    let ids = |stable: bool| -> BTreeSet<u64> {
        let grasps = judged.grasps.iter();
        grasps
            .filter(|grasp| grasp.stable == Some(stable))
            .map(|grasp| grasp.id)
            .collect()
    };
    let (stable, unstable) = (ids(true), ids(false));
    assert!(
        stable.len() > 1 && !unstable.is_empty(),
        "{stable:?} {unstable:?}"
    );

    desk.succeed("build held.parquet --only-stable -q -o held.landscape");
    let files = LandscapeFiles::read(&desk.path("held.landscape")).unwrap();
    let members = files.minima.iter().flat_map(|row| row.members.clone());
    assert_eq!(members.collect::<BTreeSet<u64>>(), stable);

    desk.succeed("build g.parquet -q -o all.landscape");
    let sentence = desk.mistake("draw all.landscape --stability g.parquet");
    assert_says(
        &sentence,
        &["--stability g.parquet", "no grasp was simulated"],
    );
    desk.succeed("draw all.landscape --stability held.parquet -q -o marked");
    desk.succeed("draw all.landscape -q -o plain");
    let files = LandscapeFiles::read(&desk.path("all.landscape")).unwrap();
    let held: Vec<bool> = files
        .minima
        .iter()
        .map(|row| {
            let held = row.members.iter().filter(|id| stable.contains(id)).count();
            2 * held >= row.members.len()
        })
        .collect();
    for name in ["barriers_minima.svg", "disconnectivity_minima.svg"] {
        let [marked, plain] = ["marked", "plain"]
            .map(|folder| fs::read_to_string(desk.path(folder).join(name)).unwrap());
        for (word, expected) in [
            (">stable", held.contains(&true)),
            (">unstable", held.contains(&false)),
        ] {
            let squeezed: String = marked.split_whitespace().collect();
            assert_eq!(squeezed.contains(word), expected, "{word} in {name}");
            let squeezed: String = plain.split_whitespace().collect();
            assert!(!squeezed.contains(word), "{word} in the plain {name}");
        }
    }
}

#[test]
fn no_such_file() {
    let desk = Desk::empty();
    assert_eq!(
        desk.early_mistake("build g.parquet"),
        "no such file: g.parquet"
    );
    assert_eq!(
        desk.early_mistake("build absent/g.parquet"),
        "no such file: absent/g.parquet"
    );
}

#[test]
fn not_parquet() {
    let desk = Desk::empty();
    fs::write(desk.path("g.parquet"), "id,object\n1,ball\n").unwrap();
    assert_says(
        &desk.early_mistake("build g.parquet"),
        &["g.parquet is not a Parquet file or is damaged"],
    );
    fs::write(desk.path("g.parquet"), "").unwrap();
    assert_says(
        &desk.early_mistake("build g.parquet"),
        &["g.parquet is not a Parquet file or is damaged"],
    );
    let whole = grasps();
    fs::write(desk.path("g.parquet"), &whole[..whole.len() / 2]).unwrap();
    assert_says(
        &desk.early_mistake("build g.parquet"),
        &["g.parquet is not a Parquet file or is damaged"],
    );
}

#[test]
fn wrong_schema_version() {
    let sentence =
        Desk::refusal(|parts| metadata(parts, |value| value["schema_version"] = json!(7)));
    assert_eq!(
        sentence,
        "spoilt.parquet has schema version 7, but this program knows version 1 only"
    );
}

#[test]
fn missing_column() {
    let sentence = Desk::refusal(|parts| parts.without("rotation_wxyz"));
    assert_says(&sentence, &["spoilt.parquet has no column `rotation_wxyz`"]);
}

#[test]
fn not_a_number() {
    let sentence = Desk::refusal(|parts| {
        let mut values = parts.floats("energy");
        values[2] = f64::NAN;
        parts.set("energy", Float64Array::from(values))
    });
    assert_says(&sentence, &["spoilt.parquet, row 2", "`energy` holds NaN"]);
}

#[test]
fn infinite() {
    let sentence = Desk::refusal(|parts| {
        let lists = change(&parts, "translation_m", |row, values| {
            if row == 1 {
                values[2] = f64::INFINITY;
            }
        });
        parts.set("translation_m", lists)
    });
    assert_says(
        &sentence,
        &["spoilt.parquet, row 1", "`translation_m` holds inf"],
    );
}

#[test]
fn quaternion_not_unit() {
    let sentence = Desk::refusal(|parts| {
        let lists = change(&parts, "rotation_wxyz", |row, values| {
            if row == 3 {
                values.copy_from_slice(&[1.0, 1.0, 0.0, 0.0]);
            }
        });
        parts.set("rotation_wxyz", lists)
    });
    assert_says(
        &sentence,
        &[
            "spoilt.parquet, row 3",
            "`rotation_wxyz` has length 1.41",
            "expected 1",
        ],
    );
}

#[test]
fn joint_far_beyond_its_limit() {
    let (name, [_, upper]) = first_joint();
    let sentence = Desk::refusal(|parts| {
        let lists = change(&parts, "joints_rad", |row, values| {
            if row == 4 {
                values[0] = upper + 1.01;
            }
        });
        parts.set("joints_rad", lists)
    });
    assert_says(
        &sentence,
        &[
            "spoilt.parquet, row 4",
            &name,
            "more than 1 rad beyond its limits",
        ],
    );
}

#[test]
fn joint_beyond_its_limit_as_published() {
    let (name, [_, upper]) = first_joint();
    let desk = Desk::with_grasps();
    let parts = Parts::of(&desk.path("g.parquet"));
    let lists = change(&parts, "joints_rad", |row, values| {
        if row == 1 {
            values[0] = upper + 0.58;
        }
    });
    parts
        .set("joints_rad", lists)
        .write(&desk.path("g.parquet"));
    let said = desk.succeed("build g.parquet --first 2");
    let warning =
        format!("farthest is `{name}` in row 1, by 0.5800 rad; they are kept as they are");
    assert_says(&said, &["warning: ", &warning]);
    let files = LandscapeFiles::read(&desk.path("g.landscape")).unwrap();
    assert!(
        files
            .manifest
            .warnings
            .iter()
            .any(|told| told.ends_with(&warning)),
        "{:?}",
        files.manifest.warnings
    );
    assert_eq!(files.manifest.counts.grasps, 2, "kept");
}

#[test]
fn contact_out_of_range() {
    let sentence = Desk::refusal(|parts| {
        let lists =
            (0..6).map(|row| Some([Some(0), Some(5), Some(if row == 2 { 9999 } else { 7 })]));
        let lists = ListArray::from_iter_primitive::<UInt32Type, _, _>(lists);
        parts.set("contacts", lists)
    });
    assert_says(
        &sentence,
        &[
            "spoilt.parquet, row 2",
            "contact 9999 does not exist",
            "`human`",
            "surface points",
        ],
    );
}

#[test]
fn hand_that_does_not_match_its_description() {
    let sentence = Desk::refusal(|parts| {
        metadata(parts, |value| {
            value["hands"][0]["joint_names"][0] = json!("elbow");
        })
    });
    assert_says(
        &sentence,
        &["spoilt.parquet: hand `human` does not match", "`elbow`"],
    );
    let sentence = Desk::refusal(|parts| {
        metadata(parts, |value| {
            value["hands"][0]["surface_points"] = json!(5000);
        })
    });
    assert_says(
        &sentence,
        &[
            "spoilt.parquet: hand `human` does not match",
            "5000 surface points",
        ],
    );
    let sentence = Desk::refusal(|parts| {
        metadata(parts, |value| value["hands"][0]["description"] = json!([]))
    });
    assert_says(
        &sentence,
        &[
            "spoilt.parquet: the file does not describe hand `human`",
            "--hand",
        ],
    );
}

#[test]
fn missing_object() {
    let sentence = Desk::refusal(|parts| {
        metadata(parts, |value| value["objects"][0]["mesh_obj"] = json!(null))
    });
    assert_says(
        &sentence,
        &["spoilt.parquet", "mesh of object `ball`", "--object"],
    );
    let sentence = Desk::refusal(|parts| metadata(parts, |value| value["objects"] = json!([])));
    assert_says(&sentence, &["spoilt.parquet", "`ball`", "described"]);
    let desk = Desk::with_grasps();
    assert_says(
        &desk.early_mistake("build g.parquet --object teapot"),
        &["--object teapot", "ball"],
    );
    assert_says(
        &desk.early_mistake("build g.parquet --hand claw"),
        &["--hand claw", "human"],
    );
}

#[test]
fn no_grasps() {
    let sentence = Desk::refusal(|mut parts| {
        for (_, array) in &mut parts.columns {
            *array = array.slice(0, 0);
        }
        parts
    });
    assert_eq!(sentence, "spoilt.parquet holds no grasps");
}

#[test]
fn one_grasp_only() {
    let sentence = Desk::refusal(|mut parts| {
        for (_, array) in &mut parts.columns {
            *array = array.slice(0, 1);
        }
        parts
    });
    assert_says(
        &sentence,
        &["spoilt.parquet: only one grasp", "at least two"],
    );
    let desk = Desk::with_grasps();
    assert_says(
        &desk.early_mistake("build g.parquet --first 1"),
        &["--first 1", "at least two"],
    );
    assert_says(
        &desk.early_mistake("build g.parquet --first 0"),
        &["--first 0", "at least two"],
    );
}

#[test]
fn identical_grasps() {
    let desk = Desk::with_grasps();
    let (mut file, _) = GraspFile::read(&desk.path("g.parquet"), Overrides::default()).unwrap();
    let first = file.grasps[0].clone();
    file.grasps = (0..4)
        .map(|id| Grasp {
            id,
            ..first.clone()
        })
        .collect();
    file.write(&desk.path("same.parquet")).unwrap();
    assert_says(
        &desk.mistake("build same.parquet"),
        &["same.parquet: all 4 grasps lie in one minimum"],
    );
    assert!(!desk.path("same.landscape").exists());
    assert!(!desk.path("same.landscape.partial").exists());
}

#[test]
fn unwritable_output() {
    let desk = Desk::with_grasps();
    fs::write(desk.path("taken"), "years of work").unwrap();
    fs::create_dir(desk.path("folder")).unwrap();
    fs::write(desk.path("folder/thesis.tex"), "years of work").unwrap();
    for command in [
        "build g.parquet",
        "synth --object ball -n 1 --steps 1 --keep all",
    ] {
        for (output, folder) in [("absent/x", "absent"), ("taken/x", "taken")] {
            let sentence = desk.early_mistake(&format!("{command} -o {output}"));
            assert_eq!(
                sentence,
                format!("--output {output}: there is no folder {folder}")
            );
        }
    }
    for output in ["taken", "folder"] {
        let sentence = desk.early_mistake(&format!("build g.parquet -o {output}"));
        assert_says(
            &sentence,
            &[&format!("{output} exists and was not made by landscape")],
        );
    }
    for output in ["folder", "."] {
        let sentence = desk.early_mistake(&format!("synth --object ball -n 1 -o {output}"));
        assert_says(&sentence, &[&format!("--output {output}"), "folder"]);
    }
}

/// Grasps of others come without our metadata; hand and object are then named, and the energy is the default one.
#[test]
fn grasps_of_others() {
    let foreign = |mut parts: Parts| {
        parts.metadata = None;
        parts
    };
    assert_says(
        &Desk::refusal(foreign),
        &[
            "spoilt.parquet",
            "does not describe its hand and object",
            "--hand",
        ],
    );
    let desk = Desk::with_grasps();
    foreign(Parts::of(&desk.path("g.parquet"))).write(&desk.path("own.parquet"));
    let said = desk.succeed("build own.parquet --hand human --object ball --first 2");
    assert_says(&said, &["warning: the file does not tell the energy"]);
    desk.succeed("build g.parquet --first 2 --quiet");
    let energies = |name: &str| {
        let files = LandscapeFiles::read(&desk.path(name)).unwrap();
        files
            .minima
            .iter()
            .map(|row| row.energy.to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(energies("own.landscape"), energies("g.landscape"));
}

#[test]
fn mistakes_in_flags() {
    let desk = Desk::with_grasps();
    fs::write(desk.path("typo.toml"), "[energy]\nprior_wieght = 1.0\n").unwrap();
    fs::write(
        desk.path("negative.toml"),
        "[energy]\ndistance_weight = -1.0\n",
    )
    .unwrap();
    fs::write(desk.path("torn.toml"), "[energy").unwrap();
    fs::write(desk.path("claw.urdf"), "<robot").unwrap();
    fs::write(desk.path("empty.obj"), "# nothing\n").unwrap();
    fs::write(
        desk.path("open.obj"),
        "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n",
    )
    .unwrap();
    let cases: [(&str, &[&str]); 17] = [
        (
            "synth --object teapot",
            &[
                "--object teapot",
                "neither a file nor an object",
                "ball",
                "jar",
            ],
        ),
        (
            "synth --object ball --hand claw",
            &["--hand claw", "neither a file nor a hand", "human"],
        ),
        (
            "synth --object ball --hand claw.urdf",
            &["claw.urdf", "URDF cannot be read"],
        ),
        (
            "synth --object open.obj",
            &["open.obj is not closed: 3 edges border a hole"],
        ),
        ("synth --object empty.obj", &["empty.obj has no faces"]),
        (
            "synth --object ball --preset quick",
            &["--preset quick", "default, paper, released"],
        ),
        ("synth --object ball -n 0", &["-n 0"]),
        ("synth --object ball --spread 0", &["--spread 0"]),
        (
            "synth --object ball --contacts 1",
            &["contacts = 1", "between 2 and 8"],
        ),
        (
            "synth --object ball --config typo.toml",
            &["typo.toml", "line 2", "prior_wieght", "`prior_weight`"],
        ),
        (
            "synth --object ball --config negative.toml",
            &["negative.toml", "[energy]", "distance_weight = -1"],
        ),
        (
            "synth --object ball --config torn.toml",
            &["torn.toml", "line 1"],
        ),
        (
            "synth --object ball --config absent.toml",
            &["cannot read absent.toml"],
        ),
        ("synth --object ball --threads 0", &["--threads 0"]),
        (
            "build g.parquet --temperature -1",
            &["--temperature -1", "positive"],
        ),
        (
            "build g.parquet --temperature nan",
            &["--temperature NaN", "positive"],
        ),
        ("build g.parquet --force 0", &["--force 0", "positive"]),
    ];
    for (line, words) in cases {
        let sentence = desk.early_mistake(line);
        assert_says(&sentence, words);
        let (_, cause) = sentence.rsplit_once(": ").unwrap_or(("", &sentence));
        assert_eq!(sentence.matches(cause).count(), 1, "said twice: {sentence}");
    }
}

/// The small network of the tests, as a user has it: weights and specs in one folder.
fn desk_with_network() -> Desk {
    let desk = Desk::empty();
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/deepsdf");
    for (from, to) in [
        ("small_model.safetensors", "model.safetensors"),
        ("small_specs.json", "specs.json"),
    ] {
        fs::copy(reference.join(from), desk.path(to)).unwrap();
    }
    desk
}

#[test]
fn a_network_becomes_an_object() {
    let desk = desk_with_network();
    let cache = desk.path("cache");
    let run = |line: &str| {
        let output = desk
            .command(line)
            .env("XDG_CACHE_HOME", &cache)
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "landscape {line}: {said}");
        String::from_utf8(output.stdout).unwrap()
    };
    let text = run("objects bake model.safetensors --code 2 --scale 0.05 --cells 40 -o jar.obj");
    assert_says(&text, &["size", "triangles", "smooth field"]);
    assert_eq!(
        names(desk.folder.path()),
        ["cache", "jar.obj", "model.safetensors", "specs.json"]
    );
    let mesh = fs::read(desk.path("jar.obj")).unwrap();
    run(
        "objects bake model.safetensors --specs specs.json --codes model.safetensors --code 2 --scale 0.05 --cells 40 \
         -o again.obj --threads 1",
    );
    assert_eq!(fs::read(desk.path("again.obj")).unwrap(), mesh);
    let fields = fs::read_dir(cache.join("landscape/fields")).map(Iterator::count);
    if cfg!(target_os = "linux") {
        assert_eq!(
            fields.unwrap(),
            1,
            "both meshes are the same, so their field is"
        );
    }
    run("synth --object jar.obj -n 2 --steps 100 --keep all -o jar.parquet");
    let (file, _) = GraspFile::read(&desk.path("jar.parquet"), Overrides::default()).unwrap();
    assert_eq!(
        (file.grasps.len(), &*file.metadata.objects[0].name),
        (2, "jar")
    );
}

#[test]
fn mistakes_with_networks() {
    let desk = desk_with_network();
    let specs = fs::read_to_string(desk.path("specs.json")).unwrap();
    fs::write(
        desk.path("wide.json"),
        specs.replace("\"CodeLength\": 16", "\"CodeLength\": 17"),
    )
    .unwrap();
    fs::write(
        desk.path("typo.json"),
        specs.replace("latent_in", "latent_on"),
    )
    .unwrap();
    fs::write(desk.path("taken.json"), &specs).unwrap();
    fs::write(desk.path("model.pth"), "").unwrap();
    fs::write(desk.path("text.safetensors"), "hello, hello, hello").unwrap();
    fs::create_dir(desk.path("alone")).unwrap();
    fs::copy(
        desk.path("model.safetensors"),
        desk.path("alone/model.safetensors"),
    )
    .unwrap();
    let cases: [(&str, &[&str]); 13] = [
        ("absent.safetensors", &["cannot read absent.safetensors"]),
        (
            "model.pth",
            &["model.pth", ".safetensors", "docs/neural_objects.md"],
        ),
        (
            "text.safetensors",
            &["text.safetensors is not a valid .safetensors file"],
        ),
        (
            "alone/model.safetensors",
            &["no alone/specs.json", "--specs"],
        ),
        (
            "model.safetensors --specs absent.json",
            &["cannot read absent.json"],
        ),
        (
            "model.safetensors --specs wide.json",
            &["lin0.weight_v", "[128, 19]", "[128, 20]"],
        ),
        (
            "model.safetensors --specs typo.json",
            &["typo.json", "`latent_on`", "`latent_in`"],
        ),
        (
            "model.safetensors --code 3",
            &["--code 3", "has 3, numbered from 0"],
        ),
        ("model.safetensors --cells 4", &["--cells 4", "16"]),
        (
            "model.safetensors --scale -0.1",
            &["--scale -0.1", "positive"],
        ),
        ("model.safetensors --scale 100", &["metres are expected"]),
        (
            "model.safetensors -o bottle.stl",
            &["--output bottle.stl", ".obj"],
        ),
        (
            "model.safetensors -o taken.obj",
            &["taken.json", "--output"],
        ),
    ];
    for (rest, words) in cases {
        let scale = if rest.contains("--scale") {
            ""
        } else {
            " --scale 0.1"
        };
        let output = if rest.contains("-o ") {
            ""
        } else {
            " -o bottle.obj"
        };
        let cells = if rest.contains("--cells") {
            ""
        } else {
            " --cells 16"
        };
        assert_says(
            &desk.early_mistake(&format!("objects bake -q {rest}{scale}{output}{cells}")),
            words,
        );
    }
}

#[test]
fn the_objects_that_come_with_the_program() {
    let output = Desk::empty().run("objects list");
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    for name in landscape::grasp::object::OBJECT_NAMES {
        assert!(
            text.lines()
                .any(|line| line.starts_with(&format!("{name} "))),
            "{name}: {text}"
        );
    }
    assert_says(&text, &["70 × 70 × 70", "sphere", "axis", "none"]);
}

#[test]
fn help_and_version() {
    let desk = Desk::empty();
    let text = |line: &str| {
        let output = desk.run(line);
        assert!(output.status.success(), "landscape {line}");
        String::from_utf8(output.stdout).unwrap()
    };
    assert_says(&text("--help"), &["synth", "build", "Examples:"]);
    assert_says(
        &text("synth --help"),
        &["--object", "Examples:", "landscape synth --object"],
    );
    assert_says(
        &text("build --help"),
        &["--neighbours", "Examples:", "landscape build "],
    );
    assert_says(&text("objects --help"), &["list", "bake"]);
    assert_says(
        &text("objects bake --help"),
        &["--specs", "--scale", "Examples:", "landscape objects bake "],
    );
    assert_eq!(
        text("--version"),
        format!("landscape {}\n", env!("CARGO_PKG_VERSION"))
    );
    // Without arguments: the help, as an answer to a mistake.
    let output = desk.run("");
    assert_eq!(output.status.code(), Some(1));
    assert_says(
        &String::from_utf8(output.stderr).unwrap(),
        &["Usage: landscape"],
    );
}

/// The file with its metadata changed.
fn metadata(mut parts: Parts, change: impl FnOnce(&mut Value)) -> Parts {
    let mut value = serde_json::from_str(parts.metadata.as_ref().unwrap()).unwrap();
    change(&mut value);
    parts.metadata = Some(value.to_string());
    parts
}

/// A column of vectors with its rows changed.
fn change(
    parts: &Parts,
    name: &str,
    mut change: impl FnMut(usize, &mut [f64]),
) -> FixedSizeListArray {
    let (_, array): &(String, ArrayRef) = parts
        .columns
        .iter()
        .find(|(column, _)| column == name)
        .unwrap();
    let lists = array.as_fixed_size_list();
    let width = usize::try_from(lists.value_length()).unwrap();
    let mut values = lists
        .values()
        .as_primitive::<Float64Type>()
        .values()
        .to_vec();
    for (row, vector) in values.chunks_mut(width).enumerate() {
        change(row, vector);
    }
    let rows = values
        .chunks(width)
        .map(|row| Some(row.iter().copied().map(Some).collect::<Vec<_>>()));
    let length = lists.value_length();
    FixedSizeListArray::from_iter_primitive::<Float64Type, _, _>(rows, length)
}

fn first_joint() -> (String, [f64; 2]) {
    let desk = Desk::with_grasps();
    let (file, _) = GraspFile::read(&desk.path("g.parquet"), Overrides::default()).unwrap();
    let hand = &file.metadata.hands[0];
    (hand.joint_names[0].clone(), hand.limits_rad[0])
}
