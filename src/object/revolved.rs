//! The smooth signed-distance field of a solid of revolution: a bi-cubic B-spline over radius and height.
//!
//! Neither a grid in space nor the facets of a mesh are exactly symmetric about an axis. Grasps that differ by a rotation
//! about the axis are the same grasp, so their energies must be equal. Two coordinates are also cheaper than three.

use nalgebra::{Matrix3, Unit, Vector3};
use rayon::prelude::*;

use super::Shape;
use super::field::{self, FieldReport};
use super::spline::{RIM, Weights, dot, solve_lines};
use crate::mesh::{ExactMesh, Mesh};

/// Cell, margin around the object and blending shell (part of the margin) of the grids, metres. They are like those of
/// [`Field`](super::Field) but finer, since two dimensions cost little.
const LEVELS: [[f64; 3]; 3] = [
    [0.75e-3, 0.034, 0.012],
    [0.004, 0.2, 0.08],
    [0.04, 2.0, 1.0],
];
/// Directions about the axis over which distances to the mesh are averaged. Their differences are not simple fractions of a
/// turn, so that they meet facets at different places.
const TURNS_RAD: [f64; 4] = [0.1, 1.7, 3.2, 4.9];
/// Number of nodes beyond the axis, enough that the boundary condition of the grid has no effect at the axis.
const BEYOND_AXIS: usize = 16;

/// A smooth signed-distance field with rotational symmetry about an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Revolved {
    point: Vector3<f64>,
    axis: Unit<Vector3<f64>>,
    levels: Vec<Level>,
    /// Height of the centre on the axis, and the radius, of the ball that gives the distance beyond all grids.
    ball: [f64; 2],
    report: FieldReport,
}

/// One grid over radius and height. It is used up to its border and blended with the next over a shell inside it.
#[derive(Debug, Clone, PartialEq)]
struct Level {
    low: f64,
    high: f64,
    outer: f64,
    shell_m: f64,
    cell_m: f64,
    /// Height of the first node.
    origin: f64,
    /// Nodes along radius and height.
    nodes: [usize; 2],
    /// Coefficients, height varying fastest.
    coefficients: Vec<f32>,
}

/// Value and derivatives along radius and height.
#[derive(Debug, Clone, Copy, Default)]
struct Profile {
    value: f64,
    r: f64,
    z: f64,
    rr: f64,
    rz: f64,
    zz: f64,
}

impl Profile {
    /// `far + weight·(near − far)` and its derivatives.
    fn blend(weight: &Self, near: &Self, far: &Self) -> Self {
        let gap = Self {
            value: near.value - far.value,
            r: near.r - far.r,
            z: near.z - far.z,
            rr: near.rr - far.rr,
            rz: near.rz - far.rz,
            zz: near.zz - far.zz,
        };
        let w = weight;
        Self {
            value: far.value + w.value * gap.value,
            r: far.r + w.value * gap.r + w.r * gap.value,
            z: far.z + w.value * gap.z + w.z * gap.value,
            rr: far.rr + w.value * gap.rr + 2.0 * w.r * gap.r + w.rr * gap.value,
            rz: far.rz + w.value * gap.rz + w.r * gap.z + w.z * gap.r + w.rz * gap.value,
            zz: far.zz + w.value * gap.zz + 2.0 * w.z * gap.z + w.zz * gap.value,
        }
    }
}

