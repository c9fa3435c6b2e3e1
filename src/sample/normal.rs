//! Standard normal numbers with the same bits on every processor.

use rand::RngExt;

use super::Rng;

/// Draws a number of the standard normal distribution, √(−2 ln u) cos 2πv with u and v uniform.
///
/// The functions are those of the crate `libm`, whose results do not depend on the processor; a distribution that uses the
/// functions of the platform would make chains differ between processors. G. E. P. Box and M. E. Muller, Ann. Math. Stat. 29,
/// 610 (1958).
pub fn standard_normal(rng: &mut Rng) -> f64 {
    let above_zero = 1.0 - rng.random::<f64>();
    let turn: f64 = rng.random();
    (-2.0 * libm::log(above_zero)).sqrt() * libm::cos(std::f64::consts::TAU * turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Task, stream};

    #[test]
    fn the_numbers_are_of_the_standard_normal_distribution() {
        const COUNT: usize = 100_000;
        let mut rng = stream(20_261_126, Task::Start, 0);
        let mut drawn: Vec<f64> = (0..COUNT).map(|_| standard_normal(&mut rng)).collect();
        drawn.sort_by(f64::total_cmp);
        // Kolmogorov and Smirnov's distance from the distribution function; larger in one of a thousand samples.
        let distance = drawn.iter().enumerate().fold(0.0_f64, |most, (k, x)| {
            let below = 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
            let [low, high] = [k, k + 1].map(|k| k as f64 / COUNT as f64);
            most.max((below - low).abs()).max((high - below).abs())
        });
        assert!(distance < 1.95 / (COUNT as f64).sqrt(), "{distance}");
    }

    #[test]
    fn successive_numbers_are_independent() {
        const COUNT: usize = 100_000;
        let mut rng = stream(20_261_126, Task::Start, 1);
        let drawn: Vec<f64> = (0..COUNT).map(|_| standard_normal(&mut rng)).collect();
        let root = (COUNT as f64).sqrt();
        for lag in 1..5 {
            let pairs = || drawn.iter().zip(&drawn[lag..]);
            let product: f64 = pairs().map(|(a, b)| a * b).sum();
            let squares: f64 = pairs().map(|(a, b)| (a * a - 1.0) * (b * b - 1.0)).sum();
            // Standard deviations are 1 and 2.
            assert!(product.abs() / root < 4.0, "lag {lag}: {product}");
            assert!(squares.abs() / root < 8.0, "lag {lag}: {squares}");
        }
    }
}
