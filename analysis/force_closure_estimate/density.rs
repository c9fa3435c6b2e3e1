//! Violins of samples: densities and quartiles.

use landscape::figure::chart::Violin;

/// Number of points at which a density is computed.
const PLACES: usize = 256;

/// The density and the quartiles of `samples`. The density uses a Gaussian kernel between the smallest and the largest
/// sample, with Silverman's bandwidth 0.9 min(σ, interquartile range / 1.34) n^(−1/5) (1986, eq. 3.31). Without samples
/// nothing is drawn.
pub(crate) fn violin(at: f64, half_width: f64, samples: &[f64]) -> Violin {
    let sorted = sorted(samples.iter().copied());
    let quartiles = [0.25, 0.5, 0.75].map(|part| quantile(&sorted, part));
    Violin {
        at,
        half_width,
        density: kernel_density(&sorted, quartiles[2] - quartiles[0]),
        quartiles: (!sorted.is_empty()).then_some(quartiles),
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
    let bandwidth = 0.9 * spread * libm::pow(count, -0.2);
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
                libm::exp(-0.5 * apart * apart)
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
    use landscape::sample::{Task, stream};
    use rand::RngExt;
    use rand_distr::StandardNormal;

    #[test]
    fn quantiles_are_known() {
        let hundred: Vec<f64> = (0..=100).map(f64::from).collect();
        for (part, known) in [(0.05, 5.0), (0.5, 50.0), (0.95, 95.0)] {
            assert!((quantile(&hundred, part) - known).abs() < 1e-12);
        }
        let two = sorted([2.0, f64::NAN, 1.0].into_iter());
        assert!((quantile(&two, 0.25) - 1.25).abs() < 1e-12);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn the_density_of_a_normal_sample_is_a_bell() {
        let mut rng = stream(0, Task::Start, 0);
        let samples: Vec<f64> = (0..50_000)
            .map(|_| 3.0 + 2.0 * rng.sample::<f64, _>(StandardNormal))
            .collect();
        let drawn = violin(0.0, 1.0, &samples);
        let area: f64 = drawn
            .density
            .windows(2)
            .map(|pair| 0.5 * (pair[0][1] + pair[1][1]) * (pair[1][0] - pair[0][0]))
            .sum();
        for [y, density] in &drawn.density {
            let z = (y - 3.0) / 2.0;
            let bell = libm::exp(-0.5 * z * z) / (2.0 * std::f64::consts::TAU.sqrt());
            assert!(
                (density / area - bell).abs() < 0.008,
                "{y}: {density} {bell}"
            );
        }
        let [_, median, upper] = drawn.quartiles.unwrap();
        assert!((median - 3.0).abs() < 0.03 && (upper - 3.0 - 2.0 * 0.6745).abs() < 0.03);
    }

    #[test]
    fn equal_samples_are_a_line() {
        let drawn = violin(0.0, 1.0, &[4.0; 9]);
        assert_eq!(drawn.density, [[4.0, 1.0]]);
        assert_eq!(drawn.quartiles, Some([4.0; 3]));
        let none = violin(0.0, 1.0, &[]);
        assert!(none.density.is_empty() && none.quartiles.is_none());
    }
}
