//! Summaries of samples: densities for violins, quantiles for boxes.

use super::Scale;

/// A density drawn on both sides of a vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Violin {
    /// Its place on the x axis.
    pub at: f64,
    /// Half of its width at the largest density, in units of the x axis (decades on a logarithmic axis).
    pub half_width: f64,
    /// Pairs of y and density, in ascending order of y. Only ratios of densities matter.
    pub density: Vec<[f64; 2]>,
    /// Lower quartile, median and upper quartile, drawn inside if given.
    pub quartiles: Option<[f64; 3]>,
}

/// Quantiles of a sample, drawn as a box with whiskers.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantiles {
    /// Its place on the x axis.
    pub at: f64,
    /// Half of the width of the box, in units of the x axis (decades on a logarithmic axis).
    pub half_width: f64,
    /// End of the lower whisker, lower quartile, median, upper quartile, end of the upper whisker.
    pub values: [f64; 5],
}

/// Number of points at which a density is computed.
const PLACES: usize = 256;

impl Violin {
    /// The density and the quartiles of `samples`. The density uses a Gaussian kernel between the smallest and the largest
    /// sample, with Silverman's bandwidth 0.9 min(σ, interquartile range / 1.34) n^(−1/5) (1986, eq. 3.31). On a
    /// logarithmic y axis it is the density of the logarithm. Without samples nothing is drawn.
    pub fn from_samples(at: f64, half_width: f64, samples: &[f64], y: Scale) -> Self {
        let sorted = sorted(samples.iter().map(|&sample| y.transform(sample)));
        let quartiles = [0.25, 0.5, 0.75].map(|part| quantile(&sorted, part));
        let density = kernel_density(&sorted, quartiles[2] - quartiles[0]);
        Self {
            at,
            half_width,
            density: density.into_iter().map(|[v, d]| [y.invert(v), d]).collect(),
            quartiles: (!sorted.is_empty()).then(|| quartiles.map(|value| y.invert(value))),
        }
    }

    /// The density of a histogram, without quartiles. `edges` ascend and are one more than `counts`.
    ///
    /// # Panics
    /// If the number of edges is not the number of counts plus one.
    pub fn from_bins(at: f64, half_width: f64, edges: &[f64], counts: &[f64]) -> Self {
        assert_eq!(edges.len(), counts.len() + 1, "one more edge than bins");
        let bins = edges.windows(2).zip(counts);
        Self {
            at,
            half_width,
            density: bins
                .flat_map(|(edge, count)| {
                    let density = count / (edge[1] - edge[0]);
                    [[edge[0], density], [edge[1], density]]
                })
                .collect(),
            quartiles: None,
        }
    }
}

impl Quantiles {
    /// Quartiles and median of `samples`, with whiskers from their 5 % to their 95 % quantile. Without samples nothing is
    /// drawn.
    pub fn from_samples(at: f64, half_width: f64, samples: &[f64]) -> Self {
        let sorted = sorted(samples.iter().copied());
        Self {
            at,
            half_width,
            values: [0.05, 0.25, 0.5, 0.75, 0.95].map(|part| quantile(&sorted, part)),
        }
    }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.filter(|value| !value.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// Quantile by linear interpolation between order statistics; NaN for an empty sample.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = part * last as f64;
    let below = whole(place).min(last);
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// Gaussian kernel density on a grid. Each sample is split between its two nearest grid points, so the cost of the kernel
/// does not grow with the number of samples.
fn kernel_density(sorted: &[f64], interquartile: f64) -> Vec<[f64; 2]> {
    let (Some(&low), Some(&high)) = (sorted.first(), sorted.last()) else {
        return Vec::new();
    };
    let count = sorted.len() as f64;
    let mean = sorted.iter().sum::<f64>() / count;
    let variance = sorted.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
    // If more than half of the samples are equal, the interquartile range is zero and only σ is used.
    let spread = match interquartile / 1.34 {
        quartiles if quartiles > 0.0 => quartiles.min(variance.sqrt()),
        _ => variance.sqrt(),
    };
    let bandwidth = 0.9 * spread * count.powf(-0.2);
    if bandwidth.is_nan() || bandwidth <= 0.0 {
        return vec![[low, 1.0]];
    }
    let step = (high - low) / (PLACES - 1) as f64;
    let mut weights = [0.0; PLACES];
    for value in sorted {
        let place = (value - low) / step;
        let below = whole(place).min(PLACES - 2);
        weights[below] += below as f64 + 1.0 - place;
        weights[below + 1] += place - below as f64;
    }
    // A kernel narrower than the grid spacing would fall between the grid points.
    let bandwidth = bandwidth.max(step);
    (0..PLACES)
        .map(|place| {
            let kernel = |other: usize| {
                let apart = (place as f64 - other as f64) * step / bandwidth;
                (-0.5 * apart * apart).exp()
            };
            let density = weights
                .iter()
                .enumerate()
                .map(|(other, weight)| weight * kernel(other))
                .sum();
            [low + place as f64 * step, density]
        })
        .collect()
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "places are not negative"
)]
fn whole(place: f64) -> usize {
    place as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Task, stream};
    use rand::RngExt;
    use rand_distr::StandardNormal;

