//! Results do not depend on the number of threads or on interruptions.

use std::fs;

use crate::desk::{Desk, assert_says};
use crate::records::records;
use crate::{BUILD, LONG_SYNTH, PATIENT, STABILITY, SYNTH, grasps, landscape, names, promised};
use landscape::store::{GraspFile, LandscapeFiles, Overrides};

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
    assert_eq!(
        file.metadata.command,
        "landscape synth --object ball -n 6 --steps 1 --seed 1 --keep all"
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

/// The error advises to keep other grasps or to run more chains. Both must work and reuse the finished chains.
#[test]
fn chains_of_a_run_without_success_are_not_lost() {
    let desk = Desk::empty();
    let strict = "[energy.layer]\nmost_force_compliance = 1e-6\n";
    fs::write(desk.path("strict.toml"), strict).unwrap();
    let few = "synth --object ball --config strict.toml --steps 1 -n 1 -q";
    assert_says(
        &desk.mistake(few),
        &["the chain did not pass the filter", "--keep", "-n"],
    );
    assert_eq!(
        names(desk.folder.path()),
        ["grasps.parquet.partial", "strict.toml"]
    );
    desk.resume(
        "synth --object ball --config strict.toml --steps 1 -n 2 --keep all -q",
        "grasps.parquet.partial",
    );
    let fresh = Desk::empty();
    fs::write(fresh.path("strict.toml"), strict).unwrap();
    fresh.succeed("synth --object ball --config strict.toml --steps 1 -n 2 --keep all -q");
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
