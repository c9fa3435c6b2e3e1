//! Adds minima to a finished map.

use super::rest::{at_rest, by_energy};
use super::{Charted, LandscapeBuilder};
use crate::energy::Energy;
use crate::optimize::Quench;
use crate::sample::Kernel;
use crate::topography::barrier::Connection;
use crate::topography::journal::{JournalError, Run};
use crate::topography::landscape::Landscape;
use crate::topography::minima::MatchTolerance;
use crate::topography::network::{Minimum, MinimumId};

use super::MapSettings;

/// What is added to a finished map.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Addition {
    /// Minima, some of which the map may have already.
    pub minima: Vec<Minimum>,
    /// Two minima of the map between which further searches are made.
    pub pair: Option<PairSearch>,
}

/// Independent searches between two minima, whatever was searched before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PairSearch {
    /// The numbers of the minima in the map to which they are added.
    pub minima: [MinimumId; 2],
    /// Number of searches, every other one of them from the second minimum to the first.
    pub searches: usize,
}

impl PairSearch {
    /// The usual number of searches: four times as many as the map makes across a merge at most.
    pub const USUAL: usize = 40;
}

/// Maps the surface between the minima of `earlier` and those of `addition`, and does only what is new.
///
/// A minimum that `earlier` has gets the members of its new copy. All others are connected as in
/// [`build_landscape`](super::build_landscape); pairs of two minima of `earlier` are left as they are. Members count the
/// input points of both. The searches of [`Addition::pair`] come last. They lower the height at which its minima merge if
/// they find a lower way, and the connection that decides this height is relaxed for longer if its evidence is a chain or
/// worse.
///
/// With k nearest neighbours, a near pair of two earlier minima was a near pair before, and new connections never raise a
/// barrier, so no pair is missed. The map differs from one made at once in three ways: chains have other random streams,
/// because minima have other numbers; pairs that new minima would have pushed out of the k nearest are kept; and minima that
/// only ripples divide are known by the lowest of them alone.
///
/// The settings should be those of `earlier`, and its minima are taken as they are: the energy must be the same.
/// [`Landscape::evaluations`] counts what was spent on the new connections.
///
/// # Errors
/// If the journal of `run` cannot store a record.
///
/// # Panics
/// If a minimum of the pair is not in `earlier`, or both are the same.
pub fn grow_landscape(
    energy: &dyn Energy,
    kernel: &dyn Kernel,
    earlier: &Landscape,
    addition: Addition,
    settings: &MapSettings,
    run: &Run<'_>,
) -> Result<Landscape, JournalError> {
    let (minima, rejected) = at_rest(energy, addition.minima, &settings.sameness);
    let start = Charted::onto(energy, earlier, (minima, addition.pair), &settings.sameness);
    let mapped = start.minima.clone();
    LandscapeBuilder::new((energy, kernel), &mapped, start, settings, run).map(rejected)
}

impl Charted {
    /// All that `earlier` knows, and what is added.
    pub(super) fn onto(
        energy: &dyn Energy,
        earlier: &Landscape,
        (minima, pair): (Vec<Minimum>, Option<PairSearch>),
        sameness: &MatchTolerance,
    ) -> Self {
        let space = energy.space();
        let mut all: Vec<(Minimum, Option<usize>)> = (earlier.network.node_weights().cloned())
            .enumerate()
            .map(|(number, minimum)| (minimum, Some(number)))
            .collect();
        let known = all.len();
        for minimum in minima {
            let (x, height) = (&minimum.coordinates, minimum.energy);
            // The earlier minima are sorted by energy.
            let first = all[..known].partition_point(|(m, _)| m.energy < height - sameness.energy);
            let mut near = all[first..known].iter_mut();
            if let Some((same, _)) = near.find(|(m, _)| sameness.holds(space, x, height, m)) {
                same.members.extend(minimum.members);
                same.members.sort_unstable();
                same.members.dedup();
            } else {
                all.push((minimum, None));
            }
        }
        all.sort_by(|(a, _), (b, _)| by_energy(a, b));
        let mut number = vec![0; known];
        for (new, (_, old)) in all.iter().enumerate() {
            if let Some(old) = old {
                number[*old] = new;
            }
        }
        let renumbered = |id: &mut MinimumId| id.0 = number[id.0];
        let (settled, minima) = (all.into_iter())
            .map(|(minimum, old)| (old.is_some(), minimum))
            .unzip();
        let mut start = Self {
            settled,
            pair: pair.map(|mut pair| {
                let [from, to] = pair.minima;
                assert_ne!(from, to, "searches need two different minima");
                pair.minima.iter_mut().for_each(renumbered);
                pair
            }),
            ..Self::new(minima)
        };
        for connection in &earlier.connections {
            if by_definition(connection) {
                continue;
            }
            let mut connection = connection.clone();
            renumbered(&mut connection.from);
            renumbered(&mut connection.to);
            let pair = (connection.from.0, connection.to.0);
            start.best.insert(pair, connection);
        }
        for attempt in &earlier.attempts.list {
            let mut attempt = attempt.clone();
            renumbered(&mut attempt.from);
            renumbered(&mut attempt.to);
            start.attempts.push(attempt);
        }
        let stray =
            |minimum: &Minimum| Quench::at_rest(minimum.coordinates.clone(), minimum.energy);
        let listed = |stray: &&Minimum| {
            let (x, height) = (&stray.coordinates, stray.energy);
            let mut all = start.minima.iter();
            all.any(|minimum| sameness.holds(space, x, height, minimum))
        };
        let strays = earlier.unlisted_minima.iter();
        let strays: Vec<_> = strays
            .filter(|minimum| !listed(minimum))
            .map(stray)
            .collect();
        start.unlisted_minima = strays;
        start
    }
}

/// Whether a connection was not found but set at the ceiling; see [`MapSettings::ceiling`].
fn by_definition(connection: &Connection) -> bool {
    connection.edge.height.is_finite() && connection.path.images.is_empty()
}
