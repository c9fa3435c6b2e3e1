//! MJCF, tested on a description with all difficult features: every way to write a frame, classes, includes, couplings.
//! Errors name the place.
//!
//! Reference: `MuJoCo` 4.0.0, `mj_kinematics`, for the files below.
#![cfg(feature = "grasp")]

use std::fs;
use std::path::Path;

use crate::described::described;
use crate::table::{assert_says, rows};
use landscape::hand::{Hand, HandFiles, JointKind, PosedHand};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

const KNOT: &str = r#"<!-- a comment first --><mujoco model="knot">
  <compiler angle="degree" eulerseq="XYz" autolimits="true"/>
  <default>
    <joint axis="0 1 0" range="-40 80"/>
    <geom type="capsule" size="0.01 0.02"/>
    <default class="thick">
      <geom size="0.015 0.02"/>
      <default class="thicker"><geom euler="0 90 0"/></default>
    </default>
    <default class="slide"><joint type="slide" axis="1 0 1" range="-0.01 0.03"/></default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <frame pos="0.1 0 0" euler="10 20 30">
      <body name="palm" pos="0 0.2 0" axisangle="1 1 0 40" childclass="thick">
        <freejoint/>
        <geom name="flat" type="box" size="0.03 0.04 0.01"/>
        <body name="a" pos="0.03 0 0" xyaxes="0 1 0 -1 0 0.2">
          <joint name="a1" pos="0 0.01 0.02"/>
          <joint name="a2" axis="1 0 0" pos="-0.005 0 0" ref="15"/>
          <geom name="side" class="thicker" pos="0 0 0.03"/>
          <include file="tip.xml"/>
        </body>
        <body name="b" pos="-0.03 0 0" zaxis="0 1 1">
          <joint name="b1" class="slide"/>
          <joint name="b2" range="-20 20"/>
          <geom name="ends" fromto="0 0 0 0.01 0.02 0.05" size="0.008"/>
          <frame pos="0 0 0.05" quat="1 0 0 1"><geom name="ball" type="sphere" size="0.01" pos="0 0.01 0"/></frame>
        </body>
      </body>
    </frame>
  </worldbody>
  <equality><joint joint1="a2" joint2="a1" polycoef="0.1 0.5 0 0 0"/></equality>
</mujoco>
"#;

const TIP: &str = r#"<mujocoinclude>
  <body name="c" pos="0 0 0.06" euler="0 0 90">
    <joint name="c1" range="0 90"/>
    <geom name="tip" pos="0 0 0.02"/>
  </body>
</mujocoinclude>
"#;

/// The difficult hand, read from files and posed.
fn knot() -> (Hand, PosedHand) {
    let folder = tempfile::tempdir().expect("a folder for two small files");
    let path = folder.path().join("knot.xml");
    fs::write(&path, KNOT).expect("the folder is ours");
    fs::write(folder.path().join("tip.xml"), TIP).expect("the folder is ours");
    let files = HandFiles::load(&path).expect("MuJoCo reads it");
    assert_eq!(files.files.len(), 2);
    let hand = Hand::from_files(&files).expect("MuJoCo reads it");
    let mut x = hand.rest_coordinates();
    x[7..].copy_from_slice(&[0.4, 0.7, 0.02, -0.2]);
    let mut posed = PosedHand::default();
    hand.pose(&x, &mut posed);
    (hand, posed)
}

/// The name that a line begins with, and its numbers.
fn numbered(line: &str) -> (&str, Vec<f64>) {
    let mut words = line.split_whitespace();
    let name = words.next().expect("a line has a name");
    (
        name,
        words
            .map(|word| word.parse().expect("numbers follow"))
            .collect(),
    )
}

#[test]
fn joints_and_bodies_are_as_in_mujoco() {
    let (hand, posed) = knot();
    let names: Vec<&str> = hand
        .joints
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    assert_eq!(names, ["a1", "c1", "b1", "b2"]);
    assert_eq!(hand.joints[2].kind, JointKind::Slide);
    assert!((hand.joints[3].limits[1] - 20f64.to_radians()).abs() < 1e-15);
    // a2 = ref + 0.1 + a1 / 2 stays between -40° and 80°, which leaves a1 less.
    let lower = 2.0 * (-40f64.to_radians() - 15f64.to_radians() - 0.1);
    let upper = 2.0 * (80f64.to_radians() - 15f64.to_radians() - 0.1);
    let [low, high] = hand.joints[0].limits;
    assert!((low - lower.max(-40f64.to_radians())).abs() < 1e-12);
    assert!((high - upper.min(80f64.to_radians())).abs() < 1e-12);
    assert_eq!(
        hand.notes.len(),
        2,
        "plane and free joint: {:?}",
        hand.notes
    );

    // Body, position and quaternion.
    let bodies = "
        palm 0.0163175911166535 0.17057370639048863 0.062464911203745255 0.8282465070429416 0.2922334056444758 0.4241409821524345 0.22070747032070717
        a 0.03497332232776608 0.1830096476227356 0.04057793519594838 0.274929875765247 0.4367014917751933 0.35792655664957457 0.7781991715094569
        b 0.014848962866831584 0.16519411146482293 0.0829679585888468 0.9033395684135073 -0.010172232659244891 0.21830120123290125 0.3690782239058499
        c 0.08756277546966401 0.20202675117861718 0.062319581651104315 -0.3151898008607928 0.27247388550611945 -0.17435058547304333 0.8921968642041611
    ";
    for line in bodies
        .lines()
        .skip(1)
        .filter(|line| !line.trim().is_empty())
    {
        let (name, numbers) = numbered(line);
        let [x, y, z, w, i, j, k] = numbers[..] else {
            panic!("{line}");
        };
        let position = [x, y, z];
        let frame = posed.object_from_link[hand.link(name).unwrap().0];
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        let rotation: Matrix3<f64> = *rotation.to_rotation_matrix().matrix();
        assert!(
            (frame.translation - Vector3::from(position)).norm() < 1e-12,
            "{name}"
        );
        assert!((frame.rotation - rotation).amax() < 1e-12, "{name}");
    }
}

