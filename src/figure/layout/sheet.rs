//! Layout of a graph on a sheet: its components stand side by side, and lengths of links determine each component.

use super::graph::{components, majorise, pack, separate, shortest_paths};

/// Largest number of canvas units per unit of length, so that two nodes are not a sheet apart.
const LARGEST_UNIT: f64 = 230.0;

/// Centres of discs of these `radii` inside `frame` (upper left, lower right). Distances between nodes that `links` (ends,
/// length ≥ 0) connect are about proportional to the shortest paths between them. `seed` only separates nodes that the
/// layout puts in the same place.
///
/// # Panics
/// If a link refers to a node that has no radius.
pub fn place_in(
    frame: [[f64; 2]; 2],
    radii: &[f64],
    links: &[([usize; 2], f64)],
    seed: u64,
) -> Vec<[f64; 2]> {
    let count = radii.len();
    let largest = radii.iter().copied().fold(0.0, f64::max) + 4.0;
    let room = [0, 1].map(|axis| frame[1][axis] - frame[0][axis] - 2.0 * largest);
    let parts = components(count, links);
    let mut index_in_part = vec![0; count];
    let mut parts_of = vec![0; count];
    for (part, nodes) in parts.iter().enumerate() {
        for (index, &node) in nodes.iter().enumerate() {
            (index_in_part[node], parts_of[node]) = (index, part);
        }
    }
    let mut local = vec![[0.0; 2]; count];
    let mut boxes = Vec::with_capacity(parts.len());
    for (part, nodes) in parts.iter().enumerate() {
        let inside: Vec<([usize; 2], f64)> = (links.iter())
            .filter(|(ends, _)| parts_of[ends[0]] == part)
            .map(|&(ends, length)| (ends.map(|end| index_in_part[end]), length))
            .collect();
        let layout = majorise(nodes.len(), &shortest_paths(nodes.len(), &inside), seed);
        let (points, extent) = turned(&layout.points);
        for (&node, point) in nodes.iter().zip(points) {
            local[node] = point;
        }
        // The margin around every component is half a typical link.
        boxes.push(extent.map(|side| side + 0.6));
    }
    let (corners, extent) = pack(&boxes, room[0] / room[1]);
    let fit = (0..2)
        .map(|axis| room[axis] / extent[axis].max(f64::MIN_POSITIVE))
        .fold(LARGEST_UNIT, f64::min);
    let mut points: Vec<[f64; 2]> = (0..count)
        .map(|node| {
            [0, 1].map(|axis| fit * (corners[parts_of[node]][axis] + 0.3 + local[node][axis]))
        })
        .collect();
    for _ in 0..4 {
        separate(&mut points, radii, 5.0);
        fit_into(&mut points, frame, largest);
    }
    points
}

/// Rotates points so that their longest extent is horizontal, and moves their bounding box to the origin.
fn turned(points: &[[f64; 2]]) -> (Vec<[f64; 2]>, [f64; 2]) {
    let count = points.len().max(1) as f64;
    let mean = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count);
    let moment = |a: usize, b: usize| {
        points
            .iter()
            .map(|point| (point[a] - mean[a]) * (point[b] - mean[b]))
            .sum::<f64>()
    };
    let angle = 0.5 * libm::atan2(2.0 * moment(0, 1), moment(0, 0) - moment(1, 1));
    let (sin, cos) = libm::sincos(angle);
    let mut points: Vec<[f64; 2]> = points
        .iter()
        .map(|&[x, y]| [cos * x + sin * y, cos * y - sin * x])
        .collect();
    let [low, high] = bounds(&points);
    for point in &mut points {
        *point = [point[0] - low[0], point[1] - low[1]];
    }
    (points, [high[0] - low[0], high[1] - low[1]])
}

/// Smallest and largest coordinates; zeros if there are no points.
fn bounds(points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    if points.is_empty() {
        return [[0.0; 2]; 2];
    }
    let least = |axis: usize| {
        points
            .iter()
            .map(|point| point[axis])
            .fold(f64::INFINITY, f64::min)
    };
    let most = |axis: usize| {
        points
            .iter()
            .map(|point| point[axis])
            .fold(f64::NEG_INFINITY, f64::max)
    };
    [[least(0), least(1)], [most(0), most(1)]]
}

/// Centres points in `frame`. Each direction is squeezed only if it does not fit.
fn fit_into(points: &mut [[f64; 2]], frame: [[f64; 2]; 2], margin: f64) {
    let [low, high] = bounds(points);
    for axis in 0..2 {
        let room = frame[1][axis] - frame[0][axis] - 2.0 * margin;
        let squeeze = (room / (high[axis] - low[axis]).max(f64::MIN_POSITIVE)).min(1.0);
        let middle = 0.5 * (low[axis] + high[axis]);
        let centre = 0.5 * (frame[0][axis] + frame[1][axis]);
        for point in points.iter_mut() {
            point[axis] = centre + squeeze * (point[axis] - middle);
        }
    }
}
