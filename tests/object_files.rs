//! Object files of users, in any format, unit and state of repair.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::fmt::Write;
use std::fs;

use crate::desk::{Desk, assert_says};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use landscape::mesh::Mesh;
use landscape::object::Object;
use serde_json::json;

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
    desk.write("d.toml", DUMBBELL);
    let said = desk.said("objects inspect d.toml --side-file d.json");
    assert_says(
        &said,
        &[
            "dumbbell",
            "50, 50, 170",
            "pieces overlap",
            "mass (kg)",
            "symmetry declared",
            "round about",
        ],
    );
    assert!(desk.text("d.json").contains("axis"));
    assert!(desk.path("d.png").exists());
    assert_says(
        &desk.mistake("objects inspect d.toml --side-file d.json"),
        &["d.json exists"],
    );
    // One shape is its formula.
    let single: Vec<&str> = DUMBBELL.lines().take(4).collect();
    desk.write("rod.toml", single.join("\n"));
    let said = desk.said("objects inspect rod.toml");
    assert_says(
        &said,
        &["symmetry declared", "round about (0.000, 0.000, 1.000)"],
    );
    desk.write("bad.toml", DUMBBELL.replace("0.025", "-1"));
    assert_says(
        &desk.mistake("objects inspect bad.toml"),
        &["bad.toml", "radius_m", "-1 is not"],
    );
    desk.write("typo.toml", DUMBBELL.replace("sphere", "spere"));
    assert_says(
        &desk.mistake("synth --object typo.toml"),
        &["typo.toml", "spere"],
    );
}

#[test]
fn scales_units_and_repairs_are_told() {
    let desk = Desk::empty();
    let (millimetres, _) = ball(1e3);
    desk.write("mm.ply", millimetres);
    let sentence = desk.mistake("objects inspect mm.ply");
    assert_says(&sentence, &["mm is", "m across", "--scale 0.001"]);
    let said = desk.said("objects inspect mm.ply --scale 0.001");
    assert_says(&said, &["pieces", "symmetry found", "a ball"]);

    // Three faces missing, two turned, and ten times as large as it should be.
    let (_, obj) = ball(10.0);
    let mut lines: Vec<String> = obj.lines().map(str::to_owned).collect();
    let first = lines.iter().position(|line| line.starts_with('f')).unwrap();
    lines.drain(first + 40..first + 43);
    for face in [first + 7, first + 100] {
        let words: Vec<&str> = lines[face].split(' ').collect();
        lines[face] = format!("f {} {} {}", words[2], words[1], words[3]);
    }
    desk.write("worn.obj", lines.join("\n"));
    let said = desk.said("objects inspect worn.obj --scale 0.1");
    assert_says(
        &said,
        &["worn.obj: 2 triangles", "were turned", "hole", "closed"],
    );
    let said = desk.said("objects inspect worn.obj --scale 0.01");
    assert_says(&said, &["less than a fingertip", "--scale"]);

    let half = lines.iter().take(first + (lines.len() - first) / 2);
    desk.write("half.obj", half.cloned().collect::<Vec<_>>().join("\n"));
    let sentence = desk.mistake("synth --object half.obj --scale 0.1");
    assert_says(
        &sentence,
        &["half.obj is not closed", "% of its surface is missing"],
    );
    assert_says(
        &desk.mistake("synth --object mm.ply --scale 0"),
        &["--scale 0", "not from 1e-6"],
    );
}

/// An open cup of eight corners, and a sheet: the edges of a box without its lid, in millimetres.
fn open_box(faces: &str) -> String {
    let mut text = String::new();
    for corner in 0..8 {
        let side = |bit: i32| if corner >> bit & 1 == 1 { 40 } else { -40 };
        writeln!(text, "v {} {} {}", side(0), side(1), side(2)).unwrap();
    }
    text + faces
}

const CUP: &str = "f 1 3 4 2\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

