//! Descents of contact sets on the unit sphere along Eq. 7.

use crate::relaxed::{RelaxedForceClosure, Touch};
use landscape::energy::Energy;
use landscape::object::Sphere;
use landscape::optimize::{QuenchSettings, quench_traced};
use landscape::space::{Euclidean, Space};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::sets::{Verdict, contacts, points};

/// Longest step of all contacts together, in radii.
pub(crate) const STEP: f64 = 0.1;

/// Eq. 7 for the points yᵢ/‖yᵢ‖, which cannot leave the sphere.
struct OnSphere {
    space: Euclidean,
    test: RelaxedForceClosure,
    ball: Sphere,
}

impl OnSphere {
    fn new(contacts: usize) -> Self {
        Self {
            space: Euclidean::new(3 * contacts),
            test: RelaxedForceClosure::paper(Vector3::zeros(), 1.0),
            ball: Sphere {
                centre: Vector3::zeros(),
                radius_m: 1.0,
            },
        }
    }
}

fn on_sphere(x: &[f64]) -> Vec<Vector3<f64>> {
    x.chunks_exact(3)
        .map(|y| Vector3::from_column_slice(y).normalize())
        .collect()
}

impl Energy for OnSphere {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let mut touches: Vec<Touch> = on_sphere(x).into_iter().map(Touch::at).collect();
        let value = self.test.value_and_forces(&self.ball, &mut touches);
        let slots = x.chunks_exact(3).zip(gradient.chunks_exact_mut(3));
        for (touch, (y, slot)) in touches.iter().zip(slots) {
            // Only the tangential part of the force moves y/‖y‖: dp = (I − ppᵀ) dy / ‖y‖.
            let tangential = touch.force - touch.point * touch.point.dot(&touch.force);
            let length = Vector3::from_column_slice(y).norm();
            slot.copy_from_slice((tangential / length).as_slice());
        }
        value
    }
}

/// Verdicts on `count` random sets after each of the `steps` and at the end.
pub(crate) struct Descents {
    pub(crate) contacts: usize,
    pub(crate) steps: Vec<usize>,
    /// For each of `steps` and each set.
    pub(crate) verdicts: Vec<Vec<Verdict>>,
    pub(crate) end: Vec<Verdict>,
}

impl Descents {
    pub(crate) fn of(contacts: usize, count: u64, steps: Vec<usize>) -> Self {
        let energy = OnSphere::new(contacts);
        let traces: Vec<_> = (0..count)
            .into_par_iter()
            .map(|id| descend(&energy, contacts, id, &steps))
            .collect();
        let at = |step: usize| traces.iter().map(|(trace, _)| trace[step]).collect();
        Self {
            contacts,
            verdicts: (0..steps.len()).map(at).collect(),
            steps,
            end: traces.iter().map(|(_, end)| *end).collect(),
        }
    }
}

/// Verdicts after `steps` accepted steps and at the end. A set that has converged stays where it is.
fn descend(energy: &OnSphere, count: usize, id: u64, steps: &[usize]) -> (Vec<Verdict>, Verdict) {
    let start: Vec<f64> = points(count, id).iter().flatten().copied().collect();
    let settings = QuenchSettings::default()
        .with_max_step(STEP)
        .with_max_evaluations(300);
    let verdict = |x: &[f64]| Verdict::of(&contacts(&on_sphere(x)));
    let mut path = vec![start.clone()];
    let found = quench_traced(energy, &start, &settings, &mut |x, _| path.push(x.to_vec()));
    let last = path.len() - 1;
    let trace = steps.iter().map(|&step| verdict(&path[step.min(last)]));
    (trace.collect(), verdict(&found.x))
}
