//! Every hand of `data/hands` is valid, and the human hand has human dimensions and reach.
#![cfg(feature = "grasp")]

mod plausible;
mod refusals;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::described::described;
use crate::toy_hand::toy_hand;
use landscape::hand::{HAND_NAMES, Hand, HandFiles, PosedHand, axis_distance, closest_points};
use nalgebra::{DMatrix, Vector3};

/// The built-in hands, read anew.
fn hands() -> Vec<Hand> {
    let read = |name: &str| Hand::named(name).unwrap_or_else(|error| panic!("{name}: {error}"));
    HAND_NAMES.map(read).into()
}

/// Every folder of `data/hands` is a built-in hand with the same files.
#[test]
fn folders_are_hands() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/hands");
    let mut folders: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .flatten()
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().into_string().unwrap())
        .collect();
    folders.sort();
    let expected = "gripper_parallel gripper_three_finger human human_thumbless";
    assert_eq!(folders.join(" "), expected);
    for name in folders {
        assert!(HAND_NAMES.contains(&name.as_str()), "{name}");
        for file in HandFiles::named(&name).unwrap().files {
            let own = folder.join(&name).join(&file.name);
            let path = if own.exists() {
                own
            } else {
                folder.join("human").join(&file.name)
            };
            assert_eq!(file.text, fs::read_to_string(path).unwrap(), "{name}");
        }
    }
    let told = Hand::named("foot").unwrap_err().to_string();
    assert!(
        told.contains("foot") && told.contains("gripper_parallel"),
        "{told}"
    );
}

fn posed(hand: &Hand, x: &[f64]) -> PosedHand {
    let mut posed = PosedHand::default();
    hand.pose(x, &mut posed);
    posed
}

/// The flat hand: all joints at zero, root frame at the origin.
fn flat(hand: &Hand) -> Vec<f64> {
    let mut x = hand.rest_coordinates();
    x[7..].fill(0.0);
    x
}

/// Gap between two capsules of a posed hand, metres; negative if they overlap.
fn gap(hand: &Hand, posed: &PosedHand, [i, j]: [usize; 2]) -> f64 {
    let distance = closest_points(&posed.capsules[i], &posed.capsules[j])
        .offset
        .norm();
    distance - hand.capsules[i].radius_m - hand.capsules[j].radius_m
}

#[test]
fn every_hand_is_sound() {
    for hand in hands() {
        let name = &hand.name;
        let rest = posed(&hand, &hand.rest_coordinates());
        assert!(
            (700..850).contains(&hand.surface.len()),
            "{name} has {} points",
            hand.surface.len()
        );
        assert!(hand.surface.is_sorted_by_key(|point| point.link), "{name}");
        for (i, point) in hand.surface.iter().enumerate() {
            assert!((point.normal.norm() - 1.0).abs() < 1e-12, "{name}");
            assert!(point.region < hand.regions.len(), "{name}");
            // Outward: a hair along the normal is outside every capsule of the point's own link, creases included.
            let outside = rest.points[i] + hand.point_normal(&rest, i) * 1e-4;
            let own = hand
                .capsules
                .iter()
                .zip(&rest.capsules)
                .filter(|(capsule, _)| capsule.link == point.link);
            for (capsule, ends) in own {
                assert!(
                    axis_distance(&outside, ends) > capsule.radius_m,
                    "{name}: point {i} of {point:?} in {capsule:?}"
                );
            }
        }
        let areas: Vec<f64> = hand.surface.iter().map(|point| point.area_m2).collect();
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        let spread = (areas
            .iter()
            .map(|area| (area / mean - 1.0).powi(2))
            .sum::<f64>()
            / areas.len() as f64)
            .sqrt();
        // The narrow faces of boxes hold few points.
        let most = if name.starts_with("gripper") {
            0.35
        } else {
            0.25
        };
        assert!(spread < most, "{name}: areas vary by {spread}");

        for (joint, rest) in hand.joints.iter().zip(&hand.prior.rest) {
            assert!(
                joint.limits[0] <= *rest && *rest <= joint.limits[1],
                "{name}: {} at rest",
                joint.name
            );
        }
        let k = hand.joints.len();
        let precision = DMatrix::from_row_slice(k, k, &hand.prior.precision);
        assert!(precision.symmetric_eigenvalues().min() > 0.0, "{name}");
        for &pair in &hand.self_pairs {
            assert!(
                gap(&hand, &rest, pair) > 0.0,
                "{name}: {pair:?} overlap at rest"
            );
        }
        assert!(
            hand.palm.volar.dot(&hand.palm.distal).abs() < 1e-12,
            "{name}"
        );
    }
}

