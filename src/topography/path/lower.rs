//! Lowers the top of a path over a kinked energy, seam by seam.
//!
//! If the kinks of an envelope E = min over pieces are close together, a string never converges, because its images switch
//! from piece to piece. Such a path is a sequence of pieces, and its height is decided where it changes from one piece to
//! the next: between two crossings, a straight line through one smooth piece rises little above its ends. The crossing of
//! two pieces can descend along their seam independently of the rest of the path. So the highest crossing is moved down its
//! seam until it converges or a third piece is lower than both. The path then goes through that piece, and its top is one
//! of the two new seams. A move counts only if the highest point of the path falls.

use std::cell::OnceCell;

use super::pass::{Pass, Peak};
use super::seam::{Sheet, slide};
use super::{Path, PathSettings, SeamSettings, near};
use crate::energy::Energy;
use crate::space::Space;
use crate::space::vector::{dot, norm, scale};
use crate::topography::eigen::Piece;

const GOLDEN: f64 = 0.381_966_011_250_105;
/// Golden-section probes between two nodes.
const PROBES: usize = 10;
/// Greatest number of segments searched for the top, besides those with a node above it.
const SEARCHED: usize = 8;
/// Number of move lengths tried; each is `SHORTER` times the previous one.
const TRIALS: usize = 4;
const SHORTER: f64 = 0.4;
/// Distance over which the neighbours of the top follow it, in lengths of its move.
const WIDTH: f64 = 4.0;
/// Thresholds, as fractions of the energy tolerance: by how much a third piece must undercut a seam, by how much two pieces
/// may differ on it, and by how much a top must fall.
const UNDERCUT: f64 = 0.05;
const TIE: f64 = 1e-3;
const GAIN: f64 = 1e-3;
/// Height above the ends from which choices are not proven optimal, in units of the height at which evaluations become
/// rough. Without proofs just above that, a few tops stay too high; with proofs everywhere, a map takes 50 % longer.
const HOPELESS: f64 = 4.0;

#[derive(Clone)]
struct Node {
    x: Vec<f64>,
    energy: f64,
    gradient: Vec<f64>,
    choice: OnceCell<Vec<u32>>,
}

/// A polygon through the pieces of a kinked energy.
struct Kinked<'e> {
    energy: &'e dyn Energy,
    settings: &'e PathSettings,
    /// Energy above which evaluations are rough.
    ceiling: f64,
    /// Energy above which choices are not proven optimal.
    hopeless: f64,
    /// Greatest distance between nodes.
    spacing: f64,
    /// Smallest fall of the top that counts.
    gain: f64,
    nodes: Vec<Node>,
}

struct Top {
    segment: usize,
    energy: f64,
    x: Vec<f64>,
    /// Nearby points of the path before and after it.
    sides: [Vec<f64>; 2],
}

/// A path whose top was lowered as far as possible.
pub(super) struct Lowered {
    pub(super) path: Path,
    pub(super) peak: Peak,
    /// Whether no move lowers the top any more *and* halving the node distance hardly changed its height.
    pub(super) relaxed: bool,
}

/// Lowers the top of the polygon through `images`. Returns `None` if no point between its ends is finite.
pub(super) fn lower(
    energy: &dyn Energy,
    images: &[Vec<f64>],
    floor: f64,
    settings: &PathSettings,
    seams: &SeamSettings,
) -> Option<Lowered> {
    let mut path = Kinked::new(energy, images, seams.spacing, floor, settings);
    let mut top = path.top(f64::INFINITY)?;
    path.lower(&mut top, seams.moves);
    let mut relaxed = false;
    for halving in 1..=seams.halvings {
        path.spacing = seams.spacing * 0.5_f64.powi(i32::try_from(halving).unwrap_or(i32::MAX));
        path.refine();
        let before = top.energy;
        top = path.top(f64::INFINITY)?;
        let change = top.energy - before;
        let rests = path.lower(&mut top, seams.moves);
        relaxed = rests && change.abs() <= settings.slack(top.energy - floor);
        if relaxed {
            break;
        }
    }
    Some(Lowered {
        relaxed,
        peak: path.peak(&top),
        path: path.path(&top),
    })
}

/// The path with its top replaced by `pass`, if no point between its ends is higher than the pass.
pub(super) fn over(
    energy: &dyn Energy,
    path: &Path,
    pass: &Pass,
    floor: f64,
    settings: &PathSettings,
    seams: &SeamSettings,
) -> Option<Path> {
    let mut images = path.images.clone();
    images[path.top()].clone_from(&pass.x);
    let spacing = 0.5 * seams.spacing;
    let polygon = Kinked::new(energy, &images, spacing, floor, settings);
    let top = polygon.top(f64::INFINITY)?;
    let slack = settings.slack(pass.energy - floor);
    (top.energy <= pass.energy + slack).then(|| polygon.path(&top))
}

