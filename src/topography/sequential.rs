//! Sequential ADELM as published, which assigns minima one by one in order of arrival.
//!
//! M. Hill, E. Nijkamp and S.-C. Zhu, *Building a telescope to look into high-dimensional image spaces*, Quarterly of
//! Applied Mathematics 77, 269 (2019), arXiv:1803.01043.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Phase;
use super::adelm::{Chain, ChainSettings, chain};
use super::barrier::{Connection, Start};
use super::build::by_energy;
use super::families::Families;
use super::journal::{JournalError, Run, bits};
use super::landscape::Landscape;
use super::minima::MatchTolerance;
use super::network::{Edge, Evidence, Minimum, MinimumId, Network};
use super::path::Path;
use super::support::Attempts;
use super::tree::Tree;
use crate::energy::Energy;
use crate::optimize::QuenchSettings;
use crate::sample::{Kernel, Task, stream};
use crate::space::Space;

/// Settings of [`sequential`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SequentialSettings {
    /// Settings of the chains. Assignment uses the one temperature and force given here, which set the resolution of the
    /// map. Barriers between representatives use `attempts` forces, each `escalation` times the last, with `replicas`
    /// chains each.
    pub chain: ChainSettings,
    /// Settings of the descents at the ends of chains.
    pub quench: QuenchSettings,
    /// Tolerance within which two minima are the same.
    pub sameness: MatchTolerance,
    /// Whether to stop chains and skip pairs that can change neither families nor tree. A chain of the tree stage stops above
    /// the lowest known path between its ends, and any chain stops above the lowest chain of its pair. A pair is skipped if
    /// it is already joined at the energy of its higher minimum. Stopped chains count as not arrived.
    pub pruned: bool,
    /// Seed of all chains.
    pub seed: u64,
}

impl Default for SequentialSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl SequentialSettings {
    /// Settings for a surface whose typical barrier is `energy` high and `length` wide.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self {
            chain: ChainSettings::for_scales(energy, length),
            quench: QuenchSettings::for_scales(energy, length),
            sameness: MatchTolerance::for_scales(energy, length),
            pruned: true,
            seed: 0,
        }
    }
}

/// The outcome of [`sequential`].
#[derive(Debug, Clone)]
pub struct Sequential {
    /// Minima sorted by energy. The edges join each minimum to the representative it was assigned to (at that time) and
    /// representatives to each other. All are raw chains ([`Evidence::Chain`]).
    pub landscape: Landscape,
    /// Lowest member of each family, in the order of `landscape.families`.
    pub representatives: Vec<MinimumId>,
    /// Minima in their order of arrival.
    pub arrivals: Vec<MinimumId>,
}

