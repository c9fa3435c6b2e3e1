//! Connects one pair of minima: runs chains in both directions, then relaxes the best chain and the geodesics.

use serde::{Deserialize, Serialize};

use super::adelm::{ChainSettings, chain};
use super::journal::bits;
use super::minima::MatchTolerance;
use super::network::{Edge, Evidence, Minimum, MinimumId};
use super::path::{Pass, Path, PathSettings, geodesics, relax};
use crate::energy::{Counted, Energy};
use crate::optimize::QuenchSettings;
use crate::sample::{Kernel, Task, stream};

/// Origin of the lowest path of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Start {
    /// An attraction–diffusion chain.
    Chain {
        /// Whether it ran from the higher minimum to the lower.
        backward: bool,
        /// Its number among the replicas of its trial and direction.
        replica: usize,
    },
    /// The geodesic between the two minima.
    Straight,
    /// The geodesic the other way round, such as a rotation of more than half a turn or the far side of a torus.
    Round,
}

/// A pass found while a pair was connected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Crossing {
    /// Index of the pass in the path.
    pub pass: usize,
    /// [`Evidence::Saddle`] or [`Evidence::Seam`].
    pub evidence: Evidence,
    /// From the end of one descent over the pass to the end of the other.
    pub path: Path,
}

/// The result of connecting one pair. Numbers are stored bit for bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Connection {
    /// The lower minimum, where the path starts.
    pub from: MinimumId,
    /// The higher minimum.
    pub to: MinimumId,
    /// Height, evidence, term and length.
    #[serde(with = "edge")]
    pub edge: Edge,
    /// The lowest path found; empty if there is none.
    pub path: Path,
    /// Barriers of the raw chains from `from` to `to`, one for each replica; `None` if no force arrived.
    #[serde(with = "bits::options")]
    pub forward: Vec<Option<f64>>,
    /// The same from `to` to `from`.
    #[serde(with = "bits::options")]
    pub backward: Vec<Option<f64>>,
    /// The origin of the path.
    pub start: Option<Start>,
    /// Height of the roughly relaxed geodesic; infinite if it leaves the domain or its top is invalid.
    #[serde(with = "bits::number")]
    pub straight: f64,
    /// Why the energy declares the top of the path invalid, if it does.
    pub invalid_reason: Option<String>,
    /// All passes found.
    pub crossings: Vec<Crossing>,
    /// Evaluations spent.
    pub evaluations: usize,
}

impl Connection {
    /// A connection whose height is given, without a path.
    pub(super) fn by_definition(
        (from, to): (MinimumId, MinimumId),
        height: f64,
        length: f64,
    ) -> Self {
        Self {
            from,
            to,
            edge: Edge {
                height,
                evidence: Evidence::Path,
                term: None,
                length,
            },
            path: Path::default(),
            forward: Vec::new(),
            backward: Vec::new(),
            start: None,
            straight: f64::INFINITY,
            invalid_reason: None,
            crossings: Vec::new(),
            evaluations: 0,
        }
    }
}

/// Stores an [`Edge`] bit for bit.
mod edge {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{Edge, Evidence};

    type Record = ([u64; 2], Evidence, Option<String>);

    pub(super) fn serialize<S: Serializer>(edge: &Edge, serializer: S) -> Result<S::Ok, S::Error> {
        let numbers = [edge.height, edge.length].map(f64::to_bits);
        (numbers, edge.evidence, &edge.term).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Edge, D::Error> {
        let (numbers, evidence, term) = Record::deserialize(deserializer)?;
        let [height, length] = numbers.map(f64::from_bits);
        Ok(Edge {
            height,
            evidence,
            term,
            length,
        })
    }
}

/// The random streams and the effort of one trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Number of the trial, from 0. Each trial has new random streams, and later ones relax strings for longer.
    pub attempt: usize,
    /// Seed of the run.
    pub seed: u64,
}

/// Two minima to be connected.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// Their numbers, the lower minimum first.
    pub ids: (MinimumId, MinimumId),
    /// The minima.
    pub minima: (&'a Minimum, &'a Minimum),
    /// The effort of this trial.
    pub effort: Effort,
    /// Height at which known paths already join them; infinite if none does. Only used on a surface with ripples.
    pub known: f64,
}

/// The inputs that all pairs share.
#[derive(Debug, Clone, Copy)]
pub struct Connector<'a> {
    /// Settings of the chains.
    pub chain: &'a ChainSettings,
    /// Settings of the strings.
    pub path: &'a PathSettings,
    /// Settings of every descent.
    pub quench: &'a QuenchSettings,
    /// Tolerance within which two stationary points are the same.
    pub sameness: &'a MatchTolerance,
}

