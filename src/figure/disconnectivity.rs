//! The disconnectivity graph (Becker and Karplus 1997): it shows at which energy minima become connected.

use super::axis::Span;
use super::canvas::Canvas;
use super::heights::Heights;
use super::layout::{TreeLayout, leaf_count, place};
use super::leaf::{
    DiscScale, LEAST_SYMBOL, Leaf, Looks, draw_title, explain_sizes, leaves_of, most_members,
};
use super::leaf_values::{AXIS_ROOM, LeafValues};
use super::legend::Legend;
use super::look::{Key, Look};
use super::notes::{draw_notes, notes_height};
use super::strip::{PICTURE_DENSITY, Picture, draw_row, row_height};
use super::style::{Anchor, Colour, Stroke, TextFace};
use super::theme::{INK, LINE, MARGIN, PALE_LINE, TEXT, UNLABELLED, WHITE};
use super::{FigureError, text_width};
use crate::topography::{Evidence, Network, Node, Tree};

const LABEL_RADIUS: f64 = 9.0;
/// Least radius of symbols in a tree with many leaves, canvas units.
const LEAST_CROWDED_SYMBOL: f64 = 3.0;
/// Least support for each mark, the fill of the mark, and its text in the legend.
const SUPPORT: [(f64, Colour, &str); 3] = [
    (0.95, INK, "95 % or more"),
    (0.70, PALE_LINE, "70 to 95 %"),
    (0.00, WHITE, "less, or not searched"),
];

/// A merge tree with a circle at the end of every branch.
#[derive(Debug, Clone, PartialEq)]
pub struct DisconnectivityPicture {
    /// The tree. Heights and energies of all nodes must be finite.
    pub tree: Tree,
    /// Description of leaf i of the tree, for every i.
    pub leaves: Vec<Leaf>,
    /// Looks of known labels.
    pub key: Key,
    /// Title; empty for none.
    pub title: String,
    /// Name and unit of the energy axis.
    pub energy_label: String,
    /// Plural noun for the members that the circles count; it heads their legend.
    pub members_label: String,
    /// Text in the legend about trees that are not connected to each other.
    pub apart: String,
    /// Support of each node of the tree ([`Searched::support`](crate::topography::Searched::support)); `None` marks a merge as
    /// not searched. No marks are drawn if this is empty.
    pub support: Vec<Option<f64>>,
    /// Width and height of the graph in canvas units.
    pub size: [u32; 2],
    /// Places the branches at the values of their leaves, with an axis below the graph; without it they stand side by side.
    pub place_by: Option<LeafValues>,
    /// Colours the circles by a quantity, in place of their labels.
    pub colour_by: Option<LeafValues>,
    /// What names of leaves mean: lines below the graph and the pictures, each a name and a text.
    pub notes: Vec<(String, String)>,
    /// Pictures of some leaves. They stand below the graph in the order of the branches, and the line above each has the
    /// look of the leaf if the leaf has a label.
    pub examples: Vec<(usize, Picture)>,
}

impl DisconnectivityPicture {
    /// Largest number of leaves. On a sheet of the usual width they are then one or two pixels apart.
    pub const MOST_LEAVES: usize = 2000;
    /// Largest number of leaves that are drawn with circles and bars. More are drawn as thin lines that slant from merge to
    /// merge, as by the program disconnectionDPS; bars and circles would be one black area.
    pub const MOST_CIRCLES: usize = 100;
    /// Number of even levels to which the merges of a tree with more leaves should be raised ([`View::swept`]). Hundreds of
    /// merges in a narrow range of heights cannot be told apart.
    ///
    /// [`View::swept`]: crate::topography::view::View::swept
    pub const LEVELS: usize = 40;

    /// Picture of `tree` with the numbers of members in `network`, without labels.
    pub fn new(tree: Tree, network: &Network) -> Self {
        Self {
            tree,
            leaves: leaves_of(network),
            key: Key::default(),
            title: String::new(),
            energy_label: "energy".to_owned(),
            members_label: "members".to_owned(),
            apart: "apart: not connected".to_owned(),
            support: Vec::new(),
            size: [1200, 860],
            place_by: None,
            colour_by: None,
            notes: Vec::new(),
            examples: Vec::new(),
        }
    }

