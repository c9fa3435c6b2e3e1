//! `landscape route`: the lowest way between two minima of a landscape, edge by edge.

use std::path::PathBuf;

use anyhow::{Context, bail, ensure};
use clap::Args;
use serde_json::{Value, json};

use super::args::Common;
use super::input::open_landscape;
use super::printing::tell;
use crate::figure::MAKER;
use crate::printable::numbered;
use crate::store::{EdgeRow, LandscapeFiles};
use crate::study::Drives;
use crate::topography::{MinimumId, minimax_path};

/// The lowest way between two minima.
#[derive(Debug, Args)]
pub(super) struct Route {
    /// The landscape: a folder of `landscape build`.
    #[arg(value_name = "FOLDER")]
    landscape: PathBuf,
    /// The minimum to start from, named as in the tree: m3.
    #[arg(value_name = "FROM")]
    from: String,
    /// The minimum to arrive at.
    #[arg(value_name = "TO")]
    to: String,
    /// Drive each edge in simulation under four conditions, and show how often the object followed (seconds for each edge).
    #[arg(long)]
    drive: bool,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape route grasps.landscape m3 m17                  the edges of the lowest way from m3 to m17, and their heights
  landscape route grasps.landscape m3 m17 --drive          how often a simulated hand takes the object along each of them

The lowest way has the lowest highest point of all ways in the landscape. Heights are energies, and a barrier is the height above
the higher end of an edge. docs/roadmap.md describes how ways are driven.";

pub(super) fn run(command: &Route, common: &Common) -> anyhow::Result<()> {
    let files = open_landscape(&command.landscape)?;
    let name = command.landscape.display().to_string();
    let ends = [&command.from, &command.to].map(|end| minimum(end, files.minima.len()));
    let [from, to] = ends;
    let (from, to) = (from?, to?);
    ensure!(
        from != to,
        "{} and {} are the same minimum: name two",
        command.from,
        command.to
    );
    let network = files.network(&command.landscape)?;
    let route = minimax_path(&network, from, to)
        .with_context(|| format!("no way leads from m{} to m{} in {name}", from.0, to.0))?;
    let drives = command
        .drive
        .then(|| Drives::of(&files, &name))
        .transpose()?;
    let edges: anyhow::Result<Vec<Value>> = route
        .windows(2)
        .map(|pair| edge(&files, [pair[0], pair[1]], drives.as_ref()))
        .collect();
    let edges = edges?;
    let heights = edges.iter().filter_map(|edge| edge["height"].as_f64());
    let minima: Vec<String> = route.iter().map(|id| format!("m{}", id.0)).collect();
    tell(
        common,
        &json!({
            "made_by": MAKER,
            "minima": minima,
            "height": heights.max_by(f64::total_cmp),
            "edges": edges,
        }),
    )
}

fn minimum(name: &str, count: usize) -> anyhow::Result<MinimumId> {
    match name.strip_prefix('m').map(str::parse) {
        Some(Ok(number)) if number < count => Ok(MinimumId(number)),
        Some(Ok(_)) => bail!("{name}: {}", numbered(count, "minimum", 'm')),
        _ => bail!("{name}: write minima as the tree names them, such as m0 or m17"),
    }
}

fn edge(
    files: &LandscapeFiles,
    ends: [MinimumId; 2],
    drives: Option<&Drives<'_>>,
) -> anyhow::Result<Value> {
    let [a, b] = ends.map(|end| end.0 as u64);
    let known = |edge: &&EdgeRow| [[a, b], [b, a]].contains(&[edge.a, edge.b]);
    let row = files.edges.iter().filter(known);
    let height = |edge: &EdgeRow| edge.height.unwrap_or(f64::INFINITY);
    let row = row.min_by(|one, other| height(one).total_cmp(&height(other)));
    let row = row.context("the landscape lacks an edge of its own network: build it again")?;
    let success = drives.map(|drives| drives.success(ends)).transpose()?;
    Ok(json!({
        "from": format!("m{a}"),
        "to": format!("m{b}"),
        "height": row.height,
        "barrier": row.relative_barrier,
        "length_m": row.length,
        "way": row.way,
        "succeeded": success.map(|success| success.succeeded),
        "of": success.map(|success| success.of),
    }))
}
