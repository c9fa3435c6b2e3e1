//! Builds a landscape: selects the pairs to connect and connects them.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;
use petgraph::unionfind::UnionFind;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::adelm::ChainSettings;
use super::barrier::{Connection, Connector, Effort, Pair};
use super::groups::{GroupSettings, Groups};
use super::journal::{JournalError, Run};
use super::landscape::{Landscape, NoMinimum};
use super::minima::{MatchTolerance, distinct};
use super::network::{Claim, Edge, Evidence, Minimum, MinimumId, Network};
use super::pairs::{bridges, candidates, distances};
use super::path::PathSettings;
use super::ripples::{Parts, basins, between, merged};
use super::scales::{Scales, median};
use super::support::{Trial, resample};
use super::tree::{Tree, spanning_forest};
use super::{Phase, Tally};
use crate::energy::Energy;
use crate::optimize::{Quench, QuenchSettings, StopReason};
use crate::sample::Kernel;
use crate::space::interpolate;
use crate::space::vector::norm;

/// Settings of [`build_landscape`]. [`MapSettings::for_scales`] sets all that have units from one energy and one length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MapSettings {
    /// Number of nearest minima to connect each minimum with. The minimum spanning tree of the distances is always added.
    pub neighbours: usize,
    /// Pairs connected between two updates of the skipping rule. It affects the result, so it must not depend on threads.
    pub batch: usize,
    /// Whether to skip pairs that known passes already join at the energy of the higher minimum, the lowest possible.
    pub pruned: bool,
    /// Rounds that join separate components, each by its shortest untried link.
    pub join_rounds: usize,
    /// Rounds that retry the connections that decide the tree if their evidence is a chain or worse.
    pub retry_rounds: usize,
    /// Least number of chains in each direction for the connections that decide the tree. Support is based on them.
    pub decisive_replicas: usize,
    /// Settings of the chains.
    pub chain: ChainSettings,
    /// Settings of the paths.
    pub path: PathSettings,
    /// Settings of the descents.
    pub quench: QuenchSettings,
    /// Tolerance within which two stationary points are the same.
    pub sameness: MatchTolerance,
    /// Settings of the groups.
    pub groups: GroupSettings,
    /// Height at which all minima are joined by definition, such as the cost of letting go. Higher connections get this
    /// height, and minima that no path joins are joined at it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ceiling: Option<f64>,
    /// Number of bootstrap resamplings for the support of merges.
    pub resamplings: usize,
    /// Seed of all chains.
    pub seed: u64,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl MapSettings {
    /// Settings for a surface whose typical barrier is `energy` high and `length` wide.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self {
            neighbours: 8,
            batch: 64,
            pruned: true,
            join_rounds: 3,
            retry_rounds: 2,
            decisive_replicas: 4,
            chain: ChainSettings::for_scales(energy, length),
            path: PathSettings::for_scales(energy, length),
            quench: QuenchSettings::for_scales(energy, length),
            sameness: MatchTolerance::for_scales(energy, length),
            groups: GroupSettings::default(),
            ceiling: None,
            resamplings: 200,
            seed: 0,
        }
    }

    /// Settings measured on the minima. The length is the median distance to the nearest other minimum, and the energy is
    /// the median of the finite barriers along the straight lines to it. If there is no other minimum or no such barrier,
    /// the [`Scales`] of the surface around the minima are used.
    ///
    /// One or two minima are too few to measure, and surfaces with walls (contact) need scales chosen by hand.
    pub fn for_minima(energy: &dyn Energy, minima: &[Minimum]) -> Self {
        let space = energy.space();
        let all = distances(space, minima);
        let (mut lengths, mut heights) = (Vec::new(), Vec::new());
        let mut gradient = vec![0.0; space.tangents()];
        for (i, row) in all.iter().enumerate() {
            // Distances to copies (0) and to invalid points (not finite) are ignored.
            let others = (0..minima.len()).filter(|j| row[*j] > 0.0 && row[*j].is_finite());
            let Some(j) = others.min_by(|a, b| row[*a].total_cmp(&row[*b])) else {
                continue;
            };
            lengths.push(row[j]);
            let (from, to) = (&minima[i], &minima[j]);
            let top = (1..16)
                .map(|k| {
                    let share = f64::from(k) / 16.0;
                    let x = interpolate(space, &from.coordinates, &to.coordinates, share);
                    energy.evaluate(&x, &mut gradient)
                })
                .fold(f64::NEG_INFINITY, f64::max);
            let height = top - from.energy.max(to.energy);
            if height.is_finite() && height > 0.0 {
                heights.push(height);
            }
        }
        let around = || {
            let points: Vec<_> = minima.iter().map(|m| m.coordinates.clone()).collect();
            Scales::measured(energy, &points)
        };
        Self::for_scales(
            median(heights).unwrap_or_else(|| around().energy),
            median(lengths).unwrap_or_else(|| around().length),
        )
    }
}

