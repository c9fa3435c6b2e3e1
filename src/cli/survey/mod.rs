//! `landscape survey`: a data set of many objects as one job.

mod files;
mod part;

use std::path::{Path, PathBuf};

use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;

use self::files::{Plan, Task};
use self::part::Part;
use super::args::{Again, Common, FamilyBarrier, HandAndObject, WithPage};
use super::build::{Mapping, keep_stable};
use super::output::{check_folder, given_or_beside, make_folder};
use super::run::{Watch, journal_beside, open_journal, stoppable};
use super::{input, interruption};
use crate::cli::printing::{complain, print_json, sentence, shown, tell_text};
use crate::evaluation::taxonomy::Rule;
use crate::grasp::GraspEnergy;
use crate::printable::counted;
use crate::store::{FileSet, GraspFile, Population, Source, content_hash};
use crate::study::{self, GraspMapSettings, StudyError, SurveyFailure, SurveyedPopulation};
use crate::topography::{MemoryJournal, Run};

/// Name of the folder of landscapes in a survey.
const LANDSCAPES: &str = "landscapes";
/// Name of the file in the folder of a landscape with what the survey says of its population.
const POPULATION: &str = "population.json";
/// Names of the files of a survey.
const FILES: [&str; 10] = [
    "summary.md",
    "survey.json",
    "populations.csv",
    "kinds.csv",
    "types.svg",
    "types.png",
    "contacts.svg",
    "contacts.png",
    "rarefaction.svg",
    "rarefaction.png",
];

