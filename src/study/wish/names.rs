//! Names of the parts of a hand by which people ask for them.

use std::collections::BTreeSet;

use crate::evaluation::taxonomy::Anatomy;
use crate::hand::Hand;

/// Names of the parts of a hand, for wishes.
#[derive(Debug, Clone)]
pub struct HandNames {
    /// For each digit, the palm first, the names it is known by.
    digits: Vec<Vec<String>>,
    /// For each surface point, the name of its region.
    pub(super) regions: Vec<String>,
}

impl HandNames {
    /// Digits have their names in the file of the hand, and those of a human hand where it is built like one; regions are
    /// those that the hand names, or else those of a human hand, or else its links.
    pub fn of(hand: &Hand) -> Self {
        let anatomy = Anatomy::of(hand).ok();
        let patch = |i: usize| anatomy.as_ref().map(|anatomy| anatomy.patch(i).name());
        let regions = hand.surface.iter().enumerate().map(|(i, point)| {
            let own = &hand.regions[point.region];
            match patch(i) {
                Some(patch) if !own.contains('.') => patch,
                _ => own.clone(),
            }
        });
        let regions: Vec<String> = regions.collect();
        let digits = (hand.digits.iter().enumerate()).map(|(digit, own)| {
            let of_digit = |i: &usize| hand.links[hand.surface[*i].link.0].digit == digit;
            let first = (0..hand.surface.len()).find(of_digit).and_then(patch);
            let human = first.and_then(|name| Some(name.split('.').next()?.to_owned()));
            let mut names = vec![own.clone()];
            names.extend(human.filter(|human| human != own && digit > 0));
            names
        });
        Self {
            digits: digits.collect(),
            regions,
        }
    }

    /// The name in the hand's file of a digit.
    pub(super) fn digit(&self, name: &str) -> Option<&str> {
        let known = |names: &&Vec<String>| names.iter().any(|known| known == name);
        Some(self.digits.iter().find(known)?.first()?.as_str())
    }

    /// The numbers of the surface points of a region, or of all regions whose names begin with it.
    pub(super) fn points(&self, region: &str) -> Vec<usize> {
        let own = |i: &usize| is_within(&self.regions[*i], region);
        (0..self.regions.len()).filter(own).collect()
    }

    pub(super) fn digit_names(&self) -> Vec<String> {
        // The name of a human hand is the shorter one to type.
        let names = self.digits.iter().filter_map(|names| names.last());
        names.cloned().collect()
    }

    pub(super) fn region_names(&self) -> Vec<String> {
        let names: BTreeSet<&String> = self.regions.iter().collect();
        names.into_iter().cloned().collect()
    }
}

/// Whether a region is the given one or a part of it.
pub(super) fn is_within(region: &str, whole: &str) -> bool {
    let rest = region.strip_prefix(whole);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}
