//! A list of the spheres of a layer that may be near the object while the hand moves a little.
//!
//! Such lists are usual in molecular dynamics (Verlet, *Physical Review* 159, 98 (1967)). A sphere that is farther from the
//! object than it and its list can have moved since is not measured. Nothing else is left out, so the spheres found are
//! bitwise the same as without a list, only faster.

use nalgebra::Vector3;

use super::{Layer, NearSphere, small};
use crate::hand::{Frame, PosedHand};
use crate::object::Shape;

/// Spheres up to this much farther away are listed, metres. The list is valid until some link has moved that far.
const SKIN_M: f64 = 0.006;

/// Rounding error of displacements below a metre.
const ROUNDING_M: f64 = 1e-12;

/// The spheres of one layer that may be near one object, for poses near that at which they were listed.
#[derive(Debug, Clone, Default)]
pub struct NeighbourList {
    /// Frames of the links when the list was made.
    object_from_link: Vec<Frame>,
    reach_m: f64,
    listed: Vec<Listed>,
}

/// A sphere and what is known of its distance.
#[derive(Debug, Clone, Copy)]
struct Listed {
    sphere: u32,
    /// A lower bound of its gap when its centre was here, metres.
    gap_m: f64,
    centre: Vector3<f64>,
}

impl NeighbourList {
    /// Puts all spheres within `reach_m` of the object, and within the clearance of resting ones, in `near`, by index.
    ///
    /// # Panics
    /// If `posed` belongs to another hand than `layer`.
    pub fn find(
        &mut self,
        layer: &Layer,
        posed: &PosedHand,
        shape: &dyn Shape,
        reach_m: f64,
        near: &mut Vec<NearSphere>,
    ) {
        near.clear();
        let reach_m = reach_m.max(layer.clearance_m);
        let slope = shape.lipschitz();
        if !self.is_valid(layer, posed, reach_m) {
            self.list(layer, posed, shape, reach_m);
        }
        for listed in &mut self.listed {
            let sphere = &layer.spheres[listed.sphere as usize];
            let centre = posed.object_from_link[sphere.link.0].point(&sphere.centre);
            let moved_m = (centre - listed.centre).norm() + ROUNDING_M;
            if listed.gap_m - slope * moved_m > reach_m {
                continue;
            }
            let (distance_m, gradient, hessian) = shape.hessian(&centre);
            listed.gap_m = distance_m - sphere.radius_m;
            listed.centre = centre;
            if listed.gap_m <= reach_m {
                near.push(NearSphere {
                    sphere: listed.sphere,
                    centre,
                    gap_m: listed.gap_m,
                    gradient,
                    hessian,
                });
            }
        }
    }

    fn is_valid(&self, layer: &Layer, posed: &PosedHand, reach_m: f64) -> bool {
        let is_still = |link: usize| {
            layer.link_balls[link].is_none_or(|(centre, radius_m)| {
                let (now, then) = (&posed.object_from_link[link], &self.object_from_link[link]);
                now.greatest_movement_m(then, &centre, radius_m) + ROUNDING_M < SKIN_M
            })
        };
        self.reach_m.to_bits() == reach_m.to_bits()
            && self.object_from_link.len() == posed.object_from_link.len()
            && (0..self.object_from_link.len()).all(is_still)
    }

    /// Lists the spheres that come within `reach_m` if no link moves farther than [`SKIN_M`].
    fn list(&mut self, layer: &Layer, posed: &PosedHand, shape: &dyn Shape, reach_m: f64) {
        self.reach_m = reach_m;
        self.object_from_link.clone_from(&posed.object_from_link);
        self.listed.clear();
        let slope = shape.lipschitz();
        let listed_m = (reach_m + SKIN_M) * slope.max(1.0);
        let mut at = 0;
        while let Some(group) = layer.groups.get(at) {
            let frame = &posed.object_from_link[group.link.0];
            let middle = frame.point(&group.centre);
            let distance_m = shape.distance(&middle);
            if distance_m > listed_m + slope * group.radius_m {
                at = group.next;
                continue;
            }
            at += 1;
            for index in group.spheres.clone() {
                let sphere = &layer.spheres[index];
                let centre = frame.point(&sphere.centre);
                let away_m = (centre - middle).norm() + ROUNDING_M;
                let gap_m = distance_m - slope * away_m - sphere.radius_m;
                if gap_m <= listed_m {
                    self.listed.push(Listed {
                        sphere: small(index),
                        gap_m,
                        centre,
                    });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::grasp::start::start_pose;
    use crate::hand::Hand;
    use crate::object::Object;
    use crate::sample::{Task, stream};
    use crate::space::joints_of_mut;

    /// The list only saves work: after any movements the spheres found are those of all spheres, to the last bit.
    #[test]
    fn no_near_sphere_is_missed() {
        let object = Object::named("mug").unwrap();
        let shape = &*object.shape;
        for name in ["human", "gripper_three_finger", "gripper_parallel"] {
            let hand = Hand::named(name).unwrap();
            let layer = Layer::new(&hand, 0.025);
            let mut rng = stream(1, Task::Start, 0);
            let (mut posed, mut near) = (PosedHand::default(), Vec::new());
            let (mut list, mut made, mut listed) = (NeighbourList::default(), 0, 0);
            let mut x = Vec::new();
            for step in 0..400 {
                // From four starts, steps of a fraction of a millimetre and now and then of centimetres.
                if step % 100 == 0 {
                    x = start_pose(&hand, &object, &mut rng);
                }
                let size_m = if step % 10 == 0 { 0.02 } else { 0.0005 };
                for coordinate in &mut x[..3] {
                    *coordinate += size_m * rng.random_range(-1.0..1.0);
                }
                for angle in joints_of_mut(&mut x) {
                    *angle += 10.0 * size_m * rng.random_range(-1.0..1.0);
                }
                hand.pose_links(&x, &mut posed);
                let reach_m = if step < 200 { 0.006 } else { 0.012 };
                made += usize::from(!list.is_valid(&layer, &posed, reach_m));
                list.find(&layer, &posed, shape, reach_m, &mut near);
                listed += list.listed.len();
                let all = (0u32..).zip(&layer.spheres).map(|(index, sphere)| {
                    let centre = posed.object_from_link[sphere.link.0].point(&sphere.centre);
                    let (distance_m, gradient, hessian) = shape.hessian(&centre);
                    NearSphere {
                        sphere: index,
                        centre,
                        gap_m: distance_m - sphere.radius_m,
                        gradient,
                        hessian,
                    }
                });
                let expected: Vec<NearSphere> = all.filter(|near| near.gap_m <= reach_m).collect();
                assert_eq!(near, expected, "{name} at step {step}");
            }
            assert!((5..200).contains(&made), "{name}: {made}");
            assert!(
                5 * listed < 4 * 400 * layer.spheres.len(),
                "{name}: {listed}"
            );
        }
    }
}