#[test]
fn open_surfaces_become_walls_only_if_a_thickness_is_given() {
    let desk = Desk::empty();
    desk.write("cup.obj", open_box(CUP));
    desk.write("sheet.obj", open_box("f 1 3 4 2\n"));
    for verb in ["objects inspect cup.obj", "synth --object cup.obj"] {
        let said = desk.mistake(&format!("{verb} --scale 0.001"));
        assert_says(
            &said,
            &[
                "cup.obj is not closed",
                "% of its surface is missing",
                "--thickness 2",
            ],
        );
    }
    // Five walls of 80 × 80 mm, mitred at the edges; at the rim they end as high as the sheet.
    let said = desk.said("objects inspect cup.obj --scale 0.001 --thickness 4");
    assert_says(
        &said,
        &[
            "cup.obj: 1 open surface became a wall",
            "84, 84, 82",
            "volume (cm³)",
        ],
    );
    let said = desk.said("objects inspect sheet.obj --scale 0.001 --thickness 4");
    assert_says(&said, &["80, 80, 4", "volume (cm³)"]);
    desk.said("synth --object sheet.obj --scale 0.001 --thickness 4 -n 1 --steps 1 --keep all -o sheet.parquet",
    );
    let file = desk.grasps("sheet.parquet");
    assert_says(&file.metadata.command, &["--scale 0.001 --thickness 4"]);
    let object = file.metadata.objects[0]
        .build(file.grasps[0].scale)
        .unwrap();
    assert!((object.mesh.volume() / 25.6e-6 - 1.0).abs() < 1e-6);
    for (line, words) in [
        ("synth --object mug --thickness 2", "mug is closed"),
        (
            "objects inspect cup.obj --thickness 0",
            "--thickness 0 is not",
        ),
    ] {
        assert_says(&desk.mistake(line), &[words]);
    }
}

/// A tetrahedron 10 cm high that is valid except for the fields in `changed`.
fn tetrahedron(changed: &[(&str, serde_json::Value)]) -> String {
    let corners = [
        0.0f32, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1,
    ];
    let faces = [0u32, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let corners = corners.iter().flat_map(|x| x.to_le_bytes());
    let data: Vec<u8> = corners
        .chain(faces.iter().flat_map(|i| i.to_le_bytes()))
        .collect();
    let mut document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 12, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 48}],
        "buffers": [{"byteLength": 96, "uri": format!("data:;base64,{}", STANDARD.encode(data))}]
    });
    for (entry, value) in changed {
        document[entry] = value.clone();
    }
    document.to_string()
}

/// Many parts of a glTF file may refer to the same part, and a link may lead anywhere.
#[test]
fn gltf_costs_no_more_than_it_holds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.gltf");
    let load = |changed: &[(&str, serde_json::Value)]| {
        fs::write(&path, tetrahedron(changed)).unwrap();
        Mesh::load(&path).map(|mesh| mesh.triangles().len())
    };
    assert_eq!(load(&[]).unwrap(), 4);
    let primitives = vec![json!({"attributes": {"POSITION": 0}, "indices": 1}); 1000];
    let said = load(&[
        ("scenes", json!([{"nodes": [1]}])),
        ("nodes", json!([{"mesh": 0}, {"children": vec![0; 60_000]}])),
        ("meshes", json!([{ "primitives": primitives }])),
    ]);
    let said = said.unwrap_err().to_string();
    assert!(said.contains("used too often"), "{said}");
    #[cfg(unix)]
    {
        let secret = tempfile::NamedTempFile::new().unwrap();
        fs::write(secret.path(), [0; 96]).unwrap();
        std::os::unix::fs::symlink(secret.path(), folder.path().join("link.bin")).unwrap();
        let said = load(&[("buffers", json!([{"byteLength": 96, "uri": "link.bin"}]))]);
        let said = said.unwrap_err().to_string();
        assert!(said.contains("out of its folder"), "{said}");
    }
}

#[test]
fn shapes_need_a_part_and_a_mesh_inside_out_is_told() {
    let desk = Desk::empty();
    desk.write("none.toml", "name = \"none\"\n");
    let said = String::from_utf8(desk.run("objects inspect none.toml").stderr).unwrap();
    assert!(said.contains("[[parts]]"), "{said}");
    let obj = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";
    desk.write("out.obj", obj);
    let said = desk.said("objects inspect out.obj");
    assert!(said.contains("1 piece was inside out and turned"), "{said}");
}