impl Revolved {
    /// Bakes the field of a mesh that is symmetric about the axis through `point` along `axis`, in a fraction of a second.
    ///
    /// # Panics
    /// Never: there is always an outermost grid.
    pub fn bake(mesh: &Mesh, exact: &ExactMesh, point: &Vector3<f64>, axis: &Vector3<f64>) -> Self {
        let axis = Unit::new_normalize(*axis);
        let (mut low, mut high, mut radius) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
        for vertex in mesh.vertices() {
            let arm = vertex - point;
            let height = arm.dot(&axis);
            low = low.min(height);
            high = high.max(height);
            radius = radius.max((arm - axis.into_inner() * height).norm());
        }
        let mut helper = Vector3::zeros();
        helper[axis.iamin()] = 1.0;
        let first = axis.cross(&helper).normalize();
        let second = axis.cross(&first);
        let spokes =
            TURNS_RAD.map(|turn_rad| first * libm::cos(turn_rad) + second * libm::sin(turn_rad));
        let levels: Vec<Level> = LEVELS
            .map(|level| {
                Level::sample(level, [low, high, radius], |r, z| {
                    let distance = |spoke: &Vector3<f64>| {
                        exact.distance(&(point + axis.into_inner() * z + spoke * r))
                    };
                    spokes.iter().map(distance).sum::<f64>() / spokes.len() as f64
                })
            })
            .to_vec();
        let outermost = levels.last().expect("levels are listed above");
        let mut field = Self {
            point: *point,
            axis,
            ball: outermost.ball(),
            report: FieldReport {
                cell_m: levels[0].cell_m,
                nodes: levels.iter().map(|level| level.coefficients.len()).sum(),
                max_error_m: 0.0,
                max_error_anywhere_m: 0.0,
                lipschitz: 1.0,
            },
            levels,
        };
        field.report.lipschitz = field.steepest();
        (field.report.max_error_m, field.report.max_error_anywhere_m) =
            field::errors(&field, field.report.cell_m, mesh, exact);
        field
    }

    /// Size of the field and its accuracy.
    pub fn report(&self) -> &FieldReport {
        &self.report
    }

    /// Radius, height and the direction away from the axis (zero on it).
    #[inline]
    fn place(&self, point: &Vector3<f64>) -> (f64, f64, Vector3<f64>) {
        let arm = point - self.point;
        let height = arm.dot(&self.axis);
        let away = arm - self.axis.into_inner() * height;
        let radius = away.norm();
        let outward = if radius > 0.0 {
            away / radius
        } else {
            Vector3::zeros()
        };
        (radius, height, outward)
    }

    #[inline]
    fn profile<const ORDER: usize>(&self, r: f64, z: f64) -> Profile {
        let finest = &self.levels[0];
        if finest.holds_alone(r, z) {
            finest.profile::<ORDER>(r, z)
        } else {
            self.profile_beyond::<ORDER>(r, z, 0)
        }
    }

    #[inline(never)]
    fn profile_beyond<const ORDER: usize>(&self, r: f64, z: f64, level: usize) -> Profile {
        let Some(here) = self.levels.get(level) else {
            let [centre, radius] = self.ball;
            let height = z - centre;
            let length = libm::hypot(r, height);
            let (er, ez) = (r / length, height / length);
            return Profile {
                value: length - radius,
                r: er,
                z: ez,
                rr: ez * ez / length,
                rz: -er * ez / length,
                zz: er * er / length,
            };
        };
        if here.holds_alone(r, z) {
            return here.profile::<ORDER>(r, z);
        }
        let beyond = self.profile_beyond::<ORDER>(r, z, level + 1);
        match here.weight(r, z) {
            Some(weight) => Profile::blend(&weight, &here.profile::<ORDER>(r, z), &beyond),
            None => beyond,
        }
    }

    /// Largest gradient outside the solid at nodes and cell centres, with a small margin for the points between them.
    fn steepest(&self) -> f64 {
        const HEADROOM: f64 = 1.01;
        let of_level = |level: &Level| {
            let slope = |row: usize, k: usize, shift: f64| {
                let r = (row as f64 + shift) * level.cell_m;
                let z = level.origin + (k as f64 + shift) * level.cell_m;
                let profile = self.profile::<1>(r, z);
                if profile.value > -0.5 * level.cell_m {
                    libm::hypot(profile.r, profile.z)
                } else {
                    0.0
                }
            };
            (0..level.nodes[0] - BEYOND_AXIS)
                .into_par_iter()
                .map(|row| {
                    (0..level.nodes[1]).fold(0.0, |steepest: f64, k| {
                        steepest.max(slope(row, k, 0.0)).max(slope(row, k, 0.5))
                    })
                })
                .reduce(|| 0.0, f64::max)
        };
        self.levels.iter().map(of_level).fold(1.0, f64::max) * HEADROOM
    }
}

