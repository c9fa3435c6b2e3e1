//! The posed hand of one evaluation and what is measured of it.

use std::sync::PoisonError;

use nalgebra::Vector3;

use super::GraspEnergy;
use crate::grasp::contact::ContactSearch;
use crate::grasp::hand::PosedHand;
use crate::grasp::term::{Contact, Forces, Scene};
use crate::space::Space;

/// Buffers of one evaluation, and what is remembered to make the next one cheaper (never to change its result).
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) posed: PosedHand,
    /// Where each surface point's distance was last measured, and that distance.
    measured: Vec<(Vector3<f64>, f64)>,
    /// Points within `band_m` at the current pose: index and signed distance.
    pub(super) near: Vec<(u32, f64)>,
    pub(super) band_m: f64,
    pub(super) forces: Forces,
    pub(super) contacts: Vec<Contact>,
    pub(super) search: ContactSearch,
    pub(super) warm: Vec<u32>,
    pub(super) distance_factor: f64,
}

impl Scratch {
    fn new() -> Self {
        Self {
            distance_factor: 1.0,
            ..Self::default()
        }
    }
}

impl GraspEnergy {
    pub(super) fn with_scratch<R>(&self, work: impl FnOnce(&mut Scratch) -> R) -> R {
        let pool = || self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = pool().pop().unwrap_or_else(Scratch::new);
        let result = work(&mut scratch);
        pool().push(scratch);
        result
    }

    pub(super) fn pose(&self, x: &[f64], scratch: &mut Scratch) {
        assert_eq!(x.len(), self.space.coordinates(), "a pose of another hand");
        self.hand.pose(x, &mut scratch.posed);
    }

    /// Fills `near` with every surface point whose signed distance is at most `band_m`. Points whose last measurement
    /// rules that out are not measured again.
    pub(super) fn measure(&self, band_m: f64, scratch: &mut Scratch) {
        let points = &scratch.posed.points;
        let unknown = (Vector3::zeros(), f64::NEG_INFINITY);
        scratch.measured.resize(points.len(), unknown);
        scratch.near.clear();
        scratch.band_m = band_m;
        let shape = &*self.object.shape;
        let lipschitz = shape.lipschitz();
        for ((index, point), known) in (0u32..).zip(points).zip(&mut scratch.measured) {
            if known.1 - lipschitz * (point - known.0).norm() > band_m {
                continue;
            }
            if known.0 != *point || known.1 == f64::NEG_INFINITY {
                *known = (*point, shape.distance(point));
            }
            if known.1 <= band_m {
                scratch.near.push((index, known.1));
            }
        }
    }

    pub(super) fn measure_contacts(&self, choice: &[u32], scratch: &mut Scratch) {
        scratch.contacts.clear();
        for &index in choice {
            let point = scratch.posed.points[index as usize];
            let (distance_m, gradient, hessian) = self.object.shape.hessian(&point);
            scratch.contacts.push(Contact {
                index,
                link: self.hand.surface[index as usize].link,
                point,
                distance_m,
                gradient,
                hessian,
            });
        }
    }

    pub(super) fn scene<'a>(&'a self, x: &'a [f64], scratch: &'a Scratch) -> Scene<'a> {
        Scene {
            hand: &self.hand,
            posed: &scratch.posed,
            joints_rad: &x[7..],
            object: &self.object,
            near: &scratch.near,
            contacts: &scratch.contacts,
            unit_m: self.unit_m,
            distance_factor: scratch.distance_factor,
        }
    }
}
