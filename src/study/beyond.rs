//! Grasps that a set lacks: chains that start where the unseen is expected, and an archive that keeps only what is far from
//! all that is there.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;

use super::synthesis::{
    Origin, PopulationSettings, Synthesis, judged, objection, one_chain, outcomes, usual_chains,
};
use super::wish::{Asked, Served, Wishes};
use super::{JournalError, Run, StudyError, tally};
use crate::evaluation::contact_regions;
use crate::evaluation::taxonomy::{Labeller, Rule, UNLISTED};
use crate::grasp::grip::Parts;
use crate::grasp::start::start_pose_facing;
use crate::grasp::synthesis::{Given, SynthesisSettings, Synthesized, Wish};
use crate::grasp::{GraspEnergy, Judgement};
use crate::hand::Hand;
use crate::mesh::SurfaceSample;
use crate::object::Object;
use crate::sample::Rng;
use crate::space::Space;
use crate::store::{GraspRow, LandscapeFiles, Population};
use crate::topography::Phase;

/// Chains of a round. Where a round starts follows from all rounds before it.
const ROUND: u64 = 32;
/// Kinds of starts, which the chains of a round take in turn.
const KINDS: u64 = 4;
/// Places far from all contacts at which chains of a round start.
const FAR: usize = 8;
/// How far a chain that starts beside a pose is moved first, in distances of the archive.
const BESIDE: f64 = 4.0;
/// Greatest number of descents of a chain that is asked for a set of digits which the set lacks.
const WISHED_STEPS: u32 = 8;
/// Least number of ends before their statistics end the search. With fewer, the number of kinds met once says little.
const LEAST_ENDS: usize = 30;
/// A minimum is rare if at most so many grasps descended into it.
const RARE: usize = 2;
/// Fraction of the grasps of a set without a landscape beside which chains start: those farthest from all others.
const LONELY_SHARE: usize = 4;

/// What is there already.
#[derive(Debug, Clone, PartialEq)]
pub struct Archive {
    /// Poses of grasps and minima.
    pub known: Vec<Vec<f64>>,
    /// Poses beside which the unseen is expected: rare minima, minima of no type and the tops of paths of a landscape; the
    /// grasps farthest from all others and those of no type of a file.
    pub rare: Vec<Vec<f64>>,
    /// Least distance of a new grasp from all others, metres of the pose space: the root mean square movement of the hand's
    /// surface, modulo the symmetry of the object.
    pub distance_m: f64,
    /// The search ends when one more end is new with less than this chance.
    pub chance: f64,
}

/// What a set lacked.
#[derive(Debug, Clone, PartialEq)]
pub struct Added {
    /// Number of grasps and minima that were there.
    pub known: usize,
    /// Number of given grasps, each of which was refined first.
    pub given: usize,
    /// How many of these became grasps that pass the filter.
    pub repaired: usize,
    /// Number of chains of the search.
    pub chains: usize,
    /// Number of their ends that pass the filter.
    pub ends: usize,
    /// How many of these are new: far from all that is there and from each other.
    pub new: usize,
    /// Good–Turing estimate of the chance that one more end is new; `None` without ends.
    pub chance: Option<f64>,
    /// Grasp types of the new ones, most frequent first; empty if the taxonomy does not apply to the hand.
    pub types: Vec<(String, usize)>,
    /// Sets of digits (and the palm) with which the new ones touch, most frequent first.
    pub contacts: Vec<(String, usize)>,
}

impl Archive {
    /// Greatest distance of the default, metres, and the default chance.
    pub const DISTANCE_M: f64 = 0.005;
    /// See [`Archive::chance`].
    pub const CHANCE: f64 = 0.1;

