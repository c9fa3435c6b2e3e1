//! What `landscape synth` says of its chains, as sentences and as JSON.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::evaluation::Diversity;
use crate::grasp::{GraspEnergy, Judgement};
use crate::printable::counted;
use crate::study::{Added, Keep, PopulationSettings, Synthesis, tally};

/// What came out, in one sentence, and why the other chains gave nothing in another.
pub(super) fn answer(
    energy: &GraspEnergy,
    found: &Synthesis,
    settings: &PopulationSettings,
    output: &Path,
) -> String {
    let (kept, chains) = (found.grasps.len(), found.chains.len());
    let mut text = format!(
        "wrote {} of the {} hand on {} from {} to {}",
        counted(kept, "grasp"),
        energy.hand().name,
        energy.object().name,
        counted(chains, "chain"),
        output.display()
    );
    // With another filter, what the strict one says is for the statistics.
    if settings.keep == Keep::Strict
        && let Some(refused) = refused(found)
    {
        let _ = write!(text, "; {refused}");
    }
    text.push('\n');
    for wish in &found.wishes {
        let _ = writeln!(
            text,
            "{}: {} of {}{}",
            wish.wish,
            wish.found,
            counted(wish.chains, "chain"),
            others(&wish.refused)
        );
    }
    text
}

/// What a set lacked, in sentences.
pub(super) fn added_text(added: &Added) -> String {
    let mut text = String::new();
    if added.given > 0 {
        let given = counted(added.given, "given grasp");
        let _ = writeln!(
            text,
            "{} of {given} pass the filter after a descent",
            added.repaired
        );
    }
    let chance = added.chance.map_or_else(String::new, |chance| {
        format!("; one more end would be new with a chance of {chance:.2}")
    });
    let ends = counted(added.ends, "end");
    let chains = counted(added.chains, "chain");
    let _ = writeln!(text, "{} of {ends} of {chains} are new{chance}", added.new);
    for (what, counts) in [("types", &added.types), ("touching", &added.contacts)] {
        if !counts.is_empty() {
            let _ = writeln!(text, "new {what}: {}", spelled(counts));
        }
    }
    text
}

/// What a set lacked, as JSON.
pub(super) fn added_value(added: &Added) -> Value {
    json!({
        "known": added.known,
        "given": added.given,
        "repaired": added.repaired,
        "chains": added.chains,
        "ends": added.ends,
        "new": added.new,
        "chance": added.chance,
        "types": numbers(&added.types),
        "contacts": numbers(&added.contacts),
    })
}

/// Names with their numbers, by name.
fn numbers(counts: &[(String, usize)]) -> BTreeMap<&str, usize> {
    counts
        .iter()
        .map(|(name, count)| (name.as_str(), *count))
        .collect()
}

/// The sentence that a set lacks nothing that was found.
pub(super) fn nothing_new(added: &Added) -> String {
    format!(
        "--beyond: none of {} is farther than --apart from the {} there; run more (-n) or lower --apart",
        counted(added.ends, "end"),
        counted(added.known, "pose")
    )
}

/// The most frequent of some names, with their numbers.
fn spelled(counts: &[(String, usize)]) -> String {
    let named = counts
        .iter()
        .take(MOST_NAMES)
        .map(|(name, count)| format!("{name} {count}"));
    let rest = counts.len().saturating_sub(MOST_NAMES);
    let rest = (rest > 0).then(|| format!("and {rest} more"));
    named.chain(rest).collect::<Vec<_>>().join(", ")
}

/// Why chains did not find what they were asked for: `; others: became Medium Wrap 3, gives way under loads 1`.
fn others(refused: &[(String, usize)]) -> String {
    match refused {
        [] => String::new(),
        refused => format!("; others: {}", spelled(refused)),
    }
}

/// How many names or reasons are printed in a line.
const MOST_NAMES: usize = 8;
/// How many ends of chains the strict filter refuses, and why: `refused: 3 (gives way under loads 2, hand in itself 1)`.
pub(super) fn refused(found: &Synthesis) -> Option<String> {
    let reasons = reasons(found);
    let count: usize = reasons.iter().map(|(_, count)| count).sum();
    let told: Vec<String> = reasons
        .iter()
        .map(|(reason, count)| format!("{reason} {count}"))
        .collect();
    (count > 0).then(|| format!("refused: {count} ({})", told.join(", ")))
}

