//! The command line. Each subcommand reads, makes one library call, and writes. Data goes to files or standard output, and
//! progress to standard error. A user's mistake ends with one sentence and exit code 1, or 2 if the command line cannot be read;
//! docs/scripts.md lists all exit codes.

use std::borrow::Cow;
use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::{Mutex, MutexGuard, PoisonError};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::printable::printable;

mod args;
mod build;
mod cache;
mod compare;
mod config;
mod diff;
mod diversity;
mod draw;
mod export;
mod hands;
mod hands_can;
mod import;
mod input;
mod inspect;
mod interruption;
mod join;
mod judge;
mod label;
mod manuals;
mod object_inspect;
mod objects;
mod output;
mod printing;
mod progress;
mod provenance;
mod rates;
mod report;
mod route;
mod run;
mod stability;
mod surface;
mod survey;
mod synth;
mod text;
mod thermodynamics;

use args::Common;
use printing::{OURS, complain, explain, note_failure, sentence, take_failure};
use provenance::Provenance;
pub use run::Watch;

/// Shows how diverse a population of grasps really is: synthesizes grasps by differentiable force closure and maps the
/// energy landscape between them.
#[derive(Debug, Parser)]
#[command(name = "landscape", version, propagate_version = true, arg_required_else_help = true, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Synthesize grasps of a hand on an object
    #[command(after_help = synth::EXAMPLES)]
    Synth(synth::Synth),
    /// Map the energy landscape between the grasps of a file
    #[command(after_help = build::EXAMPLES)]
    Build(build::Build),
    /// Judge the grasps of a file, or contacts without a hand
    #[command(after_help = inspect::EXAMPLES)]
    Inspect(inspect::Inspect),
    /// List the built-in hands, or show the derived properties of your own hand
    Hands(hands::Hands),
    /// Simulate the grasps of a file in a physics engine: does the object stay in the hand?
    #[command(after_help = stability::EXAMPLES)]
    Stability(stability::Stability),
    /// Label the grasps of a file with types of the GRASP taxonomy, by a rule or by hand
    #[command(after_help = label::EXAMPLES)]
    Label(label::LabelCommand),
    /// Put several files of grasps together, with their hands, objects and provenance
    #[command(after_help = join::EXAMPLES)]
    Join(join::Join),
    /// List the built-in objects, show the derived properties of your own object, or make an object from a neural network
    Objects(objects::Objects),
    /// Find all minima and saddles of a model surface, or of your own energy
    #[command(after_help = surface::examples())]
    Surface(surface::Surface),
    /// Write a page (HTML) on which a landscape, two landscapes or the grasps of a file are explored
    #[command(after_help = report::EXAMPLES)]
    Report(report::Report),
    /// Draw a finished landscape again, with fewer minima or levels, or with other colours
    #[command(after_help = draw::EXAMPLES)]
    Draw(draw::Draw),
    /// Test statistically how a landscape agrees with the taxonomy of grasps
    #[command(after_help = compare::EXAMPLES)]
    Compare(compare::Compare),
    /// Show the differences between two landscapes
    #[command(after_help = diff::EXAMPLES)]
    Diff(diff::Diff),
    /// Show which of several sets of grasps is more diverse
    #[command(after_help = diversity::EXAMPLES)]
    Diversity(diversity::Diversity),
    /// Judge sets of grasps by the tests and measures of several publications
    #[command(after_help = judge::examples())]
    Judge(judge::Judge),
    /// Map all grasps of a data set, and show what its objects cover, share and lack
    #[command(after_help = survey::EXAMPLES)]
    Survey(survey::Survey),
    /// Compute heat capacity, occupation of minima and free energies of a landscape against temperature
    #[command(after_help = thermodynamics::EXAMPLES)]
    Thermodynamics(thermodynamics::Thermodynamics),
    /// Compute rates, first-passage times and the fastest pathways between two sets of minima
    #[command(after_help = rates::EXAMPLES)]
    Rates(rates::Rates),
    /// Show the lowest way between two minima of a landscape, and whether a hand can go it
    #[command(after_help = route::EXAMPLES)]
    Route(route::Route),
    /// Print the settings of a command, with comments, as a file for its flag `--config`
    #[command(after_help = config::EXAMPLES)]
    Config(config::Config),
    /// Read grasps of other programs, or min.data and ts.data of PATHSAMPLE or topsearch
    #[command(after_help = import::EXAMPLES)]
    Import(import::Import),
    /// Write grasps for other programs: tables, DexGraspNet, MuJoCo, glTF scenes
    #[command(after_help = export::EXAMPLES)]
    Export(export::Export),
    /// Show where fields and cut objects are kept between runs, or remove them
    #[command(after_help = cache::EXAMPLES)]
    Cache(cache::CacheOf),
    /// Print the script with which a shell completes this command line
    #[command(after_help = manuals::COMPLETIONS)]
    Completions(manuals::Completions),
    /// Write a manual page for each command
    #[command(after_help = manuals::MAN)]
    Man(manuals::Man),
}

