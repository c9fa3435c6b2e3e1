//! Meaning of the columns of a table.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::euler::of_euler;
use super::joints::matched;
use super::table::{Cell, Table};
use super::{Published, Read, finite, listed};
use crate::space::Pose;

/// Meaning of the columns of a table, and of the numbers of any file. Omitted columns are sought under the names that
/// `landscape export` writes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Mapping {
    /// Position: one column of lists, or three columns.
    pub translation: Option<Columns>,
    /// Unit of positions; metres if it is not stated. A stated unit is believed even if no grasp is near the object.
    pub translation_unit: Option<LengthUnit>,
    /// Rotation: one column of lists, or one column for each number of its form.
    pub rotation: Option<Columns>,
    /// Representation of rotations.
    pub rotation_form: RotationForm,
    /// Unit of Euler angles and rotation vectors.
    pub rotation_unit: AngleUnit,
    /// Direction of the pose.
    pub frame: Frame,
    /// The link of the hand whose pose it is, at the joints of the grasp; the root if it is not stated.
    pub link: Option<String>,
    /// Joints: one column of lists, or a column for each joint of the hand.
    pub joints: Option<JointColumns>,
    /// Names of the joints, in order: those in a column of lists, or those of a file that uses other names.
    pub joint_names: Option<Vec<String>>,
    /// Unit of joint angles.
    pub joint_unit: AngleUnit,
    /// Scale factor of the object: a column, or a number.
    pub scale: Option<Scale>,
    /// Column with the ids of grasps.
    pub id: Option<String>,
    /// Column with the names of objects.
    pub object: Option<String>,
    /// Column with labels.
    pub label: Option<String>,
    /// Column with lists of contacts: indices of the hand's surface points.
    pub contacts: Option<String>,
}

/// A column of lists, or several columns of numbers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Columns {
    /// A column of lists.
    List(String),
    /// Columns of numbers, in order.
    Each(Vec<String>),
}

/// Columns of the joints.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum JointColumns {
    /// A column of lists.
    List(String),
    /// The column of each joint of the hand.
    Each(BTreeMap<String, String>),
}

/// Source of the scale.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Scale {
    /// One number for all grasps.
    Number(f64),
    /// A column.
    Column(String),
}

/// Units of lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LengthUnit {
    /// Metres.
    #[default]
    M,
    /// Centimetres.
    Cm,
    /// Millimetres.
    Mm,
    /// The unit of the object's mesh: metres once multiplied with the scale of the object.
    Mesh,
}

/// Units of angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AngleUnit {
    /// Radians.
    #[default]
    Rad,
    /// Degrees.
    Deg,
}

impl LengthUnit {
    /// The unit in metres; that of the mesh depends on the grasp, and counts as 1 here.
    pub(super) fn metres(self) -> f64 {
        match self {
            Self::M | Self::Mesh => 1.0,
            Self::Cm => 1e-2,
            Self::Mm => 1e-3,
        }
    }
}

impl AngleUnit {
    pub(super) fn radians(self) -> f64 {
        match self {
            Self::Rad => 1.0,
            Self::Deg => std::f64::consts::PI / 180.0,
        }
    }
}

/// Representations of a rotation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RotationForm {
    /// A quaternion w x y z (MuJoCo).
    #[default]
    Wxyz,
    /// A quaternion x y z w (ROS, Isaac Gym, scipy).
    Xyzw,
    /// Angles about the fixed axes x, y, z, in this order (DexGraspNet, URDF).
    FixedXyz,
    /// Rotation axis times angle.
    RotationVector,
    /// A matrix in row-major order.
    Matrix,
}

impl RotationForm {
    fn length(self) -> usize {
        match self {
            Self::Wxyz | Self::Xyzw => 4,
            Self::FixedXyz | Self::RotationVector => 3,
            Self::Matrix => 9,
        }
    }

