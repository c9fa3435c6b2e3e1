//! `landscape hands`: built-in hands, and quantities derived from other hands.

use std::cmp::Reverse;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Subcommand, ValueHint};
use nalgebra::Vector3;
use serde_json::{Value, json};

use super::args::Common;
use super::input;
use super::output::{check_picture, check_side_file, source_of};
use crate::cli::printing::{complain, tell, tell_written};
use crate::figure::{Image, Marker, Scene, Surface, contact_sheet_canvas};
use crate::hand::{Ball, HAND_NAMES, Hand, JointKind, LinkId, PosedHand, Skin};
use crate::space::joints_of_mut;
use crate::store::FileSet;

/// Hands.
#[derive(Debug, Args)]
pub(super) struct Hands {
    #[command(subcommand)]
    pub(super) command: HandsCommand,
}

#[derive(Debug, Subcommand)]
pub(super) enum HandsCommand {
    /// List the built-in hands
    List,
    /// Show the derived properties of a hand (table, picture), or write a side file in which they can be changed
    #[command(after_help = EXAMPLES)]
    Inspect(HandsInspect),
    /// Say which of the 33 grasp types a hand can do on some objects, and whether they hold (table, picture)
    #[command(after_help = super::hands_can::EXAMPLES)]
    Can(super::hands_can::HandsCan),
}

