//! The hand in the page stands as in Rust: frames of links, points of the skin, and the outline.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use landscape::figure::{Camera, Scene};
use landscape::grasp::Grasp;
use landscape::hand::{Hand, HandFiles, PosedHand};
use landscape::sample::{Task, stream};
use landscape::store::HandMetadata;
use landscape::study::Origin;
use nalgebra::Vector3;
use rand::RngExt;
use serde_json::json;

use super::{made, mano, numbers, succeed};
use crate::browser::{act, browser};
use crate::desk::Desk;

const POSES: usize = 20;

/// Hands: with hinges, mimicked and sliding joints, ball joints, and a published one where it is at hand.
fn hands(folder: &Path) -> Vec<HandMetadata> {
    let named = ["human", "gripper_parallel", "gripper_three_finger"];
    let mut hands: Vec<HandMetadata> = named
        .map(|name| HandMetadata::new(name.to_owned(), &HandFiles::named(name).unwrap()).unwrap())
        .into();
    std::fs::write(folder.join("mano.npz"), mano::Model::new().npz()).unwrap();
    let files = HandFiles::load(&folder.join("mano.npz")).unwrap();
    hands.push(HandMetadata::new("mano".to_owned(), &files).unwrap());
    match std::env::var_os("LANDSCAPE_TEST_DATA") {
        Some(data) => {
            let path = Path::new(&data).join("hands/urdf/shadow_hand_right_nomesh.urdf");
            let files = HandFiles::load(&path).unwrap();
            hands.push(HandMetadata::new("shadow".to_owned(), &files).unwrap());
        }
        None => {
            crate::skipped::skipped(
                "LANDSCAPE_TEST_DATA is not set: the Shadow Hand was not posed",
            );
        }
    }
    hands
}

fn poses(hand: &Hand) -> Vec<Vec<f64>> {
    let mut rng = stream(9, Task::Start, 0);
    let mut pose = || {
        let mut x: Vec<f64> = (0..7).map(|_| rng.random_range(-1.0..1.0)).collect();
        let joints = hand.joints.iter().map(|joint| {
            let [low, high] = joint.limits_rad.map(|limit| limit.clamp(-3.0, 3.0));
            rng.random_range(low..=high)
        });
        x.extend(joints);
        x
    };
    (0..POSES).map(|_| pose()).collect()
}

#[test]
fn hands_are_posed_as_in_rust() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    let ball = Origin::named("human", "ball").unwrap().object;
    for metadata in hands(desk.folder.path()) {
        let hand = metadata.build().unwrap();
        let name = metadata.name.clone();
        let origin = Origin {
            hand: metadata,
            object: ball.clone(),
            scale: 1.0,
            given: Vec::new(),
        };
        made::grasp_of(&origin, &desk.path("h.parquet"));
        succeed(&desk, "report h.parquet -q");
        let poses = poses(&hand);
        let script = format!(
            r"const hand = model.header.hands[0];
            const skins = new Float64Array(3 * hand.skin.count.length);
            finish({{ poses: {}.map(x => {{
              const frames = poseLinks(hand, Float64Array.from(x));
              poseSkin(hand, frames, skins);
              return {{ frames: Array.from(frames), skin: Array.from(skins).filter((_, k) => k % 301 < 3) }};
            }}) }});",
            json!(poses)
        );
        let told = act(&browser, &desk, "h.grasps.html", "", &script);
        let skin = if hand.bends() {
            hand.capsule_skin()
        } else {
            hand.skin()
        };
        let mut posed = PosedHand::default();
        for (x, found) in poses.iter().zip(told["poses"].as_array().unwrap()) {
            hand.pose(x, &mut posed);
            let ours: Vec<f64> = (posed.object_from_link.iter())
                .flat_map(|frame| {
                    frame
                        .rotation
                        .transpose()
                        .iter()
                        .chain(frame.translation.iter())
                        .copied()
                        .collect::<Vec<_>>()
                })
                .collect();
            let theirs = numbers(&found["frames"]);
            assert_eq!(ours.len(), theirs.len(), "{name}");
            let gap = ours
                .iter()
                .zip(&theirs)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(gap < 1e-6, "{name}: a frame differs by {gap}");
            let points: Vec<f64> = skin
                .pose(&posed)
                .iter()
                .flat_map(|p| [p.x, p.y, p.z])
                .collect();
            let kept = points.iter().enumerate().filter(|(k, _)| k % 301 < 3);
            let gap = kept
                .zip(numbers(&found["skin"]))
                .map(|((_, a), b)| (a - b).abs())
                .fold(0.0, f64::max);
            // Places are stored in 65,535 steps along the longest side of the hand.
            assert!(gap < 2e-5, "{name}: the skin differs by {gap} m");
        }
    }
}

/// Side of the pictures that are compared, pixels.
const SIDE: u32 = 300;

#[test]
fn a_grasp_has_the_outline_of_the_program_s_own_picture() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    let mut file = made::committed();
    file.grasps.truncate(3);
    file.write(&desk.path("g.parquet")).unwrap();
    succeed(&desk, "report g.parquet -q");
    let population = &file.landscapes()[0];
    let (hand, object) = (population.hand().unwrap(), population.object().unwrap());
    let skin = hand.skin();
    for (item, row) in file.grasps.iter().enumerate() {
        let scene = Scene::of_grasp(
            &hand,
            &skin,
            &object,
            &Grasp::new(row.grasp.pose.clone(), Vec::new()),
        );
        let camera: Camera = scene.framed(Vector3::new(0.6, -0.7, 0.3), Vector3::z());
        let picture = scene.render(&camera, SIDE, SIDE);
        let back = camera.toward_eye();
        let script = format!(
            r"const view = new View(document.createElement('canvas'));
            view.setScene({item});
            view.pose(model.coordinates({item}));
            view.aim(new THREE.Vector3({}, {}, {}), new THREE.Vector3({}, {}, {}), {});
            view.render({SIDE}, {SIDE}, 1);
            const flat = document.createElement('canvas');
            [flat.width, flat.height] = [{SIDE}, {SIDE}];
            const context = flat.getContext('2d');
            context.drawImage(view.canvas, 0, 0);
            const pixels = context.getImageData(0, 0, {SIDE}, {SIDE}).data;
            finish({{ alpha: byteText(pixels.filter((_, k) => k % 4 === 3)) }});",
            camera.target.x,
            camera.target.y,
            camera.target.z,
            back.x,
            back.y,
            back.z,
            camera.half_extent_m
        );
        let told = act(&browser, &desk, "g.grasps.html", "", &script);
        let alpha = STANDARD.decode(told["alpha"].as_str().unwrap()).unwrap();
        let ours = picture
            .rgb
            .chunks_exact(3)
            .map(|rgb| rgb.iter().any(|value| *value < 245));
        let (mut both, mut either) = (0, 0);
        for (ours, theirs) in ours.zip(alpha.iter().map(|alpha| *alpha > 127)) {
            both += usize::from(ours && theirs);
            either += usize::from(ours || theirs);
        }
        let share = both as f64 / either as f64;
        assert!(
            either > 10_000 && share > 0.97,
            "grasp {item}: {share} of {either}"
        );
    }
}