    /// The rotation as a quaternion w x y z.
    pub(super) fn quaternion(self, values: &[f64], unit: AngleUnit) -> Result<[f64; 4], String> {
        const TOLERANCE: f64 = 1e-3;
        let of = |q: UnitQuaternion<f64>| [q.w, q.i, q.j, q.k];
        let radians = unit.radians();
        match (self, values) {
            (Self::Wxyz, &[w, x, y, z]) | (Self::Xyzw, &[x, y, z, w]) => {
                let norm = Quaternion::new(w, x, y, z).norm();
                if (norm - 1.0).abs() > TOLERANCE {
                    return Err(format!("its quaternion has length {norm:.4}, expected 1"));
                }
                Ok([w, x, y, z])
            }
            (Self::FixedXyz, &[a, b, c]) => Ok(of_euler([a, b, c].map(|angle| angle * radians))),
            (Self::RotationVector, &[x, y, z]) => Ok(of(UnitQuaternion::from_scaled_axis(
                Vector3::new(x, y, z) * radians,
            ))),
            (Self::Matrix, values) if values.len() == 9 => {
                let matrix = Matrix3::from_row_slice(values);
                let off = (matrix * matrix.transpose() - Matrix3::identity()).norm();
                if off > TOLERANCE || matrix.determinant() < 0.0 {
                    return Err("its rotation matrix is not orthogonal, or it mirrors".to_owned());
                }
                Ok(of(UnitQuaternion::from_rotation_matrix(
                    &Rotation3::from_matrix_unchecked(matrix),
                )))
            }
            _ => Err(format!(
                "its rotation has {} numbers, expected {}",
                values.len(),
                self.length()
            )),
        }
    }
}

/// Directions of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// Pose of the hand in the object's frame: `p_object = R p_hand + t`.
    #[default]
    ObjectFromHand,
    /// Pose of the object in the hand's frame.
    HandFromObject,
}

impl Mapping {
    /// Position (metres) and quaternion of the hand in the object's frame, from a position in the unit of the mapping and a
    /// rotation, which are a pose in its direction.
    pub(super) fn directed(
        &self,
        translation: [f64; 3],
        rotation_wxyz: [f64; 4],
    ) -> ([f64; 3], [f64; 4]) {
        let metres = self.translation_unit.unwrap_or_default().metres();
        let translation_m = translation.map(|x| x * metres);
        if self.frame == Frame::ObjectFromHand {
            return (translation_m, rotation_wxyz);
        }
        let [w, x, y, z] = rotation_wxyz;
        let inverse = Isometry3::from_parts(
            Translation3::from(Vector3::from(translation_m)),
            UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
        )
        .inverse();
        let q = inverse.rotation;
        (inverse.translation.vector.into(), [q.w, q.i, q.j, q.k])
    }

    /// The quaternion w x y z of four numbers in the order that the mapping tells.
    pub(super) fn ordered(&self, [a, b, c, d]: [f64; 4]) -> Result<[f64; 4], String> {
        match self.rotation_form {
            RotationForm::Wxyz => Ok([a, b, c, d]),
            RotationForm::Xyzw => Ok([d, a, b, c]),
            _ => Err(
                "the rotations of this format are quaternions: `rotation_form` is `wxyz` or `xyzw`"
                    .to_owned(),
            ),
        }
    }
}

/// The columns in use; all of them exist.
struct Layout<'a> {
    mapping: &'a Mapping,
    translation: Vec<String>,
    rotation: Vec<String>,
    /// Columns of joints, and for each joint of the hand the index among their numbers.
    joints: (Vec<String>, Vec<usize>),
}

pub(super) fn read(table: &Table, hand: &[String], mapping: &Mapping) -> Result<Read, String> {
    let mut notes = Vec::new();
    let layout = Layout {
        mapping,
        translation: columns(
            table,
            mapping.translation.as_ref(),
            "translation",
            "translation_m",
            &["translation_m_x", "translation_m_y", "translation_m_z"],
        )?,
        rotation: columns(
            table,
            mapping.rotation.as_ref(),
            "rotation",
            "rotation_wxyz",
            &["rotation_w", "rotation_x", "rotation_y", "rotation_z"],
        )?,
        joints: joint_columns(table, hand, mapping, &mut notes)?,
    };
    for column in [
        &mapping.id,
        &mapping.object,
        &mapping.label,
        &mapping.contacts,
    ]
    .into_iter()
    .flatten()
    {
        needed(table, column)?;
    }
    if let Some(Scale::Column(column)) = &mapping.scale {
        needed(table, column)?;
    }
    let grasp = |(place, row): (usize, &BTreeMap<String, Cell>)| {
        layout
            .grasp(row)
            .map_err(|problem| format!("row {place} (the first is 0): {problem}"))
    };
    Ok(Read {
        grasps: table
            .rows
            .iter()
            .enumerate()
            .map(grasp)
            .collect::<Result<_, _>>()?,
        notes,
        format: "table",
        ..Read::default()
    })
}

