//! Summary statistics of a population of grasps.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use serde::Serialize;

use super::grasps::friction;
use super::{number, table};
use crate::store::Population;
use crate::study::JudgedGrasp;

/// Numbers of grasps that pass the filters.
#[derive(Debug, Serialize)]
pub(super) struct Landscape {
    hand: String,
    object: String,
    scale: f64,
    grasps: usize,
    passes_strict: usize,
    passes_published: usize,
    passes_released: usize,
    /// Counts of the first failed conditions of the strict filter.
    objections: BTreeMap<&'static str, usize>,
    /// Number of grasps that touch with each link.
    touched_by: BTreeMap<String, usize>,
}

impl Landscape {
    pub(super) fn of(population: &Population<'_>, judged: &[JudgedGrasp]) -> Self {
        let count =
            |test: fn(&JudgedGrasp) -> bool| judged.iter().filter(|grasp| test(grasp)).count();
        let mut objections = BTreeMap::new();
        let mut touched_by = BTreeMap::new();
        for grasp in judged {
            if let Some(reason) = grasp.objection {
                *objections.entry(reason).or_default() += 1;
            }
            let links: BTreeSet<&String> =
                grasp.contacts.iter().map(|contact| &contact.link).collect();
            for link in links {
                *touched_by.entry(link.clone()).or_default() += 1;
            }
        }
        Self {
            hand: population.hand.name.clone(),
            object: population.object.name.clone(),
            scale: population.scale,
            grasps: judged.len(),
            passes_strict: count(|grasp| grasp.objection.is_none()),
            passes_published: count(|grasp| grasp.passes_published),
            passes_released: count(|grasp| grasp.passes_released),
            objections,
            touched_by,
        }
    }

    pub(super) fn title(&self) -> String {
        let scale = if (self.scale - 1.0).abs() > f64::EPSILON {
            format!(", scale {}", self.scale)
        } else {
            String::new()
        };
        let (grasps, hand, object) = (self.grasps, &self.hand, &self.object);
        format!("{grasps} grasps of the {hand} hand on {object}{scale}\n\n")
    }
}

/// The landscape as a page of text.
pub(super) fn summary(landscape: &Landscape, judged: &[JudgedGrasp]) -> String {
    let mut text = landscape.title();
    let total = landscape.grasps;
    let share = |count: usize| {
        let percent = 100.0 * count as f64 / total as f64;
        format!("{count} of {total} ({percent:.0} %)")
    };
    for (filter, count) in [
        ("strict filter", landscape.passes_strict),
        ("Eq. 11 as printed", landscape.passes_published),
        ("Eq. 11 as released", landscape.passes_released),
    ] {
        let _ = writeln!(text, "{filter:<20} {}", share(count));
    }
    for (reason, count) in by_frequency(&landscape.objections) {
        let _ = writeln!(text, "  refused for {reason}: {count}");
    }
    text.push('\n');
    text.push_str(&quantiles(judged));
    text.push_str("\ntouched by\n");
    let mut rows = Vec::new();
    for (link, count) in by_frequency(&landscape.touched_by) {
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
        ("digits in contact", |grasp| grasp.judgement.digits as f64),
        ("energy", |grasp| grasp.energy),
    ];
    let header = ["", "least", "10 %", "median", "90 %", "most"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    let mut row = |name: String, mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        let last = values.len() - 1;
        // Quantiles in tenths, rounded to the nearest grasp, since friction may be infinite.
        let at = |tenths: usize| number(values[(last * tenths + 5) / 10]);
        let mut cells = vec![name];
        cells.extend([0, 1, 5, 9, 10].map(at));
        rows.push(cells);
    };
    for (name, value) in measures {
        row(name.to_owned(), judged.iter().map(value).collect());
    }
    let terms = judged
        .first()
        .into_iter()
        .flat_map(|grasp| grasp.terms.keys());
    for term in terms {
        let values = judged.iter().map(|grasp| grasp.terms[term]);
        row(format!("  {term}"), values.collect());
    }
    table(&rows)
}
