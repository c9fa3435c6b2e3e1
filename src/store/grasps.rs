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
//! | `joints_rad` | double\[k\] | joint angles, radians, in the order of the hand's joint names; absent for k = 0 |
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
//! | `label_auto`?∅ | string | result of the rule: a grasp type, the cell of the taxonomy if types of it are close (`power/palm/2-5/abducted`), the category if cells of it are close (`power`), `unlisted`, or `not_applicable` |
//! | `label_score`?∅ | double | probability of the type that is the answer, 0 to 1 |
//! | `label_best`?∅ | string | the answer and the two most probable other types, with their probabilities |
//! | `label_category`?∅ | string | `power`, `intermediate` or `precision` from the human's label, otherwise the rule's; null if that is no type or cell |
//! | `label_source`?∅ | string | `human` or `rule`: origin of `label_category`; null: not labelled |
//! | `source`? | string | origin of the grasp; absent: empty |
//! | `chain_seed`?, `chain_step`? | uint64 | the chain and step that found it; absent: 0 |
//!
//! `?` may be absent, `∅` may be null; other columns are ignored, with a warning. Narrower numbers, lists of any kind,
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

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::atomic::write_atomic;
use super::columns::Columns;
use super::error::{Fault, StoreError, Warning, list};
use super::metadata::{HandMetadata, Metadata, ObjectMetadata, SCHEMA_VERSION};
use super::population::Population;
use super::quaternion::canonical;
use super::row::{self, Column, columns};
use super::table::{FLAG, FLOAT, INDICES, Kind, TEXT, Table, VECTOR, WHOLE};
use crate::grasp::Grasp;
use crate::hand::HandFiles;
use crate::object::{Object, ObjectParts};
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

