//! The same comparison through `landscape surface`, with a program that computes the surface in other units.

use std::path::Path;
use std::process::Command;

use landscape::energy::model::Surface;
use landscape::store::{Counts, LandscapeFiles, StationaryRow};

use super::AS_IT_IS;
use super::scaled::{Units, binary, decimal, stretch, surfaces};

/// Whether Python is available.
fn python() -> bool {
    let found = Command::new("python3").arg("--version").output();
    let there = found.is_ok_and(|output| output.status.success());
    if !there {
        crate::skipped::skipped("there is no python3");
    }
    there
}

/// Points and findings of a run in the original units of the surface.
fn mapped(surface: &Surface, units: Units) -> (Vec<StationaryRow>, String) {
    let folder = tempfile::TempDir::new().unwrap();
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/units/shell.py");
    let model = surface.name.split(' ').next().unwrap();
    let (program, Units { length, energy }) = (program.display(), units);
    let stretch = stretch(surface, units);
    let sides = surface.low.iter().zip(&surface.high);
    let sides: Vec<String> = sides
        .map(|(low, high)| format!("{}:{}", low * stretch, high * stretch))
        .collect();
    let run = Command::new(env!("CARGO_BIN_EXE_landscape"))
        .args(["surface", "-q", "--patience", "8", "-o", "out"])
        .args(["--coordinates", surface.coordinates])
        .arg(format!("--region={}", sides.join(",")))
        .arg("--command")
        .arg(format!("python3 '{program}' {model} {length:?} {energy:?}"))
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(run.status.success(), "{}: {said}", surface.name);
    let out = folder.path().join("out");
    let manifest = LandscapeFiles::read(&out).unwrap().manifest;
    let findings = ["saddles", "coverage", "ends_of_searches"].map(|key| &manifest.findings[key]);
    // The scales are measured by descents without a tolerance: where a gradient is too small to be squared, they may end a
    // step earlier in one unit than in another.
    let counts = Counts {
        evaluations: 0,
        ..manifest.counts
    };
    let findings = format!("{findings:?}, {counts:?}");
    let rows = StationaryRow::read(&out).unwrap().into_iter();
    let rows = rows.map(|row| StationaryRow {
        energy: row.energy / energy,
        coordinates: row.coordinates.iter().map(|x| x / stretch).collect(),
        gradient_norm: row.gradient_norm / energy * stretch,
        curvatures: (row.curvatures.iter())
            .map(|c| c / energy * (stretch * stretch))
            .collect(),
        ..row
    });
    (rows.collect(), findings)
}

#[test]
fn a_program_is_mapped_the_same_in_all_units() {
    if !python() {
        return;
    }
    for mut surface in surfaces() {
        if surface.name.starts_with("lj") {
            surface = landscape::energy::model::named(&["lj", "4"]).unwrap();
        }
        let (known, findings) = mapped(&surface, AS_IT_IS);
        let same = mapped(&surface, binary()[1]);
        assert_eq!(same, (known.clone(), findings), "{}", surface.name);
        let (found, _) = mapped(&surface, decimal()[2]);
        let name = &surface.name;
        assert_eq!(found.len(), known.len(), "{name}");
        for (found, known) in found.iter().zip(&known) {
            assert_eq!(found.index, known.index, "{name}");
            let near = (found.energy - known.energy).abs() < 1e-6 * (1.0 + known.energy.abs());
            assert!(near, "{name}: {} instead of {}", found.energy, known.energy);
        }
    }
}
