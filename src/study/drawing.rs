//! Pictures and text files of a network and its tree, with views applied.

use std::fmt::Write as _;

use super::digits::significant;
use super::error::StudyError;
use super::looks;
use crate::figure::layout::collapse;
use crate::figure::{
    BarrierPicture, DisconnectivityPicture, Leaf, LeafValues, Picture, leaves_of_families,
};
use crate::store::{Manifest, StoreError};
use crate::topography::view::{Levels, View, bottoms, network_of_families, restricted};
use crate::topography::{
    self, Ancestors, Attempts, Evidence, MinimumId, Network, Node, Tree, spanning_forest,
};

/// Names of the pictures, without what comes second ([`Titles::first`]) and format.
const PICTURES: [&str; 2] = ["disconnectivity", "barriers"];

/// Callback that stores a file with the given name and bytes.
pub type Put<'a> = &'a mut dyn FnMut(&str, &[u8]) -> Result<(), StoreError>;

/// What the branches and circles of a picture are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Resolution {
    /// A branch for each family.
    Families,
    /// A branch for each minimum.
    Minima,
}

impl Resolution {
    const fn name(self) -> &'static str {
        match self {
            Self::Families => "families",
            Self::Minima => "minima",
        }
    }
}

/// Texts and layout seed of the pictures, and which of them come first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Titles {
    /// Name of the landscape.
    pub title: String,
    /// Name and unit of the energy.
    pub energy: String,
    /// Name of the members of minima, plural.
    pub members: String,
    /// Seed of the layout.
    pub seed: u64,
    /// What the first pictures show: the families of many grasps, or the minima of a surface. The others have names that end in
    /// what they show. Families that come second are drawn only where they simplify the minima.
    pub first: Resolution,
}

impl Titles {
    pub(super) fn of_grasps(grasps: usize, [hand, object]: [&str; 2], seed: u64) -> Self {
        Self {
            title: format!("{grasps} grasps, {hand} hand on {object}"),
            energy: "energy E(H, O)".to_owned(),
            members: "grasps".to_owned(),
            seed,
            first: Resolution::Families,
        }
    }

    pub(super) fn of_surface(title: String, members: &str, seed: u64) -> Self {
        Self {
            title,
            energy: "energy".to_owned(),
            members: members.to_owned(),
            seed,
            first: Resolution::Minima,
        }
    }

    pub(super) fn of_free_energies(name: &str, temperature: f64) -> Self {
        Self {
            title: format!("{name}: free energies at kT = {}", significant(temperature)),
            energy: "free energy".to_owned(),
            members: "minima".to_owned(),
            seed: 0,
            first: Resolution::Minima,
        }
    }

    /// The titles that a finished landscape was drawn with, with another seed if one is given.
    pub fn of_manifest(manifest: &Manifest, seed: Option<u64>) -> Self {
        let seed = seed.unwrap_or(manifest.seed);
        match (&manifest.hand, &manifest.object) {
            (Some(hand), Some(object)) => {
                let names = [hand.name.as_str(), object.name.as_str()];
                let grasps = usize::try_from(manifest.counts.grasps).unwrap_or(usize::MAX);
                Self::of_grasps(grasps, names, seed)
            }
            _ => Self::of_surface(manifest.source.name.clone(), "members", seed),
        }
    }
}

/// A landscape to be drawn.
#[derive(Debug)]
pub struct Drawing<'a> {
    /// Minima and connections.
    pub network: &'a Network,
    /// Its tree of merges.
    pub tree: &'a Tree,
    /// The searches, for the support of merges, if they are known.
    pub attempts: Option<&'a Attempts>,
    /// One leaf for each minimum.
    pub leaves: Vec<Leaf>,
    /// The family of each minimum, numbered without gaps.
    pub family_of: Vec<usize>,
    /// Names that a person would give the families; empty if there are none.
    pub family_names: Vec<String>,
    /// Texts of the pictures.
    pub titles: &'a Titles,
    /// Which part is shown.
    pub views: Views,
    /// Quantities of the minima that place the branches and colour the circles of disconnectivity graphs. A family has the
    /// value of its lowest minimum.
    pub quantities: Quantities,
    /// Pictures of some minima, drawn below the disconnectivity graph of the families.
    pub examples: Vec<(MinimumId, Picture)>,
}

