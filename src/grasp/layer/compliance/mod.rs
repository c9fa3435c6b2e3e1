//! How much an elastic layer gives under loads on the object, with contact forces in friction cones.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined uses the vector instructions chosen at run time"
)]

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::grasp::layer::cone::{Cone, Potential};
use crate::grasp::layer::factors::{Factors, Lower, multiple};

/// A patch of the layer: an elastic contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Stiffness W: that of 5 mm of a finger is 1.
    pub stiffness: f64,
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
    /// Its derivative by the stiffness of each node.
    pub by_stiffness: Vec<f64>,
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
    /// Force of the loads.
    pub load: f64,
    /// Torque of the loads relative to their force at the object's radius.
    pub torque_share: f64,
    /// How far a load moves an object that nothing holds.
    pub free_motion: f64,
    /// Rounding δ of the friction cones, a motion.
    pub friction_rounding: f64,
    /// Rounding c, as a fraction of C without contacts.
    pub rounding: f64,
}

/// Remainder relative to the load after which one more step of Newton's method is exact to rounding: the method converges
/// quadratically.
const LAST_REMAINDER: f64 = 1e-5;
const MOST_STEPS: usize = 60;
const MOST_HALVINGS: usize = 30;

/// Directions of the loads: the corners of a tetrahedron, whose second moment is that of a sphere.
const DIRECTIONS: [[f64; 3]; 4] = [
    [1.0, 1.0, 1.0],
    [1.0, -1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
];

const LANES: usize = 8;
type Lanes = [f64; LANES];

/// Eight nodes, laid out for vectorised sums. Missing ones have no stiffness.
#[derive(Debug, Clone, Copy)]
struct Group {
    stiffness: Lanes,
    arm: [Lanes; 3],
    normal: [Lanes; 3],
}

impl Group {
    fn of(nodes: &[Node]) -> Self {
        let mut group = Self {
            stiffness: [0.0; LANES],
            arm: [[0.0; LANES]; 3],
            normal: [[1.0; LANES], [0.0; LANES], [0.0; LANES]],
        };
        for (lane, node) in nodes.iter().enumerate() {
            group.stiffness[lane] = node.stiffness;
            for k in 0..3 {
                group.arm[k][lane] = node.arm[k];
                group.normal[k][lane] = node.inward_normal[k];
            }
        }
        group
    }

    /// A contact of the group at the motion `y`.
    #[inline(always)]
    fn contact(&self, lane: usize, y: &[f64; 6], cone: &Cone) -> Contact {
        let [a, n] = [&self.arm, &self.normal].map(|of| [of[0][lane], of[1][lane], of[2][lane]]);
        let u = [
            y[0] + y[4] * a[2] - y[5] * a[1],
            y[1] + y[5] * a[0] - y[3] * a[2],
            y[2] + y[3] * a[1] - y[4] * a[0],
        ];
        let normal = u[0] * n[0] + u[1] * n[1] + u[2] * n[2];
        let t = [
            u[0] - n[0] * normal,
            u[1] - n[1] * normal,
            u[2] - n[2] * normal,
        ];
        let at = Potential::of(normal, t[0] * t[0] + t[1] * t[1] + t[2] * t[2], cone);
        let inverse = 1.0 / at.tangential;
        let t = [t[0] * inverse, t[1] * inverse, t[2] * inverse];
        let f = [
            at.along * n[0] + at.across * t[0],
            at.along * n[1] + at.across * t[1],
            at.along * n[2] + at.across * t[2],
        ];
        Contact { a, n, u, t, f, at }
    }
}

/// A contact at a motion of the object: its arm and normal, the displacement u = Gᵀy of its layer, the direction t of the
/// part of u across the normal, and the force per stiffness.
struct Contact {
    a: [f64; 3],
    n: [f64; 3],
    u: [f64; 3],
    t: [f64; 3],
    f: [f64; 3],
    at: Potential,
}

/// Sums over loads of the derivatives by stiffness, arm (three) and normal (three) of the nodes of a group.
type Slopes = [Lanes; 7];

/// Adds W G Gᵀ.
fn add_stuck(matrix: &mut Lower, weight: f64, arm: &Vector3<f64>) {
    let a = arm * weight;
    for k in 0..3 {
        matrix[k][k] += weight;
        matrix[3 + k][3 + k] += a.dot(arm) - a[k] * arm[k];
    }
    matrix[3][1] -= a.z;
    matrix[3][2] += a.y;
    matrix[4][0] += a.z;
    matrix[4][2] -= a.x;
    matrix[5][0] -= a.y;
    matrix[5][1] += a.x;
    matrix[4][3] -= a.y * arm.x;
    matrix[5][3] -= a.z * arm.x;
    matrix[5][4] -= a.z * arm.y;
}

/// Sums over nodes: the potential, its six derivatives and its 21 second derivatives (the force block, the lower left block
/// by rows, the torque block).
const SUMS: usize = 1 + 6 + 6 + 9 + 6;

/// Adds the sums over the nodes of a group.
#[inline(always)]
fn add_group(group: &Group, y: &[f64; 6], cone: &Cone, sums: &mut [Lanes; SUMS]) {
    for lane in 0..LANES {
        let w = group.stiffness[lane];
        let Contact { a, n, t, f, at, .. } = group.contact(lane, y, cone);
        let f = [w * f[0], w * f[1], w * f[2]];
        let value = w * at.value;
        let (p, q, r, z) = (w * at.p, w * at.q, w * at.r, w * at.z);
        let qn = [
            q * n[0] + r * t[0],
            q * n[1] + r * t[1],
            q * n[2] + r * t[2],
        ];
        let rt = [
            r * n[0] + z * t[0],
            r * n[1] + z * t[1],
            r * n[2] + z * t[2],
        ];
        let j00 = p + qn[0] * n[0] + rt[0] * t[0];
        let j11 = p + qn[1] * n[1] + rt[1] * t[1];
        let j22 = p + qn[2] * n[2] + rt[2] * t[2];
        let j10 = qn[1] * n[0] + rt[1] * t[0];
        let j20 = qn[2] * n[0] + rt[2] * t[0];
        let j21 = qn[2] * n[1] + rt[2] * t[1];
        // A J with A = [a]ₓ, by rows.
        let m00 = a[1] * j20 - a[2] * j10;
        let m01 = a[1] * j21 - a[2] * j11;
        let m02 = a[1] * j22 - a[2] * j21;
        let m10 = a[2] * j00 - a[0] * j20;
        let m11 = a[2] * j10 - a[0] * j21;
        let m12 = a[2] * j20 - a[0] * j22;
        let m20 = a[0] * j10 - a[1] * j00;
        let m21 = a[0] * j11 - a[1] * j10;
        let m22 = a[0] * j21 - a[1] * j20;
        let parts = [
            value,
            f[0],
            f[1],
            f[2],
            a[1] * f[2] - a[2] * f[1],
            a[2] * f[0] - a[0] * f[2],
            a[0] * f[1] - a[1] * f[0],
            j00,
            j10,
            j20,
            j11,
            j21,
            j22,
            m00,
            m01,
            m02,
            m10,
            m11,
            m12,
            m20,
            m21,
            m22,
            // A J Aᵀ, lower triangle.
            a[1] * m02 - a[2] * m01,
            a[1] * m12 - a[2] * m11,
            a[1] * m22 - a[2] * m21,
            a[2] * m10 - a[0] * m12,
            a[2] * m20 - a[0] * m22,
            a[0] * m21 - a[1] * m20,
        ];
        for (sum, part) in sums.iter_mut().zip(parts) {
            sum[lane] += part;
        }
    }
}

/// The sums over all nodes at a motion.
struct Sums<'a> {
    groups: &'a [Group],
    at: &'a [f64; 6],
    cone: &'a Cone,
}

