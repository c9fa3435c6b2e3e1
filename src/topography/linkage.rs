//! Which ends of descents are the same stationary point.

use petgraph::unionfind::UnionFind;
use rayon::prelude::*;

use super::minima::MatchTolerance;
use super::places::{are_apart, widened};
use crate::optimize::Quench;
use crate::space::Space;

/// Relative slack of the triangle inequality between measured distances.
const SLACK: f64 = 1e-9;

/// Single linkage of `ends`, which rise in energy: ends belong together if a sequence of pairs that match joins them.
///
/// Pairs are not measured one by one, because a data set has many ends in each minimum. An end that matches an earlier one,
/// its leader, within half the tolerance of distance belongs to it. Ends a and b of two leaders L and M match only if d(L, M)
/// is at most the tolerance plus d(a, L) plus d(b, M), and only if d(a, M) is at most the tolerance plus d(b, M). Only these
/// pairs are measured. The distance of the space must obey the triangle inequality, at least between points as near as this.
///
/// An end is compared with the leaders within the tolerance of energy, by landmarks first. Ends that scatter by more than half
/// the tolerance of distance all lead, and then nearly all pairs within the tolerance of energy are compared.
pub(super) fn linkage(
    space: &dyn Space,
    ends: &[&Quench],
    sameness: &MatchTolerance,
) -> UnionFind<usize> {
    let landmarks = |end: &&Quench| space.landmarks(&end.x);
    let landmarks: Vec<Vec<f64>> = ends.par_iter().map(landmarks).collect();
    let apart = |a: usize, b: usize, reach: f64| {
        are_apart(&landmarks[a], &landmarks[b], widened(reach, &landmarks[a]))
    };
    let near = |a: usize, b: usize, reach: f64| {
        !apart(a, b, reach) && space.within(&ends[a].x, &ends[b].x, reach)
    };
    let rise = |a: usize, b: usize| (ends[b].energy - ends[a].energy).abs();
    let distance = |a: usize, b: usize| space.distance(&ends[a].x, &ends[b].x);

    let mut sets = UnionFind::new(ends.len());
    let mut groups: Vec<Group> = Vec::new();
    let mut first = 0;
    for end in 0..ends.len() {
        while first < groups.len() && rise(groups[first].leader, end) > sameness.energy {
            first += 1;
        }
        let leads = |group: &&mut Group| near(group.leader, end, 0.5 * sameness.distance);
        if let Some(group) = groups[first..].iter_mut().find(leads) {
            let offset = distance(group.leader, end);
            group.radius = group.radius.max(offset);
            group.members.push((end, offset));
            sets.union(group.leader, end);
        } else {
            groups.push(Group {
                leader: end,
                radius: 0.0,
                members: vec![(end, 0.0)],
            });
        }
    }
    for (k, one) in groups.iter().enumerate() {
        for other in &groups[k + 1..] {
            // Members lie up to the tolerance above their leaders.
            if rise(one.leader, other.leader) > 2.0 * (1.0 + SLACK) * sameness.energy {
                break;
            }
            // Measured distances obey the triangle inequality up to rounding.
            let most = |offset: f64| (sameness.distance + offset) * (1.0 + SLACK);
            let lead = other.leader;
            if sets.equiv(one.leader, lead)
                || !near(one.leader, lead, most(one.radius + other.radius))
            {
                continue;
            }
            let between = distance(one.leader, lead);
            let touch = one.members.iter().any(|(a, offset)| {
                if between > most(offset + other.radius) || !near(*a, lead, most(other.radius)) {
                    return false;
                }
                let rest = distance(*a, lead);
                other.members.iter().any(|(b, offset)| {
                    rest <= most(*offset)
                        && rise(*a, *b) <= sameness.energy
                        && near(*a, *b, sameness.distance)
                })
            });
            if touch {
                sets.union(one.leader, other.leader);
            }
        }
    }
    sets
}

/// Ends near one of them.
struct Group {
    /// The lowest of them.
    leader: usize,
    /// Greatest distance from the leader.
    radius: f64,
    /// All of them with their distances from the leader.
    members: Vec<(usize, f64)>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::StopReason;
    use crate::sample::{Task, stream};
    use crate::space::{Euclidean, PoseMetric, PoseSpace, Symmetry, Torus};
    use nalgebra::Vector3;
    use rand::RngExt;

