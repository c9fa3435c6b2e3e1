//! The level at which the families of a landscape are made, and whether two levels are comparable.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::grasp::EnergySettings;
use crate::store::Manifest;

/// Height of the ripples of the energy of a layer, as a fraction of the cost of letting go. Differences below it tell
/// nothing.
pub(super) const ROUGHNESS: f64 = 0.005;

/// Relative difference below which levels are equal.
const TIE: f64 = 1e-9;

/// The level of families: a relative barrier and its unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FamilyLevel {
    /// Greatest relative barrier within a family, in units of the energy.
    pub barrier: f64,
    /// Cost of letting go, in the same unit: the compliance alone. `None` if the energy has no such scale.
    pub letting_go: Option<f64>,
}

impl FamilyLevel {
    /// The level of a landscape, or the `given` one in units of its energy; `None` if the landscape records none.
    pub fn of(manifest: &Manifest, given: Option<f64>) -> Option<Self> {
        Some(Self {
            barrier: given.or(manifest.family_barrier)?,
            letting_go: manifest.letting_go,
        })
    }

    /// The default level: what it costs to put one resting phalanx on the object
    /// ([`LayerSettings::hump`](crate::grasp::layer::LayerSettings::hump)), and at least a ripple. `None` if the compliance
    /// has no weight.
    ///
    /// So grasps are of one family if the hand gets from one to the other without pushing more than one phalanx at a time over
    /// the hump. The level is the same for all hands and objects.
    pub fn default_of(settings: &EnergySettings) -> Option<Self> {
        let cost = letting_go(settings)?;
        let hump = settings.layer.hump();
        Some(Self {
            barrier: hump.max(ROUGHNESS * cost),
            letting_go: Some(cost),
        })
    }

    /// Whether families at the two levels may be compared: at equal fractions of the cost of letting go, or, if neither
    /// energy knows this cost, at equal barriers.
    pub fn equals(&self, other: &Self) -> bool {
        let fraction = |level: &Self| level.barrier / level.letting_go.unwrap_or(1.0);
        let (one, other_fraction) = (fraction(self), fraction(other));
        self.letting_go.is_some() == other.letting_go.is_some()
            && (one - other_fraction).abs() <= TIE * one.abs().max(other_fraction.abs())
    }

    /// Why the families of two named landscapes cannot be compared, in one sentence without a full stop; `None` if they can.
    pub fn difference(one: (&str, &Self), other: (&str, &Self)) -> Option<String> {
        let ((name, level), (other_name, other_level)) = (one, other);
        if level.equals(other_level) {
            return None;
        }
        let advice = if level.letting_go.is_some() == other_level.letting_go.is_some() {
            "make both at one level (--family-barrier)"
        } else {
            "their energies have different units, so no common level exists: build both with one energy"
        };
        Some(format!(
            "the families of {name} are made at a relative barrier of {level}, those of {other_name} at {other_level}, so their \
             numbers cannot be compared: {advice}"
        ))
    }
}

impl fmt::Display for FamilyLevel {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:.4}", self.barrier)?;
        match self.letting_go {
            Some(cost) => {
                let percent = 100.0 * self.barrier / cost;
                write!(formatter, " ({percent:.1} % of the cost of letting go)")
            }
            None => Ok(()),
        }
    }
}

/// Cost of letting go in units of the energy: the compliance of a hand that touches nothing, which is the weight of the
/// compliance of the elastic layer; `None` if that is 0.
///
/// The whole energy of a hand that has let go is higher: its phalanges reach nothing (15 of the human hand at 0.0075 each:
/// 0.1125), and its pose costs 0.01 to 0.04. These parts do not tell how the object is held, so they are no part of the
/// unit, and a pass counts as letting go from the unit on.
pub(super) fn letting_go(settings: &EnergySettings) -> Option<f64> {
    let cost = settings.layer.compliance_weight;
    Some(cost).filter(|cost| *cost > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(barrier: f64, letting_go: Option<f64>) -> FamilyLevel {
        FamilyLevel {
            barrier,
            letting_go,
        }
    }

    #[test]
    fn levels_are_fractions_of_the_cost_of_letting_go() {
        let closed = level(0.05, Some(1.0));
        assert_eq!(
            closed.to_string(),
            "0.0500 (5.0 % of the cost of letting go)"
        );
        assert!(
            closed.equals(&level(0.15, Some(3.0))),
            "in any unit of energy"
        );
        assert!(!closed.equals(&level(0.06, Some(1.0))));
        assert!(!closed.equals(&level(0.05, None)));
        assert!(level(0.1, None).equals(&level(0.1, None)));
    }

    /// The cost is found by sampling the energy of a phalanx along its way to the object.
    #[test]
    fn the_default_level_is_the_cost_of_putting_a_phalanx_on_the_object() {
        let mut settings = EnergySettings::default();
        let layer = settings.layer;
        let energy = |k: f64, u: f64| 1.0 - (1.0 - u).powi(3) * (1.0 - k * u);
        let highest = |k: f64| {
            let along = (0..=10_000).map(|n| energy(k, f64::from(n) * 1e-4));
            along.fold(0.0, f64::max) - energy(k, 1.0)
        };
        let expected = layer.reach_weight * highest(layer.reach_hump);
        let found = FamilyLevel::default_of(&settings).unwrap();
        assert!((found.barrier - expected).abs() < 1e-6, "{found}");
        assert_eq!(found.letting_go, Some(1.0));
        settings.layer.reach_hump = 0.0;
        let flat = FamilyLevel::default_of(&settings).unwrap();
        assert!(
            (flat.barrier - ROUGHNESS).abs() < 1e-12,
            "ripples never divide a family"
        );
        settings.layer.compliance_weight = 0.0;
        assert_eq!(FamilyLevel::default_of(&settings), None);
    }

    #[test]
    fn a_difference_is_told_with_what_to_do() {
        let told = |one, other| FamilyLevel::difference(("a", &one), ("b", &other));
        assert_eq!(told(level(0.1, None), level(0.1, None)), None);
        let barriers = told(level(0.1, None), level(0.2, None)).unwrap();
        assert!(barriers.contains("of a are made at a relative barrier of 0.1000"));
        assert!(barriers.ends_with("(--family-barrier)"), "{barriers}");
        let units = told(level(0.05, Some(1.0)), level(0.05, None)).unwrap();
        assert!(units.ends_with("build both with one energy"), "{units}");
    }
}
