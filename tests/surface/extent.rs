//! What `landscape surface` searches for, for how long, from which points and in which box.

use std::fs;
use std::process::Command;

use landscape::store::StationaryRow;
use landscape::topography::SearchSettings;

use super::programs::{program, python};
use super::promised;
use crate::desk::Desk;

#[test]
fn a_budget_ends_at_a_batch_that_can_be_repeated() {
    let desk = Desk::empty();
    let text = desk.mapped(&[
        "lj",
        "9",
        "--budget",
        "2s",
        "--search",
        "all",
        "--no-report",
        "-o",
        "a",
    ]);
    assert!(
        text.contains("nothing is claimed, since the search was stopped"),
        "{text}"
    );
    let told = text.split("`--search all --searches ").nth(1).unwrap();
    let searches = told.split('`').next().unwrap();
    desk.mapped(&[
        "lj",
        "9",
        "--searches",
        searches,
        "--search",
        "all",
        "--no-report",
        "-o",
        "b",
    ]);
    for name in [
        "stationary.parquet",
        "min.data",
        "ts.data",
        "points.min",
        "points.ts",
    ] {
        let [a, b] = ["a", "b"].map(|folder| fs::read(desk.path(folder).join(name)).unwrap());
        assert!(a == b, "{name}");
    }
    for wrong in ["10", "1 h", "-5s", "0s", "1e9d"] {
        let said = desk.unmapped(&["lj", "6", &format!("--budget={wrong}")]);
        assert!(said.contains("--budget"), "{said}");
    }
    let said = desk.unmapped(&["lj", "6", "--budget", "0s"]);
    assert!(said.contains("1e8 s") && !said.contains("  "), "{said}");
}

