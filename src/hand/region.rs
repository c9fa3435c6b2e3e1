//! The digit of each link and the region of each surface point.

use nalgebra::Vector3;

use super::model::within;
use super::side_file::{AxesEntry, PalmEntry, PalmRule, SideFile};
use super::{Capsule, Hand, HandError, Link, LinkId, PalmFrame, PosedHand};
use crate::limits::HAND_POSITION;

// The region of a patch of a digit follows from its outward normal n in the link's frame: tip, back or side if n·distal,
// n·pad or n·radial passes its threshold, otherwise pad.
const TIP: f64 = 0.45;
const BACK: f64 = -0.5;
const SIDE: f64 = 0.8;

/// A side of a digit, defined by its outward normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PatchSide {
    /// The pad.
    Pad,
    /// The thumb's side of a finger.
    Radial,
    /// The little finger's side.
    Ulnar,
    /// The back.
    Back,
    /// The end of the last bone.
    Tip,
}

impl PatchSide {
    /// The side with these components of the outward normal: out of the pad, to the thumb's side, to the tip. `last`:
    /// whether it is on the last bone of the digit.
    pub fn of([pad, radial, distal]: [f64; 3], last: bool) -> Self {
        match () {
            () if last && distal > TIP => Self::Tip,
            () if pad < BACK => Self::Back,
            () if radial > SIDE => Self::Radial,
            () if radial < -SIDE => Self::Ulnar,
            () => Self::Pad,
        }
    }

    /// The last part of a region's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pad => "pad",
            Self::Radial => "radial",
            Self::Ulnar => "ulnar",
            Self::Back => "back",
            Self::Tip => "tip",
        }
    }

    /// The side with this name.
    pub fn named(name: &str) -> Option<Self> {
        [Self::Pad, Self::Radial, Self::Ulnar, Self::Back, Self::Tip]
            .into_iter()
            .find(|side| side.name() == name)
    }
}

/// Gives each link its digit and returns the digits' names, `palm` first.
///
/// Without a side file the palm is the rigid body from which the most moving branches with geometry leave, and each branch
/// is a digit. A branch that forks into fingers, each of at least two moving links, belongs to the palm up to the fork: an
/// example is a half palm that carries the ring and little finger. Wrist and forearm count as palm here; see
/// [`Hand::is_arm`].
pub(super) fn assign_digits(
    links: &mut [Link],
    capsules: &[Capsule],
    side: &SideFile,
) -> Result<Vec<String>, HandError> {
    let mut names = vec!["palm".to_owned()];
    if let Some(digits) = &side.digits {
        for (d, digit) in digits.iter().enumerate() {
            names.push(digit.name.clone());
            for name in digit.segments.values().flatten() {
                let link = links
                    .iter_mut()
                    .find(|link| &link.name == name)
                    .ok_or_else(|| HandError::Unknown {
                        place: "\"digits\" of the side file".to_owned(),
                        kind: "link",
                        name: name.clone(),
                    })?;
                link.digit = d + 1;
            }
        }
        // Links without geometry between listed links belong to the digit of their child.
        for l in (0..links.len()).rev() {
            let child = links
                .iter()
                .find(|child| child.parent.is_some_and(|parent| parent.0 == l));
            if let Some(digit) = child.map(|child| child.digit)
                && links[l].digit == 0
                && capsules.iter().all(|capsule| capsule.link.0 != l)
            {
                links[l].digit = digit;
            }
        }
        return Ok(names);
    }

    // First link of the rigid body of each link; branches start at rigid bodies.
    let mut body: Vec<usize> = Vec::with_capacity(links.len());
    for (l, link) in links.iter().enumerate() {
        body.push(match (link.motion, link.parent) {
            (None, Some(parent)) => body[parent.0],
            _ => l,
        });
    }
    let inside = |l: usize, root: usize| {
        let mut at = Some(l);
        while let Some(l) = at.filter(|&l| l != root) {
            at = links[l].parent.map(|parent| parent.0);
        }
        at.is_some()
    };
    let mut branches: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    for (first, link) in links.iter().enumerate() {
        if link.motion.is_some()
            && let Some(parent) = link.parent
            && capsules.iter().any(|capsule| inside(capsule.link.0, first))
        {
            branches[body[parent.0]].push(first);
        }
    }
    let palm = (0..links.len())
        .rev()
        .max_by_key(|&l| branches[l].len())
        .expect("a hand has a root");
    let moving_links = |first: usize| {
        let below = (0..links.len()).filter(|&l| inside(l, first) && links[l].motion.is_some());
        below
            .filter(|&l| capsules.iter().any(|capsule| inside(capsule.link.0, l)))
            .count()
    };
    let mut digits: Vec<usize> = Vec::new();
    let mut open: Vec<usize> = branches[palm].iter().rev().copied().collect();
    while let Some(first) = open.pop() {
        let fork = (first..links.len()).find(|&l| inside(l, first) && branches[l].len() > 1);
        match fork {
            Some(fork)
                if branches[fork]
                    .iter()
                    .all(|&finger| moving_links(finger) > 1) =>
            {
                open.extend(branches[fork].iter().rev());
            }
            _ => digits.push(first),
        }
    }
    let owner: Vec<Option<usize>> = (0..links.len())
        .map(|l| digits.iter().position(|&first| inside(l, first)))
        .collect();
    for (link, owner) in links.iter_mut().zip(owner) {
        link.digit = owner.map_or(0, |d| d + 1);
    }
    names.extend((1..=digits.len()).map(|d| format!("digit {d}")));
    Ok(names)
}

