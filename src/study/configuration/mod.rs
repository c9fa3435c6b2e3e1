//! Files of settings: what `landscape config` prints, and what `--config` reads.
//!
//! A template beside this file explains each key in a comment and names no value: the values are those of the program, so
//! the printed file cannot differ from them. A file may set the keys of its template only. The settings of the program have
//! more fields, which follow from others or differ between energies; files of results record them as well.

mod ranges;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde::de::{DeserializeOwned, Error};
use serde::{Deserialize, Serialize};
use toml::de::{DeTable, DeValue};
use toml::{Table, Value};

use super::experiment::overlay;
use super::settings::{MapSearch, default_map};
use super::{Experiment, GraspMapSettings};
use crate::evaluation::stability::{NAMED, Protocol, named};
use crate::formats::toml_text;
use crate::limits::Beyond;
use crate::topography::{FamilySettings, LowestSettings, MapSettings, SearchSettings};

pub(super) const SYNTH: &str = include_str!("synth.txt");
const BUILD: &str = include_str!("build.txt");
const SURFACE: &str = include_str!("surface.txt");
const DROP: &str = include_str!("drop.txt");
const LOADS: &str = include_str!("loads.txt");

/// A file of settings that `landscape config` prints.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one in a command")]
pub enum ConfigurationFile {
    /// Of `synth`.
    Synth,
    /// Of `build`.
    Build,
    /// Of `surface`.
    Surface,
    /// Of `stability`.
    Stability(Protocol),
}

impl ConfigurationFile {
    /// The whole file with a comment on each key. Read back, it gives the defaults.
    ///
    /// # Panics
    /// Never: settings are plain data.
    pub fn text(&self) -> String {
        let (template, values) = self.parts();
        let name = values.get("protocol").and_then(Value::as_str);
        let test = NAMED.iter().find(|test| name == Some(test.name.as_str()));
        let head = test.map(|test| format!("# {}\n# Source: {}\n\n", test.about, test.source));
        head.unwrap_or_default() + &rendered(template, &values)
    }

    /// The settings that a file may set, as they are without one.
    ///
    /// # Panics
    /// Never: settings are plain data.
    pub fn values(&self) -> Table {
        let (template, values) = self.parts();
        retained(values, &settable(template), "")
    }

    /// The template and the values.
    fn parts(&self) -> (&'static str, Table) {
        match self {
            Self::Synth => (SYNTH, plain(&Experiment::default())),
            Self::Build => {
                let values = plain(&BuildFile {
                    search: Some(MapSearch::default()),
                    map: Some(default_map()),
                    ..BuildFile::default()
                });
                (BUILD, values)
            }
            Self::Surface => (SURFACE, plain(&SurfaceFile::standard())),
            Self::Stability(protocol) => {
                let template = match protocol {
                    Protocol::Drop(_) => DROP,
                    Protocol::Loads(_) => LOADS,
                };
                (template, plain(protocol))
            }
        }
    }
}

/// Fills in a template: `key` becomes `key = value`. `key ~` is measured or depends on the energy, and `key ? example` has no
/// value, so both begin with `#`, as do all keys of a section that is missing.
fn rendered(template: &str, values: &Table) -> String {
    let mut text = String::new();
    let (mut section, mut missing) = (Vec::new(), false);
    for line in template.lines() {
        if line.is_empty() || line.starts_with('#') {
            let _ = writeln!(text, "{line}");
        } else if let Some(name) = line.strip_prefix('[') {
            section = name.trim_end_matches(']').split('.').collect();
            missing = at(values, &section).is_none();
            let _ = writeln!(text, "{}{line}", if missing { "#" } else { "" });
        } else {
            let mut words = line.splitn(3, ' ');
            let key = words.next().unwrap_or_default();
            let mark = words.next();
            let path: Vec<&str> = section.iter().copied().chain([key]).collect();
            let value = at(values, &path);
            let hidden = missing || mark == Some("~") || value.is_none();
            let shown = value.map_or_else(
                || words.next().unwrap_or_default().to_owned(),
                ToString::to_string,
            );
            let _ = writeln!(text, "{}{key} = {shown}", if hidden { "#" } else { "" });
        }
    }
    text
}

/// The paths of the keys of a template.
fn settable(template: &str) -> Vec<String> {
    let mut section = String::new();
    let mut keys = Vec::new();
    for line in template.lines() {
        if let Some(name) = line.strip_prefix('[') {
            section = format!("{}.", name.trim_end_matches(']'));
        } else if !line.is_empty() && !line.starts_with('#') {
            let key = line.split(' ').next().unwrap_or_default();
            keys.push(format!("{section}{key}"));
        }
    }
    keys
}

