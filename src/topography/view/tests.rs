use proptest::prelude::*;

use super::*;
use crate::topography::network::Network;
use crate::topography::tree::tests::{any_network, network};

fn height(tree: &Tree, a: usize, b: usize) -> Option<f64> {
    tree.minimax(MinimumId(a), MinimumId(b))
}

fn well_formed(view: &View) {
    let leaves = view.minima.len();
    for (id, node) in view.tree.nodes.iter().enumerate() {
        assert_eq!(node.minimum, (id < leaves).then_some(MinimumId(id)));
        assert!(node.minimum.is_some() || node.children.len() > 1);
        assert_eq!(node.parent.is_none(), view.tree.roots.contains(&NodeId(id)));
        for child in &node.children {
            assert!(child.0 < id);
            assert_eq!(view.tree.nodes[child.0].parent, Some(NodeId(id)));
            assert!(view.tree.nodes[child.0].energy <= node.energy);
        }
    }
}

/// Checks that every pair of kept minima merges as in the whole tree.
fn unchanged(view: &View, whole: &Tree) {
    well_formed(view);
    for (i, a) in view.minima.iter().enumerate() {
        for (j, b) in view.minima.iter().enumerate() {
            assert_eq!(height(&view.tree, i, j), whole.minimax(*a, *b));
        }
    }
}

/// Minima 0 and 1 join at 1, 2 and 3 at 2, and all at 3; 4 stays separate.
fn example() -> Network {
    use Evidence::{Chain, Path, Saddle};
    network(
        &[0.0, 0.1, 0.2, 0.3, 0.4],
        &[(0, 1, 1.0, Saddle), (2, 3, 2.0, Path), (1, 3, 3.0, Chain)],
    )
}

#[test]
fn filters_hide_and_keep_heights() {
    let network = example();
    let tree = Tree::from_network(&network, Evidence::Chain);
    let whole = View::whole(&tree);
    assert_eq!(whole.tree, tree);
    let lowest = whole.lowest(3);
    assert_eq!(lowest.minima, [0, 1, 2].map(MinimumId));
    // The merge of 2 and 3 is gone because 3 is hidden, but both still join through it.
    assert_eq!(lowest.tree.nodes.len(), 5);
    assert_eq!(height(&lowest.tree, 1, 2), Some(3.0));
    assert_eq!(lowest.tree.nodes[4].evidence, Evidence::Chain);
    // 4 joins nothing, 2 is 2.8 deep, 3 is 1.7 deep and 1 is 0.9 deep.
    for (count, kept) in [
        (1, &[0][..]),
        (2, &[0, 4]),
        (3, &[0, 2, 4]),
        (4, &[0, 2, 3, 4]),
        (9, &[0, 1, 2, 3, 4]),
    ] {
        let deepest = whole.deepest(count);
        assert!(
            deepest
                .minima
                .iter()
                .map(|minimum| minimum.0)
                .eq(kept.iter().copied())
        );
        unchanged(&deepest, &tree);
    }
    let picked = whole.picked(&[4, 2, 0, 99].map(MinimumId));
    assert_eq!(picked.minima, [0, 2, 4].map(MinimumId));
    assert_eq!(height(&picked.tree, 0, 1), Some(3.0));
    assert_eq!(height(&picked.tree, 0, 2), None);
    let members = whole.with_members(&[5, 1, 2, 0, 2], 2);
    assert_eq!(members.minima, picked.minima);
    // In a chain of filters, numbers remain those of the whole tree.
    assert_eq!(picked.lowest(2).minima, [0, 2].map(MinimumId));
    assert_eq!(whole.lowest(0).tree, Tree::default());
    let below = whole.below(2.0);
    assert_eq!(below.tree.roots.len(), 3);
    assert_eq!(height(&below.tree, 2, 3), Some(2.0));
}

#[test]
fn monotonic_sequences_end_in_bottoms() {
    let network = example();
    // 1 leads to 0, and 3 leads to 2 and to 1; 4 is isolated.
    assert_eq!(bottoms(&network, Evidence::Chain), [0, 2, 4].map(MinimumId));
    assert_eq!(
        bottoms(&network, Evidence::Saddle),
        [0, 2, 3, 4].map(MinimumId)
    );
    // At equal energies the lower number counts as lower.
    let flat = super::super::tree::tests::network(&[1.0, 1.0], &[(1, 0, 2.0, Evidence::Path)]);
    assert_eq!(bottoms(&flat, Evidence::Chain), [MinimumId(0)]);
}