/// Maps the surface between `minima`.
///
/// Connects near pairs, joins separate components, and retries the connections that decide the tree if their evidence is a
/// chain or worse. Every pass found on the way becomes a connection of the two minima that its descents reach. A pair is
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
    let mut builder = LandscapeBuilder {
        energy,
        kernel,
        settings,
        run,
        distances: distances(energy.space(), &minima),
        minima,
        best: BTreeMap::new(),
        tried: BTreeMap::new(),
        unlisted_minima: Vec::new(),
        trials: BTreeMap::new(),
        known: None,
        evaluations: 0,
    };
    builder.join_over_ripples()?;
    builder.connect_neighbours()?;
    builder.join_components()?;
    builder.retry_upper_bounds()?;
    builder.replicate()?;
    builder.merge_over_ripples();
    builder.join_at_the_ceiling();
    let network = builder.network();
    let (mut unlisted_minima, _) = distinct(
        energy,
        &builder.unlisted_minima,
        &settings.sameness,
        f64::INFINITY,
    );
    for stray in &mut unlisted_minima {
        stray.members.clear();
    }
    Ok(Landscape {
        rejected,
        unlisted_minima,
        resampled: resample(
            &network,
            &builder.trials,
            settings.resamplings,
            settings.seed,
        ),
        tree: Tree::from_network(&network, Evidence::Chain),
        groups: Groups::new(&network, &settings.groups),
        network,
        connections: builder.best.into_values().collect(),
        evaluations: builder.evaluations,
    })
}

/// The distinct points of `minima` that are minima, sorted by energy, and the rejected points.
fn at_rest(
    energy: &dyn Energy,
    minima: Vec<Minimum>,
    sameness: &MatchTolerance,
) -> (Vec<Minimum>, Vec<NoMinimum>) {
    let space = energy.space();
    let examined: Vec<Result<Minimum, NoMinimum>> = minima
        .into_par_iter()
        .enumerate()
        .map(|(row, minimum)| moving(energy, &minimum, row, sameness).map_or(Ok(minimum), Err))
        .collect();
    let (mut sorted, mut rejected) = (Vec::new(), Vec::new());
    for minimum in examined {
        match minimum {
            Ok(minimum) => sorted.push(minimum),
            Err(refused) => rejected.push(refused),
        }
    }
    sorted.sort_by(by_energy);
    let mut distinct: Vec<Minimum> = Vec::with_capacity(sorted.len());
    for minimum in sorted {
        let first = distinct.partition_point(|m| m.energy < minimum.energy - sameness.energy);
        let (x, height) = (&minimum.coordinates, minimum.energy);
        let mut near = distinct[first..].iter_mut();
        if let Some(known) = near.find(|known| sameness.holds(space, x, height, known)) {
            known.members.extend(minimum.members);
            known.members.sort_unstable();
            known.members.dedup();
        } else {
            distinct.push(minimum);
        }
    }
    (distinct, rejected)
}

/// The rejection of the point in `row`, if it is not a minimum.
fn moving(
    energy: &dyn Energy,
    minimum: &Minimum,
    row: usize,
    sameness: &MatchTolerance,
) -> Option<NoMinimum> {
    let (space, x) = (energy.space(), &minimum.coordinates);
    let finite = x.len() == space.coordinates() && x.iter().all(|c| c.is_finite());
    if !finite {
        let gradient_norm = f64::NAN;
        return Some(NoMinimum { row, gradient_norm });
    }
    let mut gradient = vec![0.0; space.tangents()];
    let height = energy.evaluate(x, &mut gradient);
    let gradient_norm = norm(&gradient);
    // NaN values fail these comparisons too.
    let rests = (height - minimum.energy).abs() <= sameness.energy
        && gradient_norm * sameness.distance <= sameness.energy;
    (!rests).then_some(NoMinimum { row, gradient_norm })
}

