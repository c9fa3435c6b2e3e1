//! Contacts lie on the object's surface.

use super::{Forces, Scene, Term, rounded_norm};

/// Distance of the contacts from the surface, on either side.
///
/// ```text
/// E = w Σᵢ (√(dᵢ² + r²) − r) / unit
/// ```
///
/// Liu et al. (2021), Eq. 7, last term (there r = 0). Never capped: a cap would make every release cost the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Weight w per unit length.
    pub weight: f64,
    /// Rounding r, metres.
    pub rounding_m: f64,
}

impl Distance {
    /// Cost of one contact at signed distance `distance_m`.
    pub fn cost(&self, distance_m: f64, unit_m: f64) -> f64 {
        self.weight * rounded_norm(distance_m, self.rounding_m).0 / unit_m
    }

    /// Largest distance from the surface that costs at most `cost`.
    pub fn reach_m(&self, cost: f64, unit_m: f64) -> f64 {
        if self.weight == 0.0 {
            return f64::INFINITY;
        }
        let total = cost.max(0.0) * unit_m / self.weight + self.rounding_m;
        (total * total - self.rounding_m * self.rounding_m)
            .max(0.0)
            .sqrt()
    }
}

impl Term for Distance {
    fn name(&self) -> &'static str {
        "distance"
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let scale = self.weight * scene.distance_factor / scene.unit_m;
        let mut energy = 0.0;
        for contact in scene.contacts {
            let (value, slope) = rounded_norm(contact.distance_m, self.rounding_m);
            energy += scale * value;
            forces.push(
                contact.link,
                &contact.point,
                &(contact.gradient * (scale * slope)),
            );
        }
        energy
    }
}
