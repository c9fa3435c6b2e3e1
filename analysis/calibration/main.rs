//! Whether the probabilities of the rule mean what they say → `figures/calibration.md` and `.png`
//!
//! `LANDSCAPE_TEST_DATA=FOLDER cargo run --release --example calibration -- [--rule RULE.toml] [--output STEM]`
//!
//! Which exponent of the fits (`sharpness` of the rule) suits widened fixtures with errors best is told by the loss −ln of the
//! probability that the answer is right or wrong as it is. The reliability is then measured on fixtures that took no part.
//! Only objects of one solid are used, and for the choice every third of these, because the others take hours.
//! FOLDER holds the Shadow hand; without it the fixtures on that hand are left out.

#[path = "../../tests/taxonomy/fixture.rs"]
mod fixture;
#[expect(dead_code, reason = "tests need shares")]
#[path = "../../tests/taxonomy/judge.rs"]
mod judge;
#[path = "../reliability.rs"]
mod reliability;
#[expect(
    dead_code,
    reason = "what only `pose_fixtures` calls makes widened fixtures"
)]
#[path = "../../tests/taxonomy/widened.rs"]
mod widened;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use fixture::Fixture;
use judge::{Case, Error, Noise, Outcome, judge_each, read, widened_cases};
use landscape::evaluation::taxonomy::{Rule, Taxonomy};
use landscape::figure::chart::{Axis, Chart, Corner, Panel, Series};
use reliability::{Answered, Bin, calibration_error, reliability, table};

type Failure = Box<dyn std::error::Error + Send + Sync>;

const FOLDER: &str = "tests/taxonomy/fixtures";
/// Exponents that are tried.
const TRIED: [f64; 8] = [0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0, 3.0];
const SEED: u64 = 5;
/// Every so many fixtures are used for the choice.
const EVERY: usize = 3;

/// What an answer is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Level {
    Type,
    Cell,
    Category,
}

impl Level {
    const ALL: [Self; 3] = [Self::Type, Self::Cell, Self::Category];

    fn name(self) -> &'static str {
        match self {
            Self::Type => "type",
            Self::Cell => "cell",
            Self::Category => "category",
        }
    }

    /// The probability of the answer, and whether it is right.
    fn answered(self, outcome: &Outcome) -> Option<Answered> {
        let label = &outcome.label;
        let best = label.best.first()?;
        let truth = Taxonomy::feix().numbered(outcome.truth?)?;
        let found = Taxonomy::feix().numbered(best.number)?;
        Some(match self {
            Self::Type => (best.score, truth.number == found.number),
            Self::Cell => (label.cell_probability, truth.cell == found.cell),
            Self::Category => {
                let own = label
                    .categories
                    .iter()
                    .find(|(kind, _)| *kind == found.category);
                (
                    own.map_or(0.0, |(_, p)| *p),
                    truth.category == found.category,
                )
            }
        })
    }
}

/// Outcomes under one condition.
struct Condition {
    name: &'static str,
    outcomes: Vec<Outcome>,
}

