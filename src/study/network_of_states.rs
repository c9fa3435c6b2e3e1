//! The minima and transition states of a finished landscape, for thermodynamics and kinetics.

use std::path::Path;

use super::error::StudyError;
use super::name_of;
use crate::printable::counted;
use crate::store::{LandscapeFiles, Manifest, StationaryRow, StoreError};
use crate::thermal::Superposition;
use crate::topography::exchange::{Database, NO_TRANSITION_STATES, Vibrations};
use crate::topography::{Evidence, Families, FamilySettings, Network, Tree, Verdict};

/// The names of the files.
const FILES: [&str; 2] = ["min.data", "ts.data"];
/// A curvature below this fraction of the greatest of all is 0 within the accuracy of the differences.
const FLAT: f64 = 1e-6;
/// Where all curvatures are below this, in the units of the landscape, they are more likely those of flat points (0, but for
/// the steps of the differences) than those of wells in very large units of length.
const ALL_FLAT: f64 = 1e-10;
/// Greatest number of points that a note names.
const NAMED: usize = 8;
/// Energies divided by a temperature, and temperatures, must be below this, so that sums of them are numbers.
const FAR: f64 = 1e290;

/// Minima and transition states with their vibrations, from `min.data` and `ts.data` of a landscape or of PATHSAMPLE.
#[derive(Debug, Clone)]
pub struct NetworkOfStates {
    /// Name of the folder, for titles.
    pub name: String,
    /// The minima in ascending order of energy, and the transition states.
    pub database: Database,
    /// The number of each minimum in the landscape: minimum i is m*numbers\[i\]*. It is i, unless minima were left out
    /// ([`NetworkOfStates::without_faces`]).
    pub numbers: Vec<usize>,
    /// The row of each minimum of the landscape (m0, m1, …) in `min.data`, counted from 0.
    pub rows: Vec<usize>,
    /// The lowest connection of each pair.
    pub network: Network,
    /// The evidence for each connection: [`Evidence::Saddle`] if this program searched the landscape, otherwise
    /// [`Evidence::Given`].
    pub evidence: Evidence,
    /// Its tree of merges.
    pub tree: Tree,
    /// Sets of minima of the landscape (by their numbers in it) that low barriers join.
    pub families: Families,
    /// Number of connections without curvatures (bounds that are no verified saddles, or saddles on a face of a box), which
    /// are left out.
    pub left_out: usize,
    /// Where the harmonic formulae do not hold and what the files had wrong, a sentence each, without capital and full stop.
    pub notes: Vec<String>,
}

/// Why a text is no list of minima ([`NetworkOfStates::minima_of`]).
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NumberedMinima {
    /// The text is empty.
    #[error(
        "it is empty; its first line is how many minima it lists, and the numbers of these follow"
    )]
    Empty,
    /// A word is no whole number.
    #[error("`{0}` is not the number of a minimum")]
    NoNumber(String),
    /// There are fewer or more numbers than the text says.
    #[error(
        "its first line says {}, and {} {}; one or more are needed, as many as it says",
        counted(*told, "minimum"),
        counted(*found, "number"),
        if *found == 1 { "follows" } else { "follow" }
    )]
    Count {
        /// The first number.
        told: usize,
        /// How many numbers follow.
        found: usize,
    },
    /// No minimum has the number.
    #[error(
        "minimum {number} does not exist: min.data lists {}, counted from 1",
        counted(*count, "minimum")
    )]
    NoSuchMinimum {
        /// The number.
        number: usize,
        /// Number of minima.
        count: usize,
    },
}

