//! Finds points near a given point without computing all distances.

/// Points in a tree of boxes, each halved across its longest side (J. L. Bentley, Commun. ACM 18, 509 (1975)).
pub(super) struct Places {
    points: Vec<Vec<f64>>,
    /// Point numbers, ordered so that the points of each box are contiguous.
    order: Vec<usize>,
    boxes: Vec<Bounds>,
}

struct Bounds {
    low: Vec<f64>,
    high: Vec<f64>,
    /// Range of its points in `order`.
    from: usize,
    to: usize,
    /// Index of the first of its two consecutive halves; `None` for a leaf.
    halves: Option<usize>,
}

/// Greatest number of points in a leaf.
const FEW: usize = 8;
/// Rounding error of a distance, relative to the coordinates.
const ROUNDED: f64 = 1e-12;

impl Places {
    /// Builds the tree for points with equally many coordinates.
    pub(super) fn new(points: Vec<Vec<f64>>) -> Self {
        let mut order: Vec<usize> = (0..points.len()).collect();
        let mut boxes = vec![Bounds::around(&points, &order, 0, points.len())];
        let mut next = 0;
        while next < boxes.len() {
            let Bounds { from, to, .. } = boxes[next];
            let sides = boxes[next].low.iter().zip(&boxes[next].high);
            let lengths = sides.map(|(low, high)| high - low).enumerate();
            let longest = lengths.max_by(|(_, a), (_, b)| a.total_cmp(b));
            if let (true, Some((side, _))) = (to - from > FEW, longest) {
                let middle = from.midpoint(to);
                order[from..to].select_nth_unstable_by(middle - from, |a, b| {
                    (points[*a][side].total_cmp(&points[*b][side])).then(a.cmp(b))
                });
                boxes[next].halves = Some(boxes.len());
                for (from, to) in [(from, middle), (middle, to)] {
                    boxes.push(Bounds::around(&points, &order, from, to));
                }
            }
            next += 1;
        }
        Self {
            points,
            order,
            boxes,
        }
    }

    /// Numbers of the points within `reach` of `place` (up to rounding), ascending.
    pub(super) fn within(&self, reach: f64, place: &[f64]) -> Vec<usize> {
        let wide = widened(reach, place);
        let mut found = Vec::new();
        let mut rest = vec![0];
        while let Some(number) = rest.pop() {
            let bounds = &self.boxes[number];
            // NaN counts as near.
            if bounds.squared_distance(place) > wide * wide {
                continue;
            }
            if let Some(first) = bounds.halves {
                rest.extend([first, first + 1]);
                continue;
            }
            let inside = self.order[bounds.from..bounds.to].iter().copied();
            found.extend(inside.filter(|k| !are_apart(&self.points[*k], place, wide)));
        }
        found.sort_unstable();
        found
    }
}

/// `reach` with the rounding error of a distance from `place`.
pub(super) fn widened(reach: f64, place: &[f64]) -> f64 {
    let largest = place.iter().fold(reach, |most, c| most.max(c.abs()));
    reach + ROUNDED * largest
}

/// Whether two points are farther apart than `wide`. A NaN excludes nothing by itself.
pub(super) fn are_apart(one: &[f64], other: &[f64], wide: f64) -> bool {
    let mut squared = 0.0;
    one.iter().zip(other).any(|(a, b)| {
        squared += (a - b) * (a - b);
        squared > wide * wide
    })
}

impl Bounds {
    fn around(points: &[Vec<f64>], order: &[usize], from: usize, to: usize) -> Self {
        let sides = points.first().map_or(0, Vec::len);
        let (mut low, mut high) = (vec![f64::INFINITY; sides], vec![f64::NEG_INFINITY; sides]);
        for point in order[from..to].iter().map(|k| &points[*k]) {
            for ((low, high), c) in low.iter_mut().zip(&mut high).zip(point) {
                (*low, *high) = (low.min(*c), high.max(*c));
            }
        }
        Self {
            low,
            high,
            from,
            to,
            halves: None,
        }
    }

    fn squared_distance(&self, place: &[f64]) -> f64 {
        let sides = self.low.iter().zip(&self.high).zip(place);
        sides
            .map(|((low, high), c)| (low - c).max(c - high).max(0.0).powi(2))
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Task, stream};
    use rand::RngExt;

    #[test]
    fn those_within_reach_are_found() {
        let mut rng = stream(1, Task::Start, 0);
        for sides in [0_usize, 1, 3] {
            // A coarse grid makes many points coincide or lie exactly at the reach.
            let mut point = || -> Vec<f64> {
                (0..sides)
                    .map(|_| f64::from(rng.random_range(0..9_u8)))
                    .collect()
            };
            let points: Vec<Vec<f64>> = (0..300).map(|_| point()).collect();
            let places = Places::new(points.clone());
            for _ in 0..50 {
                let place = point();
                let squared = |other: &[f64]| -> f64 {
                    other.iter().zip(&place).map(|(a, b)| (a - b).powi(2)).sum()
                };
                for reach in [0.0, 1.0, 2.0] {
                    let expected: Vec<usize> = (0..300)
                        .filter(|k| squared(&points[*k]) <= reach * reach)
                        .collect();
                    assert_eq!(places.within(reach, &place), expected);
                }
            }
        }
        assert!(Places::new(Vec::new()).within(1.0, &[0.0]).is_empty());
    }
}
