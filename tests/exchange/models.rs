//! Hands and grasps as models of other simulators.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::{difference, grasps, succeed, with_table};
use crate::described::described;
use crate::desk::{Desk, assert_says};
use landscape::evaluation::stability::SixDirections;
use landscape::grasp::Grasp;
use landscape::grasp::closing::opened;
use landscape::hand::{HAND_NAMES, Hand, HandFiles, PosedHand};
use landscape::mesh::ExactMesh;
use landscape::space::Pose;
use landscape::study::{ExportedFile, MujocoScene, approaches, hand_urdf};

/// Coordinates that do not begin at zero, a joint that follows another, one without end, a slide, a body fixed to another,
/// and names that XML has to escape.
const ODD: &str = r#"<mujoco model="odd &amp; &lt;small&gt;"><compiler angle="radian" autolimits="true"/><worldbody>
<body name="palm"><geom type="box" size="0.03 0.02 0.01"/>
  <body name="first" pos="0.03 0 0.01" euler="0.3 1.5707963 -0.4">
    <joint name="a&quot;b" axis="0 1 0" range="-0.3 1.2" ref="0.4"/><geom type="capsule" fromto="0 0 0 0 0 0.04" size="0.008"/>
    <body name="second" pos="0 0 0.04">
      <joint name="follower" axis="0 1 0" range="-2 2"/><geom type="sphere" size="0.009" pos="0 0 0.02"/>
    </body>
  </body>
  <body name="other" pos="-0.03 0 0.01">
    <joint name="endless" axis="1 0 1"/><geom type="cylinder" size="0.007 0.02" pos="0 0 0.02"/>
    <body name="nail" pos="0 0 0.05" quat="0.8 0 0.6 0"><geom type="capsule" fromto="0 0 0 0 0 -0.02" size="0.004"/></body>
  </body>
  <body name="jaw" pos="0 0.03 0.02"><joint name="slide" type="slide" axis="0 -1 0" range="0 0.02"/>
    <geom type="box" size="0.01 0.004 0.01"/></body>
</body></worldbody>
<equality><joint joint1="follower" joint2="a&quot;b" polycoef="0.1 0.7 0 0 0"/></equality></mujoco>"#;

fn hands() -> Vec<Hand> {
    let named = HAND_NAMES
        .iter()
        .map(|name| HandFiles::named(name).unwrap());
    let named = named.map(|files| Hand::from_files(&files).unwrap());
    named.chain([described(ODD, None).unwrap()]).collect()
}

fn write(folder: &Path, files: &[ExportedFile]) {
    for file in files {
        fs::write(folder.join(&file.name), &file.bytes).unwrap();
    }
}

/// Places of links by name at these coordinates.
fn frames(hand: &Hand, joints: &[f64]) -> BTreeMap<String, landscape::hand::Frame> {
    let mut posed = PosedHand::default();
    hand.pose(&Pose::at_origin(joints), &mut posed);
    let names = hand.links.iter().map(|link| link.name.clone());
    names.zip(posed.object_from_link).collect()
}

#[test]
fn a_hand_comes_back_from_urdf() {
    for hand in hands() {
        let desk = Desk::empty();
        let files = hand_urdf(&hand).unwrap();
        write(&desk.path(""), &files);
        let again =
            Hand::from_files(&HandFiles::load(&desk.path(&files[0].name)).unwrap()).unwrap();
        let told = |hand: &Hand| -> Vec<(String, bool)> {
            let joints = hand.joints.iter();
            joints
                .map(|joint| (joint.name.clone(), joint.wraps))
                .collect()
        };
        assert_eq!(told(&hand), told(&again), "{}", hand.name);
        for (one, two) in hand.joints.iter().zip(&again.joints) {
            for (limit, other) in one.limits_rad.iter().zip(two.limits_rad) {
                assert!((limit - other).abs() < 1e-12, "{}: {}", hand.name, one.name);
            }
        }
        for share in [0.0, 0.3, 0.5, 0.9, 1.0] {
            let limits = hand.joints.iter().map(|joint| joint.limits_rad);
            let joints: Vec<f64> = limits.map(|[a, b]| a + share * (b - a)).collect();
            let (one, two) = (frames(&hand, &joints), frames(&again, &joints));
            assert_eq!(one.len(), two.len());
            for (name, frame) in one {
                let other = &two[&name];
                let off = (frame.translation - other.translation).norm()
                    + (frame.rotation - other.rotation).norm();
                assert!(off < 1e-13, "{} {name}: {off}", hand.name);
            }
        }
    }
}

#[test]
fn dictionaries_of_dexonomy_come_back() {
    let desk = with_table();
    let before = grasps(&desk.path("t.parquet"));
    succeed(&desk, "export t.parquet dexonomy");
    let names: Vec<String> = ["07", "09", "11"].map(|id| format!("{id}.npy")).into();
    for name in &names {
        assert!(desk.path("t.dexonomy").join(name).is_file());
    }
    let line = "--hand gripper_parallel --object ball -q";
    succeed(&desk, &format!("import t.dexonomy {line} -o again.parquet"));
    assert!(difference(&before, &grasps(&desk.path("again.parquet"))) <= 0.0);
    succeed(&desk, "export t.parquet dexonomy --grasp 9 -o nine.npy");
    let one = desk.path("t.dexonomy").join("09.npy");
    assert_eq!(
        fs::read(one).unwrap(),
        fs::read(desk.path("nine.npy")).unwrap()
    );
    assert_says(
        &desk.mistake("export t.parquet dexonomy -o many.npy -q"),
        &["many.npy", "--grasp", "folder"],
    );
}

