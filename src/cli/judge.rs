//! `landscape judge`: published tests and measures of sets of grasps.

use std::path::{Path, PathBuf};

use anyhow::{bail, ensure};
use clap::Args;

use super::args::{Again, Common, Lacking};
use super::input;
use super::output::{Report, check_report, given_or_beside, write_report};
use super::run::resumable;
use crate::evaluation::stability::{NAMED, NamedProtocol};
use crate::store::GraspFile;
use crate::study::referee::measures::{Measure, Resampling};
use crate::study::referee::{JudgedSet, RefereeSettings, judge_sets, referee_fingerprint};

/// Judge sets of grasps.
#[derive(Debug, Args)]
pub(super) struct Judge {
    /// The sets: files of grasps (Parquet). `landscape import` makes them of published ones.
    #[arg(value_name = "FILE", required = true)]
    sets: Vec<PathBuf>,
    /// The tests, separated by commas; `none` for none. By default all.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    tests: Vec<String>,
    /// The measures, separated by commas; `none` for none. By default all.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    measures: Vec<String>,
    /// Name of the files to write, without their endings; by default that of the first set with `.judge`.
    #[arg(short, long, value_name = "NAME")]
    output: Option<PathBuf>,
    #[command(flatten)]
    lacking: Lacking,
    /// Measure each object by N of its grasps (mean over twenty random choices), so that sets of different size are
    /// comparable; objects with fewer grasps do not count. Tests see all grasps.
    #[arg(long, value_name = "N")]
    at: Option<usize>,
    /// Seed of the resamplings.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    again: Again,
}

/// The help, with the tests and measures.
pub(super) fn examples() -> String {
    let tests = NAMED
        .iter()
        .map(|test| format!("  {:<20} {}\n", test.name, test.title));
    let measures = Measure::ALL.map(|measure| {
        let unit = match measure.unit() {
            "" => String::new(),
            unit => format!(", {unit}"),
        };
        let held = if measure.of_held() {
            "; of grasps that hold"
        } else {
            ""
        };
        format!("  {:<28} {}{unit}{held}\n", measure.name(), measure.title())
    });
    format!(
        "\
Examples:
  landscape judge grasps.parquet                           grasps.judge.md, .json, .csv, .png, .svg: all tests and measures
  landscape judge mine.parquet theirs.parquet              two sets side by side
  landscape judge a.parquet b.parquet --tests drop,dexgraspbench --measures none -o two
  landscape import theirs.npy --hand shadow.xml --object mug.obj -o theirs.parquet    makes a set of a published file

Every grasp is simulated by every test, with the numbers of its publication in our engine (Rapier): Python runs the same
tests in MuJoCo. A table has the share of grasps that hold, another one says on how many grasps two tests disagree.
What a test needs and a file lacks, such as squeezed joints, is derived by a rule that the table states. Intervals are
95 %, over resampled objects and, within these, grasps; a set of one object says nothing of other objects. A
second CSV (.grasps.csv) has the outcome of each grasp. An interrupted run continues when the same command is given again.

Tests (`landscape config stability --protocol NAME` prints the numbers):
{}
Measures (docs/measures.md explains each, and shows where it misleads):
{}",
        tests.collect::<String>(),
        measures.concat()
    )
}

pub(super) fn run(command: &Judge, common: &Common) -> anyhow::Result<()> {
    let tests: Vec<&'static NamedProtocol> =
        chosen("tests", &command.tests, &NAMED, |test| &test.name)?;
    let all: &[Measure] = &Measure::ALL;
    let measures = chosen("measures", &command.measures, all, |measure| measure.name())?;
    let measures: Vec<Measure> = measures.into_iter().copied().collect();
    ensure!(
        !(tests.is_empty() && measures.is_empty()),
        "--tests none --measures none: nothing is left to do"
    );
    ensure!(
        command.at != Some(0),
        "--at 0: a number of grasps, 1 or more, is needed"
    );
    let output = given_or_beside(command.output.as_ref(), &command.sets[0], "judge")?;
    let inputs: Vec<&Path> = command.sets.iter().map(PathBuf::as_path).collect();
    check_report(&output, &["csv", "grasps.csv"], &inputs, common.force)?;
    let names = input::names(&command.sets);
    let files = command.sets.iter().map(|path| {
        let read = input::read_lacking(path, &command.lacking);
        let (file, warnings) = read?;
        ensure!(!file.grasps.is_empty(), "{} has no grasps", path.display());
        if !common.quiet {
            input::warn(&warnings);
        }
        Ok(file)
    });
    let files: Vec<GraspFile> = files.collect::<anyhow::Result<_>>()?;
    let sets = names.iter().zip(&files);
    let sets: Vec<JudgedSet<'_>> = sets.map(|(name, file)| JudgedSet { name, file }).collect();
    let settings = RefereeSettings {
        tests,
        measures,
        resampling: Resampling {
            seed: command.seed,
            at: command.at,
            ..Resampling::default()
        },
    };
    let fingerprint = referee_fingerprint(&sets, &settings)?;
    let (output, quiet) = (output.as_path(), common.quiet);
    let (found, journal) = resumable(output, &fingerprint, &command.again, quiet, |run| {
        Ok(judge_sets(&sets, &settings, run)?)
    })?;
    let files: Vec<&GraspFile> = files.iter().collect();
    let report = Report {
        text: found.markdown(),
        value: found.to_json(),
        chart: Some(found.chart()),
        tables: vec![
            ("csv", found.csv()),
            ("grasps.csv", found.csv_of_grasps(&files)),
        ],
    };
    write_report(Some(output), report, common)?;
    journal.remove()?;
    Ok(())
}

/// The members of `all` that a flag names; all without the flag.
fn chosen<'a, T>(
    flag: &str,
    names: &[String],
    all: &'a [T],
    name_of: impl Fn(&T) -> &str,
) -> anyhow::Result<Vec<&'a T>> {
    match names {
        [] => return Ok(all.iter().collect()),
        [none] if none == "none" => return Ok(Vec::new()),
        _ => {}
    }
    let mut found = Vec::new();
    for name in names {
        let Some(member) = all.iter().find(|member| name_of(member) == name) else {
            let known: Vec<&str> = all.iter().map(&name_of).collect();
            bail!(
                "--{flag} {name}: the {flag} are {}, or none",
                known.join(", ")
            );
        };
        found.push(member);
    }
    Ok(found)
}
