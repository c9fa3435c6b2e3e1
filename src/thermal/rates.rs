//! Rates between minima, and between sets of minima.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::elimination::{Elimination, Gains, Unreachable};
use super::superposition::{Missing, Well};
use super::{log_add, log_sum};
use crate::topography::Observer;
use crate::topography::exchange::Database;

/// How a system crosses a transition state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Dynamics {
    /// Without recrossing: transition-state theory (H. Eyring, J. Chem. Phys. 3, 107 (1935)).
    #[default]
    TransitionState,
    /// With friction γ (a rate: the drag force is −γ times the momentum): H. A. Kramers, Physica 7, 284 (1940). The rate of
    /// transition-state theory is multiplied by √(1 + (γ/2ω)²) − γ/2ω, where −ω² is the negative curvature.
    Kramers {
        /// γ, in units of 1/time.
        friction: f64,
    },
}

impl Dynamics {
    /// Logarithm of the share of crossings that are not undone at once.
    fn log_transmission(self, negative_curvature: impl Fn() -> Option<f64>) -> Option<f64> {
        match self {
            Self::TransitionState => Some(0.0),
            Self::Kramers { friction } => {
                let frequency = negative_curvature()?.abs().sqrt();
                let ratio = friction / (2.0 * frequency);
                // √(1 + r²) − r without cancellation.
                Some(-libm::log(libm::hypot(ratio, 1.0) + ratio))
            }
        }
    }
}

/// States and the rates between them, in logarithms.
///
/// From minima and transition states (harmonic transition-state theory, in units where k = 1):
///
/// ```text
/// k(a → b) = Σ over transition states ‡ of a and b:  (o_a/o‡) (∏ ω_a/∏ ω‡)/2π · exp(−(V‡ − V_a)/T)
/// ```
///
/// o: orders of point groups; ω² : positive Hessian eigenvalues. Degenerate rearrangements (‡ joins two copies of one
/// minimum) lead nowhere and are left out. See D. J. Wales, *Energy Landscapes* (Cambridge, 2003), chapter 7.
///
/// ```
/// use landscape::thermal::RateNetwork;
///
/// // 0 ⇄ 1 → 2: from 0 it takes (1 + 3/2)/1 + 1/2 on average.
/// let log_rates = [(0, 1, 0.0), (1, 0, 3_f64.ln()), (1, 2, 2_f64.ln())];
/// let network = RateNetwork::from_log_rates(3, &log_rates, &[0.0; 3]);
/// let rates = network.between(&[0], &[2]).forward?;
/// assert!((rates.mean_time.exp() - 1.0 / 3.0).abs() < 1e-12);
/// # Ok::<(), landscape::thermal::Unreachable>(())
/// ```
#[derive(Debug, Clone)]
pub struct RateNetwork {
    pub(super) rates: Vec<BTreeMap<usize, f64>>,
    pub(super) log_weights: Vec<f64>,
}

/// Rate constants from one set of states to another, in natural logarithms.
///
/// ```text
/// first_passage = ln Σ_b p_b/T_b
/// mean_time     = −ln Σ_b p_b T_b
/// steady_state  = ln Σ_b p_b Σ_j k(b → j) q_j
/// ```
///
/// p: equilibrium probability of source b within the sources; T: its mean first-passage time to the targets; q: the
/// probability that state j reaches the targets before the sources. D. J. Wales, J. Chem. Phys. 130, 204111 (2009).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetRates {
    /// The rate if the sources do not exchange before they react.
    pub first_passage: f64,
    /// The inverse of the mean time to the targets.
    pub mean_time: f64,
    /// The rate at a steady state that is fed at equilibrium within the sources. It counts every departure that reaches the
    /// targets before it returns.
    pub steady_state: f64,
}

/// How two sets of states, the sources and the targets, exchange.
#[derive(Debug, Clone, PartialEq)]
pub struct Between {
    /// Rates from the sources to the targets, with the sources in equilibrium among themselves; an error if no target can be
    /// reached from a source, or if a source may be lost on its way.
    pub forward: Result<SetRates, Unreachable>,
    /// Rates from the targets to the sources.
    pub backward: Result<SetRates, Unreachable>,
    /// ln of the committor: the probability that each state reaches a target before a source. −∞ for the sources and for
    /// states that reach neither.
    pub log_committors: Vec<f64>,
}