    /// The partition by measuring all pairs.
    fn all_pairs(
        space: &dyn Space,
        ends: &[&Quench],
        sameness: &MatchTolerance,
    ) -> UnionFind<usize> {
        let mut sets = UnionFind::new(ends.len());
        for a in 0..ends.len() {
            for b in a + 1..ends.len() {
                if ends[b].energy - ends[a].energy <= sameness.energy
                    && space.within(&ends[a].x, &ends[b].x, sameness.distance)
                {
                    sets.union(a, b);
                }
            }
        }
        sets
    }

    fn end(x: Vec<f64>, energy: f64) -> Quench {
        Quench {
            x,
            energy,
            gradient_norm: 0.0,
            evaluations: 1,
            stop: StopReason::Converged,
        }
    }

    /// Checks the sets of `ends`, and returns their number and the size of the largest.
    fn check(space: &dyn Space, mut ends: Vec<Quench>, sameness: &MatchTolerance) -> [usize; 2] {
        ends.sort_by(|a, b| a.energy.total_cmp(&b.energy));
        let ends: Vec<&Quench> = ends.iter().collect();
        let expected = all_pairs(space, &ends, sameness).into_labeling();
        let found = linkage(space, &ends, sameness);
        let mut sizes = vec![0; ends.len()];
        for (a, label) in expected.iter().enumerate() {
            sizes[*label] += 1;
            for (b, other) in expected.iter().enumerate().take(a) {
                assert_eq!(found.equiv(a, b), label == other, "{a}, {b}");
            }
        }
        let count = sizes.iter().filter(|size| **size > 0).count();
        [count, sizes.into_iter().max().unwrap_or(0)]
    }

    /// From far apart to one cloud, on a plane, a torus, and for poses of a hand with one joint about an axis.
    #[test]
    fn the_sets_are_those_of_all_pairs() {
        let sameness = MatchTolerance {
            energy: 0.1,
            distance: 0.2,
        };
        let metric = PoseMetric {
            centroid: Vector3::zeros(),
            radius_of_gyration_m: 1.0,
            joint_levers_m: vec![1.0],
            joint_reaches_m: vec![1.0],
            rotation_reach_m: 1.0,
            wraps: vec![false],
        };
        let axis = Symmetry::Axis {
            point: Vector3::zeros(),
            direction: Vector3::z(),
        };
        let poses = PoseSpace::new(metric, axis);
        let (plane, torus) = (Euclidean::new(2), Torus::new(2));
        let spaces: [(&dyn Space, &[f64]); 3] = [
            (&plane, &[0.0, 0.0]),
            (&torus, &[3.0, 0.0]),
            (&poses, &[0.7, 0.0, 0.2, 1.0, 0.0, 0.0, 0.0, 0.1]),
        ];
        for (number, (space, origin)) in spaces.into_iter().enumerate() {
            let mut found = Vec::new();
            for case in 0..30 {
                let mut rng = stream(9, Task::Start, case);
                let width = 0.2 + 0.2 * case as f64;
                let mut draw = |_| {
                    let steps = (0..space.tangents()).map(|_| width * (rng.random::<f64>() - 0.5));
                    let mut x = origin.to_vec();
                    space.exp(&mut x, &steps.collect::<Vec<f64>>());
                    // Energies in steps, so that some are equal.
                    end(x, 0.04 * f64::from(rng.random_range(0..20_u8)))
                };
                let ends: Vec<Quench> = (0..150).map(&mut draw).collect();
                found.push(check(space, ends, &sameness));
            }
            // Or the test would say little.
            let few = found.iter().filter(|[sets, _]| *sets < 10).count();
            let many = found.iter().filter(|[sets, _]| *sets > 100).count();
            assert!(few > 0 && many > 0, "space {number}: {found:?}");
        }
    }

    #[test]
    fn equal_ends_are_one_without_tolerance() {
        let mut rng = stream(9, Task::Start, 99);
        let ends = (0..200).map(|_| {
            let [x, y, energy] = [(); 3].map(|()| f64::from(rng.random_range(0..4_u8)));
            end(vec![x, y], energy)
        });
        let none = MatchTolerance {
            energy: 0.0,
            distance: 0.0,
        };
        let [sets, largest] = check(&Euclidean::new(2), ends.collect(), &none);
        assert!(sets > 50 && largest > 3, "{sets} {largest}");
        assert_eq!(check(&Euclidean::new(2), Vec::new(), &none), [0, 0]);
    }
}
