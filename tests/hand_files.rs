//! Published hands: URDF and MJCF files compared with `MuJoCo`'s kinematics, and the properties derived from them.
//!
//! The files are not part of the project: `LANDSCAPE_TEST_DATA` names the folder that contains them.
#![cfg(feature = "grasp")]

use std::fs;
use std::path::{Path, PathBuf};

use crate::described::described;
use crate::published::{DEX_URDF, Difference, REFERENCES, numbers, of_dex_urdf};
use crate::table::assert_says;
use landscape::hand::{Hand, HandFiles, LinkId, PosedHand};
use nalgebra::{Matrix3, Vector3};

/// The folder of the published hands, if available.
fn published() -> Option<PathBuf> {
    let folder = crate::published::folder();
    if folder.is_none() {
        crate::skipped::skipped("LANDSCAPE_TEST_DATA is not set");
    }
    folder
}

fn load(path: &Path) -> Hand {
    let files = HandFiles::load(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    Hand::from_files(&files).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The frames of all bodies agree to a nanometre and a nanoradian at 21 configurations; the order and the limits of
/// joints agree with the files.
#[test]
fn hands_move_as_in_mujoco() {
    let Some(folder) = published() else { return };
    for [description, reference] in REFERENCES {
        let hand = load(&folder.join(description));
        let reference = crate::published::reference(&folder.join(reference));
        let worst = Difference::of(&hand, &reference);
        assert!(worst.frames >= 21 * 16, "{description}: {worst:?}");
        assert!(
            worst.metres < 1e-9 && worst.radians < 1e-9,
            "{description}: {worst:?}"
        );

        let order: Vec<&str> = reference["joint_order"]
            .as_array()
            .unwrap()
            .iter()
            .map(|name| name.as_str().unwrap())
            .collect();
        let ours: Vec<&str> = hand
            .joints
            .iter()
            .map(|joint| joint.name.as_str())
            .collect();
        if Path::new(description)
            .extension()
            .is_some_and(|kind| kind == "xml")
        {
            assert_eq!(ours, order, "{description}");
        }
        for (name, range) in order
            .iter()
            .zip(reference["joint_range"].as_array().unwrap())
        {
            let joint = &hand.joints[hand.joint(name).unwrap()];
            for (limit, told) in joint.limits.iter().zip(numbers(range)) {
                assert!(
                    (limit - told).abs() < 1e-9,
                    "{description}: limits of {name}"
                );
            }
        }
    }
}

/// So do hands with meshes and couplings that are published as URDF.
#[test]
fn hands_of_dex_urdf_move_as_in_mujoco() {
    let Some(folder) = published() else { return };
    for [description, reference] in DEX_URDF {
        let files = HandFiles::load_within(&folder.join(description), &folder).unwrap();
        let hand = Hand::from_files(&files).unwrap();
        let reference = crate::published::reference(&of_dex_urdf(reference));
        let worst = Difference::of(&hand, &reference);
        assert!(
            worst.frames >= 6 * 9 && worst.metres < 1e-9 && worst.radians < 1e-9,
            "{description}: {worst:?}"
        );
    }
}

/// At the same coordinates the mirrored hand is the mirror image, to the last bit but one; mirroring twice changes nothing.
#[test]
fn mirrored_hands_are_mirror_images() {
    let mut hands: Vec<(String, HandFiles)> = ["human", "gripper_parallel", "gripper_three_finger"]
        .map(|name| (name.to_owned(), HandFiles::named(name).unwrap()))
        .into();
    if let Some(folder) = published() {
        for [description, _] in &REFERENCES[..6] {
            let files = HandFiles::load(&folder.join(description)).unwrap();
            hands.push(((*description).to_owned(), files));
        }
    }
    for (name, files) in hands {
        let right = Hand::from_files(&files).unwrap();
        let mirrored = files.mirrored().unwrap();
        let left = Hand::from_files(&mirrored).unwrap();
        let twice = Hand::from_files(&mirrored.mirrored().unwrap()).unwrap();
        assert_eq!(twice, right, "{name}");
        let mirror = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0));
        // Any pose of the root, mirrored: a quaternion keeps the part along the mirror's normal.
        let mut x = right.rest_coordinates();
        x[..7].copy_from_slice(&[0.1, -0.2, 0.3, 0.5, 0.1, -0.7, 0.2]);
        for (i, (q, joint)) in x[7..].iter_mut().zip(&right.joints).enumerate() {
            let [lower, upper] = joint.limits;
            *q = lower + (upper - lower) * (0.37 * (i + 1) as f64).fract();
        }
        let mut of_left = x.clone();
        for i in [0, 5, 6] {
            of_left[i] = -of_left[i];
        }
        let (mut a, mut b) = (PosedHand::default(), PosedHand::default());
        right.pose(&x, &mut a);
        left.pose(&of_left, &mut b);
        for (p, q) in a.points.iter().zip(&b.points) {
            assert!((mirror * p - q).norm() < 1e-12, "{name}: {p} and {q}");
        }
        for (p, q) in a.object_from_link.iter().zip(&b.object_from_link) {
            assert!(
                (mirror * p.rotation * mirror - q.rotation).amax() < 1e-12,
                "{name}"
            );
            assert!(
                (mirror * p.translation - q.translation).norm() < 1e-12,
                "{name}"
            );
        }
        for (p, q) in a.capsules.iter().flatten().zip(b.capsules.iter().flatten()) {
            assert!((mirror * p - q).norm() < 1e-12, "{name}");
        }
        for i in 0..right.surface.len() {
            let difference = mirror * right.point_normal(&a, i) - left.point_normal(&b, i);
            assert!(difference.norm() < 1e-12, "{name}: normal {i}");
        }
    }
}