#[test]
fn a_number_of_minima_that_is_not_used_is_told() {
    let desk = Desk::empty();
    let said = |more: &[&str]| {
        let output =
            desk.surface(&[&["muller-brown", "--lowest", "5", "--no-report"], more].concat());
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let note = "--lowest 5 was not used, because everything is searched for";
    assert!(said(&[]).contains(note));
    assert!(!said(&["--search", "lowest"]).contains(note));
}

#[test]
fn the_lowest_minima_are_joined() {
    let desk = Desk::empty();
    let arguments = [
        "lj",
        "13",
        "--search",
        "lowest",
        "--lowest",
        "5",
        "--no-report",
    ];
    let with = |threads: &str, folder: &str| {
        desk.mapped(&[&arguments[..], &["--threads", threads, "-o", folder]].concat())
    };
    let text = with("1", "a");
    assert!(
        text.contains("only the lowest part of the landscape was searched")
            && text.contains("they are all joined"),
        "{text}"
    );
    assert!(text.contains("## Deepest merges"), "{text}");
    let rows = desk.stationary("a");
    // The icosahedron, and the lowest of its defects (Tsai and Jordan 1993).
    let energies: Vec<f64> = rows.iter().take(3).map(|row| row.energy).collect();
    for (energy, known) in energies.iter().zip([-44.326801, -41.471980, -41.444597]) {
        assert!((energy - known).abs() < 1e-5, "{energies:?}");
    }
    with("2", "b");
    assert_eq!(
        promised(&desk.path("a")).len(),
        promised(&desk.path("b")).len()
    );
    for name in [
        "stationary.parquet",
        "paths.parquet",
        "edges.parquet",
        "points.ts",
    ] {
        let [a, b] = ["a", "b"].map(|folder| fs::read(desk.path(folder).join(name)).unwrap());
        assert!(a == b, "{name} depends on the number of threads");
    }
}

#[test]
fn a_search_begins_with_known_points() {
    let desk = Desk::empty();
    desk.mapped(&["lj", "6", "--no-report", "-o", "six"]);
    // Known minima alone are enough.
    for from in ["six", "six/points.min"] {
        let output = format!("{}-again", from.replace('/', "-"));
        let text = desk.mapped(&["lj", "6", "--from", from, "--no-report", "-o", &output]);
        assert!(text.contains("**2 minima** and **3 saddles**"), "{text}");
    }
    desk.write("points.txt", "0.5, -1.0 # a comment\n\n-0.5 1.4\n");
    let text = desk.mapped(&["muller-brown", "--from", "points.txt", "--no-report"]);
    assert!(text.contains("**3 minima** and **2 saddles**"), "{text}");
    let said = desk.unmapped(&["lj", "6", "--from", "points.txt"]);
    assert!(
        said.contains("point 1 has 2 numbers") && said.contains("18"),
        "{said}"
    );
    let said = desk.unmapped(&["lj", "7", "--from", "six/points.min"]);
    assert!(said.contains("points of 21 finite coordinates"), "{said}");
    let said = desk.unmapped(&["lj", "7", "--from", "nowhere"]);
    assert!(said.contains("nowhere"), "{said}");
}

#[test]
fn a_quaternion_of_zeros_is_refused() {
    let desk = Desk::empty();
    desk.write("points.txt", "1 0 0 0\n0 0 0 0\n");
    let said = desk.unmapped(&["orientation", "--from", "points.txt"]);
    assert!(said.contains("point 2 is not a quaternion"), "{said}");
}

#[test]
fn a_box_keeps_its_points() {
    if !python() {
        return;
    }
    let desk = Desk::empty();
    // (x − 2)² + (y² − 1)² falls toward the face x = 1, where two minima and the saddle between them lie.
    let lines = "assert abs(x) <= 1 + 1e-12 and abs(y) <= 2 + 1e-12\nenergy = (x - 2) ** 2 + (y * y - 1) ** 2\n\
                 gradient = [2 * (x - 2), 4 * y * (y * y - 1)]";
    let command = program(&desk, "boxed.py", lines);
    let arguments = [
        "--command",
        &command,
        "--region=-1:1,-2:2",
        "--coordinates",
        "box",
    ];
    desk.mapped(&[&arguments[..], &["-o", "boxed"]].concat());
    let rows = desk.stationary("boxed");
    let minima: Vec<_> = rows.iter().filter(|row| row.index == 0).collect();
    assert_eq!(minima.len(), 2, "{rows:?}");
    for minimum in minima {
        let [x, y] = [minimum.coordinates[0], minimum.coordinates[1]];
        assert!(
            (x - 1.0).abs() < 1e-9 && (y.abs() - 1.0).abs() < 1e-5,
            "{x} {y}"
        );
    }
    // Its points can be given again, and points outside are moved to the nearest face.
    desk.write("outside.txt", "7 1.1\n");
    for from in ["boxed", "outside.txt"] {
        let known = ["--from", from, "--no-report", "-o", "again"];
        let text = desk.mapped(&[&arguments[..], &known, &["--force"]].concat());
        // Four more saddles of the unrolled box are mirror images, which join a minimum to itself.
        assert!(text.contains("**2 minima** and **1 saddle**"), "{text}");
        assert!(text.contains("Minima there: 2; saddles there: 1"), "{text}");
    }
}

/// Of two minima inside the box and two on its face, free energies count the former, once they are asked to.
#[test]
fn minima_on_a_face_can_be_left_out() {
    if !python() {
        return;
    }
    let desk = Desk::empty();
    // The slope along x is 10 (x + 0.5) (0.3 − x).
    let lines = "energy = -10 * (x**3 / 3 + 0.1 * x * x - 0.15 * x) + (y * y - 1) ** 2\n\
                 gradient = [-10 * (x + 0.5) * (x - 0.3), 4 * y * (y * y - 1)]";
    let command = program(&desk, "faced.py", lines);
    let region = ["--region=-1:1,-2:2", "--coordinates", "box", "-o", "faced"];
    desk.mapped(&[&["--command", &command][..], &region].concat());
    for verb in [
        &["thermodynamics", "faced"][..],
        &[
            "rates",
            "faced",
            "--from",
            "m2",
            "--to",
            "m3",
            "--temperature",
            "1",
        ],
    ] {
        let run = |more: &[&str]| desk.run(&[verb, more].concat().join(" "));
        let refused = run(&[]);
        let said = String::from_utf8(refused.stderr).unwrap();
        assert!(!refused.status.success(), "{verb:?}");
        assert!(
            said.contains("2 of 4 minima are unknown: m0 and m1")
                && said.contains("--without-faces"),
            "{said}"
        );
        let counted = run(&["--without-faces"]);
        let said = String::from_utf8(counted.stderr).unwrap();
        assert!(counted.status.success(), "{said}");
        let text = String::from_utf8(counted.stdout).unwrap();
        assert!(
            text.contains("2 of 4 minima are left out") && text.contains("m0 and m1"),
            "{text}"
        );
    }
}

/// A time alone lifts the usual limit of searches, and a limit that is given stays.
#[test]
fn a_time_alone_limits_a_search() {
    let desk = Desk::empty();
    desk.write("limit.toml", "[search]\nmax_searches = 640\n");
    for (arguments, searches) in [
        (&[][..], 100_000),
        (&["--budget", "2h"], SearchSettings::NO_LIMIT),
        (&["--budget", "2h", "--searches", "640"], 640),
        (&["--budget", "2h", "--config", "limit.toml"], 640),
    ] {
        let always = [
            "double-well",
            "1",
            "-q",
            "--no-report",
            "--force",
            "-o",
            "d.landscape",
        ];
        desk.mapped(&[&always, arguments].concat());
        let manifest = desk.text("d.landscape/landscape.json");
        let expected = format!("\"max_searches\": {searches}");
        assert!(manifest.contains(&expected), "{arguments:?}: {expected}");
    }
}
