//! Contact points on an object without a hand: their relaxed force closure as an energy, and a search for its minima.

use nalgebra::Vector3;
use rand::RngExt;
use rand_distr::{Distribution, UnitSphere};
use serde::{Deserialize, Serialize};

use crate::relaxed::{RelaxedForceClosure, Touch};
use landscape::energy::Energy;
use landscape::grasp::closure::{
    PointContact, RANK_EPSILON, grasp_matrix_rank_margin, is_force_closure, net_wrench,
};
use landscape::object::{Object, Shape};
use landscape::optimize::{QuenchSettings, quench};
use landscape::sample::{Kernel, Mala, Rng, State, TargetDensity, Task, stream};
use landscape::space::{Euclidean, Space};

/// Relaxed force closure of n points as an energy on ℝ³ⁿ (the coordinates of all points in sequence, metres). See
/// [`RelaxedForceClosure`] and Liu et al. (2021), Eq. 7.
#[derive(Debug, Clone)]
pub(crate) struct PointsEnergy<'a> {
    test: RelaxedForceClosure,
    shape: &'a dyn Shape,
    space: Euclidean,
}

impl<'a> PointsEnergy<'a> {
    /// The energy of `contacts` points on `shape`.
    pub(crate) fn new(test: RelaxedForceClosure, shape: &'a dyn Shape, contacts: usize) -> Self {
        Self {
            test,
            shape,
            space: Euclidean::new(3 * contacts),
        }
    }
}

impl Energy for PointsEnergy<'_> {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        assert_eq!(x.len(), self.space.coordinates());
        let mut touches: Vec<Touch> = points(x).map(Touch::at).collect();
        let energy = self.test.value_and_forces(self.shape, &mut touches);
        for (slot, touch) in gradient.chunks_exact_mut(3).zip(&touches) {
            slot.copy_from_slice(touch.force.as_slice());
        }
        if energy.is_nan() {
            f64::INFINITY
        } else {
            energy
        }
    }
}

fn points(x: &[f64]) -> impl Iterator<Item = Vector3<f64>> + '_ {
    x.chunks_exact(3).map(Vector3::from_column_slice)
}

/// Settings of the search for contact points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct ContactPointSettings {
    /// Number of points n.
    pub(crate) contacts: usize,
    /// Weight w of distances from the surface, see [`RelaxedForceClosure`].
    pub(crate) distance_weight: f64,
    /// Langevin steps before the descent; with 0 there is only the descent.
    pub(crate) steps: u32,
    /// Temperature of the first step.
    pub(crate) temperature_start: f64,
    /// Temperature of the last step.
    pub(crate) temperature_end: f64,
    /// Target acceptance rate of the step-length adaptation.
    pub(crate) acceptance: f64,
    /// Number of attempts from new starts. The first whose points lie on the mesh (within [`LARGEST_GAP_M`]) with ‖Gc‖ at
    /// most [`good_net_wrench`](Self::good_net_wrench) ends the search; if there is none, the one of least energy counts.
    pub(crate) attempts: u32,
    /// ‖Gc‖ on the mesh at which an attempt is good enough.
    pub(crate) good_net_wrench: f64,
}

impl Default for ContactPointSettings {
    fn default() -> Self {
        Self {
            contacts: 4,
            distance_weight: 1.0,
            steps: 2_000,
            temperature_start: 0.5,
            temperature_end: 0.005,
            acceptance: 0.57,
            attempts: 8,
            good_net_wrench: 0.1,
        }
    }
}

/// Contact points found, measured on the exact mesh.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ContactPoints {
    /// Number of the search, which selects its random stream.
    pub(crate) number: u64,
    /// Final positions, metres.
    pub(crate) points: Vec<Vector3<f64>>,
    /// Relaxed force closure there ([`RelaxedForceClosure`] with the roundings of the search).
    pub(crate) energy: f64,
    /// The nearest points of the mesh, metres.
    pub(crate) on_mesh: Vec<Vector3<f64>>,
    /// The contacts there: arm from the centroid divided by the object's radius, and inward normal.
    pub(crate) contacts: Vec<PointContact>,
    /// Largest distance of a point from the mesh, metres.
    pub(crate) gap_m: f64,
}

/// Greatest distance of a contact from the mesh, metres, as in the strict filter of grasps.
pub(crate) const LARGEST_GAP_M: f64 = 0.002;

