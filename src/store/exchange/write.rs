//! Writes grasps in the formats of other programs.

use serde_json::{Map, Value};

use super::dexgraspnet::{ROTATION, TRANSLATION};
use super::euler::to_euler;
use crate::formats::npy;
use crate::formats::pickle_writer::Writer;
use crate::hand::Hand;
use crate::store::GraspRow;

/// A grasp as MuJoCo's qpos: a free joint (position, quaternion w x y z) or the joints of a virtual wrist, then one number per
/// joint of the model. The free joint is that of a body to which the world of the hand's file is attached (`MjSpec.attach`).
#[derive(Debug, Clone, PartialEq)]
pub struct QposRow {
    /// The id of the grasp.
    pub id: u64,
    /// The qpos vector.
    pub qpos: Vec<f64>,
}

/// An array of DexGraspNet's dictionaries for `numpy.load(…, allow_pickle=True)`.
pub fn dexgraspnet_npy(grasps: &[&GraspRow], joint_names: &[String]) -> Vec<u8> {
    let mut writer = Writer::of_objects(grasps.len());
    for grasp in grasps {
        writer.open_dictionary();
        writer.text("qpos");
        writer.open_dictionary();
        let angles = to_euler(grasp.grasp.pose.rotation_wxyz());
        let joints = joint_names
            .iter()
            .map(String::as_str)
            .zip(grasp.grasp.pose.joints().iter().copied());
        let wrist = ROTATION.into_iter().zip(angles).chain(
            TRANSLATION
                .into_iter()
                .zip(grasp.grasp.pose.translation_m().iter().copied()),
        );
        for (name, value) in joints.chain(wrist) {
            writer.text(name);
            writer.number(value);
        }
        writer.close_dictionary();
        writer.text("scale");
        writer.number(grasp.scale);
        writer.close_dictionary();
    }
    npy::with_header("|O", &format!("({},)", grasps.len()), &writer.finish())
}

/// Names of the columns of [`table_csv`] before the joints.
const COLUMNS: [&str; 13] = [
    "id",
    "object",
    "scale",
    "hand",
    "translation_m_x",
    "translation_m_y",
    "translation_m_z",
    "rotation_w",
    "rotation_x",
    "rotation_y",
    "rotation_z",
    "label",
    "contacts",
];

/// A CSV table with one row per grasp and one column per joint (radians). Numbers keep every bit.
pub fn table_csv(grasps: &[&GraspRow], joint_names: &[String]) -> Vec<u8> {
    let head = COLUMNS
        .iter()
        .map(ToString::to_string)
        .chain(joint_names.iter().cloned());
    let rows = grasps.iter().map(|grasp| {
        let contacts: Vec<String> = grasp
            .grasp
            .contacts
            .iter()
            .map(ToString::to_string)
            .collect();
        let mut row = vec![
            grasp.id.to_string(),
            grasp.object.clone(),
            grasp.scale.to_string(),
            grasp.hand.clone(),
        ];
        row.extend(grasp.grasp.pose.translation_m().iter().map(f64::to_string));
        row.extend(grasp.grasp.pose.rotation_wxyz().iter().map(f64::to_string));
        row.push(grasp.label.clone().unwrap_or_default());
        // Brackets make a single contact a list as well.
        row.push(format!("[{}]", contacts.join(" ")));
        row.extend(grasp.grasp.pose.joints().iter().map(f64::to_string));
        row
    });
    csv_table(std::iter::once(head.collect()).chain(rows))
}

/// A table with commas, its head first. All rows have the same length.
pub fn csv_table(rows: impl Iterator<Item = Vec<String>>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        // Writing to a Vec cannot fail, and all rows have the same length.
        let _ = writer.write_record(row);
    }
    writer.into_inner().unwrap_or_default()
}