const EXAMPLES: &str = "\
Examples:
  landscape synth --object bottle_round -n 64              grasps.parquet: grasps of the human hand on a bottle
  landscape build grasps.parquet                           grasps.landscape/: the landscape between them
  landscape inspect grasps.parquet                         the quality of these grasps
  landscape stability grasps.parquet                       grasps.stability.parquet: which grasps hold in simulation
  landscape label grasps.parquet                           grasps.labelled.parquet: the types of these grasps
  landscape surface lj 7                                   lj-7.landscape/: all minima and saddles of a model
  landscape report grasps.landscape --open                 grasps.report.html: explore it in a browser
  landscape draw grasps.landscape --lowest 50              grasps.view/: the same pictures of its 50 lowest minima
  landscape diff warm.landscape cold.landscape             the minima and merges that moved
  landscape diversity one.parquet other.parquet            which of the two sets of grasps is more diverse
  landscape judge mine.parquet theirs.parquet              published tests and measures of both sets, side by side
  landscape survey grasps/                                 grasps.survey/: what the files of a whole data set cover

A landscape consists of the local minima of the energy and of the barriers between them; docs/glossary.md explains the
terms. `landscape help synth`, `landscape help build` and so on describe the commands.";

/// Runs the command line of this process.
pub fn run() -> ExitCode {
    ExitCode::from(run_process(std::env::args_os()))
}

/// Runs a command line, which begins with the program name, as that of this process: an interruption ends the process.
/// Returns its exit code.
pub fn run_process(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> u8 {
    interruption::watch();
    status(arguments)
}

/// Runs a command line, which begins with the program name.
pub fn run_with(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
    ExitCode::from(status(arguments))
}

/// The sentence with which the command line ends that [`call`] was given, if it fails.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{sentence}")]
pub struct CallError {
    /// The sentence, without `error:`.
    pub sentence: String,
    /// The kind of the error of the operating system, if there was one.
    pub kind: Option<io::ErrorKind>,
}

/// Refuses an output file as every command does: its folder is missing, or (without `force`) it exists and was not made by
/// this program as a file of its kind.
///
/// # Errors
/// The sentence that a command line would end with.
pub fn check_output(path: &std::path::Path, force: bool) -> Result<(), CallError> {
    output::check_file(path, &[], force).map_err(|error| CallError {
        sentence: printing::shown(&sentence(&error)),
        kind: None,
    })
}

/// Ends one [`call`] from another thread, even before the call's turn.
#[derive(Debug, Default)]
pub struct Stop(Mutex<Turn>);

/// Where a call stands.
#[derive(Debug, Default)]
struct Turn {
    running: bool,
    stopped: bool,
}

impl Stop {
    /// Asks the call to end after the tasks that it works on. Finished tasks are kept.
    pub fn stop(&self) {
        let mut turn = self.turn();
        turn.stopped = true;
        if turn.running {
            interruption::set_stopped(true);
        }
    }

    fn turn(&self) -> MutexGuard<'_, Turn> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The turn of the call, which ends with what is returned, even by a panic.
    fn turn_of(&self, bars: bool) -> impl Drop + '_ {
        struct Running<'a>(&'a Stop);
        impl Drop for Running<'_> {
            fn drop(&mut self) {
                progress::want_bars(false);
                self.0.set_running(false);
            }
        }
        self.set_running(true);
        progress::want_bars(bars);
        Running(self)
    }

    /// Begins or ends the turn of the call.
    fn set_running(&self, running: bool) {
        let mut turn = self.turn();
        turn.running = running;
        interruption::set_stopped(running && turn.stopped);
    }
}

