//! The sources obey the table "Rooms: who may use whom" of docs/ARCHITECTURE.md.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// A row of the table.
struct Room {
    row: u32,
    crates: BTreeSet<String>,
}

/// The rooms of the table, by name.
fn rooms(document: &str) -> BTreeMap<String, Room> {
    let quoted = |cell: &str| -> Vec<String> {
        let parts = cell.split('`').skip(1).step_by(2);
        parts.map(str::to_owned).collect()
    };
    let rows = document.lines().filter_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, row, name, _, crates, _] = cells[..] else {
            return None;
        };
        let name = quoted(name).pop()?;
        let crates = quoted(crates).into_iter().collect();
        Some((
            name,
            Room {
                row: row.parse().ok()?,
                crates,
            },
        ))
    });
    rows.collect()
}

/// The text of a file before its tests.
pub(super) fn before_tests(text: &str) -> &str {
    let heads = [
        "mod tests",
        "pub(super) mod tests",
        "#[cfg(unix)]\nmod tests",
    ];
    let heads = heads.map(|head| text.find(&format!("#[cfg(test)]\n{head}")));
    let ends = heads
        .into_iter()
        .flatten()
        .chain(text.find("#[cfg(all(test"));
    &text[..ends.min().unwrap_or(text.len())]
}

/// Whether a path names Rust that is not only for tests.
pub(super) fn is_code(path: &str) -> bool {
    let only_tests = ["/tests.rs", "/testing"]
        .iter()
        .any(|part| path.contains(part));
    !only_tests
        && Path::new(path)
            .extension()
            .is_some_and(|ending| ending == "rs")
}

/// The code of a file without comments and tests.
fn code(text: &str) -> String {
    let lines = before_tests(text).lines();
    let lines = lines.map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// The name that a text begins with.
fn name(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
    &text[..end.unwrap_or(text.len())]
}

/// The names that follow a path: one name, or those of a group in braces.
fn heads(rest: &str) -> Vec<&str> {
    let Some(group) = rest.strip_prefix('{') else {
        return vec![name(rest)];
    };
    let (mut depth, mut start, mut names) = (0, 0, Vec::new());
    for (place, letter) in group.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                names.push(name(group[start..place].trim_start()));
                start = place + 1;
                if letter == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    names
}

/// Places where `path::` begins, and what follows.
fn named<'a>(code: &'a str, path: &str) -> Vec<&'a str> {
    let begins = |place: usize| {
        let before = code[..place].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || matches!(c, '_' | ':'))
    };
    let places = code.match_indices(path).filter(|(place, _)| begins(*place));
    places
        .map(|(place, _)| &code[place + path.len()..])
        .collect()
}

/// The rooms that a file names; `depth` is the number of modules that it lies in, its own included.
fn used(code: &str, depth: usize) -> BTreeSet<&str> {
    let mut used: BTreeSet<&str> = named(code, "crate::").into_iter().flat_map(heads).collect();
    let from_root = named(code, &"super::".repeat(depth));
    used.extend(from_root.into_iter().flat_map(heads));
    used
}

