use std::collections::BTreeSet;

use super::*;
use crate::evaluation::stability::NAMED;
use crate::grasp::EnergySettings;
use crate::study::settings::{MapSearch, map_of};
use crate::topography::MapSettings;

fn file(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

fn all() -> Vec<ConfigurationFile> {
    let protocols = NAMED.iter().map(|test| test.protocol.clone());
    let first = [
        ConfigurationFile::Synth,
        ConfigurationFile::Build,
        ConfigurationFile::Surface,
    ];
    let protocols = protocols.map(ConfigurationFile::Stability);
    first.into_iter().chain(protocols).collect()
}

/// The paths of all keys that are not sections.
fn keys(table: &Table) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (key, value) in table {
        match value {
            Value::Table(under) => {
                found.extend(keys(under).iter().map(|under| format!("{key}.{under}")));
            }
            _ => {
                found.insert(key.clone());
            }
        }
    }
    found
}

/// The text without the signs that hide keys.
fn shown(text: &str) -> String {
    let shown = text.lines().map(|line| match line.strip_prefix('#') {
        Some(rest) if !rest.is_empty() && !rest.starts_with(' ') => rest,
        _ => line,
    });
    shown.collect::<Vec<_>>().join("\n")
}

fn settings_of_build(energy: &EnergySettings) -> GraspMapSettings {
    GraspMapSettings {
        map: map_of(energy),
        temperature: None,
        force: None,
        search: MapSearch::default(),
    }
}

/// What a text means to the program, as a table, whatever reads it.
fn read(of: &ConfigurationFile, text: &str) -> Result<Table, String> {
    let (_folder, path) = file(text);
    let told = |error: &dyn std::error::Error| crate::printable::sentence(error);
    match of {
        ConfigurationFile::Synth => {
            let found = Experiment::read(&path).map_err(|error| told(&error))?;
            Ok(plain(&found))
        }
        ConfigurationFile::Build => {
            let found = settings_of_build(&EnergySettings::default()).with_file(&path);
            let found = found.map_err(|error| told(&error))?;
            Ok(plain(&BuildFile {
                temperature: found.temperature,
                force: found.force,
                search: Some(found.search),
                map: Some(found.map),
            }))
        }
        ConfigurationFile::Surface => {
            let found = SurfaceConfiguration::read(Some(&path)).map_err(|error| told(&error))?;
            let mut search = found.search(SearchSettings::for_scales(3.0, 0.2)).unwrap();
            search.seed = found.seed().unwrap_or(search.seed);
            Ok(plain(&SurfaceFile {
                search: Some(search),
                lowest: Some(found.lowest(LowestSettings::default()).unwrap()),
                families: Some(found.families(FamilySettings::of_saddles()).unwrap()),
            }))
        }
        ConfigurationFile::Stability(_) => {
            let found: Protocol = protocol_of_text(text).map_err(|error| error.to_string())?;
            found.validate().map_err(|error| told(&error))?;
            Ok(plain(&found))
        }
    }
}

/// A printed file changes nothing, whatever energy or surface it is used for.
#[test]
fn printed_files_give_the_defaults() {
    for of in all() {
        let text = of.text();
        let found = read(&of, &text).unwrap();
        let usual = match &of {
            ConfigurationFile::Synth => plain(&Experiment::default()),
            _ => read(
                &of,
                if matches!(of, ConfigurationFile::Stability(_)) {
                    &text
                } else {
                    ""
                },
            )
            .unwrap(),
        };
        assert_eq!(found, usual, "{of:?}");
        if let ConfigurationFile::Stability(protocol) = &of {
            assert_eq!(found, plain(protocol));
        }
    }
    let (_folder, path) = file(&ConfigurationFile::Build.text());
    let usual = settings_of_build(&EnergySettings::default());
    let found = usual.clone().with_file(&path).unwrap();
    assert_eq!(found.map, usual.map);
}