/// Reason why contact points are not in force closure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Objection {
    /// A point is farther than [`LARGEST_GAP_M`] from the mesh.
    Distance,
    /// The contacts do not span all wrenches.
    Rank,
    /// No forces in the friction cones balance; the net wrench of equal forces is mostly a force.
    Force,
    /// No forces in the friction cones balance; the net wrench of equal forces is mostly a torque.
    Torque,
}

impl ContactPoints {
    /// ‖Gc‖ on the mesh.
    pub(crate) fn net_wrench(&self) -> f64 {
        net_wrench(&self.contacts)
    }

    /// Whether all points are within [`LARGEST_GAP_M`] with ‖Gc‖ below `net_wrench` (0.5 in Liu et al. 2021, Eq. 11).
    pub(crate) fn passes_relaxed(&self, net_wrench: f64) -> bool {
        self.gap_m <= LARGEST_GAP_M && self.net_wrench() < net_wrench
    }

    /// The objection of the exact test at `friction`; `None` in force closure.
    ///
    /// # Panics
    /// If `friction` is negative or not finite.
    pub(crate) fn objection(&self, friction: f64) -> Option<Objection> {
        if self.gap_m > LARGEST_GAP_M {
            Some(Objection::Distance)
        } else if grasp_matrix_rank_margin(&self.contacts) <= RANK_EPSILON {
            Some(Objection::Rank)
        } else if is_force_closure(&self.contacts, friction) {
            None
        } else {
            let net: nalgebra::Vector6<f64> = self.contacts.iter().map(PointContact::wrench).sum();
            let force = net.fixed_rows::<3>(0).norm();
            let torque = net.fixed_rows::<3>(3).norm();
            Some(if force >= torque {
                Objection::Force
            } else {
                Objection::Torque
            })
        }
    }
}

/// Rounding of ‖Gc‖.
const ROUNDING: f64 = 0.01;
/// Rounding of distances, metres. It lets a descent converge at the minimum, where Eq. 7 has a kink.
const DISTANCE_ROUNDING_M: f64 = 1e-4;
/// Length of the first Langevin step, relative to the object's radius; it adapts.
const FIRST_STEP: f64 = 0.03;

/// Runs search number `number` with the given seed: points drawn uniformly from the ball around the centroid that contains
/// the object are moved by annealed Langevin steps and then to a minimum of relaxed force closure. The energy is Eq. 7 of
/// Liu et al. (2021), with its norms rounded near zero. Searches are independent.
///
/// # Panics
/// If `settings` has no attempts.
pub(crate) fn find_contact_points(
    object: &Object,
    settings: &ContactPointSettings,
    seed: u64,
    number: u64,
) -> ContactPoints {
    let mut rng = stream(seed, Task::Start, number);
    let test = RelaxedForceClosure {
        rounding: ROUNDING,
        distance_weight: settings.distance_weight,
        distance_rounding_m: DISTANCE_ROUNDING_M,
        ..RelaxedForceClosure::of_object(object)
    };
    let energy = PointsEnergy::new(test, &*object.shape, settings.contacts);
    let refine = QuenchSettings::default().with_max_step(0.2 * object.radius_m);
    let mut best: Option<ContactPoints> = None;
    for _ in 0..settings.attempts {
        let start: Vec<f64> = (0..settings.contacts)
            .flat_map(|_| in_ball(object, &mut rng))
            .collect();
        let end = anneal(&energy, settings, object.radius_m, &start, &mut rng);
        let found = quench(&energy, &end, &refine);
        let found = measure(object, number, found.energy, points(&found.x).collect());
        if found.passes_relaxed(settings.good_net_wrench) {
            return found;
        }
        if best
            .as_ref()
            .is_none_or(|known| found.energy < known.energy)
        {
            best = Some(found);
        }
    }
    best.expect("there is at least one attempt")
}

/// A point drawn uniformly from the ball around the centroid that contains the object.
fn in_ball(object: &Object, rng: &mut Rng) -> [f64; 3] {
    let direction: [f64; 3] = UnitSphere.sample(rng);
    let radius = object.radius_m * libm::cbrt(rng.random::<f64>());
    (object.centroid + Vector3::from(direction) * radius).into()
}

