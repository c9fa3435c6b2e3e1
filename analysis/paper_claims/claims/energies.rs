//! Claims H9 and H10, which evaluate the energy: with lifted fingers, and on a hand without a thumb.

use super::{Claim, Claims, Failure, Finding, Verdict};
use landscape::evaluation::taxonomy::{Labeller, Taxonomy};
use landscape::grasp::{Grasp, GraspEnergy, judge};
use landscape::hand::Hand;
use landscape::space::{Pose, joints_of_mut};
use landscape::study::{NamedLandscape, settings_for_grasps};
use landscape::topography::{Run, quench_all};
use rayon::prelude::*;

pub(super) fn examine(
    landscape: &NamedLandscape<'_>,
    claims: &Claims,
) -> Result<[Finding; 2], Failure> {
    let energy = (landscape.setting).energy(landscape.files, &landscape.name)?;
    let lifted = lifted(landscape, &energy, claims)?;
    Ok([lifted, thumbless(landscape, &energy, claims.get("H10"))?])
}

fn passes_strict(energy: &GraspEnergy, x: &[f64]) -> bool {
    judge(energy, &Grasp::best(energy, x.to_vec())).passes_strict()
}

/// H9: grasp types of sphere grasps after fingers are lifted.
fn lifted(
    landscape: &NamedLandscape<'_>,
    energy: &GraspEnergy,
    claims: &Claims,
) -> Result<Finding, Failure> {
    let asked = claims.get("H9");
    let named = landscape.names.iter().zip(&landscape.files.minima);
    let spheres: Vec<&[f64]> = named
        .filter(|(named, _)| asked.has("spheres", named.number))
        .map(|(_, minimum)| &minimum.coordinates[..])
        .collect();
    if spheres.len() < claims.statistics.least_per_class {
        return Ok(asked.insufficient(&format!("{} sphere minima", spheres.len())));
    }
    let hand = energy.hand();
    let quench = settings_for_grasps(energy).quench;
    let labeller = Labeller::new(hand, energy.object(), landscape.rule);
    let mut became = vec![false; spheres.len()];
    let mut told = Vec::new();
    // The expected grasp type for each set of lifted fingers.
    let becomes = asked.thresholds["becomes"].as_table();
    for (fingers, kind) in becomes.into_iter().flatten() {
        let starts = spheres.iter().map(|x| straightened(hand, x, fingers));
        let starts: Vec<Vec<f64>> = starts.collect();
        let ends = quench_all(energy, &starts, &quench, &Run::default())?;
        let mut counts = [0, 0, 0];
        for (end, became) in ends.iter().zip(&mut became) {
            let best = labeller.label(&end.x).best;
            let like = best.first().map(|best| i64::from(best.number)) == kind.as_integer();
            let valid = passes_strict(energy, &end.x);
            for (count, met) in counts.iter_mut().zip([like, valid, like && valid]) {
                *count += usize::from(met);
            }
            *became |= like && valid;
        }
        let number = kind.as_integer().and_then(|kind| u8::try_from(kind).ok());
        let entry = number.and_then(|number| Taxonomy::feix().numbered(number));
        told.push(format!(
            "{fingers} lifted: {} like {}, {} valid, {} both",
            counts[0],
            entry.map_or("", |entry| &entry.name),
            counts[1],
            counts[2]
        ));
    }
    let share = became.iter().filter(|became| **became).count() as f64 / spheres.len() as f64;
    Ok(asked.finding(
        Verdict::of(share >= asked.number("least_share")),
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
fn thumbless(
    landscape: &NamedLandscape<'_>,
    energy: &GraspEnergy,
    asked: &Claim,
) -> Result<Finding, Failure> {
    let other = Hand::named("human_thumbless")?;
    let joints = other.joints.iter();
    let joints: Option<Vec<usize>> = joints
        .map(|joint| energy.hand().joint(&joint.name))
        .collect();
    let Some(joints) = joints else {
        let why = "the poses are those of another hand than the human one";
        return Ok(asked.finding(Verdict::NotTested, None, why.to_owned()));
    };
    let object = energy.object();
    let energy = GraspEnergy::new(other.into(), object.clone(), *energy.settings())?;
    let labeller = Labeller::new(energy.hand(), object, landscape.rule);
    let minima = landscape.files.minima.iter();
    let poses: Vec<Vec<f64>> = minima
        .map(|row| {
            let known = Pose::from(row.coordinates.clone());
            let kept: Vec<f64> = joints.iter().map(|&joint| known.joints()[joint]).collect();
            let translation_m = std::array::from_fn(|k| known[k]);
            Pose::new(translation_m, known.rotation_wxyz(), &kept).into()
        })
        .collect();
    let uses_thumb = |x: &&Vec<f64>| {
        let best = labeller.label(x).best.into_iter();
        let mut entries = best.filter_map(|best| Taxonomy::feix().numbered(best.number));
        entries.any(|entry| entry.uses(1))
    };
    let wrong = poses.par_iter().filter(uses_thumb).count();
    let valid = poses
        .par_iter()
        .filter(|x| passes_strict(&energy, x))
        .count();
    let mut guessed = Vec::new();
    for name in ["gripper_three_finger", "gripper_parallel"] {
        if Labeller::new(&Hand::named(name)?, object, landscape.rule).applies() {
            guessed.push(name);
        }
    }
    let holds = wrong == 0 && guessed.is_empty();
    if guessed.is_empty() {
        guessed.push("none");
    }
    Ok(asked.finding(
        Verdict::of(holds),
        None,
        format!(
            "the minima's poses on the human hand without its thumb: {wrong} of {} with a thumb type among the best three, \
             {valid} still pass the strict filter; grippers to which the rule applies: {}",
            poses.len(),
            guessed.join(", ")
        ),
    ))
}

/// The pose with the given fingers straight: `little`, or `little and ring`. The palm does not change.
fn straightened(hand: &Hand, x: &[f64], fingers: &str) -> Vec<f64> {
    let mut x = x.to_vec();
    let joints = joints_of_mut(&mut x);
    let straight = hand.straight_joints();
    for link in &hand.links {
        let digit = &hand.digits[link.digit];
        let lifted = fingers.split(" and ").any(|finger| finger == digit);
        if let Some(motion) = link.motion.as_ref().filter(|_| lifted) {
            joints[motion.joint] = straight[motion.joint];
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
            let finger = |finger: &&str| known.name.starts_with(*finger);
            let named = known.name != "little_cmc_flexion" && ["little", "ring"].iter().any(finger);
            let kept = joints_of(&bent)[joint];
            let wanted = if named { straight[joint] } else { kept };
            let found = joints_of(&lifted)[joint];
            assert!((found - wanted).abs() < 1e-12, "{}", known.name);
        }
    }
}
