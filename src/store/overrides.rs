//! The hands and objects of a file of grasps: those that its metadata describe, those that the user gives instead, and,
//! if the metadata are lost, those that the rows name and that come with the program.
//!
//! The rows themselves, and how the metadata get lost, are in [`grasps`](super::grasps).

use std::collections::BTreeSet;
use std::path::Path;

use super::error::{StoreError, Warning, list};
use super::grasps::{GraspFile, GraspRow, TERM};
use super::metadata::{HandMetadata, Metadata, ObjectMetadata, SCHEMA_VERSION};
use super::table::{TEXT, Table};
use crate::hand::HandFiles;
use crate::object::{Object, ObjectParts};

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
    /// Assigns rows to the hand or object that replaced theirs, and drops values that are no longer valid.
    pub(super) fn exchange(&mut self, path: &Path, warning: &Warning) -> Result<(), StoreError> {
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
                        "cannot scale `{given}`: the grasps are of `{told}` at scale {}. Give an object called `{told}` to \
                         apply that scale",
                        grasp.scale
                    ),
                });
            }
            grasp.forget_outcome();
            grasp.forget_label_of_rule();
            (grasp.label, grasp.label_category, grasp.label_source) = (None, None, None);
        }
        self.forget_protocols();
        Ok(())
    }

    /// Removes the descriptions of a simulation and of a rule of which no result is left.
    pub(super) fn forget_protocols(&mut self) {
        if self.grasps.iter().all(|grasp| grasp.stable.is_none()) {
            self.metadata.stability = serde_json::Value::Null;
        }
        if self.grasps.iter().all(|grasp| grasp.label_auto.is_none()) {
            self.metadata.labels = serde_json::Value::Null;
        }
    }
}

impl GraspRow {
    /// Removes the outcome of a simulation.
    pub(super) fn forget_outcome(&mut self) {
        self.stable = None;
        self.stable_reason = None;
        self.stable_displacement_m = None;
        self.stable_turn_rad = None;
    }

    /// Removes the label of the rule or of a labeller; that of a human stays.
    pub(super) fn forget_label_of_rule(&mut self) {
        self.label_auto = None;
        self.label_score = None;
        self.label_best = None;
        if self.label_source.as_deref() != Some("human") {
            self.label_category = None;
            self.label_source = None;
        }
    }
}

/// The metadata of a file with the user's overrides.
pub(super) fn describe(
    path: &Path,
    table: &Table,
    overrides: Overrides,
) -> Result<(Metadata, Vec<Warning>), StoreError> {
    let mut warnings = Vec::new();
    let Some(json) = &table.metadata else {
        return foreign(path, table, overrides);
    };
    let mut metadata = Metadata::from_json(path, json)?;
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
                "{column} `{given}` is not one of those that the file describes ({}), so it is unclear which of them it \
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