fn needed(table: &Table, column: &str) -> Result<(), String> {
    if table.columns.iter().any(|name| name == column) {
        return Ok(());
    }
    Err(format!(
        "it has no column `{column}`, which the mapping names; it has {}",
        listed(table.columns.iter().map(String::as_str))
    ))
}

/// The mapped columns, or those with the default names.
fn columns(
    table: &Table,
    mapped: Option<&Columns>,
    what: &str,
    list: &str,
    each: &[&str],
) -> Result<Vec<String>, String> {
    let has = |name: &str| table.columns.iter().any(|column| column == name);
    match mapped {
        Some(Columns::List(column)) => {
            needed(table, column)?;
            Ok(vec![column.clone()])
        }
        Some(Columns::Each(columns)) => {
            for column in columns {
                needed(table, column)?;
            }
            Ok(columns.clone())
        }
        None if has(list) => Ok(vec![list.to_owned()]),
        None if each.iter().all(|name| has(name)) => {
            Ok(each.iter().map(ToString::to_string).collect())
        }
        None => Err(format!(
            "it has neither a column `{list}` nor `{}`: name the columns of the {what} in a mapping (it has {})",
            each.join("`, `"),
            listed(table.columns.iter().map(String::as_str))
        )),
    }
}

fn joint_columns(
    table: &Table,
    hand: &[String],
    mapping: &Mapping,
    notes: &mut Vec<String>,
) -> Result<(Vec<String>, Vec<usize>), String> {
    const LIST: &str = "joints";
    let has_list = table.columns.iter().any(|column| column == LIST);
    let in_order = || (0..hand.len()).collect::<Vec<usize>>();
    let list = match &mapping.joints {
        Some(JointColumns::List(column)) => Some(column.as_str()),
        Some(JointColumns::Each(columns)) => return Ok((named(table, hand, columns)?, in_order())),
        None => has_list.then_some(LIST),
    };
    if let Some(column) = list {
        needed(table, column)?;
        let places = if let Some(names) = &mapping.joint_names {
            matched(&names.iter().map(String::as_str).collect::<Vec<_>>(), hand)?
        } else {
            notes.push(format!(
                    "column `{column}` does not name its joints: they are taken to be in the hand's order, {}",
                    hand.join(", ")
                ));
            in_order()
        };
        return Ok((vec![column.to_owned()], places));
    }
    // Columns with the names of joints. Other columns are ignored.
    let bare = |name: &String| table.columns.iter().find(|column| *column == name).cloned();
    let names: Option<Vec<String>> = hand.iter().map(bare).collect();
    if let Some(names) = names {
        return Ok((names, in_order()));
    }
    let missing = hand
        .iter()
        .filter(|name| bare(name).is_none())
        .map(String::as_str);
    Err(format!(
        "it has no columns for the joints {} of the hand: name them in a mapping",
        listed(missing)
    ))
}

/// The column that a mapping names for each joint of the hand.
fn named(
    table: &Table,
    hand: &[String],
    columns: &BTreeMap<String, String>,
) -> Result<Vec<String>, String> {
    let column = |joint: &String| {
        let column = columns.get(joint).cloned();
        column.ok_or_else(|| format!("the mapping names no column for joint {joint} of the hand"))
    };
    let names = hand
        .iter()
        .map(column)
        .collect::<Result<Vec<String>, _>>()?;
    for name in &names {
        needed(table, name)?;
    }
    if let Some(extra) = columns.keys().find(|joint| !hand.contains(joint)) {
        return Err(format!(
            "the mapping names joint {extra}, which the hand does not have; it has {}",
            listed(hand.iter().map(String::as_str))
        ));
    }
    Ok(names)
}