impl pulp::NullaryFnOnce for Sums<'_> {
    type Output = [f64; SUMS];

    #[inline(always)]
    fn call(self) -> Self::Output {
        let mut lanes = [[0.0; LANES]; SUMS];
        for group in self.groups {
            add_group(group, self.at, self.cone, &mut lanes);
        }
        lanes.map(|lane| {
            let pairs: [f64; 4] = std::array::from_fn(|k| lane[k] + lane[k + 4]);
            (pairs[0] + pairs[1]) + (pairs[2] + pairs[3])
        })
    }
}

/// Adds to `slopes` the derivatives by the nodes of √C at the motion that solves a load; `factor` is the derivative of the
/// root.
struct AddSlopes<'a> {
    groups: &'a [Group],
    at: &'a [f64; 6],
    cone: &'a Cone,
    factor: f64,
    slopes: &'a mut [Slopes],
}

impl pulp::NullaryFnOnce for AddSlopes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (y, factor) = (self.at, self.factor);
        for (group, slopes) in self.groups.iter().zip(self.slopes) {
            let mut sums = *slopes;
            for lane in 0..LANES {
                let Contact { u, f, at, .. } = group.contact(lane, y, self.cone);
                let scaled = factor * group.stiffness[lane];
                // The potential depends on the normal through n·u and |t|² = |u|² − (n·u)², where u is the motion alone:
                // ∂ψ/∂a da + ∂ψ/∂T dT with da = u·dn, dT = −(a/T) u·dn.
                let by_normal = scaled * (at.along - at.p * at.normal);
                let parts = [
                    factor * at.value,
                    // ∂u/∂a: f·(y_τ × da) = da·(f × y_τ).
                    scaled * (f[1] * y[5] - f[2] * y[4]),
                    scaled * (f[2] * y[3] - f[0] * y[5]),
                    scaled * (f[0] * y[4] - f[1] * y[3]),
                    by_normal * u[0],
                    by_normal * u[1],
                    by_normal * u[2],
                ];
                for (sum, part) in sums.iter_mut().zip(parts) {
                    sum[lane] -= part;
                }
            }
            *slopes = sums;
        }
    }
}

