//! `--json`: one document of every command, with the fields that docs/scripts.md describes and no others.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::desk::Desk;
use crate::diversity::plant;
use crate::table::rows;
use crate::{in_cache, thirty_grasps};

/// Section of the page, and a command of which it describes the document.
const RUNS: &str = "
    synth | synth --object ball -n 4 --steps 1 --keep all --drop 2 -o s.parquet
    synth | synth --object ball -n 2 --steps 1 --keep all --drop 0 -q -o s.parquet
    synth | synth --object ball -n 2 --steps 2 --keep all --drop 0 --grips thumb+index -o s.parquet
    synth | synth --from g.parquet --beyond g.parquet -n 2 --steps 1 --keep all --drop 0 -o s.parquet
    build | build g.parquet --first 3 -o b.landscape --no-report
    surface | surface muller-brown --no-report
    import of a landscape | import database --no-report
    inspect | inspect g.parquet
    inspect | inspect thirty.parquet
    inspect of contacts | inspect contacts.json
    inspect of contacts | inspect one.json
    inspect --path | inspect g.landscape --path m0 m1 --pictures 2
    stability | stability g.parquet
    label | label g.parquet
    label --learn | label --learn named.parquet -o my.labeller
    label | label g.parquet --by my.labeller
    label --explain | label g.parquet --explain 0
    label --explain | label g.parquet --explain 0 --by my.labeller
    join | join g.parquet g.parquet -o twice.parquet
    hands list | hands list
    hands inspect | hands inspect gripper_parallel
    hands can | hands can human pen -n 1
    objects list | objects list
    objects inspect | objects inspect cube.obj
    objects inspect | objects inspect bottle_round --side-file side.json
    objects bake | objects bake model.safetensors --specs specs.json --scale 0.1 --cells 40 -o baked.obj
    import of grasps | import g.csv --hand human --object ball
    report | report g.landscape
    draw | draw g.landscape
    compare | compare g.landscape
    compare of two landscapes | compare g.landscape g.landscape -o two
    diff | diff g.landscape other.landscape
    diversity | diversity thirty.parquet
    judge | judge g.parquet --tests drop,graspqp --measures q1,types
    survey | survey g.parquet thirty.parquet --first 30 --no-map -o counted.survey
    survey | survey g.parquet --first 3 --no-report
    a task of a survey | survey g.parquet --first 3 --no-report -o shared.survey --task 1/2
    thermodynamics | thermodynamics muller-brown.landscape
    rates | rates muller-brown.landscape --from m1 --to m0 --temperature 10,20
    export | export g.parquet csv -o e.csv
    export | export g.parquet urdf -o hand
    export | export g.landscape roadmap -o map.json
    route | route g.landscape m0 m1
    route | route g.landscape m0 m1 --drive
    config | config build
    cache | cache
    cache clear | cache clear
    completions | completions bash
    man | man pages
";

/// A field that the page describes.
struct Field {
    path: Vec<String>,
    kind: String,
    met: bool,
}

/// The fields of the page by section: items such as ``- `a`, `b[].c` (number): meaning``.
fn described() -> BTreeMap<String, Vec<Field>> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scripts.md");
    let mut sections: BTreeMap<String, Vec<Field>> = BTreeMap::new();
    let mut titles: Vec<String> = Vec::new();
    for line in fs::read_to_string(page).unwrap().lines() {
        if let Some(title) = line.strip_prefix("### ") {
            titles = title.split(", ").map(str::to_owned).collect();
        } else if let Some(row) = line.strip_prefix("- `").filter(|_| !titles.is_empty()) {
            let (paths, rest) = row.split_once("` (").expect(line);
            let (kind, meaning) = rest.split_once("): ").expect(line);
            assert!(meaning.len() > 3, "{line}");
            for (title, path) in titles
                .iter()
                .flat_map(|title| paths.split("`, `").map(move |path| (title, path)))
            {
                let path = path.replace("[]", ".[]");
                let path = path.split('.').filter(|part| !part.is_empty());
                sections.entry(title.clone()).or_default().push(Field {
                    path: path.map(str::to_owned).collect(),
                    kind: kind.to_owned(),
                    met: false,
                });
            }
        }
    }
    sections
}