    /// The grasps of a population on the space of `energy`, which must be that of its hand and object.
    pub fn of_population(energy: &GraspEnergy, population: &Population<'_>) -> Self {
        let rows = &population.grasps;
        let known: Vec<Vec<f64>> = rows.iter().map(|row| pose(row)).collect();
        let space = energy.pose_space();
        let away = |place: usize| {
            let others = (0..known.len()).filter(|other| *other != place);
            let distances = others.map(|other| space.distance(&known[place], &known[other]));
            distances.fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<f64> = (0..known.len()).into_par_iter().map(away).collect();
        let mut lonely: Vec<usize> = (0..known.len()).collect();
        lonely.sort_by(|a, b| distances[*b].total_cmp(&distances[*a]).then(a.cmp(b)));
        lonely.truncate(known.len().div_ceil(LONELY_SHARE));
        let unlisted = (0..rows.len()).filter(|place| is_unlisted(rows[*place]));
        let rare = lonely.iter().copied().chain(unlisted);
        Self {
            rare: once_each(rare).map(|place| known[place].clone()).collect(),
            known,
            ..Self::empty()
        }
    }

    /// The minima of a landscape in `folder`, and its grasps.
    ///
    /// # Errors
    /// If the folder is no landscape of grasps, or damaged.
    pub fn of_landscape(folder: &Path) -> Result<Self, StudyError> {
        let files = LandscapeFiles::read(folder)?;
        let grasps = LandscapeFiles::grasps(folder)?;
        let grasps = grasps.ok_or_else(|| StudyError::NotOfGrasps(folder.display().to_string()))?;
        let minima = &files.minima;
        let mut rare: Vec<usize> = (0..minima.len())
            .filter(|minimum| minima[*minimum].members.len() <= RARE)
            .collect();
        rare.sort_by_key(|minimum| minima[*minimum].members.len());
        let unlisted =
            (0..minima.len()).filter(|minimum| minima[*minimum].label() == Some(UNLISTED));
        // Descents from the tops of paths end in minima that nobody listed.
        let tops = files.paths.iter().filter(|point| point.terms.is_some());
        let tops: Vec<&[f64]> = tops.map(|point| point.coordinates.as_slice()).collect();
        let rare = once_each(rare.into_iter().chain(unlisted));
        let rare: Vec<&[f64]> = rare
            .map(|minimum| minima[minimum].coordinates.as_slice())
            .collect();
        let of_minima = minima.iter().map(|minimum| minimum.coordinates.clone());
        Ok(Self {
            rare: in_turn(&rare, &tops),
            known: of_minima.chain(grasps.grasps.iter().map(pose)).collect(),
            ..Self::empty()
        })
    }

    fn empty() -> Self {
        Self {
            known: Vec::new(),
            rare: Vec::new(),
            distance_m: Self::DISTANCE_M,
            chance: Self::CHANCE,
        }
    }

    /// A text of all that a chain depends on.
    pub fn fingerprint(&self) -> String {
        format!("{self:?}")
    }
}

fn pose(row: &GraspRow) -> Vec<f64> {
    row.grasp.pose.to_vec()
}

fn is_unlisted(row: &GraspRow) -> bool {
    row.label
        .as_ref()
        .or(row.label_auto.as_ref())
        .is_some_and(|label| label == UNLISTED)
}

/// The poses of two lists, one of each in turn while both last.
fn in_turn(one: &[&[f64]], other: &[&[f64]]) -> Vec<Vec<f64>> {
    let places = 0..one.len().max(other.len());
    let both = places.flat_map(|place| [one.get(place), other.get(place)]);
    both.flatten().map(|pose| pose.to_vec()).collect()
}

fn once_each(places: impl Iterator<Item = usize>) -> impl Iterator<Item = usize> {
    let mut seen = BTreeSet::new();
    places.filter(move |place| seen.insert(*place))
}

/// Runs chains of `energy`, which must be that of `origin`, and keeps the ends that `archive` lacks.
///
/// Given grasps are refined first, and those that pass are kept: they are repaired. Then rounds of chains start at random,
/// beside the rare poses of the archive, with sets of digits that touch nowhere in it, and at places of the object far from
/// all contacts. Wishes of the settings replace the sets of digits. An end is new if it is farther than the distance of the
/// archive from all that is there and from each other new one. After each round the chance that one more end is new is
/// estimated (I. J. Good, Biometrika 40, 237 (1953)):
///
/// ```text
/// chance = (number of new ends that no other end came near) / (number of ends)
/// ```
///
/// The search ends when it falls below that of the archive, or after `settings.chains` chains. The estimate is one for the
/// mixture of starts, not for uniform ones. The result does not depend on threads or interruptions.
///
/// # Errors
/// If the journal takes no record.
///
/// # Panics
/// As [`synthesize_population`](super::synthesize_population).
pub fn synthesize_beyond(
    energy: &GraspEnergy,
    origin: &Origin,
    settings: &PopulationSettings,
    archive: &Archive,
    run: &Run<'_>,
) -> Result<(Synthesis, Added), JournalError> {
    let wishes = settings.wishes(energy);
    let wishes = wishes.expect("wishes were understood before");
    let given = origin.given.len() as u64;
    let numbers: Vec<u64> = (0..given).collect();
    let tally = run.tally(Phase::Synthesize, numbers.len());
    let none = Wishes::none(energy.hand(), energy.object());
    let tasks = (numbers.as_slice(), &tally, "");
    let mut chains = usual_chains(energy, origin, settings, &none, tasks, run)?;
    let mut grasps: Vec<GraspRow> = (chains.iter())
        .filter(|(end, judgement)| objection(None, end, judgement, settings).is_none())
        .map(|(end, judgement)| origin.row(energy, settings.seed, end, judgement))
        .collect();
    let mut added = Added {
        known: archive.known.len(),
        given: origin.given.len(),
        repaired: grasps.len(),
        chains: 0,
        ends: 0,
        new: 0,
        chance: None,
        types: Vec::new(),
        contacts: Vec::new(),
    };
    let mut search = Search {
        energy,
        settings,
        archive,
        known: archive.known.clone(),
        met: Vec::new(),
    };
    search.known.extend(grasps.iter().map(pose));
    let mut objections = Vec::new();
    let mut next = 0;
    while next < settings.chains {
        let round: Vec<u64> = (next..(next + ROUND).min(settings.chains)).collect();
        next += round.len() as u64;
        let most = settings.chains.div_ceil(ROUND);
        let tally = (round[0] / ROUND, most);
        let tally = [tally.0, tally.1].map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        let ends = search.round(given, &round, &wishes, (tally[0], tally[1]), run)?;
        let found: Vec<Option<String>> = (ends.par_iter())
            .map(|(end, judgement)| {
                objection(wishes.of_chain(end.chain - given), end, judgement, settings)
            })
            .collect();
        for ((end, judgement), objection) in ends.iter().zip(&found) {
            if objection.is_none() {
                added.ends += 1;
                if search.is_new(&end.refined.pose) {
                    let row = origin.row(energy, settings.seed, end, judgement);
                    grasps.push(GraspRow {
                        source: concat!("landscape ", env!("CARGO_PKG_VERSION"), " synth --beyond")
                            .to_owned(),
                        ..row
                    });
                }
            }
        }
        chains.extend(ends);
        objections.extend(found);
        let once = search.met.iter().filter(|(_, count)| *count == 1).count();
        added.chance = (added.ends > 0).then(|| once as f64 / added.ends as f64);
        if added.ends >= LEAST_ENDS && added.chance.is_some_and(|chance| chance < archive.chance) {
            break;
        }
    }
    added.chains = objections.len();
    added.new = grasps.len() - added.repaired;
    describe(energy, &grasps[added.repaired..], &mut added);
    let found = Synthesis {
        wishes: outcomes(&wishes, &objections),
        chains,
        grasps,
    };
    Ok((found, added))
}

/// Names the types and contacts of new grasps.
fn describe(energy: &GraspEnergy, new: &[GraspRow], added: &mut Added) {
    let (hand, object) = (energy.hand(), energy.object());
    let labeller = Labeller::new(hand, object, Rule::standard());
    if labeller.applies() {
        let labels: Vec<&str> = (new.par_iter())
            .map(|row| labeller.label(&row.grasp.pose).text())
            .collect();
        added.types = tally(labels.into_iter());
    }
    let contacts: Vec<String> = (new.par_iter())
        .map(|row| set_name(&contact_regions(hand, object, &row.grasp.pose)))
        .collect();
    added.contacts = tally(contacts.iter().map(String::as_str));
}

fn set_name(digits: &BTreeSet<&str>) -> String {
    let digits: Vec<&str> = digits.iter().copied().collect();
    digits.join("+")
}

/// A search for what an archive lacks.
struct Search<'a> {
    energy: &'a GraspEnergy,
    settings: &'a PopulationSettings,
    archive: &'a Archive,
    /// Poses that are there.
    known: Vec<Vec<f64>>,
    /// New poses, and how many ends came near each.
    met: Vec<(Vec<f64>, usize)>,
}

