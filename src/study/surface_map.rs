//! The landscape between the minima below points of a surface, and its report.

use std::fmt::Write;

use super::build::joined;
use super::drawing::{Titles, Views, not_drawn};
use super::error::StudyError;
use super::report::{WrittenLandscape, conclude, method};
use super::settings::{MapSearch, StudyRun};
use super::surface::Subject;
use super::tables::{Input, Mapped, upper_bounds};
use super::uncertainty::Uncertainty;
use super::{Digits, json as value};
use crate::energy::Energy;
use crate::printable::counted;
use crate::sample::Mala;
use crate::store::{AtomicFolder, Counts, LandscapeFiles, Manifest};
use crate::topography::exchange::Database;
use crate::topography::{
    ChainSettings, Landscape, MapSettings, Merge, MinimumId, Scales, Tuning, TuningSettings,
    distinct, log_grid, quench_all, tune,
};

/// Step of the finite differences of the curvatures, relative to the longest step of a path.
const CURVATURE_STEP: f64 = 1e-4;

/// The landscape between given points, and how it was made.
#[derive(Debug)]
pub struct SurfaceMap {
    /// Minima, connections, tree and families.
    pub landscape: Landscape,
    /// The settings, measured on the minima.
    pub settings: MapSettings,
    /// Minima in order of arrival, if they were mapped by attraction–diffusion alone.
    pub arrivals: Option<Vec<MinimumId>>,
    /// The chains that chose temperature and force of such a map.
    pub tuning: Option<Tuning>,
    /// Number of points given.
    pub starts: usize,
    /// Number of points whose descents did not end at a minimum.
    pub lost: usize,
    /// Energy evaluations of all stages.
    pub evaluations: usize,
}

/// Descends from `starts` on any surface, merges equal minima, and joins them as `search` says: by relaxed paths and
/// attraction–diffusion searches across every merge, or by attraction–diffusion alone, whose temperature and force a few
/// chains choose ([`tune`]). `adjust` may change the settings that were measured on the minima.
///
/// # Errors
/// [`StudyError::NoMinimum`] if no descent ends at a minimum, [`StudyError::OneMinimum`] if all end at the same one,
/// [`StudyError::Journal`] if a finished task cannot be stored.
///
/// # Panics
/// If a point has the wrong length.
///
/// # Examples
/// Two wells of the Müller–Brown surface and the pass between them.
///
/// ```
/// use landscape::energy::model::MullerBrown;
/// use landscape::study::{MapSearch, StudyRun, map_surface};
///
/// let starts = [vec![-0.7, 1.2], vec![0.5, 0.1]];
/// let (energy, run) = (MullerBrown::new(), StudyRun::default());
/// let found = map_surface("muller-brown", &energy, &starts, MapSearch::Passes, |_| (), &run)?;
/// let height = found.landscape.tree.nodes.last().unwrap().energy;
/// assert!(height > -80.0 && height < -40.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn map_surface(
    name: &str,
    energy: &dyn Energy,
    starts: &[Vec<f64>],
    search: MapSearch,
    adjust: impl FnOnce(&mut MapSettings),
    run: &StudyRun<'_>,
) -> Result<SurfaceMap, StudyError> {
    let scales = Scales::measured(energy, starts);
    let quenches = quench_all(energy, starts, &scales.quench(), &run.run)?;
    let spent: usize = quenches.iter().map(|quench| quench.evaluations).sum();
    let (minima, rejected) = distinct(
        energy,
        &quenches,
        &scales.sameness(),
        scales.gradient_tolerance(),
    );
    (run.stage_ended)("quench", spent);
    match minima.len() {
        0 => {
            return Err(StudyError::NoMinimum {
                surface: name.to_owned(),
                searches: starts.len(),
                ends: "(no descent from a given point converged)".to_owned(),
            });
        }
        1 => return Err(StudyError::OneMinimumOfSurface(starts.len())),
        _ => {}
    }
    let mut settings = MapSettings::for_minima(energy, &minima);
    adjust(&mut settings);
    let kernel = Mala::new(energy);
    let mut tuning = None;
    if search == MapSearch::Adelm {
        let found = tune(energy, &kernel, &minima, &few_chains(&settings), &run.run)?;
        (run.stage_ended)("choose", found.evaluations);
        if let Some(best) = found.recommended() {
            (settings.chain.temperature, settings.chain.force) = (best.temperature, best.force);
        }
        tuning = Some(found);
    }
    let (landscape, arrivals) = joined(search, (energy, &kernel), minima, &settings, run)?;
    let tuned = tuning.as_ref().map_or(0, |found| found.evaluations);
    Ok(SurfaceMap {
        evaluations: spent + tuned + landscape.evaluations,
        arrivals,
        tuning,
        landscape,
        settings,
        starts: starts.len(),
        lost: rejected.len(),
    })
}

/// A few chains at temperatures and forces around those of the scales.
fn few_chains(settings: &MapSettings) -> TuningSettings {
    let ChainSettings {
        temperature, force, ..
    } = settings.chain;
    TuningSettings {
        temperatures: log_grid(temperature / 4.0, 4.0 * temperature, 3),
        forces: log_grid(force / 8.0, 8.0 * force, 7),
        pairs: 6,
        neighbours: settings.neighbours,
        chain: settings.chain.clone(),
        quench: settings.quench.clone(),
        sameness: settings.sameness,
        seed: settings.seed,
    }
}