/// Survey a data set.
#[derive(Debug, Args)]
pub(super) struct Survey {
    /// Files of grasps, and folders that are searched for them (files with the ending `.parquet`, also in folders within).
    #[arg(value_name = "FILE|FOLDER", required = true)]
    sets: Vec<PathBuf>,
    /// The folder to write; by default the name of the first file or folder with the ending `.survey`.
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Count types, cells and sets of contact regions only, without mapping landscapes, which takes almost all of the time.
    /// Families are then unknown.
    #[arg(long, conflicts_with_all = ["family_barrier", "config", "no_report"])]
    no_map: bool,
    /// File (TOML) with any of the settings that `landscape config build` prints, for all landscapes.
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    config: Option<PathBuf>,
    #[command(flatten)]
    families: FamilyBarrier,
    /// Survey only the grasps that held in simulation (column `stable` of `landscape stability`).
    #[arg(long)]
    only_stable: bool,
    /// Survey only the first N grasps of each hand on each object.
    #[arg(long, value_name = "N")]
    first: Option<usize>,
    /// Seed of all random draws; 0 by default.
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    of: HandAndObject,
    #[command(flatten)]
    page: WithPage,
    /// Map one part of the populations only, as one of COUNT tasks of a scheduler, from 1/COUNT to COUNT/COUNT. The same
    /// command without this flag joins the parts.
    #[arg(long, value_name = "NUMBER/COUNT", conflicts_with_all = ["no_map", "resume"])]
    task: Option<String>,
    #[command(flatten)]
    again: Again,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape survey grasps/                                 grasps.survey/: what the files in this folder cover
  landscape survey mug.parquet bowl.parquet -o cups.survey
  landscape survey grasps/ --no-map                        types and sets of contact regions only, within minutes
  landscape survey grasps/ --task 3/64                     the third of 64 tasks that share the work (docs/cluster.md)

A file may contain several hands and objects; each hand on each object is a population of its own. For each of them, the
landscape is built as `landscape build` does it, into landscapes/ in the output folder. The survey then compares the
objects and pools them by hand:
  summary.md           what is covered, what objects share, what is missing; effective numbers at equal sample size
  populations.csv      one row for each population
  kinds.csv            the number of grasps of each type, cell, set of touching digits and family
  types, contacts      pictures (SVG, PNG): which object has which grasp types, and which sets of touching digits
  rarefaction          how the numbers of kinds grow with the number of grasps
  survey.json          all of it, for programs

An interrupted survey continues where it stopped when the same command is given again. If files were added since, only what
is new is mapped. A file that cannot be read is named in the summary, and the command ends with exit code 1 after everything
else is written.";

/// What is kept in the folder of a landscape: a later survey with the same inputs and settings takes it from there.
#[derive(Serialize, Deserialize)]
struct Kept {
    fingerprint: String,
    population: SurveyedPopulation,
}

pub(super) fn run(command: &Survey, common: &Common) -> anyhow::Result<()> {
    let part = command.task.as_deref().map(Part::named).transpose()?;
    command.families.checked()?;
    if let Some(first @ 0..2) = command.first {
        anyhow::bail!("--first {first}: a landscape needs at least two grasps");
    }
    let output = given_or_beside(command.output.as_ref(), &command.sets[0], "survey")?;
    let inputs: Vec<&Path> = command.sets.iter().map(PathBuf::as_path).collect();
    let expected = |name: &str| FILES.contains(&name) || name == LANDSCAPES;
    check_folder(&output, &inputs, expected, common)?;
    let plan = Plan::of(command, common.quiet)?;
    anyhow::ensure!(
        !plan.tasks.is_empty(),
        "none of the {} files could be read: {}",
        plan.files.len(),
        plan.failures[0]
    );
    let told = plan.repeated.iter().filter(|_| !common.quiet);
    told.for_each(|repeated| complain(&format!("note: {repeated}")));
    if !common.quiet {
        input::warn(&plan.noted);
    }
    let made = make_folder(&output.join(LANDSCAPES))?;
    if let Some(part) = part {
        made.keep();
        return command.one_part(part, &plan, &output, common);
    }

    let fingerprint = command.fingerprint(&plan)?;
    let journal = open_journal(&output, &fingerprint, &command.again, common.quiet)?;
    let run = Run {
        journal: &stoppable(&journal),
        ..Run::default()
    };
    let all: Vec<&Task> = plan.tasks.iter().collect();
    let outcomes = command.outcomes(&plan, &all, &output, &run, common)?;
    let (mut populations, mut failures) = (Vec::new(), plan.failures);
    for outcome in outcomes {
        match outcome {
            Ok(population) => populations.push(population),
            Err(failure) => failures.push(failure),
        }
    }
    let survey = study::Survey::new(populations, failures);
    write(&survey, &output, common)?;
    journal.remove()?;
    anyhow::ensure!(
        survey.failures.is_empty(),
        "{} of the files or populations could not be surveyed, the first one because of this: {} (the survey of the others \
         is in {})",
        survey.failures.len(),
        survey.failures[0],
        output.display()
    );
    Ok(())
}

/// A population, or why it could not be surveyed.
type Outcome = Result<SurveyedPopulation, SurveyFailure>;

impl Survey {
    /// Distinguishes the journals of different surveys.
    fn fingerprint(&self, plan: &Plan) -> anyhow::Result<String> {
        let mut parts = plan.hashes.clone();
        let tasks = plan.tasks.iter();
        parts.extend(tasks.flat_map(|task| [task.name.clone(), task.grasps.clone()]));
        if let Some(path) = &self.config {
            parts.push(std::fs::read_to_string(path)?);
        }
        let numbers = (self.families.family_barrier, self.seed, self.first);
        let flags = (self.no_map, self.page.no_report);
        let version = env!("CARGO_PKG_VERSION");
        parts.push(format!("{numbers:?} {flags:?} {version}"));
        let parts: Vec<&[u8]> = parts.iter().map(String::as_bytes).collect();
        Ok(content_hash(&parts))
    }

