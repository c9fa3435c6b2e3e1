//! Judges of bare contacts: the relaxed and the exact force-closure test. They know neither hand nor object.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT,
    SolverStatus, SupportedConeT, ZeroConeT,
};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// A point contact: where it pushes and in which direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointContact {
    /// Arm from the torque centre, divided by the length that makes torques comparable to forces.
    pub arm: Vector3<f64>,
    /// Inward unit normal: the direction in which the contact pushes the object.
    pub inward_normal: Vector3<f64>,
}

impl PointContact {
    /// Wrench (force, torque) of a unit normal force at this contact.
    pub fn wrench(&self) -> Vector6<f64> {
        let torque = self.arm.cross(&self.inward_normal);
        Vector6::new(
            self.inward_normal.x,
            self.inward_normal.y,
            self.inward_normal.z,
            torque.x,
            torque.y,
            torque.z,
        )
    }
}

/// ‖Gc‖₂, the wrench left over when every contact pushes with a unit force along its normal.
///
/// ```text
/// G = [I … I; [x₁]ₓ … [xₙ]ₓ]  (6 × 3n),   c = (c₁, …, cₙ)
/// ```
///
/// Dimensionless, zero when the normals alone balance. Liu et al. (2021), Eq. 6.
pub fn net_wrench(contacts: &[PointContact]) -> f64 {
    contacts
        .iter()
        .map(PointContact::wrench)
        .sum::<Vector6<f64>>()
        .norm()
}

/// Smallest eigenvalue of `GGᵀ`: positive when the contacts' forces span all six wrench directions.
///
/// Two point contacts always give zero: no force turns the object about the line through them.
pub fn grasp_matrix_rank_margin(contacts: &[PointContact]) -> f64 {
    let mut moment = Matrix3::zeros();
    let mut inertia = Matrix3::zeros();
    for contact in contacts {
        let cross = contact.arm.cross_matrix();
        moment += cross;
        inertia += cross * cross.transpose();
    }
    let mut gram = Matrix6::zeros();
    gram.fixed_view_mut::<3, 3>(0, 0)
        .copy_from(&(Matrix3::identity() * contacts.len() as f64));
    gram.fixed_view_mut::<3, 3>(3, 0).copy_from(&moment);
    gram.fixed_view_mut::<3, 3>(0, 3)
        .copy_from(&moment.transpose());
    gram.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
    gram.symmetric_eigenvalues().min()
}

/// The rank condition of force closure, `GGᵀ` ≻ εI, uses this ε (Liu et al. 2021, Eq. 3, with arms of order one).
pub const RANK_EPSILON: f64 = 1e-4;

/// Wrench residuals and cone violations below this count as balance. Contact forces sum to one, so it is relative.
const BALANCE_TOLERANCE: f64 = 1e-8;

/// Friction coefficients above this are reported as infinite.
const LARGEST_FRICTION: f64 = 1e3;

/// Exact force closure with point contacts and Coulomb friction `friction`: forces inside the friction cones balance
/// (Σ fₙ = 1, fₙ ≥ 0, Gf = 0) *and* the contacts span all wrenches (`GGᵀ` ≻ εI).
///
/// Liu et al. (2021), Eqs. 1–3. Cost: one small conic programme, about 0.15 ms for four contacts.
///
/// # Panics
/// If `friction` is negative or not finite.
pub fn is_force_closure(contacts: &[PointContact], friction: f64) -> bool {
    assert!(friction >= 0.0 && friction.is_finite());
    grasp_matrix_rank_margin(contacts) > RANK_EPSILON
        && cone_margin(contacts, friction).is_some_and(|margin| margin >= -BALANCE_TOLERANCE)
}

