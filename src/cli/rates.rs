//! `landscape rates`: rates between two sets of minima.

use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;

use anyhow::{Context, bail, ensure};
use clap::Args;

use super::args::{Common, FamilyBarrier};
use super::output::{Report, check_report, write_report};
use super::run::Watch;
use super::thermodynamics::check_temperature;
use crate::printable::numbered;
use crate::study::{Kinetics, KineticsSettings, NetworkOfStates};
use crate::thermal::Dynamics;

/// Rates between minima.
#[derive(Debug, Args)]
pub(super) struct Rates {
    /// A landscape with curvatures (of `landscape surface`, `build` or `import`), or a folder with min.data and ts.data.
    #[arg(value_name = "FOLDER")]
    landscape: PathBuf,
    /// Where to start: minima (m3) and families (g1), named as in the tree, or a file such as min.A or min.B of PATHSAMPLE.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', required = true)]
    from: Vec<String>,
    /// Where to arrive, likewise.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', required = true)]
    to: Vec<String>,
    /// Temperatures kT, in units of the energy.
    #[arg(
        long,
        value_name = "T,...",
        value_delimiter = ',',
        required = true,
        allow_negative_numbers = true
    )]
    temperature: Vec<f64>,
    /// Friction γ in units of 1/time, for Kramers rates; without it, transition-state theory. Friction needs the
    /// negative curvatures of saddles, which landscapes of `landscape surface` hold and min.data and ts.data do not.
    #[arg(long, value_name = "GAMMA", allow_negative_numbers = true)]
    friction: Option<f64>,
    /// Number of pathways to list, fastest first.
    #[arg(long, value_name = "N", default_value_t = 5)]
    pathways: usize,
    /// Write NAME.md, NAME.json, and an Arrhenius plot NAME.svg and NAME.png.
    #[arg(long, short, value_name = "NAME")]
    output: Option<PathBuf>,
    /// Leave out minima whose curvatures are unknown, such as those on a face of a box, where they are not harmonic wells, and
    /// the saddles that lead to them. A note gives their number and their energies.
    #[arg(long)]
    without_faces: bool,
    #[command(flatten)]
    families: FamilyBarrier,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape rates lj-7.landscape --from m1 --to m0 --temperature 0.05,0.1,0.2
  landscape rates lj-13.landscape --from g1 --to g0 --temperature 0.2 --pathways 10
  landscape rates lj-7.landscape --from m1 --to m0 --temperature 0.1 --friction 10
  landscape rates pathsample/ --from m12,m15 --to m0 --temperature 0.5 -o folding
  landscape rates pathsample/ --from pathsample/min.B --to pathsample/min.A --temperature 0.5

Rates over single transition states follow from energies, curvatures and point groups (harmonic transition-state theory, or
Kramers with --friction). Rates between sets of minima, mean first-passage times and committors follow by eliminating all
other minima one by one (graph transformation), in logarithms, so that they are exact however slow the process is.
Temperatures are kT in units of the energy; times are in units of √(mass · length² / energy).

Minima are named as in the tree: m0 is the lowest. g1 stands for all minima of a family. A file lists minima as PATHSAMPLE
does: first how many, then their numbers, counted from 1 in the order of min.data of the folder. The answer shows these
numbers, too.";

/// Greatest number of pathways.
const MOST: usize = 10_000;

pub(super) fn run(command: &Rates, common: &Common) -> anyhow::Result<()> {
    command.families.checked()?;
    for temperature in &command.temperature {
        check_temperature("--temperature", *temperature)?;
    }
    let dynamics = match command.friction {
        None => Dynamics::TransitionState,
        Some(friction) => {
            ensure!(
                friction >= 0.0 && friction.is_finite(),
                "--friction {friction}: a rate is needed, 0 or more"
            );
            Dynamics::Kramers { friction }
        }
    };
    ensure!(
        command.pathways <= MOST,
        "--pathways {}: at most {MOST} are listed",
        command.pathways
    );
    if let Some(output) = &command.output {
        check_report(output, &[], &[&command.landscape], common.force)?;
    }
    let mut states = NetworkOfStates::open(&command.landscape, &command.families.settings())?;
    if command.without_faces {
        states = states.without_faces();
    }
    let [from, to] = [("--from", &command.from), ("--to", &command.to)]
        .map(|(flag, names)| chosen(flag, names, &states));
    let (from, to) = (from?, to?);
    if let Some(both) = from.iter().find(|minimum| to.contains(minimum)) {
        bail!("m{} is both in --from and in --to", states.numbers[*both]);
    }
    let settings = KineticsSettings {
        temperatures: command.temperature.clone(),
        dynamics,
        pathways: command.pathways,
    };
    let watch = Watch::new(common.quiet);
    let found = Kinetics::new(&states, (&from, &to), &settings, &|news| watch.see(news))?;
    watch.lap("eliminate", 0);
    let report = Report {
        text: found.markdown(),
        value: found.to_json(),
        chart: Some(found.chart()),
        tables: Vec::new(),
    };
    write_report(command.output.as_deref(), report, common)
}

/// The places of the minima that the names choose, ascending, each once. Of families and files, those that were left out do not
/// count.
fn chosen(flag: &str, names: &[String], states: &NetworkOfStates) -> anyhow::Result<Vec<usize>> {
    let (count, families) = (states.rows.len(), &states.families);
    let mut chosen = Vec::new();
    for name in names {
        let name = name.trim();
        let number = |prefix: char| name.strip_prefix(prefix)?.parse::<usize>().ok();
        let listed: Vec<usize> = if let Some(family) = number('g') {
            let Some(members) = families.members.get(family) else {
                bail!(
                    "{flag} {name}: {}",
                    numbered(families.members.len(), "family", 'g')
                );
            };
            members.iter().map(|minimum| minimum.0).collect()
        } else if let Some(minimum) = number('m') {
            ensure!(
                minimum < count,
                "{flag} {name}: {}",
                numbered(count, "minimum", 'm')
            );
            vec![minimum]
        } else {
            let read = match fs::read(name) {
                Ok(read) => read,
                Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                    "{flag} {name}: no such file; write minima and families as the tree names them, such as m0,m3,g1"
                ),
                Err(error) => return Err(error).context(format!("{flag} {name}")),
            };
            let text = str::from_utf8(&read).ok().with_context(|| {
                format!(
                    "{flag} {name}: not a text file; a list of minima such as min.A of PATHSAMPLE is needed"
                )
            })?;
            let listed = states.minima_of(text);
            listed.with_context(|| format!("{flag} {name}"))?
        };
        let before = chosen.len();
        chosen.extend(
            listed
                .into_iter()
                .filter_map(|minimum| states.place_of(minimum)),
        );
        ensure!(
            chosen.len() > before,
            "{flag} {name}: its curvatures are unknown, so --without-faces leaves it out; name other minima"
        );
    }
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}
