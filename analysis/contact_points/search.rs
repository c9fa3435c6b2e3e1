//! Contact points on an object without a hand: their relaxed force closure as an energy, and a search for its minima.

use nalgebra::Vector3;
use rand::RngExt;
use rand_distr::{Distribution, UnitSphere};

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
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPointSettings {
    /// Number of points.
    pub(crate) contacts: usize,
    /// Langevin steps before the descent; with 0 there is only the descent.
    pub(crate) steps: u32,
    /// Number of attempts from new starts. The first whose points lie on the mesh (within [`LARGEST_GAP_M`]) with ‖Gc‖ less
    /// than 0.1 ends the search; if there is none, the one of least energy counts.
    pub(crate) attempts: u32,
}

/// Contact points found, measured on the exact mesh.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ContactPoints {
    /// Relaxed force closure of the final points.
    energy: f64,
    /// The nearest points of the mesh, metres.
    pub(crate) on_mesh: Vec<Vector3<f64>>,
    /// The contacts there: arm from the centroid divided by the object's radius, and inward normal.
    contacts: Vec<PointContact>,
    /// Largest distance of a point from the mesh, metres.
    gap_m: f64,
}

/// Greatest distance of a contact from the mesh, metres, as in the strict filter of grasps.
const LARGEST_GAP_M: f64 = 0.002;

impl ContactPoints {
    /// Whether all points are within [`LARGEST_GAP_M`] with ‖Gc‖ below `most` (0.5 in Liu et al. 2021, Eq. 11).
    pub(crate) fn passes_relaxed(&self, most: f64) -> bool {
        self.gap_m <= LARGEST_GAP_M && net_wrench(&self.contacts) < most
    }

    /// Whether all points are within [`LARGEST_GAP_M`] and in force closure by the exact test.
    pub(crate) fn is_confirmed(&self, friction: f64) -> bool {
        self.gap_m <= LARGEST_GAP_M
            && grasp_matrix_rank_margin(&self.contacts) > RANK_EPSILON
            && is_force_closure(&self.contacts, friction)
    }
}

/// First and last temperature of the annealing, and the acceptance at which the length of steps aims.
const TEMPERATURES: [f64; 2] = [0.5, 0.005];
const ACCEPTANCE: f64 = 0.57;
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
        let end = anneal(&energy, settings.steps, object.radius_m, &start, &mut rng);
        let found = quench(&energy, &end, &refine);
        let found = measure(object, found.energy, points(&found.x));
        if found.passes_relaxed(0.1) {
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
    steps: u32,
    radius_m: f64,
    start: &[f64],
    rng: &mut Rng,
) -> Vec<f64> {
    let kernel = Mala::new(energy);
    let mut state = kernel.start(start);
    let mut proposal = State::default();
    let mut log_step = libm::log(FIRST_STEP * radius_m);
    let [hot, cold] = TEMPERATURES;
    for step in 0..steps {
        let progress = f64::from(step) / f64::from(steps);
        let law = TargetDensity {
            temperature: hot * libm::pow(cold / hot, progress),
            attraction: None,
        };
        let ratio = kernel.propose(&state, &law, libm::exp(log_step), rng, &mut proposal);
        let accepted = libm::log(rng.random::<f64>()) < ratio;
        if accepted {
            std::mem::swap(&mut state, &mut proposal);
        }
        log_step += 0.05 * (f64::from(u8::from(accepted)) - ACCEPTANCE);
    }
    state.coordinates
}

fn measure(
    object: &Object,
    energy: f64,
    points: impl Iterator<Item = Vector3<f64>>,
) -> ContactPoints {
    let nearest: Vec<_> = points.map(|p| object.exact.nearest(&p)).collect();
    let contacts = nearest.iter().map(|n| PointContact {
        arm: (n.point - object.centroid) / object.radius_m,
        inward_normal: -n.normal,
    });
    let gaps = nearest.iter().map(|n| n.distance_m.abs());
    ContactPoints {
        energy,
        on_mesh: nearest.iter().map(|n| n.point).collect(),
        contacts: contacts.collect(),
        gap_m: gaps.fold(0.0, f64::max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descent_alone_may_fail_where_attempts_do_not() {
        let hammer = Object::named("hammer").unwrap();
        let [descent, full] = [(0, 1), (300, 8)].map(|(steps, attempts)| ContactPointSettings {
            contacts: 3,
            steps,
            attempts,
        });
        let confirmed = |settings: &ContactPointSettings| {
            let found = (0..20).map(|number| find_contact_points(&hammer, settings, 5, number));
            found.filter(|found| found.is_confirmed(0.5)).count()
        };
        let (alone, full) = (confirmed(&descent), confirmed(&full));
        assert!(alone < 18 && full >= 19, "{alone} {full}");
        let again = find_contact_points(&hammer, &descent, 5, 3);
        assert_eq!(again, find_contact_points(&hammer, &descent, 5, 3));
    }

    #[test]
    fn points_on_a_ball_are_in_force_closure() {
        let ball = Object::named("ball").unwrap();
        let settings = ContactPointSettings {
            contacts: 4,
            steps: 2000,
            attempts: 8,
        };
        let found = find_contact_points(&ball, &settings, 1, 0);
        assert!(found.passes_relaxed(0.1) && found.is_confirmed(0.5));
        assert_eq!(found.on_mesh.len(), 4);
    }
}
