//! What a population can be asked for: grasp types, cells of the taxonomy, sets of digits, sets of contact regions.

mod names;
mod plan;

use std::collections::BTreeSet;

use rand::RngExt;
use serde::{Deserialize, Serialize};

pub use self::names::HandNames;
use self::names::is_within;
pub(super) use self::plan::Plan;
use self::plan::palmar_points;
use crate::evaluation::taxonomy::{Anatomy, GraspType, Labeller, Rule, Taxonomy, Unlike};
use crate::evaluation::{TOUCHING_M, contact_regions};
use crate::grasp::GraspEnergy;
use crate::grasp::between::{start_between, start_facing};
use crate::grasp::grip::Parts;
use crate::grasp::start::start_pose_facing;
use crate::grasp::synthesis::Wish;
use crate::hand::{Hand, PosedHand};
use crate::object::Object;
use crate::sample::Rng;

/// Fraction of the attempts at a set of digits without the palm in which only the last links take part.
const TIPS: f64 = 0.6;
/// Ways in which attempts at a type begin, in turn: in a posture of the type with the links that it needs, in such a posture with
/// all links of its digits, and with the straight hand and all links of its digits. No way is best for all types.
const WAYS: usize = 3;

/// What a chain of a population is asked for.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Asked {
    /// A grasp type, by its number from 1 to 33.
    Type(u8),
    /// A cell of the taxonomy's table: `precision/pad/2/abducted`.
    Cell(String),
    /// These digits (and the palm) touch, and no others.
    Digits(BTreeSet<String>),
    /// These regions touch, and no other digits than theirs.
    Regions(BTreeSet<String>),
}

/// A wish that makes no sense, or not for this hand.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WishError {
    /// No type of that number or name.
    #[error(
        "{0}: this is not one of the 33 grasp types; give a number from 1 to 33 or a name, such as \"Tip Pinch\""
    )]
    Type(String),
    /// No cell of that name.
    #[error("{name}: this is not one of the 17 cells: {}", .cells.join(", "))]
    Cell {
        /// What was given.
        name: String,
        /// All cells.
        cells: Vec<String>,
    },
    /// Types and cells are defined for hands like a human one.
    #[error(
        "{wish}: the {hand} hand is not built like a human one ({why}); ask for digits (--grips) or regions (--regions)"
    )]
    Hand {
        /// What was asked for.
        wish: String,
        /// Name of the hand.
        hand: String,
        /// Why it is unlike a human hand.
        why: Unlike,
    },
    /// The hand lacks a digit that a type needs.
    #[error("{wish}: the {hand} hand lacks a digit that this needs")]
    Digit {
        /// What was asked for.
        wish: String,
        /// Name of the hand.
        hand: String,
    },
    /// A name of no digit or region.
    #[error("{name}: the {hand} hand has no such {kind}; it has {}", .known.join(", "))]
    Name {
        /// What was given.
        name: String,
        /// Name of the hand.
        hand: String,
        /// `digit` or `region`.
        kind: &'static str,
        /// What the hand has.
        known: Vec<String>,
    },
    /// A set of less than two parts.
    #[error("{0}: a grasp needs at least two parts of the hand")]
    Few(String),
}

impl Asked {
    /// A type by number, name or alias.
    ///
    /// # Errors
    /// If there is none.
    pub fn type_named(name: &str) -> Result<Self, WishError> {
        let entry = Taxonomy::feix().named(name.trim());
        let entry = entry.ok_or_else(|| WishError::Type(name.to_owned()))?;
        Ok(Self::Type(entry.number))
    }

    /// A cell by name.
    ///
    /// # Errors
    /// If there is none.
    pub fn cell_named(name: &str) -> Result<Self, WishError> {
        let mut cells: Vec<String> = Vec::new();
        for entry in &Taxonomy::feix().types {
            if !cells.contains(&entry.cell) {
                cells.push(entry.cell.clone());
            }
        }
        let name = name.trim();
        if cells.iter().any(|cell| cell == name) {
            return Ok(Self::Cell(name.to_owned()));
        }
        let name = name.to_owned();
        Err(WishError::Cell { name, cells })
    }

