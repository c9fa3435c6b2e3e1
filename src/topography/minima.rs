//! Minima: descend, merge duplicates, and (where no population is given) hop about for more.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::journal::{Journal, bits, remember};
use super::network::Minimum;
use super::{Observer, Phase, Tally};
use crate::energy::Energy;
use crate::optimize::{Quench, QuenchSettings, StopReason, quench};
use crate::sample::{Task, stream};
use crate::space::Space;

/// When two stationary points are one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sameness {
    /// Greatest difference in energy.
    pub energy: f64,
    /// Greatest distance, modulo the symmetry of the space.
    pub distance: f64,
}

impl Default for Sameness {
    fn default() -> Self {
        Self {
            energy: 1e-6,
            distance: 1e-3,
        }
    }
}

impl Sameness {
    /// Whether `quench` ended in `minimum`.
    pub fn holds(&self, space: &dyn Space, x: &[f64], energy: f64, minimum: &Minimum) -> bool {
        (energy - minimum.energy).abs() <= self.energy
            && space.distance(x, &minimum.coordinates) <= self.distance
    }
}

/// A start that led to no minimum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rejected {
    /// Row of the start.
    pub row: usize,
    /// Norm of the gradient where the descent ended, energy per length.
    pub gradient_norm: f64,
    /// Why it ended there.
    pub stop: StopReason,
}

/// Descends from every start, in parallel; row i of the result belongs to start i.
pub fn quench_all(
    energy: &dyn Energy,
    starts: &[Vec<f64>],
    settings: &QuenchSettings,
    journal: &dyn Journal,
    observer: &Observer<'_>,
) -> Vec<Quench> {
    let tally = Tally::new(Phase::Quench, starts.len(), observer);
    let row = |(row, start): (usize, &Vec<f64>)| {
        let record = remember(journal, &format!("quench/{row}"), || {
            QuenchRecord::from(quench(energy, start, settings))
        });
        tally.tick();
        record.into()
    };
    starts.par_iter().enumerate().map(row).collect()
}

/// The distinct minima among `found`, lowest first, and the rows that are none: those whose gradient exceeds
/// `max_gradient` (energy per length).
///
/// Duplicates are chained: points belong together when a sequence of pairs that are the same joins them. A minimum is
/// represented by its lowest member. The result depends on the order of the input only through the row numbers.
pub fn distinct(
    energy: &dyn Energy,
    found: &[Quench],
    sameness: &Sameness,
    max_gradient: f64,
) -> (Vec<Minimum>, Vec<Rejected>) {
    let space = energy.space();
    let (mut sorted, mut rejected) = (Vec::new(), Vec::new());
    for (row, quench) in found.iter().enumerate() {
        // A gradient that is not a number must not pass.
        if quench.energy.is_finite() && quench.gradient_norm <= max_gradient {
            sorted.push(row);
        } else {
            rejected.push(Rejected {
                row,
                gradient_norm: quench.gradient_norm,
                stop: quench.stop,
            });
        }
    }
    sorted.sort_by(|a, b| order(&found[*a], &found[*b]).then(a.cmp(b)));
    let mut sets = petgraph::unionfind::UnionFind::new(sorted.len());
    for (i, a) in sorted.iter().enumerate() {
        for (j, b) in sorted.iter().enumerate().skip(i + 1) {
            if found[*b].energy - found[*a].energy > sameness.energy {
                break;
            }
            if !sets.equiv(i, j) && space.distance(&found[*a].x, &found[*b].x) <= sameness.distance
            {
                sets.union(i, j);
            }
        }
    }
    let mut minima: Vec<Minimum> = Vec::new();
    let mut number = vec![None; sorted.len()];
    for (i, row) in sorted.iter().enumerate() {
        // Rows come by rising energy: the first of a set is its lowest.
        let place = *number[sets.find(i)].get_or_insert_with(|| {
            minima.push(Minimum {
                coordinates: found[*row].x.clone(),
                energy: found[*row].energy,
                choice: energy.choice(&found[*row].x),
                members: Vec::new(),
            });
            minima.len() - 1
        });
        minima[place].members.push(*row);
    }
    for minimum in &mut minima {
        minimum.members.sort_unstable();
    }
    (minima, rejected)
}