impl RateNetwork {
    /// The rates between the minima of `database` at a temperature kT.
    ///
    /// # Errors
    /// If the curvatures of a stationary point are not known.
    ///
    /// # Panics
    /// If the temperature is not positive and finite, or a friction is negative.
    pub fn new(database: &Database, temperature: f64, dynamics: Dynamics) -> Result<Self, Missing> {
        assert!(temperature > 0.0 && temperature.is_finite());
        if let Dynamics::Kramers { friction } = dynamics {
            assert!(friction >= 0.0, "a friction is not negative");
        }
        let minima = database.minima.iter().enumerate();
        let wells = minima.map(|(row, minimum)| {
            let vibrations = minimum.vibrations.as_ref();
            let vibrations = vibrations.ok_or(Missing::MinimumVibrations(row))?;
            Ok(Well::new(minimum.energy, vibrations).log_weight(temperature))
        });
        let log_weights: Vec<f64> = wells.collect::<Result<_, _>>()?;
        let mut rates = vec![BTreeMap::new(); log_weights.len()];
        for (row, state) in database.transition_states.iter().enumerate() {
            let [a, b] = state.ends;
            if a == b {
                continue;
            }
            let vibrations = state.vibrations.as_ref();
            let vibrations = vibrations.ok_or(Missing::StateVibrations(row))?;
            let transmission = dynamics
                .log_transmission(|| vibrations.negative_curvature)
                .ok_or(Missing::NegativeCurvature(row))?;
            let weight = Well::new(state.energy, vibrations).log_weight(temperature);
            let flow = weight - libm::log(TAU) + transmission;
            for (from, to) in [(a, b), (b, a)] {
                let rate = rates[from].entry(to).or_insert(f64::NEG_INFINITY);
                *rate = log_add(*rate, flow - log_weights[from]);
            }
        }
        Ok(Self { rates, log_weights })
    }

    /// Any Markov process of `states` states: `(from, to, ln of the rate)`, and ln of the equilibrium weights, up to a
    /// constant. Rates of one pair add up.
    ///
    /// # Panics
    /// If a state does not exist, a state leads to itself, or a weight is missing.
    pub fn from_log_rates(
        states: usize,
        log_rates: &[(usize, usize, f64)],
        log_weights: &[f64],
    ) -> Self {
        assert_eq!(log_weights.len(), states);
        let mut network = vec![BTreeMap::new(); states];
        for (from, to, log_rate) in log_rates {
            assert!(
                from != to && *to < states,
                "a transition leads to another state"
            );
            if *log_rate > f64::NEG_INFINITY {
                let rate = network[*from].entry(*to).or_insert(f64::NEG_INFINITY);
                *rate = log_add(*rate, *log_rate);
            }
        }
        Self {
            rates: network,
            log_weights: log_weights.to_vec(),
        }
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.rates.len()
    }

    /// ln of the rate from one state to another; −∞ if there is none.
    ///
    /// # Panics
    /// If `from` does not exist.
    pub fn log_rate(&self, from: usize, to: usize) -> f64 {
        let rate = self.rates[from].get(&to).copied();
        rate.unwrap_or(f64::NEG_INFINITY)
    }

    /// ln of the equilibrium probability of each of `states` within them.
    ///
    /// # Panics
    /// If a state does not exist.
    pub fn log_shares(&self, states: &[usize]) -> Vec<f64> {
        let sum = log_sum(states.iter().map(|state| self.log_weights[*state]));
        let weights = states.iter().map(|state| self.log_weights[*state]);
        weights.map(|weight| weight - sum).collect()
    }

    fn marked(&self, states: &[usize]) -> Vec<bool> {
        let mut marked = vec![false; self.states()];
        for state in states {
            marked[*state] = true;
        }
        marked
    }

    /// Rates between two sets of states in both directions, and committors. All other states are eliminated once, which
    /// takes nearly all of the time.
    ///
    /// # Panics
    /// If one of the sets is empty, a state does not exist, or a state is in both.
    pub fn between(&self, sources: &[usize], targets: &[usize]) -> Between {
        self.between_watched(sources, targets, &|_| ())
    }

