//! How far grasps spread: standard deviations, principal components and entropies.

use nalgebra::{Rotation3, Vector3};

use super::facts::{GraspFacts, MeasuredObject};
use crate::evaluation::diversity::{BOX_M, entropy, explained_variance};
use crate::space::object_from_hand;

/// Standard deviation of values over `len − less`; `None` if that is not positive.
fn deviation(values: &[f64], less: usize) -> Option<f64> {
    let divisor = values.len().checked_sub(less).filter(|count| *count > 0)?;
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((squares / divisor as f64).sqrt())
}

/// Mean over columns of what is measured of each; `None` if there is no column or a column has no value.
fn mean_of_columns(columns: usize, mut of: impl FnMut(usize) -> Option<f64>) -> Option<f64> {
    let sum = (0..columns).try_fold(0.0, |sum, column| Some(sum + of(column)?))?;
    (columns > 0).then(|| sum / columns as f64)
}

/// Mean over the joints of their population deviation (÷ n), radians.
pub(super) fn joint_deviation(grasps: &[&GraspFacts]) -> Option<f64> {
    let joints = grasps.first()?.pose.joints().len();
    mean_of_columns(joints, |joint| {
        let column: Vec<f64> = (grasps.iter())
            .map(|facts| facts.pose.joints()[joint])
            .collect();
        deviation(&column, 0)
    })
}

/// Mean over position (metres), intrinsic XYZ Euler angles and joints of the sample deviation (÷ n − 1). Metres and radians
/// are mixed, as published.
pub(super) fn pooled_deviation(grasps: &[&GraspFacts]) -> Option<f64> {
    let rows: Vec<Vec<f64>> = (grasps.iter())
        .map(|facts| {
            let pose = object_from_hand(&facts.pose);
            let turned = euler_xyz(&pose.rotation.to_rotation_matrix());
            let root = pose.translation.vector.iter().chain(&turned).copied();
            root.chain(facts.pose.joints().iter().copied()).collect()
        })
        .collect();
    mean_of_columns(rows.first()?.len(), |column| {
        let column: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        deviation(&column, 1)
    })
}

/// Angles α, β, γ of R = Rx(α) Ry(β) Rz(γ), radians.
fn euler_xyz(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let r = rotation.matrix();
    Vector3::new(
        libm::atan2(-r[(1, 2)], r[(2, 2)]),
        libm::asin(r[(0, 2)].clamp(-1.0, 1.0)),
        libm::atan2(-r[(0, 1)], r[(0, 0)]),
    )
}

/// Share of the variance of (position, rotation vector, joints) in the first principal component, unscaled; `None` without
/// two grasps.
pub(super) fn first_component(grasps: &[&GraspFacts]) -> Option<f64> {
    let row = |facts: &&GraspFacts| -> Vec<f64> {
        let pose = object_from_hand(&facts.pose);
        let root = pose.translation.vector.iter().copied();
        let turned = pose.rotation.scaled_axis();
        let joints = facts.pose.joints().iter().copied();
        root.chain(turned.iter().copied()).chain(joints).collect()
    };
    let rows: Vec<Vec<f64>> = grasps.iter().map(row).collect();
    (rows.len() > 1).then(|| explained_variance(&rows)[0])
}

/// Entropy of values over the bins of a range, as `GraspQP` has it: what lies outside is dropped.
fn inner_entropy(values: impl Iterator<Item = f64>, [low, high]: [f64; 2]) -> f64 {
    if low >= high {
        return 0.0;
    }
    entropy(
        values.filter(|value| (low..=high).contains(value)),
        (low, high),
    )
}

/// Mean over the joints of the entropy between their limits, nats; `None` without grasps.
pub(super) fn joint_entropy(object: &MeasuredObject, grasps: &[&GraspFacts]) -> Option<f64> {
    grasps.first()?;
    mean_of_columns(object.hand.joints.len(), |joint| {
        let values = grasps.iter().map(|facts| facts.pose.joints()[joint]);
        Some(inner_entropy(values, object.hand.joints[joint].limits))
    })
}

/// Mean over x, y, z of the entropy over ±0.1 m about the object's origin, nats; `None` without grasps.
pub(super) fn position_entropy(grasps: &[&GraspFacts]) -> Option<f64> {
    grasps.first()?;
    mean_of_columns(3, |axis| {
        let values = grasps.iter().map(|facts| facts.pose.translation_m()[axis]);
        Some(inner_entropy(values, [-BOX_M, BOX_M]))
    })
}

/// Mean over the four numbers of the quaternion of the entropy over ±1, nats; `None` without grasps. The quaternions of
/// files have w ≥ 0.
pub(super) fn orientation_entropy(grasps: &[&GraspFacts]) -> Option<f64> {
    grasps.first()?;
    mean_of_columns(4, |number| {
        let values = grasps
            .iter()
            .map(|facts| facts.pose.rotation_wxyz()[number]);
        Some(inner_entropy(values, [-1.0, 1.0]))
    })
}