/// Derived properties of a hand.
#[derive(Debug, Args)]
pub(super) struct HandsInspect {
    /// The hand: the name of a built-in hand, or a URDF, MJCF or MANO (.npz) file.
    #[arg(value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    hand: String,
    /// The folder with all files that the hand's description refers to (meshes, included files); by default its own folder.
    /// Files elsewhere are refused.
    #[arg(long, value_name = "FOLDER")]
    hand_folder: Option<PathBuf>,
    /// Use its mirror image instead.
    #[arg(long)]
    mirror: bool,
    /// The picture to write, with or without .png; by default the name of the hand, in the current folder.
    #[arg(long, short, value_name = "NAME")]
    output: Option<PathBuf>,
    /// Write a side file (.json) that states all that is derived. A side file beside the description, with the same name, is
    /// read with it: what it states is not derived any more.
    #[arg(long, value_name = "FILE")]
    side_file: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  landscape hands inspect my_hand.xml                      a table, and my_hand.png
  landscape hands inspect my_hand.xml --side-file my_hand.json
                                                           also write what was derived; beside my_hand.xml it is read in
                                                           place of that, so delete what you leave as it is
  landscape synth --hand my_hand.xml --object mug          grasps of that hand
  landscape synth --hand my_hand.xml --mirror --object mug
                                                           grasps of its mirror image";

/// Side of each image, pixels.
const SIDE: u32 = 420;
/// Radius of the mark at a surface point, metres.
const POINT_M: f64 = 1.2e-3;
/// Colours of palm and digits, with their names in the report.
const COLOURS: [(&str, [u8; 3]); 6] = [
    ("grey", [120, 128, 140]),
    ("orange", [213, 80, 40]),
    ("blue", [40, 120, 190]),
    ("green", [60, 150, 80]),
    ("violet", [150, 90, 170]),
    ("ochre", [200, 150, 30]),
];

pub(super) fn run(command: &HandsCommand, common: &Common) -> anyhow::Result<()> {
    match command {
        HandsCommand::List => list(common),
        HandsCommand::Inspect(command) => inspect(command, common),
        HandsCommand::Can(command) => super::hands_can::run(command, common),
    }
}

fn list(common: &Common) -> anyhow::Result<()> {
    let entry = |name: &&str| {
        let hand = Hand::named(name)?;
        Ok(json!({
            "name": name,
            "joints": hand.joints.len(),
            "points": hand.surface.len(),
            "capsules": hand.capsules.len(),
            "digits": hand.digits[1..],
        }))
    };
    let hands = HAND_NAMES.iter().map(entry);
    tell(
        common,
        &json!({ "hands": hands.collect::<anyhow::Result<Vec<Value>>>()? }),
    )
}

fn inspect(command: &HandsInspect, common: &Common) -> anyhow::Result<()> {
    let files = input::hand_files(
        &command.hand,
        command.hand_folder.as_deref(),
        command.mirror,
    )?;
    let picture = picture_named(command.output.as_deref(), &command.hand);
    let source = source_of(&command.hand, &HAND_NAMES, &picture);
    check_picture(&picture, &command.hand, &source, common.force)?;
    if let Some(side_file) = &command.side_file {
        check_side_file(side_file, common.force)?;
    }
    let beside = Path::new(&command.hand).with_extension("json");
    if !common.quiet && !HAND_NAMES.contains(&command.hand.as_str()) && beside.is_file() {
        complain(&format!(
            "{} is read with it: what it states is not derived",
            beside.display()
        ));
    }
    let hand = Hand::from_files(&files)?;
    let sheet = sheet(&hand);
    let (images, captions): (Vec<Image>, Vec<String>) = sheet.into_iter().unzip();
    let sheet = contact_sheet_canvas(&images, &captions, 3).made_of(source);
    let sheet = sheet.encode(&picture);
    let sheet = sheet.with_context(|| format!("--output {}", picture.display()))?;
    let mut outputs = FileSet::default();
    outputs.add(&picture, &sheet)?;
    let mut wrote = vec![picture.as_path()];
    if let Some(side_file) = &command.side_file {
        outputs.add(side_file, files.side_file_of(&hand)?.as_bytes())?;
        wrote.push(side_file);
    }
    outputs.finish()?;
    let written: Vec<String> = wrote
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    tell_written(common, &value(&hand, &wrote), &written.join(" and "))
}

/// The picture to write: the given name, or that of the input, with the ending .png.
pub(super) fn picture_named(output: Option<&Path>, input: &str) -> PathBuf {
    if let Some(output) = output.filter(|path| path.extension().is_some_and(|end| end == "png")) {
        return output.to_owned();
    }
    let stem = || Path::new(input).file_stem().unwrap_or_default();
    let mut name = output.map_or_else(stem, Path::as_os_str).to_owned();
    name.push(".png");
    name.into()
}

/// The report: derived quantities, in metres and radians.
fn value(hand: &Hand, wrote: &[&Path]) -> Value {
    let links: Vec<Value> = (hand.links.iter().enumerate())
        .map(|(number, link)| {
            let part = if hand.is_arm(LinkId(number)) {
                "arm"
            } else {
                hand.digits[link.digit].as_str()
            };
            let points = hand.surface.iter().filter(|at| at.link.0 == number);
            json!({
                "name": link.name,
                "part": part,
                "colour": if part == "arm" { None } else { Some(COLOURS[link.digit % COLOURS.len()].0) },
                "points": points.clone().count(),
                // An empty sum is −0.
                "area_m2": points.map(|at| at.area_m2).sum::<f64>() + 0.0,
                "capsules": hand.capsules.iter().filter(|capsule| capsule.link.0 == number).count(),
            })
        })
        .collect();
    let metric = hand.pose_metric();
    let joints: Vec<Value> = (hand.joints.iter().enumerate())
        .map(|(number, joint)| {
            json!({
                "name": joint.name,
                "kind": match joint.kind {
                    JointKind::Hinge => "hinge",
                    JointKind::Slide => "slide",
                },
                "endless": joint.wraps,
                "limits": joint.limits,
                "rest": hand.prior.rest[number],
                "deviation": hand.prior.deviations[number],
                "lever_m": metric.joint_levers_m[number],
                "followers": followers(hand, number),
            })
        })
        .collect();
    let palm = &hand.palm;
    json!({
        "name": hand.name,
        "links": links,
        "joints": joints,
        "palm": {
            "centre_m": palm.centre.as_slice(),
            "faces": palm.volar.as_slice(),
            "fingers": palm.distal.as_slice(),
            "faced_m": palm.faced_m,
        },
        "self_pairs": hand.self_pairs.len(),
        "notes": hand.notes.iter().cloned().chain(expense(hand, hand.balls())).collect::<Vec<_>>(),
        "wrote": wrote,
    })
}

/// Number of balls in the meshes of a hand above which it is called slow: more than built-in hands have.
const MANY_BALLS: usize = 4_200;
/// Number of capsule pairs above which a hand is called slow, ten times that of built-in and usual hands.
const MANY_PAIRS: usize = 10_000;

/// Notes about a slow hand, with remedies. `balls` are those of its elastic layer, if the energy has one.
pub(super) fn expense(hand: &Hand, balls: &[Ball]) -> Vec<String> {
    let most = |links: &[LinkId]| {
        let of_link = |link: usize| links.iter().filter(|of| of.0 == link).count();
        let most = (0..hand.links.len()).max_by_key(|&link| (of_link(link), Reverse(link)));
        most.map_or((0, ""), |link| {
            (of_link(link), hand.links[link].name.as_str())
        })
    };
    let mut notes = Vec::new();
    if balls.len() > MANY_BALLS {
        let (count, link) = most(&balls.iter().map(|ball| ball.link).collect::<Vec<_>>());
        notes.push(format!(
            "chains of this hand are slow: {} balls fill its meshes, and every step measures those near the object; {count} \
             of the balls are in link \"{link}\" alone; plainer collision meshes, without ribs, screws and holes, need fewer",
            balls.len(),
        ));
    }
    let pairs = hand.self_pairs.len();
    if pairs > MANY_PAIRS {
        let (count, link) = most(&hand.capsules.iter().map(|c| c.link).collect::<Vec<_>>());
        notes.push(format!(
            "chains of this hand are slow: its {} capsules make {pairs} pairs that every step checks for self-penetration; \
             {count} of the capsules belong to link \"{link}\" alone; thin boxes need many: give such links fewer \
             (`capsules` or `filling` of a side file, which `landscape hands inspect` writes), or name links that never \
             touch each other (`apart`)",
            hand.capsules.len(),
        ));
    }
    notes
}

/// The links that a joint moves besides its own, and how.
fn followers(hand: &Hand, joint: usize) -> Vec<Value> {
    let own = hand.joints[joint].link.0;
    let others = hand
        .links
        .iter()
        .enumerate()
        .filter(|(number, _)| *number != own);
    let moved = others.filter_map(|(_, link)| {
        let motion = link
            .motion
            .as_ref()
            .filter(|motion| motion.joint == joint)?;
        Some(json!({ "link": link.name, "ratio": motion.ratio, "offset": motion.offset }))
    });
    moved.collect()
}

/// The coordinates of the hand with all joints at a share of their ranges.
fn at(hand: &Hand, share: f64) -> Vec<f64> {
    let mut x = hand.rest_coordinates();
    for (q, joint) in joints_of_mut(&mut x).iter_mut().zip(&hand.joints) {
        let [lower, upper] = joint.limits;
        *q = lower + share * (upper - lower);
    }
    x
}

/// The hand at `x`, covered with `skin`.
fn scene(hand: &Hand, skin: &Skin, x: &[f64]) -> Scene {
    let mut posed = PosedHand::default();
    hand.pose(x, &mut posed);
    Scene {
        surfaces: vec![Surface::of_hand(skin, &posed)],
        markers: Vec::new(),
        cones: Vec::new(),
    }
}

/// Its surface points at `x`, coloured by digit.
fn surface_points(hand: &Hand, x: &[f64]) -> Vec<Marker> {
    let mut posed = PosedHand::default();
    hand.pose(x, &mut posed);
    let points = hand.surface.iter().zip(&posed.points);
    points
        .map(|(at, p)| Marker {
            centre: *p,
            radius_m: POINT_M,
            colour: COLOURS[hand.links[at.link.0].digit % COLOURS.len()].1,
        })
        .collect()
}

/// The pictures of the hand and their captions.
fn sheet(hand: &Hand) -> Vec<(Image, String)> {
    let skin = hand.skin();
    let rest = hand.rest_coordinates();
    let with_points = Scene {
        markers: surface_points(hand, &rest),
        ..scene(hand, &skin, &rest)
    };
    let mut capsules = scene(hand, &hand.capsule_skin(), &rest);
    capsules.surfaces[0].colour = [170, 184, 200];
    let palm = &hand.palm;
    let side = palm.volar.cross(&palm.distal);
    // Slightly from the side, since a gripper's fingers would hide each other from the palm's direction.
    let front = palm.volar + 0.25 * side + 0.15 * palm.distal;
    let draw = |scene: Scene, from: Vector3<f64>, caption: &str| {
        let image = scene.render(&scene.framed(from, palm.distal), SIDE, SIDE);
        (image, caption.to_owned())
    };
    let skinned = |x: &[f64]| scene(hand, &skin, x);
    vec![
        draw(skinned(&rest), front, "at rest, from what the palm faces"),
        draw(skinned(&rest), side, "at rest, from the side"),
        draw(with_points, front, "points by part (colours in table)"),
        draw(capsules, front, "inner capsules, for collisions"),
        draw(
            skinned(&at(hand, 0.0)),
            side,
            "all joints at their lower limits",
        ),
        draw(
            skinned(&at(hand, 1.0)),
            side,
            "all joints at their upper limits",
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::HandFiles;

    #[test]
    fn joints_name_their_followers() {
        let hand = Hand::named("gripper_parallel").unwrap();
        let report = value(&hand, &[]);
        let follower = &report["joints"][0]["followers"][0];
        assert_eq!(
            (&follower["link"], &follower["ratio"]),
            (&json!("jaw_2"), &json!(1.0))
        );
    }

    /// Three plates of two millimetres on hinges, thin boxes as in slow hands.
    #[test]
    fn a_hand_of_thin_boxes_is_called_expensive() {
        let plate = |name: &str, y: f64| {
            format!(
                "<link name=\"{name}\"><collision><origin xyz=\"0 {y} 0\"/><geometry><box size=\"0.1 0.09 0.002\"/></geometry>\
                 </collision></link>"
            )
        };
        let hinge = |name: &str, x: f64| {
            format!(
                "<joint name=\"{name}_hinge\" type=\"revolute\"><parent link=\"palm\"/><child link=\"{name}\"/>\
                 <origin xyz=\"{x} 0.01 0\"/><axis xyz=\"1 0 0\"/>\
                 <limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>"
            )
        };
        let names = ["one", "two", "three"];
        let mut text = format!("<robot name=\"plates\">{}", plate("palm", -0.05));
        for (name, x) in names.into_iter().zip([-0.15, 0.0, 0.15]) {
            text += &plate(name, 0.05);
            text += &hinge(name, x);
        }
        text += "</robot>";
        let hand = Hand::from_files(&HandFiles::of_texts([["hand", &text]])).unwrap();
        let notes = expense(&hand, hand.balls());
        let balls = format!("{} balls", hand.balls().len());
        assert!(notes[0].contains(&balls), "{notes:?}");
        let without_layer = expense(&hand, &[]);
        assert_eq!(notes[1..], without_layer);
        let note = &without_layer[0];
        let pairs = format!("{} pairs", hand.self_pairs.len());
        assert!(
            note.contains(&pairs) && note.contains("link \"palm\" alone"),
            "{note}"
        );
        let told = value(&hand, &[]);
        assert!(told["notes"].as_array().unwrap().contains(&json!(note)));
        for name in HAND_NAMES {
            let hand = Hand::named(name).unwrap();
            assert!(expense(&hand, hand.balls()).is_empty(), "{name}");
        }
    }
}
