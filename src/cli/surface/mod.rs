//! `landscape surface`: every minimum and saddle of a model, or of an energy that another program computes.

mod program;
mod report;

use std::path::PathBuf;

use anyhow::{Context, bail, ensure};
use clap::ValueEnum;
use program::{Region, command_hash, region};
use report::{KINKS, Report, fates, kinks, spell};

pub(super) use program::space;

use super::args::{Common, Surface};
use super::input::within;
use super::landscape::{Input, Mapped};
use super::output::check_place;
use super::run::{DiskJournal, Unfinished, Watch, check_resumable, until_unwritable};
use super::uncertainty::Unseen;
use super::{complain, print};
use crate::energy::{Counted, Energy, model};
use crate::limits::SEARCHES;
use crate::store::{Source, StationaryRow, content_hash};
use crate::topography::exchange::Database;
use crate::topography::{self, GroupSettings, SearchSettings, explore, in_box};

/// What is to be mapped.
struct Subject<'a> {
    name: &'a str,
    energy: &'a dyn Energy,
    /// What its coordinates are, as `--coordinates` names it.
    coordinates: String,
    /// Where random starts are drawn.
    low: Vec<f64>,
    high: Vec<f64>,
    /// What made the energy: the model, or the program and the files its command names.
    source: Source,
    /// What went wrong with the energy, if anything did.
    check: &'a (dyn Fn() -> anyhow::Result<()> + Sync),
}

pub(super) fn run(command: &Surface, common: &Common) -> anyhow::Result<()> {
    for (flag, value) in [
        ("patience", command.patience),
        ("searches", command.searches),
    ] {
        if let Some(value) = value {
            within(&format!("--{flag}"), SEARCHES, value as f64)?;
        }
    }
    command.groups.checked()?;
    if let Some(output) = &command.output {
        check_place(output)?;
    }
    let region = command.region.as_deref().map(region).transpose()?;
    match &command.command {
        None => run_model(command, common, region),
        Some(program) => {
            let region = region.context("--command needs --region")?;
            run_program(command, common, program, region)
        }
    }
}

fn run_model(command: &Surface, common: &Common, region: Option<Region>) -> anyhow::Result<()> {
    let surface = model::named(&command.model)?;
    let needed = surface.low.len();
    let (low, high) = region.unwrap_or((surface.low, surface.high));
    ensure!(
        low.len() == needed,
        "--region: `{}` has {needed} coordinates, not {}",
        surface.name,
        low.len()
    );
    let subject = Subject {
        name: &surface.name,
        energy: &*surface.energy,
        coordinates: surface.coordinates.to_owned(),
        low,
        high,
        source: Source {
            name: surface.name.clone(),
            content_hash: content_hash(&[surface.name.as_bytes()]),
        },
        check: &|| Ok(()),
    };
    until_unwritable(|| map(command, common, &subject))?
}

fn run_program(
    command: &Surface,
    common: &Common,
    program: &str,
    (low, high): Region,
) -> anyhow::Result<()> {
    let external = program::start(command, program, (&low, &high))?;
    let coordinates = command.coordinates.to_possible_value();
    let coordinates = coordinates.map_or_else(String::new, |value| value.get_name().to_owned());
    let subject = Subject {
        name: program,
        energy: &external,
        coordinates,
        low,
        high,
        source: Source {
            name: program.to_owned(),
            content_hash: command_hash(program),
        },
        check: &|| program::check(&external),
    };
    until_unwritable(|| map(command, common, &subject))?
}

