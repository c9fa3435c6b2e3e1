//! Hand poses: SE(3) × joints, modulo the symmetry of the object.

use nalgebra::{Isometry3, Unit, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::coordinates::{joints_of, joints_of_mut, put_root, rotation_of, translation_of};
use super::rotation::{any_normal, axes, exp, log, other_way};
use super::torus::wrap;
use super::{Space, Symmetry};

/// Lengths that convert rotations of the hand and its joints into motion of its surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoseMetric {
    /// Centroid of the surface points in the rest pose, hand (root) frame, metres.
    pub centroid: Vector3<f64>,
    /// Radius of gyration r of the surface points about the centroid, metres.
    pub radius_of_gyration_m: f64,
    /// `ℓ_j`: root-mean-square lever of each joint over *all* surface points, metres per radian. Defines the metric.
    pub joint_levers_m: Vec<f64>,
    /// Root-mean-square lever of each joint over the points it moves, metres per radian. Defines the step scales.
    pub joint_reaches_m: Vec<f64>,
    /// The same for a rotation of the whole hand, metres per radian (about 0.08 for a human hand).
    pub rotation_reach_m: f64,
    /// Whether each joint has no limits and therefore wraps at ±π.
    pub wraps: Vec<bool>,
}

/// The space of hand poses: a point is `[tx, ty, tz, qw, qx, qy, qz, joints…]`, the transform `object_from_hand` of the
/// hand's root frame and the joint angles (7 + k numbers, metres and radians, w ≥ 0).
///
/// ```text
/// tangent = (Δp, r ω, ℓ₁ Δθ₁, …, ℓ_k Δθ_k)   (6 + k, all metres),   p = t + R c₀
/// Exp:  p' = p + Δp,   R' = R exp(ω),   t' = p' − R' c₀,   θ' = θ + Δθ
/// ```
///
/// p: centroid of the rest-pose surface points in the object's frame; ω: in the hand's own frame; c₀, r, `ℓ_j`:
/// [`PoseMetric`]. Geodesics are those of ℝ³ × SO(3) × joints. Joints without limits wrap, all others are never clamped.
///
/// Distance and direction are taken modulo the [`Symmetry`] of the object, at the global optimum. Two rotations exactly
/// half a turn apart are joined about the axis whose first non-zero component is positive (hand frame);
/// [`Space::log_other_way`] gives the other path.
#[derive(Debug, Clone)]
pub struct PoseSpace {
    metric: PoseMetric,
    symmetry: Symmetry,
}

/// A rigid hand: position of the centroid and orientation, object frame.
#[derive(Clone, Copy)]
struct Rigid {
    centroid: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
}

impl PoseSpace {
    /// Poses measured by `metric`, modulo `symmetry`.
    ///
    /// # Panics
    /// If the lists of the metric differ in length, a length in it is not positive and finite, or the direction of an axis
    /// is zero.
    pub fn new(metric: PoseMetric, symmetry: Symmetry) -> Self {
        let joints = metric.joint_levers_m.len();
        assert_eq!(
            (metric.joint_reaches_m.len(), metric.wraps.len()),
            (joints, joints),
            "one entry a joint"
        );
        let lengths = metric.joint_levers_m.iter().chain(&metric.joint_reaches_m);
        for length in lengths.chain([&metric.radius_of_gyration_m, &metric.rotation_reach_m]) {
            assert!(
                *length > 0.0 && length.is_finite(),
                "a lever of {length} m measures nothing"
            );
        }
        Self {
            metric,
            symmetry: symmetry.normalized(),
        }
    }

    /// The metric.
    pub fn metric(&self) -> &PoseMetric {
        &self.metric
    }

    /// The symmetry of the object, with its axis of unit length.
    pub fn symmetry(&self) -> &Symmetry {
        &self.symmetry
    }

