//! Builds a landscape: selects the pairs to connect and connects them.

mod grow;
mod known;
mod pair;
mod rest;
mod rippled;
mod searches;
mod settings;
mod waypoints;

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;
use petgraph::unionfind::UnionFind;
use rayon::prelude::*;

use super::barrier::{Connection, Connector, Crossing, Pair, Start};
use super::families::Families;
use super::journal::{JournalError, Run};
use super::landscape::{Landscape, NoMinimum};
use super::minima::distinct;
use super::network::{Claim, Evidence, Minimum, MinimumId, Network};
use super::pairs::{BetweenMinima, Distances as _, bridges, candidates};
use super::ripples::{basins, between};
use super::support::{Attempt, Attempts};
use super::tree::{Tree, spanning_forest};
use super::{Phase, Tally};
use crate::energy::Energy;
use crate::optimize::Quench;
use crate::sample::Kernel;
pub use grow::{Addition, PairSearch, grow_landscape};
pub(super) use pair::search_between;
use rest::at_rest;
pub(super) use rest::by_energy;
pub use settings::MapSettings;
use waypoints::Waypoints;

/// Rounds that join separate components. What is apart after them stays apart.
const JOIN_ROUNDS: usize = 3;
/// Rounds that relax the connections that decide the tree for longer, each with twice the effort of the one before.
const RETRY_ROUNDS: usize = 2;

/// Maps the surface between `minima`.
///
/// Connects near pairs by straight lines, joins separate components, searches for lower ways across every merge of the tree by
/// independent attraction–diffusion chains, and relaxes the connections that decide the tree for longer if their evidence is
/// a chain or worse. Every pass found on the way becomes a connection of the two minima that its descents reach. A pair is
/// skipped if known passes already join it at the energy of its higher minimum. The result does not depend on the order of
/// `minima` (they are sorted), the number of threads, or interruptions.
///
/// Equal minima are merged with their members. Points that are no minima are listed in [`Landscape::rejected`].
///
/// # Errors
/// If the journal of `run` cannot store a record.
pub fn build_landscape(
    energy: &dyn Energy,
    kernel: &dyn Kernel,
    minima: Vec<Minimum>,
    settings: &MapSettings,
    run: &Run<'_>,
) -> Result<Landscape, JournalError> {
    let (minima, rejected) = at_rest(energy, minima, &settings.sameness);
    let start = Charted::new(minima);
    let mapped = start.minima.clone();
    LandscapeBuilder::new((energy, kernel), &mapped, start, settings, run).map(rejected)
}

/// What is known before a map is made.
struct Charted {
    /// Minima, lowest first.
    minima: Vec<Minimum>,
    /// Whether each minimum was in an earlier map. Pairs of two such minima are not connected again.
    settled: Vec<bool>,
    best: BTreeMap<(usize, usize), Connection>,
    attempts: Vec<Attempt>,
    unlisted_minima: Vec<Quench>,
    /// Two of the minima between which further searches are made, whatever is known.
    pair: Option<PairSearch>,
}

impl Charted {
    fn new(minima: Vec<Minimum>) -> Self {
        Self {
            settled: vec![false; minima.len()],
            minima,
            best: BTreeMap::new(),
            attempts: Vec::new(),
            unlisted_minima: Vec::new(),
            pair: None,
        }
    }
}

struct LandscapeBuilder<'a> {
    energy: &'a dyn Energy,
    kernel: &'a dyn Kernel,
    settings: &'a MapSettings,
    run: &'a Run<'a>,
    distances: BetweenMinima<'a>,
    minima: Vec<Minimum>,
    /// Whether each of the mapped minima was in an earlier map.
    settled: Vec<bool>,
    best: BTreeMap<(usize, usize), Connection>,
    tried: BTreeMap<(usize, usize), usize>,
    /// Ends of descents that are not known minima.
    unlisted_minima: Vec<Quench>,
    attempts: Vec<Attempt>,
    /// Number of the next search.
    searches: usize,
    /// Two of the minima between which further searches are made.
    pair: Option<PairSearch>,
    waypoints: Waypoints,
    /// The passes that the further searches crossed.
    crossed: Vec<Crossing>,
    /// Height of the lowest pass from one basin right into another.
    passes: BTreeMap<(usize, usize), f64>,
    /// The tree of the passes known so far, on a surface with ripples.
    known: Option<Tree>,
    evaluations: usize,
}

