//! Chooses the temperature and force of attraction–diffusion with a few chains.
//!
//! M. Hill, E. Nijkamp and S.-C. Zhu, Quarterly of Applied Mathematics 77, 269 (2019); M. Hill's thesis, section 4.3.3.

use serde::{Deserialize, Serialize};

use super::adelm::{ChainSettings, chain, stays};
use super::journal::{JournalError, Run, bits};
use super::minima::MatchTolerance;
use super::network::Minimum;
use super::pairs::{BetweenMinima, candidates};
use super::{Phase, Tally};
use crate::energy::Energy;
use crate::optimize::QuenchSettings;
use crate::sample::{Kernel, Task, stream};

/// Fraction of free chains that must return to their minimum at temperatures below melting.
const FROZEN: f64 = 0.9;

/// Fraction of the joinable pairs that the chosen force should join.
const JOINED: f64 = 0.9;

/// Settings of [`tune`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TuningSettings {
    /// Temperatures T to choose from, ascending.
    pub temperatures: Vec<f64>,
    /// Forces F = αT to choose from, energy per length, ascending.
    pub forces: Vec<f64>,
    /// Greatest number of pairs between which chains run.
    pub pairs: usize,
    /// Number of nearest neighbours of each minimum that form the candidate pairs; the pairs used are spread by distance.
    pub neighbours: usize,
    /// Settings of the chains. Their temperature, force, attempts and replicas are not used.
    pub chain: ChainSettings,
    /// Descents at the ends of chains.
    pub quench: QuenchSettings,
    /// Tolerance within which two minima are the same.
    pub sameness: MatchTolerance,
    /// Seed of all chains.
    pub seed: u64,
}

impl Default for TuningSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl TuningSettings {
    /// Settings for a surface whose typical barrier is `energy` high and `length` wide.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self {
            temperatures: log_grid(0.003125 * energy, 0.2 * energy, 4),
            forces: log_grid(0.5 * energy / length, 32.0 * energy / length, 13),
            pairs: 12,
            neighbours: 3,
            chain: ChainSettings::for_scales(energy, length),
            quench: QuenchSettings::for_scales(energy, length),
            sameness: MatchTolerance::for_scales(energy, length),
            seed: 0,
        }
    }
}

/// Returns `count` values from `low` to `high` with equal ratios.
pub fn log_grid(low: f64, high: f64, count: usize) -> Vec<f64> {
    let ratio = libm::log(high / low) / count.saturating_sub(1).max(1) as f64;
    (0..count)
        .map(|k| low * libm::exp(ratio * k as f64))
        .collect()
}

/// Formats a number with three significant digits.
fn short(value: f64) -> String {
    let decimals = (0..12).find(|k| value.abs() * 10_f64.powi(*k) >= 99.5);
    let decimals = usize::try_from(decimals.unwrap_or(0)).unwrap_or(0);
    format!("{value:.decimals$}")
}

/// The trials and the recommended one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tuning {
    /// Pairs that chains ran between, both ways.
    pub pairs: Vec<(usize, usize)>,
    /// Results for each temperature and force that was tried on all pairs.
    pub trials: Vec<TuningTrial>,
    /// Index of the recommended trial; `None` if no trial joined half of the pairs.
    pub best: Option<usize>,
    /// Evaluations spent.
    pub evaluations: usize,
}

/// Chains between all pairs at one temperature and force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TuningTrial {
    /// T.
    pub temperature: f64,
    /// F = αT.
    pub force: f64,
    /// Fraction of free chains (without force) that are still in their minimum after as many steps as a chain's patience.
    pub retention: f64,
    /// Fraction of the chains that arrived.
    pub arrived: f64,
    /// Fraction of the pairs that some chain joined.
    pub joined: f64,
    /// Median over all pairs of the lower raw barrier above the higher minimum; `None` if half of the pairs are not joined.
    pub median_barrier: Option<f64>,
    /// Evaluations of these chains.
    pub evaluations: usize,
}

impl Tuning {
    /// The recommended trial.
    pub fn recommended(&self) -> Option<&TuningTrial> {
        self.trials.get(self.best?)
    }

    /// A sentence that states the recommendation and its reason.
    pub fn reason(&self) -> Option<String> {
        let best = self.recommended()?;
        Some(format!(
            "of {} temperatures and forces tried on {} pairs, T = {} and F = {} met the lowest median barrier, {} \
             ({:.0} % of the pairs joined; without pull {:.0} % of the chains stay in their minimum)",
            self.trials.len(),
            self.pairs.len(),
            short(best.temperature),
            short(best.force),
            best.median_barrier.map_or(String::new(), short),
            100.0 * best.joined,
            100.0 * best.retention
        ))
    }
}

/// Outcome of one chain, for the journal.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Outcome {
    #[serde(with = "bits::options")]
    barrier: Vec<Option<f64>>,
    evaluations: usize,
}

