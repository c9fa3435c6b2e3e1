//! Every reader of files against broken files. The result is a value or one error message, never a panic, and memory stays
//! bounded.
//!
//! Each reader gets [`INPUTS`] mutations of valid files, the same ones in every run. `LANDSCAPE_FUZZ_INPUTS=10000 cargo
//! test --release --test fuzz` runs more of them, `LANDSCAPE_FUZZ_SECONDS=300` runs for that many seconds per reader, and
//! `LANDSCAPE_FUZZ_READER=urdf` selects one reader. Inputs that make a reader fail are left in `target/fuzz/<reader>`. The
//! file being read is stored there as `<reader>.reading`, because a stack overflow cannot be caught. A finding becomes a
//! test beside its reader. The coverage-guided fuzzer in `guided` uses the same list.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod magnitudes;
mod mutate;
mod readers;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use landscape::sample::{Rng, Task, stream};
use rand::RngExt;
use readers::{Read, readers};

/// Root folder of the valid files.
const PROJECT: &str = env!("CARGO_MANIFEST_DIR");
/// Mutations of each reader's files in a normal run of the tests.
const INPUTS: u64 = 150;
/// Largest time for one input.
const SLOWEST: Duration = Duration::from_secs(20);
/// Largest memory for one input of at most a megabyte, kilobytes.
const LARGEST_KB: u64 = 1_500_000;

/// Peak memory of this process, kilobytes; 0 if the system does not report it.
fn peak_kb() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
    number.unwrap_or(0)
}

/// The fault of a reader on some bytes, if there is one.
fn fault(read: Read, bytes: &[u8], folder: &Path) -> Option<String> {
    let (started, before) = (Instant::now(), peak_kb());
    let Ok(result) = catch_unwind(AssertUnwindSafe(|| read(bytes, folder))) else {
        return Some("it panics".to_owned());
    };
    // The system counts pages of several threads at times only, so that the peak may even fall a little.
    let (took, grew) = (started.elapsed(), peak_kb().saturating_sub(before));
    match result {
        _ if took > SLOWEST => Some(format!("it takes {took:?}")),
        _ if grew > LARGEST_KB => Some(format!("it takes {grew} kB")),
        Err(sentence) if sentence.is_empty() => Some("it says nothing".to_owned()),
        _ => None,
    }
}

#[test]
fn broken_files_have_sentences() {
    let seconds = std::env::var("LANDSCAPE_FUZZ_SECONDS").ok();
    let span = seconds.map(|seconds| Duration::from_secs_f64(seconds.parse().unwrap()));
    let inputs = std::env::var("LANDSCAPE_FUZZ_INPUTS").ok();
    let long = span.is_some() || inputs.is_some();
    let inputs = inputs.map_or(INPUTS, |inputs| inputs.parse().unwrap());
    let only = std::env::var("LANDSCAPE_FUZZ_READER").ok();
    let target = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/fuzz");
    fs::create_dir_all(&target).unwrap();
    let mut findings = Vec::new();
    for (name, seeds, read) in readers() {
        if only.as_ref().is_some_and(|only| only != name) {
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let results: Vec<_> = seeds.iter().map(|seed| read(seed, folder.path())).collect();
        // MANO's file cannot be among them.
        let good = results.iter().any(Result::is_ok);
        assert!(good || name == "npz", "{name}: no good file: {results:?}");
        for (i, seed) in seeds.iter().enumerate() {
            let fault = fault(read, seed, folder.path());
            assert!(fault.is_none(), "{name}: good file {i}: {fault:?}");
        }
        let (started, mut count) = (Instant::now(), 0);
        while span.map_or(count < inputs, |span| started.elapsed() < span) {
            let mut rng: Rng = stream(count, Task::Start, 0);
            let [seed, other] = [0; 2].map(|_| &seeds[rng.random_range(0..seeds.len())]);
            let broken = mutate::mutated(seed, other, &mut rng);
            let reading: PathBuf = target.join(format!("{name}.reading"));
            if long {
                fs::write(&reading, &broken).unwrap();
            }
            if let Some(fault) = fault(read, &broken, folder.path()) {
                let path = target.join(format!("{name}.{count}"));
                fs::write(&path, &broken).unwrap();
                findings.push(format!("{name}: {fault}: {}", path.display()));
            }
            count += 1;
        }
    }
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}