impl<'a> LandscapeBuilder<'a> {
    /// A builder that knows `start`, whose minima are `mapped`.
    fn new(
        (energy, kernel): (&'a dyn Energy, &'a dyn Kernel),
        mapped: &'a [Minimum],
        start: Charted,
        settings: &'a MapSettings,
        run: &'a Run<'a>,
    ) -> Self {
        Self {
            energy,
            kernel,
            settings,
            run,
            distances: BetweenMinima::new(energy.space(), mapped),
            minima: start.minima,
            settled: start.settled,
            tried: (start.attempts.iter())
                .map(|attempt| ((attempt.from.0, attempt.to.0), 1))
                .collect(),
            searches: next_search(&start.attempts),
            pair: start.pair,
            waypoints: Waypoints::default(),
            crossed: Vec::new(),
            passes: BTreeMap::new(),
            best: start.best,
            unlisted_minima: start.unlisted_minima,
            attempts: start.attempts,
            known: None,
            evaluations: 0,
        }
    }

    fn map(mut self, rejected: Vec<NoMinimum>) -> Result<Landscape, JournalError> {
        self.join_over_ripples()?;
        self.connect_neighbours()?;
        self.join_components()?;
        self.search()?;
        self.retry_upper_bounds()?;
        self.merge_over_ripples();
        self.join_at_the_ceiling();
        let (network, settings) = (self.network(), self.settings);
        let (mut unlisted_minima, _) = distinct(
            self.energy,
            &self.unlisted_minima,
            &settings.sameness,
            f64::INFINITY,
        );
        for stray in &mut unlisted_minima {
            stray.members.clear();
        }
        Ok(Landscape {
            rejected,
            unlisted_minima,
            attempts: Attempts {
                list: self.attempts,
                tolerance: settings.sameness.energy,
            },
            tree: Tree::from_network(&network, Evidence::Chain),
            families: Families::new(&network, &settings.families),
            network,
            connections: self.best.into_values().collect(),
            evaluations: self.evaluations,
        })
    }
}

