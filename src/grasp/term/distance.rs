//! Distance of contacts from the object's surface.

use super::{Forces, NormForm, Scene, Stage, Term};

/// Distance of the contacts from the surface, on either side.
///
/// ```text
/// E = w Σᵢ (√(dᵢ² + r²) − r) / unit
/// ```
///
/// Liu et al. (2021), Eq. 7, last term (there r = 0); their code has w Σᵢ (dᵢ/unit)². It is not capped, since with a cap
/// all releases would cost the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Weight w per unit length (or its square).
    pub weight: f64,
    /// Norm or square.
    pub form: NormForm,
    /// Rounding r, metres.
    pub rounding_m: f64,
}

impl Distance {
    /// Cost of one contact at signed distance `distance_m`.
    pub fn cost(&self, distance_m: f64, unit_m: f64) -> f64 {
        self.weight * self.value(distance_m, unit_m).0
    }

    /// Greatest distance from the surface that costs at most `cost`.
    pub fn reach_m(&self, cost: f64, unit_m: f64) -> f64 {
        if self.weight == 0.0 {
            return f64::INFINITY;
        }
        unit_m
            * self
                .form
                .reach(cost / self.weight, self.rounding_m / unit_m)
    }

    /// Energy at weight 1, and its derivative with respect to the distance.
    fn value(&self, distance_m: f64, unit_m: f64) -> (f64, f64) {
        let (value, slope) = self
            .form
            .apply(distance_m / unit_m, self.rounding_m / unit_m);
        (value, slope / unit_m)
    }
}

impl Term for Distance {
    fn name(&self) -> &'static str {
        "distance"
    }

    fn weight(&self) -> f64 {
        self.weight
    }

    fn stage(&self) -> Stage {
        Stage::Contacts
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let scale = self.weight * scene.distance_factor;
        let mut energy = 0.0;
        for contact in scene.contacts {
            let (value, slope) = self.value(contact.distance_m, scene.unit_m);
            energy += scale * value;
            forces.push_surface(
                contact.index,
                contact.link,
                &contact.point,
                &(contact.gradient * (scale * slope)),
            );
        }
        energy
    }
}
