//! Hands that can be read but are hardly meant, or not meant as they are written: virtual wrists, closed loops, fingers that
//! touch where they rest, and confused units.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write;

use crate::described::described;
use crate::published::{DEX_URDF, REFERENCES};
use crate::table::assert_says;
use crate::toy_hand::{joint, link};
use landscape::hand::{HAND_NAMES, Hand, HandFiles, PosedHand};
use nalgebra::Vector3;

use super::gap;

/// A digit of two phalanges: name, base on the palm, axis, and range of both joints as URDF texts.
#[derive(Clone, Copy)]
struct Digit {
    name: &'static str,
    base: &'static str,
    axis: &'static str,
    range: [f64; 2],
    /// Attributes of the box that the last phalanx is made of.
    tip: &'static str,
}

const fn digit(name: &'static str, base: &'static str, axis: &'static str) -> Digit {
    Digit {
        name,
        base,
        axis,
        range: [0.0, 1.4],
        tip: "0.016 0.016 0.04",
    }
}

const THREE: [Digit; 3] = [
    digit("one", "-0.04 0.025 0.02", "0 1 0"),
    digit("two", "-0.04 -0.025 0.02", "0 1 0"),
    digit("thumb", "0.04 0 0.02", "0 -1 0"),
];

/// The palm and its digits in URDF, without the element around them.
fn body(digits: &[Digit]) -> String {
    let mut text = link("palm", "0.1 0.08 0.03", "0 0 0");
    for digit in digits {
        let [near, far] = ["near", "far"].map(|part| format!("{}_{part}", digit.name));
        text += &link(&near, "0.016 0.016 0.045", "0 0 0.0245");
        text += &link(&far, digit.tip, "0 0 0.0225");
        let bend = |name: &str, links: [&str; 2], place: &str| {
            joint(name, "revolute", links, place, digit.axis, digit.range)
        };
        text += &bend(&format!("{}_1", digit.name), ["palm", &near], digit.base);
        text += &bend(&format!("{}_2", digit.name), [&near, &far], "0 0 0.05");
    }
    text
}

fn read(digits: &[Digit]) -> Result<Hand, String> {
    urdf(&body(digits))
}

fn urdf(body: &str) -> Result<Hand, String> {
    let text = format!("<robot name=\"claw\">{body}</robot>");
    described(&text, None).map_err(|error| error.to_string())
}

fn posed(hand: &Hand, joints: &[f64]) -> PosedHand {
    let mut x = hand.rest_coordinates();
    x[7..].copy_from_slice(joints);
    let mut posed = PosedHand::default();
    hand.pose(&x, &mut posed);
    posed
}

/// Whether some capsules of two links are checked against each other.
fn checked(hand: &Hand, links: [&str; 2]) -> bool {
    let named = |capsule: usize| hand.links[hand.capsules[capsule].link.0].name.as_str();
    let pairs = hand.self_pairs.iter().map(|pair| pair.map(named));
    pairs
        .into_iter()
        .any(|pair| pair == links || pair == [links[1], links[0]])
}

