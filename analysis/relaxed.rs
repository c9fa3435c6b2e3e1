//! Relaxed force closure of any number of contact points on a shape, with its derivative, without a hand.

use nalgebra::{Matrix3, Matrix6, Vector3};

use landscape::grasp::closure::{PointContact, RANK_EPSILON};
use landscape::object::{Object, Shape};

/// The relaxed force-closure test of points pᵢ on a shape with signed distance d.
///
/// ```text
/// FC = w_rank max(0, ε − λ_min(GGᵀ)) + √(‖Gc‖² + r²) − r + w Σᵢ (√(d(pᵢ)² + r_d²) − r_d) / unit
/// cᵢ = −∇d/‖∇d‖ at pᵢ,   aᵢ = (pᵢ − centroid) / unit,   Gc = Σᵢ (cᵢ, aᵢ × cᵢ),   G = [I … I; [a₁]ₓ … [aₙ]ₓ]
/// ```
///
/// Dimensionless; zero exactly if the points are on the surface, their normals balance, and they span all wrenches. Liu et
/// al. (2021), Eq. 7, has `r = r_d = 0` and `w_rank = w = 1`. A set whose FC without the distance term is small needs
/// little friction (see [`least_friction`](landscape::grasp::closure::least_friction)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RelaxedForceClosure {
    /// Centre of torques, metres: the object's centroid.
    pub(crate) centroid: Vector3<f64>,
    /// Length unit of arms and distances, metres: the object's radius.
    pub(crate) unit_m: f64,
    /// Weight of the rank condition.
    pub(crate) rank_weight: f64,
    /// Threshold ε of the rank condition.
    pub(crate) rank_epsilon: f64,
    /// Rounding r of the net wrench.
    pub(crate) rounding: f64,
    /// Weight w of distances from the surface.
    pub(crate) distance_weight: f64,
    /// Rounding `r_d` of distances, metres.
    pub(crate) distance_rounding_m: f64,
}

/// A contact point with the shape's distance and derivatives there, and the derivative of FC.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touch {
    /// Position, metres.
    pub(crate) point: Vector3<f64>,
    /// Signed distance to the shape, metres.
    pub(crate) distance_m: f64,
    /// Gradient of the signed distance.
    pub(crate) gradient: Vector3<f64>,
    /// Hessian of the signed distance, 1/m.
    pub(crate) hessian: Matrix3<f64>,
    /// ∂FC/∂p, 1/m.
    pub(crate) force: Vector3<f64>,
}

impl Touch {
    /// A point that is not measured yet.
    pub(crate) fn at(point: Vector3<f64>) -> Self {
        Self {
            point,
            distance_m: 0.0,
            gradient: Vector3::zeros(),
            hessian: Matrix3::zeros(),
            force: Vector3::zeros(),
        }
    }

    /// Computes distance, gradient and Hessian of `shape` at the point.
    pub(crate) fn measure<S: Shape + ?Sized>(&mut self, shape: &S) {
        (self.distance_m, self.gradient, self.hessian) = shape.hessian(&self.point);
    }
}

impl RelaxedForceClosure {
    /// Eq. 7 as printed.
    pub(crate) fn paper(centroid: Vector3<f64>, unit_m: f64) -> Self {
        Self {
            centroid,
            unit_m,
            rank_weight: 1.0,
            rank_epsilon: RANK_EPSILON,
            rounding: 0.0,
            distance_weight: 1.0,
            distance_rounding_m: 0.0,
        }
    }

    /// Eq. 7 as printed, with the centroid and radius of `object`.
    pub(crate) fn of_object(object: &Object) -> Self {
        Self::paper(object.centroid, object.radius_m)
    }

    /// FC of `points`, without curvature.
    pub(crate) fn value<S: Shape + ?Sized>(&self, shape: &S, points: &[Vector3<f64>]) -> f64 {
        let answers = points.iter().map(|point| {
            let (distance_m, gradient) = shape.gradient(point);
            (*point, distance_m, gradient)
        });
        self.value_of(answers)
    }

