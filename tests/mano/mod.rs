//! MANO, tested on a synthetic file with the keys and shapes of the real one, which may not be redistributed.
#![cfg(feature = "grasp")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod model;

use std::fs;
use std::sync::{Arc, LazyLock};

use crate::table::assert_says;
use landscape::energy::{Energy, Explain};
use landscape::grasp::{EnergySettings, GraspEnergy};
use landscape::hand::{Hand, HandFiles, PosedHand};
use landscape::object::Object;
use landscape::sample::{Task, stream};
use model::{Model, POSES, archive, npy};
use nalgebra::Vector3;
use rand::RngExt;
use zip::CompressionMethod;

static MODEL: LazyLock<Model> = LazyLock::new(Model::new);

/// The hand of a file with this side file.
fn read(bytes: &[u8], side: &str) -> Result<Hand, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mano.npz");
    fs::write(&path, bytes).unwrap();
    fs::write(folder.path().join("mano.json"), side).unwrap();
    let files = HandFiles::load(&path).and_then(|files| Hand::from_files(&files));
    files.map_err(|error| error.to_string())
}

fn hand(side: &str) -> Hand {
    read(&MODEL.npz(), side).unwrap()
}

/// Angles near the mean pose.
fn angles(seed: u64) -> Vec<f64> {
    let mut rng = stream(seed, Task::Start, 1);
    MODEL
        .mean
        .iter()
        .map(|mean| mean + rng.random_range(-0.5..0.5))
        .collect()
}