/// Each directed edge of the skin has its opposite, so it closes; it encloses a positive volume; and it bends without
/// tearing: every vertex stays near the links that carry it.
#[test]
fn skins_are_closed_and_bend() {
    for hand in hands() {
        let skin = hand.skin();
        let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
        for &[a, b, c] in &skin.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *edges.entry([from, to]).or_default() += 1;
                *edges.entry([to, from]).or_default() -= 1;
            }
        }
        assert!(
            edges.values().all(|&count| count == 0),
            "{}: the skin has a hole",
            hand.name
        );

        let mut bent = hand.rest_coordinates();
        for (q, joint) in bent[7..].iter_mut().zip(&hand.joints) {
            *q = joint.limits[0] + 0.8 * (joint.limits[1] - joint.limits[0]);
        }
        for x in [hand.rest_coordinates(), bent] {
            let posed = posed(&hand, &x);
            let vertices = skin.pose(&posed);
            let volume: f64 = (skin.triangles.iter())
                .map(|t| t.map(|v| vertices[v as usize]))
                .map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0)
                .sum();
            assert!(volume > 1e-5, "{}: volume {volume} m³", hand.name);
            for (vertex, bound) in vertices.iter().zip(&skin.vertices) {
                let carried = |link| bound.bindings.iter().any(|(carrier, ..)| *carrier == link);
                let parts = hand
                    .capsules
                    .iter()
                    .zip(&posed.capsules)
                    .filter(|(capsule, _)| carried(capsule.link));
                let distance = parts
                    .map(|(capsule, ends)| axis_distance(vertex, ends) - capsule.radius_m)
                    .fold(f64::INFINITY, f64::min);
                assert!(
                    (-10e-3..8e-3).contains(&distance),
                    "{}: a vertex is {distance} m off",
                    hand.name
                );
            }
        }
    }
}

/// The hand has the joint-centre lengths of Buchholz et al. (1992) for a hand length of 187 mm, and the fingertips of
/// the flat hand are at the right places.
#[test]
fn human_hand_has_published_lengths() {
    let hand = Hand::human();
    let flat = posed(&hand, &flat(&hand));
    let at = |name: &str| flat.object_from_link[hand.link(name).unwrap().0];
    for (finger, knuckle, [proximal, middle, distal]) in [
        ("index", [25.0, 86.0, 0.0], [45.8, 26.7, 18.1]),
        ("middle", [3.0, 83.0, 0.0], [49.7, 31.8, 20.2]),
        ("ring", [-17.0, 78.0, -1.0], [45.6, 30.9, 20.0]),
        ("little", [-35.0, 70.0, -3.0], [38.1, 21.9, 17.4]),
    ] {
        let frames =
            ["proximal", "middle", "distal"].map(|segment| at(&format!("{finger}_{segment}")));
        assert!(
            (frames[0].translation * 1e3 - Vector3::from(knuckle)).norm() < 1e-3,
            "{finger}"
        );
        let link = hand.link(&format!("{finger}_distal")).unwrap();
        let pulp = hand
            .capsules
            .iter()
            .find(|capsule| capsule.link == link)
            .unwrap();
        let tip = (pulp.b.y + pulp.radius_m) * 1e3;
        assert!((tip - distal).abs() < 1e-3, "{finger}: tip at {tip} mm");
        // Straight and in the plane of the palm: the whole finger from the knuckle is the sum of its bones.
        let whole = (frames[2].translation - frames[0].translation).norm() * 1e3;
        assert!(
            (whole - proximal - middle).abs() < 1e-3,
            "{finger}: {whole} mm to the last joint"
        );
        assert!(
            ((frames[1].translation - frames[0].translation).norm() * 1e3 - proximal).abs() < 1e-3
        );
        assert!(
            frames[2].direction(&Vector3::y()).y > 0.99
                && frames[2].direction(&Vector3::z()).z > 0.98,
            "{finger}"
        );
    }
    let thumb = ["thumb_trapezium", "thumb_proximal", "thumb_distal"]
        .map(|name| at(name).translation * 1e3);
    assert!(
        ((thumb[1] - thumb[0]).norm() - 46.9).abs() < 1e-3
            && ((thumb[2] - thumb[1]).norm() - 36.7).abs() < 1e-3
    );
    let highest = flat.points.iter().map(|p| p.y * 1e3).fold(0.0, f64::max);
    assert!((highest - 185.0).abs() < 3.0, "hand length {highest} mm");
    // Breadth at the knuckles, between the outermost points there.
    let across = flat
        .points
        .iter()
        .filter(|p| (0.060..0.095).contains(&p.y) && p.x < 0.040)
        .map(|p| p.x * 1e3);
    let breadth =
        across.clone().fold(f64::NEG_INFINITY, f64::max) - across.fold(f64::INFINITY, f64::min);
    assert!((breadth - 84.0).abs() < 4.0, "breadth {breadth} mm");
}