    /// FC of points whose signed distance (metres) and its gradient are known.
    pub(crate) fn value_of(
        &self,
        answers: impl IntoIterator<Item = (Vector3<f64>, f64, Vector3<f64>)>,
    ) -> f64 {
        let mut sums = Sums::default();
        for (point, distance_m, gradient) in answers {
            self.add(&mut sums, &point, distance_m, &gradient);
        }
        let rank = sums.moments.lack_of_rank(self.rank_epsilon);
        self.total(&sums, rank.as_ref())
    }

    /// Measures `touches` on `shape`, returns their FC, and stores the derivatives in them.
    pub(crate) fn value_and_forces<S: Shape + ?Sized>(
        &self,
        shape: &S,
        touches: &mut [Touch],
    ) -> f64 {
        for touch in &mut *touches {
            touch.measure(shape);
        }
        self.forces(touches)
    }

    /// FC of measured `touches`; stores the derivatives in them, which contain the curvature as it turns the normals.
    pub(crate) fn forces(&self, touches: &mut [Touch]) -> f64 {
        let mut sums = Sums::default();
        for touch in &*touches {
            self.add(&mut sums, &touch.point, touch.distance_m, &touch.gradient);
        }
        let rank = sums.moments.lack_of_rank(self.rank_epsilon);
        let root = hypotenuse(sums.net_wrench_squared(), self.rounding);
        // If the contacts balance without rounding, zero is a subgradient.
        let slope = if root > 0.0 { 1.0 / root } else { 0.0 };
        let [by_force, by_torque] = [sums.force * slope, sums.torque * slope];
        let per_metre = 1.0 / self.unit_m;
        for touch in &mut *touches {
            let contact = self.contact(&touch.point, &touch.gradient);
            let by_normal = by_force + by_torque.cross(&contact.arm);
            let mut by_arm = contact.inward_normal.cross(&by_torque);
            if let Some(lack) = &rank {
                by_arm += lack.by_arm(&contact.arm) * self.rank_weight;
            }
            let root = hypotenuse(touch.distance_m.powi(2), self.distance_rounding_m);
            let by_distance = if root > 0.0 {
                self.distance_weight * per_metre * touch.distance_m / root
            } else {
                0.0
            };
            touch.force = by_arm * per_metre
                + by_turning(&touch.gradient, &touch.hessian, &by_normal)
                + touch.gradient * by_distance;
        }
        self.total(&sums, rank.as_ref())
    }

    /// The contact at a point with the given gradient of the signed distance.
    pub(crate) fn contact(&self, point: &Vector3<f64>, gradient: &Vector3<f64>) -> PointContact {
        PointContact {
            arm: (point - self.centroid) * (1.0 / self.unit_m),
            inward_normal: inward_normal(gradient),
        }
    }

    fn add(&self, sums: &mut Sums, point: &Vector3<f64>, distance_m: f64, gradient: &Vector3<f64>) {
        let contact = self.contact(point, gradient);
        sums.force += contact.inward_normal;
        sums.torque += contact.arm.cross(&contact.inward_normal);
        sums.moments.add(&contact.arm);
        sums.distance_m +=
            hypotenuse(distance_m.powi(2), self.distance_rounding_m) - self.distance_rounding_m;
    }

