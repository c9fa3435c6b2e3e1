//! Clipping of lines and polygons at a rectangle.

/// A rectangle, canvas units: left, top, right, bottom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Frame {
    pub(super) fn contains(&self, [x, y]: [f64; 2]) -> bool {
        x >= self.left && x <= self.right && y >= self.top && y <= self.bottom
    }

    /// The part of the segment inside the rectangle (Liang and Barsky 1984), if any.
    fn segment(&self, from: [f64; 2], to: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (step, room) in [
            (-dx, from[0] - self.left),
            (dx, self.right - from[0]),
            (-dy, from[1] - self.top),
            (dy, self.bottom - from[1]),
        ] {
            if step == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if step < 0.0 {
                enter = enter.max(room / step);
            } else {
                leave = leave.min(room / step);
            }
        }
        let at = |t: f64| [from[0] + t * dx, from[1] + t * dy];
        (enter <= leave).then(|| {
            // Ends inside stay bitwise equal, so that pieces join.
            let start = if enter > 0.0 { at(enter) } else { from };
            let end = if leave < 1.0 { at(leave) } else { to };
            [start, end]
        })
    }

    /// The pieces of a polyline inside the rectangle. A NaN coordinate breaks the line.
    pub(super) fn polyline(&self, points: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
        let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
        for pair in points.windows(2) {
            if pair.iter().flatten().any(|coordinate| coordinate.is_nan()) {
                continue;
            }
            let Some([from, to]) = self.segment(pair[0], pair[1]) else {
                continue;
            };
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&from) => piece.push(to),
                _ => pieces.push(vec![from, to]),
            }
        }
        pieces
    }

    /// The part of the polygon inside the rectangle (Sutherland and Hodgman 1974).
    pub(super) fn polygon(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let sides: [(usize, f64, f64); 4] = [
            (0, self.left, 1.0),
            (0, self.right, -1.0),
            (1, self.top, 1.0),
            (1, self.bottom, -1.0),
        ];
        let mut polygon = points.to_vec();
        for (axis, limit, inward) in sides {
            let depth = |point: &[f64; 2]| inward * (point[axis] - limit);
            let mut clipped = Vec::with_capacity(polygon.len() + 4);
            for (index, point) in polygon.iter().enumerate() {
                let before = &polygon[(index + polygon.len() - 1) % polygon.len()];
                let (a, b) = (depth(before), depth(point));
                if (a < 0.0) != (b < 0.0) {
                    let t = a / (a - b);
                    clipped.push([0, 1].map(|k| before[k] + t * (point[k] - before[k])));
                }
                if b >= 0.0 {
                    clipped.push(*point);
                }
            }
            polygon = clipped;
        }
        polygon
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame {
        left: 0.0,
        top: 0.0,
        right: 10.0,
        bottom: 10.0,
    };

    #[test]
    fn lines_are_cut_at_the_frame() {
        let points = [
            [-5.0, 5.0],
            [5.0, 5.0],
            [5.0, 25.0],
            [8.0, 25.0],
            [8.0, 5.0],
            [f64::NAN, 5.0],
            [1.0, 1.0],
            [2.0, 1.0],
        ];
        assert_eq!(
            FRAME.polyline(&points),
            [
                vec![[0.0, 5.0], [5.0, 5.0], [5.0, 10.0]],
                vec![[8.0, 10.0], [8.0, 5.0]],
                vec![[1.0, 1.0], [2.0, 1.0]],
            ]
        );
    }

    #[test]
    fn polygons_are_cut_at_the_frame() {
        let triangle = [[5.0, 5.0], [15.0, 5.0], [5.0, 15.0]];
        let clipped = FRAME.polygon(&triangle);
        let area: f64 = (0..clipped.len())
            .map(|i| {
                let (p, q) = (clipped[i], clipped[(i + 1) % clipped.len()]);
                0.5 * (p[0] * q[1] - q[0] * p[1])
            })
            .sum();
        assert!((area - 25.0).abs() < 1e-12, "{clipped:?}");
        assert!(
            FRAME
                .polygon(&[[20.0, 0.0], [30.0, 0.0], [25.0, 5.0]])
                .is_empty()
        );
    }
}
