//! What the rule says of grasps whose type is known → `figures/taxonomy_confusion.md` and `.png`
//!
//! `cargo run --release --example confusion -- FIXTURES.json … [--shadow EXAMPLES.json --hand HAND.xml] [--noise RAD] [--rule
//! SIGNATURES.toml]`
//!
//! Fixtures are grasps of the human hand: `{"fixtures": [{"type": 9, "joints": {"index_mcp_flexion": 0.7, …}, "object":
//! {"name": "ball", "scale": 1}, "object_from_hand": {"translation_m": [x, y, z], "rotation_wxyz": [w, x, y, z]}}]}`; a type of 0
//! or null is no grasp of the taxonomy. The examples on the Shadow hand (`--shadow`) are poses and contacts without an object, of
//! which the program's own files hold none.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use landscape::figure::{Anchor, Canvas, TextFace, theme};
use landscape::grasp::hand::{Hand, HandFiles, PosedHand};
use landscape::grasp::object::Object;
use landscape::grasp::taxonomy::{
    Anatomy, Category, Label, Labeller, Rule, Taxonomy, Touch, Verdict, label_contacts,
};
use landscape::sample::{Task, stream};
use nalgebra::Vector3;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;

type Failure = Box<dyn std::error::Error>;

/// Noisy copies of each fixture.
const COPIES: u64 = 10;
/// An annotated contact counts as so much area, mm²: certain.
const ANNOTATED_MM2: f64 = 60.0;

#[derive(Deserialize)]
struct Fixtures {
    fixtures: Vec<Fixture>,
}

#[derive(Deserialize)]
struct Fixture {
    /// Number of the type; 0 for none.
    #[serde(rename = "type", default)]
    number: Option<u8>,
    joints: BTreeMap<String, f64>,
    object: Held,
    object_from_hand: Placement,
}

#[derive(Deserialize)]
struct Held {
    name: String,
    #[serde(default = "one")]
    scale: f64,
}

fn one() -> f64 {
    1.0
}

#[derive(Deserialize)]
struct Placement {
    translation_m: [f64; 3],
    rotation_wxyz: [f64; 4],
}

#[derive(Deserialize)]
struct Examples {
    joint_order: Vec<String>,
    templates: Vec<Template>,
}

#[derive(Deserialize)]
struct Template {
    feix_number: u8,
    qpos: Vec<f64>,
    contacts: Vec<Annotated>,
}

#[derive(Deserialize)]
struct Annotated {
    body: String,
    normal_body: [f64; 3],
    point_body: [f64; 3],
}

/// What is true and what the rule says.
struct Outcome {
    /// Number of the type; `None` for what is no grasp of the taxonomy.
    truth: Option<u8>,
    label: Label,
}

/// Outcomes under one condition.
struct Condition {
    name: String,
    outcomes: Vec<Outcome>,
}

fn main() -> Result<(), Failure> {
    let mut fixtures = Vec::new();
    let (mut shadow, mut hand, mut noise) = (None, None, 0.1);
    let mut rule = Rule::standard().clone();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--shadow" => shadow = Some(PathBuf::from(value()?)),
            "--hand" => hand = Some(PathBuf::from(value()?)),
            "--rule" => rule = Rule::parse(&std::fs::read_to_string(value()?)?)?,
            "--noise" => noise = value()?.parse()?,
            _ => fixtures.push(PathBuf::from(&argument)),
        }
    }
    let mut conditions = Vec::new();
    if !fixtures.is_empty() {
        conditions.push(Condition {
            name: "fixtures as posed".to_owned(),
            outcomes: of_fixtures(&fixtures, &rule, 0.0, 1)?,
        });
        conditions.push(Condition {
            name: format!("fixtures, joints ± {noise} rad, {COPIES} times each"),
            outcomes: of_fixtures(&fixtures, &rule, noise, COPIES)?,
        });
    }
    if let Some(examples) = shadow {
        let hand = hand.ok_or("--shadow needs --hand, the model of its hand")?;
        conditions.push(Condition {
            name: "annotated examples on the Shadow hand, no object".to_owned(),
            outcomes: of_examples(&examples, &hand, &rule)?,
        });
    }
    let report = report(&conditions, &rule);
    println!("{report}");
    std::fs::write("figures/taxonomy_confusion.md", &report)?;
    let shown = conditions.get(1).or(conditions.first());
    if let Some(condition) = shown {
        picture(condition).save("figures/taxonomy_confusion.png".as_ref())?;
    }
    Ok(())
}

