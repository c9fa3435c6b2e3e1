//! Objects as a user brings them: any format, unit and state of repair.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::fmt::Write;
use std::fs;

use desk::{Desk, assert_says};
use landscape::grasp::object::Object;

mod desk;

const DUMBBELL: &str = "\
name = \"dumbbell\"
mass_kg = 0.4
[[parts]]
cylinder = { centre = [0, 0, 0], axis = [0, 0, 1], radius_m = 0.012, half_height_m = 0.06 }
[[parts]]
sphere = { centre = [0, 0, 0.06], radius_m = 0.025 }
[[parts]]
sphere = { centre = [0, 0, -0.06], radius_m = 0.025 }
";

fn told(desk: &Desk, line: &str) -> String {
    let output = desk.run(line);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "landscape {line}: {said}");
    said + &String::from_utf8(output.stdout).unwrap()
}

/// A ball as text of another format, its coordinates multiplied by a factor.
fn ball(factor: f64) -> (String, String) {
    let (mesh, _) = Object::parts_of_named("ball").unwrap();
    let (mut ply, mut obj) = (String::new(), String::new());
    let counts = [mesh.vertices().len(), mesh.triangles().len()];
    let [vertices, faces] = counts;
    write!(
        ply,
        "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .unwrap();
    for v in mesh.vertices() {
        let v = v * factor;
        writeln!(ply, "{} {} {}", v.x, v.y, v.z).unwrap();
        writeln!(obj, "v {} {} {}", v.x, v.y, v.z).unwrap();
    }
    for [a, b, c] in mesh.triangles() {
        writeln!(ply, "3 {a} {b} {c}").unwrap();
        writeln!(obj, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    (ply, obj)
}

#[test]
fn shapes_in_toml_are_objects() {
    let desk = Desk::empty();
    fs::write(desk.path("d.toml"), DUMBBELL).unwrap();
    let said = told(&desk, "objects inspect d.toml --side-file d.json");
    assert_says(
        &said,
        &[
            "dumbbell",
            "50.0 × 50.0 × 170.0 mm",
            "3 pieces that overlap",
            "0.400 kg",
            "symmetry declared none",
            "round about",
        ],
    );
    assert!(
        fs::read_to_string(desk.path("d.json"))
            .unwrap()
            .contains("axis")
    );
    assert!(desk.path("d.png").exists());
    assert_says(
        &desk.mistake("objects inspect d.toml --side-file d.json"),
        &["d.json exists"],
    );
    // One shape is its formula.
    let single: Vec<&str> = DUMBBELL.lines().take(4).collect();
    fs::write(desk.path("rod.toml"), single.join("\n")).unwrap();
    let said = told(&desk, "objects inspect rod.toml");
    assert_says(
        &said,
        &[
            "a formula, exact",
            "symmetry declared round about (0.000, 0.000, 1.000)",
        ],
    );
    fs::write(desk.path("bad.toml"), DUMBBELL.replace("0.025", "-1")).unwrap();
    assert_says(
        &desk.mistake("objects inspect bad.toml"),
        &["bad.toml", "radius_m", "positive"],
    );
    fs::write(desk.path("typo.toml"), DUMBBELL.replace("sphere", "spere")).unwrap();
    assert_says(
        &desk.mistake("synth --object typo.toml"),
        &["typo.toml", "spere"],
    );
}

#[test]
fn scales_units_and_repairs_are_told() {
    let desk = Desk::empty();
    let (millimetres, _) = ball(1e3);
    fs::write(desk.path("mm.ply"), millimetres).unwrap();
    let sentence = desk.mistake("objects inspect mm.ply");
    assert_says(&sentence, &["mm is", "m across", "--scale 0.001"]);
    let said = told(&desk, "objects inspect mm.ply --scale 0.001");
    assert_says(
        &said,
        &["watertight, 1 piece\n", "symmetry found    a ball"],
    );

    // Three faces missing, two turned, and ten times as large as it should be.
    let (_, obj) = ball(10.0);
    let mut lines: Vec<String> = obj.lines().map(str::to_owned).collect();
    let first = lines.iter().position(|line| line.starts_with('f')).unwrap();
    lines.drain(first + 40..first + 43);
    for face in [first + 7, first + 100] {
        let words: Vec<&str> = lines[face].split(' ').collect();
        lines[face] = format!("f {} {} {}", words[2], words[1], words[3]);
    }
    fs::write(desk.path("worn.obj"), lines.join("\n")).unwrap();
    let said = told(&desk, "objects inspect worn.obj --scale 0.1");
    assert_says(
        &said,
        &["worn.obj: 2 triangles", "were turned", "hole", "closed"],
    );
    let said = told(&desk, "objects inspect worn.obj --scale 0.01");
    assert_says(&said, &["less than a fingertip", "--scale"]);

    let half = lines.iter().take(first + (lines.len() - first) / 2);
    fs::write(
        desk.path("half.obj"),
        half.cloned().collect::<Vec<_>>().join("\n"),
    )
    .unwrap();
    let sentence = desk.mistake("synth --object half.obj --scale 0.1");
    assert_says(
        &sentence,
        &["half.obj is not closed", "% of its surface is missing"],
    );
    assert_says(
        &desk.mistake("synth --object mm.ply --scale 0"),
        &["--scale 0", "positive"],
    );
}
