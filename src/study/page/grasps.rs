//! The grasps of a file on a page.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::labels::{Key, labels};
use super::likeness::{self, Likeness};
use super::pack::{Pack, Texts};
use super::touch::{Touch, packed, touches};
use super::{Scenes, known, subject};
use crate::energy::Energy;
use crate::evaluation::taxonomy::{Label, Rule, Taxonomy};
use crate::printable::counted;
use crate::store::{GraspFile, GraspRow};
use crate::study::Counted;
use crate::study::diversity::Counter;
use crate::study::drawing::Titles;
use crate::study::error::StudyError;
use crate::study::names::MinimumName;

/// Greatest number of touched places of a grasp, and if there are more than [`MANY`] grasps.
const TOUCHES: [usize; 2] = [24, 8];
const MANY: usize = 1000;

/// The grasps of a file, to be shown on a page.
#[derive(Debug, Clone, Copy)]
pub struct PageGrasps<'a> {
    /// Name of the file.
    pub name: &'a str,
    /// Its content.
    pub file: &'a GraspFile,
    /// Labels by the rule, by id.
    pub labels: &'a BTreeMap<u64, Label>,
}

/// A grasp of a population with what is shown of it.
struct Shown<'a> {
    row: &'a GraspRow,
    scene: usize,
    touches: Vec<Touch>,
    /// The parts of the hand that touch.
    regions: String,
    /// Whether it passes the strict filter; `None` if it was not judged.
    strict: Option<bool>,
}

