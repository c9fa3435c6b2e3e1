//! A small hand in URDF: a thumb and four fingers of two phalanges each, all boxes.

use std::fmt::Write;

/// The fingers in order from the thumb, and their offset toward it, metres.
const FINGERS: [(&str, f64); 4] = [
    ("index", 0.03),
    ("middle", 0.01),
    ("ring", -0.01),
    ("little", -0.03),
];

/// The URDF text. With a half palm, ring and little finger are on a movable part of the palm that comes first in the file,
/// as in the Schunk SVH hand.
pub(crate) fn toy_hand(half_palm: bool) -> String {
    let mut text = String::from("<robot name=\"toy\">\n");
    // The half palm takes its half of the palm.
    let (width, middle) = if half_palm {
        (0.045, 0.0175)
    } else {
        (0.08, 0.0)
    };
    link(&mut text, "palm", [width, 0.1, 0.02], [middle, -0.05, 0.0]);
    if half_palm {
        joint(
            &mut text,
            "hollow",
            ["palm", "half"],
            [-0.02, -0.06, 0.0],
            [0, 1, 0],
            0.4,
        );
        link(&mut text, "half", [0.03, 0.05, 0.018], [0.0, 0.03, 0.001]);
    }
    for (name, x) in FINGERS {
        let on_half = half_palm && x < 0.0;
        let (carrier, shift) = if on_half {
            ("half", [0.02, 0.06])
        } else {
            ("palm", [0.0, 0.0])
        };
        let base = [x + shift[0], shift[1], 0.0];
        let one = format!("{name}_1");
        joint(
            &mut text,
            &format!("{name}_knuckle"),
            [carrier, &one],
            base,
            [1, 0, 0],
            1.6,
        );
        link(&mut text, &one, [0.014, 0.04, 0.014], [0.0, 0.022, 0.0]);
        let two = format!("{name}_2");
        joint(
            &mut text,
            &format!("{name}_bend"),
            [&one, &two],
            [0.0, 0.045, 0.0],
            [1, 0, 0],
            1.6,
        );
        link(&mut text, &two, [0.014, 0.03, 0.014], [0.0, 0.017, 0.0]);
    }
    joint(
        &mut text,
        "thumb_base",
        ["palm", "thumb_1"],
        [0.045, -0.07, 0.0],
        [0, 0, 1],
        1.0,
    );
    link(
        &mut text,
        "thumb_1",
        [0.035, 0.016, 0.016],
        [0.02, 0.0, 0.0],
    );
    joint(
        &mut text,
        "thumb_bend",
        ["thumb_1", "thumb_2"],
        [0.04, 0.0, 0.0],
        [0, 0, 1],
        1.2,
    );
    link(
        &mut text,
        "thumb_2",
        [0.03, 0.016, 0.016],
        [0.017, 0.0, 0.0],
    );
    text + "</robot>\n"
}

fn link(text: &mut String, name: &str, size: [f64; 3], [x, y, z]: [f64; 3]) {
    let [a, b, c] = size;
    let _ = writeln!(
        text,
        "<link name=\"{name}\"><collision><origin xyz=\"{x} {y} {z}\"/><geometry><box size=\"{a} {b} {c}\"/></geometry>\
         </collision></link>"
    );
}

fn joint(
    text: &mut String,
    name: &str,
    [parent, child]: [&str; 2],
    [x, y, z]: [f64; 3],
    [i, j, k]: [i32; 3],
    upper: f64,
) {
    let _ = writeln!(
        text,
        "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
         <origin xyz=\"{x} {y} {z}\"/><axis xyz=\"{i} {j} {k}\"/>\
         <limit lower=\"0\" upper=\"{upper}\" effort=\"1\" velocity=\"1\"/></joint>"
    );
}
