//! The Vendi score, with a kernel on the surface of the hand.

use nalgebra::{DMatrix, Matrix3, Vector3};
use rayon::prelude::*;

use super::facts::MeasuredObject;
use crate::hand::PosedHand;
use crate::space::{Symmetry, object_from_hand};

/// The length ℓ of the kernel, metres: hands this far apart have a similarity of 0.61.
pub const KERNEL_LENGTH_M: f64 = 0.02;

/// Most points of the hand that the kernel compares.
const POINTS: usize = 128;

/// Turns about an axis of symmetry over which the kernel is averaged. At 6° a fingertip 20 cm off the axis moves by ℓ.
const TURNS: u32 = 64;

/// Similarities of grasps of one object, from 0 to 1.
///
/// ```text
/// k(x, y) = κ(x, y)/√(κ(x, x) κ(y, y)),   κ(x, y) = Σ_g exp(−d²(x, g y)/2ℓ²)
/// d²(x, y) = Σₚ aₚ |p(x) − p(y)|²/Σₚ aₚ
/// ```
///
/// p(x): surface points of the hand in the pose x, object frame; aₚ: their areas; g: the motions that map the object on to
/// itself. d is the distance that the metric of poses approximates for small motions. A Gaussian of distances between points
/// of a Euclidean space is positive definite, and so is its mean over a group. The group of an axis is replaced by 64 turns.
/// For a ball, the hand's own frame about the centre is compared instead, which no turn of the ball changes.
pub(super) struct Kernel {
    /// The place of each grasp in the matrix; `None` if it was left out.
    rows: Vec<Option<usize>>,
    matrix: DMatrix<f64>,
}

/// The surface of a hand: points times the roots of their shares of the area.
struct Surface {
    points: Vec<Vector3<f64>>,
    /// Mean of the squares.
    squared: f64,
    mean: Vector3<f64>,
}

/// A motion of the object on to itself.
struct Motion {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Kernel {
    /// Compares the grasps with the given numbers.
    pub(super) fn of(object: &MeasuredObject, grasps: &[usize]) -> Self {
        let surfaces: Vec<Surface> = (grasps.par_iter())
            .map(|grasp| Surface::of(object, &object.grasps[*grasp].pose))
            .collect();
        let group = motions(object.space.symmetry());
        let own: Vec<f64> = surfaces
            .par_iter()
            .map(|a| similarity(a, a, &group))
            .collect();
        let row = |i: usize| -> Vec<f64> {
            let to = |j: usize| {
                similarity(&surfaces[i], &surfaces[j], &group) / (own[i] * own[j]).sqrt()
            };
            (0..i).map(to).collect()
        };
        let lower: Vec<Vec<f64>> = (0..grasps.len()).into_par_iter().map(row).collect();
        let mut matrix = DMatrix::identity(grasps.len(), grasps.len());
        for (i, row) in lower.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                matrix[(i, j)] = *value;
                matrix[(j, i)] = *value;
            }
        }
        let mut rows = vec![None; object.grasps.len()];
        for (row, grasp) in grasps.iter().enumerate() {
            rows[*grasp] = Some(row);
        }
        Self { rows, matrix }
    }

    /// The Vendi score of grasps, with repetition; `None` if there are none.
    ///
    /// ```text
    /// VS = exp(−Σ λ ln λ),   λ: eigenvalues of √(pᵢ pⱼ) k(i, j)
    /// ```
    ///
    /// p: share of each of the different grasps, which gives the same as all grasps with equal shares.
    pub(super) fn vendi(&self, grasps: &[usize]) -> Option<f64> {
        let mut counts = vec![0usize; self.matrix.nrows()];
        for row in grasps.iter().filter_map(|grasp| self.rows[*grasp]) {
            counts[row] += 1;
        }
        let total: usize = counts.iter().sum();
        let met: Vec<usize> = (0..counts.len()).filter(|row| counts[*row] > 0).collect();
        if met.is_empty() {
            return None;
        }
        let root = |row: usize| (counts[row] as f64 / total as f64).sqrt();
        let weighted = DMatrix::from_fn(met.len(), met.len(), |i, j| {
            self.matrix[(met[i], met[j])] * root(met[i]) * root(met[j])
        });
        let mut shares: Vec<f64> = weighted.symmetric_eigenvalues().iter().copied().collect();
        shares.sort_by(f64::total_cmp);
        let positive = shares.into_iter().filter(|share| *share > 0.0);
        let entropy: f64 = positive.map(|share| -share * libm::log(share)).sum();
        Some(libm::exp(entropy))
    }
}

