//! A tri-cubic B-spline on a regular grid. It is C² and interpolates the samples.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::jet::Jet;

/// Number of nodes beyond the box on each side, enough that the boundary condition has no effect inside.
pub(super) const RIM: usize = 3;

/// A tri-cubic B-spline over a box.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spline {
    /// Position of node (0, 0, 0), metres.
    pub(super) origin: Vector3<f64>,
    /// Distance between neighbouring nodes, metres.
    pub(super) cell_m: f64,
    /// Number of nodes along x, y, z.
    pub(super) nodes: [usize; 3],
    /// Coefficients, z varying fastest. Single precision halves the memory traffic; all arithmetic is in double precision.
    pub(super) coefficients: Vec<f32>,
}

/// Weights of four neighbouring coefficients along one axis, and their derivatives.
pub(super) struct Weights {
    pub(super) first: usize,
    pub(super) value: [f64; 4],
    pub(super) slope: [f64; 4],
    pub(super) bend: [f64; 4],
}

impl Spline {
    /// Number of nodes along each axis of a grid over a box of these extents.
    pub(super) fn nodes_for(extents: &Vector3<f64>, cell_m: f64) -> [usize; 3] {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small positive count"
        )]
        let along = |extent: f64| (extent / cell_m).ceil() as usize + 2 * RIM + 1;
        [along(extents.x), along(extents.y), along(extents.z)]
    }

    /// Interpolates the samples of `sample_row`, which writes the values along one row of nodes from its first node in z
    /// direction.
    pub(super) fn interpolate(
        low: &Vector3<f64>,
        high: &Vector3<f64>,
        cell_m: f64,
        sample_row: impl Fn(&Vector3<f64>, &mut [f64]) + Sync,
    ) -> Self {
        let origin = low.add_scalar(-cell_m * RIM as f64);
        let nodes = Self::nodes_for(&(high - low), cell_m);
        let [nx, ny, nz] = nodes;
        let mut values = vec![0.0; nx * ny * nz];
        values
            .par_chunks_mut(nz)
            .enumerate()
            .for_each(|(row, values)| {
                let start =
                    origin + Vector3::new((row / ny) as f64, (row % ny) as f64, 0.0) * cell_m;
                sample_row(&start, values);
            });
        values
            .par_chunks_mut(nz)
            .for_each(|row| solve_lines(row, 1));
        values
            .par_chunks_mut(ny * nz)
            .for_each(|plane| solve_lines(plane, nz));
        solve_lines(&mut values, ny * nz);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "rounding to single precision is meant"
        )]
        let coefficients = values.into_iter().map(|value| value as f32).collect();
        Self {
            origin,
            cell_m,
            nodes,
            coefficients,
        }
    }

    /// Value and, for `ORDER` ≥ 1, gradient and, for `ORDER` ≥ 2, Hessian at `point`, which must lie in the box.
    ///
    /// The four coefficients of a row are four lanes that are summed only at the end, which compilers vectorise.
    #[inline]
    pub(super) fn jet<const ORDER: usize>(&self, point: &Vector3<f64>) -> Jet {
        let [_, ny, nz] = self.nodes;
        let inverse_cell = 1.0 / self.cell_m;
        let x = self.weights::<ORDER>(point, inverse_cell, 0);
        let y = self.weights::<ORDER>(point, inverse_cell, 1);
        let z = self.weights::<ORDER>(point, inverse_cell, 2);
        let base = (x.first * ny + y.first) * nz + z.first;

        // Sums over x and y, with a lane for each z: value and derivatives along x and y.
        let [mut v, mut vx, mut vy] = [[0.0; 4]; 3];
        let [mut vxx, mut vxy, mut vyy] = [[0.0; 4]; 3];
        for i in 0..4 {
            let [a, b, c] = self.plane::<ORDER>(base + i * ny * nz, &y);
            for k in 0..4 {
                v[k] += x.value[i] * a[k];
                if ORDER >= 1 {
                    vx[k] += x.slope[i] * a[k];
                    vy[k] += x.value[i] * b[k];
                }
                if ORDER >= 2 {
                    vxx[k] += x.bend[i] * a[k];
                    vxy[k] += x.slope[i] * b[k];
                    vyy[k] += x.value[i] * c[k];
                }
            }
        }
        let mut jet = Jet {
            value: dot(&v, &z.value),
            gradient: Vector3::zeros(),
            hessian: Matrix3::zeros(),
        };
        if ORDER >= 1 {
            jet.gradient = Vector3::new(dot(&vx, &z.value), dot(&vy, &z.value), dot(&v, &z.slope));
        }
        if ORDER >= 2 {
            let (xx, yy, zz) = (dot(&vxx, &z.value), dot(&vyy, &z.value), dot(&v, &z.bend));
            let (xy, xz, yz) = (dot(&vxy, &z.value), dot(&vx, &z.slope), dot(&vy, &z.slope));
            jet.hessian = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        }
        jet
    }

    /// Sums over y of the four rows from `start` on, with a lane for each z: value, first and second derivative along y.
    #[inline]
    fn plane<const ORDER: usize>(&self, start: usize, y: &Weights) -> [[f64; 4]; 3] {
        let row = |j: usize| -> [f64; 4] {
            let start = start + j * self.nodes[2];
            let row: &[f32; 4] = self.coefficients[start..start + 4]
                .try_into()
                .expect("four coefficients");
            row.map(f64::from)
        };
        let [p, q, r, s] = [row(0), row(1), row(2), row(3)];
        let sum = |w: &[f64; 4]| -> [f64; 4] {
            std::array::from_fn(|k| (w[0] * p[k] + w[1] * q[k]) + (w[2] * r[k] + w[3] * s[k]))
        };
        let zero = [0.0; 4];
        [
            sum(&y.value),
            if ORDER >= 1 { sum(&y.slope) } else { zero },
            if ORDER >= 2 { sum(&y.bend) } else { zero },
        ]
    }

    #[inline]
    fn weights<const ORDER: usize>(
        &self,
        point: &Vector3<f64>,
        inverse_cell: f64,
        axis: usize,
    ) -> Weights {
        let along = (point[axis] - self.origin[axis]) * inverse_cell;
        Weights::at::<ORDER>(along, self.nodes[axis], inverse_cell)
    }
}

