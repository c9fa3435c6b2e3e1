//! Rest pose and pose prior.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::side_file::SideFile;
use super::{HandError, Joint, PosePrior};

/// Standard deviation of a joint as a share of its range: the limits lie two standard deviations from the middle.
const DEVIATION_OF_RANGE: f64 = 0.25;

/// Rest pose and the pose in which the skin is cast, radians.
pub(super) fn poses(joints: &[Joint], side: &SideFile) -> Result<(Vec<f64>, Vec<f64>), HandError> {
    let mut rest: Vec<f64> = joints
        .iter()
        .map(|joint| f64::midpoint(joint.limits_rad[0], joint.limits_rad[1]))
        .collect();
    fill(
        &mut rest,
        joints,
        &side.rest_deg,
        "\"rest_deg\" of the side file",
        f64::to_radians,
    )?;
    let mut cast = rest.clone();
    fill(
        &mut cast,
        joints,
        &side.cast_deg,
        "\"cast_deg\" of the side file",
        f64::to_radians,
    )?;
    Ok((rest, cast))
}

/// The prior about a rest pose.
///
/// ```text
/// Λ = (D C D)⁻¹,   C = (1 − ι) k Σ vᵢ uᵢ uᵢᵀ / Σ vᵢ + ι I
/// ```
///
/// D: standard deviations, a quarter of each joint's range; `uᵢ`, `vᵢ`: orthonormalised synergies and their shares of
/// variance; ι: share that is independent from joint to joint (1 without synergies). The trace of C is the number of
/// joints k, whatever the shares.
pub(super) fn gaussian(
    rest_rad: Vec<f64>,
    joints: &[Joint],
    side: &SideFile,
) -> Result<PosePrior, HandError> {
    let count = joints.len();
    let independent = side
        .independent_share
        .unwrap_or(if side.synergies.is_empty() { 1.0 } else { 0.25 });
    check_share("\"independent_share\" of the side file", independent)?;

    let mut total = 0.0;
    let mut directions: Vec<DVector<f64>> = Vec::new();
    let mut synergies = DMatrix::zeros(count, count);
    for (i, synergy) in side.synergies.iter().enumerate() {
        let place = format!("synergy {i} of the side file");
        check_share(&format!("the variance of {place}"), synergy.variance)?;
        let mut weights = vec![0.0; count];
        fill(&mut weights, joints, &synergy.weights, &place, |weight| {
            weight
        })?;
        let mut direction = DVector::from_vec(weights);
        for earlier in &directions {
            direction -= earlier * earlier.dot(&direction);
        }
        let direction = direction.try_normalize(1e-6).ok_or(HandError::Degenerate {
            place: "a synergy that is zero or a mixture of those before it",
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
    for (i, joint) in joints.iter().enumerate() {
        let deviation = (joint.limits_rad[1] - joint.limits_rad[0]) * DEVIATION_OF_RANGE;
        covariance.row_mut(i).scale_mut(deviation);
        covariance.column_mut(i).scale_mut(deviation);
    }
    let deviations_rad = covariance.diagonal().map(f64::sqrt).as_slice().to_vec();
    let mut precision = covariance
        .cholesky()
        .expect("a positive share of it is diagonal")
        .inverse();
    precision.fill_lower_triangle_with_upper_triangle();
    Ok(PosePrior {
        rest_rad,
        precision: precision.as_slice().to_vec(),
        deviations_rad,
    })
}

fn check_share(what: &str, value: f64) -> Result<(), HandError> {
    if value > 0.0 && value <= 1.0 {
        Ok(())
    } else {
        Err(HandError::Share {
            what: what.to_owned(),
            value,
        })
    }
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
    use crate::grasp::hand::Hand;
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
            let deviation = (joint.limits_rad[1] - joint.limits_rad[0]) / 4.0;
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
