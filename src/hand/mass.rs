//! Masses of links, for programs that simulate the hand.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::{Capsule, Hand, LinkId};

/// Mass distribution of a link, link frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkMass {
    /// Mass, kilograms.
    pub mass_kg: f64,
    /// Centre of mass, metres.
    pub centre: Vector3<f64>,
    /// Tensor of inertia about the centre of mass, kg m².
    pub inertia: Matrix3<f64>,
}

impl Hand {
    /// The mass of a link whose capsules have the density `density_kg_m3` and overlap freely, and a little more, `least_kg`
    /// and `least_kg_m2`, at its origin, because the first of two joints at the same place moves a link without geometry.
    ///
    /// # Panics
    /// If there is no such link.
    pub fn link_mass(
        &self,
        link: LinkId,
        density_kg_m3: f64,
        [least_kg, least_kg_m2]: [f64; 2],
    ) -> LinkMass {
        assert!(link.0 < self.links.len(), "a link of this hand");
        let least = LinkMass {
            mass_kg: least_kg,
            centre: Vector3::zeros(),
            inertia: Matrix3::from_diagonal_element(least_kg_m2),
        };
        let capsules = self.capsules.iter().filter(|c| c.link == link);
        capsules
            .map(|capsule| of_capsule(capsule, density_kg_m3))
            .fold(least, |sum, part| sum.with(&part))
    }
}

impl LinkMass {
    fn with(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        if mass_kg <= 0.0 {
            return *self;
        }
        let centre = (self.centre * self.mass_kg + other.centre * other.mass_kg) / mass_kg;
        let about = |part: &Self| part.inertia + of_point(part.mass_kg, &(part.centre - centre));
        Self {
            mass_kg,
            centre,
            inertia: about(self) + about(other),
        }
    }
}

/// Inertia of a point about a place that is `offset` away from it.
fn of_point(mass_kg: f64, offset: &Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::from_diagonal_element(offset.norm_squared()) - offset * offset.transpose()) * mass_kg
}

/// A cylinder and two half balls, whose centres of mass lie ⅜ of the radius away from its ends.
fn of_capsule(capsule: &Capsule, density_kg_m3: f64) -> LinkMass {
    let (r, span) = (capsule.radius_m, capsule.b - capsule.a);
    let length = span.norm();
    let along = span.try_normalize(1e-12).unwrap_or_else(Vector3::z);
    let cylinder = density_kg_m3 * PI * r * r * length;
    let ball = density_kg_m3 * PI * r * r * r * 4.0 / 3.0;
    let axial = cylinder * r * r / 2.0 + ball * r * r * 2.0 / 5.0;
    let across = cylinder * (r * r / 4.0 + length * length / 12.0)
        + ball * (r * r * 2.0 / 5.0 + length * length / 4.0 + length * r * 3.0 / 8.0);
    let line = along * along.transpose();
    LinkMass {
        mass_kg: cylinder + ball,
        centre: capsule.a.lerp(&capsule.b, 0.5),
        inertia: line * axial + (Matrix3::identity() - line) * across,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sums over a grid of points in a capsule agree with the formulae.
    #[test]
    fn a_capsule_has_the_moments_of_its_points() {
        let capsule = Capsule {
            link: LinkId(0),
            a: Vector3::new(0.01, -0.02, 0.03),
            b: Vector3::new(0.04, 0.01, 0.03),
            radius_m: 0.012,
        };
        let found = of_capsule(&capsule, 1000.0);
        let step = 0.001;
        let (mut mass, mut inertia) = (0.0, Matrix3::zeros());
        let range = |axis: usize| {
            let (low, high) = (capsule.a.inf(&capsule.b), capsule.a.sup(&capsule.b));
            let count = (high[axis] - low[axis] + 2.0 * capsule.radius_m) / step;
            let first = low[axis] - capsule.radius_m;
            (0..)
                .map(move |k| first + (f64::from(k) + 0.5) * step)
                .take_while(move |x| *x < first + count * step)
        };
        for x in range(0) {
            for y in range(1) {
                for z in range(2) {
                    let p = Vector3::new(x, y, z);
                    if super::super::axis_distance(&p, &[capsule.a, capsule.b]) < capsule.radius_m {
                        mass += 1000.0 * step.powi(3);
                        inertia += of_point(1000.0 * step.powi(3), &(p - found.centre));
                    }
                }
            }
        }
        assert!(
            (mass / found.mass_kg - 1.0).abs() < 0.01,
            "{mass} {found:?}"
        );
        assert!((inertia - found.inertia).norm() < 0.01 * inertia.norm());
        let whole = found.with(&found);
        assert!((whole.inertia - 2.0 * found.inertia).norm() < 1e-12);
    }
}
