//! The objects of `data/objects`, and fields compared with exact distances.
#![cfg(feature = "grasp")]

use std::path::{Path, PathBuf};

use crate::table::assert_says;
use landscape::mesh::{ExactMesh, Mesh};
use landscape::object::{
    Description, Field, FieldSettings, OBJECT_NAMES, Object, ObjectError, Shape,
};
use landscape::sample::{Task, stream};
use landscape::space::Symmetry;
use nalgebra::{Unit, Vector3};
use rand::RngExt;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/objects")
}

/// Mesh and description of an object of the crate, without baking its field.
fn read(name: &str) -> (Mesh, Description) {
    let path = folder().join(name);
    let text =
        std::fs::read_to_string(path.with_extension("json")).expect("each mesh has a description");
    (
        Mesh::load(path.with_extension("obj")).expect("our meshes are valid"),
        Description::from_json(name, &text).expect("our descriptions are valid"),
    )
}

#[test]
fn every_object_is_listed_and_every_listed_object_is_there() {
    let files = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut stems: Vec<String> = files
        .filter(|path| path.extension().is_some_and(|kind| kind == "obj"))
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    stems.sort();
    assert_eq!(stems, OBJECT_NAMES);
}

#[test]
fn every_object_stands_on_the_ground_and_is_of_a_size_to_grasp() {
    for name in OBJECT_NAMES {
        let (mesh, description) = read(name);
        let [low, high] = mesh.bounds();
        let size_m = high - low;
        assert!(low.z.abs() < 1e-6, "{name} does not stand on z = 0");
        assert!(
            (0.01..0.15).contains(&size_m.x) && (0.01..0.15).contains(&size_m.y),
            "{name} is {size_m} wide"
        );
        assert!(
            (0.005..0.35).contains(&size_m.z),
            "{name} is {} m tall",
            size_m.z
        );
        let mass_kg = description.mass_kg.unwrap();
        let density = mass_kg / mesh.volume();
        // From half-empty bottles to steel on a wooden handle.
        assert!(
            (300.0..3000.0).contains(&density),
            "{name} has {density} kg/m³"
        );
        assert!(
            (1_500..9_000).contains(&mesh.triangles().len()),
            "{name}: {} triangles",
            mesh.triangles().len()
        );
        let bytes = std::fs::metadata(folder().join(name).with_extension("obj")).unwrap();
        assert!(bytes.len() < 300_000, "{name}: {} bytes", bytes.len());
        assert_eq!(description.name.as_deref(), Some(name));
    }
}

/// Bakes the field and checks its report, and separately its error at random points near the surface.
fn assert_field_is_accurate(name: &str, mesh: &Mesh) {
    let exact = ExactMesh::new(mesh);
    let field = Field::bake(mesh, &exact, &FieldSettings::default());
    let report = *field.report();
    eprintln!("{name}: {report:?}");
    assert!(report.cell_m <= 0.002);
    assert!(report.max_error_m <= 0.2e-3, "{name}: {report:?}");
    assert!(
        report.max_error_anywhere_m <= report.cell_m / 2.0,
        "{name}: {report:?}"
    );
    assert!(report.lipschitz < 1.4, "{name}: {report:?}");

    let mut rng = stream(1, Task::Start, 0);
    let [low, high] = mesh.bounds();
    for _ in 0..2_000 {
        let share = Vector3::from_fn(|_, _| rng.random_range(-0.4..1.4));
        let point = low + (high - low).component_mul(&share);
        let distance = exact.distance(&point);
        if distance.abs() < 0.02 {
            let error = (field.distance(&point) - distance).abs();
            assert!(error <= report.cell_m / 2.0, "{name}: {error} m at {point}");
        }
    }
    // Where hands start from, and beyond all grids, distances are still good to a few per cent.
    for _ in 0..100 {
        let direction = Unit::new_normalize(Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)));
        for reach_m in [0.3, 0.6, 1.5, 5.0] {
            let point = mesh.centroid() + direction.scale(reach_m);
            let (exact, smooth) = (exact.distance(&point), field.distance(&point));
            assert!(
                (exact - smooth).abs() < 0.03 * exact,
                "{name}: {smooth} for {exact} m"
            );
        }
    }
}

#[test]
fn fields_of_our_objects_match_the_exact_distance() {
    for name in ["bottle_round", "bottle_medicine"] {
        assert_field_is_accurate(name, &read(name).0);
    }
}

#[test]
fn a_named_object_is_whole() {
    let ball = Object::named("ball").unwrap();
    assert!((ball.centroid - Vector3::new(0.0, 0.0, 0.035)).norm() < 1e-6);
    assert!((ball.radius_m - 0.035).abs() < 1e-6);
    assert!((ball.shape.distance(&Vector3::new(0.0, 0.1, 0.035)) - 0.065).abs() < 1e-12);
    assert!(
        ball.surface_samples
            .iter()
            .all(|s| (s.normal.dot(&(s.point - ball.centroid))) > 0.034)
    );
    let message = Object::named("bottel").unwrap_err().to_string();
    assert_says(&message, &["bottel", "bottle_round"]);
}

#[test]
fn a_description_lies_beside_its_mesh() {
    let ball = Object::load(folder().join("ball.obj")).unwrap();
    assert_eq!((ball.name.as_str(), ball.mass_kg), ("ball", 0.06));
    assert!(ball.field_report.is_none(), "a ball needs no field");
    assert!(matches!(ball.symmetry, Symmetry::Sphere { .. }));

    let elsewhere = tempfile::tempdir().unwrap();
    let path = elsewhere.path().join("thing.obj");
    std::fs::copy(folder().join("ball.obj"), &path).unwrap();
    std::fs::write(path.with_extension("json"), "{ \"mass_kg\": \"heavy\" }").unwrap();
    let message = Object::load(&path).unwrap_err().to_string();
    assert_says(&message, &["thing.json", "heavy"]);
}

#[test]
fn false_descriptions_are_refused() {
    let (mesh, _) = read("bottle_square");
    let axis = Symmetry::Axis {
        point: Vector3::zeros(),
        direction: Vector3::z(),
    };
    let wrong = Description {
        symmetry: axis,
        ..Description::default()
    };
    let error = Object::from_mesh("square", mesh.clone(), &wrong).unwrap_err();
    assert!(
        matches!(error, ObjectError::Deviation { deviation_m, .. } if deviation_m > 5e-3),
        "{error}"
    );
    let wrong = Description {
        mass_kg: Some(-1.0),
        ..Description::default()
    };
    assert!(matches!(
        Object::from_mesh("square", mesh, &wrong),
        Err(ObjectError::Beyond {
            field: "mass_kg",
            ..
        })
    ));
    let (mesh, ball) = read("ball");
    let primitive = ball.primitive;
    let moved = Mesh::new(
        "ball",
        mesh.vertices().iter().map(|v| v.add_scalar(2e-3)).collect(),
        mesh.triangles().to_vec(),
    );
    let wrong = Description {
        primitive,
        ..Description::default()
    };
    let error = Object::from_mesh("ball", moved.unwrap(), &wrong).unwrap_err();
    assert!(error.to_string().contains("a primitive shape"), "{error}");
    assert!(Description::from_json("x", r#"{"mass": 1}"#).is_err());
}
