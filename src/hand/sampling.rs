//! Joint coordinates that cover the ranges of a hand.

use super::Joint;

/// Coordinates of all joints, radians or metres: both ends of all ranges at once, both ends of each range with the other
/// joints in the middle, and then `count` points of a sequence that fills the ranges evenly.
///
/// ```text
/// qⱼ(n) = lⱼ + (uⱼ − lⱼ) frac(½ + n φ⁻ʲ),    φᵈ⁺¹ = φ + 1
/// ```
///
/// d is the number of joints, j = 1 … d, and l and u are the limits. This is the additive recurrence of Roberts (2018) with
/// the generalised golden ratio φ. It has no seed.
pub(super) fn joint_samples(joints: &[Joint], count: usize) -> Vec<Vec<f64>> {
    let at = |joint: &Joint, share: f64| {
        let [low, high] = joint.limits_rad;
        (low + share * (high - low)).min(high)
    };
    let all = |share: f64| -> Vec<f64> { joints.iter().map(|joint| at(joint, share)).collect() };
    let mut samples = vec![all(0.0), all(1.0)];
    for (j, joint) in joints.iter().enumerate() {
        for share in [0.0, 1.0] {
            let mut one = all(0.5);
            one[j] = at(joint, share);
            samples.push(one);
        }
    }
    let golden = golden_ratio(joints.len());
    for n in 1..=count {
        let mut step = 1.0;
        let point = joints.iter().map(|joint| {
            step /= golden;
            at(joint, (0.5 + n as f64 * step).fract())
        });
        samples.push(point.collect());
    }
    samples
}

/// The positive solution of φᵈ⁺¹ = φ + 1.
fn golden_ratio(dimensions: usize) -> f64 {
    let root = 1.0 / (dimensions as f64 + 1.0);
    // The map contracts: its slope at the solution is below ½.
    (0..64).fold(1.5, |ratio, _| libm::pow(1.0 + ratio, root))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::Hand;

    /// Known values for one and two dimensions, and every tenth of every range is visited about equally often.
    #[test]
    fn ranges_are_filled_evenly() {
        assert!((golden_ratio(1) - 1.618_033_988_749_895).abs() < 1e-14);
        assert!((golden_ratio(2) - 1.324_717_957_244_746).abs() < 1e-14);
        let joints = Hand::human().joints;
        let samples = joint_samples(&joints, 200);
        assert_eq!(samples.len(), 2 + 2 * joints.len() + 200);
        for (j, joint) in joints.iter().enumerate() {
            let [low, high] = joint.limits_rad;
            for tenth in 0..10 {
                let [from, to] =
                    [tenth, tenth + 1].map(|k| low + (high - low) * f64::from(k) / 10.0);
                let evenly = samples[samples.len() - 200..]
                    .iter()
                    .map(|sample| sample[j]);
                let visits = evenly.filter(|q| (from..to).contains(q)).count();
                assert!((8..=32).contains(&visits), "{}: {visits}", joint.name);
            }
            assert!(
                samples
                    .iter()
                    .all(|sample| (low..=high).contains(&sample[j]))
            );
            let ends = |k: usize| {
                samples
                    .iter()
                    .any(|sample| (sample[j] - joint.limits_rad[k]).abs() < 1e-12)
            };
            assert!(ends(0) && ends(1));
        }
    }
}