/// Whether a value is of a kind, such as `text` or `number or null`.
fn is_of(kind: &str, value: &Value) -> bool {
    kind.split(" or ").any(|kind| match kind {
        "number" => value.is_number(),
        "integer" => value.is_u64(),
        "text" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "list" => value.is_array(),
        "object" => value.is_object(),
        "missing" => false,
        other => panic!("`{other}` is no kind of value"),
    })
}

/// Checks that the page describes all of `value`, which stands at `path`.
fn check(section: &str, path: &[String], value: &Value, fields: &mut [Field]) {
    let fits = |field: &Field| {
        field.path.len() == path.len()
            && field
                .path
                .iter()
                .zip(path)
                .all(|(told, met)| told == met || told == "*" && met != "[]")
    };
    // An exact name goes before `*`.
    let exact = fields.iter().position(|field| field.path == path);
    if let Some(row) = exact.or_else(|| fields.iter().position(fits)) {
        let kind = fields[row].kind.clone();
        assert!(
            is_of(&kind, value),
            "{section}: {path:?} is not {kind}: {value}"
        );
        fields[row].met = true;
        return;
    }
    let below = |part: String| [path, &[part]].concat();
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                check(section, &below(key.clone()), value, fields);
            }
        }
        Value::Array(items) => {
            for item in items {
                check(section, &below("[]".into()), item, fields);
            }
        }
        _ => panic!("{section}: docs/scripts.md does not describe {path:?}: {value}"),
    }
}

fn inputs() -> Desk {
    let desk = Desk::with_grasps();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let copy = |from: &str, to: &str| fs::copy(root.join(from), desk.path(to)).unwrap();
    copy(
        "tests/reference/deepsdf/small_model.safetensors",
        "model.safetensors",
    );
    copy("tests/reference/deepsdf/small_specs.json", "specs.json");
    copy("data/objects/box.obj", "cube.obj");
    desk.add_landscape("g.landscape");
    desk.add_database("database");
    desk.write("thirty.parquet", thirty_grasps());
    let types = ["Medium Wrap", "Tripod"];
    plant(&desk, "named.parquet", 40, &types, false);
    desk.write(
        "contacts.json",
        r#"{"contacts": [
            {"position": [0.03, 0, 0.01], "inward_normal": [-1, 0, 0]},
            {"position": [-0.03, 0, 0.01], "inward_normal": [1, 0, 0]},
            {"position": [0, 0.03, -0.01], "inward_normal": [0, -1, 0]},
            {"position": [0, -0.03, -0.01], "inward_normal": [0, 1, 0]}
        ]}"#,
    );
    desk.write(
        "one.json",
        r#"{"contacts": [{"position": [0.03, 0, 0], "inward_normal": [-1, 0, 0]}], "length": 0.1}"#,
    );
    desk.succeed("export g.parquet csv -q -o g.csv");
    desk.succeed("surface muller-brown -q --no-report -o muller-brown.landscape");
    desk.succeed(
        "build g.parquet --first 3 --seed 2 --neighbours 1 -q --no-report -o other.landscape",
    );
    desk
}

