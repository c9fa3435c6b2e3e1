//! The magnetisation diagram: the temperatures and forces at which chains arrive, and the settings it recommends.
//!
//! M. Hill, E. Nijkamp and S.-C. Zhu, Quarterly of Applied Mathematics 77, 269 (2019); M. Hill's thesis, section 4.3.3.

use serde::{Deserialize, Serialize};

use super::Phase;
use super::adelm::{ChainSettings, chain, stays};
use super::groups::{Level, level, most_stable};
use super::journal::{JournalError, Run, bits};
use super::minima::MatchTolerance;
use super::network::Minimum;
use super::pairs::{BetweenMinima, Distances, candidates, nearest};
use crate::agreement::adjusted_rand;
use crate::energy::Energy;
use crate::optimize::QuenchSettings;
use crate::sample::{Kernel, Task, stream};

/// Fraction of free chains that must return to their minimum at temperatures below melting.
pub(super) const FROZEN: f64 = 0.9;

/// Settings of [`diagram`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DiagramSettings {
    /// Temperatures T, ascending.
    pub temperatures: Vec<f64>,
    /// Forces F = αT, energy per length, ascending.
    pub forces: Vec<f64>,
    /// Number of chains for each pair and direction at each T and F.
    pub replicas: usize,
    /// Greatest number of minima in the sample: a few at all energies, and the nearest ones of each.
    pub minima: usize,
    /// Nearest neighbours in the sample that each minimum is paired with, besides the edges of a minimum spanning tree.
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

impl Default for DiagramSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl DiagramSettings {
    /// Settings for a surface whose typical barrier is `energy` high and `length` wide.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self {
            temperatures: log_grid(0.0125 * energy, 0.2 * energy, 5),
            forces: log_grid(0.25 * energy / length, 32.0 * energy / length, 15),
            replicas: 4,
            minima: 24,
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

/// The measured diagram and its recommendation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagram {
    /// Indices of the minima in the sample.
    pub minima: Vec<usize>,
    /// Pairs of them that chains ran between, both ways.
    pub pairs: Vec<(usize, usize)>,
    /// One row of the diagram for each temperature.
    pub isotherms: Vec<Isotherm>,
    /// The recommended temperature, force and relative barrier; `None` if no force joined most pairs.
    pub recommended: Option<Recommendation>,
    /// Evaluations spent.
    pub evaluations: usize,
}

/// The diagram at one temperature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Isotherm {
    /// T.
    pub temperature: f64,
    /// Fraction of free chains (without force) that are still in their minimum after as many steps as a chain's patience.
    pub retention: f64,
    /// Thresholds of all pairs from the first to the second minimum, then of all pairs backward.
    pub thresholds: Vec<Threshold>,
    /// Statistics of the whole sample at each force, ascending.
    pub levels: Vec<ForceLevel>,
}

/// The forces between which a chain becomes certain to arrive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Threshold {
    /// The minimum at which the chains start.
    pub from: usize,
    /// The minimum that attracts.
    pub to: usize,
    /// Least force at which any chain arrived.
    pub first: Option<f64>,
    /// Least force from which on all chains arrived.
    pub always: Option<f64>,
    /// Lowest raw barrier met at any force.
    pub lowest_barrier: Option<f64>,
    /// The force at which it was met.
    pub lowest_at: Option<f64>,
}

/// Statistics of all pairs at one temperature and force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ForceLevel {
    /// F.
    pub force: f64,
    /// Fraction of the chains that arrived.
    pub arrived: f64,
    /// Fraction of the pairs that some chain joined.
    pub joined: f64,
    /// Number of groups of minima joined by chains, mean over replicas.
    pub groups: f64,
    /// Mean adjusted Rand index between the groups of two replicas.
    pub stability: f64,
    /// Median over all pairs of the lowest relative raw barrier; `None` if half of the pairs are not joined.
    pub median_barrier: Option<f64>,
}

/// The recommended settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recommendation {
    /// T.
    pub temperature: f64,
    /// F = αT.
    pub force: f64,
    /// Relative raw barrier b at which replicas agree best on the groups.
    pub barrier: f64,
    /// Mean adjusted Rand index of the replicas at this barrier.
    pub stability: f64,
    /// A sentence with the reason.
    pub reason: String,
}