    #[test]
    fn quantiles_are_known() {
        let box_of = |samples: &[f64]| Quantiles::from_samples(0.0, 1.0, samples).values.to_vec();
        let hundred: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!(box_of(&hundred), [5.0, 25.0, 50.0, 75.0, 95.0]);
        assert_eq!(box_of(&[7.0]), [7.0; 5]);
        assert_eq!(box_of(&[1.0, f64::NAN, 2.0])[1..4], [1.25, 1.5, 1.75]);
        assert!(box_of(&[]).iter().all(|value| value.is_nan()));
    }

    #[test]
    fn the_density_of_a_normal_sample_is_a_bell() {
        let mut rng = stream(0, Task::Start, 0);
        let samples: Vec<f64> = (0..50_000)
            .map(|_| 3.0 + 2.0 * rng.sample::<f64, _>(StandardNormal))
            .collect();
        let violin = Violin::from_samples(0.0, 1.0, &samples, Scale::Linear);
        let area: f64 = violin
            .density
            .windows(2)
            .map(|pair| 0.5 * (pair[0][1] + pair[1][1]) * (pair[1][0] - pair[0][0]))
            .sum();
        for [y, density] in &violin.density {
            let z = (y - 3.0) / 2.0;
            let bell = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::TAU.sqrt());
            assert!(
                (density / area - bell).abs() < 0.008,
                "{y}: {density} {bell}"
            );
        }
        let [_, median, upper] = violin.quartiles.unwrap();
        assert!((median - 3.0).abs() < 0.03 && (upper - 3.0 - 2.0 * 0.6745).abs() < 0.03);
        // On a logarithmic axis the exponentials of these samples look the same.
        let exponentials: Vec<f64> = samples.iter().map(|x| 10f64.powf(*x)).collect();
        let other = Violin::from_samples(0.0, 1.0, &exponentials, Scale::Logarithmic);
        for (a, b) in violin.density.iter().zip(&other.density) {
            assert!(
                (a[0] - b[0].log10()).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-6 * area.max(a[1])
            );
        }
    }

    #[test]
    fn equal_samples_are_a_line() {
        let violin = Violin::from_samples(0.0, 1.0, &[4.0; 9], Scale::Linear);
        assert_eq!(violin.density, [[4.0, 1.0]]);
        assert_eq!(violin.quartiles, Some([4.0; 3]));
        let none = Violin::from_samples(0.0, 1.0, &[], Scale::Linear);
        assert!(none.density.is_empty() && none.quartiles.is_none());
    }

    #[test]
    fn bins_keep_their_edges() {
        let violin = Violin::from_bins(0.0, 1.0, &[0.0, 1.0, 3.0], &[2.0, 2.0]);
        assert_eq!(
            violin.density,
            [[0.0, 2.0], [1.0, 2.0], [1.0, 1.0], [3.0, 1.0]]
        );
    }
}
