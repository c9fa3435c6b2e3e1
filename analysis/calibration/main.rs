//! Whether the probabilities of the rule mean what they say → `figures/calibration.md` and `.png`
//!
//! `LANDSCAPE_TEST_DATA=FOLDER cargo run --release --example calibration -- [--rule RULE.toml] [--output STEM]`
//!
//! Which numbers of the rule's [`Sharpness`] suit widened fixtures with errors as large as people's is told by the loss −ln of
//! the probability that the answer is right or wrong as it is. The reliability is then measured on fixtures that took no part.
//! Only objects of one solid are used, and for the choice every third of these: the others take hours.
//! FOLDER holds the Shadow hand and one with MANO's bones; without it the fixtures on these hands are left out.

#[expect(dead_code, reason = "fixtures have no measured distances")]
#[path = "../annotated/contact.rs"]
mod contact;
#[path = "../reliability.rs"]
mod reliability;
#[path = "../widened_sets.rs"]
mod widened_sets;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::PathBuf;

use landscape::evaluation::taxonomy::{Rule, Sharpness, Taxonomy};
use landscape::figure::chart::{Axis, Chart, Corner, Panel, Series};
use reliability::{Answered, Bin, calibration_error, reliability, table};
use widened_sets::judge::{Case, Outcome, judge_each};
use widened_sets::{conditions, scenes};

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Exponents of a grasp that fits no type, and what is added for one that fits a type wholly, that are tried.
const LEAST: [f64; 6] = [0.4, 0.6, 0.8, 1.0, 1.5, 2.0];
const BY_FIT: [f64; 4] = [0.0, 1.0, 1.5, 2.0];
/// Losses that differ by less are taken as equal: the fixtures are too few to tell them apart.
const ALIKE: f64 = 0.005;
const SEED: u64 = 5;
/// Hands that are moved by so much along each axis, or more, err like those of people.
const LIKE_PEOPLE_M: f64 = 0.005;
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
    /// Whether the choice rests on it.
    like_people: bool,
    outcomes: Vec<Outcome>,
}

/// All pairs of numbers that are tried.
fn tried() -> Vec<Sharpness> {
    let pairs = LEAST
        .into_iter()
        .flat_map(|least| BY_FIT.map(|by_fit| Sharpness { least, by_fit }));
    pairs.collect()
}

/// The outcomes under all conditions, for each sharpness.
fn outcomes(
    cases: &[Case],
    rule: &Rule,
    sharpness: &[Sharpness],
) -> Result<Vec<Vec<Condition>>, Failure> {
    let mut all: Vec<Vec<Condition>> = sharpness.iter().map(|_| Vec::new()).collect();
    for (name, noise) in conditions(SEED) {
        let found = judge_each(cases, rule, noise, sharpness)?;
        for (own, outcomes) in all.iter_mut().zip(found) {
            own.push(Condition {
                name,
                like_people: noise.place_m >= LIKE_PEOPLE_M,
                outcomes,
            });
        }
    }
    Ok(all)
}

/// Mean loss −ln p(right) or −ln (1 − p) of the answers' types, with errors like those of people.
fn loss(conditions: &[Condition]) -> f64 {
    let like_people = conditions.iter().filter(|condition| condition.like_people);
    let all = like_people.flat_map(|condition| &condition.outcomes);
    let losses = all.filter_map(|outcome| {
        let (score, right) = Level::Type.answered(outcome)?;
        let told = if right { score } else { 1.0 - score };
        Some(-libm::log(told.max(1e-6)))
    });
    let losses: Vec<f64> = losses.collect();
    losses.iter().sum::<f64>() / losses.len() as f64
}

/// The head of the report with the loss of each pair that is tried, and these losses.
fn choices(rule: &Rule, fitted: &[Case]) -> Result<(String, Vec<f64>), Failure> {
    let sharpness = rule.sharpness;
    let mut text = format!(
        "# Whether the rule's probabilities mean what they say\n\n`LANDSCAPE_TEST_DATA=… cargo run --release --example \
         calibration`, rule {}.\n\n## The exponent of the fits\n\nThe exponent is *least* + *by fit* × (how well the best \
         type fits). On {} widened fixtures; the loss under the two conditions below whose errors are as large as those of \
         people, the calibration errors under all. The rule has {} and {}.\n\n| least | by fit | loss of the type's \
         probability | calibration error, type | cell | category |\n|---|---|---|---|---|---|\n",
        rule.version,
        fitted.len(),
        sharpness.least,
        sharpness.by_fit
    );
    let tried = tried();
    let mut losses = Vec::new();
    for (Sharpness { least, by_fit }, found) in tried.iter().zip(outcomes(fitted, rule, &tried)?) {
        losses.push(loss(&found));
        let errors = Level::ALL.map(|level| {
            let all = found.iter().flat_map(|condition| &condition.outcomes);
            calibration_error(&reliability(
                all.filter_map(|outcome| level.answered(outcome)),
            ))
        });
        let _ = writeln!(
            text,
            "| {least} | {by_fit} | {:.4} | {:.3} | {:.3} | {:.3} |",
            loss(&found),
            errors[0],
            errors[1],
            errors[2]
        );
    }
    Ok((text, losses))
}