/// A side file that contains all derived properties gives the same hand.
#[test]
fn the_derived_side_file_says_it_all() {
    let mut hands: Vec<HandFiles> = [
        "human",
        "human_left",
        "gripper_parallel",
        "gripper_three_finger",
    ]
    .map(|name| HandFiles::named(name).unwrap())
    .into();
    if let Some(folder) = published() {
        hands
            .push(HandFiles::load(&folder.join("shadow_dexgraspnet/shadow_hand_vis.xml")).unwrap());
    }
    for files in hands {
        let hand = Hand::from_files(&files).unwrap();
        let text = files.derived_side_file().unwrap();
        let mut with = files.clone();
        with.files.retain(|file| {
            Path::new(&file.name)
                .extension()
                .is_none_or(|kind| kind != "json")
        });
        let side = HandFiles::of_texts([["side.json", text.as_str()]])
            .files
            .remove(0);
        with.files.insert(1, side);
        let again = Hand::from_files(&with).unwrap();
        assert_eq!(
            (&again.name, &again.links, &again.joints),
            (&hand.name, &hand.links, &hand.joints)
        );
        assert_eq!(again.digits, hand.digits);
        assert_eq!(again.capsules, hand.capsules, "{}", hand.name);
        assert_eq!(again.self_pairs, hand.self_pairs, "{}", hand.name);
        assert_eq!(again.surface.len(), hand.surface.len(), "{}", hand.name);
        let off = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        assert!(off(&again.prior.rest, &hand.prior.rest) < 1e-12);
        assert!(off(&again.prior.deviations, &hand.prior.deviations) < 1e-12);
        assert!((again.palm.volar - hand.palm.volar).norm() < 1e-12);
        let (ours, theirs) = (again.pose_metric(), hand.pose_metric());
        assert!(
            off(&ours.joint_levers_m, &theirs.joint_levers_m) < 1e-12,
            "{}",
            hand.name
        );
    }
}