/// Quantities of the minima that a disconnectivity graph shows beside the energy; one value for each minimum.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Quantities {
    /// Where the branches stand.
    pub place_by: Option<LeafValues>,
    /// Colour of the circles.
    pub colour_by: Option<LeafValues>,
}

impl Quantities {
    /// The values of some minima, in this order.
    fn of(&self, minima: &[usize]) -> Self {
        let chosen = |all: &Option<LeafValues>| {
            all.as_ref().map(|all| LeafValues {
                name: all.name.clone(),
                values: minima.iter().map(|minimum| all.values[*minimum]).collect(),
            })
        };
        Self {
            place_by: chosen(&self.place_by),
            colour_by: chosen(&self.colour_by),
        }
    }
}

/// Which part of a landscape is shown; by default all of it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Views {
    /// Number of lowest minima to show.
    pub lowest: Option<usize>,
    /// Number of minima to show, those at the bottom of the deepest valleys.
    pub deepest: Option<usize>,
    /// Least number of members of a minimum.
    pub members: Option<usize>,
    /// Whether to show only the bottoms of monotonic sequences, which no connection joins to a lower minimum.
    pub monotonic: bool,
    /// Number of even levels to which merges are raised.
    pub levels: Option<usize>,
    /// Names of the minima to show; empty for all.
    pub picked: Vec<MinimumId>,
}

impl Views {
    /// Applies the filters and then the levels, which are returned too. `picked` names leaves of this tree.
    fn of(&self, network: &Network, tree: &Tree, picked: &[MinimumId]) -> (View, Option<Levels>) {
        let mut view = View::whole(tree);
        if !picked.is_empty() {
            view = view.picked(picked);
        }
        if self.monotonic {
            view = view.picked(&bottoms(network, Evidence::Chain));
        }
        if let Some(least) = self.members {
            let members: Vec<usize> = network.node_weights().map(|m| m.members.len()).collect();
            view = view.with_members(&members, least);
        }
        if let Some(count) = self.lowest {
            view = view.lowest(count);
        }
        if let Some(count) = self.deepest {
            view = view.deepest(count);
        }
        let levels = self
            .levels
            .and_then(|count| Levels::spanning(&view.tree, count));
        match levels {
            Some(levels) => (view.swept(&levels), Some(levels)),
            None => (view, None),
        }
    }

    /// Description for a title.
    fn spell(&self) -> String {
        let mut parts = Vec::new();
        if !self.picked.is_empty() {
            parts.push("picked".to_owned());
        }
        if self.monotonic {
            parts.push("bottoms of monotonic sequences".to_owned());
        }
        if let Some(least) = self.members {
            parts.push(format!("at least {least} members"));
        }
        if let Some(count) = self.lowest {
            parts.push(format!("the {count} lowest"));
        }
        if let Some(count) = self.deepest {
            parts.push(format!("the {count} deepest"));
        }
        if let Some(count) = self.levels {
            parts.push(format!("{count} levels"));
        }
        parts.join(", ")
    }
}

/// Number of valleys in a disconnectivity graph that would have too many leaves.
const PRUNED: usize = 400;

/// Greatest number of families or minima that are named in pictures, as in `inspect --path g0 g4`. More names would hide them.
pub(super) const MOST_NAMED: usize = 60;

/// Greatest number of families whose names are spelled out below pictures.
const MOST_EXPLAINED: usize = 8;
/// Least number of members of these families.
const LEAST_EXPLAINED: usize = 3;

struct Shown<'a> {
    resolution: Resolution,
    /// What the leaves are called beside their numbers; empty if nothing.
    names: &'a [String],
    quantities: Quantities,
    examples: Vec<(MinimumId, Picture)>,
    network: &'a Network,
    tree: Tree,
    /// Of each merge of the tree of minima, if it is known; empty if none is.
    support: Vec<Option<f64>>,
    leaves: &'a [Leaf],
    picked: Vec<MinimumId>,
}

