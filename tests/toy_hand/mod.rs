//! Hands of boxes in URDF, among them a thumb and four fingers of two phalanges each.

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
    let bend = |name: &str, links: [&str; 2], place: &str, axis: &str, upper: f64| {
        joint(name, "revolute", links, place, axis, [0.0, upper])
    };
    // The half palm takes its half of the palm.
    let mut text = if half_palm {
        let palm = link("palm", "0.045 0.1 0.02", "0.0175 -0.05 0");
        let hollow = bend("hollow", ["palm", "half"], "-0.02 -0.06 0", "0 1 0", 0.4);
        palm + &hollow + &link("half", "0.03 0.05 0.018", "0 0.03 0.001")
    } else {
        link("palm", "0.08 0.1 0.02", "0 -0.05 0")
    };
    for (name, x) in FINGERS {
        let (carrier, base) = if half_palm && x < 0.0 {
            ("half", format!("{} 0.06 0", x + 0.02))
        } else {
            ("palm", format!("{x} 0 0"))
        };
        let [one, two] = ["1", "2"].map(|number| format!("{name}_{number}"));
        let knuckle = format!("{name}_knuckle");
        text += &bend(&knuckle, [carrier, &one], &base, "1 0 0", 1.6);
        text += &link(&one, "0.014 0.04 0.014", "0 0.022 0");
        let middle = format!("{name}_bend");
        text += &bend(&middle, [&one, &two], "0 0.045 0", "1 0 0", 1.6);
        text += &link(&two, "0.014 0.03 0.014", "0 0.017 0");
    }
    let [one, two] = ["thumb_1", "thumb_2"];
    text += &bend("thumb_base", ["palm", one], "0.045 -0.07 0", "0 0 1", 1.0);
    text += &link(one, "0.035 0.016 0.016", "0.02 0 0");
    text += &bend("thumb_bend", [one, two], "0.04 0 0", "0 0 1", 1.2);
    text += &link(two, "0.03 0.016 0.016", "0.017 0 0");
    format!("<robot name=\"toy\">{text}</robot>")
}

/// A link that is a box of these sides about `middle`.
pub(crate) fn link(name: &str, sides: &str, middle: &str) -> String {
    format!(
        "<link name=\"{name}\"><collision><origin xyz=\"{middle}\"/><geometry><box size=\"{sides}\"/></geometry></collision></link>"
    )
}

/// A joint from `parent` to `child`.
pub(crate) fn joint(
    name: &str,
    kind: &str,
    [parent, child]: [&str; 2],
    place: &str,
    axis: &str,
    [low, high]: [f64; 2],
) -> String {
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin xyz=\"{place}\"/>\
         <axis xyz=\"{axis}\"/><limit lower=\"{low}\" upper=\"{high}\" effort=\"1\" velocity=\"1\"/></joint>"
    )
}
