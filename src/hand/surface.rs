//! Surface points, spread evenly over the outside of the union of the capsules and hulls.

use nalgebra::Vector3;

use super::hull::{GOLDEN_ANGLE, Hull, in_triangle};
use super::{Hand, LinkId, PosedHand, SurfacePoint, axis_distance};

/// Default number of surface points: the count from which Liu et al. (2021) sample contacts.
pub(super) const POINTS: usize = 773;
/// Largest number of points; each is compared with all candidates.
pub(super) const MOST_POINTS: usize = 10_000;
/// Number of candidates per point.
const CANDIDATES_PER_POINT: f64 = 20.0;
/// Rounds of Lloyd's relaxation; the spacing hardly changes after the third.
const ROUNDS: usize = 4;

/// A candidate: a point of the union in the rest pose, root frame.
struct Candidate {
    link: LinkId,
    point: Vector3<f64>,
    normal: Vector3<f64>,
    area_m2: f64,
}

/// Points on the union of capsules and hulls in the rest pose, sorted by link, each with the area nearest to it.
///
/// Candidates lie on equal-area spirals around each exact capsule and evenly over the triangles of each hull; candidates
/// inside another solid are dropped. Farthest-point sampling (Eldar et al. 1997) and a few rounds of Lloyd's relaxation
/// choose among the candidates. Nothing is random. Wrist and forearm have no points.
pub(super) fn sample(
    hand: &Hand,
    rest: &PosedHand,
    hulls: &[Hull],
    count: usize,
) -> Vec<SurfacePoint> {
    let solids = Solids { hand, rest, hulls };
    let candidates = solids.candidates(count);
    let mut chosen = farthest(&candidates, count);
    let mut cells = assign(&candidates, &chosen);
    for _ in 0..ROUNDS {
        chosen = recentre(&candidates, &cells, chosen.len());
        cells = assign(&candidates, &chosen);
    }
    let mut areas = vec![0.0; chosen.len()];
    for (candidate, &cell) in candidates.iter().zip(&cells) {
        areas[cell] += candidate.area_m2;
    }
    let mut points: Vec<SurfacePoint> = chosen
        .iter()
        .zip(areas)
        .map(|(&index, area_m2)| {
            let Candidate {
                link,
                point,
                normal,
                ..
            } = candidates[index];
            let frame = &rest.object_from_link[link.0];
            let normal = frame.rotation.tr_mul(&normal).normalize();
            SurfacePoint {
                link,
                point: frame.inverse_point(&point),
                normal,
                area_m2,
                region: 0,
            }
        })
        .collect();
    points.sort_by_key(|point| point.link);
    points
}

/// The solids whose surface is sampled.
struct Solids<'a> {
    hand: &'a Hand,
    rest: &'a PosedHand,
    hulls: &'a [Hull],
}