impl<'e> Kinked<'e> {
    fn new(
        energy: &'e dyn Energy,
        images: &[Vec<f64>],
        spacing: f64,
        floor: f64,
        settings: &'e PathSettings,
    ) -> Self {
        let mut path = Self {
            energy,
            settings,
            ceiling: floor + settings.exact_below,
            hopeless: floor + HOPELESS * settings.exact_below,
            spacing,
            gain: GAIN * settings.energy_tolerance,
            nodes: Vec::new(),
        };
        path.nodes = images.iter().map(|x| path.node(x.clone())).collect();
        path.refine();
        path
    }

    /// A thinned path: the ends, the top, and images between them at half the longest step.
    fn path(&self, top: &Top) -> Path {
        let mut path = Path::default();
        let mut keep = |x: &[f64], energy: f64, always: bool| {
            let far = path.images.last().is_none_or(|last: &Vec<f64>| {
                near(self.space(), last, x) >= 0.5 * self.settings.max_step
            });
            if always || far {
                path.images.push(x.to_vec());
                path.energies.push(energy);
            }
        };
        let last = self.nodes.len() - 1;
        for (i, node) in self.nodes.iter().enumerate() {
            keep(&node.x, node.energy, i == last);
            if i == top.segment {
                keep(&top.x, top.energy, true);
            }
        }
        path
    }

