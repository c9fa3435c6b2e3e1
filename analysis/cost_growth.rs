//! Growth of the cost of a map with the number of minima → `figures/cost_growth.png`, `.md`, `.csv`
//!
//! The cost is the number of energy evaluations of [`map`] for n random minima of a landscape with many: grasps, and a
//! rugged surface.
//!
//! ```text
//! landscape synth --object bottle_round -n 1280 --seed 8 -o target/many.parquet
//! cargo run --release --example cost_growth target/many.parquet
//! ```
//!
//! It takes about half an hour of CPU, nearly all of it for the grasps. Maps in the .csv are not repeated.

#[path = "grasp_minima.rs"]
mod grasp_minima;
mod line;
mod waves;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use grasp_minima::{Grasps, shuffled};
use landscape::energy::Energy;
use landscape::figure::chart::{Axis, Chart, Corner, Panel, Series};
use landscape::figure::theme;
use landscape::grasp::GraspKernel;
use landscape::optimize::QuenchSettings;
use landscape::sample::{Kernel, Mala, Task, stream};
use landscape::topography::{MapSettings, MatchTolerance, Minimum, Run, build_landscape, in_box};
use line::Line;
use waves::Waves;

const SEED: u64 = 9;
const SIZES: [usize; 5] = [50, 100, 200, 371, 800];
/// Number of samples of each size; grasps are expensive.
const RUGGED_SAMPLES: [u64; 5] = [4, 4, 4, 4, 4];
const GRASP_SAMPLES: [u64; 5] = [2, 2, 1, 1, 1];
/// Number of nearest minima per minimum, fewer than in `landscape build` to save time.
const NEIGHBOURS: usize = 3;
const ANGLES: usize = 7;
const TABLE: &str = "figures/cost_growth.csv";
const COLUMNS: &str = "landscape,minima,sample,pairs,evaluations";
const GRASPS: &str = "grasps";
const RUGGED: &str = "waves";

/// One map.
#[derive(Clone)]
struct Row {
    landscape: String,
    minima: usize,
    sample: u64,
    pairs: usize,
    evaluations: usize,
}

impl Row {
    fn line(&self) -> String {
        let Self {
            landscape,
            minima,
            sample,
            pairs,
            evaluations,
        } = self;
        format!("{landscape},{minima},{sample},{pairs},{evaluations}")
    }

    fn parse(line: &str) -> Option<Self> {
        let fields: Vec<&str> = line.split(',').collect();
        let [landscape, minima, sample, pairs, evaluations] = *fields.as_slice() else {
            return None;
        };
        Some(Self {
            landscape: landscape.to_owned(),
            minima: minima.parse().ok()?,
            sample: sample.parse().ok()?,
            pairs: pairs.parse().ok()?,
            evaluations: evaluations.parse().ok()?,
        })
    }
}

/// Makes the maps that are missing in the table, smallest first. `minima` gives the minima of a sample in random order.
fn measure(
    rows: &mut Vec<Row>,
    name: &str,
    samples: [u64; 5],
    surface: (&dyn Energy, &dyn Kernel),
    settings: &MapSettings,
    minima: &[Minimum],
) -> Result<(), Box<dyn Error>> {
    for (size, samples) in SIZES.into_iter().zip(samples) {
        if minima.len() < size {
            return Err(format!("{name}: {} minima, {size} are needed", minima.len()).into());
        }
        for sample in 0..samples {
            let same =
                |row: &Row| (&*row.landscape, row.minima, row.sample) == (name, size, sample);
            if rows.iter().any(same) {
                continue;
            }
            // Samples start at different places of the random order.
            let first = usize::try_from(sample)? * minima.len() / 4;
            let taken = minima.iter().cycle().skip(first).take(size).cloned();
            let found = build_landscape(
                surface.0,
                surface.1,
                taken.collect(),
                settings,
                &Run::default(),
            )?;
            let tried = found.connections.iter();
            rows.push(Row {
                landscape: name.to_owned(),
                minima: size,
                sample,
                pairs: tried.filter(|c| !c.forward.is_empty()).count(),
                evaluations: found.evaluations,
            });
            let lines: Vec<String> = rows.iter().map(Row::line).collect();
            fs::write(TABLE, format!("{COLUMNS}\n{}\n", lines.join("\n")))?;
        }
    }
    Ok(())
}