    /// Draws the picture: energy upward, leaves side by side, merges as bars, or as fans of slanted lines above
    /// [`DisconnectivityPicture::MOST_CIRCLES`] leaves. A merge with evidence worse than [`Evidence::Path`] is dashed and
    /// pale, down to its children.
    ///
    /// # Errors
    /// [`FigureError::Leaves`] or [`FigureError::NotFinite`] if the fields are inconsistent; [`FigureError::TooMany`] for
    /// more leaves than [`DisconnectivityPicture::MOST_LEAVES`].
    pub fn draw(&self) -> Result<Canvas, FigureError> {
        let count = leaf_count(&self.tree);
        if self.leaves.len() != count {
            return Err(FigureError::Leaves {
                described: self.leaves.len(),
                present: count,
            });
        }
        FigureError::check_count(count, Self::MOST_LEAVES)?;
        if let Some((node, bad)) = self
            .tree
            .nodes
            .iter()
            .enumerate()
            .find(|(_, node)| !node.energy.is_finite())
        {
            return Err(FigureError::NotFinite {
                node,
                energy: bad.energy,
            });
        }
        for values in [&self.place_by, &self.colour_by].into_iter().flatten() {
            values.check(count)?;
        }
        let below = self.room_for_examples() + notes_height(self.notes.len());
        let mut canvas = Canvas::new(self.size[0], self.size[1] + below);
        let top = draw_title(&mut canvas, &self.title);
        let layout = match &self.place_by {
            Some(values) => values.place(&self.tree),
            None => place(&self.tree),
        };
        let scale = self.disc_scale(&layout, canvas.width());
        let legend = self.legend(scale);
        let right = canvas.width() - MARGIN - legend.width();
        legend.draw(&mut canvas, [right, top], f64::from(self.size[1]) - MARGIN);
        draw_notes(&mut canvas, &self.notes);
        let plot = Plot::new(
            self,
            &layout,
            scale,
            [top + 0.5 * TEXT, right - 34.0],
            &mut canvas,
        );
        plot.draw_examples(&mut canvas);
        plot.draw_branches(&mut canvas);
        plot.draw_support(&mut canvas);
        plot.draw_leaves(&mut canvas);
        Ok(canvas)
    }

    /// The merges with the number of the mark of their support.
    fn marks_of_support(&self) -> impl Iterator<Item = (usize, usize)> {
        let merges = self.support.iter().zip(&self.tree.nodes).enumerate();
        let merges = merges.filter(|(_, (_, node))| !node.children.is_empty());
        merges.filter_map(|(node, (support, _))| {
            let share = support.unwrap_or(0.0);
            let mark = SUPPORT.iter().position(|(least, ..)| share >= *least)?;
            Some((node, mark))
        })
    }

    /// The looks of the leaves that are drawn with labels: all, or in a crowded tree those that have one.
    fn looks(&self) -> Looks<'_> {
        let looks = Looks::of(&self.leaves, &self.key);
        if self.is_crowded() {
            looks.only_labelled()
        } else {
            looks
        }
    }

    /// Whether there are too many leaves for bars, and for circles that tell their members.
    fn is_crowded(&self) -> bool {
        self.leaves.len() > Self::MOST_CIRCLES
    }

    fn room_for_examples(&self) -> u32 {
        let pictures = || self.examples.iter().map(|(_, picture)| picture);
        let side = pictures().map(|picture| picture.image.width / PICTURE_DENSITY);
        let lines = pictures().map(|picture| picture.texts.len()).max();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a length on a sheet"
        )]
        side.max()
            .map_or(0, |side| row_height(side, lines.unwrap_or(0)).ceil() as u32)
    }

    /// Scale of the circles. They overlap a little if there are many leaves, but neighbours rarely have the same energy.
    fn disc_scale(&self, layout: &TreeLayout, width: f64) -> DiscScale {
        let spacing = 0.7 * width / (layout.width + 1.0);
        let symbols = self.colour_by.is_none() && self.looks().have_symbols();
        if self.is_crowded() {
            let least = if symbols { LEAST_CROWDED_SYMBOL } else { 1.0 };
            return DiscScale::equal((0.5 * spacing).clamp(least, 4.0));
        }
        let most = most_members(&self.leaves);
        let largest = if most > 1.0 {
            (1.6 * spacing).clamp(13.0, 36.0)
        } else {
            (0.6 * spacing).clamp(3.2, 14.0)
        };
        let scale = (largest / most.sqrt()).max(3.2).min(44.0 / most.sqrt());
        let scale = DiscScale::by_members(scale);
        if symbols {
            return scale.at_least(LEAST_SYMBOL);
        }
        scale
    }

    fn legend(&self, scale: DiscScale) -> Legend {
        let mut legend = Legend::default();
        if let Some(values) = &self.colour_by {
            let span = values.span();
            legend.heading(&values.name);
            legend.bar(span.low, span.high);
        } else {
            self.looks().explain(LABEL_RADIUS, &mut legend);
        }
        if !self.is_crowded() {
            explain_sizes(
                &self.leaves,
                scale,
                &self.members_label,
                UNLABELLED,
                &mut legend,
            );
        }
        let merges = || {
            self.tree
                .nodes
                .iter()
                .filter(|node| !node.children.is_empty())
        };
        let bounds = merges().any(|node| node.evidence > Evidence::Path);
        if bounds || self.tree.roots.len() > 1 {
            legend.heading("connection");
        }
        if bounds {
            if merges().any(|node| node.evidence <= Evidence::Path) {
                legend.line(Stroke::solid(LINE, 2.5), "relaxed");
            }
            legend.line(upper_bound(2.5), "upper bound");
        }
        if self.tree.roots.len() > 1 {
            legend.note(&self.apart);
        }
        if self.marks_of_support().next().is_some() {
            legend.heading("support");
            let marks: Vec<usize> = (self.marks_of_support()).map(|(_, mark)| mark).collect();
            for (number, (_, fill, text)) in SUPPORT.into_iter().enumerate() {
                if marks.contains(&number) {
                    legend.disc(6.0, fill, text);
                }
            }
        }
        legend
    }
}