/// Published hands are found to have four or five digits, one of which is a thumb, and a palm that faces the side to
/// which fingers curl.
#[test]
fn roles_follow_from_the_tree() {
    let Some(folder) = published() else { return };
    for (description, digits, volar, distal) in [
        (REFERENCES[0][0], 6, -Vector3::y(), Vector3::z()),
        (REFERENCES[1][0], 6, -Vector3::y(), Vector3::z()),
        (REFERENCES[2][0], 6, -Vector3::y(), Vector3::z()),
        (REFERENCES[4][0], 6, -Vector3::y(), -Vector3::x()),
        (REFERENCES[5][0], 5, Vector3::z(), Vector3::x()),
        (REFERENCES[6][0], 5, Vector3::x(), Vector3::z()),
        // The root is turned: what is −y in the others is x here.
        (REFERENCES[7][0], 6, Vector3::x(), Vector3::z()),
    ] {
        let hand = load(&folder.join(description));
        assert_eq!(hand.digits.len(), digits, "{description}");
        assert_eq!(hand.digits[1], "thumb", "{description}");
        let of_thumb = hand.links.iter().filter(|link| link.digit == 1);
        assert!(of_thumb.clone().count() >= 4);
        let named = |name: &str| ["th", "link_1"].iter().any(|part| name.contains(part));
        assert!(
            of_thumb.into_iter().all(|link| named(&link.name)),
            "{description}"
        );
        let palm = &hand.palm;
        assert!(palm.volar.dot(&volar) > 0.8, "{description}: {palm:?}");
        assert!(palm.distal.dot(&distal) > 0.8, "{description}: {palm:?}");
        assert_eq!(hand.surface.len(), 773, "{description}");
    }
}

/// So it is for the hands of dex-urdf, of which two are grippers whose palms face between the fingers: those of Barrett
/// point to opposite sides of the palm.
#[test]
fn roles_of_dex_urdf_follow_from_the_tree() {
    let Some(folder) = published() else { return };
    let of = |place: usize| {
        let path = folder.join(DEX_URDF[place][0]);
        Hand::from_files(&HandFiles::load_within(&path, &folder).unwrap()).unwrap()
    };
    for (place, digits, thumb, volar) in [
        (0, 4, Some("link_12.0"), Vector3::x()),
        (1, 3, Some("finger_3_med_link"), Vector3::z()),
        (2, 3, None, Vector3::z()),
        (3, 5, Some("thumb_distal"), Vector3::x()),
        (4, 5, Some("thdistal"), Vector3::x()),
    ] {
        let hand = of(place);
        let name = DEX_URDF[place][1];
        assert_eq!(hand.digits.len(), 1 + digits, "{name}: {:?}", hand.digits);
        assert_eq!(hand.has_thumb(), thumb.is_some(), "{name}");
        if let Some(link) = thumb.map(|link| hand.link(link).unwrap()) {
            assert_eq!(hand.links[link.0].digit, 1, "{name}");
        }
        assert!(
            hand.palm.volar.dot(&volar) > 0.94,
            "{name}: {:?}",
            hand.palm
        );
    }
    let barrett = of(1);
    assert!(barrett.palm.volar.z > 0.998, "{:?}", barrett.palm);
    assert!(barrett.palm.distal.y.abs() > 0.998, "{:?}", barrett.palm);
}

/// Wrist and forearm belong neither to the palm nor to a digit: they keep their capsules and have no surface points.
/// The palm moves with the wrist.
#[test]
fn a_forearm_is_no_palm() {
    let Some(folder) = published() else { return };
    let hand = load(&folder.join(REFERENCES[7][0]));
    let arm: Vec<&str> = (hand.links.iter().enumerate())
        .filter(|(l, _)| hand.is_arm(LinkId(*l)))
        .map(|(_, link)| link.name.as_str())
        .collect();
    assert_eq!(arm, ["world", "forearm", "wrist"]);
    assert!((hand.capsules.iter()).any(|capsule| hand.links[capsule.link.0].name == "forearm"));
    assert!(hand.surface.iter().all(|point| !hand.is_arm(point.link)));
    // Palm and fingers have nearly the points of the same hand without a forearm.
    let alone = load(&folder.join(REFERENCES[3][0]));
    let extent = |hand: &Hand| hand.pose_metric().radius_of_gyration_m;
    assert!((extent(&hand) / extent(&alone) - 1.0).abs() < 0.2);

    let mut joints = hand.prior.rest.clone();
    assert!((hand.palm_at(&joints).volar - hand.palm.volar).norm() < 1e-12);
    let wrist = hand.joint("WRJ1").unwrap();
    joints[wrist] += 0.3;
    let moved = hand.palm_at(&joints);
    let turned = moved.volar.angle(&hand.palm.volar);
    assert!(turned > 0.25 && turned < 0.3 + 1e-9, "{turned}");
    assert!((moved.centre - hand.palm.centre).norm() > 0.005);
}

