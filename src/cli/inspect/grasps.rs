//! The grasps of a file, judged on the exact mesh.

use std::collections::BTreeMap;
use std::fmt::Write;

use anyhow::Context;
use serde::Serialize;

use super::{Inspect, number, table, yes};
use crate::cli::args::Common;
use crate::cli::printing::{print, print_json};
use crate::cli::{input, progress};
use crate::evaluation::human_likeness::MEASURES;
use crate::grasp::Judgement;
use crate::grasp::closure::{PointContact, contact_forces};
use crate::grasp::filter::{MOST_GAP_M, STRICT_FRICTION};
use crate::printable::counted;
use crate::store::GraspRow;
use crate::study::{JudgedContact, JudgedGrasp, JudgedPopulation, judge_all};

/// All data for machine-readable output.
#[derive(Serialize)]
struct Everything<'a> {
    landscapes: Vec<JudgedPopulation>,
    grasps: &'a [JudgedGrasp],
}

pub(super) fn run(command: &Inspect, common: &Common) -> anyhow::Result<()> {
    let file = input::grasps(&command.file, &command.of, common)?;
    input::all_known("--grasp", &command.grasp, &file, &command.file)?;
    let name = command.file.display();
    let wanted = |grasp: &GraspRow| command.grasp.is_empty() || command.grasp.contains(&grasp.id);
    let count = file.grasps.iter().filter(|grasp| wanted(grasp)).count();
    let bar = progress::bar("grasps", count as u64, common.quiet);
    let mut landscapes = Vec::new();
    let mut all = Vec::new();
    let mut text = String::new();
    for population in file.landscapes() {
        let grasps: Vec<&GraspRow> = population
            .grasps
            .iter()
            .copied()
            .filter(|g| wanted(g))
            .collect();
        if grasps.is_empty() {
            continue;
        }
        let energy = population.energy().with_context(|| format!("{name}"))?;
        let judged = judge_all(&energy, &population, &grasps, || bar.inc(1));
        let counts = JudgedPopulation::of(&population, energy.hand(), &judged);
        if !command.grasp.is_empty() {
            for grasp in &judged {
                text.push_str(&detail(grasp));
                text.push('\n');
            }
        } else if command.each {
            text.push_str(&title(&counts));
            text.push_str(&lines(&judged));
            text.push('\n');
        } else {
            text.push_str(&verdict(
                &counts,
                &judged,
                &grasps,
                file.has_unverified_outcomes(),
            ));
            if common.verbose {
                text.push_str(&summary(&counts, &judged));
            }
            text.push('\n');
        }
        landscapes.push(counts);
        all.extend(judged);
    }
    bar.finish_and_clear();
    if command.grasp.is_empty() && !command.each && !common.verbose {
        text.push_str("--verbose prints all measures, --each one line for each grasp, --grasp ID all about one.\n");
    }
    if common.json {
        let everything = Everything {
            landscapes,
            grasps: &all,
        };
        return print_json(&everything);
    }
    print(&text);
    Ok(())
}

fn millimetres(metres: f64) -> String {
    format!("{:.2}", 1e3 * metres)
}

fn passes(is: bool) -> String {
    if is { "passes" } else { "refused" }.to_owned()
}

fn friction(judgement: &Judgement) -> f64 {
    judgement.least_friction.unwrap_or(f64::INFINITY)
}

