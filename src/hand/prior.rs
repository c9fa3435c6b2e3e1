//! Rest pose and pose prior.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::model::{coordinates_of, within};
use super::side_file::SideFile;
use super::{HandError, Joint, JointKind, PosePrior};
use crate::limits::{JOINT_DEVIATION, Limit, SYNERGY_WEIGHT, VARIANCE_SHARE};

/// Standard deviation of a joint as a share of its range, so that the limits are two standard deviations from the middle.
const DEVIATION_OF_RANGE: f64 = 0.25;

/// The rest pose and the pose in which the skin is built, radians.
pub(super) fn poses(joints: &[Joint], side: &SideFile) -> Result<(Vec<f64>, Vec<f64>), HandError> {
    let mut rest: Vec<f64> = joints.iter().map(resting).collect();
    let given = [&side.rest_deg, &side.rest_mm];
    fill_measured(&mut rest, joints, ("rest", coordinates_of), given)?;
    let mut cast = rest.clone();
    fill_measured(
        &mut cast,
        joints,
        ("cast", coordinates_of),
        [&side.cast_deg, &BTreeMap::new()],
    )?;
    Ok((rest, cast))
}

/// Where a hinge rests, as a share of the way from straight (zero, or the limit nearest to zero) to the middle of its
/// range. Half-closed fingers would block the way to the palm.
const RESTING: f64 = 0.5;

/// The rest coordinate of a joint unless the side file gives one. A slide rests in the middle of its range.
fn resting(joint: &Joint) -> f64 {
    let [lower, upper] = joint.limits;
    let middle = f64::midpoint(lower, upper);
    match joint.kind {
        JointKind::Hinge => {
            let straight = 0.0f64.clamp(lower, upper);
            straight + RESTING * (middle - straight)
        }
        JointKind::Slide => middle,
    }
}

/// Reads the entries `…_deg` (degrees, hinges) and `…_mm` (millimetres, slides) of the side file. Each must be within
/// `limit`.
fn fill_measured(
    values: &mut [f64],
    joints: &[Joint],
    (entry, limit): (&str, fn(JointKind) -> Limit),
    [angles, lengths]: [&BTreeMap<String, f64>; 2],
) -> Result<(), HandError> {
    for (kind, unit, entries) in [
        (JointKind::Hinge, "deg", angles),
        (JointKind::Slide, "mm", lengths),
    ] {
        let place = format!("\"{entry}_{unit}\" of the side file");
        let other = |joint: &&Joint| joint.kind != kind && entries.contains_key(&joint.name);
        if let Some(joint) = joints.iter().find(other) {
            return Err(HandError::Unit {
                place,
                joint: joint.name.clone(),
            });
        }
        let convert = |value: f64| match kind {
            JointKind::Hinge => value.to_radians(),
            JointKind::Slide => 1e-3 * value,
        };
        for (name, value) in entries {
            let place = || format!("joint \"{name}\" in {place}");
            within(limit(kind), convert(*value), place)?;
        }
        fill(values, joints, entries, &place, convert)?;
    }
    Ok(())
}