/// The dual function, its gradient and the negative of its second derivative at a motion.
struct Dual {
    value: f64,
    gradient: [f64; 6],
    curvature: Lower,
}

impl Dual {
    fn at(groups: &[Group], load: &[f64; 6], y: &[f64; 6], support: f64, cone: &Cone) -> Self {
        // The widest vector instructions of the processor: without fused multiplication they give the same bits.
        let sums = pulp::Arch::new().dispatch(Sums {
            groups,
            at: y,
            cone,
        });
        let mut curvature = multiple(support);
        for (k, (i, j)) in CURVATURE.into_iter().enumerate() {
            curvature[i][j] += sums[7 + k];
        }
        Self {
            value: dot(y, load) - 0.5 * support * dot(y, y) - sums[0],
            gradient: std::array::from_fn(|k| load[k] - y[k] * support - sums[1 + k]),
            curvature,
        }
    }
}

fn dot(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64; 6]) -> f64 {
    dot(a, a).sqrt()
}

/// Places of the second derivatives in the order of their sums.
const CURVATURE: [(usize, usize); 21] = [
    (0, 0),
    (1, 0),
    (2, 0),
    (1, 1),
    (2, 1),
    (2, 2),
    (3, 0),
    (3, 1),
    (3, 2),
    (4, 0),
    (4, 1),
    (4, 2),
    (5, 0),
    (5, 1),
    (5, 2),
    (3, 3),
    (4, 3),
    (5, 3),
    (4, 4),
    (5, 4),
    (5, 5),
];