/// The palm of a gripper faces the place where its digits close.
#[test]
fn grippers_face_what_they_close_on() {
    for (name, volar, digits) in [
        (
            "gripper_parallel",
            Vector3::z(),
            &["palm", "finger 1", "finger 2"][..],
        ),
        (
            "gripper_three_finger",
            Vector3::y(),
            &["palm", "thumb", "finger 1", "finger 2"],
        ),
    ] {
        let hand = Hand::named(name).unwrap();
        assert!(
            hand.palm.volar.dot(&volar) > 0.97,
            "{name}: {:?}",
            hand.palm
        );
        assert!(hand.palm.faced_m.abs() < 1e-12, "{name}");
        assert_eq!(hand.digits, digits, "{name}");
    }
}

/// A description cannot read files outside its folder, whatever path it contains; the user may name a wider folder.
#[test]
fn references_stay_in_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("hand/meshes");
    fs::create_dir_all(&inner).unwrap();
    let tetrahedron =
        "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(folder.path().join("outside.obj"), tetrahedron).unwrap();
    fs::write(inner.join("inside.obj"), tetrahedron).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("../../outside.obj", inner.join("link.obj")).unwrap();
    let path = folder.path().join("hand/hand.urdf");
    let load = |mesh: &str, within: Option<&Path>| {
        let urdf = format!(
            r#"<robot name="r"><link name="a"><visual><geometry><mesh filename="{mesh}"/></geometry></visual></link>
            <link name="b"><visual><geometry><sphere radius="0.01"/></geometry></visual></link>
            <joint name="j" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0 0 0.2"/></joint></robot>"#
        );
        fs::write(&path, urdf).unwrap();
        let files = match within {
            Some(within) => HandFiles::load_within(&path, within),
            None => HandFiles::load(&path),
        };
        files.map(|_| ()).map_err(|error| error.to_string())
    };
    let absolute = folder.path().join("outside.obj");
    for mesh in [
        "meshes/inside.obj",
        "package://any/meshes/inside.obj",
        "meshes/../meshes/inside.obj",
    ] {
        assert_eq!(load(mesh, None), Ok(()), "{mesh}");
    }
    let mut outside = vec!["../outside.obj", absolute.to_str().unwrap()];
    if cfg!(unix) {
        outside.push("meshes/link.obj");
    }
    for mesh in outside {
        let error = load(mesh, None).unwrap_err();
        assert_says(&error, &["outside", "--hand-folder"]);
        assert_eq!(load(mesh, Some(folder.path())), Ok(()), "{mesh}");
    }
    // Not looked for outside: no word on whether it is there.
    for mesh in [
        "package://outside.obj",
        "package://any/../outside.obj",
        "package://any/outside.obj",
    ] {
        assert!(load(mesh, None).is_err(), "{mesh}");
    }
    assert_eq!(
        load("package://any/outside.obj", Some(folder.path())),
        Ok(())
    );
    if cfg!(unix) {
        assert!(load("/etc/passwd", None).unwrap_err().contains("outside"));
        assert!(
            load("file:///dev/zero", None)
                .unwrap_err()
                .contains("outside")
        );
    }
}

/// The fuzzer found this: the reader took half a minute for a hundred thousand nested elements.
#[test]
fn deep_nesting_is_refused() {
    let text = format!("<robot name=\"r\">{}", "<geometry>".repeat(100_000));
    for text in [
        text.clone(),
        text + &"</geometry>".repeat(100_000) + "</robot>",
    ] {
        let error = described(&text, None).unwrap_err().to_string();
        assert!(
            error.contains("(hand, line 1)") || error.starts_with("hand, line 1"),
            "{}",
            &error[..100]
        );
    }
}

