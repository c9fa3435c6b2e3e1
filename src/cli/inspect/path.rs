//! The lowest way between two minima of a landscape: as pictures with the energy by term along it, and as an animation.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use nalgebra::Vector3;
use rayon::prelude::*;
use serde_json::json;

use super::{Inspect, number, table};
use crate::cli::args::Common;
use crate::cli::input::{open_landscape, within};
use crate::cli::output::{check_file, is_scene};
use crate::cli::{complain, print, print_json};
use crate::figure::chart::{Axis, Chart, Mark, Panel, Series};
use crate::figure::{
    Canvas, PICTURE_DENSITY, Picture, Scene, Surface, draw_row, row_height, side_in_row, theme,
};
use crate::grasp::{Grasp, GraspEnergy};
use crate::hand::PosedHand;
use crate::limits::PICTURES;
use crate::store::{FileSet, LandscapeFiles};
use crate::study::{GraspSetting, MinimaxPath, Waypoint};
use crate::topography::MinimumId;

/// Endings of the files of a way.
const ENDINGS: [&str; 3] = ["png", "svg", "glb"];
/// Width of the strip, canvas units.
const WIDTH: u32 = 1600;
/// Terms that never reach this share of the highest one are not drawn.
const LEAST_SHARE: f64 = 0.02;
/// How long the animation takes, seconds a centimetre, and at least.
const SECONDS_PER_CM: f64 = 0.25;
const LEAST_SECONDS: f64 = 3.0;

