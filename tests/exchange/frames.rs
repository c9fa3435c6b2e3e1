//! Frames of the hand and the object in the files of `DexGraspBench`, `BODex` and Dexonomy.

use std::fs;

use super::difference;
use crate::desk::{Desk, assert_says};
use crate::pickled::{QPOS, Value, bodex, nested, npy_of};
use landscape::hand::{Hand, HandFiles, PosedHand};
use landscape::store::exchange::{self, Mapping};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// A hand with one joint, whose palm stands so in the world of its file.
fn hand_with_palm(pos: &str, quat: &str) -> String {
    format!(
        r#"<mujoco><compiler angle="radian"/><worldbody>
<body name="palm" pos="{pos}" quat="{quat}"><geom type="box" size="0.03 0.01 0.03"/>
<body name="thumb" pos="-0.02 0 0.03"><geom type="capsule" fromto="0 0 0 0 0 0.05" size="0.008"/></body>
<body name="finger" pos="0.02 0 0.03"><joint name="jaw" axis="0 1 0" range="-1 1"/>
<geom type="capsule" fromto="0 0 0 0 0 0.05" size="0.008"/></body></body></worldbody></mujoco>"#
    )
}

const TURNED: f64 = std::f64::consts::FRAC_1_SQRT_2;

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() < 1e-9, "{found:?} is not {expected:?}");
    }
}

