//! Results do not depend on units. Every reference surface, with lengths multiplied by 10⁻³ to 10³ and energies by 10⁻⁶ to
//! 10⁶, has the same points, the same tree and the same claims.

mod scaled;
mod stiff;

use landscape::energy::model::Surface;
use landscape::sample::Rng;
use landscape::topography::{FamilySettings, Landscape, Run, SearchSettings, explore, in_box};
use scaled::{Scaled, Units, binary, decimal, surfaces};

const AS_IT_IS: Units = Units {
    length: 1.0,
    energy: 1.0,
};

/// Results in the original units of the surface.
struct Found {
    /// Energies and coordinates.
    minima: Vec<(f64, Vec<f64>)>,
    saddles: Vec<(f64, Vec<f64>)>,
    /// Heights of the merges, ascending.
    merges: Vec<f64>,
    /// The claim of completeness.
    claims: String,
    /// Details of the search.
    details: String,
}

impl Found {
    fn explored(surface: &Surface, units: Units) -> Self {
        let energy = Scaled::new(surface, units);
        let draw = in_box(&surface.low, &surface.high);
        let draw = |rng: &mut Rng| energy.scaled(&draw(rng));
        let settings = SearchSettings::measured(&energy, &draw, 1);
        let found = explore(&energy, &draw, &settings, &Run::default()).unwrap();
        let landscape = found.landscape(&energy, &FamilySettings::default());
        let mapped = Self::mapped(&landscape, &energy, units);
        let complete = found.coverage.unseen.is_some_and(|least| least < 0.5);
        Self {
            claims: format!("{}, complete: {complete}", mapped.claims),
            details: format!(
                "{:?}, {:?}, {} refused, {} evaluations",
                found.coverage,
                found.search_ends,
                found.refused.len(),
                found.evaluations
            ),
            saddles: (found.saddles.iter())
                .map(|s| (s.energy / units.energy, energy.unscaled(&s.coordinates)))
                .collect(),
            ..mapped
        }
    }

    fn mapped(landscape: &Landscape, energy: &Scaled<'_>, units: Units) -> Self {
        let minima = landscape.network.node_weights();
        let merges = landscape.tree.nodes.iter().filter(|n| n.minimum.is_none());
        let mut merges: Vec<f64> = merges.map(|node| node.energy / units.energy).collect();
        merges.sort_by(f64::total_cmp);
        Self {
            minima: minima
                .map(|m| (m.energy / units.energy, energy.unscaled(&m.coordinates)))
                .collect(),
            saddles: Vec::new(),
            merges,
            claims: format!("{} components", landscape.tree.roots.len()),
            details: String::new(),
        }
    }

    fn assert_identical(&self, other: &Self, what: &str) {
        assert_eq!(self.minima, other.minima, "{what}");
        assert_eq!(self.saddles, other.saddles, "{what}");
        assert_eq!(self.merges, other.merges, "{what}");
        assert_eq!(self.claims, other.claims, "{what}");
        assert_eq!(self.details, other.details, "{what}");
    }

    /// Compares up to rounding: points are as exact as their tolerances, and symmetric copies may have any order.
    fn assert_equal(&self, other: &Self, what: &str) {
        let energies = |points: &[(f64, Vec<f64>)]| points.iter().map(|point| point.0).collect();
        let pairs: [(Vec<f64>, Vec<f64>); 3] = [
            (energies(&self.minima), energies(&other.minima)),
            (energies(&self.saddles), energies(&other.saddles)),
            (self.merges.clone(), other.merges.clone()),
        ];
        for (known, found) in pairs {
            assert_eq!(known.len(), found.len(), "{what}: {known:?}, {found:?}");
            for (known, found) in known.iter().zip(&found) {
                let near = (known - found).abs() < 1e-6 * (1.0 + known.abs());
                assert!(near, "{what}: {found} instead of {known}");
            }
        }
        assert_eq!(self.claims, other.claims, "{what}");
    }
}

fn in_all_units(found: &dyn Fn(&Surface, Units) -> Found) {
    for surface in surfaces() {
        let known = found(&surface, AS_IT_IS);
        assert!(!known.minima.is_empty());
        for units in binary() {
            let what = format!("{} in {units:?}", surface.name);
            known.assert_identical(&found(&surface, units), &what);
        }
        for units in decimal() {
            let what = format!("{} in {units:?}", surface.name);
            known.assert_equal(&found(&surface, units), &what);
        }
    }
}

#[test]
fn a_search_finds_the_same_in_all_units() {
    in_all_units(&Found::explored);
}
