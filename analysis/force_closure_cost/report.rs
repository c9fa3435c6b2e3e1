//! The tables of the costs.

use std::fmt::Write as _;

use super::fit;
use super::line::Line;
use super::{CONTACTS, Costs, Measured};

/// The authors' code in torch on one CPU thread, changed only for device and eigenvalue solver: value and derivative on the
/// analytic sphere, one grasp at a time. CPU seconds, measured by us on another day.
pub(crate) const OFFICIAL_S: [f64; 6] =
    [0.537e-3, 0.545e-3, 0.551e-3, 0.550e-3, 0.587e-3, 0.902e-3];
/// The same per grasp in a batch of 1024.
pub(crate) const OFFICIAL_BATCH_S: [f64; 6] = [6.94e-6, 7.36e-6, 8.77e-6, 12.3e-6, 33.2e-6, 441e-6];
/// Target for three to five contacts on an analytic shape, value and derivative, seconds.
const TARGET_S: f64 = 1.5e-6;

/// The line through the published costs on an RTX 3090, Liu et al. (2021), Fig. 4, seconds.
pub(crate) fn paper_s(contacts: usize) -> f64 {
    1e-3 * (0.107 * libm::log10(contacts as f64) + 1.502)
}

pub(crate) fn text(measured: &Measured) -> String {
    let mut text = String::from(
        "# What force-closure tests cost\n\nWritten by `cargo run --release --example force_closure_cost`; \
         timings differ from run to run. One core. Contacts are spread at random over the sphere, or within 2 mm of \
         a bottle; each number is the mean over many sets in the fastest of up to 25 turns.\n\n",
    );
    costs(&mut text, measured);
    target(&mut text, measured);
    fits(&mut text, measured);
    shares(&mut text, measured);
    text
}

/// A row of a table.
fn row(text: &mut String, name: &str, cells: impl IntoIterator<Item = String>) {
    let cells: Vec<String> = cells.into_iter().collect();
    let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
}

fn head(text: &mut String, name: &str) {
    row(text, name, CONTACTS.map(|n| format!("n = {n}")));
    let _ = writeln!(text, "|---|{}", "---:|".repeat(CONTACTS.len()));
}

fn micro(costs: &[f64]) -> impl Iterator<Item = String> {
    costs.iter().map(|t| match 1e6 * t {
        t if t < 10.0 => format!("{t:.3}"),
        t if t < 1000.0 => format!("{t:.1}"),
        t => format!("{t:.0}"),
    })
}

fn costs(text: &mut String, measured: &Measured) {
    text.push_str("## Costs (µs)\n\n");
    head(text, "test");
    for relaxed in &measured.relaxed {
        let shape = relaxed.shape;
        row(
            text,
            &format!("relaxed, {shape}: value"),
            micro(&relaxed.value),
        );
        let name = format!("relaxed, {shape}: value and derivative");
        row(text, &name, micro(&relaxed.forces));
    }
    let name = "relaxed, sphere, rank condition active: value and derivative";
    row(text, name, micro(&measured.lacking_rank));
    row(
        text,
        "exact: force closure at μ = 0.5",
        micro(&measured.force_closure),
    );
    row(
        text,
        "exact: least friction μ₀",
        micro(&measured.least_friction),
    );
    row(
        text,
        "paper (RTX 3090): 0.107 log₁₀ n + 1.502 ms",
        micro(&CONTACTS.map(paper_s)),
    );
    row(
        text,
        "official code, CPU: value and derivative",
        micro(&OFFICIAL_S),
    );
    let name = "official code, CPU, each of a batch of 1024: value and derivative";
    row(text, name, micro(&OFFICIAL_BATCH_S));
    text.push('\n');
}

fn target(text: &mut String, measured: &Measured) {
    let Some(sphere) = measured.relaxed.first() else {
        return;
    };
    let worst = sphere.forces[0].max(sphere.forces[1]);
    let verdict = if worst <= TARGET_S { "met" } else { "missed" };
    let times = |reference: &[f64]| -> [f64; 2] {
        [0, 1].map(|index| reference[index] / sphere.forces[index])
    };
    let ([a, b], [c, d]) = (times(&OFFICIAL_S), times(&OFFICIAL_BATCH_S));
    let _ = writeln!(
        text,
        "Target for three to five contacts on an analytic shape, rank condition inactive: 1.5 µs; **{verdict}** ({:.2} and \
         {:.2} µs). The official code on a CPU takes {a:.0} and {b:.0} times as long, in batches of 1024 {c:.0} and {d:.0} \
         times.\n",
        1e6 * sphere.forces[0],
        1e6 * sphere.forces[1]
    );
}

fn fits(text: &mut String, measured: &Measured) {
    text.push_str(
        "## Laws\n\nLeast squares over the six n; times in µs.\n\n\
         | test | a log₁₀ n + b | R² | a n + b | R² |\n|---|---|---:|---|---:|\n",
    );
    let mut logarithm_wins = Vec::new();
    let mut all: Vec<(String, &Costs)> = Vec::new();
    for relaxed in &measured.relaxed {
        all.push((format!("relaxed, {}", relaxed.shape), &relaxed.forces));
    }
    all.push(("force closure at 0.5".to_owned(), &measured.force_closure));
    all.push(("least friction".to_owned(), &measured.least_friction));
    for (name, costs) in &all {
        let costs: Vec<f64> = costs.iter().map(|t| 1e6 * t).collect();
        let [log, line] = [fit::logarithm, fit::proportion].map(|law| law(&CONTACTS, &costs));
        let sum = |line: &Line, x: &str| format!("{:.3} {x} + {:.3}", line.slope, line.offset);
        let cells = [
            sum(&log, "log n").replace("+ -", "− "),
            format!("{:.4}", log.r_squared),
            sum(&line, "n").replace("+ -", "− "),
            format!("{:.6}", line.r_squared),
        ];
        row(text, name, cells);
        if log.r_squared > line.r_squared {
            logarithm_wins.push(name.clone());
        }
    }
    text.push('\n');
    if logarithm_wins.is_empty() {
        text.push_str(
            "Every one of our costs follows a straight line in n better than one in log n: on a CPU each contact costs its \
             own time. The paper's line has an offset of 1.502 ms and gains 0.27 ms between 3 and 1000 contacts: that of \
             a GPU that is never filled.\n\n",
        );
    } else {
        let _ = writeln!(
            text,
            "A line in log n describes better than one in n: {}.\n",
            logarithm_wins.join("; ")
        );
    }
}

fn shares(text: &mut String, measured: &Measured) {
    text.push_str(
        "## Where the time goes\n\nShare of asking the shape for distances, normals and curvature in value and derivative: \
         median and, in brackets, quartiles over the turns. Where asking is nearly all, the ratio of two timings may exceed \
         100 % by their noise. The paper says 80 % for normals.\n\n",
    );
    head(text, "share");
    for relaxed in &measured.relaxed {
        let cells = relaxed.answers_share.iter().map(|share| {
            let percent = |share: f64| format!("{:.0}", 100.0 * share);
            let [lower, median, upper] = [share.lower, share.median, share.upper].map(percent);
            format!("{median} % ({lower}–{upper})")
        });
        row(text, relaxed.shape, cells);
    }
}