/// Runs a command line, which begins with the program name, for a caller inside this process: returns what would go to
/// standard output. Calls from several threads run one after the other; `stop` ends this one. With `bars`, progress is shown
/// even by `--quiet`.
///
/// # Errors
/// The sentence that the command line would end with.
pub fn call(
    arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    bars: bool,
    stop: &Stop,
) -> Result<String, CallError> {
    static ONE: Mutex<()> = Mutex::new(());
    let arguments = match parse(arguments) {
        Ok(arguments) => arguments,
        // The version, or help that was asked for.
        Err(told) if !told.use_stderr() => return Ok(told.render().to_string()),
        Err(error) => {
            return Err(CallError {
                sentence: error.to_string().trim_end().to_owned(),
                kind: None,
            });
        }
    };
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let _turn = stop.turn_of(bars);
    let (result, text) = printing::taking(|| {
        interruption::check()?;
        printing::begin(&arguments.common);
        arguments.common.on_threads(|| dispatch(&arguments))
    });
    match result {
        Ok(()) => Ok(text),
        Err(error) => Err(CallError {
            sentence: printing::shown(&sentence(&error)),
            kind: (error.chain())
                .find_map(|cause| cause.downcast_ref::<io::Error>())
                .map(io::Error::kind),
        }),
    }
}

fn status(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> u8 {
    let arguments = match parse(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            // Coloured, unless the text quotes control sequences.
            let text = error.render().to_string();
            if matches!(printable(&text, OURS), Cow::Owned(_)) {
                complain(text.trim_end());
                return USAGE;
            }
            let printed = error.print().and_then(|()| io::stdout().flush());
            if error.use_stderr() {
                return USAGE;
            }
            note_failure(printed);
            return end(Ok(()));
        }
    };
    end(execute(&arguments))
}

fn execute(arguments: &Arguments) -> anyhow::Result<()> {
    printing::begin(&arguments.common);
    arguments.common.threads()?;
    dispatch(arguments)
}

fn dispatch(arguments: &Arguments) -> anyhow::Result<()> {
    let common = &arguments.common;
    explain(|| {
        format!(
            "landscape {} on {} threads; files will record this command: {}",
            env!("CARGO_PKG_VERSION"),
            rayon::current_num_threads(),
            common.provenance.command
        )
    });
    match &arguments.command {
        Command::Synth(command) => synth::run(command, common),
        Command::Build(command) => build::run(command, common),
        Command::Inspect(command) => inspect::run(command, common),
        Command::Hands(command) => hands::run(&command.command, common),
        Command::Stability(command) => stability::run(command, common),
        Command::Label(command) => label::run(command, common),
        Command::Join(command) => join::run(command, common),
        Command::Objects(command) => objects::run(&command.command, common),
        Command::Surface(command) => surface::run(command, common),
        Command::Report(command) => report::run(command, common),
        Command::Draw(command) => draw::run(command, common),
        Command::Compare(command) => compare::run(command, common),
        Command::Diff(command) => diff::run(command, common),
        Command::Route(command) => route::run(command, common),
        Command::Diversity(command) => diversity::run(command, common),
        Command::Judge(command) => judge::run(command, common),
        Command::Survey(command) => survey::run(command, common),
        Command::Thermodynamics(command) => thermodynamics::run(command, common),
        Command::Rates(command) => rates::run(command, common),
        Command::Config(command) => config::run(command, common),
        Command::Import(command) => import::run(command, common),
        Command::Export(command) => export::run(command, common),
        Command::Cache(command) => cache::run(command, common),
        Command::Completions(command) => manuals::completions(command, definition(), common),
        Command::Man(command) => manuals::man(command, &definition(), common),
    }
}

/// Exit code of a failed command.
const FAILURE: u8 = 1;

/// Exit code of a command line that cannot be read: unknown flags, missing arguments, values of the wrong kind.
const USAGE: u8 = 2;

/// Exit code after the reader closed the pipe, as for SIGPIPE.
const PIPE_CLOSED: u8 = 141;

/// Prints the error, if any, and returns the exit code.
fn end(result: anyhow::Result<()>) -> u8 {
    let error = match (result, take_failure()) {
        (Ok(()), None) => return 0,
        (Err(error), _) => error,
        // If the reader closed the pipe, it has read enough.
        (Ok(()), Some(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            return PIPE_CLOSED;
        }
        (Ok(()), Some(error)) => {
            anyhow::Error::new(error).context("cannot write to standard output")
        }
    };
    complain(&format!("error: {}", sentence(&error)));
    FAILURE
}

/// The definition of the command line: its subcommands, arguments and flags.
pub fn definition() -> clap::Command {
    let mut definition = Arguments::command();
    definition.build();
    definition
}

fn parse(
    arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>,
) -> Result<Arguments, clap::Error> {
    let mut definition = definition();
    let matches = definition.try_get_matches_from_mut(arguments)?;
    let mut parsed =
        Arguments::from_arg_matches(&matches).map_err(|error| error.format(&mut definition))?;
    parsed.common.provenance = Provenance::of(&definition, &matches);
    Ok(parsed)
}
