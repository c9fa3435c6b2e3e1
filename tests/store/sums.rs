//! Checksums: damaged, altered or foreign files are refused and never read as other numbers.

use std::fs;
use std::path::{Path, PathBuf};

use crate::store::{file, flipped, landscape, of, place, read, sentence};
use arrow_array::Float64Array;
use landscape::store::{AtomicFolder, LandscapeFiles, Overrides, StoreError, Warning};
use serde_json::Value;
use tempfile::TempDir;

/// A finished landscape in a folder of its own.
fn finished(files: &LandscapeFiles) -> (TempDir, PathBuf) {
    let (folder, path) = place("cup.landscape");
    let unfinished = AtomicFolder::open(&path, false).unwrap();
    files.write(&unfinished).unwrap();
    (folder, unfinished.finish().unwrap())
}

/// Changes the manifest of the landscape at `path`.
fn edit(path: &Path, change: impl FnOnce(&mut Value)) {
    let manifest = path.join("landscape.json");
    let mut value: Value = serde_json::from_slice(&fs::read(&manifest).unwrap()).unwrap();
    change(&mut value);
    fs::write(manifest, value.to_string()).unwrap();
}

/// Distance between the bytes that are changed.
const EVERY: usize = 11;

#[test]
fn a_damaged_file_of_grasps_is_refused_or_read_as_it_was() {
    let (_folder, path) = place("grasps.parquet");
    file(3).write(&path).unwrap();
    let bytes = fs::read(&path).unwrap();
    let (whole, _) = read(&path).unwrap();
    let mut refused = 0;
    for position in (0..bytes.len()).step_by(EVERY) {
        fs::write(&path, flipped(&bytes, position, 1 << (position % 8))).unwrap();
        match read(&path) {
            Ok((found, warnings)) => {
                assert_eq!(found, whole, "byte {position}");
                // Where the name of the program or of the checksum is damaged, the file looks like one of another program.
                let told = |warning: &Warning| matches!(warning, Warning::Unsealed(_));
                assert!(warnings.iter().all(told), "byte {position}: {warnings:?}");
            }
            Err(_) => refused += 1,
        }
    }
    assert!(10 * refused > 9 * (bytes.len() / EVERY), "{refused}");
}

#[test]
fn a_damaged_file_of_a_landscape_is_refused() {
    let (_folder, path) = finished(&landscape());
    for name in ["minima.parquet", "edges.parquet", "paths.parquet"] {
        let file = path.join(name);
        let bytes = fs::read(&file).unwrap();
        for position in (0..bytes.len()).step_by(11) {
            fs::write(&file, flipped(&bytes, position, 1)).unwrap();
            let refused = LandscapeFiles::read(&path).unwrap_err();
            assert!(
                matches!(&refused, StoreError::NotOfLandscape { path, .. } if *path == file),
                "{refused}"
            );
        }
        fs::write(&file, bytes).unwrap();
    }
    assert_eq!(LandscapeFiles::read(&path).unwrap(), landscape());
}

#[test]
fn files_of_two_landscapes_are_not_mixed() {
    let mut other = landscape();
    other.edges[0].height = Some(0.75);
    let (folder, path) = finished(&landscape());
    let (_other_folder, other) = finished(&other);
    fs::copy(other.join("edges.parquet"), path.join("edges.parquet")).unwrap();
    let refused = LandscapeFiles::read(&path).unwrap_err();
    assert_eq!(
        sentence(&refused, folder.path()),
        "cup.landscape/edges.parquet does not belong to this landscape: cup.landscape/landscape.json lists another \
         checksum for it, or none, so it was altered or comes from elsewhere; put the original table back, or build the \
         landscape again"
    );
    fs::copy(other.join("landscape.json"), path.join("landscape.json")).unwrap();
    fs::copy(other.join("minima.parquet"), path.join("minima.parquet")).unwrap();
    let whole = LandscapeFiles::read(&path).unwrap();
    assert_eq!(whole.edges[0].height, Some(0.75));
}

#[test]
fn an_altered_manifest_and_one_without_checksums_are_refused() {
    let (folder, path) = finished(&landscape());
    // Other spaces are no other content.
    edit(&path, |_| {});
    assert_eq!(LandscapeFiles::read(&path).unwrap(), landscape());

    edit(&path, |manifest| manifest["scale"] = 0.07.into());
    let refused = || sentence(&LandscapeFiles::read(&path).unwrap_err(), folder.path());
    let said = "cup.landscape/landscape.json is not as landscape wrote it: its content does not match its checksum, so it \
                was damaged or altered; use an intact copy, or make it again";
    assert_eq!(refused(), said);
    edit(&path, |manifest| {
        manifest.as_object_mut().unwrap().remove("checksums");
    });
    assert_eq!(refused(), said);
}

/// Pandas and others may keep our metadata in files whose content they changed.
#[test]
fn what_another_program_wrote_from_our_file_is_read() {
    let mut file = file(3);
    let changed = of(&file).set("energy", Float64Array::from(vec![0.5, 0.6, 0.7]));
    let (read, _) = changed.read(Overrides::default()).unwrap();
    for (grasp, energy) in file.grasps.iter_mut().zip([0.5, 0.6, 0.7]) {
        grasp.energy = energy;
    }
    assert_eq!(read, file);
}