/// Maps `minima`, given in order of arrival, by sequential ADELM.
///
/// *Burn-in.* Every new minimum exchanges one chain in each direction with the representative of each family. It joins the
/// family with the lowest barrier reached, and becomes its representative if it is lower. If no chain arrives, it founds a
/// new family. *Tree stage.* Every pair of representatives is joined by the lowest barrier of all chains of a schedule of
/// forces, in both directions.
///
/// The families depend on the order of arrival, on T and F, and on the seed, and barriers are only upper bounds.
/// [`build_landscape`](super::build_landscape) has none of these drawbacks; this function is for comparison with published
/// maps. It runs 2 L chains for each minimum, for L families, and up to L (L − 1) times the schedule at the end.
///
/// # Errors
/// If the journal of `run` cannot store a record.
pub fn sequential(
    energy: &dyn Energy,
    kernel: &dyn Kernel,
    minima: &[Minimum],
    settings: &SequentialSettings,
    run: &Run<'_>,
) -> Result<Sequential, JournalError> {
    let builder = SequentialBuilder {
        energy,
        kernel,
        minima,
        settings,
        run,
    };
    let mut known: BTreeMap<(usize, usize), Contact> = BTreeMap::new();
    let mut evaluations = 0;
    // Representative and members of each family.
    let mut families: Vec<(usize, Vec<usize>)> = Vec::new();
    let tally = run.tally(Phase::Assign, minima.len());
    for new in 0..minima.len() {
        let contacts: Vec<Contact> = families
            .par_iter()
            .map(|(representative, _)| {
                builder.contact(Stage::BurnIn, (*representative, new), f64::INFINITY)
            })
            .collect::<Result<_, _>>()?;
        evaluations += contacts
            .iter()
            .map(|found| found.evaluations)
            .sum::<usize>();
        let reached = contacts
            .iter()
            .enumerate()
            .filter(|(_, found)| found.reached());
        // Of equal barriers the first one, which is the older family.
        let nearest = reached.min_by(|a, b| a.1.barrier.total_cmp(&b.1.barrier));
        if let Some((family, contact)) = nearest {
            let (representative, members) = &mut families[family];
            known.insert((*representative, new), contact.clone());
            members.push(new);
            if minima[new].energy < minima[*representative].energy {
                *representative = new;
            }
        } else {
            families.push((new, vec![new]));
        }
        tally.tick();
    }
    let representatives: Vec<usize> = families
        .iter()
        .map(|(representative, _)| *representative)
        .collect();
    let pairs: Vec<(usize, usize)> = (0..representatives.len())
        .flat_map(|j| (0..j).map(move |i| (i, j)))
        .map(|(i, j)| (representatives[i], representatives[j]))
        .collect();
    let pairs = nearest_first(energy.space(), minima, pairs);
    evaluations += builder.tree_stage(&pairs, &mut known)?;
    Ok(builder.outcome(&families, known, evaluations))
}

/// Sorts pairs by distance. Near pairs have low passes, so joining them first lets more of the others be skipped.
fn nearest_first(
    space: &dyn Space,
    minima: &[Minimum],
    pairs: Vec<(usize, usize)>,
) -> Vec<(usize, usize)> {
    let mut pairs: Vec<(f64, (usize, usize))> = pairs
        .into_par_iter()
        .map(|(a, b)| {
            let distance = space.distance(&minima[a].coordinates, &minima[b].coordinates);
            (distance, (a, b))
        })
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    pairs.into_iter().map(|(_, pair)| pair).collect()
}

/// Pairs of the tree stage between two updates of the bounds. It affects the result, so it must not depend on threads.
const BATCH: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    BurnIn,
    Tree,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Contact {
    /// Lowest barrier; infinite if no chain arrived.
    #[serde(with = "bits::number")]
    barrier: f64,
    /// Path of that chain, from the first minimum.
    path: Path,
    start: Option<Start>,
    /// Barriers of the chains from the first minimum to the second.
    #[serde(with = "bits::options")]
    forward: Vec<Option<f64>>,
    #[serde(with = "bits::options")]
    backward: Vec<Option<f64>>,
    evaluations: usize,
}

impl Contact {
    fn reached(&self) -> bool {
        self.barrier.is_finite()
    }
}

struct SequentialBuilder<'a> {
    energy: &'a dyn Energy,
    kernel: &'a dyn Kernel,
    minima: &'a [Minimum],
    settings: &'a SequentialSettings,
    run: &'a Run<'a>,
}

