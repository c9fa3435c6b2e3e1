//! The posed hand of one evaluation and what is measured of it.

use std::sync::PoisonError;

use super::GraspEnergy;
use super::near::NearSearch;
use crate::grasp::contact::ContactSearch;
use crate::grasp::term::{Contact, Forces, NearPoint, Proximity, Scene};
use crate::hand::PosedHand;
use crate::space::Space;

/// Buffers of one evaluation, and what is remembered to make the next one cheaper (never to change its result).
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    /// The pose that `posed` holds.
    x: Vec<f64>,
    pub(super) posed: PosedHand,
    surface: NearSearch,
    /// Points within `band_m` at the current pose, by rising index.
    pub(super) near: Vec<NearPoint>,
    pub(super) band_m: f64,
    pub(super) proximity: Proximity,
    pub(super) forces: Forces,
    /// Energy and forces of the contact-free terms, if they were computed at the current pose.
    pub(super) contact_free: Option<ContactFree>,
    pub(super) contacts: Vec<Contact>,
    pub(super) search: ContactSearch,
    pub(super) warm: Vec<u32>,
    pub(super) ramp: Ramp,
}

/// Energy and forces of the terms that need no contacts.
#[derive(Debug, Clone, Default)]
pub(super) struct ContactFree {
    /// The factor on depths they were computed with.
    pub(super) depth_factor: f64,
    pub(super) energy: f64,
    pub(super) forces: Forces,
}

/// Factors on weights while a synthesis begins softly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ramp {
    /// On the weight of contact distances.
    pub distance: f64,
    /// On the weights of depths: hand in object, object in hand, hand in hand.
    pub depth: f64,
}

impl Default for Ramp {
    /// The energy as it is.
    fn default() -> Self {
        Self {
            distance: 1.0,
            depth: 1.0,
        }
    }
}

impl GraspEnergy {
    /// Works with the scratch whose memory is nearest to `x`; threads that work elsewhere do not take each other's.
    pub(super) fn with_scratch<R>(&self, x: &[f64], work: impl FnOnce(&mut Scratch) -> R) -> R {
        let pool = || self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = take_nearest(&mut pool(), x).unwrap_or_default();
        let result = work(&mut scratch);
        pool().push(scratch);
        result
    }

    /// A scratch that knows what the last one used knows.
    pub(super) fn copy_of_scratch(&self) -> Scratch {
        let pool = self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        pool.last().cloned().unwrap_or_default()
    }

    /// Poses the links of the hand, unless they are there already.
    pub(super) fn pose(&self, x: &[f64], scratch: &mut Scratch) {
        assert_eq!(x.len(), self.space.coordinates(), "a pose of another hand");
        let bits = |x: &f64| x.to_bits();
        if scratch.x.iter().map(bits).eq(x.iter().map(bits)) {
            return;
        }
        self.hand.pose_links(x, &mut scratch.posed);
        scratch.x.clear();
        scratch.x.extend_from_slice(x);
        scratch.band_m = f64::NAN;
        scratch.contact_free = None;
    }

    /// Fills `near` with every surface point whose signed distance is at most `band_m`; with gradients of those at most
    /// at `graded_m`.
    pub(super) fn measure(&self, band_m: f64, graded_m: f64, scratch: &mut Scratch) {
        scratch.band_m = band_m;
        scratch.surface.find(
            &self.hand,
            &scratch.posed,
            &*self.object.shape,
            (band_m, graded_m),
            &mut scratch.near,
        );
    }

    pub(super) fn measure_contacts(&self, choice: &[u32], scratch: &mut Scratch) {
        scratch.contacts.clear();
        for &index in choice {
            let point = self.hand.surface_point(&scratch.posed, index as usize);
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
            proximity: &scratch.proximity,
            contacts: &scratch.contacts,
            unit_m: self.unit_m,
            distance_factor: scratch.ramp.distance,
        }
    }
}

fn take_nearest(pool: &mut Vec<Scratch>, x: &[f64]) -> Option<Scratch> {
    if pool.len() < 2 {
        return pool.pop();
    }
    // Any measure will do; a radian moves fingers by centimetres.
    let weight = |coordinate: usize| if coordinate < 3 { 1.0 } else { 0.05 };
    let away = |scratch: &Scratch| -> f64 {
        let steps = scratch.x.iter().zip(x).enumerate();
        steps.map(|(k, (a, b))| (weight(k) * (a - b)).powi(2)).sum()
    };
    let nearest = (0..pool.len()).min_by(|a, b| away(&pool[*a]).total_cmp(&away(&pool[*b])))?;
    Some(pool.swap_remove(nearest))
}