impl LandscapeBuilder<'_> {
    /// Whether an earlier map has dealt with this pair.
    fn is_settled(&self, (i, j): (usize, usize)) -> bool {
        self.settled[i] && self.settled[j]
    }

    fn roughness(&self) -> f64 {
        self.settings.path.roughness
    }

    /// The lowest minimum of each minimum's basin; each its own on a surface without ripples.
    fn basins(&self) -> Vec<usize> {
        if self.roughness() > 0.0 {
            basins(&self.network(), self.roughness())
        } else {
            (0..self.minima.len()).collect()
        }
    }

    /// Whether a connection may be improved: if it is new, or if it decides at which height the two minima of further
    /// searches merge.
    fn may_improve(&self, network: &Network) -> impl Fn(&(usize, usize)) -> bool {
        let height = self.pair.and_then(|pair| {
            let [a, b] = pair.minima;
            Tree::from_network(network, Evidence::Chain).minimax(a, b)
        });
        let tolerance = self.settings.sameness.energy;
        move |pair| {
            let apart = height.map(|height| (self.best[pair].edge.height - height).abs());
            !self.is_settled(*pair) || apart.is_some_and(|apart| apart <= tolerance)
        }
    }

    /// The pairs that decide the tree of whole basins, and may be improved.
    fn decisive(&self, network: &Network) -> Vec<(usize, usize)> {
        let (basins, may_improve) = (self.basins(), self.may_improve(network));
        spanning_forest(network, Evidence::Chain)
            .into_iter()
            .filter_map(|edge| network.edge_endpoints(edge))
            .map(|(a, b)| (a.index().min(b.index()), a.index().max(b.index())))
            .filter(|(a, b)| basins[*a] != basins[*b] && may_improve(&(*a, *b)))
            .collect()
    }

    /// Connects `pairs` in parallel and adds the outcomes in order.
    fn connect(&mut self, pairs: &[(usize, usize)], tally: &Tally<'_>) -> Result<(), JournalError> {
        let found = self.each(pairs, tally, "pair", &|connector, pair| {
            connector.connect(self.energy, pair)
        })?;
        for pair in pairs {
            *self.tried.entry(*pair).or_insert(0) += 1;
        }
        self.take_all(found);
        Ok(())
    }

    /// Connects near pairs, except those that known passes already join at the energy of the higher minimum.
    fn connect_neighbours(&mut self) -> Result<(), JournalError> {
        let settings = self.settings;
        let mut pairs = if self.roughness() > 0.0 {
            between(&self.distances, &self.basins(), settings.neighbours)
        } else {
            candidates(&self.distances, settings.neighbours)
        };
        pairs.retain(|pair| !self.is_settled(*pair));
        let tally = self.run.tally(Phase::Connect, pairs.len());
        let mut known = Tree::from_network(&self.network(), Evidence::Path);
        for batch in growing(&pairs, settings.batch) {
            let open: Vec<_> = (batch.iter().copied())
                .filter(|pair| !(settings.pruned && self.joined_at_the_bottom(&known, *pair)))
                .collect();
            for _ in open.len()..batch.len() {
                tally.tick();
            }
            self.known = (self.roughness() > 0.0).then(|| known.clone());
            self.connect(&open, &tally)?;
            // Building the tree goes through all connections, so it is rebuilt only when it has changed and is needed.
            if settings.pruned && !open.is_empty() {
                known = Tree::from_network(&self.network(), Evidence::Path);
            }
        }
        self.known = None;
        Ok(())
    }

    /// Connects pairs of minima in separate components, each by its shortest untried link.
    fn join_components(&mut self) -> Result<(), JournalError> {
        for round in 0..JOIN_ROUNDS {
            let component = self.components();
            let pairs = bridges(&self.distances, &component, &|pair| {
                self.tried.contains_key(&pair) || self.is_settled(pair)
            });
            if pairs.is_empty() {
                break;
            }
            let tally = (self.run).tally_of_round(Phase::Join, (round, JOIN_ROUNDS), pairs.len());
            self.connect(&pairs, &tally)?;
        }
        Ok(())
    }

    /// Relaxes the connections that decide the tree for longer if their evidence is a chain or worse.
    fn retry_upper_bounds(&mut self) -> Result<(), JournalError> {
        for round in 0..RETRY_ROUNDS {
            let pairs = self.unsure();
            if pairs.is_empty() {
                break;
            }
            let tally = (self.run).tally_of_round(Phase::Retry, (round, RETRY_ROUNDS), pairs.len());
            for pair in &pairs {
                self.tried
                    .entry(*pair)
                    .and_modify(|tries| *tries = (*tries).max(1))
                    .or_insert(1);
            }
            let found = self.each(&pairs, &tally, "retry", &|connector, pair| {
                connector.improve(self.energy, pair, &self.best[&(pair.ids.0.0, pair.ids.1.0)])
            })?;
            for pair in &pairs {
                *self.tried.entry(*pair).or_insert(0) += 1;
            }
            self.take_all(found);
        }
        Ok(())
    }

    /// The pairs that decide the tree and whose evidence is a chain or worse, on a surface with ripples no verified pass.
    fn unsure(&self) -> Vec<(usize, usize)> {
        let network = self.network();
        if self.roughness() > 0.0 {
            let mut pairs = self.decisive(&network);
            pairs.retain(|pair| self.best[pair].edge.evidence > Evidence::Saddle);
            return pairs;
        }
        spanning_forest(&network, Evidence::Chain)
            .into_iter()
            .filter(|edge| network[*edge].evidence > Evidence::Path)
            .filter_map(|edge| network.edge_endpoints(edge))
            .map(|(a, b)| (a.index(), b.index()))
            .filter(self.may_improve(&network))
            .collect()
    }

    /// Runs `work` for each of `pairs` in parallel, and returns the results in their order. The journal stores them under
    /// `kind`.
    fn each(
        &self,
        pairs: &[(usize, usize)],
        tally: &Tally<'_>,
        kind: &str,
        work: &(dyn Fn(&Connector<'_>, Pair<'_>) -> Connection + Sync),
    ) -> Result<Vec<Connection>, JournalError> {
        let connector = self.connector();
        let attempt = |pair: &(usize, usize)| self.tried.get(pair).copied().unwrap_or(0);
        // Far pairs take longest. They are begun first, so that no thread waits for the last of them.
        let distance = |(i, j): (usize, usize)| self.distances.between(i, j);
        let places = pairs.par_iter().enumerate();
        let mut order: Vec<(f64, usize)> = places
            .map(|(place, pair)| (distance(*pair), place))
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        let found = self.run.each(
            tally,
            &order,
            |(_, place)| {
                let (i, j) = pairs[*place];
                format!("{kind}/{i}-{j}/{}", attempt(&(i, j)))
            },
            |(_, place)| {
                let (i, j) = pairs[*place];
                let pair = Pair {
                    ids: (MinimumId(i), MinimumId(j)),
                    minima: (&self.minima[i], &self.minima[j]),
                    attempt: attempt(&(i, j)),
                    known: self.known_height((i, j)),
                };
                work(&connector, pair)
            },
        )?;
        let places = order.into_iter().map(|(_, place)| place);
        let mut found: Vec<(usize, Connection)> = places.zip(found).collect();
        found.sort_unstable_by_key(|(place, _)| *place);
        Ok(found.into_iter().map(|(_, outcome)| outcome).collect())
    }

    fn connector(&self) -> Connector<'_> {
        Connector {
            path: &self.settings.path,
            quench: &self.settings.quench,
            sameness: &self.settings.sameness,
        }
    }

    fn known_height(&self, (i, j): (usize, usize)) -> f64 {
        let known = self.known.as_ref();
        let height = known.and_then(|tree| tree.minimax(MinimumId(i), MinimumId(j)));
        height.unwrap_or(f64::INFINITY)
    }

    fn network(&self) -> Network {
        let mut network = Network::default();
        for minimum in &self.minima {
            network.add_node(minimum.clone());
        }
        for ((i, j), connection) in &self.best {
            network.add_edge(
                NodeIndex::new(*i),
                NodeIndex::new(*j),
                connection.edge.clone(),
            );
        }
        network
    }

    fn components(&self) -> Vec<usize> {
        let mut sets = UnionFind::new(self.minima.len());
        for ((i, j), connection) in &self.best {
            if connection.edge.height.is_finite() {
                sets.union(*i, *j);
            }
        }
        sets.into_labeling()
    }

    /// Whether known passes already join a pair at the energy of its higher minimum, so that no path can be lower.
    fn joined_at_the_bottom(&self, known: &Tree, (i, j): (usize, usize)) -> bool {
        let bottom = self.minima[i].energy.max(self.minima[j].energy);
        known
            .minimax(MinimumId(i), MinimumId(j))
            .is_some_and(|height| height <= bottom + self.settings.sameness.energy)
    }
}

