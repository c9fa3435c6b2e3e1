//! Files of torch: those of graspqp, and of `MultiDex` (`GenDexGrasp`) and DRO-Grasp.
//!
//! | content | of | pose | joints |
//! | --- | --- | --- | --- |
//! | `parameters`: `root_pose` (N, 7), and (N) for each joint by name | graspqp | position, quaternion x y z w | by name |
//! | `metadata`: tuples that end in q, object, robot | `MultiDex` | position, two columns of the matrix: 9 + joints numbers | of Shadow's and Barrett's hand by name, of others in the hand's order |
//! | the same | DRO-Grasp | position, angles about the moving axes x, y, z: 6 + joints numbers | in the hand's order |

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::dexgraspbench::isometry;
use super::euler::of_moving_euler;
use super::hand_joints::HandJoints;
use super::joints::{follows, matched};
use super::mapping::{Mapping, RotationForm};
use super::{Published, Read, finite, listed};
use crate::formats::pickle::{Heap, Id, Node};
use crate::printable::counted;
use crate::space::Pose;

/// Largest number of grasps in a file. A small file could otherwise give very many, because its entries may share tensors.
const MOST: usize = 1 << 20;
/// Name of the entry with the pose in files of graspqp.
const ROOT: &str = "root_pose";

/// The joints of `MultiDex`, whose files do not name them, by the name of the robot. The names are those of the hands' files
/// without prefixes; Barrett's are those of its URDF.
const ORDERS: [(&str, &[&str]); 2] = [
    (
        "shadowhand",
        &[
            "WRJ2", "WRJ1", "FFJ4", "FFJ3", "FFJ2", "FFJ1", "MFJ4", "MFJ3", "MFJ2", "MFJ1", "RFJ4",
            "RFJ3", "RFJ2", "RFJ1", "LFJ5", "LFJ4", "LFJ3", "LFJ2", "LFJ1", "THJ5", "THJ4", "THJ3",
            "THJ2", "THJ1",
        ],
    ),
    (
        "barrett",
        &[
            "bh_j32_joint",
            "bh_j33_joint",
            "bh_j11_joint",
            "bh_j12_joint",
            "bh_j13_joint",
            "bh_j21_joint",
            "bh_j22_joint",
            "bh_j23_joint",
        ],
    ),
];

pub(super) fn read(
    heap: &Heap,
    whole: Id,
    hand: &HandJoints,
    mapping: &Mapping,
) -> Result<Read, String> {
    let parameters = heap.entry(whole, "parameters");
    let metadata = heap.entry(whole, "metadata");
    match (parameters, metadata) {
        (Some(parameters), None) => of_parameters(heap, parameters, hand, mapping),
        (None, Some(metadata)) => of_metadata(heap, metadata, hand, mapping),
        _ => Err(format!(
            "it has neither `parameters` alone (graspqp) nor `metadata` alone (MultiDex, DRO-Grasp): {}",
            super::unread::INSTEAD
        )),
    }
}

/// The joints of the hand among those of a file.
struct Order {
    /// For each joint of the hand, its place among the numbers of the file.
    places: Vec<usize>,
    /// How many numbers the file has.
    count: usize,
}

impl Order {
    /// The order of numbers with these names, which may hold joints that follow others.
    fn named(names: &[&str], hand: &HandJoints) -> Result<Self, String> {
        let own = |place: &usize| !follows(names[*place], &hand.names, &hand.following);
        let own: Vec<usize> = (0..names.len()).filter(own).collect();
        let own_names: Vec<&str> = own.iter().map(|place| names[*place]).collect();
        let places = matched(&own_names, &hand.names)?.into_iter();
        Ok(Self {
            places: places.map(|place| own[place]).collect(),
            count: names.len(),
        })
    }
}