/// Raw barriers of the replicas at each force, ascending. An entry is empty if all replicas failed at a higher force.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Scan {
    levels: Vec<Replicas>,
    evaluations: usize,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Replicas {
    #[serde(with = "bits::options")]
    barriers: Vec<Option<f64>>,
}

/// Measures the magnetisation diagram between some of `minima` (sorted by energy).
///
/// For each pair, direction and temperature, chains run at the highest force first and then at lower ones until all
/// replicas fail. The recommended temperature is the highest at which free chains stay in their minimum. The recommended
/// force has the lowest barriers among those that join nine pairs of ten. The recommended barrier b is the relative barrier
/// at which the partitions of the replicas are most alike. The outcome depends neither on threads nor on interruptions.
///
/// # Errors
/// If the journal of `run` cannot store a record.
pub fn diagram(
    energy: &dyn Energy,
    kernel: &dyn Kernel,
    minima: &[Minimum],
    settings: &DiagramSettings,
    run: &Run<'_>,
) -> Result<Diagram, JournalError> {
    let all = BetweenMinima::new(energy.space(), minima);
    let chosen = sample(&all, settings.minima);
    let among: Vec<Vec<f64>> = (chosen.iter())
        .map(|i| chosen.iter().map(|j| all.between(*i, *j)).collect())
        .collect();
    let pairs: Vec<(usize, usize)> = candidates(&among, settings.neighbours)
        .into_iter()
        .map(|(i, j)| (chosen[i], chosen[j]))
        .collect();
    let measurement = Measurement {
        energy,
        kernel,
        minima,
        settings,
    };
    let temperatures = settings.temperatures.len();
    let tasks: Vec<(usize, usize)> = (0..temperatures)
        .flat_map(|t| (0..2 * pairs.len()).map(move |k| (t, k)))
        .collect();
    let tally = run.tally(Phase::Diagram, tasks.len() + temperatures * chosen.len());
    let way = |k: usize| {
        let (a, b) = pairs[k % pairs.len()];
        if k >= pairs.len() { (b, a) } else { (a, b) }
    };
    let scans: Vec<Scan> = run.each(
        &tally,
        &tasks,
        |(t, k)| {
            let (from, to) = way(*k);
            format!("diagram/{t}/{from}-{to}")
        },
        |(t, k)| measurement.scan(*t, way(*k)),
    )?;
    let free: Vec<(usize, usize)> = (0..temperatures)
        .flat_map(|t| chosen.iter().map(move |i| (t, *i)))
        .collect();
    let stays: Vec<(usize, usize)> = run.each(
        &tally,
        &free,
        |(t, i)| format!("diagram/{t}/{i}"),
        |(t, i)| measurement.stays(*t, *i),
    )?;
    let mut evaluations = scans.iter().map(|scan| scan.evaluations).sum::<usize>();
    evaluations += stays.iter().map(|stay| stay.1).sum::<usize>();
    let isotherms: Vec<Isotherm> = (0..temperatures)
        .map(|t| {
            let rows = &scans[2 * t * pairs.len()..2 * (t + 1) * pairs.len()];
            let stayed = &stays[t * chosen.len()..(t + 1) * chosen.len()];
            let stayed: usize = stayed.iter().map(|(stayed, _)| stayed).sum();
            Isotherm {
                temperature: settings.temperatures[t],
                retention: stayed as f64 / (chosen.len() * settings.replicas).max(1) as f64,
                thresholds: measurement.thresholds(&pairs, rows),
                levels: (0..settings.forces.len())
                    .map(|f| measurement.force_level(&chosen, &pairs, rows, f))
                    .collect(),
            }
        })
        .collect();
    let recommended = choose(&isotherms).map(|(t, f)| {
        let rows = &scans[2 * t * pairs.len()..2 * (t + 1) * pairs.len()];
        let b = measurement.barrier_level(&chosen, &pairs, rows, f);
        recommendation(&isotherms, (t, f), b)
    });
    Ok(Diagram {
        minima: chosen,
        pairs,
        isotherms,
        recommended,
        evaluations,
    })
}

