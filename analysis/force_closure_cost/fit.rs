//! Straight lines through costs.

/// y = slope · x + offset with the share of the variance that it explains.
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

/// t = a log₁₀ n + b, as in the paper.
pub(crate) fn logarithm(contacts: &[usize], costs: &[f64]) -> Line {
    line(contacts, costs, f64::log10, |t| t)
}

/// t = a n + b.
pub(crate) fn proportion(contacts: &[usize], costs: &[f64]) -> Line {
    line(contacts, costs, |n| n, |t| t)
}

/// log₁₀ t = a log₁₀ n + b: a power law.
pub(crate) fn power(contacts: &[usize], costs: &[f64]) -> Line {
    line(contacts, costs, f64::log10, f64::log10)
}

fn line(contacts: &[usize], costs: &[f64], x: impl Fn(f64) -> f64, y: impl Fn(f64) -> f64) -> Line {
    let points: Vec<[f64; 2]> = contacts
        .iter()
        .zip(costs)
        .map(|(&n, &t)| [x(n as f64), y(t)])
        .collect();
    Line::through(&points)
}
