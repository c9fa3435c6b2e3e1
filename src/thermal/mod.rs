//! Thermodynamics and kinetics of a landscape, from its minima and transition states.
//!
//! Each minimum is a harmonic well ([`Superposition`]); the sum over wells gives free energies, the heat capacity and the
//! occupation of minima against the temperature. Rates of transition-state theory between neighbouring minima make a
//! [`RateNetwork`]. First-passage times, committors and rates between sets of minima follow by eliminating the other minima
//! one by one. All sums are of positive numbers and are taken in logarithms, so that rates which differ by hundreds of
//! powers of ten keep their digits.
//!
//! Temperatures are kT, in units of the energy. Masses are 1 unless the curvatures were weighted with masses, and times
//! are in the unit √(mass · length² / energy).

mod dense;
mod elimination;
mod measures;
mod pathways;
mod rates;
mod superposition;

pub use elimination::Unreachable;
pub use measures::{Funnels, SAME, count_superbasins, frustration, range_of_energies, superbasins};
pub use pathways::Pathway;
pub use rates::{Between, Dynamics, RateNetwork, SetRates};
pub use superposition::{Missing, Superposition};

/// ln(eᵃ + eᵇ), without overflow.
fn log_add(a: f64, b: f64) -> f64 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    if low == f64::NEG_INFINITY || high == f64::INFINITY {
        return high;
    }
    high + libm::log1p(libm::exp(low - high))
}

/// ln Σ exp of the given numbers; −∞ for none.
fn log_sum(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().fold(f64::NEG_INFINITY, log_add)
}
