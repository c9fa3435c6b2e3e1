//! Shared by the programs about yields: runs of many chains, and a table of their numbers that grows with each run.

mod interval;

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;
use std::{fs, io};

use landscape::grasp::synthesis::SynthesisSettings;
use landscape::grasp::{EnergySettings, GraspEnergy};
use landscape::hand::Hand;
use landscape::object::Object;

pub(crate) use interval::interval;

/// A run: many chains of one method on one object.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    /// Name of the row or line.
    pub(crate) name: String,
    pub(crate) object: &'static str,
    pub(crate) energy: EnergySettings,
    pub(crate) synthesis: SynthesisSettings,
    pub(crate) seed: u64,
    pub(crate) chains: u64,
}

impl Run {
    /// Identifies this run, including its settings.
    pub(crate) fn key(&self) -> Result<String, serde_json::Error> {
        let settings = serde_json::to_string(&(self.energy, self.synthesis))?;
        // FNV-1a is sufficient for a name.
        let hash = settings
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            });
        Ok(format!(
            "{},{},{},{},{hash:016x}",
            self.name, self.object, self.seed, self.chains
        ))
    }

    /// The energy of a hand on the object.
    pub(crate) fn energy(
        &self,
        hand: Arc<Hand>,
    ) -> Result<GraspEnergy, Box<dyn std::error::Error>> {
        let object = Object::named(self.object)?;
        Ok(GraspEnergy::new(hand, Arc::new(object), self.energy)?)
    }
}

/// A comma-separated table whose first five columns are the key of a run. Runs in it are not repeated.
#[derive(Debug)]
pub(crate) struct Table {
    header: String,
    rows: Vec<String>,
}

impl Table {
    pub(crate) fn read(path: &Path, columns: &str) -> io::Result<Self> {
        let header = format!("name,object,seed,chains,settings,{columns}");
        let text = match fs::read_to_string(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            text => text?,
        };
        let mut lines = text.lines();
        let known = lines.next() == Some(&*header);
        let rows = lines.filter(|_| known).map(str::to_owned).collect();
        Ok(Self { header, rows })
    }

    /// The numbers of a run, row by row; empty if it was not made yet.
    pub(crate) fn of(&self, key: &str) -> Vec<Vec<f64>> {
        let of_key = self
            .rows
            .iter()
            .filter_map(|row| row.strip_prefix(key)?.strip_prefix(','));
        of_key
            .map(|row| {
                row.split(',')
                    .map(|v| v.parse().unwrap_or(f64::NAN))
                    .collect()
            })
            .collect()
    }

    pub(crate) fn add(&mut self, key: &str, numbers: &[f64]) {
        let mut row = key.to_owned();
        for number in numbers {
            let _ = write!(row, ",{number}");
        }
        self.rows.push(row);
    }

    /// Writes the rows of these runs in this order; other rows are dropped.
    pub(crate) fn write(&self, path: &Path, keys: &[String]) -> io::Result<()> {
        let mut text = format!("{}\n", self.header);
        for key in keys {
            let of_key =
                |row: &&String| row.strip_prefix(&**key).is_some_and(|r| r.starts_with(','));
            for row in self.rows.iter().filter(of_key) {
                text.push_str(row);
                text.push('\n');
            }
        }
        fs::write(path, text)
    }
}
