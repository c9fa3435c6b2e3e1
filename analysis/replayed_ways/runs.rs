//! Landscapes and drives, made if they are missing.

use std::fs;
use std::path::Path;

use landscape::evaluation::stability::{Reason, Replay, Replayed};
use landscape::store::LandscapeFiles;
use landscape::study::Drives;
use rayon::prelude::*;

use super::Failure;
use super::command::landscape;
use super::design::{CHAINS, CONDITIONS, Drive, Kind, MAP, NEIGHBOURS, drawn};
use super::table::Table;

const HEADER: &str = "drive,condition,held,reason,off_m,off_rad,way_s";
/// Drives between two writes of the table.
const BATCH: usize = 16;

/// The landscape of a hand on an object in `folder`, built if it is missing.
pub(crate) fn mapped(
    folder: &Path,
    [hand, object]: [&str; 2],
    seed: u64,
) -> Result<LandscapeFiles, Failure> {
    let place = |ending: &str| folder.join(format!("{hand}.{object}.{ending}"));
    let [grasps, map] = ["parquet", "landscape"].map(|ending| place(ending).display().to_string());
    if !Path::new(&grasps).exists() {
        let seed = seed.to_string();
        let of = [
            "synth", "--hand", hand, "--object", object, "-n", CHAINS, "--seed", &seed,
        ];
        landscape(&[&of[..], &["-q", "-o", &grasps]].concat())?;
    }
    if !Path::new(&map).exists() {
        let settings = folder.join("build.toml");
        fs::write(&settings, MAP)?;
        let settings = settings.display().to_string();
        let of = [
            "--config",
            &settings,
            "--neighbours",
            NEIGHBOURS,
            "--no-report",
        ];
        landscape(&[&["build", &grasps][..], &of, &["-q", "-o", &map]].concat())?;
    }
    Ok(LandscapeFiles::read(Path::new(&map))?)
}

/// What was driven in a landscape.
pub(crate) struct Driven<'a> {
    pub(crate) set: String,
    pub(crate) files: &'a LandscapeFiles,
    pub(crate) ways: Drives<'a>,
    pub(crate) drives: Vec<Drive>,
    table: Table,
}

impl<'a> Driven<'a> {
    /// Drives all that is drawn; the table `folder/set.csv` keeps what is done.
    pub(crate) fn new(
        folder: &Path,
        set: String,
        files: &'a LandscapeFiles,
        seed: u64,
    ) -> Result<Self, Failure> {
        let path = folder.join(format!("{set}.csv"));
        let mut driven = Self {
            ways: Drives::of(files, &set)?,
            drives: drawn(files, seed),
            table: Table::read(&path, HEADER)?,
            files,
            set,
        };
        let keys: Vec<String> = driven.drives.iter().map(|drive| drive.key()).collect();
        let missing = driven
            .drives
            .iter()
            .filter(|drive| driven.table.of(&drive.key()).is_empty());
        let missing: Vec<Drive> = missing.copied().collect();
        for (number, batch) in missing.chunks(BATCH).enumerate() {
            let rows: Vec<_> = batch.par_iter().map(|drive| driven.rows(*drive)).collect();
            for (drive, rows) in batch.iter().zip(rows) {
                driven
                    .table
                    .set(&drive.key(), rows?.iter().map(|row| &row[..]));
            }
            let partial = path.with_extension("partial");
            driven.table.write(&partial, &keys)?;
            fs::rename(partial, &path)?;
            eprintln!(
                "{}: {} of {}",
                driven.set,
                number * BATCH + batch.len(),
                missing.len()
            );
        }
        Ok(driven)
    }

    fn rows(&self, drive: Drive) -> Result<Vec<[f64; 6]>, String> {
        let row = |condition: usize| {
            let found = self
                .replayed(drive, condition)
                .map_err(|error| error.to_string())?;
            let held = f64::from(u8::from(found.reason == Reason::Held));
            let reason = f64::from(found.reason as u8);
            Ok([
                condition as f64,
                held,
                reason,
                found.off_m,
                found.off_rad,
                found.way_s,
            ])
        };
        (0..drive.conditions(&self.set)).map(row).collect()
    }

    /// Drives a way under one condition.
    pub(crate) fn replayed(&self, drive: Drive, condition: usize) -> Result<Replayed, Failure> {
        let way = match drive.kind {
            Kind::Rest => self.ways.rest(drive.ends[0]),
            Kind::Relaxed => self.ways.path(drive.ends)?,
            Kind::Straight | Kind::Random => self.ways.straight(drive.ends),
        };
        Ok(self.ways.replay(&way, &Replay::conditions()[condition]))
    }

    /// Whether a drive succeeds under each condition.
    pub(crate) fn successes(&self, drive: Drive) -> [bool; CONDITIONS] {
        let rows = self.table.of(&drive.key());
        std::array::from_fn(|condition| rows.get(condition).is_some_and(|row| row[1] > 0.5))
    }

    /// The name of the reason of a drive under the main condition, and how far off the object ended, metres.
    pub(crate) fn ending(&self, drive: Drive) -> (&'static str, f64) {
        let rows = self.table.of(&drive.key());
        let [code, off_m] = [2, 3].map(|place| rows.first().map_or(f64::NAN, |row| row[place]));
        let known = Reason::ALL
            .into_iter()
            .find(|reason| (f64::from(*reason as u8) - code).abs() < 0.5);
        (known.map_or("", Reason::name), off_m)
    }

    /// Whether both ends of a drive hold at rest under each condition.
    pub(crate) fn ends_hold(&self, drive: Drive) -> [bool; CONDITIONS] {
        let rest = |end| {
            self.successes(Drive {
                kind: Kind::Rest,
                ends: [end; 2],
            })
        };
        let [from, to] = drive.ends.map(rest);
        std::array::from_fn(|condition| from[condition] && to[condition])
    }
}
