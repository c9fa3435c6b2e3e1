//! Files of torch: graspqp, `MultiDex` and DRO-Grasp.

use std::fs;

use crate::desk::Desk;
use crate::pickled::{Tensors, torch_of};
use landscape::store::exchange::{HandJoints, Mapping, Read, read};

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() < 1e-6, "{found:?} is not {expected:?}");
    }
}

fn read_as(content: &Tensors<'_>, joints: &[&str], mapping: &Mapping) -> Result<Read, String> {
    let desk = Desk::empty();
    let path = desk.path("g.pt");
    fs::write(&path, torch_of(content)).unwrap();
    let names: Vec<String> = joints.iter().map(ToString::to_string).collect();
    read(&path, &names, mapping).map_err(|error| error.to_string())
}

/// A quarter turn about z and about x.
const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

#[test]
fn graspqp_has_a_tensor_for_each_joint() {
    let content = Tensors::Parameters(&[
        ("b", &[2], &[0.5, 0.25]),
        ("a", &[2], &[-0.5, 1.0]),
        (
            "root_pose",
            &[2, 7],
            &[
                0.1, 0.2, 0.3, 0.0, 0.0, HALF, HALF, //
                0.0, 0.0, -0.1, 1.0, 0.0, 0.0, 0.0,
            ],
        ),
    ]);
    let found = read_as(&content, &["a", "b"], &Mapping::default()).unwrap();
    assert_eq!(found.format, "graspqp");
    let half = f64::from(HALF);
    near(
        &found.grasps[0].pose,
        &[0.1, 0.2, 0.3, half, 0.0, 0.0, half, -0.5, 0.5],
    );
    near(
        &found.grasps[1].pose,
        &[0.0, 0.0, -0.1, 0.0, 1.0, 0.0, 0.0, 1.0, 0.25],
    );
    let wrong = read_as(&content, &["a", "c"], &Mapping::default()).unwrap_err();
    assert!(wrong.contains("not in the file: c"), "{wrong}");
}

#[test]
fn q_is_read_by_its_length() {
    // Position, then x → y and y → −x, then the joints.
    let columns = [0.1, 0.2, 0.3, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.5, 0.25];
    let content = Tensors::Metadata(&[(&columns, "contactdb+apple", "allegro")]);
    let found = read_as(&content, &["a", "b"], &Mapping::default()).unwrap();
    let half = f64::from(HALF);
    near(
        &found.grasps[0].pose,
        &[0.1, 0.2, 0.3, half, 0.0, 0.0, half, 0.5, 0.25],
    );
    assert_eq!(
        (found.format, found.grasps[0].object.as_deref()),
        ("MultiDex", Some("contactdb+apple"))
    );
    assert!(
        found
            .notes
            .iter()
            .any(|note| note.contains("hand's order, a, b"))
    );
    // A quarter turn about x, then one about the z that has turned: R = Rx Rz.
    let quarter = std::f32::consts::FRAC_PI_2;
    let angles = [0.1, 0.2, 0.3, quarter, 0.0, quarter, 0.5, 0.25];
    let content = Tensors::Metadata(&[(&angles, "contactdb+apple", "allegro")]);
    let found = read_as(&content, &["a", "b"], &Mapping::default()).unwrap();
    assert_eq!(found.format, "DRO-Grasp");
    near(
        &found.grasps[0].pose,
        &[0.1, 0.2, 0.3, 0.5, 0.5, -0.5, 0.5, 0.5, 0.25],
    );
    let wrong = read_as(&content, &["a"], &Mapping::default()).unwrap_err();
    assert!(
        wrong.contains("8 numbers") && wrong.contains("`joint_names`"),
        "{wrong}"
    );
    let content =
        Tensors::Metadata(&[(&angles, "apple", "allegro"), (&angles, "apple", "barrett")]);
    let wrong = read_as(&content, &["a", "b"], &Mapping::default()).unwrap_err();
    assert!(wrong.contains("2 robots (allegro, barrett)"), "{wrong}");
}

/// The files of `MultiDex` have the joints of Shadow's hand in an order of their own.
#[test]
fn the_joints_of_shadows_hand_are_named() {
    let mut q: Vec<f32> = vec![0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    q.extend((0..24_u8).map(f32::from));
    let content = Tensors::Metadata(&[(&q, "apple", "shadowhand")]);
    // As in MuJoCo's file: FFJ4 … FFJ1, thumb last, the wrist first.
    let fingers = ["FF", "MF", "RF", "LF", "TH"].iter().flat_map(|finger| {
        let first = if ["LF", "TH"].contains(finger) { 5 } else { 4 };
        (1..=first).map(move |joint| format!("rh_{finger}J{joint}"))
    });
    let names: Vec<String> = fingers
        .chain(["rh_WRJ1".to_owned(), "rh_WRJ2".to_owned()])
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let found = read_as(&content, &names, &Mapping::default()).unwrap();
    let joints = found.grasps[0].pose.joints();
    // FFJ1 is the sixth number, LFJ5 the fifteenth; the wrist comes first.
    assert_eq!(
        (joints[0], joints[16], joints[22], joints[23]),
        (5.0, 14.0, 1.0, 0.0)
    );
    // As long as the 24 joints of DRO-Grasp's.
    let short = Tensors::Metadata(&[(&q[..30], "apple", "shadowhand")]);
    let wrong = read_as(&short, &names[..21], &Mapping::default()).unwrap_err();
    assert!(wrong.contains("24 joints of `shadowhand`"), "{wrong}");
    // A joint that follows another is left out.
    let followed = HandJoints {
        names: names
            .iter()
            .filter(|name| **name != "rh_FFJ1")
            .map(ToString::to_string)
            .collect(),
        following: vec!["rh_FFJ1".to_owned()],
        rest: None,
    };
    let desk = Desk::empty();
    fs::write(desk.path("g.pt"), torch_of(&content)).unwrap();
    let found = read(&desk.path("g.pt"), followed, &Mapping::default()).unwrap();
    assert_eq!(found.grasps[0].pose.joints()[..2], [4.0, 3.0]);
}
