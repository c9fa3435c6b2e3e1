//! `landscape inspect` as a user runs it: bare contacts compared with references, files of grasps, and the messages of all
//! mistakes.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::fs;

use crate::desk::{Desk, assert_says};
use landscape::store::{GraspFile, Overrides};
use nalgebra::{Rotation3, Vector3};
use serde_json::{Value, json};

impl Desk {
    /// The output of a command that must succeed.
    fn print(&self, line: &str) -> String {
        let output = self.run(line);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "landscape {line}: {said}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// The output of `inspect` for the bare contacts of a file.
    fn text(&self, file: &Value) -> String {
        fs::write(self.path("c.json"), file.to_string()).unwrap();
        self.print("inspect c.json")
    }

    /// The same output as JSON.
    fn report(&self, file: &Value) -> Value {
        fs::write(self.path("c.json"), file.to_string()).unwrap();
        serde_json::from_str(&self.print("inspect c.json --json")).unwrap()
    }

    /// A file with a few grasps of `data/grasps.parquet`; the last of them is moved off the object.
    fn with_grasps() -> Self {
        let desk = Self::empty();
        let (mut file, _) = GraspFile::read(data().as_ref(), Overrides::default()).unwrap();
        file.grasps.truncate(5);
        file.grasps[4].grasp.pose[0] += 0.3;
        file.write(&desk.path("g.parquet")).unwrap();
        desk
    }
}

fn data() -> &'static str {
    concat!(env!("CARGO_MANIFEST_DIR"), "/data/grasps.parquet")
}

fn contacts(positions: &[Vector3<f64>], inward_normals: &[Vector3<f64>]) -> Value {
    let contact = |(position, normal): (&Vector3<f64>, &Vector3<f64>)| json!({ "position": position.as_slice(), "inward_normal": normal.as_slice() });
    let contacts: Vec<Value> = positions.iter().zip(inward_normals).map(contact).collect();
    json!({ "contacts": contacts })
}

/// Contacts at the given directions on the unit sphere.
fn on_sphere(directions: &[[f64; 3]]) -> Value {
    let points: Vec<Vector3<f64>> = directions
        .iter()
        .map(|d| Vector3::from(*d).normalize())
        .collect();
    let normals: Vec<Vector3<f64>> = points.iter().map(|point| -point).collect();
    contacts(&points, &normals)
}

fn with(mut file: Value, key: &str, value: impl Into<Value>) -> Value {
    file[key] = value.into();
    file
}

fn numbers(value: &Value) -> Vec<f64> {
    let numbers = value.as_array().unwrap().iter();
    numbers.map(|number| number.as_f64().unwrap()).collect()
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_column_slice(&numbers(value))
}

fn vectors(values: &Value) -> Vec<Vector3<f64>> {
    values.as_array().unwrap().iter().map(vector).collect()
}

/// All sets of the two files of references.
fn references() -> Vec<Value> {
    let files = [
        include_str!("reference/force_closure.json"),
        include_str!("reference/force_closure_analytic.json"),
    ];
    let mut all = Vec::new();
    for file in files {
        let file: Value = serde_json::from_str(file).unwrap();
        all.extend(file["cases"].as_array().unwrap().iter().cloned());
    }
    assert_eq!(all.len(), 110 + 22);
    all
}

/// A reference set as a file of contacts, with its own centre and length.
fn file_of(case: &Value) -> Value {
    let file = contacts(&vectors(&case["points"]), &vectors(&case["axes"]));
    with(with(file, "centre", vec![0.0; 3]), "length", 1.0)
}

/// Line `name` of a page, without the name.
fn line<'a>(text: &'a str, name: &str) -> &'a str {
    text.lines()
        .find_map(|line| line.strip_prefix(name))
        .expect(name)
        .trim()
}