/// The uses in `files` (paths below `src`, and texts) that the table does not allow.
fn faults(document: &str, manifest: &str, files: &BTreeMap<String, String>) -> Vec<String> {
    let rooms = rooms(document);
    let dependencies = manifest
        .split("[dev-dependencies]")
        .next()
        .unwrap_or_default();
    let dependencies: Vec<String> = (dependencies.lines())
        .filter_map(|line| line.split_once(" = {").or_else(|| line.split_once(" = \"")))
        .map(|(name, _)| name.to_owned())
        .collect();
    let mut faults = Vec::new();
    let mut present = BTreeSet::new();
    for (path, text) in files.iter().filter(|(path, _)| is_code(path)) {
        let code = code(text);
        let module = path.trim_end_matches(".rs").trim_end_matches("/mod");
        let name = module.split('/').next().unwrap_or_default();
        if matches!(name, "lib" | "main") {
            continue;
        }
        let Some(room) = rooms.get(name) else {
            faults.push(format!("{path}: `{name}` has no row"));
            continue;
        };
        present.insert(name.to_owned());
        for other in used(&code, module.split('/').count()) {
            let above = rooms.get(other).is_some_and(|other| other.row < room.row);
            if other != name && !above {
                faults.push(format!("{path}: `{name}` may not use `{other}`"));
            }
        }
        for dependency in &dependencies {
            let listed = rooms.values().any(|room| room.crates.contains(dependency));
            let path_of = format!("{}::", dependency.replace('-', "_"));
            if listed && !room.crates.contains(dependency) && !named(&code, &path_of).is_empty() {
                faults.push(format!("{path}: `{name}` may not name {dependency}"));
            }
        }
    }
    for (name, room) in &rooms {
        if !present.contains(name) {
            faults.push(format!("`{name}` has a row and no file"));
        }
        let unknown = room
            .crates
            .iter()
            .filter(|name| !dependencies.contains(name));
        faults.extend(unknown.map(|known| format!("`{name}`: {known} is no dependency")));
    }
    faults
}

/// Adds the texts of all files in a folder and below, by path, except packages that npm installed.
pub(super) fn add_files(folder: &Path, below: &str, files: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{below}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            if !path.ends_with("node_modules") {
                add_files(&path, &format!("{name}/"), files);
            }
        } else {
            files.insert(name, fs::read_to_string(&path).unwrap());
        }
    }
}

#[test]
fn rooms_use_only_rooms_above_and_crates_of_their_own() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = |name: &str| fs::read_to_string(project.join(name)).unwrap();
    let mut files = BTreeMap::new();
    add_files(&project.join("src"), "", &mut files);
    let found = faults(&text("docs/ARCHITECTURE.md"), &text("Cargo.toml"), &files);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn wrong_uses_are_found() {
    let table = "| 1 | `low` | | `png` |\n| 1 | `side` | | |\n| 2 | `high` | | |\n| 3 | `none` | | `nix` |\n";
    let manifest = "[dependencies]\npng = \"1\"\n\n[dev-dependencies]\nnix = \"1\"\n";
    let files = [
        ("lib.rs", "use crate::high::Any;"),
        (
            "low/mod.rs",
            "mod deep;\nuse super::side::B;\n#[cfg(test)]\nmod tests;",
        ),
        ("low/tests.rs", "use crate::high::A;"),
        (
            "low/deep.rs",
            "use super::A;\nuse super::super::{low::B, high::{a, b}};\npub fn a() {\n    png::read()\n}\n\
             #[cfg(test)]\nmod tests {\n    use crate::side::A;\n}\n",
        ),
        ("side.rs", "//! crate::high\nuse crate::side::A;"),
        (
            "high.rs",
            "use crate::{low, side::{A, B}, new};\nfn b() {\n    low::png::read() + png::write()\n}",
        ),
        ("new.rs", ""),
    ];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let found = faults(table, manifest, &BTreeMap::from(files));
    let expected = [
        "high.rs: `high` may not use `new`",
        "high.rs: `high` may not name png",
        "low/deep.rs: `low` may not use `high`",
        "low/mod.rs: `low` may not use `side`",
        "new.rs: `new` has no row",
        "`none` has a row and no file",
        "`none`: nix is no dependency",
    ];
    assert_eq!(found, expected);
}

/// The method of the paper is for the figures that compare with it: no other module names it.
#[test]
fn nothing_uses_the_room_of_the_paper() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = BTreeMap::new();
    add_files(&sources, "", &mut files);
    files.retain(|name, _| is_code(name) && !name.starts_with("grasp/paper/"));
    for (name, text) in files {
        let code = code(&text);
        assert!(!code.contains("paper::"), "{name} names grasp::paper");
    }
}
