//! The map as text that other programs read: Newick, DOT and JSON (trees), GraphML (graphs), JSON (everything).

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

    /// The evidence of that name.
    pub fn named(name: &str) -> Option<Self> {
        let all = [
            Self::Saddle,
            Self::Seam,
            Self::Path,
            Self::Chain,
            Self::None,
        ];
        all.into_iter().find(|evidence| evidence.name() == name)
    }
}

/// The tree in Newick form, one line a root: leaves by `name`, branches as long as the rise in energy.
///
/// Without `support` (none, or as many entries as nodes: [`support`](super::support())) merges are labelled by their height.
/// With it they are labelled by their support in percent, as programs that draw trees expect it, and the height is in a
/// comment, `[&energy=…]`.
pub fn newick(tree: &Tree, support: &[Option<f64>], name: impl Fn(MinimumId) -> String) -> String {
    let mut text = String::new();
    for root in &tree.roots {
        write_subtree(tree, *root, support, &name, &mut text);
        text.push_str(";\n");
    }
    text
}

fn write_subtree(
    tree: &Tree,
    id: NodeId,
    support: &[Option<f64>],
    name: &impl Fn(MinimumId) -> String,
    text: &mut String,
) {
    let node = &tree.nodes[id.0];
    for (k, child) in node.children.iter().enumerate() {
        text.push(if k == 0 { '(' } else { ',' });
        write_subtree(tree, *child, support, name, text);
    }
    if let Some(minimum) = node.minimum {
        // A quoted label may hold anything; a quote in it is doubled.
        let label = name(minimum).replace('\'', "''");
        write!(text, "'{label}'")
    } else if let Some(share) = of(support, id.0) {
        write!(text, "){}[&energy={}]", percent(share), node.energy)
    } else {
        write!(text, "){}", node.energy)
    }
    .expect("text grows without fail");
    if let Some(parent) = node.parent {
        write!(text, ":{}", tree.nodes[parent.0].energy - node.energy)
            .expect("text grows without fail");
    }
}

fn of(support: &[Option<f64>], node: usize) -> Option<f64> {
    support.get(node).copied().flatten()
}

/// Tenths of a percent are more than resamplings tell.
fn percent(share: f64) -> f64 {
    (1000.0 * share).round() / 10.0
}

/// The tree in the DOT language of Graphviz, leaves by `name` and merges by their height; each node has its `energy` as an
/// attribute, each merge its `evidence` and, where it is known, its `support` (a share; none, or as many entries as nodes).
/// Merges that rest on something worse than [`Evidence::Path`] are dashed.
pub fn dot(tree: &Tree, support: &[Option<f64>], name: impl Fn(MinimumId) -> String) -> String {
    let mut text = String::from("graph disconnectivity {\n  node [fontname=\"sans-serif\"];\n");
    for (id, node) in tree.nodes.iter().enumerate() {
        let energy = node.energy;
        let line = if let Some(minimum) = node.minimum {
            let label = quoted(&name(minimum));
            format!("  n{id} [label={label}, energy=\"{energy}\", shape=box];\n")
        } else {
            let evidence = node.evidence.name();
            let support = of(support, id);
            let support = support.map_or(String::new(), |share| format!("support=\"{share}\", "));
            format!(
                "  n{id} [label=\"{energy:.6}\", energy=\"{energy}\", evidence=\"{evidence}\", {support}shape=plaintext];\n"
            )
        };
        text.push_str(&line);
    }
    for (id, node) in tree.nodes.iter().enumerate() {
        let style = if node.evidence > Evidence::Path {
            " [style=dashed]"
        } else {
            ""
        };
        for child in &node.children {
            writeln!(text, "  n{id} -- n{}{style};", child.0).expect("text grows without fail");
        }
    }
    text.push_str("}\n");
    text
}

