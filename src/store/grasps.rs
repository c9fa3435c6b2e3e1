//! `grasps.parquet`: one row per grasp.
//!
//! | column | type | meaning |
//! | --- | --- | --- |
//! | `id`? | uint64 | unique in the file; absent: the row number |
//! | `object`? | string | name of the object; absent: the only one the file describes |
//! | `scale`? | double | factor on the object's size; absent: 1 |
//! | `hand`? | string | name of the hand; absent: the only one the file describes |
//! | `translation_m` | double\[3\] | position of the hand's root in the object's frame, metres |
//! | `rotation_wxyz` | double\[4\] | unit quaternion, scalar first, object from hand; w ≥ 0 |
//! | `joints` | double\[k\] | joint angles, radians; metres for sliding joints, in the order of the hand's joint names; absent for k = 0 |
//! | `squeeze_joints`?∅ | double\[k\] | joint targets that press, as the makers of the grasp stored them (`squeeze_qpos`), in the unit and order of `joints` |
//! | `contacts` | list of uint32 | contact set: indices into the hand's surface points, each once |
//! | `energy` | double | total energy |
//! | `term_<name>` | double | one column for each energy term; they add up to `energy` |
//! | `net_wrench` | double | ‖Gc‖, arms divided by the object's radius |
//! | `distance_squared` | double | Σ d² of the contacts in the authors' unit (120 mm) |
//! | `penetration` | double | penetration energy in the authors' unit |
//! | `friction`?∅ | double | μ₀, least friction of exact force closure; null: none suffices |
//! | `epsilon`?∅ | double | Ferrari–Canny ε at μ = 0.5, see `closure::epsilon`; ≤ 0: some wrench cannot be resisted; null: not computed |
//! | `stable`?∅ | bool | held in simulation; null: not simulated |
//! | `stable_reason`?∅ | string | reason, see `grasp::stability::Reason`; null: not simulated |
//! | `stable_displacement_m`?∅, `stable_turn_rad`?∅ | double | displacement and rotation of the object in simulation |
//! | `label`?∅ | string | grasp type given by a human, or `unlisted` |
//! | `label_auto`?∅ | string | result of the rule or of a labeller that was taught: a grasp type, the cell of the taxonomy if types of it are close (`power/palm/2-5/abducted`), the category if cells of it are close (`power`), `unlisted`, or `not_applicable` |
//! | `label_score`?∅ | double | probability of the type that is the answer, 0 to 1 |
//! | `label_best`?∅ | string | the answer with its certainty (`likely`, `open` or `a guess`), and the two most probable other types of its category |
//! | `label_category`?∅ | string | `power`, `intermediate` or `precision` from the human's label, otherwise the most probable one by the rule or labeller, also of unlisted grasps; null if there is none |
//! | `label_source`?∅ | string | `human`, `rule` or `labeller`: origin of `label_category`; null: not labelled |
//! | `source`? | string | origin of the grasp; absent: empty |
//! | `chain_seed`?, `chain_step`? | uint64 | the chain and step that found it; absent: 0 |
//!
//! `?` may be absent, `∅` may be null; other columns are ignored. Narrower numbers, lists of any kind,
//! categorical strings and every usual compression are accepted, so a table may pass through other tools:
//!
//! ```python
//! pandas.read_parquet("grasps.parquet")
//! polars.read_parquet("grasps.parquet")
//! duckdb.sql("select label, count(*) from 'grasps.parquet' group by label")
//! about = pyarrow.parquet.read_metadata("grasps.parquet").metadata[b"landscape"]   # JSON: hand, object, settings
//! ```
//!
//! pyarrow and pandas keep the metadata when they filter a table and write it back; in pandas they are
//! `frame.attrs["landscape"]`. polars and `DuckDB` drop them. In that case, restore them with pyarrow,
//! `table.replace_schema_metadata({"landscape": about})`, or name hand and object again when the file is read
//! ([`Overrides`]). Hands and objects that come with the program are known by the names in the rows.
//!
//! The checksum of this program is lost as well. Nothing then vouches that the measures in a row are those of its pose, so the
//! commands of the program compute them anew ([`GraspFile::verify`]). In rows where they differ, the computed ones are used,
//! and outcomes of simulations and labels of the rule are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::atomic::write_atomic;
use super::columns::Columns;
use super::error::{Fault, StoreError, Warning};
use super::metadata::{HandMetadata, Metadata, ObjectMetadata};
use super::overrides::{Overrides, describe};
use super::population::Population;
use super::quaternion::canonical;
use super::row::{self, Column, columns};
use super::table::{FLAG, FLOAT, INDICES, Kind, TEXT, Table, VECTOR, WHOLE};
use crate::grasp::Grasp;
use crate::space::Pose;

