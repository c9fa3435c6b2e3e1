//! The minima and transition states of a finished landscape, for thermodynamics and kinetics.

use std::path::Path;

use super::error::StudyError;
use crate::store::{StationaryRow, StoreError};
use crate::topography::exchange::{Database, Vibrations};
use crate::topography::{Evidence, GroupSettings, Groups, Network, Tree};

/// The names of the files.
const FILES: [&str; 2] = ["min.data", "ts.data"];

/// Minima and transition states with their vibrations, from `min.data` and `ts.data` of a landscape or of PATHSAMPLE.
#[derive(Debug, Clone)]
pub struct NetworkOfStates {
    /// Name of the folder, for titles.
    pub name: String,
    /// The minima in ascending order of energy, so that minimum i is m*i* of the landscape, and the transition states.
    pub database: Database,
    /// The lowest connection of each pair.
    pub network: Network,
    /// Its tree of merges.
    pub tree: Tree,
    /// Sets of minima that low barriers join.
    pub groups: Groups,
    /// Number of connections without curvatures (bounds that are no verified saddles), which are left out.
    pub left_out: usize,
}

impl NetworkOfStates {
    /// Reads a folder. If the folder is a landscape of `landscape surface`, its `stationary.parquet` adds the number of
    /// vibrational modes and the negative curvatures, which `min.data` and `ts.data` do not hold.
    ///
    /// # Errors
    /// If a file is missing or damaged, or if it holds no vibrational data (`min.data` of topsearch).
    pub fn open(folder: &Path, groups: &GroupSettings) -> Result<Self, StudyError> {
        if !folder.is_dir() {
            return Err(if folder.exists() {
                StoreError::NoFolder(folder.to_owned()).into()
            } else {
                StoreError::NotFound(folder.to_owned()).into()
            });
        }
        let [minima, states] = FILES.map(|name| read(folder, name));
        let parsed = Database::parse(&minima?, &states?);
        let (mut database, _) = parsed.map_err(|source| StudyError::Exchange {
            folder: folder.display().to_string(),
            source,
        })?;
        if folder.join("stationary.parquet").is_file() {
            complete(&mut database, &StationaryRow::read(folder)?);
        }
        if database
            .minima
            .iter()
            .all(|minimum| is_placeholder(minimum.vibrations))
        {
            return Err(StudyError::NoVibrations(folder.display().to_string()));
        }
        let before = database.transition_states.len();
        (database.transition_states).retain(|state| !is_placeholder(state.vibrations));
        let left_out = before - database.transition_states.len();
        let database = database.by_energy();
        let network = database.network();
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self {
            name: name.strip_suffix(".landscape").unwrap_or(&name).to_owned(),
            tree: Tree::from_network(&network, Evidence::Chain),
            groups: Groups::new(&network, groups),
            database,
            network,
            left_out,
        })
    }
}

/// Whether vibrational data are missing, or are the placeholders that are written where nothing is known.
fn is_placeholder(vibrations: Option<Vibrations>) -> bool {
    vibrations.is_none_or(|known| known == Vibrations::default())
}

/// Adds what only the table knows. Its rows are in the order of the texts.
fn complete(database: &mut Database, rows: &[StationaryRow]) {
    let (minima, saddles): (Vec<_>, Vec<_>) = rows.iter().partition(|row| row.index == 0);
    if minima.len() != database.minima.len() || saddles.len() != database.transition_states.len() {
        return;
    }
    database.vibrational_modes = minima.first().map(|row| row.curvatures.len());
    for (state, row) in database.transition_states.iter_mut().zip(saddles) {
        if let Some(vibrations) = &mut state.vibrations {
            let lowest = row.curvatures.first().copied();
            vibrations.negative_curvature = lowest.filter(|lowest| *lowest < 0.0);
        }
    }
}

fn read(folder: &Path, name: &str) -> Result<String, StoreError> {
    let path = folder.join(name);
    match std::fs::read_to_string(&path) {
        Ok(text) => Ok(text),
        Err(source) if source.kind() == std::io::ErrorKind::NotFound => {
            Err(StoreError::NotFound(path))
        }
        Err(source) => Err(StoreError::Io {
            action: "read",
            path,
            source,
        }),
    }
}
