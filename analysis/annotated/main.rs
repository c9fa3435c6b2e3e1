//! Labels of the rule for grasps that people posed and named → `figures/annotated_grasps.md`, `.png` and `.csv`
//!
//! `LANDSCAPE_TEST_DATA=FOLDER cargo run --release --example annotated -- [--looked-at] [--rule RULE.toml]
//! [--explain ID …] [--output STEM]`
//!
//! The folder holds `ycb_affordance` (grasps, objects and the hand), `taxonomy` (templates of the types) and
//! `hands/shadow_dexonomy` (the hand of the templates). None of this is part of the project, and no number of the rule is
//! fitted to it. One third of the objects was not looked at before the rule was final (`people.rs`); `--looked-at` leaves it
//! out, and with it the targets and what limits the rule.

mod case;
mod contact;
mod disagreements;
mod limits;
mod pairs;
mod people;
mod picture;
mod reliability;
mod report;
mod targets;
mod templates;

use std::path::{Path, PathBuf};

use case::Case;
use landscape::evaluation::taxonomy::{Rule, explain};
use people::UNSEEN;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Cases of one origin.
struct Set {
    name: String,
    short: &'static str,
    posed_by_people: bool,
    cases: Vec<Case>,
}

fn main() -> Result<(), Failure> {
    let mut looked_at = false;
    let mut explained: Vec<String> = Vec::new();
    let mut rule = Rule::standard().clone();
    let mut output = PathBuf::from("figures/annotated_grasps");
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--looked-at" => looked_at = true,
            "--rule" => rule = Rule::parse(&std::fs::read_to_string(value()?)?)?,
            "--explain" => explained.push(value()?),
            "--output" => output = PathBuf::from(value()?),
            _ => return Err(format!("{argument} is not known").into()),
        }
    }
    let data = std::env::var_os("LANDSCAPE_TEST_DATA").ok_or("LANDSCAPE_TEST_DATA is not set")?;
    let sets = sets(Path::new(&data), &rule, !looked_at)?;
    for case in sets.iter().flat_map(|set| &set.cases) {
        if explained.iter().any(|id| *id == case.id || id == "all") {
            println!(
                "== {} {}: {}\n{}",
                case.id,
                case.object,
                case.truth.name,
                explain(&case.label, &rule)
            );
        }
    }
    let (text, types) = report::report(&sets, !looked_at, &rule.version)?;
    std::fs::write(output.with_extension("md"), text)?;
    std::fs::write(output.with_extension("csv"), types)?;
    picture::picture(&sets).save(&output.with_extension("png"))?;
    let people = Path::new(&data).join("ycb_affordance");
    let stem = output.with_file_name("annotated_disagreements");
    disagreements::write(&sets[0].cases, &people, &stem, &rule.version)
}

fn sets(data: &Path, rule: &Rule, whole: bool) -> Result<Vec<Set>, Failure> {
    let people = data.join("ycb_affordance");
    let unseen = |object: &str| UNSEEN.contains(&object);
    let mut sets = vec![Set {
        name: "People's grasps, objects that were looked at".to_owned(),
        short: "seen",
        posed_by_people: true,
        cases: people::cases(&people, rule, |object| !unseen(object))?,
    }];
    if whole {
        sets.push(Set {
            name: "People's grasps, objects that were not looked at".to_owned(),
            short: "unseen",
            posed_by_people: true,
            cases: people::cases(&people, rule, unseen)?,
        });
    }
    sets.push(Set {
        name: "Templates on the Shadow hand, without an object".to_owned(),
        short: "templates",
        posed_by_people: false,
        cases: templates::cases(
            &data.join("taxonomy/dexonomy_shadow_examples.json"),
            &data.join("hands/shadow_dexonomy/shadow_right.xml"),
            rule,
        )?,
    });
    Ok(sets)
}
