//! Three contacts at the corners of a triangle, for which balance is a planar problem.
//!
//! The torque about each side of the triangle must vanish, and only the force of the third corner across the plane has such
//! a torque. So balanced forces lie in the plane of the triangle, and they are concurrent or parallel. In that plane a
//! contact with inward normal c = r p̂ + s n̂ (p̂ in the plane, n̂ across it, r² + s² = 1) may push with p̂ + t p̂⊥, where
//!
//! ```text
//! |t| ≤ √(r²μ² − s²),   not at all if rμ < |s|
//! ```
//!
//! The two edges of each of the three wedges are six planar wrenches in ℝ³. The three contacts can balance unless a
//! half-space contains all six, that is, a plane through two of them has the other four on one side.

use std::array::from_fn;

use nalgebra::{Vector2, Vector3};

use super::PointContact;

/// Relative height below which a triangle counts as a line, for which forces need not be coplanar.
const FLATNESS: f64 = 1e-9;

/// Depths (of unit forces) below this are rounding errors.
const ROUND_OFF: f64 = 4e-16;

pub(super) struct Triangle {
    corners: [Corner; 3],
}

#[derive(Clone, Copy)]
struct Corner {
    position: Vector2<f64>,
    /// p̂; zero if the inward normal is perpendicular to the plane.
    push: Vector2<f64>,
    /// r.
    in_plane: f64,
    /// |s|.
    across: f64,
}

impl Triangle {
    /// The triangle; `None` if the three points lie on a line.
    pub(super) fn of(contacts: &[PointContact; 3]) -> Option<Self> {
        let sides: [Vector3<f64>; 3] =
            from_fn(|i| contacts[(i + 2) % 3].arm - contacts[(i + 1) % 3].arm);
        let longest =
            (0..3).max_by(|&a, &b| sides[a].norm_squared().total_cmp(&sides[b].norm_squared()))?;
        let length = sides[longest].norm();
        let double_area = sides[(longest + 1) % 3].cross(&sides[(longest + 2) % 3]);
        if double_area.norm() <= FLATNESS * length * length {
            return None;
        }
        let normal = double_area.normalize();
        let along = sides[longest] / length;
        let axes = [along, normal.cross(&along)];
        let origin = contacts[longest].arm;
        let corners = contacts.map(|contact| {
            let from_origin = (contact.arm - origin) / length;
            let projected = Vector2::from(axes.map(|axis| contact.inward_normal.dot(&axis)));
            let in_plane = projected.norm();
            Corner {
                position: Vector2::from(axes.map(|axis| from_origin.dot(&axis))),
                push: projected.try_normalize(0.0).unwrap_or_default(),
                in_plane,
                across: contact.inward_normal.dot(&normal).abs(),
            }
        });
        Some(Self { corners })
    }

    /// The least friction at which every contact can push in the plane, max |s|/r.
    pub(super) fn friction_to_push(&self) -> f64 {
        self.corners.iter().fold(0.0, |worst: f64, corner| {
            worst.max(corner.across / corner.in_plane)
        })
    }

    /// For a friction at which all contacts can push: positive if forces do not balance, negative if they do; continuous.
    pub(super) fn imbalance(&self, friction: f64) -> f64 {
        let mut wrenches = [Vector3::zeros(); 6];
        for (corner, edges) in self.corners.iter().zip(wrenches.chunks_exact_mut(2)) {
            let reach = corner.in_plane * friction;
            let squared = ((reach - corner.across) * (reach + corner.across)).max(0.0);
            let along = (1.0 + squared).sqrt().recip();
            let push = corner.push * along;
            let sideways = Vector2::new(-push.y, push.x) * squared.sqrt();
            for (edge, force) in edges.iter_mut().zip([push - sideways, push + sideways]) {
                *edge = Vector3::new(force.x, force.y, corner.position.perp(&force));
            }
        }
        depth_in_a_half_space(&wrenches) - ROUND_OFF
    }
}

/// The greatest depth of all six vectors in a half-space bounded by a plane through two of them; negative outside all.
fn depth_in_a_half_space(vectors: &[Vector3<f64>; 6]) -> f64 {
    let mut deepest = f64::NEG_INFINITY;
    for i in 0..6 {
        for j in i + 1..6 {
            let normal = vectors[i].cross(&vectors[j]);
            let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
            for (k, vector) in vectors.iter().enumerate() {
                if k != i && k != j {
                    let height = normal.dot(vector);
                    lowest = lowest.min(height);
                    highest = highest.max(height);
                }
            }
            deepest = deepest.max(lowest).max(-highest);
        }
    }
    deepest
}