impl<'a> Drawing<'a> {
    /// The whole of a landscape without anything else, in which each minimum is a family.
    pub fn new(
        network: &'a Network,
        tree: &'a Tree,
        leaves: Vec<Leaf>,
        titles: &'a Titles,
    ) -> Self {
        Self {
            network,
            tree,
            attempts: None,
            family_of: (0..leaves.len()).collect(),
            leaves,
            family_names: Vec::new(),
            titles,
            views: Views::default(),
            quantities: Quantities::default(),
            examples: Vec::new(),
        }
    }
}

impl Drawing<'_> {
    /// Width of a disconnectivity graph, canvas units.
    pub const WIDTH: u32 = 1600;

    /// Whether [`Drawing::write`] may write a file with this name.
    pub fn writes(name: &str) -> bool {
        let texts = ["tree.nwk", "tree.dot", "tree.json", "barriers.graphml"];
        let picture = name.strip_suffix(".svg").or(name.strip_suffix(".png"));
        let picture = picture.map(|stem| match stem.rsplit_once('_') {
            Some((stem, "families" | "minima")) => stem,
            _ => stem,
        });
        texts.contains(&name) || picture.is_some_and(|stem| PICTURES.contains(&stem))
    }

    /// Gives `put` the tree (Newick, DOT, JSON), the network (GraphML) and the pictures (SVG and PNG) of the visible part.
    ///
    /// # Errors
    /// The first error of `put`, or of a picture.
    ///
    /// # Panics
    /// If there is not one leaf and one family for each minimum.
    pub fn write(&self, put: Put<'_>) -> Result<(), StudyError> {
        let (view, _) = (self.views).of(self.network, self.tree, &self.views.picked);
        let name = |id: MinimumId| format!("m{}", view.minima[id.0].0);
        let support = self.support();
        let known = carried((self.tree, &support), &view.tree, |leaf| view.minima[leaf]);
        let newick = topography::newick(&view.tree, &known, name);
        put("tree.nwk", newick.as_bytes())?;
        let dot = topography::dot(&view.tree, &known, name);
        put("tree.dot", dot.as_bytes())?;
        let json = topography::tree_json(&view.tree, &known, name);
        put("tree.json", json.as_bytes())?;
        let network = visible(self.network, &view);
        let network = network.as_ref().unwrap_or(self.network);
        let known = of_edges(network, &view.tree, &known);
        let graphml = topography::graphml(network, &known, name);
        put("barriers.graphml", graphml.as_bytes())?;

        self.pictures_of(&support, put)
    }

    /// Writes the pictures of the families and of the minima.
    fn pictures_of(&self, support: &[Option<f64>], put: Put<'_>) -> Result<(), StudyError> {
        let families = network_of_families(self.network, &self.family_of);
        let mut leaves = leaves_of_families(&self.leaves, &self.family_of);
        name_leaves(&mut leaves, 'g');
        let mut minima = self.leaves.clone();
        let unnamed = || minima.iter().all(|leaf| leaf.caption.is_none());
        if self.titles.first == Resolution::Minima && unnamed() {
            name_leaves(&mut minima, 'm');
        }
        let mut picked: Vec<MinimumId> = (self.views.picked.iter())
            .map(|minimum| MinimumId(self.family_of[minimum.0]))
            .collect();
        picked.sort_unstable();
        picked.dedup();
        // Minima are sorted by energy, so the first of a family is its lowest.
        let mut lowest: Vec<Option<usize>> = vec![None; leaves.len()];
        for (minimum, family) in self.family_of.iter().enumerate() {
            lowest[*family].get_or_insert(minimum);
        }
        let lowest: Vec<usize> = lowest.into_iter().flatten().collect();
        let families_tree = collapse(self.tree, &self.family_of);
        let of_families = Shown {
            resolution: Resolution::Families,
            names: &self.family_names,
            quantities: self.quantities.of(&lowest),
            examples: (self.examples.iter())
                .map(|(minimum, picture)| (MinimumId(self.family_of[minimum.0]), picture.clone()))
                .collect(),
            network: &families,
            tree: families_tree.clone(),
            support: carried((self.tree, support), &families_tree, |leaf| {
                MinimumId(lowest[leaf])
            }),
            leaves: &leaves,
            picked,
        };
        let of_minima = Shown {
            resolution: Resolution::Minima,
            names: &[],
            quantities: self.quantities.clone(),
            examples: Vec::new(),
            network: self.network,
            tree: self.tree.clone(),
            support: support.to_vec(),
            leaves: &minima,
            picked: self.views.picked.clone(),
        };
        if self.titles.first == Resolution::Families {
            self.pictures(&of_families, "", put)?;
            return self.pictures(&of_minima, "_minima", put);
        }
        self.pictures(&of_minima, "", put)?;
        // A family of all minima, or one for each, tells nothing more.
        if (2..minima.len()).contains(&leaves.len()) {
            self.pictures(&of_families, "_families", put)?;
        }
        Ok(())
    }

    /// The support of each merge of the tree; empty if no merge was searched.
    fn support(&self) -> Vec<Option<f64>> {
        let searched = self.attempts.map(|attempts| attempts.of_merges(self.tree));
        let searched = searched.unwrap_or_default();
        if searched.iter().all(Option::is_none) {
            return Vec::new();
        }
        let support = searched
            .iter()
            .map(|found| found.map(|found| found.support()));
        support.collect()
    }

    /// Writes the disconnectivity graph and the barrier graph as SVG and PNG.
    fn pictures(&self, shown: &Shown<'_>, ending: &str, put: Put<'_>) -> Result<(), StudyError> {
        let (view, levels) = (self.views).of(shown.network, &shown.tree, &shown.picked);
        let legible = at_most(&view, DisconnectivityPicture::MOST_LEAVES, PRUNED);
        let title = self.title(shown, &view, &legible);
        let tree = self.tree_picture(shown, &legible, levels, title);
        let most = BarrierPicture::MOST_NODES;
        let legible = at_most(&view, most, most);
        let graph = self.graph_picture(shown, &legible, self.title(shown, &view, &legible));
        for (name, canvas) in PICTURES.into_iter().zip([tree.draw()?, graph.draw()?]) {
            for format in ["svg", "png"] {
                let name = format!("{name}{ending}.{format}");
                put(&name, &canvas.encode(name.as_ref())?)?;
            }
        }
        Ok(())
    }

    /// Title that names the part drawn: the view, and how much of it is legible.
    fn title(&self, shown: &Shown<'_>, view: &View, legible: &View) -> String {
        let mut spelled = self.views.spell();
        let drawn = legible.minima.len();
        if drawn < view.minima.len() {
            if !spelled.is_empty() {
                spelled.push_str(", of these ");
            }
            let _ = write!(spelled, "the {drawn} deepest");
        }
        let (title, all, what) = (
            &self.titles.title,
            shown.leaves.len(),
            shown.resolution.name(),
        );
        if spelled.is_empty() {
            return match (self.titles.first, shown.resolution) {
                (Resolution::Minima, Resolution::Families) => format!("{title}, {all} families"),
                _ => title.clone(),
            };
        }
        format!("{title}: {drawn} of {all} {what} ({spelled})")
    }

    fn tree_picture(
        &self,
        shown: &Shown<'_>,
        view: &View,
        mut levels: Option<Levels>,
        mut title: String,
    ) -> DisconnectivityPicture {
        let cut = squashing(&view.tree);
        let mut drawn = cut.map_or(view.clone(), |(_, height)| view.below(height));
        if levels.is_none() && view.minima.len() > DisconnectivityPicture::MOST_CIRCLES {
            levels = Levels::spanning(&drawn.tree, DisconnectivityPicture::LEVELS);
            if let Some(levels) = &levels {
                drawn = drawn.swept(levels);
                let _ = write!(title, ", merges raised to {} levels", levels.count);
            }
        }
        let mut tree = DisconnectivityPicture::new(drawn.tree, &Network::default());
        tree.leaves = leaves_shown(shown, view);
        tree.key = looks::key();
        tree.notes = notes(shown, view);
        tree.support = carried((&shown.tree, &shown.support), &tree.tree, |leaf| {
            view.minima[leaf]
        });
        if let Some((count, height)) = cut {
            tree.apart = format!("apart: joined above {height:.2}");
            let merges = if count == 1 { "merge" } else { "merges" };
            let _ = write!(title, " ({count} {merges} above {height:.2} not drawn)");
        }
        tree.title = title;
        let visible_examples = shown.examples.iter().filter_map(|(of, picture)| {
            let leaf = view.minima.iter().position(|minimum| minimum == of)?;
            Some((leaf, picture.clone()))
        });
        tree.examples = visible_examples.collect();
        let minima: Vec<usize> = view.minima.iter().map(|minimum| minimum.0).collect();
        let quantities = shown.quantities.of(&minima);
        tree.place_by = quantities.place_by;
        tree.colour_by = quantities.colour_by;
        tree.size = [Self::WIDTH, 900];
        self.titles.energy.clone_into(&mut tree.energy_label);
        self.titles.members.clone_into(&mut tree.members_label);
        tree
    }

    fn graph_picture(&self, shown: &Shown<'_>, view: &View, title: String) -> BarrierPicture {
        let network = visible(shown.network, view);
        let mut graph = BarrierPicture::new(network.as_ref().unwrap_or(shown.network));
        graph.leaves = leaves_shown(shown, view);
        graph.key = looks::key();
        graph.notes = notes(shown, view);
        graph.title = title;
        self.titles.energy.clone_into(&mut graph.energy_label);
        self.titles.members.clone_into(&mut graph.members_label);
        graph.seed = self.titles.seed;
        graph
    }
}

