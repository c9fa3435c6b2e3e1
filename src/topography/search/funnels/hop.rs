//! Basin hopping at a ladder of temperatures (parallel tempering), which finds the lowest minima.
//!
//! D. J. Wales and J. P. K. Doye, J. Phys. Chem. A 101, 5111 (1997), with exchanges between temperatures. Neither
//! temperatures nor step lengths are given: they adapt to how often hops are accepted and how often they lead back.

use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::energy::{Counted, Energy};
use crate::optimize::{QuenchSettings, StopReason, quench};
use crate::sample::{Rng, Task, stream};
use crate::space::vector::times;
use crate::topography::journal::bits;
use crate::topography::scales::{median, random_tangent};
use crate::topography::search::Draw;

/// Shares of the accepted hops among those that reach another minimum, for each temperature.
const ACCEPTED: [f64; 4] = [0.08, 0.15, 0.28, 0.45];
/// Share of the hops that lead back to their minimum.
const BACK: f64 = 0.2;
/// Factors by which temperatures and step lengths adapt after each leg.
const ADAPT: (f64, f64) = (1.3, 1.1);
/// First temperatures, relative to the median change of energy of a hop.
const FIRST: [f64; 4] = [0.08, 0.12, 0.18, 0.27];
/// Hops of each walker between two exchanges, and exchanges of a leg.
const LEG: (usize, usize) = (10, 15);
/// Number of the lowest minima that a leg reports.
const REPORTED: usize = 60;

/// A minimum met by a hop.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Met {
    #[serde(with = "bits::list")]
    pub(super) x: Vec<f64>,
    #[serde(with = "bits::number")]
    pub(super) energy: f64,
}

/// Walkers at a ladder of temperatures, from the coldest to the hottest.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Team {
    walkers: Vec<Met>,
    #[serde(with = "bits::list")]
    temperatures: Vec<f64>,
    #[serde(with = "bits::list")]
    steps: Vec<f64>,
    /// Hops of all walkers together.
    pub(super) hops: usize,
    /// Lowest energy.
    #[serde(with = "bits::number")]
    pub(super) best: f64,
    /// Number of the hop that found it.
    pub(super) best_at: usize,
}

/// The result of a leg.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Leg {
    pub(super) team: Team,
    /// The lowest minima met, lowest first.
    pub(super) met: Vec<Met>,
    pub(super) evaluations: usize,
}

/// What all legs have in common.
pub(super) struct Hopping<'a> {
    pub(super) energy: &'a dyn Energy,
    pub(super) draw: &'a Draw<'a>,
    pub(super) quench: QuenchSettings,
    /// Energy difference below which two minima are taken for one.
    pub(super) tie: f64,
    /// First root-mean-square step along each tangent.
    pub(super) step: f64,
    pub(super) seed: u64,
}

