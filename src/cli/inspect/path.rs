//! The minimax path between two minima of a landscape, as pictures with the energy by term, and as an animation.

use anyhow::{Context, bail, ensure};
use serde_json::{Value, json};

use super::Inspect;
use crate::cli::args::{Common, within};
use crate::cli::input::open_landscape;
use crate::cli::output::{check_file, given_or_beside, is_scene, with_ending};
use crate::cli::printing::{complain, print_json, tell};
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
    let ending = format!("m{}-m{}", from.0, to.0);
    let output = given_or_beside(command.output.as_ref(), folder, &ending)?;
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
        tell(common, &barrier(&files, &energy, &path))?;
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

/// Parses `m3`, or `g2` for the lowest minimum of a family.
fn minimum(files: &LandscapeFiles, name: &str) -> anyhow::Result<MinimumId> {
    let count = files.minima.len();
    let (kind, number) = name.split_at_checked(1).unwrap_or((name, ""));
    match (kind, number.parse::<usize>()) {
        ("m", Ok(number)) if number < count => Ok(MinimumId(number)),
        ("m", Ok(_)) => bail!("--path {name}: {}", numbered(count, "minimum", 'm')),
        ("g", Ok(number)) => {
            let mut rows = files.minima.iter();
            let place = rows.position(|row| row.family == number as u64);
            let place = place.with_context(|| format!("--path {name}: no such family"))?;
            Ok(MinimumId(place))
        }
        _ => bail!("--path {name}: write minima as the tree names them (m3), or families (g0)"),
    }
}

/// The barrier: terms at the start, the top and the end of the path.
fn barrier(files: &LandscapeFiles, energy: &GraspEnergy, path: &MinimaxPath) -> Value {
    let steps = &path.points;
    let ends = [&steps[0], &steps[steps.len() - 1]];
    let top = &steps[path.top()];
    let higher = ends[usize::from(ends[1].point.energy >= ends[0].point.energy)];
    let row = |name: &str, of: &dyn Fn(&Waypoint) -> f64| {
        json!({
            "term": name.replace('_', " "),
            "start": of(ends[0]),
            "top": of(top),
            "end": of(ends[1]),
            "top above the higher end": of(top) - of(higher),
        })
    };
    let mut rows = vec![row("energy", &|step| step.point.energy)];
    for (term, name) in energy.term_names().iter().enumerate() {
        rows.push(row(name, &|step| step.terms()[term]));
    }
    let named = |id: &MinimumId| format!("m{} (g{})", id.0, files.minima[id.0].family);
    let route: Vec<String> = path.minima.iter().map(named).collect();
    json!({
        "lowest_way_found": route.join(" → "),
        "what_it_is": ways(files, &path.minima).into_iter().flatten().collect::<Vec<_>>(),
        "length_m": ends[1].along_m,
        "highest_point_after_m": top.along_m,
        "energy along it": rows,
    })
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

fn value(files: &LandscapeFiles, energy: &GraspEnergy, path: &MinimaxPath) -> Value {
    let MinimaxPath {
        minima: route,
        points: steps,
    } = path;
    let steps: Vec<Value> = steps
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
