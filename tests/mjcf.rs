//! MJCF, tested on a description with all difficult features: every way to write a frame, classes, includes, couplings.
//! Errors name the place.
//!
//! Reference: `MuJoCo` 4.0.0, `mj_kinematics`, for the files below.
#![cfg(feature = "grasp")]

use std::fs;
use std::path::Path;

use crate::described::described;
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
    assert!((hand.joints[3].limits_rad[1] - 20f64.to_radians()).abs() < 1e-15);
    // a2 = ref + 0.1 + a1 / 2 stays between -40° and 80°, which leaves a1 less.
    let lower = 2.0 * (-40f64.to_radians() - 15f64.to_radians() - 0.1);
    let upper = 2.0 * (80f64.to_radians() - 15f64.to_radians() - 0.1);
    let [low, high] = hand.joints[0].limits_rad;
    assert!((low - lower.max(-40f64.to_radians())).abs() < 1e-12);
    assert!((high - upper.min(80f64.to_radians())).abs() < 1e-12);
    assert_eq!(
        hand.notes.len(),
        2,
        "plane and free joint: {:?}",
        hand.notes
    );

    for (name, position, [w, i, j, k]) in [
        (
            "palm",
            [
                0.016_317_591_116_653_5,
                0.170_573_706_390_488_63,
                0.062_464_911_203_745_255,
            ],
            [
                0.828_246_507_042_941_6,
                0.292_233_405_644_475_8,
                0.424_140_982_152_434_5,
                0.220_707_470_320_707_17,
            ],
        ),
        (
            "a",
            [
                0.034_973_322_327_766_08,
                0.183_009_647_622_735_6,
                0.040_577_935_195_948_38,
            ],
            [
                0.274_929_875_765_247,
                0.436_701_491_775_193_3,
                0.357_926_556_649_574_57,
                0.778_199_171_509_456_9,
            ],
        ),
        (
            "b",
            [
                0.014_848_962_866_831_584,
                0.165_194_111_464_822_93,
                0.082_967_958_588_846_8,
            ],
            [
                0.903_339_568_413_507_3,
                -0.010_172_232_659_244_891,
                0.218_301_201_232_901_25,
                0.369_078_223_905_849_9,
            ],
        ),
        (
            "c",
            [
                0.087_562_775_469_664_01,
                0.202_026_751_178_617_18,
                0.062_319_581_651_104_315,
            ],
            [
                -0.315_189_800_860_792_8,
                0.272_473_885_506_119_45,
                -0.174_350_585_473_043_33,
                0.892_196_864_204_161_1,
            ],
        ),
    ] {
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
    // Middles and directions of the capsules.
    for (name, radius, position, axis) in [
        (
            "a",
            0.015,
            [
                0.061_268_048_898_715_05,
                0.192_518_199_400_676_38,
                0.051_448_758_423_526_35,
            ],
            Some([
                -0.467_410_740_986_052_84,
                0.740_514_525_557_081_2,
                0.482_872_070_687_298_3,
            ]),
        ),
        (
            "b",
            0.008,
            [
                0.020_970_038_053_708_38,
                0.180_267_450_794_487_36,
                0.104_998_094_312_654_58,
            ],
            Some([
                -0.223_510_063_735_838_23,
                -0.550_400_531_185_800_6,
                -0.804_426_818_721_995_1,
            ]),
        ),
        (
            "b",
            0.010,
            [
                0.027_871_022_197_540_875,
                0.167_546_384_395_894_62,
                0.132_211_158_960_524_85,
            ],
            None,
        ),
        (
            "c",
            0.015,
            [
                0.099_484_930_371_315_8,
                0.199_239_788_941_866_45,
                0.078_133_975_853_600_5,
            ],
            Some([
                0.596_107_745_082_589_1,
                -0.139_348_111_837_537_12,
                0.790_719_710_124_809_7,
            ]),
        ),
    ] {
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
            let across = (to - from).normalize().cross(&Vector3::from(axis));
            assert!(across.norm() < 1e-9, "{name}");
        }
    }
}

