//! The fastest pathways between two sets of states.

use std::collections::BTreeSet;

use petgraph::algo::{astar, dijkstra};
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::{EdgeFiltered, EdgeRef, Reversed};

use super::log_sum;
use super::rates::RateNetwork;

/// A sequence of states from a source to a target, and its part in the rate between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Pathway {
    /// The states, from source to target.
    pub states: Vec<usize>,
    /// ln of the rate of direct passages along this sequence: share of the source within the sources, times its first rate,
    /// times the branching probabilities of the states between. Passages that step back and forth are not counted.
    pub log_rate: f64,
}

impl RateNetwork {
    /// The pathways without loops that carry the greatest rates of direct passage, fastest first, at most `count`.
    ///
    /// The best pathway is a shortest path for the costs −ln P, P = kᵢⱼ/Σⱼ kᵢⱼ (D. A. Evans and D. J. Wales, J. Chem. Phys.
    /// 121, 1080 (2004)); the next ones follow by the algorithm of J. Y. Yen, Manage. Sci. 17, 712 (1971). A pathway meets
    /// sources and targets only at its ends.
    ///
    /// # Panics
    /// If a state does not exist.
    pub fn fastest_pathways(
        &self,
        sources: &[usize],
        targets: &[usize],
        count: usize,
    ) -> Vec<Pathway> {
        let costs = Costs::new(self, sources, targets);
        let mut found: Vec<(f64, Vec<usize>)> = Vec::new();
        let mut candidates: BTreeSet<Candidate> = BTreeSet::new();
        candidates.extend(costs.best(&[], &BTreeSet::new()));
        while found.len() < count
            && let Some(Candidate { cost, nodes }) = candidates.pop_first()
        {
            // Every later pathway leaves this one at some node.
            for length in 1..nodes.len() {
                let root = &nodes[..length];
                let taken = found.iter().map(|(_, nodes)| nodes).chain([&nodes]);
                let closed = taken
                    .filter(|known| known.len() > length && known[..length] == *root)
                    .map(|known| [known[length - 1], known[length]])
                    .collect();
                candidates.extend(costs.best(root, &closed));
            }
            found.push((cost, nodes));
        }
        let pathway = |(cost, nodes): (f64, Vec<usize>)| Pathway {
            states: nodes[1..nodes.len() - 1].to_vec(),
            log_rate: -(cost - costs.shift),
        };
        found.into_iter().map(pathway).collect()
    }
}

/// A pathway that may be the next best; ordered by cost, then by its nodes.
#[derive(Debug, Clone, PartialEq)]
struct Candidate {
    cost: f64,
    nodes: Vec<usize>,
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let costs = self.cost.total_cmp(&other.cost);
        costs.then_with(|| self.nodes.cmp(&other.nodes))
    }
}

/// The graph of the states, between a node before all sources and a node behind all targets, with costs that are not
/// negative.
struct Costs {
    graph: DiGraph<(), f64>,
    first: usize,
    last: usize,
    /// What was added to the cost of every pathway.
    shift: f64,
    /// Least cost from each node to the last one, infinite if no way leads there. Closed edges only make ways longer, so that
    /// searches are led by it.
    to_go: Vec<f64>,
}

impl Costs {
    fn new(network: &RateNetwork, sources: &[usize], targets: &[usize]) -> Self {
        let count = network.states();
        let [is_source, is_target] = [sources, targets].map(|set| {
            let mut marked = vec![false; count];
            for state in set {
                marked[*state] = true;
            }
            marked
        });
        let mut graph = DiGraph::new();
        for _ in 0..count + 2 {
            graph.add_node(());
        }
        let (first, last) = (count, count + 1);
        let exits: Vec<f64> = (network.rates.iter())
            .map(|rates| log_sum(rates.values().copied()))
            .collect();
        // The first transition counts with its rate and not with its probability. These costs may have any sign, so a
        // constant is added to all of them; each pathway has exactly one.
        let shares = network.log_shares(sources);
        let starts = || {
            sources
                .iter()
                .zip(&shares)
                .map(|(b, share)| share + exits[*b])
        };
        let shift = starts().fold(0.0, f64::max);
        for (source, start) in sources.iter().zip(starts()) {
            if start > f64::NEG_INFINITY {
                graph.add_edge(
                    NodeIndex::new(first),
                    NodeIndex::new(*source),
                    shift - start,
                );
            }
        }
        for target in targets {
            graph.add_edge(NodeIndex::new(*target), NodeIndex::new(last), 0.0);
        }
        for (from, rates) in network.rates.iter().enumerate() {
            if is_target[from] {
                continue;
            }
            for (to, rate) in rates {
                if !is_source[*to] {
                    let cost = (exits[from] - rate).max(0.0);
                    graph.add_edge(NodeIndex::new(from), NodeIndex::new(*to), cost);
                }
            }
        }
        let ways = dijkstra(Reversed(&graph), NodeIndex::new(last), None, |edge| {
            *edge.weight()
        });
        let cost = |node: usize| ways.get(&NodeIndex::new(node)).copied();
        Self {
            to_go: (0..count + 2)
                .map(|node| cost(node).unwrap_or(f64::INFINITY))
                .collect(),
            graph,
            first,
            last,
            shift,
        }
    }

