//! How a grasp uses the hand, in numbers that can be compared with those of people's grasps of similar objects.
//!
//! [`HandUse`] measures one grasp of a hand that is built like a human one; [`MEASURES`] lists what it measures. What people
//! do is no part of the program: `analysis/human_likeness` compares.

use serde::Serialize;

use super::taxonomy::{
    Anatomy, DIGITS, PalmPart, Patch, TouchingPatch, flexion, held, thumb_elevation, touches,
    touches_enough,
};
use crate::hand::{Hand, PosedHand};
use crate::object::Object;

/// How one grasp uses the hand.
///
/// Contact is all of the hand's surface within 5 mm of the object, weighted by area and nearness ([`touches`]).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HandUse {
    /// Number of digits that touch.
    pub digits: usize,
    /// Share of the contact that is on the palm, 0 to 1.
    pub palm_share: f64,
    /// Share of the contact on each digit, thumb first, 0 to 1.
    pub digit_shares: [f64; 5],
    /// Width of the object under the contacts, metres; unknown if too little of the object is near.
    pub width_m: Option<f64>,
    /// Angle of the thumb's metacarpal above the plane of the palm, radians; unknown without a thumb.
    pub thumb_abduction_rad: Option<f64>,
    /// Flexion of a finger, summed over its joints, mean over the fingers, radians.
    pub finger_flexion_rad: Option<f64>,
}

/// A number that [`HandUse`] has.
#[derive(Clone, Copy)]
pub struct Measure {
    /// Name, with the unit in which `of` is.
    pub name: &'static str,
    /// The number; `None` where it could not be measured.
    pub of: fn(&HandUse) -> Option<f64>,
}

impl std::fmt::Debug for Measure {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name)
    }
}

/// All numbers of [`HandUse`].
pub const MEASURES: [Measure; 10] = [
    Measure {
        name: "digits that touch",
        of: |of| Some(of.digits as f64),
    },
    Measure {
        name: "palm, % of contact",
        of: |of| Some(100.0 * of.palm_share),
    },
    Measure {
        name: "thumb, % of contact",
        of: |of| Some(100.0 * of.digit_shares[0]),
    },
    Measure {
        name: "index, % of contact",
        of: |of| Some(100.0 * of.digit_shares[1]),
    },
    Measure {
        name: "middle, % of contact",
        of: |of| Some(100.0 * of.digit_shares[2]),
    },
    Measure {
        name: "ring, % of contact",
        of: |of| Some(100.0 * of.digit_shares[3]),
    },
    Measure {
        name: "little, % of contact",
        of: |of| Some(100.0 * of.digit_shares[4]),
    },
    Measure {
        name: "width at the grasp, mm",
        of: |of| of.width_m.map(|width| 1e3 * width),
    },
    Measure {
        name: "thumb abduction, °",
        of: |of| of.thumb_abduction_rad.map(f64::to_degrees),
    },
    Measure {
        name: "finger flexion, °",
        of: |of| of.finger_flexion_rad.map(f64::to_degrees),
    },
];

impl HandUse {
    /// Measures the hand at pose `x = [t, q(wxyz), joints]`, object frame; `None` if it does not touch the object.
    ///
    /// # Panics
    /// If `x` does not have 7 numbers more than the hand has joints, or `anatomy` belongs to another hand.
    pub fn of(hand: &Hand, anatomy: &Anatomy, object: &Object, x: &[f64]) -> Option<Self> {
        let mut posed = PosedHand::default();
        hand.pose(x, &mut posed);
        let contact = touches(hand, anatomy, &posed, object);
        let area = |test: &dyn Fn(Patch) -> bool| -> f64 {
            let own = contact.iter().filter(|touch| test(touch.patch));
            own.map(|touch: &TouchingPatch| touch.weight_mm2).sum()
        };
        let whole = area(&|_| true);
        if whole <= 0.0 {
            return None;
        }
        let of_digit =
            |digit: usize| area(&|patch| matches!(patch, Patch::Digit(own, ..) if own == digit));
        let digits: [f64; DIGITS.len()] = std::array::from_fn(|place| of_digit(place + 1));
        let on_palm = area(&|patch| matches!(patch, Patch::Palm(part) if part != PalmPart::Dorsum));
        let flexions: Vec<f64> = (2..=DIGITS.len())
            .filter_map(|digit| flexion(anatomy, &posed, digit))
            .map(|[knuckle, beyond]| knuckle + beyond)
            .collect();
        let mean = flexions.iter().sum::<f64>() / flexions.len() as f64;
        let volar = anatomy.palm_axes(&posed).volar;
        Some(Self {
            digits: digits.iter().filter(|mm2| touches_enough(**mm2)).count(),
            palm_share: on_palm / whole,
            digit_shares: digits.map(|mm2| mm2 / whole),
            width_m: held(object, &contact, &volar).map(|held| held.width_m),
            thumb_abduction_rad: thumb_elevation(anatomy, &posed),
            finger_flexion_rad: (!flexions.is_empty()).then_some(mean),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::joints_of_mut;

    /// The ball of 70 mm in the hollow of the hand, fingers bent by this much at the knuckle.
    fn in_the_hollow(flexion_rad: f64) -> HandUse {
        let hand = Hand::human();
        let anatomy = Anatomy::of(&hand).unwrap();
        let ball = Object::named("ball").unwrap();
        let mut x = hand.rest_coordinates();
        let root = ball.centroid - (hand.palm.centre + hand.palm.volar * 0.034);
        x[..3].copy_from_slice(root.as_slice());
        let joints = joints_of_mut(&mut x);
        joints.fill(0.0);
        for (angle, joint) in joints.iter_mut().zip(&hand.joints) {
            if joint.name.ends_with("mcp_flexion") && !joint.name.starts_with("thumb") {
                *angle = flexion_rad;
            }
        }
        HandUse::of(&hand, &anatomy, &ball, &x).unwrap()
    }

    #[test]
    fn shares_add_up_and_angles_are_those_of_the_joints() {
        for flexion_rad in [0.0, 0.6] {
            let found = in_the_hollow(flexion_rad);
            let sum = found.palm_share + found.digit_shares.iter().sum::<f64>();
            assert!((sum - 1.0).abs() < 1e-9, "{found:?}");
            let flexion = found.finger_flexion_rad.unwrap();
            // The axes of the joints are not quite at right angles to the palm's plane.
            assert!((flexion - flexion_rad).abs() < 0.1, "{found:?}");
            let width_mm = 1e3 * found.width_m.unwrap();
            assert!((width_mm - 70.0).abs() < 3.0, "{found:?}");
        }
        let open = in_the_hollow(0.0);
        assert!(open.palm_share > 0.5, "{open:?}");
        assert!(open.digits <= in_the_hollow(0.9).digits, "{open:?}");
    }

    #[test]
    fn each_measure_has_its_name_once() {
        let mut names = MEASURES.map(|measure| measure.name);
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn a_hand_off_the_object_has_no_use() {
        let hand = Hand::human();
        let anatomy = Anatomy::of(&hand).unwrap();
        let ball = Object::named("ball").unwrap();
        let mut x = hand.rest_coordinates();
        x[0] += 1.0;
        assert_eq!(HandUse::of(&hand, &anatomy, &ball, &x), None);
    }
}