    /// What is asked for, in words.
    pub fn name(&self) -> String {
        let joined = |names: &BTreeSet<String>| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            names.join("+")
        };
        match self {
            Self::Type(number) => Taxonomy::feix()
                .numbered(*number)
                .map_or_else(|| number.to_string(), |entry| entry.name.clone()),
            Self::Cell(cell) => cell.clone(),
            Self::Digits(names) | Self::Regions(names) => joined(names),
        }
    }

    /// The types that would grant it; none for digits and regions.
    fn types(&self) -> Vec<&'static GraspType> {
        let types = Taxonomy::feix().types.iter();
        match self {
            Self::Type(number) => types.filter(|entry| entry.number == *number).collect(),
            Self::Cell(cell) => types.filter(|entry| entry.cell == *cell).collect(),
            Self::Digits(_) | Self::Regions(_) => Vec::new(),
        }
    }
}

/// A wish for one hand on one object.
#[derive(Debug)]
pub struct Wishes<'a> {
    hand: &'a Hand,
    object: &'a Object,
    labeller: Labeller<'a>,
    names: HandNames,
    anatomy: Result<Anatomy, Unlike>,
    served: Vec<(Asked, Vec<Plan>)>,
}

impl<'a> Wishes<'a> {
    /// No wish for the hand of an energy on its object.
    pub fn none(hand: &'a Hand, object: &'a Object) -> Self {
        Self {
            hand,
            object,
            labeller: Labeller::new(hand, object, Rule::standard()),
            served: Vec::new(),
            names: HandNames::of(hand),
            anatomy: Anatomy::of(hand),
        }
    }

    /// Prepares wishes for the hand of an energy on its object.
    ///
    /// # Errors
    /// If a wish makes no sense for the hand.
    pub fn new(hand: &'a Hand, object: &'a Object, asked: &[Asked]) -> Result<Self, WishError> {
        let mut wishes = Self::none(hand, object);
        let planned = asked.iter().map(|asked| wishes.planned(asked));
        wishes.served = planned.collect::<Result<_, _>>()?;
        Ok(wishes)
    }

    /// Like [`Wishes::new`], without the wishes that make no sense for the hand.
    pub(super) fn possible(hand: &'a Hand, object: &'a Object, asked: &[Asked]) -> Self {
        let mut wishes = Self::none(hand, object);
        let planned = asked.iter().filter_map(|asked| wishes.planned(asked).ok());
        wishes.served = planned.collect();
        wishes
    }

    /// A wish and how it is tried.
    ///
    /// # Errors
    /// If it makes no sense for the hand.
    pub(super) fn planned(&self, asked: &Asked) -> Result<(Asked, Vec<Plan>), WishError> {
        let (hand, names) = (self.hand, &self.names);
        let plans = match asked {
            Asked::Type(_) | Asked::Cell(_) => {
                let anatomy = self.anatomy.as_ref().map_err(|why| WishError::Hand {
                    wish: asked.name(),
                    hand: hand.name.clone(),
                    why: *why,
                })?;
                let plans: Vec<Plan> = (asked.types().into_iter())
                    .filter(|entry| Rule::standard().can_be_done(anatomy, entry))
                    .filter_map(|entry| Plan::of_type(hand, anatomy, entry))
                    .collect();
                plans
            }
            Asked::Digits(digits) => {
                let groups = digits.iter().map(|name| {
                    let own = names.digit(name).ok_or_else(|| WishError::Name {
                        name: name.clone(),
                        hand: hand.name.clone(),
                        kind: "digit",
                        known: names.digit_names(),
                    })?;
                    let digit = hand.digits.iter().position(|known| known == own);
                    Ok(palmar_points(hand, digit.unwrap_or_default()))
                });
                Plan::of_groups(hand, asked, groups.collect::<Result<Vec<_>, WishError>>()?)?
            }
            Asked::Regions(regions) => {
                let groups = regions.iter().map(|name| {
                    let points = names.points(name);
                    if points.is_empty() {
                        return Err(WishError::Name {
                            name: name.clone(),
                            hand: hand.name.clone(),
                            kind: "region",
                            known: names.region_names(),
                        });
                    }
                    Ok(points)
                });
                Plan::of_groups(hand, asked, groups.collect::<Result<Vec<_>, WishError>>()?)?
            }
        };
        if plans.is_empty() {
            return Err(WishError::Digit {
                wish: asked.name(),
                hand: hand.name.clone(),
            });
        }
        // Digits go by their names in the file of the hand from here on.
        let asked = match asked {
            Asked::Digits(digits) => Asked::Digits(
                (digits.iter())
                    .filter_map(|name| names.digit(name).map(str::to_owned))
                    .collect(),
            ),
            other => other.clone(),
        };
        Ok((asked, plans))
    }

