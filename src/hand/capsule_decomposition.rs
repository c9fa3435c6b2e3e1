//! Capsules that approximate a convex solid for collision.

use nalgebra::Vector3;

use super::hull::{Hull, directions};
use super::{Capsule, axis_distance};

/// Cells along the longest side of the grid of points to cover.
const CELLS: f64 = 24.0;
/// Number of candidate directions of an axis.
const DIRECTIONS: u32 = 96;
/// An axis ends where its depth falls below this share of the depth at its start.
const LEAST_DEPTH: f64 = 0.8;
/// A point counts as covered this far outside a capsule, as a share of its radius.
const MARGIN: f64 = 0.3;
/// Points shallower than this share of the deepest point need not be covered.
const SHALLOW: f64 = 0.5;
/// Largest number of capsules in a solid.
const MOST: usize = 8;

/// Capsules that fill a hull, largest first, none sticking out.
///
/// Greedy: each capsule starts from the deepest point not yet covered and takes the longest axis that stays deep.
pub(super) fn capsules_in(hull: &Hull) -> Vec<Capsule> {
    let [low, high] = hull.bounds();
    let size = high - low;
    let cell = size.max() / CELLS;
    let mut open = grid(hull, &low, &size, cell);
    let mut capsules: Vec<Capsule> = Vec::new();
    let Some(deepest) = open.iter().map(|(_, depth)| *depth).max_by(f64::total_cmp) else {
        return capsules;
    };
    while capsules.len() < MOST {
        let next = open.iter().max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((start, depth)) = next
            .copied()
            .filter(|(_, depth)| *depth > SHALLOW * deepest)
        else {
            break;
        };
        let capsule = longest(hull, &start, depth, cell / 2.0);
        let ends = [capsule.a, capsule.b];
        let reach = capsule.radius_m * (1.0 + MARGIN) + cell / 4.0;
        open.retain(|(point, _)| axis_distance(point, &ends) > reach);
        capsules.push(capsule);
    }
    capsules
}

/// Grid points inside the hull, with their depths.
fn grid(
    hull: &Hull,
    low: &Vector3<f64>,
    size: &Vector3<f64>,
    cell: f64,
) -> Vec<(Vector3<f64>, f64)> {
    let steps = |axis: usize| {
        let count = (1..64u32)
            .find(|&n| f64::from(n) * cell >= size[axis] - 1e-9)
            .unwrap_or(64)
            .max(4);
        (0..=count).map(move |i| f64::from(i) / f64::from(count))
    };
    let mut points = Vec::new();
    for x in steps(0) {
        for y in steps(1) {
            for z in steps(2) {
                let point = low + size.component_mul(&Vector3::new(x, y, z));
                let depth = hull.depth(&point);
                if depth > 0.0 {
                    points.push((point, depth));
                }
            }
        }
    }
    points
}

/// The longest capsule through a point of this depth.
fn longest(hull: &Hull, start: &Vector3<f64>, depth: f64, step: f64) -> Capsule {
    let axes = (0..3).map(|axis| Vector3::ith(axis, 1.0));
    // Half of the sphere is enough, since an axis has two ends.
    let all = axes.chain(directions(2 * DIRECTIONS).take(DIRECTIONS as usize));
    let mut best = (-1.0, *start, *start);
    for direction in all {
        let [back, ahead] = [-step, step].map(|step| {
            let inside = |n: &u32| {
                let at = start + direction * (f64::from(*n) * step);
                hull.depth(&at) >= LEAST_DEPTH * depth
            };
            let count = (1..1000u32).take_while(inside).last().unwrap_or(0);
            f64::from(count) * step
        });
        if ahead - back > best.0 + 1e-9 {
            best = (
                ahead - back,
                start + direction * back,
                start + direction * ahead,
            );
        }
    }
    let (_, a, b) = best;
    // In a convex solid, the depth along a segment is least at one of its ends.
    let radius_m = hull.depth(&a).min(hull.depth(&b)).min(depth);
    Capsule {
        link: hull.link,
        a,
        b,
        radius_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::LinkId;

    fn cuboid(size: [f64; 3]) -> Hull {
        let corner =
            |k: usize| Vector3::from_fn(|i, _| if k >> i & 1 == 1 { size[i] } else { 0.0 });
        let corners: Vec<_> = (0..8).map(corner).collect();
        Hull::of(LinkId(0), &corners).unwrap()
    }

    /// Capsules stay inside, and what they leave open of a finger and of a palm is thin.
    #[test]
    fn boxes_are_filled() {
        for (size, most) in [
            ([0.018, 0.02, 0.05], 1),
            ([0.084, 0.1, 0.026], 8),
            ([0.03; 3], 1),
        ] {
            let hull = cuboid(size);
            let capsules = capsules_in(&hull);
            assert!(
                (1..=most).contains(&capsules.len()),
                "{size:?}: {}",
                capsules.len()
            );
            for capsule in &capsules {
                for end in [&capsule.a, &capsule.b] {
                    assert!(hull.depth(end) > capsule.radius_m - 1e-12);
                }
            }
            let mut worst = 0.0f64;
            for (point, _) in grid(&hull, &Vector3::zeros(), &Vector3::from(size), 0.002) {
                let gaps = capsules
                    .iter()
                    .map(|c| axis_distance(&point, &[c.a, c.b]) - c.radius_m);
                let gap = gaps.fold(f64::INFINITY, f64::min);
                if hull.depth(&point) > 0.002 {
                    worst = worst.max(gap);
                }
            }
            assert!(worst < 0.01, "{size:?}: {worst} m open");
        }
    }
}
