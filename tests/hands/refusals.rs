//! Descriptions of hands that cannot be used: the error names the mistake.

use crate::described::described;
use crate::table::{assert_says, rows};
use landscape::hand::{Hand, HandError, HandFiles};

#[test]
fn bad_descriptions_are_named() {
    let error = |joints: &str, geometry: &str| {
        let mut text = format!(
            r#"<robot name="r"><link name="a"><collision><geometry>{geometry}</geometry></collision></link>
               <link name="b"/><link name="c"/>"#
        );
        for joint in joints.split(" ; ") {
            let words: Vec<&str> = joint.splitn(5, ' ').collect();
            let [name, kind, parent, child] = words[..4] else {
                panic!("{joint}")
            };
            let more = words.get(4).unwrap_or(&"");
            let joint = format!(
                r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{more}</joint>"#
            );
            text += &joint;
        }
        described(&(text + "</robot>"), None)
            .unwrap_err()
            .to_string()
    };
    assert!(described("<robot", None).is_err() && described("", None).is_err());
    assert!(matches!(
        described("<robot name=\"r\"/>", None),
        Err(HandError::Element { .. })
    ));
    // Message, joints (name, kind, parent, child and content), and geometry of the first link.
    let cases = r#"
        joint "k" is planar | j continuous a b ; k planar b c
        joint "k" names joint "l" | j continuous a b ; k revolute b c <mimic joint="l"/>
        follows others in a circle | j continuous a b <mimic joint="k"/> ; k continuous b c <mimic joint="j"/>
        the limits of joint "k": -inf is not from -100 to 100 rad | j continuous a b ; k revolute b c <limit lower="-inf" upper="inf" effort="1" velocity="1"/>
        this description has 2: a, c | j continuous a b
        two joints named "j" | j continuous a b ; j fixed b c
        link "b" is the child of two joints, "j" and "k", but the links of a hand form a tree: delete one | j continuous a b ; k fixed c b
        its joints form a ring | j continuous b c ; k fixed c b
        joint "k" names link "d" | j continuous a b ; k fixed b d
        no movable joint | j fixed a b ; k fixed b c
        link "a", the mesh x.stl | j continuous a b ; k fixed b c | <mesh filename="x.stl"/>
        a size in link "a": -1 is not from 1e-6 to 10 m | j continuous a b ; k fixed b c | <sphere radius="-1"/>
        "j" has an axis of length zero | j continuous a b <axis xyz="0 0 0"/> ; k fixed b c
    "#;
    for case in rows(cases) {
        let geometry = case.get(2).unwrap_or(&r#"<sphere radius="0.1"/>"#);
        let found = error(case[1], geometry);
        assert!(found.contains(case[0]), "{found} instead of {}", case[0]);
    }
}

/// Errors of the form name element, link or joint, file and line, and say what to do.
#[test]
fn what_is_missing_or_unreadable_is_named_with_its_line() {
    const GOOD: &str = r#"<?xml version="1.0"?>
<robot name="r">
<link name="a"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
<link name="b">
  <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  <visual><geometry><box size="0.01 0.01 0.01"/></geometry><material name="m"><color rgba="1 0 0 1"/></material></visual>
  <collision><origin xyz="0 0 0.03" rpy="0 0 0"/><geometry><box size="0.01 0.01 0.05"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 0.02"/><axis xyz="1 0 0"/>
  <limit lower="0" upper="1.4" effort="1" velocity="1"/></joint>
</robot>"#;
    let read = |text: &str| {
        let files = HandFiles::of_texts([["claw.urdf", text]]);
        Hand::from_files(&files).map_err(|error| error.to_string())
    };
    let good = read(GOOD).unwrap();
    assert!(good.notes.is_empty(), "{:?}", good.notes);
    let refused = |text: &str, case: &[&str]| {
        let spoilt = text.replace(case[0], if case[1] == "-" { "" } else { case[1] });
        assert_ne!(spoilt, text, "{case:?}");
        let error = read(&spoilt).unwrap_err();
        assert!(
            error.starts_with(case[2]) && error.contains(case[3]),
            "{case:?}: {error}"
        );
    };
    // What is replaced, by what, the place that is named, and the problem.
    let cases = r#"
        <limit lower="0" upper="1.4" effort="1" velocity="1"/> | - | <joint> "j" (claw.urdf, line 8) | <limit> is missing: add <limit
        lower="0" upper="1.4" | - | <limit> of joint "j" (claw.urdf, line 9) | lower and upper, which are missing: add them in radians, or write type="continuous"
        <limit lower="0" upper="1.4" effort="1" velocity="1"/> | <limit/> | <limit> of joint "j" (claw.urdf, line 9) | missing
        upper="1.4" | - | <limit> of joint "j" | the range from 0 to 0 is empty
        upper="1.4" | upper="wide" | <limit> of joint "j" | "wide" is not a number
        <geometry><box size="0.01 0.01 0.05"/></geometry> | - | <collision> of link "b" (claw.urdf, line 7) | <geometry> is missing: give it a shape
        <geometry><box size="0.01 0.01 0.05"/></geometry> | <geometry/> | <geometry> of link "b" (claw.urdf, line 7) | no shape
        <geometry><box size="0.01 0.01 0.05"/></geometry> | <geometry><cone/></geometry> | <cone> of link "b" | box, cylinder, capsule
        "0.01 0.01 0.05" | " 0.036 0.018" | <box> of link "b" (claw.urdf, line 7) | size=" 0.036 0.018" has 2 numbers where 3 are needed
        xyz="1 0 0" | xyz="1,0,0" | <axis> of joint "j" | "1,0,0" is not a number
        <child link="b"/> | - | <joint> "j" | <child> is missing
        type="revolute" | - | <joint> "j" | type is missing
        revolute | hinge | <joint> "j" | type="hinge": revolute, continuous
        <mass value="1"/> | - | <inertial> of link "b" (claw.urdf, line 5) | <mass> is missing
        rgba="1 0 0 1" | rgba="1 0 0" | <color> of link "b" | 3 numbers where 4
        <axis | <axis xyz="0 0 1"/><axis | <axis> of joint "j" | another <axis>
        </robot> | - | claw.urdf, line | not XML
        robot | model | <model> (claw.urdf, line 2) | the root element is <model>
        robot | sdf | claw.urdf | SDF is not read
        <link name="a"> | <xacro:finger prefix="left"/><link name="a"> | claw.urdf: xacro is not read | `xacro claw.urdf > claw_expanded.urdf`
        0.01 0.01 0.05 | ${size} | claw.urdf: xacro | expand its macros
    "#;
    for case in rows(cases) {
        refused(GOOD, &case);
    }
    let slide = r#"<limit lower="0" upper="1.4" effort="1" velocity="1"/> | - | <joint> "j" (claw.urdf, line 8) | in metres"#;
    let slide = rows(slide).next().unwrap();
    refused(&GOOD.replace("revolute", "prismatic"), &slide);
    // A mimic joint has the limits of its leader, and nothing needs a velocity.
    let follower = r#"<link name="c"/><joint name="k" type="revolute"><parent link="b"/><child link="c"/><mimic joint="j"/></joint></robot>"#;
    assert!(read(&GOOD.replace("</robot>", follower)).is_ok());
    assert_eq!(read(&GOOD.replace(" velocity=\"1\"", "")), Ok(good));
}

/// Files of other formats, and pointers in place of files, are named as such.
#[test]
fn other_formats_are_named() {
    const POINTER: &str = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n";
    let folder = tempfile::tempdir().unwrap();
    let told = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        HandFiles::load(&path).unwrap_err().to_string()
    };
    let cases = r#"
        hand.usd | PXR-USDC | USD is not read: export the hand as URDF or MJCF
        hand.usda | #usda 1.0 | USD is not read
        hand.sdf | <sdf/> | SDF is not read
        hand.mjb | x | mj_saveLastXML
        hand.xacro | <robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="a.xacro"/><link name="a"/></robot> | `xacro hand.xacro > hand.urdf`
        undeclared.urdf.xacro | <robot><xacro:finger/></robot> | `xacro undeclared.urdf.xacro > undeclared.urdf`
    "#;
    for case in rows(cases).chain([vec!["hand.urdf", POINTER, "git lfs pull"]]) {
        let [name, text, words] = case[..] else {
            panic!("{case:?}")
        };
        let error = told(name, text);
        assert_says(&error, &[words, name]);
    }
    std::fs::write(folder.path().join("tip.stl"), POINTER).unwrap();
    let error = told(
        "claw.urdf",
        r#"<robot name="r"><link name="a"><collision><geometry><mesh filename="tip.stl"/></geometry></collision></link></robot>"#,
    );
    assert_says(&error, &["tip.stl: it is a Git LFS pointer"]);
}

