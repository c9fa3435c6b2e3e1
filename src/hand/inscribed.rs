//! Balls that fill the meshes of a hand up to their surface.
//!
//! Capsules that fill convex hulls leave corners open and cover holes. The balls found here fill the solid that the meshes
//! of a link bound, and together they follow its surface to within a fraction of a millimetre where the link faces objects.
//! The elastic layer and the simulation of stability use them in place of such capsules. A ball has a distance from an
//! object that is as smooth as that of its centre, for every rotation.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::{Arc, OnceLock};

use nalgebra::Vector3;

use super::hull::{directions, in_triangle};
use super::volar::volar_directions;
use super::{Hand, LinkId, Part, Solid};
use crate::mesh::ExactMesh;

/// Greatest radius of a ball, metres: fingers of robots are up to about twice as thick.
const MOST_M: f64 = 0.014;
/// Distance between the points of a surface that are to be covered, metres.
const SPACING_M: f64 = 0.0015;
/// Greatest number of these points of a hand; the distance grows if there would be more.
const MOST_POINTS: f64 = 40_000.0;

/// When a point of the surface counts as covered by a ball.
#[derive(Debug, Clone, Copy)]
struct Covered {
    /// This far outside the ball, metres.
    outside_m: f64,
    /// This near the point at which the ball touches the surface, metres: an edge needs no chain of tiny balls.
    beside_m: f64,
}

/// How closely balls follow a surface: where the link faces objects, and on its back.
#[derive(Debug, Clone, Copy)]
struct Fineness {
    facing: Covered,
    back: Covered,
}

const BACK_REACH_M: f64 = 0.004;
const FINE: Fineness = Fineness {
    facing: Covered {
        outside_m: 0.00045,
        beside_m: 0.002,
    },
    back: Covered {
        outside_m: 0.0015,
        beside_m: BACK_REACH_M,
    },
};
/// A third as many balls, for the search of a descent's start.
const COARSE: Fineness = Fineness {
    facing: Covered {
        outside_m: 0.0015,
        beside_m: 0.004,
    },
    back: Covered {
        outside_m: 0.004,
        beside_m: 0.008,
    },
};
/// A point is on the back if the cosine between its normal and the palmar side is below this.
const BACK: f64 = -0.5;
/// A point is on the palmar side if this cosine is not below this share of its greatest value on the link.
const PALMAR: f64 = 0.8;
/// Distance between the palmar points of a link, metres.
const PALMAR_SPACING_M: f64 = 0.01;
/// Rounds in which a ball shrinks until nothing of the surface is inside; few are needed.
const ROUNDS: usize = 30;
/// Depth of the surface in a ball that is rounding error, metres.
const INSIDE_M: f64 = 1e-5;
/// Edge of the cells in which points are sought, metres.
const CELL_M: f64 = 0.004;
/// Number of directions in which the area of a ball's part of the surface is projected.
const DIRECTIONS: u32 = 32;

/// A ball in the meshes of a link, link frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// The link it is fixed to.
    pub link: LinkId,
    /// Centre, metres.
    pub centre: Vector3<f64>,
    /// Radius, metres: the mean distance of the centre from the part of the surface that is nearest to the ball.
    pub radius_m: f64,
    /// The greatest area of a shadow of the part of the surface that is nearest to it, m². A piece of a capsule casts a
    /// shadow of its length times its diameter.
    pub shadow_m2: f64,
}

/// The balls of a hand.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Inscribed {
    /// Sorted by link.
    pub(crate) balls: Vec<Ball>,
    /// Fewer balls, which follow the surface less closely; of the same links.
    pub(crate) coarse: Vec<Ball>,
    /// Points on the middle line of the palmar side of each link that has balls, and the link.
    pub(crate) palmar: Vec<(LinkId, Vector3<f64>)>,
}

/// The balls, computed on first use. They follow from the geometry, so all values are equal.
#[derive(Debug, Clone, Default)]
pub(super) struct Cache(Arc<OnceLock<Inscribed>>);

impl PartialEq for Cache {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Hand {
    /// The balls that fill the meshes, boxes and cylinders of the hand, sorted by link. Wrist and forearm, links of capsules
    /// and hands that bend have none. The first call may take a few seconds.
    pub fn balls(&self) -> &[Ball] {
        &self.inscribed().balls
    }

