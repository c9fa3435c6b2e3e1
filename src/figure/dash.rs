//! Splits dashed lines into their solid pieces.

/// The dashes of a straight line with the pattern (length of a dash, length of a gap). The line starts and ends with a
/// dash: dashes and gaps are scaled so that a whole number of them fits.
pub(super) fn line(from: [f64; 2], to: [f64; 2], [dash, gap]: [f64; 2]) -> Vec<[[f64; 2]; 2]> {
    let length = libm::hypot(to[0] - from[0], to[1] - from[1]);
    let at = |distance: f64| between(from, to, (distance / length).min(1.0));
    let gaps = ((length - dash) / (dash + gap)).round().max(0.0);
    let fit = length / (dash + gaps * (dash + gap));
    let mut dashes = Vec::new();
    let mut start = 0.0;
    while start < length - 1e-6 * length {
        dashes.push([at(start), at(start + dash * fit)]);
        start += (dash + gap) * fit;
    }
    dashes
}

/// The dashes of straight lines from point to point. The pattern continues around corners.
pub(super) fn polyline(points: &[[f64; 2]], pattern: [f64; 2]) -> Vec<[[f64; 2]; 2]> {
    let mut dashes = Vec::new();
    // Whether the current piece is a gap, and its remaining length.
    let (mut gap, mut left) = (0, pattern[0]);
    for pair in points.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let length = libm::hypot(to[0] - from[0], to[1] - from[1]);
        let mut start = 0.0;
        while start < length {
            let end = (start + left).min(length);
            if gap == 0 {
                dashes.push([start / length, end / length].map(|t| between(from, to, t)));
            }
            left -= end - start;
            start = end;
            // A remainder that vanishes against the coordinates would never be used up.
            if left <= 1e-6 {
                gap = 1 - gap;
                left = pattern[gap];
            }
        }
    }
    dashes
}

fn between(from: [f64; 2], to: [f64; 2], t: f64) -> [f64; 2] {
    [0, 1].map(|axis| from[axis] + t * (to[axis] - from[axis]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dashed_line_ends_with_dashes() {
        let dashes = line([0.0, 5.0], [97.0, 5.0], [6.0, 4.0]);
        assert_eq!(dashes.len(), 10);
        assert!((dashes[9][1][0] - 97.0).abs() < 1e-9);
        assert!(dashes.windows(2).all(|pair| pair[0][1][0] < pair[1][0][0]));
    }

    #[test]
    fn dashes_run_on_around_corners() {
        assert_eq!(
            polyline(&[[0.0, 0.0], [3.0, 0.0], [3.0, 20.0]], [6.0, 4.0]),
            [
                [[0.0, 0.0], [3.0, 0.0]],
                [[3.0, 0.0], [3.0, 3.0]],
                [[3.0, 7.0], [3.0, 13.0]],
                [[3.0, 17.0], [3.0, 20.0]],
            ]
        );
    }

    #[test]
    fn dashes_end_however_the_lengths_round() {
        assert_eq!(polyline(&[[0.0, 0.0], [0.0, 1e3]], [9.1, 5.85]).len(), 67);
    }
}
