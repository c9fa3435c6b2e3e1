//! Report of a landscape of grasps: the tables, the manifest and the summary.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use petgraph::graph::NodeIndex;
use rayon::prelude::*;

use super::build::{GraspLandscape, Growth};
use super::connected::ConnectedPair;
use super::drawing::{Titles, Views, not_drawn};
use super::error::StudyError;
use super::family_names::{FamilyName, family_names};
use super::level::{FamilyLevel, letting_go};
use super::tables::{Input, Mapped, upper_bounds};
use super::uncertainty::{self, GRASPS, Uncertainty};
use super::ways::Way;
use super::{json, median, spell, tally};
use crate::grasp::GraspEnergy;
use crate::printable::{counted, printable};
use crate::store::{AtomicFolder, Counts, GraspRow, LandscapeFiles, Manifest, Population, Source};
use crate::topography::exchange::Database;
use crate::topography::{Evidence, LEAST_MEMBERS, Merge, MinimumId};

/// Step of the finite differences of the curvatures, relative to the longest step of a saddle search.
const CURVATURE_STEP: f64 = 1e-4;

/// Writes the last files of a landscape folder.
pub(super) fn conclude(
    files: LandscapeFiles,
    summary: &str,
    folder: &AtomicFolder,
) -> Result<WrittenLandscape, StudyError> {
    // The manifest lists the checksums of all tables, so it comes last.
    files.write(folder)?;
    let text = printable(summary, &['\n', '\t']).into_owned();
    folder.write("summary.md", text.as_bytes())?;
    Ok(WrittenLandscape {
        files,
        text,
        ..WrittenLandscape::default()
    })
}

/// A landscape whose files are written, and what it is about, for a reader.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WrittenLandscape {
    /// Its tables and manifest.
    pub files: LandscapeFiles,
    /// The text of `summary.md`, without control characters.
    pub text: String,
    /// The answer in one sentence; empty for surfaces.
    pub headline: String,
    /// What a reader must know of a map of grasps, each without capital and full stop.
    pub notes: Vec<String>,
}

/// A number of minima as people count grasps.
fn different(minima: usize) -> String {
    match minima {
        1 => "1 different one".to_owned(),
        count => format!("{count} different ones"),
    }
}

/// A mapped population and its report.
#[derive(Debug)]
pub struct GraspReport<'a> {
    /// The landscape.
    pub found: &'a GraspLandscape,
    /// The energy that was mapped.
    pub energy: &'a GraspEnergy,
    /// The grasps it was made from.
    pub population: &'a Population<'a>,
    /// The file of the grasps.
    pub source: Source,
    /// The command line that repeats the mapping.
    pub command: String,
    /// Warnings about the grasps.
    pub warnings: Vec<String>,
}

/// How the minima of a map were joined, in words.
pub(super) const fn method(is_sequential: bool) -> &'static str {
    if is_sequential {
        "sequential ADELM"
    } else {
        "relaxed connections"
    }
}

