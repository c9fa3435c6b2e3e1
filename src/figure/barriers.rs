//! The barrier graph: minima in the plane, near each other if the barrier between them is low.

use petgraph::unionfind::UnionFind;

use super::axis::Span;
use super::canvas::Canvas;
use super::layout::place_in;
use super::leaf::{
    DiscScale, LEAST_SYMBOL, Leaf, Looks, draw_title, explain_sizes, leaves_of, most_members,
};
use super::legend::Legend;
use super::look::{Key, Look};
use super::notes::{draw_notes, notes_height};
use super::style::{Anchor, Colour, Stroke, TextFace};
use super::theme::{INK, LINE, MARGIN, PALE_LINE, TEXT, UNLABELLED, WHITE, sequential};
use super::{FigureError, axis, text_width};
use crate::topography::{Evidence, Network};

const LABEL_RADIUS: f64 = 10.0;
/// Width of the line of a typical barrier. `WIDTHS` are the thinnest and the thickest line.
const TYPICAL_WIDTH: f64 = 2.6;
const WIDTHS: [f64; 2] = [0.7, 9.0];
/// Ratio of widths that the eye tells apart.
const DISTINCT: f64 = 1.3;
/// Energies that differ by less than this share of the height of the links differ by rounding.
const ROUNDING: f64 = 1e-9;
/// Difference between heights, relative to the greatest above the lowest minimum, that is rounding: searches know heights to
/// about this.
const TIE: f64 = 1e-6;

/// A connection of two minima.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Numbers of the minima.
    pub ends: [usize; 2],
    /// Highest energy on the path.
    pub height: f64,
    /// Evidence for the height. Links with [`Evidence::None`] are not drawn.
    pub evidence: Evidence,
}

/// Minima as circles, connections as lines.
#[derive(Debug, Clone, PartialEq)]
pub struct BarrierPicture {
    /// Energy of each minimum.
    pub energies: Vec<f64>,
    /// Description of each minimum. Energy colours the circles if no minimum has a label.
    pub leaves: Vec<Leaf>,
    /// Looks of known labels.
    pub key: Key,
    /// The connections.
    pub links: Vec<Link>,
    /// What names of leaves mean: lines below the picture, each a name and a text.
    pub notes: Vec<(String, String)>,
    /// Title; empty for none.
    pub title: String,
    /// Name of the energy, for the colour bar.
    pub energy_label: String,
    /// Plural noun for the members that the circles count.
    pub members_label: String,
    /// Seed of the layout. It matters only if the layout is ambiguous.
    pub seed: u64,
    /// Width and height in canvas units.
    pub size: [u32; 2],
}

/// Where a [`BarrierPicture`] has its circles and lines, for programs that paint them themselves.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlacedGraph {
    /// Centre of each circle.
    pub points: Vec<[f64; 2]>,
    /// Radius of each circle.
    pub radii: Vec<f64>,
    /// The lines.
    pub lines: Vec<PlacedLink>,
}

/// A line of a [`PlacedGraph`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedLink {
    /// The connection, its lower end first.
    pub link: Link,
    /// Width of the line.
    pub width: f64,
    /// Whether no detour over other connections is lower.
    pub is_lowest: bool,
}

impl BarrierPicture {
    /// Largest number of minima of a picture. More circles and lines would hide each other, and the cost of the layout
    /// grows with the number of pairs.
    pub const MOST_NODES: usize = 500;

    /// Picture of `network`, without labels.
    pub fn new(network: &Network) -> Self {
        let links = network.raw_edges().iter().map(|edge| Link {
            ends: [edge.source().index(), edge.target().index()],
            height: edge.weight.height,
            evidence: edge.weight.evidence,
        });
        Self {
            energies: network
                .node_weights()
                .map(|minimum| minimum.energy)
                .collect(),
            leaves: leaves_of(network),
            key: Key::default(),
            links: links.collect(),
            notes: Vec::new(),
            title: String::new(),
            energy_label: "energy".to_owned(),
            members_label: "members".to_owned(),
            seed: 0,
            size: [1200, 860],
        }
    }

