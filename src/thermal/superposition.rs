//! The harmonic superposition approximation.

use super::log_sum;
use crate::topography::exchange::{Database, Vibrations};

/// Why a [`Superposition`] cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Missing {
    /// There are no minima.
    #[error("at least one minimum is needed")]
    Minima,
    /// A minimum has no vibrational data.
    #[error(
        "the curvatures of m{0} are unknown: it may lie on a face of a box, where it is not a harmonic well"
    )]
    MinimumVibrations(usize),
    /// A transition state has no vibrational data.
    #[error("the curvatures of saddle {0} are unknown")]
    StateVibrations(usize),
    /// The negative curvature of a transition state is needed (for Kramers rates) and not known.
    #[error("the negative curvature of saddle {0} is unknown, but --friction needs it")]
    NegativeCurvature(usize),
}

/// A stationary point as a harmonic oscillator.
#[derive(Debug, Clone, Copy)]
pub(super) struct Well {
    pub(super) energy: f64,
    /// −½ Σ ln λ − ln o: logarithm of the partition function without the powers of the temperature.
    pub(super) log_width: f64,
}

impl Well {
    pub(super) fn new(energy: f64, vibrations: &Vibrations) -> Self {
        let order = f64::from(vibrations.point_group_order);
        Self {
            energy,
            log_width: -0.5 * vibrations.log_product - libm::log(order),
        }
    }

    /// ln Z without the powers of the temperature.
    pub(super) fn log_weight(&self, temperature: f64) -> f64 {
        self.log_width - self.energy / temperature
    }
}

/// The minima of a landscape as independent harmonic wells.
///
/// ```text
/// Z(T) = Σᵢ Zᵢ,   Zᵢ = (1/oᵢ) ∏ₖ (T/ωᵢₖ) exp(−Vᵢ/T),   ωᵢₖ² = λᵢₖ,   pᵢ = Zᵢ/Z
/// ```
///
/// Vᵢ: energy of minimum i; λᵢₖ: its positive Hessian eigenvalues; oᵢ: order of its point group, because a minimum of N equal
/// atoms has 2 N!/oᵢ copies (factors common to all minima are left out); T: temperature, with k = ħ = 1. Classical. See D. J.
/// Wales, Mol. Phys. 78, 151 (1993), and *Energy Landscapes* (Cambridge, 2003), chapter 7.
///
/// The approximation holds at low temperatures. It knows only the minima that it is given.
///
/// ```
/// use landscape::thermal::Superposition;
/// use landscape::topography::exchange::{Database, Layout};
///
/// // A deep narrow well and a shallow wide one of equal point groups.
/// let text = "0.0 8.0 1 0 0 0\n1.0 2.0 1 0 0 0\n";
/// let (database, _) = Database::parse(text, "")?;
/// let wells = Superposition::new(&database)?;
/// // They are equally occupied at T = ΔV/(½ Δ ln-product) = 1/3.
/// let occupation = wells.occupation(1.0 / 3.0);
/// assert!((occupation[0] - 0.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Superposition {
    wells: Vec<Well>,
    /// Number of vibrational modes of a minimum.
    modes: usize,
}

impl Superposition {
    /// The wells of the minima of `database`, in its order.
    ///
    /// # Errors
    /// If there are no minima, or the curvatures of one are not known.
    pub fn new(database: &Database) -> Result<Self, Missing> {
        if database.minima.is_empty() {
            return Err(Missing::Minima);
        }
        let minima = database.minima.iter().enumerate();
        let wells = minima.map(|(row, minimum)| {
            let vibrations = minimum.vibrations.as_ref();
            let vibrations = vibrations.ok_or(Missing::MinimumVibrations(row))?;
            Ok(Well::new(minimum.energy, vibrations))
        });
        Ok(Self {
            wells: wells.collect::<Result<_, _>>()?,
            modes: database.vibrational_modes.unwrap_or(0),
        })
    }

    /// The number of vibrational modes of a minimum; 0 if it is unknown.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// ln Zᵢ of each minimum.
    ///
    /// # Panics
    /// If `temperature` is not positive and finite; so in all functions of the temperature.
    pub fn log_partition_functions(&self, temperature: f64) -> Vec<f64> {
        let powers = self.modes as f64 * libm::log(checked(temperature));
        let wells = self.wells.iter();
        wells
            .map(|well| well.log_weight(temperature) + powers)
            .collect()
    }

    /// Equilibrium probability pᵢ of each minimum.
    pub fn occupation(&self, temperature: f64) -> Vec<f64> {
        let temperature = checked(temperature);
        let energies = self.wells.iter().map(|well| well.energy);
        let lowest = energies.fold(f64::INFINITY, f64::min);
        // Energies far from 0 would cost digits.
        let above = |well: &Well| well.log_width - (well.energy - lowest) / temperature;
        let weights: Vec<f64> = self.wells.iter().map(above).collect();
        let sum = log_sum(weights.iter().copied());
        weights
            .iter()
            .map(|weight| libm::exp(weight - sum))
            .collect()
    }

    /// Mean of the energy Vᵢ of the occupied minimum, and the variance of Vᵢ/T, whose square root may be beyond the range of
    /// numbers where a minimum is not occupied.
    fn moments(&self, temperature: f64) -> [f64; 2] {
        let occupation = self.occupation(temperature);
        let wells = || (occupation.iter().zip(&self.wells)).filter(|(p, _)| **p > 0.0);
        let mean: f64 = wells().map(|(p, well)| p * well.energy).sum();
        let variance = wells().map(|(p, well)| p * ((well.energy - mean) / temperature).powi(2));
        [mean, variance.sum()]
    }

