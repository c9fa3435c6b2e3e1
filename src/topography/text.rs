//! The map as text that other programs read: Newick (trees), GraphML (graphs), JSON.

use std::fmt::{Display, Write};

use petgraph::visit::EdgeRef;
use serde_json::{Value, json};

use super::map::Landscape;
use super::network::{Evidence, MinimumId, Network};
use super::tree::{NodeId, Tree};

impl Evidence {
    /// The lower-case name used in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Saddle => "saddle",
            Self::Seam => "seam",
            Self::Path => "path",
            Self::Chain => "chain",
            Self::None => "none",
        }
    }
}

/// The tree in Newick form, one line a root: leaves by `name`, merges by their height, branches as long as the rise in
/// energy.
pub fn newick(tree: &Tree, name: impl Fn(MinimumId) -> String) -> String {
    let mut text = String::new();
    for root in &tree.roots {
        write_subtree(tree, *root, &name, &mut text);
        text.push_str(";\n");
    }
    text
}

fn write_subtree(tree: &Tree, id: NodeId, name: &impl Fn(MinimumId) -> String, text: &mut String) {
    let node = &tree.nodes[id.0];
    for (k, child) in node.children.iter().enumerate() {
        text.push(if k == 0 { '(' } else { ',' });
        write_subtree(tree, *child, name, text);
    }
    if let Some(minimum) = node.minimum {
        // A quoted label may hold anything; a quote in it is doubled.
        let label = name(minimum).replace('\'', "''");
        write!(text, "'{label}'")
    } else {
        write!(text, "){}", node.energy)
    }
    .expect("text grows without fail");
    if let Some(parent) = node.parent {
        write!(text, ":{}", tree.nodes[parent.0].energy - node.energy)
            .expect("text grows without fail");
    }
}

/// The network as GraphML: energy and number of members on nodes; height, relative barrier, evidence, term and length on
/// edges. Pairs never reached are left out: no edge means nothing.
pub fn graphml(network: &Network, name: impl Fn(MinimumId) -> String) -> String {
    let keys = [
        ("node", "name", "string"),
        ("node", "energy", "double"),
        ("node", "members", "int"),
        ("edge", "height", "double"),
        ("edge", "barrier", "double"),
        ("edge", "evidence", "string"),
        ("edge", "term", "string"),
        ("edge", "length", "double"),
    ]
    .map(|(owner, key, kind)| {
        format!("  <key id=\"{key}\" for=\"{owner}\" attr.name=\"{key}\" attr.type=\"{kind}\"/>\n")
    });
    let nodes = network.node_weights().enumerate().map(|(i, minimum)| {
        let data = [
            data("name", &name(MinimumId(i))),
            data("energy", &minimum.energy),
            data("members", &minimum.members.len()),
        ];
        format!("    <node id=\"m{i}\">{}</node>\n", data.concat())
    });
    let reached = network
        .edge_references()
        .filter(|edge| edge.weight().height.is_finite());
    let edges = reached.map(|edge| {
        let (a, b, weight) = (edge.source(), edge.target(), edge.weight());
        let barrier = weight.height - network[a].energy.max(network[b].energy);
        let term = weight.term.as_ref().map(|term| data("term", term));
        let data = [
            data("height", &weight.height),
            data("barrier", &barrier),
            data("evidence", &weight.evidence.name()),
            term.unwrap_or_default(),
            data("length", &weight.length),
        ];
        let (a, b) = (a.index(), b.index());
        format!(
            "    <edge source=\"m{a}\" target=\"m{b}\">{}</edge>\n",
            data.concat()
        )
    });
    [
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(),
        "<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\n".to_owned(),
        keys.concat(),
        "  <graph edgedefault=\"undirected\">\n".to_owned(),
        nodes.collect(),
        edges.collect(),
        "  </graph>\n</graphml>\n".to_owned(),
    ]
    .concat()
}

fn data(key: &str, value: &dyn Display) -> String {
    format!("<data key=\"{key}\">{}</data>", escaped(&value.to_string()))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

impl Landscape {
    /// Minima, connections (without their paths), tree and groups as JSON; a height never found is `null`.
    pub fn to_json(&self) -> Value {
        let minima: Vec<Value> = self
            .network
            .node_weights()
            .map(|minimum| {
                json!({
                    "energy": minimum.energy,
                    "members": minimum.members,
                    "choice": minimum.choice,
                    "coordinates": minimum.coordinates,
                })
            })
            .collect();
        let connections: Vec<Value> = self
            .connections
            .iter()
            .map(|connection| {
                json!({
                    "from": connection.from,
                    "to": connection.to,
                    "height": connection.edge.height,
                    "evidence": connection.edge.evidence,
                    "term": connection.edge.term,
                    "length": connection.edge.length,
                    "chains_forward": connection.forward,
                    "chains_backward": connection.backward,
                    "start": connection.start,
                    "objection": connection.objection,
                    "evaluations": connection.evaluations,
                })
            })
            .collect();
        let evidence: serde_json::Map<String, Value> = self
            .tally()
            .into_iter()
            .map(|(evidence, count)| (evidence.name().to_owned(), json!(count)))
            .collect();
        json!({
            "minima": minima,
            "connections": connections,
            "tree": self.tree,
            "groups": self.groups,
            "evidence": evidence,
            "evaluations": self.evaluations,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::tree::tests::network;

    fn example() -> Network {
        network(
            &[0.0, 0.5, 1.0],
            &[
                (0, 1, 2.0, Evidence::Saddle),
                (1, 2, 4.0, Evidence::Path),
                (0, 2, f64::INFINITY, Evidence::None),
            ],
        )
    }

    #[test]
    fn newick_of_a_small_tree() {
        let tree = Tree::from_network(&example(), Evidence::Chain);
        let text = newick(&tree, |id| format!("m{}'", id.0));
        assert_eq!(text, "('m2''':3,('m0''':2,'m1''':1.5)2:2)4;\n");
    }

    #[test]
    fn graphml_escapes_names_and_omits_what_was_never_reached() {
        let text = graphml(&example(), |id| format!("<{}>", id.0));
        assert!(text.contains("<data key=\"name\">&lt;0&gt;</data>"));
        assert_eq!(text.matches("<edge ").count(), 2);
        assert!(text.contains(
            "<edge source=\"m1\" target=\"m2\"><data key=\"height\">4</data><data key=\"barrier\">3</data><data key=\"evidence\">path</data>"
        ));
    }
}
