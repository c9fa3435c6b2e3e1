//! Penetration depth of hand and object, with the exported hand and the exact mesh of the object.

use nalgebra::Vector3;

use crate::hand::{Hand, Part, PosedHand, Solid};
use crate::mesh::{DEPTH_TOLERANCE_M, ExactMesh};

/// Greatest depth of a point of the hand in the object or of the object in the hand, metres; 0 without overlap.
///
/// ```text
/// max { −d(p, O) : p ∈ ∂H } ∪ { −d(p, P) : p ∈ ∂O, P part of H },   d: signed distance
/// ```
///
/// ∂H are the triangles of the exported hand ([`Hand::solid_skin`]): those of its parts (meshes, hulls of boxes and
/// cylinders, capsules), or the skin of MANO. The skin drawn over a hand of capsules does not count, as it is thicker at
/// creases. A part is a capsule, or all meshes of one link: its inside is the union of the solids that they bound (after
/// repair if necessary), or else of their convex hulls. The result is at most
/// [`DEPTH_TOLERANCE_M`] too small.
///
/// # Panics
/// If `posed` belongs to another hand.
pub fn deepest_m(exact: &ExactMesh, hand: &Hand, posed: &PosedHand) -> f64 {
    fold_parts(exact, hand, posed, 0.0, |deepest_m, part| {
        deeper_m(exact, posed, part, deepest_m)
    })
}

/// Whether [`deepest_m`] is at least `depth_m`. This is much cheaper than the depth itself, because smaller depths are not
/// sought. A depth within [`DEPTH_TOLERANCE_M`] of `depth_m` may be judged either way.
///
/// # Panics
/// If `posed` belongs to another hand.
pub(crate) fn is_deeper(exact: &ExactMesh, hand: &Hand, posed: &PosedHand, depth_m: f64) -> bool {
    let known_m = depth_m - DEPTH_TOLERANCE_M;
    let deepest_m = fold_parts(exact, hand, posed, known_m, |deepest_m, part| {
        if deepest_m >= depth_m {
            return deepest_m;
        }
        deeper_m(exact, posed, part, deepest_m)
    });
    deepest_m >= depth_m
}

/// Greatest depth of this part in the object or of the object in the part, if more than `known_m`.
fn deeper_m(exact: &ExactMesh, posed: &PosedHand, part: &Part, known_m: f64) -> f64 {
    let known_m = part.holds(exact, posed, known_m);
    part.is_in(exact, posed, known_m)
}

/// Greatest depth of a point of the object's surface inside a part of the hand, metres; 0 if none is inside. It is the
/// second half of [`deepest_m`]. A part deep inside a thick object counts as zero, since only the hand's surface is then
/// inside the object.
///
/// # Panics
/// If `posed` belongs to another hand.
pub fn object_inside_hand_m(exact: &ExactMesh, hand: &Hand, posed: &PosedHand) -> f64 {
    fold_parts(exact, hand, posed, 0.0, |deepest_m, part| {
        part.holds(exact, posed, deepest_m)
    })
}

/// Folds over the parts that may touch the object, from the depth that is known before.
fn fold_parts(
    exact: &ExactMesh,
    hand: &Hand,
    posed: &PosedHand,
    known_m: f64,
    deeper: impl Fn(f64, &Part) -> f64,
) -> f64 {
    hand.parts(posed)
        .iter()
        .filter(|part| {
            let centre = part.frame(posed).point(&part.centre);
            exact.gap_within(&centre, part.radius_m).is_some() || exact.surrounds(&centre)
        })
        .fold(known_m, deeper)
}

impl Part {
    /// Greatest depth of the object's surface inside this part, if more than `known_m`; otherwise `known_m`.
    fn holds(&self, exact: &ExactMesh, posed: &PosedHand, known_m: f64) -> f64 {
        match &self.solid {
            Solid::Capsule { number, radius_m } => exact
                .segment_distance_within(&posed.capsules[*number], radius_m - known_m)
                .map_or(known_m, |distance_m| radius_m - distance_m),
            Solid::Mesh(solid) => {
                let frame = self.frame(posed);
                let place = |point: &Vector3<f64>| frame.inverse_point(point);
                solid.deepest(exact.surface(), place, known_m)
            }
            Solid::Nothing => known_m,
        }
    }

    /// Greatest depth of this part's surface inside the object, if more than `known_m`, which is at least [`Part::holds`].
    fn is_in(&self, exact: &ExactMesh, posed: &PosedHand, known_m: f64) -> f64 {
        if let Solid::Capsule { number, .. } = self.solid {
            let axis = &posed.capsules[number];
            let crossed = exact.segment_distance_within(axis, ON_AXIS_M).is_some();
            // If the axis is outside, the surface is no deeper in the object than the object is in the capsule.
            if !crossed && !exact.surrounds(&axis[0]) {
                return known_m;
            }
        }
        let frame = self.frame(posed);
        exact.deepest(&self.surface, |point| frame.point(point), known_m)
    }
}

/// Distance from the surface below which an axis crosses it, metres.
const ON_AXIS_M: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::HandFiles;
    use crate::mesh::Mesh;

    /// A plate 1 mm thick that is 8 mm deep in anything around the origin below 1 cm.
    const PLATE: &str = "v -0.0005 -0.005 0.002\nv 0.0005 -0.005 0.002\nv 0.0005 0.005 0.002\nv -0.0005 0.005 0.002\n\
v -0.0005 -0.005 0.03\nv 0.0005 -0.005 0.03\nv 0.0005 0.005 0.03\nv -0.0005 0.005 0.03\n\
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

    /// A palm of boxes, given by centre and length along x, and a distant fingertip.
    fn palm(boxes: &[[f64; 2]]) -> Hand {
        let boxes: Vec<String> = (boxes.iter())
            .map(|[middle, length]| {
                format!(
                    r#"<collision><origin xyz="{middle} 0 0"/><geometry><box size="{length} 0.04 0.02"/></geometry></collision>"#
                )
            })
            .collect();
        let boxes = boxes.concat();
        let text = format!(
            r#"<robot name="r"><link name="palm">{boxes}</link>
<link name="tip"><collision><geometry><sphere radius="0.005"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="palm"/><child link="tip"/><origin xyz="0 0.1 0"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#
        );
        Hand::from_files(&HandFiles::of_texts([["hand", &text]])).unwrap()
    }

    #[test]
    fn boxes_of_a_link_that_touch_are_one_solid() {
        let plate = ExactMesh::new(&Mesh::from_obj("plate", &mut PLATE.as_bytes()).unwrap());
        for boxes in [&[[0.0, 0.08]][..], &[[-0.02, 0.04], [0.02, 0.04]]] {
            let hand = palm(boxes);
            let mut posed = PosedHand::default();
            hand.pose(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0], &mut posed);
            let depth_m = object_inside_hand_m(&plate, &hand, &posed);
            assert!((depth_m - 0.008).abs() < 1e-4, "{boxes:?}: {depth_m}");
            assert!(is_deeper(&plate, &hand, &posed, 0.0078));
            assert!(!is_deeper(&plate, &hand, &posed, 0.0082));
        }
    }
}