/// The number after the last search of `attempts`.
fn next_search(attempts: &[Attempt]) -> usize {
    let numbers = attempts.iter().map(|attempt| match attempt.start {
        Start::Chain { replica, .. } => replica + 1,
        Start::Straight | Start::Round => 0,
    });
    numbers.max().unwrap_or(0)
}

/// Batches of at least `least` pairs, and of a sixteenth of those before: what is known grows ever more slowly, and many
/// threads share a batch.
fn growing<T>(pairs: &[T], least: usize) -> impl Iterator<Item = &[T]> {
    let mut done = 0;
    std::iter::from_fn(move || {
        let size = least.max(1).max(done / 16).min(pairs.len() - done);
        let batch = &pairs[done..done + size];
        done += size;
        (size > 0).then_some(batch)
    })
}

pub(super) fn claim(connection: &Connection) -> Claim {
    Claim {
        invalid: connection.invalid_reason.is_some(),
        height: connection.edge.height,
        evidence: connection.edge.evidence,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_grow() {
        let pairs: Vec<usize> = (0..200).collect();
        let sizes = |least| growing(&pairs, least).map(<[_]>::len).collect::<Vec<_>>();
        assert_eq!(sizes(4)[..16], [4; 16]);
        assert_eq!(
            sizes(4)[16..],
            [
                4, 4, 4, 4, 5, 5, 5, 5, 6, 6, 7, 7, 7, 8, 8, 9, 9, 10, 11, 11, 1
            ]
        );
        assert_eq!(sizes(0).iter().sum::<usize>(), 200);
        assert_eq!(sizes(500), [200]);
        assert_eq!(growing(&pairs[..0], 16).count(), 0);
    }
}
