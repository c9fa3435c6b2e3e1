//! The map in text formats: Newick, DOT and JSON for trees, GraphML for graphs.

use std::fmt::{Display, Write};

use petgraph::visit::EdgeRef;
use serde::Serialize;

use super::network::{Evidence, MinimumId, Network};
use super::tree::{NodeId, Tree};
use crate::printable::printable;

impl Evidence {
    /// The lower-case name used in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Saddle => "saddle",
            Self::Given => "given",
            Self::Path => "path",
            Self::Chain => "chain",
            Self::None => "none",
        }
    }

    /// The evidence with the given name.
    pub fn named(name: &str) -> Option<Self> {
        let all = [
            Self::Saddle,
            Self::Given,
            Self::Path,
            Self::Chain,
            Self::None,
        ];
        all.into_iter().find(|evidence| evidence.name() == name)
    }
}

/// Writes the tree in Newick form, one line ended by `;` for each root. Leaves are labelled by `name` (any text), and the
/// length of a branch is its rise in energy.
///
/// If `support` is empty, merges are labelled by their height. Otherwise it has one entry for each node
/// ([`Searched::support`](super::Searched::support)), merges are labelled by their support in percent, as programs that draw trees expect,
/// and the height is in a comment, `[&energy=…]`.
pub fn newick(tree: &Tree, support: &[Option<f64>], name: impl Fn(MinimumId) -> String) -> String {
    let mut text = String::new();
    // An explicit stack, next item last, because trees may be deeper than the call stack allows.
    let mut rest: Vec<Scaled> = Vec::new();
    for root in &tree.roots {
        rest.push(Scaled::Separator(";\n"));
        rest.push(Scaled::Subtree(*root));
        while let Some(piece) = rest.pop() {
            match piece {
                Scaled::Separator(separator) => text.push_str(separator),
                Scaled::Subtree(id) if tree.nodes[id.0].minimum.is_none() => {
                    rest.push(Scaled::Label(id));
                    for (k, child) in tree.nodes[id.0].children.iter().enumerate().rev() {
                        rest.push(Scaled::Subtree(*child));
                        rest.push(Scaled::Separator(if k == 0 { "(" } else { "," }));
                    }
                }
                Scaled::Subtree(id) | Scaled::Label(id) => {
                    write_label(tree, id, support, &name, &mut text);
                }
            }
        }
    }
    text
}

enum Scaled {
    Separator(&'static str),
    Subtree(NodeId),
    /// The label of a subtree and the length of its branch.
    Label(NodeId),
}

fn write_label(
    tree: &Tree,
    id: NodeId,
    support: &[Option<f64>],
    name: &impl Fn(MinimumId) -> String,
    text: &mut String,
) {
    let node = &tree.nodes[id.0];
    if let Some(minimum) = node.minimum {
        // A quoted label may hold any text. Quotes in it are doubled.
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

/// Support in percent, rounded to tenths since resampling is no more precise.
fn percent(share: f64) -> f64 {
    (1000.0 * share).round() / 10.0
}

/// Writes the tree in the DOT language of Graphviz. Leaves are labelled by `name` and merges by their height. Each node has
/// its `energy` as an attribute; each merge has its `evidence` and, if known, its `support` (a fraction; `support` is empty
/// or has one entry for each node). Merges with weaker evidence than [`Evidence::Path`] are dashed.
pub fn dot(tree: &Tree, support: &[Option<f64>], name: impl Fn(MinimumId) -> String) -> String {
    let mut text = String::from("graph disconnectivity {\n  node [fontname=\"sans-serif\"];\n");
    for (id, node) in tree.nodes.iter().enumerate() {
        let energy = node.energy;
        let line = if let Some(minimum) = node.minimum {
            let label = quoted(&name(minimum));
            format!("  n{id} [label={label}, energy=\"{energy}\", shape=box];\n")
        } else {
            let evidence = node.evidence.name();
            // The label of a tiny negative height has no sign.
            let label = if energy.abs() < 5e-7 { 0.0 } else { energy };
            let support = of(support, id);
            let support = support.map_or(String::new(), |share| format!("support=\"{share}\", "));
            format!(
                "  n{id} [label=\"{label:.6}\", energy=\"{energy}\", evidence=\"{evidence}\", {support}shape=plaintext];\n"
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

/// A quoted DOT label. Quotes, backslashes and line breaks are escaped. Other control characters have no escape, and
/// Graphviz ends a text at a zero byte, so they are replaced by �.
fn quoted(text: &str) -> String {
    let text = text
        .replace('\\', "\\\\")
        .replace('"', "\\\"")
        .replace('\n', "\\n");
    format!("\"{}\"", printable(&text, &[]))
}

/// Writes the tree as the text of a JSON file with `roots` and `nodes`. Each node has `energy`, `minimum` (its number,
/// `null` for a merge), `children` and `parent` (node numbers) and `evidence`. Leaves also have a `name`; merges have the
/// number of `leaves` below and their `support` (a fraction, or `null` if unknown; `support` is empty or has one entry for
/// each node). Serde can read it back as a [`Tree`]. The list is flat, because deeply nested trees overflow most parsers.
pub fn tree_json(
    tree: &Tree,
    support: &[Option<f64>],
    name: impl Fn(MinimumId) -> String,
) -> String {
    let leaves_below = tree.leaves_below();
    let nodes = (tree.nodes.iter().enumerate())
        .map(|(id, node)| {
            let (children, energy, evidence) = (&node.children[..], node.energy, node.evidence);
            let (minimum, parent) = (node.minimum, node.parent);
            if let Some(leaf) = minimum {
                let name = name(leaf);
                JsonNode::Leaf {
                    children,
                    energy,
                    evidence,
                    minimum,
                    name,
                    parent,
                }
            } else {
                let (leaves, support) = (leaves_below[id], of(support, id));
                JsonNode::Merge {
                    children,
                    energy,
                    evidence,
                    leaves,
                    minimum,
                    parent,
                    support,
                }
            }
        })
        .collect();
    let roots = &tree.roots;
    pretty(&JsonTree { nodes, roots })
}

fn pretty(tree: &JsonTree<'_>) -> String {
    let mut text = serde_json::to_string_pretty(tree).expect("numbers and texts are JSON");
    text.push('\n');
    text
}

#[derive(Serialize)]
struct JsonTree<'a> {
    nodes: Vec<JsonNode<'a>>,
    roots: &'a [NodeId],
}

/// The fields are in alphabetical order.
#[derive(Serialize)]
#[serde(untagged)]
enum JsonNode<'a> {
    Leaf {
        children: &'a [NodeId],
        energy: f64,
        evidence: Evidence,
        minimum: Option<MinimumId>,
        name: String,
        parent: Option<NodeId>,
    },
    Merge {
        children: &'a [NodeId],
        energy: f64,
        evidence: Evidence,
        leaves: usize,
        minimum: Option<MinimumId>,
        parent: Option<NodeId>,
        support: Option<f64>,
    },
}

/// Writes the network as GraphML. Nodes have energy and number of members. Edges have height, relative barrier, evidence,
/// term and length, and edges of the tree have the support of their merge (`support` is empty or has one entry for each
/// edge). Pairs that were never connected are left out.
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

/// Escapes text of an XML element. XML 1.0 cannot hold most control characters, so they are replaced by �. Parsers read a
/// carriage return as a new line unless it is escaped.
fn escaped(text: &str) -> String {
    let held = |c: char| !matches!(c, '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}');
    text.replace(|c| !held(c), "\u{fffd}")
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\r', "&#13;")
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
}
