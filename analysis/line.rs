//! Straight lines through points.

/// The line y = slope · x + offset, and its share of explained variance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    pub(crate) slope: f64,
    pub(crate) offset: f64,
    pub(crate) r_squared: f64,
}

impl Line {
    /// Least squares.
    pub(crate) fn through(points: &[[f64; 2]]) -> Self {
        let count = points.len() as f64;
        let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
        let centre = [mean(0), mean(1)];
        let moment = |a: usize, b: usize| -> f64 {
            points
                .iter()
                .map(|point| (point[a] - centre[a]) * (point[b] - centre[b]))
                .sum()
        };
        let slope = moment(0, 1) / moment(0, 0);
        let residual = moment(1, 1) - slope * moment(0, 1);
        Self {
            slope,
            offset: centre[1] - slope * centre[0],
            r_squared: 1.0 - residual / moment(1, 1),
        }
    }

    pub(crate) fn at(&self, x: f64) -> f64 {
        self.slope * x + self.offset
    }
}
