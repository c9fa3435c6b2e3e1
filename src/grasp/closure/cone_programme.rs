//! Balance of any number of contacts by second-order cone programming.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT,
    SolverStatus, SupportedConeT, ZeroConeT,
};
use nalgebra::{SMatrix, SVector, Vector3, Vector6};

use super::{PointContact, tangents_of, with_moderate_arms};

/// Balanced forces with the greatest margin to the friction cones.
pub(super) struct WidestMargin {
    /// The greatest s for which balanced forces with ‖fₜ‖ cos θ ≤ fₙ sin θ − s exist.
    pub(super) margin: f64,
    /// ds/dθ.
    pub(super) slope: f64,
    /// Whether the solver reached its tolerances.
    solved: bool,
    forces: Vec<Vector3<f64>>,
}

/// Tolerated violation of the cones (normal forces add up to one) if the solver reached its tolerances.
const SOLVED_TOLERANCE: f64 = 1e-10;

/// The same if the solver stalled.
pub(super) const BALANCE_TOLERANCE: f64 = 1e-8;

impl WidestMargin {
    /// Whether the forces lie in the cones within the accuracy of the solver.
    pub(super) fn balances(&self) -> bool {
        self.margin
            >= if self.solved {
                -SOLVED_TOLERANCE
            } else {
                -BALANCE_TOLERANCE
            }
    }

    /// Whether the forces lie strictly inside. A margin of zero may also mean that a contact is not needed.
    pub(super) fn is_open(&self) -> bool {
        self.margin > BALANCE_TOLERANCE
    }
}

/// Balanced forces (Gf = 0, Σ fₙ = 1, fₙ ≥ 0) farthest inside cones of half-angle θ; `None` if there are none in any cones.
pub(super) fn widest_margin(contacts: &[PointContact], half_angle: f64) -> Option<WidestMargin> {
    let contacts = &with_moderate_arms(contacts);
    if contacts.iter().any(|contact| !contact.is_finite()) {
        return None;
    }
    let n = contacts.len();
    let (sine, cosine) = libm::sincos(half_angle);
    let margin_column = 3 * n;
    let cone_of = |i: usize| 7 + n + 3 * i;
    let axes: Vec<[Vector3<f64>; 3]> = contacts
        .iter()
        .map(|contact| {
            let [first, second] = tangents_of(&contact.inward_normal);
            [contact.inward_normal, first, second]
        })
        .collect();
    let mut columns = Columns::default();
    for (i, (contact, axes)) in contacts.iter().zip(&axes).enumerate() {
        for (component, axis) in axes.iter().enumerate() {
            columns.begin();
            for (row, value) in contact.wrench_of(axis).iter().enumerate() {
                columns.push(row, *value);
            }
            if component == 0 {
                columns.push(6, 1.0);
                columns.push(7 + i, -1.0);
                columns.push(cone_of(i), -sine);
            } else {
                columns.push(cone_of(i) + component, -cosine);
            }
        }
    }
    columns.begin();
    for i in 0..n {
        columns.push(cone_of(i), 1.0);
    }
    let rows = cone_of(n);
    let mut bounds = vec![0.0; rows];
    bounds[6] = 1.0;
    let mut linear = vec![0.0; margin_column + 1];
    linear[margin_column] = -1.0;
    let mut cones = vec![ZeroConeT(7), NonnegativeConeT(n)];
    cones.extend((0..n).map(|_| SecondOrderConeT(3)));

    let (x, z, solved) = solve(&linear, &columns.matrix(rows), &bounds, &cones)?;
    let force = |i: usize| &x[3 * i..3 * i + 3];
    let slope = (0..n)
        .map(|i| {
            let (f, dual) = (force(i), &z[cone_of(i)..cone_of(i) + 3]);
            cosine * dual[0] * f[0] - sine * (dual[1] * f[1] + dual[2] * f[2])
        })
        .sum();
    let forces = axes
        .iter()
        .enumerate()
        .map(|(i, axes)| axes.iter().zip(force(i)).map(|(axis, f)| axis * *f).sum())
        .collect();
    Some(WidestMargin {
        margin: x[margin_column],
        slope,
        solved,
        forces,
    })
}

/// Balanced forces of point contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactForces {
    /// One force for each contact, in the frame of the contacts; the normal components add up to one.
    pub forces: Vec<Vector3<f64>>,
    /// ‖Gf‖₂, the remaining wrench due to rounding.
    pub residual: f64,
    /// Greatest violation of a friction cone: max over contacts of ‖fₜ‖ − μ fₙ and −fₙ; negative inside the cones.
    pub violation: f64,
}