/// Every key of the settings is in its template with a comment above it, and every key of the template exists.
#[test]
fn templates_explain_every_key() {
    for of in all() {
        let text = of.text();
        let told: Table = toml::from_str(&shown(&text)).unwrap();
        let mut known = keys(&of.values());
        let told = keys(&told);
        known.extend(
            told.iter()
                .filter(|key| {
                    let without_value = [
                        "temperature",
                        "force",
                        "barrier",
                        "mass_kg",
                        "density_kg_m3",
                        "linear_damping_per_s",
                        "angular_damping_per_s",
                        "force_n",
                        "displacement_m",
                        "turn_rad",
                    ];
                    without_value.contains(&key.rsplit('.').next().unwrap_or_default())
                })
                .cloned(),
        );
        assert_eq!(told, known, "{of:?}");
        let lines: Vec<&str> = text.lines().collect();
        for (number, line) in lines.iter().enumerate() {
            if line.contains(" = ") && !line.starts_with("# ") {
                let above = lines[number - 1];
                assert!(above.starts_with("# "), "{of:?}: no comment on `{line}`");
            }
        }
    }
}

/// Other values that a setting can take.
fn others(key: &str, value: &Value) -> Vec<Value> {
    match value {
        Value::Boolean(is) => vec![Value::from(!is)],
        Value::Integer(number) => [1, 2, -1].map(|more| Value::from(number + more)).into(),
        Value::Float(number) => [0.5 * number, 0.9 * number, 0.25, 2.0 * number + 1.0]
            .map(Value::from)
            .into(),
        Value::Array(parts) if parts[0].is_array() => vec![Value::Array(parts[1..].to_vec())],
        Value::Array(numbers) => [0.5, 2.0]
            .map(|factor| {
                let scaled = numbers
                    .iter()
                    .map(|number| Value::from(factor * number.as_float().unwrap()));
                Value::Array(scaled.collect())
            })
            .into(),
        Value::String(_) => {
            let words: &[&str] = match key {
                "search" => &["adelm"],
                "worst" => &["chain", "saddle"],
                "protocol" => &[],
                "rule" => &["squeeze", "none"],
                "needed" => &["half", "all"],
                "measured_from" => &["closed", "load"],
                "contact" => &["hand", "digits"],
                other => panic!("no other value of {other} is known"),
            };
            words.iter().map(|word| Value::from(*word)).collect()
        }
        Value::Table(_) | Value::Datetime(_) => Vec::new(),
    }
}

fn set(table: &mut Table, path: &[&str], value: Value) {
    match path {
        [key] => {
            table.insert((*key).to_owned(), value);
        }
        [section, rest @ ..] => {
            let under = table.entry(*section).or_insert_with(|| Table::new().into());
            set(under.as_table_mut().unwrap(), rest, value);
        }
        [] => {}
    }
}

/// Each key alone changes the setting of its name.
#[test]
fn every_key_can_be_changed() {
    for of in all() {
        let text = of.text();
        let whole: Table = toml::from_str(&shown(&text)).unwrap();
        let protocol = at(&whole, &["protocol"]).cloned();
        for key in keys(&whole) {
            let path: Vec<&str> = key.split('.').collect();
            let name = path[path.len() - 1];
            if name == "protocol" {
                continue;
            }
            let before = at(&whole, &path).unwrap();
            let attempts: Vec<(Value, Result<Table, String>)> = others(name, before)
                .into_iter()
                .filter(|value| value != before)
                .map(|value| {
                    let mut given = Table::new();
                    if let Some(protocol) = &protocol {
                        given.insert("protocol".to_owned(), protocol.clone());
                    }
                    set(&mut given, &path, value.clone());
                    let found = read(&of, &given.to_string());
                    (value, found)
                })
                .collect();
            let done = attempts.iter().any(|(value, found)| {
                found
                    .as_ref()
                    .is_ok_and(|found| at(found, &path) == Some(value))
            });
            assert!(done, "{of:?}: {key} cannot be changed: {attempts:?}");
        }
    }
}