    /// The copy of `b` under the object's symmetry that is nearest to `a`.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn align(&self, a: &[f64], b: &[f64]) -> Vec<f64> {
        let mut copy = b.to_vec();
        if !matches!(self.symmetry, Symmetry::None) {
            let from = self.rigid(a);
            let (step, turn) = self.rigid_log(&from, &self.rigid(b));
            let rotation = from.rotation * exp(&turn);
            let origin = from.centroid + step - rotation * self.metric.centroid;
            put_root(&mut copy, &origin, &rotation);
        }
        copy
    }

    fn rigid(&self, x: &[f64]) -> Rigid {
        assert_eq!(x.len(), self.coordinates(), "coordinates of a pose");
        let rotation = rotation_of(x);
        Rigid {
            centroid: translation_of(x) + rotation * self.metric.centroid,
            rotation,
        }
    }

    /// Translation of the centroid (object frame, metres) and rotation vector (hand frame, radians) from `a` to the nearest
    /// copy of `b`.
    fn rigid_log(&self, a: &Rigid, b: &Rigid) -> (Vector3<f64>, Vector3<f64>) {
        let radius = self.metric.radius_of_gyration_m;
        match &self.symmetry {
            Symmetry::None => plain_log(a, b),
            Symmetry::Axis { point, direction } => axis_log(a, b, point, direction, radius),
            Symmetry::Sphere { centre } => sphere_log(a, b, centre, radius),
            Symmetry::Finite(group) => finite_log(a, b, group, radius),
        }
    }

    fn joint_steps<'a>(&'a self, a: &'a [f64], b: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let scales = self.metric.joint_levers_m.iter().zip(&self.metric.wraps);
        (joints_of(a).iter().zip(joints_of(b)))
            .zip(scales)
            .map(|((from, to), (lever, wraps))| {
                lever * if *wraps { wrap(to - from) } else { to - from }
            })
    }

    fn write_tangent(
        &self,
        a: &[f64],
        b: &[f64],
        step: &Vector3<f64>,
        turn: &Vector3<f64>,
        tangent: &mut [f64],
    ) -> f64 {
        assert_eq!(tangent.len(), self.tangents(), "tangents of a pose");
        tangent[..3].copy_from_slice(step.as_slice());
        tangent[3..6].copy_from_slice((turn * self.metric.radius_of_gyration_m).as_slice());
        for (component, joint) in tangent[6..].iter_mut().zip(self.joint_steps(a, b)) {
            *component = joint;
        }
        tangent
            .iter()
            .map(|component| component * component)
            .sum::<f64>()
            .sqrt()
    }
}

impl Space for PoseSpace {
    fn coordinates(&self) -> usize {
        7 + self.metric.joint_levers_m.len()
    }

    fn tangents(&self) -> usize {
        6 + self.metric.joint_levers_m.len()
    }

    fn exp(&self, x: &mut [f64], tangent: &[f64]) {
        assert_eq!(tangent.len(), self.tangents(), "tangents of a pose");
        let from = self.rigid(x);
        let turn = Vector3::from_column_slice(&tangent[3..6]) / self.metric.radius_of_gyration_m;
        let rotation = from.rotation * exp(&turn);
        let origin = from.centroid + Vector3::from_column_slice(&tangent[..3])
            - rotation * self.metric.centroid;
        put_root(x, &origin, &rotation);
        let scales = self.metric.joint_levers_m.iter().zip(&self.metric.wraps);
        let joints = joints_of_mut(x).iter_mut().zip(&tangent[6..]);
        for ((angle, step), (lever, wraps)) in joints.zip(scales) {
            *angle += step / lever;
            if *wraps {
                *angle = wrap(*angle);
            }
        }
    }

    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        let (step, turn) = self.rigid_log(&self.rigid(a), &self.rigid(b));
        self.write_tangent(a, b, &step, &turn, tangent)
    }

    fn log_other_way(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> Option<f64> {
        let (step, turn) = self.rigid_log(&self.rigid(a), &self.rigid(b));
        let turn = other_way(&turn)?;
        Some(self.write_tangent(a, b, &step, &turn, tangent))
    }

    fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let (step, turn) = self.rigid_log(&self.rigid(a), &self.rigid(b));
        let rigid = squared_length(&(step, turn), self.metric.radius_of_gyration_m);
        (rigid
            + self
                .joint_steps(a, b)
                .map(|joint| joint * joint)
                .sum::<f64>())
        .sqrt()
    }

    /// The joints and, if the object has no symmetry, the position and orientation of the hand.
    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        let rigid = self.rigid(x);
        let scales = self.metric.joint_levers_m.iter().zip(&self.metric.wraps);
        let mut landmarks: Vec<f64> = (joints_of(x).iter().zip(scales))
            .flat_map(|(angle, (lever, wraps))| {
                if *wraps {
                    [lever * libm::cos(*angle), lever * libm::sin(*angle)]
                } else {
                    [lever * angle, 0.0]
                }
            })
            .collect();
        if matches!(self.symmetry, Symmetry::None) {
            landmarks.extend(rigid.centroid.iter());
            landmarks.extend(axes(&rigid.rotation, self.metric.radius_of_gyration_m));
        }
        landmarks
    }

    fn step_scales(&self) -> Vec<f64> {
        let rotation = self.metric.radius_of_gyration_m / self.metric.rotation_reach_m;
        let joints = self
            .metric
            .joint_levers_m
            .iter()
            .zip(&self.metric.joint_reaches_m);
        [1.0; 3]
            .into_iter()
            .chain([rotation; 3])
            .chain(joints.map(|(lever, reach)| lever / reach))
            .collect()
    }
}

