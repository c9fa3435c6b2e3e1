//! Paths of a small landscape of grasps, in the colours of the taxonomy, and its comparison with another landscape.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use crate::desk::{Desk, assert_says};
use landscape::hand::Hand;
use landscape::store::{GraspFile, Overrides};
use serde_json::Value;

fn index(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap()).unwrap()
}

/// Two landscapes of three grasps each.
fn landscapes() -> &'static Desk {
    static MADE: OnceLock<Desk> = OnceLock::new();
    MADE.get_or_init(|| {
        let desk = Desk::empty();
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/data/grasps.parquet");
        let (file, _) = GraspFile::read(data.as_ref(), Overrides::default()).unwrap();
        for (name, first) in [("one", 0), ("two", 7)] {
            let mut part = file.clone();
            part.grasps = file.grasps[first..first + 3].to_vec();
            part.write(&desk.path(&format!("{name}.parquet"))).unwrap();
            desk.print(&format!("build {name}.parquet -q"));
        }
        desk
    })
}

/// A hand that has no human grasp types gets one sentence that says why, and no chart; earlier versions printed thirty rows of
/// insufficient data.
#[test]
fn a_landscape_without_grasp_types_is_compared_in_one_sentence() {
    let desk = Desk::empty();
    let synth = "synth --hand gripper_three_finger --object ball -n 2 --steps 1 --keep all";
    desk.print(&format!("{synth} -o g.parquet -q"));
    desk.print("build g.parquet -o g.landscape -q");
    let said = desk.print("compare g.landscape -o x");
    let lines: Vec<&str> = said.lines().filter(|line| !line.is_empty()).collect();
    assert_eq!(lines.len(), 2, "{said}");
    assert_says(
        lines[1],
        &[
            "Grasp types cannot be compared",
            "2 fingers instead of three or four",
        ],
    );
    assert!(!desk.path("x.svg").exists() && desk.path("x.json").exists());
    let said = desk.print("inspect g.parquet --verbose");
    assert_says(&said, &["not human", "2 fingers"]);
}

/// The JSON part of a binary glTF file.
fn gltf(path: &Path) -> Value {
    let bytes = fs::read(path).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap());
    serde_json::from_slice(&bytes[20..20 + length as usize]).unwrap()
}

/// Types of two landscapes side by side, and their families at separate barriers and at a common one.
fn compared(desk: &Desk) {
    desk.print("compare one.landscape two.landscape -o both -q");
    let both = desk.json("both.json");
    let grasps: u64 = both["types"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| {
            let [one, two] = [0, 1].map(|side| row["grasps"][side].as_u64().unwrap());
            one + two
        })
        .sum();
    assert!(grasps <= 6);
    let report = desk.text("both.md");
    assert_says(&report, &["one.landscape", "two.landscape", "of 17 cells"]);
    let barriers = ["one", "two"].map(|name| {
        let files = desk.landscape(&format!("{name}.landscape"));
        files.manifest.family_barrier.unwrap()
    });
    let note = "numbers cannot be compared";
    assert_eq!(
        report.contains(note),
        barriers[0].to_bits() != barriers[1].to_bits()
    );
    // At one barrier their families can be; at an endless one there are no more than before.
    let line = "compare one.landscape two.landscape --family-barrier 1e9 -o same -q";
    desk.print(line);
    let same = desk.json("same.json");
    assert_eq!(same["family_barriers"], serde_json::json!([1e9, 1e9]));
    let families = |told: &Value| told["families"][0].as_u64().unwrap();
    assert!(families(&same) <= families(&both));
    let report = desk.text("same.md");
    assert!(!report.contains(note));
}

#[test]
fn small_landscapes_are_looked_at_from_all_sides() {
    let desk = landscapes();
    let files = desk.landscape("one.landscape");
    let edge = files.edges.iter().find(|edge| edge.height.is_some());
    let edge = edge.unwrap();
    let way = format!(
        "inspect one.landscape --path m{} m{} --pictures 4 -o way",
        edge.a, edge.b
    );

    let told = desk.document(&format!("{way} --json"));
    let points = told["points"].as_array().unwrap();
    let energy = |point: &Value| point["energy"].as_f64().unwrap();
    for point in points {
        let terms = point["terms"].as_array().unwrap();
        let sum: f64 = terms.iter().map(|term| term.as_f64().unwrap()).sum();
        assert!((sum - energy(point)).abs() < 1e-9);
    }
    let minima = told["minima"].as_array().unwrap();
    let end = |minimum: &Value| files.minima[index(minimum)].energy;
    for (point, minimum) in [
        (&points[0], &minima[0]),
        (&points[points.len() - 1], &minima[minima.len() - 1]),
    ] {
        assert!((energy(point) - end(minimum)).abs() < 1e-6);
    }
    // No way is lower than the lowest, and this one is not above the edge's own.
    let top = points.iter().map(energy).fold(f64::NEG_INFINITY, f64::max);
    assert!(
        top <= edge.height.unwrap() + 1e-6,
        "{top} {:?}",
        edge.height
    );
    // Steps do not jump: the object's symmetry is undone where paths meet.
    let places: Vec<f64> = points
        .iter()
        .map(|point| point["place_m"].as_f64().unwrap())
        .collect();
    let length = places[places.len() - 1];
    assert!(
        places
            .windows(2)
            .all(|pair| pair[1] > pair[0] && pair[1] - pair[0] < 0.2 * length + 0.002)
    );

    let text = desk.print(&way);
    assert_says(&text, &["top above the higher end", "compliance"]);
    for ending in ["png", "svg"] {
        assert!(
            fs::metadata(desk.path(&format!("way.{ending}")))
                .unwrap()
                .len()
                > 10_000
        );
    }
    let animated = gltf(&desk.path("way.glb"));
    let primitive = &animated["meshes"][0]["primitives"][0];
    assert_eq!(primitive["targets"].as_array().unwrap().len(), points.len());
    let sampler = &animated["animations"][0]["samplers"][0];
    let count = |accessor: &Value| index(&animated["accessors"][index(accessor)]["count"]);
    assert_eq!(count(&sampler["input"]), points.len());
    assert_eq!(count(&sampler["output"]), points.len().pow(2));

    // What is exported is the hand that was judged, not the skin of the pictures.
    desk.print("export one.parquet glb --grasp 0 -o judged.glb -q");
    let judged = gltf(&desk.path("judged.glb"));
    let position = &judged["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
    assert_eq!(
        index(&judged["accessors"][index(position)]["count"]),
        Hand::human().solid_skin().vertices.len()
    );

    desk.print("draw one.landscape --colour category --examples 3 -o view -q");
    let drawn = desk.text("view/disconnectivity.svg");
    assert!(drawn.contains("base64,"));
    let categories = ["power", "precision", "intermediate", "unlisted"];
    assert!(categories.iter().any(|category| drawn.contains(category)));

    compared(desk);
}

#[test]
fn mistakes_about_ways_are_told() {
    let desk = landscapes();
    for (line, said) in [
        ("inspect one.landscape", "is a folder"),
        ("inspect one.landscape --path m0 m99", "m99"),
        ("inspect one.landscape --path m0 x", "(m3)"),
        ("inspect one.landscape --path m0 m0", "the same minimum"),
        ("inspect one.landscape --path g99 m0", "no such family"),
        ("draw one.landscape --examples 0", "--examples 0"),
    ] {
        assert_says(&desk.mistake(line), &[said]);
    }
}
