//! From a hand and an object to a population of grasps.

use rayon::prelude::*;

use super::{Experiment, JournalError, Run};
use crate::grasp::spread::spread;
use crate::grasp::synthesis::{Given, Synthesized, synthesize, synthesize_from};
use crate::grasp::{GraspEnergy, Judgement, judge};
use crate::hand::HandFiles;
use crate::object::{Object, ObjectParts};
use crate::optimize::QuenchSettings;
use crate::store::{
    GraspRow, HandMetadata, Metadata, ObjectMetadata, Population, RebuildError, SCHEMA_VERSION,
    content_hash,
};
use crate::topography::Phase;

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
        }
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
        Ok(Metadata {
            schema_version: SCHEMA_VERSION,
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            seed: settings.seed,
            hands: vec![self.hand.clone()],
            objects: vec![self.object.clone()],
            energy: serde_json::to_value(settings.experiment.energy)?,
            settings: serde_json::to_value(settings.experiment.synthesis)?,
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
    fn given(&self, chain: u64) -> Option<&GraspRow> {
        let count = self.given.len() as u64;
        let place = chain.checked_rem(count)?;
        self.given.get(usize::try_from(place).ok()?)
    }

    fn row(
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
/// If the settings ask for no attempt, or a given grasp is one of another hand.
pub fn synthesize_population(
    energy: &GraspEnergy,
    origin: &Origin,
    settings: &PopulationSettings,
    run: &Run<'_>,
) -> Result<Synthesis, JournalError> {
    let ends = synthesize_chains(energy, origin, settings, run)?;
    let judged = ends.into_par_iter().map(|end| {
        let judgement = judge(energy, &end.refined);
        (end, judgement)
    });
    let chains: Vec<(Synthesized, Judgement)> = judged.collect();
    let mut kept: Vec<&(Synthesized, Judgement)> = chains
        .iter()
        .filter(|(_, judgement)| settings.keep.keeps(judgement))
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
    Ok(Synthesis { chains, grasps })
}

fn synthesize_chains(
    energy: &GraspEnergy,
    origin: &Origin,
    settings: &PopulationSettings,
    run: &Run<'_>,
) -> Result<Vec<Synthesized>, JournalError> {
    let chains: Vec<u64> = (0..settings.chains).collect();
    run.each(
        &run.tally(Phase::Synthesize, chains.len()),
        &chains,
        |chain| format!("chain {chain}"),
        |chain| one_chain(energy, origin, settings, *chain),
    )
}

fn one_chain(
    energy: &GraspEnergy,
    origin: &Origin,
    settings: &PopulationSettings,
    chain: u64,
) -> Synthesized {
    let (of_chain, seed) = (&settings.experiment.synthesis, settings.seed);
    let descent = QuenchSettings::default();
    let Some(given) = origin.given(chain) else {
        return synthesize(energy, of_chain, &descent, seed, chain);
    };
    let given = Given {
        x: &given.grasp.pose,
        displacement_m: settings.displacement_m,
    };
    synthesize_from(energy, of_chain, &descent, seed, chain, &given)
}