/// The whole view, or its `pruned` deepest valleys if it has more than `most` minima.
fn at_most(view: &View, most: usize, pruned: usize) -> View {
    if view.minima.len() > most {
        view.deepest(pruned)
    } else {
        view.clone()
    }
}

/// Names leaves by a letter and their numbers, if there are few.
fn name_leaves(leaves: &mut [Leaf], letter: char) {
    if leaves.len() <= MOST_NAMED {
        for (number, leaf) in leaves.iter_mut().enumerate() {
            leaf.caption = Some(format!("{letter}{number}"));
        }
    }
}

fn leaves_shown(shown: &Shown<'_>, view: &View) -> Vec<Leaf> {
    let leaves = view.minima.iter();
    leaves
        .map(|minimum| shown.leaves[minimum.0].clone())
        .collect()
}

/// Names of the largest leaves that several members are in, in the order of their numbers.
fn notes(shown: &Shown<'_>, view: &View) -> Vec<(String, String)> {
    let members = |leaf: usize| shown.leaves[leaf].members;
    let mut named: Vec<usize> = (view.minima.iter())
        .map(|minimum| minimum.0)
        .filter(|leaf| members(*leaf) >= LEAST_EXPLAINED)
        .filter(|leaf| shown.names.get(*leaf).is_some_and(|name| !name.is_empty()))
        .collect();
    named.sort_by_key(|leaf| (std::cmp::Reverse(members(*leaf)), *leaf));
    named.truncate(MOST_EXPLAINED);
    named.sort_unstable();
    let caption = |leaf: usize| shown.leaves[leaf].caption.clone();
    (named.into_iter())
        .filter_map(|leaf| Some((caption(leaf)?, shown.names[leaf].clone())))
        .collect()
}

