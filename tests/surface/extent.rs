//! What `landscape surface` searches for, for how long, from which points and in which box.

use std::fs;

use landscape::topography::SearchSettings;

use super::programs::{program, python};
use super::promised;
use crate::desk::{Desk, assert_says};

#[test]
fn a_budget_ends_at_a_batch_that_can_be_repeated() {
    let desk = Desk::empty();
    let text = desk.mapped("lj 9 --budget 2s --search all --no-report -o a");
    assert_says(&text, &["nothing is claimed, since the search was stopped"]);
    let told = text.split("`--search all --searches ").nth(1).unwrap();
    let searches = told.split('`').next().unwrap();
    desk.mapped(&format!(
        "lj 9 --searches {searches} --search all --no-report -o b"
    ));
    for name in "stationary.parquet min.data ts.data points.min points.ts".split(' ') {
        let [a, b] = ["a", "b"].map(|folder| fs::read(desk.path(folder).join(name)).unwrap());
        assert!(a == b, "{name}");
    }
    for wrong in ["10", "1 h", "-5s", "0s", "1e9d"] {
        let said = desk.unmapped(&format!("lj 6 `--budget={wrong}`"));
        assert!(said.contains("--budget"), "{said}");
    }
    let said = desk.unmapped("lj 6 --budget 0s");
    assert!(said.contains("1e8 s") && !said.contains("  "), "{said}");
}

#[test]
fn a_number_of_minima_that_is_not_used_is_told() {
    let desk = Desk::empty();
    let said = |more: &str| {
        desk.succeed(&format!(
            "surface muller-brown --lowest 5 --no-report {more}"
        ))
    };
    let note = "--lowest 5 was not used, because everything is searched for";
    assert!(said("").contains(note));
    assert!(!said("--search lowest").contains(note));
}

#[test]
fn the_lowest_minima_are_joined() {
    let desk = Desk::empty();
    let with = |threads: &str, folder: &str| {
        let search = "lj 13 --search lowest --lowest 5 --no-report";
        desk.mapped(&format!("{search} --threads {threads} -o {folder}"))
    };
    let text = with("1", "a");
    assert_says(
        &text,
        &[
            "only the lowest part of the landscape was searched",
            "they are all joined",
        ],
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
    for name in "stationary.parquet paths.parquet edges.parquet points.ts".split(' ') {
        let [a, b] = ["a", "b"].map(|folder| fs::read(desk.path(folder).join(name)).unwrap());
        assert!(a == b, "{name} depends on the number of threads");
    }
}

#[test]
fn a_search_begins_with_known_points() {
    let desk = Desk::empty();
    desk.mapped("lj 6 --no-report -o six");
    // Known minima alone are enough.
    for from in ["six", "six/points.min"] {
        let output = format!("{}-again", from.replace('/', "-"));
        let text = desk.mapped(&format!("lj 6 --from {from} --no-report -o {output}"));
        assert!(text.contains("**2 minima** and **3 saddles**"), "{text}");
    }
    desk.write("points.txt", "0.5, -1.0 # a comment\n\n-0.5 1.4\n");
    let text = desk.mapped("muller-brown --from points.txt --no-report");
    assert!(text.contains("**3 minima** and **2 saddles**"), "{text}");
    let said = desk.unmapped("lj 6 --from points.txt");
    assert_says(&said, &["point 1 has 2 numbers", "18"]);
    let said = desk.unmapped("lj 7 --from six/points.min");
    assert!(said.contains("points of 21 finite coordinates"), "{said}");
    let said = desk.unmapped("lj 7 --from nowhere");
    assert!(said.contains("nowhere"), "{said}");
}

#[test]
fn a_quaternion_of_zeros_is_refused() {
    let desk = Desk::empty();
    desk.write("points.txt", "1 0 0 0\n0 0 0 0\n");
    let said = desk.unmapped("orientation --from points.txt");
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
    let search = format!("--command `{command}` --region=-1:1,-2:2 --coordinates box");
    desk.mapped(&format!("{search} -o boxed"));
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
        let text = desk.mapped(&format!(
            "{search} --from {from} --no-report -o again --force"
        ));
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
    desk.mapped(&format!(
        "--command `{command}` --region=-1:1,-2:2 --coordinates box -o faced"
    ));
    for verb in [
        "thermodynamics faced",
        "rates faced --from m2 --to m3 --temperature 1",
    ] {
        let said = desk.failure(verb);
        let unknown = "2 of 4 minima are unknown: m0 and m1";
        assert_says(&said, &[unknown, "--without-faces"]);
        let text = desk.print(&format!("{verb} --without-faces"));
        assert_says(&text, &["2 of 4 minima are left out", "m0 and m1"]);
    }
}

/// A time alone lifts the usual limit of searches, and a limit that is given stays.
#[test]
fn a_time_alone_limits_a_search() {
    let desk = Desk::empty();
    desk.write("limit.toml", "[search]\nmax_searches = 640\n");
    for (arguments, searches) in [
        ("", 100_000),
        ("--budget 2h", SearchSettings::NO_LIMIT),
        ("--budget 2h --searches 640", 640),
        ("--budget 2h --config limit.toml", 640),
    ] {
        let search = "double-well 1 -q --no-report --force -o d.landscape";
        desk.mapped(&format!("{search} {arguments}"));
        let manifest = desk.text("d.landscape/landscape.json");
        let expected = format!("\"max_searches\": {searches}");
        assert!(manifest.contains(&expected), "{arguments}: {expected}");
    }
}