impl GraspReport<'_> {
    fn mapped(&self) -> Mapped<'_> {
        Mapped {
            landscape: &self.found.landscape,
            energy: self.energy,
            inputs: self
                .population
                .grasps
                .iter()
                .map(|grasp| input(grasp))
                .collect(),
            ways: (self.found.landscape.connections.par_iter())
                .map(|connection| Way::of(self.energy, &connection.path))
                .collect(),
        }
    }

    fn titles(&self) -> Titles {
        Titles::of_grasps(
            self.population.grasps.len(),
            [&self.population.hand.name, &self.population.object.name],
            self.found.settings.seed,
        )
    }

    /// Writes the tables, pictures, texts and summary of `landscape build` into `folder`.
    ///
    /// # Errors
    /// If the folder cannot be written, or a number is not finite.
    pub fn write(&self, folder: &AtomicFolder) -> Result<WrittenLandscape, StudyError> {
        let (mapped, titles) = (self.mapped(), self.titles());
        let merges = mapped.landscape.merges();
        let uncertainty = Uncertainty::of(mapped.landscape, GRASPS);
        let names = family_names(&mapped, self.energy);
        let files = self.files(&mapped, &merges, &uncertainty, &names);
        let difference = CURVATURE_STEP * self.found.settings.path.max_step;
        let database = Database::from_landscape(self.energy, mapped.landscape, difference);
        let spelled = names.iter().map(|family| family.name.clone()).collect();
        mapped.draw(&titles, Views::default(), &database, spelled, folder)?;
        uncertainty.unseen.draw(&titles.title, folder)?;
        let mut inputs = vec![self.source.clone()];
        inputs.extend(self.found.growth.iter().map(|growth| growth.onto.clone()));
        let grasps = self.population.to_file(&self.command, inputs);
        LandscapeFiles::write_grasps(&grasps, folder)?;
        let text = self.summary(&mapped, &merges, &uncertainty, (&files, &names));
        let mut headline = self.headline(files.minima.len(), &uncertainty);
        if let Some(connected) = self.connected() {
            let _ = write!(headline, " {}.", connected.spell(told_height));
        }
        // Those of the grasps are known before they are mapped.
        let warnings = files.manifest.warnings.iter().skip(self.warnings.len());
        let notes = warnings.map(|note| printable(note, &[]).into_owned());
        Ok(WrittenLandscape {
            headline: printable(&headline, &[]).into_owned(),
            notes: notes.collect(),
            ..conclude(files, &text, folder)?
        })
    }

    fn connected(&self) -> Option<&ConnectedPair> {
        self.found.growth.as_ref()?.connected.as_ref()
    }

    /// How many different grasps and families there are, and how many further grasps would be of one of these.
    fn headline(&self, minima: usize, uncertainty: &Uncertainty) -> String {
        let families = self.found.landscape.families.members.len();
        let further = match uncertainty.unseen.coverage() {
            Some(share) => format!("{share} further grasps would be of a known family"),
            None => {
                format!(
                    "to estimate how many families are missing, {LEAST_MEMBERS} grasps are needed"
                )
            }
        };
        format!(
            "{} of the {} hand on {} are {} in {}; {further}.",
            counted(self.population.grasps.len(), "grasp"),
            self.population.hand.name,
            self.population.object.name,
            different(minima),
            counted(families, "family")
        )
    }

    fn files(
        &self,
        mapped: &Mapped<'_>,
        merges: &[Merge],
        uncertainty: &Uncertainty,
        names: &[FamilyName],
    ) -> LandscapeFiles {
        let found = self.found;
        let mut findings = mapped.findings(merges, uncertainty);
        let mut tell = |name: &str, value| findings.insert(name.to_owned(), value);
        tell("family_names", json(names));
        tell("method", method(found.arrivals.is_some()).into());
        if let Some(arrivals) = &found.arrivals {
            tell("arrivals", json(arrivals));
        }
        tell("chosen", found.choice.spell().into());
        if let Some(growth) = &found.growth {
            tell("growth", json(growth));
        }
        if let Some(tuning) = &found.choice.tuning {
            tell("tuning", json(tuning));
        }
        mapped.files(Manifest {
            command: self.command.clone(),
            seed: found.settings.seed,
            source: self.source.clone(),
            onto: found.growth.as_ref().map(|growth| growth.onto.clone()),
            hand: Some(self.population.hand.clone()),
            object: Some(self.population.object.clone()),
            scale: self.population.scale,
            energy: json(self.energy.settings()),
            settings: json(&found.settings),
            terms: self.energy.term_names(),
            letting_go: letting_go(self.energy.settings()),
            counts: Counts {
                grasps: self.population.grasps.len() as u64,
                evaluations: found.evaluations as u64,
                ..Counts::default()
            },
            findings,
            warnings: self.warnings(merges),
            ..Manifest::default()
        })
    }

    fn warnings(&self, merges: &[Merge]) -> Vec<String> {
        let found = self.found;
        let mut warnings = self.warnings.clone();
        let rejected = found.landscape.rejected.len();
        if rejected > 0 {
            warnings.push(format!(
                "{} left out: the descents that led there ended on a slope",
                if rejected == 1 {
                    "1 minimum is".to_owned()
                } else {
                    format!("{rejected} minima are")
                }
            ));
        }
        let unrelaxed = merges
            .iter()
            .filter(|merge| merge.evidence > Evidence::Path)
            .count();
        if unrelaxed > 0 {
            warnings.push(format!(
            "only an upper bound is known for {unrelaxed} of {} (evidence `chain`): drawn dashed, listed in summary.md",
            counted(merges.len(), "merge")
        ));
        }
        warnings
    }

    fn summary(
        &self,
        mapped: &Mapped<'_>,
        merges: &[Merge],
        uncertainty: &Uncertainty,
        (files, names): (&LandscapeFiles, &[FamilyName]),
    ) -> String {
        let manifest = &files.manifest;
        let mut lines = self.overview(files, merges, uncertainty);
        let notes = manifest.warnings.iter().cloned();
        let notes = notes.chain(not_drawn(files.minima.len()));
        lines.extend(notes.map(|note| format!("Note: {note}.\n")));
        lines.extend(largest_families(mapped, names));
        lines.extend(upper_bounds(merges));
        lines.push(format!(
            "\nMade by `{}`, landscape {}.\n",
            manifest.command, manifest.program_version
        ));
        lines.join("\n")
    }

    fn overview(
        &self,
        files: &LandscapeFiles,
        merges: &[Merge],
        uncertainty: &Uncertainty,
    ) -> Vec<String> {
        let found = self.found;
        let counts = &files.manifest.counts;
        let chain = &found.settings.chain;
        let mut lines = vec![
            format!(
                "# {} of the {} hand on {}\n",
                counted(self.population.grasps.len(), "grasp"),
                self.population.hand.name,
                self.population.object.name
            ),
            format!("{}\n", self.headline(files.minima.len(), uncertainty)),
            format!(
                "- **different grasps** are the minima of the energy ({}), and **families** are sets of them ({}): {}",
                files.minima.len(),
                found.landscape.families.members.len(),
                self.rule_of_families()
            ),
            format!(
                "- attraction–diffusion chains: temperature T = {:.4}, pull F = {:.0}/m, F/T = α = {:.0}/m; {}",
                chain.temperature,
                chain.force,
                chain.alpha(),
                found.choice.spell()
            ),
            format!(
                "- {} of minima connected; {}",
                counted(files.edges.len(), "pair"),
                match counts.components {
                    0 | 1 => "paths join all minima".to_owned(),
                    parts => format!("the minima fall into {parts} parts that no path joins"),
                }
            ),
        ];
        lines.extend(evidence(files, merges));
        lines.extend(ways(files, merges));
        lines.extend(uncertainty::lines(uncertainty));
        lines.extend(found.growth.as_ref().map(|growth| self.grown(growth)));
        lines.extend(
            self.connected()
                .map(|pair| format!("- {}", pair.spell(told_height))),
        );
        lines.push(format!("- {} energy evaluations\n", counts.evaluations));
        lines
    }

    /// To which landscape how much was added.
    fn grown(&self, growth: &Growth) -> String {
        let added = self.population.grasps.len() - growth.grasps;
        let minima = self.found.landscape.network.node_count();
        format!(
            "- grown from {} ({} in {}): {} added, {} now; this took {} of the energy evaluations",
            growth.onto.name,
            counted(growth.grasps, "grasp"),
            counted(growth.minima, "minimum"),
            counted(added, "grasp"),
            counted(minima, "minimum"),
            growth.evaluations
        )
    }

    /// How the families were made.
    fn rule_of_families(&self) -> String {
        let found = self.found;
        let barrier = found.landscape.families.barrier;
        if found.arrivals.is_some() {
            return format!(
                "assigned one by one, in the order of the grasps, by sequential ADELM; greatest relative raw barrier {barrier:.3}"
            );
        }
        let families = &found.settings.families;
        let usual = FamilyLevel::default_of(self.energy.settings());
        let why = match families.barrier {
            Some(given) => match usual {
                Some(level) if level.barrier.to_bits() == given.to_bits() => {
                    "what it costs to put one resting phalanx on the object"
                }
                _ => "as given with --family-barrier",
            },
            None => "chosen",
        };
        format!(
            "minima joined by relaxed connections with relative barrier up to {barrier:.3} ({why})"
        )
    }
}