/// The part of a table whose paths are among `keys`. `section` ends with a dot.
fn retained(table: Table, keys: &[String], section: &str) -> Table {
    let kept = |(key, value)| {
        let path = format!("{section}{key}");
        let value = match value {
            Value::Table(under) => {
                let under = retained(under, keys, &format!("{path}."));
                (!under.is_empty()).then_some(Value::Table(under))
            }
            value => keys.contains(&path).then_some(value),
        };
        value.map(|value| (key, value))
    };
    table.into_iter().filter_map(kept).collect()
}

/// Reads a text that may hold any part of a `T`, but only keys of the template.
pub(super) fn parse<T: DeserializeOwned>(template: &str, text: &str) -> Result<T, toml::de::Error> {
    // Texts that are too long or too deep are refused here.
    toml_text::parse::<Table>(text)?;
    let table = DeTable::parse(text)?;
    check_keys(table.get_ref(), &settable(template), "", text)?;
    toml_text::parse(text)
}

/// Refuses other keys than `keys`. `section` ends with a dot.
fn check_keys(
    table: &DeTable<'_>,
    keys: &[String],
    section: &str,
    text: &str,
) -> Result<(), toml::de::Error> {
    for (key, value) in table {
        let path = format!("{section}{}", key.get_ref());
        let under = format!("{path}.");
        let is_section = keys.iter().any(|known| known.starts_with(&under));
        if !is_section && !keys.contains(&path) {
            let before = text.get(..key.span().start).unwrap_or_default();
            let line = 1 + before.matches('\n').count();
            let here = keys.iter().filter_map(|known| known.strip_prefix(section));
            let mut names: Vec<_> = here.filter_map(|known| known.split('.').next()).collect();
            names.dedup();
            return Err(toml::de::Error::custom(format!(
                "line {line}: unknown key `{path}`, expected one of `{}`",
                names.join("`, `")
            )));
        }
        if let (true, DeValue::Table(inner)) = (is_section, value.get_ref()) {
            check_keys(inner, keys, &under, text)?;
        }
    }
    Ok(())
}

/// A protocol of `stability` from a text (TOML), which may leave out any number.
///
/// # Errors
/// If the text is not TOML, names no protocol, or has unknown keys.
pub fn protocol_of_text(text: &str) -> Result<Protocol, toml::de::Error> {
    let table: Table = toml_text::parse(text)?;
    match table
        .get("protocol")
        .and_then(Value::as_str)
        .and_then(named)
    {
        Some(Protocol::Drop(_)) => parse(DROP, text),
        Some(Protocol::Loads(_)) => parse(LOADS, text),
        None => toml_text::parse(text),
    }
}

/// The value of a path of keys.
fn at<'a>(table: &'a Table, path: &[&str]) -> Option<&'a Value> {
    let (last, before) = path.split_last()?;
    let mut table = table;
    for key in before {
        table = table.get(*key)?.as_table()?;
    }
    table.get(*last)
}

fn plain(settings: &impl Serialize) -> Table {
    Table::try_from(settings).expect("settings are plain data with text keys")
}

/// Why a file of settings cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigurationError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file holds something else.
    #[error("{} does not contain settings of `landscape {verb}` (`landscape config {verb}` prints them)", path.display())]
    Toml {
        /// The file.
        path: PathBuf,
        /// The command that was to read it.
        verb: &'static str,
        /// Why.
        source: Box<toml::de::Error>,
    },
    /// A number is out of its range.
    #[error("{}: {key} = {beyond}", path.display())]
    Range {
        /// The file.
        path: PathBuf,
        /// The key, with its sections.
        key: String,
        /// Its value and its range.
        beyond: Beyond,
    },
}

/// A file as it was given: its keys and values, of which none is unknown.
#[derive(Debug, Clone)]
struct Given {
    path: PathBuf,
    verb: &'static str,
    table: Table,
}