    /// Whether the shape of this capsule's link is that of its balls, so that the capsule only fills it.
    pub fn is_filling(&self, capsule: usize) -> bool {
        let link = self.capsules[capsule].link;
        let balls = self.balls();
        let first = balls.partition_point(|ball| ball.link < link);
        !self.exact[capsule] && balls.get(first).is_some_and(|ball| ball.link == link)
    }

    pub(crate) fn inscribed(&self) -> &Inscribed {
        self.inscribed.0.get_or_init(|| {
            if self.meshes.is_empty() || self.bends() {
                return Inscribed::default();
            }
            Inscribed::of(self)
        })
    }
}

/// A point of a surface.
struct Sample {
    point: Vector3<f64>,
    normal: Vector3<f64>,
    back: bool,
}

impl Inscribed {
    fn of(hand: &Hand) -> Self {
        let volar = volar_directions(hand);
        let parts: Vec<(LinkId, &ExactMesh)> = (hand.rigid_parts().iter())
            .filter_map(|part: &Part| match (&part.solid, part.link) {
                (Solid::Mesh(solid), Some(link)) if !hand.is_arm(link) => Some((link, &**solid)),
                _ => None,
            })
            .collect();
        let area_m2: f64 = (parts.iter())
            .flat_map(|(_, solid)| solid.surface().triangles())
            .map(|triangle| doubled(&triangle).norm() / 2.0)
            .sum();
        let share_m2 = SPACING_M.powi(2).max(area_m2 / MOST_POINTS);
        let mut found = Self::default();
        for (link, solid) in parts {
            let samples = sample(solid, share_m2, volar[link.0].as_ref());
            let balls = inscribed(&samples, solid);
            for (list, fineness) in [(&mut found.balls, FINE), (&mut found.coarse, COARSE)] {
                let chosen = cover(&samples, &balls, fineness);
                list.extend(chosen.into_iter().map(|(ball, own)| Ball {
                    link,
                    centre: ball.centre,
                    radius_m: radius_m(ball, &samples, &own),
                    shadow_m2: shadow(&samples, &own) * share_m2,
                }));
            }
            if let Some(direction) = volar[link.0] {
                let points = middle_line(&samples, &direction);
                found
                    .palmar
                    .extend(points.into_iter().map(|point| (link, point)));
            }
        }
        // A mesh that could not be united with the others of its link is a part of its own.
        found.balls.sort_by_key(|ball| ball.link);
        found.coarse.sort_by_key(|ball| ball.link);
        found.palmar.sort_by_key(|(link, _)| *link);
        found
    }
}

fn doubled([a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Points spread evenly over a surface, each for an area of `share_m2`.
fn sample(solid: &ExactMesh, share_m2: f64, volar: Option<&Vector3<f64>>) -> Vec<Sample> {
    let mut samples = Vec::new();
    let (mut left, mut k) = (0.5, 0.0);
    for triangle in solid.surface().triangles() {
        let doubled = doubled(&triangle);
        let Some(normal) = doubled.try_normalize(f64::MIN_POSITIVE) else {
            continue;
        };
        left += doubled.norm() / 2.0 / share_m2;
        while left >= 1.0 {
            left -= 1.0;
            k += 1.0;
            samples.push(Sample {
                point: in_triangle(triangle, k),
                normal,
                back: volar.is_some_and(|volar| normal.dot(volar) < BACK),
            });
        }
    }
    samples
}

/// A ball that touches the surface at a sample.
struct Touching {
    centre: Vector3<f64>,
    radius_m: f64,
    at: Vector3<f64>,
}

/// The greatest ball that touches the surface from inside at each sample. It shrinks until the nearest point of the surface
/// is not inside (Ma et al. 2012, "3D medial axis point approximation using nearest neighbors and the normal field").
fn inscribed(samples: &[Sample], solid: &ExactMesh) -> Vec<Touching> {
    let ball = |sample: &Sample| {
        let (at, inward) = (sample.point, -sample.normal);
        let mut radius_m = MOST_M;
        for _ in 0..ROUNDS {
            let centre = at + inward * radius_m;
            let foot = solid.surface().foot(&centre);
            let off = foot - at;
            if (foot - centre).norm() >= radius_m - INSIDE_M {
                break;
            }
            let toward = off.dot(&inward);
            // A foot beside the sample rather than before it is rounding.
            if toward <= 1e-3 * off.norm() {
                break;
            }
            radius_m = off.norm_squared() / (2.0 * toward);
        }
        let centre = at + inward * radius_m;
        // Nothing of the ball may be outside, whatever the normals of the triangles are.
        let radius_m = radius_m.min((solid.surface().foot(&centre) - centre).norm());
        Touching {
            centre,
            radius_m,
            at,
        }
    };
    samples.iter().map(ball).collect()
}

/// A few of `balls` that cover all samples, each with the samples that are nearest to it. Greedy: the next ball is the one
/// that covers most samples that no other covers.
fn cover<'a>(
    samples: &[Sample],
    balls: &'a [Touching],
    fineness: Fineness,
) -> Vec<(&'a Touching, Vec<usize>)> {
    let cell = |point: &Vector3<f64>| point.map(|x| whole((x / CELL_M).floor()));
    let mut cells: BTreeMap<[i32; 3], Vec<u32>> = BTreeMap::new();
    for (index, sample) in (0u32..).zip(samples) {
        let list = cells.entry(cell(&sample.point).into()).or_default();
        list.push(index);
    }
    let covered_by = |ball: &Touching| {
        let most_m =
            [fineness.facing, fineness.back].map(|covered| covered.outside_m.max(covered.beside_m));
        let reach = ball.radius_m + most_m[0].max(most_m[1]);
        let [low, high] = [-reach, reach].map(|step| cell(&ball.centre.add_scalar(step)));
        let mut list = Vec::new();
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for (_, indices) in cells.range([x, y, low.z]..=[x, y, high.z]) {
                    list.extend(indices.iter().copied().filter(|&index| {
                        let sample = &samples[index as usize];
                        let covered = if sample.back {
                            fineness.back
                        } else {
                            fineness.facing
                        };
                        (sample.point - ball.centre).norm() <= ball.radius_m + covered.outside_m
                            || (sample.point - ball.at).norm() <= covered.beside_m
                    }));
                }
            }
        }
        list
    };
    let lists: Vec<Vec<u32>> = balls.iter().map(covered_by).collect();
    let mut open = vec![true; samples.len()];
    let mut left = samples.len();
    let mut heap: BinaryHeap<(usize, Reverse<usize>)> = (lists.iter().enumerate())
        .map(|(index, list)| (list.len(), Reverse(index)))
        .collect();
    let mut chosen: Vec<usize> = Vec::new();
    while left > 0 {
        let Some((gain, Reverse(index))) = heap.pop() else {
            break;
        };
        let now = lists[index].iter().filter(|&&s| open[s as usize]).count();
        if now < gain {
            // What a ball covers alone only becomes less, so the greatest number that is still true is the greatest of all.
            if now > 0 {
                heap.push((now, Reverse(index)));
            }
            continue;
        }
        if now == 0 {
            break;
        }
        for &sample in &lists[index] {
            left -= usize::from(std::mem::take(&mut open[sample as usize]));
        }
        chosen.push(index);
    }
    let mut nearest = vec![(f64::INFINITY, usize::MAX); samples.len()];
    for (place, &index) in chosen.iter().enumerate() {
        for &sample in &lists[index] {
            let ball = &balls[index];
            let outside = (samples[sample as usize].point - ball.centre).norm() - ball.radius_m;
            if outside < nearest[sample as usize].0 {
                nearest[sample as usize] = (outside, place);
            }
        }
    }
    let mut found: Vec<(&Touching, Vec<usize>)> = (chosen.iter())
        .map(|&index| (&balls[index], Vec::new()))
        .collect();
    for (sample, (_, place)) in nearest.into_iter().enumerate() {
        if let Some((_, own)) = found.get_mut(place) {
            own.push(sample);
        }
    }
    found.retain(|(_, own)| !own.is_empty());
    found
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "hands are small, and the cast saturates"
)]
fn whole(cells: f64) -> i32 {
    cells as i32
}