fn anneal(
    energy: &PointsEnergy<'_>,
    settings: &ContactPointSettings,
    radius_m: f64,
    start: &[f64],
    rng: &mut Rng,
) -> Vec<f64> {
    let kernel = Mala::new(energy);
    let mut state = kernel.start(start);
    let mut proposal = State::default();
    let mut log_step = libm::log(FIRST_STEP * radius_m);
    let cooling = settings.temperature_end / settings.temperature_start;
    for step in 0..settings.steps {
        let progress = f64::from(step) / f64::from(settings.steps);
        let law = TargetDensity {
            temperature: settings.temperature_start * libm::pow(cooling, progress),
            attraction: None,
        };
        let ratio = kernel.propose(&state, &law, libm::exp(log_step), rng, &mut proposal);
        let accepted = libm::log(rng.random::<f64>()) < ratio;
        if accepted {
            std::mem::swap(&mut state, &mut proposal);
        }
        log_step += 0.05 * (f64::from(u8::from(accepted)) - settings.acceptance);
    }
    state.coordinates
}

fn measure(object: &Object, number: u64, energy: f64, points: Vec<Vector3<f64>>) -> ContactPoints {
    let nearest: Vec<_> = points.iter().map(|p| object.exact.nearest(p)).collect();
    let contact = |point: &Vector3<f64>, normal: &Vector3<f64>| PointContact {
        arm: (point - object.centroid) / object.radius_m,
        inward_normal: -normal,
    };
    ContactPoints {
        number,
        points,
        energy,
        on_mesh: nearest.iter().map(|n| n.point).collect(),
        contacts: nearest
            .iter()
            .map(|n| contact(&n.point, &n.normal))
            .collect(),
        gap_m: nearest
            .iter()
            .fold(0.0, |gap, n| n.distance_m.abs().max(gap)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use landscape::object::Cuboid;

    #[test]
    fn the_gradient_is_that_of_central_differences() {
        let block = Cuboid {
            centre: Vector3::new(0.01, 0.0, 0.0),
            half_extents: Vector3::new(0.03, 0.02, 0.04),
            edge_radius_m: 0.005,
        };
        for contacts in [3, 4, 5] {
            let test = RelaxedForceClosure {
                rounding: ROUNDING,
                distance_rounding_m: DISTANCE_ROUNDING_M,
                ..RelaxedForceClosure::paper(Vector3::zeros(), 0.05)
            };
            let energy = PointsEnergy::new(test, &block, contacts);
            let mut rng = stream(1, Task::Start, contacts as u64);
            // The points are outside the edges, where normals vary.
            let x: Vec<f64> = (0..3 * contacts)
                .map(|_| 0.06 * if rng.random() { 1.0 } else { -1.0 } * rng.random_range(0.8..1.2))
                .collect();
            let mut gradient = vec![0.0; x.len()];
            energy.evaluate(&x, &mut gradient);
            let mut unused = gradient.clone();
            for k in 0..x.len() {
                let mut at = |step: f64| {
                    let mut moved = x.clone();
                    moved[k] += step;
                    energy.evaluate(&moved, &mut unused)
                };
                let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                assert!(
                    (slope - gradient[k]).abs() < 1e-4,
                    "{slope} {}",
                    gradient[k]
                );
            }
        }
    }

    #[test]
    fn descent_alone_may_fail_where_attempts_do_not() {
        let hammer = Object::named("hammer").unwrap();
        let descent = ContactPointSettings {
            contacts: 3,
            steps: 0,
            attempts: 1,
            ..ContactPointSettings::default()
        };
        let full = ContactPointSettings {
            steps: 300,
            attempts: 8,
            ..descent
        };
        let confirmed = |settings: &ContactPointSettings| {
            let found = (0..20).map(|number| find_contact_points(&hammer, settings, 5, number));
            found.filter(|found| found.objection(0.5).is_none()).count()
        };
        let (alone, full) = (confirmed(&descent), confirmed(&full));
        assert!(alone < 18 && full >= 19, "{alone} {full}");
        let again = find_contact_points(&hammer, &descent, 5, 3);
        assert_eq!(again, find_contact_points(&hammer, &descent, 5, 3));
    }

    #[test]
    fn points_on_a_ball_are_in_force_closure() {
        let ball = Object::named("ball").unwrap();
        let found = find_contact_points(&ball, &ContactPointSettings::default(), 1, 0);
        assert!(found.passes_relaxed(0.1) && found.objection(0.5).is_none());
    }
}