/// Indices of at most `count` minima: a quarter spread evenly by energy, each with its three nearest others.
fn sample(distances: &dyn Distances, count: usize) -> Vec<usize> {
    let n = distances.len();
    if n <= count {
        return (0..n).collect();
    }
    let seeds = count.div_ceil(4);
    let mut chosen: Vec<usize> = (0..seeds).map(|k| k * n / seeds).collect();
    let mut round = chosen.clone().into_iter().cycle();
    while chosen.len() < count {
        let Some(seed) = round.next() else { break };
        let other = nearest(distances, seed, 1, |i, _| !chosen.contains(&i)).pop();
        chosen.extend(other.map(|(_, i)| i));
    }
    chosen.sort_unstable();
    chosen
}

fn choose(isotherms: &[Isotherm]) -> Option<(usize, usize)> {
    let usable = |isotherm: &Isotherm| {
        let levels = isotherm.levels.iter().enumerate();
        let joined = levels.filter(|(_, level)| level.joined >= 0.9);
        let barriers = joined.filter_map(|(f, level)| level.median_barrier.map(|b| (f, b)));
        barriers.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(f, _)| f)
    };
    let frozen = (isotherms.iter().enumerate().rev()).filter(|(_, row)| row.retention >= FROZEN);
    let coldest = isotherms.iter().enumerate().take(1);
    frozen
        .chain(coldest)
        .find_map(|(t, row)| usable(row).map(|f| (t, f)))
}

fn recommendation(
    isotherms: &[Isotherm],
    (t, f): (usize, usize),
    b: Option<Level>,
) -> Recommendation {
    let (row, level) = (&isotherms[t], &isotherms[t].levels[f]);
    let next = isotherms.get(t + 1).map_or(String::new(), |next| {
        format!(
            ", {:.0} % at {}",
            100.0 * next.retention,
            short(next.temperature)
        )
    });
    let kept = format!(
        "T = {}: without pull {:.0} % of the chains stay in their minimum{next}; F = {}: {:.0} % of the pairs are joined, \
         over the lowest median barrier, {}",
        short(row.temperature),
        100.0 * row.retention,
        short(level.force),
        100.0 * level.joined,
        level.median_barrier.map_or(String::new(), short)
    );
    let (barrier, stability) = b.map_or((0.0, 1.0), |level| (level.barrier, level.stability));
    Recommendation {
        temperature: row.temperature,
        force: level.force,
        barrier,
        stability,
        reason: format!(
            "{kept}; b = {}: replicas agree best on the groups (adjusted Rand index {stability:.2})",
            short(barrier)
        ),
    }
}

/// Formats a number with three significant digits.
pub(super) fn short(value: f64) -> String {
    let decimals = (0..12).find(|k| value.abs() * 10_f64.powi(*k) >= 99.5);
    let decimals = usize::try_from(decimals.unwrap_or(0)).unwrap_or(0);
    format!("{value:.decimals$}")
}

struct Measurement<'a> {
    energy: &'a dyn Energy,
    kernel: &'a dyn Kernel,
    minima: &'a [Minimum],
    settings: &'a DiagramSettings,
}