/// Settings of all maps.
fn lighter(settings: MapSettings) -> MapSettings {
    MapSettings {
        neighbours: NEIGHBOURS,
        searches: 0,
        seed: SEED,
        ..settings
    }
}

fn rugged(rows: &mut Vec<Row>) -> Result<(), Box<dyn Error>> {
    let energy = Waves::random(ANGLES, 2, 60, &mut stream(SEED, Task::Surface, 0));
    let half = std::f64::consts::PI;
    let (low, high) = ([-half; ANGLES], [half; ANGLES]);
    let draw = in_box(&low, &high);
    let starts: Vec<Vec<f64>> = (0..6000)
        .map(|start| draw(&mut stream(SEED, Task::Start, start)))
        .collect();
    let mut settings = MapSettings::for_scales(1.0, 1.0);
    settings.quench = QuenchSettings::default().with_gradient_tolerance(1e-8);
    settings.sameness = MatchTolerance {
        energy: 1e-6,
        distance: 1e-3,
    };
    let minima = shuffled(&energy, &starts, &settings, 1e-6, SEED)?;
    eprintln!("{RUGGED}: {} minima", minima.len());
    // The same scale for all sizes, that of the smallest.
    let settings = lighter(MapSettings::for_minima(&energy, &minima[..SIZES[0]]));
    let kernel = Mala::new(&energy);
    measure(
        rows,
        RUGGED,
        RUGGED_SAMPLES,
        (&energy, &kernel),
        &settings,
        &minima,
    )
}

fn grasps(rows: &mut Vec<Row>, path: &Path) -> Result<(), Box<dyn Error>> {
    let grasps = Grasps::read(path)?;
    let minima = grasps.minima(SEED)?;
    eprintln!("{GRASPS}: {} minima", minima.len());
    let kernel = GraspKernel::new(&grasps.energy);
    let settings = lighter(grasps.settings.clone());
    measure(
        rows,
        GRASPS,
        GRASP_SAMPLES,
        (&grasps.energy, &kernel),
        &settings,
        &minima,
    )
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut rows: Vec<Row> = fs::read_to_string(TABLE)
        .unwrap_or_default()
        .lines()
        .filter_map(Row::parse)
        .collect();
    rugged(&mut rows)?;
    report(&rows)?;
    let complete = |size: usize, samples: u64| {
        let of_size = rows
            .iter()
            .filter(|row| row.landscape == GRASPS && row.minima == size);
        of_size.count() as u64 >= samples
    };
    if !SIZES
        .into_iter()
        .zip(GRASP_SAMPLES)
        .all(|(size, samples)| complete(size, samples))
    {
        let path = std::env::args()
            .nth(1)
            .map_or_else(|| PathBuf::from("target/many.parquet"), PathBuf::from);
        grasps(&mut rows, &path)?;
    }
    report(&rows)
}

/// Exponents of the evaluations against n.
struct Growth {
    line: Line,
    exponent: [f64; 3],
}

/// 97.5 % quantiles of Student's t with 1, 2, … degrees of freedom (R. A. Fisher, Statistical Methods for Research Workers,
/// table IV).
const STUDENT: [f64; 18] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
    2.145, 2.131, 2.120, 2.110, 2.101,
];

