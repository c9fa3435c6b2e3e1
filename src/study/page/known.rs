//! What is known of the grasps of a file, in plain words.

use std::collections::BTreeMap;

use serde_json::Value;

use super::trust::{Statement, missing, told};
use crate::grasp::filter::passes_strict;
use crate::grasp::{Grasp, GraspEnergy};
use crate::store::{GraspFile, GraspRow};
use crate::study::Counted;
use crate::topography::{LEAST_MEMBERS, Rarefaction};

/// Greatest number of grasps that are judged for a page: a judgement takes milliseconds.
pub(super) const JUDGED: usize = 500;
/// Least share of simulated grasps that held for which no caution is asked.
const MOST_HOLD: f64 = 0.9;
/// Whether every grasp is judged, or each so many-th.
pub(super) fn step(grasps: usize) -> usize {
    grasps.div_ceil(JUDGED).max(1)
}

/// Whether a grasp passes the strict filter on the exact mesh.
pub(super) fn strict(energy: &GraspEnergy, row: &GraspRow) -> bool {
    // Contacts of a replaced hand are dropped.
    if row.grasp.contacts.is_empty() {
        return passes_strict(energy, &Grasp::best(energy, row.grasp.pose.to_vec()));
    }
    passes_strict(energy, &row.grasp)
}

/// All statements. `judged`: how many grasps pass the strict filter, and of how many; `curves`: those of the kinds.
pub(super) fn statements(
    file: &GraspFile,
    judged: [usize; 2],
    curves: &BTreeMap<String, Rarefaction>,
) -> Value {
    let mut statements = vec![filtered(judged, file.grasps.len()), simulated(file)];
    statements.extend(curves.get(Counted::Contacts.name()).map(touching));
    statements.push(Statement {
        tone: "note",
        short: "no map yet".to_owned(),
        long: "No ways between these grasps were searched. `landscape build` with this file finds the minima that they share, \
               the families of these minima, and the barriers between them."
            .to_owned(),
    });
    told(statements)
}

fn filtered([passed, judged]: [usize; 2], grasps: usize) -> Statement {
    let sample = if judged < grasps {
        format!(" Of the {grasps} grasps, {judged} were judged, evenly spaced in the file.")
    } else {
        String::new()
    };
    Statement {
        tone: if passed == judged { "good" } else { "care" },
        short: format!("{passed} of {judged} pass the strict filter"),
        long: format!(
            "By the strict filter, a grasp resists any small load with friction 0.5, and its contacts touch the object. It \
             goes at most 1 or 2 mm into the object, keeps its joints within their limits and holds with at least two digits. \
             This was computed from the poses for this page.{sample}"
        ),
    }
}

fn simulated(file: &GraspFile) -> Statement {
    let known = || file.grasps.iter().filter_map(|row| row.stable);
    let (simulated, held) = (known().count(), known().filter(|held| *held).count());
    if simulated == 0 {
        return Statement {
            tone: "care",
            short: "not simulated".to_owned(),
            long: "Whether the grasps hold the object was not simulated. `landscape stability` with this file does that and \
                   writes which of them hold."
                .to_owned(),
        };
    }
    let rest = match file.grasps.len() - simulated {
        0 => String::new(),
        rest => format!(
            " {} not simulated.",
            if rest == 1 {
                "One was".to_owned()
            } else {
                format!("{rest} were")
            }
        ),
    };
    Statement {
        tone: if held as f64 >= MOST_HOLD * simulated as f64 {
            "good"
        } else {
            "care"
        },
        short: format!("{held} of {simulated} held in simulation"),
        long: format!(
            "{} simulated in a physics engine, and {held} of them kept the object in the hand.{rest} A simulation leaves out \
             much, such as the softness of the skin.",
            if simulated == 1 {
                "1 grasp was".to_owned()
            } else {
                format!("{simulated} grasps were")
            }
        ),
    }
}

/// Sets of contact regions, and how many of them were probably not met.
fn touching(found: &Rarefaction) -> Statement {
    let [set, sets] = ["set of contact regions", Counted::Contacts.name()];
    let number = match found.kinds {
        1 => format!("1 {set}"),
        several => format!("{several} {sets}"),
    };
    let meaning = "Two grasps have the same set of contact regions if the same digits (and the palm) touch the object.";
    match found.estimate {
        Some(estimate) => {
            let [low, high] = estimate.unseen_interval;
            let rest = missing(
                [set, sets],
                [estimate.unseen, low, high],
                estimate.coverage,
                found.members as f64,
            );
            let unseen = if estimate.unseen < 0.5 {
                "probably none unseen".to_owned()
            } else {
                format!("about {:.0} unseen", estimate.unseen)
            };
            Statement {
                short: format!("{number}, {unseen}"),
                long: format!("{meaning} {}", rest.long),
                ..rest
            }
        }
        None => Statement {
            tone: "care",
            short: number,
            long: format!(
                "{meaning} With fewer than {LEAST_MEMBERS} grasps, the number of missing {sets} cannot be estimated."
            ),
        },
    }
}
