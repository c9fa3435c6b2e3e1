//! What only a relaxed path joins: an upper bound, dashed, and no transition state.

use crate::table::assert_says;
use landscape::energy::FunctionOn;
use landscape::space::Euclidean;
use landscape::store::{AtomicFolder, LandscapeFiles, Source};
use landscape::study::{
    Kinetics, KineticsSettings, NetworkOfStates, StudyRun, Subject, SurfaceReport, SurfaceSearch,
    search_surface,
};
use landscape::thermal::Dynamics;
use landscape::topography::{Evidence, FamilySettings, SearchSettings, in_box};
use tempfile::TempDir;

/// Two minima with vanishing curvatures, joined at exactly 1 by a saddle with a flat direction.
fn quartic(p: &[f64], gradient: &mut [f64]) -> f64 {
    let [a, b] = [p[0], p[1]];
    let rest = a * a - 1.0;
    gradient[0] = 8.0 * a * rest.powi(3);
    gradient[1] = 4.0 * b.powi(3);
    rest.powi(4) + b.powi(4)
}

#[test]
fn minima_that_no_verified_saddle_joins_are_joined_by_a_bound() {
    let energy = FunctionOn::new(Euclidean::new(2), quartic);
    let (low, high) = (vec![-1.7, -1.2], vec![1.7, 1.2]);
    let subject = Subject {
        name: "quartic",
        energy: &energy,
        coordinates: "flat".to_owned(),
        low: low.clone(),
        high: high.clone(),
        source: Source::default(),
    };
    let settings = SearchSettings::measured(&energy, &in_box(&low, &high), 0);
    let search = SurfaceSearch {
        settings: &settings,
        lowest: None,
        known: &[],
        pair: None,
    };
    let families = FamilySettings::default();
    let searched = search_surface(&subject, &search, &families, &StudyRun::default()).unwrap();
    assert_eq!(searched.found.minima.len(), 2);
    assert_eq!(searched.found.components(), 2);
    let [root] = searched.landscape.tree.roots[..] else {
        panic!("{:?}", searched.landscape.tree)
    };
    let top = &searched.landscape.tree.nodes[root.0];
    assert_eq!(top.evidence, Evidence::Chain);
    assert!((top.energy - 1.0).abs() < 1e-6, "{}", top.energy);
    let place = TempDir::new().unwrap();
    let report = SurfaceReport {
        subject: &subject,
        found: &searched.found,
        landscape: &searched.landscape,
        settings: &settings,
        lowest: None,
        command: String::new(),
        measuring: 0,
    };
    let folder = AtomicFolder::open(&place.path().join("quartic.landscape"), true).unwrap();
    let summary = report.write(&folder).unwrap().text;
    let finished = folder.finish().unwrap();
    assert_says(&summary, &["2 components", "is an upper bound"]);
    let files = LandscapeFiles::read(&finished).unwrap();
    assert_eq!(files.edges[0].evidence, "chain");
    let svg = std::fs::read_to_string(finished.join("disconnectivity.svg")).unwrap();
    assert!(svg.contains("upper bound") && !svg.contains("apart"));

    let states = NetworkOfStates::open(&finished, &families).unwrap();
    let asked = KineticsSettings {
        temperatures: vec![0.2],
        dynamics: Dynamics::TransitionState,
        pathways: 3,
    };
    let refused = Kinetics::new(&states, (&[1], &[0]), &asked, &|_| ());
    assert_says(&refused.unwrap_err().to_string(), &["transition states"]);
}
