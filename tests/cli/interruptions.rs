//! Results do not depend on the number of threads or on interruptions. `tests/crashes` interrupts syntheses, maps and searches.

use crate::desk::{Desk, assert_says};
use crate::{PATIENT, STABILITY, held_grasps, names};

/// The error advises to keep other grasps or to run more chains. Both must work and reuse the finished chains.
#[test]
fn chains_of_a_run_without_success_are_not_lost() {
    let desk = Desk::empty();
    let strict = "[energy.layer]\nmost_force_compliance = 1e-6\n";
    desk.write("strict.toml", strict);
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
    fresh.write("strict.toml", strict);
    fresh.succeed("synth --object ball --config strict.toml --steps 1 -n 2 --keep all -q");
    assert_eq!(contents_by_name(&desk), contents_by_name(&fresh));
}

fn contents_by_name(desk: &Desk) -> Vec<(String, Vec<u8>)> {
    let read = |name: String| (name.clone(), desk.bytes(&name));
    names(desk.folder.path()).into_iter().map(read).collect()
}

#[test]
fn an_interrupted_simulation_continues() {
    let desk = Desk::with_grasps();
    desk.write("p.toml", PATIENT);
    let journal = "held.parquet.partial";
    let line = format!("{STABILITY} --threads 2");
    desk.interrupt(&line, journal, 2);
    assert!(!desk.path("held.parquet").exists());

    let other = desk.early_mistake("stability g.parquet -o held.parquet");
    assert_says(&other, &[journal, "other input or settings", "--fresh"]);

    desk.resume(&format!("{line} --resume"), journal);
    let continued = desk.bytes("held.parquet");
    assert!(
        continued == held_grasps(),
        "the bytes of a run on one thread"
    );
    assert_eq!(
        names(desk.folder.path()),
        ["g.parquet", "held.parquet", "p.toml"]
    );
    let nothing = desk.early_mistake(&format!("{STABILITY} --resume"));
    assert_says(&nothing, &[journal, "no interrupted run"]);
}