impl Layout<'_> {
    fn grasp(&self, row: &BTreeMap<String, Cell>) -> Result<Published, String> {
        let mapping = self.mapping;
        let translation = numbers(row, &self.translation)?;
        let Ok(translation) = <[f64; 3]>::try_from(translation.as_slice()) else {
            return Err(format!(
                "its position has {} numbers, expected 3",
                translation.len()
            ));
        };
        let rotation = numbers(row, &self.rotation)?;
        let rotation = mapping
            .rotation_form
            .quaternion(&rotation, mapping.rotation_unit)?;
        let (translation_m, rotation_wxyz) = mapping.directed(translation, rotation);
        let (columns, places) = &self.joints;
        let joints = numbers(row, columns)?;
        let expected = mapping.joint_names.as_ref().map_or(places.len(), Vec::len);
        if joints.len() != expected.max(places.len()) {
            return Err(format!(
                "it has {} joints, expected {expected}",
                joints.len()
            ));
        }
        let joints: Vec<f64> = places
            .iter()
            .map(|&place| joints[place] * mapping.joint_unit.radians())
            .collect();
        Ok(Published {
            id: whole(row, mapping.id.as_deref().unwrap_or("id"))?,
            pose: Pose::new(translation_m, rotation_wxyz, &joints),
            scale: self.scale(row)?,
            object: text(row, mapping.object.as_deref().unwrap_or("object")),
            label: text(row, mapping.label.as_deref().unwrap_or("label")),
            contacts: contacts(row, mapping.contacts.as_deref().unwrap_or("contacts"))?,
            ..Published::default()
        })
    }

    fn scale(&self, row: &BTreeMap<String, Cell>) -> Result<Option<f64>, String> {
        let column = match &self.mapping.scale {
            Some(Scale::Number(scale)) => return Ok(Some(*scale)),
            Some(Scale::Column(column)) => column,
            None => "scale",
        };
        match row.get(column) {
            None => Ok(None),
            Some(_) => match numbers(row, &[column.to_owned()])?[..] {
                [scale] => Ok(Some(scale)),
                _ => Err(format!("column `{column}` contains no single number")),
            },
        }
    }
}

/// The numbers in some columns, in order.
fn numbers(row: &BTreeMap<String, Cell>, columns: &[String]) -> Result<Vec<f64>, String> {
    let mut all = Vec::new();
    for column in columns {
        match row.get(column).map(|cell| (cell.numbers(), cell)) {
            Some((Some(numbers), _)) => all.extend(numbers),
            Some((None, Cell::Text(text))) => {
                return Err(format!(
                    "column `{column}` contains `{text}` where numbers are needed"
                ));
            }
            _ => return Err(format!("column `{column}` is empty")),
        }
        finite(&all, &format!("column `{column}`"))?;
    }
    Ok(all)
}

fn text(row: &BTreeMap<String, Cell>, column: &str) -> Option<String> {
    match row.get(column)? {
        Cell::Text(text) => Some(text.clone()),
        Cell::Number(number) => Some(number.to_string()),
        Cell::List(_) => None,
    }
}

fn whole(row: &BTreeMap<String, Cell>, column: &str) -> Result<Option<u64>, String> {
    let Some(cell) = row.get(column) else {
        return Ok(None);
    };
    // Keep all digits of a whole number. A table may also contain 7.0.
    if let Cell::Text(text) = cell
        && let Ok(number) = text.parse()
    {
        return Ok(Some(number));
    }
    match cell.numbers().as_deref() {
        Some([number]) => match natural(*number) {
            Some(number) => Ok(Some(number)),
            None => Err(format!(
                "column `{column}` contains {number}, expected a whole number"
            )),
        },
        _ => Err(format!("column `{column}` contains no number")),
    }
}

fn natural(number: f64) -> Option<u64> {
    // Beyond 2⁵³, floating-point numbers do not represent every whole number.
    let is = number.fract() == 0.0 && (0.0..=9.0e15).contains(&number);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number below 2⁵³"
    )]
    is.then_some(number as u64)
}

fn contacts(row: &BTreeMap<String, Cell>, column: &str) -> Result<Option<Vec<u32>>, String> {
    let values = match row.get(column).map(|cell| (cell.numbers(), cell)) {
        None => return Ok(None),
        Some((Some(values), _)) => values,
        Some((None, Cell::Text(text))) => {
            return Err(format!(
                "column `{column}` contains `{text}`, expected whole numbers"
            ));
        }
        Some((None, _)) => return Err(format!("column `{column}` contains no numbers")),
    };
    let index = |value: f64| {
        let index = natural(value).and_then(|value| u32::try_from(value).ok());
        index.ok_or_else(|| format!("column `{column}` contains {value}, expected a whole number"))
    };
    values
        .into_iter()
        .map(index)
        .collect::<Result<Vec<u32>, _>>()
        .map(Some)
}