#[test]
fn digits_that_touch_at_rest_but_not_always_are_checked() {
    // Half closed, as they rest, the tips of thumb and fingers are inside each other.
    let close = |base| Digit { base, ..THREE[0] };
    let digits = [
        close("-0.04 0.0075 0.02"),
        Digit {
            name: "two",
            ..close("-0.04 -0.0075 0.02")
        },
        THREE[2],
    ];
    let hand = read(&digits).unwrap();
    let rest = posed(&hand, &hand.prior.rest);
    let tips = |hand: &Hand, posed: &PosedHand| {
        let link = |name: &str| hand.link(name).unwrap();
        let of = |name: &str| {
            (0..hand.capsules.len())
                .filter(move |&c| hand.capsules[c].link == link(name))
                .collect::<Vec<_>>()
        };
        let (first, second) = (of("one_far"), of("thumb_far"));
        let pairs = first
            .iter()
            .flat_map(|&i| second.iter().map(move |&j| [i, j]));
        pairs
            .map(|pair| gap(hand, posed, pair))
            .fold(f64::INFINITY, f64::min)
    };
    assert!(tips(&hand, &rest) < -5e-3, "the example is as it is meant");
    assert!(tips(&hand, &posed(&hand, &[0.0; 6])) > 0.04);
    for links in [
        ["one_far", "thumb_far"],
        ["two_far", "thumb_far"],
        ["one_far", "two_far"],
        ["one_near", "two_near"],
    ] {
        assert!(checked(&hand, links), "{links:?}");
    }
    // Digits that share a knuckle are always inside each other there, and near the palm they nearly always are.
    let knuckle = [
        close("-0.04 0.003 0.02"),
        Digit {
            name: "two",
            ..close("-0.04 -0.003 0.02")
        },
        THREE[2],
    ];
    let hand = read(&knuckle).unwrap();
    assert!(!checked(&hand, ["one_near", "two_near"]));
    assert!(checked(&hand, ["one_far", "two_far"]));
}

/// What a virtual wrist is made of: names, kinds, axes and ranges of joints, one behind the other.
const WRIST: [(&str, &str, &str, [f64; 2]); 6] = [
    ("slide_x", "prismatic", "1 0 0", [-1.0, 1.0]),
    ("slide_y", "prismatic", "0 1 0", [-1.0, 1.0]),
    ("slide_z", "prismatic", "0 0 1", [-1.0, 1.0]),
    ("roll", "revolute", "1 0 0", [-PI, PI]),
    ("pitch", "revolute", "0 1 0", [-FRAC_PI_2, FRAC_PI_2]),
    ("yaw", "continuous", "0 0 1", [0.0, 0.0]),
];

/// URDF of these joints in front of the palm, each at `place` in the link before.
fn wrist(joints: &[(&str, &str, &str, [f64; 2])], place: &str) -> String {
    let mut text = String::from("<link name=\"base\"/>");
    let mut above = "base".to_owned();
    for (k, &(name, kind, axis, range)) in joints.iter().enumerate() {
        let below = if k + 1 == joints.len() {
            "palm".to_owned()
        } else {
            let _ = write!(text, "<link name=\"{name}_link\"/>");
            format!("{name}_link")
        };
        text += &joint(name, kind, [&above, &below], place, axis, range);
        above = below;
    }
    text
}

