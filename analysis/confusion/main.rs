//! Labels of the rule for grasps of known type → `figures/taxonomy_confusion.md`, `.png` and `.csv`
//!
//! `cargo run --release --example confusion [-- --explain]`. The fixtures are those of `tests/taxonomy/fixtures`. The rule was
//! checked on the first two files while it was written; `second_held_out` must not be used to choose a rule. `--explain` also
//! prints the reasons for each fixture with a wrong type.

#[path = "../../tests/taxonomy/fixture.rs"]
mod fixture;
mod judge;
mod picture;
mod report;

use judge::{Error, Noise, Outcome};
use landscape::evaluation::taxonomy::{Rule, explain};

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Outcomes under one condition.
struct Condition {
    name: String,
    outcomes: Vec<Outcome>,
}

/// Files of fixtures.
const SETS: [&str; 3] = ["development", "held_out", "second_held_out"];
/// Errors of the joints.
const JOINTS_RAD: f64 = 0.1;
const COPIES: u64 = 3;

fn main() -> Result<(), Failure> {
    let explained = std::env::args().any(|argument| argument == "--explain");
    let rule = Rule::standard();
    let mut conditions = Vec::new();
    for set in SETS {
        let path = format!("tests/taxonomy/fixtures/{set}.json");
        let cases = judge::cases(judge::read(path.as_ref())?)?;
        let name = set.replace('_', " ");
        conditions.push(Condition {
            name: format!("{name}, as posed"),
            outcomes: judge::judge(&cases, rule, Noise::NONE)?,
        });
        for (error, word) in [(Error::Moved, "moved"), (Error::Misread, "misread")] {
            let noise = Noise {
                error,
                joints_rad: JOINTS_RAD,
                copies: COPIES,
                seed: 0,
            };
            conditions.push(Condition {
                name: format!("{name}, joints {word} by {JOINTS_RAD} rad, {COPIES} times each"),
                outcomes: judge::judge(&cases, rule, noise)?,
            });
        }
    }
    if explained {
        for outcome in conditions.iter().flat_map(|condition| &condition.outcomes) {
            if outcome.found() != outcome.truth {
                println!("== {}\n{}", outcome.id, explain(&outcome.label, rule));
            }
        }
    }
    // The last set of fixtures, as posed and in the hardest condition.
    let shown = &conditions[conditions.len() - 3..conditions.len() - 1];
    let [text, csv] = report::report(&conditions, shown, rule);
    std::fs::write("figures/taxonomy_confusion.md", text)?;
    std::fs::write("figures/taxonomy_confusion.csv", csv)?;
    picture::picture(&shown[1]).save("figures/taxonomy_confusion.png".as_ref())?;
    Ok(())
}