/// In earlier versions such numbers led to overflows, panics and minutes of work.
#[test]
fn numbers_that_nobody_means_are_named() {
    let urdf = |[xyz, upper, axis, radius]: [&str; 4], mimic: &str| {
        format!(
            r#"<robot name="r"><link name="a"><visual><geometry><sphere radius="0.01"/></geometry></visual></link>
            <link name="b"><visual><origin xyz="{xyz} 0 0"/><geometry><sphere radius="{radius}"/></geometry></visual></link>
            <link name="c"/>
            <joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="{axis} 0 0"/>
            <limit lower="0" upper="{upper}" effort="1" velocity="1"/></joint>
            <joint name="k" type="revolute"><parent link="b"/><child link="c"/>{mimic}
            <limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>"#
        )
    };
    let good = ["0.1", "1", "1", "0.01"];
    assert!(described(&urdf(good, ""), None).is_ok());
    let told = [
        "a position in link \"b\"",
        "of joint \"j\"",
        "\"j\" has an axis of length zero",
        "a size in link \"b\"",
    ];
    for (place, told) in told.into_iter().enumerate() {
        for value in ["1e155", "-1e155", "1e308"] {
            let mut spoilt = good;
            spoilt[place] = value;
            let said = described(&urdf(spoilt, ""), None).unwrap_err().to_string();
            assert!(said.contains(told), "{value}: {said}");
        }
    }
    for mimic in ["multiplier=\"1e155\"", "offset=\"-1e155\""] {
        let mimic = format!("<mimic joint=\"j\" {mimic}/>");
        let said = described(&urdf(good, &mimic), None)
            .unwrap_err()
            .to_string();
        assert!(said.contains("the coupling of joint \"k\""), "{said}");
    }
    let mjcf = |attribute: &str| {
        let text = format!(
            "<mujoco><worldbody><body name=\"p\"><geom size=\"0.02\"/><body name=\"f\"><joint name=\"j\"/>\
             <geom size=\"0.01\" {attribute}/></body></body></worldbody></mujoco>"
        );
        described(&text, None).map_err(|error| error.to_string())
    };
    assert!(mjcf("").is_ok());
    for (attribute, told) in [
        (
            "pos=\"0 1e155 0\"",
            "a position in link \"f\": 1e155 is not from -10 to 10 m",
        ),
        (
            "quat=\"1e200 0 1e200 0\"",
            "link \"f\": the numbers of an orientation are too large",
        ),
    ] {
        let said = mjcf(attribute).unwrap_err();
        assert!(said.contains(told), "{attribute}: {said}");
    }
    let side = r#"{"palm": {"centre_m": [0, 1e155, 0], "volar": [0, 0, 1], "distal": [0, 1, 0]}}"#;
    let said = described(&urdf(good, ""), Some(side))
        .unwrap_err()
        .to_string();
    assert_says(&said, &["\"palm\" of the side file: 1e155 is not from"]);
}