impl Shape for Revolved {
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        let (r, z, _) = self.place(point);
        self.profile::<0>(r, z).value
    }

    fn gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let (r, z, outward) = self.place(point);
        let profile = self.profile::<1>(r, z);
        (
            profile.value,
            outward * profile.r + self.axis.into_inner() * profile.z,
        )
    }

    fn hessian(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
        /// Below this radius, metres, the slope divided by the radius equals its limit, the curvature, to all relevant
        /// digits.
        const ON_AXIS_M: f64 = 1e-7;
        let (r, z, outward) = self.place(point);
        let profile = self.profile::<2>(r, z);
        let axis = self.axis.into_inner();
        let around = if r > ON_AXIS_M {
            profile.r / r
        } else {
            profile.rr
        };
        // The second derivative is `around` across the plane of the axis and the point, and that of the profile within it.
        let by_outward = outward * (profile.rr - around) + axis * profile.rz;
        let by_axis = axis * (profile.zz - around) + outward * profile.rz;
        let hessian = Matrix3::from_fn(|i, j| {
            let diagonal = if i == j { around } else { 0.0 };
            outward[i] * by_outward[j] + axis[i] * by_axis[j] + diagonal
        });
        (
            profile.value,
            outward * profile.r + axis * profile.z,
            hessian,
        )
    }

    fn lipschitz(&self) -> f64 {
        self.report.lipschitz
    }
}

