//! Numbers of any magnitude: each number of a small valid file is replaced in turn, and the content is used as the command
//! line uses it. The result is a value or one error message, which names the file if the reader knows it.
//!
//! `LANDSCAPE_FUZZ_READER=urdf` selects one reader, and `LANDSCAPE_FUZZ_INPUTS` (of any value) runs all cases.

use std::fs;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, OnceLock};

use landscape::energy::Energy;
use landscape::grasp::GraspEnergy;
use landscape::grasp::synthesis::synthesize;
use landscape::hand::{Hand, HandFiles, PosedHand};
use landscape::mesh::{ExactMesh, Mesh};
use landscape::object::{
    Assembly, Description, Field, FieldSettings, Object, Revolved, find_symmetry,
};
use landscape::optimize::QuenchSettings;
use landscape::space::Symmetry;

use super::readers::samples::{OBJ, URDF};
use super::readers::{Experiment, Read, readers, settings, told};

/// Replacements of a number.
const WRITTEN: &str = "0 1e-300 1e-30 1e-9 1e9 1e30 1e155 1e300 -1e-300 -1e-30 -1e-9 -1e9 -1e30 -1e155 -1e300 nan inf -inf \
                       18446744073709551615";

/// Longer files only repeat the same kinds of numbers.
const LONGEST: usize = 5000;

/// One case in this many is run. Since the stride does not divide the number of values, each value meets many numbers.
const STRIDE: usize = 5;

/// The function that reads and uses the files of a reader, if it does more than the reader, and the name of the file in its
/// messages.
fn user(reader: &str) -> Option<(Read, &'static str)> {
    let user: (Read, &str) = match reader {
        "urdf" | "mjcf" => (
            |bytes, _| hand(&string(bytes), r#"{"surface_points": 20}"#),
            "",
        ),
        "side_file" => (|bytes, _| hand(URDF, &string(bytes)), ""),
        "object_obj" => (|bytes, folder| mesh("obj", bytes, folder), "m.obj"),
        "object_stl" => (|bytes, folder| mesh("stl", bytes, folder), "m.stl"),
        "object_ply" => (|bytes, folder| mesh("ply", bytes, folder), "m.ply"),
        "object_gltf" => (|bytes, folder| mesh("gltf", bytes, folder), "m.gltf"),
        "object_glb" => (|bytes, folder| mesh("glb", bytes, folder), "m.glb"),
        "object_toml" => (shapes, ""),
        "object_json" => (description, ""),
        "experiment_toml" => (experiment, ""),
        _ => return None,
    };
    Some(user)
}

/// Files with numbers that are missing in those of the fuzzer.
fn more(reader: &str) -> &'static [&'static str] {
    match reader {
        "object_toml" => &[
            "[[parts]]\ncuboid = { centre = [0.01, 0, 0], half_extents = [0.02, 0.03, 0.04], edge_radius_m = 0.002 }\n",
            "[[parts]]\nsphere = { centre = [0.03, 0, 0], radius_m = 0.02 }\n",
            "[[parts]]\ncapsule = { a = [0, 0, 0], b = [0, 0, 0.05], radius_m = 0.01 }\n",
            "[[parts]]\ncuboid = { centre = [0, 0, 0], half_extents = [0.02, 0.03, 0.04] }\n\
             [[parts]]\ncuboid = { centre = [0.03, 0, 0], half_extents = [0.02, 0.02, 0.02] }\n",
        ],
        "object_json" => &[
            r#"{"mass_kg": 0.1, "primitive": {"sphere": {"centre": [0, 0, 0], "radius_m": 0.1}},
                "symmetry": {"axis": {"point": [0, 0, 0], "direction": [0, 0, 1]}}}"#,
            r#"{"primitive": {"sphere": {"centre": [0.01, 0, 0], "radius_m": 0.1}}, "symmetry": {"sphere": {"centre": [0.01, 0, 0]}}}"#,
            r#"{"primitive": {"cuboid": {"centre": [0, 0, 0], "half_extents": [0.1, 0.1, 0.1]}},
                "symmetry": {"finite": [{"rotation": [0, 0, 0, 1], "translation": [0, 0, 0]}]}}"#,
        ],
        "experiment_toml" => &[
            "[energy]\nself_penetration_weight = 10.0\njoint_limits_weight = 20.0\nprior_weight = 0.02\n",
            "[synthesis]\nsteps = 2\n[synthesis.grips]\nwhole = 0.2\npinch = 0.2\ntips = 0.6\n",
        ],
        _ => &[],
    }
}