/// Every command prints one document of the fields that the page describes, and the page describes no others.
#[test]
fn documents_are_as_described() {
    let desk = inputs();
    let mut sections = described();
    for run in rows(RUNS) {
        let [section, line] = run[..] else {
            panic!("{run:?}");
        };
        let mut command = desk.command(&format!("{line} --json"));
        if line.starts_with("cache") {
            // Not the cache of whoever runs the tests.
            in_cache(&mut command, &desk.path("cache"));
        }
        let output = command.output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{line}: {said}");
        let value: Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|error| panic!("{line}: {error}"));
        assert!(value.is_object(), "{line}");
        let fields = sections
            .get_mut(section)
            .unwrap_or_else(|| panic!("no section {section}"));
        check(section, &[], &value, fields);
    }
    let unmet: Vec<String> = (sections.iter())
        .flat_map(|(section, fields)| fields.iter().map(move |field| (section, field)))
        .filter(|(_, field)| !field.met && !field.kind.contains("missing"))
        .map(|(section, field)| format!("{section}: {}", field.path.join(".")))
        .collect();
    assert_eq!(unmet, [""; 0], "described, but no command prints them");
}

/// No command is forgotten.
#[test]
fn every_command_has_its_document() {
    let mut open = vec![(String::new(), landscape::cli::definition())];
    let mut commands = BTreeSet::new();
    while let Some((name, command)) = open.pop() {
        let under: Vec<_> = command
            .get_subcommands()
            .filter(|under| under.get_name() != "help")
            .collect();
        if under.is_empty() {
            commands.insert(name.trim().to_owned());
        }
        open.extend(
            under
                .iter()
                .map(|under| (format!("{name} {}", under.get_name()), (*under).clone())),
        );
    }
    let runs = |command: &String| {
        rows(RUNS).any(|run| format!("{} ", run[1]).starts_with(&format!("{command} ")))
    };
    let forgotten: Vec<_> = commands.iter().filter(|command| !runs(command)).collect();
    assert_eq!(forgotten, [""; 0]);
}

/// With `--json`, standard output holds the document alone, with or without `--quiet` and `--verbose`. A mistake leaves it
/// empty.
#[test]
fn standard_output_holds_the_document_alone() {
    let desk = Desk::with_grasps();
    let document = |flags: &str| {
        let (text, said) = desk.both(&format!("label g.parquet --force --json {flags}"));
        (serde_json::from_str::<Value>(&text).unwrap(), said)
    };
    let (usual, _) = document("");
    let (quiet, nothing) = document("-q");
    let (verbose, told) = document("-v");
    assert_eq!((&usual, nothing.as_str()), (&quiet, ""));
    assert_eq!(usual, verbose);
    assert!(told.contains("read 6 grasps from g.parquet"), "{told}");
    let output = desk.run("label absent.parquet --json");
    assert_eq!((output.status.code(), output.stdout), (Some(1), Vec::new()));
}

/// With `--log-format json`, standard error holds one document in each line, and the outputs are the same.
#[test]
fn lines_may_be_documents() {
    let desk = Desk::with_grasps();
    let lines = |line: &str| -> Vec<Value> {
        let output = desk.run(line);
        let said = String::from_utf8(output.stderr).unwrap();
        said.lines()
            .map(|line| serde_json::from_str(line).expect(&said))
            .collect()
    };
    let level = |lines: &[Value], level: &str| -> Vec<String> {
        let of = lines.iter().filter(|line| line["level"] == level);
        of.map(|line| line["message"].as_str().unwrap().to_owned())
            .collect()
    };
    let told = lines("label g.parquet -v --log-format json -o l.parquet");
    assert!(
        told.iter()
            .all(|line| line["unix_seconds"].as_f64().unwrap() > 1e9)
    );
    assert!(
        level(&told, "info").contains(&"wrote l.parquet".to_owned()),
        "{told:?}"
    );
    assert!(!level(&told, "detail").is_empty(), "{told:?}");
    let told = lines("label missing.parquet --log-format json");
    let [error] = level(&told, "error").try_into().unwrap();
    assert!(
        error.contains("missing.parquet") && !error.starts_with("error"),
        "{error}"
    );
    desk.succeed("label g.parquet -q -o plain.parquet");
    let [plain, logged] = ["plain.parquet", "l.parquet"].map(|name| desk.bytes(name));
    assert!(plain == logged, "the same bytes");
}
