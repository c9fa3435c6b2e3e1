//! MANO, the hand model of Romero, Tzionas and Black (2017), read from the user's own copy.
//!
//! Its licence forbids redistribution, so no part of it is written anywhere: [`HandFiles`](super::HandFiles) hold only the
//! path of the file and a hash of its bytes.

mod assemble;

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use nalgebra::{DMatrix, DVector, Vector3};
use serde::{Deserialize, Serialize};

use super::HandError;
use crate::formats::array::Numbers;
use crate::formats::npz;
use crate::limits::MANO_NUMBER;

pub(super) use assemble::assemble;

/// Number of links: the wrist and three per finger.
const LINKS: usize = 16;
/// Number of angles of all joints but the wrist.
const ANGLES: usize = 45;
/// Number of entries of their rotation matrices.
const ENTRIES: usize = 135;
/// Parents in every MANO file; the order is wrist, index, middle, little, ring, thumb.
const PARENTS: [usize; LINKS - 1] = [0, 1, 2, 0, 4, 5, 0, 7, 8, 0, 10, 11, 0, 13, 14];

/// The text of a description in place of the model itself.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Reference {
    /// Path of the file as it was given; the file is read again from there.
    mano_file: PathBuf,
    /// FNV-1a hash of its bytes, 128 bits.
    hash: String,
}

/// The reference to a MANO file, if a description has one.
pub(super) fn reference(text: &str) -> Option<Reference> {
    text.trim_start()
        .starts_with('{')
        .then(|| serde_json::from_str(text).ok())?
}

/// Whether a file is an archive of `NumPy`.
pub(super) fn is_archive(path: &Path) -> bool {
    path.extension()
        .is_some_and(|kind| kind.eq_ignore_ascii_case("npz"))
}

/// The description that refers to the file with these bytes.
pub(super) fn description(path: &Path, bytes: &[u8]) -> Result<String, HandError> {
    // Steps `.` are dropped, so that the same path gives the same text.
    let steps = path.components().filter(|step| *step != Component::CurDir);
    let reference = Reference {
        mano_file: steps.collect(),
        hash: hash(bytes),
    };
    Ok(serde_json::to_string(&reference)?)
}

fn hash(bytes: &[u8]) -> String {
    let hash = bytes.iter().fold(
        0x6c62_272e_07bb_0142_62b8_2175_6295_c58d_u128,
        |hash, byte| {
            (hash ^ u128::from(*byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b)
        },
    );
    format!("{hash:032x}")
}

/// The arrays of a MANO file, metres and radians.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Arrays {
    file: String,
    template: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
    /// 3 × shapes, per vertex.
    shape_directions: Vec<DMatrix<f64>>,
    /// 3 × 135, per vertex.
    pose_directions: Vec<DMatrix<f64>>,
    /// Links × vertices.
    regressor: DMatrix<f64>,
    /// Vertices × links.
    weights: DMatrix<f64>,
    /// Each row is a principal component of the angles.
    components: DMatrix<f64>,
    mean_rad: DVector<f64>,
    /// Each row is one of the poses from which the components were computed.
    coefficients: DMatrix<f64>,
}

impl Reference {
    /// Hash of the file's bytes.
    pub(super) fn hash(&self) -> &str {
        &self.hash
    }

    /// Reads the file.
    pub(super) fn read(&self) -> Result<Arrays, HandError> {
        let bytes = super::sources::bytes(&self.mano_file).map_err(|problem| HandError::Mano {
            file: self.mano_file.display().to_string(),
            problem: format!(
                "cannot be read ({problem}); MANO's licence forbids storing it in files of grasps: name your copy with \
                 --hand"
            ),
        })?;
        if hash(&bytes) != self.hash {
            return Err(HandError::Mano {
                file: self.mano_file.display().to_string(),
                problem: "is not the file that was described: name the right one with --hand"
                    .to_owned(),
            });
        }
        let file = self.mano_file.display().to_string();
        Arrays::read(&file, &bytes).map_err(|problem| HandError::Mano { file, problem })
    }
}

