//! Claims H7, H9 and H10, which evaluate the energy: along paths, with lifted fingers, and on other hands.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::fisher::fisher_exact;
use super::{Failure, Finding, Verdict, insufficient};
use landscape::agreement::spearman;
use landscape::evaluation::taxonomy::{Anatomy, Category, Labeller, PalmPart, Patch, Taxonomy};
use landscape::grasp::{Grasp, GraspEnergy, judge};
use landscape::hand::{Hand, PosedHand};
use landscape::space::{Pose, interpolate, joints_of_mut};
use landscape::study::{MinimaxPath, MinimumName, NamedLandscape, Waypoint, settings_for_grasps};
use landscape::topography::{MinimumId, Run, quench_all};

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Smooth {
    pub(super) claim: String,
    precision: Vec<u8>,
    power: Vec<u8>,
    others: Vec<u8>,
    least_points: usize,
    most_ways: usize,
    least_monotony: f64,
    level: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Lifted {
    pub(super) claim: String,
    spheres: Vec<u8>,
    least_share: f64,
    /// Expected grasp type for each set of lifted fingers.
    becomes: BTreeMap<String, u8>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Thumbless {
    pub(super) claim: String,
}

pub(super) struct Experiments<'a> {
    landscape: &'a NamedLandscape<'a>,
    energy: GraspEnergy,
    least_per_class: usize,
}

/// Measurements along one path.
struct Way {
    /// Fraction of its points that pass the published filter.
    passing: f64,
    /// Rank correlation between position and gap under the palm.
    monotony: f64,
}

impl<'a> Experiments<'a> {
    pub(super) fn new(
        landscape: &'a NamedLandscape<'a>,
        least_per_class: usize,
    ) -> Result<Self, Failure> {
        let energy = (landscape.setting).energy(landscape.files, &landscape.name)?;
        Ok(Self {
            landscape,
            energy,
            least_per_class,
        })
    }

    fn minima(&self, keep: impl Fn(&MinimumName) -> bool) -> Vec<usize> {
        let numbered = self.landscape.names.iter().enumerate();
        numbered
            .filter(|(_, named)| keep(named))
            .map(|(i, _)| i)
            .collect()
    }

    fn of_types(&self, types: &[u8]) -> Vec<usize> {
        self.minima(|named| named.number.is_some_and(|number| types.contains(&number)))
    }

    /// H7: paths between precision and power spheres, compared with those between precision grasps and cylinders.
    pub(super) fn smooth(&self, asked: &Smooth) -> Result<Finding, Failure> {
        let spheres = [&asked.precision, &asked.power].map(|types| self.of_types(types));
        let cylinders = self.of_types(&asked.others);
        let precision = self.minima(|named| named.category == Some(Category::Precision));
        if spheres.iter().any(Vec::is_empty) || cylinders.is_empty() || precision.is_empty() {
            return Ok(insufficient(
                "H7",
                &asked.claim,
                &format!(
                    "minima: {} precision sphere, {} power sphere, {} cylinder",
                    spheres[0].len(),
                    spheres[1].len(),
                    cylinders.len()
                ),
            ));
        }
        let ways = self.ways(asked, &spheres[1], &spheres[0])?;
        let others = self.ways(asked, &cylinders, &precision)?;
        let whole = |ways: &[Way]| ways.iter().filter(|way| way.passing >= 1.0).count();
        let [own, other] = [whole(&ways), whole(&others)];
        let p = fisher_exact([own, other], [ways.len(), others.len()]);
        let smooth = ways
            .iter()
            .filter(|way| way.passing >= 1.0 && way.monotony >= asked.least_monotony)
            .count();
        let best = |ways: &[Way]| ways.iter().map(|way| way.passing).fold(0.0, f64::max);
        Ok(Finding::new(
            "H7",
            &asked.claim,
            Verdict::of(smooth > 0 && p < asked.level),
            Some(p),
            format!(
                "{own} of {} ways between precision and power spheres pass Eq. 11 all along, {smooth} of them with a gap under \
                 the palm that grows all the way; of those between precision grasps and cylinders {other} of {} (Fisher p \
                 {p:.4}); best way passes {:.0} % (cylinders {:.0} %)",
                ways.len(),
                others.len(),
                100.0 * best(&ways),
                100.0 * best(&others)
            ),
        ))
    }

    /// The lowest paths between the minima of two lists.
    fn ways(&self, asked: &Smooth, from: &[usize], to: &[usize]) -> Result<Vec<Way>, Failure> {
        let height = |a: usize, b: usize| self.landscape.tree.minimax(MinimumId(a), MinimumId(b));
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for &a in from {
            for &b in to {
                if let Some(height) = height(a, b).filter(|h| a != b && h.is_finite()) {
                    let floor = self.landscape.files.minima[a]
                        .energy
                        .max(self.landscape.files.minima[b].energy);
                    pairs.push((height - floor, a, b));
                }
            }
        }
        pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        pairs.truncate(asked.most_ways);
        let found: Vec<Option<Way>> = pairs
            .par_iter()
            .map(|&(_, a, b)| self.way(asked, MinimumId(a), MinimumId(b)))
            .collect::<Result<_, Failure>>()?;
        Ok(found.into_iter().flatten().collect())
    }

    fn way(&self, asked: &Smooth, a: MinimumId, b: MinimumId) -> Result<Option<Way>, Failure> {
        let space = self.energy.pose_space();
        let path =
            MinimaxPath::between(self.landscape.files, &self.landscape.network, space, [a, b])?;
        let Some(MinimaxPath { points: images, .. }) = path else {
            return Ok(None);
        };
        let between = asked.least_points.div_ceil(images.len().max(2) - 1).max(1);
        let x = |image: &Waypoint| image.point.coordinates.clone();
        let mut points: Vec<Vec<f64>> = Vec::new();
        for pair in images.windows(2) {
            for part in 0..between {
                let t = part as f64 / between as f64;
                points.push(interpolate(space, &x(&pair[0]), &x(&pair[1]), t));
            }
        }
        points.extend(images.last().map(x));
        let passing = points
            .iter()
            .filter(|x| {
                judge(&self.energy, &Grasp::best(&self.energy, (*x).clone())).passes_published()
            })
            .count();
        let gaps: Vec<f64> = points.iter().map(|x| self.palm_gap_m(x)).collect();
        let order: Vec<f64> = (0..points.len()).map(|i| i as f64).collect();
        Ok(Some(Way {
            passing: passing as f64 / points.len() as f64,
            monotony: spearman(&order, &gaps),
        }))
    }

    /// Distance of the palm from the object, metres.
    fn palm_gap_m(&self, x: &[f64]) -> f64 {
        let hand = self.energy.hand();
        let mut posed = PosedHand::default();
        hand.pose(x, &mut posed);
        let Ok(anatomy) = Anatomy::of(hand) else {
            return f64::NAN;
        };
        (0..hand.surface.len())
            .filter(|&i| anatomy.patch(i) == Patch::Palm(PalmPart::Volar))
            .map(|i| self.energy.object().exact.distance(&posed.points[i]))
            .fold(f64::INFINITY, f64::min)
    }

    /// H9: grasp types of sphere grasps after fingers are lifted.
    pub(super) fn lifted(&self, asked: &Lifted) -> Result<Finding, Failure> {
        let spheres = self.of_types(&asked.spheres);
        if spheres.len() < self.least_per_class {
            return Ok(insufficient(
                "H9",
                &asked.claim,
                &format!("{} sphere minima", spheres.len()),
            ));
        }
        let hand = self.energy.hand();
        let quench = settings_for_grasps(&self.energy).quench;
        let labeller = Labeller::new(hand, self.energy.object(), self.landscape.rule);
        let mut became = vec![false; spheres.len()];
        let mut told = Vec::new();
        for (fingers, kind) in &asked.becomes {
            let starts: Vec<Vec<f64>> = spheres
                .iter()
                .map(|&i| straightened(hand, &self.landscape.files.minima[i].coordinates, fingers))
                .collect();
            let ends = quench_all(&self.energy, &starts, &quench, &Run::default())?;
            let mut counts = [0, 0, 0];
            for (place, end) in ends.iter().enumerate() {
                let label = labeller.label(&end.x);
                let like = label.best.first().map(|best| best.number) == Some(*kind);
                let valid =
                    judge(&self.energy, &Grasp::best(&self.energy, end.x.clone())).passes_strict();
                counts[0] += usize::from(like);
                counts[1] += usize::from(valid);
                counts[2] += usize::from(like && valid);
                became[place] |= like && valid;
            }
            let name = Taxonomy::feix().numbered(*kind);
            told.push(format!(
                "{fingers} lifted: {} like {}, {} valid, {} both",
                counts[0],
                name.map_or("", |entry| &entry.name),
                counts[1],
                counts[2]
            ));
        }
        let share = became.iter().filter(|became| **became).count() as f64 / spheres.len() as f64;
        Ok(Finding::new(
            "H9",
            &asked.claim,
            Verdict::of(share >= asked.least_share),
            None,
            format!(
                "of {} sphere minima, after relaxing: {}; {:.0} % became one or the other and stayed valid",
                spheres.len(),
                told.join("; "),
                100.0 * share
            ),
        ))
    }

    /// H10: the same poses on a hand without a thumb, and labels of grippers.
    pub(super) fn thumbless(&self, asked: &Thumbless) -> Result<Finding, Failure> {
        let hand = self.energy.hand();
        let other = Hand::named("human_thumbless")?;
        let joints: Option<Vec<usize>> = other
            .joints
            .iter()
            .map(|joint| hand.joint(&joint.name))
            .collect();
        let Some(joints) = joints else {
            return Ok(Finding::new(
                "H10",
                &asked.claim,
                Verdict::NotTested,
                None,
                "the poses are those of another hand than the human one".to_owned(),
            ));
        };
        let energy = GraspEnergy::new(
            other.into(),
            self.energy.object().clone(),
            *self.energy.settings(),
        )?;
        let labeller = Labeller::new(energy.hand(), energy.object(), self.landscape.rule);
        let poses: Vec<Vec<f64>> = self
            .landscape
            .files
            .minima
            .iter()
            .map(|row| {
                let known = Pose::from(row.coordinates.clone());
                let kept: Vec<f64> = joints.iter().map(|&joint| known.joints()[joint]).collect();
                let translation_m = std::array::from_fn(|k| known[k]);
                Pose::new(translation_m, known.rotation_wxyz(), &kept).into()
            })
            .collect();
        let taxonomy = Taxonomy::feix();
        let uses_thumb = |x: &Vec<f64>| {
            let best = labeller.label(x).best;
            best.iter().any(|candidate| {
                let entry = taxonomy.numbered(candidate.number);
                entry.is_some_and(|entry| entry.uses(1))
            })
        };
        let wrong = poses.par_iter().filter(|x| uses_thumb(x)).count();
        let valid = poses
            .par_iter()
            .filter(|x| judge(&energy, &Grasp::best(&energy, (*x).clone())).passes_strict())
            .count();
        let mut guessed = Vec::new();
        for name in ["gripper_three_finger", "gripper_parallel"] {
            let gripper = Hand::named(name)?;
            if Labeller::new(&gripper, self.energy.object(), self.landscape.rule).applies() {
                guessed.push(name);
            }
        }
        Ok(Finding::new(
            "H10",
            &asked.claim,
            Verdict::of(wrong == 0 && guessed.is_empty()),
            None,
            format!(
                "the minima's poses on the human hand without its thumb: {wrong} of {} with a thumb type among the best three, \
                 {valid} still pass the strict filter; grippers to which the rule applies: {}",
                poses.len(),
                if guessed.is_empty() {
                    "none".to_owned()
                } else {
                    guessed.join(", ")
                }
            ),
        ))
    }
}

/// The pose with the given fingers straight: `little`, or `little and ring`. The palm does not change.
fn straightened(hand: &Hand, x: &[f64], fingers: &str) -> Vec<f64> {
    let straight = hand.straight_joints();
    let mut x = x.to_vec();
    for (joint, angle) in straight.iter().enumerate() {
        let moves = hand.links.iter().find(|link| {
            link.motion
                .as_ref()
                .is_some_and(|motion| motion.joint == joint)
        });
        let digit = moves.map_or("", |link| hand.digits[link.digit].as_str());
        if fingers.split(" and ").any(|finger| finger == digit) {
            joints_of_mut(&mut x)[joint] = *angle;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use landscape::space::joints_of;

    #[test]
    fn only_the_fingers_named_are_straightened() {
        let hand = Hand::human();
        let bent: Vec<f64> = hand.rest_coordinates().iter().map(|q| q + 0.3).collect();
        let lifted = straightened(&hand, &bent, "little and ring");
        let straight = hand.straight_joints();
        for (joint, known) in hand.joints.iter().enumerate() {
            // The metacarpal of the little finger is part of the palm.
            let named = known.name != "little_cmc_flexion"
                && ["little", "ring"]
                    .iter()
                    .any(|finger| known.name.starts_with(finger));
            let wanted = if named {
                straight[joint]
            } else {
                joints_of(&bent)[joint]
            };
            assert!(
                (joints_of(&lifted)[joint] - wanted).abs() < 1e-12,
                "{}",
                known.name
            );
        }
    }
}