    fn total(&self, sums: &Sums, rank: Option<&LackOfRank>) -> f64 {
        rank.map_or(0.0, |lack| self.rank_weight * lack.value)
            + (hypotenuse(sums.net_wrench_squared(), self.rounding) - self.rounding)
            + self.distance_weight * sums.distance_m / self.unit_m
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    force: Vector3<f64>,
    torque: Vector3<f64>,
    moments: Moments,
    distance_m: f64,
}

impl Sums {
    fn net_wrench_squared(&self) -> f64 {
        self.force.norm_squared() + self.torque.norm_squared()
    }
}

/// √(s² + r²), given s².
fn hypotenuse(squared: f64, rounding: f64) -> f64 {
    (squared + rounding * rounding).sqrt()
}

/// −g/‖g‖, or zero if the gradient is zero.
fn inward_normal(gradient: &Vector3<f64>) -> Vector3<f64> {
    let length = gradient.norm();
    if length > 0.0 {
        gradient * -(1.0 / length)
    } else {
        Vector3::zeros()
    }
}

/// ∂E/∂p from ∂E/∂c for an E that depends on the point only by its inward normal c = −g/‖g‖, so dc = −(I − ccᵀ) H dp / ‖g‖.
fn by_turning(
    gradient: &Vector3<f64>,
    hessian: &Matrix3<f64>,
    by_normal: &Vector3<f64>,
) -> Vector3<f64> {
    let length = gradient.norm();
    if length == 0.0 {
        return Vector3::zeros();
    }
    let per_length = 1.0 / length;
    let unit = gradient * per_length;
    let tangential = by_normal - unit * unit.dot(by_normal);
    hessian * tangential * -per_length
}

/// Number, sum and second moments of arms, which determine `GGᵀ`.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    count: f64,
    /// Σ a
    first: Vector3<f64>,
    /// Σ aaᵀ
    second: Matrix3<f64>,
}

impl Moments {
    fn add(&mut self, arm: &Vector3<f64>) {
        self.count += 1.0;
        self.first += arm;
        self.second += arm * arm.transpose();
    }

    /// The lower right block of `GGᵀ`: Σ [a]ₓ[a]ₓᵀ.
    fn inertia(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(self.second.trace()) - self.second
    }

    /// Whether `GGᵀ` − εI is positive definite. Its upper left block (n − ε)I is, and the Schur complement must be: Σ
    /// [a]ₓ[a]ₓᵀ − εI − [Σa]ₓ[Σa]ₓᵀ / (n − ε).
    fn exceed(&self, epsilon: f64) -> bool {
        let upper = self.count - epsilon;
        if upper <= 0.0 {
            return false;
        }
        let isotropic = epsilon + self.first.norm_squared() / upper;
        let complement = self.inertia() - Matrix3::from_diagonal_element(isotropic)
            + self.first * self.first.transpose() / upper;
        complement.cholesky().is_some()
    }

    /// How far the least eigenvalue of `GGᵀ` is below ε; `None` if it is above.
    fn lack_of_rank(&self, epsilon: f64) -> Option<LackOfRank> {
        // This test is much cheaper and nearly always sufficient.
        if self.exceed(epsilon) {
            return None;
        }
        let mut gram = Matrix6::zeros();
        let cross = self.first.cross_matrix();
        gram.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(self.count);
        gram.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross);
        gram.fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&cross.transpose());
        gram.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.inertia());
        let eigen = gram.symmetric_eigen();
        let least = eigen.eigenvalues.imin();
        let vector = eigen.eigenvectors.column(least);
        Some(LackOfRank {
            value: (epsilon - eigen.eigenvalues[least]).max(0.0),
            force: vector.fixed_rows::<3>(0).into_owned(),
            torque: vector.fixed_rows::<3>(3).into_owned(),
        })
    }
}

/// A direction of wrenches that the contacts hardly span.
#[derive(Debug, Clone, Copy)]
struct LackOfRank {
    /// ε − `λ_min(GGᵀ)`, not negative.
    value: f64,
    /// The eigenvector (force and torque).
    force: Vector3<f64>,
    torque: Vector3<f64>,
}