impl Hopping<'_> {
    /// Leg number `id` of `team`, or the first leg of a new team.
    pub(super) fn leg(&self, id: u64, team: Option<&Team>) -> Leg {
        let counted = Counted::new(self.energy);
        let mut rng = stream(self.seed, Task::BasinHopping, id);
        let mut team = match team {
            Some(team) => team.clone(),
            None => self.recruited(&counted, &mut rng),
        };
        let mut met = team.walkers.clone();
        let count = team.walkers.len();
        // For each temperature: hops that led elsewhere, those of them that were accepted, and hops that led back.
        let mut tally = vec![[0_usize; 3]; count];
        for _ in 0..LEG.1 {
            for (k, tally) in tally.iter_mut().enumerate() {
                for _ in 0..LEG.0 {
                    team.hops += 1;
                    let Some(next) =
                        self.hop(&counted, &team.walkers[k].x, team.steps[k], &mut rng)
                    else {
                        continue;
                    };
                    let here = team.walkers[k].energy;
                    if (next.energy - here).abs() <= self.tie {
                        tally[2] += 1;
                        continue;
                    }
                    tally[0] += 1;
                    if next.energy < team.best - self.tie {
                        (team.best, team.best_at) = (next.energy, team.hops);
                    }
                    let chance = libm::exp((here - next.energy) / team.temperatures[k]);
                    if rng.random::<f64>() < chance {
                        tally[1] += 1;
                        met.push(next.clone());
                        team.walkers[k] = next;
                    }
                }
            }
            for k in 1..count {
                let colder = team.temperatures[k - 1].recip() - team.temperatures[k].recip();
                let chance =
                    libm::exp(colder * (team.walkers[k - 1].energy - team.walkers[k].energy));
                if rng.random::<f64>() < chance {
                    team.walkers.swap(k - 1, k);
                }
            }
        }
        for (k, [moved, accepted, back]) in tally.into_iter().enumerate() {
            let share = accepted as f64 / moved.max(1) as f64;
            team.temperatures[k] *= if share > ACCEPTED[k] {
                ADAPT.0.recip()
            } else {
                ADAPT.0
            };
            let share = back as f64 / (LEG.0 * LEG.1) as f64;
            team.steps[k] *= if share > BACK {
                ADAPT.1
            } else {
                ADAPT.1.recip()
            };
        }
        team.temperatures.sort_by(f64::total_cmp);
        Leg {
            team,
            met: lowest(met, self.tie, REPORTED),
            evaluations: usize::try_from(counted.evaluations()).unwrap_or(usize::MAX),
        }
    }

    /// A new team at random points.
    fn recruited(&self, energy: &dyn Energy, rng: &mut Rng) -> Team {
        let mut walkers = Vec::new();
        let mut changes = Vec::new();
        for _ in FIRST {
            let walker = self.somewhere(energy, rng);
            for _ in 0..5 {
                let next = self.hop(energy, &walker.x, self.step, rng);
                changes.extend(next.map(|next| (next.energy - walker.energy).abs()));
            }
            walkers.push(walker);
        }
        let typical = median(changes).unwrap_or(1.0).max(self.tie);
        let best = walkers.iter().map(|walker| walker.energy);
        Team {
            best: best.fold(f64::INFINITY, f64::min),
            best_at: 0,
            hops: 0,
            temperatures: FIRST.map(|share| share * typical).to_vec(),
            steps: vec![self.step; walkers.len()],
            walkers,
        }
    }

    /// The minimum below `x`.
    pub(super) fn below(&self, energy: &dyn Energy, x: &[f64]) -> Met {
        let found = quench(energy, x, &self.quench);
        Met {
            x: found.x,
            energy: found.energy,
        }
    }

    /// The minimum below a random point. If no descent converges, the last one counts.
    fn somewhere(&self, energy: &dyn Energy, rng: &mut Rng) -> Met {
        let mut found = quench(energy, &(self.draw)(rng), &self.quench);
        for _ in 0..20 {
            if found.stop != StopReason::Budget && found.energy.is_finite() {
                break;
            }
            found = quench(energy, &(self.draw)(rng), &self.quench);
        }
        Met {
            x: found.x,
            energy: found.energy,
        }
    }

    /// The minimum below a random point near `x`.
    fn hop(&self, energy: &dyn Energy, x: &[f64], step: f64, rng: &mut Rng) -> Option<Met> {
        let space = energy.space();
        let n = space.tangents();
        let kick = random_tangent(n, step * (n as f64).sqrt(), rng);
        let mut x = x.to_vec();
        space.exp(&mut x, &times(&kick, &space.step_scales()));
        let found = quench(energy, &x, &self.quench);
        (found.stop != StopReason::Budget && found.energy.is_finite()).then_some(Met {
            x: found.x,
            energy: found.energy,
        })
    }
}

/// The lowest `count` of the minima, lowest first, one for each energy.
pub(super) fn lowest(mut met: Vec<Met>, tie: f64, count: usize) -> Vec<Met> {
    met.sort_by(|a, b| a.energy.total_cmp(&b.energy));
    met.dedup_by(|later, first| later.energy - first.energy <= tie);
    met.truncate(count);
    met
}