/// One grasp with its measures and labels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GraspRow {
    /// Unique in its file.
    pub id: u64,
    /// Name of the object.
    pub object: String,
    /// Scale factor of the object.
    pub scale: f64,
    /// Name of the hand.
    pub hand: String,
    /// Pose, its quaternion of unit length with w ≥ 0, and contact set.
    pub grasp: Grasp,
    /// Joint coordinates to which the makers of the grasp close the hand so that it presses, in the order of its joints, radians
    /// or metres; `None` if they stored none.
    pub squeeze_joints: Option<Vec<f64>>,
    /// Total energy.
    pub energy: f64,
    /// Weighted energy terms, in the order of [`Metadata::terms`].
    pub terms: Vec<f64>,
    /// ‖Gc‖.
    pub net_wrench: f64,
    /// Σ d² in the authors' unit.
    pub distance_squared: f64,
    /// Penetration energy in the authors' unit.
    pub penetration: f64,
    /// Least friction of exact force closure μ₀; `None` if no friction suffices.
    pub friction: Option<f64>,
    /// Ferrari–Canny ε; zero or negative if some wrench cannot be resisted.
    pub epsilon: Option<f64>,
    /// Whether the grasp held in simulation.
    pub stable: Option<bool>,
    /// The reason in one word.
    pub stable_reason: Option<String>,
    /// Displacement of the object in simulation, metres.
    pub stable_displacement_m: Option<f64>,
    /// Rotation of the object in simulation, radians.
    pub stable_turn_rad: Option<f64>,
    /// Grasp type given by a human, or `unlisted`.
    pub label: Option<String>,
    /// Grasp type given by the rule.
    pub label_auto: Option<String>,
    /// Score of the best type.
    pub label_score: Option<f64>,
    /// The three types that fit best, with their scores.
    pub label_best: Option<String>,
    /// Category by the human's label, otherwise by the rule's.
    pub label_category: Option<String>,
    /// Origin of the category: `human` or `rule`.
    pub label_source: Option<String>,
    /// Origin of the grasp.
    pub source: String,
    /// Seed of the chain that found it.
    pub chain_seed: u64,
    /// Step of that chain.
    pub chain_step: u64,
}

/// Content of `grasps.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspFile {
    /// How the file was made, and its hands and objects.
    pub metadata: Metadata,
    /// Rows.
    pub grasps: Vec<GraspRow>,
}

impl GraspFile {
    /// Reads and checks `path`. In the result, all rows refer to described hands and objects, have unit quaternions with w
    /// ≥ 0, finite numbers, unique ids, existing contacts, and joints at most 1 rad beyond their limits.
    ///
    /// # Errors
    /// One sentence that names the file and, if there are any, the row and column.
    pub fn read(path: &Path, overrides: Overrides) -> Result<(Self, Vec<Warning>), StoreError> {
        let table = Table::read(path)?;
        let (metadata, mut warnings) = describe(path, &table, overrides)?;
        if table.rows == 0 {
            return Err(StoreError::Empty(path.to_path_buf()));
        }
        let mut file = Self {
            grasps: rows(&table, &metadata)?,
            metadata,
        };
        for warning in &warnings {
            file.exchange(path, warning)?;
        }
        file.refuse_faults(path)?;
        for grasp in &mut file.grasps {
            let pose = &mut grasp.grasp.pose;
            pose.set_rotation_wxyz(canonical(pose.rotation_wxyz()));
        }
        warnings.extend(file.beyond_limits());
        if !table.sealed {
            warnings.push(Warning::Unsealed(path.to_path_buf()));
        }
        Ok((file, warnings))
    }