impl SequentialBuilder<'_> {
    /// Joins `pairs` batch by batch and returns the evaluations spent.
    fn tree_stage(
        &self,
        pairs: &[(usize, usize)],
        known: &mut BTreeMap<(usize, usize), Contact>,
    ) -> Result<usize, JournalError> {
        let tally = self.run.tally(Phase::Connect, pairs.len());
        let mut evaluations = 0;
        for batch in pairs.chunks(BATCH) {
            let bounds = self.bounds(batch, known);
            let contacts: Vec<Option<Contact>> = (batch.par_iter())
                .zip(bounds)
                .map(|(pair, bound)| {
                    let contact = bound.map(|bound| self.contact(Stage::Tree, *pair, bound));
                    tally.tick();
                    contact.transpose()
                })
                .collect::<Result<_, _>>()?;
            for (pair, contact) in batch.iter().zip(contacts) {
                if let Some(contact) = contact {
                    evaluations += contact.evaluations;
                    known.insert(*pair, contact);
                }
            }
        }
        Ok(evaluations)
    }

    /// For each pair, the height above which a path between its ends is irrelevant; `None` if every path is.
    fn bounds(
        &self,
        pairs: &[(usize, usize)],
        known: &BTreeMap<(usize, usize), Contact>,
    ) -> Vec<Option<f64>> {
        if !self.settings.pruned {
            return vec![Some(f64::INFINITY); pairs.len()];
        }
        let mut network = Network::default();
        for minimum in self.minima {
            network.add_node(minimum.clone());
        }
        for ((a, b), contact) in known {
            let edge = Edge::bare(contact.barrier, Evidence::Chain);
            network.add_edge(NodeIndex::new(*a), NodeIndex::new(*b), edge);
        }
        let tree = Tree::from_network(&network, Evidence::Chain);
        let bound = |(a, b): &(usize, usize)| {
            let height = tree.minimax(MinimumId(*a), MinimumId(*b));
            let bottom = self.minima[*a].energy.max(self.minima[*b].energy);
            let height = height.unwrap_or(f64::INFINITY);
            (height > bottom + self.settings.sameness.energy).then_some(height)
        };
        pairs.iter().map(bound).collect()
    }

    /// Runs chains in both directions between two minima (by arrival). They stop above `bound`.
    fn contact(
        &self,
        stage: Stage,
        (a, b): (usize, usize),
        bound: f64,
    ) -> Result<Contact, JournalError> {
        let (kind, forces, replicas) = match stage {
            Stage::BurnIn => ("assign", 1, 1),
            Stage::Tree => (
                "representatives",
                self.settings.chain.attempts,
                self.settings.chain.replicas,
            ),
        };
        self.run.remember(&format!("{kind}/{a}-{b}"), || {
            let mut contact = Contact {
                barrier: f64::INFINITY,
                path: Path::default(),
                start: None,
                forward: Vec::new(),
                backward: Vec::new(),
                evaluations: 0,
            };
            for backward in [false, true] {
                let mut force = self.settings.chain.force;
                for step in 0..forces {
                    for replica in 0..replicas {
                        let number = step * replicas + replica;
                        let bound = if self.settings.pruned {
                            bound.min(contact.barrier)
                        } else {
                            f64::INFINITY
                        };
                        let found = self.chain(stage, (a, b), backward, (number, force), bound);
                        contact.add(found, backward, number);
                    }
                    force *= self.settings.chain.escalation;
                }
            }
            contact
        })
    }

    fn chain(
        &self,
        stage: Stage,
        (a, b): (usize, usize),
        backward: bool,
        (number, force): (usize, f64),
        bound: f64,
    ) -> Chain {
        // The stream number has 24 bits for a minimum and 14 bits for a chain in each direction.
        let id = [
            b,
            usize::from(stage == Stage::Tree),
            usize::from(backward),
            number,
        ]
        .into_iter()
        .zip([24, 1, 1, 14])
        .fold(a as u64, |id, (part, width)| (id << width) | part as u64);
        let mut rng = stream(self.settings.seed, Task::Sequential, id);
        let ends = (&self.minima[a], &self.minima[b]);
        chain(
            self.energy,
            self.kernel,
            if backward { (ends.1, ends.0) } else { ends },
            force,
            &self.settings.chain,
            (&self.settings.quench, &self.settings.sameness),
            bound,
            &mut rng,
        )
    }

    /// The network of the contacts, sorted by energy.
    fn outcome(
        &self,
        families: &[(usize, Vec<usize>)],
        known: BTreeMap<(usize, usize), Contact>,
        evaluations: usize,
    ) -> Sequential {
        let mut order: Vec<usize> = (0..self.minima.len()).collect();
        order.sort_by(|a, b| by_energy(&self.minima[*a], &self.minima[*b]).then(a.cmp(b)));
        let mut number = vec![0; order.len()];
        let mut network = Network::default();
        for (id, arrival) in order.iter().enumerate() {
            number[*arrival] = id;
            network.add_node(self.minima[*arrival].clone());
        }
        let mut connections: Vec<Connection> = known
            .into_iter()
            .map(|((a, b), contact)| self.connection((number[a], number[b]), (a, b), contact))
            .collect();
        connections.sort_by_key(|connection| (connection.from, connection.to));
        let mut barrier: f64 = 0.0;
        let mut family_of = vec![0; number.len()];
        for (family, (_, members)) in families.iter().enumerate() {
            for member in members {
                family_of[number[*member]] = family;
            }
        }
        for connection in &connections {
            let (from, to) = (connection.from.0, connection.to.0);
            let edge = connection.edge.clone();
            if family_of[from] == family_of[to] {
                // Minima are sorted by energy, so `to` is the higher one.
                let above = network[NodeIndex::new(to)].energy;
                barrier = barrier.max(edge.height - above);
            }
            network.add_edge(NodeIndex::new(from), NodeIndex::new(to), edge);
        }
        let mut members: Vec<Vec<MinimumId>> = families
            .iter()
            .map(|(_, members)| members.iter().map(|m| MinimumId(number[*m])).collect())
            .collect();
        for family in &mut members {
            family.sort_unstable();
        }
        members.sort_unstable();
        Sequential {
            representatives: members.iter().map(|family| family[0]).collect(),
            arrivals: number.into_iter().map(MinimumId).collect(),
            landscape: Landscape {
                tree: Tree::from_network(&network, Evidence::Chain),
                families: Families {
                    barrier,
                    members,
                    scan: Vec::new(),
                },
                network,
                connections,
                rejected: Vec::new(),
                unlisted_minima: Vec::new(),
                attempts: Attempts::default(),
                evaluations,
            },
        }
    }

    fn connection(
        &self,
        (one, other): (usize, usize),
        (a, b): (usize, usize),
        mut contact: Contact,
    ) -> Connection {
        let space = self.energy.space();
        if one > other {
            contact.path = contact.path.reversed();
            std::mem::swap(&mut contact.forward, &mut contact.backward);
            if let Some(Start::Chain { backward, .. }) = &mut contact.start {
                *backward = !*backward;
            }
        }
        contact.path.unfold(space);
        let top = contact.path.images.get(contact.path.top());
        let ends = (&self.minima[a], &self.minima[b]);
        let (evidence, length) = if contact.barrier.is_finite() {
            (Evidence::Chain, contact.path.length(space))
        } else {
            let [a, b] = [ends.0, ends.1].map(|end| &end.coordinates);
            (Evidence::None, space.distance(a, b))
        };
        let edge = Edge {
            term: top.and_then(|top| super::barrier::rising_term(self.energy, top, ends)),
            length,
            ..Edge::bare(contact.barrier, evidence)
        };
        let (from, to) = (MinimumId(one.min(other)), MinimumId(one.max(other)));
        Connection {
            invalid_reason: top.and_then(|top| self.energy.invalid_reason(top)),
            forward: contact.forward,
            backward: contact.backward,
            start: contact.start,
            evaluations: contact.evaluations,
            ..Connection::new(from, to, edge, contact.path)
        }
    }
}

impl Contact {
    fn add(&mut self, found: Chain, backward: bool, replica: usize) {
        self.evaluations += found.evaluations;
        let barrier = found.arrived.then_some(found.barrier);
        if backward {
            self.backward.push(barrier);
        } else {
            self.forward.push(barrier);
        }
        if barrier.is_some_and(|barrier| barrier < self.barrier) {
            self.barrier = found.barrier;
            self.start = Some(Start::Chain { backward, replica });
            self.path = if backward {
                found.path.reversed()
            } else {
                found.path
            };
        }
    }
}