    /// Height of a link above the higher of its ends.
    fn barrier(&self, link: &Link) -> f64 {
        let [a, b] = link.ends.map(|end| self.energies[end]);
        (link.height - a.max(b)).clamp(0.0, f64::MAX)
    }

    /// Draws the picture.
    ///
    /// Distances in the plane follow path lengths over the square roots of relative barriers (height above the higher end).
    /// Minimax heights would form an ultrametric, which the plane cannot show. The width of a line is ∝ barrier^(−½). A
    /// line is dashed if only an upper bound is known, and dark if it belongs to the spanning tree of lowest barriers.
    ///
    /// # Errors
    /// [`FigureError::Leaves`], [`FigureError::NoSuchNode`] or [`FigureError::NotFinite`] if the fields are inconsistent;
    /// [`FigureError::TooMany`] for more minima than [`BarrierPicture::MOST_NODES`].
    pub fn draw(&self) -> Result<Canvas, FigureError> {
        self.check()?;
        let links = self.drawn_links();
        let widths = Widths::new(self, &links);
        let room = notes_height(self.notes.len());
        let mut canvas = Canvas::new(self.size[0], self.size[1] + room);
        let top = draw_title(&mut canvas, &self.title);
        let bottom = f64::from(self.size[1]);
        let area = 0.75 * canvas.width() * (bottom - top);
        let scale = self.disc_scale(area);
        let legend = self.legend(&links, &widths, scale);
        let right = canvas.width() - MARGIN - legend.width();
        legend.draw(&mut canvas, [right, top], bottom - MARGIN);
        draw_notes(&mut canvas, &self.notes);
        let frame = [[MARGIN, top], [right - 34.0, bottom - MARGIN]];
        if self.energies.is_empty() {
            let face = TextFace::new(TEXT, INK).anchored(Anchor::Middle);
            canvas.text(
                [
                    0.5 * (frame[0][0] + frame[1][0]),
                    0.5 * (frame[0][1] + frame[1][1]),
                ],
                "no minima",
                face,
            );
        }
        let (points, radii) = self.place(frame, scale, &links, &widths);
        draw_links(&mut canvas, &links, &widths, &points);
        self.draw_nodes(&mut canvas, &points, &radii, frame);
        Ok(canvas)
    }

    /// The circles and lines of the picture on a sheet of its size without title and legend.
    ///
    /// # Errors
    /// As [`BarrierPicture::draw`].
    pub fn placed(&self) -> Result<PlacedGraph, FigureError> {
        self.check()?;
        let links = self.drawn_links();
        let widths = Widths::new(self, &links);
        let [width, height] = self.size.map(f64::from);
        let frame = [[MARGIN; 2], [width - MARGIN, height - MARGIN]];
        let scale = self.disc_scale(0.75 * width * height);
        let (points, radii) = self.place(frame, scale, &links, &widths);
        let line = |(index, &link): (usize, &Link)| PlacedLink {
            link,
            width: widths.width(widths.barriers[index]),
            is_lowest: widths.is_lowest[index],
        };
        Ok(PlacedGraph {
            points,
            radii,
            lines: links.iter().enumerate().map(line).collect(),
        })
    }

    fn drawn_links(&self) -> Vec<Link> {
        let drawn = |link: &&Link| link.evidence != Evidence::None && link.height.is_finite();
        lowest_links(self.links.iter().filter(drawn).copied())
    }

    fn place(
        &self,
        frame: [[f64; 2]; 2],
        scale: DiscScale,
        links: &[Link],
        widths: &Widths,
    ) -> (Vec<[f64; 2]>, Vec<f64>) {
        let radii: Vec<f64> = (self.leaves.iter())
            .map(|leaf| scale.radius(leaf.members))
            .collect();
        let ends: Vec<([usize; 2], f64)> = widths.links(links).collect();
        (place_in(frame, &radii, &ends, self.seed), radii)
    }

    fn check(&self) -> Result<(), FigureError> {
        let present = self.energies.len();
        if self.leaves.len() != present {
            return Err(FigureError::Leaves {
                described: self.leaves.len(),
                present,
            });
        }
        FigureError::check_count(present, Self::MOST_NODES)?;
        if let Some((node, &energy)) = self
            .energies
            .iter()
            .enumerate()
            .find(|(_, energy)| !energy.is_finite())
        {
            return Err(FigureError::NotFinite { node, energy });
        }
        match self
            .links
            .iter()
            .flat_map(|link| link.ends)
            .find(|&end| end >= present)
        {
            Some(node) => Err(FigureError::NoSuchNode { node, present }),
            None => Ok(()),
        }
    }

