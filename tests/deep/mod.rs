//! Trees of any depth and shape are read, written, laid out, viewed and compared with a bounded stack.

use std::io::Write as _;

use landscape::figure::layout::{collapse, place};
use landscape::space::Euclidean;
use landscape::topography::view::{Levels, View, bottoms, network_of_families, restricted};
use landscape::topography::{
    Ancestors, Edge, Evidence, MatchTolerance, MergeChange, Minimum, MinimumId, Network, Tree,
    TreeDifference, dot, graphml, newick, spanning_forest, tree_json,
};
use rand::RngExt;

use crate::desk::Desk;

/// A network of `count` minima in ascending order of energy.
fn network(count: usize, links: impl Iterator<Item = (usize, usize, f64)>) -> Network {
    let mut network = Network::with_capacity(count, 2 * count);
    for row in 0..count {
        network.add_node(Minimum {
            coordinates: vec![row as f64],
            energy: row as f64 / count as f64,
            members: vec![row],
        });
    }
    for (a, b, height) in links {
        let edge = Edge {
            height,
            evidence: Evidence::Saddle,
            term: None,
            length: 1.0,
        };
        let [a, b] = [a, b].map(|end| u32::try_from(end).unwrap().into());
        network.add_edge(a, b, edge);
    }
    network
}

/// Every minimum joins all earlier ones, at its own height.
fn comb(count: usize) -> Network {
    let step = move |k: usize| 1.0 + k as f64 / count as f64;
    network(count, (1..count).map(move |k| (k - 1, k, step(k))))
}

/// The comb with its deep branch first among the children, because the highest numbers join first.
fn reversed_comb(count: usize) -> Network {
    let step = move |k: usize| 2.0 - k as f64 / count as f64;
    network(count, (1..count).map(move |k| (k - 1, k, step(k))))
}

/// All minima join at one height.
fn star(count: usize) -> Network {
    network(count, (1..count).map(|k| (0, k, 2.0)))
}

/// Pairs join at one height, and the pairs at another.
fn pairs(count: usize) -> Network {
    let height = |k: usize| if k % 2 == 1 { 2.0 } else { 3.0 };
    network(count, (1..count).map(move |k| (k - 1, k, height(k))))
}

/// Every minimum joins some earlier one, and some join any other.
fn random(count: usize) -> Network {
    let mut rng = landscape::sample::stream(1, landscape::sample::Task::Start, 0);
    let mut links = Vec::new();
    for k in 1..count {
        links.push((rng.random_range(0..k), k, 1.0 + rng.random::<f64>()));
        links.push((rng.random_range(0..count), k, 1.0 + rng.random::<f64>()));
    }
    network(count, links.into_iter())
}

/// Calls all functions that use a tree.
fn exercise(network: &Network) {
    let count = network.node_count();
    let tree = Tree::from_network(network, Evidence::Chain);
    assert_eq!(tree.roots.len(), 1);
    let name = |id: MinimumId| format!("m{}", id.0);
    let merges = tree.nodes.iter().map(|node| !node.children.is_empty());
    let known: Vec<Option<f64>> = merges.map(|merge| merge.then_some(1.0)).collect();

    let text = newick(&tree, &known, name);
    assert_eq!(text.matches("'m").count(), count);
    assert_eq!(text.matches('(').count(), text.matches(')').count());
    assert_eq!(
        dot(&tree, &known, name).matches(" -- ").count(),
        tree.nodes.len() - 1
    );
    let text = tree_json(&tree, &known, name);
    assert_eq!(serde_json::from_str::<Tree>(&text).unwrap(), tree);
    assert_eq!(graphml(network, &[], name).matches("<node ").count(), count);

    let layout = place(&tree);
    assert_eq!(
        (layout.leaves.len(), layout.width),
        (count, (count - 1) as f64)
    );
    let ancestors = Ancestors::of(&tree);
    for edge in spanning_forest(network, Evidence::Chain) {
        let (a, b) = network.edge_endpoints(edge).unwrap();
        let joint = ancestors.joint(MinimumId(a.index()), MinimumId(b.index()));
        let height = tree.nodes[joint.unwrap().0].energy;
        // Links that tie make one merge, at the highest of their heights.
        assert!(height >= network[edge].height && height <= network[edge].height + 1e-7);
    }

    // Compared with itself and with a comb.
    let minima: Vec<Minimum> = network.node_weights().cloned().collect();
    let compare = |other: &Tree| {
        let sides = [(&minima[..], &tree), (&minima[..], other)];
        let reach = MatchTolerance {
            energy: 0.0,
            distance: 0.4,
        };
        TreeDifference::between(&Euclidean::new(1), sides[0], sides[1], &reach).unwrap()
    };
    let same = compare(&tree);
    assert_eq!((same.matches.len(), same.merges.len()), (count, count - 1));
    let unchanged = |merge: &MergeChange| merge.after == Some(merge.before);
    assert!(same.merges.iter().all(unchanged));
    let other = compare(&Tree::from_network(&comb(count), Evidence::Chain));
    assert_eq!(other.merges.len(), count - 1);
    assert!(other.merges.iter().all(|merge| merge.after.is_some()));

    let view = View::whole(&tree);
    let low = view.lowest(500);
    assert_eq!(low.minima.len(), 500);
    let shown = restricted(network, &low.minima, Evidence::Chain);
    assert_eq!(
        Tree::from_network(&shown, Evidence::Chain).nodes.len(),
        low.tree.nodes.len()
    );
    for levels in [1, 40, count] {
        let levels = Levels::spanning(&tree, levels).unwrap();
        assert_eq!(view.swept(&levels).tree.roots.len(), 1);
    }
    assert_eq!(view.below(-1.0).tree.roots.len(), count);
    assert!(!bottoms(network, Evidence::Chain).is_empty());
    for families in [1, 1000, count] {
        let family_of: Vec<usize> = (0..count).map(|minimum| minimum % families).collect();
        assert_eq!(
            network_of_families(network, &family_of).node_count(),
            families
        );
        let coarse = collapse(&tree, &family_of);
        assert_eq!(
            (coarse.roots.len(), coarse.nodes.len() > families),
            (1, families > 1)
        );
    }
}

