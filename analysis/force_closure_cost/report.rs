//! The tables of the costs.

use std::fmt::Write as _;

use super::fit;
use super::line::Line;
use super::timing::Share;
use super::{CONTACTS, Costs, Measured};

/// The authors' code in torch on one CPU thread, changed only for device and eigenvalue solver: value and derivative on the
/// analytic sphere, one grasp at a time. CPU seconds, measured by us on another day.
pub(crate) const OFFICIAL_S: [f64; 6] =
    [0.537e-3, 0.545e-3, 0.551e-3, 0.550e-3, 0.587e-3, 0.902e-3];
/// The same per grasp in a batch of 1024.
pub(crate) const OFFICIAL_BATCH_S: [f64; 6] = [6.94e-6, 7.36e-6, 8.77e-6, 12.3e-6, 33.2e-6, 441e-6];
/// Number of additions, multiplications, divisions and square roots for a contact on the sphere.
const OPERATIONS: f64 = 190.0;
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
        "## Laws\n\nLeast squares over the six n; times in µs. R² is of t, for the power law of log t.\n\n\
         | test | a log₁₀ n + b | R² | a n + b | R² | power law | R² |\n|---|---|---:|---|---:|---|---:|\n",
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
        let [log, line, power] =
            [fit::logarithm, fit::proportion, fit::power].map(|law| law(&CONTACTS, &costs));
        let sum = |line: &Line, x: &str| format!("{:.3} {x} + {:.3}", line.slope, line.offset);
        let cells = [
            sum(&log, "log n").replace("+ -", "− "),
            format!("{:.4}", log.r_squared),
            sum(&line, "n").replace("+ -", "− "),
            format!("{:.6}", line.r_squared),
            format!("{:.3} n^{:.2}", libm::pow(10f64, power.offset), power.slope),
            format!("{:.4}", power.r_squared),
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
        "## Where the time goes\n\nShare of asking the shape: distances and normals for the value; curvature too for the \
         derivative. The part alone and the whole are timed in turns: median and, in brackets, quartiles of the ratio \
         within a turn. Where asking is nearly all, the ratio of two timings may exceed 100 % by their noise. The paper \
         says 80 % for normals.\n\n",
    );
    head(text, "share");
    let cells = |shares: &[Share]| -> Vec<String> {
        let percent = |share: f64| format!("{:.0}", 100.0 * share);
        shares
            .iter()
            .map(|share| {
                let [lower, median, upper] = [share.lower, share.median, share.upper].map(percent);
                format!("{median} % ({lower}–{upper})")
            })
            .collect()
    };
    for relaxed in &measured.relaxed {
        let shape = relaxed.shape;
        row(
            text,
            &format!("{shape}: value"),
            cells(&relaxed.normals_share),
        );
        let name = format!("{shape}: value and derivative");
        row(text, &name, cells(&relaxed.answers_share));
    }
    if let Some(sphere) = measured.relaxed.first() {
        text.push_str("\nOn the sphere, value and derivative (µs, fastest turns):\n\n");
        head(text, "part");
        row(
            text,
            "shape: distance, normal, curvature",
            micro(&sphere.answers),
        );
        row(
            text,
            "sums over contacts and rank check",
            micro(&measured.sums),
        );
        let rest: Vec<f64> = (0..CONTACTS.len())
            .map(|k| (sphere.forces[k] - sphere.answers[k] - measured.sums[k]).max(0.0))
            .collect();
        row(text, "derivative (the rest)", micro(&rest));
        let active: Vec<f64> = (0..CONTACTS.len())
            .map(|k| (measured.lacking_rank[k] - sphere.forces[k]).max(0.0))
            .collect();
        row(
            text,
            "added by an active rank condition (eigenvectors of a 6 × 6 matrix)",
            micro(&active),
        );
        let per_contact =
            (sphere.forces[5] - sphere.forces[4]) / (CONTACTS[5] - CONTACTS[4]) as f64;
        let _ = writeln!(
            text,
            "\nA further contact on the sphere costs {:.0} ns, value and derivative. Counted by hand that is about {OPERATIONS} \
             operations (15 divisions and 4 square roots among them), so {:.1} GFLOP/s of the about 10 that two lanes without \
             fused multiply-add can reach on a core of 3 GHz. More would take wider vectors, which the rule of the same bits on \
             every processor forbids to choose at run time.",
            1e9 * per_contact,
            1e-9 * OPERATIONS / per_contact
        );
    }
}