impl NetworkOfStates {
    /// Reads a folder. If the folder is a landscape of `landscape surface`, its `stationary.parquet` adds the number of
    /// vibrational modes, the negative curvatures, and which points are not isolated. `min.data` and `ts.data` do not hold
    /// these. If `families` names no barrier, that of the landscape's own families holds.
    ///
    /// # Errors
    /// If a file is missing or damaged (the manifest, if there is one, too), or if it holds no vibrational data (`min.data`
    /// of topsearch).
    pub fn open(folder: &Path, families: &FamilySettings) -> Result<Self, StudyError> {
        if !folder.is_dir() {
            return Err(if folder.exists() {
                StoreError::NoFolder(folder.to_owned()).into()
            } else {
                StoreError::NotFound(folder.to_owned()).into()
            });
        }
        let [minima, states] = FILES;
        let alone = !folder.join(states).exists();
        let states = if alone {
            String::new()
        } else {
            read(folder, states)?
        };
        let parsed = Database::read(&read(folder, minima)?, &states);
        let parsed = parsed.map_err(|source| StudyError::Exchange {
            folder: folder.display().to_string(),
            source,
        })?;
        let (mut database, mut notes) = (parsed.database, parsed.notes);
        notes.extend(alone.then(|| NO_TRANSITION_STATES.to_owned()));
        if folder.join("stationary.parquet").is_file() {
            notes.extend(complete(&mut database, &StationaryRow::read(folder)?));
        }
        if (database.minima.iter()).all(|minimum| minimum.vibrations.is_none()) {
            return Err(StudyError::NoVibrations(folder.display().to_string()));
        }
        let all = database.transition_states.len();
        (database.transition_states).retain(|state| state.vibrations.is_some());
        let left_out = all - database.transition_states.len();
        let rows = database.rows_by_energy();
        let database = database.by_energy();
        let manifest = manifest(folder)?;
        // What was imported says so. Tables do not tell whether this program searched a landscape: which of them there are
        // depends on how it did. Of our own connections, only verified saddles have curvatures.
        let is_own = |manifest: &Manifest| manifest.energy.get("imported").is_none();
        let is_own = manifest.as_ref().is_some_and(is_own);
        let evidence = if is_own {
            Evidence::Saddle
        } else {
            Evidence::Given
        };
        let families = FamilySettings {
            barrier: (families.barrier).or_else(|| manifest?.family_barrier),
            ..families.clone()
        };
        let network = network_of(&database, evidence);
        let name = name_of(folder);
        Ok(Self {
            name: name.strip_suffix(".landscape").unwrap_or(&name).to_owned(),
            tree: Tree::from_network(&network, Evidence::Chain),
            families: Families::new(&network, &families),
            numbers: (0..database.minima.len()).collect(),
            database,
            rows,
            network,
            evidence,
            left_out,
            notes,
        })
    }

    /// The same without the minima whose curvatures are not known, such as those on faces of a box, and without the transition
    /// states that lead to them. A note tells what is left out. Minima keep their names.
    #[must_use]
    pub fn without_faces(mut self) -> Self {
        let unknown = self.unknown();
        if unknown.is_empty() {
            return self;
        }
        let mut place = vec![None; self.database.minima.len()];
        let known = self.database.minima.iter().enumerate();
        let known = known.filter(|(_, minimum)| minimum.vibrations.is_some());
        for (new, (old, _)) in known.enumerate() {
            place[old] = Some(new);
        }
        self.notes.push(format!(
            "{} of {} minima are left out with the saddles that lead to them, since their curvatures are unknown, as on a face \
             of a box: {}; partition functions, occupations and rates lack them",
            unknown.len(),
            self.database.minima.len(),
            listed(self.names(&unknown))
        ));
        let states = &mut self.database.transition_states;
        states.retain_mut(|state| match [place[state.ends[0]], place[state.ends[1]]] {
            [Some(one), Some(other)] => {
                state.ends = [one, other];
                true
            }
            _ => false,
        });
        (self.database.minima).retain(|minimum| minimum.vibrations.is_some());
        let mut numbers = place.iter();
        self.numbers
            .retain(|_| numbers.next().is_some_and(Option::is_some));
        self.network = network_of(&self.database, self.evidence);
        self.tree = Tree::from_network(&self.network, Evidence::Chain);
        self
    }