/// Chooses temperature and force with chains between a few pairs of `minima` (sorted by energy).
///
/// At each temperature, bisection finds the least force at which a chain gets from each minimum of a pair to the other. It
/// assumes that every stronger force succeeds as well. Two forces are then tried on all pairs: the least one that should
/// join nine pairs of ten, and the next one that is at least twice as strong. The recommended trial is the one whose chains
/// meet the lowest barriers, among temperatures at which free chains stay in their minimum if there are any.
///
/// For P pairs and G forces, at most P (2 log₂ G + 6) chains run at each temperature. The outcome depends neither on threads
/// nor on interruptions.
///
/// # Errors
/// If the journal of `run` cannot store a record.
pub fn tune(
    energy: &dyn Energy,
    kernel: &dyn Kernel,
    minima: &[Minimum],
    settings: &TuningSettings,
    run: &Run<'_>,
) -> Result<Tuning, JournalError> {
    let all = candidates(
        &BetweenMinima::new(energy.space(), minima),
        settings.neighbours,
    );
    let count = settings.pairs.min(all.len());
    let tuner = Tuner {
        energy,
        kernel,
        minima,
        settings,
        run,
        pairs: (0..count).map(|k| all[k * all.len() / count]).collect(),
    };
    let temperatures = settings.temperatures.len();
    // Each direction of each pair needs a scan, a free chain and two trials.
    let tally = run.tally(Phase::Choose, 8 * temperatures * count);
    let mut evaluations = 0;
    let mut trials = Vec::new();
    for t in 0..temperatures {
        let (thresholds, retention, spent) = tuner.scan(t, &tally)?;
        evaluations += spent;
        for f in tuner.worth_trying(&thresholds) {
            let trial = tuner.trial((t, f), retention, &tally)?;
            evaluations += trial.evaluations;
            trials.push(trial);
        }
    }
    Ok(Tuning {
        best: best(&trials),
        pairs: tuner.pairs,
        trials,
        evaluations,
    })
}

/// Index of the trial with the lowest barriers; the cheaper one of equal trials.
fn best(trials: &[TuningTrial]) -> Option<usize> {
    let joined = trials.iter().enumerate().filter_map(|(k, trial)| {
        let frozen = trial.retention >= FROZEN;
        Some((!frozen, trial.median_barrier?, trial.evaluations, k))
    });
    joined
        .min_by(|a, b| {
            let barriers = a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
            barriers.then((a.2, a.3).cmp(&(b.2, b.3)))
        })
        .map(|(.., k)| k)
}

struct Tuner<'a> {
    energy: &'a dyn Energy,
    kernel: &'a dyn Kernel,
    minima: &'a [Minimum],
    settings: &'a TuningSettings,
    run: &'a Run<'a>,
    pairs: Vec<(usize, usize)>,
}

