//! Temperature and force of `landscape build`: from a few chains, or from a magnetisation diagram (`--diagram`).

use super::build::Build;
use super::grasp_map::contact_slope;
use super::run::Watch;
use crate::figure::diagram_chart;
use crate::grasp::{GraspEnergy, GraspKernel};
use crate::store::{AtomicFolder, Journal};
use crate::topography::{
    Diagram, DiagramSettings, JournalError, MapSettings, Minimum, Run, Tuning, TuningSettings,
    diagram, log_grid, tune,
};

/// How temperature and force came about.
#[derive(Debug, Default)]
pub(super) struct Choice {
    /// The magnetisation diagram, if it was asked for.
    pub(super) diagram: Option<Diagram>,
    /// The few chains that chose instead, unless both values were given.
    pub(super) tuning: Option<Tuning>,
    /// Whether both were given.
    given: bool,
}

impl Choice {
    /// Chooses what is not given, and sets it.
    pub(super) fn make(
        command: &Build,
        surface: (&GraspEnergy, &GraspKernel<'_>),
        minima: &[Minimum],
        settings: &mut MapSettings,
        (journal, watch): (&Journal, &mut Watch),
    ) -> Result<Self, JournalError> {
        let mut choice = Self {
            given: command.temperature.is_some() && command.pull.is_some(),
            ..Self::default()
        };
        let mut best = None;
        if command.diagram {
            let run = Run {
                journal,
                observer: &|news| watch.see(news),
            };
            let found = measure(surface, minima, settings, &run)?;
            watch.lap("diagram", found.evaluations);
            let recommended = found.recommended.as_ref();
            best = recommended.map(|best| (best.temperature, best.force));
            choice.diagram = Some(found);
        } else if !choice.given {
            let run = Run {
                journal,
                observer: &|news| watch.see(news),
            };
            let found = try_few(command, surface, minima, settings, &run)?;
            watch.lap("choose", found.evaluations);
            best = found
                .recommended()
                .map(|best| (best.temperature, best.force));
            choice.tuning = Some(found);
        }
        if let Some((temperature, force)) = best {
            settings.chain.temperature = command.temperature.unwrap_or(temperature);
            settings.chain.force = command.pull.unwrap_or(force);
        }
        Ok(choice)
    }

    /// Evaluations spent on it.
    pub(super) fn evaluations(&self) -> usize {
        let diagram = self.diagram.as_ref().map_or(0, |found| found.evaluations);
        diagram + self.tuning.as_ref().map_or(0, |found| found.evaluations)
    }

    /// How T and F were chosen, for the summary.
    pub(super) fn spell(&self) -> String {
        let measured = self.diagram.as_ref().map(|found| {
            let best = found.recommended.as_ref();
            best.map(|best| format!("by its magnetisation diagram: {}", best.reason))
        });
        let tried = || self.tuning.as_ref()?.reason();
        match (measured, self.given) {
            (_, true) => "as asked for".to_owned(),
            (Some(Some(reason)), false) => reason,
            (Some(None), false) => {
                "the usual values: in the diagram no force joined most pairs".to_owned()
            }
            (None, false) => tried().unwrap_or_else(|| {
                "the usual values: none of those tried joined half of the pairs".to_owned()
            }),
        }
    }
}

/// A few chains at few temperatures and forces about those that suit a hand, or at the one that is given.
fn try_few(
    command: &Build,
    (energy, kernel): (&GraspEnergy, &GraspKernel<'_>),
    minima: &[Minimum],
    settings: &MapSettings,
    run: &Run<'_>,
) -> Result<Tuning, JournalError> {
    let slope = contact_slope(energy);
    let settings = TuningSettings {
        temperatures: command
            .temperature
            .map_or_else(|| log_grid(0.0025, 0.04, 3), |given| vec![given]),
        forces: command
            .pull
            .map_or_else(|| log_grid(slope, 32.0 * slope, 11), |given| vec![given]),
        pairs: 12,
        neighbours: settings.neighbours,
        chain: settings.chain.clone(),
        quench: settings.quench.clone(),
        sameness: settings.sameness,
        seed: settings.seed,
    };
    tune(energy, kernel, minima, &settings, run)
}

/// The diagram of a hand: temperatures and forces about those that suit it, forces in units of the slope of one contact.
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

/// `diagram.json` and the picture.
pub(super) fn write(found: &Diagram, title: &str, folder: &AtomicFolder) -> anyhow::Result<()> {
    let text = format!("{:#}\n", serde_json::to_value(found)?);
    folder.write("diagram.json", text.as_bytes())?;
    let canvas = diagram_chart(title, "1/m", found).draw()?;
    for name in ["diagram.svg", "diagram.png"] {
        folder.write(name, &canvas.encode(name.as_ref())?)?;
    }
    Ok(())
}
