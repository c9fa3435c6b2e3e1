//! Files that version 0.1.0 wrote with schema 1. They are read for ever; nobody makes them anew.
//!
//! They were made by `landscape synth --object ball -n 6 --preset four_points --steps 400 --keep all --seed 1`, `stability`,
//! `label`, `build --first 3 --no-report`, and `surface muller-brown --no-report`; pictures, texts and `resampled.parquet`,
//! which nothing reads any more, were left out.

use std::path::{Path, PathBuf};

use landscape::store::{GraspFile, LandscapeFiles, Overrides, StationaryRow};

fn golden(name: &str) -> PathBuf {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/schema_1");
    Path::new(folder).join(name)
}

#[test]
fn grasps_of_schema_1_are_read() {
    let (file, warnings) =
        GraspFile::read(&golden("grasps.parquet"), Overrides::default()).unwrap();
    assert_eq!(warnings, []);
    let metadata = &file.metadata;
    assert_eq!((metadata.schema_version, metadata.seed), (1, 1));
    assert_eq!(metadata.command, "landscape label h.parquet");
    let earlier: Vec<&str> = metadata
        .earlier
        .iter()
        .map(|step| step.command.as_str())
        .collect();
    assert_eq!(
        earlier,
        [
            "landscape synth --object ball -n 6 --steps 400 --seed 1 --preset four_points --keep all",
            "landscape stability g.parquet",
        ]
    );
    assert_eq!(metadata.stability["protocol"]["protocol"], "drop");
    assert_eq!(file.grasps.len(), 6);
    let second = &file.grasps[1];
    assert_eq!((second.id, second.scale), (1, 1.0));
    assert_eq!(
        (second.hand.as_str(), second.object.as_str()),
        ("human", "ball")
    );
    assert_eq!(*second.grasp.contacts, [307, 325, 625, 635]);
    assert_eq!(second.stable, Some(true));
    assert_eq!(second.label_auto.as_deref(), Some("Sphere 4 Finger"));
    assert_eq!(second.label_category.as_deref(), Some("power"));
    assert!((second.energy - 0.179312).abs() < 1e-6);
    assert!((second.grasp.pose.translation_m()[0] - 0.057637).abs() < 1e-6);
    assert!((second.terms.iter().sum::<f64>() - second.energy).abs() < 1e-12);
    let [population] = file.landscapes().try_into().unwrap();
    let hand = population.hand().unwrap();
    assert_eq!((hand.joints.len(), hand.surface.len()), (22, 773));
    let (mesh, _) = population.mesh().unwrap();
    assert!(!mesh.triangles().is_empty());
}

#[test]
fn landscapes_of_schema_1_are_read() {
    let map = golden("map");
    let files = LandscapeFiles::read(&map).unwrap();
    assert_eq!(LandscapeFiles::warnings(&map).unwrap(), []);
    let manifest = &files.manifest;
    assert_eq!(manifest.command, "landscape build grasps.parquet --first 3");
    let counts = &manifest.counts;
    assert_eq!(
        (counts.grasps, counts.minima, counts.groups, counts.pairs),
        (3, 3, 2, 3)
    );
    assert_eq!(files.minima[2].members, [2]);
    assert_eq!(
        files.minima[1].labels,
        [("Sphere 4 Finger".to_owned(), 1)].into()
    );
    assert_eq!(files.edges[0].evidence, "seam");
    assert!((files.edges[0].height.unwrap() - 0.185562).abs() < 1e-6);
    assert!(files.paths.len() > 50);

    let surface = golden("surface");
    let files = LandscapeFiles::read(&surface).unwrap();
    assert_eq!(files.manifest.command, "landscape surface muller-brown");
    let rows = StationaryRow::read(&surface).unwrap();
    let energies: Vec<f64> = rows
        .iter()
        .map(|row| (row.energy * 1e4).round() / 1e4)
        .collect();
    assert_eq!(
        energies,
        [-146.6995, -108.1667, -80.7678, -72.2489, -40.6648]
    );
}
