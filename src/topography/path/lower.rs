//! Lowers the top of a path.
//!
//! A stiff surface bends its valleys, so the straight line between two images of a string lies far above the valley. The top
//! of such a path is moved down across the path, and the path follows it. A move counts only if the highest point of the path
//! falls.

use super::across::descend_across;
use super::pass::{Pass, Peak};
use super::{LoweringSettings, Path, PathSettings, near};
use crate::energy::Energy;
use crate::space::Space;
use crate::space::vector::{dot, norm, scale};
use crate::topography::eigen::Scaled;

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
/// Thresholds, as fractions of the energy tolerance: by how much the energy may rise in a step of a move, and by how much a
/// top must fall.
const TIE: f64 = 1e-3;
const GAIN: f64 = 1e-3;

#[derive(Clone)]
struct Node {
    x: Vec<f64>,
    energy: f64,
    gradient: Vec<f64>,
}

/// A polygon of closely spaced points.
struct Polygon<'e> {
    energy: &'e dyn Energy,
    settings: &'e PathSettings,
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
    lowering: &LoweringSettings,
) -> Option<Lowered> {
    let mut path = Polygon::new(energy, images, lowering.spacing, settings);
    let mut top = path.top(f64::INFINITY)?;
    path.lower(&mut top, lowering.moves);
    let mut relaxed = false;
    for halving in 1..=lowering.halvings {
        path.spacing = lowering.spacing * 0.5_f64.powi(i32::try_from(halving).unwrap_or(i32::MAX));
        path.refine();
        let before = top.energy;
        top = path.top(f64::INFINITY)?;
        let change = top.energy - before;
        let rests = path.lower(&mut top, lowering.moves);
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
    lowering: &LoweringSettings,
) -> Option<Path> {
    let mut images = path.images.clone();
    images[path.top()].clone_from(&pass.x);
    let spacing = 0.5 * lowering.spacing;
    let polygon = Polygon::new(energy, &images, spacing, settings);
    let top = polygon.top(f64::INFINITY)?;
    let slack = settings.slack(pass.energy - floor);
    (top.energy <= pass.energy + slack).then(|| polygon.path(&top))
}

impl<'e> Polygon<'e> {
    fn new(
        energy: &'e dyn Energy,
        images: &[Vec<f64>],
        spacing: f64,
        settings: &'e PathSettings,
    ) -> Self {
        let mut path = Self {
            energy,
            settings,
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
        let energy = self.energy.evaluate(&x, &mut gradient);
        Node {
            x,
            energy,
            gradient,
        }
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
        space.log_near(&from.x, &to.x, &mut along);
        let mut gradient = along.clone();
        let point = |s: f64| {
            let mut step = along.clone();
            scale(&mut step, s);
            let mut x = from.x.clone();
            space.exp(&mut x, &step);
            x
        };
        let mut height = |s: f64| self.energy.evaluate(&point(s), &mut gradient);
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
        let mut x = point(middle);
        let last = self.nodes.len() - 1;
        if from.energy > value && i > 0 {
            (x, value) = (from.x.clone(), from.energy);
        } else if to.energy > value && i + 1 < last {
            (x, value) = (to.x.clone(), to.energy);
        }
        Top {
            segment: i,
            energy: value,
            x,
        }
    }

    /// The end of a descent from `top` across the path: converged, or at its greatest length.
    fn slid(&self, top: &Top) -> Vec<f64> {
        let reach = 2.0 * self.settings.max_step;
        let surface = Scaled::new(self.energy);
        let tangent = surface.scaled(&self.peak(top).tangent);
        descend_across(
            &surface,
            &tangent,
            &top.x,
            (
                self.settings.force_tolerance,
                TIE * self.settings.energy_tolerance,
            ),
            self.settings.max_step,
            self.settings.refinement_steps,
            &mut |x| near(self.space(), &top.x, x) > reach,
        )
    }

    /// The straight lines from the ends to `tip`; `None` if they reach `limit`.
    fn straight(&self, tip: &Node, limit: f64) -> Option<Self> {
        let low = |node: &Node| node.energy < limit;
        let (first, last) = (&self.nodes[0], &self.nodes[self.nodes.len() - 1]);
        if !low(first) || !low(last) {
            return None;
        }
        // From the tip down, because points that are too high are next to it.
        let below = |x| Some(self.node(x)).filter(low);
        let down = self.between_ends(first, tip).rev();
        let down: Vec<Node> = down.map(below).collect::<Option<_>>()?;
        let up = self.between_ends(tip, last);
        let up: Vec<Node> = up.map(below).collect::<Option<_>>()?;
        let mut nodes = vec![first.clone()];
        nodes.extend(down.into_iter().rev());
        nodes.push(tip.clone());
        nodes.extend(up);
        nodes.push(last.clone());
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
    /// The path becomes straight lines to the moved top, or its neighbours follow part of the move.
    fn lowered(&self, top: &Top) -> Option<(Self, Top)> {
        let space = self.space();
        let place = self.slid(top);
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
                    .straight(&tip, limit)
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
            tangent,
        }
    }
}