#[test]
fn capsules_are_as_in_mujoco() {
    let (hand, posed) = knot();
    // Radii, middles and directions of the capsules; a ball has none.
    let capsules = "
        a 0.015 0.06126804889871505 0.19251819940067638 0.05144875842352635 -0.46741074098605284 0.7405145255570812 0.4828720706872983
        b 0.008 0.02097003805370838 0.18026745079448736 0.10499809431265458 -0.22351006373583823 -0.5504005311858006 -0.8044268187219951
        b 0.01 0.027871022197540875 0.16754638439589462 0.13221115896052485
        c 0.015 0.0994849303713158 0.19923978894186645 0.0781339758536005 0.5961077450825891 -0.13934811183753712 0.7907197101248097
    ";
    for line in capsules
        .lines()
        .skip(1)
        .filter(|line| !line.trim().is_empty())
    {
        let (name, numbers) = numbered(line);
        let (radius, position) = (numbers[0], [numbers[1], numbers[2], numbers[3]]);
        let axis = numbers.get(4..7).map(Vector3::from_column_slice);
        let link = hand.link(name).unwrap();
        let place = hand
            .capsules
            .iter()
            .position(|capsule| capsule.link == link && (capsule.radius_m - radius).abs() < 1e-12)
            .unwrap();
        let [from, to] = posed.capsules[place];
        assert!(
            (from.lerp(&to, 0.5) - Vector3::from(position)).norm() < 1e-12,
            "{name}"
        );
        if let Some(axis) = axis {
            let across = (to - from).normalize().cross(&axis);
            assert!(across.norm() < 1e-9, "{name}");
        }
    }
}

/// Each fault is named with its element, the file and the line.
#[test]
fn faults_are_found_where_they_are() {
    let body = |inside: &str| {
        format!(
            "<mujoco>\n<compiler meshdir=\"m\"/>\n<default><default class=\"k\"/></default>\n<asset>\n\
             <mesh name=\"gone\" file=\"gone.stl\"/></asset>\n<worldbody><body name=\"p\"><geom size=\"0.1\"/>\n\
             <body name=\"f\">\n{inside}\n</body></body></worldbody></mujoco>"
        )
    };
    let good = "<joint name=\"j\"/><geom size=\"0.01\"/>";
    assert!(described(&body(good), None).is_ok());
    let cases = r#"
        <joint type="ball"/> | <joint> | ball
        <joint axis="0 0 0"/> | <joint> | no direction
        <joint name="q" range="1 2 3"/> | <joint> "q" | 3 numbers where 2
        <joint range="2 1"/> | <joint> | is empty
        <joint limited="true"/> | <joint> | range is missing
        <joint type="slide"/> | <joint> | range is missing
        <joint class="l"/> | <joint> | no default class is called "l"
        <joint pos="0 x 0"/> | <joint> | finite numbers
        <joint pos="0 nan 0"/> | <joint> | finite numbers
        <joint/><geom/> | <geom> | positive number
        <joint/><geom type="sdf"/> | <geom> | sdf
        <joint/><geom type="mesh"/> | <geom> | mesh is missing
        <joint/><geom mesh="none"/> | <geom> | no mesh is called "none"
        <joint/><geom mesh="gone"/> | <mesh> "gone" | line 5
        <joint/><geom size="1" quat="0 0 0 0"/> | <geom> | no direction
        <joint/><geom size="1" euler="0 0 0" zaxis="1 0 0"/> | <geom> | both
        <joint/><replicate/> | <replicate> | not read
        <include file="away.xml"/> | <include> "away.xml" | not among the files
        <include/> | <include> | file is missing
        <joint></body> | hand | not XML
    "#;
    for case in rows(cases) {
        let inside = case[0];
        let error = described(&body(inside), None).unwrap_err().to_string();
        for part in &case[1..] {
            assert!(error.contains(part), "{inside}: {error}");
        }
        if !error.contains("line 5") {
            assert!(error.contains("line 8"), "{inside}: {error}");
        }
    }
    let deep = format!(
        "<mujoco>{}{}</mujoco>",
        "<body>".repeat(400),
        "</body>".repeat(400)
    );
    assert!(described(&deep, None).is_err());
    for nothing in "<mujoco/> <mujoco><worldbody/></mujoco> <mujocoinclude/> <mujoco".split(' ') {
        assert!(described(nothing, None).is_err(), "{nothing}");
    }
}