impl Search<'_> {
    /// Whether an end is far from all others; counts it.
    fn is_new(&mut self, x: &[f64]) -> bool {
        let (space, reach) = (self.energy.pose_space(), self.archive.distance_m);
        if self
            .known
            .par_iter()
            .any(|known| space.within(known, x, reach))
        {
            return false;
        }
        let near = self
            .met
            .iter_mut()
            .find(|(met, _)| space.within(met, x, reach));
        if let Some((_, count)) = near {
            *count += 1;
            return false;
        }
        self.met.push((x.to_vec(), 1));
        true
    }

    /// The ends of the chains of a round.
    fn round(
        &self,
        given: u64,
        round: &[u64],
        wishes: &Wishes<'_>,
        tally: (usize, usize),
        run: &Run<'_>,
    ) -> Result<Vec<(Synthesized, Judgement)>, JournalError> {
        let energy = self.energy;
        let (hand, object) = (energy.hand(), energy.object());
        let poses: Vec<&[f64]> = (self.known.iter().map(Vec::as_slice))
            .chain(self.met.iter().map(|(met, _)| met.as_slice()))
            .collect();
        let unused = unused_sets(hand, object, &poses);
        // A digit may have no point that may touch.
        let unused = Wishes::possible(hand, object, &unused);
        let far = self.far_places(&poses, FAR);
        let of_chain = &self.settings.experiment.synthesis;
        let ends = run.each(
            &run.tally_of_round(Phase::Synthesize, tally, round.len()),
            round,
            |chain| format!("chain {}", given + chain),
            |chain| {
                let (kind, turn) = (chain % KINDS, chain / KINDS);
                let place = |of: usize| usize::try_from(turn % of.max(1) as u64).unwrap_or(0);
                let rare = self.archive.rare.get(place(self.archive.rare.len()));
                let beside = rare.filter(|_| kind == 1).map(|x| Given {
                    x,
                    displacement_m: BESIDE * self.archive.distance_m,
                });
                let facing = Facing {
                    sample: far[place(far.len())],
                    settings: of_chain,
                };
                let fewer = SynthesisSettings {
                    steps: of_chain.steps.min(WISHED_STEPS),
                    ..*of_chain
                };
                let task = [self.settings.seed, given + chain];
                let asked: Option<Served<'_>> = wishes.of_chain(*chain);
                match (asked, kind) {
                    (Some(asked), _) => one_chain(energy, of_chain, task, beside, Some(&asked)),
                    (None, 2) => match unused.of_chain(turn) {
                        Some(set) => one_chain(energy, &fewer, task, None, Some(&set)),
                        None => one_chain(energy, of_chain, task, None, None),
                    },
                    (None, 3) => one_chain(energy, of_chain, task, None, Some(&facing)),
                    (None, _) => one_chain(energy, of_chain, task, beside, None),
                }
            },
        )?;
        Ok(judged(energy, ends))
    }

    /// Points of the object's surface far from the contacts of all poses and from each other.
    fn far_places(&self, poses: &[&[f64]], count: usize) -> Vec<SurfaceSample> {
        let energy = self.energy;
        let centres = poses
            .par_iter()
            .map(|x| energy.contact_centre(x, &energy.contacts(x)));
        let centres: Vec<_> = centres.collect();
        let samples = &energy.object().surface_samples;
        let mut gaps: Vec<f64> = (samples.iter())
            .map(|sample| {
                let gaps = centres.iter().map(|centre| (centre - sample.point).norm());
                gaps.fold(f64::INFINITY, f64::min)
            })
            .collect();
        (0..count)
            .map(|_| {
                let farthest = (0..samples.len()).max_by(|a, b| gaps[*a].total_cmp(&gaps[*b]));
                let sample = samples[farthest.unwrap_or(0)];
                for (gap, other) in gaps.iter_mut().zip(samples) {
                    *gap = gap.min((sample.point - other.point).norm());
                }
                sample
            })
            .collect()
    }
}

