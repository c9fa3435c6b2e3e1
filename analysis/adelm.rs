//! Attraction–diffusion alone against the default map → `figures/adelm.svg`, `.png`, `.md`
//!
//! The Müller–Brown surface, seven Lennard-Jones atoms, and the first 40 grasps of the bottle and of a mug:
//!
//! ```text
//! landscape synth --object mug -n 90 -o target/mug.parquet
//! cargo run --release --example adelm target/mug.parquet
//! ```
//!
//! It takes ten minutes of two cores. Comparisons in `target/adelm` are not repeated.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use landscape::energy::model;
use landscape::figure::chart::{Axis, Chart, Panel, Series};
use landscape::figure::theme;
use landscape::sample::{Task, stream};
use landscape::space::Space;
use landscape::store::{GraspFile, Overrides, Source};
use landscape::study::{
    GraspLandscape, GraspMapSettings, MapSearch, StudyRun, Subject, SurfaceSearch, map_population,
    map_surface, search_surface,
};
use landscape::topography::{
    FamilySettings, Landscape, MatchTolerance, Minimum, SearchSettings, TreeDifference, in_box,
};
use serde::{Deserialize, Serialize};

/// Grasps of each file.
const GRASPS: usize = 40;
/// Random points on each surface.
const POINTS: u64 = 200;

/// Both maps of one system.
#[derive(Serialize, Deserialize)]
struct Comparison {
    system: String,
    /// Minima in both maps.
    minima: usize,
    /// Merges of these minima in the default map, as far as it joins them.
    merges: usize,
    /// Heights of merges by attraction–diffusion alone and in the default map.
    heights: Vec<[f64; 2]>,
    /// Evaluations of attraction–diffusion alone and of the default map.
    evaluations: [usize; 2],
}

fn main() -> Result<(), Box<dyn Error>> {
    let mug = std::env::args().nth(1);
    let mug = mug.unwrap_or_else(|| "target/mug.parquet".to_owned());
    fs::create_dir_all("target/adelm")?;
    let comparisons = [
        once("Müller–Brown", || {
            surface("Müller–Brown", &["muller-brown"])
        })?,
        once("LJ₇", || surface("LJ₇", &["lj", "7"]))?,
        once("bottle", || grasps("bottle", "data/grasps.parquet"))?,
        once("mug", || grasps("mug", &mug))?,
    ];
    fs::write("figures/adelm.md", table(&comparisons)?)?;
    let panels = comparisons.iter().map(panel).collect();
    let chart = Chart {
        columns: 2,
        panel_size: [680, 520],
        ..Chart::new("", panels)
    };
    let canvas = chart.draw()?;
    for ending in ["svg", "png"] {
        canvas.save(Path::new(&format!("figures/adelm.{ending}")))?;
    }
    Ok(())
}

/// A comparison that is made once.
fn once(
    system: &str,
    make: impl FnOnce() -> Result<Comparison, Box<dyn Error>>,
) -> Result<Comparison, Box<dyn Error>> {
    let path = format!("target/adelm/{system}.json");
    if let Ok(text) = fs::read_to_string(&path) {
        return Ok(serde_json::from_str(&text)?);
    }
    let made = make()?;
    fs::write(&path, serde_json::to_string(&made)?)?;
    Ok(made)
}

fn surface(system: &str, words: &[&str]) -> Result<Comparison, Box<dyn Error>> {
    let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
    let surface = model::named(&words)?;
    let (energy, run) = (&*surface.energy, StudyRun::default());
    let subject = Subject {
        name: &surface.name,
        energy,
        coordinates: surface.coordinates.to_owned(),
        low: surface.low.clone(),
        high: surface.high.clone(),
        source: Source::default(),
    };
    let draw = in_box(&subject.low, &subject.high);
    let settings = SearchSettings::measured(energy, &draw, 0);
    let search = SurfaceSearch {
        settings: &settings,
        lowest: None,
        known: &[],
        pair: None,
    };
    let passes = search_surface(&subject, &search, &FamilySettings::of_saddles(), &run)?;
    let starts: Vec<Vec<f64>> = (0..POINTS)
        .map(|id| draw(&mut stream(0, Task::Start, id)))
        .collect();
    let alone = map_surface(
        &surface.name,
        energy,
        &starts,
        MapSearch::Adelm,
        |_| (),
        &run,
    )?;
    compared(
        system,
        energy.space(),
        [&alone.landscape, &passes.landscape],
        [alone.evaluations, passes.found.evaluations],
        &settings.sameness,
    )
}