    /// Scale at which circles cover about a tenth of the plane.
    fn disc_scale(&self, area: f64) -> DiscScale {
        let total: usize = self.leaves.iter().map(|leaf| leaf.members.max(1)).sum();
        let most = most_members(&self.leaves);
        let one = (0.06 * area / (std::f64::consts::PI * total.max(1) as f64)).sqrt();
        let scale = DiscScale::by_members(one.clamp(3.0, 16.0).min(40.0 / most.sqrt()));
        if Looks::of(&self.leaves, &self.key).have_symbols() {
            return scale.at_least(LEAST_SYMBOL);
        }
        scale
    }

    /// The range of the energies of minima; empty if they differ by rounding only, compared with the links.
    fn energy_range(&self) -> Span {
        let low = self.energies.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self
            .energies
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let heights = self.links.iter().map(|link| link.height);
        let highest = heights.filter(|height| height.is_finite());
        let highest = highest.fold(high, f64::max);
        if high - low <= ROUNDING * (highest - low) {
            return Span { low, high: low };
        }
        Span { low, high }
    }

    fn legend(&self, links: &[Link], widths: &Widths, scale: DiscScale) -> Legend {
        let mut legend = Legend::default();
        let looks = Looks::of(&self.leaves, &self.key);
        looks.explain(LABEL_RADIUS, &mut legend);
        let Span { low, high } = self.energy_range();
        if looks.is_empty() && high > low {
            legend.heading(&self.energy_label);
            legend.bar(low, high);
        }
        explain_sizes(
            &self.leaves,
            scale,
            &self.members_label,
            UNLABELLED,
            &mut legend,
        );
        if links.is_empty() {
            return legend;
        }
        legend.heading("barrier");
        for (barrier, text) in widths.explained() {
            legend.line(Stroke::solid(LINE, widths.width(barrier)), &text);
        }
        if widths.is_lowest.contains(&false) {
            legend.line(Stroke::solid(PALE_LINE, TYPICAL_WIDTH), "a detour is lower");
        }
        if links.iter().any(|link| link.evidence > Evidence::Path) {
            legend.line(dashed(LINE, TYPICAL_WIDTH), "upper bound");
        }
        legend
    }

    fn draw_nodes(
        &self,
        canvas: &mut Canvas,
        points: &[[f64; 2]],
        radii: &[f64],
        frame: [[f64; 2]; 2],
    ) {
        let looks = Looks::of(&self.leaves, &self.key);
        let range = self.energy_range();
        for (node, (&point, &radius)) in points.iter().zip(radii).enumerate() {
            let look = if looks.is_empty() && range.high > range.low {
                Look::disc(sequential(range.part(self.energies[node])))
            } else {
                looks.look(&self.leaves[node])
            };
            canvas.symbol(look.symbol, point, (radius, 3.0), WHITE);
            look.draw(canvas, point, radius, 1.2);
        }
        for (leaf, (&[x, y], &radius)) in self.leaves.iter().zip(points.iter().zip(radii)) {
            let Some(caption) = leaf.caption.as_deref() else {
                continue;
            };
            let (size, half) = (0.85 * TEXT, 0.5 * text_width(caption, 0.85 * TEXT, false));
            let x = x.clamp(
                frame[0][0] + half,
                (frame[1][0] - half).max(frame[0][0] + half),
            );
            let [_, up, down] = looks.look(leaf).symbol.reach();
            let above = y - up * radius - 0.7 * size;
            let y = if above - 0.5 * size < frame[0][1] {
                y + down * radius + 0.7 * size
            } else {
                above
            };
            let shade = WHITE.with_opacity(0.75);
            canvas.rectangle(
                [x - half - 3.0, y - 0.5 * size],
                [x + half + 3.0, y + 0.5 * size],
                shade,
            );
            canvas.text(
                [x, y],
                caption,
                TextFace::new(size, INK).anchored(Anchor::Middle),
            );
        }
    }
}