#[test]
fn a_virtual_wrist_becomes_the_pose() {
    let plain = read(&THREE).unwrap();
    // Joints of the hand come first in the file, and the palm is not where the root is.
    for (text, displaced) in [
        (wrist(&WRIST, "0 0 0") + &body(&THREE), false),
        (body(&THREE) + &wrist(&WRIST, "0 0 0"), false),
        (wrist(&WRIST[..3], "0 0 0") + &body(&THREE), false),
        (wrist(&WRIST, "0 0 0.05") + &body(&THREE), true),
        // Marks for drawing are no geometry.
        (
            wrist(&WRIST, "0 0 0").replace(
                "<link name=\"roll_link\"/>",
                "<link name=\"roll_link\"><visual><geometry><sphere radius=\"0.01\"/></geometry></visual></link>",
            ) + &body(&THREE),
            false,
        ),
    ] {
        let hand = urdf(&text).unwrap();
        let names = |hand: &Hand| {
            hand.joints
                .iter()
                .map(|joint| joint.name.clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(names(&hand), names(&plain));
        let root = &hand.links[0].name;
        assert_eq!(root, if displaced { "base" } else { "palm" });
        assert_eq!(hand.links.len(), plain.links.len() + usize::from(displaced));
        let [note] = &hand.notes[..] else {
            panic!("{:?}", hand.notes)
        };
        assert_says(note, &["slide_x, slide_y, slide_z", root]);
        let bent = [0.3, 0.1, 0.2, 0.9, 1.0, 0.5];
        let offset = if displaced {
            Vector3::z() * 0.3
        } else {
            Vector3::zeros()
        };
        let [ours, theirs] = [&hand, &plain].map(|hand| posed(hand, &bent));
        for link in &plain.links {
            let [ours, theirs] = [(&hand, &ours), (&plain, &theirs)]
                .map(|(hand, posed)| posed.object_from_link[hand.link(&link.name).unwrap().0]);
            assert!(
                (ours.translation - theirs.translation - offset).norm() < 1e-12,
                "{}",
                link.name
            );
            assert!(
                (ours.rotation - theirs.rotation).amax() < 1e-12,
                "{}",
                link.name
            );
        }
    }
}

/// A wrist that turns by less is one, also if the forearm has no geometry.
#[test]
fn a_real_wrist_stays() {
    let real = [
        ("wrist_1", "revolute", "0 1 0", [-0.5, 0.2]),
        ("wrist_2", "revolute", "1 0 0", [-0.7, 0.5]),
    ];
    let hand = urdf(&(wrist(&real, "0 0 0.03") + &body(&THREE))).unwrap();
    assert_eq!(hand.joints.len(), 8);
    assert_eq!(hand.notes, Vec::<String>::new());
    // Behind a virtual wrist it stays as well.
    let both: Vec<_> = WRIST.into_iter().chain(real).collect();
    let hand = urdf(&(wrist(&both, "0 0 0") + &body(&THREE))).unwrap();
    let names: Vec<&str> = hand
        .joints
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    assert_eq!(names[..2], ["wrist_1", "wrist_2"]);
    assert_eq!(hand.joints.len(), 8);
}

/// MJCF of a four-bar linkage in the plane y = 0: crank and rocker on the palm, and a coupler on the crank. `end` is the point
/// of the coupler that is joined to the rocker, and `more` are elements of `<equality>`.
fn four_bar(rocker: [f64; 2], end: [f64; 2], more: &str) -> String {
    let [x, z] = rocker;
    let [end_x, end_z] = end;
    let [top_x, top_z] = [end_x - x, end_z + 0.04 - z];
    format!(
        "<mujoco><compiler angle=\"radian\"/><worldbody><body name=\"palm\"><geom type=\"box\" size=\"0.04 0.03 0.01\" pos=\"0 0 -0.02\"/>\
         <body name=\"crank\"><joint name=\"drive\" axis=\"0 1 0\" range=\"0 0.9\"/>\
         <geom type=\"capsule\" fromto=\"0 0 0 0 0 0.04\" size=\"0.004\"/>\
         <body name=\"coupler\" pos=\"0 0 0.04\"><joint name=\"passive\" axis=\"0 1 0\" range=\"-2 2\"/>\
         <geom type=\"capsule\" fromto=\"0 0 0 {end_x} 0 {end_z}\" size=\"0.004\"/>\
         <site name=\"pin\" pos=\"{end_x} 0 {end_z}\"/></body></body>\
         <body name=\"rocker\" pos=\"{x} 0 {z}\"><joint name=\"back\" axis=\"0 1 0\"/>\
         <geom type=\"capsule\" fromto=\"0 0 0 {top_x} 0 {top_z}\" size=\"0.004\"/>\
         <site name=\"hole\" pos=\"{top_x} 0 {top_z}\"/></body>\
         <body name=\"jaw\" pos=\"-0.03 0 0\"><joint name=\"jaw\" axis=\"0 1 0\" range=\"0 1\"/>\
         <geom type=\"capsule\" fromto=\"0 0 0 0 0 0.05\" size=\"0.006\"/></body>\
         </body></worldbody><equality>{more}</equality></mujoco>"
    )
}

/// The widest opening between the pin on the coupler and the hole in the rocker over the range of the drive, metres.
fn opening_m(hand: &Hand, rocker: [f64; 2], end: [f64; 2]) -> f64 {
    let drive = hand.joint("drive").expect("the linkage has it");
    let mut widest = 0.0f64;
    for step in 0..=50 {
        let [low, high] = hand.joints[drive].limits;
        let mut joints = hand.prior.rest.clone();
        joints[drive] = low + (high - low) * f64::from(step) / 50.0;
        let posed = posed(hand, &joints);
        let at = |link: &str, x: f64, z: f64| {
            posed.object_from_link[hand.link(link).expect("the linkage has it").0]
                .point(&Vector3::new(x, 0.0, z))
        };
        let pin = at("coupler", end[0], end[1]);
        let hole = at("rocker", end[0] - rocker[0], end[1] + 0.04 - rocker[1]);
        widest = widest.max((pin - hole).norm());
    }
    widest
}

const CONNECT: &str = "<connect body1=\"coupler\" body2=\"rocker\" anchor=\"0.03 0 0\"/>";
/// The rocker is as long as the crank, and the coupler as long as the palm between them.
const PARALLEL: [[f64; 2]; 2] = [[0.03, 0.0], [0.03, 0.0]];

#[test]
fn a_linkage_moves_as_one_joint() {
    let [rocker, end] = PARALLEL;
    for more in [
        CONNECT,
        "<connect site1=\"pin\" site2=\"hole\"/>",
        "<connect body1=\"rocker\" body2=\"coupler\" anchor=\"0 0 0.04\"/>",
    ] {
        let hand = described(&four_bar(rocker, end, more), None).unwrap();
        let names: Vec<&str> = hand
            .joints
            .iter()
            .map(|joint| joint.name.as_str())
            .collect();
        assert_eq!(names, ["drive", "jaw"], "{more}");
        assert!(opening_m(&hand, rocker, end) < 1e-6, "{more}");
        let [low, high] = hand.joints[0].limits;
        assert!(
            low.abs() < 1e-9 && (high - 0.9).abs() < 1e-9,
            "the range of the drive is kept"
        );
        let [note] = &hand.notes[..] else {
            panic!("{:?}", hand.notes)
        };
        assert_says(note, &["closes a loop between", "back = 1.000 drive"]);
    }
    // An inactive constraint holds nothing, and one to a body outside the hand is told.
    let off = CONNECT.replace("/>", " active=\"false\"/>");
    let hand = described(&four_bar(rocker, end, &off), None).unwrap();
    assert_eq!((hand.joints.len(), hand.notes.len()), (4, 0));
    let outside = CONNECT.replace("rocker", "table");
    let hand = described(&four_bar(rocker, end, &outside), None).unwrap();
    assert!(
        hand.notes[0].contains("does not belong to the hand"),
        "{:?}",
        hand.notes
    );
    let absurd = CONNECT.replace("0.03 0 0", "1e300 0 0");
    let told = described(&four_bar(rocker, end, &absurd), None)
        .unwrap_err()
        .to_string();
    assert_says(&told, &["a point of <connect>", "is not from -10 to 10 m"]);
    // The palm may be held by the world.
    let hand = described(&four_bar(rocker, end, "<weld body1=\"palm\"/>"), None).unwrap();
    assert_eq!((hand.joints.len(), hand.notes.len()), (4, 0));
}

/// The rocker is much shorter than the crank, so its angle is no line over that of the drive.
#[test]
fn a_loop_that_no_line_closes_is_refused() {
    let (rocker, end) = ([0.03, 0.02], [0.03, 0.002]);
    let more = "<connect body1=\"coupler\" body2=\"rocker\" anchor=\"0.03 0 0.002\"/>";
    let told = described(&four_bar(rocker, end, more), None)
        .unwrap_err()
        .to_string();
    for part in [
        "<connect> (hand, line 1)",
        "\"coupler\" and \"rocker\"",
        " mm. Cut the loop: remove this element",
        "drive, passive, back",
    ] {
        assert!(told.contains(part), "{told}");
    }
    // Its opening is told in millimetres.
    let open: f64 = told
        .split("opens by ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!((1.0..200.0).contains(&open), "{told}");
    // A weld of two moving links is refused as well, and without the links there is no loop.
    let weld = "<weld body1=\"coupler\" body2=\"jaw\"/>";
    let text = four_bar(rocker, end, weld);
    assert!(
        described(&text, None)
            .unwrap_err()
            .to_string()
            .contains("<weld>")
    );
    let hand = described(&text, Some(r#"{"without": ["coupler"]}"#)).unwrap();
    assert_eq!(hand.joints.len(), 3);
}

#[test]
fn confused_units_are_told() {
    let with = |change: &dyn Fn(&mut Digit)| {
        let mut digits = THREE;
        change(&mut digits[0]);
        read(&digits)
    };
    let probably = |hand: &Hand| {
        let told = hand.notes.iter().filter(|note| note.contains("probably"));
        told.cloned().collect::<Vec<_>>().join("\n")
    };
    assert_eq!(read(&THREE).unwrap().notes, Vec::<String>::new());
    // Degrees: 80 rad are 4584°.
    let told = with(&|digit| digit.range = [-80.0, 80.0]).unwrap_err();
    assert!(told.contains("joint \"one_1\": its range is -4584° to 4584°; probably its limits are in degrees; give them"), "{told}");
    assert!(
        with(&|digit| digit.range = [0.0, 120.0])
            .unwrap_err()
            .contains("degrees")
    );
    let told = probably(&with(&|digit| digit.range = [-10.0, 10.0]).unwrap());
    assert_says(
        &told,
        &["joint \"one_2\": its range is -573° to 573°; probably its limits are in degrees"],
    );
    assert_eq!(
        probably(&with(&|digit| digit.range = [-TAU, TAU]).unwrap()),
        ""
    );
    // Radians that are taken for degrees.
    let tiny = THREE.map(|digit| Digit {
        range: [0.0, 1.4f64.to_radians()],
        ..digit
    });
    let told = read(&tiny).unwrap_err();
    assert_says(
        &told,
        &["its range of 1.40° is the widest", "angle=\"radian\""],
    );
    // A tip in millimetres, centimetres, and scaled twice.
    for tip in ["1.6 1.6 4", "0.16 0.16 0.95"] {
        let told = with(&|digit| digit.tip = tip).unwrap_err();
        assert_says(&told, &["link \"one_far\"", "millimetres"]);
    }
    let told = probably(&with(&|digit| digit.tip = "16e-6 16e-6 4e-5").unwrap());
    assert_says(
        &told,
        &["link \"one_far\": its geometry is only 0.040 mm long"],
    );
}

#[test]
fn sizes_and_places_are_told() {
    let told = |body: &str| urdf(body).map(|hand| hand.notes.join("\n"));
    // All lengths a thousand, a hundred and ten times as large or small.
    let scaled = |factor: f64| {
        let mut text = String::new();
        for piece in body(&THREE).split_inclusive('"') {
            let numbers: Option<Vec<f64>> = piece
                .trim_end_matches('"')
                .split(' ')
                .map(|word| word.parse().ok())
                .collect();
            match numbers {
                Some(numbers) if numbers.len() == 3 && numbers.iter().all(|x| x.abs() < 0.5) => {
                    let words: Vec<String> =
                        numbers.iter().map(|x| (factor * x).to_string()).collect();
                    let _ = write!(text, "{}\"", words.join(" "));
                }
                _ => text += piece,
            }
        }
        told(&text)
    };
    assert_eq!(scaled(1.0).unwrap(), "");
    for (factor, refused, cause) in [
        (30.0, true, "millimetres or centimetres"),
        (10.0, false, "millimetres or centimetres"),
        (0.1, false, "scaled twice"),
        (0.01, true, "scaled twice"),
    ] {
        let answer = scaled(factor);
        assert_eq!(answer.is_err(), refused, "{factor}: {answer:?}");
        let text = answer.unwrap_or_else(|told| told);
        assert_says(&text, &["at rest; probably its lengths", cause]);
    }
    // The hand is far from the root.
    let mount = "<link name=\"mount\"/><joint name=\"m\" type=\"fixed\"><parent link=\"mount\"/><child link=\"palm\"/><origin xyz=\"0 0 0.5\"/></joint>";
    let text = told(&(mount.to_owned() + &body(&THREE))).unwrap();
    assert_says(
        &text,
        &["from the origin of its root link \"mount\"", "probably"],
    );
    assert_eq!(
        told(&(mount.replace("0.5", "0.2") + &body(&THREE))).unwrap(),
        ""
    );
    // A long slide.
    let slide = |upper: f64| {
        link("pad", "0.02 0.02 0.02", "0 0 0")
            + &joint(
                "travel",
                "prismatic",
                ["palm", "pad"],
                "0 0.05 0",
                "0 1 0",
                [0.0, upper],
            )
    };
    assert_eq!(told(&(body(&THREE) + &slide(0.03))).unwrap(), "");
    let text = told(&(body(&THREE) + &slide(3.0))).unwrap();
    assert_says(
        &text,
        &["joint \"travel\": it slides by 3.00 m; probably its limits are in millimetres"],
    );
}

/// The thumb turns to the other side than the fingers, but toward them.
#[test]
fn a_finger_that_turns_to_the_other_side_is_told() {
    let finger = |name, base| Digit {
        name,
        base,
        ..THREE[0]
    };
    let row = [
        finger("one", "-0.04 0.03 0.02"),
        finger("two", "-0.04 0 0.02"),
        finger("three", "-0.04 -0.03 0.02"),
    ];
    let against = Digit {
        axis: "0 1 0",
        range: [-1.4, 0.0],
        ..THREE[2]
    };
    let with = |first: Digit| read(&[first, row[1], row[2], against]).unwrap().notes;
    assert_eq!(with(row[0]), Vec::<String>::new());
    let notes = with(Digit {
        range: [-1.4, 0.0],
        ..row[0]
    });
    assert_eq!(notes.len(), 2, "{notes:?}");
    assert_says(
        &notes[0],
        &["joint \"one_1\": its range is -80° to 0°, while the same joints of the other digits"],
    );
    assert!(notes[1].contains("joint \"one_2\""), "{notes:?}");
}

/// Nothing is doubted of the hands of the program and of published ones, and the closed loops of a published gripper become
/// one joint.
#[test]
fn published_hands_are_plausible() {
    for name in HAND_NAMES {
        assert_eq!(
            Hand::named(name).unwrap().notes,
            Vec::<String>::new(),
            "{name}"
        );
    }
    let Some(folder) = crate::published::folder() else {
        crate::skipped::skipped("LANDSCAPE_TEST_DATA is not set");
        return;
    };
    let published = REFERENCES.iter().chain(&DEX_URDF).map(|[file, _]| *file);
    for file in published {
        let hand = HandFiles::load(&folder.join(file))
            .and_then(|files| Hand::from_files(&files))
            .unwrap();
        let doubted = |note: &&String| note.contains("probably") || note.contains("virtual wrist");
        assert_eq!(hand.notes.iter().find(doubted), None, "{file}");
    }
    let path = folder.join("../strangers/hands/2f85.xml");
    let hand = HandFiles::load(&path)
        .and_then(|files| Hand::from_files(&files))
        .unwrap();
    let names: Vec<&str> = hand
        .joints
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    assert_eq!(names, ["left_driver_joint"]);
    let [low, high] = hand.joints[0].limits;
    assert!(low.abs() < 0.03 && high > 0.75, "{low} to {high}");
}