impl Level {
    /// Interpolates `distance(radius, height)` around a solid between heights low and high within a radius.
    fn sample(
        [cell_m, margin_m, shell_m]: [f64; 3],
        [low, high, radius]: [f64; 3],
        distance: impl Fn(f64, f64) -> f64 + Sync,
    ) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small positive count"
        )]
        let cells = |extent: f64| (extent / cell_m).ceil() as usize;
        let (low, high, outer) = (low - margin_m, high + margin_m, radius + margin_m);
        let nodes = [
            BEYOND_AXIS + cells(outer) + RIM + 1,
            cells(high - low) + 2 * RIM + 1,
        ];
        let origin = low - cell_m * RIM as f64;
        // Samples from the axis outward are mirrored beyond the axis.
        let half: Vec<Vec<f64>> = (0..nodes[0] - BEYOND_AXIS)
            .into_par_iter()
            .map(|i| {
                let height = |k: usize| origin + k as f64 * cell_m;
                (0..nodes[1])
                    .map(|k| distance(i as f64 * cell_m, height(k)))
                    .collect()
            })
            .collect();
        let mut values: Vec<f64> = (0..nodes[0])
            .flat_map(|row| half[row.abs_diff(BEYOND_AXIS)].iter().copied())
            .collect();
        values
            .par_chunks_mut(nodes[1])
            .for_each(|row| solve_lines(row, 1));
        solve_lines(&mut values, nodes[1]);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "rounding to single precision is meant"
        )]
        let coefficients = (0..nodes[0])
            .flat_map(|row| {
                let row = BEYOND_AXIS + row.abs_diff(BEYOND_AXIS);
                values[row * nodes[1]..(row + 1) * nodes[1]]
                    .iter()
                    .map(|value| *value as f32)
            })
            .collect();
        Self {
            low,
            high,
            outer,
            shell_m,
            cell_m,
            origin,
            nodes,
            coefficients,
        }
    }

    #[inline]
    fn profile<const ORDER: usize>(&self, r: f64, z: f64) -> Profile {
        let inverse_cell = 1.0 / self.cell_m;
        let along = r * inverse_cell + BEYOND_AXIS as f64;
        let x = Weights::at::<ORDER>(along, self.nodes[0], inverse_cell);
        let y = Weights::at::<ORDER>(
            (z - self.origin) * inverse_cell,
            self.nodes[1],
            inverse_cell,
        );
        let row = |i: usize| -> [f64; 4] {
            let start = (x.first + i) * self.nodes[1] + y.first;
            let row: &[f32; 4] = self.coefficients[start..start + 4]
                .try_into()
                .expect("four coefficients");
            row.map(f64::from)
        };
        let [a, b, c, d] = [row(0), row(1), row(2), row(3)];
        let sum = |w: &[f64; 4]| -> [f64; 4] {
            std::array::from_fn(|k| (w[0] * a[k] + w[1] * b[k]) + (w[2] * c[k] + w[3] * d[k]))
        };
        let values = sum(&x.value);
        let mut profile = Profile {
            value: dot(&values, &y.value),
            ..Profile::default()
        };
        if ORDER >= 1 {
            let slopes = sum(&x.slope);
            profile.r = dot(&slopes, &y.value);
            profile.z = dot(&values, &y.slope);
            if ORDER >= 2 {
                profile.rr = dot(&sum(&x.bend), &y.value);
                profile.rz = dot(&slopes, &y.slope);
                profile.zz = dot(&values, &y.bend);
            }
        }
        profile
    }

    #[inline]
    fn holds_alone(&self, r: f64, z: f64) -> bool {
        r <= self.outer - self.shell_m
            && z >= self.low + self.shell_m
            && z <= self.high - self.shell_m
    }

    /// Weight of this level: one inside the shell, `None` (zero) outside the border, C² between.
    fn weight(&self, r: f64, z: f64) -> Option<Profile> {
        let step = |inside: f64, inward: f64| {
            let t = inside / self.shell_m;
            if t <= 0.0 {
                return None;
            }
            if t >= 1.0 {
                return Some([1.0, 0.0, 0.0]);
            }
            let s = 1.0 - t;
            let by = inward / self.shell_m;
            Some([
                t * t * t * (10.0 - 15.0 * t + 6.0 * t * t),
                30.0 * t * t * s * s * by,
                60.0 * t * s * (s - t) * by * by,
            ])
        };
        let (above, below) = (z - self.low, self.high - z);
        let a = step(self.outer - r, -1.0)?;
        let b = step(above.min(below), if above < below { 1.0 } else { -1.0 })?;
        Some(Profile {
            value: a[0] * b[0],
            r: a[1] * b[0],
            z: a[0] * b[1],
            rr: a[2] * b[0],
            rz: a[1] * b[1],
            zz: a[0] * b[2],
        })
    }

    /// The ball whose distance agrees on average with this level in the middle of its shell.
    fn ball(&self) -> [f64; 2] {
        let centre = f64::midpoint(self.low, self.high);
        let reach = (self.high - self.low - self.shell_m) / 2.0;
        let out = self.outer - self.shell_m / 2.0;
        let gaps = [
            reach - self.profile::<0>(0.0, centre + reach).value,
            reach - self.profile::<0>(0.0, centre - reach).value,
            out - self.profile::<0>(out, centre).value,
        ];
        [centre, gaps.iter().sum::<f64>() / gaps.len() as f64]
    }
}

#[cfg(test)]
mod tests {
    use super::super::Object;
    use super::*;
    use crate::space::Symmetry;

    #[test]
    fn it_is_smooth_across_its_axis() {
        let object = Object::named("bottle_round").unwrap();
        let Symmetry::Axis { point, direction } = &object.symmetry else {
            panic!("a round bottle is round");
        };
        let side: Vector3<f64> = direction.cross(&Vector3::new(0.3, 0.5, 0.1)).normalize();
        for height in [-0.2, -0.05, 0.0, 0.08, 0.2] {
            let centre = point + direction * height;
            let (_, gradient, hessian) = object.shape.hessian(&centre);
            assert!(gradient.dot(&side).abs() < 1e-12);
            let near = object.shape.gradient(&(centre + side * 1e-6)).1;
            let expected = gradient + hessian * (side * 1e-6);
            assert!((near - expected).norm() < 1e-5, "{near} {expected}");
        }
    }
}
