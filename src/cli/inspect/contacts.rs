//! Contacts without a hand, from a JSON file.

use std::fmt::Write;

use anyhow::Context;

use super::{Inspect, number, table, yes};
use crate::cli::args::Common;
use crate::cli::printing::{print, print_json};
use crate::grasp::closure::RANK_EPSILON;
use crate::study::{BalancingForces, ContactsReport, GivenContacts};

/// Judges the contacts in the bytes of the file that the command names.
pub(super) fn run(command: &Inspect, bytes: &[u8], common: &Common) -> anyhow::Result<()> {
    let name = command.file.display();
    let flags = [
        ("--grasp", !command.grasp.is_empty()),
        ("--each", command.each),
        ("--hand", command.of.hand.is_some()),
        ("--object", command.of.object.is_some()),
    ];
    if let Some((flag, _)) = flags.iter().find(|(_, given)| *given) {
        anyhow::bail!("{flag}: {name} contains bare contacts, not grasps");
    }
    let contacts = parse(bytes).with_context(|| format!("{name}"))?;
    let report = contacts.judge().with_context(|| format!("{name}"))?;
    if common.json {
        return print_json(&report);
    }
    print(&text(&report));
    Ok(())
}

/// Parses the file; an error names the wrong field.
fn parse(bytes: &[u8]) -> anyhow::Result<GivenContacts> {
    const NO_CONTACTS: &str = "not a list of contacts (see `landscape inspect --help`)";
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let file = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let place = error.path().to_string();
        let cause = anyhow::Error::new(error.into_inner());
        if place == "." {
            cause.context(NO_CONTACTS)
        } else {
            cause.context(place).context(NO_CONTACTS)
        }
    })?;
    json.end().context(NO_CONTACTS)?;
    Ok(file)
}

fn text(report: &ContactsReport) -> String {
    let friction = report.friction;
    let mut text = String::new();
    for (what, value) in measures(report) {
        let _ = writeln!(text, "{}", format!("{what:<26} {value}").trim_end());
    }
    text.push('\n');
    match &report.forces {
        Some(forces) => text += &forces_text(forces, friction),
        None => {
            let _ = writeln!(text, "no forces balance at friction {}", number(friction));
        }
    }
    text
}

/// The measures by name; an empty name stands for an empty line.
fn measures(report: &ContactsReport) -> [(&'static str, String); 13] {
    let vector = |values: &[f64]| {
        values
            .iter()
            .map(|v| number(*v))
            .collect::<Vec<_>>()
            .join("  ")
    };
    let relaxed_test = if report.net_wrench < 0.5 {
        "below the 0.5 of the relaxed test"
    } else {
        "not below the 0.5 of the relaxed test"
    };
    let span = if report.rank_margin > RANK_EPSILON {
        "all wrenches are spanned"
    } else {
        "some wrench is out of reach, whatever the friction"
    };
    let least_friction = report.least_friction.unwrap_or(f64::INFINITY);
    let [force, torque] = [&report.weakest_wrench[..3], &report.weakest_wrench[3..]];
    let empty = ("", String::new());
    [
        ("contacts", report.contacts.to_string()),
        ("centre of torques", vector(&report.centre)),
        ("length of arms", number(report.length)),
        empty.clone(),
        (
            "|Gc|",
            format!("{}   {relaxed_test}", number(report.net_wrench)),
        ),
        (
            "least eigenvalue of GGᵀ",
            format!("{}   {span}", number(report.rank_margin)),
        ),
        ("least friction", number(least_friction)),
        empty,
        ("at friction", number(report.friction)),
        ("  force closure", yes(report.force_closure).to_owned()),
        ("  epsilon", number(report.epsilon)),
        ("  weakest against force", vector(force)),
        ("              and torque", vector(torque)),
    ]
}

/// The forces as a table.
fn forces_text(forces: &BalancingForces, friction: f64) -> String {
    let header = "contact|normal|sideways|share of limit|force x|y|z".split('|');
    let mut rows: Vec<Vec<String>> = vec![header.map(str::to_owned).collect()];
    for (index, force) in forces.vectors.iter().enumerate() {
        let (normal, tangential) = (forces.normal[index], forces.tangential[index]);
        let limit = friction * normal;
        let share = if limit > 0.0 {
            format!("{:.0} %", 100.0 * tangential / limit)
        } else {
            "-".to_owned()
        };
        let mut row = vec![index.to_string(), number(normal), number(tangential), share];
        row.extend(force.map(number));
        rows.push(row);
    }
    let head =
        "forces that balance, as far inside the cones as possible (normal forces add up to one)";
    format!("{head}\n{}", table(&rows))
}