#[test]
fn vertices_are_those_of_the_formula() {
    let betas = [0.8, -1.5, 0.3];
    let hand = hand(r#"{"mano": {"betas": [0.8, -1.5, 0.3]}}"#);
    assert_eq!(
        (hand.links.len(), hand.joints.len(), hand.surface.len()),
        (16, 45, 778)
    );
    let mut posed = PosedHand::default();
    for seed in 0..4 {
        let angles = angles(seed);
        let mut x = hand.rest_coordinates();
        x[7..].copy_from_slice(&angles);
        hand.pose(&x, &mut posed);
        let vertices = MODEL.vertices(&betas, &angles);
        for (i, (point, v)) in posed.points.iter().zip(MODEL.order()).enumerate() {
            assert!((point - vertices[v]).norm() < 1e-12, "vertex {v}");
            assert_eq!(hand.surface_point(&posed, i), *point);
        }
        // The drawn skin has the corrections of the pose.
        assert_eq!(hand.skin().pose(&posed), posed.points);
    }
    assert_eq!(
        hand.digits,
        ["palm", "thumb", "index", "middle", "ring", "little"]
    );
    // Fingers point along −x.
    assert!(hand.palm.distal.x < -0.9, "{:?}", hand.palm);
    assert!(hand.capsules.len() >= 16 && !hand.self_pairs.is_empty());
}

/// Coordinates that are principal components give the poses of these components.
#[test]
fn components_are_shares_of_angles() {
    let hand = hand(r#"{"mano": {"components": 6}}"#);
    assert_eq!(hand.joints.len(), 6);
    let shares = [0.4, -0.2, 0.9, 0.0, 0.3, -0.5];
    let mut x = hand.rest_coordinates();
    assert!(x[7..].iter().all(|share| *share == 0.0));
    x[7..].copy_from_slice(&shares);
    let mut posed = PosedHand::default();
    hand.pose(&x, &mut posed);
    let angles: Vec<f64> = (0..45)
        .map(|k| {
            MODEL.mean[k]
                + (0..6)
                    .map(|c| shares[c] * MODEL.components[(c, k)])
                    .sum::<f64>()
        })
        .collect();
    let vertices = MODEL.vertices(&[], &angles);
    for (point, v) in posed.points.iter().zip(MODEL.order()) {
        assert!((point - vertices[v]).norm() < 1e-12);
    }
}

/// The prior is the length of the weights of the components, each in its standard deviation.
#[test]
fn the_prior_is_that_of_components() {
    let hand = hand("{}");
    let deviation = |c: usize| {
        let squares = (0..POSES).map(|n| MODEL.coefficients[45 * n + c].powi(2));
        (squares.sum::<f64>() / POSES as f64).sqrt()
    };
    let mut rng = stream(3, Task::Start, 0);
    let weights: Vec<f64> = (0..45).map(|_| rng.random_range(-1.0..1.0)).collect();
    let z: Vec<f64> = (0..45)
        .map(|k| (0..45).map(|c| weights[c] * MODEL.components[(c, k)]).sum())
        .collect();
    let mut square = 0.0;
    for (i, a) in z.iter().enumerate() {
        for (j, b) in z.iter().enumerate() {
            square += a * hand.prior.precision[45 * i + j] * b;
        }
    }
    let exact: f64 = (0..45).map(|c| (weights[c] / deviation(c)).powi(2)).sum();
    assert!(
        (square / exact - 1.0).abs() < 1e-9,
        "{square} instead of {exact}"
    );
}

/// At any coordinates the pose of the mirrored hand is the mirror image; mirroring twice changes nothing.
#[test]
fn the_mirrored_hand_is_the_mirror_image() {
    for entries in ["", r#", "mano": {"components": 9, "betas": [1.5]}"#] {
        let hands =
            [false, true].map(|mirror| hand(&format!(r#"{{"mirror": {mirror}{entries}}}"#)));
        let [right, left] = &hands;
        assert_eq!(&left.mirrored(), right);
        assert_eq!(left.name, "mano_mirrored");
        let mirror = |v: &Vector3<f64>| Vector3::new(-v.x, v.y, v.z);
        let mut x = right.rest_coordinates();
        x[..7].copy_from_slice(&[0.1, -0.2, 0.3, 0.5, 0.1, -0.7, 0.2]);
        for (i, q) in x[7..].iter_mut().enumerate() {
            *q += 0.4 * libm::sin(i as f64);
        }
        let mut of_left = x.clone();
        for i in [0, 5, 6] {
            of_left[i] = -of_left[i];
        }
        let (mut a, mut b) = (PosedHand::default(), PosedHand::default());
        right.pose(&x, &mut a);
        left.pose(&of_left, &mut b);
        for i in 0..right.surface.len() {
            assert!((mirror(&a.points[i]) - b.points[i]).norm() < 1e-12);
            let normals = [right.point_normal(&a, i), left.point_normal(&b, i)];
            assert!((mirror(&normals[0]) - normals[1]).norm() < 1e-12);
        }
        for (p, q) in a.capsules.iter().flatten().zip(b.capsules.iter().flatten()) {
            assert!((mirror(p) - q).norm() < 1e-12);
        }
        assert!((mirror(&right.palm.volar) - left.palm.volar).norm() < 1e-12);
    }
}

#[test]
fn compressed_archives_are_read() {
    let [stored, deflated] =
        [CompressionMethod::Stored, CompressionMethod::Deflated].map(|method| MODEL.packed(method));
    assert!(deflated.len() < stored.len());
    assert_eq!(read(&deflated, "{}"), read(&stored, "{}"));
}

/// The energy of a grasp has its gradient; the layer is in the object.
#[test]
fn the_energy_of_a_grasp_has_its_gradient() {
    let hand = Arc::new(hand("{}"));
    let object = Arc::new(Object::named("ball").unwrap());
    let radius = object.radius_m;
    let palm = hand.palm;
    let energy = GraspEnergy::new(hand, object, EnergySettings::default()).unwrap();
    let mut x = energy.hand().rest_coordinates();
    // Pressed into the palm.
    let facing = palm.centre + palm.volar * (0.7 * radius);
    x[..3].copy_from_slice((energy.object().centroid - facing).as_slice());
    let terms = energy.terms(&x);
    assert!(
        terms
            .iter()
            .any(|(name, value)| name == "pressing" && *value > 0.0),
        "{terms:?}"
    );
    let mut gradient = vec![0.0; energy.space().tangents()];
    energy.evaluate(&x, &mut gradient);
    for (i, slope) in gradient.iter().enumerate() {
        let along = |step: f64| {
            let mut tangent = vec![0.0; gradient.len()];
            tangent[i] = step;
            let mut moved = x.clone();
            energy.space().exp(&mut moved, &tangent);
            energy.evaluate(&moved, &mut tangent)
        };
        let difference = (along(1e-6) - along(-1e-6)) / 2e-6;
        let error = (slope - difference).abs() / (1.0 + difference.abs());
        assert!(error < 2e-4, "tangent {i}: {slope} against {difference}");
    }
}

#[test]
fn what_cannot_be_used_is_said() {
    let good = MODEL.npz();
    for (side, part) in [
        (r#"{"mano": {"components": 46}}"#, "1 to 45"),
        (
            r#"{"mano": {"betas": [0,0,0,0,0,0,0,0,0,0,0]}}"#,
            "10 shapes",
        ),
        (r#"{"rest_deg": {"a": 1}}"#, "\"rest_deg\""),
        (r#"{"no_contact": ["thumb"]}"#, "thumb"),
    ] {
        let error = read(&good, side).unwrap_err();
        assert!(error.contains(part), "{side}: {error}");
    }
    let some = |names: &[&str]| {
        archive(
            names.iter().map(|name| (*name, npy("<f8", &[0, 3], &[]))),
            CompressionMethod::Stored,
        )
    };
    assert!(
        read(b"PK", "{}")
            .unwrap_err()
            .contains("not a .npz archive")
    );
    assert!(read(&some(&[]), "{}").unwrap_err().contains("`v_template`"));
    assert!(
        read(&some(&["v_template"]), "{}")
            .unwrap_err()
            .contains("`f`")
    );
    let mut other = MODEL.clone();
    other.weights[5] = 0.5;
    assert!(read(&other.npz(), "{}").unwrap_err().contains("sum to 1"));
    other = MODEL.clone();
    other.faces[0] = 778;
    assert!(read(&other.npz(), "{}").unwrap_err().contains("`f`"));
    other = MODEL.clone();
    other.mean[0] = f64::NAN;
    let error = read(&other.npz(), "{}").unwrap_err();
    assert_says(&error, &["NaN is not from", "`hands_mean`"]);
}

/// Files of grasps hold the place of the model but not its content.
#[test]
fn nothing_of_the_model_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mano.npz");
    fs::write(&path, MODEL.npz()).unwrap();
    let files = HandFiles::load(&path).unwrap();
    assert!(
        files.files.iter().all(|file| file.text.len() < 1000),
        "{files:?}"
    );
    let dotted = HandFiles::load(&folder.path().join("./mano.npz")).unwrap();
    assert_eq!(dotted.files[0].text, files.files[0].text);
    let side = files.derived_side_file().unwrap();
    let mut with = files.clone();
    with.files.push(
        HandFiles::of_texts([["mano.json", side.as_str()]])
            .files
            .remove(0),
    );
    let [hand, again] = [&files, &with].map(|files| Hand::from_files(files).unwrap());
    assert_eq!(
        (&hand.self_pairs, &hand.joints),
        (&again.self_pairs, &again.joints)
    );
    fs::write(&path, b"another").unwrap();
    let error = Hand::from_files(&files).unwrap_err().to_string();
    assert!(error.contains("--hand"), "{error}");
    fs::remove_file(&path).unwrap();
    let error = Hand::from_files(&files).unwrap_err().to_string();
    assert_says(&error, &["licence", "--hand"]);
}