impl Connector<'_> {
    /// Connects a pair.
    ///
    /// Chains run in both directions `replicas` times, each with growing force until one arrives. The best chain, the
    /// straight line and, unless much longer, the other way round are relaxed, and the lowest path is kept. If no replicas
    /// are set, chains run only for a pair that is tried again. The outcome depends only on the two minima, their numbers, the settings and the effort.
    pub fn connect(&self, energy: &dyn Energy, kernel: &dyn Kernel, pair: Pair<'_>) -> Connection {
        let (from, to) = (&pair.minima.0.coordinates, &pair.minima.1.coordinates);
        let again = usize::from(pair.effort.attempt > 0);
        let replicas = self.chain.replicas.max(again) << pair.effort.attempt;
        let chains = self.chains(energy, kernel, pair, replicas);
        let ways = geodesics(energy.space(), from, to, self.path.detour);
        let mut starts: Vec<_> = [Start::Straight, Start::Round]
            .into_iter()
            .zip(ways)
            .collect();
        starts.extend(chains.best.iter().map(Best::start));
        self.relaxed(energy, pair, chains, &starts)
    }

    /// Relaxes the straight line for a few iterations, to find out whether only ripples divide a pair.
    pub(super) fn connect_roughly(&self, energy: &dyn Energy, pair: Pair<'_>) -> Connection {
        let (from, to) = (&pair.minima.0.coordinates, &pair.minima.1.coordinates);
        let path = PathSettings {
            coarse_iterations: self.path.coarse_iterations / 3,
            ..self.path.clone()
        };
        let quick = Connector {
            path: &path,
            ..*self
        };
        let floor = pair.minima.0.energy.max(pair.minima.1.energy);
        let pair = Pair {
            known: floor + path.roughness,
            ..pair
        };
        let ways = geodesics(energy.space(), from, to, 0.0);
        let starts: Vec<_> = ways.into_iter().map(|way| (Start::Straight, way)).collect();
        quick.relaxed(energy, pair, Chains::default(), &starts)
    }

    /// Runs `replicas` more chains in each direction and relaxes the best one if it is lower than `known`.
    pub fn replicate(
        &self,
        energy: &dyn Energy,
        kernel: &dyn Kernel,
        pair: Pair<'_>,
        replicas: usize,
        known: f64,
    ) -> Connection {
        let chains = self.chains(energy, kernel, pair, replicas);
        let lower = chains.best.iter().filter(|best| best.barrier < known);
        let starts: Vec<_> = lower.map(Best::start).collect();
        self.relaxed(energy, pair, chains, &starts)
    }

    /// The connection over the lowest of the paths relaxed from `starts`.
    fn relaxed(
        &self,
        energy: &dyn Energy,
        pair: Pair<'_>,
        chains: Chains,
        starts: &[(Start, Vec<Vec<f64>>)],
    ) -> Connection {
        let (counted, minima) = (Counted::new(energy), pair.minima);
        let mut settings = self.path.clone();
        let doublings = pair.effort.attempt.min(MOST_DOUBLINGS);
        settings.coarse_iterations <<= doublings;
        settings.iterations <<= doublings;
        if let Some(seams) = &mut settings.seams {
            seams.moves <<= doublings;
            seams.halvings += doublings;
        }
        if settings.roughness > 0.0 && pair.effort.attempt == 0 {
            // Lowering a top costs more than all the rest, and few of these paths decide the tree.
            settings.seams = None;
        } else if settings.roughness > 0.0 {
            // This pair decides the tree, so even a top at the level of ripples is led over a pass.
            settings.roughness *= LEVEL;
            settings.refinement_steps <<= 1;
        }
        let points: Vec<_> = starts.iter().map(|(_, points)| points.clone()).collect();
        let outcome = relax(
            &counted,
            minima,
            &points,
            &settings,
            self.quench,
            self.sameness,
            pair.known,
        );
        let mut connection = Connection {
            from: pair.ids.0,
            to: pair.ids.1,
            edge: Edge {
                height: f64::INFINITY,
                evidence: Evidence::None,
                term: None,
                length: energy
                    .space()
                    .distance(&minima.0.coordinates, &minima.1.coordinates),
            },
            path: Path::default(),
            forward: chains.forward,
            backward: chains.backward,
            start: None,
            straight: f64::INFINITY,
            invalid_reason: None,
            crossings: Vec::new(),
            evaluations: 0,
        };
        if let Some(outcome) = outcome {
            let found = outcome.height.is_finite();
            connection.edge = Edge {
                height: outcome.height,
                evidence: if found {
                    outcome.evidence
                } else {
                    Evidence::None
                },
                term: rising_term(energy, &outcome.top, minima),
                length: outcome.path.length(energy.space()),
            };
            connection.path = outcome.path;
            connection.start = Some(starts[outcome.start].0);
            if let Some(rough) = outcome.first
                && starts[0].0 == Start::Straight
            {
                connection.straight = rough;
            }
            connection.invalid_reason = outcome.invalid_reason;
            connection.crossings = outcome.passes.into_iter().map(Crossing::from).collect();
        }
        let relaxing = usize::try_from(counted.evaluations()).unwrap_or(usize::MAX);
        connection.evaluations = chains.evaluations + relaxing;
        connection
    }

    fn chains(
        &self,
        energy: &dyn Energy,
        kernel: &dyn Kernel,
        Pair {
            ids,
            minima,
            effort,
            ..
        }: Pair<'_>,
        replicas: usize,
    ) -> Chains {
        let mut evaluations = 0;
        let mut best: Option<Best> = None;
        let mut run = |backward: bool, replica: usize| {
            let mut force = self.chain.force;
            for attempt in 0..self.chain.attempts {
                let part = [effort.attempt, usize::from(backward), replica, attempt];
                let id = stream_number(ids, part);
                let mut rng = stream(effort.seed, Task::AttractionDiffusion, id);
                let found = chain(
                    energy,
                    kernel,
                    if backward {
                        (minima.1, minima.0)
                    } else {
                        minima
                    },
                    force,
                    self.chain,
                    (self.quench, self.sameness),
                    f64::INFINITY,
                    &mut rng,
                );
                evaluations += found.evaluations;
                if found.arrived {
                    if best
                        .as_ref()
                        .is_none_or(|known| found.barrier < known.barrier)
                    {
                        let path = if backward {
                            found.path.reversed()
                        } else {
                            found.path
                        };
                        best = Some(Best {
                            barrier: found.barrier,
                            path,
                            start: Start::Chain { backward, replica },
                        });
                    }
                    return Some(found.barrier);
                }
                force *= self.chain.escalation;
            }
            None
        };
        let [forward, backward] =
            [false, true].map(|backward| (0..replicas).map(|k| run(backward, k)).collect());
        Chains {
            forward,
            backward,
            best,
            evaluations,
        }
    }
}