fn of_fixtures(
    paths: &[PathBuf],
    rule: &Rule,
    noise_rad: f64,
    copies: u64,
) -> Result<Vec<Outcome>, Failure> {
    let hand = Hand::from_files(&HandFiles::named("human")?)?;
    let mut objects: BTreeMap<(String, u64), Object> = BTreeMap::new();
    let mut outcomes = Vec::new();
    for path in paths {
        let file: Fixtures = serde_json::from_str(&std::fs::read_to_string(path)?)?;
        for (index, fixture) in (0u64..).zip(&file.fixtures) {
            let Held { name, scale } = &fixture.object;
            let key = (name.clone(), scale.to_bits());
            if !objects.contains_key(&key) {
                objects.insert(key.clone(), object(name, *scale)?);
            }
            let labeller = Labeller::new(&hand, &objects[&key], rule);
            for copy in 0..copies {
                let mut random = stream(index, Task::Start, copy);
                let mut x = fixture.object_from_hand.translation_m.to_vec();
                x.extend(fixture.object_from_hand.rotation_wxyz);
                for joint in &hand.joints {
                    let angle = fixture.joints.get(&joint.name).copied().unwrap_or(0.0);
                    let step: f64 = StandardNormal.sample(&mut random);
                    let [lower, upper] = joint.limits_rad;
                    x.push((angle + noise_rad * step).clamp(lower, upper));
                }
                outcomes.push(Outcome {
                    truth: fixture.number.filter(|number| *number > 0),
                    label: labeller.label(&x),
                });
            }
        }
    }
    Ok(outcomes)
}

/// An object that comes with the program, at a scale.
fn object(name: &str, scale: f64) -> Result<Object, Failure> {
    let object = Object::named(name)?;
    let mesh = object.mesh.scaled(name, scale)?;
    Ok(Object::from_mesh(
        name,
        mesh,
        &object.description.scaled(scale),
    )?)
}

fn of_examples(path: &Path, hand: &Path, rule: &Rule) -> Result<Vec<Outcome>, Failure> {
    let examples: Examples = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let hand = Hand::from_files(&HandFiles::load(hand)?)?;
    let anatomy = Anatomy::of(&hand).ok_or("this hand is not read as a human one")?;
    let mut outcomes = Vec::new();
    for template in &examples.templates {
        let mut x = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        for joint in &hand.joints {
            let place = examples
                .joint_order
                .iter()
                .position(|name| *name == joint.name);
            x.push(template.qpos[place.ok_or(format!("no angle of {}", joint.name))?]);
        }
        let mut posed = PosedHand::default();
        hand.pose(&x, &mut posed);
        let touch = |contact: &Annotated| {
            let link = hand.link(&contact.body)?;
            let frame = &posed.object_from_link[link.0];
            let normal = Vector3::from(contact.normal_body);
            Some(Touch {
                patch: anatomy.patch_on(&hand, link, &normal)?,
                point: frame.point(&Vector3::from(contact.point_body)),
                normal: frame.direction(&normal),
                weight_mm2: ANNOTATED_MM2,
            })
        };
        let touches: Option<Vec<Touch>> = template.contacts.iter().map(touch).collect();
        let touches = touches.ok_or("a contact is on no link of this hand")?;
        if std::env::var_os("EXPLAIN").is_some() {
            println!("== {}", template.feix_number);
            for touch in &touches {
                println!("   {:?}", touch.patch);
            }
        }
        outcomes.push(Outcome {
            truth: Some(template.feix_number),
            label: label_contacts(rule, &anatomy, &posed, &touches, None),
        });
    }
    Ok(outcomes)
}

/// The type that the rule holds best, whatever the thresholds.
fn best(label: &Label) -> Option<u8> {
    label.best.first().map(|best| best.number)
}

fn report(conditions: &[Condition], rule: &Rule) -> String {
    let feix = Taxonomy::feix();
    let mut text = format!(
        "# Labels of grasps whose type is known\n\n`cargo run --release --example confusion`, rule {}.\n\
         Right: the best type is of the true category, cell, type, whatever its score; *accepted*: not unlisted.\n\n\
         | grasps | count | category | opposition | cell | type | type among best three | accepted | ambiguous | others accepted |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
        rule.version
    );
    for condition in conditions {
        let known: Vec<&Outcome> = condition
            .outcomes
            .iter()
            .filter(|outcome| outcome.truth.is_some())
            .collect();
        let others: Vec<&Outcome> = condition
            .outcomes
            .iter()
            .filter(|outcome| outcome.truth.is_none())
            .collect();
        let share = |of: &[&Outcome], test: &dyn Fn(&Outcome) -> bool| {
            let right = of.iter().filter(|outcome| test(outcome)).count();
            if of.is_empty() {
                "–".to_owned()
            } else {
                format!("{:.3} ({right})", right as f64 / of.len() as f64)
            }
        };
        let alike = |within: u8| {
            move |outcome: &Outcome| {
                let entry = |number: Option<u8>| feix.numbered(number?);
                let pair = entry(outcome.truth).zip(entry(best(&outcome.label)));
                pair.is_some_and(|(truth, found)| truth.distance(found) <= within)
            }
        };
        let accepted = |outcome: &Outcome| {
            matches!(
                outcome.label.verdict,
                Verdict::Listed(_) | Verdict::Ambiguous(_)
            )
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            condition.name,
            known.len(),
            share(&known, &alike(3)),
            share(&known, &alike(2)),
            share(&known, &alike(1)),
            share(&known, &alike(0)),
            share(&known, &|outcome| {
                outcome
                    .label
                    .best
                    .iter()
                    .any(|best| Some(best.number) == outcome.truth)
            }),
            share(&known, &accepted),
            share(&known, &|outcome| matches!(
                outcome.label.verdict,
                Verdict::Ambiguous(_)
            )),
            share(&others, &accepted),
        );
    }
    for condition in conditions {
        let _ = writeln!(text, "\n## {}\n", condition.name);
        text += &categories(condition);
        text.push('\n');
        text += &types(condition);
    }
    text
}

