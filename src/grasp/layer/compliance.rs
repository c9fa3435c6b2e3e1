//! How much an elastic layer gives under loads on the object, with contact forces in friction cones.

use nalgebra::{Cholesky, Const, Matrix3, Matrix6, Vector3, Vector6};

/// A patch of the layer: how much of it carries, where, and in which direction it pushes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Stiffness W.
    pub weight: f64,
    /// Arm from the object's centroid, in units of the object's radius.
    pub arm: Vector3<f64>,
    /// Unit normal into the object.
    pub inward_normal: Vector3<f64>,
}

/// The mean compliance and its derivatives.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Compliance {
    /// The mean over loads of √(C + c) − √c, divided by its value without contacts.
    pub value: f64,
    /// Its derivative by the weight of each node.
    pub by_weight: Vec<f64>,
    /// Its derivative by the arm of each node.
    pub by_arm: Vec<Vector3<f64>>,
    /// Its derivative by the inward normal of each node, for a normal that stays of unit length.
    pub by_normal: Vec<Vector3<f64>>,
    /// Its derivative by a rotation of the loads.
    pub by_rotation: Vector3<f64>,
}

/// Constants of the compliance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComplianceSettings {
    /// Friction coefficient μ.
    pub friction: f64,
    /// Stiffness κ of the support.
    pub support_stiffness: f64,
    /// Torque τ of the loads.
    pub torque_load: f64,
    /// Rounding c.
    pub rounding: f64,
}

/// Remainder relative to the load after which one more step of Newton's method is exact to rounding: the method converges
/// quadratically.
const LAST_REMAINDER: f64 = 1e-6;
const MOST_STEPS: usize = 60;
const MOST_HALVINGS: usize = 30;

/// Directions of the loads: the corners of a tetrahedron, whose second moment is that of a sphere.
const DIRECTIONS: [[f64; 3]; 4] = [
    [1.0, 1.0, 1.0],
    [1.0, -1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
];

/// The projection of u on the friction cone about the normal n: the gradient of the potential ½|P(u)|².
#[derive(Clone, Copy)]
enum Projection {
    /// Outside the dual cone: no force.
    Open,
    /// Inside the cone: P(u) = u.
    Sticks { force: Vector3<f64> },
    /// On the cone: P(u) = (n + μ t) s, with the unit tangent t of u.
    Slips {
        tangent: Vector3<f64>,
        /// The force along the normal, s.
        along: f64,
        /// n·u and |u − n (n·u)|.
        normal: f64,
        tangential: f64,
    },
}

#[inline]
fn project(u: &Vector3<f64>, n: &Vector3<f64>, mu: f64) -> Projection {
    let normal = n.dot(u);
    let t = u - n * normal;
    let squared = t.norm_squared();
    if normal < 0.0 && mu * mu * squared <= normal * normal {
        return Projection::Open;
    }
    if normal >= 0.0 && squared <= mu * mu * normal * normal {
        return Projection::Sticks { force: *u };
    }
    let tangential = squared.sqrt();
    Projection::Slips {
        tangent: t / tangential,
        along: (normal + mu * tangential) / (1.0 + mu * mu),
        normal,
        tangential,
    }
}

impl Projection {
    #[inline]
    fn force(&self, n: &Vector3<f64>, mu: f64) -> Vector3<f64> {
        match *self {
            Self::Open => Vector3::zeros(),
            Self::Sticks { force } => force,
            Self::Slips { tangent, along, .. } => (n + tangent * mu) * along,
        }
    }
}

/// Gᵀ y = y_f + y_τ × a.
#[inline]
fn pulled(y: &Vector6<f64>, arm: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        y[0] + y[4] * arm.z - y[5] * arm.y,
        y[1] + y[5] * arm.x - y[3] * arm.z,
        y[2] + y[3] * arm.y - y[4] * arm.x,
    )
}

#[inline]
fn wrench(force: &Vector3<f64>, arm: &Vector3<f64>) -> Vector6<f64> {
    let torque = arm.cross(force);
    Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
}