#[test]
fn mistakes_name_file_and_line() {
    let usual = || settings_of_build(&EnergySettings::default());
    let sentence = |text: &str| {
        let (_folder, path) = file(text);
        let told = |error: ConfigurationError| crate::printable::sentence(&error);
        (
            usual().with_file(&path).map_err(told).unwrap_err(),
            SurfaceConfiguration::read(Some(&path))
                .map_err(told)
                .unwrap_err(),
        )
    };
    let (build, surface) = sentence("# mine\n[map]\nneigbours = 3\n[search]\nstepps = 3\n");
    for words in ["mine.toml", "landscape config build", "line 3", "neigbours"] {
        assert!(build.contains(words), "{build}");
    }
    for words in ["mine.toml", "landscape config surface", "line 2"] {
        assert!(surface.contains(words), "{surface}");
    }
    for (text, words) in [
        ("[map]\nneighbours = -1\n", "line 2"),
        (
            "[map]\nneighbours = 0\n",
            "map.neighbours = 0 is not from 1",
        ),
        (
            "[map.path]\nsegments = 1000000000\n",
            "map.path.segments = 1e9 is not",
        ),
        ("temperature = nan\n", "temperature = NaN is not"),
        ("temperature = inf\n", "temperature = inf is not"),
        ("force = -1.0\n", "force = -1 is not"),
        ("temperature = 0\n", "temperature = 0 is not from 1e-15"),
        ("[map]\nneighbours = 2.5\n", "expected a whole number"),
        ("[map", "line 1"),
    ] {
        let (build, _) = sentence_of_build(text);
        assert!(build.contains(words), "{text}: {build}");
    }
    let absent = usual().with_file(Path::new("absent.toml")).unwrap_err();
    assert_eq!(absent.to_string(), "cannot read absent.toml");
}

/// Whether a number is written with a point says nothing about what it may be.
#[test]
fn numbers_may_be_written_without_a_point() {
    let usual = || settings_of_build(&EnergySettings::default());
    for text in ["force = 2000000\n", "force = 2000000.0\n"] {
        let (_folder, path) = file(text);
        assert_eq!(usual().with_file(&path).unwrap().force, Some(2e6), "{text}");
    }
    let (_folder, path) = file("[search]\nlength = 2000000\n");
    let found = SurfaceConfiguration::read(Some(&path)).unwrap();
    let found = found.search(SearchSettings::for_scales(3.0, 0.2)).unwrap();
    assert_eq!(found, SearchSettings::for_scales(3.0, 2e6));
}

fn sentence_of_build(text: &str) -> (String, PathBuf) {
    let (_folder, path) = file(text);
    let error = settings_of_build(&EnergySettings::default())
        .with_file(&path)
        .unwrap_err();
    (crate::printable::sentence(&error), path)
}

/// What follows from a length and an energy follows from those of the file, and other keys still override it.
#[test]
fn scales_of_a_file_replace_those_that_were_measured() {
    let (_folder, path) = file("[search]\nlength = 4.0\nquench = { max_evaluations = 7 }\n");
    let found = SurfaceConfiguration::read(Some(&path)).unwrap();
    let found = found.search(SearchSettings::for_scales(3.0, 0.2)).unwrap();
    let mut expected = SearchSettings::for_scales(3.0, 4.0);
    expected.quench.max_evaluations = 7;
    assert_eq!(found, expected);
    assert_ne!(MapSettings::default(), default_map());
}

/// More keys than anybody can know are no help: a new one must replace another or be worth it.
#[test]
fn files_have_few_keys() {
    let templates = [SYNTH, BUILD, SURFACE, DROP, LOADS];
    let count: usize = templates
        .map(|template| settable(template).len())
        .iter()
        .sum();
    assert!(count <= 80, "{count} keys");
}

/// Fields of the settings that no template has cannot be set.
#[test]
fn only_keys_of_the_template_can_be_set() {
    for (of, text) in all().iter().zip([
        "[energy.layer]\npatch_spacing_m = 0.02\n",
        "[map.chain]\nescalation = 3.0\n",
        "[search.quench]\nmax_step = 0.1\n",
        "protocol = \"drop\"\nrest = { time_s = 1.0 }\n",
        "protocol = \"dexgraspbench\"\nsolver = { substeps = 3 }\n",
    ]) {
        let refusal = read(of, text).unwrap_err();
        assert!(refusal.contains("line 2: unknown key"), "{refusal}");
    }
}