impl Surface {
    fn of(object: &MeasuredObject, pose: &[f64]) -> Self {
        let hand = &object.hand;
        let mut posed = PosedHand::default();
        hand.pose(pose, &mut posed);
        let step = hand.surface.len().div_ceil(POINTS).max(1);
        let chosen = || (posed.points.iter().zip(&hand.surface)).step_by(step);
        let area: f64 = chosen().map(|(_, point)| point.area_m2).sum();
        let centre = match object.space.symmetry() {
            Symmetry::Sphere { centre } => Some(centre),
            _ => None,
        };
        let turned = object_from_hand(pose).rotation;
        let place = |point: &Vector3<f64>| match centre {
            Some(centre) => turned.inverse_transform_vector(&(point - centre)),
            None => *point,
        };
        let (mut squared, mut mean) = (0.0, Vector3::zeros());
        let points = chosen().map(|(point, surface)| {
            let share = surface.area_m2 / area;
            let place = place(point);
            squared += share * place.norm_squared();
            mean += place * share;
            place * share.sqrt()
        });
        Self {
            points: points.collect(),
            squared,
            mean,
        }
    }
}

/// κ of two hands.
fn similarity(a: &Surface, b: &Surface, group: &[Motion]) -> f64 {
    let mut moment = Matrix3::zeros();
    for (a, b) in a.points.iter().zip(&b.points) {
        moment += a * b.transpose();
    }
    let of = |motion: &Motion| {
        let Motion {
            rotation,
            translation,
        } = motion;
        let moved = rotation * b.mean;
        let squared = b.squared + 2.0 * translation.dot(&moved) + translation.norm_squared();
        let product = rotation.component_mul(&moment).sum() + translation.dot(&a.mean);
        let distance_squared = (a.squared + squared - 2.0 * product).max(0.0);
        libm::exp(-distance_squared / (2.0 * KERNEL_LENGTH_M * KERNEL_LENGTH_M))
    };
    group.iter().map(of).sum()
}

/// The motions of a symmetry, the identity first.
fn motions(symmetry: &Symmetry) -> Vec<Motion> {
    let mut motions = vec![Motion {
        rotation: Matrix3::identity(),
        translation: Vector3::zeros(),
    }];
    match symmetry {
        Symmetry::None | Symmetry::Sphere { .. } => {}
        Symmetry::Axis { point, direction } => {
            let axis = direction.normalize();
            let (across, along) = (axis.cross_matrix(), axis * axis.transpose());
            motions.extend((1..TURNS).map(|turn| {
                let angle = std::f64::consts::TAU * f64::from(turn) / f64::from(TURNS);
                let (sine, cosine) = libm::sincos(angle);
                let rotation =
                    Matrix3::identity() * cosine + across * sine + along * (1.0 - cosine);
                Motion {
                    rotation,
                    translation: point - rotation * point,
                }
            }));
        }
        Symmetry::Finite(group) => {
            // The identity may be listed or left out, and it counts once.
            let moves = group.iter().filter(|motion| {
                motion.rotation.angle() > 1e-6 || motion.translation.vector.norm() > 1e-9
            });
            motions.extend(moves.map(|motion| Motion {
                rotation: motion.rotation.to_rotation_matrix().into_inner(),
                translation: motion.translation.vector,
            }));
        }
    }
    motions
}