/// What the evidence of a merge proves.
const VERIFIED: &str = ". Each is the lowest pass found; a `saddle` is verified to be a pass, but a lower one may exist";

/// On what connections and merges rest.
fn evidence(files: &LandscapeFiles, merges: &[Merge]) -> Vec<String> {
    let connections = files.edges.iter().map(|edge| edge.evidence.as_str());
    let terms = merges.iter().filter_map(|merge| merge.term.as_deref());
    let mut lines = vec![
        format!("- evidence of connections: {}", spell(&tally(connections))),
        format!(
            "- evidence of merges: {}",
            spell(&tally(merges.iter().map(|merge| merge.evidence.name())))
        ) + VERIFIED,
        format!(
            "- what dominates the tops of merges: {}",
            spell(&tally(terms))
        ),
    ];
    if let Some(depth) = median(merges.iter().map(|merge| merge.depth).collect()) {
        lines.push(format!("- median merge depth: {depth:.3}"));
    }
    lines
}

/// What the connections that make merges are; nothing if the energy does not tell.
fn ways(files: &LandscapeFiles, merges: &[Merge]) -> Option<String> {
    let of: BTreeMap<_, _> = (files.edges.iter())
        .filter_map(|edge| Some(((edge.a, edge.b), edge.way.as_deref()?)))
        .collect();
    let ends = merges
        .iter()
        .map(|merge| merge.ends.map(|end| end.0 as u64));
    let told: Vec<&str> = ends
        .filter_map(|[a, b]| of.get(&(a.min(b), a.max(b))).copied())
        .collect();
    let cost = files.manifest.letting_go?;
    let released = merges.iter().filter(|merge| merge.height >= cost).count();
    let rule = if released > 0 {
        format!("; {released} have the height {cost:.3}, the cost of letting go, by definition")
    } else {
        String::new()
    };
    (!told.is_empty()).then(|| {
        format!(
            "- ways over merges: {}{rule}",
            spell(&tally(told.into_iter()))
        )
    })
}