/// A sentence for the summary if the pictures do not show all of these minima.
pub(super) fn not_drawn(minima: usize) -> Option<String> {
    let [leaves, nodes] = [
        DisconnectivityPicture::MOST_LEAVES,
        BarrierPicture::MOST_NODES,
    ];
    (minima > leaves.min(nodes)).then(|| {
        format!(
            "pictures show what is legible: the {PRUNED} deepest valleys in disconnectivity graphs of more than {leaves} \
             minima or families, and the {nodes} deepest in barrier graphs; the texts (tree.nwk, tree.dot, tree.json, \
             barriers.graphml) contain all, and `landscape draw` draws what its views choose"
        )
    })
}

/// The support of each merge of `shown`, a simplification of another tree whose support is known: the least support of the
/// merges of the whole tree that join its branches. `minimum` gives the leaf of the whole tree for each leaf of `shown`.
fn carried(
    (whole, support): (&Tree, &[Option<f64>]),
    shown: &Tree,
    minimum: impl Fn(usize) -> MinimumId,
) -> Vec<Option<f64>> {
    if support.is_empty() {
        return Vec::new();
    }
    let first = shown.fold(|node, branches: &[usize]| branches.first().copied().unwrap_or(node.0));
    let ancestors = Ancestors::of(whole);
    let of_merge = |node: &Node| {
        let leaves: Vec<MinimumId> = (node.children.iter())
            .map(|child| minimum(first[child.0]))
            .collect();
        let merges = leaves.windows(2).map(|pair| {
            let merge = ancestors.joint(pair[0], pair[1])?;
            support[merge.0]
        });
        merges.flatten().reduce(f64::min)
    };
    shown.nodes.iter().map(of_merge).collect()
}

