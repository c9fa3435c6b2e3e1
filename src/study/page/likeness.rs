//! The grasps of a file in the plane, alike ones near each other, and the curves of their kinds.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::pack::Pack;
use crate::figure::layout::{majorise, pack as beside, place_among, stress};
use crate::space::Space;
use crate::topography::Rarefaction;

/// Greatest number of grasps of which all are placed together; of more, [`LANDMARKS`] are, and the others among these.
const TOGETHER: usize = 300;
/// Greatest number of landmarks.
const LANDMARKS: usize = 200;
/// Width and height of the picture, about that of its panel: pictures of several populations are packed for it.
const ASPECT: f64 = 1.6;
/// Margin about the picture of a population, of the longest of all.
const MARGIN: f64 = 0.06;
/// Points of a curve of kinds.
const POINTS: usize = 40;

/// The picture of a population: a place for each grasp, metres.
pub(super) struct Likeness {
    places: Vec<[f64; 2]>,
    /// Root mean square of the relative errors of the distances in the picture; NaN if there are none.
    error: f64,
}

impl Likeness {
    /// Places grasps so that distances in the plane follow those of `space` ([`majorise`]).
    pub(super) fn of(space: &dyn Space, poses: &[&[f64]]) -> Self {
        let count = poses.len();
        let (fixed, rows) = if count <= TOGETHER {
            let row = |pose: &&[f64]| {
                poses
                    .iter()
                    .map(|other| space.distance(pose, other))
                    .collect()
            };
            ((0..count).collect(), poses.par_iter().map(row).collect())
        } else {
            landmarks(space, poses)
        };
        let distances: Vec<f64> = (rows.iter())
            .flat_map(|row: &Vec<f64>| fixed.iter().map(|other: &usize| row[*other]))
            .collect();
        let placed = majorise(fixed.len(), &distances, 0).points;
        let pairs = distances.iter().filter(|distance| **distance > 0.0).count() as f64 / 2.0;
        let error = (stress(&placed, &distances) / pairs).sqrt();
        let places = if count <= TOGETHER {
            placed
        } else {
            let place = |grasp: usize| {
                let row: Vec<f64> = rows.iter().map(|row| row[grasp]).collect();
                place_among(&placed, &row)
            };
            (0..count).into_par_iter().map(place).collect()
        };
        Self { places, error }
    }

    /// Least and greatest coordinates along an axis.
    fn bounds(&self, axis: usize) -> [f64; 2] {
        let along = || self.places.iter().map(|place| place[axis]);
        let least = along().fold(f64::INFINITY, f64::min);
        let most = along().fold(f64::NEG_INFINITY, f64::max);
        if least <= most {
            [least, most]
        } else {
            [0.0; 2]
        }
    }
}

/// Landmarks and the distances of all grasps from each. Each landmark is the grasp that is farthest from those before it (de
/// Silva and Tenenbaum 2004, *Sparse Multidimensional Scaling Using Landmark Points*), so that every cluster has some. None
/// coincides with another.
fn landmarks(space: &dyn Space, poses: &[&[f64]]) -> (Vec<usize>, Vec<Vec<f64>>) {
    let mut nearest = vec![f64::INFINITY; poses.len()];
    let (mut chosen, mut rows) = (Vec::new(), Vec::new());
    let mut next = 0;
    while chosen.len() < LANDMARKS && nearest[next] > 0.0 {
        let distances = poses
            .par_iter()
            .map(|pose| space.distance(poses[next], pose));
        let row: Vec<f64> = distances.collect();
        for (nearest, distance) in nearest.iter_mut().zip(&row) {
            *nearest = nearest.min(*distance);
        }
        chosen.push(next);
        rows.push(row);
        let farthest =
            (0..poses.len()).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]).then(b.cmp(&a)));
        next = farthest.unwrap_or(0);
    }
    (chosen, rows)
}