impl Solids<'_> {
    fn candidates(&self, count: usize) -> Vec<Candidate> {
        let capsules = (0..self.hand.capsules.len()).filter(|&i| self.hand.exact[i]);
        let capsules =
            || (capsules.clone()).filter(|&i| !self.hand.is_arm(self.hand.capsules[i].link));
        let hulls = (0..self.hulls.len()).filter(|&i| !self.hand.is_arm(self.hulls[i].link));
        let mut total: f64 = capsules().map(|i| self.capsule_area(i)).sum();
        total += (hulls.clone().map(|i| self.hulls[i].area_m2())).sum::<f64>();
        let share = total / (count as f64 * CANDIDATES_PER_POINT);
        let mut candidates = Vec::new();
        for i in capsules() {
            self.on_capsule(i, share, &mut candidates);
        }
        for i in hulls {
            self.on_hull(i, share, &mut candidates);
        }
        candidates
    }

    fn capsule_area(&self, i: usize) -> f64 {
        let [a, b] = self.rest.capsules[i];
        let radius = self.hand.capsules[i].radius_m;
        std::f64::consts::TAU * radius * ((b - a).norm() + 2.0 * radius)
    }

    fn on_capsule(&self, i: usize, share: f64, candidates: &mut Vec<Candidate>) {
        let capsule = &self.hand.capsules[i];
        let area = self.capsule_area(i);
        let count = (1..u32::MAX)
            .find(|&n| f64::from(n) * share >= area)
            .expect("the share is a fixed part of all areas");
        let [a, b] = self.rest.capsules[i];
        let length = (b - a).norm();
        let along = (b - a).try_normalize(1e-12).unwrap_or_else(Vector3::z);
        let across = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
        let third = along.cross(&across);
        for k in 0..count {
            // A slice of given height has the same area on a sphere as on the surrounding cylinder (Archimedes).
            let height = (f64::from(k) + 0.5) / f64::from(count)
                * (length + 2.0 * capsule.radius_m)
                - capsule.radius_m;
            let on_axis = height.clamp(0.0, length);
            let sine = (height - on_axis) / capsule.radius_m;
            let (sin, cos) = libm::sincos(f64::from(k) * GOLDEN_ANGLE);
            let normal =
                along * sine + (across * cos + third * sin) * (1.0 - sine * sine).max(0.0).sqrt();
            let point = a + along * on_axis + normal * capsule.radius_m;
            if !self.in_capsule(Some(i), &point) && !self.in_hull(None, &point, &normal) {
                candidates.push(Candidate {
                    link: capsule.link,
                    point,
                    normal,
                    area_m2: area / f64::from(count),
                });
            }
        }
    }

    /// Puts candidates on each triangle in proportion to its area; the remainder is carried on to the next triangle.
    fn on_hull(&self, i: usize, share: f64, candidates: &mut Vec<Candidate>) {
        let hull = &self.hulls[i];
        let frame = &self.rest.object_from_link[hull.link.0];
        let (mut left, mut k) = (0.5, 0.0);
        for triangle in &hull.triangles {
            let doubled = hull.doubled(triangle);
            left += doubled.norm() / 2.0 / share;
            let [a, b, c] = hull.corners(triangle);
            while left >= 1.0 {
                left -= 1.0;
                k += 1.0;
                let point = frame.point(&in_triangle([a, b, c], k));
                let normal = frame.direction(&doubled.normalize());
                if !self.in_capsule(None, &point) && !self.in_hull(Some(i), &point, &normal) {
                    candidates.push(Candidate {
                        link: hull.link,
                        point,
                        normal,
                        area_m2: share,
                    });
                }
            }
        }
    }

    /// Whether a point lies inside an exact capsule other than its own. If two surfaces coincide, the first capsule keeps
    /// its points.
    fn in_capsule(&self, own: Option<usize>, point: &Vector3<f64>) -> bool {
        self.hand.capsules.iter().enumerate().any(|(i, capsule)| {
            let tie = if own.is_some_and(|own| i < own) {
                1e-9
            } else {
                -1e-9
            };
            Some(i) != own
                && self.hand.exact[i]
                && axis_distance(point, &self.rest.capsules[i]) < capsule.radius_m + tie
        })
    }

    /// The same for hulls, which come after all capsules. A point of a face that lies against another hull counts as
    /// inside.
    fn in_hull(&self, own: Option<usize>, point: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
        let ahead = point + normal * AHEAD_M;
        self.hulls.iter().enumerate().any(|(i, hull)| {
            let tie = if own.is_some_and(|own| i < own) {
                -1e-9
            } else {
                1e-9
            };
            let frame = &self.rest.object_from_link[hull.link.0];
            let depth = |point| hull.depth(&frame.inverse_point(point));
            Some(i) != own && (depth(point) > tie || depth(&ahead) > tie)
        })
    }
}

/// Clearance that is checked in front of a face, metres.
const AHEAD_M: f64 = 1e-5;

/// Squared distance along one sheet of the surface; infinite between surfaces that face each other, as on two fingers side
/// by side.
fn separation(a: &Candidate, b: &Candidate) -> f64 {
    if a.normal.dot(&b.normal) > 0.0 {
        (a.point - b.point).norm_squared()
    } else {
        f64::INFINITY
    }
}

fn farthest(candidates: &[Candidate], count: usize) -> Vec<usize> {
    let mut gaps = vec![f64::INFINITY; candidates.len()];
    let mut chosen = Vec::with_capacity(count);
    let mut next = 0;
    while chosen.len() < count.min(candidates.len()) {
        chosen.push(next);
        let newest = &candidates[next];
        let mut widest = -1.0;
        for (i, candidate) in candidates.iter().enumerate() {
            gaps[i] = gaps[i].min(separation(candidate, newest));
            if gaps[i] > widest {
                (widest, next) = (gaps[i], i);
            }
        }
    }
    chosen
}