    /// Number of wishes.
    pub fn len(&self) -> usize {
        self.served.len()
    }

    /// Whether nothing is asked for.
    pub fn is_empty(&self) -> bool {
        self.served.is_empty()
    }

    /// The number of the wish that chain number `chain` serves: they take turns.
    ///
    /// # Panics
    /// If nothing is asked for.
    pub fn place(&self, chain: u64) -> usize {
        usize::try_from(chain % self.served.len() as u64).expect("less than the number of wishes")
    }

    /// The wish that chain number `chain` serves; `None` if nothing is asked for.
    pub fn of_chain(&self, chain: u64) -> Option<Served<'_>> {
        let place = (!self.is_empty()).then(|| self.place(chain))?;
        Some(Served {
            wishes: self,
            asked: &self.served[place].0,
            plans: &self.served[place].1,
        })
    }

    /// What pose `x` is, in the terms of a wish: its type or cell, the digits or the regions that touch.
    fn found(&self, asked: &Asked, x: &[f64]) -> String {
        match asked {
            Asked::Type(_) => self.labeller.label(x).text().to_owned(),
            Asked::Cell(_) => {
                let label = self.labeller.label(x);
                label.listed_cell().unwrap_or(label.text()).to_owned()
            }
            Asked::Digits(_) => {
                let touching = contact_regions(self.hand, self.object, x);
                touching.into_iter().collect::<Vec<_>>().join("+")
            }
            Asked::Regions(_) => {
                let touching = self.touching(x);
                touching.into_iter().collect::<Vec<_>>().join("+")
            }
        }
    }

    /// The regions with a surface point at most 2 mm off the object.
    fn touching(&self, x: &[f64]) -> BTreeSet<&str> {
        let mut posed = PosedHand::default();
        self.hand.pose(x, &mut posed);
        let points = posed.points.iter().enumerate();
        points
            .filter(|(i, _)| self.hand.may_touch(&self.hand.surface[*i]))
            .filter(|(_, point)| self.object.exact.distance(point) <= TOUCHING_M)
            .map(|(i, _)| self.names.regions[i].as_str())
            .collect()
    }

    fn grants(&self, asked: &Asked, x: &[f64]) -> bool {
        match asked {
            Asked::Type(number) => {
                let found = self.labeller.label(x).grasp_type();
                found.is_some_and(|entry| entry.number == *number)
            }
            Asked::Cell(cell) => self.labeller.label(x).listed_cell() == Some(cell),
            Asked::Digits(digits) => {
                let touching = contact_regions(self.hand, self.object, x);
                touching.into_iter().eq(digits.iter().map(String::as_str))
            }
            Asked::Regions(regions) => {
                let touching = self.touching(x);
                let part = |region: &str| region.split('.').next().map(str::to_owned);
                let asked: BTreeSet<_> = regions.iter().map(|region| part(region)).collect();
                let all = (regions.iter())
                    .all(|region| touching.iter().any(|found| is_within(found, region)));
                all && touching.iter().all(|found| asked.contains(&part(found)))
            }
        }
    }
}

/// The wish that a chain serves.
#[derive(Debug, Clone, Copy)]
pub struct Served<'a> {
    wishes: &'a Wishes<'a>,
    asked: &'a Asked,
    plans: &'a [Plan],
}

impl Served<'_> {
    /// What is asked for.
    pub fn asked(&self) -> &Asked {
        self.asked
    }

    /// Why the end of a chain at pose `x` is not what was asked for; `None` if it is.
    pub fn objection(&self, x: &[f64]) -> Option<String> {
        let granted = self.wishes.grants(self.asked, x);
        (!granted).then(|| match self.wishes.found(self.asked, x) {
            found if found.is_empty() => "touches nowhere".to_owned(),
            found => format!("became {found}"),
        })
    }
}

