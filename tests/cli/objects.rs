//! Named objects, and networks as objects.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::desk::{Desk, assert_says};
use crate::table::rows;
use crate::{in_cache, names};

/// The small test network as a user has it: weights and specs in one folder.
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
        let mut command = desk.command(line);
        in_cache(&mut command, &cache);
        let output = command.output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "landscape {line}: {said}");
        String::from_utf8(output.stdout).unwrap()
    };
    let text = run("objects bake model.safetensors --code 2 --scale 0.05 --cells 40 -o jar.obj");
    assert_says(&text, &["size (mm)", "triangles", "field cell (mm)"]);
    assert_eq!(
        names(desk.folder.path()),
        ["cache", "jar.obj", "model.safetensors", "specs.json"]
    );
    let mesh = desk.bytes("jar.obj");
    run(
        "objects bake model.safetensors --specs specs.json --codes model.safetensors --code 2 --scale 0.05 --cells 40 \
         -o again.obj --threads 1",
    );
    assert_eq!(desk.bytes("again.obj"), mesh);
    let fields = fs::read_dir(cache.join("landscape/fields")).map(Iterator::count);
    if cfg!(target_os = "linux") {
        assert_eq!(
            fields.unwrap(),
            1,
            "both meshes are the same, so their field is"
        );
    }
    run("synth --object jar.obj -n 2 --steps 1 --keep all -o jar.parquet");
    let file = desk.grasps("jar.parquet");
    assert_eq!(
        (file.grasps.len(), &*file.metadata.objects[0].name),
        (2, "jar")
    );
}

#[test]
fn mistakes_with_networks() {
    let desk = desk_with_network();
    fs::copy(desk.path("specs.json"), desk.path("taken.json")).unwrap();
    desk.write("model.pth", "");
    fs::create_dir(desk.path("alone")).unwrap();
    fs::copy(
        desk.path("model.safetensors"),
        desk.path("alone/model.safetensors"),
    )
    .unwrap();
    let cases = "
        absent.safetensors | cannot read absent.safetensors
        model.pth | model.pth | .safetensors | docs/neural_objects.md
        alone/model.safetensors | no alone/specs.json | --specs
        model.safetensors --code 3 | --code 3 | has 3, numbered from 0
        model.safetensors --cells 4 | --cells 4 | 16
        model.safetensors --scale -0.1 | --scale -0.1 | not from 1e-6
        model.safetensors --scale 100 | metres are expected
        model.safetensors -o bottle.stl | --output bottle.stl | .obj
        model.safetensors -o taken.obj | taken.json | --output
    ";
    for case in rows(cases) {
        let flags = [
            ("--scale", " --scale 0.1"),
            ("-o ", " -o bottle.obj"),
            ("--cells", " --cells 16"),
        ];
        let missing = flags.iter().filter(|(flag, _)| !case[0].contains(flag));
        let missing: String = missing.map(|(_, text)| *text).collect();
        let sentence = desk.early_mistake(&format!("objects bake -q {}{missing}", case[0]));
        assert_says(&sentence, &case[1..]);
    }
}

#[test]
fn the_objects_that_come_with_the_program() {
    let output = Desk::empty().run("objects list");
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    for name in landscape::object::OBJECT_NAMES {
        assert!(
            text.lines()
                .any(|line| line.trim_start().starts_with(&format!("{name} "))),
            "{name}: {text}"
        );
    }
    assert_says(&text, &["70, 70, 70", "sphere", "axis", "none"]);
}

/// A box of these half sides as OBJ, closed or without its top.
fn cuboid([x, y, z]: [f64; 3], open: bool) -> String {
    let mut text = String::new();
    for corner in 0..8 {
        let sign = |bit: i32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let _ = writeln!(text, "v {} {} {}", x * sign(0), y * sign(1), z * sign(2));
    }
    let faces = [
        "1 3 4 2", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6", "5 6 8 7",
    ];
    for face in &faces[..if open { 5 } else { 6 }] {
        let _ = writeln!(text, "f {face}");
    }
    text
}

/// A share just above the limit is not printed as the limit itself.
#[test]
fn what_is_refused_for_its_holes_is_told_apart_from_what_is_closed() {
    let desk = Desk::empty();
    // The top is 1 of 1 + 1 + 4 · 2 areas and a little: 10.04 %.
    desk.write("open.obj", cuboid([0.03, 0.03, 0.0597], true));
    let sentence = desk.early_mistake("objects inspect open.obj");
    assert_says(
        &sentence,
        &["about 10.1 % of its surface is missing; up to 10 %"],
    );
    desk.write("huge.obj", cuboid([89.2000007629, 30.0, 30.0], false));
    let sentence = desk.early_mistake("objects inspect huge.obj");
    assert_says(&sentence, &["huge is 178.4 m across", "--scale 0.001"]);
}

/// Two boxes that share a face's middle as one piece: a channel through which a box is pushed into its own side.
#[test]
fn a_mesh_that_runs_through_itself_is_told() {
    let desk = Desk::empty();
    desk.write("sound.obj", cuboid([0.03, 0.03, 0.03], false));
    let said = desk.succeed("objects inspect sound.obj");
    assert!(!said.contains("intersects itself"), "{said}");
    // A bar bent until its end lies in its beginning: rings of four corners, along a turn and a bit.
    let (mut text, rings) = (String::new(), 30);
    for ring in 0..rings {
        let angle = 7.0 * f64::from(ring) / f64::from(rings - 1);
        for (out, up) in [(0.02, -0.01), (0.04, -0.01), (0.04, 0.01), (0.02, 0.01)] {
            let _ = writeln!(
                text,
                "v {} {} {up}",
                out * libm::cos(angle),
                out * libm::sin(angle)
            );
        }
    }
    for ring in 0..rings - 1 {
        for side in 0..4 {
            let next = (side + 1) % 4;
            let at = |ring: i32, side: i32| 4 * ring + side + 1;
            let [a, b] = [at(ring, side), at(ring, next)];
            let [c, d] = [at(ring + 1, next), at(ring + 1, side)];
            let _ = writeln!(text, "f {a} {d} {c} {b}");
        }
    }
    let last = 4 * (rings - 1);
    let _ = writeln!(
        text,
        "f 1 2 3 4\nf {} {} {} {}",
        last + 4,
        last + 3,
        last + 2,
        last + 1
    );
    desk.write("bent.obj", text);
    let said = desk.succeed("objects inspect bent.obj");
    assert_says(&said, &["bent intersects itself"]);
}