impl Tuner<'_> {
    fn ways(&self) -> Vec<(usize, usize)> {
        let back = self.pairs.iter().map(|(a, b)| (*b, *a));
        self.pairs.iter().copied().chain(back).collect()
    }

    fn chain_settings(&self, t: usize) -> ChainSettings {
        ChainSettings {
            temperature: self.settings.temperatures[t],
            ..self.settings.chain.clone()
        }
    }

    /// Runs one chain at temperature `t` and force `f` (indices). Returns its barrier if it arrives, and the evaluations.
    fn chain(
        &self,
        (from, to): (usize, usize),
        (t, f): (usize, usize),
        replica: usize,
    ) -> (Option<f64>, usize) {
        // The stream number has 20 bits for a minimum and 8 bits for each other index.
        let parts = [(to, 20), (t, 8), (f, 8), (replica, 8)];
        let id = parts
            .into_iter()
            .fold(from as u64, |id, (part, width)| (id << width) | part as u64);
        let found = chain(
            self.energy,
            self.kernel,
            (&self.minima[from], &self.minima[to]),
            self.settings.forces[f],
            &self.chain_settings(t),
            (&self.settings.quench, &self.settings.sameness),
            f64::INFINITY,
            &mut stream(self.settings.seed, Task::Tuning, id),
        );
        (found.arrived.then_some(found.barrier), found.evaluations)
    }

    /// Returns for each pair the index of the least force that joins it in either direction (the number of forces if none
    /// does), the fraction of free chains that stay in their minimum, and the evaluations spent.
    fn scan(&self, t: usize, tally: &Tally<'_>) -> Result<(Vec<usize>, f64, usize), JournalError> {
        let ways = self.ways();
        let found: Vec<(usize, bool, usize)> = self.run.each(
            tally,
            &ways,
            |(from, to)| format!("tune/{t}/{from}-{to}"),
            |way| {
                let (threshold, spent) = self.threshold(t, *way);
                let (stayed, free) = self.stays(t, *way);
                (threshold, stayed, spent + free)
            },
        )?;
        // Each task is two of the tally: the least force, and whether a free chain stays.
        for _ in &ways {
            tally.tick();
        }
        let (there, back) = found.split_at(self.pairs.len());
        let either = there.iter().zip(back).map(|(a, b)| a.0.min(b.0));
        let stayed = found.iter().filter(|(_, stayed, _)| *stayed).count();
        Ok((
            either.collect(),
            stayed as f64 / found.len().max(1) as f64,
            found.iter().map(|(.., spent)| spent).sum(),
        ))
    }

    /// Finds by bisection the index of the least force at which a chain arrives. Also returns the evaluations.
    fn threshold(&self, t: usize, way: (usize, usize)) -> (usize, usize) {
        let (mut fails, mut arrives, mut spent) = (0, self.settings.forces.len(), 0);
        while fails < arrives {
            let middle = fails.midpoint(arrives);
            let (barrier, evaluations) = self.chain(way, (t, middle), 0);
            spent += evaluations;
            if barrier.is_some() {
                arrives = middle;
            } else {
                fails = middle + 1;
            }
        }
        (arrives, spent)
    }

    /// Returns whether a free chain stays in the first minimum, and the evaluations.
    fn stays(&self, t: usize, (from, to): (usize, usize)) -> (bool, usize) {
        let id = (((from as u64) << 20 | to as u64) << 8 | t as u64) | 1 << 63;
        stays(
            self.energy,
            self.kernel,
            &self.minima[from],
            &self.chain_settings(t),
            (&self.settings.quench, &self.settings.sameness),
            &mut stream(self.settings.seed, Task::Tuning, id),
        )
    }

    /// Indices of the forces to try on all pairs.
    fn worth_trying(&self, thresholds: &[usize]) -> Vec<usize> {
        let forces = &self.settings.forces;
        let mut reached: Vec<usize> = (thresholds.iter().copied())
            .filter(|f| *f < forces.len())
            .collect();
        reached.sort_unstable();
        let enough = (1..=reached.len()).find(|k| *k as f64 >= JOINED * reached.len() as f64);
        let Some(least) = enough.map(|k| reached[k - 1]) else {
            return Vec::new();
        };
        let double = forces
            .iter()
            .position(|force| *force >= 1.99 * forces[least]);
        std::iter::once(least).chain(double).collect()
    }

    fn trial(
        &self,
        (t, f): (usize, usize),
        retention: f64,
        tally: &Tally<'_>,
    ) -> Result<TuningTrial, JournalError> {
        let ways = self.ways();
        let found: Vec<Outcome> = self.run.each(
            tally,
            &ways,
            |(from, to)| format!("tune/{t}/{f}/{from}-{to}"),
            |way| {
                let (barrier, evaluations) = self.chain(*way, (t, f), 1);
                Outcome {
                    barrier: vec![barrier],
                    evaluations,
                }
            },
        )?;
        let barriers: Vec<Option<f64>> = found.iter().map(|found| found.barrier[0]).collect();
        let (there, back) = barriers.split_at(self.pairs.len());
        let mut lowest: Vec<f64> = (self.pairs.iter().zip(there).zip(back))
            .map(|(((a, b), there), back)| {
                let floor = self.minima[*a].energy.max(self.minima[*b].energy);
                let least = there.iter().chain(back).copied();
                least.fold(f64::INFINITY, f64::min) - floor
            })
            .collect();
        let joined = lowest.iter().filter(|barrier| barrier.is_finite()).count();
        lowest.sort_by(f64::total_cmp);
        let median = lowest.get(lowest.len() / 2).copied();
        Ok(TuningTrial {
            temperature: self.settings.temperatures[t],
            force: self.settings.forces[f],
            retention,
            arrived: barriers.iter().flatten().count() as f64 / barriers.len().max(1) as f64,
            joined: joined as f64 / lowest.len().max(1) as f64,
            median_barrier: median.filter(|barrier| barrier.is_finite()),
            evaluations: found.iter().map(|found| found.evaluations).sum(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(retention: f64, median_barrier: Option<f64>, evaluations: usize) -> TuningTrial {
        TuningTrial {
            temperature: 1.0,
            force: 1.0,
            retention,
            arrived: 1.0,
            joined: 1.0,
            median_barrier,
            evaluations,
        }
    }

    #[test]
    fn grids_and_numbers() {
        let grid = log_grid(0.01, 1.0, 3);
        assert!((grid[1] - 0.1).abs() < 1e-12 && (grid[2] - 1.0).abs() < 1e-12);
        assert_eq!(log_grid(2.0, 9.0, 1).len(), 1);
        let shown = [0.0025, 564.43, 12.345, 0.0, 99.96].map(short);
        assert_eq!(shown, ["0.00250", "564", "12.3", "0", "100"]);
    }

    #[test]
    fn frozen_and_low_is_best() {
        let trials = [
            trial(1.0, Some(2.0), 10),
            trial(1.0, Some(1.0), 20),
            trial(1.0, Some(1.0), 10),
            trial(0.5, Some(0.1), 1),
            trial(1.0, None, 1),
        ];
        assert_eq!(best(&trials), Some(2));
        // If free chains leave their minimum at every temperature, the lowest barrier decides.
        assert_eq!(best(&trials[3..]), Some(0));
        assert_eq!(best(&trials[4..]), None);
    }
}