/// The pictures of all populations side by side, with their names and the places of these. Distances within a picture are in
/// metres; those between two mean nothing.
pub(super) fn packed(pictures: &[(String, Likeness)], pack: &mut Pack) -> Value {
    let bounds: Vec<[[f64; 2]; 2]> = (pictures.iter())
        .map(|(_, picture)| [0, 1].map(|axis| picture.bounds(axis)))
        .collect();
    let longest = bounds
        .iter()
        .flatten()
        .map(|[least, most]| most - least)
        .fold(0.0, f64::max);
    let margin = if longest > 0.0 { MARGIN * longest } else { 1.0 };
    let sizes: Vec<[f64; 2]> = (bounds.iter())
        .map(|bounds| bounds.map(|[least, most]| most - least + 2.0 * margin))
        .collect();
    let (corners, size) = beside(&sizes, ASPECT);
    let mut places = [Vec::new(), Vec::new()];
    for (((_, picture), bounds), corner) in pictures.iter().zip(&bounds).zip(&corners) {
        for (axis, places) in places.iter_mut().enumerate() {
            let shift = corner[axis] + margin - bounds[axis][0];
            places.extend(picture.places.iter().map(|place| place[axis] + shift));
        }
    }
    let parts = pictures.iter().zip(&corners).zip(&sizes);
    let parts = parts.map(|(((name, picture), corner), size)| {
        let error = picture.error.is_finite().then_some(picture.error);
        json!({ "name": name, "corner": corner, "size": size, "error": error })
    });
    json!({
        "size": size,
        "parts": parts.collect::<Vec<_>>(),
        "x": pack.floats(&places[0]),
        "y": pack.floats(&places[1]),
    })
}

/// The curve for each way of counting kinds that finds any, by its name.
pub(super) fn curves(
    kinds: &BTreeMap<&str, BTreeMap<String, usize>>,
) -> BTreeMap<String, Rarefaction> {
    let found = kinds.iter().filter(|(_, counts)| !counts.is_empty());
    let curve = found.map(|(name, counts)| {
        let sizes: Vec<usize> = counts.values().copied().collect();
        ((*name).to_owned(), Rarefaction::new(&sizes, POINTS))
    });
    curve.collect()
}

/// The curves as an entry of the header.
pub(super) fn told(curves: &BTreeMap<String, Rarefaction>) -> Value {
    let told = curves
        .iter()
        .map(|(name, curve)| (name.clone(), json!(curve)));
    Value::Object(told.collect::<Map<_, _>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Euclidean;

    /// Three clusters in eight dimensions, `count` points.
    fn clusters(count: usize) -> Vec<Vec<f64>> {
        let point = |k: usize| {
            let mut x = vec![0.0; 8];
            x[k % 3] = 1.0;
            x[3 + k % 5] = 0.1 * ((k * 7919) % 13) as f64 / 13.0;
            x
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn alike_points_are_near_with_and_without_landmarks() {
        for count in [60, 900] {
            let points = clusters(count);
            let points: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
            let space = Euclidean::new(8);
            let found = Likeness::of(&space, &points);
            assert_eq!(found.places.len(), count);
            let gap = |a: usize, b: usize| {
                let [p, q] = [found.places[a], found.places[b]];
                libm::hypot(p[0] - q[0], p[1] - q[1])
            };
            for k in 3..count {
                let others = (0..3).filter(|other| other % 3 != k % 3);
                let apart = others
                    .map(|other| gap(k, other))
                    .fold(f64::INFINITY, f64::min);
                assert!(gap(k, k % 3) < 0.5 * apart, "{count}: {k}");
            }
            assert!(found.error < 0.6, "{}", found.error);
        }
    }

    #[test]
    fn pictures_of_populations_do_not_overlap() {
        let points = clusters(30);
        let points: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
        let picture = || Likeness::of(&Euclidean::new(8), &points);
        let pictures = [
            ("one".to_owned(), picture()),
            ("other".to_owned(), picture()),
        ];
        let told = packed(&pictures, &mut Pack::default());
        let number = |part: usize, what: &str, axis: usize| {
            told["parts"][part][what][axis].as_f64().unwrap()
        };
        let apart = |axis: usize| {
            number(0, "corner", axis) + number(0, "size", axis) <= number(1, "corner", axis) + 1e-9
        };
        assert!(apart(0) || apart(1), "{told}");
        assert_eq!(told["x"]["count"], 60);
    }

    #[test]
    fn few_points_have_places() {
        let space = Euclidean::new(1);
        for points in [vec![], vec![vec![1.0]], vec![vec![1.0], vec![1.0]]] {
            let points: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
            let found = Likeness::of(&space, &points);
            assert!(found.places.iter().flatten().all(|place| place.is_finite()));
            let told = packed(&[("one".to_owned(), found)], &mut Pack::default());
            assert!(told["size"][0].as_f64().unwrap() > 0.0);
        }
    }
}
