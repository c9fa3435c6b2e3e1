//! A search tree over boxes along the axes.

use nalgebra::Vector3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};

use super::exact::to_parry;

/// A tree over boxes, each given by its lowest and highest corner.
pub(super) struct BoxTree(Bvh);

impl BoxTree {
    pub(super) fn new(boxes: impl Iterator<Item = [Vector3<f64>; 2]>) -> Self {
        let boxes = boxes.map(|[low, high]| Aabb::new(to_parry(&low), to_parry(&high)));
        Self(Bvh::from_iter(
            BvhBuildStrategy::default(),
            boxes.enumerate(),
        ))
    }

    /// Numbers, ascending, of the boxes that are no farther than `slack` from the box between two corners; a box that is
    /// farther by rounding error may be among them.
    pub(super) fn near(&self, low: &Vector3<f64>, high: &Vector3<f64>, slack: f64) -> Vec<usize> {
        /// Covers rounding.
        const LOOSE: f64 = 1.001;
        let reach = slack * LOOSE;
        let wanted = Aabb::new(
            to_parry(&low.add_scalar(-reach)),
            to_parry(&high.add_scalar(reach)),
        );
        let mut found: Vec<usize> = (self.0.intersect_aabb(&wanted))
            .map(|number| number as usize)
            .collect();
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Task, stream};
    use rand::RngExt;

    #[test]
    fn finds_what_a_search_of_all_boxes_finds() {
        let mut rng = stream(5, Task::Start, 0);
        let mut corner = |most: f64| Vector3::from_fn(|_, _| rng.random_range(0.0..most));
        let boxes: Vec<[Vector3<f64>; 2]> = (0..400)
            .map(|_| {
                let low = corner(1.0);
                [low, low + corner(0.1)]
            })
            .collect();
        let tree = BoxTree::new(boxes.iter().copied());
        let slack = 0.02;
        for [low, high] in &boxes {
            let meets = |other: &[Vector3<f64>; 2]| {
                (0..3).all(|axis| {
                    low[axis] <= other[1][axis] + slack && other[0][axis] <= high[axis] + slack
                })
            };
            let all: Vec<usize> = (0..boxes.len()).filter(|&at| meets(&boxes[at])).collect();
            let mut found = tree.near(low, high, slack);
            found.retain(|&at| meets(&boxes[at]));
            assert_eq!(found, all);
        }
        assert!(
            BoxTree::new(std::iter::empty())
                .near(&boxes[0][0], &boxes[0][1], 1.0)
                .is_empty()
        );
    }
}
