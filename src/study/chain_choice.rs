//! Chooses temperature and force of the chains of a grasp map from a few chains.

use super::settings::{GraspMapSettings, StudyRun, contact_slope};
use crate::grasp::{GraspEnergy, GraspKernel};
use crate::topography::{
    ChainSettings, JournalError, MapSettings, Minimum, Run, Tuning, TuningSettings, log_grid, tune,
};

/// How temperature and force of the chains were chosen.
#[derive(Debug, Default)]
pub struct ChainChoice {
    /// The few chains, unless both values were given.
    pub tuning: Option<Tuning>,
    /// Who gave both values, if they were given.
    given: Option<String>,
}

impl ChainChoice {
    /// Chooses the values that are not given and sets them in `map`.
    pub(super) fn make(
        settings: &GraspMapSettings,
        surface: (&GraspEnergy, &GraspKernel<'_>),
        minima: &[Minimum],
        map: &mut MapSettings,
        run: &StudyRun<'_>,
    ) -> Result<Self, JournalError> {
        let given = settings.temperature.is_some() && settings.force.is_some();
        let mut choice = Self {
            given: given.then(|| "as asked for".to_owned()),
            ..Self::default()
        };
        if choice.given.is_none() {
            let found = try_few(settings, surface, minima, map, &run.run)?;
            (run.stage_ended)("choose", found.evaluations);
            if let Some(best) = found.recommended() {
                map.chain = ChainSettings {
                    temperature: settings.temperature.unwrap_or(best.temperature),
                    force: settings.force.unwrap_or(best.force),
                    ..map.chain.clone()
                };
            }
            choice.tuning = Some(found);
        }
        Ok(choice)
    }

    /// The values of the landscape of this name.
    pub(super) fn of_earlier(name: &str) -> Self {
        Self {
            given: Some(format!("as in {name}")),
            ..Self::default()
        }
    }

    /// Evaluations spent on the choice.
    pub fn evaluations(&self) -> usize {
        self.tuning.as_ref().map_or(0, |found| found.evaluations)
    }

    /// Describes how temperature and force were chosen.
    pub fn spell(&self) -> String {
        let tried = || self.tuning.as_ref()?.reason();
        self.given.clone().or_else(tried).unwrap_or_else(|| {
            "the usual values: none of those tried joined half of the pairs".to_owned()
        })
    }
}

/// Pairs between which the few chains run. The choice must cost little beside the map.
const PAIRS: usize = 6;

/// Tries a few chains at the temperature and the forces typical of hands, or at the given ones.
fn try_few(
    settings: &GraspMapSettings,
    (energy, kernel): (&GraspEnergy, &GraspKernel<'_>),
    minima: &[Minimum],
    map: &MapSettings,
    run: &Run<'_>,
) -> Result<Tuning, JournalError> {
    let slope = contact_slope(energy.settings());
    let one = |given: f64| vec![given];
    let settings = TuningSettings {
        temperatures: one(settings.temperature.unwrap_or(map.chain.temperature)),
        forces: settings
            .force
            .map_or_else(|| log_grid(slope, 32.0 * slope, 6), one),
        pairs: PAIRS,
        neighbours: map.neighbours,
        chain: map.chain.clone(),
        quench: map.quench.clone(),
        sameness: map.sameness,
        seed: map.seed,
    };
    tune(energy, kernel, minima, &settings, run)
}