/// A file that includes itself, and a package path that leads out of its package, are refused.
#[test]
fn circles_and_ways_out_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ring.xml");
    fs::write(&path, "<mujoco>\n<include file=\"ring.xml\"/></mujoco>").unwrap();
    let error = HandFiles::load(&path).unwrap_err().to_string();
    assert_says(&error, &["line 2", "ring.xml includes itself"]);
    fs::write(
        folder.path().join("b.xml"),
        "<mujocoinclude><include file=\"./ring.xml\"/></mujocoinclude>",
    )
    .unwrap();
    fs::write(&path, "<mujoco>\n<include file=\"b.xml\"/></mujoco>").unwrap();
    let error = HandFiles::load(&path).unwrap_err().to_string();
    assert_says(&error, &["ring.xml includes itself by way of b.xml"]);
    fs::write(folder.path().join("b.xml"), "<mujocoinclude/>").unwrap();
    fs::write(
        &path,
        "<mujoco><include file=\"b.xml\"/>\n<include file=\"b.xml\"/></mujoco>",
    )
    .unwrap();
    let error = HandFiles::load(&path).unwrap_err().to_string();
    assert_says(&error, &["line 2", "b.xml is included a second time"]);

    let path = folder.path().join("out.urdf");
    let link = r#"<link name="a"><visual><geometry><mesh filename="package://p/../../secret.obj"/></geometry></visual></link>"#;
    fs::write(&path, format!("<robot name=\"r\">{link}</robot>")).unwrap();
    let error = HandFiles::load(&path).unwrap_err().to_string();
    assert!(error.contains("inside its package"), "{error}");
    let error = HandFiles::load(Path::new("/nowhere/hand.urdf"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("/nowhere/hand.urdf"), "{error}");
}

/// Mesh assets: `refpos`, `refquat`, then `scale`, in this order.
#[test]
fn mesh_frames_are_applied() {
    let text = r#"<mujoco><asset>
        <mesh name="m" vertex="0 0 0  10 0 0  0 20 0  0 0 30" refpos="1 0 0" refquat="0.7 0 0 0.7" scale="0.001 0.002 0.001"/>
        </asset><worldbody><body name="p"><geom size="0.002" pos="0 0 0.1"/><body name="f"><joint/><geom mesh="m"/></body></body></worldbody></mujoco>"#;
    let hand = described(text, None).unwrap();
    let link = hand.link("f").unwrap();
    let of_link = hand.surface.iter().filter(|point| point.link == link);
    let (low, high) = of_link.fold(
        (
            Vector3::repeat(f64::INFINITY),
            Vector3::repeat(f64::NEG_INFINITY),
        ),
        |(low, high), at| (low.inf(&at.point), high.sup(&at.point)),
    );
    // Moved by -1 along x, a quarter of a turn back about z, then scaled; MuJoCo has the same corners.
    let (expected_low, expected_high) = (
        Vector3::new(0.0, -0.018, 0.0),
        Vector3::new(0.02, 0.002, 0.03),
    );
    assert!((low - expected_low).amax() < 2.5e-3, "{low}");
    assert!((high - expected_high).amax() < 2.5e-3, "{high}");
}

/// The fuzzer found this: lines were counted from the start for each element, and all pairs were compared.
#[test]
fn large_descriptions_take_no_time_or_are_refused() {
    let around = |inside: &str, outside: &str| {
        format!(
            "<mujoco><worldbody><body name=\"p\"><geom size=\"0.02\"/>{inside}<body name=\"f\"><joint/>\
             <geom size=\"0.01\" pos=\"0 0 0.05\"/></body></body></worldbody>{outside}</mujoco>"
        )
    };
    let sites = "<site pos=\"0 0 0\"/>\n".repeat(50_000);
    let hand = described(&around(&sites, ""), Some(r#"{"surface_points": 20}"#)).unwrap();
    assert_eq!(hand.links.len(), 2);
    let geoms = "<geom type=\"ellipsoid\" size=\"0.01 0.02 0.03\"/>".repeat(600);
    let bodies: Vec<String> = (0..1100)
        .map(|i| format!("<body name=\"b{i}\"/>"))
        .collect();
    let bodies = bodies.concat();
    for (inside, parts) in [
        (geoms, ["602 pieces of geometry", "side file"]),
        (bodies, ["1102 links", "at most 1000"]),
    ] {
        let error = described(&around(&inside, ""), None)
            .unwrap_err()
            .to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
}