/// Sets of digits, with and without the palm, with which no pose touches; with a thumb only those that have it.
fn unused_sets(hand: &Hand, object: &Object, poses: &[&[f64]]) -> Vec<Asked> {
    let used: BTreeSet<BTreeSet<&str>> = (poses.par_iter())
        .map(|x| contact_regions(hand, object, x))
        .collect();
    // A set is a number whose bits are its digits; hands have few.
    let digits = &hand.digits[..hand.digits.len().min(MOST_DIGITS)];
    let sets = (0..1usize << digits.len()).filter_map(|bits| {
        let members = (digits.iter().enumerate()).filter(|(digit, _)| (bits >> digit) & 1 == 1);
        let set: BTreeSet<&str> = members.map(|(_, name)| name.as_str()).collect();
        let thumb = !hand.has_thumb() || (bits >> 1) & 1 == 1;
        (thumb && set.len() > 1 && !used.contains(&set)).then_some(set)
    });
    let mut sets: Vec<BTreeSet<&str>> = sets.collect();
    sets.sort_by(|a, b| a.len().cmp(&b.len()).then(a.cmp(b)));
    let named = |set: BTreeSet<&str>| Asked::Digits(set.into_iter().map(str::to_owned).collect());
    sets.into_iter().map(named).collect()
}