    /// As [`RateNetwork::between`], where `observer` hears of the elimination.
    ///
    /// # Panics
    /// As [`RateNetwork::between`].
    pub fn between_watched(
        &self,
        sources: &[usize],
        targets: &[usize],
        observer: &Observer<'_>,
    ) -> Between {
        assert!(!sources.is_empty() && !targets.is_empty(), "a set is empty");
        let mut kept = self.marked(sources);
        for target in targets {
            assert!(!kept[*target], "a state is a source and a target");
        }
        for target in targets {
            kept[*target] = true;
        }
        let none = vec![0.0; self.states()];
        let elimination = Elimination::new(&self.rates, &kept, none, observer);
        let mut committors = vec![f64::NEG_INFINITY; self.states()];
        for target in targets {
            committors[*target] = 0.0;
        }
        Between {
            forward: self.rates_in(&elimination, sources, targets),
            backward: self.rates_in(&elimination, targets, sources),
            log_committors: elimination.values(committors, Gains::Left),
        }
    }

    /// The rates from `sources` to `targets` after all other states were eliminated.
    fn rates_in(
        &self,
        others: &Elimination,
        sources: &[usize],
        targets: &[usize],
    ) -> Result<SetRates, Unreachable> {
        let is_source = self.marked(sources);
        let kept: Vec<bool> = is_source.iter().map(|source| !source).collect();
        let sources_left = others.log_sources.clone();
        let elimination = Elimination::new(&others.left, &kept, sources_left, &|_| ());
        let mut times = vec![f64::INFINITY; self.states()];
        for target in targets {
            times[*target] = f64::NEG_INFINITY;
        }
        let times = elimination.values(times, Gains::Counted);
        let unreachable = sources.iter().find(|b| times[**b] == f64::INFINITY);
        if let Some(state) = unreachable {
            return Err(Unreachable(*state));
        }
        // With all other states eliminated, the flow that arrives before it returns is the direct rate to the targets.
        let arriving = |source: usize| {
            let direct = others.left[source].iter();
            let direct = direct.filter(|(to, _)| !is_source[**to]);
            log_sum(direct.map(|(_, rate)| *rate))
        };
        let shares = self.log_shares(sources);
        let pairs = || sources.iter().zip(&shares);
        Ok(SetRates {
            first_passage: log_sum(pairs().map(|(b, share)| share - times[*b])),
            mean_time: -log_sum(pairs().map(|(b, share)| share + times[*b])),
            steady_state: log_sum(pairs().map(|(b, share)| share + arriving(*b))),
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand::RngExt;

    use super::*;
    use crate::sample::{Rng, Task, stream};
    use crate::topography::exchange::{MinimumEntry, TransitionStateEntry, Vibrations};

    /// A random network in detailed balance, connected by a ring.
    fn reversible(states: usize, spread: f64, rng: &mut Rng) -> RateNetwork {
        let weights: Vec<f64> = (0..states)
            .map(|_| rng.random_range(-spread..spread))
            .collect();
        let mut log_rates = Vec::new();
        for a in 0..states {
            for b in a + 1..states {
                let neighbours = b == a + 1 || (a == 0 && b == states - 1);
                if neighbours || rng.random_bool(0.2) {
                    let flow = rng.random_range(-2.0 * spread..-spread);
                    log_rates.push((a, b, flow - weights[a]));
                    log_rates.push((b, a, flow - weights[b]));
                }
            }
        }
        RateNetwork::from_log_rates(states, &log_rates, &weights)
    }

    /// Solves Kᵢ yᵢ − Σ kᵢⱼ yⱼ = wᵢ with yᵢ given for some states, by a dense LU decomposition.
    fn solved(network: &RateNetwork, given: &BTreeMap<usize, f64>, source: f64) -> Vec<f64> {
        let n = network.states();
        let (mut matrix, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for i in 0..n {
            if let Some(value) = given.get(&i) {
                matrix[(i, i)] = 1.0;
                right[i] = *value;
                continue;
            }
            right[i] = source;
            for (j, rate) in &network.rates[i] {
                matrix[(i, i)] += libm::exp(*rate);
                matrix[(i, *j)] -= libm::exp(*rate);
            }
        }
        let solution = matrix.lu().solve(&right).unwrap();
        solution.iter().copied().collect()
    }

    #[test]
    fn small_networks_agree_with_matrix_methods() {
        let mut rng = stream(7, Task::Start, 0);
        // The last one has its own way of elimination, as a dense matrix.
        for states in [3, 4, 8, 20, 60, 300] {
            let network = reversible(states, 2.0, &mut rng);
            let (sources, targets) = ([0, 1], [states - 1]);
            let given = targets.iter().map(|target| (*target, 0.0)).collect();
            let times = solved(&network, &given, 1.0);

            let mut given: BTreeMap<usize, f64> = sources.iter().map(|s| (*s, 0.0)).collect();
            given.insert(states - 1, 1.0);
            let chances = solved(&network, &given, 0.0);
            let between = network.between(&sources, &targets);
            let ours = &between.log_committors;
            for (log, chance) in ours.iter().zip(&chances) {
                approx::assert_relative_eq!(
                    libm::exp(*log),
                    *chance,
                    max_relative = 1e-10,
                    epsilon = 1e-13
                );
            }

            let shares: Vec<f64> = network
                .log_shares(&sources)
                .iter()
                .map(|s| libm::exp(*s))
                .collect();
            let rates = between.forward.unwrap();
            let mean: f64 = shares.iter().zip(sources).map(|(p, b)| p * times[b]).sum();
            approx::assert_relative_eq!(
                libm::exp(rates.mean_time),
                1.0 / mean,
                max_relative = 1e-10
            );
            let inverse: f64 = shares.iter().zip(sources).map(|(p, b)| p / times[b]).sum();
            approx::assert_relative_eq!(
                libm::exp(rates.first_passage),
                inverse,
                max_relative = 1e-10
            );
            let flow = |b: usize| -> f64 {
                let rates = network.rates[b].iter();
                rates.map(|(j, rate)| libm::exp(*rate) * chances[*j]).sum()
            };
            let steady: f64 = shares.iter().zip(sources).map(|(p, b)| p * flow(b)).sum();
            approx::assert_relative_eq!(
                libm::exp(rates.steady_state),
                steady,
                max_relative = 1e-10
            );
        }
    }

    /// At a steady state, the flow from one set to another is the same in both directions.
    #[test]
    fn detailed_balance_holds_where_rates_span_hundreds_of_decades() {
        let mut rng = stream(8, Task::Start, 0);
        for (states, spread, least_decades) in
            [(40, 400.0, 300.0), (150, 400.0, 300.0), (300, 50.0, 60.0)]
        {
            let network = reversible(states, spread, &mut rng);
            let all: Vec<f64> = network
                .rates
                .iter()
                .flat_map(|r| r.values().copied())
                .collect();
            let span = all.iter().copied().fold(f64::NEG_INFINITY, f64::max)
                - all.iter().copied().fold(f64::INFINITY, f64::min);
            assert!(span > least_decades * std::f64::consts::LN_10, "{span}");
            let (a, b) = ([0, 5, 6], [30, 31]);
            let (between, reverse) = (network.between(&a, &b), network.between(&b, &a));
            let (there, back) = (between.forward.unwrap(), between.backward.unwrap());
            assert_eq!(reverse.backward, Ok(there));
            let weight = |set: &[usize]| log_sum(set.iter().map(|s| network.log_weights[*s]));
            approx::assert_relative_eq!(
                weight(&a) + there.steady_state,
                weight(&b) + back.steady_state,
                max_relative = 1e-12
            );
            // What does not reach one set first reaches the other.
            let (to, from) = (&between.log_committors, &reverse.log_committors);
            for (q, p) in to.iter().zip(from) {
                assert!((libm::exp(*q) + libm::exp(*p) - 1.0).abs() < 1e-12);
            }
        }
        // A chain of barriers, exactly: times add up.
        let step = -350.0;
        let chain =
            RateNetwork::from_log_rates(3, &[(0, 1, step), (1, 0, 0.0), (1, 2, step)], &[0.0; 3]);
        // T₀ = 1/k + T₁, T₁ = (1 + T₀)/(1 + k) → T₀ = 2/k + 1/k², T₁ = 1/k + 1/k²
        for start in [0, 1] {
            let time = -chain.between(&[start], &[2]).forward.unwrap().mean_time;
            assert!((time - 700.0).abs() < 1e-10, "{start}: {time}");
        }
    }

    #[test]
    fn islands_are_told() {
        let network = RateNetwork::from_log_rates(
            4,
            &[(0, 1, 0.0), (1, 0, 0.0), (2, 3, 0.0), (3, 2, 0.0)],
            &[0.0; 4],
        );
        assert_eq!(network.between(&[3], &[0]).forward, Err(Unreachable(3)));
        assert!(network.between(&[1], &[0]).log_committors[2] < -f64::MAX);
        // A state that may be lost on the way has no mean time either.
        let lossy = RateNetwork::from_log_rates(3, &[(0, 1, 0.0), (0, 2, 0.0)], &[0.0; 3]);
        assert_eq!(lossy.between(&[0], &[2]).forward, Err(Unreachable(0)));
        // The same among many states: from 7 one may get lost in 150, and from everywhere reach 7.
        let mut rng = stream(9, Task::Start, 0);
        let safe = reversible(150, 2.0, &mut rng);
        let mut rates: Vec<(usize, usize, f64)> = Vec::new();
        for (from, to) in safe.rates.iter().enumerate() {
            rates.extend(to.iter().map(|(to, rate)| (from, *to, *rate)));
        }
        rates.push((7, 150, 0.0));
        let lossy = RateNetwork::from_log_rates(151, &rates, &[0.0; 151]);
        assert_eq!(lossy.between(&[1], &[2]).forward, Err(Unreachable(1)));
        let chances = lossy.between(&[1], &[2]).log_committors;
        assert!(chances[150] < -f64::MAX && chances[7].is_finite());
    }

    fn pass(curvature: Option<f64>) -> Database {
        let vibrations = |log_product, order, negative_curvature| {
            Some(Vibrations {
                log_product,
                point_group_order: order,
                negative_curvature,
                ..Vibrations::default()
            })
        };
        Database {
            minima: vec![
                MinimumEntry {
                    energy: 0.0,
                    vibrations: vibrations(4.0, 2, None),
                },
                MinimumEntry {
                    energy: 0.5,
                    vibrations: vibrations(3.0, 1, None),
                },
            ],
            transition_states: vec![
                TransitionStateEntry {
                    energy: 2.0,
                    ends: [0, 1],
                    vibrations: vibrations(2.0, 1, curvature),
                },
                TransitionStateEntry {
                    energy: 1.0,
                    ends: [0, 0],
                    vibrations: vibrations(2.0, 1, curvature),
                },
            ],
            vibrational_modes: Some(2),
        }
    }

    #[test]
    fn rates_of_transition_state_theory() {
        let temperature = 0.25;
        let eyring =
            RateNetwork::new(&pass(Some(-9.0)), temperature, Dynamics::TransitionState).unwrap();
        let expected = 2.0 * libm::exp(1.0_f64) / TAU * libm::exp(-8.0_f64);
        approx::assert_relative_eq!(
            libm::exp(eyring.log_rate(0, 1)),
            expected,
            max_relative = 1e-12
        );
        assert!(eyring.log_rate(0, 0) < -f64::MAX);
        // Detailed balance with the harmonic weights.
        let back = eyring.log_weights[0] + eyring.log_rate(0, 1) - eyring.log_weights[1];
        approx::assert_relative_eq!(eyring.log_rate(1, 0), back, max_relative = 1e-12);
        let kramers = |friction| {
            let network = RateNetwork::new(
                &pass(Some(-9.0)),
                temperature,
                Dynamics::Kramers { friction },
            );
            libm::exp(network.unwrap().log_rate(0, 1)) / expected
        };
        approx::assert_relative_eq!(kramers(0.0), 1.0, max_relative = 1e-12);
        approx::assert_relative_eq!(kramers(6.0), 2.0_f64.sqrt() - 1.0, max_relative = 1e-12);
        // Strong friction: ω/γ.
        approx::assert_relative_eq!(kramers(3e8), 1e-8, max_relative = 1e-8);
        let unknown = RateNetwork::new(
            &pass(None),
            temperature,
            Dynamics::Kramers { friction: 1.0 },
        );
        assert_eq!(unknown.unwrap_err(), Missing::NegativeCurvature(0));
    }
}
