//! Descriptions of hands that cannot be used: the error names the mistake.

use crate::described::described;
use landscape::hand::{Hand, HandError, HandFiles};

#[test]
fn bad_descriptions_are_named() {
    let error = |joint: &str, geometry: &str| {
        let text = format!(
            r#"<robot name="r"><link name="a"><collision><geometry>{geometry}</geometry></collision></link>
            <link name="b"/><link name="c"/>{joint}</robot>"#
        );
        described(&text, None).unwrap_err().to_string()
    };
    let sphere = r#"<sphere radius="0.1"/>"#;
    let joint = |name: &str, kind: &str, parent: &str, child: &str, more: &str| {
        format!(
            r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{more}</joint>"#
        )
    };
    let turn = joint("j", "continuous", "a", "b", "");
    let both = turn.clone() + &joint("k", "fixed", "b", "c", "");
    assert!(described("<robot", None).is_err() && described("", None).is_err());
    assert!(matches!(
        described("<robot name=\"r\"/>", None),
        Err(HandError::Element { .. })
    ));
    for (message, joint, geometry) in [
        (
            "joint \"k\" is planar",
            turn.clone() + &joint("k", "planar", "b", "c", ""),
            sphere,
        ),
        (
            "joint \"k\" names joint \"l\"",
            turn.clone() + &joint("k", "revolute", "b", "c", r#"<mimic joint="l"/>"#),
            sphere,
        ),
        (
            "follows others in a circle",
            joint("j", "continuous", "a", "b", r#"<mimic joint="k"/>"#)
                + &joint("k", "continuous", "b", "c", r#"<mimic joint="j"/>"#),
            sphere,
        ),
        (
            "the limits of joint \"k\": -inf is not from -100 to 100 rad",
            turn.clone()
                + &joint(
                    "k",
                    "revolute",
                    "b",
                    "c",
                    r#"<limit lower="-inf" upper="inf" effort="1" velocity="1"/>"#,
                ),
            sphere,
        ),
        ("this description has 2: a, c", turn.clone(), sphere),
        (
            "two joints named \"j\"",
            turn.clone() + &joint("j", "fixed", "b", "c", ""),
            sphere,
        ),
        (
            "link \"b\" is the child of two joints, \"j\" and \"k\", but the links of a hand form a tree: delete one",
            turn.clone() + &joint("k", "fixed", "c", "b", ""),
            sphere,
        ),
        (
            "its joints form a ring",
            joint("j", "continuous", "b", "c", "") + &joint("k", "fixed", "c", "b", ""),
            sphere,
        ),
        (
            "joint \"k\" names link \"d\"",
            turn.clone() + &joint("k", "fixed", "b", "d", ""),
            sphere,
        ),
        (
            "no movable joint",
            joint("j", "fixed", "a", "b", "") + &joint("k", "fixed", "b", "c", ""),
            sphere,
        ),
        (
            "link \"a\", the mesh x.stl",
            both.clone(),
            r#"<mesh filename="x.stl"/>"#,
        ),
        (
            "a size in link \"a\": -1 is not from 1e-6 to 10 m",
            both.clone(),
            r#"<sphere radius="-1"/>"#,
        ),
        (
            "\"j\" has an axis of length zero",
            both.replace("</joint>", r#"<axis xyz="0 0 0"/></joint>"#),
            sphere,
        ),
    ] {
        let found = error(&joint, geometry);
        assert!(found.contains(message), "{found} instead of {message}");
    }
}

/// Errors of the form name element, link or joint, file and line, and say what to do.
#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
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
    let limit = r#"<limit lower="0" upper="1.4" effort="1" velocity="1"/>"#;
    let shape = r#"<geometry><box size="0.01 0.01 0.05"/></geometry>"#;
    let slide = GOOD.replace("revolute", "prismatic");
    for (text, from, to, place, problem) in [
        (
            GOOD,
            limit,
            "",
            "<joint> \"j\" (claw.urdf, line 8)",
            "<limit> is missing: add <limit",
        ),
        (
            &slide,
            limit,
            "",
            "<joint> \"j\" (claw.urdf, line 8)",
            "in metres",
        ),
        (
            GOOD,
            r#"lower="0" upper="1.4" "#,
            "",
            "<limit> of joint \"j\" (claw.urdf, line 9)",
            "lower and upper, which are missing: add them in radians, or write type=\"continuous\"",
        ),
        (
            GOOD,
            limit,
            "<limit/>",
            "<limit> of joint \"j\" (claw.urdf, line 9)",
            "missing",
        ),
        (
            GOOD,
            "upper=\"1.4\"",
            "",
            "<limit> of joint \"j\"",
            "the range from 0 to 0 is empty",
        ),
        (
            GOOD,
            "upper=\"1.4\"",
            "upper=\"wide\"",
            "<limit> of joint \"j\"",
            "\"wide\" is not a number",
        ),
        (
            GOOD,
            shape,
            "",
            "<collision> of link \"b\" (claw.urdf, line 7)",
            "<geometry> is missing: give it a shape",
        ),
        (
            GOOD,
            shape,
            "<geometry/>",
            "<geometry> of link \"b\" (claw.urdf, line 7)",
            "no shape",
        ),
        (
            GOOD,
            shape,
            "<geometry><cone/></geometry>",
            "<cone> of link \"b\"",
            "box, cylinder, capsule",
        ),
        (
            GOOD,
            "0.01 0.01 0.05",
            " 0.036 0.018",
            "<box> of link \"b\" (claw.urdf, line 7)",
            "size=\" 0.036 0.018\" has 2 numbers where 3 are needed",
        ),
        (
            GOOD,
            "xyz=\"1 0 0\"",
            "xyz=\"1,0,0\"",
            "<axis> of joint \"j\"",
            "\"1,0,0\" is not a number",
        ),
        (
            GOOD,
            "<child link=\"b\"/>",
            "",
            "<joint> \"j\"",
            "<child> is missing",
        ),
        (
            GOOD,
            "type=\"revolute\"",
            "",
            "<joint> \"j\"",
            "type is missing",
        ),
        (
            GOOD,
            "revolute",
            "hinge",
            "<joint> \"j\"",
            "type=\"hinge\": revolute, continuous",
        ),
        (
            GOOD,
            "<mass value=\"1\"/>",
            "",
            "<inertial> of link \"b\" (claw.urdf, line 5)",
            "<mass> is missing",
        ),
        (
            GOOD,
            "rgba=\"1 0 0 1\"",
            "rgba=\"1 0 0\"",
            "<color> of link \"b\"",
            "3 numbers where 4",
        ),
        (
            GOOD,
            "<axis",
            "<axis xyz=\"0 0 1\"/><axis",
            "<axis> of joint \"j\"",
            "another <axis>",
        ),
        (GOOD, "</robot>", "", "claw.urdf, line ", "not XML"),
        (
            GOOD,
            "robot",
            "model",
            "<model> (claw.urdf, line 2)",
            "the root element is <model>",
        ),
        (GOOD, "robot", "sdf", "claw.urdf", "SDF is not read"),
        (
            GOOD,
            "<link name=\"a\">",
            "<xacro:finger prefix=\"left\"/><link name=\"a\">",
            "claw.urdf: xacro is not read",
            "`xacro claw.urdf > claw_expanded.urdf`",
        ),
        (
            GOOD,
            "0.01 0.01 0.05",
            "${size}",
            "claw.urdf: xacro",
            "expand its macros",
        ),
    ] {
        let spoilt = text.replace(from, to);
        assert_ne!(spoilt, text, "{from}");
        let error = read(&spoilt).unwrap_err();
        assert!(
            error.starts_with(place) && error.contains(problem),
            "{place}: {error}"
        );
    }
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
    for (name, text, words) in [
        (
            "hand.usd",
            "PXR-USDC",
            "USD is not read: export the hand as URDF or MJCF",
        ),
        ("hand.usda", "#usda 1.0", "USD is not read"),
        ("hand.sdf", "<sdf/>", "SDF is not read"),
        ("hand.mjb", "x", "mj_saveLastXML"),
        (
            "hand.xacro",
            "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:include filename=\"a.xacro\"/><link name=\"a\"/></robot>",
            "`xacro hand.xacro > hand.urdf`",
        ),
        (
            "undeclared.urdf.xacro",
            "<robot><xacro:finger/></robot>",
            "`xacro undeclared.urdf.xacro > undeclared.urdf`",
        ),
        ("hand.urdf", POINTER, "git lfs pull"),
    ] {
        let error = told(name, text);
        assert!(
            error.contains(words) && error.contains(name),
            "{name}: {error}"
        );
    }
    std::fs::write(folder.path().join("tip.stl"), POINTER).unwrap();
    let error = told(
        "claw.urdf",
        r#"<robot name="r"><link name="a"><collision><geometry><mesh filename="tip.stl"/></geometry></collision></link></robot>"#,
    );
    assert!(
        error.contains("tip.stl: it is a Git LFS pointer"),
        "{error}"
    );
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
    assert!(
        said.contains("\"palm\" of the side file: 1e155 is not from"),
        "{said}"
    );
}

#[test]
fn bad_side_files_are_named() {
    let side = |side_file: &str| {
        let text = include_str!("../../data/hands/human/human.urdf");
        described(text, Some(side_file)).unwrap_err().to_string()
    };
    assert!(side(r#"{"rest_deg": {"toe": 3}}"#).contains("joint \"toe\""));
    assert!(side(r#"{"palms": 3}"#).contains("palms"));
    assert!(
        side(r#"{"digits": [{"name": "d", "segments": {"s": ["toe"]}}]}"#).contains("link \"toe\"")
    );
    for (entry, told) in [
        (
            r#"{"rest_mm": {"index_mcp_flexion": 3}}"#,
            "in the wrong unit",
        ),
        (
            r#"{"deviation_deg": {"index_mcp_flexion": 0}}"#,
            "0 is not from 1e-6",
        ),
        (r#"{"metric": {"levers_m": {"toe": 1}}}"#, "joint \"toe\""),
        (
            r#"{"metric": {"rotation_reach_m": -1}}"#,
            "-1 is not from 1e-6",
        ),
        // Found by fuzzing.
        (r#"{"surface_points": 0}"#, "positive"),
        (
            r#"{"surface_points": 1000000000000}"#,
            "at most 10000 are allowed: ask for fewer",
        ),
        (r#"{"no_contact": ["toe"]}"#, "link \"toe\""),
        (r#"{"without": ["toe"]}"#, "link \"toe\""),
        (r#"{"apart": [["palm", "toe"]]}"#, "link \"toe\""),
        (r#"{"filling": {"toe": []}}"#, "link \"toe\""),
    ] {
        assert!(side(entry).contains(told), "{entry}: {}", side(entry));
    }
    assert!(side(r#"{"independent_share": 0}"#).contains("independent_share"));
}