    /// The minima without curvatures.
    fn unknown(&self) -> Vec<usize> {
        let minima = self.database.minima.iter().enumerate();
        let unknown = minima.filter(|(_, minimum)| minimum.vibrations.is_none());
        unknown.map(|(minimum, _)| minimum).collect()
    }

    /// The names of minima in the landscape.
    pub(super) fn names(&self, minima: &[usize]) -> Vec<String> {
        let names = minima.iter();
        names
            .map(|minimum| format!("m{}", self.numbers[*minimum]))
            .collect()
    }

    /// The numbers of minima in the landscape.
    pub(super) fn numbered(&self, minima: &[usize]) -> Vec<usize> {
        minima
            .iter()
            .map(|minimum| self.numbers[*minimum])
            .collect()
    }

    /// Numbers of the minima of the landscape that were left out.
    pub(super) fn left_out_minima(&self) -> Vec<usize> {
        let all = 0..self.rows.len();
        all.filter(|number| self.place_of(*number).is_none())
            .collect()
    }

    /// A value for each minimum of the landscape, in the order of their numbers; `None` for those that were left out.
    pub(super) fn of_landscape(&self, values: &[f64]) -> Vec<Option<f64>> {
        let all = 0..self.rows.len();
        all.map(|number| Some(values[self.place_of(number)?]))
            .collect()
    }

    /// The place in the database of minimum m*number* of the landscape; `None` if it was left out or does not exist.
    pub fn place_of(&self, number: usize) -> Option<usize> {
        self.numbers.binary_search(&number).ok()
    }

    /// The minima as harmonic wells.
    pub(super) fn wells(&self) -> Result<Superposition, StudyError> {
        let unknown = self.unknown();
        if unknown.is_empty() {
            return Ok(Superposition::new(&self.database)?);
        }
        Err(StudyError::MinimaWithoutVibrations {
            name: self.name.clone(),
            count: unknown.len(),
            all: self.database.minima.len(),
            minima: listed(self.names(&unknown)),
        })
    }

    /// The numbers of the minima that the text lists, ascending, each once: `min.A` or `min.B` of PATHSAMPLE, which begins with how many
    /// there are and counts minima from 1 in the order of `min.data`.
    ///
    /// # Errors
    /// If the text holds another word than a number, another number of minima than it says, or a number that no minimum has.
    pub fn minima_of(&self, text: &str) -> Result<Vec<usize>, NumberedMinima> {
        let numbers = text.split_whitespace().map(|word| {
            let number = word.parse::<usize>().ok();
            number.ok_or_else(|| NumberedMinima::NoNumber(word.to_owned()))
        });
        let numbers = numbers.collect::<Result<Vec<usize>, _>>()?;
        let Some((count, numbers)) = numbers.split_first() else {
            return Err(NumberedMinima::Empty);
        };
        if *count != numbers.len() || numbers.is_empty() {
            return Err(NumberedMinima::Count {
                told: *count,
                found: numbers.len(),
            });
        }
        let mut place = vec![0; self.rows.len()];
        for (minimum, row) in self.rows.iter().enumerate() {
            place[*row] = minimum;
        }
        let minima = numbers.iter().map(|number| {
            let minimum = number.checked_sub(1).and_then(|row| place.get(row));
            minimum.copied().ok_or(NumberedMinima::NoSuchMinimum {
                number: *number,
                count: place.len(),
            })
        });
        let mut minima = minima.collect::<Result<Vec<usize>, _>>()?;
        minima.sort_unstable();
        minima.dedup();
        Ok(minima)
    }

    /// The network of the same states with free energies.
    pub(super) fn network_of(&self, free: &Database) -> Network {
        network_of(free, self.evidence)
    }

