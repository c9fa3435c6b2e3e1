//! How a wish is tried.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::{Asked, WishError};
use crate::evaluation::taxonomy::{
    Anatomy, GraspType, ImaginedTouch, Opposition, PalmPart, Patch, Rule,
};
use crate::grasp::between::{Opposed, Place};
use crate::grasp::grip::{Parts, Side};
use crate::hand::{Hand, LinkId, volar_directions};

/// Least cosine between the normal of a part of a link and its palmar side, so that the part is of that side.
const PALMAR: f64 = 0.5;
/// How a wish is tried: what takes part, the two sides that oppose, and what touches.
#[derive(Debug, Clone)]
pub(in crate::study) struct Plan {
    pub(super) entry: Option<&'static GraspType>,
    pub(super) parts: Parts,
    /// Fewer parts, with which some attempts are made.
    pub(super) narrow: Option<Parts>,
    pub(super) sides: Opposed,
    pub(super) touch: Vec<ImaginedTouch>,
    pub(super) by_palm: bool,
}

impl Plan {
    /// The plan for a type. `None` if the hand has no parts for one of its sides.
    pub(super) fn of_type(
        hand: &Hand,
        anatomy: &Anatomy,
        entry: &'static GraspType,
    ) -> Option<Self> {
        let expected = Rule::standard().expected_touch(entry);
        let touch = |patches: &mut dyn Iterator<Item = Patch>| -> Vec<ImaginedTouch> {
            let touches = patches.flat_map(|patch| ImaginedTouch::of(hand, anatomy, patch));
            touches
                .filter(|touch| hand.link_may_touch(touch.link))
                .collect()
        };
        let sides = Opposed {
            first: places(&touch(&mut expected.first.iter().copied())),
            second: places(&touch(&mut expected.second.iter().copied())),
        };
        let touch = touch(&mut expected.all());
        (!sides.first.is_empty() && !sides.second.is_empty()).then(|| Self {
            entry: Some(entry),
            parts: parts(hand, &touch, true),
            narrow: Some(parts(hand, &touch, false)),
            by_palm: entry.opposition == Opposition::Palm,
            sides,
            touch,
        })
    }

    /// The plan for groups of surface points that are to touch: the thumb or the palm opposes the others, or else the first
    /// group does.
    pub(super) fn of_groups(
        hand: &Hand,
        asked: &Asked,
        groups: Vec<Vec<usize>>,
    ) -> Result<Vec<Self>, WishError> {
        if groups.len() < 2 {
            return Err(WishError::Few(asked.name()));
        }
        // No type is asked for, so nothing asks which part of the hand it is.
        let patch = Patch::Palm(PalmPart::Volar);
        let touch: Vec<Vec<ImaginedTouch>> = groups
            .into_iter()
            .map(|points| ImaginedTouch::of_points(hand, points.into_iter(), |_| patch))
            .collect();
        let digit = |group: &Vec<ImaginedTouch>| {
            let link = group.first().map(|touch| touch.link);
            link.map_or(0, |link| hand.links[link.0].digit)
        };
        let thumb = |group: &&Vec<ImaginedTouch>| hand.has_thumb() && digit(group) == 1;
        let palm = |group: &&Vec<ImaginedTouch>| digit(group) == 0;
        let thumbs: Vec<_> = touch.iter().filter(thumb).collect();
        let palms: Vec<_> = touch.iter().filter(palm).collect();
        let some =
            |group: &Vec<&Vec<ImaginedTouch>>| !group.is_empty() && group.len() < touch.len();
        let first: Vec<&Vec<ImaginedTouch>> = match (some(&thumbs), some(&palms)) {
            (true, false) => thumbs,
            (_, true) => palms.clone(),
            _ => touch.iter().take(1).collect(),
        };
        let is_first = |group: &Vec<ImaginedTouch>| first.contains(&group);
        // Digits without the palm hold with their ends, so these stand on both sides of the object.
        let by_palm = !palms.is_empty();
        let by_ends = matches!(asked, Asked::Digits(_)) && !by_palm;
        let counts = |touch: &&ImaginedTouch| !by_ends || hand.is_last_link(touch.link);
        let side = |chosen: bool| -> Vec<Place> {
            let groups = touch.iter().filter(|group| is_first(group) == chosen);
            let own = groups.flatten().filter(counts).copied();
            places(&own.collect::<Vec<_>>())
        };
        let sides = Opposed {
            first: side(true),
            second: side(false),
        };
        let all: Vec<ImaginedTouch> = touch.into_iter().flatten().collect();
        let last: Vec<ImaginedTouch> = (all.iter().copied())
            .filter(|touch| hand.is_last_link(touch.link))
            .collect();
        if sides.first.is_empty() || sides.second.is_empty() {
            return Err(WishError::Few(asked.name()));
        }
        Ok(vec![Self {
            entry: None,
            parts: parts(hand, &all, false),
            narrow: by_ends.then(|| parts(hand, &last, false)),
            by_palm,
            sides,
            touch: all,
        }])
    }
}

fn places(touch: &[ImaginedTouch]) -> Vec<Place> {
    let place = |touch: &ImaginedTouch| Place {
        link: touch.link,
        point: touch.point,
        normal: touch.normal,
    };
    touch.iter().map(place).collect()
}

/// The links that touch, with their palmar sides or, where another part of them touches, the side of that. If `wide`, the other
/// links of the same digits as well, with their palmar sides.
fn parts(hand: &Hand, touch: &[ImaginedTouch], wide: bool) -> Parts {
    let volar = volar_directions(hand);
    let digits: BTreeSet<usize> = (touch.iter())
        .map(|touch| hand.links[touch.link.0].digit)
        .collect();
    Parts::new(hand, |link| {
        let own = touch.iter().filter(|touch| touch.link == link);
        let normal: Vector3<f64> = own.map(|touch| touch.normal).sum();
        let normal = normal.try_normalize(1e-6);
        match normal {
            Some(normal) if !is_palmar(&volar, link, &normal) => Some(Side::Toward(normal)),
            Some(_) => Some(Side::Palmar),
            None => (wide && digits.contains(&hand.links[link.0].digit)).then_some(Side::Palmar),
        }
    })
}

fn is_palmar(volar: &[Option<Vector3<f64>>], link: LinkId, normal: &Vector3<f64>) -> bool {
    volar[link.0].is_none_or(|volar| volar.dot(normal) > PALMAR)
}

/// The surface points on the palmar sides of the links of a digit; of the palm, 0.
pub(super) fn palmar_points(hand: &Hand, digit: usize) -> Vec<usize> {
    let volar = volar_directions(hand);
    let own = |i: &usize| {
        let point = &hand.surface[*i];
        hand.links[point.link.0].digit == digit
            && !hand.is_arm(point.link)
            && hand.may_touch(point)
            && volar[point.link.0].is_some()
            && is_palmar(&volar, point.link, &point.normal)
    };
    (0..hand.surface.len()).filter(own).collect()
}