pub(super) fn run(command: &Inspect, ends: &[String], common: &Common) -> anyhow::Result<()> {
    let folder = &command.file;
    let name = folder.display().to_string();
    let files = open_landscape(folder)?;
    let [from, to] = [&ends[0], &ends[1]].map(|end| minimum(&files, end));
    let (from, to) = (from?, to?);
    ensure!(from != to, "--path {} {}: one minimum", ends[0], ends[1]);
    within("--pictures", PICTURES, command.pictures as f64)?;
    let output = match &command.output {
        Some(output) => output.clone(),
        None => beside(folder, from, to)?,
    };
    for ending in ENDINGS {
        check_file(&with_ending(&output, ending), &[folder], common)?;
    }
    let setting = GraspSetting::of(&files, &name)?;
    let energy = setting.energy(&files, &name)?;
    let network = files.network(folder)?;
    let path = MinimaxPath::between(&files, &network, energy.pose_space(), [from, to])?
        .with_context(|| format!("no way leads from m{} to m{} in {name}", from.0, to.0))?;
    let (points, route) = (path.points.par_iter(), path.minima);
    let steps: Vec<Waypoint> = points.map(|point| point.explained(&energy)).collect();

    let text = text(&files, &energy, &route, &steps);
    if command.json {
        print_json(&value(&energy, &route, &steps))?;
    } else {
        print(&text);
    }
    let canvas = strip(&energy, &steps, command.pictures)?;
    let mut outputs = FileSet::default();
    for path in ENDINGS.map(|ending| with_ending(&output, ending)) {
        let bytes = if is_scene(&path) {
            animation(&energy, &steps)
        } else {
            canvas.encode(&path)?
        };
        outputs.add(&path, &bytes)?;
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

/// `NAME.m3-m17` beside the landscape.
fn beside(folder: &Path, from: MinimumId, to: MinimumId) -> anyhow::Result<PathBuf> {
    let stem = folder.file_stem();
    let stem = stem.with_context(|| format!("{} names no folder", folder.display()))?;
    let name = format!("{}.m{}-m{}", stem.to_string_lossy(), from.0, to.0);
    Ok(folder.with_file_name(name))
}

/// `m3`, or `g2` for the lowest minimum of a group.
fn minimum(files: &LandscapeFiles, name: &str) -> anyhow::Result<MinimumId> {
    let count = files.minima.len();
    let (kind, number) = name.split_at_checked(1).unwrap_or((name, ""));
    match (kind, number.parse::<usize>()) {
        ("m", Ok(number)) if number < count => Ok(MinimumId(number)),
        ("m", Ok(_)) => bail!(
            "--path {name}: there are {count} minima, m0 to m{}",
            count - 1
        ),
        ("g", Ok(number)) => {
            let mut rows = files.minima.iter();
            let place = rows.position(|row| row.group == number as u64);
            let place = place.with_context(|| format!("--path {name}: there is no such group"))?;
            Ok(MinimumId(place))
        }
        _ => bail!("--path {name}: write minima as the tree names them (m3), or groups (g0)"),
    }
}

fn top(steps: &[Waypoint]) -> usize {
    let places = 0..steps.len();
    places
        .max_by(|a, b| steps[*a].point.energy.total_cmp(&steps[*b].point.energy))
        .unwrap_or(0)
}

fn millimetres(step: &Waypoint) -> f64 {
    1e3 * step.along_m
}

/// What the barrier is made of: terms at the start, at the top and at the end.
fn text(
    files: &LandscapeFiles,
    energy: &GraspEnergy,
    route: &[MinimumId],
    steps: &[Waypoint],
) -> String {
    let top = top(steps);
    let minima: Vec<String> = route.iter().map(|id| format!("m{}", id.0)).collect();
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
        "way {} (groups {})\n{} points, {:.1} mm; the top is after {:.1} mm\n\n{}",
        minima.join(" → "),
        groups.join(" → "),
        steps.len(),
        millimetres(&steps[last]),
        millimetres(&steps[top]),
        table(&rows)
    )
}

fn value(energy: &GraspEnergy, route: &[MinimumId], steps: &[Waypoint]) -> serde_json::Value {
    let steps: Vec<serde_json::Value> = steps
        .iter()
        .map(|step| {
            json!({
                "place_m": step.along_m,
                "energy": step.point.energy,
                "terms": step.terms(),
                "contacts": step.point.choice,
                "coordinates": step.point.coordinates,
            })
        })
        .collect();
    let route: Vec<usize> = route.iter().map(|id| id.0).collect();
    json!({ "minima": route, "terms": energy.term_names(), "points": steps })
}

/// Energy by term over the way, and rendered points of it below.
fn strip(energy: &GraspEnergy, steps: &[Waypoint], pictures: usize) -> anyhow::Result<Canvas> {
    let shown = shown(steps, pictures);
    let names = energy.term_names();
    let lines = |of: &dyn Fn(&Waypoint) -> f64| -> Vec<[f64; 2]> {
        steps
            .iter()
            .map(|step| [millimetres(step), of(step)])
            .collect()
    };
    let most = steps
        .iter()
        .map(|step| step.point.energy)
        .fold(0.0, f64::max);
    let mut series: Vec<Series> = shown
        .iter()
        .map(|&place| {
            Series::new(Mark::Vertical(millimetres(&steps[place]))).coloured(theme::FAINT)
        })
        .collect();
    let mut colour = 0;
    for (term, name) in names.iter().enumerate() {
        let highest = steps
            .iter()
            .map(|step| step.terms()[term])
            .fold(0.0, f64::max);
        if highest >= LEAST_SHARE * most {
            let line = Series::line(lines(&|step| step.terms()[term]));
            series.push(line.named(name).coloured(theme::series(colour)));
            colour += 1;
        }
    }
    let total = Series::line(lines(&|step| step.point.energy));
    series.push(Series {
        width: 5.0,
        ..total.named("energy").coloured(theme::INK)
    });
    for (number, &place) in shown.iter().enumerate() {
        let step = &steps[place];
        let points = vec![[millimetres(step), step.point.energy]];
        series.push(Series::points(points).coloured(theme::INK));
        series.push(Series::new(Mark::Text {
            // Above all curves.
            at: [millimetres(step), 1.07 * most],
            text: (number + 1).to_string(),
            anchor: crate::figure::Anchor::Middle,
        }));
    }
    let panel = Panel::new(
        "",
        Axis::linear("way of the hand's surface (mm)"),
        // Room for the numbers above the curves.
        Axis::linear("energy and its terms").with_range(0.0, 1.2 * most),
        series,
    );
    let chart = Chart {
        // Inside the panel it would hide numbers.
        legend_below: true,
        panel_size: [WIDTH - 44, 620],
        ..Chart::new("", vec![panel])
    };
    let graph = chart.draw()?;
    let side = side_in_row(WIDTH, shown.len());
    let height = graph.height();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a length on a sheet"
    )]
    let below = row_height(side, 2).ceil() as u32;
    let mut canvas = graph.with_room_below(below);
    draw_row(
        &mut canvas,
        height - 60.0,
        &rendered(energy, steps, &shown, side),
    );
    Ok(canvas)
}