pub(super) fn by_energy(a: &Minimum, b: &Minimum) -> std::cmp::Ordering {
    a.energy.total_cmp(&b.energy).then_with(|| {
        let coordinates = a.coordinates.iter().zip(&b.coordinates);
        let orders = coordinates.map(|(a, b)| a.total_cmp(b));
        orders.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    })
}

struct LandscapeBuilder<'a> {
    energy: &'a dyn Energy,
    kernel: &'a dyn Kernel,
    settings: &'a MapSettings,
    run: &'a Run<'a>,
    distances: Vec<Vec<f64>>,
    minima: Vec<Minimum>,
    best: BTreeMap<(usize, usize), Connection>,
    tried: BTreeMap<(usize, usize), usize>,
    /// Ends of descents that are not known minima.
    unlisted_minima: Vec<Quench>,
    trials: BTreeMap<(usize, usize), Trial>,
    /// The tree of the passes known so far, on a surface with ripples.
    known: Option<Tree>,
    evaluations: usize,
}

impl LandscapeBuilder<'_> {
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

    /// Finds near minima that only ripples divide, by strings of a few iterations.
    fn join_over_ripples(&mut self) -> Result<(), JournalError> {
        let settings = self.settings;
        if self.roughness() <= 0.0 {
            return Ok(());
        }
        let pairs = candidates(&self.distances, settings.neighbours);
        let tally = self.run.tally(Phase::Connect, pairs.len());
        for batch in pairs.chunks(settings.batch.max(1)) {
            let known = Tree::from_network(&self.network(), Evidence::Path);
            let open: Vec<_> = (batch.iter().copied())
                .filter(|pair| !self.joined_at_the_bottom(&known, *pair))
                .collect();
            let mut found = self.each(&open, &tally, "ripple", &|connector, pair| {
                connector.connect_roughly(self.energy, pair)
            })?;
            let spent = |connection: &Connection| connection.evaluations;
            self.evaluations += found.iter().map(spent).sum::<usize>();
            found.retain(|connection| connection.edge.evidence <= Evidence::Path);
            for connection in &mut found {
                // They are counted already.
                connection.evaluations = 0;
            }
            self.take_all(found);
        }
        Ok(())
    }

    /// Replaces minima that only ripples divide by the lowest of them.
    fn merge_over_ripples(&mut self) {
        if self.roughness() <= 0.0 {
            return;
        }
        let (network, basins) = (self.network(), self.basins());
        let parts = Parts {
            minima: std::mem::take(&mut self.minima),
            best: std::mem::take(&mut self.best),
            trials: std::mem::take(&mut self.trials),
        };
        let whole = merged(self.energy.space(), &network, parts, &basins);
        (self.minima, self.best, self.trials) = (whole.minima, whole.best, whole.trials);
    }

    /// Gives connections above the ceiling its height, and joins components that no path joins.
    fn join_at_the_ceiling(&mut self) {
        let Some(ceiling) = self.settings.ceiling else {
            return;
        };
        for connection in self.best.values_mut() {
            if connection.edge.height >= ceiling {
                connection.edge.height = ceiling;
                connection.edge.evidence = Evidence::Path;
            }
        }
        let component = self.components();
        // Minima are sorted by energy, so minimum 0 is the lowest of the first component.
        let apart: Vec<usize> = (1..component.len())
            .filter(|i| component[*i] != component[0] && !component[..*i].contains(&component[*i]))
            .collect();
        for i in apart {
            let ids = (MinimumId(0), MinimumId(i));
            let distance = (self.energy.space())
                .distance(&self.minima[0].coordinates, &self.minima[i].coordinates);
            self.best
                .insert((0, i), Connection::by_definition(ids, ceiling, distance));
        }
    }

    /// The pairs that decide the tree of whole basins.
    fn decisive(&self, network: &Network) -> Vec<(usize, usize)> {
        let basins = self.basins();
        spanning_forest(network, Evidence::Chain)
            .into_iter()
            .filter_map(|edge| network.edge_endpoints(edge))
            .map(|(a, b)| (a.index().min(b.index()), a.index().max(b.index())))
            .filter(|(a, b)| basins[*a] != basins[*b])
            .collect()
    }

    /// Connects `pairs` in parallel and adds the outcomes in order.
    fn connect(&mut self, pairs: &[(usize, usize)], tally: &Tally<'_>) -> Result<(), JournalError> {
        let found = self.each(pairs, tally, "pair", &|connector, pair| {
            connector.connect(self.energy, self.kernel, pair)
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
        let pairs = if self.roughness() > 0.0 {
            between(&self.distances, &self.basins(), settings.neighbours)
        } else {
            candidates(&self.distances, settings.neighbours)
        };
        let tally = self.run.tally(Phase::Connect, pairs.len());
        let mut known = Tree::from_network(&self.network(), Evidence::Path);
        for batch in pairs.chunks(settings.batch.max(1)) {
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

    /// Connects pairs of minima in separate components.
    fn join_components(&mut self) -> Result<(), JournalError> {
        for _ in 0..self.settings.join_rounds {
            let component = self.components();
            let pairs = bridges(&self.distances, &component, &|pair| {
                self.tried.contains_key(&pair)
            });
            if pairs.is_empty() {
                break;
            }
            let tally = self.run.tally(Phase::Join, pairs.len());
            self.connect(&pairs, &tally)?;
        }
        Ok(())
    }

    /// Retries the connections that decide the tree if their evidence is a chain or worse.
    fn retry_upper_bounds(&mut self) -> Result<(), JournalError> {
        for _ in 0..self.settings.retry_rounds {
            let pairs = self.unsure();
            if pairs.is_empty() {
                break;
            }
            let tally = self.run.tally(Phase::Retry, pairs.len());
            self.connect(&pairs, &tally)?;
        }
        Ok(())
    }

    /// The pairs that decide the tree and whose evidence is a chain or worse, on a surface with ripples no verified pass.
    fn unsure(&self) -> Vec<(usize, usize)> {
        let network = self.network();
        if self.roughness() > 0.0 {
            let mut pairs = self.decisive(&network);
            pairs.retain(|pair| self.best[pair].edge.evidence > Evidence::Seam);
            return pairs;
        }
        spanning_forest(&network, Evidence::Chain)
            .into_iter()
            .filter(|edge| network[*edge].evidence > Evidence::Path)
            .filter_map(|edge| network.edge_endpoints(edge))
            .map(|(a, b)| (a.index(), b.index()))
            .collect()
    }

    /// Runs more chains between the pairs that decide the tree. A chain is relaxed only if it is lower than the known path.
    fn replicate(&mut self) -> Result<(), JournalError> {
        let mut pairs = self.decisive(&self.network());
        pairs.retain(|pair| self.missing_replicas(*pair) > 0);
        if pairs.is_empty() {
            return Ok(());
        }
        let tally = self.run.tally(Phase::Replicate, pairs.len());
        let found = self.each(&pairs, &tally, "replicas", &|connector, pair| {
            let ends = (pair.ids.0.0, pair.ids.1.0);
            let known = self.best[&ends].edge.height;
            let replicas = self.missing_replicas(ends);
            connector.replicate(self.energy, self.kernel, pair, replicas, known)
        })?;
        self.take_all(found);
        Ok(())
    }

    /// Number of chains still to run in each direction of a decisive pair.
    fn missing_replicas(&self, pair: (usize, usize)) -> usize {
        let known = self.trials.get(&pair).map_or(0, Trial::replicas);
        self.settings.decisive_replicas.saturating_sub(known)
    }

    /// Runs `work` for each of `pairs` in parallel. The journal stores the results under `kind`.
    fn each(
        &self,
        pairs: &[(usize, usize)],
        tally: &Tally<'_>,
        kind: &str,
        work: &(dyn Fn(&Connector<'_>, Pair<'_>) -> Connection + Sync),
    ) -> Result<Vec<Connection>, JournalError> {
        let connector = Connector {
            chain: &self.settings.chain,
            path: &self.settings.path,
            quench: &self.settings.quench,
            sameness: &self.settings.sameness,
        };
        let one = |(i, j): &(usize, usize)| {
            let attempt = self.tried.get(&(*i, *j)).copied().unwrap_or(0);
            let connection = self.run.remember(&format!("{kind}/{i}-{j}/{attempt}"), || {
                let pair = Pair {
                    ids: (MinimumId(*i), MinimumId(*j)),
                    minima: (&self.minima[*i], &self.minima[*j]),
                    effort: Effort {
                        attempt,
                        seed: self.settings.seed,
                    },
                    known: self.known_height((*i, *j)),
                };
                work(&connector, pair)
            });
            tally.tick();
            connection
        };
        // One task for each pair, because pairs take different times and threads cannot share a task.
        pairs.par_iter().with_max_len(1).map(one).collect()
    }

    fn known_height(&self, (i, j): (usize, usize)) -> f64 {
        let known = self.known.as_ref();
        let height = known.and_then(|tree| tree.minimax(MinimumId(i), MinimumId(j)));
        height.unwrap_or(f64::INFINITY)
    }

    /// Adds connections and the passes found on their paths, in order.
    fn take_all(&mut self, found: Vec<Connection>) {
        let side_connections: Vec<Vec<Connection>> = found
            .par_iter()
            .with_max_len(1)
            .map(|connection| self.side_connections(connection))
            .collect();
        for (connection, side_connections) in found.into_iter().zip(&side_connections) {
            let pair = (connection.from.0, connection.to.0);
            let trial = self.trials.entry(pair).or_default();
            trial.add(&connection, side_connections);
            self.evaluations += connection.evaluations;
            self.collect_unlisted_minima(&connection);
            self.take(connection);
        }
        for connection in side_connections.into_iter().flatten() {
            self.take(connection);
        }
    }

    /// The passes of a connection as connections of the known minima they join.
    fn side_connections(&self, connection: &Connection) -> Vec<Connection> {
        let mut side_connections = Vec::new();
        for crossing in &connection.crossings {
            let (path, last) = (&crossing.path, crossing.path.images.len() - 1);
            let find = |k: usize| self.find(&path.images[k], path.energies[k]);
            let (Some(a), Some(b)) = (find(0), find(last)) else {
                continue;
            };
            if a == b || (a.min(b), a.max(b)) == (connection.from.0, connection.to.0) {
                continue;
            }
            let top = &path.images[crossing.pass];
            let invalid_reason = self.energy.invalid_reason(top);
            let evidence = match invalid_reason {
                Some(_) => Evidence::Chain,
                None => crossing.evidence,
            };
            let mut path = path.clone();
            if a > b {
                path = path.reversed();
            }
            path.unfold(self.energy.space());
            side_connections.push(Connection {
                from: MinimumId(a.min(b)),
                to: MinimumId(a.max(b)),
                edge: Edge {
                    height: crossing.path.energies[crossing.pass],
                    evidence,
                    term: super::barrier::rising_term(
                        self.energy,
                        top,
                        (&self.minima[a], &self.minima[b]),
                    ),
                    length: path.length(self.energy.space()),
                },
                path,
                forward: Vec::new(),
                backward: Vec::new(),
                start: None,
                straight: f64::INFINITY,
                invalid_reason,
                crossings: vec![crossing.clone()],
                evaluations: 0,
            });
        }
        side_connections
    }

    fn collect_unlisted_minima(&mut self, connection: &Connection) {
        for path in connection.crossings.iter().map(|crossing| &crossing.path) {
            for end in [0, path.images.len() - 1] {
                let (x, energy) = (&path.images[end], path.energies[end]);
                if self.find(x, energy).is_none() {
                    self.unlisted_minima.push(Quench {
                        x: x.clone(),
                        energy,
                        gradient_norm: 0.0,
                        evaluations: 0,
                        stop: StopReason::Converged,
                    });
                }
            }
        }
    }

    fn find(&self, x: &[f64], energy: f64) -> Option<usize> {
        let tolerance = self.settings.sameness.energy;
        let first = self
            .minima
            .partition_point(|m| m.energy < energy - tolerance);
        (first..self.minima.len())
            .take_while(|i| self.minima[*i].energy <= energy + tolerance)
            .find(|i| {
                self.settings
                    .sameness
                    .holds(self.energy.space(), x, energy, &self.minima[*i])
            })
    }

    /// Keeps the better of this connection and the known one, with the raw barriers of both.
    fn take(&mut self, new: Connection) {
        let pair = (new.from.0, new.to.0);
        let Some(known) = self.best.get_mut(&pair) else {
            self.best.insert(pair, new);
            return;
        };
        let floor = self.minima[pair.0].energy.max(self.minima[pair.1].energy);
        let tie = self.settings.sameness.energy;
        let slack = self.settings.path.height_tolerance * (known.edge.height - floor) + tie;
        let (mut better, mut other) = if claim(&new).beats(claim(known), tie, slack) {
            (new, known.clone())
        } else {
            (known.clone(), new)
        };
        // Raw barriers record all chains, whichever path was kept.
        better.forward.append(&mut other.forward);
        better.backward.append(&mut other.backward);
        better.evaluations += other.evaluations;
        *known = better;
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

pub(super) fn claim(connection: &Connection) -> Claim {
    Claim {
        invalid: connection.invalid_reason.is_some(),
        height: connection.edge.height,
        evidence: connection.edge.evidence,
    }
}