#[test]
fn the_format_told_is_the_format_read() {
    let desk = Desk::empty();
    let help = desk.print("inspect --help");
    let from = help.find("\n  {\n").unwrap();
    let example = &help[from..];
    let to = example.find("\n  }").unwrap() + "\n  }".len();
    // What is told beside a line is set off by spaces.
    let example: String = example[..to]
        .lines()
        .map(|line| {
            let content = line.trim_start();
            content.split("   ").next().unwrap()
        })
        .collect();
    fs::write(desk.path("c.json"), &example).unwrap();
    let text = desk.print("inspect c.json");
    assert_eq!(line(&text, "contacts  "), "2");
    assert_eq!(line(&text, "centre "), "0, 0, 0.09");
    assert_eq!(line(&text, "length "), "0.1");
    assert_eq!(line(&text, "friction "), "0.5");
}

#[test]
fn reference_sets_through_the_program() {
    let desk = Desk::empty();
    let mut infinite = 0;
    for case in references() {
        let id = case["id"].as_str().unwrap();
        let mut file = file_of(&case);
        let report = desk.report(&file);
        let close = |key: &str, expected: f64, tolerance: f64| {
            let found = report[key].as_f64().unwrap();
            assert!(
                (found - expected).abs() <= tolerance * expected.abs().max(1.0),
                "{id}: {key} = {found}, expected {expected}"
            );
        };
        close("net_wrench", case["gc_norm"].as_f64().unwrap(), 1e-9);
        let Some(least) = case["mu0"].as_f64() else {
            infinite += 1;
            assert!(report["least_friction"].is_null(), "{id}: {report}");
            assert!(report["forces"].is_null(), "{id}: {report}");
            assert_eq!(report["force_closure"], false, "{id}");
            let text = desk.text(&file);
            assert_eq!(line(&text, "least friction"), "inf", "{id}");
            assert_says(&text, &["no forces balance at friction 0.5000"]);
            continue;
        };
        close("least_friction", least, 1e-5);
        // At the least friction itself the forces exist to within round-off only: a hair above.
        file["friction"] = json!(least * 1.001 + 1e-5);
        forces_balance(id, &file, &desk.report(&file));
    }
    assert_eq!(infinite, 10);
}

/// Checks the forces of a report from the file alone.
fn forces_balance(id: &str, file: &Value, report: &Value) {
    let friction = file["friction"].as_f64().unwrap();
    let (centre, length) = (vector(&file["centre"]), file["length"].as_f64().unwrap());
    let found = &report["forces"];
    let forces = vectors(&found["forces"]);
    let contacts = file["contacts"].as_array().unwrap();
    assert_eq!(forces.len(), contacts.len(), "{id}");
    let (mut push, mut torque, mut sum) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for (index, (contact, force)) in contacts.iter().zip(&forces).enumerate() {
        push += force;
        torque += ((vector(&contact["position"]) - centre) / length).cross(force);
        let axis = vector(&contact["inward_normal"]).normalize();
        let normal = axis.dot(force);
        let tangential = (force - axis * normal).norm();
        sum += normal;
        assert!(normal >= -1e-8, "{id}: pulls with {normal:e}");
        let outside = tangential - friction * normal;
        assert!(outside <= 1e-8, "{id}: {outside:e} outside the cone");
        assert!((normal - numbers(&found["normal"])[index]).abs() < 1e-12);
        assert!((tangential - numbers(&found["tangential"])[index]).abs() < 1e-12);
    }
    assert!(
        libm::hypot(push.norm(), torque.norm()) <= 1e-9,
        "{id}: {report}"
    );
    assert!(
        (sum - 1.0).abs() <= 1e-9,
        "{id}: normal forces sum to {sum}"
    );
}