/// Adds W G Gᵀ to the lower triangle.
fn add_stuck(matrix: &mut Matrix6<f64>, weight: f64, arm: &Vector3<f64>) {
    let a = arm * weight;
    for k in 0..3 {
        matrix[(k, k)] += weight;
        matrix[(3 + k, 3 + k)] += a.dot(arm) - a[k] * arm[k];
    }
    matrix[(3, 1)] -= a.z;
    matrix[(3, 2)] += a.y;
    matrix[(4, 0)] += a.z;
    matrix[(4, 2)] -= a.x;
    matrix[(5, 0)] -= a.y;
    matrix[(5, 1)] += a.x;
    matrix[(4, 3)] -= a.y * arm.x;
    matrix[(5, 3)] -= a.z * arm.x;
    matrix[(5, 4)] -= a.z * arm.y;
}

#[inline]
fn add_rank_one(matrix: &mut Matrix6<f64>, weight: f64, column: &Vector6<f64>) {
    for j in 0..6 {
        let factor = weight * column[j];
        for i in j..6 {
            matrix[(i, j)] += factor * column[i];
        }
    }
}

/// The dual function, its gradient and the negative of its second derivative (lower triangle) at a point.
struct Dual {
    value: f64,
    gradient: Vector6<f64>,
    curvature: Matrix6<f64>,
}

impl Dual {
    fn at(
        nodes: &[Node],
        load: &Vector6<f64>,
        y: &Vector6<f64>,
        settings: &ComplianceSettings,
    ) -> Self {
        let (mu, support) = (settings.friction, 1.0 / settings.support_stiffness);
        let mut value = y.dot(load) - 0.5 * support * y.norm_squared();
        let mut gradient = load - y * support;
        let mut curvature = Matrix6::from_diagonal_element(support);
        for node in nodes {
            let n = &node.inward_normal;
            let at = project(&pulled(y, &node.arm), n, mu);
            match at {
                Projection::Open => continue,
                Projection::Sticks { force } => {
                    add_stuck(&mut curvature, node.weight, &node.arm);
                    value -= 0.5 * node.weight * force.norm_squared();
                    gradient -= wrench(&(force * node.weight), &node.arm);
                }
                Projection::Slips {
                    tangent,
                    along,
                    tangential,
                    ..
                } => {
                    let scale = node.weight / (1.0 + mu * mu);
                    let ray = wrench(&(n + tangent * mu), &node.arm);
                    add_rank_one(&mut curvature, scale, &ray);
                    let across = wrench(&n.cross(&tangent), &node.arm);
                    let bend = node.weight * along * mu / tangential;
                    add_rank_one(&mut curvature, bend, &across);
                    value -= 0.5 * node.weight * along * along * (1.0 + mu * mu);
                    gradient -= ray * (node.weight * along);
                }
            }
        }
        Self {
            value,
            gradient,
            curvature,
        }
    }
}

/// The y that maximises the dual function.
fn maximise(
    nodes: &[Node],
    load: &Vector6<f64>,
    start: Vector6<f64>,
    settings: &ComplianceSettings,
) -> Vector6<f64> {
    let mut y = start;
    let mut at = Dual::at(nodes, load, &y, settings);
    let last = LAST_REMAINDER * load.norm();
    for _ in 0..MOST_STEPS {
        let Some(factor) = Cholesky::<f64, Const<6>>::new(at.curvature) else {
            break;
        };
        let remainder = at.gradient.norm();
        let step = factor.solve(&at.gradient);
        if remainder <= last {
            return y + step;
        }
        let slope = step.dot(&at.gradient);
        let mut length = 1.0;
        let mut better = None;
        for _ in 0..MOST_HALVINGS {
            let tried = y + step * length;
            let found = Dual::at(nodes, load, &tried, settings);
            if found.value >= at.value + 1e-4 * length * slope
                || found.gradient.norm() < 0.5 * remainder
            {
                better = Some((tried, found));
                break;
            }
            length *= 0.5;
        }
        // Rounding: no step improves the value any more.
        let Some(next) = better else { break };
        (y, at) = next;
    }
    y
}

