//! `landscape build --diagram`: temperature and force from a magnetisation diagram.

use super::run::{DiskJournal, Watch};
use crate::figure::diagram_chart;
use crate::grasp::{GraspEnergy, GraspKernel};
use crate::store::AtomicFolder;
use crate::topography::{Diagram, DiagramSettings, MapSettings, Minimum, diagram, log_grid};

/// The diagram of a hand: temperatures and forces about those that suit it, forces in units of the slope of one contact.
pub(super) fn measure(
    (energy, kernel): (&GraspEnergy, &GraspKernel<'_>),
    minima: &[Minimum],
    settings: &MapSettings,
    journal: &DiskJournal<'_>,
    watch: &Watch,
) -> Diagram {
    let contact_slope = energy.settings().distance_weight / energy.unit_m();
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
    diagram(energy, kernel, minima, &settings, journal, &|p| {
        watch.see(p);
    })
}

/// `diagram.json` and the picture.
pub(super) fn write(found: &Diagram, title: &str, folder: &AtomicFolder) -> anyhow::Result<()> {
    let text = format!("{:#}\n", serde_json::to_value(found)?);
    folder.write("diagram.json", text.as_bytes())?;
    let canvas = diagram_chart(title, "1/m", found).draw()?;
    for ending in ["svg", "png"] {
        canvas.save(&folder.path().join(format!("diagram.{ending}")))?;
    }
    Ok(())
}

/// How T and F were chosen, for the summary.
pub(super) fn choice(found: Option<&Diagram>, given: bool) -> String {
    let measured = found.and_then(|found| found.recommended.as_ref());
    match (measured, given) {
        (_, true) => "as asked for".to_owned(),
        (Some(best), false) => format!("by its magnetisation diagram: {}", best.reason),
        (None, false) if found.is_some() => {
            "the usual values: in the diagram no force joined most pairs".to_owned()
        }
        (None, false) => "the usual values for a hand; --diagram measures them".to_owned(),
    }
}
