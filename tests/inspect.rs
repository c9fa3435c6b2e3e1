//! `landscape inspect` as a user runs it: bare contacts compared with references, files of grasps, and the messages of all
//! mistakes.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use crate::desk::{Desk, assert_says};
use crate::table::rows;
use landscape::store::{GraspFile, Overrides};
use nalgebra::{Rotation3, Vector3};
use serde_json::{Value, json};

impl Desk {
    /// The output of `inspect` for the bare contacts of a file.
    fn shown(&self, file: &Value) -> String {
        self.write("c.json", file.to_string());
        self.print("inspect c.json")
    }

    /// The same output as JSON.
    fn report(&self, file: &Value) -> Value {
        self.write("c.json", file.to_string());
        self.document("inspect c.json --json")
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
    desk.write("c.json", &example);
    let text = desk.print("inspect c.json");
    assert_eq!(line(&text, "contacts  "), "2");
    assert_eq!(line(&text, "centre "), "0, 0, 0.09");
    assert_eq!(line(&text, "arms divided by"), "0.1");
    assert_eq!(line(&text, "friction "), "0.5");
}

#[test]
fn positive_zero_and_negative_epsilon() {
    let desk = Desk::empty();
    let height = 0.75_f64.sqrt();
    let round = [[1.0, 0.0, 0.0], [-0.5, height, 0.0], [-0.5, -height, 0.0]];
    let pair = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
    let one_side = [[1.0, 0.1, 0.0], [1.0, -0.1, 0.1], [1.0, 0.0, -0.1]];
    let cases = [
        (&round[..], true, "yes"),
        // Two points balance, but nothing turns about the line through them.
        (&pair[..], true, "no"),
        (&one_side[..], false, "no"),
    ];
    let mut signs = Vec::new();
    for (directions, balance, closure) in cases {
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
        let text = desk.shown(&file);
        assert_eq!(line(&text, "force closure"), closure);
    }
    assert_eq!(signs, [1.0, 0.0, -1.0]);
}

/// Other units, another frame and the lengths of normals do not matter: by default arms are divided by the longest one, and
/// torques are about the mean of the positions.
#[test]
fn units_and_frames_do_not_matter() {
    let desk = Desk::empty();
    let turn = Rotation3::from_euler_angles(0.4, -1.2, 2.0);
    let shift = Vector3::new(-30.0, 500.0, 12.0);
    let points = [
        [1.0, 0.2, 0.1],
        [-0.7, 0.8, 0.0],
        [-0.4, -0.9, 0.3],
        [0.1, 0.2, -1.0],
    ];
    let points = points.map(|point| Vector3::from(point).normalize());
    let axes = points.map(|point| -point);
    let here = desk.report(&contacts(&points, &axes));
    let points = points.map(|p| turn * p * 1000.0 + shift);
    let axes = axes.map(|axis| turn * axis * 1e200);
    let there = desk.report(&contacts(&points, &axes));
    for key in ["net_wrench", "rank_margin", "least_friction", "epsilon"] {
        let [a, b] = [&here, &there].map(|report| report[key].as_f64().unwrap());
        assert!((a - b).abs() <= 2e-6 * a.abs().max(1.0), "{key} {a}, {b}");
    }
    assert_eq!(here["force_closure"], there["force_closure"]);
}

const CONTACT: &str = r#"{"position": [1, 0, 0], "inward_normal": [-1, 0, 0]}"#;
const OTHER: &str = r#"{"position": [-1, 0.1, 0], "inward_normal": [1, 0, 0]}"#;

#[test]
fn mistakes_in_contacts() {
    let desk = Desk::empty();
    let filled = |text: &str| text.replace("CONTACT", CONTACT).replace("OTHER", OTHER);
    let cases = r#"
        { | not a list of contacts | {help} | line 1
        {} | missing field `contacts` | {help}
        [CONTACT] | list | "contacts" | {help}
        {"contacts": []} | it has no contacts
        {"contacts": 3} | contacts: invalid type: integer `3`
        {"contacts": [CONTACT]} | give a "length"
        {"contacts": [CONTACT, OTHER]} x} | trailing characters
        {"contacts": [CONTACT, OTHER], "frction": 1} | frction | `friction`
        {"contacts": [CONTACT, OTHER], "friction": 1, "friction": 2} | duplicate field `friction`
        {"contacts": [CONTACT, OTHER], "friction": -1} | "friction" is -1 | from 0 to 1000
        {"contacts": [CONTACT, OTHER], "friction": 1e200} | "friction" is 1e200 | from 0 to 1000
        {"contacts": [CONTACT, OTHER], "friction": "inf"} | friction: invalid type: string "inf"
        {"contacts": [CONTACT, OTHER], "friction": 1e999} | friction: number out of range
        {"contacts": [CONTACT, OTHER], "friction": NaN} | friction: expected value
        {"contacts": [CONTACT, OTHER], "length": 0} | "length" is 0 | positive
        {"contacts": [CONTACT, OTHER], "length": -2} | "length" is -2 | positive
        {"contacts": [CONTACT, OTHER], "length": 1e-200} | "length" is 1e-200 | same unit
        {"contacts": [CONTACT, OTHER], "centre": [0, 0]} | centre | array of length 3
        {"contacts": [CONTACT, OTHER], "centre": [1e308, 0, 0]} | too far apart
        {"contacts": [CONTACT, {"position": [1, 0], "inward_normal": [1, 0, 0]}]} | contacts[1].position | array of length 3 | line 1 column
        {"contacts": [CONTACT, {"position": [1, 0, "a"], "inward_normal": [1, 0, 0]}]} | contacts[1].position[2] | string "a"
        {"contacts": [CONTACT, {"positon": [1, 0, 0], "inward_normal": [1, 0, 0]}]} | contacts[1] | positon | `position`
        {"contacts": [CONTACT, {"position": [1, 0, 0]}]} | contacts[1] | missing field `inward_normal`
        {"contacts": [CONTACT, {"position": [-1, 0, 0], "inward_normal": [0, 0, 0]}]} | contacts[1].inward_normal is zero
    "#;
    for case in rows(cases) {
        desk.write("c.json", filled(case[0]));
        let sentence = desk.mistake("inspect c.json");
        assert_says(&sentence, &["c.json"]);
        let words = case[1..]
            .iter()
            .map(|word| word.replace("{help}", "landscape inspect --help"));
        for word in words {
            assert_says(&sentence, &[&word]);
        }
        assert!(!sentence.contains('\n'), "{sentence}");
    }
    let many = format!(r#"{{"contacts": [{}]}}"#, vec![CONTACT; 20_000].join(","));
    desk.write("c.json", many);
    let sentence = desk.mistake("inspect c.json");
    assert_says(&sentence, &["it has 20000 contacts, but at most 400"]);
    let two = filled(r#"{"contacts": [CONTACT, OTHER]}"#);
    desk.write("c.json", two);
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
    assert_eq!(line(&text, "passes the strict filter"), "4");
    // Only one is far away. The mean comes first.
    let quantiles: Vec<f64> = line(&text, "gap (mm)")
        .split_whitespace()
        .map(|cell| cell.parse().unwrap())
        .collect();
    assert!(quantiles[3] <= 2.0 && quantiles[5] > 200.0, "{text}");
}

#[test]
fn grasps_one_by_one() {
    let desk = Desk::with_grasps();
    let file = desk.grasps("g.parquet");
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
    let file = desk.grasps("g.parquet");
    let all = desk.document("inspect g.parquet --json -q");
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
    let whole = desk.bytes("g.parquet");
    desk.write("torn.parquet", &whole[..whole.len() / 2]);
    desk.write("empty", "");
    desk.write("words.txt", "these are words\n");
    for name in ["torn.parquet", "empty", "words.txt"] {
        let sentence = desk.mistake(&format!("inspect {name}"));
        assert_says(&sentence, &[name, "is not a Parquet file or is damaged"]);
    }
}