impl Arrays {
    /// An error is half a sentence.
    fn read(file: &str, bytes: &[u8]) -> Result<Self, String> {
        let mut arrays = npz::read(bytes)?;
        let vertices = numbers(&mut arrays, "v_template", &[None, Some(3)])?;
        let count = vertices.shape[0];
        let triangles = take(&mut arrays, "f", &[None, Some(3)])?;
        let shapes = numbers(&mut arrays, "shapedirs", &[Some(count), Some(3), None])?;
        let poses = numbers(
            &mut arrays,
            "posedirs",
            &[Some(count), Some(3), Some(ENTRIES)],
        )?;
        let regressor = numbers(&mut arrays, "J_regressor", &[Some(LINKS), Some(count)])?;
        let weights = numbers(&mut arrays, "weights", &[Some(count), Some(LINKS)])?;
        let tree = take(&mut arrays, "kintree_table", &[Some(2), Some(LINKS)])?;
        let components = numbers(
            &mut arrays,
            "hands_components",
            &[Some(ANGLES), Some(ANGLES)],
        )?;
        let mean = numbers(&mut arrays, "hands_mean", &[Some(ANGLES)])?;
        let coefficients = numbers(&mut arrays, "hands_coeffs", &[None, Some(ANGLES)])?;
        let mut tree = tree.values[1..LINKS].iter().zip(PARENTS);
        if !tree.all(|(found, parent)| (found - parent as f64).abs() < 0.5) {
            return Err(
                "has a tree of joints (`kintree_table`) that differs from MANO's".to_owned(),
            );
        }
        let directions = |array: &Numbers| -> Vec<DMatrix<f64>> {
            let columns = array.shape[2];
            let of_vertex = array.values.chunks_exact((3 * columns).max(1));
            of_vertex
                .map(|rows| DMatrix::from_row_slice(3, columns, rows))
                .collect()
        };
        let matrix = |array: &Numbers| {
            DMatrix::from_row_slice(array.shape[0], array.shape[1], &array.values)
        };
        Ok(Self {
            file: file.to_owned(),
            template: vertices
                .values
                .chunks_exact(3)
                .map(Vector3::from_column_slice)
                .collect(),
            triangles: corners(&triangles.values, count)?,
            shape_directions: if shapes.shape[2] == 0 {
                vec![DMatrix::zeros(3, 0); count]
            } else {
                directions(&shapes)
            },
            pose_directions: directions(&poses),
            regressor: matrix(&regressor),
            weights: normalised(matrix(&weights))?,
            components: matrix(&components),
            mean_rad: DVector::from_vec(mean.values),
            coefficients: matrix(&coefficients),
        })
    }
}

/// As [`take`], for numbers within their limit.
fn numbers(
    arrays: &mut BTreeMap<String, Numbers>,
    name: &str,
    shape: &[Option<usize>],
) -> Result<Numbers, String> {
    let array = take(arrays, name, shape)?;
    let mut values = array.values.iter();
    values
        .try_for_each(|value| MANO_NUMBER.check(*value))
        .map_err(|beyond| format!("has a number out of range in `{name}`: {beyond}"))?;
    Ok(array)
}

/// Takes an array of this shape; `None` means any length.
fn take(
    arrays: &mut BTreeMap<String, Numbers>,
    name: &str,
    shape: &[Option<usize>],
) -> Result<Numbers, String> {
    let array = arrays.remove(name).ok_or_else(|| {
        format!("has no array of numbers `{name}`: export it as docs/mano.md shows")
    })?;
    let fits = array.shape.len() == shape.len()
        && (array.shape.iter().zip(shape))
            .all(|(side, wanted)| wanted.is_none_or(|wanted| wanted == *side));
    if !fits {
        let wanted: Vec<String> = (shape.iter())
            .map(|side| side.map_or("n".to_owned(), |side| side.to_string()))
            .collect();
        return Err(format!(
            "has an array `{name}` of shape {:?} where ({}) is needed",
            array.shape,
            wanted.join(", ")
        ));
    }
    Ok(array)
}

fn corners(values: &[f64], vertices: usize) -> Result<Vec<[u32; 3]>, String> {
    let index = |&value: &f64| {
        let known = value >= 0.0 && value < vertices as f64 && value.fract() == 0.0;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number below the count of vertices"
        )]
        known.then_some(value as u32)
    };
    let corners: Option<Vec<u32>> = values.iter().map(index).collect();
    let corners = corners.ok_or("has a face (`f`) with a vertex that does not exist")?;
    Ok(corners
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .collect())
}

/// Divides the weights of each vertex by their sum, which must be nearly 1.
fn normalised(mut weights: DMatrix<f64>) -> Result<DMatrix<f64>, String> {
    for mut row in weights.row_iter_mut() {
        let sum = row.sum();
        if row.min() < 0.0 || (sum - 1.0).abs() > 1e-3 {
            return Err(
                "has skinning weights (`weights`) that are negative or do not sum to 1".to_owned(),
            );
        }
        row /= sum;
    }
    Ok(weights)
}
