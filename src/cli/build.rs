//! `landscape build`: the landscape between the grasps of a file.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};

use super::args::{Again, Common, FamilyBarrier, HandAndObject, WithPage, pair_named, within};
use super::input;
use super::output::{check_inputs, check_place};
use super::report;
use super::run::{Unfinished, Watch, check_resumable, stoppable};
use crate::cli::printing::{explain, explain_settings, print_landscapes};
use crate::grasp::GraspEnergy;
use crate::limits::ENERGY_SCALE;
use crate::printable::counted;
use crate::store::{GraspFile, Population, Source, content_hash};
use crate::study::{
    ConfigurationError, EarlierLandscape, GraspLandscape, GraspMapSettings, GraspReport,
    JoinedGrasps, MapSearch, PageLandscape, StudyError, StudyRun, WrittenLandscape,
    grow_population, map_population, name_of,
};
use crate::topography::{PairSearch, Run};

/// Map a landscape.
#[derive(Debug, Args)]
pub(super) struct Build {
    /// The grasps: a file of `landscape synth`, or your own file with the same columns.
    #[arg(value_name = "FILE")]
    grasps: PathBuf,
    /// The folder to write; by default the name of the file with the ending `.landscape`.
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Number of nearest minima to which each minimum is connected, in addition to a minimum spanning tree of distances; 10
    /// by default. More connections lower some barriers.
    #[arg(long, value_name = "K")]
    neighbours: Option<usize>,
    /// Temperature T of attraction–diffusion; by default the usual one of the energy.
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(super) temperature: Option<f64>,
    /// Force F = αT of attraction–diffusion, energy per metre; by default the best of a few that are tried on some pairs.
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    pub(super) pull: Option<f64>,
    /// File (TOML) with any of the settings that `landscape config build` prints. Flags override it.
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    config: Option<PathBuf>,
    /// How the minima are joined; `passes` by default.
    #[arg(long, value_enum)]
    search: Option<Search>,
    /// Add the grasps to this finished landscape, with its settings, and do only what is new. Grasps that it contains already
    /// are skipped. Without --output a new folder is named after the file; the old landscape stays as it is.
    #[arg(long, value_name = "LANDSCAPE", value_hint = clap::ValueHint::AnyPath, conflicts_with_all = [
        "neighbours", "temperature", "pull", "config", "search", "seed",
    ])]
    onto: Option<PathBuf>,
    /// Spend more on two minima of the landscape of --onto, as it names them (m3, m17): 40 further searches for a lower way
    /// between them. FILE need hold no new grasps; it may be the grasps.parquet of that landscape.
    #[arg(long, num_args = 2, value_names = ["FROM", "TO"], requires = "onto")]
    connect: Option<Vec<String>>,
    #[command(flatten)]
    families: FamilyBarrier,
    /// Map only the grasps that held in simulation (column `stable` of `landscape stability`).
    #[arg(long)]
    only_stable: bool,
    /// Map only the first N grasps of each hand, object and size in the file, for a quick look.
    #[arg(long, value_name = "N")]
    first: Option<usize>,
    /// Seed of all random draws; 0 by default.
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    of: HandAndObject,
    #[command(flatten)]
    page: WithPage,
    #[command(flatten)]
    again: Again,
}

/// How the minima of a map are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Search {
    /// By relaxed paths over verified passes, and independent attraction–diffusion searches for lower ways across every merge.
    Passes,
    /// By attraction–diffusion alone, as published (sequential ADELM): minima are assigned one by one, in the order of the
    /// file, to the family with the lowest raw barrier. Every barrier is an upper bound, and the result depends on the order.
    Adelm,
}

