//! Lennard-Jones clusters, found by basin hopping and mapped. Minima and merge heights agree with the literature.

use landscape::energy::model::LennardJones;
use landscape::sample::{Mala, Task, stream};
use landscape::topography::{
    Evidence, HoppingSettings, Landscape, MapSettings, MatchTolerance, Minimum, MinimumId, Run,
    build_landscape, hop,
};
use rand::RngExt;

fn hopped(atoms: usize) -> Vec<Minimum> {
    let energy = LennardJones::new(atoms);
    let starts: Vec<Vec<f64>> = (0..4)
        .map(|id| {
            let mut rng = stream(1, Task::Start, id);
            (0..3 * atoms)
                .map(|_| rng.random_range(-1.2..1.2))
                .collect()
        })
        .collect();
    let hopping = HoppingSettings {
        kick: 1.2,
        sameness: MatchTolerance {
            energy: 1e-6,
            distance: 1e-2,
        },
        ..HoppingSettings::default()
    };
    hop(&energy, &starts, &hopping, &Run::default())
}

fn mapped(atoms: usize) -> Landscape {
    let energy = LennardJones::new(atoms);
    let minima = hopped(atoms);
    let settings = MapSettings::for_minima(&energy, &minima);
    build_landscape(
        &energy,
        &Mala::new(&energy),
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

#[test]
fn nine_atoms_by_hopping() {
    // Doye and Wales (2002): 21 minima.
    assert_eq!(hopped(9).len(), 21);
}