/// Runs `work` on a stack that is too small for recursion over the trees of `exercise`.
fn on_a_small_stack(work: impl FnOnce() + Send + 'static) {
    let thread = std::thread::Builder::new().stack_size(256 << 10);
    thread.spawn(work).unwrap().join().unwrap();
}

const SHAPES: [fn(usize) -> Network; 5] = [comb, reversed_comb, star, pairs, random];

#[test]
fn trees_of_any_shape_need_no_stack() {
    for shape in SHAPES {
        on_a_small_stack(move || exercise(&shape(20_000)));
    }
}

#[test]
fn ancestors_are_those_that_walking_finds() {
    for network in [comb(60), reversed_comb(60), star(30), pairs(40), random(80)] {
        let tree = Tree::from_network(&network, Evidence::Chain);
        // Without its highest merges the tree falls apart.
        for tree in [tree.clone(), View::whole(&tree).below(1.6).tree] {
            let ancestors = Ancestors::of(&tree);
            for a in (0..network.node_count()).map(MinimumId) {
                for b in (0..network.node_count()).map(MinimumId) {
                    assert_eq!(ancestors.joint(a, b), tree.joint(a, b));
                }
            }
        }
    }
}

/// Runs the program on a chain of 50,000 minima, whose tree is as deep.
#[test]
fn a_deep_tree_is_imported_and_drawn_again() {
    let desk = Desk::empty();
    let count = 50_000;
    let (mut min, mut ts) = (Vec::new(), Vec::new());
    for k in 0..count {
        writeln!(min, "{k} {}", 1e-3 * f64::from(k)).unwrap();
    }
    for k in 1..count {
        writeln!(ts, "{} {k} {}", k - 1, 0.5 + 2e-3 * f64::from(k)).unwrap();
    }
    let [min, ts] = [min, ts].map(|bytes| String::from_utf8(bytes).unwrap());
    desk.database("chain", &min, &ts);
    let said = desk.print("import chain");
    assert!(said.contains("pictures show what is legible"), "{said}");
    assert_eq!(desk.tree("chain.landscape").nodes.len(), 99_999);
    let drawn = desk.text("chain.landscape/barriers.svg");
    assert!(drawn.contains("500 of 50000 minima (the 500 deepest)"));
    let drawn = desk.text("chain.landscape/disconnectivity.svg");
    assert!(drawn.contains("400 of 50000 minima (the 400 deepest), merges raised to 40 levels"));
    desk.print("draw chain.landscape --lowest 30 -o view");
    assert_eq!(desk.tree("view").nodes.len(), 59);
}

/// Energies that differ by one or two units in the last place, by more than the largest number, or by less than the
/// smallest normal number.
#[test]
fn energies_of_any_range_are_drawn() {
    let desk = Desk::empty();
    for (number, energies) in [
        ["1.0", "1.0000000000000002", "1.0000000000000004"],
        ["-1.7e308", "0", "1.7e308"],
        ["1.7e308", "1.7e308", "1.7e308"],
        ["0", "5e-324", "1e-323"],
        ["5e-324", "5e-324", "5e-324"],
        ["0", "0", "0"],
        ["0", "1e-320", "1e300"],
    ]
    .into_iter()
    .enumerate()
    {
        let [low, middle, high] = energies;
        let folder = format!("p{number}");
        let ts = format!("0 1 {high}\n1 2 {high}\n");
        desk.database(&folder, &format!("0 {low}\n1 {middle}\n2 {middle}\n"), &ts);
        desk.print(&format!("import {folder}"));
        for picture in ["disconnectivity", "barriers"] {
            let drawn = desk.text(&format!("{folder}.landscape/{picture}.svg"));
            assert!(
                !drawn.contains("NaN") && !drawn.contains("2147483647"),
                "{energies:?}"
            );
        }
    }
}
