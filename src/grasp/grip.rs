//! Which parts of a hand take part in a grasp.

use nalgebra::Vector3;
use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::hand::{Hand, LinkId};
use crate::limits::{ENERGY_SETTING, Limit, SHARE};
use crate::sample::Rng;

/// The side of a link with which it takes part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Side {
    /// The side to which it closes.
    Palmar,
    /// The side with this outward direction, a unit vector of the link's frame.
    Toward(Vector3<f64>),
}

/// The links of a hand that take part in a grasp, each with a side; the others rest.
///
/// A [`Grip`] is a usual choice of them. What a [`Wish`](super::synthesis::Wish) asks for may take part with other sides: the
/// thumb's side of the index finger in a lateral grasp.
#[derive(Debug, Clone, PartialEq)]
pub struct Parts(Vec<Option<Side>>);

impl Parts {
    /// The links that `side` chooses.
    pub fn new(hand: &Hand, side: impl Fn(LinkId) -> Option<Side>) -> Self {
        Self(
            (0..hand.links.len())
                .map(|link| side(LinkId(link)))
                .collect(),
        )
    }

    /// The side with which a link takes part; `None` if it rests.
    ///
    /// # Panics
    /// If the hand has no such link.
    pub fn side(&self, link: LinkId) -> Option<Side> {
        self.0[link.0]
    }
}

/// A usual choice of the parts of a hand that take part; the others rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grip {
    /// Number of digits: the thumb and the fingers next to it.
    pub digits: usize,
    /// Whether the palm takes part.
    pub palm: bool,
    /// Whether only the last links of the digits take part.
    pub tips: bool,
}

impl Grip {
    /// Palm and all digits.
    pub const WHOLE: Self = Self {
        digits: usize::MAX,
        palm: true,
        tips: false,
    };

    /// Whether a link takes part. Digits are numbered from the thumb, if there is one.
    pub fn takes(self, hand: &Hand, link: LinkId) -> bool {
        match hand.links[link.0].digit {
            0 => self.palm,
            digit => digit <= self.digits && (!self.tips || hand.is_last_link(link)),
        }
    }

    /// The links that take part, with their palmar sides.
    pub fn parts(self, hand: &Hand) -> Parts {
        Parts::new(hand, |link| self.takes(hand, link).then_some(Side::Palmar))
    }
}

/// Relative frequencies of the grips of a population. A hand without a thumb has no grips of some fingers only: its fingers
/// do not oppose each other one by one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GripShares {
    /// Palm and all digits.
    pub whole: f64,
    /// All digits without the palm.
    pub digits: f64,
    /// Thumb and three fingers.
    pub quadpod: f64,
    /// Thumb and two fingers.
    pub tripod: f64,
    /// Thumb and one finger.
    pub pinch: f64,
    /// Fraction of the grips without the palm in which only the last links take part.
    pub tips: f64,
}

impl Default for GripShares {
    fn default() -> Self {
        Self {
            whole: 0.2,
            digits: 0.2,
            quadpod: 0.2,
            tripod: 0.2,
            pinch: 0.2,
            tips: 0.6,
        }
    }
}

impl GripShares {
    /// The numbers by name and their limits.
    pub(crate) fn values(&self) -> [(&'static str, Limit, f64); 6] {
        [
            ("grips.whole", ENERGY_SETTING, self.whole),
            ("grips.digits", ENERGY_SETTING, self.digits),
            ("grips.quadpod", ENERGY_SETTING, self.quadpod),
            ("grips.tripod", ENERGY_SETTING, self.tripod),
            ("grips.pinch", ENERGY_SETTING, self.pinch),
            ("grips.tips", SHARE, self.tips),
        ]
    }

    /// Draws a grip for `hand`; [`Grip::WHOLE`] if no grip of positive frequency is possible.
    pub(crate) fn draw(&self, hand: &Hand, rng: &mut Rng) -> Grip {
        let count = hand.digits.len().saturating_sub(1);
        let fewer = |digits: usize| hand.has_thumb() && digits < count;
        let grips = [
            (count, count >= 2, self.digits),
            (4, fewer(4), self.quadpod),
            (3, fewer(3), self.tripod),
            (2, fewer(2), self.pinch),
        ];
        let possible = || grips.iter().filter(|(_, possible, _)| *possible);
        let total = self.whole + possible().map(|(.., share)| share).sum::<f64>();
        let mut left = rng.random::<f64>() * total - self.whole;
        let tips = rng.random::<f64>() < self.tips;
        if left < 0.0 {
            return Grip::WHOLE;
        }
        for &(digits, _, share) in possible() {
            left -= share;
            if left < 0.0 {
                return Grip {
                    digits,
                    palm: false,
                    tips,
                };
            }
        }
        Grip::WHOLE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Task, stream};

    fn count(hand: &Hand, shares: &GripShares, wanted: Grip) -> usize {
        let mut rng = stream(1, Task::Start, 0);
        let drawn = (0..10_000).map(|_| shares.draw(hand, &mut rng));
        drawn.filter(|grip| *grip == wanted).count()
    }

    #[test]
    fn grips_are_drawn_at_their_frequencies() {
        let (hand, shares) = (Hand::human(), GripShares::default());
        assert!((1850..2150).contains(&count(&hand, &shares, Grip::WHOLE)));
        for (digits, share) in [(2, 0.2), (3, 0.2), (4, 0.2), (5, 0.2)] {
            for (tips, part) in [(false, 0.4), (true, 0.6)] {
                let grip = Grip {
                    digits,
                    palm: false,
                    tips,
                };
                let found = count(&hand, &shares, grip) as f64;
                let expected = 10_000.0 * share * part;
                assert!((found - expected).abs() < 100.0, "{grip:?} {found}");
            }
        }
    }

    #[test]
    fn a_hand_without_a_thumb_uses_all_fingers() {
        let hand = Hand::named("human_thumbless").unwrap();
        let pinches = GripShares {
            whole: 0.0,
            digits: 0.0,
            ..GripShares::default()
        };
        assert_eq!(count(&hand, &pinches, Grip::WHOLE), 10_000);
    }

    #[test]
    fn a_pinch_by_the_tips_takes_two_links() {
        let hand = Hand::human();
        let grip = Grip {
            digits: 2,
            palm: false,
            tips: true,
        };
        let links = (0..hand.links.len()).map(LinkId);
        let taken: Vec<&str> = links
            .filter(|link| grip.takes(&hand, *link))
            .map(|link| hand.links[link.0].name.as_str())
            .collect();
        assert_eq!(taken, ["thumb_distal", "index_distal"]);
    }
}
