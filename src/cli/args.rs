//! The arguments that several verbs share. Those of one verb are in its own file.

use anyhow::{Context, bail};
use clap::{Args, ValueHint};

use super::provenance::Provenance;
use crate::limits::{Limit, THREADS};
use crate::printable::numbered;
use crate::topography::{FamilySettings, MinimumId, PairSearch};

/// Flags of every subcommand.
#[derive(Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag by itself")]
pub(super) struct Common {
    /// Number of threads; all cores by default. The result does not depend on it.
    #[arg(long, global = true, value_name = "N")]
    threads: Option<usize>,
    /// Print neither progress bars nor summary.
    #[arg(long, short, global = true)]
    pub(super) quiet: bool,
    /// Print the result as one JSON document, in place of texts; docs/scripts.md describes it.
    #[arg(long, global = true)]
    pub(super) json: bool,
    /// Say on standard error what is being done, and why.
    #[arg(long, short, global = true, conflicts_with = "quiet")]
    pub(super) verbose: bool,
    /// Write the lines on standard error (progress, warnings, errors) as texts, or each as a JSON document.
    #[arg(long, global = true, value_name = "FORMAT", default_value = "text")]
    pub(super) log_format: LogFormat,
    /// Overwrite the output even if this program did not make it, if it may have been edited, or if it is also an input.
    #[arg(long, global = true)]
    pub(super) force: bool,
    /// This command line, for the files that it writes.
    #[arg(skip)]
    pub(super) provenance: Provenance,
}

/// Stack of a thread on which a whole command may run, as large as that of a program's first thread.
const STACK: usize = 8 << 20;

impl Common {
    /// Sets up the threads of this process.
    pub(super) fn threads(&self) -> anyhow::Result<()> {
        let Some(threads) = self.threads else {
            return Ok(());
        };
        within("--threads", THREADS, threads as f64)?;
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .context("cannot start the threads")
    }

    /// Runs `work` on threads of its own, if a number of them is wanted: those of the process may be at work already.
    pub(super) fn on_threads<T: Send>(
        &self,
        work: impl FnOnce() -> anyhow::Result<T> + Send,
    ) -> anyhow::Result<T> {
        let Some(threads) = self.threads else {
            return work();
        };
        within("--threads", THREADS, threads as f64)?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .stack_size(STACK)
            .build();
        pool.context("cannot start the threads")?.install(work)
    }
}

/// Handling of an interrupted run, which is continued by default.
#[derive(Debug, Args)]
pub(super) struct Again {
    /// Continue an interrupted run; fail if there is none. (Without this flag, the command continues an interrupted run if
    /// there is one and begins a new one otherwise.)
    #[arg(long, conflicts_with = "fresh")]
    pub(super) resume: bool,
    /// Begin a new run even if there is an interrupted one, whose results are lost.
    #[arg(long)]
    pub(super) fresh: bool,
}

/// The page of a landscape.
#[derive(Debug, Args)]
pub(super) struct WithPage {
    /// Leave out report.html, the page on which the landscape is explored (`landscape report` writes it later).
    #[arg(long)]
    pub(super) no_report: bool,
}

/// The greatest barrier within a family.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct FamilyBarrier {
    /// Put minima that are joined by a relative barrier of at most E, in units of the energy, into one family. (The energy of
    /// grasps is in units of the cost of letting go.) The families of two landscapes are comparable only at the
    /// same E.
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    pub(super) family_barrier: Option<f64>,
}

impl FamilyBarrier {
    /// Returns the given barrier if it is valid.
    pub(super) fn checked(self) -> anyhow::Result<Option<f64>> {
        if let Some(barrier) = self.family_barrier {
            anyhow::ensure!(
                barrier.is_finite() && barrier >= 0.0,
                "--family-barrier {barrier}: a number in units of the energy is needed, 0 or more"
            );
        }
        Ok(self.family_barrier)
    }

    pub(super) fn settings(self) -> FamilySettings {
        FamilySettings {
            barrier: self.family_barrier,
            ..FamilySettings::default()
        }
    }
}

/// Hand and object of grasps whose file does not describe them, or others for judging the poses.
#[derive(Debug, Args)]
pub(super) struct HandAndObject {
    /// The hand, if the file does not describe it. If the file does, judge the poses with this other hand, which must have
    /// the same joints; contacts are then chosen again.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) hand: Option<String>,
    /// The object, if the file does not describe it. If the file does, judge the poses with this other object (in its own
    /// size); the contact set stays, all measures are computed again, and labels and outcomes of simulations are dropped.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) object: Option<String>,
}

/// Hand and object of files of grasps that do not describe theirs.
#[derive(Debug, Args)]
pub(super) struct Lacking {
    /// The hand of files that do not describe theirs.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) hand: Option<String>,
    /// The object of files that do not describe theirs.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) object: Option<String>,
}

/// Format of the lines on standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum LogFormat {
    /// Sentences, and bars at a terminal.
    Text,
    /// One JSON document in each line; docs/scripts.md describes them.
    Json,
}

/// Rejects the value of a flag that is beyond its limit.
pub(super) fn within(flag: &str, limit: Limit, value: f64) -> anyhow::Result<()> {
    let told = |beyond| anyhow::anyhow!("{flag} {beyond}");
    limit.check(value).map_err(told)
}

/// The minimum that the value of a flag names, `m3` or `3`, of `count`.
pub(super) fn minimum_named(flag: &str, name: &str, count: usize) -> anyhow::Result<MinimumId> {
    match name.strip_prefix('m').unwrap_or(name).parse() {
        Ok(number) if number < count => Ok(MinimumId(number)),
        Ok(_) => bail!("--{flag} {name}: {}", numbered(count, "minimum", 'm')),
        Err(_) => {
            bail!("--{flag} {name}: write minima as the tree names them, such as m0 or m17")
        }
    }
}

/// The usual searches between the two minima that `--connect` names, of `count`.
pub(super) fn pair_named(names: &[String], count: usize) -> anyhow::Result<PairSearch> {
    let minima = names
        .iter()
        .map(|name| minimum_named("connect", name, count));
    match minima.collect::<anyhow::Result<Vec<_>>>()?[..] {
        [from, to] if from != to => Ok(PairSearch {
            minima: [from, to],
            searches: PairSearch::USUAL,
        }),
        _ => bail!("--connect {}: name two different minima", names.join(" ")),
    }
}