fn texts(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

/// graspqp: a tensor for each joint.
fn of_parameters(
    heap: &Heap,
    parameters: Id,
    hand: &HandJoints,
    mapping: &Mapping,
) -> Result<Read, String> {
    if !matches!(
        mapping.rotation_form,
        RotationForm::Wxyz | RotationForm::Xyzw
    ) {
        return Err(
            "the rotations of graspqp are quaternions x y z w: leave `rotation_form` out of the mapping".to_owned(),
        );
    }
    let Node::Dictionary(entries) = heap.node(parameters) else {
        return Err("its `parameters` are not a dictionary".to_owned());
    };
    let (mut names, mut columns) = (Vec::new(), Vec::new());
    let mut roots = None;
    for (key, value) in entries {
        let Node::Text(name) = heap.node(*key) else {
            return Err("its `parameters` have a key that is not text".to_owned());
        };
        let numbers = heap.numbers(*value);
        let numbers = numbers.ok_or_else(|| format!("its `{name}` is not a tensor of numbers"))?;
        if name == ROOT {
            roots = Some(numbers);
        } else {
            names.push(name.as_str());
            columns.push(numbers.values);
        }
    }
    let roots = roots.ok_or_else(|| format!("its `parameters` have no `{ROOT}`"))?;
    let [count, 7] = roots.shape[..] else {
        return Err(format!(
            "its `{ROOT}` has the shape {:?}; grasps × 7 is needed",
            roots.shape
        ));
    };
    if let Some(place) = columns.iter().position(|column| column.len() != count) {
        return Err(format!(
            "its joint `{}` has {}, but `{ROOT}` has {count} rows",
            names[place],
            counted(columns[place].len(), "number")
        ));
    }
    if let Some(given) = &mapping.joint_names {
        if given.len() != names.len() {
            return Err(format!(
                "it has {}, but the mapping names {}",
                counted(names.len(), "joint"),
                given.len()
            ));
        }
        names = texts(given);
    }
    let order = Order::named(&names, hand)?;
    let unit = mapping.joint_unit.radians();
    let grasp = |(place, root): (usize, &[f64])| {
        let told = |problem| format!("row {place}: {problem}");
        let [x, y, z, qx, qy, qz, qw] = *root else {
            return Err(told("it has no seven numbers".to_owned()));
        };
        let rotation = [qw, qx, qy, qz];
        isometry(&[x, y, z, qw, qx, qy, qz], ROOT).map_err(told)?;
        let joints = order
            .places
            .iter()
            .map(|joint| unit * columns[*joint][place]);
        let joints: Vec<f64> = joints.collect();
        finite(&joints, "its joints").map_err(told)?;
        let (translation_m, rotation_wxyz) = mapping.directed([x, y, z], rotation);
        Ok(Published {
            pose: Pose::new(translation_m, rotation_wxyz, &joints),
            ..Published::default()
        })
    };
    let grasps = roots.values.chunks_exact(7).enumerate().map(grasp);
    Ok(Read {
        grasps: grasps.collect::<Result<_, _>>()?,
        format: "graspqp",
        notes: vec![format!(
            "`{ROOT}` is taken for a position and a quaternion x y z w, as in graspqp"
        )],
        ..Read::default()
    })
}

/// `MultiDex` and DRO-Grasp: a tuple for each grasp.
#[expect(
    clippy::too_many_lines,
    reason = "the checks of one tuple, one after the other"
)]
fn of_metadata(
    heap: &Heap,
    metadata: Id,
    hand: &HandJoints,
    mapping: &Mapping,
) -> Result<Read, String> {
    if mapping.rotation_form != RotationForm::default() {
        return Err(
            "the rotations of MultiDex and DRO-Grasp follow from the number of numbers: leave `rotation_form` out of the \
             mapping"
                .to_owned(),
        );
    }
    let Node::List(items) = heap.node(metadata) else {
        return Err("its `metadata` is not a list of grasps".to_owned());
    };
    if items.len() > MOST {
        return Err(format!("it contains more than {MOST} grasps"));
    }
    let rows: Vec<Row<'_>> = (items.iter().enumerate())
        .map(|(place, item)| {
            let row = Row::of(heap, *item);
            row.ok_or_else(|| {
                format!("entry {place} of its `metadata` is not a tuple of q, the name of the object and that of the robot")
            })
        })
        .collect::<Result<_, _>>()?;
    let robots: BTreeSet<&str> = rows.iter().map(|row| row.robot).collect();
    if robots.len() > 1 {
        return Err(format!(
            "it contains grasps of {} robots ({}): save those of each robot in a file of its own",
            robots.len(),
            listed(robots.iter().copied())
        ));
    }
    let robot = robots.first().copied().unwrap_or_default();
    let known = ORDERS.iter().find(|(name, _)| *name == robot);
    let lengths: BTreeSet<usize> = rows.iter().map(|row| row.length).collect();
    if lengths.len() > 1 {
        return Err("the q of its grasps differ in length".to_owned());
    }
    let length = lengths.first().copied().unwrap_or_default();
    // The file of DRO-Grasp has the order of its own kinematics.
    let names: Vec<&str> = match (&mapping.joint_names, known) {
        (Some(given), _) => texts(given),
        (None, Some((_, order))) if length == 9 + order.len() => order.to_vec(),
        // With 21 joints, the 30 numbers of a Shadow hand of DRO-Grasp would be those of another hand of MultiDex.
        (None, Some((_, order)))
            if length == 6 + order.len() && order.len() != hand.names.len() =>
        {
            return Err(format!(
                "its q has {} for the {} joints of `{robot}`, but the hand has {}: give --mapping with `joint_names` for all \
                 joints of the file",
                counted(length, "number"),
                order.len(),
                hand.names.len()
            ));
        }
        _ => texts(&hand.names),
    };
    let unnamed = mapping.joint_names.is_none() && names == texts(&hand.names);
    // Some descriptions count the thumb's and the fingers' joints from 0, which only a mapping can say.
    let order = Order::named(&names, hand).map_err(|problem| {
        format!("{problem}; its robot is `{robot}`: give --mapping with `joint_names`")
    })?;
    let rotation = match length.checked_sub(order.count) {
        Some(9) => Rotation::TwoColumns,
        Some(6) => Rotation::MovingAngles,
        _ => {
            return Err(format!(
                "its q has {}; 9 (MultiDex: position, two columns of the rotation) or 6 (DRO-Grasp: position, three angles) and \
                 the {} joints are needed: give --mapping with `joint_names` for all joints of the file, or save the poses as \
                 a table",
                counted(length, "number"),
                order.count
            ));
        }
    };
    let mut read = Read {
        format: rotation.format(),
        notes: vec![rotation.note()],
        ..Read::default()
    };
    if unnamed {
        read.notes.push(format!(
            "the file does not name its joints: they are taken to be in the hand's order, {}",
            hand.names.join(", ")
        ));
    }
    let unit = mapping.joint_unit.radians();
    for (place, row) in rows.iter().enumerate() {
        let entry = |problem: String| format!("entry {place} of its `metadata`: {problem}");
        let q = heap.numbers(row.q).map(|q| q.values).unwrap_or_default();
        finite(&q, "its q").map_err(entry)?;
        let (root, joints) = q.split_at(length - order.count);
        let position = [root[0], root[1], root[2]];
        let turn = rotation.quaternion(&root[3..]).map_err(entry)?;
        let (translation_m, rotation_wxyz) = mapping.directed(position, turn);
        let joints: Vec<f64> = order
            .places
            .iter()
            .map(|joint| unit * joints[*joint])
            .collect();
        read.grasps.push(Published {
            pose: Pose::new(translation_m, rotation_wxyz, &joints),
            object: Some(row.object.to_owned()),
            ..Published::default()
        });
    }
    Ok(read)
}

