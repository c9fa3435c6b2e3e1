//! Finds the surface points of the hand near the object, with caching.
//!
//! Two bounds save most of the work. First, when a link has moved by s since its points were bounded, none is nearer than
//! its bound minus s times the slope of the shape. Only the first points, in order of their bounds, are therefore posed.
//! Second, a point that has moved by s since its measurement is measured again only if it can have entered the band. The
//! cache never changes a result.

use nalgebra::Vector3;

use crate::grasp::term::NearPoint;
use crate::hand::{Frame, Hand, LinkId, PosedHand};
use crate::object::Shape;

/// Points tested in vain, for each point of the link, before its bounds are renewed, which costs about as much.
const PATIENCE: usize = 4;

/// Rounding error of displacements below a metre.
const ROUNDING_M: f64 = 1e-12;

/// Cached data of the surface points of one hand near one object.
#[derive(Debug, Clone, Default)]
pub(super) struct NearSearch {
    points: Vec<Known>,
    links: Vec<Bounds>,
    /// One bit for each surface point: whether it must be tested.
    marks: Vec<u64>,
}

/// Last measured position and distance of a surface point.
#[derive(Debug, Clone, Copy)]
struct Known {
    point: Vector3<f64>,
    distance_m: f64,
    gradient: Option<Vector3<f64>>,
}

#[derive(Debug, Clone, Default)]
struct Bounds {
    /// Ball around the points, link frame.
    centre: Vector3<f64>,
    radius_m: f64,
    /// Frame of the link for which the bounds hold.
    frame: Frame,
    /// Lower bound of each point's distance there, ascending, and its index.
    order: Vec<(f64, u32)>,
    /// Points tested since then that were too far.
    in_vain: usize,
}

impl NearSearch {
    /// Fills `near` with all surface points up to the signed distance `band_m`, by index, with gradients up to `graded_m`.
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
            // Points that depend on several links have no bounds.
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

    /// Resets the cache for the points of `hand`.
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

    /// Marks the points that their bounds do not exclude.
    fn mark(&mut self, posed: &PosedHand, band_m: f64, slope: f64) {
        for (link, frame) in self.links.iter_mut().zip(&posed.object_from_link) {
            let reach = band_m + slope * link.moved_m(frame);
            // A NaN bound excludes nothing.
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

    /// Renews the bounds of the points of `link` at its current frame.
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
    /// Whether a point that moved here cannot be within the band.
    fn rules_out(&self, point: &Vector3<f64>, band_m: f64, slope: f64) -> bool {
        let spare = self.distance_m - band_m;
        spare > 0.0 && spare * spare > slope * slope * (point - self.point).norm_squared()
    }

    /// Measures at `point`, including the gradient if the distance is at most `graded_m`.
    fn measure(&mut self, point: &Vector3<f64>, shape: &dyn Shape, graded_m: f64) {
        let measured = self.point == *point && self.distance_m != f64::NEG_INFINITY;
        if measured && (self.gradient.is_some() || self.distance_m > graded_m) {
            return;
        }
        // A point that was near is probably near again, so both are measured at once.
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
    /// Greatest movement of any of the points.
    fn moved_m(&self, frame: &Frame) -> f64 {
        frame.greatest_movement_m(&self.frame, &self.centre, self.radius_m) + ROUNDING_M
    }
}