fn squared_length((step, turn): &(Vector3<f64>, Vector3<f64>), radius: f64) -> f64 {
    step.norm_squared() + radius * radius * turn.norm_squared()
}

fn plain_log(a: &Rigid, b: &Rigid) -> (Vector3<f64>, Vector3<f64>) {
    (
        b.centroid - a.centroid,
        log(&(a.rotation.inverse() * b.rotation)),
    )
}

fn finite_log(
    a: &Rigid,
    b: &Rigid,
    group: &[Isometry3<f64>],
    radius: f64,
) -> (Vector3<f64>, Vector3<f64>) {
    let mut best = plain_log(a, b);
    for element in group {
        let copy = Rigid {
            centroid: element.rotation * b.centroid + element.translation.vector,
            rotation: element.rotation * b.rotation,
        };
        let candidate = plain_log(a, &copy);
        if squared_length(&candidate, radius) < squared_length(&best, radius) {
            best = candidate;
        }
    }
    best
}

/// If b is rotated by φ about the axis, the squared distance is
///
/// ```text
/// d²(φ) = const − 2K cos(φ − φ₀) + 4r² acos²(ρ cos((φ − 2β)/2))
/// ```
///
/// The first term is that of the positions; the second contains the scalar part ρ cos(φ/2 − β) of the quaternion between
/// the two orientations. [`balance`] finds the minimum between the centres φ₀ and 2β of the two terms.
fn axis_log(
    a: &Rigid,
    b: &Rigid,
    point: &Vector3<f64>,
    direction: &Vector3<f64>,
    radius: f64,
) -> (Vector3<f64>, Vector3<f64>) {
    let (arm_a, arm_b) = (a.centroid - point, b.centroid - point);
    let cosine = arm_a.dot(&arm_b) - arm_a.dot(direction) * arm_b.dot(direction);
    let sine = direction.dot(&arm_b.cross(&arm_a));
    let between = b.rotation * a.rotation.inverse();
    let along = between.imag().dot(direction);
    let across = (between.imag() - direction * along).norm();
    let twist = 2.0 * libm::atan2(-along, between.w);
    let offset = wrap(libm::atan2(sine, cosine) - twist);
    let pull = libm::hypot(cosine, sine) / (radius * radius);
    let angle =
        twist + balance(pull, libm::hypot(between.w, along), across, offset.abs()).copysign(offset);
    let turn = UnitQuaternion::from_axis_angle(&Unit::new_unchecked(*direction), angle);
    let copy = Rigid {
        centroid: point + turn * arm_b,
        rotation: turn * b.rotation,
    };
    plain_log(a, &copy)
}

/// Minimises `|v_a − W v_b|² + r² angle(W)²` over all rotations W between the hands, where v is the arm from the centre to
/// the centroid in the hand's own frame. For a given angle the best W rotates `v_b` directly toward `v_a`.
fn sphere_log(
    a: &Rigid,
    b: &Rigid,
    centre: &Vector3<f64>,
    radius: f64,
) -> (Vector3<f64>, Vector3<f64>) {
    let arm_a = a.rotation.inverse() * (a.centroid - centre);
    let arm_b = b.rotation.inverse() * (b.centroid - centre);
    let normal = arm_b.cross(&arm_a);
    let (sine, cosine) = (normal.norm(), arm_a.dot(&arm_b));
    let angle = balance(
        libm::hypot(cosine, sine) / (radius * radius),
        1.0,
        0.0,
        libm::atan2(sine, cosine),
    );
    let axis = if sine > 0.0 {
        normal / sine
    } else {
        any_normal(&arm_b)
    };
    let turn = axis * angle;
    (a.rotation * (exp(&turn) * arm_b - arm_a), turn)
}