impl Measurement<'_> {
    fn chain_settings(&self, t: usize) -> ChainSettings {
        ChainSettings {
            temperature: self.settings.temperatures[t],
            ..self.settings.chain.clone()
        }
    }

    /// Runs chains from the highest force down to the first force at which all fail.
    fn scan(&self, t: usize, (from, to): (usize, usize)) -> Scan {
        let settings = self.chain_settings(t);
        let mut scan = Scan {
            levels: vec![Replicas::default(); self.settings.forces.len()],
            evaluations: 0,
        };
        for (f, force) in self.settings.forces.iter().enumerate().rev() {
            let barriers: Vec<Option<f64>> = (0..self.settings.replicas)
                .map(|replica| {
                    // The stream number has 20 bits for a minimum and 8 bits for each other index.
                    let parts = [(to, 20), (t, 8), (f, 8), (replica, 8)];
                    let id = parts
                        .into_iter()
                        .fold(from as u64, |id, (part, width)| (id << width) | part as u64);
                    let mut rng = stream(self.settings.seed, Task::Diagram, id);
                    let found = chain(
                        self.energy,
                        self.kernel,
                        (&self.minima[from], &self.minima[to]),
                        *force,
                        &settings,
                        (&self.settings.quench, &self.settings.sameness),
                        f64::INFINITY,
                        &mut rng,
                    );
                    scan.evaluations += found.evaluations;
                    found.arrived.then_some(found.barrier)
                })
                .collect();
            let failed = barriers.iter().all(Option::is_none);
            scan.levels[f].barriers = barriers;
            if failed {
                break;
            }
        }
        scan
    }

    /// Number of free chains that stay in minimum `i`, and the evaluations spent.
    fn stays(&self, t: usize, i: usize) -> (usize, usize) {
        let settings = self.chain_settings(t);
        let (mut count, mut evaluations) = (0, 0);
        for replica in 0..self.settings.replicas {
            let id = (((i as u64) << 8 | t as u64) << 8 | replica as u64) | 1 << 63;
            let mut rng = stream(self.settings.seed, Task::Diagram, id);
            let judge = (&self.settings.quench, &self.settings.sameness);
            let (stayed, spent) = stays(
                self.energy,
                self.kernel,
                &self.minima[i],
                &settings,
                judge,
                &mut rng,
            );
            count += usize::from(stayed);
            evaluations += spent;
        }
        (count, evaluations)
    }

    fn thresholds(&self, pairs: &[(usize, usize)], rows: &[Scan]) -> Vec<Threshold> {
        let forces = &self.settings.forces;
        let threshold = |(k, scan): (usize, &Scan)| {
            let (a, b) = pairs[k % pairs.len()];
            let backward = k >= pairs.len();
            let arrived = |level: &Replicas| level.barriers.iter().flatten().count();
            let first = scan.levels.iter().position(|level| arrived(level) > 0);
            let fails = |level: &Replicas| arrived(level) < self.settings.replicas;
            let always = scan
                .levels
                .iter()
                .rposition(fails)
                .map_or(0, |last| last + 1);
            let met = scan.levels.iter().zip(forces).flat_map(|(level, force)| {
                let barriers = level.barriers.iter().flatten();
                barriers.map(move |barrier| (*barrier, *force))
            });
            let lowest = met.min_by(|a, b| a.0.total_cmp(&b.0));
            Threshold {
                from: if backward { b } else { a },
                to: if backward { a } else { b },
                first: first.map(|f| forces[f]),
                always: forces.get(always).copied(),
                lowest_barrier: lowest.map(|(barrier, _)| barrier),
                lowest_at: lowest.map(|(_, force)| force),
            }
        };
        rows.iter().enumerate().map(threshold).collect()
    }

    /// Lowest relative barrier of each pair at force `f` (an index), for each replica.
    fn barriers(&self, pairs: &[(usize, usize)], rows: &[Scan], f: usize) -> Vec<Vec<f64>> {
        let barrier = |(k, (a, b)): (usize, &(usize, usize)), replica: usize| {
            let floor = self.minima[*a].energy.max(self.minima[*b].energy);
            [k, k + pairs.len()]
                .iter()
                .filter_map(|row| *rows[*row].levels[f].barriers.get(replica)?)
                .fold(f64::INFINITY, |least, barrier| least.min(barrier - floor))
        };
        (0..self.settings.replicas)
            .map(|replica| {
                let pairs = pairs.iter().enumerate();
                pairs.map(|pair| barrier(pair, replica)).collect()
            })
            .collect()
    }

    fn force_level(
        &self,
        chosen: &[usize],
        pairs: &[(usize, usize)],
        rows: &[Scan],
        f: usize,
    ) -> ForceLevel {
        let replicas = self.barriers(pairs, rows, f);
        let chains: usize = (rows.iter())
            .map(|row| row.levels[f].barriers.iter().flatten().count())
            .sum();
        let mut lowest: Vec<f64> = (0..pairs.len())
            .map(|k| {
                replicas
                    .iter()
                    .fold(f64::INFINITY, |least, row| least.min(row[k]))
            })
            .collect();
        let joined = lowest.iter().filter(|barrier| barrier.is_finite()).count();
        lowest.sort_by(f64::total_cmp);
        let median = lowest.get(lowest.len() / 2).copied();
        let found = agreement(chosen, pairs, &replicas, f64::INFINITY);
        ForceLevel {
            force: self.settings.forces[f],
            arrived: chains as f64 / (rows.len() * self.settings.replicas).max(1) as f64,
            joined: joined as f64 / pairs.len().max(1) as f64,
            groups: found.1,
            stability: found.0.stability,
            median_barrier: median.filter(|barrier| barrier.is_finite()),
        }
    }

    /// The relative barrier at which the replicas at force `f` (an index) agree best.
    fn barrier_level(
        &self,
        chosen: &[usize],
        pairs: &[(usize, usize)],
        rows: &[Scan],
        f: usize,
    ) -> Option<Level> {
        let replicas = self.barriers(pairs, rows, f);
        let mut heights: Vec<f64> = replicas.iter().flatten().copied().collect();
        heights.retain(|height| height.is_finite());
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        let count = heights.len().min(24);
        let scan: Vec<Level> = (1..=count)
            .map(|k| heights[k * heights.len() / count - 1])
            .map(|barrier| agreement(chosen, pairs, &replicas, barrier).0)
            .collect();
        most_stable(&scan, chosen.len())
    }
}