impl Given {
    /// Reads a file that may hold any part of a `T`.
    fn read<T: Serialize + for<'a> Deserialize<'a>>(
        path: &Path,
        (verb, template): (&'static str, &str),
    ) -> Result<(Self, T), ConfigurationError> {
        let text = std::fs::read_to_string(path).map_err(|source| ConfigurationError::Read {
            path: path.to_path_buf(),
            source,
        })?;
        let given = |table| Self {
            path: path.to_path_buf(),
            verb,
            table,
        };
        // Read as what it must be first, so that errors name lines.
        let typed: T =
            parse(template, &text).map_err(|error| given(Table::new()).refused(error))?;
        let table = toml::from_str(&text).map_err(|error| given(Table::new()).refused(error))?;
        let given = given(table);
        ranges::check(&given.table, &plain(&typed)).map_err(|(key, beyond)| {
            ConfigurationError::Range {
                path: path.to_path_buf(),
                key,
                beyond,
            }
        })?;
        Ok((given, typed))
    }

    fn refused(&self, source: toml::de::Error) -> ConfigurationError {
        ConfigurationError::Toml {
            path: self.path.clone(),
            verb: self.verb,
            source: Box::new(source),
        }
    }

    /// The settings in which the values of a section of the file replace those of `usual`.
    fn over<T: Serialize + for<'a> Deserialize<'a>>(
        &self,
        section: &str,
        usual: &T,
    ) -> Result<T, ConfigurationError> {
        let mut table = plain(usual);
        if let Some(Value::Table(given)) = self.table.get(section) {
            overlay(&mut table, given.clone());
        }
        table.try_into().map_err(|error| self.refused(error))
    }
}

/// The keys of a file of `build`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
struct BuildFile {
    temperature: Option<f64>,
    force: Option<f64>,
    search: Option<MapSearch>,
    map: Option<MapSettings>,
}

impl GraspMapSettings {
    /// These settings with the values of a file (TOML) in place of theirs.
    ///
    /// # Errors
    /// If the file cannot be read, has unknown keys, or a number is out of its range.
    pub fn with_file(self, path: &Path) -> Result<Self, ConfigurationError> {
        let (given, file) = Given::read::<BuildFile>(path, ("build", BUILD))?;
        Ok(Self {
            map: given.over("map", &self.map)?,
            temperature: file.temperature.or(self.temperature),
            force: file.force.or(self.force),
            search: file.search.unwrap_or(self.search),
        })
    }
}

/// The keys of a file of `surface`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
struct SurfaceFile {
    search: Option<SearchSettings>,
    lowest: Option<LowestSettings>,
    families: Option<FamilySettings>,
}

impl SurfaceFile {
    fn standard() -> Self {
        Self {
            search: Some(SearchSettings::default()),
            lowest: Some(LowestSettings::default()),
            families: Some(FamilySettings::of_saddles()),
        }
    }
}

/// Settings of a search of a surface from a file (TOML).
#[derive(Debug, Clone, Default)]
pub struct SurfaceConfiguration(Option<Given>);

impl SurfaceConfiguration {
    /// Reads a file. Without one, nothing is changed.
    ///
    /// # Errors
    /// If the file cannot be read, has unknown keys, or a number is out of its range.
    pub fn read(path: Option<&Path>) -> Result<Self, ConfigurationError> {
        let read =
            |path| Given::read::<SurfaceFile>(path, ("surface", SURFACE)).map(|(given, _)| given);
        Ok(Self(path.map(read).transpose()?))
    }

    /// The seed of all random draws, if the file sets it.
    pub fn seed(&self) -> Option<u64> {
        match at(&self.0.as_ref()?.table, &["search", "seed"]) {
            Some(Value::Integer(seed)) => u64::try_from(*seed).ok(),
            _ => None,
        }
    }

    /// Whether the file sets `max_searches`.
    pub fn limits_searches(&self) -> bool {
        let given = self.0.as_ref();
        given.is_some_and(|given| at(&given.table, &["search", "max_searches"]).is_some())
    }

    /// The settings of the search in place of those measured on the surface. If the file sets the length or the energy, all
    /// that follows from these follows from its values.
    ///
    /// # Errors
    /// Never after [`Self::read`].
    pub fn search(&self, measured: SearchSettings) -> Result<SearchSettings, ConfigurationError> {
        let Some(given) = &self.0 else {
            return Ok(measured);
        };
        let number = |key| match at(&given.table, &["search", key]) {
            Some(Value::Float(number)) => Some(*number),
            Some(Value::Integer(number)) => Some(*number as f64),
            _ => None,
        };
        let usual = match (number("energy"), number("length")) {
            (None, None) => measured,
            (energy, length) => SearchSettings {
                seed: measured.seed,
                ..SearchSettings::for_scales(
                    energy.unwrap_or(measured.energy),
                    length.unwrap_or(measured.length),
                )
            },
        };
        given.over("search", &usual)
    }

    /// The settings of the search for the lowest part in place of the usual ones.
    ///
    /// # Errors
    /// Never after [`Self::read`].
    pub fn lowest(&self, usual: LowestSettings) -> Result<LowestSettings, ConfigurationError> {
        match &self.0 {
            Some(given) => given.over("lowest", &usual),
            None => Ok(usual),
        }
    }

    /// The settings of the families in place of the usual ones.
    ///
    /// # Errors
    /// Never after [`Self::read`].
    pub fn families(&self, usual: FamilySettings) -> Result<FamilySettings, ConfigurationError> {
        match &self.0 {
            Some(given) => given.over("families", &usual),
            None => Ok(usual),
        }
    }
}

#[cfg(test)]
mod tests;
