//! Writes the dictionaries of `DexGraspBench` and Dexonomy.

use crate::formats::npy;
use crate::formats::pickle_writer::Writer;
use crate::hand::Hand;
use crate::store::GraspRow;

/// A grasp as `DexGraspBench` and Dexonomy store one in a file, for `numpy.load(…, allow_pickle=True).item()`: position,
/// quaternion w x y z of the hand and joints, before the hand closes, when it touches and when it presses. The hand's frame is
/// that of its description: both programs attach the world of the MJCF to a body with a free joint. The object stands at the
/// origin of the world.
///
/// # Panics
/// If the grasp is one of another hand.
pub fn dexonomy_npy(hand: &Hand, grasp: &GraspRow, before: &[f64], squeezed: &[f64]) -> Vec<u8> {
    let pose = &grasp.grasp.pose;
    let root = [pose.translation_m(), &pose.rotation_wxyz()].concat();
    let mut writer = Writer::of_object();
    writer.open_dictionary();
    for (key, joints) in [
        ("pregrasp_qpos", before),
        ("grasp_qpos", pose.joints()),
        ("squeeze_qpos", squeezed),
    ] {
        writer.text(key);
        writer.numbers(&[&root, joints].concat());
    }
    writer.text("obj_pose");
    writer.numbers(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    writer.text("obj_scale");
    writer.number(grasp.scale);
    for (key, text) in [("obj_path", &grasp.object), ("hand_type", &grasp.hand)] {
        writer.text(key);
        writer.text(text);
    }
    writer.text("joint_names");
    let names = hand.joints.iter().map(|joint| joint.name.as_str());
    writer.texts(names);
    writer.close_dictionary();
    npy::with_header("|O", "()", &writer.finish())
}