/// Palm and digits of a hand that sets are made of.
const MOST_DIGITS: usize = 7;

/// A wish for any grasp from starts with the palm facing a place.
struct Facing<'a> {
    sample: SurfaceSample,
    settings: &'a SynthesisSettings,
}

impl Wish for Facing<'_> {
    fn begin(
        &self,
        energy: &GraspEnergy,
        _chain: u64,
        _attempt: u32,
        rng: &mut Rng,
    ) -> (Vec<f64>, Parts) {
        let hand = energy.hand();
        let grip = self.settings.grips.draw(hand, rng);
        (start_pose_facing(hand, &self.sample, rng), grip.parts(hand))
    }

    fn grants(&self, _energy: &GraspEnergy, _pose: &[f64]) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_lists_take_turns() {
        let (one, other) = ([&[1.0][..], &[2.0]], [&[3.0][..]]);
        assert_eq!(in_turn(&one, &other), [[1.0], [3.0], [2.0]]);
    }

    #[test]
    fn sets_of_digits_that_touch_nowhere_are_unused() {
        let hand = Hand::human();
        let ball = Object::named("ball").unwrap();
        let mut far = hand.rest_coordinates();
        far[0] = 1.0;
        let all = unused_sets(&hand, &ball, &[&far]);
        // The thumb with some of four fingers and the palm.
        assert_eq!(all.len(), 31);
        let gripper = Hand::named("gripper_parallel").unwrap();
        let mut far = gripper.rest_coordinates();
        far[0] = 1.0;
        assert_eq!(unused_sets(&gripper, &ball, &[&far]).len(), 4);
    }
}