/// A height as reports on grasps tell it.
fn told_height(height: f64) -> String {
    format!("{height:.3}")
}

/// A row and its label: the human label, or else the automatic one.
fn input(grasp: &GraspRow) -> Input {
    Input {
        id: grasp.id,
        label: grasp.label.clone().or_else(|| grasp.label_auto.clone()),
    }
}

fn largest_families(mapped: &Mapped<'_>, names: &[FamilyName]) -> Vec<String> {
    let lowest = |members: &[MinimumId]| {
        let energies = members
            .iter()
            .map(|id| mapped.landscape.network[NodeIndex::new(id.0)].energy);
        energies.fold(f64::INFINITY, f64::min)
    };
    let mut families: Vec<(&FamilyName, f64)> =
        (names.iter().zip(&mapped.landscape.families.members))
            .map(|(name, members)| (name, lowest(members)))
            .collect();
    families.sort_by_key(|(name, _)| (std::cmp::Reverse(name.grasps), name.family));
    let mut lines = vec![
        "## Largest families\n".to_owned(),
        "A name gives the most frequent type and its share, what touches the object in most grasps, and, where two thirds \
         agree, the side of the thumb and the place on the object.\n"
            .to_owned(),
        "| family | name | different grasps | grasps | lowest energy |\n|---|---|---|---|---|".to_owned(),
    ];
    lines.extend(families.into_iter().take(12).map(|(name, energy)| {
        let share = match &name.label {
            Some(_) => format!(" ({:.0} %)", 100.0 * name.label_share),
            None => String::new(),
        };
        let told = match name.name.split_once(", ") {
            Some((first, rest)) => format!("{first}{share}, {rest}"),
            None => format!("{}{share}", name.name),
        };
        format!(
            "| g{} | {told} | {} | {} | {energy:.3} |",
            name.family, name.minima, name.grasps
        )
    }));
    lines
}