/// Support of the merge that each edge of the tree makes; `None` for other edges.
fn of_edges(network: &Network, tree: &Tree, support: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut of_edges = vec![None; network.edge_count()];
    let ancestors = Ancestors::of(tree);
    for edge in spanning_forest(network, Evidence::Chain) {
        let ends = network.edge_endpoints(edge);
        let merge =
            ends.and_then(|(a, b)| ancestors.joint(MinimumId(a.index()), MinimumId(b.index())));
        of_edges[edge.index()] = merge.and_then(|merge| *support.get(merge.0)?);
    }
    of_edges
}

/// The network of a view, if it hides anything.
fn visible(network: &Network, view: &View) -> Option<Network> {
    let hides = view.minima.len() < network.node_count();
    hides.then(|| restricted(network, &view.minima, Evidence::Chain))
}

/// Number of merges that would squash the others in a picture (at most a twentieth), and the height below them.
fn squashing(tree: &Tree) -> Option<(usize, f64)> {
    // A merge of n branches counts n − 1 times.
    let merges = tree.nodes.iter().filter(|node| node.minimum.is_none());
    let heights: Vec<f64> = merges
        .flat_map(|node| vec![node.energy; node.children.len() - 1])
        .collect();
    let bottom = (tree.nodes.iter()).fold(f64::INFINITY, |low, node| low.min(node.energy));
    let (&highest, &usual) = heights.last().zip(heights.get(heights.len() * 19 / 20))?;
    if highest - bottom < 2.0 * (usual - bottom) {
        return None;
    }
    let count = heights.iter().filter(|height| **height > usual).count();
    (count > 0).then_some((count, usual))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::NodeId;

    fn ladder(heights: &[f64]) -> Tree {
        let leaf = |number| Node {
            energy: -10.0,
            minimum: Some(MinimumId(number)),
            children: Vec::new(),
            parent: None,
            evidence: Evidence::Saddle,
        };
        let mut nodes: Vec<Node> = (0..=heights.len()).map(leaf).collect();
        for (k, height) in heights.iter().enumerate() {
            let below = if k == 0 { 0 } else { heights.len() + k };
            nodes.push(Node {
                energy: *height,
                minimum: None,
                children: vec![NodeId(k + 1), NodeId(below)],
                parent: None,
                evidence: Evidence::Path,
            });
        }
        Tree {
            nodes,
            roots: Vec::new(),
        }
    }

    #[test]
    fn only_what_squashes_the_rest_is_cut_off() {
        // Energies may be negative, so heights are measured from the lowest minimum.
        assert_eq!(squashing(&ladder(&[-9.0, -8.5, -8.0])), None);
        let mut heights = vec![-9.0; 20];
        heights.push(5.0);
        assert_eq!(squashing(&ladder(&heights)), Some((1, -9.0)));
        assert_eq!(squashing(&ladder(&[])), None);
    }
}