/// A hand of a palm and a finger, each with this content.
fn two_links(palm: &str, finger: &str, more: &str) -> String {
    format!(
        r#"<robot name="r"><link name="palm">{palm}</link><link name="finger">{finger}</link>
        <joint name="j" type="revolute"><parent link="palm"/><child link="finger"/><origin xyz="0 0 0.04"/><axis xyz="1 0 0"/>
        <limit lower="0" upper="1.5" effort="1" velocity="1"/></joint>{more}</robot>"#
    )
}

const BALL: &str = r#"<geometry><sphere radius="0.02"/></geometry>"#;
/// Axes and frames that a description draws are no part of the hand, wherever they are; without any collision geometry, what
/// is drawn is the hand.
#[test]
fn marks_are_not_solid() {
    let solid = format!("<collision>{BALL}</collision>");
    let plain = described(&two_links(&solid, &solid, ""), None).unwrap();
    assert!(plain.notes.is_empty(), "{:?}", plain.notes);
    let axes = r#"<visual><geometry><cylinder radius="0.003" length="0.2"/></geometry></visual>"#;
    let link = |name: &str, parent: &str| {
        format!(
            r#"<link name="{name}">{axes}</link><joint name="{name}_joint" type="fixed"><parent link="{parent}"/>
            <child link="{name}"/></joint>"#
        )
    };
    let marked = two_links(
        &solid,
        &solid,
        &(link("axes", "palm") + &link("tip", "finger")),
    );
    let marked = described(&marked, None).unwrap();
    let [note] = &marked.notes[..] else {
        panic!("{:?}", marked.notes)
    };
    assert!(
        note.starts_with(
            "links \"tip\" and \"axes\" have no collision geometry, so visual geometry is left out"
        ),
        "{note}"
    );
    let shapes = |hand: &Hand| -> Vec<_> {
        let capsules = hand.capsules.iter();
        capsules
            .map(|capsule| (capsule.a, capsule.b, capsule.radius_m))
            .collect()
    };
    assert_eq!(shapes(&marked), shapes(&plain));
    // Marks on the finger itself, beside its collision geometry, never counted.
    let beside = described(&two_links(&solid, &(solid.clone() + axes), ""), None).unwrap();
    assert_eq!(beside, plain);
    // A mark that moves by a joint of its own.
    let moved = two_links(&solid, axes, "");
    let moved = described(&moved, None).unwrap();
    assert_eq!(moved.capsules.len(), 1);
    assert!(
        moved.notes[0].starts_with("link \"finger\" has no"),
        "{:?}",
        moved.notes
    );

    let drawn = format!("<visual>{BALL}</visual>");
    let drawn = described(&two_links(&drawn, &drawn, ""), None).unwrap();
    assert_eq!(shapes(&drawn), shapes(&plain));
    assert_eq!(
        drawn.notes,
        ["no link has collision geometry, so the visual geometry is the hand"]
    );
    // So in MJCF, where geoms that collide with nothing are drawn.
    let mjcf = |geom: &str| {
        let text = format!(
            "<mujoco><worldbody><body name=\"palm\"><geom size=\"0.02\"/><body name=\"axes\">{geom}</body>\
             <body name=\"finger\" pos=\"0 0 0.04\"><joint range=\"0 90\"/><geom size=\"0.02\"/></body></body></worldbody></mujoco>"
        );
        described(&text, None).unwrap()
    };
    let marked =
        mjcf("<geom type=\"capsule\" size=\"0.003 0.1\" contype=\"0\" conaffinity=\"0\"/>");
    assert_eq!(shapes(&marked), shapes(&mjcf("")));
    assert!(
        marked.notes[0].starts_with("link \"axes\" has no"),
        "{:?}",
        marked.notes
    );
}
