//! The table of the results.

use std::fmt::Write;

use landscape::grasp::energy::AUTHORS_UNIT_M;

use super::interval::interval;
use super::row::Row;
use super::{BOTTLES, POPULATIONS, SEED, SIMPLE};

/// Whether a grasp held in one of the tests; `None` if it was not simulated.
type Held = fn(&Row) -> Option<bool>;

const OUTCOMES: [(&str, Held); 4] = [
    ("drop", |row| row.drop),
    ("drop, let go at once", |row| row.at_once),
    ("six directions, squeezed", |row| row.six),
    ("six directions, rigid", |row| row.rigid),
];

/// Whether a grasp belongs to a line of the table.
type Place = fn(&Row) -> bool;

/// Published static stability of Table I, per cent.
const PUBLISHED: [(&str, f64); 4] = [
    ("union of balls (Liu et al.)", 72.53),
    ("visuo-haptic (Liu et al.)", 85.00),
    ("paper, σ < 0.0015", 76.98),
    ("paper, σ < 0.0005", 85.00),
];

fn is_bottle(row: &Row) -> bool {
    BOTTLES.contains(&row.object.as_str())
}

/// A share such as `87.0 % [83.9, 89.6] of 531`.
fn share(rows: &[&Row], held: Held) -> String {
    let known: Vec<bool> = rows.iter().filter_map(|row| held(row)).collect();
    if known.is_empty() {
        return "none".to_owned();
    }
    let of = known.len() as f64;
    let count = known.iter().filter(|held| **held).count() as f64;
    let [low, high] = interval(count, of).map(|bound| 100.0 * bound);
    format!("{:.1} % [{low:.1}, {high:.1}] of {of}", 100.0 * count / of)
}

/// A line of the table: the grasps that pass the strict filter and belong to it.
fn line(text: &mut String, name: &str, rows: &[Row], keep: impl Fn(&Row) -> bool) {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.strict && keep(row)).collect();
    let shares = OUTCOMES.map(|(_, holds)| share(&rows, holds)).join(" | ");
    let _ = writeln!(text, "| {name} | {shares} |");
}

pub(crate) fn text(rows: &[Row]) -> String {
    let mut text = format!(
        "# Stability in simulation\n\nGrasps of the human hand by the default synthesis (`closed`), seed {SEED}, with no step \
         after the descent. Those that pass the strict filter count. {} chains on each of {}, and {} on each of {}. Every end \
         is dropped; the first {} on each bottle are pushed, too. In brackets: 95 % intervals (Wilson). Protocols: \
         `landscape stability --help`. σ is the mean distance of a grasp's contacts from the exact mesh.\n\n",
        POPULATIONS[0].1,
        BOTTLES.join(", "),
        POPULATIONS[0].2,
        SIMPLE.join(", "),
        POPULATIONS[1].1
    );
    text.push_str(
        "In the drop test hand and object are rigid, and what presses is what they overlap at the start. The object comes to \
         rest in the hand for a second before gravity acts; let go at once, it falls while the engine still looks for the \
         forces. The squeezed test drives the joints. σ < 0.0005 is the paper's stricter filter. Its unit is not stated; both \
         readings are below.\n\n## Beside Table I\n\n",
    );
    let names = OUTCOMES.map(|(name, _)| name).join(" | ");
    let _ = writeln!(text, "|  | {names} |\n|---|---|---|---|---|");
    for (name, per_cent) in PUBLISHED {
        let _ = writeln!(text, "| {name} | {per_cent:.2} % | | | |");
    }
    let units: [(&str, f64); 2] = [("m", 1.0), ("× 120 mm", AUTHORS_UNIT_M)];
    let places: [(&str, Place); 2] = [("bottles", is_bottle), ("with simple shapes", |_| true)];
    for (place, here) in places {
        line(&mut text, &format!("**closed, {place}**"), rows, here);
        for sigma in [0.0015, 0.0005] {
            for (unit, unit_m) in units {
                let name = format!("closed, σ < {sigma} {unit}, {place}");
                line(&mut text, &name, rows, |row| {
                    here(row) && row.sigma_m < sigma * unit_m
                });
            }
        }
    }
    text.push_str("\n## By object\n\n| | of all chains | drop |\n|---|---|---|\n");
    for name in BOTTLES.iter().chain(&SIMPLE) {
        let dropped: Vec<&Row> = (rows.iter())
            .filter(|row| row.object == *name && row.drop.is_some())
            .collect();
        let (chains, mut kept) = (dropped.len(), dropped);
        kept.retain(|row| row.strict);
        let drop = share(&kept, OUTCOMES[0].1);
        let _ = writeln!(text, "| {name} | {} of {chains} | {drop} |", kept.len());
    }
    text
}
