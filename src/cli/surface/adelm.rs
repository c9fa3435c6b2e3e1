//! `landscape surface --search adelm`: the minima below random points, joined by attraction–diffusion alone.

use anyhow::ensure;

use super::{Check, Coordinates, Sought, Surface, Work, output_of};
use crate::cli::args::Common;
use crate::sample::{Task, stream};
use crate::store::content_hash;
use crate::study::{MapSearch, SurfaceConfiguration, SurfaceMapReport, in_region, map_surface};
use crate::topography::MapSettings;

/// Random points from which descents begin, if `--searches` does not say how many.
const POINTS: usize = 200;

pub(super) fn map(
    command: &Surface,
    common: &Common,
    configuration: &SurfaceConfiguration,
    sought: &Sought<'_>,
    check: &Check<'_>,
) -> anyhow::Result<()> {
    ensure!(
        command.coordinates != Coordinates::Box,
        "--search adelm: chains are not confined to a box; search there without it"
    );
    let given = [
        (command.patience.is_some(), "--patience"),
        (command.config.is_some(), "--config"),
        (
            command.families.family_barrier.is_some(),
            "--family-barrier",
        ),
        (command.connect.is_some(), "--connect"),
    ];
    let unused = given
        .into_iter()
        .find_map(|(given, flag)| given.then_some(flag));
    if let Some(flag) = command.extent.not_of_adelm().or(unused) {
        anyhow::bail!(
            "{flag} has no effect on attraction–diffusion alone: leave out {flag} or `--search adelm`"
        );
    }
    let subject = sought.shown;
    let (mut starts, known_hash) = command.extent.known(subject.low.len())?;
    sought.fit(&mut starts)?;
    let seed = command.seed.or(configuration.seed()).unwrap_or(0);
    let draw = in_region(subject.energy.space(), (&subject.low, &subject.high));
    let count = command.searches.unwrap_or(POINTS);
    starts.extend((0..count as u64).map(|id| draw(&mut stream(seed, Task::Start, id))));

    let work = Work {
        output: output_of(command, subject),
        fingerprint: content_hash(&[
            b"adelm",
            subject.source.content_hash.as_bytes(),
            subject.coordinates.as_bytes(),
            format!("{:?}", (&subject.low, &subject.high, count, seed)).as_bytes(),
            known_hash.as_bytes(),
            env!("CARGO_PKG_VERSION").as_bytes(),
        ]),
        enough: &|_| false,
        check,
    };
    let seeded = |settings: &mut MapSettings| settings.seed = seed;
    let (name, energy) = (subject.name, subject.energy);
    let (found, begun) = work.run(command, common, |run| {
        map_surface(name, energy, &starts, MapSearch::Adelm, seeded, run)
    })?;
    let report = SurfaceMapReport {
        subject,
        found: &found,
        command: common.provenance.command.clone(),
    };
    let written = report.write(&begun.unfinished.folder)?;
    begun.conclude(command, common, written, &found.landscape.attempts.list)
}