#[derive(Default)]
struct Chains {
    forward: Vec<Option<f64>>,
    backward: Vec<Option<f64>>,
    best: Option<Best>,
    evaluations: usize,
}

struct Best {
    barrier: f64,
    /// Its path, from the lower minimum.
    path: Path,
    start: Start,
}

impl Best {
    fn start(&self) -> (Start, Vec<Vec<f64>>) {
        (self.start, self.path.images.clone())
    }
}

/// How often the effort of a relaxation is doubled at most, however often a pair is tried.
const MOST_DOUBLINGS: usize = 2;

/// Share of a ripple below which the top of a decisive path does not matter.
const LEVEL: f64 = 0.01;

/// Number of points kept of each descent from a pass.
const KEPT: usize = 8;

impl From<Pass> for Crossing {
    fn from(pass: Pass) -> Self {
        let [first, second] = pass.descents.map(|descent| descent.thinned(KEPT));
        let mut path = first.reversed();
        let top = path.images.len() - 1;
        path.images.extend(second.images.into_iter().skip(1));
        path.energies.extend(second.energies.into_iter().skip(1));
        Self {
            pass: top,
            evidence: if pass.seam {
                Evidence::Seam
            } else {
                Evidence::Saddle
            },
            path,
        }
    }
}

/// A unique number for every chain of a run, for up to 2²⁰ minima and 2⁸ replicas.
fn stream_number(
    (from, to): (MinimumId, MinimumId),
    [attempt, direction, replica, escalation]: [usize; 4],
) -> u64 {
    [
        (to.0, 20),
        (attempt, 4),
        (direction, 1),
        (replica, 8),
        (escalation, 4),
    ]
    .into_iter()
    .fold(from.0 as u64, |number, (part, width)| {
        (number << width) | part as u64
    })
}

/// The term that rises most from the higher minimum to the top.
pub(super) fn rising_term(
    energy: &dyn Energy,
    top: &[f64],
    minima: (&Minimum, &Minimum),
) -> Option<String> {
    let higher = if minima.0.energy > minima.1.energy {
        minima.0
    } else {
        minima.1
    };
    let below = energy.terms(&higher.coordinates);
    let rises = energy.terms(top).into_iter().zip(below);
    rises
        .map(|((name, above), (_, below))| (above - below, name))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
