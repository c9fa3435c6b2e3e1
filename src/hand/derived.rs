//! Writes the derived properties of a hand as a side file.

use std::collections::BTreeMap;

use super::side_file::{CapsuleEntry, DigitEntry, MetricEntry, PalmEntry, SideFile};
use super::{Hand, HandError, HandFiles, JointKind};

impl HandFiles {
    /// The side file that states all that is derived for this hand and all that its own side file states. It is a
    /// text to edit.
    ///
    /// The hand of the same files with this side file is the same hand.
    ///
    /// # Errors
    /// As [`Hand::from_files`].
    pub fn derived_side_file(&self) -> Result<String, HandError> {
        self.side_file_of(&Hand::from_files(self)?)
    }

    /// As [`HandFiles::derived_side_file`], for a hand that has already been read from these files.
    pub(crate) fn side_file_of(&self, hand: &Hand) -> Result<String, HandError> {
        let mut side = self.side()?;
        // A side file describes the hand before it is mirrored.
        let mirrored = side.mirror;
        let unmirrored = mirrored.then(|| hand.mirrored());
        let hand = unmirrored.as_ref().unwrap_or(hand);
        if !mirrored {
            side.name.get_or_insert_with(|| hand.name.clone());
        }
        side.palm.get_or_insert(PalmEntry {
            centre_m: hand.palm.centre.into(),
            volar: hand.palm.volar.into(),
            distal: hand.palm.distal.into(),
            faced_m: hand.palm.faced_m,
        });
        side.self_pairs.get_or_insert_with(|| hand.link_pairs());
        if self.mano().is_some() {
            // MANO's file says the rest, and its side file may not have the other entries.
            hand.fill_metric(&mut side.metric);
            return Ok(serde_json::to_string_pretty(&side)? + "\n");
        }
        side.comment.get_or_insert_with(|| {
            "What was derived for this hand. Change what you know better; entries that are missing are derived.".to_owned()
        });
        side.surface_points.get_or_insert(hand.surface.len());
        if side.digits.is_none() {
            side.digits = Some(hand.digit_entries());
        }
        for (capsule, exact) in hand.capsules.iter().zip(&hand.exact) {
            let name = &hand.links[capsule.link.0].name;
            if !exact && !side.capsules.contains_key(name) {
                side.filling.entry(name.clone()).or_default();
            }
        }
        let missing = |entries: &BTreeMap<String, Vec<CapsuleEntry>>| -> Vec<String> {
            let empty = entries.iter().filter(|(_, list)| list.is_empty());
            empty.map(|(name, _)| name.clone()).collect()
        };
        for name in missing(&side.filling) {
            let own = hand.capsules.iter().zip(&hand.exact);
            let own = own.filter(|(capsule, exact)| {
                !**exact && hand.links[capsule.link.0].name == name.as_str()
            });
            let entries = own.map(|(capsule, _)| CapsuleEntry {
                a: capsule.a.into(),
                b: capsule.b.into(),
                radius_m: capsule.radius_m,
            });
            let entries = entries.collect();
            side.filling.insert(name, entries);
        }
        hand.fill_joints(&mut side);
        Ok(serde_json::to_string_pretty(&side)? + "\n")
    }
}

impl Hand {
    /// The digits and their links, one segment per link.
    fn digit_entries(&self) -> Vec<DigitEntry> {
        let entry = |(digit, name): (usize, &String)| DigitEntry {
            name: name.clone(),
            segments: (self.links.iter())
                .filter(|link| link.digit == digit)
                .map(|link| (link.name.clone(), vec![link.name.clone()]))
                .collect(),
        };
        self.digits.iter().enumerate().skip(1).map(entry).collect()
    }

    /// Pairs of links with capsules that are checked against each other.
    fn link_pairs(&self) -> Vec<[String; 2]> {
        let links = self
            .self_pairs
            .iter()
            .map(|pair| pair.map(|capsule| self.capsules[capsule].link.0));
        let mut links: Vec<[usize; 2]> = links.collect();
        links.sort_unstable();
        links.dedup();
        let names = |pair: [usize; 2]| pair.map(|link| self.links[link].name.clone());
        links.into_iter().map(names).collect()
    }

    fn fill_joints(&self, side: &mut SideFile) {
        for (j, joint) in self.joints.iter().enumerate() {
            let name = || joint.name.clone();
            let [rest, deviation] = [self.prior.rest[j], self.own_deviation(j)];
            match joint.kind {
                JointKind::Hinge => {
                    side.rest_deg.entry(name()).or_insert(rest.to_degrees());
                    side.deviation_deg
                        .entry(name())
                        .or_insert(deviation.to_degrees());
                }
                JointKind::Slide => {
                    side.rest_mm.entry(name()).or_insert(1e3 * rest);
                    side.deviation_mm.entry(name()).or_insert(1e3 * deviation);
                }
            }
        }
        self.fill_metric(&mut side.metric);
    }

    fn fill_metric(&self, entries: &mut MetricEntry) {
        let metric = self.pose_metric();
        let lengths = metric.joint_levers_m.iter().zip(&metric.joint_reaches_m);
        for (joint, (lever, reach)) in self.joints.iter().zip(lengths) {
            entries.levers_m.entry(joint.name.clone()).or_insert(*lever);
            entries
                .reaches_m
                .entry(joint.name.clone())
                .or_insert(*reach);
        }
        entries
            .radius_of_gyration_m
            .get_or_insert(metric.radius_of_gyration_m);
        entries
            .rotation_reach_m
            .get_or_insert(metric.rotation_reach_m);
    }

    /// A quarter of the range, the default of the side file's deviations. The prior's own deviations include the synergies.
    fn own_deviation(&self, j: usize) -> f64 {
        let [lower, upper] = self.joints[j].limits;
        (upper - lower) / 4.0
    }
}