fn string(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A hand, used as in `hands inspect`. Its derived side file must be readable.
fn hand(urdf: &str, side: &str) -> Result<(), String> {
    let files = HandFiles::of_texts([["hand", urdf], ["hand.json", side]]);
    let hand = Hand::from_files(&files).map_err(|error| error.to_string())?;
    let mut posed = PosedHand::default();
    for end in 0..3 {
        let mut x = hand.rest_coordinates();
        for (q, joint) in x[7..].iter_mut().zip(&hand.joints) {
            *q = [*q, joint.limits[0], joint.limits[1]][end];
        }
        hand.pose(&x, &mut posed);
        let points = posed.points.iter().flatten();
        assert!(points.into_iter().all(|x| x.is_finite()), "a point is lost");
    }
    let metric = hand.pose_metric();
    let levers = metric.joint_levers_m.iter().chain(&metric.joint_reaches_m);
    let radius = [metric.radius_of_gyration_m, metric.rotation_reach_m];
    assert!(
        levers.chain(&radius).all(|length| *length > 0.0),
        "no metric: {metric:?}"
    );
    let _ = hand.straight();
    let derived = files.derived_side_file().unwrap();
    let derived = HandFiles::of_texts([["hand", urdf], ["hand.json", &derived]]);
    Hand::from_files(&derived).unwrap();
    Ok(())
}

/// All derived properties of a mesh and its description, as for an object, with the coarsest field.
fn object(name: &str, mesh: &Mesh, description: &Description) -> Result<(), String> {
    if description.primitive.is_some() {
        return told(Object::from_mesh(name, mesh.clone(), description));
    }
    told(mesh.check_size(name))?;
    let exact = ExactMesh::new(mesh);
    let found = find_symmetry(mesh, &exact, 1e-3);
    let numbers = [mesh.volume(), mesh.area_m2(), mesh.radius_m()];
    assert!(
        numbers
            .iter()
            .all(|number| *number > 0.0 && number.is_finite()),
        "{numbers:?}, {found:?}"
    );
    assert!(
        mesh.sample_surface(50, 0)
            .iter()
            .all(|at| at.point.norm().is_finite())
    );
    assert!((0.0..=1.0).contains(&mesh.buried_share()));
    if let Symmetry::Axis { point, direction } = &description.symmetry {
        let _ = Revolved::bake(mesh, &exact, point, direction);
        return Ok(());
    }
    let coarse = FieldSettings {
        cell_m: None,
        most_nodes: 2000,
    };
    let _ = Field::bake(mesh, &exact, &coarse);
    Ok(())
}

fn mesh(kind: &str, bytes: &[u8], folder: &Path) -> Result<(), String> {
    let path = folder.join(format!("m.{kind}"));
    fs::write(&path, bytes).unwrap();
    let read = Mesh::read(&path, 1.0).map_err(|error| error.to_string())?;
    object(
        &path.display().to_string(),
        &read.mesh,
        &Description::default(),
    )
}

fn shapes(bytes: &[u8], _: &Path) -> Result<(), String> {
    let read = settings::<Assembly>(bytes)?.object("m.toml");
    let (mesh, description) = read.map_err(|error| error.to_string())?;
    object("m.toml", &mesh, &description)
}

/// A description with the mesh of its formula. Without a formula the mesh has no symmetry, so that nothing is baked.
fn description(bytes: &[u8], _: &Path) -> Result<(), String> {
    let read = Description::from_json("m.json", &string(bytes));
    let description = read.map_err(|error| error.to_string())?;
    let mesh = match &description.primitive {
        Some(shape) => shape.mesh("m.json").map_err(|error| error.to_string())?,
        None => Mesh::from_obj("m.obj", &mut OBJ.as_bytes()).unwrap(),
    };
    told(Object::from_mesh("m.json", mesh, &description))
}

/// A short chain with these settings.
fn experiment(bytes: &[u8], _: &Path) -> Result<(), String> {
    static BODIES: OnceLock<(Arc<Hand>, Arc<Object>)> = OnceLock::new();
    let (hand, ball) = BODIES.get_or_init(|| {
        let hand = Hand::from_files(&HandFiles::of_texts([
            ["hand", URDF],
            ["hand.json", r#"{"surface_points": 20}"#],
        ]))
        .unwrap();
        (Arc::new(hand), Arc::new(Object::named("ball").unwrap()))
    });
    let read: Experiment = settings(bytes)?;
    told(read.energy.validate())?;
    told(read.synthesis.validate())?;
    let mut chain = read.synthesis;
    chain.steps = chain.steps.min(2);
    let energy = GraspEnergy::new(hand.clone(), ball.clone(), read.energy);
    let energy = energy.map_err(|error| error.to_string())?;
    let short = QuenchSettings::default().with_max_evaluations(20);
    let end = synthesize(&energy, &chain, &short, 0, 0);
    let mut gradient = vec![0.0; energy.space().tangents()];
    let value = energy.evaluate(&end.refined.pose, &mut gradient);
    assert!(!value.is_nan() && !gradient.iter().any(|slope| slope.is_nan()));
    assert!(
        end.refined.pose.iter().all(|x| x.is_finite()),
        "{:?}",
        end.refined
    );
    Ok(())
}

/// Places of the numbers in a text, except those in names.
fn numbers(text: &[u8]) -> Vec<Range<usize>> {
    let of_name = |byte: &u8| byte.is_ascii_alphabetic() || b"_#$/".contains(byte);
    let mut found = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let sign = usize::from(text[at] == b'-');
        let digit = text.get(at + sign).is_some_and(u8::is_ascii_digit);
        if !digit || (at > 0 && (of_name(&text[at - 1]) || text[at - 1].is_ascii_digit())) {
            at += 1;
            continue;
        }
        let more = |byte: &&u8| byte.is_ascii_digit() || b".eE+-".contains(byte);
        let end = at + sign + text[at + sign..].iter().take_while(more).count();
        if !text.get(end).is_some_and(of_name) {
            found.push(at..end);
        }
        at = end;
    }
    found
}

/// The text with each of its numbers replaced by each value, and a description of the change. Binary files are left to the
/// mutations of bytes.
fn variants(seed: &[u8]) -> Vec<(String, Vec<u8>)> {
    let Ok(text) = std::str::from_utf8(seed) else {
        return Vec::new();
    };
    let of_place = |place: Range<usize>| {
        let value = move |value: &str| {
            let (before, after) = (&text[..place.start], &text[place.end..]);
            let said = format!("{value} at byte {}", place.start);
            (said, format!("{before}{value}{after}").into_bytes())
        };
        WRITTEN.split_whitespace().map(value)
    };
    numbers(seed).into_iter().flat_map(of_place).collect()
}

#[test]
fn numbers_of_any_magnitude_are_used_or_refused() {
    let only = std::env::var("LANDSCAPE_FUZZ_READER").ok();
    let every = std::env::var("LANDSCAPE_FUZZ_INPUTS").is_ok();
    let stride = if every { 1 } else { STRIDE };
    let mut findings = Vec::new();
    for (name, seeds, read) in readers() {
        if only.as_ref().is_some_and(|only| only != name) {
            continue;
        }
        let (read, file) = user(name).unwrap_or((read, ""));
        let seeds = seeds.into_iter().filter(|seed| seed.len() < LONGEST);
        let seeds = seeds.chain(more(name).iter().map(|text| text.as_bytes().to_vec()));
        let folder = tempfile::tempdir().unwrap();
        let all = seeds.flat_map(|seed| variants(&seed));
        for (said, bytes) in all.step_by(stride) {
            match catch_unwind(AssertUnwindSafe(|| read(&bytes, folder.path()))) {
                Err(_) => findings.push(format!("{name}: {said}: it panics")),
                Ok(Err(sentence)) if sentence.is_empty() || !sentence.contains(file) => {
                    findings.push(format!("{name}: {said}: it says only {sentence:?}"));
                }
                Ok(_) => {}
            }
        }
    }
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}