/// Contact forces that balance at friction `friction`, as far inside the friction cones as possible, if any.
///
/// ```text
/// max s   with   ‖fₜ,i‖ cos θ ≤ fₙ,i sin θ − s,   fₙ,i ≥ 0,   Σ fₙ,i = 1,   Gf = 0,   tan θ = μ
/// ```
///
/// Solved as a second-order cone programme, then projected onto Gf = 0, Σ fₙ = 1, so that ‖Gf‖ ≤ 10⁻⁹ (usually 10⁻¹⁶). The
/// cones hold to about 10⁻⁸. If `friction` is [`least_friction`](super::least_friction), the forces lie on the cones. Arms
/// above 10⁶ are first scaled down together to order one, and ‖Gf‖ then refers to the scaled arms.
///
/// # Panics
/// If `friction` is negative or not finite.
pub fn contact_forces(contacts: &[PointContact], friction: f64) -> Option<ContactForces> {
    assert!(friction >= 0.0 && friction.is_finite());
    if contacts.is_empty() {
        return None;
    }
    let contacts = &with_moderate_arms(contacts);
    let widest = widest_margin(contacts, libm::atan(friction))?;
    if widest.margin < -BALANCE_TOLERANCE {
        return None;
    }
    let forces = balanced(contacts, widest.forces);
    let residual = contacts
        .iter()
        .zip(&forces)
        .map(|(contact, force)| contact.wrench_of(force))
        .sum::<Vector6<f64>>()
        .norm();
    let violation = contacts
        .iter()
        .zip(&forces)
        .map(|(contact, force)| {
            let along = contact.inward_normal.dot(force);
            let across = (force - contact.inward_normal * along).norm();
            (across - friction * along).max(-along)
        })
        .fold(f64::NEG_INFINITY, f64::max);
    Some(ContactForces {
        forces,
        residual,
        violation,
    })
}

fn balanced(contacts: &[PointContact], mut forces: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let rows: Vec<_> = contacts
        .iter()
        .map(|contact| {
            let mut rows = SMatrix::<f64, 7, 3>::zeros();
            rows.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
            rows.fixed_view_mut::<3, 3>(3, 0)
                .copy_from(&contact.arm.cross_matrix());
            rows.fixed_view_mut::<1, 3>(6, 0)
                .copy_from(&contact.inward_normal.transpose());
            rows
        })
        .collect();
    let gram: SMatrix<f64, 7, 7> = rows.iter().map(|rows| rows * rows.transpose()).sum();
    // Contacts on a line leave singular directions, which no force can correct and which need no correction.
    let eigen = gram.symmetric_eigen();
    let threshold = 1e-10 * eigen.eigenvalues.max();
    let inverse = eigen.eigenvalues.map(|value| {
        if value > threshold {
            value.recip()
        } else {
            0.0
        }
    });
    // The second round removes rounding errors.
    for _ in 0..2 {
        let mut missing: SVector<f64, 7> = -rows
            .iter()
            .zip(&forces)
            .map(|(rows, force)| rows * force)
            .sum::<SVector<f64, 7>>();
        missing[6] += 1.0;
        let multipliers =
            eigen.eigenvectors * inverse.component_mul(&eigen.eigenvectors.tr_mul(&missing));
        for (rows, force) in rows.iter().zip(&mut forces) {
            *force += rows.tr_mul(&multipliers);
        }
    }
    forces
}

/// The shortest vector of the convex hull of `points` (not empty, of order one at most); `None` if the solver fails.
pub(super) fn shortest_in_hull(points: &[Vector6<f64>]) -> Option<Vector6<f64>> {
    // min t with ‖Σ λ p‖ ≤ t, Σ λ = 1, λ ≥ 0.
    let n = points.len();
    let mut columns = Columns::default();
    for (i, point) in points.iter().enumerate() {
        columns.begin();
        columns.push(0, 1.0);
        columns.push(1 + i, -1.0);
        for (row, value) in point.iter().enumerate() {
            columns.push(n + 2 + row, -value);
        }
    }
    columns.begin();
    columns.push(n + 1, -1.0);
    let mut bounds = vec![0.0; n + 8];
    bounds[0] = 1.0;
    let mut linear = vec![0.0; n + 1];
    linear[n] = 1.0;
    let cones = [ZeroConeT(1), NonnegativeConeT(n), SecondOrderConeT(7)];
    let (x, _, _) = solve(&linear, &columns.matrix(n + 8), &bounds, &cones)?;
    let shortest = points
        .iter()
        .zip(&x)
        .map(|(point, weight)| point * *weight)
        .sum();
    Some(shortest)
}

/// Minimises cᵀx with b − Ax in the cones: the solution, its dual, and whether both converged; `None` if infeasible.
fn solve(
    linear: &[f64],
    matrix: &CscMatrix<f64>,
    bounds: &[f64],
    cones: &[SupportedConeT<f64>],
) -> Option<(Vec<f64>, Vec<f64>, bool)> {
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_gap_abs(1e-11)
        .tol_gap_rel(1e-11)
        .tol_feas(1e-11)
        .build()
        .expect("the settings are constants within the solver's limits");
    let no_quadratic = CscMatrix::zeros((linear.len(), linear.len()));
    let mut solver = DefaultSolver::new(&no_quadratic, linear, matrix, bounds, cones, settings)
        .expect("the dimensions of the programme agree by construction");
    solver.solve();
    let solved = match solver.solution.status {
        SolverStatus::Solved => true,
        SolverStatus::AlmostSolved
        | SolverStatus::InsufficientProgress
        | SolverStatus::MaxIterations => false,
        _ => return None,
    };
    Some((solver.solution.x, solver.solution.z, solved))
}

#[derive(Default)]
struct Columns {
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl Columns {
    fn begin(&mut self) {
        self.starts.push(self.rows.len());
    }

    /// The rows of a column must be ascending.
    fn push(&mut self, row: usize, value: f64) {
        self.rows.push(row);
        self.values.push(value);
    }

    fn matrix(mut self, rows: usize) -> CscMatrix<f64> {
        let columns = self.starts.len();
        self.starts.push(self.rows.len());
        CscMatrix::new(rows, columns, self.starts, self.rows, self.values)
    }
}
