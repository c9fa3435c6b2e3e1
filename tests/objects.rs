//! The objects of `data/objects`, and fields compared with exact distances.
#![cfg(feature = "grasp")]

use std::path::{Path, PathBuf};

use landscape::mesh::{ExactMesh, Mesh};
use landscape::object::{
    Description, Field, FieldSettings, OBJECT_NAMES, Object, ObjectError, Shape,
};
use landscape::sample::{Task, stream};
use landscape::space::Symmetry;
use nalgebra::{Rotation3, Unit, Vector3};
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

/// Scans of real objects, if the external test data are available.
fn scans() -> Option<PathBuf> {
    let root = std::env::var_os("LANDSCAPE_TEST_DATA");
    if root.is_none() {
        crate::skipped::skipped("LANDSCAPE_TEST_DATA is not set");
    }
    root.map(|root| PathBuf::from(root).join("objects"))
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

#[test]
fn only_the_mug_has_a_handle() {
    for name in OBJECT_NAMES {
        let (mesh, _) = read(name);
        // A closed surface has three edges for two triangles: V − E + F = 2 − 2 · handles.
        let (vertices, faces) = (mesh.vertices().len(), mesh.triangles().len());
        let handles = usize::from(name == "mug");
        assert_eq!(vertices + 2 * handles, faces / 2 + 2, "{name}");
    }
}

#[test]
fn vessels_are_hollow() {
    let wall_mm = |name: &str, from_mm: [f64; 3], to_mm: [f64; 3]| {
        let exact = ExactMesh::new(&read(name).0);
        let (from, to) = (Vector3::from(from_mm) * 1e-3, Vector3::from(to_mm) * 1e-3);
        let inside =
            (0..1000).filter(|i| exact.distance(&from.lerp(&to, f64::from(*i) / 1000.0)) < 0.0);
        inside.count() as f64 * (to - from).norm()
    };
    // Through the wall from the axis outward, away from the handle; through the base; through the handle.
    assert!((wall_mm("mug", [0.0, 0.0, 50.0], [-60.0, 0.0, 50.0]) - 4.5).abs() < 0.2);
    assert!((wall_mm("mug", [0.0, 0.0, 80.0], [0.0, 0.0, -10.0]) - 6.0).abs() < 0.2);
    assert!((wall_mm("mug", [45.0, 0.0, 50.0], [95.0, 0.0, 50.0]) - 9.0).abs() < 0.2);
    assert!((wall_mm("bowl", [0.0, 0.0, 50.0], [80.0, 0.0, 50.0]) - 5.3).abs() < 0.2);
    assert!((wall_mm("bowl", [0.0, 0.0, 80.0], [0.0, 0.0, -10.0]) - 6.0).abs() < 0.2);
}

#[test]
fn declared_axes_hold_to_a_tenth_of_a_millimetre() {
    for name in OBJECT_NAMES {
        let (mesh, description) = read(name);
        let Symmetry::Axis { point, direction } = description.symmetry else {
            continue;
        };
        let exact = ExactMesh::new(&mesh);
        let turn = Rotation3::from_axis_angle(&Unit::new_normalize(direction), 0.713);
        let off = mesh
            .vertices()
            .iter()
            .map(|v| exact.distance(&(turn * (v - point) + point)).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-4, "{name} is off its axis by {off} m");
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
#[ignore = "two minutes: bakes every object"]
fn fields_of_all_objects_match_the_exact_distance() {
    for name in OBJECT_NAMES {
        assert_field_is_accurate(name, &read(name).0);
    }
}

#[test]
fn fields_of_scans_match_the_exact_distance() {
    let Some(scans) = scans() else {
        return;
    };
    for file in ["ycb_006_mustard_bottle.obj", "ycb_055_baseball.obj"] {
        assert_field_is_accurate(file, &Mesh::load(scans.join(file)).unwrap());
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
    assert!(
        message.contains("bottel") && message.contains("bottle_round"),
        "{message}"
    );
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
    assert!(
        message.contains("thing.json") && message.contains("heavy"),
        "{message}"
    );
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

/// Meshes of several pieces, as published: outside distances and depths are those of the union.
#[test]
fn inside_of_a_union_is_inside_of_a_piece() {
    let Some(objects) = scans() else { return };
    let folder = objects.with_file_name("dexgraspnet").join("meshes");
    for code in [
        "sem-Bottle-437678d4bc6be981c8724d5673a063a6",
        "core-mug-8570d9a8d24cb0acbebd3c0c0c70fb03",
    ] {
        let read = Mesh::read(&folder.join(format!("{code}.obj")), 0.1).unwrap();
        assert_eq!(read.repairs, [], "{code}");
        let mesh = read.mesh;
        assert!(mesh.overlaps() && mesh.piece_count() > 3);
        let exact = ExactMesh::new(&mesh);
        let pieces = piecewise(&mesh);
        let within =
            |p: &Vector3<f64>, slack: f64| pieces.iter().any(|piece| piece.distance(p) < slack);
        let [low, high] = mesh.bounds();
        let mut rng = stream(5, Task::Start, 0);
        let (mut inside, mut too_deep, mut too_shallow) = (0, 0, 0);
        for _ in 0..4_000 {
            let share = Vector3::from_fn(|_, _| rng.random_range(-0.05..1.05));
            let p = low + (high - low).component_mul(&share);
            let nearest = exact.nearest(&p);
            if nearest.distance_m.abs() < 1e-4 {
                continue;
            }
            // Pieces are up to 0.02 mm apart.
            assert_eq!(nearest.distance_m < 0.0, within(&p, 2e-5), "{code}: {p}");
            if nearest.distance_m > 0.0 {
                continue;
            }
            inside += 1;
            // The whole ball about p lies inside, and just past its nearest point it ends.
            let depth = -nearest.distance_m;
            for direction in 0..26 {
                let direction = if direction < 13 {
                    direction
                } else {
                    direction + 1
                };
                let way =
                    [direction / 9, direction / 3 % 3, direction % 3].map(|s| f64::from(s) - 1.0);
                let reached = p + Vector3::from(way).normalize() * (depth - 8e-5);
                too_deep += usize::from(!within(&reached, 2e-5));
            }
            let past = p + (nearest.point - p) * (1.0 + 8e-5 / depth);
            too_shallow += usize::from(within(&past, -2e-5));
        }
        assert!(inside > 300, "{inside}");
        // Where pieces nearly touch, the slit between them is closed, or left, by less than it is wide.
        assert!(
            50 * too_deep <= inside && 50 * too_shallow <= inside,
            "{code}: of {inside} points {too_deep} seem too deep and {too_shallow} too shallow"
        );
    }
}

/// Each piece as a separate mesh.
fn piecewise(mesh: &Mesh) -> Vec<ExactMesh> {
    let mut piece_of: Vec<usize> = (0..mesh.vertices().len()).collect();
    // As many sweeps as it takes for the lowest number of each piece to reach all of it.
    loop {
        let mut changed = false;
        for triangle in mesh.triangles() {
            let least = triangle
                .iter()
                .fold(usize::MAX, |least, &v| least.min(piece_of[v as usize]));
            for v in triangle {
                changed |= piece_of[*v as usize] != least;
                piece_of[*v as usize] = least;
            }
        }
        if !changed {
            break;
        }
    }
    let mut pieces = std::collections::BTreeMap::<usize, Vec<[u32; 3]>>::new();
    for triangle in mesh.triangles() {
        pieces
            .entry(piece_of[triangle[0] as usize])
            .or_default()
            .push(*triangle);
    }
    let piece = |triangles| Mesh::new("piece", mesh.vertices().to_vec(), triangles);
    pieces
        .into_values()
        .map(|triangles| ExactMesh::new(&piece(triangles).expect("each piece is closed")))
        .collect()
}