    /// Whether each simulated grasp of a file held, by id. Nothing else of the file is read, so that it need not describe its
    /// hand and object; but only the checksum of this program vouches for the outcomes.
    ///
    /// # Errors
    /// If the file is no table, a value has the wrong type, or another program wrote the file.
    pub fn outcomes(path: &Path) -> Result<BTreeMap<u64, bool>, StoreError> {
        let table = Table::read(path)?;
        let marked = (table.metadata.as_deref())
            .and_then(|text| serde_json::from_str::<serde_json::Value>(text).ok())
            .is_some_and(|metadata| metadata["stability"]["unverified"] == true);
        if !table.sealed || marked {
            return Err(StoreError::Unsealed(path.to_path_buf()));
        }
        let ids = table.defaulted("id", &WHOLE, |row| Some(row as u64))?;
        let outcomes = table.optional("stable", &FLAG)?;
        let simulated = ids.into_iter().zip(outcomes);
        Ok(simulated
            .filter_map(|(id, stable)| Some((id, stable?)))
            .collect())
    }

    /// Whether the metadata of a file of grasps are there.
    ///
    /// # Errors
    /// If the file is no table.
    pub fn describes_itself(path: &Path) -> Result<bool, StoreError> {
        Ok(Table::read(path)?.metadata.is_some())
    }

    /// Whether a file is a grasp file of this program, that is, a Parquet file whose footer has its metadata.
    pub fn is_ours(path: &Path) -> bool {
        Table::describes_itself(path)
    }

    /// Writes the file atomically. Equal content gives equal bytes. Quaternions are stored with w ≥ 0.
    ///
    /// # Errors
    /// If [`GraspFile::read`] would refuse the content; [`GraspFile::faults`] finds this beforehand.
    pub fn write(&self, path: &Path) -> Result<(), StoreError> {
        write_atomic(path, &self.encode(path)?)
    }

    /// The bytes that [`GraspFile::write`] writes. Errors name `path`.
    ///
    /// # Errors
    /// If [`GraspFile::read`] would refuse the content.
    pub fn encode(&self, path: &Path) -> Result<Vec<u8>, StoreError> {
        if self.grasps.is_empty() {
            return Err(StoreError::Empty(path.to_path_buf()));
        }
        let metadata = self.metadata.to_json(path)?;
        self.refuse_faults(path)?;
        self.columns().encode(path, &metadata)
    }

    /// The landscapes in this file, sorted by hand, object and scale.
    ///
    /// # Panics
    /// If a row refers to a hand or object that the metadata do not describe; [`GraspFile::read`] refuses such files.
    pub fn landscapes(&self) -> Vec<Population<'_>> {
        let mut groups = BTreeMap::<_, Vec<&GraspRow>>::new();
        for grasp in &self.grasps {
            // Positive numbers sort in the order of their bits.
            let key = (
                grasp.hand.as_str(),
                grasp.object.as_str(),
                grasp.scale.to_bits(),
            );
            groups.entry(key).or_default().push(grasp);
        }
        let population = |((hand, object, scale), grasps): ((&str, &str, u64), _)| Population {
            metadata: &self.metadata,
            hand: self.hand(hand).expect("every row names a described hand"),
            object: self
                .object(object)
                .expect("every row names a described object"),
            scale: f64::from_bits(scale),
            grasps,
        };
        groups.into_iter().map(population).collect()
    }

    pub(super) fn hand(&self, name: &str) -> Option<&HandMetadata> {
        self.metadata.hands.iter().find(|hand| hand.name == name)
    }

    pub(super) fn object(&self, name: &str) -> Option<&ObjectMetadata> {
        self.metadata
            .objects
            .iter()
            .find(|object| object.name == name)
    }

    fn columns(&self) -> Columns {
        let grasps = || self.grasps.iter();
        let rotations: Vec<_> = grasps()
            .map(|grasp| canonical(grasp.grasp.pose.rotation_wxyz()))
            .collect();
        let mut columns = Columns::default();
        row::write(NAMED, &self.grasps, &mut columns);
        columns.vectors(
            "translation_m",
            grasps().map(|grasp| grasp.grasp.pose.translation_m()),
        );
        columns.vectors("rotation_wxyz", rotations.iter().map(<[f64; 4]>::as_slice));
        columns.vectors("joints", grasps().map(|grasp| grasp.grasp.pose.joints()));
        row::write(SQUEEZED, &self.grasps, &mut columns);
        columns.indices("contacts", grasps().map(|grasp| &*grasp.grasp.contacts));
        columns.floats("energy", grasps().map(|grasp| grasp.energy));
        for (term, name) in self.metadata.terms.iter().enumerate() {
            columns.floats(&term_column(name), grasps().map(|grasp| grasp.terms[term]));
        }
        row::write(MEASURED, &self.grasps, &mut columns);
        columns
    }
}