    /// Mean energy U = κ T + Σ pᵢ Vᵢ, kinetic energy included; κ: number of modes.
    pub fn mean_energy(&self, temperature: f64) -> f64 {
        self.modes as f64 * temperature + self.moments(temperature)[0]
    }

    /// Heat capacity dU/dT = κ + (Σ pᵢ Vᵢ² − (Σ pᵢ Vᵢ)²)/T², in units of Boltzmann's constant. Without the number of modes it lacks κ.
    pub fn heat_capacity(&self, temperature: f64) -> f64 {
        self.modes as f64 + self.moments(temperature)[1]
    }

    /// Shannon entropy −Σ pᵢ ln pᵢ of the occupation: the landscape entropy. Its exponential is the effective number of
    /// occupied minima.
    pub fn landscape_entropy(&self, temperature: f64) -> f64 {
        let occupation = self.occupation(temperature);
        let occupied = occupation.iter().filter(|p| **p > 0.0);
        occupied.map(|p| -p * libm::log(*p)).sum::<f64>().max(0.0)
    }

    /// Free energies of the minima and transition states as a landscape: the `energy` of each entry becomes
    ///
    /// ```text
    /// Fᵢ = −T ln Zᵢ,   F‡ = −T ln Z‡,   k = (T/2π) exp(−(F‡ − Fᵢ)/T)
    /// ```
    ///
    /// Z‡ has one mode less, and k is the harmonic rate of transition-state theory, with T/2π in the place of kT/h. Where
    /// a transition state is lower in free energy than a minimum that it joins, its energy is raised to that of the minimum.
    /// Transition states of one pair stay apart. Free energies are counted from the lowest minimum.
    ///
    /// # Errors
    /// If the curvatures of a transition state are not known.
    ///
    /// # Panics
    /// If `database` is not the one that this was made of, or `temperature` is not positive and finite.
    pub fn free_energy_landscape(
        &self,
        database: &Database,
        temperature: f64,
    ) -> Result<Database, Missing> {
        assert_eq!(database.minima.len(), self.wells.len());
        let ln = libm::log(checked(temperature));
        // The powers of the temperature that all minima have are left out; one less at transition states.
        let free = |well: &Well, fewer: f64| -temperature * (well.log_weight(temperature) - fewer);
        let minima: Vec<f64> = self.wells.iter().map(|well| free(well, 0.0)).collect();
        let lowest = minima.iter().copied().fold(f64::INFINITY, f64::min);
        let mut result = database.clone();
        for (entry, value) in result.minima.iter_mut().zip(&minima) {
            entry.energy = value - lowest;
        }
        for (row, state) in result.transition_states.iter_mut().enumerate() {
            let vibrations = state.vibrations.as_ref();
            let vibrations = vibrations.ok_or(Missing::StateVibrations(row))?;
            let height = free(&Well::new(state.energy, vibrations), ln);
            let ends = state.ends.map(|end| minima[end]);
            state.energy = height.max(ends[0]).max(ends[1]) - lowest;
        }
        Ok(result)
    }
}

fn checked(temperature: f64) -> f64 {
    assert!(
        temperature > 0.0 && temperature.is_finite(),
        "a temperature is positive and finite, not {temperature}"
    );
    temperature
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::exchange::MinimumEntry;

    fn database(minima: &[(f64, f64, u32)]) -> Database {
        Database {
            minima: minima
                .iter()
                .map(|(energy, log_product, order)| MinimumEntry {
                    energy: *energy,
                    vibrations: Some(Vibrations {
                        log_product: *log_product,
                        point_group_order: *order,
                        ..Vibrations::default()
                    }),
                })
                .collect(),
            vibrational_modes: Some(3),
            ..Database::default()
        }
    }

    #[test]
    fn derivatives_of_the_partition_function() {
        let wells = Superposition::new(&database(&[
            (-3.0, 5.0, 48),
            (-2.5, 3.0, 2),
            (-1.0, -2.0, 1),
            (-0.9, -2.1, 4),
        ]))
        .unwrap();
        for temperature in [0.05, 0.2, 1.0, 7.0] {
            let log_z = |t: f64| log_sum(wells.log_partition_functions(t));
            let step = 1e-5 * temperature;
            let slope = |f: &dyn Fn(f64) -> f64| {
                (f(temperature + step) - f(temperature - step)) / (2.0 * step)
            };
            // U = T² d ln Z/dT, C = dU/dT.
            let energy = temperature * temperature * slope(&log_z);
            approx::assert_relative_eq!(
                wells.mean_energy(temperature),
                energy,
                max_relative = 1e-7,
                epsilon = 1e-7
            );
            let capacity = slope(&|t| wells.mean_energy(t));
            approx::assert_relative_eq!(
                wells.heat_capacity(temperature),
                capacity,
                max_relative = 1e-6
            );
            let sum: f64 = wells.occupation(temperature).iter().sum();
            approx::assert_relative_eq!(sum, 1.0, max_relative = 1e-13);
        }
        // Cold: the ground state alone.
        assert!((wells.heat_capacity(1e-3) - 3.0).abs() < 1e-12);
        assert!(wells.landscape_entropy(1e-3) < 1e-12);
        // Very hot: widths decide.
        let hot = wells.occupation(1e9);
        approx::assert_relative_eq!(
            hot[3] / hot[2],
            libm::exp(0.05_f64) / 4.0,
            max_relative = 1e-6
        );
    }
}
