//! Müller and Brown's surface from random starts: minima and merge heights agree with published values.

use landscape::energy::model::MullerBrown;
use landscape::optimize::QuenchSettings;
use landscape::sample::{Mala, Task, stream};
use landscape::topography::{
    Evidence, MapSettings, MatchTolerance, Minimum, MinimumId, Run, build_landscape, distinct,
    quench_all,
};
use rand::RngExt;

fn minima() -> Vec<Minimum> {
    let starts: Vec<Vec<f64>> = (0..40)
        .map(|id| {
            let mut rng = stream(1, Task::Start, id);
            vec![rng.random_range(-1.5..1.0), rng.random_range(-0.3..1.8)]
        })
        .collect();
    let energy = MullerBrown::new();
    let found = quench_all(
        &energy,
        &starts,
        &QuenchSettings::default(),
        &Run::default(),
    )
    .unwrap();
    distinct(&energy, &found, &MatchTolerance::default(), 1e-6).0
}

#[test]
fn merge_heights_are_the_published_ones() {
    let reference: serde_json::Value =
        serde_json::from_str(include_str!("reference/landscapes.json")).unwrap();
    let reference = &reference["muller_brown"];
    let (energy, minima) = (MullerBrown::new(), minima());
    assert_eq!(minima.len(), reference["minima"].as_array().unwrap().len());
    let settings = MapSettings::for_minima(&energy, &minima);
    let found = build_landscape(
        &energy,
        &Mala::new(&energy),
        minima,
        &settings,
        &Run::default(),
    )
    .unwrap();
    for i in 0..3 {
        let known = reference["minima"][i]["energy"].as_f64().unwrap();
        assert!((found.network[petgraph::graph::NodeIndex::new(i)].energy - known).abs() < 1e-5);
        for j in 0..3 {
            let height = found.tree.minimax(MinimumId(i), MinimumId(j)).unwrap();
            let known = reference["minimax"][i][j].as_f64().unwrap();
            assert!((height - known).abs() < 1e-5, "{i} {j}: {height} {known}");
        }
    }
    for node in &found.tree.nodes {
        assert_eq!(node.evidence, Evidence::Saddle);
    }
    // No pass joins the two lowest directly; the path between them leads through the third and says so.
    let around = found.connection(MinimumId(0), MinimumId(1)).unwrap();
    assert_eq!(around.edge.evidence, Evidence::Path);
    // A raw chain is an upper bound, up to the length of a step (measured excess below 0.01).
    for connection in &found.connections {
        let exact = found.tree.minimax(connection.from, connection.to).unwrap();
        for barrier in connection
            .forward
            .iter()
            .chain(&connection.backward)
            .flatten()
        {
            assert!(*barrier > exact - 0.05, "{barrier} {exact}");
        }
    }
}

/// By definition, all minima are joined at the ceiling: higher passes have its height, and lower ones keep theirs.
#[test]
fn no_merge_is_above_the_ceiling() {
    let (energy, minima) = (MullerBrown::new(), minima());
    // The passes are at −72.2 and −40.7.
    let settings = MapSettings {
        ceiling: Some(-60.0),
        ..MapSettings::for_minima(&energy, &minima)
    };
    let kernel = Mala::new(&energy);
    let found = build_landscape(&energy, &kernel, minima, &settings, &Run::default()).unwrap();
    let merges: Vec<(f64, Evidence)> = found
        .merges()
        .iter()
        .map(|merge| (merge.height, merge.evidence))
        .collect();
    assert_eq!(merges.len(), 2);
    for (height, evidence) in merges {
        if height > -70.0 {
            assert_eq!(
                (height.to_bits(), evidence),
                ((-60.0_f64).to_bits(), Evidence::Path)
            );
        } else {
            assert!((height + 72.248_94).abs() < 1e-4, "{height}");
            assert_eq!(evidence, Evidence::Saddle);
        }
    }
}

#[test]
fn a_minimum_left_out_is_found_on_the_way() {
    let (energy, mut minima) = (MullerBrown::new(), minima());
    let between = minima.remove(2);
    let settings = MapSettings::for_scales(50.0, 1.0);
    let found = build_landscape(
        &energy,
        &Mala::new(&energy),
        minima,
        &settings,
        &Run::default(),
    )
    .unwrap();
    let height = found.tree.minimax(MinimumId(0), MinimumId(1)).unwrap();
    assert!((height + 40.6648435).abs() < 1e-5);
    assert_eq!(found.unlisted_minima.len(), 1);
    assert!((found.unlisted_minima[0].energy - between.energy).abs() < 1e-6);
}
