//! A synthetic file with the keys and shapes of the real MANO file.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use landscape::sample::{Task, stream};
use nalgebra::{DMatrix, Matrix3, Matrix4, Rotation3, Vector3};
use rand::RngExt;
use zip::CompressionMethod;

const VERTICES: usize = 778;
const LINKS: usize = 16;
const PARENTS: [usize; 15] = [0, 1, 2, 0, 4, 5, 0, 7, 8, 0, 10, 11, 0, 13, 14];
pub(crate) const POSES: usize = 60;

/// The arrays of the synthetic file.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub(crate) template: Vec<f64>,
    pub(crate) faces: Vec<u32>,
    pub(crate) shapes: Vec<f64>,
    pub(crate) poses: Vec<f64>,
    pub(crate) regressor: Vec<f64>,
    pub(crate) weights: Vec<f64>,
    pub(crate) components: DMatrix<f64>,
    pub(crate) mean: Vec<f64>,
    pub(crate) coefficients: Vec<f64>,
}

/// Start and tip of each joint's bone: fingers along −x, side by side in z, the palm facing −y.
fn bones() -> Vec<[Vector3<f64>; 2]> {
    let mut bones = vec![[Vector3::new(0.05, 0.0, 0.0), Vector3::new(-0.03, 0.0, 0.0)]];
    for (side, length) in [(0.03, 1.0), (0.01, 1.1), (-0.032, 0.8), (-0.011, 1.0)] {
        let mut at = Vector3::new(-0.04, 0.0, side);
        for bone in [0.04, 0.028, 0.022] {
            let next = at - Vector3::x() * bone * length;
            bones.push([at, next]);
            at = next;
        }
    }
    let mut at = Vector3::new(0.02, -0.01, 0.035);
    for bone in [0.04, 0.033, 0.027] {
        let next = at + Vector3::new(-0.6, -0.35, 0.72).normalize() * bone;
        bones.push([at, next]);
        at = next;
    }
    bones
}