/// No errors, errors of the joints, and errors of the hand's place like those of people who pose by eye.
fn conditions() -> [(&'static str, Noise); 3] {
    let of = |joints_rad, place_m, copies| Noise {
        error: Error::Moved,
        joints_rad,
        place_m,
        copies,
        seed: SEED,
    };
    [
        ("as posed", of(0.0, 0.0, 1)),
        ("joints moved by 0.1 rad", of(0.1, 0.0, 1)),
        (
            "hand moved by 3 mm along each axis, joints by 0.05 rad",
            of(0.05, 0.003, 1),
        ),
    ]
}

/// The outcomes under all conditions, for each exponent.
fn outcomes(
    cases: &[Case],
    rule: &Rule,
    sharpness: &[f64],
) -> Result<Vec<Vec<Condition>>, Failure> {
    let mut all: Vec<Vec<Condition>> = sharpness.iter().map(|_| Vec::new()).collect();
    for (name, noise) in conditions() {
        let found = judge_each(cases, rule, noise, sharpness)?;
        for (own, outcomes) in all.iter_mut().zip(found) {
            own.push(Condition { name, outcomes });
        }
    }
    Ok(all)
}

/// Mean loss −ln p(right) or −ln (1 − p) of the answers' types.
fn loss(conditions: &[Condition]) -> f64 {
    let all = conditions.iter().flat_map(|condition| &condition.outcomes);
    let losses = all.filter_map(|outcome| {
        let (score, right) = Level::Type.answered(outcome)?;
        let told = if right { score } else { 1.0 - score };
        Some(-libm::log(told.max(1e-6)))
    });
    let losses: Vec<f64> = losses.collect();
    losses.iter().sum::<f64>() / losses.len() as f64
}

fn fixtures(names: &[&str]) -> Result<Vec<Fixture>, Failure> {
    let mut all = Vec::new();
    for name in names {
        all.extend(read(Path::new(&format!("{FOLDER}/{name}.json")))?);
    }
    // Objects of one solid need no field, which would take minutes.
    all.retain(|fixture| fixture.object.len() == 1);
    Ok(all)
}

fn main() -> Result<(), Failure> {
    let mut rule = Rule::standard().clone();
    let mut output = PathBuf::from("figures/calibration");
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--rule" => rule = Rule::parse(&std::fs::read_to_string(value()?)?)?,
            "--output" => output = PathBuf::from(value()?),
            _ => return Err(format!("{argument} is not known").into()),
        }
    }
    let widened = |file: &str, names: &[&str]| {
        widened_cases(
            Path::new(&format!("{FOLDER}/{file}.json")),
            fixtures(names)?,
        )
    };
    let mut place = 0;
    let mut fitted = widened("widened", &["development", "held_out"])?;
    fitted.retain(|_| {
        place += 1;
        place % EVERY == 0
    });
    let unseen = widened("widened_held_out", &["second_held_out"])?;
    let mut text = format!(
        "# Whether the rule's probabilities mean what they say\n\n`LANDSCAPE_TEST_DATA=… cargo run --release --example \
         calibration`, rule {}.\n\n## The exponent of the fits\n\nOn {} widened fixtures, under all conditions below. The rule \
         has {}.\n\n| exponent | loss of the type's probability | calibration error, type | cell | category |\n|---|---|---|---|---|\n",
        rule.version,
        fitted.len(),
        rule.sharpness
    );
    for (sharpness, found) in TRIED.iter().zip(outcomes(&fitted, &rule, &TRIED)?) {
        let errors = Level::ALL.map(|level| {
            let all = found.iter().flat_map(|condition| &condition.outcomes);
            calibration_error(&reliability(
                all.filter_map(|outcome| level.answered(outcome)),
            ))
        });
        let _ = writeln!(
            text,
            "| {sharpness} | {:.4} | {:.3} | {:.3} | {:.3} |",
            loss(&found),
            errors[0],
            errors[1],
            errors[2]
        );
    }
    let judged = outcomes(&unseen, &rule, &[rule.sharpness])?.remove(0);
    let _ = write!(
        text,
        "\n## On fixtures that took no part\n\n{} widened fixtures of the second authored set: other scenes, sizes, forms, and \
         hands. *Calibration error*: the mean difference between the probability and the share that is right, over five bins.\n\n\
         | condition | answers | right: category, cell, type | calibration error: category, cell, type | unlisted | others \
         accepted |\n|---|---|---|---|---|---|\n",
        unseen.len()
    );
    for condition in &judged {
        text += &row(condition);
    }
    for level in Level::ALL {
        let all = judged.iter().flat_map(|condition| &condition.outcomes);
        let bins = reliability(all.filter_map(|outcome| level.answered(outcome)));
        let _ = write!(
            text,
            "\nReliability of the {}, all conditions, calibration error {:.3}:\n\n{}",
            level.name(),
            calibration_error(&bins),
            table("probability", "answers", &bins)
        );
    }
    println!("{text}");
    let draft = output.with_extension("md.new");
    std::fs::write(&draft, &text)?;
    std::fs::rename(draft, output.with_extension("md"))?;
    let curves: Vec<(&str, Vec<Bin>)> = Level::ALL
        .into_iter()
        .map(|level| {
            let all = judged.iter().flat_map(|condition| &condition.outcomes);
            let answers = all.filter_map(|outcome| level.answered(outcome));
            (level.name(), reliability(answers).to_vec())
        })
        .collect();
    picture(&curves)
        .draw()?
        .save(&output.with_extension("png"))?;
    Ok(())
}

/// Share of right answers against their probability. A calibrated rule follows the dashed diagonal.
fn picture(curves: &[(&str, Vec<Bin>)]) -> Chart {
    let mut series = vec![
        Series::line(vec![[0.0, 0.0], [1.0, 1.0]])
            .named("calibrated")
            .dashed(),
    ];
    for (name, bins) in curves {
        let kept = bins.iter().filter(|bin| bin.count > 0);
        let points: Vec<[f64; 2]> = kept.map(|bin| [bin.score, bin.right]).collect();
        series.push(Series::line(points.clone()).named(name));
        series.push(Series::points(points).named(name));
    }
    let axis = |label: &str| Axis::linear(label).with_range(0.0, 1.0);
    let panel = Panel {
        legend: Some(Corner::UpperLeft),
        ..Panel::new(
            "Reliability of the rule on fixtures that took no part",
            axis("probability of the answer"),
            axis("share of answers that are right"),
            series,
        )
    };
    Chart::new("", vec![panel])
}

fn row(condition: &Condition) -> String {
    let (known, others): (Vec<&Outcome>, Vec<&Outcome>) = condition
        .outcomes
        .iter()
        .partition(|outcome| outcome.truth.is_some());
    let share = |of: &[&Outcome], test: &dyn Fn(&Outcome) -> bool| {
        100.0 * of.iter().filter(|outcome| test(outcome)).count() as f64 / of.len().max(1) as f64
    };
    let error = |level: Level| {
        calibration_error(&reliability(known.iter().filter_map(|o| level.answered(o))))
    };
    format!(
        "| {} | {} | {:.0}, {:.0}, {:.0} % | {:.3}, {:.3}, {:.3} | {:.0} % | {:.0} % of {} |\n",
        condition.name,
        known.len(),
        share(&known, &|outcome| outcome.right(3)),
        share(&known, &|outcome| outcome.right(1)),
        share(&known, &|outcome| outcome.right(0)),
        error(Level::Category),
        error(Level::Cell),
        error(Level::Type),
        share(&known, &|outcome| !outcome.accepted()),
        share(&others, &Outcome::accepted),
        others.len()
    )
}
