//! From a hand and an object to a population of grasps.

use rayon::prelude::*;

use serde_json::json;

use super::wish::{Asked, Served, WishError, Wishes};
use super::{Experiment, JournalError, Run, tally};
use crate::grasp::spread::spread;
use crate::grasp::synthesis::{
    Given, SynthesisSettings, Synthesized, Wish, synthesize, synthesize_from, synthesize_towards,
};
use crate::grasp::{GraspEnergy, Judgement, judge};
use crate::hand::HandFiles;
use crate::object::{Object, ObjectParts};
use crate::optimize::QuenchSettings;
use crate::store::{
    GraspRow, HandMetadata, LIMIT_TOLERANCE_RAD, Metadata, ObjectMetadata, Population,
    RebuildError, SCHEMA_VERSION, content_hash,
};
use crate::topography::{Phase, Tally};

/// What grasps are made of: a hand, an object, and possibly grasps to start from.
#[derive(Debug, Clone, PartialEq)]
pub struct Origin {
    /// The hand.
    pub hand: HandMetadata,
    /// The object at scale 1.
    pub object: ObjectMetadata,
    /// Factor on the size of the object.
    pub scale: f64,
    /// Grasps to start from: chain i from row i, and again from the first after the last. Empty for random starts.
    pub given: Vec<GraspRow>,
}

/// Settings of [`synthesize_population`].
#[derive(Debug, Clone, PartialEq)]
pub struct PopulationSettings {
    /// The energy, and how a chain runs.
    pub experiment: Experiment,
    /// Seed of every random draw.
    pub seed: u64,
    /// Number of chains; each gives one grasp at most.
    pub chains: u64,
    /// How far each given grasp is moved at first, in a random direction, metres.
    pub displacement_m: f64,
    /// Which ends of chains are kept.
    pub keep: Keep,
    /// Keeps at most so many of them, spread evenly over the object.
    pub at_most: Option<usize>,
    /// What is asked for; chains serve these wishes in turn, and an end counts only if it is what its chain was asked for.
    /// Empty for any grasp.
    pub asked: Vec<Asked>,
}

impl Default for PopulationSettings {
    fn default() -> Self {
        Self {
            experiment: Experiment::default(),
            seed: 0,
            chains: 64,
            displacement_m: 0.0,
            keep: Keep::Strict,
            at_most: None,
            asked: Vec::new(),
        }
    }
}

impl PopulationSettings {
    /// The wishes, prepared for the hand and the object of an energy.
    ///
    /// # Errors
    /// If a wish makes no sense for the hand.
    pub fn wishes<'a>(&self, energy: &'a GraspEnergy) -> Result<Wishes<'a>, WishError> {
        Wishes::new(energy.hand(), energy.object(), &self.asked)
    }
}

/// Which ends of chains are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// Those that pass the strict filter.
    Strict,
    /// Those that pass Eq. 11 of Liu et al. (2021).
    Published,
    /// Every one.
    All,
}

impl Keep {
    fn keeps(self, judgement: &Judgement) -> bool {
        match self {
            Self::Strict => judgement.passes_strict(),
            Self::Published => judgement.passes_published(),
            Self::All => true,
        }
    }
}

/// What [`synthesize_population`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct Synthesis {
    /// The ends of all chains and their judgements, in the order of the chains.
    pub chains: Vec<(Synthesized, Judgement)>,
    /// What was kept.
    pub grasps: Vec<GraspRow>,
    /// What came of each wish.
    pub wishes: Vec<WishOutcome>,
}

/// What came of a wish.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WishOutcome {
    /// What was asked for.
    pub wish: String,
    /// Number of chains that served it.
    pub chains: usize,
    /// How many of them ended in a grasp that is what was asked for.
    pub found: usize,
    /// Why the others did not, with their numbers, most frequent first.
    pub refused: Vec<(String, usize)>,
}

impl Origin {
    /// A hand and an object that come with the program, by name, at scale 1.
    ///
    /// # Errors
    /// If there is no hand or no object of that name.
    pub fn named(hand: &str, object: &str) -> Result<Self, RebuildError> {
        let files = HandFiles::named(hand).map_err(|source| RebuildError::Hand {
            file: hand.to_owned(),
            source,
        })?;
        let (mesh, description) = Object::parts_of_named(object)?;
        let parts = ObjectParts {
            name: object.to_owned(),
            mesh,
            notes: Vec::new(),
            description,
        };
        Ok(Self {
            hand: HandMetadata::new(hand.to_owned(), &files)?,
            object: ObjectMetadata::new(&parts)?,
            scale: 1.0,
            given: Vec::new(),
        })
    }

    /// Whether a population has the same hand, object and scale.
    pub fn is_of(&self, population: &Population<'_>) -> bool {
        let (hand, object) = (population.hand, population.object);
        self.hand.is_same_hand(hand)
            && self.object.content_hash == object.content_hash
            && self.scale.to_bits() == population.scale.to_bits()
    }