/// Points evenly along the way, the top among them.
fn shown(steps: &[Waypoint], count: usize) -> Vec<usize> {
    let length = steps.last().map_or(0.0, |step| step.along_m);
    let nearest = |place: f64| {
        let apart = |i: &usize| (steps[*i].along_m - place).abs();
        (0..steps.len())
            .min_by(|a, b| apart(a).total_cmp(&apart(b)))
            .unwrap_or(0)
    };
    let mut shown: Vec<usize> = (0..count)
        .map(|k| nearest(length * k as f64 / (count - 1) as f64))
        .collect();
    let top = top(steps);
    let inner = 1..count - 1;
    let closest = inner.min_by_key(|&k| shown[k].abs_diff(top));
    if let Some(closest) = closest {
        shown[closest] = top;
    }
    shown.sort_unstable();
    shown.dedup();
    shown
}

/// All from one side, so that what moves is the hand.
fn rendered(energy: &GraspEnergy, steps: &[Waypoint], shown: &[usize], side: u32) -> Vec<Picture> {
    let (hand, object) = (energy.hand(), energy.object());
    let skin = hand.skin();
    let scene = |place: usize| {
        let step = &steps[place];
        let grasp = Grasp::new(step.point.coordinates.clone(), step.point.choice.clone());
        Scene::of_grasp(hand, &skin, object, &grasp)
    };
    let middle = scene(shown[shown.len() / 2]);
    let toward_eye = middle.best_camera(Vector3::z()).toward_eye();
    let all = Scene {
        surfaces: shown
            .iter()
            .filter_map(|&place| scene(place).surfaces.into_iter().next())
            .collect(),
        ..Scene::default()
    };
    let camera = all.framed(toward_eye, Vector3::z());
    let highest = top(steps);
    let picture = |(number, &place): (usize, &usize)| {
        let said = if place == highest { "top, " } else { "" };
        let step = &steps[place];
        Picture {
            image: scene(place).render(&camera, side * PICTURE_DENSITY, side * PICTURE_DENSITY),
            texts: vec![
                format!("{}", number + 1),
                format!("{said}E {:.2}", step.point.energy),
            ],
            colour: None,
            of: None,
        }
    };
    shown.par_iter().enumerate().map(picture).collect()
}

/// The hand's skin moving along the way over the resting object.
fn animation(energy: &GraspEnergy, steps: &[Waypoint]) -> Vec<u8> {
    let hand = energy.hand();
    let skin = hand.skin();
    let mut posed = PosedHand::default();
    let frames: Vec<Vec<Vector3<f64>>> = steps
        .iter()
        .map(|step| {
            hand.pose(&step.point.coordinates, &mut posed);
            skin.pose(&posed)
        })
        .collect();
    hand.pose(&steps[0].point.coordinates, &mut posed);
    let scene = Scene {
        surfaces: vec![
            Surface::of_hand(&skin, &posed),
            Surface::of_mesh(&energy.object().mesh),
        ],
        ..Scene::default()
    };
    let length = steps.last().map_or(0.0, |step| step.along_m);
    let seconds = (1e2 * length * SECONDS_PER_CM).max(LEAST_SECONDS);
    let times: Vec<f64> = steps
        .iter()
        .map(|step| seconds * step.along_m / length.max(f64::MIN_POSITIVE))
        .collect();
    scene.to_animated_glb(&times, &frames)
}
