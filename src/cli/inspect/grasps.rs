//! The grasps of a file, judged on the exact mesh.

use std::collections::BTreeMap;
use std::fmt::Write;

use anyhow::Context;
use serde_json::{Value, json};

use super::Inspect;
use crate::cli::args::Common;
use crate::cli::printing::{print, print_json};
use crate::cli::text::{in_words, table, text};
use crate::cli::{input, progress};
use crate::grasp::Judgement;
use crate::printable::counted;
use crate::store::GraspRow;
use crate::study::{JudgedGrasp, JudgedPopulation, judge_all};

pub(super) fn run(command: &Inspect, common: &Common) -> anyhow::Result<()> {
    let file = input::grasps(&command.file, &command.of, common)?;
    input::all_known("--grasp", &command.grasp, &file, &command.file)?;
    let name = command.file.display();
    let wanted = |grasp: &&GraspRow| command.grasp.is_empty() || command.grasp.contains(&grasp.id);
    let count = file.grasps.iter().filter(wanted).count();
    let bar = progress::bar("grasps", count as u64, common.quiet);
    let (mut landscapes, mut all, mut said) = (Vec::new(), Vec::new(), String::new());
    for population in file.landscapes() {
        let grasps: Vec<&GraspRow> = population.grasps.iter().copied().filter(wanted).collect();
        if grasps.is_empty() {
            continue;
        }
        let energy = population.energy().with_context(|| format!("{name}"))?;
        let judged = judge_all(&energy, &population, &grasps, || bar.inc(1));
        let counts = JudgedPopulation::of(&population, energy.hand(), &judged);
        if !command.grasp.is_empty() {
            for grasp in &judged {
                let what = format!("grasp {}: {} on {}", grasp.id, grasp.hand, grasp.object);
                said.extend([&*what, "\n\n", &text(&serde_json::to_value(grasp)?), "\n"]);
            }
        } else if command.each {
            let rows: Vec<Value> = judged.iter().map(row).collect();
            said.extend([&*of_pair(&counts), "\n\n", &table(&rows), "\n"]);
        } else {
            let unverified = file.has_unverified_outcomes();
            said += &verdict(&counts, &judged, &grasps, unverified);
            if common.verbose {
                said.extend(["\n", &text(&in_rows(&counts)?), "\n"]);
                said += &table(&quantiles(&judged)?);
            }
            said.push('\n');
        }
        landscapes.push(counts);
        all.extend(judged);
    }
    bar.finish_and_clear();
    if common.json {
        return print_json(&json!({ "landscapes": landscapes, "grasps": all }));
    }
    if command.grasp.is_empty() && !command.each && !common.verbose {
        said += "--verbose prints all measures, --each one line for each grasp, --grasp ID all about one.\n";
    }
    print(&said);
    Ok(())
}

/// A grasp in the table of `--each`.
fn row(grasp: &JudgedGrasp) -> Value {
    let judgement = &grasp.judgement;
    json!({
        "id": grasp.id,
        "energy": grasp.energy,
        "net_wrench": judgement.net_wrench,
        "least_friction": judgement.least_friction,
        "epsilon": judgement.epsilon,
        "gap_m": judgement.gap_m,
        "deepest_m": judgement.deepest_m,
        "self_penetration_m": judgement.self_penetration_m,
        "digits": judgement.digits,
        "strict_filter": grasp.objection.unwrap_or("passes"),
    })
}

/// How many grasps of which hand on what: `3 grasps of the human hand on mug (scale 2)`.
fn of_pair(of: &JudgedPopulation) -> String {
    let (grasps, hand, object) = (counted(of.grasps, "grasp"), &of.hand, &of.object);
    let scale = if (of.scale - 1.0).abs() > f64::EPSILON {
        format!(" (scale {})", of.scale)
    } else {
        String::new()
    };
    format!("{grasps} of the {hand} hand on {object}{scale}")
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
        1e3 * values.fold(0.0, f64::max)
    };
    let mut text = format!(
        "{passing} of {} {} the strict filter; the farthest contact is {:.2} mm off the object, and the hand is at most \
         {:.2} mm deep in it.\n",
        of_pair(population),
        if passing == 1 { "passes" } else { "pass" },
        most(|judgement| judgement.gap_m),
        most(|judgement| judgement.deepest_m)
    );
    if passing < total {
        let mut reasons: Vec<_> = population.objections.iter().collect();
        reasons.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let reasons = reasons
            .iter()
            .map(|(reason, count)| format!("{reason} {count}"));
        let reasons: Vec<String> = reasons.collect();
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

/// The counts, with those of links as rows, in which names stay as they are.
fn in_rows(counts: &JudgedPopulation) -> anyhow::Result<Value> {
    let links = counts.links_in_contact.iter();
    let links = links.map(|(link, grasps)| json!({ "link": link, "grasps": grasps }));
    let links: Vec<Value> = links.collect();
    let mut counts = serde_json::to_value(counts)?;
    counts["links_in_contact"] = json!(links);
    Ok(counts)
}

/// Quantiles of all numbers of the judgements.
fn quantiles(judged: &[JudgedGrasp]) -> anyhow::Result<Vec<Value>> {
    let mut measures: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for grasp in judged {
        let grasp = serde_json::to_value(grasp)?;
        let parts = [
            ("", &grasp),
            ("term: ", &grasp["terms"]),
            ("hand use: ", &grasp["hand_use"]),
        ];
        for (part, entries) in parts {
            for (name, value) in entries.as_object().into_iter().flatten() {
                if let Some(value) = value.as_f64() {
                    let (name, value) = in_words(name, value);
                    let all = measures.entry(format!("{part}{name}"));
                    all.or_default().push(value);
                }
            }
        }
    }
    let uncounted = ["id", "scale"];
    measures.retain(|name, _| !uncounted.contains(&name.as_str()));
    let row = |(name, mut values): (String, Vec<f64>)| {
        values.sort_by(f64::total_cmp);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let at = |tenths: usize| values[((values.len() - 1) * tenths + 5) / 10];
        json!({
            "measure": name,
            "mean": mean,
            "least": at(0),
            "10_%": at(1),
            "median": at(5),
            "90_%": at(9),
            "greatest": at(10),
        })
    };
    Ok(measures.into_iter().map(row).collect())
}
