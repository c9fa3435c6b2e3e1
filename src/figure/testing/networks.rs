//! Synthetic landscapes.

use rand::RngExt;

use crate::sample::{Task, stream};
use crate::topography::{Edge, Evidence, Minimum, MinimumId, Network, Node, NodeId, Tree};

/// Random minima in a plane on an uneven floor. They are joined to near neighbours within each of `parts` parts.
pub(in crate::figure) fn random_network(seed: u64, count: usize, parts: usize) -> Network {
    let mut rng = stream(seed, Task::Start, 0);
    let mut minima: Vec<Minimum> = (0..count)
        .map(|index| {
            let coordinates: Vec<f64> = (0..2).map(|_| rng.random_range(-1.0..1.0)).collect();
            let floor = coordinates[0].powi(2) + 0.4 * libm::sin(5.0 * coordinates[1]);
            let energy = floor + 0.6 * rng.random::<f64>();
            // Few minima collect many members.
            let members = 30 / (1 + rng.random_range(0..60));
            Minimum {
                coordinates,
                energy,
                members: (0..members.max(1))
                    .map(|member| 31 * index + member)
                    .collect(),
            }
        })
        .collect();
    minima.sort_by(|a, b| a.energy.total_cmp(&b.energy));
    let mut network = Network::default();
    for minimum in minima.clone() {
        network.add_node(minimum);
    }
    // The last parts are single minima, and the others share the rest.
    let part = |index: usize| {
        if index + parts > count.max(parts) {
            index
        } else {
            count + index % parts.div_ceil(2)
        }
    };
    for a in 0..count {
        let distance = |b: usize| {
            let [p, q] = [a, b].map(|index| &minima[index].coordinates);
            libm::hypot(p[0] - q[0], p[1] - q[1])
        };
        let mut others: Vec<usize> = (0..count)
            .filter(|&b| b != a && part(a) == part(b))
            .collect();
        others.sort_by(|&b, &c| distance(b).total_cmp(&distance(c)));
        for &b in others.iter().take(5) {
            let barrier = 2.5 * distance(b) * (0.2 + rng.random::<f64>());
            let evidence = [
                Evidence::Saddle,
                Evidence::Path,
                Evidence::Path,
                Evidence::Saddle,
                Evidence::Chain,
            ];
            let edge = Edge {
                height: minima[a].energy.max(minima[b].energy) + barrier,
                evidence: evidence[rng.random_range(0..evidence.len())],
                term: None,
                length: distance(b),
            };
            network.add_edge(
                u32::try_from(a).expect("few").into(),
                u32::try_from(b).expect("few").into(),
                edge,
            );
        }
    }
    network
}

/// The tree by Kruskal's algorithm, with two branches per merge.
fn tree_of(network: &Network) -> Tree {
    let mut nodes: Vec<Node> = network
        .node_weights()
        .enumerate()
        .map(|(index, minimum)| {
            node(
                minimum.energy,
                Some(MinimumId(index)),
                Vec::new(),
                Evidence::Saddle,
            )
        })
        .collect();
    let mut edges: Vec<_> = network.raw_edges().iter().collect();
    edges.sort_by(|a, b| a.weight.height.total_cmp(&b.weight.height));
    let top = |nodes: &[Node], mut index: usize| {
        while let Some(parent) = nodes[index].parent {
            index = parent.0;
        }
        index
    };
    for edge in edges {
        let ends = [edge.source(), edge.target()].map(|end| top(&nodes, end.index()));
        if ends[0] != ends[1] {
            let merge = NodeId(nodes.len());
            for end in ends {
                nodes[end].parent = Some(merge);
            }
            nodes.push(node(
                edge.weight.height,
                None,
                ends.map(NodeId).to_vec(),
                edge.weight.evidence,
            ));
        }
    }
    with_roots(nodes)
}

pub(in crate::figure) fn random_tree(seed: u64, leaves: usize, parts: usize) -> Tree {
    tree_of(&random_network(seed, leaves, parts))
}

/// A forest of leaves with given energies and merges (height, numbers of the branches).
pub(in crate::figure) fn forest(energies: &[f64], merges: &[(f64, &[usize])]) -> Tree {
    let mut nodes: Vec<Node> = energies
        .iter()
        .enumerate()
        .map(|(index, &energy)| node(energy, Some(MinimumId(index)), Vec::new(), Evidence::Saddle))
        .collect();
    for &(height, children) in merges {
        let merge = NodeId(nodes.len());
        for &child in children {
            nodes[child].parent = Some(merge);
        }
        nodes.push(node(
            height,
            None,
            children.iter().copied().map(NodeId).collect(),
            Evidence::Saddle,
        ));
    }
    with_roots(nodes)
}

fn node(
    energy: f64,
    minimum: Option<MinimumId>,
    children: Vec<NodeId>,
    evidence: Evidence,
) -> Node {
    Node {
        energy,
        minimum,
        children,
        parent: None,
        evidence,
    }
}

fn with_roots(nodes: Vec<Node>) -> Tree {
    let roots = (0..nodes.len())
        .filter(|&index| nodes[index].parent.is_none())
        .map(NodeId)
        .collect();
    Tree { nodes, roots }
}

/// A random connected graph: a tree and `extra` more links.
pub(in crate::figure) fn random_links(
    seed: u64,
    count: usize,
    extra: usize,
) -> Vec<([usize; 2], f64)> {
    let mut rng = stream(seed, Task::Start, 1);
    let mut links: Vec<([usize; 2], f64)> = (1..count)
        .map(|node| ([rng.random_range(0..node), node], 0.1 + rng.random::<f64>()))
        .collect();
    for _ in 0..extra {
        let ends = [0, 1].map(|_| rng.random_range(0..count));
        if ends[0] != ends[1] {
            links.push((ends, 0.1 + rng.random::<f64>()));
        }
    }
    links
}