/// A map of a surface and its report.
#[derive(Debug)]
pub struct SurfaceMapReport<'a> {
    /// The surface.
    pub subject: &'a Subject<'a>,
    /// Its map.
    pub found: &'a SurfaceMap,
    /// The call that repeats the map.
    pub command: String,
}

impl SurfaceMapReport<'_> {
    fn mapped(&self) -> Mapped<'_> {
        Mapped {
            landscape: &self.found.landscape,
            energy: self.subject.energy,
            inputs: (0..self.found.starts as u64)
                .map(|id| Input { id, label: None })
                .collect(),
            ways: Vec::new(),
        }
    }

    /// Writes tables, pictures, texts and summary into `folder`.
    ///
    /// # Errors
    /// If the folder cannot be written, or a number is not finite.
    pub fn write(&self, folder: &AtomicFolder) -> Result<WrittenLandscape, StudyError> {
        let mapped = self.mapped();
        let merges = mapped.landscape.merges();
        let uncertainty = Uncertainty::of(mapped.landscape, "starting points");
        let files = self.files(&mapped, &merges, &uncertainty);
        let minima = self.found.landscape.network.node_count();
        let title = format!(
            "{}: {} from {}",
            self.subject.name,
            counted(minima, "minimum"),
            counted(self.found.starts, "point")
        );
        let titles = Titles::of_surface(title, "starting points", self.found.settings.seed);
        let difference = CURVATURE_STEP * self.found.settings.path.max_step;
        let database = Database::from_landscape(self.subject.energy, mapped.landscape, difference);
        mapped.draw(&titles, Views::default(), &database, Vec::new(), folder)?;
        uncertainty.unseen.draw(&titles.title, folder)?;
        let text = self.summary(&merges, &files);
        conclude(files, &text, folder)
    }

    fn files(
        &self,
        mapped: &Mapped<'_>,
        merges: &[Merge],
        uncertainty: &Uncertainty,
    ) -> LandscapeFiles {
        let (subject, found) = (self.subject, self.found);
        let landscape = &found.landscape;
        let mut findings = mapped.findings(merges, uncertainty);
        findings.insert("method".to_owned(), method(found.arrivals.is_some()).into());
        if let Some(arrivals) = &found.arrivals {
            findings.insert("arrivals".to_owned(), value(arrivals));
        }
        if let Some(reason) = found.tuning.as_ref().and_then(Tuning::reason) {
            findings.insert("chosen".to_owned(), reason.into());
        }
        let first = landscape.network.node_weights().next();
        let terms = first.map_or_else(Vec::new, |minimum| {
            subject.energy.terms(&minimum.coordinates)
        });
        mapped.files(Manifest {
            command: self.command.clone(),
            seed: found.settings.seed,
            source: subject.source.clone(),
            scale: 1.0,
            energy: subject.described(),
            settings: value(&found.settings),
            terms: terms.into_iter().map(|(name, _)| name).collect(),
            counts: Counts {
                evaluations: found.evaluations as u64,
                ..Counts::default()
            },
            findings,
            warnings: self.warnings(),
            ..Manifest::default()
        })
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = vec![
            "only the minima of the given points were sought: others may lie between or below them"
                .to_owned(),
        ];
        if self.found.arrivals.is_some() {
            warnings.push(
                "every height is that of a raw chain of attraction–diffusion, an upper bound; families depend on the order of the \
                 points (without `--search adelm` passes are sought)"
                    .to_owned(),
            );
        }
        if self.found.lost > 0 {
            warnings.push(format!(
                "{} of {} descents ended at no minimum",
                self.found.lost, self.found.starts
            ));
        }
        warnings
    }

    fn summary(&self, merges: &[Merge], files: &LandscapeFiles) -> String {
        let landscape = &self.found.landscape;
        let counts = &files.manifest.counts;
        let tolerance = self.found.settings.sameness.energy;
        let digits = Digits::within(tolerance, files.minima.iter().map(|minimum| minimum.energy));
        let mut text = format!(
            "# {}\n\n- **{}** from {}, {} tried, {}\n- {} (relative barrier up to {})\n- {} evaluations of the energy\n",
            self.subject.name,
            counted(landscape.network.node_count(), "minimum"),
            counted(self.found.starts, "point"),
            counted(files.edges.len(), "pair"),
            counted(landscape.tree.roots.len(), "component"),
            counted(landscape.families.members.len(), "family"),
            digits.show(landscape.families.barrier),
            counts.evaluations,
        );
        for (evidence, count) in &files.manifest.evidence {
            let _ = writeln!(text, "- {count} connections with evidence `{evidence}`");
        }
        for warning in &files.manifest.warnings {
            let _ = writeln!(text, "- {warning}");
        }
        if let Some(sentence) = not_drawn(landscape.network.node_count()) {
            let _ = writeln!(text, "- {sentence}");
        }
        for line in upper_bounds(merges) {
            text += &line;
            text.push('\n');
        }
        text
    }
}
