//! Several files of grasps as one.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::grasps::{GraspFile, GraspRow};
use super::metadata::{HandMetadata, Metadata, ObjectMetadata, SCHEMA_VERSION, Source, Step};

/// Reason why files of grasps cannot be one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum JoinError {
    /// Two hands have the same name.
    #[error(
        "{first} and {other} both have a hand `{name}`, but two different ones: rename the description of one of them (its \
         file gives the name) and make or import its grasps again"
    )]
    OtherHand {
        first: String,
        other: String,
        name: String,
    },
    /// Two objects have the same name.
    #[error(
        "{first} and {other} both have an object `{name}`, but two different ones: give one of them another name (`--name` of \
         `landscape synth` and `import`) and make its grasps again"
    )]
    OtherObject {
        first: String,
        other: String,
        name: String,
    },
    /// The energies differ.
    #[error(
        "{first} and {other} are of different energies ({entry}), and one file has one energy: make both with one \
         --config, or leave them apart (`landscape diversity` and `survey` take several files)"
    )]
    OtherEnergy {
        first: String,
        other: String,
        /// The first entry that differs, with both values.
        entry: String,
    },
    /// The grasps were simulated in different ways.
    #[error(
        "the grasps of {first} and {other} were simulated with different protocols ({entry}): simulate both with one \
         (`landscape stability`), and join the results"
    )]
    OtherProtocol {
        first: String,
        other: String,
        /// The first entry that differs, with both values.
        entry: String,
    },
    /// The grasps were labelled by different rules.
    #[error(
        "the grasps of {first} and {other} were labelled by different rules ({entry}): label both again (`landscape label`), and \
         join the results"
    )]
    OtherRule {
        first: String,
        other: String,
        /// The first entry that differs, with both values.
        entry: String,
    },
}

/// A file of the grasps of several files.
#[derive(Debug, Clone, PartialEq)]
pub struct JoinedFile {
    /// All grasps, in the order of the files, with ids from 0. The column `source` tells file and id before.
    pub file: GraspFile,
    /// Grasps that repeat another one, bit for bit: ids of the repetition and of the first.
    pub repeated: Vec<[u64; 2]>,
    /// Hands and objects that have one content but two names, as sentences without full stops.
    pub notes: Vec<String>,
}

impl GraspFile {
    /// Puts the grasps of files one after the other. Hands and objects of one name must be the same ones, and all files must
    /// have the same energy, and the same protocol and rule where they were simulated and labelled. `command` makes the file;
    /// the sources name the files and their contents.
    ///
    /// # Errors
    /// What differs between which files, and what to do.
    ///
    /// # Panics
    /// If there is no file.
    pub fn join(files: &[(Source, Self)], command: &str) -> Result<JoinedFile, JoinError> {
        let mut metadata = metadata(files, command);
        let mut notes = Vec::new();
        let mut hands: Vec<(&str, &HandMetadata)> = Vec::new();
        let mut objects: Vec<(&str, &ObjectMetadata)> = Vec::new();
        for (source, file) in files {
            for hand in &file.metadata.hands {
                match hands.iter().find(|(_, known)| known.name == hand.name) {
                    None => hands.push((&source.name, hand)),
                    Some((_, known)) if known.is_same_hand(hand) => {}
                    Some((first, _)) => {
                        return Err(JoinError::OtherHand {
                            first: (*first).to_owned(),
                            other: source.name.clone(),
                            name: hand.name.clone(),
                        });
                    }
                }
            }
            for object in &file.metadata.objects {
                match objects.iter().find(|(_, known)| known.name == object.name) {
                    None => objects.push((&source.name, object)),
                    Some((_, known)) if known.content_hash == object.content_hash => {}
                    Some((first, _)) => {
                        return Err(JoinError::OtherObject {
                            first: (*first).to_owned(),
                            other: source.name.clone(),
                            name: object.name.clone(),
                        });
                    }
                }
            }
        }
        notes.extend(two_names(
            "hands",
            hands
                .iter()
                .map(|(_, hand)| (&hand.name, &hand.content_hash)),
        ));
        notes.extend(two_names(
            "objects",
            objects
                .iter()
                .map(|(_, object)| (&object.name, &object.content_hash)),
        ));
        metadata.hands = hands.into_iter().map(|(_, hand)| hand.clone()).collect();
        metadata.objects = objects
            .into_iter()
            .map(|(_, object)| object.clone())
            .collect();
        one_energy(files)?;
        metadata.stability = protocol(files)?;
        let unverified = files.iter().any(|(_, file)| file.has_unverified_outcomes());
        metadata.labels = rule(files)?;
        let grasps = rows(files);
        Ok(JoinedFile {
            repeated: repeated(&grasps),
            file: {
                let mut file = Self { metadata, grasps };
                if unverified {
                    file.mark_unverified();
                }
                file
            },
            notes,
        })
    }
}

/// The metadata without hands, objects, protocol and rule.
fn metadata(files: &[(Source, GraspFile)], command: &str) -> Metadata {
    let of = |(source, file): &(Source, GraspFile)| {
        let Metadata {
            command,
            seed,
            settings,
            ..
        } = &file.metadata;
        json!({ "name": source.name, "command": command, "seed": seed, "settings": settings })
    };
    let steps = files.iter().flat_map(|(_, file)| {
        let Metadata {
            earlier,
            program_version,
            command,
            inputs,
            ..
        } = &file.metadata;
        let last = Step {
            program_version: program_version.clone(),
            command: command.clone(),
            inputs: inputs.clone(),
        };
        let known = !last.command.is_empty();
        earlier.iter().cloned().chain(known.then_some(last))
    });
    let seeds = files.iter().map(|(_, file)| file.metadata.seed);
    let first = &files[0].1.metadata;
    Metadata {
        schema_version: SCHEMA_VERSION,
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        command: command.to_owned(),
        inputs: files.iter().map(|(source, _)| source.clone()).collect(),
        earlier: steps.collect(),
        // Nothing is drawn here; a seed that is common to all is kept.
        seed: Some(first.seed)
            .filter(|seed| seeds.clone().all(|other| other == *seed))
            .unwrap_or(0),
        energy: first.energy.clone(),
        settings: json!({ "joined": files.iter().map(of).collect::<Vec<_>>() }),
        terms: first.terms.clone(),
        ..Metadata::default()
    }
}