/// By energy, then by coordinates: an order that does not know row numbers.
fn order(a: &Quench, b: &Quench) -> std::cmp::Ordering {
    a.energy.total_cmp(&b.energy).then_with(|| {
        let pairs = a.x.iter().zip(&b.x);
        pairs
            .map(|(a, b)| a.total_cmp(b))
            .find(|o| o.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal)
    })
}

/// Settings of [`hop`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HoppingSettings {
    /// Descents.
    pub quench: QuenchSettings,
    /// When two minima are one.
    pub sameness: Sameness,
    /// Root-mean-square length of a kick.
    pub kick: f64,
    /// Temperature at which a hop uphill is accepted, in units of the energy.
    pub temperature: f64,
    /// A walker stops after this many hops in a row that found nothing new to it.
    pub patience: usize,
    /// Most hops of a walker.
    pub max_hops: usize,
    /// Seed of the walkers.
    pub seed: u64,
}

impl Default for HoppingSettings {
    fn default() -> Self {
        Self {
            quench: QuenchSettings::default(),
            sameness: Sameness::default(),
            kick: 1.0,
            temperature: 1.0,
            patience: 50,
            max_hops: 5000,
            seed: 0,
        }
    }
}

/// Basin hopping: walkers from `starts`, each kicking its minimum, descending and accepting by Metropolis' rule, until
/// it has found nothing new for a while. Returns the distinct minima; their members are the walkers that saw them.
///
/// D. J. Wales and J. P. K. Doye, J. Phys. Chem. A 101, 5111 (1997). No walker knows what the others or the literature
/// found. Descents that do not converge (evaporated clusters) are not minima and not counted as new.
pub fn hop(
    energy: &dyn Energy,
    starts: &[Vec<f64>],
    settings: &HoppingSettings,
    observer: &Observer<'_>,
) -> Vec<Minimum> {
    let tally = Tally::new(Phase::Hop, starts.len(), observer);
    let walk = |(walker, start): (usize, &Vec<f64>)| {
        let seen = hop_from(energy, start, walker, settings);
        tally.tick();
        seen
    };
    let seen: Vec<Vec<Quench>> = starts.par_iter().enumerate().map(walk).collect();
    let walker: Vec<usize> = (seen.iter().enumerate())
        .flat_map(|(walker, found)| std::iter::repeat_n(walker, found.len()))
        .collect();
    let (mut minima, _) = distinct(energy, &seen.concat(), &settings.sameness, f64::INFINITY);
    for minimum in &mut minima {
        for member in &mut minimum.members {
            *member = walker[*member];
        }
        minimum.members.dedup();
    }
    minima
}

fn hop_from(
    energy: &dyn Energy,
    start: &[f64],
    walker: usize,
    settings: &HoppingSettings,
) -> Vec<Quench> {
    let space = energy.space();
    let scales = space.step_scales();
    let share = settings.kick / (scales.iter().map(|s| s * s).sum::<f64>()).sqrt();
    let mut rng = stream(settings.seed, Task::BasinHopping, walker as u64);
    let mut seen: Vec<Quench> = Vec::new();
    let mut here = quench(energy, start, &settings.quench);
    if here.stop == StopReason::Converged {
        seen.push(here.clone());
    }
    let mut idle = 0;
    for _ in 0..settings.max_hops {
        if idle >= settings.patience {
            break;
        }
        idle += 1;
        let kick: Vec<f64> = scales
            .iter()
            .map(|s| {
                let noise: f64 = StandardNormal.sample(&mut rng);
                share * s * noise
            })
            .collect();
        let mut x = here.x.clone();
        space.shift(&mut x, &kick);
        let next = quench(energy, &x, &settings.quench);
        let chance: f64 = rng.random();
        if next.stop != StopReason::Converged {
            if here.stop != StopReason::Converged && next.energy < here.energy {
                here = next;
            }
            continue;
        }
        let known = seen.iter().any(|old| {
            (old.energy - next.energy).abs() <= settings.sameness.energy
                && space.distance(&old.x, &next.x) <= settings.sameness.distance
        });
        if !known {
            seen.push(next.clone());
            idle = 0;
        }
        if here.stop != StopReason::Converged
            || chance < ((here.energy - next.energy) / settings.temperature).exp()
        {
            here = next;
        }
    }
    seen
}