    /// Hand, object and grasps of a population.
    pub fn of_population(population: &Population<'_>) -> Self {
        Self {
            hand: population.hand.clone(),
            object: population.object.clone(),
            scale: population.scale,
            given: population.grasps.iter().copied().cloned().collect(),
        }
    }

    /// Builds the energy.
    ///
    /// # Errors
    /// If hand, object or settings are not valid.
    pub fn energy(&self, settings: &PopulationSettings) -> Result<GraspEnergy, RebuildError> {
        let (hand, object) = (self.hand.build()?, self.object.build(self.scale)?);
        Ok(GraspEnergy::new(hand, object, settings.experiment.energy)?)
    }

    /// What a file of the grasps says about itself, without the command that made it.
    ///
    /// # Errors
    /// If the settings cannot be stored.
    pub fn metadata(
        &self,
        energy: &GraspEnergy,
        settings: &PopulationSettings,
    ) -> Result<Metadata, serde_json::Error> {
        let mut told = serde_json::to_value(settings.experiment.synthesis)?;
        if !settings.asked.is_empty() {
            told["asked"] = json!(settings.asked);
        }
        Ok(Metadata {
            schema_version: SCHEMA_VERSION,
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            seed: settings.seed,
            hands: vec![self.hand.clone()],
            objects: vec![self.object.clone()],
            energy: serde_json::to_value(settings.experiment.energy)?,
            settings: told,
            terms: energy.term_names(),
            ..Metadata::default()
        })
    }

    /// A hash of all that a chain depends on, for the journal. How many chains there are and which are kept is no part of
    /// it.
    ///
    /// # Errors
    /// If the settings cannot be stored.
    pub fn fingerprint(
        &self,
        energy: &GraspEnergy,
        settings: &PopulationSettings,
    ) -> Result<String, serde_json::Error> {
        let metadata = serde_json::to_string(&self.metadata(energy, settings)?)?;
        let given = format!("{:?} {:?}", settings.displacement_m, self.given);
        Ok(content_hash(&[metadata.as_bytes(), given.as_bytes()]))
    }

    /// The grasp that chain number `chain` starts from.
    pub(super) fn given(&self, chain: u64) -> Option<&GraspRow> {
        let count = self.given.len() as u64;
        let place = chain.checked_rem(count)?;
        self.given.get(usize::try_from(place).ok()?)
    }

    pub(super) fn row(
        &self,
        energy: &GraspEnergy,
        seed: u64,
        end: &Synthesized,
        judged: &Judgement,
    ) -> GraspRow {
        let program = concat!("landscape ", env!("CARGO_PKG_VERSION"), " synth");
        let mut row = GraspRow {
            id: end.chain,
            object: self.object.name.clone(),
            scale: self.scale,
            hand: self.hand.name.clone(),
            grasp: end.refined.clone(),
            source: match self.given(end.chain) {
                None => program.to_owned(),
                Some(given) => format!("{program} from {}", given.id),
            },
            chain_seed: seed,
            chain_step: end.steps,
            ..GraspRow::default()
        };
        row.set_measures(energy, &end.refined, judged);
        row.energy = end.energy;
        row
    }
}

/// Runs chains of `energy`, which must be that of `origin`, and keeps the ends that pass.
///
/// Chain i draws from random stream i: a chain does not depend on the others, on threads or on interruptions. Finished
/// chains are kept in the journal of the run.
///
/// # Errors
/// If the journal takes no record.
///
/// # Panics
/// If the settings ask for no attempt, a given grasp is one of another hand, or a wish makes no sense for the hand
/// ([`PopulationSettings::wishes`]).
pub fn synthesize_population(
    energy: &GraspEnergy,
    origin: &Origin,
    settings: &PopulationSettings,
    run: &Run<'_>,
) -> Result<Synthesis, JournalError> {
    let wishes = settings.wishes(energy);
    let wishes = wishes.expect("wishes were understood before");
    let numbers: Vec<u64> = (0..settings.chains).collect();
    let tally = run.tally(Phase::Synthesize, numbers.len());
    let tasks = (numbers.as_slice(), &tally, "");
    let chains = usual_chains(energy, origin, settings, &wishes, tasks, run)?;
    let objections: Vec<Option<String>> = (chains.par_iter())
        .map(|(end, judgement)| objection(wishes.of_chain(end.chain), end, judgement, settings))
        .collect();
    let mut kept: Vec<&(Synthesized, Judgement)> = chains
        .iter()
        .zip(&objections)
        .filter_map(|(end, objection)| objection.is_none().then_some(end))
        .collect();
    if let Some(limit) = settings.at_most {
        let place =
            |end: &Synthesized| energy.contact_centre(&end.refined.pose, &end.refined.contacts);
        let (places, costs): (Vec<_>, Vec<_>) =
            kept.iter().map(|(end, _)| (place(end), end.energy)).unzip();
        let chosen = spread(&places, &costs, &energy.object().symmetry, limit);
        kept = chosen.into_iter().map(|i| kept[i]).collect();
    }
    let grasps = kept
        .iter()
        .map(|(end, judgement)| origin.row(energy, settings.seed, end, judgement))
        .collect();
    Ok(Synthesis {
        grasps,
        wishes: outcomes(&wishes, &objections),
        chains,
    })
}