/// Hand and object given by the user, for a file that does not describe them or to combine its poses with others.
///
/// A given hand or object replaces the described one of the same name, or the only one. If the two differ,
/// [`GraspFile::read`] returns a warning. A hand must have the same joints. Contacts are dropped, because they are points
/// on the old hand's surface. If the file describes nothing and its rows name one hand or object only, the given one is taken
/// for it, under that name. An object of another name is used at its own size, so the rows must be at scale 1. Labels and
/// outcomes of simulations are dropped. The energy and the other measures remain those of the replaced hand or object.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Overrides {
    /// The hand (`--hand`).
    pub hand: Option<HandMetadata>,
    /// The object (`--object`).
    pub object: Option<ObjectMetadata>,
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
        Ok((file, warnings))
    }

    /// Whether each simulated grasp of a file held, by id. Nothing else of the file is read, so that it need not describe its
    /// hand and object.
    ///
    /// # Errors
    /// If the file is no table, or a value has the wrong type.
    pub fn outcomes(path: &Path) -> Result<BTreeMap<u64, bool>, StoreError> {
        let table = Table::read(path)?;
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

    /// Assigns rows to the hand or object that replaced theirs, and drops values that are no longer valid.
    fn exchange(&mut self, path: &Path, warning: &Warning) -> Result<(), StoreError> {
        let (told, given, of_hand) = match warning {
            Warning::OtherHand { told, given } => (told, given, true),
            Warning::OtherObject { told, given } => (told, given, false),
            _ => return Ok(()),
        };
        for grasp in &mut self.grasps {
            let name = if of_hand {
                &mut grasp.hand
            } else {
                &mut grasp.object
            };
            if name != told && name != given {
                continue;
            }
            given.clone_into(name);
            if of_hand {
                grasp.grasp.contacts.clear();
            } else if told != given && grasp.scale.to_bits() != 1.0_f64.to_bits() {
                return Err(StoreError::Foreign {
                    path: path.to_path_buf(),
                    problem: format!(
                        "its grasps are of `{told}` at scale {}: the size of `{given}` in its place is unknown; give an \
                         object called `{told}`, which is taken at that scale",
                        grasp.scale
                    ),
                });
            }
            *grasp = GraspRow {
                stable: None,
                stable_reason: None,
                stable_displacement_m: None,
                stable_turn_rad: None,
                label: None,
                label_auto: None,
                label_score: None,
                label_best: None,
                label_category: None,
                label_source: None,
                ..std::mem::take(grasp)
            };
        }
        if self.grasps.iter().all(|grasp| grasp.stable.is_none()) {
            self.metadata.stability = serde_json::Value::Null;
        }
        if self.grasps.iter().all(|grasp| grasp.label_auto.is_none()) {
            self.metadata.labels = serde_json::Value::Null;
        }
        Ok(())
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
        columns.vectors(
            "joints_rad",
            grasps().map(|grasp| grasp.grasp.pose.joints()),
        );
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

const TERM: &str = "term_";

/// The metadata of a file with the user's overrides.
fn describe(
    path: &Path,
    table: &Table,
    overrides: Overrides,
) -> Result<(Metadata, Vec<Warning>), StoreError> {
    let mut warnings = Vec::new();
    let Some(json) = &table.metadata else {
        return foreign(path, table, overrides);
    };
    let (mut metadata, mut unknown) = Metadata::from_json(path, json)?;
    unknown.extend(unknown_columns(table, &metadata));
    if !unknown.is_empty() {
        let path = path.to_path_buf();
        warnings.push(Warning::Unknown { path, unknown });
    }
    if let Some(hand) = overrides.hand {
        let known: Vec<&str> = names_of_hands(&metadata).collect();
        match place(path, table, "hand", &hand.name, &known)? {
            Some(at) => {
                warnings.extend(put_hand(path, &mut metadata.hands[at], hand)?);
            }
            None => metadata.hands.push(hand),
        }
    }
    if let Some(object) = overrides.object {
        let known: Vec<&str> = names_of_objects(&metadata).collect();
        match place(path, table, "object", &object.name, &known)? {
            Some(at) => warnings.extend(put_object(&mut metadata.objects[at], object)),
            None => metadata.objects.push(object),
        }
    }
    metadata.check(path)?;
    Ok((metadata, warnings))
}

/// The hands or objects that the rows name.
fn names_in_rows(table: &Table, kind: &str) -> Result<BTreeSet<String>, StoreError> {
    Ok(table.optional(kind, &TEXT)?.into_iter().flatten().collect())
}

/// The hands and objects that the rows name, for an error.
fn told_names(table: &Table) -> Result<String, StoreError> {
    let mut told = Vec::new();
    for kind in ["hand", "object"] {
        let names = names_in_rows(table, kind)?;
        if !names.is_empty() {
            let names = list(names.iter().map(String::as_str));
            told.push(format!("the {kind} {names}"));
        }
    }
    Ok(match told.as_slice() {
        [] => String::new(),
        told => format!(" (its rows name {})", told.join(" and ")),
    })
}

/// Columns that are not read. The index of a data frame is no loss.
fn unknown_columns(table: &Table, metadata: &Metadata) -> Vec<String> {
    let known = NAMED.iter().chain(MEASURED).map(|column| column.name);
    let others = [
        "translation_m",
        "rotation_wxyz",
        "joints_rad",
        "contacts",
        "energy",
    ];
    let known: BTreeSet<&str> = known.chain(others).collect();
    let is_term = |name: &str| {
        let mut terms = metadata.terms.iter();
        (name.strip_prefix(TERM)).is_some_and(|name| terms.any(|term| term == name))
    };
    table
        .names()
        .filter(|name| !known.contains(name) && !is_term(name) && !name.starts_with("__index_"))
        .map(str::to_owned)
        .collect()
}

fn names_of_hands(metadata: &Metadata) -> impl Iterator<Item = &str> {
    metadata.hands.iter().map(|hand| hand.name.as_str())
}

fn names_of_objects(metadata: &Metadata) -> impl Iterator<Item = &str> {
    metadata.objects.iter().map(|object| object.name.as_str())
}

/// Index of the known hand (or object) that the given one replaces: the one of the same name, or the only one. The result
/// is `None` if rows refer to the given name, which the file does not describe.
fn place(
    path: &Path,
    table: &Table,
    column: &str,
    given: &str,
    known: &[&str],
) -> Result<Option<usize>, StoreError> {
    if let Some(at) = known.iter().position(|name| *name == given) {
        return Ok(Some(at));
    }
    let named = table.optional(column, &TEXT)?;
    let is_named = named.iter().flatten().any(|name| name == given);
    match known {
        [] => Ok(None),
        _ if is_named => Ok(None),
        [_] => Ok(Some(0)),
        _ => Err(StoreError::Foreign {
            path: path.to_path_buf(),
            problem: format!(
                "{column} `{given}` is none of those that the file describes ({}), so it is not clear which of them it \
                 replaces",
                list(known.iter().copied())
            ),
        }),
    }
}

/// Replaces a described hand by a given one if they differ.
fn put_hand(
    path: &Path,
    told: &mut HandMetadata,
    given: HandMetadata,
) -> Result<Option<Warning>, StoreError> {
    if told.joint_names != given.joint_names {
        let [given, stored] =
            [&given, &*told].map(|hand| list(hand.joint_names.iter().map(String::as_str)));
        return Err(StoreError::Foreign {
            path: path.to_path_buf(),
            problem: format!(
                "its poses do not fit the hand given: hand `{}` has joints {stored}, but the one given has {given}",
                told.name
            ),
        });
    }
    if told.is_same_hand(&given) {
        return Ok(None);
    }
    let warning = Warning::OtherHand {
        told: told.name.clone(),
        given: given.name.clone(),
    };
    *told = given;
    Ok(Some(warning))
}

/// Replaces a described object by a given one if they differ; otherwise only its mesh is taken.
fn put_object(told: &mut ObjectMetadata, given: ObjectMetadata) -> Option<Warning> {
    if told.content_hash == given.content_hash {
        told.mesh_obj = given.mesh_obj;
        return None;
    }
    let warning = Warning::OtherObject {
        told: told.name.clone(),
        given: given.name.clone(),
    };
    *told = given;
    Some(warning)
}

/// Metadata of a file without metadata: only hands, objects and the names of the terms are known.
fn foreign(
    path: &Path,
    table: &Table,
    overrides: Overrides,
) -> Result<(Metadata, Vec<Warning>), StoreError> {
    let mut warnings = Vec::new();
    let hands = lost(table, overrides.hand, &mut warnings)?;
    let objects = lost(table, overrides.object, &mut warnings)?;
    let (missing, flags) = match (hands.is_empty(), objects.is_empty()) {
        (false, false) => {
            let terms = table.names().filter_map(|name| name.strip_prefix(TERM));
            let metadata = Metadata {
                schema_version: SCHEMA_VERSION,
                hands,
                objects,
                terms: terms.map(str::to_owned).collect(),
                ..Metadata::default()
            };
            return Ok((metadata, warnings));
        }
        (true, false) => ("hand", "--hand"),
        (false, true) => ("object", "--object"),
        (true, true) => ("hand and object", "--hand and --object"),
    };
    Err(StoreError::NoMetadata {
        path: path.to_path_buf(),
        missing,
        flags,
        named: told_names(table)?,
    })
}

/// The hands or objects of a file without metadata: the given one, which goes by the name in the rows if they name one only,
/// and those that come with the program by the other names. Empty if none is given and these are not all that is missing.
fn lost<T: Described>(
    table: &Table,
    given: Option<T>,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<T>, StoreError> {
    let kind = T::KIND;
    let mut names = names_in_rows(table, kind)?;
    let is_given = given.is_some();
    let mut found = Vec::new();
    if let Some(mut given) = given {
        let name = given.name_mut();
        if !names.remove(name)
            && names.len() == 1
            && let Some(told) = names.pop_first()
        {
            let given = std::mem::replace(name, told.clone());
            warnings.push(Warning::TakenFor { kind, told, given });
        }
        found.push(given);
    }
    let count = names.len();
    let built_in = names.into_iter().filter_map(|name| {
        let built_in = T::built_in(&name)?;
        Some((name, built_in))
    });
    let (names, built_in): (Vec<String>, Vec<T>) = built_in.unzip();
    if is_given || names.len() == count {
        found.extend(built_in);
        if !names.is_empty() {
            warnings.push(Warning::BuiltIn { kind, names });
        }
    }
    Ok(found)
}

/// A hand or an object as files describe it.
trait Described: Sized {
    /// The column of its name.
    const KIND: &'static str;

    fn name_mut(&mut self) -> &mut String;

    /// The one of this name that comes with the program.
    fn built_in(name: &str) -> Option<Self>;
}

impl Described for HandMetadata {
    const KIND: &'static str = "hand";

    fn name_mut(&mut self) -> &mut String {
        &mut self.name
    }

    fn built_in(name: &str) -> Option<Self> {
        let files = HandFiles::named(name).ok()?;
        Self::new(name.to_owned(), &files).ok()
    }
}

impl Described for ObjectMetadata {
    const KIND: &'static str = "object";

    fn name_mut(&mut self) -> &mut String {
        &mut self.name
    }

    fn built_in(name: &str) -> Option<Self> {
        let (mesh, description) = Object::parts_of_named(name).ok()?;
        let parts = ObjectParts {
            name: name.to_owned(),
            mesh,
            notes: Vec::new(),
            description,
        };
        Self::new(&parts).ok()
    }
}

/// The columns before the pose.
const NAMED: &[Column<GraspRow>] = columns![id, object, scale, hand];

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
    let joints = table.defaulted("joints_rad", &VECTOR, |_| jointless.then(Vec::new))?;
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
