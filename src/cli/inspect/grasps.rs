//! The grasps of a file, judged on the exact mesh.

use std::fmt::Write;

use anyhow::Context;
use serde::Serialize;

use super::summary::{Landscape, summary};
use super::{Inspect, number, table, yes};
use crate::cli::args::Common;
use crate::cli::{input, print, progress};
use crate::grasp::Judgement;
use crate::grasp::closure::{PointContact, contact_forces};
use crate::grasp::filter::STRICT_FRICTION;
use crate::store::GraspRow;
use crate::study::{JudgedGrasp, judge_all};

/// All data for machine-readable output.
#[derive(Serialize)]
struct Everything<'a> {
    landscapes: Vec<Landscape>,
    grasps: &'a [JudgedGrasp],
}

pub(super) fn run(command: &Inspect, common: &Common) -> anyhow::Result<()> {
    let (file, warnings) = input::read(
        &command.file,
        command.of.hand.as_deref(),
        command.of.object.as_deref(),
    )?;
    if !common.quiet {
        input::warn(&warnings);
    }
    let name = command.file.display();
    for id in &command.grasp {
        anyhow::ensure!(
            file.grasps.iter().any(|grasp| grasp.id == *id),
            "--grasp {id}: {name} has no grasp with this id"
        );
    }
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
        let landscape = Landscape::of(&population, &judged);
        if !command.grasp.is_empty() {
            for grasp in &judged {
                text.push_str(&detail(grasp));
                text.push('\n');
            }
        } else if command.each {
            text.push_str(&landscape.title());
            text.push_str(&lines(&judged));
            text.push('\n');
        } else {
            text.push_str(&summary(&landscape, &judged));
            text.push('\n');
        }
        landscapes.push(landscape);
        all.extend(judged);
    }
    bar.finish_and_clear();
    if command.json {
        let everything = Everything {
            landscapes,
            grasps: &all,
        };
        text = serde_json::to_string_pretty(&everything)?;
    }
    print(&text);
    Ok(())
}

pub(super) fn millimetres(metres: f64) -> String {
    format!("{:.2}", 1e3 * metres)
}

pub(super) fn friction(judgement: &Judgement) -> f64 {
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
            grasp.objection.map_or("passes".to_owned(), |reason| {
                format!("refused for {reason}")
            }),
        ),
        (
            "Eq. 11 as printed",
            if grasp.passes_published {
                "passes"
            } else {
                "refused"
            }
            .to_owned(),
        ),
        (
            "Eq. 11 as released",
            if grasp.passes_released {
                "passes"
            } else {
                "refused"
            }
            .to_owned(),
        ),
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
    let bare: Vec<PointContact> = grasp.contacts.iter().map(|found| found.contact).collect();
    let forces = contact_forces(&bare, STRICT_FRICTION);
    let header = ["contact on", "digit", "point", "distance mm", "force"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for (index, touch) in grasp.contacts.iter().enumerate() {
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
    text.push('\n');
    text.push_str(&table(&rows));
    text.push_str(if forces.is_some() {
        "force: share of the normal force that balances as far inside the cones of friction 0.5 as possible\n"
    } else {
        "no forces balance at friction 0.5\n"
    });
    text
}