/// The Gaussian prior about a rest pose.
///
/// ```text
/// Λ = (D C D)⁻¹,   C = (1 − ι) k Σ vᵢ uᵢ uᵢᵀ / Σ vᵢ + ι I
/// ```
///
/// D: standard deviations, a quarter of each joint's range unless the side file says otherwise; `uᵢ`, `vᵢ`: orthonormalised
/// synergies and their shares of variance; ι: share of variance that is independent for each joint (1 without synergies).
/// The trace of C is the number of joints k for any shares.
pub(super) fn gaussian(
    rest: Vec<f64>,
    joints: &[Joint],
    side: &SideFile,
) -> Result<PosePrior, HandError> {
    let count = joints.len();
    let independent = side
        .independent_share
        .unwrap_or(if side.synergies.is_empty() { 1.0 } else { 0.25 });
    let place = || "\"independent_share\" of the side file".to_owned();
    within(VARIANCE_SHARE, independent, place)?;

    let mut total = 0.0;
    let mut directions: Vec<DVector<f64>> = Vec::new();
    let mut synergies = DMatrix::zeros(count, count);
    for (i, synergy) in side.synergies.iter().enumerate() {
        let place = format!("synergy {i} of the side file");
        let variance = || format!("the variance of {place}");
        within(VARIANCE_SHARE, synergy.variance, variance)?;
        let mut weights = vec![0.0; count];
        for weight in synergy.weights.values() {
            within(SYNERGY_WEIGHT, *weight, || format!("a weight of {place}"))?;
        }
        fill(&mut weights, joints, &synergy.weights, &place, |weight| {
            weight
        })?;
        let mut direction = DVector::from_vec(weights);
        for earlier in &directions {
            direction -= earlier * earlier.dot(&direction);
        }
        let direction = direction.try_normalize(1e-6).ok_or(HandError::Degenerate {
            place: "a synergy that is zero or a linear combination of earlier ones",
        })?;
        synergies += &direction * direction.transpose() * synergy.variance;
        total += synergy.variance;
        directions.push(direction);
    }
    let mut covariance = DMatrix::identity(count, count);
    if total > 0.0 {
        covariance =
            covariance * independent + synergies * ((1.0 - independent) * count as f64 / total);
    }
    let mut deviations: Vec<f64> = joints
        .iter()
        .map(|joint| (joint.limits[1] - joint.limits[0]) * DEVIATION_OF_RANGE)
        .collect();
    let given = [&side.deviation_deg, &side.deviation_mm];
    let entry = ("deviation", (|_| JOINT_DEVIATION) as fn(JointKind) -> Limit);
    fill_measured(&mut deviations, joints, entry, given)?;
    for (joint, &deviation) in joints.iter().zip(&deviations) {
        let place = || {
            format!(
                "the standard deviation of joint \"{}\" (a quarter of its range, unless the side file says otherwise)",
                joint.name
            )
        };
        within(JOINT_DEVIATION, deviation, place)?;
    }
    for (i, deviation) in deviations.into_iter().enumerate() {
        covariance.row_mut(i).scale_mut(deviation);
        covariance.column_mut(i).scale_mut(deviation);
    }
    let deviations = covariance.diagonal().map(f64::sqrt).as_slice().to_vec();
    let mut precision = covariance
        .cholesky()
        .ok_or_else(|| HandError::NotPositive {
            what: "the determinant of the covariance of the joints".to_owned(),
            value: 0.0,
        })?
        .inverse();
    precision.fill_lower_triangle_with_upper_triangle();
    Ok(PosePrior {
        rest,
        precision: precision.as_slice().to_vec(),
        deviations,
    })
}

/// Writes named numbers to their joints.
fn fill(
    values: &mut [f64],
    joints: &[Joint],
    entries: &BTreeMap<String, f64>,
    place: &str,
    convert: impl Fn(f64) -> f64,
) -> Result<(), HandError> {
    for (name, &value) in entries {
        let joint = joints
            .iter()
            .position(|joint| &joint.name == name)
            .ok_or_else(|| HandError::Unknown {
                place: place.to_owned(),
                kind: "joint",
                name: name.clone(),
            })?;
        values[joint] = convert(value);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::hand::Hand;
    use nalgebra::DMatrix;

    /// The covariance must give back the shares it was built from: variance along all joints sums to Σ (range/4)²-units.
    #[test]
    fn synergies_keep_their_shares_of_variance() {
        let hand = Hand::human();
        let k = hand.joints.len();
        let precision = DMatrix::from_row_slice(k, k, &hand.prior.precision);
        assert!((&precision - precision.transpose()).amax() == 0.0);
        let mut covariance = precision.try_inverse().unwrap();
        for (i, joint) in hand.joints.iter().enumerate() {
            let deviation = (joint.limits[1] - joint.limits[0]) / 4.0;
            covariance.row_mut(i).unscale_mut(deviation);
            covariance.column_mut(i).unscale_mut(deviation);
        }
        assert!((covariance.trace() - k as f64).abs() < 1e-8);
        let mut values: Vec<f64> = covariance.symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(|a, b| b.total_cmp(a));
        for (value, share) in values.iter().zip([0.55, 0.25, 0.08, 0.06, 0.04, 0.02]) {
            let expected = 0.75 * k as f64 * share + 0.25;
            assert!(
                (value - expected).abs() < 1e-8,
                "{value} instead of {expected}"
            );
        }
        assert!((values[k - 1] - 0.25).abs() < 1e-8);
    }
}
