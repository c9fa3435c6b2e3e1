//! Lennard-Jones clusters, searched and mapped. Minima and merge heights agree with the literature.

use landscape::energy::Energy;
use landscape::energy::model::{LennardJones, named};
use landscape::sample::Mala;
use landscape::space::{Cluster, Space};
use landscape::topography::{
    Landscape, MapSettings, MinimumId, Run, SearchSettings, build_landscape, explore, in_box,
    probe_size,
};

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
fn seven_atoms() {
    check(7).unwrap();
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
