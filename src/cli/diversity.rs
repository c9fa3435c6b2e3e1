//! `landscape diversity`: which of several sets of grasps is more diverse.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;

use super::args::{Common, FamilyBarrier, Lacking};
use super::input;
use super::output::{Report, check_report, given_or_beside, write_report};
use super::run::Watch;
use crate::evaluation::taxonomy::Rule;
use crate::store::{GraspFile, LandscapeFiles};
use crate::study::{
    DiversitySet, DiversitySettings, Run, StudyError, check_set_sizes, compare_diversity,
};

/// Compare how diverse sets of grasps are.
#[derive(Debug, Args)]
pub(super) struct Diversity {
    /// The sets: files of grasps (Parquet) and landscapes (folders), in any mixture.
    #[arg(value_name = "FILE|LANDSCAPE", required = true)]
    sets: Vec<PathBuf>,
    /// Name of the files to write, without .md, .json, .png and .svg; by default that of the first set with `.diversity`.
    #[arg(short, long, value_name = "NAME")]
    output: Option<PathBuf>,
    #[command(flatten)]
    lacking: Lacking,
    #[command(flatten)]
    families: FamilyBarrier,
    /// Number of resamplings for each interval.
    #[arg(long, value_name = "N", default_value_t = DiversitySettings::default().resamplings)]
    resamplings: usize,
    /// Seed of the resamplings.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape diversity one.landscape other.landscape        which of the two is more diverse; one.diversity.md, .svg, …
  landscape diversity a.parquet b.parquet c.parquet        the same of files of grasps, without families
  landscape diversity a.landscape                          the effective numbers of one set
  landscape diversity a.landscape b.landscape --family-barrier 0.1    with families at one level

The first line is the answer: how many times as many effective kinds one set has as the other, with a 95 % interval. If
the interval contains 1, no difference is shown, and the line says how many grasps in each set would show one of this size
(in four of five comparisons; widths of intervals fall as one over the square root of the number of grasps). Kinds are
four things:
  families         grasps of a landscape between which the hand passes over low barriers
  types, cells     of the GRASP taxonomy, by the rule of `landscape label` (labels by a human override it)
  sets of contact regions   different sets of digits (and the palm) that are within 2 mm of the object
An effective number says how many equally frequent kinds would be as diverse. Order 0 counts every kind, however rare;
order 1 weighs each by its frequency; order 2 shows how many are frequent. The table has all three.

All sets are rarefied to the number of grasps of the smallest one, so that no set looks diverse because it is large.
Nothing is extrapolated, and a set of fewer than thirty grasps is refused; `landscape join` puts files together. Brackets
are 95 % intervals over resamplings of the grasps. A set is called the most diverse only where the intervals of its ratios
to all others lie above 1. Families are compared at half and at twice their level, too, and all their intervals
span those of the three levels, so that the height of a single pass decides nothing. All this takes the grasps for
independent draws: a set that was chosen to be spread (synth --spread) looks more diverse than its source, and every set
depends on how it was drawn. A last paragraph is a sentence for a paper.

Writes the table (.md), the numbers (.json) and a picture (.svg, .png).";

pub(super) fn run(command: &Diversity, common: &Common) -> anyhow::Result<()> {
    anyhow::ensure!(
        (20..=100_000).contains(&command.resamplings),
        "--resamplings {}: a number from 20 to 100000 is needed",
        command.resamplings
    );
    command.families.checked()?;
    let output = given_or_beside(command.output.as_ref(), &command.sets[0], "diversity")?;
    let inputs: Vec<&Path> = command.sets.iter().map(PathBuf::as_path).collect();
    check_report(&output, &[], &inputs, common.force)?;
    let names = input::names(&command.sets);
    let opened = (command.sets.iter())
        .map(|path| Opened::of(command, path, common))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let sizes = names.iter().zip(&opened);
    check_set_sizes(sizes.map(|(name, set)| (name.as_str(), set.grasps())))?;
    let sets = Watch::over(common.quiet, |run| {
        let sets = command.sets.iter().zip(&names).zip(&opened);
        let count = |((path, name), set): ((&PathBuf, &String), &Opened)| {
            let counted = set.counted(command, path, name, run);
            counted.with_context(|| path.display().to_string())
        };
        sets.map(count).collect::<anyhow::Result<Vec<_>>>()
    })?;
    let settings = DiversitySettings {
        resamplings: command.resamplings,
        seed: command.seed,
    };
    let found = compare_diversity(&sets, &settings)?;
    let report = Report {
        text: found.markdown(),
        value: found.to_json(),
        chart: Some(found.chart()),
        tables: Vec::new(),
    };
    write_report(Some(&output), report, common)
}

/// What a path holds.
enum Opened {
    Grasps(Box<GraspFile>),
    Landscape(Box<LandscapeFiles>),
}

impl Opened {
    fn of(command: &Diversity, path: &Path, common: &Common) -> anyhow::Result<Self> {
        if path.is_dir() {
            return Ok(Self::Landscape(Box::new(input::open_landscape(path)?)));
        }
        let (file, mut warnings) = input::read_lacking(path, &command.lacking)?;
        // Counting needs no energy.
        warnings.retain(|warning| !warning.starts_with("the energy of the grasps is not recorded"));
        if !common.quiet {
            input::warn(&warnings);
        }
        Ok(Self::Grasps(Box::new(file)))
    }

    fn grasps(&self) -> usize {
        match self {
            Self::Grasps(file) => file.grasps.len(),
            Self::Landscape(files) => files.minima.iter().map(|row| row.members.len()).sum(),
        }
    }

    /// Counts the grasps.
    fn counted(
        &self,
        command: &Diversity,
        path: &Path,
        name: &str,
        run: &Run<'_>,
    ) -> Result<DiversitySet, StudyError> {
        let rule = Rule::standard();
        match self {
            Self::Grasps(file) => DiversitySet::of_grasps(name, file, rule, run),
            Self::Landscape(files) => {
                let family_barrier = command.families.family_barrier;
                DiversitySet::of_landscape(name, files, path, family_barrier, rule, run)
            }
        }
    }
}