/// Least friction coefficient μ₀ for which contact forces in the cones balance; `f64::INFINITY` where no friction
/// suffices.
///
/// ```text
/// μ₀ = inf { μ : ∃ f, ‖f_t,i‖ ≤ μ f_n,i, f_n,i ≥ 0, Σ f_n,i = 1, Gf = 0 }
/// ```
///
/// Closed form for two contacts (the forces lie on the connecting line), bisection over second-order cone programmes
/// above; accurate to about 1e-7. Independent of the rank condition.
pub fn least_friction(contacts: &[PointContact]) -> f64 {
    if contacts.len() < 2 {
        return f64::INFINITY;
    }
    if let [first, second] = contacts {
        return least_friction_of_pair(first, second);
    }
    let feasible = |friction: f64| {
        cone_margin(contacts, friction).is_some_and(|margin| margin >= -BALANCE_TOLERANCE * 0.1)
    };
    let mut high = 0.5;
    let mut low = 0.0;
    while !feasible(high) {
        low = high;
        high *= 4.0;
        if high > LARGEST_FRICTION {
            return f64::INFINITY;
        }
    }
    while high - low > 1e-8 * high.max(1.0) {
        let middle = 0.5 * (low + high);
        if feasible(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

fn least_friction_of_pair(first: &PointContact, second: &PointContact) -> f64 {
    let line = second.arm - first.arm;
    if line.norm() == 0.0 {
        return f64::INFINITY;
    }
    let tangent_of = |normal: &Vector3<f64>, direction: &Vector3<f64>| {
        let along = normal.dot(direction);
        if along > 0.0 {
            normal.cross(direction).norm() / along
        } else {
            f64::INFINITY
        }
    };
    let squeeze =
        tangent_of(&first.inward_normal, &line).max(tangent_of(&second.inward_normal, &-line));
    let spread =
        tangent_of(&first.inward_normal, &-line).max(tangent_of(&second.inward_normal, &line));
    squeeze.min(spread)
}

/// Largest s for which balanced forces with `‖f_t,i‖ ≤ μ f_n,i − s` exist; `None` where no forces balance at all.
fn cone_margin(contacts: &[PointContact], friction: f64) -> Option<f64> {
    let n = contacts.len();
    let columns = 3 * n + 1;
    let margin_column = 3 * n;
    let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); 7 + n + 3 * n];
    for (i, contact) in contacts.iter().enumerate() {
        let normal = contact.inward_normal;
        let tangent = normal.cross(&any_perpendicular(&normal)).normalize();
        let axes = [normal, tangent, normal.cross(&tangent)];
        for (component, axis) in axes.iter().enumerate() {
            let column = 3 * i + component;
            let torque = contact.arm.cross(axis);
            for k in 0..3 {
                rows[k].push((column, axis[k]));
                rows[3 + k].push((column, torque[k]));
            }
        }
        rows[6].push((3 * i, 1.0));
        rows[7 + i].push((3 * i, -1.0));
        let cone = 7 + n + 3 * i;
        rows[cone].push((3 * i, -friction));
        rows[cone].push((margin_column, 1.0));
        rows[cone + 1].push((3 * i + 1, -1.0));
        rows[cone + 2].push((3 * i + 2, -1.0));
    }
    let mut bounds = vec![0.0; rows.len()];
    bounds[6] = 1.0;
    let mut linear = vec![0.0; columns];
    linear[margin_column] = -1.0;
    let mut cones: Vec<SupportedConeT<f64>> = vec![ZeroConeT(7), NonnegativeConeT(n)];
    cones.extend((0..n).map(|_| SecondOrderConeT(3)));
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_gap_abs(1e-11)
        .tol_gap_rel(1e-11)
        .tol_feas(1e-11)
        .build()
        .expect("the settings are constants within the solver's limits");
    let mut solver = DefaultSolver::new(
        &CscMatrix::zeros((columns, columns)),
        &linear,
        &compressed_columns(&rows, columns),
        &bounds,
        &cones,
        settings,
    )
    .expect("the dimensions of the programme agree by construction");
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved
        | SolverStatus::AlmostSolved
        | SolverStatus::InsufficientProgress
        | SolverStatus::MaxIterations => Some(solver.solution.x[margin_column]),
        _ => None,
    }
}

fn any_perpendicular(v: &Vector3<f64>) -> Vector3<f64> {
    let axis = v.iamin();
    let mut other = Vector3::zeros();
    other[axis] = 1.0;
    other
}

fn compressed_columns(rows: &[Vec<(usize, f64)>], columns: usize) -> CscMatrix<f64> {
    let mut by_column: Vec<Vec<(usize, f64)>> = vec![Vec::new(); columns];
    for (row, entries) in rows.iter().enumerate() {
        for &(column, value) in entries {
            by_column[column].push((row, value));
        }
    }
    let mut starts = vec![0];
    let mut indices = Vec::new();
    let mut values = Vec::new();
    for column in by_column {
        for (row, value) in column {
            indices.push(row);
            values.push(value);
        }
        starts.push(indices.len());
    }
    CscMatrix::new(rows.len(), columns, starts, indices, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_sphere(points: &[[f64; 3]]) -> Vec<PointContact> {
        points
            .iter()
            .map(|p| {
                let arm = Vector3::from(*p).normalize();
                PointContact {
                    arm,
                    inward_normal: -arm,
                }
            })
            .collect()
    }

    #[test]
    fn three_contacts_at_120_degrees_balance_without_friction() {
        let s = 0.75f64.sqrt();
        let contacts = on_sphere(&[[1.0, 0.0, 0.0], [-0.5, s, 0.0], [-0.5, -s, 0.0]]);
        assert!(net_wrench(&contacts) < 1e-15);
        assert!(least_friction(&contacts) < 1e-7);
        assert!(is_force_closure(&contacts, 0.1));
    }

    #[test]
    fn two_contacts_balance_but_never_close() {
        let contacts = on_sphere(&[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]);
        assert!(least_friction(&contacts) < 1e-12);
        assert!(!is_force_closure(&contacts, 1.0));
    }

    #[test]
    fn contacts_on_one_side_never_balance() {
        let contacts = on_sphere(&[[1.0, 0.0, 0.0], [1.0, 0.2, 0.0], [1.0, 0.0, 0.2]]);
        assert!(!is_force_closure(&contacts, 0.5));
    }
}