#[test]
fn forces_of_the_table_balance() {
    let desk = Desk::empty();
    let file = on_sphere(&[
        [1.0, 0.2, 0.1],
        [-0.7, 0.8, 0.0],
        [-0.4, -0.9, 0.3],
        [0.1, 0.2, -1.0],
    ]);
    let text = desk.text(&file);
    let table = text.split_once("force x").unwrap().1;
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|row| {
            let cells = row.split_whitespace().filter(|cell| *cell != "%");
            cells.map(|cell| cell.parse().unwrap()).collect()
        })
        .collect();
    assert_eq!(rows.len(), 4);
    // Four decimals are printed.
    for component in 4..7 {
        let sum: f64 = rows.iter().map(|row| row[component]).sum();
        assert!(sum.abs() <= 4.0 * 0.5e-4 + 1e-12, "{text}");
    }
    let normal: f64 = rows.iter().map(|row| row[1]).sum();
    assert!((normal - 1.0).abs() <= 4.0 * 0.5e-4 + 1e-12, "{text}");
    assert!(rows.iter().all(|row| row[3] <= 100.0), "{text}");
}

#[test]
fn positive_zero_and_negative_epsilon() {
    let desk = Desk::empty();
    let height = 0.75_f64.sqrt();
    let round = [[1.0, 0.0, 0.0], [-0.5, height, 0.0], [-0.5, -height, 0.0]];
    let pair = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
    let one_side = [[1.0, 0.1, 0.0], [1.0, -0.1, 0.1], [1.0, 0.0, -0.1]];
    let cases = [
        (&round[..], true, ["yes", "all wrenches are spanned"]),
        // Two points balance, but nothing turns about the line through them.
        (&pair[..], true, ["no", "some wrench is out of reach"]),
        (&one_side[..], false, ["no", "all wrenches are spanned"]),
    ];
    let mut signs = Vec::new();
    for (directions, balance, [closure, rank]) in cases {
        let file = on_sphere(directions);
        let report = desk.report(&file);
        let epsilon = report["epsilon"].as_f64().unwrap();
        signs.push(if epsilon.abs() < 1e-9 {
            0.0
        } else {
            epsilon.signum()
        });
        assert_eq!(report["forces"].is_object(), balance, "{report}");
        assert_eq!(report["force_closure"], closure == "yes", "{report}");
        let text = desk.text(&file);
        assert_eq!(line(&text, "  force closure"), closure);
        assert_says(line(&text, "least eigenvalue of GGᵀ"), &[rank]);
        assert_says(line(&text, "  epsilon"), &[&format!("{epsilon:.4}")]);
    }
    assert_eq!(signs, [1.0, 0.0, -1.0]);
}

/// Other units and another frame give the same result: by default arms are divided by the longest one, and torques are
/// about the mean of the positions.
#[test]
fn units_and_frames_do_not_matter() {
    let desk = Desk::empty();
    let turn = Rotation3::from_euler_angles(0.4, -1.2, 2.0);
    let shift = Vector3::new(-30.0, 500.0, 12.0);
    for case in references().iter().step_by(7) {
        let (points, axes) = (vectors(&case["points"]), vectors(&case["axes"]));
        let here = desk.report(&with(contacts(&points, &axes), "friction", 0.8));
        let points: Vec<_> = points.iter().map(|p| turn * p * 1000.0 + shift).collect();
        let axes: Vec<_> = axes.iter().map(|axis| turn * axis * 7.0).collect();
        let there = desk.report(&with(contacts(&points, &axes), "friction", 0.8));
        let id = &case["id"];
        for key in ["net_wrench", "rank_margin", "least_friction", "epsilon"] {
            match (here[key].as_f64(), there[key].as_f64()) {
                (Some(a), Some(b)) => {
                    let tolerance = if key == "least_friction" { 2e-6 } else { 1e-8 };
                    assert!(
                        (a - b).abs() <= tolerance * a.abs().max(1.0),
                        "{id}: {key} {a}, {b}"
                    );
                }
                (a, b) => assert_eq!(a, b, "{id}: {key}"),
            }
        }
        assert_eq!(here["force_closure"], there["force_closure"], "{id}");
        assert_eq!(here["forces"].is_null(), there["forces"].is_null(), "{id}");
    }
}

const CONTACT: &str = r#"{"position": [1, 0, 0], "inward_normal": [-1, 0, 0]}"#;
const OTHER: &str = r#"{"position": [-1, 0.1, 0], "inward_normal": [1, 0, 0]}"#;

