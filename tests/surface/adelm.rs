//! `landscape surface --search adelm`.

use std::fs;

use landscape::store::LandscapeFiles;
use serde_json::Value;

use crate::desk::Desk;

/// Heights of the two passes of the Müller–Brown surface.
const PASSES: [f64; 2] = [-72.248_940, -40.664_844];

#[test]
fn attraction_diffusion_alone_bounds_the_passes() {
    let desk = Desk::empty();
    let told = desk.mapped("muller-brown --search adelm --no-report -o one");
    assert!(told.contains("**3 minima** from 200 points"), "{told}");
    assert!(told.contains("an upper bound"), "{told}");
    let folder = desk.path("one");
    let files = LandscapeFiles::read(&folder).unwrap();
    let mut heights: Vec<f64> = (files.edges.iter())
        .filter_map(|edge| edge.height)
        .collect();
    heights.sort_by(f64::total_cmp);
    assert_eq!(heights.len(), 2);
    for (height, pass) in heights.iter().zip(PASSES) {
        assert!(*height >= pass && *height < pass + 120.0, "{height}");
    }
    let manifest = fs::read(folder.join("landscape.json")).unwrap();
    let manifest: Value = serde_json::from_slice(&manifest).unwrap();
    let findings = &manifest["findings"];
    assert_eq!(findings["method"], "sequential ADELM");
    assert!(findings["chosen"].is_string() && findings["arrivals"].is_array());

    // The same on one thread.
    desk.mapped("muller-brown --search adelm --no-report --threads 1 -o other");
    for file in ["minima.parquet", "edges.parquet", "paths.parquet"] {
        let bytes = |name: &str| fs::read(desk.path(name).join(file)).unwrap();
        assert!(bytes("one") == bytes("other"), "{file}");
    }
}

#[test]
fn what_attraction_diffusion_does_not_use_is_refused() {
    let desk = Desk::empty();
    for flags in ["--patience 9", "--lowest 9", "--family-barrier 0.1"] {
        let said = desk.unmapped(&format!("muller-brown --search adelm {flags}"));
        assert!(said.contains(flags.split(' ').next().unwrap()), "{said}");
    }
}
