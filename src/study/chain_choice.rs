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

/// Tries a few chains at temperatures and forces typical of hands, or at the given ones.
fn try_few(
    settings: &GraspMapSettings,
    (energy, kernel): (&GraspEnergy, &GraspKernel<'_>),
    minima: &[Minimum],
    map: &MapSettings,
    run: &Run<'_>,
) -> Result<Tuning, JournalError> {
    let slope = contact_slope(energy.settings());
    let one = |given: f64| vec![given];
    // Few chains run, and their temperature is known.
    let choice = &settings.choice;
    let temperatures = settings.temperature.map(one);
    let temperatures = temperatures.or_else(|| ascending(choice.temperatures.as_deref()));
    let forces = settings.force.map(one);
    let forces = forces.or_else(|| ascending(choice.forces.as_deref()));
    let settings = TuningSettings {
        temperatures: temperatures.unwrap_or_else(|| one(map.chain.temperature)),
        forces: forces.unwrap_or_else(|| log_grid(slope, 32.0 * slope, 6)),
        pairs: choice.pairs.unwrap_or(6),
        neighbours: map.neighbours,
        chain: map.chain.clone(),
        quench: map.quench.clone(),
        sameness: map.sameness,
        seed: map.seed,
    };
    tune(energy, kernel, minima, &settings, run)
}

/// The given values in ascending order, if there are any.
fn ascending(given: Option<&[f64]>) -> Option<Vec<f64>> {
    let mut values = given.filter(|values| !values.is_empty())?.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup();
    Some(values)
}