/// Searches the surface and writes its folder.
fn map(command: &Surface, common: &Common, subject: &Subject<'_>) -> anyhow::Result<()> {
    let draw = in_box(&subject.low, &subject.high);
    let measuring = Counted::new(subject.energy);
    let mut settings = SearchSettings::measured(&measuring, &draw, command.seed);
    (subject.check)()?;
    settings.patience = command.patience.unwrap_or(settings.patience);
    settings.max_searches = command.searches.unwrap_or(settings.max_searches);
    settings.paths = command.paths.into();

    let output = match &command.output {
        Some(output) => output.clone(),
        None => PathBuf::from(format!("{}.landscape", file_name(subject.name))),
    };
    let fingerprint = content_hash(&[
        subject.source.content_hash.as_bytes(),
        subject.coordinates.as_bytes(),
        format!("{:?}", (&subject.low, &subject.high)).as_bytes(),
        serde_json::to_string(&settings)?.as_bytes(),
        env!("CARGO_PKG_VERSION").as_bytes(),
    ]);
    check_resumable(&command.again, std::slice::from_ref(&output))?;
    let unfinished = Unfinished::open(&output, &fingerprint, &command.again, common.quiet)?;
    let folder = &unfinished.folder;
    let journal = Guarded {
        journal: DiskJournal(&unfinished.journal),
        check: subject.check,
    };
    let mut watch = Watch::new(common.quiet);
    let found = explore(subject.energy, &draw, &settings, &journal, &|p| {
        watch.see(p);
    });
    watch.lap("search", found.evaluations);
    (subject.check)()?;
    if found.minima.is_empty() {
        unfinished.discard()?;
        let kinks = match kinks(&found) {
            0 => String::new(),
            kinks => format!("; {kinks} {KINKS}"),
        };
        bail!(
            "{}: {} searches from random points of the region found no minimum ({}){kinks}",
            subject.name,
            found.coverage.searches,
            spell(&fates(&found))
        );
    }
    let groups = GroupSettings {
        barrier: command.groups.group_barrier,
        ..GroupSettings::default()
    };
    let landscape = found.landscape(subject.energy, &groups);
    let report = Report {
        mapped: Mapped {
            landscape: &landscape,
            energy: subject.energy,
            inputs: (0..found.coverage.searches as u64)
                .map(|id| Input { id, label: None })
                .collect(),
            choices_below: f64::INFINITY,
        },
        unseen: Unseen::of(&landscape, "random starts"),
        found: &found,
        subject,
        settings: &settings,
        command: common.provenance.command.clone(),
        measuring: measuring.evaluations(),
    };
    let files = report.tables()?;
    StationaryRow::write(&report.stationary(), folder)?;
    let database = Database::from_exploration(&found, subject.coordinates == "atoms");
    let titles = report.titles();
    report.mapped.draw(&titles, &database, folder)?;
    report.unseen.draw(&titles.title, folder)?;
    // It lists the checksums of all tables, so it comes after them.
    files.write(folder)?;
    let text = super::shown(&report.summary());
    folder.write("summary.md", text.as_bytes())?;
    watch.lap("write", 0);
    watch.timings().write(folder)?;
    let finished = unfinished.finish()?;
    if !common.quiet {
        print(&text);
        complain(&format!("wrote {}", finished.display()));
    }
    Ok(())
}

/// A journal that takes nothing more once the energy failed: what was found since is worth nothing.
struct Guarded<'a> {
    journal: DiskJournal<'a>,
    check: &'a (dyn Fn() -> anyhow::Result<()> + Sync),
}

impl topography::Journal for Guarded<'_> {
    fn get(&self, key: &str) -> Option<Vec<u8>> {
        self.journal.get(key)
    }

    fn put(&self, key: &str, record: &[u8]) {
        if (self.check)().is_ok() {
            self.journal.put(key, record);
        }
    }
}

/// A file name made of a name.
fn file_name(name: &str) -> String {
    let parts = name.split(|c: char| !c.is_alphanumeric() && c != '.');
    let parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
    parts.join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_file_names() {
        assert_eq!(file_name("lj 7"), "lj-7");
        assert_eq!(
            file_name("python3 ./a b/my_energy.py"),
            "python3-.-a-b-my-energy.py"
        );
    }
}