/// The last three items of a tuple.
struct Row<'a> {
    q: Id,
    /// How many numbers q has.
    length: usize,
    object: &'a str,
    robot: &'a str,
}

impl<'a> Row<'a> {
    fn of(heap: &'a Heap, item: Id) -> Option<Self> {
        let Node::List(parts) = heap.node(item) else {
            return None;
        };
        let [.., q, object, robot] = parts[..] else {
            return None;
        };
        let length = match heap.node(q) {
            Node::Numbers(numbers) if numbers.shape.len() == 1 => numbers.values.len(),
            Node::List(numbers) => numbers.len(),
            _ => return None,
        };
        heap.numbers(q)?;
        let [Node::Text(object), Node::Text(robot)] = [object, robot].map(|id| heap.node(id))
        else {
            return None;
        };
        Some(Self {
            q,
            length,
            object,
            robot,
        })
    }
}

/// Forms of the rotation in a q.
#[derive(Clone, Copy)]
enum Rotation {
    TwoColumns,
    MovingAngles,
}

impl Rotation {
    fn format(self) -> &'static str {
        match self {
            Self::TwoColumns => "MultiDex",
            Self::MovingAngles => "DRO-Grasp",
        }
    }

    fn note(self) -> String {
        let form = match self {
            Self::TwoColumns => "two columns of the rotation, as in MultiDex",
            Self::MovingAngles => "three angles about the moving axes x, y, z, as in DRO-Grasp",
        };
        format!("q is taken for a position, {form}, and the joints, because of its length")
    }

    fn quaternion(self, numbers: &[f64]) -> Result<[f64; 4], String> {
        match (self, numbers) {
            (Self::MovingAngles, &[a, b, c]) => Ok(of_moving_euler([a, b, c])),
            (Self::TwoColumns, &[a, b, c, d, e, f]) => {
                of_two_columns(Vector3::new(a, b, c), Vector3::new(d, e, f))
            }
            _ => Err("its rotation is not complete".to_owned()),
        }
    }
}

/// The rotation whose first columns are nearest to two directions, both of which turn by the same angle to become orthogonal, as
/// in `GenDexGrasp`.
fn of_two_columns(first: Vector3<f64>, second: Vector3<f64>) -> Result<[f64; 4], String> {
    const SHORTEST: f64 = 1e-6;
    let unit = |v: Vector3<f64>| {
        v.try_normalize(SHORTEST)
            .ok_or("the two columns of its rotation are zero or parallel".to_owned())
    };
    let (first, second) = (unit(first)?, unit(second)?);
    let (middle, across) = (unit(first + second)?, unit(first - second)?);
    let (x, y) = (unit(middle + across)?, unit(middle - across)?);
    let matrix = Matrix3::from_columns(&[x, y, x.cross(&y)]);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
    Ok([turn.w, turn.i, turn.j, turn.k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_columns_are_made_orthogonal_from_both_sides() {
        let turn =
            of_two_columns(Vector3::new(0.0, 2.0, 0.0), Vector3::new(-1.0, 0.0, 0.0)).unwrap();
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for (q, expected) in turn.into_iter().zip([half, 0.0, 0.0, half]) {
            assert!((q - expected).abs() < 1e-12, "{turn:?}");
        }
        // Columns 60° apart about the diagonal of x and y give the same as x and y.
        let tilt = std::f64::consts::PI / 12.0;
        let (long, short) = (libm::cos(tilt), libm::sin(tilt));
        let turn = of_two_columns(
            Vector3::new(long, short, 0.0),
            Vector3::new(short, long, 0.0),
        )
        .unwrap();
        assert!((turn[0] - 1.0).abs() < 1e-12, "{turn:?}");
        assert!(of_two_columns(Vector3::x(), Vector3::x()).is_err());
    }
}