/// The mean compliance of `nodes` under eight loads: forces and torques along the corners of a tetrahedron in the frame of
/// `axes`.
///
/// ```text
/// C(v) = min over f in friction cones of  κ/2 |Σ G f − v|² + ½ Σ |f|²/W
///      = max over y ∈ R⁶ of               y·v − |y|²/2κ − ½ Σ W |P(Gᵀy)|²
/// value = Σ_v (√(C(v) + c) − √c) / Σ_v (√(C₀(v) + c) − √c),    C₀(v) = κ |v|²/2
/// ```
///
/// P is the projection on the friction cone. The maximum is unique. Newton's method finds it from the solution of the layer
/// whose contacts all stick, so that the result depends on the arguments alone. Derivatives follow from the envelope
/// theorem.
pub fn mean_compliance(
    nodes: &[Node],
    axes: &Matrix3<f64>,
    settings: &ComplianceSettings,
) -> Compliance {
    let count = nodes.len();
    let mut total = Compliance {
        value: 0.0,
        by_weight: vec![0.0; count],
        by_arm: vec![Vector3::zeros(); count],
        by_normal: vec![Vector3::zeros(); count],
        by_rotation: Vector3::zeros(),
    };
    let (mu, c) = (settings.friction, settings.rounding);
    let support = 1.0 / settings.support_stiffness;
    let mut stuck = Matrix6::from_diagonal_element(support);
    for node in nodes {
        add_stuck(&mut stuck, node.weight, &node.arm);
    }
    let stuck = stuck.cholesky();
    let mut free = 0.0;
    let mut projections = Vec::with_capacity(count);
    for k in 0..8 {
        let direction = axes * Vector3::from(DIRECTIONS[k % 4]) / 3.0_f64.sqrt();
        let (first, size) = if k < 4 { (0, 1.0) } else { (3, settings.torque_load) };
        let mut load = Vector6::zeros();
        load.fixed_rows_mut::<3>(first).copy_from(&(direction * size));
        free += (0.5 * settings.support_stiffness * size * size + c).sqrt() - c.sqrt();
        let start = stuck.as_ref().map_or(Vector6::zeros(), |s| s.solve(&load));
        let y = maximise(nodes, &load, start, settings);

        let mut compliance = y.dot(&load) - 0.5 * support * y.norm_squared();
        projections.clear();
        for node in nodes {
            let at = project(&pulled(&y, &node.arm), &node.inward_normal, mu);
            let force = at.force(&node.inward_normal, mu);
            compliance -= 0.5 * node.weight * force.norm_squared();
            projections.push((at, force));
        }
        let root = (compliance.max(0.0) + c).sqrt();
        total.value += root - c.sqrt();
        let slope = 0.5 / root;
        let [y_force, y_torque] = [0, 3].map(|row| y.fixed_rows::<3>(row).into_owned());
        for (i, (node, (at, force))) in nodes.iter().zip(&projections).enumerate() {
            if matches!(at, Projection::Open) {
                continue;
            }
            total.by_weight[i] -= slope * 0.5 * force.norm_squared();
            // ∂u/∂a: P·(y_τ × da) = da·(P × y_τ).
            total.by_arm[i] -= force.cross(&y_torque) * (slope * node.weight);
            if let Projection::Slips {
                tangent,
                along,
                normal,
                tangential,
            } = *at
            {
                // At fixed u, the potential depends on the normal through n·u and |t|² = |u|² − (n·u)².
                let by_normal = along * (1.0 - mu * normal / tangential);
                let u = node.inward_normal * normal + tangent * tangential;
                total.by_normal[i] -= u * (slope * node.weight * by_normal);
            }
        }
        let turned = if k < 4 { y_force } else { y_torque };
        total.by_rotation += (direction * size).cross(&turned) * slope;
    }
    total.value /= free;
    total.by_weight.iter_mut().for_each(|value| *value /= free);
    let vectors = total.by_arm.iter_mut().chain(&mut total.by_normal);
    vectors.for_each(|value| *value /= free);
    total.by_rotation /= free;
    total
}