    /// Refuses temperatures at which free energies or logarithms of rates would be beyond the range of numbers.
    pub(super) fn check(&self, temperatures: &[f64]) -> Result<(), StudyError> {
        let minima = self.database.minima.iter().map(|minimum| minimum.energy);
        let states = (self.database.transition_states.iter()).map(|state| state.energy);
        let farthest = (minima.chain(states)).fold(0.0, |most: f64, energy| most.max(energy.abs()));
        let far = |temperature: &&f64| farthest / **temperature > FAR || **temperature > FAR;
        match temperatures.iter().find(far) {
            None => Ok(()),
            Some(temperature) => Err(StudyError::FarTemperature {
                name: self.name.clone(),
                temperature: *temperature,
            }),
        }
    }

    /// The notes as paragraphs of a summary.
    pub(super) fn told_notes(&self) -> String {
        let mut text = String::new();
        for note in &self.notes {
            text.extend(["\nNote: ", note, ".\n"]);
        }
        text
    }
}

fn network_of(database: &Database, evidence: Evidence) -> Network {
    let mut network = database.network();
    for edge in network.edge_weights_mut() {
        edge.evidence = evidence;
    }
    network
}

/// The manifest of a landscape of this program; texts of other programs have none.
fn manifest(folder: &Path) -> Result<Option<Manifest>, StoreError> {
    match LandscapeFiles::manifest(folder) {
        Ok(manifest) => Ok(Some(manifest)),
        Err(StoreError::Unfinished(_)) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Adds what only the table knows, and returns notes about points that are no harmonic wells. The rows are in the order of
/// the texts.
fn complete(database: &mut Database, rows: &[StationaryRow]) -> Vec<String> {
    let (minima, saddles): (Vec<_>, Vec<_>) = rows.iter().partition(|row| row.index == 0);
    if minima.len() != database.minima.len() || saddles.len() != database.transition_states.len() {
        return vec![
            "stationary.parquet contains other points than min.data and ts.data, and was not used"
                .to_owned(),
        ];
    }
    database.vibrational_modes = minima.iter().map(|row| row.curvatures.len()).max();
    // Where the table has curvatures, an ln-product of 0 is known: an earlier version did not tell it from the placeholders.
    let known = |row: &StationaryRow| (!row.curvatures.is_empty()).then(Vibrations::default);
    for (minimum, row) in database.minima.iter_mut().zip(&minima) {
        minimum.vibrations = minimum.vibrations.or(known(row));
    }
    for (state, row) in database.transition_states.iter_mut().zip(&saddles) {
        state.vibrations = state.vibrations.or(known(row));
        if let Some(vibrations) = &mut state.vibrations {
            let lowest = row.curvatures.first().copied();
            vibrations.negative_curvature = lowest.filter(|lowest| *lowest < 0.0);
        }
    }
    no_wells(rows)
}

/// Notes about points whose curvatures do not describe the energy around them.
fn no_wells(rows: &[StationaryRow]) -> Vec<String> {
    let sizes = |row: &StationaryRow| row.curvatures.clone().into_iter().map(f64::abs);
    let stiffest = rows.iter().flat_map(sizes).fold(0.0, f64::max);
    let is_degenerate = |row: &&StationaryRow| row.verdict == Verdict::Degenerate.name();
    let all_are_flat = stiffest <= ALL_FLAT;
    let is_flat = |row: &&StationaryRow| {
        !is_degenerate(row) && sizes(row).any(|size| all_are_flat || size <= FLAT * stiffest)
    };
    let branches = rows
        .iter()
        .filter(|row| row.verdict == Verdict::Duplicate.name());
    let branches: Vec<&[f64]> = branches.map(|row| &row.coordinates[..]).collect();
    let is_branched = |row: &&StationaryRow| branches.contains(&&row.coordinates[..]);
    let why_flat = if all_are_flat {
        "unless lengths have a very small unit: all curvatures are below 10⁻¹⁰, as at flat points"
    } else {
        "where a curvature is 0 within the accuracy of the differences (10⁻⁶ of the greatest)"
    };
    let notes = [
        (
            named(rows.iter().filter(is_degenerate)),
            "which is not isolated (a ring, a trough or a plateau): occupations and rates do not count its extent",
        ),
        (named(rows.iter().filter(is_flat)), why_flat),
        (
            named(rows.iter().filter(is_branched)),
            "where more than two valleys meet in a saddle whose curvatures vanish",
        ),
    ];
    let told = |(points, why): (Option<String>, &str)| {
        Some(format!(
            "harmonic formulae do not hold at {}, {why}",
            points?
        ))
    };
    notes.into_iter().filter_map(told).collect()
}

/// The names of points, each as a reader of the tables finds it; `None` if there are none.
fn named<'a>(rows: impl Iterator<Item = &'a StationaryRow>) -> Option<String> {
    let name = |row: &StationaryRow| match row.index {
        0 => format!("m{}", row.id),
        _ => format!("saddle {} (m{}, m{})", row.id, row.ends[0], row.ends[1]),
    };
    let names: Vec<String> = rows.map(name).collect();
    match names.len() {
        0 => None,
        1 => Some(listed(names)),
        _ => Some(format!("each of {}", listed(names))),
    }
}

/// The first names of a list, and how many others there are.
fn listed(mut names: Vec<String>) -> String {
    let more = names.len().saturating_sub(NAMED);
    names.truncate(NAMED);
    if more > 0 {
        names.push(format!("{more} more"));
    }
    let last = names.pop().unwrap_or_default();
    if names.is_empty() {
        last
    } else {
        format!("{} and {last}", names.join(", "))
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

#[cfg(test)]
mod tests {
    use petgraph::graph::EdgeIndex;
    use serde_json::{Value, json};

    use super::*;
    use crate::store::{AtomicFolder, Manifest};

    fn row(index: u64, id: u64, curvatures: &[f64], verdict: &str) -> StationaryRow {
        StationaryRow {
            index,
            id,
            ends: [0, id],
            curvatures: curvatures.to_vec(),
            verdict: verdict.to_owned(),
            ..StationaryRow::default()
        }
    }

    #[test]
    fn points_that_are_no_wells_are_named() {
        let rows = [
            row(0, 0, &[1e-9, 4.0], "degenerate"),
            row(0, 1, &[2.0, 3.0], "sound"),
            row(0, 2, &[6e-9, 6e-9], "sound"),
            row(1, 1, &[-1.0, 2e-7], "sound"),
        ];
        let [apart, flat] = &no_wells(&rows)[..] else {
            panic!("{:?}", no_wells(&rows))
        };
        assert!(apart.contains("at m0, which is not isolated"), "{apart}");
        assert!(
            flat.contains("each of m2 and saddle 1 (m0, m1), where"),
            "{flat}"
        );
        assert!(no_wells(&rows[1..2]).is_empty());
        let many: Vec<StationaryRow> = (0..20).map(|id| row(0, id, &[1.0], "degenerate")).collect();
        assert!(
            no_wells(&many)[0].contains("m7 and 12 more"),
            "{:?}",
            no_wells(&many)
        );
    }

    #[test]
    fn a_landscape_whose_curvatures_are_all_noise_is_told() {
        let told = no_wells(&[row(0, 0, &[8e-13, 8e-13], "sound")]);
        assert!(
            told.len() == 1 && told[0].contains("m0") && told[0].contains("all curvatures"),
            "{told:?}"
        );
        assert!(no_wells(&[row(0, 0, &[1e-6, 1e-6], "sound")]).is_empty());
    }

    #[test]
    fn numbers_of_pathsample_follow_min_data() {
        let place = tempfile::tempdir().unwrap();
        let minima = "3 2 1 0 0 0\n1 2 1 0 0 0\n2 2 1 0 0 0\n";
        std::fs::write(place.path().join("min.data"), minima).unwrap();
        std::fs::write(place.path().join("ts.data"), "").unwrap();
        let states = NetworkOfStates::open(place.path(), &FamilySettings::default()).unwrap();
        assert_eq!(states.rows, [1, 2, 0]);
        assert_eq!(states.minima_of("2\n1\n2\n"), Ok(vec![0, 2]));
        assert_eq!(states.minima_of(" 3\n 3 3\n2"), Ok(vec![0, 1]));
        for (wrong, said) in [
            ("", "empty"),
            ("1\n0\n", "minimum 0 does not exist"),
            ("1\n4\n", "minimum 4 does not exist: min.data lists 3"),
            ("2\n1\n", "says 2 minima, and 1 number follows"),
            ("0\n", "one or more"),
            ("1\nm1\n", "`m1` is not the number"),
        ] {
            let told = states.minima_of(wrong).unwrap_err().to_string();
            assert!(told.contains(said), "{told}");
        }
    }

    #[test]
    fn a_known_product_of_1_of_an_earlier_version_is_kept() {
        let minima = "0 1 1 0 0 0\n1 1 1 0 0 0\n";
        let (mut database, _) = Database::parse(minima, "2 0 1 1 2 0 0 0\n").unwrap();
        assert_eq!(database.transition_states[0].vibrations, None);
        let rows = [
            row(0, 0, &[1.0], "sound"),
            row(0, 1, &[1.0], "sound"),
            row(1, 0, &[-3.0], "sound"),
        ];
        assert!(complete(&mut database, &rows).is_empty());
        let known = database.transition_states[0].vibrations.unwrap();
        assert_eq!(known.negative_curvature, Some(-3.0));
        assert_eq!(database.vibrational_modes, Some(1));
        assert_eq!(complete(&mut database, &rows[..2]).len(), 1);
    }

    /// Which tables there are does not tell whether a landscape is our own: one with few was taken for an imported one.
    #[test]
    fn our_own_saddles_are_verified_whatever_tables_there_are() {
        let place = tempfile::tempdir().unwrap();
        let evidence = |name: &str, energy: Option<Value>| {
            let path = place.path().join(name);
            if let Some(energy) = energy {
                let manifest = Manifest {
                    energy,
                    family_barrier: Some(1.5),
                    ..Manifest::default()
                };
                let folder = AtomicFolder::open(&path, false).unwrap();
                let files = LandscapeFiles {
                    manifest,
                    ..LandscapeFiles::default()
                };
                files.write(&folder).unwrap();
                folder.finish().unwrap();
            } else {
                std::fs::create_dir(&path).unwrap();
            }
            std::fs::write(path.join("min.data"), "0 2 1 0 0 0\n1 2 1 0 0 0\n").unwrap();
            std::fs::write(path.join("ts.data"), "2 1 1 1 2 0 0 0\n").unwrap();
            let states = NetworkOfStates::open(&path, &FamilySettings::default()).unwrap();
            let free = states.network_of(&states.database);
            let networks = [&states.network, &free];
            let [told, of_free] = networks.map(|network| network[EdgeIndex::new(0)].evidence);
            assert_eq!(told, of_free);
            // The families are those that the landscape records. The pass lies 1 above the higher minimum.
            let recorded = path.join("landscape.json").is_file();
            assert_eq!(states.families.members.len() == 1, recorded, "{name}");
            let none = FamilySettings {
                barrier: Some(0.5),
                ..FamilySettings::default()
            };
            let parted = NetworkOfStates::open(&path, &none).unwrap();
            assert_eq!(parted.families.members.len(), 2, "{name}");
            told
        };
        let own = json!({ "surface": "muller-brown" });
        assert_eq!(evidence("own.landscape", Some(own)), Evidence::Saddle);
        let imported = json!({ "imported": "PATHSAMPLE" });
        let imported = evidence("imported.landscape", Some(imported));
        assert_eq!(imported, Evidence::Given);
        assert_eq!(evidence("texts", None), Evidence::Given);
    }
}