/// The outcome of the drop test of some of all grasps.
pub(super) fn hold(held: usize, dropped: usize, all: usize) -> String {
    let held = match held {
        0 => format!("none of {dropped} holds"),
        1 => format!("1 of {dropped} holds"),
        held if held == dropped => format!("all {held} hold"),
        held => format!("{held} of {dropped} hold"),
    };
    let sample = if dropped < all {
        format!(" ({dropped} of {all} grasps were dropped)")
    } else {
        String::new()
    };
    format!("{held} when dropped in simulation{sample}\n")
}

/// The beginning of the sentence that no chain passed the filter.
pub(super) fn none_passed(chains: usize) -> String {
    match chains {
        1 => "the chain did not pass".to_owned(),
        chains => format!("none of the {chains} chains passed"),
    }
}

/// The sentence that no chain found what was asked for.
pub(super) fn none_granted(found: &Synthesis) -> String {
    let wishes: Vec<&str> = found.wishes.iter().map(|wish| wish.wish.as_str()).collect();
    let refused: Vec<&str> = found
        .wishes
        .iter()
        .flat_map(|wish| &wish.refused)
        .map(|(reason, _)| reason.as_str())
        .collect();
    format!(
        "{}: none of {} found this (most often: {}); run more (-n), or ask for another object or grasp",
        wishes.join(", "),
        counted(found.chains.len(), "chain"),
        refused.first().unwrap_or(&"nothing")
    )
}

/// What to do if no chain passes the filter.
pub(super) const REMEDY: &str =
    "run more (-n) or longer ones (--steps with --fresh), or keep others (--keep)";

/// The JSON document without what is known only after the file is written.
pub(super) fn value(found: &Synthesis, seconds: f64) -> Value {
    let chains = &found.chains;
    let count = |test: fn(&Judgement) -> bool| chains.iter().filter(|(_, j)| test(j)).count();
    json!({
        "chains": chains.len(),
        "strict": count(Judgement::passes_strict),
        "published": count(Judgement::passes_published),
        "released": count(Judgement::passes_released),
        "refused": BTreeMap::from_iter(reasons(found)),
        "kept": found.grasps.len(),
        "wishes": found.wishes.iter().map(|wish| json!({
            "wish": wish.wish,
            "chains": wish.chains,
            "found": wish.found,
            "refused": numbers(&wish.refused),
        })).collect::<Vec<_>>(),
        "evaluations": chains.iter().map(|(end, _)| end.evaluations).sum::<u64>(),
        "seconds": seconds,
    })
}

/// Why chains fail the strict filter, with their numbers, most frequent first.
fn reasons(found: &Synthesis) -> Vec<(String, usize)> {
    let chains = found.chains.iter();
    tally(chains.filter_map(|(_, judgement)| judgement.strict_objection()))
}

/// How diverse the grasps are that pass the strict filter. One or two grasps are always on a line.
pub(super) fn diversity(energy: &GraspEnergy, found: &Synthesis) -> Option<Diversity> {
    let chains = found.chains.iter();
    let strict = chains.filter(|(_, judgement)| judgement.passes_strict());
    let strict: Vec<_> = strict.map(|(end, _)| &end.refined).collect();
    let few = strict.len() < 3;
    Diversity::of(energy.hand(), energy.object(), strict.into_iter()).filter(|_| !few)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_of_drops_are_sentences() {
        for (held, dropped, all, told) in [
            (21, 21, 21, "all 21 hold when dropped in simulation"),
            (1, 1, 1, "1 of 1 holds when dropped in simulation"),
            (0, 2, 2, "none of 2 holds when dropped in simulation"),
            (19, 21, 21, "19 of 21 hold when dropped in simulation"),
            (
                32,
                32,
                60,
                "all 32 hold when dropped in simulation (32 of 60 grasps were dropped)",
            ),
        ] {
            assert_eq!(hold(held, dropped, all).trim_end(), told);
        }
    }
}
