//! Labels of the rule on fixtures, and how often they are right.

use std::path::Path;
use std::sync::Arc;

use landscape::evaluation::taxonomy::{
    Anatomy, Label, Labeller, Rule, Taxonomy, TouchingPatch, Verdict, held, label_contacts, touches,
};
use landscape::hand::{Hand, PosedHand};
use landscape::object::{Assembly, Object, Primitive};
use landscape::sample::{Task, stream};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::fixture::Fixture;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// The true type and the rule's label.
pub(crate) struct Outcome {
    /// Id of the fixture.
    pub(crate) id: String,
    /// Number of the type; `None` outside the taxonomy.
    pub(crate) truth: Option<u8>,
    pub(crate) label: Label,
}

/// Meaning of an error of a joint angle.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Error {
    /// The hand really has this pose. Touching parts may then be apart or penetrate, and others may touch.
    Moved,
    /// The angle is measured wrongly, but the contacts are known.
    Misread,
}

/// Errors of the joint angles: independent normal errors, clamped at the limits.
#[derive(Clone, Copy)]
pub(crate) struct Noise {
    pub(crate) error: Error,
    /// Standard deviation of each joint angle.
    pub(crate) joints_rad: f64,
    /// Number of noisy poses of each fixture.
    pub(crate) copies: u64,
    pub(crate) seed: u64,
}

impl Noise {
    /// Fixtures without errors.
    pub(crate) const NONE: Self = Self {
        error: Error::Moved,
        joints_rad: 0.0,
        copies: 1,
        seed: 0,
    };
}

impl Outcome {
    /// The best type, regardless of the thresholds.
    pub(crate) fn found(&self) -> Option<u8> {
        self.label.best.first().map(|best| best.number)
    }

    /// Whether the rule assigns a type or a cell.
    pub(crate) fn accepted(&self) -> bool {
        matches!(
            self.label.verdict,
            Verdict::Listed(_) | Verdict::Ambiguous(_) | Verdict::Broad(_)
        )
    }

    /// Whether the distance of the best type from the true one is at most `within` (see `GraspType::distance`): 3 means
    /// that the category is right, 1 the cell, 0 the type.
    pub(crate) fn right(&self, within: u8) -> bool {
        let entry = |number: Option<u8>| Taxonomy::feix().numbered(number?);
        let pair = entry(self.truth).zip(entry(self.found()));
        pair.is_some_and(|(truth, found)| truth.distance(found) <= within)
    }
}

/// A posed hand with its object.
pub(crate) struct Case {
    id: String,
    kind: Option<u8>,
    hand: Arc<Hand>,
    x: Vec<f64>,
    object: Object,
}

/// The fixtures of a file.
pub(crate) fn read(path: &Path) -> Result<Vec<Fixture>, Failure> {
    Ok(serde_json::from_str(&std::fs::read_to_string(path)?)?)
}

/// Fixtures with their objects. Each takes a second to prepare.
pub(crate) fn cases(fixtures: Vec<Fixture>) -> Result<Vec<Case>, Failure> {
    let hand = Arc::new(Hand::human());
    let case = |fixture: Fixture| -> Result<Case, Failure> {
        let id = fixture.id.clone();
        let x = fixture.coordinates(&hand);
        Ok(Case {
            object: assembled(&id, fixture.object)?,
            x: x.ok_or_else(|| format!("{id} has other joints than the hand"))?,
            hand: hand.clone(),
            kind: fixture.kind,
            id,
        })
    };
    fixtures.into_par_iter().map(case).collect()
}

fn assembled(id: &str, parts: Vec<Primitive>) -> Result<Object, Failure> {
    let assembly = Assembly {
        parts,
        ..Assembly::default()
    };
    let (mesh, description) = assembly.object(id)?;
    Ok(Object::from_mesh(id, mesh, &description)?)
}

/// Labels of all copies of all fixtures, in order.
pub(crate) fn judge(cases: &[Case], rule: &Rule, noise: Noise) -> Result<Vec<Outcome>, Failure> {
    let of_case = |(index, case): (usize, &Case)| -> Result<Vec<Outcome>, Failure> {
        let Case {
            id,
            kind,
            hand,
            x,
            object,
        } = case;
        let anatomy = Anatomy::of(hand)?;
        let labeller = Labeller::new(hand, object, rule);
        let mut posed = PosedHand::default();
        hand.pose(x, &mut posed);
        let near = touches(hand, &anatomy, &posed, object);
        let held = held(object, &near, &anatomy.palm_axes(&posed).volar);
        let misread = |x: &[f64]| {
            let mut read = PosedHand::default();
            hand.pose(x, &mut read);
            let carried: Vec<TouchingPatch> =
                near.iter().map(|t| t.carried(&posed, &read)).collect();
            label_contacts(rule, &anatomy, &read, &carried, held.clone())
        };
        let labelled = |copy: u64| {
            let mut x = x.clone();
            let mut random = stream(noise.seed, Task::Start, noise.copies * index as u64 + copy);
            for (angle, joint) in x[7..].iter_mut().zip(&hand.joints) {
                let step: f64 = StandardNormal.sample(&mut random);
                let [lower, upper] = joint.limits;
                // Some fixtures are a hair beyond a limit: without noise nothing moves.
                if noise.joints_rad > 0.0 {
                    *angle = (*angle + noise.joints_rad * step).clamp(lower, upper);
                }
            }
            let label = match noise.error {
                Error::Moved => labeller.label(&x),
                Error::Misread => misread(&x),
            };
            Outcome {
                id: id.clone(),
                truth: *kind,
                label,
            }
        };
        Ok((0..noise.copies).map(labelled).collect())
    };
    let outcomes: Vec<Vec<Outcome>> = (cases.par_iter().enumerate())
        .map(of_case)
        .collect::<Result<_, _>>()?;
    Ok(outcomes.into_iter().flatten().collect())
}

/// The share of the outcomes that pass a test; `None` if there are none.
pub(crate) fn share(outcomes: &[&Outcome], test: impl Fn(&Outcome) -> bool) -> Option<f64> {
    let passing = outcomes.iter().filter(|outcome| test(outcome)).count();
    (!outcomes.is_empty()).then(|| passing as f64 / outcomes.len() as f64)
}

/// Outcomes of grasps of the taxonomy, and of other poses.
pub(crate) fn halves(outcomes: &[Outcome]) -> [Vec<&Outcome>; 2] {
    let (grasps, others) = outcomes.iter().partition(|outcome| outcome.truth.is_some());
    [grasps, others]
}
