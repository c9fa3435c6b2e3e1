//! Which surface points of the hand are near the object: a search that remembers.
//!
//! Two bounds spare most of the work. A link that has moved by s since its points were bounded has brought none of them
//! nearer than its bound less s times the slope of the shape, so only the first few of its points, in order of their
//! bounds, are posed at all. A point that has moved by s since it was measured is measured again only if it can have come
//! within the band. What is remembered never changes a result, only its price.

use nalgebra::Vector3;

use crate::grasp::term::NearPoint;
use crate::hand::{Frame, Hand, LinkId, PosedHand};
use crate::object::Shape;

/// Points looked at in vain, per point of the link, before its bounds are renewed: that costs about as much.
const PATIENCE: usize = 4;

/// Displacements are sums of a few roundings of lengths below a metre.
const ROUNDING_M: f64 = 1e-12;

/// What is known of the surface points of one hand near one object.
#[derive(Debug, Clone, Default)]
pub(super) struct NearSearch {
    points: Vec<Known>,
    links: Vec<Bounds>,
    /// One bit a surface point: whether it is to be looked at.
    marks: Vec<u64>,
}

/// Where a surface point was last measured, and the answers there.
#[derive(Debug, Clone, Copy)]
struct Known {
    point: Vector3<f64>,
    distance_m: f64,
    gradient: Option<Vector3<f64>>,
}

/// Bounds of the distances of a link's points.
#[derive(Debug, Clone, Default)]
struct Bounds {
    /// A ball around the points, link frame.
    centre: Vector3<f64>,
    radius_m: f64,
    /// Frame of the link at which the bounds hold.
    frame: Frame,
    /// Least distance that each point can have there, rising, and its index.
    order: Vec<(f64, u32)>,
    /// Points looked at since that turned out to be far.
    in_vain: usize,
}

impl NearSearch {
    /// Fills `near` with every surface point whose signed distance is at most `band_m`, by rising index; with gradients
    /// of those at most at `graded_m`.
    pub(super) fn find(
        &mut self,
        hand: &Hand,
        posed: &PosedHand,
        shape: &dyn Shape,
        (band_m, graded_m): (f64, f64),
        near: &mut Vec<NearPoint>,
    ) {
        if self.points.len() != hand.surface.len() {
            self.forget(hand);
        }
        let slope = shape.lipschitz();
        if hand.bends() {
            // Points that several links carry have no bounds by one of them.
            self.mark_all();
        } else {
            self.mark(posed, band_m, slope);
        }
        near.clear();
        for (word, marks) in self.marks.iter_mut().enumerate() {
            while *marks != 0 {
                let index = 64 * word + marks.trailing_zeros() as usize;
                *marks &= *marks - 1;
                let link = hand.surface[index].link;
                let point = hand.surface_point(posed, index);
                let known = &mut self.points[index];
                if known.rules_out(&point, band_m, slope) {
                    continue;
                }
                known.measure(&point, shape, graded_m);
                if known.distance_m <= band_m {
                    self.links[link.0].in_vain -= 1;
                    near.push(NearPoint {
                        index: u32::try_from(index).expect("a hand has fewer than 2³² points"),
                        point,
                        distance_m: known.distance_m,
                        gradient: known.gradient,
                    });
                }
            }
        }
        for link in 0..self.links.len() {
            if !hand.bends() && self.links[link].in_vain > PATIENCE * self.links[link].order.len() {
                self.renew(hand, posed, LinkId(link), slope);
            }
        }
    }

    /// Knows nothing of the points of `hand`.
    fn forget(&mut self, hand: &Hand) {
        let unknown = Known {
            point: Vector3::zeros(),
            distance_m: f64::NEG_INFINITY,
            gradient: None,
        };
        self.points = vec![unknown; hand.surface.len()];
        self.marks = vec![0; hand.surface.len().div_ceil(64)];
        self.links = vec![Bounds::default(); hand.links.len()];
        for (point, index) in hand.surface.iter().zip(0u32..) {
            let link = &mut self.links[point.link.0];
            link.centre += point.point;
            link.order.push((f64::NEG_INFINITY, index));
        }
        for link in &mut self.links {
            link.centre /= link.order.len().max(1) as f64;
        }
        for point in &hand.surface {
            let link = &mut self.links[point.link.0];
            link.radius_m = link.radius_m.max((point.point - link.centre).norm());
        }
    }

    /// Marks the points whose bounds do not rule them out.
    fn mark(&mut self, posed: &PosedHand, band_m: f64, slope: f64) {
        for (link, frame) in self.links.iter_mut().zip(&posed.object_from_link) {
            let reach = band_m + slope * link.moved_m(frame);
            // A bound that is not a number rules nothing out.
            let marked = link
                .order
                .iter()
                .take_while(|(bound, _)| bound.is_nan() || reach.is_nan() || *bound <= reach);
            for (_, index) in marked {
                self.marks[*index as usize / 64] |= 1 << (index % 64);
                link.in_vain += 1;
            }
        }
    }

    fn mark_all(&mut self) {
        for index in 0..self.points.len() {
            self.marks[index / 64] |= 1 << (index % 64);
        }
        for link in &mut self.links {
            link.in_vain = link.order.len();
        }
    }

    /// Bounds the points of `link` anew, at its present frame.
    fn renew(&mut self, hand: &Hand, posed: &PosedHand, link: LinkId, slope: f64) {
        let bounds = &mut self.links[link.0];
        bounds.frame = posed.object_from_link[link.0];
        bounds.in_vain = 0;
        for (bound, index) in &mut bounds.order {
            let known = &self.points[*index as usize];
            let moved_m = (hand.surface_point(posed, *index as usize) - known.point).norm();
            *bound = known.distance_m - slope * (moved_m + ROUNDING_M);
        }
        bounds
            .order
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
}

impl Known {
    /// Whether a point that has moved here cannot lie within the band.
    fn rules_out(&self, point: &Vector3<f64>, band_m: f64, slope: f64) -> bool {
        let spare = self.distance_m - band_m;
        spare > 0.0 && spare * spare > slope * slope * (point - self.point).norm_squared()
    }

    /// Makes the answers those at `point`, with the gradient where the distance is at most `graded_m`.
    fn measure(&mut self, point: &Vector3<f64>, shape: &dyn Shape, graded_m: f64) {
        let measured = self.point == *point && self.distance_m != f64::NEG_INFINITY;
        if measured && (self.gradient.is_some() || self.distance_m > graded_m) {
            return;
        }
        // A point that was near is likely to be near again: one visit for both answers.
        let expected = self.distance_m <= graded_m && self.distance_m != f64::NEG_INFINITY;
        if !expected {
            self.distance_m = shape.distance(point);
            self.gradient = None;
        }
        if expected || self.distance_m <= graded_m {
            let (distance_m, gradient) = shape.gradient(point);
            self.distance_m = distance_m;
            self.gradient = Some(gradient);
        }
        self.point = *point;
    }
}

impl Bounds {
    /// Farthest that any of the points can have moved: with the centre of the ball and about it.
    fn moved_m(&self, frame: &Frame) -> f64 {
        let turn = frame.rotation - self.frame.rotation;
        let shift = turn * self.centre + (frame.translation - self.frame.translation);
        // The difference of two rotations stretches by 2 sin(φ/2), in two directions and not at all in the third.
        let stretch = (0.5 * turn.norm_squared()).sqrt();
        shift.norm() + stretch * self.radius_m + ROUNDING_M
    }
}