#[test]
fn mistakes_in_contacts() {
    let desk = Desk::empty();
    let two = |rest: &str| format!(r#"{{"contacts": [{CONTACT}, {OTHER}]{rest}}}"#);
    let second = |contact: &str| format!(r#"{{"contacts": [{CONTACT}, {contact}]}}"#);
    let help = "landscape inspect --help";
    let cases: Vec<(String, Vec<&str>)> = vec![
        ("{".into(), vec!["not a list of contacts", help, "line 1"]),
        ("{}".into(), vec!["missing field `contacts`", help]),
        (format!("[{CONTACT}]"), vec!["list", "\"contacts\"", help]),
        (r#"{"contacts": []}"#.into(), vec!["it has no contacts"]),
        (
            format!(r#"{{"contacts": [{}]}}"#, vec![CONTACT; 20_000].join(",")),
            vec!["it has 20000 contacts, but at most 400"],
        ),
        (
            r#"{"contacts": 3}"#.into(),
            vec!["contacts: invalid type: integer `3`"],
        ),
        (
            format!(r#"{{"contacts": [{CONTACT}]}}"#),
            vec!["give a \"length\""],
        ),
        (two("} x"), vec!["trailing characters"]),
        (two(r#", "frction": 1"#), vec!["frction", "`friction`"]),
        (
            two(r#", "friction": 1, "friction": 2"#),
            vec!["duplicate field `friction`"],
        ),
        (
            two(r#", "friction": -1"#),
            vec!["\"friction\" is -1", "from 0 to 1000"],
        ),
        (
            two(r#", "friction": 1e200"#),
            vec!["\"friction\" is 1e200", "from 0 to 1000"],
        ),
        (
            two(r#", "friction": "inf""#),
            vec!["friction: invalid type: string \"inf\""],
        ),
        (
            two(r#", "friction": 1e999"#),
            vec!["friction: number out of range"],
        ),
        (
            two(r#", "friction": NaN"#),
            vec!["friction: expected value"],
        ),
        (two(r#", "length": 0"#), vec!["\"length\" is 0", "positive"]),
        (
            two(r#", "length": -2"#),
            vec!["\"length\" is -2", "positive"],
        ),
        (
            two(r#", "length": 1e-200"#),
            vec!["\"length\" is 1e-200", "same unit"],
        ),
        (
            two(r#", "centre": [0, 0]"#),
            vec!["centre", "array of length 3"],
        ),
        (two(r#", "centre": [1e308, 0, 0]"#), vec!["too far apart"]),
        (
            second(r#"{"position": [1, 0], "inward_normal": [1, 0, 0]}"#),
            vec!["contacts[1].position", "array of length 3", "line 1 column"],
        ),
        (
            second(r#"{"position": [1, 0, "a"], "inward_normal": [1, 0, 0]}"#),
            vec!["contacts[1].position[2]", "string \"a\""],
        ),
        (
            second(r#"{"positon": [1, 0, 0], "inward_normal": [1, 0, 0]}"#),
            vec!["contacts[1]", "positon", "`position`"],
        ),
        (
            second(r#"{"position": [1, 0, 0]}"#),
            vec!["contacts[1]", "missing field `inward_normal`"],
        ),
        (
            second(r#"{"position": [-1, 0, 0], "inward_normal": [0, 0, 0]}"#),
            vec!["contacts[1].inward_normal is zero"],
        ),
    ];
    for (file, words) in cases {
        fs::write(desk.path("c.json"), &file).unwrap();
        let sentence = desk.mistake("inspect c.json");
        assert_says(&sentence, &["c.json"]);
        assert_says(&sentence, &words);
        assert!(!sentence.contains('\n'), "{sentence}");
    }
    fs::write(desk.path("c.json"), two("")).unwrap();
    for flags in ["--each", "--grasp 3", "--hand human", "--object ball"] {
        let sentence = desk.mistake(&format!("inspect c.json {flags}"));
        let flag = flags.split(' ').next().unwrap();
        assert_says(
            &sentence,
            &[flag, "c.json contains bare contacts, not grasps"],
        );
    }
    assert_says(&desk.mistake("inspect absent.json"), &["absent.json"]);
}

/// Only the direction of a normal matters, not its length.
#[test]
fn lengths_of_normals_do_not_matter() {
    let desk = Desk::empty();
    let points = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(-1.0, 0.1, 0.3)];
    let axes = [Vector3::new(-1.0, 0.5, 0.0), Vector3::new(1.0, 0.1, -0.2)];
    let expected = desk.report(&contacts(&points, &axes));
    let factors = [1e-300, 1e300];
    let stretched: Vec<_> = axes.iter().zip(factors).map(|(a, f)| a * f).collect();
    let found = desk.report(&contacts(&points, &stretched));
    for key in ["net_wrench", "least_friction"] {
        let [a, b] = [&expected, &found].map(|report| report[key].as_f64().unwrap());
        assert!((a - b).abs() < 1e-12, "{key}: {a}, {b}");
    }
}

#[test]
fn a_file_of_grasps_in_numbers() {
    let desk = Desk::with_grasps();
    let brief = desk.print("inspect g.parquet -q");
    let lines: Vec<&str> = brief.lines().collect();
    assert!(
        lines[0].starts_with(
            "4 of 5 grasps of the human hand on bottle_round pass the strict filter; the farthest contact is "
        ),
        "{brief}"
    );
    assert_eq!(lines[1], "refused: 1 (a contact too far off 1)");
    assert!(!brief.contains("median"), "{brief}");
    let text = desk.print("inspect g.parquet --verbose");
    assert!(text.starts_with(lines[0]), "{text}");
    assert_says(&text, &["links in contact"]);
    assert_eq!(line(&text, "passes strict"), "4");
    // Only one is far away. The mean comes first.
    let quantiles: Vec<f64> = line(&text, "gap_m")
        .split_whitespace()
        .map(|cell| cell.trim_end_matches(',').parse().unwrap())
        .collect();
    assert!(quantiles[3] <= 0.002 && quantiles[5] > 0.2, "{text}");
}

/// Whatever is right in a file without a checksum stays as it is, to the last bit.
#[test]
fn verified_measures_stay() {
    let (mut file, warnings) = GraspFile::read(data().as_ref(), Overrides::default()).unwrap();
    assert_eq!(warnings, []);
    file.grasps.truncate(8);
    let before = file.clone();
    assert_eq!(file.verify().unwrap(), None);
    assert_eq!(file, before);
}

#[test]
fn grasps_one_by_one() {
    let desk = Desk::with_grasps();
    let (file, _) = GraspFile::read(&desk.path("g.parquet"), Overrides::default()).unwrap();
    let each = desk.print("inspect g.parquet --each -q");
    let rows: Vec<Vec<&str>> = each
        .lines()
        .skip_while(|line| !line.starts_with("id "))
        .skip(1)
        .map(|line| line.split_whitespace().collect())
        .collect();
    assert_eq!(rows.len(), 5, "{each}");
    for (row, grasp) in rows.iter().zip(&file.grasps) {
        assert_eq!(row[0], grasp.id.to_string());
    }
    let verdicts: Vec<bool> = rows.iter().map(|row| row[1] == "passes").collect();
    assert_eq!(verdicts, [true, true, true, true, false], "{each}");

    let [one, far] = [file.grasps[1].id, file.grasps[4].id];
    let text = desk.print(&format!("inspect g.parquet --grasp {one} --grasp {far} -q"));
    let (first, second) = text.split_once(&format!("grasp {far}: human on")).unwrap();
    assert_says(
        first,
        &[&format!("grasp {one}: human on bottle_round"), "contacts"],
    );
    assert!(!first.contains("objection"), "{first}");
    assert_eq!(line(first, "force closure"), "yes");
    assert_says(second, &["objection"]);
    // Shares of the normal force that balances.
    let all: Value = serde_json::from_str(&desk.print("inspect g.parquet --json -q")).unwrap();
    let contacts = all["grasps"][1]["contacts"].as_array().unwrap();
    let sum: f64 = contacts
        .iter()
        .map(|contact| contact["force"].as_f64().unwrap())
        .sum();
    assert!((sum - 1.0).abs() < 5e-4, "{contacts:?}");
}

#[test]
fn grasps_for_machines() {
    let desk = Desk::with_grasps();
    let (file, _) = GraspFile::read(&desk.path("g.parquet"), Overrides::default()).unwrap();
    let all: Value = serde_json::from_str(&desk.print("inspect g.parquet --json -q")).unwrap();
    assert_eq!(all["landscapes"][0]["grasps"], 5);
    assert_eq!(all["landscapes"][0]["passes_strict"], 4);
    let judged = all["grasps"].as_array().unwrap();
    assert_eq!(judged.len(), 5);
    for (found, grasp) in judged.iter().zip(&file.grasps) {
        assert_eq!(found["id"], grasp.id);
        let contacts = found["contacts"].as_array().unwrap();
        assert_eq!(contacts.len(), grasp.grasp.contacts.len());
        for (touch, &index) in contacts.iter().zip(&grasp.grasp.contacts) {
            assert_eq!(touch["surface_point"], index);
            let gap = found["gap_m"].as_f64().unwrap();
            assert!(touch["distance_m"].as_f64().unwrap().abs() <= gap + 1e-12);
        }
        assert_eq!(found["terms"].as_object().unwrap().len(), grasp.terms.len());
    }
    // A link counts only where a contact is near the object. One grasp is far away.
    let links = all["landscapes"][0]["links_in_contact"]
        .as_object()
        .unwrap();
    for (link, count) in links {
        let near = |touch: &&Value| touch["distance_m"].as_f64().unwrap().abs() <= 0.002;
        let has = |grasp: &&Value| {
            let contacts = grasp["contacts"].as_array().unwrap();
            contacts
                .iter()
                .filter(near)
                .any(|touch| touch["link"] == **link)
        };
        assert_eq!(*count, judged.iter().filter(has).count(), "{link}");
    }
    assert!(!links.is_empty());
    // As synthesis judged the same grasps when it wrote the file.
    for (found, grasp) in judged.iter().zip(&file.grasps).take(4) {
        let near = |key: &str, told: f64| (found[key].as_f64().unwrap() - told).abs() < 1e-6;
        assert!(near("net_wrench", grasp.net_wrench), "{found}");
        assert!(near("epsilon", grasp.epsilon.unwrap()), "{found}");
        assert!(near("least_friction", grasp.friction.unwrap()), "{found}");
        assert!(found["objection"].is_null());
    }
    let one = file.grasps[2].id;
    let picked = desk.print(&format!("inspect g.parquet --grasp {one} --json -q"));
    let picked: Value = serde_json::from_str(&picked).unwrap();
    assert_eq!(picked["grasps"], json!([judged[2]]));
}

#[test]
fn mistakes_with_grasps() {
    let desk = Desk::with_grasps();
    assert_eq!(
        desk.mistake("inspect g.parquet --grasp 0 --grasp 99999"),
        "--grasp 99999: g.parquet has no grasp with this id"
    );
    let output = desk.run("inspect g.parquet --each --grasp 0");
    assert_eq!(output.status.code(), Some(2));
    assert_says(
        &String::from_utf8(output.stderr).unwrap(),
        &["--each", "cannot be used with", "--grasp"],
    );
    let whole = fs::read(desk.path("g.parquet")).unwrap();
    fs::write(desk.path("torn.parquet"), &whole[..whole.len() / 2]).unwrap();
    fs::write(desk.path("empty"), "").unwrap();
    fs::write(desk.path("words.txt"), "these are words\n").unwrap();
    for name in ["torn.parquet", "empty", "words.txt"] {
        let sentence = desk.mistake(&format!("inspect {name}"));
        assert_says(&sentence, &[name, "is not a Parquet file or is damaged"]);
    }
}