impl PageGrasps<'_> {
    /// The grasps as an entry of the header.
    pub(super) fn side(&self, scenes: &mut Scenes, pack: &mut Pack) -> Result<Value, StudyError> {
        let (mut shown, mut pictures) = (Vec::new(), Vec::new());
        let step = known::step(self.file.grasps.len());
        for population in self.file.landscapes() {
            let energy = population.energy()?;
            let (hand, object) = (energy.hand(), energy.object());
            let named = (population.object.name.as_str(), population.scale, &**object);
            let scene = scenes.add(pack, (&population.hand.name, hand), named);
            let most = TOUCHES[usize::from(self.file.grasps.len() > MANY)];
            let counter = Counter::new(hand, object, Rule::standard());
            let first = shown.len();
            let of_population = population
                .grasps
                .par_iter()
                .enumerate()
                .map(|(k, row)| Shown {
                    row,
                    scene,
                    touches: touches(&energy, &row.grasp, most),
                    regions: counter.touching(&row.grasp.pose),
                    strict: (first + k)
                        .is_multiple_of(step)
                        .then(|| known::strict(&energy, row)),
                });
            shown.extend(of_population.collect::<Vec<_>>());
            let poses: Vec<&[f64]> = (population.grasps.iter())
                .map(|row| &row.grasp.pose[..])
                .collect();
            let name = subject(
                &population.hand.name,
                &population.object.name,
                population.scale,
            );
            pictures.push((name, Likeness::of(energy.space(), &poses)));
        }
        let mut side = self.rows(&shown, pack);
        side["title"] = json!(self.title(&pictures));
        side["likeness"] = likeness::packed(&pictures, pack);
        let named = self.named(&shown);
        let curves = likeness::curves(&kinds(&shown, named.as_deref()));
        side["rarefaction"] = likeness::told(&curves);
        let judged = || shown.iter().filter_map(|shown| shown.strict);
        let judged = [judged().filter(|passes| *passes).count(), judged().count()];
        side["trust"] = known::statements(self.file, judged, &curves);
        let labels = named.map(|named| labels(&named, pack));
        if let (Value::Object(side), Some(Value::Object(labels))) = (&mut side, labels) {
            side.extend(labels);
        }
        Ok(side)
    }

    /// How many grasps of which hand on what.
    fn title(&self, pictures: &[(String, Likeness)]) -> String {
        let rows = &self.file.grasps;
        if let ([_], Some(row)) = (pictures, rows.first()) {
            return Titles::of_grasps(rows.len(), [&row.hand, &row.object], 0).title;
        }
        let distinct = |name: fn(&GraspRow) -> &str| {
            let names: std::collections::BTreeSet<&str> = rows.iter().map(name).collect();
            names.len()
        };
        format!(
            "{}, {} on {}",
            counted(rows.len(), "grasp"),
            counted(distinct(|row| &row.hand), "hand"),
            counted(distinct(|row| &row.object), "object")
        )
    }

    /// The key of the labels in a browser.
    fn key(&self) -> String {
        let mut key = Key::default();
        let metadata = &self.file.metadata;
        for hand in &metadata.hands {
            key.text(&hand.name);
            key.text(&hand.content_hash);
        }
        for object in &metadata.objects {
            key.text(&object.name);
            key.text(&object.content_hash);
        }
        for row in &self.file.grasps {
            key.text(&row.id.to_string());
            key.text(&row.hand);
            key.text(&row.object);
            key.numbers(&[row.scale]);
            key.numbers(&row.grasp.pose);
        }
        key.finish()
    }

    fn rows(&self, shown: &[Shown<'_>], pack: &mut Pack) -> Value {
        let rows = || shown.iter().map(|shown| shown.row);
        // Hands of several kinds have different numbers of joints.
        let dimensions = rows().map(|row| row.grasp.pose.len()).max().unwrap_or(0);
        let coordinates: Vec<f64> = rows()
            .flat_map(|row| {
                let rest = dimensions - row.grasp.pose.len();
                row.grasp
                    .pose
                    .iter()
                    .copied()
                    .chain(std::iter::repeat_n(0.0, rest))
            })
            .collect();
        let energies: Vec<f64> = rows().map(|row| row.energy).collect();
        let terms: Vec<f64> = rows().flat_map(|row| row.terms.iter().copied()).collect();
        let metadata = &self.file.metadata;
        let whole = terms.len() == metadata.terms.len() * shown.len();
        let stability = |row: &GraspRow| row.stable.map_or(2, u8::from);
        let objects: Texts = rows().map(|row| row.object.as_str()).collect();
        let places: Vec<Vec<Touch>> = shown.iter().map(|shown| shown.touches.clone()).collect();
        json!({
            "name": self.name,
            "key": self.key(),
            "item": "grasp",
            "command": metadata.command,
            "program": metadata.program_version,
            "energy_label": "energy E(H, O)",
            "members_label": "grasps",
            "count": shown.len(),
            "space": { "kind": "pose", "dimensions": dimensions },
            "scenes": pack.wholes(shown.iter().map(|shown| shown.scene)),
            "object": objects.packed(pack),
            "coordinates": pack.floats(&coordinates),
            "energy": pack.doubles(&energies),
            // Texts, because numbers in scripts are exact only up to 2⁵³.
            "members": rows().map(|row| row.id.to_string()).collect::<Vec<_>>(),
            "term_names": if whole { metadata.terms.clone() } else { Vec::new() },
            "terms": pack.floats(if whole { &terms } else { &[] }),
            "epsilon": pack.known_floats(rows().map(|row| row.epsilon)),
            "stable": pack.bytes(rows().map(stability)),
            "touches": packed(&places, pack),
        })
    }

    /// The labels and names of all grasps; `None` if the rule does not apply to a hand.
    fn named<'a>(&self, shown: &[Shown<'a>]) -> Option<Vec<(Option<&'a str>, MinimumName)>> {
        let named = shown.iter().map(|Shown { row, .. }| {
            let label = self.labels.get(&row.id)?.clone();
            let given = row.label.as_deref().filter(|label| !label.is_empty());
            Some((given, MinimumName::new(given, label)))
        });
        named.collect()
    }
}

/// Numbers of grasps by kind, for each way of counting kinds.
fn kinds(
    shown: &[Shown<'_>],
    named: Option<&[(Option<&str>, MinimumName)]>,
) -> BTreeMap<&'static str, BTreeMap<String, usize>> {
    let count = |kinds: &mut dyn Iterator<Item = String>| {
        let mut counts = BTreeMap::new();
        kinds.for_each(|kind| *counts.entry(kind).or_insert(0) += 1);
        counts
    };
    let names = named.into_iter().flatten().map(|(_, name)| name);
    let mut types = names
        .filter(|name| name.number.is_some())
        .map(|name| name.text().to_owned());
    let mut regions = shown.iter().map(|shown| shown.regions.clone());
    [
        (Counted::Contacts.name(), count(&mut regions)),
        ("grasp types", count(&mut types)),
    ]
    .into()
}

/// The 33 types, for the matrix and the chooser.
pub(super) fn taxonomy() -> Value {
    let types = Taxonomy::feix().types.iter();
    let entry = types.map(|entry| {
        json!({
            "number": entry.number,
            "name": entry.name,
            "aliases": entry.aliases,
            "category": entry.category.name(),
            "cell": entry.cell,
            "cue": entry.cue,
        })
    });
    entry.collect()
}