    fn space(&self) -> &'e dyn Space {
        self.energy.space()
    }

    fn node(&self, x: Vec<f64>) -> Node {
        let mut gradient = vec![0.0; self.space().tangents()];
        let (energy, choice) = self
            .energy
            .evaluate_roughly_above(&x, &mut gradient, self.ceiling);
        Node {
            x,
            energy,
            gradient,
            choice: if self.settled(energy) {
                choice.into()
            } else {
                OnceCell::new()
            },
        }
    }

    /// Whether to use the choice that came with this energy. Above the ceiling it may not be the best one, but far above it
    /// the proof would take longer than everything else.
    fn settled(&self, energy: f64) -> bool {
        !(energy > self.ceiling && energy < self.hopeless)
    }

    /// The choice at `node`, computed on demand because proofs at high energies are slow.
    fn choice<'n>(&self, node: &'n Node) -> &'n [u32] {
        node.choice
            .get_or_init(|| self.energy.active_piece(&node.x))
    }

    /// Adds nodes between those farther apart than the spacing.
    fn refine(&mut self) {
        let mut nodes = Vec::new();
        for node in std::mem::take(&mut self.nodes) {
            if let Some(last) = nodes.last() {
                let between = self.between_ends(last, &node);
                nodes.extend(between.map(|x| self.node(x)));
            }
            nodes.push(node);
        }
        self.nodes = nodes;
    }

    /// Points that divide the straight line between two nodes into parts no longer than the spacing.
    fn between_ends(
        &self,
        from: &Node,
        to: &Node,
    ) -> impl DoubleEndedIterator<Item = Vec<f64>> + use<'e> {
        let space = self.space();
        let mut tangent = vec![0.0; space.tangents()];
        let length = space.log_near(&from.x, &to.x, &mut tangent);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small positive count"
        )]
        let parts = (length / self.spacing).ceil().max(1.0) as usize;
        let start = from.x.clone();
        (1..parts).map(move |k| {
            let mut step = tangent.clone();
            scale(&mut step, k as f64 / parts as f64);
            let mut x = start.clone();
            space.exp(&mut x, &step);
            x
        })
    }

    /// The highest point of the path, which may lie between nodes far below it. Where the path is concave between two nodes
    /// it lies below both tangents. Segments are searched in the order of this bound, until none can be higher. `None` if
    /// no point is finite, or as soon as a point reaches `limit`.
    fn top(&self, limit: f64) -> Option<Top> {
        let space = self.space();
        let mut tangent = vec![0.0; space.tangents()];
        let last = self.nodes.len() - 1;
        if self.nodes[1..last]
            .iter()
            .any(|node| node.energy >= limit && limit.is_finite())
        {
            return None;
        }
        let mut bounds: Vec<(f64, usize)> = Vec::new();
        for (i, pair) in self.nodes.windows(2).enumerate() {
            let (low, high) = (pair[0].energy, pair[1].energy);
            let mut bound = low.max(high);
            space.log_near(&pair[0].x, &pair[1].x, &mut tangent);
            let rise = dot(&pair[0].gradient, &tangent);
            space.log_near(&pair[1].x, &pair[0].x, &mut tangent);
            let fall = dot(&pair[1].gradient, &tangent);
            if rise > 0.0 && fall > 0.0 {
                let s = ((high - low + fall) / (rise + fall)).clamp(0.0, 1.0);
                bound = bound.max((low + s * rise).min(high + (1.0 - s) * fall));
            }
            if bound.is_finite() {
                bounds.push((bound, i));
            }
        }
        bounds.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut best: Option<Top> = None;
        for (searched, (bound, i)) in bounds.into_iter().enumerate() {
            if best.as_ref().is_some_and(|best| best.energy >= bound) {
                break;
            }
            // A known node counts, however many bounds lie above it.
            let met = self.nodes[i].energy.max(self.nodes[i + 1].energy);
            if searched >= SEARCHED && best.as_ref().is_some_and(|best| best.energy >= met) {
                continue;
            }
            let top = self.between(i, limit);
            if top.energy >= limit {
                return None;
            }
            if best.as_ref().is_none_or(|best| top.energy > best.energy) {
                best = Some(top);
            }
        }
        best
    }

    /// The highest point of segment `i` (with its ends) by golden section, or the first point found that reaches `limit`.
    fn between(&self, i: usize, limit: f64) -> Top {
        let space = self.space();
        let (from, to) = (&self.nodes[i], &self.nodes[i + 1]);
        let mut along = vec![0.0; space.tangents()];
        let length = space.log_near(&from.x, &to.x, &mut along);
        let mut gradient = along.clone();
        let point = |s: f64| {
            let mut step = along.clone();
            scale(&mut step, s);
            let mut x = from.x.clone();
            space.exp(&mut x, &step);
            x
        };
        let mut height = |s: f64| {
            self.energy
                .evaluate_roughly_above(&point(s), &mut gradient, self.ceiling)
                .0
        };
        let (mut low, mut middle, mut high) = (0.0, GOLDEN, 1.0);
        let mut value = height(middle);
        for _ in 0..PROBES {
            if value >= limit {
                break;
            }
            let right = high - middle > middle - low;
            let probe = if right {
                middle + GOLDEN * (high - middle)
            } else {
                middle - GOLDEN * (middle - low)
            };
            let there = height(probe);
            if there > value && there.is_finite() {
                *(if right { &mut low } else { &mut high }) = middle;
                (middle, value) = (probe, there);
            } else {
                *(if right { &mut high } else { &mut low }) = probe;
            }
        }
        let (mut x, mut sides) = (point(middle), [point(low), point(high)]);
        // If the path is highest at a node, the point after it lies on another segment.
        let reach = (high - low) * length;
        let last = self.nodes.len() - 1;
        if from.energy > value && i > 0 {
            sides = [self.beside(i, i - 1, reach), point(high - low)];
            (x, value) = (from.x.clone(), from.energy);
        } else if to.energy > value && i + 1 < last {
            sides = [point(1.0 - (high - low)), self.beside(i + 1, i + 2, reach)];
            (x, value) = (to.x.clone(), to.energy);
        }
        Top {
            segment: i,
            energy: value,
            x,
            sides,
        }
    }

    /// The point at distance `reach` from node `at` toward node `toward`.
    fn beside(&self, at: usize, toward: usize, reach: f64) -> Vec<f64> {
        let space = self.space();
        let mut step = vec![0.0; space.tangents()];
        let length = space.log_near(&self.nodes[at].x, &self.nodes[toward].x, &mut step);
        scale(&mut step, (reach / length.max(f64::MIN_POSITIVE)).min(1.0));
        let mut x = self.nodes[at].x.clone();
        space.exp(&mut x, &step);
        x
    }

    /// The end of a slide from `top` along its seam: converged, at a lower third piece, or at its greatest length.
    fn slid(&self, top: &Top, choices: &[Vec<u32>; 2]) -> Vec<f64> {
        let reach = 2.0 * self.settings.max_step;
        let pieces = [0, 1].map(|side: usize| Piece::new(self.energy, choices[side].clone()));
        let mut gradient = vec![0.0; self.space().tangents()];
        let tangent = pieces[0].scaled(&self.peak(top).tangent);
        let sheet = if choices[0] == choices[1] {
            Sheet::Across(&pieces[0], &tangent)
        } else {
            Sheet::Seam([&pieces[0], &pieces[1]])
        };
        let found = slide(
            &sheet,
            &top.x,
            (
                self.settings.force_tolerance,
                TIE * self.settings.energy_tolerance,
            ),
            self.settings.max_step,
            self.settings.refinement_steps,
            &mut |x, height| {
                let undercut = height - UNDERCUT * self.settings.energy_tolerance;
                self.energy.evaluate_below(x, &mut gradient, undercut) < undercut
                    || near(self.space(), &top.x, x) > reach
            },
        );
        found.x
    }

    /// The path with its section through the two pieces at `top` rerouted over `tip`; `None` if it reaches `limit`.
    fn through_seam(
        &self,
        top: &Top,
        choices: &[Vec<u32>; 2],
        tip: &Node,
        limit: f64,
    ) -> Option<Self> {
        let mut first = top.segment;
        while first > 0 && self.choice(&self.nodes[first - 1]) == choices[0] {
            first -= 1;
        }
        let last = self.nodes.len() - 1;
        let mut end = (top.segment + 1).min(last);
        while end < last && self.choice(&self.nodes[end + 1]) == choices[1] {
            end += 1;
        }
        let low = |node: &Node| node.energy < limit;
        if !low(&self.nodes[first]) || !low(&self.nodes[end]) {
            return None;
        }
        // From the tip down, because points that are too high are next to it.
        let below = |x| Some(self.node(x)).filter(low);
        let down = self.between_ends(&self.nodes[first], tip).rev();
        let down: Vec<Node> = down.map(below).collect::<Option<_>>()?;
        let up = self.between_ends(tip, &self.nodes[end]);
        let up: Vec<Node> = up.map(below).collect::<Option<_>>()?;
        let mut nodes = self.nodes[..=first].to_vec();
        nodes.extend(down.into_iter().rev());
        nodes.push(tip.clone());
        nodes.extend(up);
        nodes.extend_from_slice(&self.nodes[end..]);
        Some(self.with(nodes))
    }

    fn with(&self, nodes: Vec<Node>) -> Self {
        Self { nodes, ..*self }
    }

    /// The path with its top moved to `tip` by the tangent `move_by`. Nodes within `width` follow by a fraction that falls
    /// to zero at that distance. `None` if a node reaches `limit`.
    fn dragged(
        &self,
        top: &Top,
        tip: &Node,
        move_by: &[f64],
        width: f64,
        limit: f64,
    ) -> Option<Self> {
        let space = self.space();
        let last = self.nodes.len() - 1;
        let sides: [Vec<usize>; 2] = [
            (1..=top.segment).rev().collect(),
            (top.segment + 1..last).collect(),
        ];
        let mut nodes = self.nodes.clone();
        for side in &sides {
            let (mut here, mut away) = (&top.x, 0.0);
            for &i in side {
                away += near(space, here, &self.nodes[i].x);
                if away >= width {
                    break;
                }
                here = &self.nodes[i].x;
                let mut step = move_by.to_vec();
                scale(&mut step, 1.0 - away / width);
                let mut x = here.clone();
                space.exp(&mut x, &step);
                nodes[i] = self.node(x);
                if nodes[i].energy >= limit {
                    return None;
                }
            }
        }
        nodes.insert(top.segment + 1, tip.clone());
        Some(self.with(nodes))
    }

    /// Lowers its `top` by at most `moves` moves. Returns whether no move lowers it any more.
    fn lower(&mut self, top: &mut Top, moves: usize) -> bool {
        for _ in 0..moves {
            let Some((lower, next)) = self.lowered(top) else {
                return true;
            };
            *self = lower;
            *top = next;
        }
        false
    }

    /// The path with its top moved down, by the longest of several moves that lowers it.
    ///
    /// The section through the two pieces is rerouted over the new crossing, or its neighbours follow part of the move.
    fn lowered(&self, top: &Top) -> Option<(Self, Top)> {
        let space = self.space();
        let choices = [0, 1].map(|side: usize| {
            let side = self.node(top.sides[side].clone());
            self.choice(&side).to_vec()
        });
        let place = self.slid(top, &choices);
        let mut move_by = vec![0.0; space.tangents()];
        let mut length = space.log_near(&top.x, &place, &mut move_by);
        for _ in 0..TRIALS {
            let mut x = top.x.clone();
            space.exp(&mut x, &move_by);
            let limit = top.energy - self.gain;
            let tip = self.node(x);
            // Most trials fail, and a single high point is enough to reject one.
            if tip.energy < limit {
                let straight = self
                    .through_seam(top, &choices, &tip, limit)
                    .and_then(|trial| trial.top(limit).map(|next| (trial, next)));
                let limit = straight.as_ref().map_or(limit, |(_, next)| next.energy);
                let dragged = self
                    .dragged(top, &tip, &move_by, WIDTH * length, limit)
                    .and_then(|trial| trial.top(limit).map(|next| (trial, next)));
                if let Some(best) = dragged.or(straight) {
                    return Some(best);
                }
            }
            length *= SHORTER;
            scale(&mut move_by, SHORTER);
        }
        None
    }

    fn peak(&self, top: &Top) -> Peak {
        let space = self.space();
        let mut tangent = vec![0.0; space.tangents()];
        space.log_near(
            &self.nodes[top.segment].x,
            &self.nodes[top.segment + 1].x,
            &mut tangent,
        );
        let length = norm(&tangent);
        scale(&mut tangent, length.max(f64::MIN_POSITIVE).recip());
        Peak {
            image: top.segment,
            x: top.x.clone(),
            energy: top.energy,
            sides: top.sides.clone(),
            tangent,
        }
    }
}
