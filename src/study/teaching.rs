//! Labelled grasps of files, from which a labeller is taught.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::{HumanLabel, Run, human_label};
use crate::evaluation::taxonomy::{Example, Labeller, Rule, TaughtWith};
use crate::store::{GraspFile, GraspRow, RebuildError};
use crate::topography::Phase;

/// The grasps of a file that a person labelled, as examples for a labeller. Labels that are no type of the taxonomy are left
/// out, and so are grasps to which it does not apply. Examples of one object are one group, whatever its scale.
///
/// `rule` must be one without a labeller. `source` has the name of the file and the hash of its bytes.
///
/// # Errors
/// If a hand or an object cannot be built.
pub fn examples(
    file: &GraspFile,
    rule: &Rule,
    source: (&str, &str),
    run: &Run<'_>,
) -> Result<(Vec<Example>, TaughtWith), RebuildError> {
    let given = |row: &GraspRow| human_label(row.label.as_deref()?).map(HumanLabel::class);
    let count = file
        .grasps
        .iter()
        .filter(|row| given(row).is_some())
        .count();
    let tally = run.tally(Phase::Label, count);
    let mut examples = Vec::new();
    let [mut hands, mut objects] = [BTreeSet::new(), BTreeSet::new()];
    for population in file.landscapes() {
        let rows: Vec<(&GraspRow, usize)> = (population.grasps.iter())
            .filter_map(|row| Some((*row, given(row)?)))
            .collect();
        if rows.is_empty() {
            continue;
        }
        let (hand, object) = (population.hand()?, population.object()?);
        let labeller = Labeller::new(&hand, &object, rule);
        let example = |(row, class): &(&GraspRow, usize)| {
            let pose = &row.grasp.pose;
            let found = labeller.example(pose, &labeller.label(pose));
            tally.tick();
            let (features, rule) = found?;
            Some(Example {
                group: row.object.clone(),
                features,
                rule,
                class: *class,
            })
        };
        let found: Vec<Option<Example>> = rows.par_iter().map(example).collect();
        let before = examples.len();
        examples.extend(found.into_iter().flatten());
        if examples.len() > before {
            hands.insert(population.hand.name.clone());
            objects.insert(population.object.name.clone());
        }
    }
    let (name, content_hash) = source;
    let taught_with = TaughtWith {
        file: name.to_owned(),
        content_hash: content_hash.to_owned(),
        labels: examples.len(),
        hands: hands.into_iter().collect(),
        objects: objects.into_iter().collect(),
    };
    Ok((examples, taught_with))
}