/// Mean distance of some samples from the centre of a ball.
fn radius_m(ball: &Touching, samples: &[Sample], own: &[usize]) -> f64 {
    let distances = own.iter().map(|&s| (samples[s].point - ball.centre).norm());
    distances.sum::<f64>() / own.len() as f64
}

/// The greatest area of a shadow of some samples, in units of the area of a sample.
fn shadow(samples: &[Sample], own: &[usize]) -> f64 {
    let area = |direction: Vector3<f64>| -> f64 {
        let cosines = own.iter().map(|&s| samples[s].normal.dot(&direction));
        cosines.map(|cosine| cosine.max(0.0)).sum()
    };
    let normal = own.iter().map(|&s| samples[s].normal).sum::<Vector3<f64>>();
    let mean = normal.try_normalize(1e-9).map_or(0.0, area);
    directions(DIRECTIONS).map(area).fold(mean, f64::max)
}

/// Points about a centimetre apart on the middle line of the palmar side, along its longest direction.
fn middle_line(samples: &[Sample], volar: &Vector3<f64>) -> Vec<Vector3<f64>> {
    let cosine = |sample: &Sample| sample.normal.dot(volar);
    let most = samples.iter().map(cosine).fold(0.0, f64::max);
    let facing: Vec<Vector3<f64>> = (samples.iter())
        .filter(|sample| cosine(sample) >= PALMAR * most && most > 0.0)
        .map(|sample| sample.point)
        .collect();
    if facing.is_empty() {
        return Vec::new();
    }
    let flat = |v: &Vector3<f64>| v - volar * volar.dot(v);
    let mean = facing.iter().sum::<Vector3<f64>>() / facing.len() as f64;
    let spread = (facing.iter().map(|point| flat(&(point - mean))))
        .map(|off| off * off.transpose())
        .sum::<nalgebra::Matrix3<f64>>();
    let eigen = spread.symmetric_eigen();
    let along = eigen
        .eigenvectors
        .column(eigen.eigenvalues.imax())
        .into_owned();
    let places = || facing.iter().map(|point| along.dot(&(point - mean)));
    let low = places().fold(f64::INFINITY, f64::min);
    let high = places().fold(f64::NEG_INFINITY, f64::max);
    let count = ((high - low) / PALMAR_SPACING_M).round().clamp(1.0, 100.0);
    (0..whole(count))
        .map(|k| {
            let at = mean + along * (low + (high - low) * (f64::from(k) + 0.5) / count);
            let off = |point: &Vector3<f64>| flat(&(point - at)).norm();
            let nearest = (facing.iter()).min_by(|a, b| off(a).total_cmp(&off(b)));
            nearest.copied().unwrap_or(at)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Balls touch the surface, and all of the surface is near a ball.
    #[test]
    fn balls_fill_a_gripper() {
        let hand = Hand::named("gripper_three_finger").unwrap();
        let volar = volar_directions(&hand);
        for part in hand.rigid_parts() {
            let (Solid::Mesh(solid), Some(link)) = (&part.solid, part.link) else {
                continue;
            };
            let balls: Vec<&Ball> = hand.balls().iter().filter(|b| b.link == link).collect();
            assert!(!balls.is_empty());
            for ball in &balls {
                // Backs are covered roughly.
                let depth = -solid.distance(&ball.centre);
                assert!((depth - ball.radius_m).abs() < BACK_REACH_M);
                assert!(ball.shadow_m2 > 0.0);
            }
            let mut open_m = Vec::new();
            for sample in sample(solid, 1e-6, volar[link.0].as_ref()) {
                if sample.back {
                    continue;
                }
                let gaps = balls
                    .iter()
                    .map(|ball| (sample.point - ball.centre).norm() - ball.radius_m);
                open_m.push(gaps.fold(f64::INFINITY, f64::min));
            }
            open_m.sort_by(f64::total_cmp);
            let most = open_m[open_m.len() * 98 / 100];
            let worst = open_m[open_m.len() - 1];
            assert!(most < 0.0008 && worst < 0.0025, "{most} {worst}");
        }
    }

    /// The shadows of the balls of a link add up to about the shadow of a link of the same size: half its surface.
    #[test]
    fn shadows_add_up() {
        let hand = Hand::named("gripper_parallel").unwrap();
        for link in 0..hand.links.len() {
            let balls = hand.balls().iter().filter(|ball| ball.link.0 == link);
            let shadow: f64 = balls.map(|ball| ball.shadow_m2).sum();
            let parts = hand.rigid_parts().iter();
            let area: f64 = parts
                .filter(|part| part.link == Some(LinkId(link)))
                .filter_map(|part| match &part.solid {
                    Solid::Mesh(solid) => Some(solid),
                    _ => None,
                })
                .flat_map(|solid| solid.surface().triangles().collect::<Vec<_>>())
                .map(|triangle| doubled(&triangle).norm() / 2.0)
                .sum();
            assert!(
                (0.2 * area..=1.02 * area).contains(&shadow),
                "{shadow} of {area}"
            );
        }
    }
}