impl Growth {
    /// Least squares of the logarithms. The interval is the 95 % interval of the normal linear model.
    fn of(rows: &[&Row]) -> Option<Self> {
        let points: Vec<[f64; 2]> = rows
            .iter()
            .map(|row| {
                [
                    libm::log(row.minima as f64),
                    libm::log(row.evaluations as f64),
                ]
            })
            .collect();
        let freedom = points.len().checked_sub(2)?;
        let student = STUDENT.get(freedom.checked_sub(1)?).or(STUDENT.last())?;
        let line = Line::through(&points);
        let error = line.slope
            * ((1.0 / line.r_squared - 1.0) / freedom as f64)
                .max(0.0)
                .sqrt();
        let half = student * error;
        Some(Self {
            exponent: [line.slope, line.slope - half, line.slope + half],
            line,
        })
    }
}

fn report(rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let mut text = format!(
        "# Cost of a map against the number of minima\n\n\
         Evaluations of energy and gradient that `map` spends on connecting n minima, which are drawn at random from all those of \
         one landscape: grasps of the human hand on the round bottle, and a sum of 60 random waves of {ANGLES} angles. Pairs: each \
         minimum with its {NEIGHBOURS} nearest ones, the minimum spanning tree, and links between components left apart; \
         no searches across merges, which `landscape build` makes besides; all else as the version of it had that made the map. \
         The exponent is the slope of the logarithms, with its 95 % interval by the normal linear model over all maps.\n"
    );
    let mut series = Vec::new();
    for (index, name) in [GRASPS, RUGGED].into_iter().enumerate() {
        let ours: Vec<&Row> = rows.iter().filter(|row| row.landscape == name).collect();
        if ours.is_empty() {
            continue;
        }
        writeln!(
            text,
            "\n## {name}\n\n| minima | maps | pairs | evaluations | a minimum | a pair |\n|---|---|---|---|---|---|"
        )?;
        for size in SIZES {
            let of_size: Vec<&&Row> = ours.iter().filter(|row| row.minima == size).collect();
            if of_size.is_empty() {
                continue;
            }
            let count = of_size.len() as f64;
            let pairs = of_size.iter().map(|row| row.pairs).sum::<usize>() as f64 / count;
            let evaluations =
                of_size.iter().map(|row| row.evaluations).sum::<usize>() as f64 / count;
            writeln!(
                text,
                "| {size} | {count} | {pairs:.0} | {evaluations:.3e} | {:.0} | {:.0} |",
                evaluations / size as f64,
                evaluations / pairs
            )?;
        }
        let points: Vec<[f64; 2]> = ours
            .iter()
            .map(|row| [row.minima as f64, row.evaluations as f64])
            .collect();
        let colour = theme::series(index);
        let mut label = name.to_owned();
        if let Some(growth) = Growth::of(&ours) {
            let [exponent, low, high] = growth.exponent;
            writeln!(
                text,
                "\nEvaluations grow as n to the power **{exponent:.2}** ({low:.2} to {high:.2}); all pairs would grow as n²."
            )?;
            write!(label, ": n^{exponent:.2}")?;
            let fitted = [45.0, 900.0].map(|n: f64| [n, libm::exp(growth.line.at(libm::log(n)))]);
            series.push(Series::line(fitted.to_vec()).coloured(colour));
            // The line starts in the middle of the smallest maps.
            let start = libm::exp(growth.line.at(libm::log(50_f64)));
            let steep = [50.0, 900.0].map(|n: f64| [n, start * (n / 50.0).powi(2)]);
            let steep = Series::line(steep.to_vec())
                .coloured(theme::series(8))
                .dashed();
            let first = index == 0;
            series.push(if first {
                steep.named("n², as all pairs")
            } else {
                steep
            });
        }
        series.push(Series::points(points).named(&label).coloured(colour));
    }
    fs::write("figures/cost_growth.md", text)?;
    let panel = Panel {
        legend: Some(Corner::UpperLeft),
        ..Panel::new(
            "",
            Axis::logarithmic("minima n"),
            Axis::logarithmic("evaluations"),
            series,
        )
    };
    let chart = Chart {
        panel_size: [900, 640],
        ..Chart::new("", vec![panel])
    };
    chart.draw()?.save(Path::new("figures/cost_growth.png"))?;
    Ok(())
}