/// For each candidate, the index in `chosen` of the nearest chosen candidate.
fn assign(candidates: &[Candidate], chosen: &[usize]) -> Vec<usize> {
    candidates
        .iter()
        .map(|candidate| {
            let mut nearest = (f64::INFINITY, 0);
            let mut any = (f64::INFINITY, 0);
            for (cell, &index) in chosen.iter().enumerate() {
                let gap = (candidate.point - candidates[index].point).norm_squared();
                if gap < any.0 {
                    any = (gap, cell);
                }
                if gap < nearest.0 && candidate.normal.dot(&candidates[index].normal) > 0.0 {
                    nearest = (gap, cell);
                }
            }
            if nearest.0.is_finite() {
                nearest.1
            } else {
                any.1
            }
        })
        .collect()
}

/// The candidate nearest to the centroid of each cell.
fn recentre(candidates: &[Candidate], cells: &[usize], count: usize) -> Vec<usize> {
    let mut centroids = vec![(Vector3::zeros(), 0.0); count];
    for (candidate, &cell) in candidates.iter().zip(cells) {
        centroids[cell].0 += candidate.point * candidate.area_m2;
        centroids[cell].1 += candidate.area_m2;
    }
    let mut best = vec![(f64::INFINITY, 0); count];
    for (i, (candidate, &cell)) in candidates.iter().zip(cells).enumerate() {
        let gap = (candidate.point - centroids[cell].0 / centroids[cell].1).norm_squared();
        if gap < best[cell].0 {
            best[cell] = (gap, i);
        }
    }
    best.into_iter().map(|(_, index)| index).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::HandFiles;

    #[test]
    fn points_lie_evenly_on_the_outside_of_the_union() {
        let hand = Hand::human();
        let mut rest = PosedHand::default();
        hand.pose(&hand.rest_coordinates(), &mut rest);
        let mut spacing = Vec::new();
        for (i, point) in hand.surface.iter().enumerate() {
            let distance = |p: &Vector3<f64>| {
                let gaps = hand.capsules.iter().zip(&rest.capsules);
                gaps.map(|(c, ends)| axis_distance(p, ends) - c.radius_m)
                    .fold(f64::INFINITY, f64::min)
            };
            let normal = hand.point_normal(&rest, i);
            assert!((normal.norm() - 1.0).abs() < 1e-12);
            assert!(
                distance(&rest.points[i]).abs() < 1e-8,
                "point {i} is {} off",
                distance(&rest.points[i])
            );
            assert!(
                distance(&(rest.points[i] + normal * 1e-5)) > 0.0,
                "normal {i} points inward"
            );
            let nearest = (0..hand.surface.len())
                .filter(|&j| j != i && hand.point_normal(&rest, j).dot(&normal) > 0.0)
                .map(|j| (rest.points[j] - rest.points[i]).norm())
                .fold(f64::INFINITY, f64::min);
            spacing.push(nearest);
            assert!(point.area_m2 > 0.0);
        }
        spacing.sort_by(f64::total_cmp);
        let (low, high) = (
            spacing[spacing.len() / 20],
            spacing[spacing.len() * 19 / 20],
        );
        assert!(low > 0.6 * high, "spacing from {low} to {high} m");
    }

    /// One sphere and one long capsule, far apart: the areas must add up to 4πr² + 2πrℓ + 4πr².
    #[test]
    fn areas_add_up() {
        let text = r#"<robot name="r"><link name="a"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
            <link name="b"><collision><origin xyz="0 0 0.1"/><geometry><capsule radius="0.01" length="0.05"/></geometry></collision></link>
            <joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/></joint></robot>"#;
        let hand = Hand::from_files(&HandFiles::of_texts([["hand", text]])).unwrap();
        let area: f64 = hand.surface.iter().map(|point| point.area_m2).sum();
        let exact = std::f64::consts::PI
            * (4.0 * 0.02_f64.powi(2) + 2.0 * 0.01 * 0.05 + 4.0 * 0.01_f64.powi(2));
        assert!((area / exact - 1.0).abs() < 1e-9, "{area} m², not {exact}");
        assert_eq!(hand.surface.len(), POINTS);
    }
}
