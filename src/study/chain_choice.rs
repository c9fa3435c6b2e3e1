//! Chooses temperature and force of the chains of a grasp map, from a few chains or from a magnetisation diagram.

use super::error::StudyError;
use super::level::letting_go;
use super::settings::{GraspMapSettings, StudyRun, contact_slope};
use crate::figure::diagram_chart;
use crate::grasp::{GraspEnergy, GraspKernel};
use crate::store::AtomicFolder;
use crate::topography::{
    ChainSettings, Diagram, DiagramSettings, JournalError, MapSettings, Minimum, Run, Tuning,
    TuningSettings, diagram, log_grid, tune,
};

/// How temperature and force of the chains were chosen.
#[derive(Debug, Default)]
pub struct ChainChoice {
    /// The magnetisation diagram, if requested.
    pub diagram: Option<Diagram>,
    /// The few chains used otherwise, unless both values were given.
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
        let mut best = None;
        if settings.diagram {
            let found = measure(surface, minima, map, &run.run)?;
            (run.stage_ended)("diagram", found.evaluations);
            let recommended = found.recommended.as_ref();
            best = recommended.map(|best| (best.temperature, best.force));
            choice.diagram = Some(found);
        } else if choice.given.is_none() {
            let found = try_few(settings, surface, minima, map, &run.run)?;
            (run.stage_ended)("choose", found.evaluations);
            let recommended = found.recommended();
            best = recommended.map(|best| (best.temperature, best.force));
            choice.tuning = Some(found);
        }
        if let Some((temperature, force)) = best {
            map.chain = ChainSettings {
                temperature: settings.temperature.unwrap_or(temperature),
                force: settings.force.unwrap_or(force),
                ..map.chain.clone()
            };
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
        let diagram = self.diagram.as_ref().map_or(0, |found| found.evaluations);
        diagram + self.tuning.as_ref().map_or(0, |found| found.evaluations)
    }

    /// Describes how temperature and force were chosen.
    pub fn spell(&self) -> String {
        let measured = self.diagram.as_ref().map(|found| {
            let best = found.recommended.as_ref();
            best.map(|best| format!("by its magnetisation diagram: {}", best.reason))
        });
        let tried = || self.tuning.as_ref()?.reason();
        match (measured, &self.given) {
            (_, Some(given)) => given.clone(),
            (Some(Some(reason)), None) => reason,
            (Some(None), None) => {
                "the usual values: in the diagram no force joined most pairs".to_owned()
            }
            (None, None) => tried().unwrap_or_else(|| {
                "the usual values: none of those tried joined half of the pairs".to_owned()
            }),
        }
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
    let slope = contact_slope(energy);
    let tried = |given: Option<f64>, [low, high]: [f64; 2], count| {
        given.map_or_else(|| log_grid(low, high, count), |given| vec![given])
    };
    // Over an elastic layer few chains run, and their temperature is known.
    let layered = letting_go(energy.settings()).is_some();
    let temperature = settings.temperature;
    let temperature = temperature.or(layered.then_some(map.chain.temperature));
    let settings = TuningSettings {
        temperatures: tried(temperature, [0.0025, 0.04], 3),
        forces: tried(
            settings.force,
            [slope, 32.0 * slope],
            if layered { 6 } else { 11 },
        ),
        pairs: if layered { 6 } else { 12 },
        neighbours: map.neighbours,
        chain: map.chain.clone(),
        quench: map.quench.clone(),
        sameness: map.sameness,
        seed: map.seed,
    };
    tune(energy, kernel, minima, &settings, run)
}

/// Measures the diagram at temperatures and forces typical of hands, with forces in units of the slope of one contact.
fn measure(
    (energy, kernel): (&GraspEnergy, &GraspKernel<'_>),
    minima: &[Minimum],
    settings: &MapSettings,
    run: &Run<'_>,
) -> Result<Diagram, JournalError> {
    let contact_slope = contact_slope(energy);
    let settings = DiagramSettings {
        temperatures: log_grid(0.0025, 0.04, 5),
        forces: log_grid(0.25 * contact_slope, 32.0 * contact_slope, 15),
        replicas: 3,
        minima: 16,
        neighbours: 2,
        chain: settings.chain.clone(),
        quench: settings.quench.clone(),
        sameness: settings.sameness,
        seed: settings.seed,
    };
    diagram(energy, kernel, minima, &settings, run)
}

/// Writes `diagram.json` and the picture.
pub(super) fn write(found: &Diagram, title: &str, folder: &AtomicFolder) -> Result<(), StudyError> {
    let text = format!("{:#}\n", super::json(found));
    folder.write("diagram.json", text.as_bytes())?;
    let canvas = diagram_chart(title, "1/m", found).draw()?;
    for name in ["diagram.svg", "diagram.png"] {
        folder.write(name, &canvas.encode(name.as_ref())?)?;
    }
    Ok(())
}
