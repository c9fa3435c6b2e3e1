//! Published tests by name: data files of numbers with their sources.

use std::sync::LazyLock;

use serde::de::Error;
use serde::{Deserialize, Deserializer};
use toml::{Table, Value};

use super::settings::Protocol;

/// The data files.
const FILES: [&str; 8] = [
    include_str!("../../../data/protocols/drop.toml"),
    include_str!("../../../data/protocols/dexgraspbench.toml"),
    include_str!("../../../data/protocols/dexgraspbench-hard.toml"),
    include_str!("../../../data/protocols/dexgraspnet.toml"),
    include_str!("../../../data/protocols/graspqp.toml"),
    include_str!("../../../data/protocols/graspqp-all.toml"),
    include_str!("../../../data/protocols/gendexgrasp.toml"),
    include_str!("../../../data/protocols/graspdatagen.toml"),
];

/// A published test.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedProtocol {
    /// Its name.
    pub name: String,
    /// What it is, in a few words.
    pub title: String,
    /// Publication and code.
    pub source: String,
    /// What it demands, in two sentences.
    pub about: String,
    /// The test.
    pub protocol: Protocol,
    /// The same as a table, to which a file adds its own numbers.
    table: Table,
}

/// The published tests.
pub static NAMED: LazyLock<Vec<NamedProtocol>> = LazyLock::new(|| FILES.map(read).into());

/// The published test of a name.
pub fn named(name: &str) -> Option<Protocol> {
    found(name).map(|test| test.protocol.clone())
}

fn found(name: &str) -> Option<&'static NamedProtocol> {
    NAMED.iter().find(|test| test.name == name)
}

fn read(text: &'static str) -> NamedProtocol {
    let table = toml::from_str(text).expect("the data files are TOML");
    let mut table: Table = table;
    let mut take = |key| match table.remove(key) {
        Some(Value::String(text)) => text,
        _ => panic!("a data file has no {key}"),
    };
    let [title, source, about] = ["title", "source", "about"].map(&mut take);
    let name = name(&table).expect("the data files have names").to_owned();
    let protocol = parsed(table.clone()).expect("the data files hold whole protocols");
    NamedProtocol {
        name,
        title,
        source,
        about,
        protocol,
        table,
    }
}

fn name(table: &Table) -> Option<&str> {
    table.get("protocol").and_then(Value::as_str)
}

/// The protocol of a whole table.
fn parsed(mut table: Table) -> Result<Protocol, toml::de::Error> {
    if name(&table) == Some("drop") {
        table.remove("protocol");
        return table.try_into().map(Protocol::Drop);
    }
    table.try_into().map(Protocol::Loads)
}

/// Replaces values of `usual` by those of `given`.
fn overlay(usual: &mut Table, given: Table) {
    // A mass replaces a density, and a density a mass.
    for [one, other] in [["mass_kg", "density_kg_m3"], ["density_kg_m3", "mass_kg"]] {
        if given.contains_key(one) {
            usual.remove(other);
        }
    }
    for (key, value) in given {
        match (usual.get_mut(&key), value) {
            (Some(Value::Table(under)), Value::Table(over)) => overlay(under, over),
            (_, value) => {
                usual.insert(key, value);
            }
        }
    }
}

impl<'de> Deserialize<'de> for Protocol {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let given = Table::deserialize(deserializer)?;
        let Some(base) = name(&given).and_then(found) else {
            let names: Vec<&str> = NAMED.iter().map(|test| test.name.as_str()).collect();
            let fault = match given.get("protocol") {
                Some(other) => format!("the protocol {other} is unknown"),
                None => "it names no protocol".to_owned(),
            };
            let names = names.join("\", \"");
            let sentence = format!("{fault}: set `protocol` to one of \"{names}\"");
            return Err(D::Error::custom(sentence));
        };
        let mut table = base.table.clone();
        overlay(&mut table, given);
        parsed(table).map_err(D::Error::custom)
    }
}