/// The first link of the rigid body that all digits are attached to; the root if there are no digits.
pub(super) fn palm_link(links: &[Link]) -> LinkId {
    let above = |l: usize| links[l].parent.map(|parent| parent.0);
    let lineage = |l: usize| {
        let mut line: Vec<usize> = std::iter::successors(Some(l), |&l| above(l)).collect();
        line.reverse();
        line
    };
    let mut common: Option<Vec<usize>> = None;
    for (l, link) in links.iter().enumerate().filter(|(_, link)| link.digit > 0) {
        let Some(parent) = above(l).filter(|&parent| links[parent].digit != link.digit) else {
            continue;
        };
        let line = lineage(parent);
        let shared = common.as_ref().map_or(line.len(), |common| {
            let pairs = common.iter().zip(&line);
            pairs.take_while(|(a, b)| a == b).count()
        });
        common = Some(line[..shared].to_vec());
    }
    let mut first = common.and_then(|line| line.last().copied()).unwrap_or(0);
    while let (None, Some(parent)) = (links[first].motion, above(first)) {
        first = parent;
    }
    LinkId(first)
}

/// Tags the surface points; see [`Hand::regions`].
pub(super) fn tag(hand: &mut Hand, rest: &PosedHand, side: &SideFile) -> Result<(), HandError> {
    let mut regions: Vec<String> = Vec::new();
    let names: Vec<String> = (0..hand.surface.len())
        .map(|i| {
            let point = &hand.surface[i];
            let link = &hand.links[point.link.0];
            if let (Some((digit, segment)), Some(axes)) = (segment(side, &link.name), &side.axes) {
                let last = (hand.subtree_ends[point.link.0] - 1) == point.link.0;
                return Ok(format!(
                    "{digit}.{segment}.{}",
                    patch(&point.normal, axes, last)?
                ));
            }
            let (position, normal) = (&rest.points[i], hand.point_normal(rest, i));
            let rule = side
                .palm_regions
                .iter()
                .find(|rule| holds(rule, position, &normal));
            Ok(rule.map_or_else(|| link.name.clone(), |rule| format!("palm.{}", rule.region)))
        })
        .collect::<Result<_, HandError>>()?;
    for (point, name) in hand.surface.iter_mut().zip(names) {
        point.region = regions
            .iter()
            .position(|known| *known == name)
            .unwrap_or_else(|| {
                regions.push(name);
                regions.len() - 1
            });
    }
    hand.regions = regions;
    Ok(())
}

fn segment<'a>(side: &'a SideFile, link: &str) -> Option<(&'a str, &'a str)> {
    side.digits.iter().flatten().find_map(|digit| {
        let (segment, _) = digit
            .segments
            .iter()
            .find(|(_, links)| links.iter().any(|name| name == link))?;
        Some((digit.name.as_str(), segment.as_str()))
    })
}

fn patch(normal: &Vector3<f64>, axes: &AxesEntry, last: bool) -> Result<&'static str, HandError> {
    let along = |axis: [f64; 3]| {
        let unit = Vector3::from(axis).try_normalize(1e-9).filter(is_unit);
        unit.map(|unit| unit.dot(normal))
            .ok_or(HandError::Degenerate {
                place: "\"axes\" of the side file",
            })
    };
    let parts = [along(axes.pad)?, along(axes.radial)?, along(axes.distal)?];
    Ok(PatchSide::of(parts, last).name())
}

fn holds(rule: &PalmRule, position: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
    let low = rule
        .min_m
        .is_none_or(|min| (0..3).all(|i| position[i] >= min[i]));
    let high = rule
        .max_m
        .is_none_or(|max| (0..3).all(|i| position[i] <= max[i]));
    low && high && Vector3::from(rule.normal).dot(normal) >= rule.at_least
}

/// Whether normalisation succeeded: for far too large numbers the norm is infinite and the direction becomes zero.
fn is_unit(direction: &Vector3<f64>) -> bool {
    (direction.norm() - 1.0).abs() < 1e-6
}

/// The palm frame of the side file.
pub(super) fn palm_frame(palm: &PalmEntry) -> Result<PalmFrame, HandError> {
    let place = "\"palm\" of the side file";
    let volar = Vector3::from(palm.volar)
        .try_normalize(1e-9)
        .filter(is_unit)
        .ok_or(HandError::Degenerate { place })?;
    let distal = Vector3::from(palm.distal);
    let distal = (distal - volar * volar.dot(&distal))
        .try_normalize(1e-9)
        .filter(is_unit)
        .ok_or(HandError::Degenerate { place })?;
    for &length in palm.centre_m.iter().chain([&palm.faced_m]) {
        within(HAND_POSITION, length, || place.to_owned())?;
    }
    Ok(PalmFrame {
        centre: palm.centre_m.into(),
        volar,
        distal,
        faced_m: palm.faced_m,
    })
}
