//! The tables of the comparison.

use std::fmt::Write as _;

use super::descent::{Descents, STEP};
use super::fit::Fit;
use super::picture::PUBLISHED_SLOPE;
use super::quality::{Quality, THRESHOLDS};
use super::sets::{FRICTIONS, Set, Verdict};

/// Upper limits of μ₀ for the fits.
const LIMITS: [f64; 11] = [
    0.1,
    0.2,
    0.3,
    0.4,
    0.5,
    0.6,
    0.8,
    1.0,
    1.5,
    2.0,
    f64::INFINITY,
];
/// Steps of the descent in the table.
const STEPS: [usize; 5] = [0, 4, 8, 15, 40];

pub(crate) fn text(sets: &[Set], limit: f64, descents: &[Descents]) -> String {
    let mut text = String::from(
        "# What the relaxed force-closure test tells about the exact one\n\nWritten by `cargo run --release --example \
         force_closure_estimate`. Contacts on the unit sphere, inward normals, torques about its centre (where they vanish). \
         μ₀: least friction at which forces balance, in closed form; force closure at μ: they balance at μ and `GGᵀ` ≻ 10⁻⁴ I. \
         The relaxed test is ‖Gc‖ < 0.5; the released code compares the square, that is ‖Gc‖ < 0.707.\n\n",
    );
    fits(&mut text, sets, limit);
    random(&mut text, sets);
    descent(&mut text, descents);
    ends(&mut text, descents);
    text
}

fn fits(text: &mut String, sets: &[Set], limit: f64) {
    let _ = writeln!(
        text,
        "## ‖Gc‖ against μ₀\n\n{} random sets of three. Least squares over the sets with μ₀ up to a limit:\n\n\
         | μ₀ ≤ | sets | a of a μ₀ | a μ₀ + b | Pearson's r |\n|---:|---:|---:|---|---:|",
        sets.len()
    );
    let mut limits = LIMITS.to_vec();
    limits.push(limit);
    limits.sort_by(f64::total_cmp);
    for at in limits {
        let fit = Fit::up_to(sets, at);
        let name = match at {
            at if at.is_infinite() => "all".to_owned(),
            at if (at - limit).abs() < 1e-9 => format!("**{at:.4}**"),
            at => format!("{at}"),
        };
        let _ = writeln!(
            text,
            "| {name} | {} | {:.3} | {:.3} μ₀ + {:.3} | {:.3} |",
            fit.sets, fit.through_origin, fit.line.slope, fit.line.offset, fit.correlation
        );
    }
    let _ = writeln!(
        text,
        "\nThe paper's slope, {PUBLISHED_SLOPE}, comes out for μ₀ ≤ {limit:.4} and for no other range that begins at zero: the \
         slope through the origin falls all the way, because the sets do not lie on a line through the origin. Three contacts \
         that need no friction at all can still have ‖Gc‖ up to 1 (an antipodal pair and a third contact). A line with an \
         offset hardly depends on the range from μ₀ ≤ 0.2 to μ₀ ≤ 0.6. Beyond μ₀ = {:.4} the published line exceeds 3, the largest ‖Gc‖ \
         there is.\n",
        3.0 / PUBLISHED_SLOPE
    );
}

/// A table row of recall for both thresholds and both frictions.
fn row<'a>(text: &mut String, name: &str, verdicts: &(impl Iterator<Item = &'a Verdict> + Clone)) {
    let percent = |share: f64| {
        if share.is_nan() {
            "–".to_owned()
        } else {
            format!("{:.1} %", 100.0 * share)
        }
    };
    let mut cells = Vec::new();
    for friction in 0..FRICTIONS.len() {
        let qualities = THRESHOLDS.map(|t| Quality::of(verdicts.clone(), t, friction));
        cells.push(percent(qualities[0].share_closed()));
        for quality in qualities {
            cells.push(percent(quality.recall()));
        }
    }
    let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
}

fn head(text: &mut String, name: &str) {
    let mut cells = vec![name.to_owned()];
    for friction in FRICTIONS {
        cells.push(format!("closed at μ = {friction}"));
        for threshold in ["0.5", "0.707"] {
            cells.push(format!("recall, {threshold}"));
        }
    }
    let _ = writeln!(text, "| {} |", cells.join(" | "));
    let _ = writeln!(text, "|---|{}", "---:|".repeat(cells.len() - 1));
}

fn random(text: &mut String, sets: &[Set]) {
    text.push_str(
        "## Random sets of three\n\nRecall: share of the force-closed sets that pass the relaxed test with ‖Gc‖ below 0.5 or \
         0.707.\n\n",
    );
    head(text, "sets");
    let verdicts = sets.iter().map(|set| &set.verdict);
    row(text, &format!("{}", sets.len()), &verdicts);
    let precision = |threshold| Quality::of(verdicts.clone(), threshold, 0).precision();
    let most = |threshold: f64| {
        let passing = sets.iter().filter(|set| set.verdict.net_wrench < threshold);
        passing.fold(0.0, |most: f64, set| most.max(set.least_friction))
    };
    let bound = |threshold: f64| threshold / (9.0 - threshold * threshold).sqrt();
    let _ = writeln!(
        text,
        "\nOf the sets that pass, {:.1} and {:.1} % are force-closed at μ = {}. What passes needs little friction: ‖Gc‖ ≥ 3 μ₀/√(1 + μ₀²) for three contacts on the sphere (the \
         equilateral triangle has the least), so ‖Gc‖ < 0.5 means μ₀ < {:.3} (largest found: {:.3}), and ‖Gc‖ < 0.707 means \
         μ₀ < {:.3} ({:.3}). The test asks for balance by equal, nearly frictionless forces, and drops nearly all sets that friction \
         holds.\n",
        100.0 * precision(THRESHOLDS[0]),
        100.0 * precision(THRESHOLDS[1]),
        FRICTIONS[0],
        bound(THRESHOLDS[0]),
        most(THRESHOLDS[0]),
        bound(THRESHOLDS[1]),
        most(THRESHOLDS[1])
    );
}

fn descent(text: &mut String, descents: &[Descents]) {
    let Some(threes) = descents.first() else {
        return;
    };
    let _ = writeln!(
        text,
        "## Sets of three on their way down Eq. 7\n\n{} random sets, minimised by L-BFGS on the sphere, where the distances of \
         Eq. 7 vanish; every step moves the contacts by at most {STEP} radii (root of the sum of squares).\n",
        threes.end.len()
    );
    head(text, "steps");
    for (step, verdicts) in threes.steps.iter().zip(&threes.verdicts) {
        if STEPS.contains(step) {
            row(text, &step.to_string(), &verdicts.iter());
        }
    }
    row(text, "end", &threes.end.iter());
    text.push_str(
        "\nSo what the relaxed test loses depends on where contacts come from: of random force-closed sets nearly all, of \
         optimised ones nothing, because the optimiser drives the very number that is tested to zero.\n\n",
    );
}

fn ends(text: &mut String, descents: &[Descents]) {
    text.push_str("## More contacts: random, and optimised to the end\n\n");
    head(text, "sets");
    for Descents {
        contacts,
        verdicts,
        end,
        ..
    } in descents
    {
        if let Some(random) = verdicts.first() {
            let name = format!("{contacts} contacts, {} random", random.len());
            row(text, &name, &random.iter());
        }
        row(
            text,
            &format!("{contacts} contacts, optimised"),
            &end.iter(),
        );
    }
}