fn upper_bound(width: f64) -> Stroke {
    Stroke::dashed(PALE_LINE, width, 9.0, 6.0)
}

/// Mapping of the data to the canvas.
struct Plot<'a> {
    picture: &'a DisconnectivityPicture,
    layout: &'a TreeLayout,
    scale: DiscScale,
    /// Canvas x of the first leaf, and canvas units per leaf.
    x: [f64; 2],
    heights: Heights,
    top: f64,
}

impl<'a> Plot<'a> {
    /// Chooses the scales and draws the energy axis.
    fn new(
        picture: &'a DisconnectivityPicture,
        layout: &'a TreeLayout,
        scale: DiscScale,
        [top, right]: [f64; 2],
        canvas: &mut Canvas,
    ) -> Self {
        let energies = || picture.tree.nodes.iter().map(|node| node.energy);
        let energies = Span {
            low: energies().fold(f64::INFINITY, f64::min),
            high: energies().fold(f64::NEG_INFINITY, f64::max),
        };
        let energies = if energies.low > energies.high {
            Span {
                low: 0.0,
                high: 1.0,
            }
        } else {
            energies.widened()
        };
        let looks = picture.looks();
        let reach = |leaf: &Leaf| {
            let reach = looks.look(leaf).symbol.reach();
            scale.radius(leaf.members) * reach[0].max(reach[2])
        };
        let largest = picture.leaves.iter().map(reach).fold(0.0, f64::max) + 2.0;
        let caption = if picture.leaves.iter().any(|leaf| leaf.caption.is_some()) {
            1.1 * TEXT
        } else {
            0.0
        };
        let axis_room = picture.place_by.as_ref().map_or(0.0, |_| AXIS_ROOM);
        let bottom = f64::from(picture.size[1]) - MARGIN - axis_room;
        // There is room for the circles of the lowest leaves below and for the stems of the roots above.
        let y = [
            bottom - largest - caption - 6.0,
            top + 0.035 * (bottom - top) + 4.0,
        ];
        let heights = Heights { energies, y };
        let left = heights.draw_axis([top, bottom, right], &picture.energy_label, canvas);
        if picture.leaves.is_empty() {
            let face = TextFace::new(TEXT, INK).anchored(Anchor::Middle);
            let middle = [0.5 * (left + right), 0.5 * (top + bottom)];
            canvas.text(middle, "no minima", face);
        }
        let pad = largest.max(0.5 * (right - left) / (layout.width + 1.0)) + 6.0;
        let inner = right - left - 2.0 * pad;
        let x = if layout.width > 0.0 {
            [left + pad, inner / layout.width]
        } else {
            [0.5 * (left + right), right - left]
        };
        if let Some(values) = &picture.place_by {
            values.draw_axis(canvas, [left + pad, right - pad], [top, bottom]);
        }
        Self {
            picture,
            layout,
            scale,
            x,
            heights,
            top,
        }
    }

