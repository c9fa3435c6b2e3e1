//! Labels of the rule for grasps of known type → `figures/taxonomy_confusion.md`, `.png` and `.csv`
//!
//! `cargo run --release --example confusion -- [--fixtures SET …] [--noise RAD] [--copies
//! N] [--seed N] [--rule RULE.toml] [--explain] [--output STEM]`
//!
//! The fixtures are those of `tests/taxonomy/fixtures`: SET is `development`, `held_out` or `second_held_out` (by default all
//! three), `widened` or `widened_held_out`. The rule was checked on the first two files while
//! it was written; `second_held_out` must not be used to choose a rule. `--explain` also prints the reasons for each fixture
//! with a wrong type.

#[path = "../../tests/taxonomy/fixture.rs"]
mod fixture;
mod judge;
mod picture;
mod report;
#[expect(
    dead_code,
    reason = "what only `pose_fixtures` calls makes widened fixtures"
)]
mod widened;

use std::path::PathBuf;

use judge::{Error, Noise, Outcome};
use landscape::evaluation::taxonomy::{Rule, explain};

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Outcomes under one condition.
struct Condition {
    name: String,
    outcomes: Vec<Outcome>,
}

fn main() -> Result<(), Failure> {
    let mut sets = Vec::new();
    let (mut explained, mut output) = (false, PathBuf::from("figures/taxonomy_confusion"));
    let mut noise = Noise {
        error: Error::Moved,
        joints_rad: 0.1,
        copies: 10,
        seed: 0,
    };
    let mut rule = Rule::standard().clone();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--fixtures" => sets.push(value()?),
            "--rule" => rule = Rule::parse(&std::fs::read_to_string(value()?)?)?,
            "--noise" => noise.joints_rad = value()?.parse()?,
            "--copies" => noise.copies = value()?.parse()?,
            "--seed" => noise.seed = value()?.parse()?,
            "--output" => output = PathBuf::from(value()?),
            "--explain" => explained = true,
            _ => return Err(format!("{argument} is not known").into()),
        }
    }
    if sets.is_empty() {
        sets.extend(["development", "held_out", "second_held_out"].map(str::to_owned));
    }
    let mut conditions = Vec::new();
    for set in &sets {
        let path = |name: &str| PathBuf::from(format!("tests/taxonomy/fixtures/{name}.json"));
        let authored = |names: &[&str]| -> Result<Vec<fixture::Fixture>, Failure> {
            let all = names.iter().map(|name| judge::read(&path(name)));
            Ok(all.collect::<Result<Vec<_>, _>>()?.concat())
        };
        let cases = match set.as_str() {
            "widened" => judge::widened_cases(&path(set), authored(&["development", "held_out"])?)?,
            "widened_held_out" => {
                judge::widened_cases(&path(set), authored(&["second_held_out"])?)?
            }
            _ => judge::cases(authored(&[set])?)?,
        };
        let name = set.replace('_', " ");
        conditions.push(Condition {
            name: format!("{name}, as posed"),
            outcomes: judge::judge(&cases, &rule, Noise::NONE)?,
        });
        for (error, word) in [(Error::Moved, "moved"), (Error::Misread, "misread")] {
            conditions.push(Condition {
                name: format!(
                    "{name}, joints {word} by {} rad, {} times each",
                    noise.joints_rad, noise.copies
                ),
                outcomes: judge::judge(&cases, &rule, Noise { error, ..noise })?,
            });
        }
    }
    if explained {
        for outcome in conditions.iter().flat_map(|condition| &condition.outcomes) {
            if outcome.found() != outcome.truth {
                println!("== {}\n{}", outcome.id, explain(&outcome.label, &rule));
            }
        }
    }
    // The last set of fixtures, as posed and in the hardest condition.
    let shown = &conditions[conditions.len() - 3..conditions.len() - 1];
    let [text, csv] = report::report(&conditions, shown, &rule);
    std::fs::write(output.with_extension("md"), text)?;
    std::fs::write(output.with_extension("csv"), csv)?;
    picture::picture(&shown[1]).save(&output.with_extension("png"))?;
    Ok(())
}