/// The fuzzer found this fault.
#[test]
fn a_range_whose_square_is_zero_is_told() {
    let text = "<mujoco><worldbody><body name=\"p\"><geom size=\"1\"/><body name=\"f\">\
                <joint type=\"slide\" range=\"0 1e-320\"/><geom size=\"0.01\"/></body></body></worldbody></mujoco>";
    let error = described(text, None).unwrap_err().to_string();
    assert!(
        error.contains("is not from 1e-6 to 100 rad or m"),
        "{error}"
    );
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
    for (inside, told) in [
        ("<joint type=\"ball\"/>", ["<joint>", "ball"]),
        ("<joint axis=\"0 0 0\"/>", ["<joint>", "no direction"]),
        (
            "<joint name=\"q\" range=\"1 2 3\"/>",
            ["<joint> \"q\"", "3 numbers where 2"],
        ),
        ("<joint range=\"2 1\"/>", ["<joint>", "is empty"]),
        ("<joint limited=\"true\"/>", ["<joint>", "range is missing"]),
        ("<joint type=\"slide\"/>", ["<joint>", "range is missing"]),
        (
            "<joint class=\"l\"/>",
            ["<joint>", "no default class is called \"l\""],
        ),
        ("<joint pos=\"0 x 0\"/>", ["<joint>", "finite numbers"]),
        ("<joint pos=\"0 nan 0\"/>", ["<joint>", "finite numbers"]),
        ("<joint/><geom/>", ["<geom>", "positive number"]),
        ("<joint/><geom type=\"sdf\"/>", ["<geom>", "sdf"]),
        (
            "<joint/><geom type=\"mesh\"/>",
            ["<geom>", "mesh is missing"],
        ),
        (
            "<joint/><geom mesh=\"none\"/>",
            ["<geom>", "no mesh is called \"none\""],
        ),
        (
            "<joint/><geom mesh=\"gone\"/>",
            ["<mesh> \"gone\"", "line 5"],
        ),
        (
            "<joint/><geom size=\"1\" quat=\"0 0 0 0\"/>",
            ["<geom>", "no direction"],
        ),
        (
            "<joint/><geom size=\"1\" euler=\"0 0 0\" zaxis=\"1 0 0\"/>",
            ["<geom>", "both"],
        ),
        ("<joint/><replicate/>", ["<replicate>", "not read"]),
        (
            "<include file=\"away.xml\"/>",
            ["<include> \"away.xml\"", "not among the files"],
        ),
        ("<include/>", ["<include>", "file is missing"]),
        ("<joint></body>", ["hand", "not XML"]),
    ] {
        let error = described(&body(inside), None).unwrap_err().to_string();
        for part in told {
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
    for nothing in [
        "<mujoco/>",
        "<mujoco><worldbody/></mujoco>",
        "<mujocoinclude/>",
        "<mujoco",
    ] {
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
    assert!(
        error.contains("line 2") && error.contains("ring.xml includes itself"),
        "{error}"
    );
    fs::write(
        folder.path().join("b.xml"),
        "<mujocoinclude><include file=\"./ring.xml\"/></mujocoinclude>",
    )
    .unwrap();
    fs::write(&path, "<mujoco>\n<include file=\"b.xml\"/></mujoco>").unwrap();
    let error = HandFiles::load(&path).unwrap_err().to_string();
    assert!(
        error.contains("ring.xml includes itself by way of b.xml"),
        "{error}"
    );
    fs::write(folder.path().join("b.xml"), "<mujocoinclude/>").unwrap();
    fs::write(
        &path,
        "<mujoco><include file=\"b.xml\"/>\n<include file=\"b.xml\"/></mujoco>",
    )
    .unwrap();
    let error = HandFiles::load(&path).unwrap_err().to_string();
    assert!(
        error.contains("line 2") && error.contains("b.xml is included a second time"),
        "{error}"
    );

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

/// A model without a name of its own has that of its file.
#[test]
fn nameless_models_are_called_as_their_files() {
    let name = |text: &str| {
        let folder = tempfile::tempdir().expect("a folder for two small files");
        let path = folder.path().join("claw.v2.xml");
        fs::write(folder.path().join("tip.xml"), TIP).expect("space for a small file");
        fs::write(&path, text).expect("space for a small file");
        let files = HandFiles::load(&path).expect("a hand");
        Hand::from_files(&files).expect("a hand").name
    };
    assert_eq!(name(KNOT), "knot");
    for model in ["", " model=\"\"", " model=\"MuJoCo Model\""] {
        let text = KNOT.replacen(" model=\"knot\"", model, 1);
        assert_eq!(name(&text), "claw.v2");
    }
}
