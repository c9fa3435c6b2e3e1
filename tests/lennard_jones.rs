//! Lennard-Jones clusters, searched and mapped. Minima and merge heights agree with the literature.

use landscape::energy::Energy;
use landscape::energy::model::{LennardJones, named};
use landscape::sample::Mala;
use landscape::space::{Cluster, Space};
use landscape::topography::{
    Evidence, GroupSettings, Landscape, LowestSettings, MapSettings, MinimumId, Run,
    SearchSettings, build_landscape, explore, explore_lowest, in_box, probe_size,
};
use std::time::{Duration, Instant};

/// The map between the minima that a search found.
fn mapped(atoms: usize) -> Landscape {
    let surface = named(&["lj".to_owned(), atoms.to_string()]).unwrap();
    let (energy, draw) = (&*surface.energy, in_box(&surface.low, &surface.high));
    let settings = SearchSettings::measured(energy, &draw, 1);
    let minima = explore(energy, &draw, &settings, &Run::default())
        .unwrap()
        .minima;
    let settings = MapSettings::for_minima(energy, &minima);
    build_landscape(
        energy,
        &Mala::new(energy),
        minima,
        &settings,
        &Run::default(),
    )
    .unwrap()
}

/// Compares energies and merge heights with those of the reference.
fn check(atoms: usize) -> Option<()> {
    let reference: serde_json::Value =
        serde_json::from_str(include_str!("reference/landscapes.json")).ok()?;
    let reference = &reference[format!("LJ{atoms}")];
    let found = mapped(atoms);
    let minima = reference["minima"].as_array()?;
    assert_eq!(found.network.node_count(), minima.len());
    for (i, known) in minima.iter().enumerate() {
        let energy = found.network[petgraph::graph::NodeIndex::new(i)].energy;
        assert!((energy - known.as_f64()?).abs() < 1e-5);
        for j in 0..minima.len() {
            let height = found.tree.minimax(MinimumId(i), MinimumId(j))?;
            let known = reference["minimax"][i][j].as_f64()?;
            assert!((height - known).abs() < 1e-5, "{i} {j}: {height} {known}");
        }
    }
    Some(())
}

#[test]
fn six_atoms() {
    check(6).unwrap();
}

#[test]
fn seven_atoms() {
    check(7).unwrap();
}

#[test]
fn eight_atoms() {
    let found = mapped(8);
    // Doye and Wales (2002): eight minima.
    assert_eq!(found.network.node_count(), 8);
    assert_eq!(found.tree.roots.len(), 1);
    for node in &found.tree.nodes {
        assert!(node.evidence <= Evidence::Path);
    }
}

/// Atoms of two elements with equal interactions: the energy of one element in another space.
struct Labelled(LennardJones, Cluster);

impl Energy for Labelled {
    fn space(&self) -> &dyn Space {
        &self.1
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.0.evaluate(x, gradient)
    }
}

/// Five equal atoms have one minimum, a trigonal bipyramid. Two of them that are labelled can both be apices, one of them, or
/// none.
#[test]
fn two_elements_have_isomers() {
    let energy = Labelled(LennardJones::new(5), Cluster::of_kinds(&[0, 0, 1, 1, 1]));
    let draw = in_box(&[-1.2; 15], &[1.2; 15]);
    let settings = SearchSettings::measured(&energy, &draw, 1);
    let found = explore(&energy, &draw, &settings, &Run::default()).unwrap();
    assert_eq!(found.minima.len(), 3);
    let spread = found.minima[2].energy - found.minima[0].energy;
    assert!(spread.abs() < 1e-6, "{spread}");
}

#[test]
fn sizes_are_told_apart() {
    for (atoms, too_large) in [(7, false), (9, false), (38, true)] {
        let surface = named(&["lj".to_owned(), atoms.to_string()]).unwrap();
        let draw = in_box(&surface.low, &surface.high);
        let settings = SearchSettings::measured(&*surface.energy, &draw, 1);
        let probe = probe_size(&*surface.energy, &draw, &settings, &|_| false);
        assert_eq!(
            probe.is_too_large(&settings),
            too_large,
            "{atoms}: {probe:?}"
        );
    }
}

#[test]
#[ignore = "ten minutes: LJ38"]
fn the_double_funnel() {
    // J. P. K. Doye, M. A. Miller and D. J. Wales, J. Chem. Phys. 110, 6896 (1999): both bottoms, and the highest saddle of the
    // lowest way between them.
    let [octahedron, icosahedral, saddle] = [-173.928427, -173.252378, -169.709];
    let surface = named(&["lj", "38"].map(str::to_owned)).unwrap();
    let energy = &*surface.energy;
    let draw = in_box(&surface.low, &surface.high);
    let settings = SearchSettings::measured(energy, &draw, 1);
    let started = Instant::now();
    let run = Run {
        enough: &|share| started.elapsed() > Duration::from_mins(10).mul_f64(share),
        ..Run::default()
    };
    let lowest = LowestSettings::default();
    let (found, report) = explore_lowest(energy, &draw, &[], &settings, &lowest, &run).unwrap();
    let near = |energy: f64| {
        let minima = found.minima.iter();
        MinimumId(
            minima
                .map(|m| m.energy)
                .position(|e| (e - energy).abs() < 1e-5)
                .unwrap(),
        )
    };
    let tree = found.landscape(energy, &GroupSettings::default()).tree;
    let height = tree.minimax(near(octahedron), near(icosahedral)).unwrap();
    assert!(report.finds > 0, "{report:?}");
    assert_eq!(near(octahedron), MinimumId(0));
    // No way below the published one is known; within half of a unit of energy the search is worth its name.
    assert!(height > saddle - 1e-3 && height < saddle + 0.5, "{height}");
}