fn grasps(system: &str, path: &str) -> Result<Comparison, Box<dyn Error>> {
    let (file, _) = GraspFile::read(Path::new(path), Overrides::default())?;
    let mut population = file.landscapes().into_iter().next().ok_or("no grasps")?;
    population.grasps.truncate(GRASPS);
    let energy = population.energy()?;
    let map = |search| -> Result<GraspLandscape, Box<dyn Error>> {
        let settings = GraspMapSettings {
            search,
            ..GraspMapSettings::new(&energy)
        };
        let run = StudyRun::default();
        Ok(map_population(&population, &energy, &settings, &run)?)
    };
    let (alone, passes) = (map(MapSearch::Adelm)?, map(MapSearch::Passes)?);
    compared(
        system,
        landscape::energy::Energy::space(&energy),
        [&alone.landscape, &passes.landscape],
        [alone.evaluations, passes.evaluations],
        &passes.settings.sameness,
    )
}

fn compared(
    system: &str,
    space: &dyn Space,
    [alone, passes]: [&Landscape; 2],
    evaluations: [usize; 2],
    reach: &MatchTolerance,
) -> Result<Comparison, Box<dyn Error>> {
    let [these, those] = [alone, passes].map(|found| {
        let minima = found.network.node_weights().cloned();
        minima.collect::<Vec<Minimum>>()
    });
    let (these, those) = ((&*these, &alone.tree), (&*those, &passes.tree));
    let forth = TreeDifference::between(space, these, those, reach)?;
    let back = TreeDifference::between(space, those, these, reach)?;
    let heights = forth.merges.iter();
    Ok(Comparison {
        system: system.to_owned(),
        minima: forth.matches.len(),
        merges: back.merges.len(),
        heights: heights
            .filter_map(|merge| Some([merge.before, merge.after?]))
            .collect(),
        evaluations,
    })
}

/// How much higher attraction–diffusion alone joins minima, in ascending order.
fn rises(comparison: &Comparison) -> Vec<f64> {
    let mut rises: Vec<f64> = comparison.heights.iter().map(|[a, b]| a - b).collect();
    rises.sort_by(f64::total_cmp);
    rises
}

fn table(comparisons: &[Comparison]) -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "# Attraction–diffusion alone and the default map\n\n\
         Heights at which minima merge by `--search adelm`, less those of the default. Missed: merges of the default map that \
         attraction–diffusion alone does not make. Grasps: the first 40 of a file; their energy is in units of the cost of \
         letting go. The default map of a surface has all its saddles, so that its tree is the known one.\n\n\
         | system | common minima | merges | missed | median rise | greatest rise | lowest | evaluations, alone | default |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for comparison in comparisons {
        let rises = rises(comparison);
        let at = |place: usize| rises.get(place).copied().unwrap_or(f64::NAN);
        writeln!(
            text,
            "| {} | {} | {} | {} | {:.3} | {:.3} | {:.3} | {} | {} |",
            comparison.system,
            comparison.minima,
            comparison.merges,
            comparison.merges.saturating_sub(comparison.heights.len()),
            at(rises.len() / 2),
            at(rises.len().saturating_sub(1)),
            at(0),
            comparison.evaluations[0],
            comparison.evaluations[1],
        )?;
    }
    Ok(text)
}

fn panel(comparison: &Comparison) -> Panel {
    let points = comparison.heights.iter().map(|[a, b]| [*b, *a]);
    let points: Vec<[f64; 2]> = points.collect();
    let all = || points.iter().flatten().copied();
    let (low, high) = (
        all().fold(f64::INFINITY, f64::min),
        all().fold(f64::NEG_INFINITY, f64::max),
    );
    let margin = 0.05 * (high - low);
    let ends = [low - margin, high + margin];
    let axis = |label: &str| Axis::linear(label).with_range(ends[0], ends[1]);
    let series = vec![
        Series::line(vec![[ends[0]; 2], [ends[1]; 2]])
            .coloured(theme::series(8))
            .dashed(),
        Series::points(points).coloured(theme::series(0)),
    ];
    Panel::new(
        &comparison.system,
        axis("height, default map"),
        axis("height, attraction–diffusion alone"),
        series,
    )
}
