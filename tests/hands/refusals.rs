//! Descriptions of hands that cannot be used: the error names the mistake.

use landscape::hand::{Hand, HandError};

#[test]
fn bad_descriptions_are_named() {
    let error = |joint: &str, geometry: &str| {
        let text = format!(
            r#"<robot name="r"><link name="a"><collision><geometry>{geometry}</geometry></collision></link>
            <link name="b"/><link name="c"/>{joint}</robot>"#
        );
        Hand::from_urdf(&text, None).unwrap_err().to_string()
    };
    let sphere = r#"<sphere radius="0.1"/>"#;
    let joint = |name: &str, kind: &str, parent: &str, child: &str, more: &str| {
        format!(
            r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{more}</joint>"#
        )
    };
    let turn = joint("j", "continuous", "a", "b", "");
    let both = turn.clone() + &joint("k", "fixed", "b", "c", "");
    assert!(Hand::from_urdf("<robot", None).is_err() && Hand::from_urdf("", None).is_err());
    assert!(matches!(
        Hand::from_urdf("<robot name=\"r\"/>", None),
        Err(HandError::Roots { .. })
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
            "joint \"k\" may move from 0 to 0:",
            turn.clone() + &joint("k", "revolute", "b", "c", ""),
            sphere,
        ),
        ("this description has 2: a, c", turn.clone(), sphere),
        (
            "two joints named \"j\"",
            turn.clone() + &joint("j", "fixed", "b", "c", ""),
            sphere,
        ),
        (
            "link \"b\" is the child of two joints, \"j\" and \"k\"",
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
    assert!(Hand::from_urdf(&urdf(good, ""), None).is_ok());
    let told = [
        "a position in link \"b\"",
        "the limits of joint \"j\"",
        "\"j\" has an axis of length zero",
        "a size in link \"b\"",
    ];
    for (place, told) in told.into_iter().enumerate() {
        for value in ["1e155", "-1e155", "1e308"] {
            let mut spoilt = good;
            spoilt[place] = value;
            let said = Hand::from_urdf(&urdf(spoilt, ""), None)
                .unwrap_err()
                .to_string();
            assert!(said.contains(told), "{value}: {said}");
        }
    }
    for mimic in ["multiplier=\"1e155\"", "offset=\"-1e155\""] {
        let mimic = format!("<mimic joint=\"j\" {mimic}/>");
        let said = Hand::from_urdf(&urdf(good, &mimic), None)
            .unwrap_err()
            .to_string();
        assert!(said.contains("the coupling of joint \"k\""), "{said}");
    }
    let mjcf = |attribute: &str| {
        let text = format!(
            "<mujoco><worldbody><body name=\"p\"><geom size=\"0.02\"/><body name=\"f\"><joint name=\"j\"/>\
             <geom size=\"0.01\" {attribute}/></body></body></worldbody></mujoco>"
        );
        Hand::from_urdf(&text, None).map_err(|error| error.to_string())
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
    let said = Hand::from_urdf(&urdf(good, ""), Some(side))
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
        Hand::from_urdf(text, Some(side_file))
            .unwrap_err()
            .to_string()
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