/// One line for each grasp.
fn lines(judged: &[JudgedGrasp]) -> String {
    let header = [
        "id",
        "energy",
        "|Gc|",
        "friction",
        "epsilon",
        "gap mm",
        "depth mm",
        "self mm",
        "digits",
        "strict filter",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for grasp in judged {
        let judgement = &grasp.judgement;
        rows.push(vec![
            grasp.id.to_string(),
            number(grasp.energy),
            number(judgement.net_wrench),
            number(friction(judgement)),
            number(judgement.epsilon),
            millimetres(judgement.gap_m),
            millimetres(judgement.deepest_m),
            millimetres(judgement.self_penetration_m),
            judgement.digits.to_string(),
            grasp.objection.unwrap_or("passes").to_owned(),
        ]);
    }
    table(&rows)
}

/// All about one grasp.
fn detail(grasp: &JudgedGrasp) -> String {
    let judgement = &grasp.judgement;
    let mut text = format!(
        "grasp {}: {} on {}{}\n\n",
        grasp.id,
        grasp.hand,
        grasp.object,
        grasp
            .label
            .as_ref()
            .map_or(String::new(), |label| format!(", {label}"))
    );
    let lines = [
        (
            "strict filter",
            grasp
                .objection
                .map_or("passes".to_owned(), |reason| format!("refused, {reason}")),
        ),
        ("Eq. 11 as printed", passes(grasp.passes_published)),
        ("Eq. 11 as released", passes(grasp.passes_released)),
        ("", String::new()),
        ("|Gc|", number(judgement.net_wrench)),
        ("least friction", number(friction(judgement))),
        (
            "force closure at 0.5",
            yes(judgement.force_closure).to_owned(),
        ),
        ("epsilon at 0.5", number(judgement.epsilon)),
        (
            "farthest contact",
            format!("{} mm", millimetres(judgement.gap_m)),
        ),
        (
            "deepest penetration",
            format!("{} mm", millimetres(judgement.deepest_m)),
        ),
        (
            "deepest in itself",
            format!("{} mm", millimetres(judgement.self_penetration_m)),
        ),
        (
            "beyond joint limits",
            format!("{:.3} rad", judgement.joint_excess_rad),
        ),
        ("", String::new()),
        ("energy", number(grasp.energy)),
    ];
    for (what, value) in lines {
        let _ = writeln!(text, "{}", format!("{what:<22} {value}").trim_end());
    }
    for (term, value) in &grasp.terms {
        let _ = writeln!(text, "  {term:<20} {}", number(*value));
    }
    text + "\n" + &touching(&grasp.contacts)
}

/// The contacts of a grasp, with the forces that balance.
fn touching(contacts: &[JudgedContact]) -> String {
    let bare: Vec<PointContact> = contacts.iter().map(|found| found.contact).collect();
    let forces = contact_forces(&bare, STRICT_FRICTION);
    let header = ["contact on", "digit", "point", "distance mm", "force"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for (index, touch) in contacts.iter().enumerate() {
        let force = forces.as_ref().map_or("-".to_owned(), |found| {
            number(found.forces[index].dot(&bare[index].inward_normal))
        });
        rows.push(vec![
            touch.link.clone(),
            touch.digit.clone(),
            touch.surface_point.to_string(),
            millimetres(touch.distance_m),
            force,
        ]);
    }
    table(&rows)
        + if forces.is_some() {
            "force: share of the normal force that balances as far inside the cones of friction 0.5 as possible\n"
        } else {
            "no forces balance at friction 0.5\n"
        }
}

fn title(of: &JudgedPopulation) -> String {
    let (grasps, hand, object) = (counted(of.grasps, "grasp"), &of.hand, &of.object);
    let scale = scale_told(of.scale);
    format!("{grasps} of the {hand} hand on {object}{scale}\n\n")
}

/// The scale of an object if it is not 1.
fn scale_told(scale: f64) -> String {
    if (scale - 1.0).abs() > f64::EPSILON {
        format!(" (scale {scale})")
    } else {
        String::new()
    }
}

/// How many grasps pass the strict filter, why the others do not, and how many held in simulation.
fn verdict(
    population: &JudgedPopulation,
    judged: &[JudgedGrasp],
    rows: &[&GraspRow],
    unverified: bool,
) -> String {
    let (total, passing) = (population.grasps, population.passes_strict);
    let most = |of: fn(&Judgement) -> f64| {
        let values = judged.iter().map(|grasp| of(&grasp.judgement));
        millimetres(values.fold(0.0, f64::max))
    };
    let mut text = format!(
        "{passing} of {} of the {} hand on {}{} {} the strict filter; the farthest contact is {} mm off the object, and the \
         hand is at most {} mm deep in it.\n",
        counted(total, "grasp"),
        population.hand,
        population.object,
        scale_told(population.scale),
        if passing == 1 { "passes" } else { "pass" },
        most(|judgement| judgement.gap_m),
        most(|judgement| judgement.deepest_m)
    );
    if passing < total {
        let reasons = by_frequency(&population.objections).into_iter();
        let reasons: Vec<String> = reasons
            .map(|(reason, count)| format!("{reason} {count}"))
            .collect();
        let _ = writeln!(
            text,
            "refused: {} ({})",
            total - passing,
            reasons.join(", ")
        );
    }
    let simulated = rows.iter().filter(|row| row.stable.is_some()).count();
    if simulated > 0 {
        let held = rows.iter().filter(|row| row.stable == Some(true)).count();
        let by_whom = if unverified {
            ", as the file says; not verified (`landscape stability` simulates them again)"
        } else {
            ""
        };
        let _ = writeln!(text, "held in simulation: {held} of {simulated}{by_whom}");
    }
    text
}

/// The counts and quantiles as a page of text.
fn summary(population: &JudgedPopulation, judged: &[JudgedGrasp]) -> String {
    let mut text = String::from("\n");
    let total = population.grasps;
    let share = |count: usize| {
        let percent = 100.0 * count as f64 / total as f64;
        format!("{count} of {total} ({percent:.0} %)")
    };
    for (filter, count) in [
        ("strict filter", population.passes_strict),
        ("Eq. 11 as printed", population.passes_published),
        ("Eq. 11 as released", population.passes_released),
    ] {
        let _ = writeln!(text, "{filter:<20} {}", share(count));
    }
    text.push('\n');
    text.push_str(&quantiles(judged));
    text.push_str(&hand_use(population, judged));
    let _ = writeln!(
        text,
        "\nlinks with a contact of the set within {:.0} mm of the object",
        1e3 * MOST_GAP_M
    );
    if population.links_in_contact.is_empty() {
        text.push_str("  none\n");
    }
    let mut rows = Vec::new();
    for (link, count) in by_frequency(&population.links_in_contact) {
        rows.push(vec![format!("  {link}"), share(count)]);
    }
    text.push_str(&table(&rows));
    text
}

/// Sorts by frequency, most frequent first, and then by name.
fn by_frequency<K: AsRef<str>>(counts: &BTreeMap<K, usize>) -> Vec<(&str, usize)> {
    let names = counts.iter().map(|(name, count)| (name.as_ref(), *count));
    let mut sorted: Vec<(&str, usize)> = names.collect();
    sorted.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    sorted
}

/// Quantiles of all measures of quality.
fn quantiles(judged: &[JudgedGrasp]) -> String {
    type Value = fn(&JudgedGrasp) -> f64;
    let measures: [(&str, Value); 9] = [
        ("|Gc|", |grasp| grasp.judgement.net_wrench),
        ("least friction", |grasp| friction(&grasp.judgement)),
        ("epsilon at friction 0.5", |grasp| grasp.judgement.epsilon),
        ("farthest contact, mm", |grasp| 1e3 * grasp.judgement.gap_m),
        ("deepest penetration, mm", |grasp| {
            1e3 * grasp.judgement.deepest_m
        }),
        ("deepest in itself, mm", |grasp| {
            1e3 * grasp.judgement.self_penetration_m
        }),
        ("beyond joint limits, rad", |grasp| {
            grasp.judgement.joint_excess_rad
        }),
        ("digits of the contact set", |grasp| {
            grasp.judgement.digits as f64
        }),
        ("energy", |grasp| grasp.energy),
    ];
    let header = ["", "least", "10 %", "median", "90 %", "most"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for (name, value) in measures {
        rows.push(row(name.to_owned(), judged.iter().map(value).collect()));
    }
    let terms = judged
        .first()
        .into_iter()
        .flat_map(|grasp| grasp.terms.keys());
    for term in terms {
        let values = judged.iter().map(|grasp| grasp.terms[term]);
        rows.push(row(format!("  {term}"), values.collect()));
    }
    table(&rows)
}

/// A row of quantiles of at least one value.
fn row(name: String, mut values: Vec<f64>) -> Vec<String> {
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    // Quantiles in tenths, rounded to the nearest grasp, since friction may be infinite.
    let at = |tenths: usize| number(values[(last * tenths + 5) / 10]);
    let mut cells = vec![name];
    cells.extend([0, 1, 5, 9, 10].map(at));
    cells
}

/// How the grasps use the hand: quantiles and the mean, or why that is not measured.
fn hand_use(population: &JudgedPopulation, judged: &[JudgedGrasp]) -> String {
    if let Some(why) = &population.not_human {
        return format!("\nuse of the hand is not measured: {why}\n");
    }
    let header = ["", "least", "10 %", "median", "90 %", "most", "mean"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for measure in MEASURES {
        let values = judged
            .iter()
            .filter_map(|grasp| (measure.of)(grasp.hand_use.as_ref()?));
        let values: Vec<f64> = values.collect();
        if values.is_empty() {
            continue;
        }
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let mut cells = row(format!("  {}", measure.name), values);
        cells.push(number(mean));
        rows.push(cells);
    }
    format!("\nuse of the hand\n{}", table(&rows))
}