/// Turns one joint and compares with a pose worked out by hand: with the index knuckle flexed by 90° the finger points
/// out of the palm.
#[test]
fn flexion_goes_to_the_palm_and_abduction_to_the_thumb() {
    let hand = Hand::human();
    let tip = |joint: &str, angle_rad: f64| {
        let mut x = flat(&hand);
        x[7 + hand.joint(joint).unwrap()] = angle_rad;
        posed(&hand, &x).object_from_link[hand.link("index_distal").unwrap().0].translation * 1e3
    };
    let (straight, quarter) = (tip("index_mcp_flexion", 0.0), std::f64::consts::FRAC_PI_2);
    let flexed = tip("index_mcp_flexion", quarter);
    assert!((flexed.y - 86.0).abs() < 1.0 && flexed.z > 71.0, "{flexed}");
    assert!(tip("index_mcp_abduction", 0.2).x > straight.x + 10.0);
    let pip = tip("index_pip_flexion", quarter);
    assert!(
        (pip.y - 86.0 - 45.8).abs() < 0.5 && (pip.z - 26.7).abs() < 0.5,
        "{pip}"
    );
}

/// Palm regions, and pad, back, both sides and tip on every segment that has them, lie where their names say.
#[test]
fn regions_lie_where_their_names_say() {
    let hand = Hand::human();
    let flat = posed(&hand, &flat(&hand));
    for finger in ["index", "middle", "ring", "little"] {
        for (i, point) in hand.surface.iter().enumerate() {
            let normal = hand.point_normal(&flat, i);
            match hand.regions[point.region]
                .strip_prefix(finger)
                .and_then(|rest| rest.rsplit('.').next())
            {
                Some("pad") => assert!(normal.z > -0.7),
                Some("back") => assert!(normal.z < -0.3),
                Some("radial") => assert!(normal.x > 0.6),
                Some("ulnar") => assert!(normal.x < -0.6),
                Some("tip") => assert!(normal.y > 0.4),
                _ => {}
            }
        }
        let patches =
            "proximal.pad proximal.back proximal.radial proximal.ulnar distal.pad distal.tip";
        for patch in patches.split(' ') {
            let name = format!("{finger}.{patch}");
            assert!(hand.regions.contains(&name), "no {name}");
        }
    }
    for palm in "dorsum web thenar hypothenar centre heads.index heads.little".split(' ') {
        let region = hand
            .regions
            .iter()
            .position(|name| *name == format!("palm.{palm}"));
        let count = hand
            .surface
            .iter()
            .filter(|point| Some(point.region) == region)
            .count();
        assert!(count >= 2, "{count} points in palm.{palm}");
    }
    assert!(
        hand.regions.iter().all(|name| name.contains('.')),
        "an untagged point: {:?}",
        hand.regions
    );
    let thumb = hand.links.iter().filter(|link| link.digit == 1).count();
    assert_eq!(
        (hand.digits.len(), thumb),
        (6, 5),
        "a palm and five digits; five links of the thumb"
    );
}

/// Ring and little finger are attached to a moving part of the palm, which comes before index and middle finger in the
/// file. Earlier versions took them for one digit, the first.
#[test]
fn fingers_on_a_moving_half_palm_are_digits_of_their_own() {
    let names = [
        "palm", "thumb", "finger 1", "finger 2", "finger 3", "finger 4",
    ];
    let links_of = |hand: &Hand, digit: &str| -> Vec<String> {
        let digit = hand.digits.iter().position(|name| name == digit).unwrap();
        let links = hand.links.iter().filter(|link| link.digit == digit);
        links.map(|link| link.name.clone()).collect()
    };
    for half_palm in [false, true] {
        let hand = described(&toy_hand(half_palm), None).unwrap();
        assert_eq!(hand.digits, names, "{half_palm}");
        assert_eq!(links_of(&hand, "thumb"), ["thumb_1", "thumb_2"]);
        // From the thumb's side on, whatever comes first in the file.
        for (finger, name) in ["index", "middle", "ring", "little"].iter().enumerate() {
            let links = links_of(&hand, names[2 + finger]);
            assert_eq!(links, [format!("{name}_1"), format!("{name}_2")]);
        }
        if half_palm {
            let half = hand
                .links
                .iter()
                .position(|link| link.name == "half")
                .unwrap();
            assert_eq!(hand.links[half].digit, 0);
            let touches = |point: &landscape::hand::SurfacePoint| point.link.0 == half;
            assert!(hand.surface.iter().any(touches), "it is palm, not arm");
        }
    }
}