#[test]
fn bad_side_files_are_named() {
    let side = |side_file: &str| {
        let text = include_str!("../../data/hands/human/human.urdf");
        described(text, Some(side_file)).unwrap_err().to_string()
    };
    // Some were found by fuzzing.
    let cases = r#"
        {"rest_deg": {"toe": 3}} | joint "toe"
        {"palms": 3} | palms
        {"digits": [{"name": "d", "segments": {"s": ["toe"]}}]} | link "toe"
        {"rest_mm": {"index_mcp_flexion": 3}} | in the wrong unit
        {"deviation_deg": {"index_mcp_flexion": 0}} | 0 is not from 1e-6
        {"metric": {"levers_m": {"toe": 1}}} | joint "toe"
        {"metric": {"rotation_reach_m": -1}} | -1 is not from 1e-6
        {"surface_points": 0} | positive
        {"surface_points": 1000000000000} | at most 10000 are allowed: ask for fewer
        {"no_contact": ["toe"]} | link "toe"
        {"without": ["toe"]} | link "toe"
        {"apart": [["palm", "toe"]]} | link "toe"
        {"filling": {"toe": []}} | link "toe"
        {"independent_share": 0} | independent_share
    "#;
    for case in rows(cases) {
        let error = side(case[0]);
        assert!(error.contains(case[1]), "{}: {error}", case[0]);
    }
}