/// The level at which pairs with relative barriers up to `barrier` are joined, and the mean number of groups. The groups
/// and the largest group are those of the first replica; the stability is the mean adjusted Rand index of two replicas.
fn agreement(
    chosen: &[usize],
    pairs: &[(usize, usize)],
    replicas: &[Vec<f64>],
    barrier: f64,
) -> (Level, f64) {
    let place = |i: usize| chosen.binary_search(&i).unwrap_or_default();
    let links = |row: &Vec<f64>| -> Vec<(usize, usize, f64)> {
        let pairs = pairs.iter().zip(row);
        pairs
            .filter(|(_, height)| height.is_finite())
            .map(|((a, b), height)| (place(*a), place(*b), *height))
            .collect()
    };
    let levels: Vec<(Level, Vec<usize>)> = replicas
        .iter()
        .map(|row| level(chosen.len(), &links(row), barrier))
        .collect();
    let (mut total, mut count) = (0.0, 0.0);
    for (k, (_, a)) in levels.iter().enumerate() {
        for (_, b) in &levels[..k] {
            total += adjusted_rand(a, b);
            count += 1.0;
        }
    }
    let groups: usize = levels.iter().map(|(level, _)| level.groups).sum();
    let first = levels.first().map_or(
        Level {
            barrier,
            stability: 1.0,
            groups: 0,
            largest: 0,
        },
        |(level, _)| *level,
    );
    let stability = if count > 0.0 { total / count } else { 1.0 };
    (
        Level { stability, ..first },
        groups as f64 / levels.len().max(1) as f64,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_and_numbers() {
        let grid = log_grid(0.01, 1.0, 3);
        assert!((grid[1] - 0.1).abs() < 1e-12 && (grid[2] - 1.0).abs() < 1e-12);
        assert_eq!(log_grid(2.0, 9.0, 1).len(), 1);
        let shown = [0.0025, 564.43, 12.345, 0.0, 99.96].map(short);
        assert_eq!(shown, ["0.00250", "564", "12.3", "0", "100"]);
    }

    #[test]
    fn samples_are_patches_of_neighbours() {
        let place = |i: usize| i as f64 + if i % 2 == 1 { 100.0 } else { 0.0 };
        let row = |i| (0..40).map(|j| (place(i) - place(j)).abs()).collect();
        let distances: Vec<Vec<f64>> = (0..40).map(row).collect();
        let chosen = sample(&distances, 8);
        assert_eq!(chosen.len(), 8);
        // The sample has the seeds 0 and 20, whose nearest neighbours are even.
        assert!(chosen.iter().all(|i| i % 2 == 0), "{chosen:?}");
        assert_eq!(sample(&distances, 40).len(), 40);
    }
}
