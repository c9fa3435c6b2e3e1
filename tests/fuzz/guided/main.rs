//! The coverage-guided fuzzer of all readers of files (libFuzzer). `.ci/nightly` builds it and documents its use.
//!
//! `LANDSCAPE_FUZZ_READER` names the reader; without it the names of all readers are printed. Valid files are added to the
//! folder `LANDSCAPE_FUZZ_SEEDS`, if it is given.
#![no_main]

use std::path::PathBuf;
use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;
use readers::{Read, readers};
use tempfile::TempDir;

#[path = "../readers/mod.rs"]
mod readers;

/// Root folder of the valid files.
const PROJECT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");

/// The reader and its folder.
static CHOSEN: OnceLock<(Read, TempDir)> = OnceLock::new();

fn choose() {
    let name = std::env::var("LANDSCAPE_FUZZ_READER").unwrap_or_default();
    let mut all = readers();
    let names: Vec<&str> = all.iter().map(|(name, ..)| *name).collect();
    let Some(place) = names.iter().position(|known| *known == name) else {
        println!("{}", names.join("\n"));
        std::process::exit(i32::from(!name.is_empty()));
    };
    let (_, seeds, read) = all.swap_remove(place);
    if let Some(folder) = std::env::var_os("LANDSCAPE_FUZZ_SEEDS").map(PathBuf::from) {
        for (number, seed) in seeds.iter().enumerate() {
            std::fs::write(folder.join(format!("seed-{number}")), seed).unwrap();
        }
    }
    // libFuzzer's hook ends the process at panics that the reader turns into sentences (damaged pages of Parquet); all
    // others reach its wrapper, which does the same.
    let _ = std::panic::take_hook();
    assert!(CHOSEN.set((read, tempfile::tempdir().unwrap())).is_ok());
}

fuzz_target!(
    init: choose(),
    |bytes: &[u8]| {
        let (reader, folder) = CHOSEN.get().expect("chosen before the first file");
        if let Err(sentence) = reader(bytes, folder.path()) {
            assert!(!sentence.is_empty(), "it says nothing");
        }
    }
);