impl Weights {
    /// Weights at a distance of `along` cells from the first of `nodes` nodes.
    #[inline]
    pub(super) fn at<const ORDER: usize>(along: f64, nodes: usize, inverse_cell: f64) -> Self {
        const SIXTH: f64 = 1.0 / 6.0;
        const TWO_THIRDS: f64 = 2.0 / 3.0;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between one and the number of nodes"
        )]
        let cell = along.max(1.0).min((nodes - 3) as f64) as u32;
        let t = along - f64::from(cell);
        let s = 1.0 - t;
        let (ss, tt) = (s * s, t * t);
        let mut weights = Self {
            first: cell as usize - 1,
            value: [0.0; 4],
            slope: [0.0; 4],
            bend: [0.0; 4],
        };
        weights.value = [
            ss * s * SIXTH,
            (0.5 * t - 1.0) * tt + TWO_THIRDS,
            (0.5 * s - 1.0) * ss + TWO_THIRDS,
            tt * t * SIXTH,
        ];
        if ORDER >= 1 {
            let slope = [
                -0.5 * ss,
                (1.5 * t - 2.0) * t,
                (2.0 - 1.5 * s) * s,
                0.5 * tt,
            ];
            weights.slope = slope.map(|slope| slope * inverse_cell);
        }
        if ORDER >= 2 {
            let bend = [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t];
            weights.bend = bend.map(|bend| bend * (inverse_cell * inverse_cell));
        }
        weights
    }
}

#[inline]
pub(super) fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

/// Turns samples into B-spline coefficients along the slowest axis of `block`, a list of slices of `stride` numbers.
///
/// Solves (c₋ + 4c + c₊)/6 = f with c = f at both ends (no curvature there), after Unser et al. (1993).
pub(super) fn solve_lines(block: &mut [f64], stride: usize) {
    let count = block.len() / stride;
    let mut factors = vec![0.0; count];
    for i in 1..count - 1 {
        factors[i] = 1.0 / (4.0 - factors[i - 1]);
        let (before, here) = block.split_at_mut(i * stride);
        for (value, previous) in here[..stride].iter_mut().zip(&before[(i - 1) * stride..]) {
            *value = (6.0 * *value - previous) * factors[i];
        }
    }
    for i in (1..count - 1).rev() {
        let (here, after) = block.split_at_mut((i + 1) * stride);
        for (value, next) in here[i * stride..].iter_mut().zip(&after[..stride]) {
            *value -= factors[i] * next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spline of x + 2y − z + sin(20 x) cos(30 z)/100 over a box of 10 cm.
    fn wavy() -> (Spline, impl Fn(&Vector3<f64>) -> f64) {
        let formula = |p: &Vector3<f64>| {
            p.x + 2.0 * p.y - p.z + 0.01 * libm::sin(20.0 * p.x) * libm::cos(30.0 * p.z)
        };
        let cell_m = 0.004;
        let fill = move |start: &Vector3<f64>, row: &mut [f64]| {
            for (k, value) in row.iter_mut().enumerate() {
                *value = formula(&(start + Vector3::z() * (k as f64 * cell_m)));
            }
        };
        (
            Spline::interpolate(&Vector3::zeros(), &Vector3::repeat(0.1), cell_m, fill),
            formula,
        )
    }

    #[test]
    fn passes_through_its_samples() {
        let (spline, formula) = wavy();
        for node in [[0.0, 0.0, 0.0], [5.0, 12.0, 20.0], [25.0, 1.0, 13.0]] {
            let point = Vector3::from(node) * spline.cell_m;
            let error = (spline.jet::<0>(&point).value - formula(&point)).abs();
            assert!(
                error < 1e-7,
                "{error} at {point}: more than rounding to single precision"
            );
        }
    }

    #[test]
    fn converges_between_samples() {
        let (spline, formula) = wavy();
        for step in 0..100 {
            let point = Vector3::new(0.001, 0.0007, 0.00093) * f64::from(step);
            let error = (spline.jet::<0>(&point).value - formula(&point)).abs();
            // 1/384 of the fourth derivative times the fourth power of the cell is 5e-9 here, rounding 2e-8.
            assert!(error < 1e-7, "{error} at {point}");
        }
    }

    #[test]
    fn points_outside_and_not_a_number_do_not_panic() {
        let (spline, _) = wavy();
        for x in [f64::NAN, f64::INFINITY, -1e300, 1e300] {
            let _ = spline.jet::<2>(&Vector3::repeat(x));
        }
    }
}