    fn at(&self, node: usize) -> [f64; 2] {
        [
            self.x[0] + self.layout.x[node] * self.x[1],
            self.heights.of(self.picture.tree.nodes[node].energy),
        ]
    }

    fn draw_examples(&self, canvas: &mut Canvas) {
        let leaves = &self.picture.leaves;
        let looks = self.picture.looks();
        let mut examples: Vec<([f64; 2], Picture)> = (self.picture.examples.iter())
            .filter_map(|(leaf, picture)| {
                let drawn = leaves.get(*leaf)?;
                // A bar that looks unlike its leaf would look like a mistake.
                let own = drawn.label.as_ref().map(|_| looks.look(drawn));
                let at = self.at(*leaf);
                let picture = Picture {
                    of: Some(at),
                    look: own.or(picture.look),
                    ..picture.clone()
                };
                Some((at, picture))
            })
            .collect();
        examples.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        let pictures: Vec<Picture> = examples.into_iter().map(|(_, picture)| picture).collect();
        if !pictures.is_empty() {
            draw_row(
                canvas,
                f64::from(self.picture.size[1]) - 0.5 * MARGIN,
                &pictures,
            );
        }
    }

    /// How far below a merge the lines to its children still slant: not beyond the next merge below it, so that no two lines
    /// cross.
    fn slant(&self, node: &Node) -> f64 {
        let [bottom, top] = self.heights.y;
        let most = (bottom - top) / DisconnectivityPicture::LEVELS as f64;
        let nodes = &self.picture.tree.nodes;
        let merges = node.children.iter().map(|child| &nodes[child.0]);
        merges
            .filter(|child| !child.children.is_empty())
            .map(|child| self.heights.of(child.energy) - self.heights.of(node.energy))
            .fold(most, f64::min)
    }

    /// Draws the lines from a merge at `at` down to the `ends`.
    fn draw_merge(&self, node: &Node, at: [f64; 2], stroke: Stroke, canvas: &mut Canvas) {
        let ends: Vec<[f64; 2]> = node.children.iter().map(|child| self.at(child.0)).collect();
        if self.picture.is_crowded() {
            let slant = self.slant(node);
            for end in ends {
                let shoulder = [end[0], end[1].min(at[1] + slant)];
                canvas.polyline(&[at, shoulder, end], stroke);
            }
            return;
        }
        let first = ends.iter().map(|end| end[0]).fold(f64::INFINITY, f64::min);
        let last = (ends.iter().map(|end| end[0])).fold(f64::NEG_INFINITY, f64::max);
        // Extending the bar by half a line width beyond the stems makes square corners.
        let half = 0.5 * stroke.width;
        canvas.line([first - half, at[1]], [last + half, at[1]], stroke);
        for end in ends {
            canvas.line([end[0], at[1]], end, stroke);
        }
    }

    fn draw_branches(&self, canvas: &mut Canvas) {
        let thinnest = if self.picture.is_crowded() { 0.4 } else { 1.0 };
        let width = (0.3 * self.x[1]).clamp(thinnest, 2.75);
        // Uncertain merges are drawn first, so that certain ones lie on top.
        for certain in [false, true] {
            for (index, node) in self.picture.tree.nodes.iter().enumerate() {
                if node.children.is_empty() || (node.evidence <= Evidence::Path) != certain {
                    continue;
                }
                let stroke = if certain {
                    Stroke::solid(LINE, width)
                } else {
                    upper_bound(width)
                };
                let [x, y] = self.at(index);
                self.draw_merge(node, [x, y], stroke, canvas);
                if node.parent.is_none() {
                    canvas.line([x, self.top], [x, y], stroke);
                }
            }
        }
    }

    /// Draws a dot in the middle of each bar.
    fn draw_support(&self, canvas: &mut Canvas) {
        let radius = (0.2 * self.x[1]).clamp(2.4, 6.0);
        for (node, mark) in self.picture.marks_of_support() {
            canvas.rimmed_circle(self.at(node), radius, SUPPORT[mark].1, LINE, 1.0);
        }
    }

