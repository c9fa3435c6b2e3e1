//! The minimax path between two minima of a landscape, as pictures with the energy by term, and as an animation.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use serde_json::json;

use super::{Inspect, number, table};
use crate::cli::args::{Common, within};
use crate::cli::input::open_landscape;
use crate::cli::output::{check_file, is_scene};
use crate::cli::printing::{complain, print, print_json};
use crate::grasp::GraspEnergy;
use crate::limits::PICTURES;
use crate::printable::numbered;
use crate::store::{EdgeRow, FileSet, LandscapeFiles};
use crate::study::{GraspSetting, MinimaxPath, Waypoint};
use crate::topography::MinimumId;

/// Endings of the files of a path.
const ENDINGS: [&str; 3] = ["png", "svg", "glb"];

pub(super) fn run(command: &Inspect, ends: &[String], common: &Common) -> anyhow::Result<()> {
    let folder = &command.file;
    let name = folder.display().to_string();
    let files = open_landscape(folder)?;
    let [from, to] = [&ends[0], &ends[1]].map(|end| minimum(&files, end));
    let (from, to) = (from?, to?);
    ensure!(
        from != to,
        "--path {} {}: both names mean the same minimum",
        ends[0],
        ends[1]
    );
    within("--pictures", PICTURES, command.pictures as f64)?;
    let output = match &command.output {
        Some(output) => output.clone(),
        None => beside(folder, from, to)?,
    };
    for ending in ENDINGS {
        check_file(&with_ending(&output, ending), &[folder], common.force)?;
    }
    let setting = GraspSetting::of(&files, &name)?;
    let energy = setting.energy(&files, &name)?;
    let network = files.network(folder)?;
    let path = MinimaxPath::between(&files, &network, energy.pose_space(), [from, to])?
        .with_context(|| format!("no path leads from m{} to m{} in {name}", from.0, to.0))?;
    let path = path.explained(&energy);
    if common.json {
        print_json(&value(&files, &energy, &path))?;
    } else {
        print(&text(&files, &energy, &path));
    }
    let canvas = path.strip(&energy, command.pictures)?;
    let mut outputs = FileSet::default();
    for name in ENDINGS.map(|ending| with_ending(&output, ending)) {
        let bytes = if is_scene(&name) {
            path.animation(&energy)
        } else {
            canvas.encode(&name)?
        };
        outputs.add(&name, &bytes)?;
    }
    outputs.finish()?;
    if !common.quiet {
        complain(&format!("wrote {}.png, .svg and .glb", output.display()));
    }
    Ok(())
}

fn with_ending(output: &Path, ending: &str) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{ending}"));
    output.with_file_name(name)
}

/// The output `NAME.m3-m17` beside the landscape.
fn beside(folder: &Path, from: MinimumId, to: MinimumId) -> anyhow::Result<PathBuf> {
    let stem = folder.file_stem();
    let stem = stem.with_context(|| format!("{} does not name a folder", folder.display()))?;
    let name = format!("{}.m{}-m{}", stem.to_string_lossy(), from.0, to.0);
    Ok(folder.with_file_name(name))
}

/// Parses `m3`, or `g2` for the lowest minimum of a group.
fn minimum(files: &LandscapeFiles, name: &str) -> anyhow::Result<MinimumId> {
    let count = files.minima.len();
    let (kind, number) = name.split_at_checked(1).unwrap_or((name, ""));
    match (kind, number.parse::<usize>()) {
        ("m", Ok(number)) if number < count => Ok(MinimumId(number)),
        ("m", Ok(_)) => bail!("--path {name}: {}", numbered(count, "minimum", 'm')),
        ("g", Ok(number)) => {
            let mut rows = files.minima.iter();
            let place = rows.position(|row| row.group == number as u64);
            let place = place.with_context(|| format!("--path {name}: no such group"))?;
            Ok(MinimumId(place))
        }
        _ => bail!("--path {name}: write minima as the tree names them (m3), or groups (g0)"),
    }
}

fn millimetres(step: &Waypoint) -> f64 {
    1e3 * step.along_m
}

/// Text on the barrier: terms at the start, the top and the end.
fn text(files: &LandscapeFiles, energy: &GraspEnergy, path: &MinimaxPath) -> String {
    let MinimaxPath {
        minima: route,
        points: steps,
    } = path;
    let top = path.top();
    let minima: Vec<String> = route.iter().map(|id| format!("m{}", id.0)).collect();
    let ways = (ways(files, route).into_iter().zip(route.windows(2)))
        .filter_map(|(way, ends)| Some(format!("m{} → m{} {}", ends[0].0, ends[1].0, way?)));
    let ways: Vec<String> = ways.collect();
    let ways = if ways.is_empty() {
        String::new()
    } else {
        format!("what it is: {}\n", ways.join(", "))
    };
    let groups: Vec<String> = route
        .iter()
        .map(|id| format!("g{}", files.minima[id.0].group))
        .collect();
    let mut rows = vec![
        ["", "start", "top", "end", "top above the higher end"]
            .map(str::to_owned)
            .to_vec(),
    ];
    let (first, last) = (0, steps.len() - 1);
    let higher = if steps[first].point.energy > steps[last].point.energy {
        first
    } else {
        last
    };
    let mut row = |name: &str, of: &dyn Fn(&Waypoint) -> f64| {
        let mut cells = vec![name.to_owned()];
        cells.extend([first, top, last].map(|place| number(of(&steps[place]))));
        cells.push(number(of(&steps[top]) - of(&steps[higher])));
        rows.push(cells);
    };
    row("energy", &|step| step.point.energy);
    for (term, name) in energy.term_names().iter().enumerate() {
        row(&format!("  {name}"), &|step| step.terms()[term]);
    }
    format!(
        "lowest way found: {} (groups {})\n{ways}{} points, {:.1} mm; the top is after {:.1} mm\n\n{}",
        minima.join(" → "),
        groups.join(" → "),
        steps.len(),
        millimetres(&steps[last]),
        millimetres(&steps[top]),
        table(&rows)
    )
}

/// What each connection of a route is, if the landscape tells.
fn ways<'f>(files: &'f LandscapeFiles, route: &[MinimumId]) -> Vec<Option<&'f str>> {
    let way = |ends: &[MinimumId]| {
        let (a, b) = (ends[0].0 as u64, ends[1].0 as u64);
        let known = |edge: &&EdgeRow| (edge.a, edge.b) == (a.min(b), a.max(b));
        files.edges.iter().find(known)?.way.as_deref()
    };
    route.windows(2).map(way).collect()
}

fn value(files: &LandscapeFiles, energy: &GraspEnergy, path: &MinimaxPath) -> serde_json::Value {
    let MinimaxPath {
        minima: route,
        points: steps,
    } = path;
    let steps: Vec<serde_json::Value> = steps
        .iter()
        .map(|step| {
            json!({
                "place_m": step.along_m,
                "energy": step.point.energy,
                "terms": step.terms(),
                "contacts": step.contacts,
                "coordinates": step.point.coordinates,
            })
        })
        .collect();
    let ways = ways(files, route);
    let minima: Vec<usize> = route.iter().map(|id| id.0).collect();
    let mut value = json!({ "minima": minima, "terms": energy.term_names(), "points": steps });
    if ways.iter().any(Option::is_some) {
        value["ways"] = json!(ways);
    }
    value
}