/// Minimiser ψ ∈ [0, δ] of −2κ cos(δ − ψ) + 4 acos²(ρ cos(ψ/2)) for κ ≥ 0, δ ∈ [0, π], ρ² + σ² = 1, ρ ≥ 0.
///
/// This is the global minimum over the circle: beyond [0, δ] both terms grow, or the mirrored angle is better. Inside,
/// the derivative vanishes where
///
/// ```text
/// 2ρ x/sin x = κ sin(δ − ψ)/sin(ψ/2),   cos x = ρ cos(ψ/2)
/// ```
///
/// The left side never falls and the right side never rises with ψ, so there is one solution, and a bracketed Newton
/// iteration finds it. With δ = π exactly, ±ψ are equally good.
fn balance(kappa: f64, rho: f64, sigma: f64, delta: f64) -> f64 {
    if kappa == 0.0 || delta == 0.0 {
        return 0.0;
    }
    if rho == 0.0 {
        return delta;
    }
    let (mut low, mut high) = (0.0, delta);
    let mut psi = delta * kappa / (kappa + rho);
    for _ in 0..100 {
        let (s, c) = libm::sincos(0.5 * psi);
        let sin_x = libm::hypot(s, sigma * c);
        let cos_x = rho * c;
        let x = libm::atan2(sin_x, cos_x);
        // x/sin x and its derivative; the series is exact to rounding below 1e-4 (next term x⁴/51).
        let (ratio, ratio_slope) = if sin_x < 1e-4 {
            (1.0 + x * x / 6.0, x / 3.0)
        } else {
            (x / sin_x, (sin_x - x * cos_x) / (sin_x * sin_x))
        };
        let x_slope = if sin_x > 0.0 {
            0.5 * rho * s / sin_x
        } else {
            0.5
        };
        let (pull, pull_slope) = libm::sincos(delta - psi);
        let value = 2.0 * rho * s * ratio - kappa * pull;
        let slope = rho * (c * ratio + 2.0 * s * ratio_slope * x_slope) + kappa * pull_slope;
        if value < 0.0 {
            low = psi;
        } else {
            high = psi;
        }
        let newton = psi - value / slope;
        let next = if (low..=high).contains(&newton) {
            newton
        } else {
            0.5 * (low + high)
        };
        let step = (next - psi).abs();
        psi = next;
        // Newton's error is squared in each step, so after a step of 1e-9 no accuracy is left to gain.
        if step <= 1e-9 * delta {
            break;
        }
    }
    psi
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use nalgebra::Translation3;
    use rand::RngExt;

    use super::*;
    use crate::sample::{Rng, Task, stream};
    use crate::space::{object_from_hand, pose_coordinates};

    fn metric() -> PoseMetric {
        PoseMetric {
            centroid: Vector3::new(0.01, -0.02, 0.07),
            radius_of_gyration_m: 0.056,
            joint_levers_m: vec![0.02, 0.002],
            joint_reaches_m: vec![0.05, 0.02],
            rotation_reach_m: 0.08,
            wraps: vec![false, true],
        }
    }

    fn random_pose(rng: &mut Rng) -> Vec<f64> {
        let mut number = || rng.random_range(-1.0..1.0);
        let rotation = exp(&(Vector3::new(number(), number(), number()) * PI));
        let hand = Isometry3::from_parts(
            Translation3::new(0.1 * number(), 0.1 * number(), 0.1 * number()),
            rotation,
        );
        pose_coordinates(&hand, &[number(), PI * number()])
    }

    fn moved(x: &[f64], by: &Isometry3<f64>) -> Vec<f64> {
        pose_coordinates(&(by * object_from_hand(x)), joints_of(x))
    }

    fn turn_about(point: &Vector3<f64>, turn: &Vector3<f64>) -> Isometry3<f64> {
        let rotation = exp(turn);
        Isometry3::from_parts((point - rotation * point).into(), rotation)
    }

    #[test]
    fn a_rotation_turns_the_hand_about_its_centroid() {
        let space = PoseSpace::new(metric(), Symmetry::None);
        let mut x = pose_coordinates(&Isometry3::translation(0.1, 0.2, 0.3), &[0.0, 0.0]);
        let centroid = object_from_hand(&x) * nalgebra::Point3::from(metric().centroid);
        space.exp(
            &mut x,
            &[0.0, 0.0, 0.0, 0.056 * 1.2, 0.0, 0.0, 0.02 * 0.3, 0.0],
        );
        let after = object_from_hand(&x) * nalgebra::Point3::from(metric().centroid);
        approx::assert_abs_diff_eq!(centroid, after, epsilon = 1e-15);
        approx::assert_abs_diff_eq!(x[3], libm::cos(0.6_f64), epsilon = 1e-15);
        approx::assert_abs_diff_eq!(x[7], 0.3, epsilon = 1e-15);
    }

    #[test]
    fn scales_are_levers_over_reaches() {
        let scales = PoseSpace::new(metric(), Symmetry::None).step_scales();
        let expected = [1.0, 1.0, 1.0, 0.7, 0.7, 0.7, 0.4, 0.1];
        approx::assert_abs_diff_eq!(scales.as_slice(), expected.as_slice(), epsilon = 1e-15);
    }

    /// The solver against a dense search over the angle: never above the best of the grid, below it by no more than the
    /// grid's own error.
    #[test]
    fn axis_alignment_is_the_global_minimum() {
        let point = Vector3::new(0.02, 0.01, 0.0);
        let direction = Vector3::new(0.3, -0.2, 2.0);
        let modulo = PoseSpace::new(metric(), Symmetry::Axis { point, direction });
        let plain = PoseSpace::new(metric(), Symmetry::None);
        let mut rng = stream(1, Task::Start, 0);
        for _ in 0..300 {
            let (a, b) = (random_pose(&mut rng), random_pose(&mut rng));
            let copy = |k: u32| {
                moved(
                    &b,
                    &turn_about(
                        &point,
                        &(direction.normalize() * f64::from(k) * TAU / 720.0),
                    ),
                )
            };
            let grid = (0..720)
                .map(|k| plain.distance(&a, &copy(k)))
                .fold(f64::INFINITY, f64::min);
            let distance = modulo.distance(&a, &b);
            assert!(
                distance <= grid + 1e-14,
                "{distance} is not the minimum, {grid} is less"
            );
            // The grid is at most half a step off, which moves the hand by at most (arm + r) · step/2.
            assert!(grid - distance < 0.4 * PI / 720.0);
        }
    }

    #[test]
    fn sphere_alignment_is_the_minimum() {
        let centre = Vector3::new(0.02, 0.01, -0.03);
        let modulo = PoseSpace::new(metric(), Symmetry::Sphere { centre });
        let plain = PoseSpace::new(metric(), Symmetry::None);
        let mut rng = stream(2, Task::Start, 0);
        for _ in 0..100 {
            let (a, b) = (random_pose(&mut rng), random_pose(&mut rng));
            let best = modulo.align(&a, &b);
            let distance = modulo.distance(&a, &b);
            approx::assert_abs_diff_eq!(plain.distance(&a, &best), distance, epsilon = 1e-14);
            for size in [1e-3, 0.1, 3.0] {
                for _ in 0..30 {
                    let turn = Vector3::from_fn(|_, _| size * rng.random_range(-1.0..1.0));
                    let other = moved(&best, &turn_about(&centre, &turn));
                    assert!(plain.distance(&a, &other) >= distance - 1e-14);
                }
            }
        }
    }

    #[test]
    fn half_turns_of_a_box_are_the_same_grasp() {
        let group = [Vector3::x(), Vector3::y(), Vector3::z()]
            .map(|axis| turn_about(&Vector3::zeros(), &(axis * PI)));
        let space = PoseSpace::new(metric(), Symmetry::Finite(group.to_vec()));
        let a = random_pose(&mut stream(3, Task::Start, 0));
        for element in &group {
            let b = moved(&a, element);
            assert!(space.distance(&a, &b) < 1e-15);
            let copy = space.align(&a, &b);
            approx::assert_abs_diff_eq!(copy.as_slice(), a.as_slice(), epsilon = 1e-15);
        }
    }

    #[test]
    fn hands_on_the_axis_and_hands_back_to_back_have_a_distance() {
        let space = PoseSpace::new(
            PoseMetric {
                centroid: Vector3::zeros(),
                ..metric()
            },
            Symmetry::Axis {
                point: Vector3::zeros(),
                direction: Vector3::z(),
            },
        );
        let pose = |x: f64, turn: Vector3<f64>| {
            pose_coordinates(&Isometry3::new(Vector3::x() * x, turn), &[0.0, 0.0])
        };
        let upright = pose(0.1, Vector3::zeros());
        // On the axis only the tilt counts.
        assert!(space.distance(&pose(0.0, Vector3::zeros()), &pose(0.0, Vector3::z())) < 1e-16);
        // Opposite place, same orientation: walking round turns the hand, so something between is shortest.
        let opposite = space.distance(&upright, &pose(-0.1, Vector3::zeros()));
        assert!(opposite < 0.056 * PI && opposite > 0.1, "{opposite}");
        // Head down: half a turn whatever φ, so the place decides and costs nothing.
        let down = space.distance(&upright, &pose(-0.1, Vector3::x() * PI));
        approx::assert_abs_diff_eq!(down, 0.056 * PI, epsilon = 1e-15);
    }
}