/// The lowest link of each pair, without loops, sorted by ends. Among equal heights the best evidence is kept.
fn lowest_links(links: impl Iterator<Item = Link>) -> Vec<Link> {
    let sorted = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
    let mut links: Vec<Link> = links
        .map(|link| Link {
            ends: sorted(link.ends),
            ..link
        })
        .collect();
    links.retain(|link| link.ends[0] != link.ends[1]);
    links.sort_by(|a, b| {
        a.ends
            .cmp(&b.ends)
            .then(a.height.total_cmp(&b.height))
            .then(a.evidence.cmp(&b.evidence))
    });
    links.dedup_by_key(|link| link.ends);
    links
}

fn dashed(colour: Colour, width: f64) -> Stroke {
    Stroke::dashed(colour, width, 9.0, 7.0)
}

fn draw_links(canvas: &mut Canvas, links: &[Link], widths: &Widths, points: &[[f64; 2]]) {
    // Pale lines before dark ones and thin lines before thick ones.
    let mut order: Vec<usize> = (0..links.len()).collect();
    order.sort_by(|&a, &b| {
        let by_barrier = widths.barriers[b].total_cmp(&widths.barriers[a]);
        widths.is_lowest[a]
            .cmp(&widths.is_lowest[b])
            .then(by_barrier)
            .then(a.cmp(&b))
    });
    for index in order {
        let link = &links[index];
        let width = widths.width(widths.barriers[index]);
        let colour = if widths.is_lowest[index] {
            LINE
        } else {
            PALE_LINE.with_opacity(0.55)
        };
        let stroke = if link.evidence > Evidence::Path {
            dashed(colour, width)
        } else {
            Stroke::solid(colour, width)
        };
        canvas.line(points[link.ends[0]], points[link.ends[1]], stroke);
    }
}

/// Widths and lengths of links from their barriers.
#[derive(Debug)]
struct Widths {
    /// Relative barrier of each link.
    barriers: Vec<f64>,
    /// Whether no detour over other links is lower by more than rounding.
    is_lowest: Vec<bool>,
    /// Median barrier over these. A link of this barrier has the typical width and length 1.
    typical: f64,
}

impl Widths {
    fn new(picture: &BarrierPicture, links: &[Link]) -> Self {
        let barriers: Vec<f64> = links.iter().map(|link| picture.barrier(link)).collect();
        let mut order: Vec<usize> = (0..links.len()).collect();
        order.sort_by(|&a, &b| {
            links[a]
                .height
                .total_cmp(&links[b].height)
                .then(barriers[a].total_cmp(&barriers[b]))
                .then(a.cmp(&b))
        });
        let lowest = picture
            .energies
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let heights = links.iter().map(|link| link.height - lowest);
        let rounding = TIE * heights.fold(0.0, f64::max);
        let mut sets = UnionFind::new(picture.energies.len());
        let mut is_lowest = vec![false; links.len()];
        for level in order.chunk_by(|&a, &b| links[b].height - links[a].height <= rounding) {
            for &index in level {
                let [a, b] = links[index].ends;
                is_lowest[index] = !sets.equiv(a, b);
            }
            for &index in level {
                let [a, b] = links[index].ends;
                sets.union(a, b);
            }
        }
        let mut direct: Vec<f64> = barriers
            .iter()
            .zip(&is_lowest)
            .filter(|(barrier, kept)| **kept && **barrier > 0.0)
            .map(|(b, _)| *b)
            .collect();
        direct.sort_by(f64::total_cmp);
        let typical = direct.get(direct.len() / 2).copied().unwrap_or(1.0);
        Self {
            barriers,
            is_lowest,
            typical,
        }
    }

    fn width(&self, barrier: f64) -> f64 {
        (TYPICAL_WIDTH * self.typical / barrier.max(f64::MIN_POSITIVE)).clamp(WIDTHS[0], WIDTHS[1])
    }

    /// Length of a link in the layout. It grows with the barrier but is never zero, so that circles do not coincide, and it
    /// is bounded, so that one huge barrier does not shrink everything else.
    fn length(&self, barrier: f64) -> f64 {
        0.35 + 0.65 * (barrier / self.typical).sqrt().min(5.0)
    }