    /// The cheapest pathway that begins with `root` and takes none of the `closed` edges from its end.
    fn best(&self, root: &[usize], closed: &BTreeSet<[usize; 2]>) -> Option<Candidate> {
        let start = root.last().copied().unwrap_or(self.first);
        let before = &root[..root.len().saturating_sub(1)];
        let open = EdgeFiltered::from_fn(&self.graph, |edge| {
            let [from, to] = [edge.source().index(), edge.target().index()];
            self.to_go[to].is_finite() && !before.contains(&to) && !closed.contains(&[from, to])
        });
        let (_, nodes) = astar(
            &open,
            NodeIndex::new(start),
            |node| node.index() == self.last,
            |edge| *edge.weight(),
            |node| self.to_go[node.index()],
        )?;
        let mut all: Vec<usize> = before.to_vec();
        all.extend(nodes.iter().map(|node| node.index()));
        let steps = all.windows(2).map(|pair| {
            let [from, to] = [pair[0], pair[1]].map(NodeIndex::new);
            let edge = self.graph.find_edge(from, to)?;
            Some(self.graph[edge])
        });
        Some(Candidate {
            cost: steps.sum::<Option<f64>>()?,
            nodes: all,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All pathways without loops, by search through all of them.
    fn all_pathways(network: &RateNetwork, sources: &[usize], targets: &[usize]) -> Vec<Pathway> {
        let shares = network.log_shares(sources);
        let mut found = Vec::new();
        let mut stack: Vec<(Vec<usize>, f64)> = sources
            .iter()
            .zip(&shares)
            .map(|(source, share)| {
                let exit = log_sum(network.rates[*source].values().copied());
                (vec![*source], share + exit)
            })
            .collect();
        while let Some((states, log_rate)) = stack.pop() {
            let last = states[states.len() - 1];
            if targets.contains(&last) {
                found.push(Pathway { states, log_rate });
                continue;
            }
            let exit = log_sum(network.rates[last].values().copied());
            for (next, rate) in &network.rates[last] {
                if !states.contains(next) && !sources.contains(next) {
                    let mut longer = states.clone();
                    longer.push(*next);
                    stack.push((longer, log_rate + rate - exit));
                }
            }
        }
        found.sort_by(|a, b| b.log_rate.total_cmp(&a.log_rate));
        found
    }

    #[test]
    fn pathways_are_ranked_as_by_complete_search() {
        let log_rates: Vec<(usize, usize, f64)> = (0..7)
            .flat_map(|a| (0..7).map(move |b| (a, b)))
            .filter(|(a, b)| a != b && (a * 3 + b * 5) % 4 != 0)
            .map(|(a, b)| (a, b, libm::sin((a * 31 + b * 17) as f64) * 20.0))
            .collect();
        let weights = [0.0, 1.0, 2.0, -1.0, 0.5, 3.0, 0.0];
        let network = RateNetwork::from_log_rates(7, &log_rates, &weights);
        let (sources, targets) = ([0, 1], [5, 6]);
        let all = all_pathways(&network, &sources, &targets);
        let ours = network.fastest_pathways(&sources, &targets, 12);
        assert_eq!(ours.len(), 12);
        for (one, other) in ours.iter().zip(&all) {
            assert_eq!(one.states, other.states);
            approx::assert_relative_eq!(one.log_rate, other.log_rate, max_relative = 1e-9);
        }
        let every = network.fastest_pathways(&sources, &targets, 10 * all.len());
        assert_eq!(every.len(), all.len());
        assert!(
            network
                .fastest_pathways(&[5], &[0], 3)
                .iter()
                .all(|p| p.states[0] == 5)
        );
    }

    #[test]
    fn no_way_is_no_pathway() {
        let network = RateNetwork::from_log_rates(3, &[(0, 1, 0.0)], &[0.0; 3]);
        assert!(network.fastest_pathways(&[0], &[2], 3).is_empty());
        let [one] = &network.fastest_pathways(&[0], &[1], 3)[..] else {
            panic!()
        };
        assert_eq!(
            (one.states.as_slice(), one.log_rate),
            ([0, 1].as_slice(), 0.0)
        );
    }
}