/// The y that maximises the dual function, and the maximum.
fn maximise(
    groups: &[Group],
    load: &[f64; 6],
    start: [f64; 6],
    support: f64,
    cone: &Cone,
) -> ([f64; 6], f64) {
    let moved = |y: &[f64; 6], step: &[f64; 6], length: f64| -> [f64; 6] {
        std::array::from_fn(|k| y[k] + step[k] * length)
    };
    let mut y = start;
    let mut at = Dual::at(groups, load, &y, support, cone);
    let last = LAST_REMAINDER * norm(load);
    for _ in 0..MOST_STEPS {
        let Some(factors) = Factors::of(&at.curvature) else {
            break;
        };
        let remainder = norm(&at.gradient);
        let step = factors.solve(&at.gradient);
        let slope = dot(&step, &at.gradient);
        if remainder <= last {
            // The maximum of the quadratic.
            return (moved(&y, &step, 1.0), at.value + 0.5 * slope);
        }
        let mut length = 1.0;
        let mut better = None;
        for _ in 0..MOST_HALVINGS {
            let tried = moved(&y, &step, length);
            let found = Dual::at(groups, load, &tried, support, cone);
            if found.value >= at.value + 1e-4 * length * slope
                || norm(&found.gradient) < 0.5 * remainder
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
    (y, at.value)
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
/// f are contact forces, G their wrenches, W the stiffness of the contacts and P the projection on the friction cone, whose
/// potential ½ |P|² is rounded (`Potential`). In the second form, which is dual to the first, y is the motion of the object:
/// contacts are springs that push and rub but never pull, and κ is the compliance of a weak support that holds an object
/// without contacts. W multiplies there, so a contact that comes or goes does so smoothly. The maximum is unique. Newton's
/// method finds it from the solution of the layer whose contacts all stick, so that the result depends on the arguments
/// alone. Derivatives follow from the envelope theorem.
///
/// Where all contacts stick, the matrix of the second form is the stiffness of the grasp, Σ W G Gᵀ, of Cutkosky and Kao
/// (*IEEE Transactions on Robotics and Automation* 5, 151, 1989) for stiff digits with soft skin. That contacts slide at
/// the edge of their cones, the weak support, the eight loads and the mean of roots are ours.
pub fn mean_compliance(
    nodes: &[Node],
    axes: &Matrix3<f64>,
    settings: &ComplianceSettings,
) -> Compliance {
    let springs = Springs::of(nodes, settings);
    let mut slopes = vec![[[0.0; LANES]; 7]; springs.groups.len()];
    let c = springs.rounding;
    let (mut free, mut value) = (0.0, 0.0);
    let mut by_rotation = Vector3::zeros();
    for k in 0..8 {
        let direction = axes * Vector3::from(DIRECTIONS[k % 4]) / 3.0_f64.sqrt();
        let (first, size) = if k < 4 {
            (0, settings.load)
        } else {
            (3, settings.load * settings.torque_share)
        };
        let force = direction * size;
        let mut load = [0.0; 6];
        load[first..first + 3].copy_from_slice(force.as_slice());
        free += springs.free_root(size);
        let (y, compliance) = springs.under(&load);
        let root = (compliance.max(0.0) + c).sqrt();
        value += root - c.sqrt();
        let factor = 0.5 / root;
        pulp::Arch::new().dispatch(AddSlopes {
            groups: &springs.groups,
            at: &y,
            cone: &springs.cone,
            factor,
            slopes: &mut slopes,
        });
        let turned = Vector3::new(y[first], y[first + 1], y[first + 2]);
        by_rotation += force.cross(&turned) * factor;
    }
    let part = |k: usize| {
        let all = slopes.iter().flat_map(move |slopes| slopes[k]);
        all.take(nodes.len()).map(|sum| sum / free)
    };
    let vectors = |first: usize| -> Vec<Vector3<f64>> {
        let all = part(first).zip(part(first + 1)).zip(part(first + 2));
        all.map(|((x, y), z)| Vector3::new(x, y, z)).collect()
    };
    Compliance {
        value: value / free,
        by_stiffness: part(0).collect(),
        by_arm: vectors(1),
        by_normal: vectors(4),
        by_rotation: by_rotation / free,
    }
}

/// Contacts as springs beside the weak support.
struct Springs {
    groups: Vec<Group>,
    /// The stiffness where all contacts stick.
    stuck: Option<Factors>,
    cone: Cone,
    /// Stiffness of the support.
    support: f64,
    /// c in the formula of [`mean_compliance`].
    rounding: f64,
}

impl Springs {
    fn of(nodes: &[Node], settings: &ComplianceSettings) -> Self {
        let support = settings.load / settings.free_motion;
        let mut stuck = multiple(support);
        for node in nodes {
            add_stuck(&mut stuck, node.stiffness, &node.arm);
        }
        Self {
            groups: nodes.chunks(LANES).map(Group::of).collect(),
            stuck: Factors::of(&stuck),
            cone: Cone::new(settings.friction, settings.friction_rounding),
            support,
            rounding: settings.rounding * 0.5 * settings.load * settings.free_motion,
        }
    }

    /// The motion y of the object under a load, and C.
    fn under(&self, load: &[f64; 6]) -> ([f64; 6], f64) {
        let start = self.stuck.as_ref().map_or([0.0; 6], |s| s.solve(load));
        maximise(&self.groups, load, start, self.support, &self.cone)
    }

    /// √(C + c) − √c.
    fn root(&self, compliance: f64) -> f64 {
        (compliance.max(0.0) + self.rounding).sqrt() - self.rounding.sqrt()
    }

    /// The same for the support alone under a load of this size.
    fn free_root(&self, size: f64) -> f64 {
        self.root(0.5 * size * size / self.support)
    }
}

/// How much an elastic layer gives under single loads, of 1 for a hand that has let go.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LoadCompliance {
    /// The greatest under a force on the object's centroid, over 14 directions.
    pub force: f64,
    /// The mean under a torque, over 14 directions.
    pub torque: f64,
}

/// The compliance of `nodes` under single loads: forces and torques along ± each of the `axes` and the diagonals between
/// them.
///
/// ```text
/// c(v) = (√(C(v) + c) − √c) / (√(C₀(v) + c) − √c)
/// ```
///
/// with the C of [`mean_compliance`]. That mean hides a single direction in which a hand does not hold; the greatest over
/// forces shows it. Of torques the mean is taken, since hardly any hand resists the torque about the axis of a thin rod.
pub fn load_compliance(
    nodes: &[Node],
    axes: &Matrix3<f64>,
    settings: &ComplianceSettings,
) -> LoadCompliance {
    let springs = Springs::of(nodes, settings);
    let diagonals = DIRECTIONS.map(|direction| Vector3::from(direction) / 3.0_f64.sqrt());
    let along = [Vector3::x(), Vector3::y(), Vector3::z()];
    let directions = along.into_iter().chain(diagonals);
    let directions: Vec<_> = directions.flat_map(|u| [axes * u, -(axes * u)]).collect();
    let under = |first: usize, size: f64| {
        let (springs, free) = (&springs, springs.free_root(size));
        directions.iter().map(move |direction| {
            let mut load = [0.0; 6];
            load[first..first + 3].copy_from_slice((direction * size).as_slice());
            springs.root(springs.under(&load).1) / free
        })
    };
    let torques = under(3, settings.load * settings.torque_share);
    LoadCompliance {
        force: under(0, settings.load).fold(0.0, f64::max),
        torque: torques.sum::<f64>() / directions.len() as f64,
    }
}

#[cfg(test)]
mod tests;
