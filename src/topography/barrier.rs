//! Connects one pair of minima by relaxing the geodesics between them, or a way that is known.

use serde::{Deserialize, Serialize};

use super::journal::bits;
use super::minima::MatchTolerance;
use super::network::{Edge, Evidence, Minimum, MinimumId};
use super::path::{Pass, Path, PathSettings, geodesics, relax};
use crate::energy::{Counted, Energy};
use crate::optimize::QuenchSettings;

/// Origin of the lowest path of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Start {
    /// An attraction–diffusion chain.
    Chain {
        /// Whether it ran from the higher minimum to the lower.
        backward: bool,
        /// Its number among the searches of the map, or among the chains of its pair and direction in sequential ADELM.
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
    /// [`Evidence::Saddle`], or what another program says of it.
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
    /// Barriers of the raw chains of sequential ADELM from `from` to `to`; `None` if a chain did not arrive.
    #[serde(with = "bits::options")]
    pub forward: Vec<Option<f64>>,
    /// The same from `to` to `from`.
    #[serde(with = "bits::options")]
    pub backward: Vec<Option<f64>>,
    /// The origin of the path.
    pub start: Option<Start>,
    /// Why the energy declares the top of the path invalid, if it does.
    pub invalid_reason: Option<String>,
    /// All passes found.
    pub crossings: Vec<Crossing>,
    /// Evaluations spent.
    pub evaluations: usize,
}

impl Connection {
    /// A connection of which no chains, passes and evaluations are known.
    pub(crate) fn new(from: MinimumId, to: MinimumId, edge: Edge, path: Path) -> Self {
        Self {
            from,
            to,
            edge,
            path,
            forward: Vec::new(),
            backward: Vec::new(),
            start: None,
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

/// Two minima to be connected.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// Their numbers, the lower minimum first.
    pub ids: (MinimumId, MinimumId),
    /// The minima.
    pub minima: (&'a Minimum, &'a Minimum),
    /// Number of the trial, from 0. Later ones relax strings for longer.
    pub attempt: usize,
    /// Height above which a path does not matter, because known ones join them; infinite if none does. Only used on a surface
    /// with ripples.
    pub known: f64,
}

/// The inputs that all pairs share.
#[derive(Debug, Clone, Copy)]
pub struct Connector<'a> {
    /// Settings of the strings.
    pub path: &'a PathSettings,
    /// Settings of every descent.
    pub quench: &'a QuenchSettings,
    /// Tolerance within which two stationary points are the same.
    pub sameness: &'a MatchTolerance,
}

impl Connector<'_> {
    /// Connects a pair: relaxes the straight line and, unless much longer, the other way round, and keeps the lowest path.
    pub fn connect(&self, energy: &dyn Energy, pair: Pair<'_>) -> Connection {
        self.relaxed(energy, pair, &self.geodesics(energy, pair))
    }

    /// Relaxes the straight line only.
    pub(super) fn connect_straight(&self, energy: &dyn Energy, pair: Pair<'_>) -> Connection {
        let (from, to) = (&pair.minima.0.coordinates, &pair.minima.1.coordinates);
        let ways = geodesics(energy.space(), from, to, 0.0);
        let starts: Vec<_> = ways.into_iter().map(|way| (Start::Straight, way)).collect();
        self.relaxed(energy, pair, &starts)
    }

    /// Relaxes the points from `start`, which lead from one minimum to the other.
    pub(super) fn connect_along(
        &self,
        energy: &dyn Energy,
        pair: Pair<'_>,
        start: (Start, Vec<Vec<f64>>),
    ) -> Connection {
        self.relaxed(energy, pair, &[start])
    }

    /// Relaxes a way that is known, and the geodesics again.
    pub(super) fn improve(
        &self,
        energy: &dyn Energy,
        pair: Pair<'_>,
        known: &Connection,
    ) -> Connection {
        let mut starts = self.geodesics(energy, pair);
        if !known.path.images.is_empty() {
            let start = known.start.unwrap_or(Start::Straight);
            starts.push((start, known.path.images.clone()));
        }
        self.relaxed(energy, pair, &starts)
    }

    fn geodesics(&self, energy: &dyn Energy, pair: Pair<'_>) -> Vec<(Start, Vec<Vec<f64>>)> {
        let (from, to) = (&pair.minima.0.coordinates, &pair.minima.1.coordinates);
        let ways = geodesics(energy.space(), from, to, self.path.detour);
        [Start::Straight, Start::Round]
            .into_iter()
            .zip(ways)
            .collect()
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
        quick.relaxed(energy, pair, &starts)
    }

    /// The connection over the lowest of the paths relaxed from `starts`.
    fn relaxed(
        &self,
        energy: &dyn Energy,
        pair: Pair<'_>,
        starts: &[(Start, Vec<Vec<f64>>)],
    ) -> Connection {
        let (counted, minima) = (Counted::new(energy), pair.minima);
        let mut settings = self.path.clone();
        let doublings = pair.attempt.min(MOST_DOUBLINGS);
        settings.coarse_iterations <<= doublings;
        settings.iterations <<= doublings;
        if let Some(lowering) = &mut settings.lowering {
            lowering.moves <<= doublings;
            lowering.halvings += doublings;
        }
        if settings.roughness > 0.0 && pair.attempt == 0 {
            // Lowering a top costs more than all the rest, and few of these paths decide the tree.
            settings.lowering = None;
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
        let unreached = Edge {
            length: (energy.space()).distance(&minima.0.coordinates, &minima.1.coordinates),
            ..Edge::bare(f64::INFINITY, Evidence::None)
        };
        let (from, to) = pair.ids;
        let mut connection = Connection::new(from, to, unreached, Path::default());
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
            connection.invalid_reason = outcome.invalid_reason;
            connection.crossings = outcome.passes.into_iter().map(Crossing::from).collect();
        }
        connection.evaluations = usize::try_from(counted.evaluations()).unwrap_or(usize::MAX);
        connection
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
            evidence: Evidence::Saddle,
            path,
        }
    }
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