pub(super) fn term_column(name: &str) -> String {
    format!("{TERM}{name}")
}

pub(super) const TERM: &str = "term_";

/// The columns before the pose.
const NAMED: &[Column<GraspRow>] = columns![id, object, scale, hand];

/// The column after the joints.
const SQUEEZED: &[Column<GraspRow>] = columns![squeeze_joints if present];

/// The columns after the energy and its terms.
const MEASURED: &[Column<GraspRow>] = columns![
    net_wrench,
    distance_squared,
    penetration,
    friction,
    epsilon,
    stable,
    stable_reason,
    stable_displacement_m,
    stable_turn_rad,
    label,
    label_auto,
    label_score,
    label_best,
    label_category,
    label_source,
    source if present,
    chain_seed if present,
    chain_step if present,
];

fn rows(table: &Table, metadata: &Metadata) -> Result<Vec<GraspRow>, StoreError> {
    let ids = table.defaulted("id", &WHOLE, |row| Some(row as u64))?;
    let only_object = only(metadata.objects.iter().map(|object| &object.name));
    let objects = table.defaulted("object", &TEXT, |_| only_object.clone())?;
    let scales = table.defaulted("scale", &FLOAT, |_| Some(1.0))?;
    let only_hand = only(metadata.hands.iter().map(|hand| &hand.name));
    let hands = table.defaulted("hand", &TEXT, |_| only_hand.clone())?;
    let translations_m = table.arrays::<3>("translation_m")?;
    let rotations_wxyz = table.arrays::<4>("rotation_wxyz")?;
    let mut hands_described = metadata.hands.iter();
    let jointless = hands_described.all(|hand| hand.joint_names.is_empty());
    let joints = table.defaulted("joints", &VECTOR, |_| jointless.then(Vec::new))?;
    let contacts = table.required("contacts", &INDICES)?;
    let energies = table.required("energy", &FLOAT)?;
    let terms = metadata.terms.iter();
    let terms = terms.map(|name| table.required(&term_column(name), &FLOAT));
    let terms = terms.collect::<Result<Vec<_>, _>>()?;
    let named = ids.into_iter().zip(objects).zip(scales).zip(hands);
    let mut rows: Vec<GraspRow> = named
        .zip(contacts)
        .enumerate()
        .map(
            |(row, ((((id, object), scale), hand), contacts))| GraspRow {
                id,
                object,
                scale,
                hand,
                grasp: Grasp {
                    pose: Pose::new(translations_m[row], rotations_wxyz[row], &joints[row]),
                    contacts,
                },
                energy: energies[row],
                terms: terms.iter().map(|term| term[row]).collect(),
                ..GraspRow::default()
            },
        )
        .collect();
    row::read(SQUEEZED, table, &mut rows)?;
    row::read(MEASURED, table, &mut rows)?;
    Ok(rows)
}

impl Table {
    /// A column that has the values `default(row)` if it is absent. The column is required if `default` returns `None`.
    fn defaulted<T>(
        &self,
        name: &str,
        kind: &Kind<T>,
        default: impl Fn(usize) -> Option<T>,
    ) -> Result<Vec<T>, StoreError> {
        if !self.has(name)
            && let Some(values) = (0..self.rows).map(default).collect()
        {
            return Ok(values);
        }
        self.required(name, kind)
    }

    /// A required column of lists of `N` numbers.
    fn arrays<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>, StoreError> {
        let array = |(row, values): (usize, Vec<f64>)| {
            let (column, found) = (name.to_owned(), values.len());
            let fault = Fault::Length {
                column,
                found,
                expected: N,
            };
            <[f64; N]>::try_from(values.as_slice())
                .ok()
                .ok_or_else(|| self.fault(row, fault))
        };
        self.required(name, &VECTOR)?
            .into_iter()
            .enumerate()
            .map(array)
            .collect()
    }
}

/// The name, if all names are equal.
fn only<'a>(names: impl Iterator<Item = &'a String>) -> Option<String> {
    let names: BTreeSet<&String> = names.collect();
    if names.len() == 1 {
        names.first().map(|name| (*name).clone())
    } else {
        None
    }
}