/// A JSON list of objects with the content of the CSV table. Lists replace its groups of columns.
pub fn table_json(grasps: &[&GraspRow], joint_names: &[String]) -> Vec<u8> {
    let entry = |grasp: &&GraspRow| {
        let mut entry = Map::new();
        let mut add = |name: &str, value: Value| entry.insert(name.to_owned(), value);
        add("id", grasp.id.into());
        add("object", grasp.object.clone().into());
        add("scale", grasp.scale.into());
        add("hand", grasp.hand.clone().into());
        add(
            "translation_m",
            grasp.grasp.pose.translation_m().to_vec().into(),
        );
        add(
            "rotation_wxyz",
            grasp.grasp.pose.rotation_wxyz().to_vec().into(),
        );
        if let Some(label) = &grasp.label {
            add("label", label.clone().into());
        }
        add("contacts", grasp.grasp.contacts.clone().into());
        for (name, angle) in joint_names.iter().zip(grasp.grasp.pose.joints()) {
            add(name, (*angle).into());
        }
        Value::Object(entry)
    };
    let entries: Vec<Value> = grasps.iter().map(entry).collect();
    let mut text = serde_json::to_string_pretty(&Value::Array(entries)).unwrap_or_default();
    text.push('\n');
    text.into_bytes()
}

/// The rows of grasps of one hand, and the names of their columns: the pose, then the joints in depth-first order, including
/// joints that follow others.
///
/// The pose is that of a free joint (`x`, `y`, `z`, `qw`, `qx`, `qy`, `qz`), or the coordinates of the hand's virtual wrist if
/// these can give the poses of all grasps.
///
/// # Panics
/// If a grasp is one of another hand.
pub fn qpos(hand: &Hand, grasps: &[&GraspRow]) -> (Vec<String>, Vec<QposRow>) {
    let moving = || {
        hand.links
            .iter()
            .enumerate()
            .filter_map(|(place, link)| Some((place, link, link.motion?)))
    };
    let of_wrist = hand.virtual_wrist.as_ref().and_then(|wrist| {
        let places = grasps
            .iter()
            .map(|grasp| wrist.coordinates(&grasp.grasp.pose));
        let places: Vec<Vec<f64>> = places.collect::<Option<_>>()?;
        Some((wrist.joint_names().map(str::to_owned).collect(), places))
    });
    let (mut names, places): (Vec<String>, _) = of_wrist.unwrap_or_else(|| {
        let free = ["x", "y", "z", "qw", "qx", "qy", "qz"].map(str::to_owned);
        let places = grasps.iter().map(|grasp| {
            let pose = &grasp.grasp.pose;
            [pose.translation_m(), &pose.rotation_wxyz()].concat()
        });
        (free.to_vec(), places.collect())
    });
    names.extend(moving().map(|(_, link, _)| link.joint_name.clone()));
    let row = |(grasp, mut qpos): (&&GraspRow, Vec<f64>)| {
        qpos.extend(moving().map(|(place, _, motion)| {
            let q = grasp.grasp.pose.joints()[motion.joint];
            // The joint's own coordinate, or the displacement of a joint that follows another.
            if hand.joints[motion.joint].link.0 == place {
                q
            } else {
                motion.ratio * q + motion.offset
            }
        }));
        QposRow { id: grasp.id, qpos }
    };
    (names, grasps.iter().zip(places).map(row).collect())
}

/// A CSV table of qpos vectors, with the names of their columns.
pub fn qpos_csv(rows: &[QposRow], names: &[String]) -> Vec<u8> {
    let head = std::iter::once("id".to_owned()).chain(names.iter().cloned());
    let rows = rows.iter().map(|row| {
        let numbers = row.qpos.iter().map(f64::to_string);
        std::iter::once(row.id.to_string()).chain(numbers).collect()
    });
    csv_table(std::iter::once(head.collect()).chain(rows))
}

/// A numpy table of qpos vectors, one grasp per row.
pub fn qpos_npy(rows: &[QposRow]) -> Vec<u8> {
    let rows: Vec<Vec<f64>> = rows.iter().map(|row| row.qpos.clone()).collect();
    npy::table(&rows)
}