#[test]
fn poses_are_those_of_the_world_of_the_hand_file() {
    let desk = Desk::empty();
    desk.write("hand.xml", hand_with_palm("0.01 0 0.034", "0.8 0 0.6 0"));
    let squeezed = [0.01, 0.02, -0.1, 0.5, 0.5, -0.5, 0.5, 0.375];
    let file = npy_of(&Value::Dictionary(&[
        ("grasp_qpos", Value::Array(&[8], &QPOS)),
        ("squeeze_qpos", Value::Array(&[8], &squeezed)),
        (
            "obj_pose",
            Value::Array(&[7], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        ),
        ("obj_scale", Value::Array(&[1], &[1.0])),
        ("joint_names", Value::Texts(&["jaw"])),
    ]));
    desk.write("a.npy", file);
    let of = "--hand hand.xml --object ball -q";
    desk.said(&format!("import a.npy {of} -o a.parquet"));
    let imported = desk.grasps("a.parquet");
    let pose = &imported.grasps[0].grasp.pose;
    assert_near(pose, &QPOS);
    assert_eq!(imported.grasps[0].squeeze_joints, Some(vec![0.375]));
    // The palm is where its place in the world puts it.
    let hand = Hand::from_files(&HandFiles::load(&desk.path("hand.xml")).unwrap()).unwrap();
    let palm = hand.links.iter().position(|link| link.name == "palm");
    let mut posed = PosedHand::default();
    hand.pose(pose, &mut posed);
    let quaternion = UnitQuaternion::from_quaternion(Quaternion::new(0.5, 0.5, -0.5, 0.5));
    let expected = quaternion * Vector3::new(0.01, 0.0, 0.034) + Vector3::new(0.01, 0.02, -0.1);
    let found = posed.object_from_link[palm.unwrap()].translation;
    assert_near(found.as_slice(), expected.as_slice());
    // Out and in again, by both formats of such poses.
    desk.said("export a.parquet dexonomy -o back");
    desk.said(&format!("import back {of} -o b.parquet"));
    let back = desk.grasps("b.parquet");
    assert!(difference(&imported, &back) < 1e-12);
    // As published, not those of the test of six directions.
    assert_eq!(back.grasps[0].squeeze_joints, Some(vec![0.375]));
    desk.said("export a.parquet qpos -o q.npy");
    desk.said(&format!("import q.npy {of} -o c.parquet"));
    let rows = desk.grasps("c.parquet");
    assert!(difference(&imported, &rows) < 1e-12);
    assert_eq!(rows.grasps[0].squeeze_joints, None);
}

/// The corrections with which `DexGraspBench` converts poses of `BODex` of the Shadow, Allegro and LEAP hands.
#[test]
fn poses_of_bodex_are_those_of_the_outermost_body() {
    let turn =
        |[w, x, y, z]: [f64; 4]| UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let given = turn([0.5, 0.5, -0.5, 0.5]);
    let at = Vector3::new(0.01, 0.02, -0.1);
    let allegro = turn([0.0, 1.0, 0.0, 1.0]);
    let leap = turn([0.0, 1.0, 0.0, 0.0]);
    let leap_turned = given * leap.inverse();
    for (pos, quat, position, rotation) in [
        (
            "0 0 0.034",
            "1 0 0 0",
            at - given * Vector3::new(0.0, 0.0, 0.034),
            given,
        ),
        ("0 0 0", "0 1 0 1", at, given * allegro.inverse()),
        (
            "0 0 0.1",
            "0 1 0 0",
            at - leap_turned * Vector3::new(0.0, 0.0, 0.1),
            leap_turned,
        ),
    ] {
        let desk = Desk::empty();
        desk.write("hand.xml", hand_with_palm(pos, quat));
        desk.write("a.npy", bodex());
        let said = desk.said("import a.npy --hand hand.xml --object ball -o a.parquet");
        assert_says(&said, &["BODex", "0.5"]);
        let grasp = &desk.grasps("a.parquet").grasps[0];
        let pose = &grasp.grasp.pose;
        assert_near(pose.translation_m(), position.as_slice());
        let turned = turn(pose.rotation_wxyz());
        assert!(turned.angle_to(&rotation) < 1e-9, "{pos} {quat}: {pose:?}");
        assert_near(pose.joints(), &[0.25]);
        // The third of the three poses.
        assert_eq!(grasp.squeeze_joints, Some(vec![0.0]));
    }
}

/// A pose of a link of a finger, planted by the forward kinematics, becomes that of the root.
#[test]
fn a_mapping_names_the_link_of_the_poses() {
    let desk = Desk::empty();
    desk.write("hand.xml", hand_with_palm("0.01 0 0.034", "0.8 0 0.6 0"));
    let hand = Hand::from_files(&HandFiles::load(&desk.path("hand.xml")).unwrap()).unwrap();
    let mut posed = PosedHand::default();
    hand.pose(&QPOS, &mut posed);
    let finger = posed.object_from_link[hand.link("finger").unwrap().0];
    let turn = UnitQuaternion::from_matrix(&finger.rotation);
    let planted = [
        finger.translation.as_slice(),
        &[turn.i, turn.j, turn.k, turn.w, QPOS[7]],
    ]
    .concat();
    let file = npy_of(&Value::Dictionary(&[
        ("grasp_qpos", Value::Array(&[8], &planted)),
        ("joint_names", Value::Texts(&["jaw"])),
    ]));
    desk.write("a.npy", file);
    let import = "import a.npy --hand hand.xml --object ball --mapping m.toml -q";
    desk.write("m.toml", "link = \"finger\"\nrotation_form = \"xyzw\"");
    desk.said(&format!("{import} -o a.parquet"));
    let pose = &desk.grasps("a.parquet").grasps[0].grasp.pose;
    let dot: f64 = (3..7).map(|k| pose[k] * QPOS[k]).sum();
    assert_near(pose.translation_m(), &QPOS[..3]);
    assert!((dot.abs() - 1.0).abs() < 1e-12, "{pose:?}");
    desk.write("m.toml", "link = \"thum\"");
    assert_says(
        &desk.mistake(&format!("{import} -o b.parquet")),
        &["link `thum`", "it has world, palm, thumb, finger"],
    );
}

#[test]
fn nested_scenes_are_read_as_flat_files() {
    let joints = ["jaw".to_owned()];
    let desk = Desk::empty();
    let pose_of_object = [0.2, 0.1, 0.05, TURNED, TURNED, 0.0, 0.0];
    let object_pose = || Value::Array(&[7], &pose_of_object);
    let read = |name: &str, entries: &[(&str, Value<'_>)]| {
        let path = desk.path(name);
        fs::write(&path, npy_of(&Value::Dictionary(entries))).unwrap();
        exchange::read(&path, &joints, &Mapping::default())
    };
    let qpos = || ("grasp_qpos", Value::Array(&[1, 8], &QPOS));
    let flat = read(
        "flat.npy",
        &[
            qpos(),
            ("obj_pose", object_pose()),
            ("obj_scale", Value::Array(&[1], &[0.5])),
        ],
    )
    .unwrap();
    assert!((flat.grasps[0].pose[0] - QPOS[0]).abs() > 0.1);
    let mug = [
        ("type", Value::Text("rigid_object")),
        ("scale", Value::Array(&[3], &[0.5, 0.5, 0.5])),
        ("pose", object_pose()),
    ];
    let objects = [
        (
            "table",
            Value::Dictionary(&[("type", Value::Text("plane"))]),
        ),
        ("mug", Value::Dictionary(&mug)),
    ];
    let named = [("obj_name", Value::Text("mug"))];
    // The task names the object, the scene does, or it has only one.
    let scenes: [&[(&str, Value<'_>)]; 3] = [
        &[
            ("scene", Value::Dictionary(&objects)),
            ("task", Value::Dictionary(&named)),
        ],
        &[
            ("scene", Value::Dictionary(&objects)),
            ("interest_obj_name", Value::Text("mug")),
        ],
        &[("scene", Value::Dictionary(&objects))],
    ];
    for (place, scene) in scenes.into_iter().enumerate() {
        let nested = [qpos(), ("scene_cfg", Value::Dictionary(scene))];
        let nested = read("nested.npy", &nested).unwrap();
        assert_eq!(nested.grasps[0].pose, flat.grasps[0].pose, "{place}");
        assert_eq!(nested.grasps[0].scale, Some(0.5));
        assert_eq!(nested.grasps[0].object.as_deref(), Some("mug"));
        // A scene of its own, beside the grasps or above, whose objects are scaled for each grasp.
        let file = npy_of(&Value::Dictionary(scene));
        fs::create_dir_all(desk.path("scenes")).unwrap();
        desk.write("scenes/a.npy", file);
        fs::create_dir_all(desk.path("grasps/mug")).unwrap();
        let qpos = [QPOS, QPOS].concat();
        let apart = read(
            "grasps/mug/0.npy",
            &[
                ("grasp_qpos", Value::Array(&[2, 8], &qpos)),
                ("scene_path", Value::Text("scenes/a.npy")),
                ("scene_scale", Value::Array(&[2], &[1.0, 0.2])),
            ],
        )
        .unwrap();
        assert_eq!(apart.grasps[1].pose, flat.grasps[0].pose, "{place}");
        assert_eq!(apart.grasps[0].scale, Some(0.5));
        assert_eq!(apart.grasps[1].scale, Some(0.1));
        assert!(apart.notes.iter().all(|note| !note.contains("scene")));
    }
    let path = desk.path("scaled.npy");
    fs::write(&path, nested()).unwrap();
    let scaled = exchange::read(&path, &joints, &Mapping::default()).unwrap();
    assert_eq!(scaled.grasps[0].scale, Some(1.0));
    assert_near(&scaled.grasps[0].pose, &QPOS);
    // What is missing is told.
    let absent = [qpos(), ("scene_path", Value::Text("scenes/b.npy"))];
    let absent = read("absent.npy", &absent).unwrap();
    assert_says(&absent.notes[0], &["scenes/b.npy", "is missing", "--scale"]);
    let cup = [("obj_name", Value::Text("cup"))];
    let wrong: &[(&str, Value<'_>)] = &[
        ("scene", Value::Dictionary(&objects)),
        ("task", Value::Dictionary(&cup)),
    ];
    let wrong = read(
        "wrong.npy",
        &[qpos(), ("scene_cfg", Value::Dictionary(wrong))],
    );
    assert_says(
        &wrong.unwrap_err().to_string(),
        &["wrong.npy", "`scene_cfg` has no object `cup`"],
    );
}