/// Before closing, the contacts that joints can move are farther from the object; the pressing targets are nearer.
#[test]
fn a_hand_opens_before_it_presses() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/grasps.parquet");
    let file = grasps(&data);
    let population = &file.landscapes()[0];
    let (hand, object) = (population.hand().unwrap(), population.object().unwrap());
    let exact = ExactMesh::new(&object.mesh);
    let distance = |joints: &[f64], grasp: &Grasp| -> f64 {
        let mut posed = PosedHand::default();
        let pose = &grasp.pose;
        let [t, q] = [pose.translation_m().to_vec(), pose.rotation_wxyz().to_vec()];
        hand.pose(&[&t[..], &q, joints].concat(), &mut posed);
        let points = grasp.contacts.iter().map(|&c| posed.points[c as usize]);
        points.map(|point| exact.distance(&point)).sum()
    };
    for row in &population.grasps[..5] {
        let grasp = &row.grasp;
        let before = opened(&hand, &exact, grasp, 0.01);
        let moved = grasp.pose.joints().iter().zip(&before);
        for (joint, (from, to)) in hand.joints.iter().zip(moved) {
            let [lower, upper] = joint.limits_rad;
            assert!((lower.min(*from)..=upper.max(*from)).contains(to));
        }
        let squeezed =
            &approaches(&hand, &object.mesh, &[grasp], &SixDirections::default())[0].squeezed;
        let at = distance(grasp.pose.joints(), grasp);
        assert!(distance(&before, grasp) > at, "{before:?}");
        assert!(distance(squeezed, grasp) < at, "{squeezed:?}");
    }
}

#[test]
fn a_scene_has_a_keyframe_for_each_grasp() {
    let desk = with_table();
    let file = grasps(&desk.path("t.parquet"));
    let population = &file.landscapes()[0];
    let (hand, object) = (population.hand().unwrap(), population.object().unwrap());
    let rows = file.grasps.iter();
    let scene = MujocoScene {
        hand: &hand,
        object: "ball",
        mesh: &object.mesh,
        mass_kg: 0.06,
        six: SixDirections::default(),
        grasps: rows.map(|row| (row.id, &row.grasp)).collect(),
    };
    let files = scene.files(&|_| ()).unwrap();
    assert_eq!(files, scene.files(&|_| ()).unwrap());
    let text = String::from_utf8(files[0].bytes.clone()).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let all = |name: &str| -> Vec<roxmltree::Node<'_, '_>> {
        let nodes = document.descendants();
        nodes.filter(|node| node.has_tag_name(name)).collect()
    };
    let count = |text: &str| text.split(' ').count();
    assert_eq!(all("key").len(), 3);
    for key in all("key") {
        // Both jaws, of which one follows the other, and the object.
        assert_eq!(count(key.attribute("qpos").unwrap()), 2 + 7);
        assert_eq!(count(key.attribute("ctrl").unwrap()), 1);
    }
    for mesh in all("mesh").iter().filter_map(|mesh| mesh.attribute("file")) {
        assert!(files.iter().any(|file| file.name == mesh), "{mesh}");
    }
    succeed(&desk, "export t.parquet mujoco");
    for file in &files {
        assert!(desk.path("t.mujoco").join(&file.name).is_file());
    }
}

/// A scene and a file of Isaac hold one hand and one object.
#[test]
fn several_objects_need_a_choice() {
    let desk = with_table();
    let two = super::TABLE.replace("\n9,1,", "\n9,1.25,");
    fs::write(desk.path("two.csv"), two).unwrap();
    succeed(
        &desk,
        "import two.csv --hand gripper_parallel --object ball -o two.parquet",
    );
    for format in ["mujoco", "isaac_grasp"] {
        let sentence = desk.mistake(&format!("export two.parquet {format} -q"));
        assert_says(&sentence, &["one object", "of scale 1.25", "--grasp"]);
        succeed(&desk, &format!("export two.parquet {format} --grasp 9"));
    }
    assert_says(
        &desk.mistake("export two.parquet isaac_grasp -o grasps.txt"),
        &["grasps.txt", ".yaml"],
    );
    for format in ["usd", "dexonomy", "urdf"] {
        succeed(&desk, &format!("export two.parquet {format}"));
    }
    let text = fs::read_to_string(desk.path("two.isaac_grasp.yaml")).unwrap();
    for line in [
        "format: isaac_grasp\n",
        "format_version: 1.0\n",
        // The keys of Isaac Sim and those of Isaac ROS.
        "object_frame_link: \"ball\"\ngripper_frame_link: \"palm\"\n",
        "object_frame: \"ball\"\ngripper_frame: \"palm\"\n",
        "  \"grasp_9\":\n    confidence: 1.0\n    position: [-0.08, 0.011, 0.05]\n    orientation: {w: 0.6, xyz: [0.0, 0.8, 0.0]}\n",
        "    cspace_position:\n      \"jaw\": 0.0301234567890123\n    pregrasp_cspace_position:\n",
    ] {
        assert!(text.contains(line), "{text}");
    }
}
