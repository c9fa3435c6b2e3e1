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
/// Pairs are not measured one by one, because a data set has many ends in each minimum. An end within half the tolerance of
/// an earlier one, its leader, belongs to it. Ends of two leaders L and M match only if d(L, M) is at most the tolerance plus
/// the distances of both from their leaders (triangle inequality), and only these pairs are measured.
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
            if rise(one.leader, other.leader) > 2.0 * sameness.energy {
                break;
            }
            let reach = sameness.distance + one.radius + other.radius;
            if sets.equiv(one.leader, other.leader) || apart(one.leader, other.leader, reach) {
                continue;
            }
            let between = distance(one.leader, other.leader) * (1.0 - SLACK);
            let touch = one.members.iter().any(|(a, offset)| {
                let reach = sameness.distance + offset;
                between <= reach + other.radius
                    && other.members.iter().any(|(b, offset)| {
                        between <= reach + offset
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
    use crate::space::{Euclidean, Torus};
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

    #[test]
    fn the_sets_are_those_of_all_pairs() {
        let sameness = MatchTolerance {
            energy: 0.1,
            distance: 0.2,
        };
        let (mut sets, mut largest) = (Vec::new(), 0);
        for case in 0..60 {
            let mut rng = stream(9, Task::Start, case);
            let space: &dyn Space = if case % 2 == 0 {
                &Euclidean::new(2)
            } else {
                &Torus::new(2)
            };
            // From far apart to one cloud; energies in steps, so that some are equal.
            let width = 0.3 + 0.1 * case as f64;
            let mut ends: Vec<Quench> = (0..150)
                .map(|_| Quench {
                    x: (0..2)
                        .map(|_| width * (rng.random::<f64>() - 0.5))
                        .collect(),
                    energy: 0.04 * f64::from(rng.random_range(0..20_u8)),
                    gradient_norm: 0.0,
                    evaluations: 1,
                    stop: StopReason::Converged,
                })
                .collect();
            ends.sort_by(|a, b| a.energy.total_cmp(&b.energy));
            let ends: Vec<&Quench> = ends.iter().collect();
            let expected = all_pairs(space, &ends, &sameness).into_labeling();
            let found = linkage(space, &ends, &sameness);
            let (mut count, mut size) = (0, vec![0; ends.len()]);
            for (a, label) in expected.iter().enumerate() {
                size[*label] += 1;
                count += usize::from(size[*label] == 1);
                for (b, other) in expected.iter().enumerate().take(a) {
                    assert_eq!(found.equiv(a, b), label == other, "case {case}: {a}, {b}");
                }
            }
            largest = largest.max(size.into_iter().max().unwrap_or(0));
            sets.push(count);
        }
        // Or the test would say little.
        let spread = [sets.iter().min(), sets.iter().max()].map(|count| *count.unwrap());
        assert!(
            spread[0] < 10 && spread[1] > 100 && largest > 100,
            "{spread:?} {largest}"
        );
    }
}