/// Of the pairs whose loss is nearly the least, the one that is least certain; and the least loss.
fn choice(tried: &[Sharpness], losses: &[f64]) -> Option<(Sharpness, f64)> {
    let best = losses.iter().copied().reduce(f64::min)?;
    let good = tried.iter().zip(losses);
    let good = good.filter(|(_, loss)| **loss <= best + ALIKE);
    let greatest_exponent = |sharpness: &Sharpness| sharpness.least + sharpness.by_fit;
    let least = good.min_by(|a, b| greatest_exponent(a.0).total_cmp(&greatest_exponent(b.0)))?;
    Some((*least.0, best))
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
    let mut place = 0;
    let mut fitted = scenes("widened", &["development", "held_out"])?;
    fitted.retain(|_| {
        place += 1;
        place % EVERY == 0
    });
    let unseen = scenes("widened_held_out", &["second_held_out"])?;
    let (mut text, losses) = choices(&rule, &fitted)?;
    let tried = tried();
    let (chosen, best) = choice(&tried, &losses).ok_or("there are no fixtures")?;
    let _ = writeln!(
        text,
        "\nThe least loss is {best:.4}. Of the pairs whose loss is at most {ALIKE} higher, {} and {} are the least certain \
         about a grasp that fits wholly, and are the choice.",
        chosen.least, chosen.by_fit
    );
    let judged = outcomes(&unseen, &rule, &[rule.sharpness])?.remove(0);
    let _ = write!(
        text,
        "\n## On fixtures that took no part\n\n{} widened fixtures of the second authored set: other scenes, sizes and forms, \
         the same four hands. *Calibration error*: the mean difference between the probability and the share that is right, over five bins.\n\n\
         | condition | answers | right: category, cell, type | calibration error: category, cell, type | unlisted | others \
         accepted | median of the best fit |\n|---|---|---|---|---|---|---|\n",
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
    text += &by_hand(&judged[0]);
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

/// How often the answers are right on each hand, where the type of the fixture agrees with what touches and elsewhere. The id
/// of a widened fixture ends with the name of its hand.
fn by_hand(condition: &Condition) -> String {
    let mut of_hand: BTreeMap<&str, Vec<&Outcome>> = BTreeMap::new();
    let known = || condition.outcomes.iter().filter(|o| o.truth.is_some());
    for outcome in known() {
        let hand = outcome.id.rsplit('-').next().unwrap_or_default();
        of_hand.entry(hand).or_default().push(outcome);
    }
    let mut text = format!(
        "\n## By hand, {}\n\n*Type agrees with contact*: all of both virtual fingers touch, the palm only where the type needs it, \
         and no other finger, but for helping ones of the type. Contact is that of the pose or corrected pose that fits a type best, \
         as the rule measures it, so the division is not independent of the rule; for [people's grasps](annotated_grasps.md) it \
         is nearness in the pose as it is.\n\n\
         | hand | type agrees with contact | answers | category | cell | type |\n|---|---|---|---|---|---|\n",
        condition.name
    );
    let mut row = |hand: &str, agrees: &str, outcomes: &[&Outcome]| {
        let [category, cell, kind] = [3, 1, 0].map(|levels| {
            let right = outcomes.iter().filter(|outcome| outcome.right(levels));
            100.0 * right.count() as f64 / outcomes.len().max(1) as f64
        });
        let _ = writeln!(
            text,
            "| {hand} | {agrees} | {} | {category:.0} % | {cell:.0} % | {kind:.0} % |",
            outcomes.len()
        );
    };
    let mut rows = |hand: &str, outcomes: &[&Outcome]| {
        let (agreeing, rest): (Vec<&Outcome>, Vec<&Outcome>) = outcomes
            .iter()
            .partition(|outcome| agrees_with_contact(outcome));
        row(hand, "all", outcomes);
        row(hand, "yes", &agreeing);
        row(hand, "no", &rest);
    };
    for (hand, outcomes) in &of_hand {
        rows(hand, outcomes);
    }
    rows("all", &known().collect::<Vec<_>>());
    text
}

/// Whether the type of a fixture agrees with what touches.
fn agrees_with_contact(outcome: &Outcome) -> bool {
    let touches = |part: &usize| {
        let mut facts = outcome.label.facts.iter();
        facts.any(|(name, degree)| *name == contact::PARTS[*part] && *degree >= 0.5)
    };
    let touching: BTreeSet<usize> = (0..contact::PARTS.len()).filter(touches).collect();
    let entry = outcome
        .truth
        .and_then(|number| Taxonomy::feix().numbered(number));
    entry.is_some_and(|entry| contact::agrees(entry, &touching))
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
    let mut fits: Vec<f64> = known.iter().map(|outcome| outcome.label.fit).collect();
    fits.sort_by(f64::total_cmp);
    let median = fits.get(fits.len() / 2).copied().unwrap_or_default();
    format!(
        "| {} | {} | {:.0}, {:.0}, {:.0} % | {:.3}, {:.3}, {:.3} | {:.0} % | {:.0} % of {} | {median:.2} |\n",
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