    /// Maps the populations of one part. What it finds is kept beside their landscapes only.
    fn one_part(
        &self,
        part: Part,
        plan: &Plan,
        output: &Path,
        common: &Common,
    ) -> anyhow::Result<()> {
        let tasks = part.of(&plan.tasks);
        let journal = MemoryJournal::default();
        let run = Run {
            journal: &stoppable(&journal),
            ..Run::default()
        };
        let outcomes = self.outcomes(plan, &tasks, output, &run, common)?;
        let failures: Vec<SurveyFailure> = outcomes.into_iter().filter_map(Result::err).collect();
        if common.json {
            print_json(&json!({
                "task": part,
                "populations": tasks.len() - failures.len(),
                "failures": failures,
            }))?;
        }
        if !common.quiet {
            complain(&format!(
                "task {part}: finished {}; the same command without --task joins all tasks",
                counted(tasks.len() - failures.len(), "population")
            ));
        }
        anyhow::ensure!(
            failures.is_empty(),
            "task {part}: {} of its {} could not be surveyed, the first one because of this: {}",
            failures.len(),
            counted(tasks.len(), "population"),
            failures[0]
        );
        Ok(())
    }

    /// Where an interruption leaves the finished populations.
    fn kept_in(&self, output: &Path) -> PathBuf {
        match self.task {
            Some(_) => output.join(LANDSCAPES),
            None => journal_beside(output),
        }
    }

    /// Surveys populations, one after the other.
    fn outcomes(
        &self,
        plan: &Plan,
        tasks: &[&Task],
        output: &Path,
        run: &Run<'_>,
        common: &Common,
    ) -> anyhow::Result<Vec<Outcome>> {
        // Populations of one file follow each other.
        let mut opened: Option<(usize, GraspFile, String)> = None;
        let key = |task: &&Task| format!("population {}", task.name);
        run.in_turn(tasks, key, |task| {
            interruption::keeps(&self.kept_in(output));
            let data = &plan.files[task.file];
            if opened.as_ref().is_none_or(|(file, ..)| *file != task.file) {
                let (file, hash, _) = files::read(data, self)?;
                opened = Some((task.file, file, hash));
            }
            let Some((_, file, hash)) = &opened else {
                anyhow::bail!("{} was not read", data.path.display());
            };
            anyhow::ensure!(
                *hash == plan.hashes[task.file],
                "{} was changed during the survey: give the same command again",
                data.path.display()
            );
            let mut population = file.landscapes().swap_remove(task.place);
            population.grasps.truncate(self.first.unwrap_or(usize::MAX));
            if !common.quiet {
                complain(&format!(
                    "population {} of {}: {} ({} grasps)",
                    task.number + 1,
                    plan.tasks.len(),
                    task.name,
                    population.grasps.len()
                ));
            }
            let source = Source {
                name: data.name.clone(),
                content_hash: hash.clone(),
            };
            self.outcome(task, &population, source, output, common)
        })
    }