impl Wish for Served<'_> {
    fn begin(
        &self,
        energy: &GraspEnergy,
        chain: u64,
        attempt: u32,
        rng: &mut Rng,
    ) -> (Vec<f64>, Parts) {
        let (way, turn) = (attempt as usize % WAYS, attempt as usize / WAYS);
        let plan = &self.plans[turn % self.plans.len()];
        let (hand, object) = (energy.hand(), energy.object());
        let is_narrow = match plan.entry {
            Some(_) => way == 0,
            None => rng.random::<f64>() < TIPS,
        };
        let parts = match &plan.narrow {
            Some(narrow) if is_narrow => narrow,
            _ => &plan.parts,
        };
        // The first attempts of the chains that serve this wish are spread evenly over the object.
        let samples = &object.surface_samples;
        let turn = chain / self.wishes.len() as u64;
        let sample = match attempt {
            0 => usize::try_from(turn % samples.len() as u64)
                .expect("less than the number of samples"),
            _ => rng.random_range(0..samples.len()),
        };
        let fit = |posed: &PosedHand| match (plan.entry, &self.wishes.anatomy) {
            (Some(entry), Ok(anatomy)) => {
                Rule::standard().imagined_fit(entry, anatomy, posed, &plan.touch)
            }
            _ => 1.0,
        };
        let sample = &samples[sample];
        let start = if plan.entry.is_some() && way == WAYS - 1 {
            start_pose_facing(hand, sample, rng)
        } else if plan.by_palm && attempt.is_multiple_of(2) {
            start_facing(hand, &plan.sides, &fit, sample, rng)
        } else {
            start_between(hand, object, &plan.sides, &fit, sample, rng)
        };
        (start, parts.clone())
    }

    fn grants(&self, _energy: &GraspEnergy, pose: &[f64]) -> bool {
        self.wishes.grants(self.asked, pose)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::grip::Side;
    use crate::hand::LinkId;

    fn set(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    #[test]
    fn wishes_are_understood_or_refused() {
        let (human, gripper) = (Hand::human(), Hand::named("gripper_parallel").unwrap());
        let ball = Object::named("ball").unwrap();
        let error = |hand: &Hand, asked: Asked| Wishes::new(hand, &ball, &[asked]).unwrap_err();
        assert_eq!(Asked::type_named("tip pinch"), Ok(Asked::Type(24)));
        assert!(Asked::type_named("34").is_err());
        assert!(Asked::cell_named("precision/pad/2/abducted").is_ok());
        assert!(
            matches!(Asked::cell_named("power"), Err(WishError::Cell { cells, .. }) if cells.len() == 17)
        );
        assert!(matches!(
            error(&gripper, Asked::Type(9)),
            WishError::Hand { .. }
        ));
        assert!(matches!(
            error(&human, Asked::Digits(set(&["thumb"]))),
            WishError::Few(_)
        ));
        let unknown = error(&human, Asked::Digits(set(&["thumb", "pinky"])));
        assert!(
            unknown
                .to_string()
                .contains("thumb, index, middle, ring, little"),
            "{unknown}"
        );
        let unknown = error(
            &human,
            Asked::Regions(set(&["thumb.distal.pad", "index.pad"])),
        );
        assert!(
            unknown.to_string().contains("index.distal.pad"),
            "{unknown}"
        );
        let jaws = set(&["finger 1", "finger 2"]);
        assert!(Wishes::new(&gripper, &ball, &[Asked::Digits(jaws)]).is_ok());
    }

    #[test]
    fn only_the_links_of_a_pinch_take_part_and_a_lateral_grasp_takes_a_side() {
        let hand = Hand::human();
        let ball = Object::named("ball").unwrap();
        let wishes = Wishes::new(&hand, &ball, &[Asked::Type(9), Asked::Type(16)]).unwrap();
        let taken = |place: usize| -> Vec<(&str, Side)> {
            let parts = wishes.served[place].1[0].narrow.as_ref().unwrap();
            let links = (0..hand.links.len()).map(LinkId);
            links
                .filter_map(|link| Some((hand.links[link.0].name.as_str(), parts.side(link)?)))
                .collect()
        };
        let pinch = [
            ("thumb_distal", Side::Palmar),
            ("index_distal", Side::Palmar),
        ];
        assert_eq!(taken(0), pinch);
        let lateral = taken(1);
        let (_, side) = lateral
            .iter()
            .find(|(name, _)| *name == "index_distal")
            .unwrap();
        let Side::Toward(direction) = side else {
            panic!("{side:?}")
        };
        assert!(direction.x > 0.9, "{direction}");
    }
}