    /// Ends and lengths of the links.
    fn links(&self, links: &[Link]) -> impl Iterator<Item = ([usize; 2], f64)> {
        let barriers = links.iter().zip(&self.barriers);
        barriers.map(|(link, &barrier)| (link.ends, self.length(barrier)))
    }

    /// Low, typical and high barriers with their texts, for the legend: only barriers whose widths can be told apart.
    fn explained(&self) -> Vec<(f64, String)> {
        let mut sorted = self.barriers.clone();
        sorted.sort_by(f64::total_cmp);
        let at = |tenths: usize| sorted[(sorted.len() - 1) * tenths / 10];
        let (low, high) = (at(1), at(9));
        // Beyond these barriers all lines have the thickest and the thinnest width.
        let [thinnest, thickest] = WIDTHS.map(|width| TYPICAL_WIDTH * self.typical / width);
        let explained = |barrier: f64| {
            let (barrier, sign) = if barrier < thickest {
                (thickest, "≤ ")
            } else if barrier > thinnest {
                (thinnest, "≥ ")
            } else {
                (barrier, "")
            };
            (barrier, format!("{sign}{}", axis::number(barrier)))
        };
        let mut values = vec![explained(low)];
        for barrier in [self.typical.clamp(low, high), high] {
            let (barrier, text) = explained(barrier);
            let before = values
                .last()
                .map_or(f64::INFINITY, |last| self.width(last.0));
            if before > DISTINCT * self.width(barrier) {
                values.push((barrier, text));
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_legible, gallery, random_network};
    use super::*;

    fn picture(count: usize, parts: usize, labels: bool) -> BarrierPicture {
        let mut picture = BarrierPicture {
            title: "Human hand on a bottle".into(),
            members_label: "grasps".into(),
            ..BarrierPicture::new(&random_network(7, count, parts))
        };
        for (index, leaf) in picture.leaves.iter_mut().enumerate().filter(|_| labels) {
            leaf.label =
                Some(["power", "precision", "intermediate"][(index * index / 5) % 3].to_owned());
        }
        picture
    }

    #[test]
    fn pictures_of_all_sizes_are_legible() {
        for (name, count, parts) in [
            ("0", 0, 1),
            ("1", 1, 1),
            ("5", 5, 1),
            ("91", 91, 9),
            ("371", 371, 2),
        ] {
            for labels in [false, true] {
                let canvas = picture(count, parts, labels).draw().unwrap();
                assert_legible(&canvas);
                gallery(
                    &canvas,
                    &format!(
                        "barriers_{name}_{}",
                        if labels { "labels" } else { "plain" }
                    ),
                );
            }
        }
    }

    #[test]
    fn circles_keep_apart_and_on_the_sheet() {
        let picture = picture(91, 9, false);
        let radii: Vec<f64> = picture
            .leaves
            .iter()
            .map(|leaf| 6.0 * (leaf.members as f64).sqrt())
            .collect();
        let widths = Widths::new(&picture, &picture.links);
        let links: Vec<_> = widths.links(&picture.links).collect();
        let points = place_in([[0.0, 0.0], [900.0, 800.0]], &radii, &links, picture.seed);
        for i in 0..91 {
            assert!((0..2).all(|axis| points[i][axis] >= radii[i]
                && points[i][axis] <= [900.0, 800.0][axis] - radii[i]));
            for j in 0..i {
                let length = libm::hypot(points[i][0] - points[j][0], points[i][1] - points[j][1]);
                assert!(
                    length > radii[i] + radii[j],
                    "{i} and {j} overlap: {length}"
                );
            }
        }
    }

    #[test]
    fn low_barriers_are_thick_and_short() {
        let picture = picture(60, 1, false);
        let widths = Widths::new(&picture, &picture.links);
        assert!(
            widths.width(0.0) > widths.width(widths.typical)
                && widths.width(widths.typical) > widths.width(1e9)
        );
        // The eye tells lines apart whose barriers differ by half.
        assert!(widths.width(widths.typical) > 1.45 * widths.width(1.5 * widths.typical));
        assert!(widths.length(0.0) < widths.length(widths.typical));
        assert_eq!(widths.is_lowest.iter().filter(|kept| **kept).count(), 59);
    }

    #[test]
    fn no_detour_is_lower_by_rounding() {
        let mut picture = picture(3, 1, false);
        picture.energies = vec![0.0; 3];
        let link = |ends, height| Link {
            ends,
            height,
            evidence: Evidence::Saddle,
        };
        picture.links = vec![
            link([0, 1], 1.0),
            link([1, 2], 1.0 + 1e-9),
            link([0, 2], 1.0 + 2e-9),
        ];
        let lowest = |picture: &BarrierPicture| Widths::new(picture, &picture.links).is_lowest;
        assert_eq!(lowest(&picture), [true; 3]);
        picture.links[2].height = 1.01;
        assert_eq!(lowest(&picture), [true, true, false]);
    }

    #[test]
    fn lines_of_the_legend_can_be_told_apart() {
        let picture = picture(60, 1, false);
        let mut widths = Widths::new(&picture, &picture.links);
        let typical = widths.typical;
        // Most barriers are so high that their lines have the thinnest width.
        for (index, barrier) in widths.barriers.iter_mut().enumerate() {
            *barrier = typical * [1.0, 10.0, 30.0, 100.0, 300.0][index % 5];
        }
        let texts: Vec<String> = widths
            .explained()
            .into_iter()
            .map(|(_, text)| text)
            .collect();
        let thinnest = format!("≥ {}", axis::number(TYPICAL_WIDTH * typical / WIDTHS[0]));
        assert_eq!(texts, [axis::number(typical), thinnest]);
        widths.barriers.fill(typical);
        assert_eq!(widths.explained().len(), 1);
    }

    #[test]
    fn unreached_pairs_have_no_line_and_bounds_are_explained() {
        let mut picture = picture(5, 1, false);
        picture.links = vec![
            Link {
                ends: [0, 1],
                height: f64::INFINITY,
                evidence: Evidence::None,
            },
            Link {
                ends: [1, 2],
                height: picture.energies[2] + 0.5,
                evidence: Evidence::Chain,
            },
        ];
        let svg = picture.draw().unwrap().to_svg().unwrap();
        assert!(svg.contains("upper bound") && svg.contains("0.5") && svg.contains("grasps"));
        picture.links.pop();
        let svg = picture.draw().unwrap().to_svg().unwrap();
        assert!(!svg.contains("upper bound") && !svg.contains("barrier"));
        picture.links[0].ends = [0, 9];
        assert!(matches!(
            picture.draw(),
            Err(FigureError::NoSuchNode {
                node: 9,
                present: 5
            })
        ));
    }

    /// Minima of one energy, which descents tell apart by rounding.
    #[test]
    fn rounding_has_no_colours() {
        let mut picture = picture(4, 1, false);
        picture.energies = vec![5e-21, 7e-20, 7.9e-18, 7.9e-18];
        picture.links = vec![Link {
            ends: [0, 2],
            height: 1.0,
            evidence: Evidence::Saddle,
        }];
        let range = picture.energy_range();
        assert!(range.high <= range.low);
        let told = |picture: &BarrierPicture| {
            let canvas = picture.draw().unwrap();
            let texts = canvas.texts();
            texts.iter().any(|(text, _)| *text == picture.energy_label)
        };
        assert!(!told(&picture));
        picture.energies[2] = 0.1;
        assert!(told(&picture));
    }

    #[test]
    fn pairs_keep_the_lowest_link() {
        let link = |ends, height| Link {
            ends,
            height,
            evidence: Evidence::Path,
        };
        let links = [link([0, 1], 9.0), link([1, 0], 7.0), link([0, 0], 1.5)];
        assert_eq!(lowest_links(links.into_iter()), [link([0, 1], 7.0)]);
    }

    #[test]
    fn captions_and_determinism() {
        let mut picture = picture(8, 1, false);
        for (index, leaf) in picture.leaves.iter_mut().enumerate() {
            leaf.caption = Some(format!("M{index}"));
        }
        let canvas = picture.draw().unwrap();
        gallery(&canvas, "barriers_captions");
        assert_eq!(
            canvas.to_svg().unwrap(),
            picture.draw().unwrap().to_svg().unwrap()
        );
    }
}