    fn outcome(
        &self,
        task: &Task,
        population: &Population<'_>,
        source: Source,
        output: &Path,
        common: &Common,
    ) -> anyhow::Result<Outcome> {
        let rule = Rule::standard();
        let file = source.name.clone();
        let failed = |error: anyhow::Error| {
            Ok(Err(SurveyFailure {
                file: task.name.clone(),
                reason: sentence(&error),
            }))
        };
        let energy = match population.energy() {
            Ok(energy) => energy,
            Err(error) => return failed(error.into()),
        };
        let count = || {
            Watch::over(common.quiet, |run| {
                SurveyedPopulation::count(&task.name, &file, population, rule, run)
            })
        };
        if self.no_map || population.grasps.len() < 2 {
            return count().map_or_else(|error| failed(error.into()), |counted| Ok(Ok(counted)));
        }
        let settings = self.settings(&energy)?;
        let mapping = Mapping {
            population,
            energy: &energy,
            settings: &settings,
            earlier: None,
            pair: None,
            source,
            warnings: population.hand.warnings().collect(),
            with_page: !self.page.no_report,
        };
        let fingerprint = mapping.fingerprint()?;
        let fingerprint = content_hash(&[fingerprint.as_bytes(), rule.version.as_bytes()]);
        let folder = output.join(LANDSCAPES);
        let folder = folder.join(format!("{}.landscape", task.name));
        if let Some(kept) = kept(&folder, &fingerprint).filter(|_| !self.again.fresh) {
            return Ok(Ok(kept));
        }
        let mut counted = match count() {
            Ok(counted) => counted,
            Err(error) => return failed(error.into()),
        };
        let made = folder.parent().map(make_folder).transpose()?;
        if self.task.is_some()
            && let Some(made) = made
        {
            made.keep();
        }
        let again = Again {
            resume: false,
            fresh: self.again.fresh,
        };
        let written = match mapping.write(&folder, &again, common) {
            Ok(written) => written,
            Err(error) => {
                return match error.downcast_ref::<StudyError>() {
                    Some(only @ StudyError::OneMinimum(_)) => {
                        counted.notes.push(format!("{}: {only}", task.name));
                        Ok(Ok(counted))
                    }
                    // A full disk or an interruption ends the survey.
                    Some(StudyError::Journal(_) | StudyError::Store(_)) | None => Err(error),
                    Some(_) => failed(error),
                };
            }
        };
        counted.add_map(&energy, &written.found, rule);
        let kept = Kept {
            fingerprint,
            population: counted,
        };
        let text = serde_json::to_vec_pretty(&kept)?;
        written.unfinished.folder.write(POPULATION, &text)?;
        written.unfinished.finish(written.watch)?;
        interruption::keeps(&self.kept_in(output));
        Ok(Ok(kept.population))
    }

    fn settings(&self, energy: &GraspEnergy) -> anyhow::Result<GraspMapSettings> {
        let mut settings = GraspMapSettings::new(energy);
        if let Some(path) = &self.config {
            settings = settings.with_file(path)?;
        }
        let map = &mut settings.map;
        map.seed = self.seed.unwrap_or(map.seed);
        map.families.barrier = self.families.family_barrier.or(map.families.barrier);
        Ok(settings)
    }
}

/// What an earlier survey with the same inputs and settings has kept in the folder of a landscape.
fn kept(folder: &Path, fingerprint: &str) -> Option<SurveyedPopulation> {
    let text = std::fs::read(folder.join(POPULATION)).ok()?;
    let kept: Kept = serde_json::from_slice(&text).ok()?;
    (kept.fingerprint == fingerprint).then_some(kept.population)
}

/// Writes tables, pictures and summary, and shows the summary.
fn write(survey: &study::Survey, output: &Path, common: &Common) -> anyhow::Result<()> {
    let command = &common.provenance.command;
    let version = env!("CARGO_PKG_VERSION");
    let made = format!("Made by `{command}`, landscape {version}.");
    let text = shown(&format!("{}\n{made}\n", survey.markdown()));
    let mut value = survey.to_json();
    value["command"] = command.as_str().into();
    let mut files = vec![
        ("summary.md", text.clone().into_bytes()),
        ("survey.json", format!("{value:#}\n").into_bytes()),
        ("populations.csv", survey.populations_csv()),
        ("kinds.csv", survey.kinds_csv()),
    ];
    let pictures = [
        (["types.svg", "types.png"], survey.type_chart()),
        (["contacts.svg", "contacts.png"], survey.contact_chart()),
        (
            ["rarefaction.svg", "rarefaction.png"],
            Some(survey.rarefaction_chart()),
        ),
    ];
    for (names, chart) in pictures {
        if let Some(chart) = chart {
            let canvas = chart.draw()?;
            for name in names {
                files.push((name, canvas.encode(name.as_ref())?));
            }
        }
    }
    let mut set = FileSet::default();
    for (name, bytes) in &files {
        set.add(&output.join(name), bytes)?;
    }
    set.finish()?;
    let written = output.display().to_string();
    tell_text(common, (&text, &value), Some(&written))
}