impl From<Search> for MapSearch {
    fn from(search: Search) -> Self {
        match search {
            Search::Passes => Self::Passes,
            Search::Adelm => Self::Adelm,
        }
    }
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape build data/grasps.parquet                      writes data/grasps.landscape/
  landscape build mug.parquet --neighbours 12 -o mug.landscape
  landscape build mug.parquet --search adelm               the published method alone, for comparison
  landscape build mug.parquet --family-barrier 0.1         families as another landscape has them at 0.1
  landscape build more.parquet --onto mug.landscape        adds grasps to a finished landscape: writes more.landscape/
  landscape build mug.landscape/grasps.parquet --onto mug.landscape --connect m3 m17 -o better.landscape
                                                           further searches for a lower way between two minima

Writes minima.parquet, edges.parquet, paths.parquet, grasps.parquet (those that were mapped), landscape.json, the tree (tree.nwk, tree.dot, tree.json), the
network (barriers.graphml), min.data and ts.data for PATHSAMPLE (with placeholders instead of curvatures), the
disconnectivity graph, the barrier graph and a rarefaction curve (SVG and PNG), summary.md, and report.html, a page on
which the landscape is explored in a browser (double-click it; --no-report leaves it out). An interrupted run continues
where it stopped when the same command is given again; --resume demands this, and --fresh starts over. The result is the
same to the last byte.

The first line counts different grasps, which are the minima of the energy, and families, which are sets of them. Two minima
are in one family if a path joins them whose relative barrier is at most the family barrier. For grasps of synth, this
barrier is what it costs to put one resting phalanx on the object, in every landscape: within a family, no more than one
phalanx at a time comes or goes.";

pub(super) fn run(command: &Build, common: &Common) -> anyhow::Result<()> {
    for (flag, value) in [("temperature", command.temperature), ("pull", command.pull)] {
        if let Some(value) = value {
            within(&format!("--{flag}"), ENERGY_SCALE, value)?;
        }
    }
    command.families.checked()?;
    if let Some(first @ 0..2) = command.first {
        anyhow::bail!("--first {first}: a landscape needs at least two grasps");
    }
    let (mut file, warnings) = input::read(
        &command.grasps,
        command.of.hand.as_deref(),
        command.of.object.as_deref(),
    )?;
    if command.only_stable {
        keep_stable(&mut file, &command.grasps)?;
    }
    if !common.quiet {
        input::warn(&warnings);
    }
    let earlier = command.onto.as_deref().map(EarlierLandscape::read);
    let earlier = earlier.transpose()?;
    let pair = match (&command.connect, &earlier) {
        (Some(names), Some(earlier)) => Some(pair_named(names, earlier.minima())?),
        _ => None,
    };
    let mut populations = file.landscapes();
    if let Some(earlier) = &earlier {
        let same = earlier.same_population(populations);
        populations = vec![same.with_context(|| format!("{}", command.grasps.display()))?];
    }
    let several = populations.len() > 1;
    let folders = populations
        .iter()
        .map(|population| folder(command, population, several))
        .collect::<anyhow::Result<Vec<_>>>()?;
    for folder in &folders {
        check_place(folder)?;
        check_inputs(folder, &[&command.grasps])?;
        for input in command.config.iter().chain(&command.onto) {
            check_inputs(folder, &[input])?;
        }
    }
    check_resumable(&command.again, &folders)?;
    for (population, folder) in populations.iter().zip(&folders) {
        let mapped = population
            .grasps
            .len()
            .min(command.first.unwrap_or(usize::MAX));
        let all = mapped == file.grasps.len();
        let of_hand: Vec<String> = population.hand.warnings().collect();
        // Numbers in the other sentences count the grasps of the file.
        let warnings = warnings.iter().map(|warning| {
            if all || of_hand.contains(warning) {
                warning.clone()
            } else {
                format!("of the whole file: {warning}")
            }
        });
        let earlier = earlier.as_ref();
        build(
            command,
            common,
            population,
            earlier.map(|earlier| (earlier, pair)),
            folder,
            warnings.collect(),
        )
        .map_err(|error| {
            if error.is::<ConfigurationError>() {
                error
            } else {
                error.context(command.grasps.display().to_string())
            }
        })?;
    }
    print_landscapes(common, &folders)
}

/// Removes the grasps that did not hold in simulation.
pub(super) fn keep_stable(file: &mut GraspFile, path: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(
        file.grasps.iter().any(|grasp| grasp.stable.is_some()),
        "--only-stable: no grasp of {} was simulated: run `landscape stability` on it first",
        path.display()
    );
    file.grasps.retain(|grasp| grasp.stable == Some(true));
    anyhow::ensure!(
        file.grasps.len() >= 2,
        "--only-stable: {} of the grasps of {} held, but a landscape needs at least two",
        file.grasps.len(),
        path.display()
    );
    Ok(())
}

/// Folder of a population's landscape: beside the file, with its name.
fn folder(command: &Build, population: &Population<'_>, several: bool) -> anyhow::Result<PathBuf> {
    let mut folder = match &command.output {
        Some(output) => output.clone(),
        None => command.grasps.with_extension("landscape"),
    };
    if several {
        let stem = folder
            .file_stem()
            .context("--output: a folder name is needed")?;
        let name = format!(
            "{}.{}.{}.{}.landscape",
            stem.to_string_lossy(),
            population.hand.name,
            population.object.name,
            population.scale
        );
        folder.set_file_name(name);
    }
    Ok(folder)
}

fn settings(
    command: &Build,
    energy: &GraspEnergy,
    earlier: Option<&EarlierLandscape>,
) -> anyhow::Result<GraspMapSettings> {
    let mut settings = GraspMapSettings::new(energy);
    if let Some(earlier) = earlier {
        settings.map = earlier.settings.clone();
    }
    if let Some(path) = &command.config {
        settings = settings.with_file(path)?;
    }
    let map = &mut settings.map;
    map.seed = command.seed.unwrap_or(map.seed);
    map.neighbours = command.neighbours.unwrap_or(map.neighbours);
    map.families.barrier = command.families.family_barrier.or(map.families.barrier);
    let search = command.search.map_or(settings.search, Into::into);
    if search == MapSearch::Adelm {
        anyhow::ensure!(
            command.families.family_barrier.is_none(),
            "--family-barrier: the burn-in of `adelm` makes the families; leave it out, or map with `--search passes`"
        );
    }
    Ok(GraspMapSettings {
        temperature: command.temperature.or(settings.temperature),
        force: command.pull.or(settings.force),
        search,
        ..settings
    })
}

/// Maps a population.
fn build(
    command: &Build,
    common: &Common,
    population: &Population<'_>,
    onto: Option<(&EarlierLandscape, Option<PairSearch>)>,
    output: &Path,
    mut warnings: Vec<String>,
) -> anyhow::Result<()> {
    let mut population = population.clone();
    population
        .grasps
        .truncate(command.first.unwrap_or(usize::MAX));
    let joined = onto.map(|(earlier, _)| earlier.joined(&population));
    let joined = joined.transpose()?;
    if let (Some((earlier, pair)), Some(joined)) = (onto, &joined) {
        if !joined.are_known(earlier) {
            warnings.extend(joining(joined));
        } else if pair.is_none() {
            return Err(StudyError::NothingNew(earlier.source.name.clone()).into());
        }
        population.clone_from(&joined.file.landscapes()[0]);
    }
    let earlier = onto.map(|(earlier, _)| earlier);
    anyhow::ensure!(
        population.grasps.len() > 1,
        "there is only one grasp of the {} hand on {}, but a landscape needs at least two",
        population.hand.name,
        population.object.name
    );
    let energy = population.energy()?;
    let settings = settings(command, &energy, earlier)?;
    explain_settings("settings of the map", &settings.map_settings());
    let mapping = Mapping {
        population: &population,
        energy: &energy,
        settings: &settings,
        earlier,
        pair: onto.and_then(|(_, pair)| pair),
        source: Source {
            name: name_of(&command.grasps),
            content_hash: content_hash(&[&std::fs::read(&command.grasps)?]),
        },
        warnings,
        with_page: !command.page.no_report,
    };
    let written = mapping.write(output, &command.again, common)?;
    let (summary, with_page) = (written.summary, mapping.with_page);
    written.unfinished.conclude(written.watch, |folder| {
        told(&summary, folder, with_page, common.verbose)
    })
}

/// The answer, what a reader must know, and where the rest is; with `verbose` the rest itself.
fn told(summary: &WrittenLandscape, folder: &Path, with_page: bool, verbose: bool) -> String {
    let mut text = summary.headline.clone();
    if with_page {
        let page = folder.join(report::PAGE);
        let _ = write!(text, " Open {}", page.display());
    }
    text.push('\n');
    if verbose {
        return text + "\n" + &summary.text;
    }
    for note in &summary.notes {
        let _ = writeln!(text, "Note: {note}.");
    }
    let file = folder.join("summary.md");
    let _ = writeln!(
        text,
        "The statistics are in {} (--verbose prints them).",
        file.display()
    );
    text
}

/// What a reader must know about grasps that were added to a landscape.
fn joining(joined: &JoinedGrasps) -> Vec<String> {
    let mut notes = Vec::new();
    if joined.repeated > 0 {
        let (repeated, verb) = (
            counted(joined.repeated, "grasp"),
            if joined.repeated == 1 { "was" } else { "were" },
        );
        notes.push(format!(
            "{repeated} of the file {verb} in the landscape already"
        ));
    }
    if joined.renumbered > 0 {
        notes.push(format!(
            "{} of the file have new ids in grasps.parquet of this landscape, because theirs were taken",
            counted(joined.renumbered, "grasp")
        ));
    }
    notes
}

/// A population that is to be mapped, and how.
pub(super) struct Mapping<'a> {
    pub(super) population: &'a Population<'a>,
    pub(super) energy: &'a GraspEnergy,
    pub(super) settings: &'a GraspMapSettings,
    /// The landscape to which the last grasps of the population are added.
    pub(super) earlier: Option<&'a EarlierLandscape>,
    /// Two minima of that landscape between which further searches are made.
    pub(super) pair: Option<PairSearch>,
    /// The file of the grasps.
    pub(super) source: Source,
    pub(super) warnings: Vec<String>,
    /// Whether report.html is written.
    pub(super) with_page: bool,
}