    fn draw_leaves(&self, canvas: &mut Canvas) {
        let leaves = &self.picture.leaves;
        let looks = self.picture.looks();
        // Large marks are drawn first, so that small ones stay visible.
        let mut order: Vec<usize> = (0..leaves.len()).collect();
        order.sort_by_key(|&leaf| (std::cmp::Reverse(leaves[leaf].members), leaf));
        let rim = (0.12 * self.x[1]).clamp(0.6, 1.2);
        let crowded = self.picture.is_crowded();
        for &index in &order {
            let leaf = &leaves[index];
            let look = match &self.picture.colour_by {
                Some(values) => Look::disc(values.colour(index)),
                None if crowded && leaf.label.is_none() => continue,
                None => looks.look(leaf),
            };
            let (at, radius) = (self.at(index), self.scale.radius(leaf.members));
            if crowded {
                look.draw(canvas, at, radius, 0.0);
                continue;
            }
            canvas.symbol(look.symbol, at, (radius, 2.0 * rim), WHITE);
            look.draw(canvas, at, radius, rim);
        }
        // At their values, leaves may stand anywhere.
        if self.picture.place_by.is_some() {
            return;
        }
        let room = 0.95 * self.x[1];
        let captions = || leaves.iter().filter_map(|leaf| leaf.caption.as_deref());
        let all_fit = captions().all(|caption| text_width(caption, TEXT, false) <= room);
        let explained = |caption: &str| self.picture.notes.iter().any(|(name, _)| name == caption);
        for (index, leaf) in leaves.iter().enumerate() {
            let caption = leaf.caption.as_deref();
            // Of many leaves, those that the notes below explain have names.
            let Some(caption) = caption.filter(|caption| all_fit || explained(caption)) else {
                continue;
            };
            let [x, y] = self.at(index);
            let [_, _, reach] = looks.look(leaf).symbol.reach();
            let below = y + reach * self.scale.radius(leaf.members) + 0.75 * TEXT;
            let face = TextFace::new(TEXT, INK).anchored(Anchor::Middle);
            canvas.text([x, below], caption, face);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::look::Hue;
    use super::super::testing::{assert_legible, forest, gallery, random_tree};
    use super::*;

    /// Members fall off quickly, as in real populations.
    fn leaves(count: usize, labels: bool) -> Vec<Leaf> {
        (0..count)
            .map(|i| Leaf {
                members: [1, 1, 4, 1, 2, 9, 1, 1, 22, 0][i % 10] + if i == 3 { 60 } else { 0 },
                label: labels
                    .then(|| ["power", "precision", "intermediate"][(i * i / 7) % 3].to_owned()),
                caption: None,
            })
            .collect()
    }

    fn picture(tree: Tree, labels: bool) -> DisconnectivityPicture {
        let leaves = leaves(leaf_count(&tree), labels);
        DisconnectivityPicture {
            leaves,
            title: "Human hand on a bottle".into(),
            energy_label: "energy E(H, O)".into(),
            members_label: "grasps".into(),
            ..DisconnectivityPicture::new(tree, &Network::default())
        }
    }

    #[test]
    fn pictures_of_all_sizes_are_legible() {
        for (name, count, parts) in [
            ("0", 0, 1),
            ("1", 1, 1),
            ("5", 5, 1),
            ("91", 91, 2),
            ("371", 371, 4),
        ] {
            for labels in [false, true] {
                let canvas = picture(random_tree(11, count, parts), labels)
                    .draw()
                    .unwrap();
                assert_legible(&canvas);
                gallery(
                    &canvas,
                    &format!(
                        "disconnectivity_{name}_{}",
                        if labels { "labels" } else { "plain" }
                    ),
                );
            }
        }
    }

    #[test]
    fn legend_explains_what_is_there_and_nothing_else() {
        let texts = |picture: &DisconnectivityPicture| -> Vec<String> {
            picture
                .draw()
                .unwrap()
                .texts()
                .iter()
                .map(|(text, _)| (*text).to_owned())
                .collect()
        };
        let mut tree = forest(&[0.0, 0.2, 0.1], &[(0.5, &[0, 1]), (1.0, &[2, 3])]);
        let plain = picture(tree.clone(), false);
        let shown = texts(&plain);
        assert!(
            shown.contains(&"grasps".to_owned()) && shown.contains(&"energy E(H, O)".to_owned())
        );
        assert!(
            !shown
                .iter()
                .any(|text| text == "upper bound" || text == "power" || text.starts_with("apart"))
        );
        tree.nodes[4].evidence = Evidence::Chain;
        let shown = texts(&picture(tree, true));
        for expected in ["upper bound", "relaxed", "power"] {
            assert!(
                shown.iter().any(|text| text == expected),
                "{expected} in {shown:?}"
            );
        }
        let apart = forest(&[0.0, 0.2, 0.1], &[(0.5, &[0, 1])]);
        assert!(
            texts(&picture(apart, false))
                .iter()
                .any(|text| text.starts_with("apart"))
        );
    }

    #[test]
    fn many_labels_are_told_apart_and_only_those_that_occur_are_named() {
        let known = (0..Look::OF_HUE).flat_map(|k| {
            let look = |(name, hue)| (format!("{name} {k}"), Look::of_hue(hue, k));
            [("round", Hue::Red), ("flat", Hue::Green)].map(look)
        });
        let mut picture = picture(random_tree(11, 60, 1), false);
        picture.key.known = known.collect();
        for (index, leaf) in picture.leaves.iter_mut().enumerate() {
            leaf.label = Some(match index % 20 {
                0 => "unlisted".to_owned(),
                1 => "mine".to_owned(),
                2 => "yours".to_owned(),
                k => picture.key.known[k - 3].0.clone(),
            });
        }
        let tree = &picture.tree;
        picture.support = vec![Some(0.99); tree.nodes.len()];
        let canvas = picture.draw().unwrap();
        assert_legible(&canvas);
        gallery(&canvas, "disconnectivity_kinds");
        let texts: Vec<&str> = canvas.texts().iter().map(|(text, _)| *text).collect();
        let first = texts.iter().position(|text| *text == "label").unwrap();
        let mut expected: Vec<&str> = (picture.key.known.iter())
            .take(17)
            .map(|(label, _)| label.as_str())
            .collect();
        expected.extend(["mine", "yours", "unlisted", "grasps"]);
        assert_eq!(texts[first + 1..][..expected.len()], expected);
        assert!(texts.contains(&"95 % or more") && !texts.contains(&"70 to 95 %"));

        // More labels than looks, and a crowded tree, in which leaves without label are no dots.
        for (index, leaf) in picture.leaves.iter_mut().enumerate() {
            leaf.label = Some(format!("cup {index}"));
        }
        let shown = |picture: &DisconnectivityPicture, wanted: &str| {
            let canvas = picture.draw().unwrap();
            canvas.texts().iter().any(|(text, _)| *text == wanted)
        };
        assert!(shown(&picture, "some labels look alike"));
        picture.leaves[0].label = None;
        assert!(shown(&picture, "none"));
        let mut crowded = self::picture(random_tree(11, 120, 1), true);
        crowded.leaves[0].label = None;
        assert!(!shown(&crowded, "none") && !shown(&crowded, "some labels look alike"));
    }

    #[test]
    fn captions_appear_and_svg_holds_the_texts() {
        let tree = forest(
            &[-146.7, -108.2, -80.8],
            &[(-72.2, &[1, 2]), (-40.7, &[0, 3])],
        );
        let mut picture = picture(tree, false);
        for (leaf, name) in picture.leaves.iter_mut().zip(["A", "B", "C"]) {
            leaf.caption = Some(name.into());
        }
        let canvas = picture.draw().unwrap();
        assert_legible(&canvas);
        gallery(&canvas, "disconnectivity_captions");
        let svg = canvas.to_svg().unwrap();
        for text in ["Human hand on a bottle", "−100", ">\nA\n", "grasps"]
            .iter()
            .map(|text| text.trim_matches(['>', '\n']))
        {
            assert!(svg.contains(text), "{text}");
        }
        assert_eq!(svg, picture.draw().unwrap().to_svg().unwrap());
    }

    #[test]
    fn merges_carry_their_support() {
        let tree = random_tree(11, 91, 2);
        let mut picture = picture(tree.clone(), true);
        picture.support = (0..tree.nodes.len())
            .map(|node| (node % 5 > 0).then_some(0.25 * (node % 5) as f64))
            .collect();
        let canvas = picture.draw().unwrap();
        assert_legible(&canvas);
        gallery(&canvas, "disconnectivity_support");
        let texts: Vec<&str> = canvas.texts().iter().map(|(text, _)| *text).collect();
        assert!(texts.contains(&"support") && texts.contains(&"70 to 95 %"));
    }

    #[test]
    fn misfits_are_errors() {
        let mut wrong = picture(random_tree(1, 4, 1), false);
        wrong.leaves.pop();
        assert!(matches!(
            wrong.draw(),
            Err(FigureError::Leaves {
                described: 3,
                present: 4
            })
        ));
        let mut wrong = picture(random_tree(1, 4, 1), false);
        wrong.tree.nodes[5].energy = f64::INFINITY;
        assert!(matches!(
            wrong.draw(),
            Err(FigureError::NotFinite { node: 5, .. })
        ));
    }
}