/// One sentence for each content that has two names.
fn two_names<'a>(what: &str, named: impl Iterator<Item = (&'a String, &'a String)>) -> Vec<String> {
    let mut by_content: BTreeMap<&String, Vec<&str>> = BTreeMap::new();
    for (name, content) in named {
        by_content.entry(content).or_default().push(name);
    }
    let several = by_content.values().filter(|names| names.len() > 1);
    several
        .map(|names| {
            format!(
                "the {what} {} have the same content, and stay apart because their names differ",
                names.join(", ")
            )
        })
        .collect()
}

fn one_energy(files: &[(Source, GraspFile)]) -> Result<(), JoinError> {
    let energy =
        |file: &GraspFile| json!({ "terms": file.metadata.terms, "energy": file.metadata.energy });
    let Some(((first, one), others)) = files.split_first() else {
        return Ok(());
    };
    for (source, file) in others {
        if let Some(entry) = difference("", &energy(one), &energy(file)) {
            return Err(JoinError::OtherEnergy {
                first: first.name.clone(),
                other: source.name.clone(),
                entry,
            });
        }
    }
    Ok(())
}

/// The common protocol of all simulated files, with the models of the objects of all.
fn protocol(files: &[(Source, GraspFile)]) -> Result<Value, JoinError> {
    let mut simulated = files
        .iter()
        .filter(|(_, file)| !file.metadata.stability.is_null());
    let Some((first, one)) = simulated.next() else {
        return Ok(Value::Null);
    };
    let mut told = one.metadata.stability.clone();
    for (source, file) in simulated {
        let other = &file.metadata.stability;
        for entry in ["protocol", "engine"] {
            if let Some(entry) = difference(entry, &told[entry], &other[entry]) {
                return Err(JoinError::OtherProtocol {
                    first: first.name.clone(),
                    other: source.name.clone(),
                    entry,
                });
            }
        }
        if let (Some(known), Some(more)) = (
            told["objects"].as_array().cloned(),
            other["objects"].as_array(),
        ) {
            let new = more.iter().filter(|model| !known.contains(model));
            let all = known.iter().chain(new).cloned().collect();
            told["objects"] = Value::Array(all);
        }
    }
    Ok(told)
}

/// The common rule of all labelled files.
fn rule(files: &[(Source, GraspFile)]) -> Result<Value, JoinError> {
    let without_program = |labels: &Value| {
        let mut labels = labels.clone();
        if let Some(entries) = labels.as_object_mut() {
            entries.remove("program_version");
        }
        labels
    };
    let mut labelled = files
        .iter()
        .filter(|(_, file)| !file.metadata.labels.is_null());
    let Some((first, one)) = labelled.next() else {
        return Ok(Value::Null);
    };
    let told = &one.metadata.labels;
    for (source, file) in labelled {
        let [one, other] = [told, &file.metadata.labels].map(without_program);
        if let Some(entry) = difference("", &one, &other) {
            return Err(JoinError::OtherRule {
                first: first.name.clone(),
                other: source.name.clone(),
                entry,
            });
        }
    }
    Ok(told.clone())
}

/// The first entry in which two values differ, with both: `layer.friction: 0.15 and 0.25`.
fn difference(place: &str, one: &Value, other: &Value) -> Option<String> {
    if one == other {
        return None;
    }
    if let (Value::Object(left), Value::Object(right)) = (one, other) {
        let within = |key: &String| {
            let inner = if place.is_empty() {
                key.clone()
            } else {
                format!("{place}.{key}")
            };
            let null = Value::Null;
            let [one, other] = [left, right].map(|entries| entries.get(key).unwrap_or(&null));
            difference(&inner, one, other)
        };
        return left.keys().chain(right.keys()).find_map(within);
    }
    Some(format!("{place}: {one} and {other}"))
}

fn rows(files: &[(Source, GraspFile)]) -> Vec<GraspRow> {
    let rows = files.iter().flat_map(|(source, file)| {
        file.grasps.iter().map(|row| {
            let before = match row.source.as_str() {
                "" => String::new(),
                before => format!(": {before}"),
            };
            GraspRow {
                source: format!("{} {}{before}", source.name, row.id),
                ..row.clone()
            }
        })
    });
    (0..)
        .zip(rows)
        .map(|(id, row)| GraspRow { id, ..row })
        .collect()
}

/// Grasps of one hand on one object of one size with one pose, bit for bit.
fn repeated(grasps: &[GraspRow]) -> Vec<[u64; 2]> {
    let mut first = BTreeMap::new();
    let mut repeated = Vec::new();
    for row in grasps {
        let pose = row.grasp.pose.to_vec();
        let bits: Vec<u64> = pose.iter().map(|number| number.to_bits()).collect();
        let key = (&row.hand, &row.object, row.scale.to_bits(), bits);
        let known = *first.entry(key).or_insert(row.id);
        if known != row.id {
            repeated.push([row.id, known]);
        }
    }
    repeated
}