/// What each type is taken for.
fn types(condition: &Condition) -> String {
    let feix = Taxonomy::feix();
    let mut text = "| type | grasps | right | taken for |\n|---|---|---|---|\n".to_owned();
    for entry in &feix.types {
        let of_type: Vec<&Outcome> = (condition.outcomes.iter())
            .filter(|outcome| outcome.truth == Some(entry.number))
            .collect();
        if of_type.is_empty() {
            continue;
        }
        let mut taken: BTreeMap<u8, usize> = BTreeMap::new();
        for outcome in &of_type {
            *taken.entry(best(&outcome.label).unwrap_or(0)).or_default() += 1;
        }
        let right = taken.remove(&entry.number).unwrap_or(0);
        let mut taken: Vec<(u8, usize)> = taken.into_iter().collect();
        taken.sort_by_key(|(number, count)| (usize::MAX - count, *number));
        let spell = |(number, count): &(u8, usize)| {
            let name = feix
                .numbered(*number)
                .map_or("nothing", |entry| &entry.name);
            format!("{name} {count}")
        };
        let taken: Vec<String> = taken.iter().map(spell).collect();
        let _ = writeln!(
            text,
            "| {} {} | {} | {right} | {} |",
            entry.number,
            entry.name,
            of_type.len(),
            taken.join(", ")
        );
    }
    text
}

/// Confusion of categories as a table.
fn categories(condition: &Condition) -> String {
    let feix = Taxonomy::feix();
    let all = [Category::Power, Category::Intermediate, Category::Precision];
    let mut text =
        "| true \\ found | power | intermediate | precision |\n|---|---|---|---|\n".to_owned();
    for truth in all {
        let count = |found: Category| {
            let category = |number: Option<u8>| Some(feix.numbered(number?)?.category);
            condition
                .outcomes
                .iter()
                .filter(|outcome| category(outcome.truth) == Some(truth))
                .filter(|outcome| category(best(&outcome.label)) == Some(found))
                .count()
        };
        let [a, b, c] = all.map(count);
        let _ = writeln!(text, "| {} | {a} | {b} | {c} |", truth.name());
    }
    text
}

/// The matrix of types: rows are true, columns found, cells the share of the row.
fn picture(condition: &Condition) -> Canvas {
    const CELL: f64 = 30.0;
    const LEFT: f64 = 330.0;
    const TOP: f64 = 160.0;
    /// 33 cells, the margins above and 30 units beyond.
    const SIZE: [u32; 2] = [1350, 1180];
    let feix = Taxonomy::feix();
    let mut canvas = Canvas::new(SIZE[0], SIZE[1]).with_pixels_per_unit(1);
    let name = |place: usize| format!("{} {}", feix.types[place].number, feix.types[place].name);
    let face = TextFace::new(19.0, theme::INK);
    for row in 0..feix.types.len() {
        let y = TOP + CELL * (row as f64 + 0.5);
        let x = LEFT + CELL * (row as f64 + 0.5);
        canvas.text([LEFT - 8.0, y], &name(row), face.anchored(Anchor::End));
        canvas.text(
            [x, TOP - 14.0],
            &feix.types[row].number.to_string(),
            face.anchored(Anchor::Middle),
        );
        let of_row: Vec<&Outcome> = (condition.outcomes.iter())
            .filter(|outcome| outcome.truth == Some(feix.types[row].number))
            .collect();
        for column in 0..feix.types.len() {
            let found = of_row
                .iter()
                .filter(|outcome| best(&outcome.label) == Some(feix.types[column].number))
                .count();
            let share = found as f64 / of_row.len().max(1) as f64;
            let corner = [LEFT + CELL * column as f64, TOP + CELL * row as f64];
            let far = [corner[0] + CELL - 1.0, corner[1] + CELL - 1.0];
            let fill = if found == 0 {
                theme::FAINT
            } else {
                theme::sequential(1.0 - share)
            };
            canvas.rectangle(corner, far, fill);
        }
    }
    let title = TextFace::new(24.0, theme::INK);
    canvas.text(
        [theme::MARGIN, 40.0],
        &format!(
            "Type found (column) for type given (row): {}",
            condition.name
        ),
        title,
    );
    canvas.text([theme::MARGIN, 80.0], "Share of the row:", face);
    for step in 0..=10u32 {
        let share = f64::from(step) / 10.0;
        let x = LEFT - 110.0 + 40.0 * f64::from(step);
        let fill = if step == 0 {
            theme::FAINT
        } else {
            theme::sequential(1.0 - share)
        };
        canvas.rectangle([x, 66.0], [x + 39.0, 94.0], fill);
        canvas.text(
            [x + 20.0, 112.0],
            &format!("{share:.1}"),
            face.anchored(Anchor::Middle),
        );
    }
    canvas
}