impl LackOfRank {
    /// Derivative of the value with respect to a contact's arm.
    fn by_arm(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        // λ = Σᵢ ‖u + v×aᵢ‖² for the eigenvector (u, v), so ∂λ/∂aᵢ = 2 (u + v×aᵢ) × v.
        (self.force + self.torque.cross(arm)).cross(&self.torque) * -2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use landscape::grasp::closure::{grasp_matrix_rank_margin, net_wrench};
    use landscape::object::Sphere;
    use landscape::sample::{Task, stream};
    use rand::RngExt;

    fn arms(count: usize, task: u64) -> Vec<Vector3<f64>> {
        let mut rng = stream(0, Task::Start, task);
        (0..count)
            .map(|_| Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)))
            .collect()
    }

    #[test]
    fn the_rank_condition_is_that_of_the_grasp_matrix() {
        let [mut above, mut below] = [0, 0];
        for task in 0..300 {
            let count = [2, 3, 4, 5, 6][usize::try_from(task % 5).unwrap()];
            let arms = arms(count, task);
            let mut moments = Moments::default();
            for arm in &arms {
                moments.add(arm);
            }
            let contacts: Vec<PointContact> = arms
                .iter()
                .map(|&arm| PointContact {
                    arm,
                    inward_normal: -arm.normalize(),
                })
                .collect();
            let margin = grasp_matrix_rank_margin(&contacts);
            for epsilon in [1e-4, 0.3, 2.5, 7.0] {
                match moments.lack_of_rank(epsilon) {
                    None => {
                        above += 1;
                        assert!(margin > epsilon - 1e-12, "{margin} {epsilon}");
                    }
                    Some(lack) => {
                        below += 1;
                        assert!((lack.value - (epsilon - margin)).abs() < 1e-9, "{task}");
                    }
                }
            }
        }
        assert!(above > 200 && below > 200, "{above} {below}");
    }

    #[test]
    fn the_parts_are_those_of_the_judges() {
        let ball = Sphere {
            centre: Vector3::new(0.01, 0.02, 0.0),
            radius_m: 0.03,
        };
        let test = RelaxedForceClosure {
            rank_epsilon: 3.0,
            ..RelaxedForceClosure::paper(Vector3::new(0.0, 0.02, 0.01), 0.05)
        };
        for count in [1, 2, 3, 4, 17, 100] {
            let points: Vec<Vector3<f64>> = arms(count, 7).iter().map(|arm| arm * 0.05).collect();
            let contacts: Vec<PointContact> = points
                .iter()
                .map(|point| test.contact(point, &ball.gradient(point).1))
                .collect();
            let distances: f64 = points.iter().map(|p| ball.distance(p).abs() / 0.05).sum();
            let rank = (3.0 - grasp_matrix_rank_margin(&contacts)).max(0.0);
            let expected = rank + net_wrench(&contacts) + distances;
            let value = test.value(&ball, &points);
            assert!(
                (value - expected).abs() < 1e-9,
                "{count}: {value} {expected}"
            );
            let mut touches: Vec<Touch> = points.iter().copied().map(Touch::at).collect();
            let again = test.value_and_forces(&ball, &mut touches);
            assert!((value - again).abs() < 1e-12);
            assert!(touches.iter().all(|touch| touch.force.norm() > 0.0));
        }
        assert!(test.value(&ball, &[]).is_finite());
    }

    #[test]
    fn points_are_pulled_to_balance() {
        let ball = Sphere {
            centre: Vector3::zeros(),
            radius_m: 0.04,
        };
        let test = RelaxedForceClosure::paper(Vector3::zeros(), 0.04);
        let on = |[x, y]: [f64; 2]| Vector3::new(x, y, 0.0) * 0.04;
        let high = 0.75_f64.sqrt();
        let balanced = [[1.0, 0.0], [-0.5, high], [-0.5, -high]].map(on);
        assert!(test.value(&ball, &balanced) < 1e-12);

        let mut touches = [[1.0, 0.0], [0.0, 1.0], [-0.6, -0.8]].map(|at| Touch::at(on(at)));
        let value = test.value_and_forces(&ball, &mut touches);
        assert!((value - 0.4472).abs() < 1e-4);
        // The third point is pulled towards the bisector of the other two, along the sphere.
        assert!(touches[2].force.x > 1.0);
        assert!(touches[2].force.dot(&touches[2].point).abs() < 1e-9);
    }
}