impl Model {
    /// Tubes around bones with smooth weights along them; everything else is small and random.
    pub(crate) fn new() -> Self {
        let bones = bones();
        let mut rng = stream(11, Task::Start, 0);
        let mut noise = |scale: f64| rng.random_range(-scale..scale);
        let (mut template, mut faces, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        for (l, [a, b]) in bones.iter().enumerate() {
            let (rings, radius) = if l == 0 {
                (7, [0.012, 0.04])
            } else {
                (6, [0.008, 0.008])
            };
            let along = (b - a).normalize();
            let across = along.cross(&Vector3::y()).normalize();
            let third = along.cross(&across);
            let first = u32::try_from(template.len() / 3).unwrap();
            for ring in 0..rings {
                let share = f64::from(ring) / f64::from(rings - 1);
                let narrow = 1.0 - 0.3 * (2.0 * share - 1.0).powi(2);
                for corner in 0..8 {
                    let (sin, cos) = libm::sincos(std::f64::consts::FRAC_PI_4 * f64::from(corner));
                    let out = across * (cos * radius[1]) + third * (sin * radius[0]);
                    template.extend((a.lerp(b, share) + out * narrow).iter());
                    owners.push((l, share));
                }
            }
            let at = |ring: u32, corner: u32| first + 8 * ring + corner % 8;
            for ring in 0..rings - 1 {
                for corner in 0..8 {
                    let [p, q] = [at(ring, corner), at(ring, corner + 1)];
                    let [r, s] = [at(ring + 1, corner), at(ring + 1, corner + 1)];
                    faces.extend([p, q, s, p, s, r]);
                }
            }
            for corner in 1..7 {
                faces.extend([at(0, 0), at(0, corner + 1), at(0, corner)]);
                faces.extend([
                    at(rings - 1, 0),
                    at(rings - 1, corner),
                    at(rings - 1, corner + 1),
                ]);
            }
        }
        // Two more, on no face.
        while template.len() < 3 * VERTICES {
            template.extend([0.05, 0.0, 0.0]);
            owners.push((0, 0.0));
        }
        let mut weights = vec![0.0; VERTICES * LINKS];
        for (row, (l, share)) in weights.chunks_exact_mut(LINKS).zip(&owners) {
            let blend = 0.5 * (1.0 - share).powi(3);
            row[*l] += 1.0;
            if let Some(ball) = l.checked_sub(1) {
                row[*l] -= blend;
                row[PARENTS[ball]] += blend;
            }
        }
        // Each joint is the middle of the first ring of its link.
        let mut regressor = vec![0.0; LINKS * VERTICES];
        for (l, row) in regressor.chunks_exact_mut(VERTICES).enumerate() {
            let own = owners.iter().position(|(owner, _)| *owner == l).unwrap();
            row[own..own + 8].fill(0.125);
        }
        let square = DMatrix::from_fn(45, 45, |_, _| noise(1.0));
        let components = square.qr().q();
        let mean = (0..45)
            .map(|k| {
                if k % 3 == 2 && k < 36 {
                    0.25
                } else {
                    noise(0.05)
                }
            })
            .collect();
        let coefficients = (0..POSES * 45)
            .map(|k| noise(1.2 / (1.0 + (k % 45) as f64).sqrt()))
            .collect();
        Self {
            shapes: (0..VERTICES * 30).map(|_| noise(1e-3)).collect(),
            poses: (0..VERTICES * 405).map(|_| noise(3e-4)).collect(),
            template,
            faces,
            regressor,
            weights,
            components,
            mean,
            coefficients,
        }
    }

    /// The file in the form of `numpy.savez`.
    pub(crate) fn npz(&self) -> Vec<u8> {
        self.packed(CompressionMethod::Stored)
    }

    pub(crate) fn packed(&self, method: CompressionMethod) -> Vec<u8> {
        let mut tree = vec![f64::from(u32::MAX)];
        tree.extend(PARENTS.map(|parent| parent as f64));
        tree.extend((0..LINKS).map(|link| link as f64));
        let floats = |values: &[f64]| {
            values
                .iter()
                .flat_map(|x| x.to_le_bytes())
                .collect::<Vec<u8>>()
        };
        #[expect(clippy::cast_possible_truncation, reason = "small whole numbers")]
        let wholes = |values: &[f64]| {
            values
                .iter()
                .flat_map(|x| (*x as i64).to_le_bytes())
                .collect::<Vec<u8>>()
        };
        let faces = self
            .faces
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect::<Vec<u8>>();
        let rows = self.components.transpose();
        let arrays = [
            (
                "v_template",
                "<f8",
                vec![VERTICES, 3],
                floats(&self.template),
            ),
            ("f", "<u4", vec![self.faces.len() / 3, 3], faces),
            (
                "shapedirs",
                "<f8",
                vec![VERTICES, 3, 10],
                floats(&self.shapes),
            ),
            (
                "posedirs",
                "<f8",
                vec![VERTICES, 3, 135],
                floats(&self.poses),
            ),
            (
                "J_regressor",
                "<f8",
                vec![LINKS, VERTICES],
                floats(&self.regressor),
            ),
            (
                "weights",
                "<f8",
                vec![VERTICES, LINKS],
                floats(&self.weights),
            ),
            ("kintree_table", "<i8", vec![2, LINKS], wholes(&tree)),
            (
                "hands_components",
                "<f8",
                vec![45, 45],
                floats(rows.as_slice()),
            ),
            ("hands_mean", "<f8", vec![45], floats(&self.mean)),
            (
                "hands_coeffs",
                "<f8",
                vec![POSES, 45],
                floats(&self.coefficients),
            ),
        ];
        archive(
            arrays
                .iter()
                .map(|(name, kind, shape, data)| (*name, npy(kind, shape, data))),
            method,
        )
    }

    /// Vertices by the formula, with 4 × 4 matrices, for the angles of all joints; and the joints.
    pub(crate) fn vertices(&self, betas: &[f64], angles: &[f64]) -> Vec<Vector3<f64>> {
        let shaped: Vec<f64> = (self.template.iter().zip(self.shapes.chunks_exact(10)))
            .map(|(x, shapes)| x + shapes.iter().zip(betas).map(|(s, b)| s * b).sum::<f64>())
            .collect();
        let joint = |l: usize| {
            let row = &self.regressor[l * VERTICES..(l + 1) * VERTICES];
            let parts = row.iter().zip(shaped.chunks_exact(3));
            parts
                .map(|(w, v)| Vector3::from_column_slice(v) * *w)
                .sum::<Vector3<f64>>()
        };
        let turned: Vec<Matrix3<f64>> = (angles.chunks_exact(3))
            .map(|a| *Rotation3::new(Vector3::from_column_slice(a)).matrix())
            .collect();
        let mut feature = Vec::new();
        for rotation in &turned {
            let less = rotation - Matrix3::identity();
            feature.extend((0..9).map(|k| less[(k / 3, k % 3)]));
        }
        let mut global: Vec<Matrix4<f64>> = vec![Matrix4::new_translation(&joint(0))];
        for (ball, &parent) in PARENTS.iter().enumerate() {
            let local = Matrix4::new_translation(&(joint(ball + 1) - joint(parent)))
                * turned[ball].to_homogeneous();
            global.push(global[parent] * local);
        }
        let moves: Vec<Matrix4<f64>> = (0..LINKS)
            .map(|l| global[l] * Matrix4::new_translation(&-joint(l)))
            .collect();
        (0..VERTICES)
            .map(|v| {
                let at = |axis: usize| {
                    let row = &self.poses[(3 * v + axis) * 135..(3 * v + axis + 1) * 135];
                    shaped[3 * v + axis] + row.iter().zip(&feature).map(|(p, f)| p * f).sum::<f64>()
                };
                let point = Vector3::new(at(0), at(1), at(2)).push(1.0);
                let weights = &self.weights[v * LINKS..(v + 1) * LINKS];
                let sum = moves
                    .iter()
                    .zip(weights)
                    .fold(Matrix4::zeros(), |sum, (m, w)| sum + m * *w);
                (sum * point).xyz()
            })
            .collect()
    }

    /// Vertices in the order of the hand's surface points: grouped by the link with the greatest weight.
    pub(crate) fn order(&self) -> Vec<usize> {
        let strongest = |v: &usize| {
            let row = &self.weights[v * LINKS..(v + 1) * LINKS];
            (0..LINKS)
                .rev()
                .max_by(|&a, &b| row[a].total_cmp(&row[b]))
                .unwrap()
        };
        let mut order: Vec<usize> = (0..VERTICES).collect();
        order.sort_by_key(strongest);
        order
    }
}

pub(crate) fn npy(kind: &str, shape: &[usize], data: &[u8]) -> Vec<u8> {
    let mut sides = String::new();
    for side in shape {
        let _ = write!(sides, "{side}, ");
    }
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({sides}), }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

pub(crate) fn archive<'a>(
    arrays: impl Iterator<Item = (&'a str, Vec<u8>)>,
    method: CompressionMethod,
) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (name, bytes) in arrays {
        archive.start_file(format!("{name}.npy"), options).unwrap();
        archive.write_all(&bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}