/// Runs chains from the given grasps, if there are some, and for the wishes in turn, if there are some, and judges their ends.
/// `tasks` are the numbers of the chains, the tally that shows them, and what stands before their keys in the journal.
pub(super) fn usual_chains(
    energy: &GraspEnergy,
    origin: &Origin,
    settings: &PopulationSettings,
    wishes: &Wishes<'_>,
    (numbers, tally, before): (&[u64], &Tally<'_>, &str),
    run: &Run<'_>,
) -> Result<Vec<(Synthesized, Judgement)>, JournalError> {
    let key = |chain: &u64| format!("{before}chain {chain}");
    let ends = run.each(tally, numbers, key, |chain| {
        let given = origin.given(*chain).map(|row| Given {
            x: &row.grasp.pose,
            displacement_m: settings.displacement_m,
        });
        let served = wishes.of_chain(*chain);
        let wish = served.as_ref().map(|served| served as &dyn Wish);
        let of_chain = &settings.experiment.synthesis;
        one_chain(energy, of_chain, [settings.seed, *chain], given, wish)
    })?;
    Ok(judged(energy, ends))
}

/// Judges the ends of chains.
pub(super) fn judged(
    energy: &GraspEnergy,
    ends: Vec<Synthesized>,
) -> Vec<(Synthesized, Judgement)> {
    let judged = ends.into_par_iter().map(|end| {
        let judgement = judge(energy, &end.refined);
        (end, judgement)
    });
    judged.collect()
}

/// Why the end of a chain is not kept; `None` if it is.
pub(super) fn objection(
    served: Option<Served<'_>>,
    end: &Synthesized,
    judgement: &Judgement,
    settings: &PopulationSettings,
) -> Option<String> {
    if !settings.keep.keeps(judgement) {
        let reason = judgement.strict_objection();
        return Some(reason.unwrap_or("fails the published filter").to_owned());
    }
    // Such ends of descents that found nothing are kept by no filter but "all".
    if judgement.joint_excess > LIMIT_TOLERANCE_RAD {
        return Some("has joints farther beyond their limits than files of grasps hold".to_owned());
    }
    served?.objection(&end.refined.pose)
}

/// What came of each wish, by what is held against the end of each chain.
pub(super) fn outcomes(wishes: &Wishes<'_>, objections: &[Option<String>]) -> Vec<WishOutcome> {
    let of_wish = |place: usize| {
        let own =
            || (objections.iter().enumerate()).filter(move |(n, _)| n % wishes.len() == place);
        let refused = tally(own().filter_map(|(_, objection)| objection.as_deref()));
        let served = wishes.of_chain(place as u64)?;
        Some(WishOutcome {
            wish: served.asked().name(),
            chains: own().count(),
            found: own().filter(|(_, objection)| objection.is_none()).count(),
            refused,
        })
    };
    (0..wishes.len()).filter_map(of_wish).collect()
}

/// Runs a chain from a given grasp, if there is one, for a wish, if there is one.
pub(super) fn one_chain(
    energy: &GraspEnergy,
    of_chain: &SynthesisSettings,
    [seed, chain]: [u64; 2],
    given: Option<Given<'_>>,
    wish: Option<&dyn Wish>,
) -> Synthesized {
    let descent = QuenchSettings::default();
    match (given, wish) {
        (given, Some(wish)) => {
            let (task, given) = ([seed, chain], given.as_ref());
            synthesize_towards(energy, of_chain, &descent, task, given, wish)
        }
        (Some(given), None) => synthesize_from(energy, of_chain, &descent, seed, chain, &given),
        (None, None) => synthesize(energy, of_chain, &descent, seed, chain),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::Grasp;

    /// Writing refuses joints that are far beyond their limits, so that no end with such joints is kept.
    #[test]
    fn no_filter_keeps_joints_that_no_file_holds() {
        let settings = PopulationSettings {
            keep: Keep::All,
            ..PopulationSettings::default()
        };
        let origin = Origin::named("human", "ball").unwrap();
        let energy = origin.energy(&settings).unwrap();
        let objection_to = |excess: f64| {
            let mut x = energy.hand().rest_coordinates();
            let last = x.len() - 1;
            x[last] = energy.hand().joints.last().unwrap().limits[1] + excess;
            let refined = Grasp::best(&energy, x);
            let judgement = judge(&energy, &refined);
            let end = Synthesized {
                chain: 0,
                raw: refined.clone(),
                refined,
                energy: 0.0,
                steps: 1,
                evaluations: 1,
            };
            objection(None, &end, &judgement, &settings)
        };
        assert_eq!(objection_to(0.9), None);
        assert!(objection_to(1.1).is_some());
    }
}