/// A quoted DOT identifier: only quotes need an escape; a backslash at the end would take the closing one.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// The tree as JSON: `roots`, and `nodes` of which each has `energy`, `minimum` (its number, `null` for a merge),
/// `children` and `parent` (numbers of nodes) and `evidence`; leaves also have a `name`, merges the number of `leaves`
/// below and their `support` (a share, `null` where it is not known; given none, or as many entries as nodes). It is read
/// back as a [`Tree`] by serde. Flat, for nested trees of many minima are too deep for most parsers.
pub fn tree_json(
    tree: &Tree,
    support: &[Option<f64>],
    name: impl Fn(MinimumId) -> String,
) -> Value {
    let mut leaves: Vec<usize> = Vec::with_capacity(tree.nodes.len());
    let nodes: Vec<Value> = (tree.nodes.iter().enumerate())
        .map(|(id, node)| {
            let mut object = json!({
                "energy": node.energy,
                "minimum": node.minimum,
                "children": node.children,
                "parent": node.parent,
                "evidence": node.evidence,
            });
            let below = node.children.iter().map(|child| leaves[child.0]).sum();
            if let Some(minimum) = node.minimum {
                object["name"] = json!(name(minimum));
                leaves.push(1);
            } else {
                object["leaves"] = json!(below);
                object["support"] = json!(of(support, id));
                leaves.push(below);
            }
            object
        })
        .collect();
    json!({ "nodes": nodes, "roots": tree.roots })
}

/// The network as GraphML: energy and number of members on nodes; height, relative barrier, evidence, term and length on
/// edges, and on those that make the tree the support of their merge (`support`: none, or one entry an edge). Pairs
/// never reached are left out: no edge means nothing.
pub fn graphml(
    network: &Network,
    support: &[Option<f64>],
    name: impl Fn(MinimumId) -> String,
) -> String {
    let keys = [
        ("node", "name", "string"),
        ("node", "energy", "double"),
        ("node", "members", "int"),
        ("edge", "height", "double"),
        ("edge", "barrier", "double"),
        ("edge", "evidence", "string"),
        ("edge", "term", "string"),
        ("edge", "length", "double"),
        ("edge", "support", "double"),
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
            of(support, edge.id().index())
                .map(|share| data("support", &share))
                .unwrap_or_default(),
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
        let text = newick(&tree, &[], |id| format!("m{}'", id.0));
        assert_eq!(text, "('m2''':3,('m0''':2,'m1''':1.5)2:2)4;\n");
    }

    #[test]
    fn dot_of_a_small_tree() {
        let mut tree = Tree::from_network(&example(), Evidence::Chain);
        tree.nodes[4].evidence = Evidence::Chain;
        let text = dot(&tree, &[], |id| format!("\"{}\\", id.0));
        assert!(
            text.contains(r#"n0 [label="\"0\\", energy="0", shape=box];"#),
            "{text}"
        );
        assert!(
            text.contains(
                r#"n3 [label="2.000000", energy="2", evidence="saddle", shape=plaintext];"#
            )
        );
        assert_eq!(text.matches(" -- ").count(), 4);
        assert!(text.contains("n4 -- n2 [style=dashed];"), "{text}");
        assert!(text.contains("n3 -- n0;"), "{text}");
    }

    #[test]
    fn json_is_read_back() {
        let tree = Tree::from_network(&example(), Evidence::Chain);
        let value = tree_json(&tree, &[], |id| format!("m{}", id.0));
        assert_eq!(value["nodes"][1]["name"], "m1");
        assert_eq!(value["nodes"][4]["leaves"], 3);
        let read: Tree = serde_json::from_str(&value.to_string()).unwrap();
        assert_eq!(read, tree);
    }

    #[test]
    fn graphml_escapes_names_and_omits_what_was_never_reached() {
        let text = graphml(&example(), &[], |id| format!("<{}>", id.0));
        assert!(text.contains("<data key=\"name\">&lt;0&gt;</data>"));
        assert_eq!(text.matches("<edge ").count(), 2);
        assert!(text.contains(
            "<edge source=\"m1\" target=\"m2\"><data key=\"height\">4</data><data key=\"barrier\">3</data><data key=\"evidence\">path</data>"
        ));
    }

    #[test]
    fn support_is_told_where_it_is_known() {
        let tree = Tree::from_network(&example(), Evidence::Chain);
        let support = [None, None, None, Some(0.955), Some(1.0)];
        let name = |id: MinimumId| format!("m{}", id.0);
        assert_eq!(
            newick(&tree, &support, name),
            "('m2':3,('m0':2,'m1':1.5)95.5[&energy=2]:2)100[&energy=4];\n"
        );
        let text = dot(&tree, &support, name);
        assert!(text.contains("evidence=\"saddle\", support=\"0.955\", shape"));
        let value = tree_json(&tree, &support, name);
        assert_eq!(value["nodes"][3]["support"], 0.955);
        assert_eq!(serde_json::from_value::<Tree>(value).unwrap(), tree);
        let text = graphml(&example(), &[Some(0.955), None, None], name);
        assert_eq!(
            text.matches("<data key=\"support\">0.955</data>").count(),
            1
        );
    }
}