#[test]
fn a_pass_on_a_level_is_open_there() {
    let tree = Tree::from_network(&example(), Evidence::Chain);
    let levels = Levels {
        first: 1.0,
        step: 1.0,
        count: 3,
    };
    assert_eq!(View::whole(&tree).swept(&levels).tree, tree);
    // With levels at 1.5 and 3.5 the upper two merges are united.
    let coarse = View::whole(&tree).swept(&Levels {
        first: 1.5,
        step: 2.0,
        count: 2,
    });
    well_formed(&coarse);
    let children: Vec<usize> = coarse
        .tree
        .nodes
        .iter()
        .map(|node| node.children.len())
        .collect();
    assert_eq!(children, [0, 0, 0, 0, 0, 2, 3]);
    assert_eq!(coarse.tree.nodes[6].evidence, Evidence::Chain);
    // If the last level is below the highest pass, its two sides stay separate.
    let cut = View::whole(&tree).swept(&Levels {
        first: 1.0,
        step: 1.0,
        count: 2,
    });
    assert_eq!(cut.tree.roots.len(), 3);
    assert_eq!(
        Levels::spanning(&tree, 5),
        Some(Levels {
            first: 1.0,
            step: 0.5,
            count: 5
        })
    );
    assert_eq!(Levels::spanning(&Tree::default(), 5), None);
    assert_eq!(Levels::spanning(&tree, 1).unwrap().of(2.9), Some(0));
}

#[test]
fn connections_lead_through_hidden_minima() {
    let network = example();
    let shown = restricted(&network, &[0, 2, 4].map(MinimumId), Evidence::Chain);
    assert_eq!(shown.node_count(), 3);
    let edges = shown.raw_edges();
    assert_eq!(edges.len(), 1);
    // 0 – 1 – 3 – 2: three connections of length one, decided by the middle one.
    approx::assert_abs_diff_eq!(edges[0].weight.height, 3.0);
    assert_eq!(edges[0].weight.evidence, Evidence::Chain);
    approx::assert_abs_diff_eq!(edges[0].weight.length, 3.0);
}

#[test]
fn families_are_minima_of_a_network() {
    let families = network_of_families(&example(), &[1, 0, 0, 1, 2]);
    let energies: Vec<f64> = families
        .node_weights()
        .map(|family| family.energy)
        .collect();
    assert_eq!(energies, [0.1, 0.0, 0.4]);
    let edges: Vec<_> = families
        .raw_edges()
        .iter()
        .map(|edge| edge.weight.height)
        .collect();
    assert_eq!(edges, [1.0]);
}

proptest! {
    #[test]
    fn no_filter_changes_a_height(network in any_network(), least in 0..3_usize, count in 0..9_usize, mask in 0..512_usize) {
        let tree = Tree::from_network(&network, Evidence::Chain);
        let whole = View::whole(&tree);
        let members: Vec<usize> = (0..network.node_count()).map(|i| i % 3).collect();
        let picked: Vec<MinimumId> = (0..network.node_count()).filter(|i| mask >> i & 1 == 1).map(MinimumId).collect();
        for view in [
            whole.lowest(count),
            whole.picked(&picked),
            whole.with_members(&members, least),
            whole.picked(&bottoms(&network, Evidence::Chain)),
            whole.lowest(count).with_members(&members, least).picked(&picked),
        ] {
            unchanged(&view, &tree);
        }
        // Filters commute.
        prop_assert_eq!(whole.picked(&picked).with_members(&members, least), whole.with_members(&members, least).picked(&picked));
    }

    #[test]
    fn levels_round_heights_up(network in any_network(), count in 1..12_usize) {
        let tree = Tree::from_network(&network, Evidence::Chain);
        let Some(levels) = Levels::spanning(&tree, count) else { return Ok(()); };
        let swept = View::whole(&tree).swept(&levels);
        well_formed(&swept);
        for i in 0..network.node_count() {
            for j in (0..network.node_count()).filter(|j| *j != i) {
                let exact = height(&tree, i, j).map(|height| levels.energy(levels.of(height).unwrap()));
                match (height(&swept.tree, i, j), exact) {
                    (Some(found), Some(exact)) => prop_assert!((found - exact).abs() < 1e-9, "{found} {exact}"),
                    (found, exact) => prop_assert_eq!(found, exact),
                }
            }
        }
        // Sweeping again at the same levels changes nothing. Sweeping and hiding commute, except for the evidence, because
        // a merge of several passes has the worst evidence of them.
        prop_assert_eq!(&swept.swept(&levels), &swept);
        let [one, other] = [swept.lowest(3), View::whole(&tree).lowest(3).swept(&levels)];
        prop_assert_eq!(&one.minima, &other.minima);
        for i in 0..one.minima.len() {
            for j in 0..one.minima.len() {
                // The same levels with another first level are equal up to rounding.
                match (height(&one.tree, i, j), height(&other.tree, i, j)) {
                    (Some(one), Some(other)) => prop_assert!((one - other).abs() < 1e-9, "{one} {other}"),
                    (one, other) => prop_assert_eq!(one, other),
                }
            }
        }
    }

    #[test]
    fn restricted_networks_have_the_restricted_tree(network in any_network(), mask in 0..512_usize) {
        let kept: Vec<MinimumId> = (0..network.node_count()).filter(|i| mask >> i & 1 == 1).map(MinimumId).collect();
        let shown = Tree::from_network(&restricted(&network, &kept, Evidence::Chain), Evidence::Chain);
        let view = View::whole(&Tree::from_network(&network, Evidence::Chain)).picked(&kept);
        for i in 0..kept.len() {
            for j in 0..kept.len() {
                match (height(&shown, i, j), height(&view.tree, i, j)) {
                    (Some(a), Some(b)) => prop_assert!((a - b).abs() < 1e-7),
                    (a, b) => prop_assert_eq!(a, b),
                }
            }
        }
    }
}