/// A mapped population, whose folder lacks its final name.
pub(super) struct Written {
    pub(super) found: GraspLandscape,
    pub(super) unfinished: Unfinished,
    pub(super) watch: Watch,
    pub(super) summary: WrittenLandscape,
}

impl Mapping<'_> {
    fn map(&self, run: &StudyRun<'_>) -> Result<GraspLandscape, StudyError> {
        let (population, settings) = (self.population, self.settings);
        match self.earlier {
            Some(earlier) => {
                let barrier = settings.map.families.barrier;
                grow_population(earlier, population, self.energy, barrier, self.pair, run)
            }
            None => map_population(population, self.energy, settings, run),
        }
    }

    /// Maps the population and writes all files into the unfinished folder of `output`.
    pub(super) fn write(
        &self,
        output: &Path,
        again: &Again,
        common: &Common,
    ) -> anyhow::Result<Written> {
        let unfinished = Unfinished::open(output, &self.fingerprint()?, again, common.quiet)?;
        let watch = Watch::new(common.quiet);
        let run = StudyRun {
            run: Run {
                journal: &stoppable(&unfinished.journal),
                observer: &|news| watch.see(news),
                ..Run::default()
            },
            stage_ended: &|name, evaluations| watch.lap(name, evaluations),
        };
        let found = match self.map(&run) {
            Err(error @ StudyError::OneMinimum { .. }) => {
                unfinished.discard()?;
                return Err(error.into());
            }
            found => found?,
        };
        explain(|| {
            format!(
                "temperature and force of the chains: {}",
                found.choice.spell()
            )
        });
        let report = GraspReport {
            found: &found,
            energy: self.energy,
            population: self.population,
            source: self.source.clone(),
            command: common.provenance.command.clone(),
            warnings: self.warnings.clone(),
        };
        let summary = report.write(&unfinished.folder)?;
        if self.with_page {
            let known = self.population.grasps.iter();
            let held = known.filter_map(|grasp| Some((grasp.id, grasp.stable?)));
            let landscape = PageLandscape {
                name: "",
                files: &summary.files,
                attempts: &summary
                    .files
                    .attempts(found.landscape.attempts.list.clone()),
                held: &held.collect(),
                energy: Some(self.energy),
            };
            report::write_into(&unfinished.folder, landscape, common)?;
        }
        Ok(Written {
            found,
            unfinished,
            watch,
            summary,
        })
    }

    /// Distinguishes the journals of different runs.
    pub(super) fn fingerprint(&self) -> anyhow::Result<String> {
        let (population, settings) = (self.population, self.settings);
        let earlier = self.earlier.map(|earlier| &earlier.source.content_hash);
        Ok(content_hash(&[
            self.source.content_hash.as_bytes(),
            serde_json::to_string(&settings.map_settings())?.as_bytes(),
            // Hand and object as changed by the flags --hand and --object.
            serde_json::to_string(population.object)?.as_bytes(),
            serde_json::to_string(population.hand)?.as_bytes(),
            &population.scale.to_le_bytes(),
            &(population.grasps.len() as u64).to_le_bytes(),
            serde_json::to_string(&settings.search)?.as_bytes(),
            earlier.map_or(&[], |hash| hash.as_bytes()),
            format!("{:?}", self.pair).as_bytes(),
            env!("CARGO_PKG_VERSION").as_bytes(),
        ]))
    }
}