/// A [`Quench`] to the last bit.
#[derive(Serialize, Deserialize)]
pub(super) struct QuenchRecord {
    #[serde(with = "bits::list")]
    x: Vec<f64>,
    #[serde(with = "bits::number")]
    energy: f64,
    #[serde(with = "bits::number")]
    gradient_norm: f64,
    evaluations: usize,
    stop: StopReason,
}

impl From<Quench> for QuenchRecord {
    fn from(quench: Quench) -> Self {
        Self {
            x: quench.x,
            energy: quench.energy,
            gradient_norm: quench.gradient_norm,
            evaluations: quench.evaluations,
            stop: quench.stop,
        }
    }
}

impl From<QuenchRecord> for Quench {
    fn from(record: QuenchRecord) -> Self {
        Self {
            x: record.x,
            energy: record.energy,
            gradient_norm: record.gradient_norm,
            evaluations: record.evaluations,
            stop: record.stop,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::model::MullerBrown;
    use crate::topography::{MemoryJournal, silent};

    fn starts(count: u64) -> Vec<Vec<f64>> {
        (0..count)
            .map(|id| {
                let mut rng = stream(5, Task::Start, id);
                vec![rng.random_range(-1.5..1.0), rng.random_range(-0.3..1.8)]
            })
            .collect()
    }

    #[test]
    fn order_of_the_input_does_not_matter() {
        let energy = MullerBrown::new();
        let mut found = quench_all(
            &energy,
            &starts(40),
            &QuenchSettings::default(),
            &MemoryJournal::default(),
            &silent,
        );
        let sameness = Sameness::default();
        let (minima, rejected) = distinct(&energy, &found, &sameness, 1e-6);
        assert_eq!(minima.len(), 3);
        assert!(rejected.is_empty());
        assert_eq!(minima.iter().map(|m| m.members.len()).sum::<usize>(), 40);
        found.reverse();
        let (reversed, _) = distinct(&energy, &found, &sameness, 1e-6);
        for (one, other) in minima.iter().zip(&reversed) {
            assert_eq!(one.coordinates, other.coordinates);
            let mut members: Vec<_> = other.members.iter().map(|row| 39 - row).collect();
            members.sort_unstable();
            assert_eq!(one.members, members);
        }
    }

    #[test]
    fn unfinished_descents_are_rejected_and_named() {
        let energy = MullerBrown::new();
        let settings = QuenchSettings::default().with_max_evaluations(3);
        let found = quench_all(
            &energy,
            &starts(5),
            &settings,
            &MemoryJournal::default(),
            &silent,
        );
        let (minima, rejected) = distinct(&energy, &found, &Sameness::default(), 1e-6);
        assert!(minima.is_empty());
        assert_eq!(rejected.len(), 5);
        assert_eq!(rejected[3].row, 3);
        assert_eq!(rejected[3].stop, StopReason::Budget);
    }

    #[test]
    fn remembered_descents_are_not_repeated() {
        let (energy, journal) = (MullerBrown::new(), MemoryJournal::default());
        let counted = crate::energy::Counted::new(&energy);
        let settings = QuenchSettings::default();
        let first = quench_all(&counted, &starts(5), &settings, &journal, &silent);
        let spent = counted.evaluations();
        assert_eq!(journal.len(), 5);
        let second = quench_all(&counted, &starts(5), &settings, &journal, &silent);
        assert_eq!(first, second);
        assert_eq!(counted.evaluations(), spent);
    }
}
