//! Joint coordinates that cover the ranges of a hand.

use super::Joint;

/// Coordinates of all joints, radians or metres: both ends of all ranges at once, both ends of each range with the other
/// joints in the middle, and then `count` points of a sequence that fills the ranges evenly.
///
/// ```text
/// qⱼ(n) = lⱼ + (uⱼ − lⱼ) frac(½ + n √pⱼ)
/// ```
///
/// pⱼ is the j-th prime number, and l and u are the limits. This additive recurrence (Richtmyer 1951) fills each range evenly
/// for any number of joints, and it has no seed.
pub(super) fn joint_samples(joints: &[Joint], count: usize) -> Vec<Vec<f64>> {
    let at = |joint: &Joint, share: f64| {
        let [low, high] = joint.limits;
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
    let roots: Vec<f64> = (primes().take(joints.len()))
        .map(|prime| f64::from(prime).sqrt())
        .collect();
    for n in 1..=count {
        let point = (joints.iter().zip(&roots))
            .map(|(joint, root)| at(joint, (0.5 + n as f64 * root).fract()));
        samples.push(point.collect());
    }
    samples
}

/// The prime numbers.
fn primes() -> impl Iterator<Item = u32> {
    (2..u32::MAX).filter(|&number| {
        (2..number)
            .take_while(|k| k * k <= number)
            .all(|k| number % k != 0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::Hand;

    /// Every tenth of every range is visited about equally often.
    #[test]
    fn ranges_are_filled_evenly() {
        assert!(primes().take(8).eq([2, 3, 5, 7, 11, 13, 17, 19]));
        let joints = Hand::human().joints;
        let samples = joint_samples(&joints, 200);
        assert_eq!(samples.len(), 2 + 2 * joints.len() + 200);
        for (j, joint) in joints.iter().enumerate() {
            let [low, high] = joint.limits;
            for tenth in 0..10 {
                let [from, to] =
                    [tenth, tenth + 1].map(|k| low + (high - low) * f64::from(k) / 10.0);
                let evenly = samples[samples.len() - 200..]
                    .iter()
                    .map(|sample| sample[j]);
                let visits = evenly.filter(|q| (from..to).contains(q)).count();
                assert!((14..=26).contains(&visits), "{}: {visits}", joint.name);
            }
            assert!(
                samples
                    .iter()
                    .all(|sample| (low..=high).contains(&sample[j]))
            );
            let ends = |k: usize| {
                samples
                    .iter()
                    .any(|sample| (sample[j] - joint.limits[k]).abs() < 1e-12)
            };
            assert!(ends(0) && ends(1));
        }
    }
}
