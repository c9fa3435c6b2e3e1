//! Cost and accuracy of connecting only near minima instead of all pairs → `figures/candidate_pairs.png`, `.md`, `.csv`
//!
//! Every landscape is mapped with all pairs and no skipping. It is then mapped with the k nearest minima of each, the
//! minimum spanning tree of distances, and links between separate components, as in `map`. For each merge of the first map,
//! the program measures how much higher the other maps join the same two minima. The landscapes are random surfaces and 100
//! grasps of data/grasps.parquet.
//!
//! `cargo run --release --example candidate_pairs [JOURNAL]` takes some four hours of CPU, nearly all of it for all pairs
//! of the grasps. Finished work is kept in JOURNAL (by default `target/candidate_pairs.journal`), so that an interrupted
//! run can continue. Landscapes in the .csv are not mapped again.

mod grasp_minima;
mod waves;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use grasp_minima::{Grasps, shuffled};
use landscape::energy::Energy;
use landscape::figure::chart::{Axis, Chart, Corner, Panel, Series};
use landscape::optimize::QuenchSettings;
use landscape::sample::{Kernel, Mala, Task, stream};
use landscape::store::{Journal, content_hash};
use landscape::topography::{
    self, Evidence, JournalError, Landscape, MapSettings, MatchTolerance, MemoryJournal, Minimum,
    MinimumId, Run, build_landscape, in_box, spanning_forest,
};
use waves::Waves;

const SEED: u64 = 7;
/// Numbers of nearest minima per minimum.
const NEIGHBOURS: [usize; 7] = [1, 2, 3, 4, 6, 8, 12];
/// Number of random surfaces of each kind, and of minima on each.
const SURFACES: u64 = 20;
const MINIMA: usize = 40;
const GRASPS: usize = 100;
/// Kinds of random surfaces: name, angles, modes, waves.
const KINDS: [(&str, usize, u8, usize); 2] = [("2 angles", 2, 4, 40), ("6 angles", 6, 2, 60)];
const ON_GRASPS: &str = "100 grasps";
const TABLE: &str = "figures/candidate_pairs.csv";
const COLUMNS: &str = "landscape,id,rule,minima,pairs,evaluations,merges,height,tolerance,excess";

/// Keeps connections without their paths, which are not used here.
struct WithoutPaths<'a>(&'a Journal);

impl topography::Journal for WithoutPaths<'_> {
    fn get(&self, key: &str) -> Option<Vec<u8>> {
        self.0.get(key)
    }

    fn put(&self, key: &str, record: &[u8]) -> Result<(), JournalError> {
        let refused = |error| JournalError::from(Box::<dyn Error + Send + Sync>::from(error));
        let mut value: serde_json::Value = serde_json::from_slice(record).map_err(refused)?;
        if let Some(path) = value.get_mut("path")
            && let Ok(empty) = serde_json::to_value(topography::Path::default())
        {
            *path = empty;
        }
        let record = serde_json::to_vec(&value).map_err(refused)?;
        topography::Journal::put(self.0, key, &record)
    }
}

/// One map of one landscape.
#[derive(Clone)]
struct Row {
    landscape: String,
    id: u64,
    /// `all`, `all, pruned`, or the number of neighbours.
    rule: String,
    minima: usize,
    pairs: usize,
    evaluations: usize,
    /// Median height of the merges of the first map above the higher of the two minima.
    height: f64,
    /// Energy difference below which two minima may be the same.
    tolerance: f64,
    /// For each merge of the first map, how much higher the same minima are joined in this map.
    excess: Vec<f64>,
}

impl Row {
    fn line(&self) -> String {
        let excess: Vec<String> = self.excess.iter().map(|e| format!("{e:.4e}")).collect();
        format!(
            "{},{},{},{},{},{},{},{:.6},{:.3e},{}",
            self.landscape,
            self.id,
            self.rule,
            self.minima,
            self.pairs,
            self.evaluations,
            self.excess.len(),
            self.height,
            self.tolerance,
            excess.join(" ")
        )
    }

    fn parse(line: &str) -> Option<Self> {
        let fields: Vec<&str> = line.split(',').collect();
        let [
            landscape,
            id,
            rule,
            minima,
            pairs,
            evaluations,
            _,
            height,
            tolerance,
            excess,
        ] = *fields.as_slice()
        else {
            return None;
        };
        Some(Self {
            landscape: landscape.to_owned(),
            id: id.parse().ok()?,
            rule: rule.to_owned(),
            minima: minima.parse().ok()?,
            pairs: pairs.parse().ok()?,
            evaluations: evaluations.parse().ok()?,
            height: height.parse().ok()?,
            tolerance: tolerance.parse().ok()?,
            excess: excess
                .split(' ')
                .filter(|part| !part.is_empty())
                .map(|part| part.parse().ok())
                .collect::<Option<_>>()?,
        })
    }
}

/// Number of pairs with chains.
fn tried(found: &Landscape) -> usize {
    let connections = found.connections.iter();
    connections
        .filter(|connection| !connection.forward.is_empty())
        .count()
}

/// Maps the minima by every rule.
fn compare(
    (landscape, id): (&str, u64),
    (energy, kernel): (&dyn Energy, &dyn Kernel),
    minima: &[Minimum],
    settings: &MapSettings,
    journal: &dyn topography::Journal,
) -> Result<Vec<Row>, JournalError> {
    let map = |neighbours: usize, pruned: bool| {
        let settings = MapSettings {
            neighbours,
            pruned,
            // Searches across merges find what no pair shows.
            searches: 0,
            ..settings.clone()
        };
        build_landscape(
            energy,
            kernel,
            minima.to_vec(),
            &settings,
            &Run {
                journal,
                ..Run::default()
            },
        )
    };
    let whole = map(minima.len(), false)?;
    let merges: Vec<(MinimumId, MinimumId, f64)> = spanning_forest(&whole.network, Evidence::Chain)
        .into_iter()
        .filter_map(|edge| {
            let (a, b) = whole.network.edge_endpoints(edge)?;
            Some((
                MinimumId(a.index()),
                MinimumId(b.index()),
                whole.network[edge].height,
            ))
        })
        .collect();
    let mut heights: Vec<f64> = merges
        .iter()
        .map(|(a, b, height)| {
            height
                - whole.tree.nodes[a.0]
                    .energy
                    .max(whole.tree.nodes[b.0].energy)
        })
        .collect();
    heights.sort_by(f64::total_cmp);
    let height = heights.get(heights.len() / 2).copied().unwrap_or(0.0);
    let row = |rule: String, found: &Landscape| Row {
        landscape: landscape.to_owned(),
        id,
        rule,
        minima: minima.len(),
        pairs: tried(found),
        evaluations: found.evaluations,
        height,
        tolerance: settings.sameness.energy,
        excess: merges
            .iter()
            .map(|(a, b, height)| found.tree.minimax(*a, *b).unwrap_or(f64::INFINITY) - height)
            .collect(),
    };
    let mut rows = vec![
        row("all".to_owned(), &whole),
        row(
            "all (joined ones skipped)".to_owned(),
            &map(minima.len(), true)?,
        ),
    ];
    for neighbours in NEIGHBOURS {
        rows.push(row(neighbours.to_string(), &map(neighbours, true)?));
    }
    Ok(rows)
}

/// Random surface `id` of a kind, and minima of it.
fn surface(
    (_, angles, modes, count): (&str, usize, u8, usize),
    id: u64,
) -> Result<(Waves, Vec<Minimum>, MapSettings), JournalError> {
    let energy = Waves::random(angles, modes, count, &mut stream(SEED, Task::Surface, id));
    let half = std::f64::consts::PI;
    let (low, high) = (vec![-half; angles], vec![half; angles]);
    let draw = in_box(&low, &high);
    let starts: Vec<Vec<f64>> = (0..2000)
        .map(|start| draw(&mut stream(SEED, Task::Start, id << 32 | start)))
        .collect();
    let mut settings = MapSettings::for_scales(1.0, 1.0);
    settings.seed = SEED;
    settings.quench = QuenchSettings::default().with_gradient_tolerance(1e-8);
    settings.sameness = MatchTolerance {
        energy: 1e-6,
        distance: 1e-3,
    };
    let mut minima = shuffled(&energy, &starts, &settings, 1e-6, id)?;
    minima.truncate(MINIMA);
    let settings = MapSettings {
        seed: SEED,
        ..MapSettings::for_minima(&energy, &minima)
    };
    Ok((energy, minima, settings))
}

fn main() -> Result<(), Box<dyn Error>> {
    let journal = std::env::args().nth(1).map_or_else(
        || PathBuf::from("target/candidate_pairs.journal"),
        PathBuf::from,
    );
    let mut rows = table();
    let known = |rows: &[Row], name: &str, id: u64| {
        rows.iter().any(|row| row.landscape == name && row.id == id)
    };
    for kind in KINDS {
        for id in 0..SURFACES {
            if known(&rows, kind.0, id) {
                continue;
            }
            let (energy, minima, settings) = surface(kind, id)?;
            let kernel = Mala::new(&energy);
            rows.extend(compare(
                (kind.0, id),
                (&energy, &kernel),
                &minima,
                &settings,
                &MemoryJournal::default(),
            )?);
            write_table(&rows)?;
        }
    }
    if !known(&rows, ON_GRASPS, 0) {
        let bytes = fs::read("data/grasps.parquet")?;
        let grasps = Grasps::read(Path::new("data/grasps.parquet"))?;
        let settings = MapSettings {
            seed: SEED,
            ..grasps.settings.clone()
        };
        let text = serde_json::to_string(&settings)?;
        let journal = Journal::open(&journal, &content_hash(&[&bytes, text.as_bytes()]), false)?;
        let mut minima = grasps.minima(SEED)?;
        minima.truncate(GRASPS);
        let kernel = landscape::grasp::GraspKernel::new(&grasps.energy);
        let surface: (&dyn Energy, &dyn Kernel) = (&grasps.energy, &kernel);
        let found = compare(
            (ON_GRASPS, 0),
            surface,
            &minima,
            &settings,
            &WithoutPaths(&journal),
        )?;
        rows.extend(found);
        write_table(&rows)?;
    }
    // Report the rounded numbers of the table, so that a run that finds all of them there gives the same report.
    report(&table())
}

/// Rows that were finished before.
fn table() -> Vec<Row> {
    let text = fs::read_to_string(TABLE).unwrap_or_default();
    text.lines().filter_map(Row::parse).collect()
}

fn write_table(rows: &[Row]) -> std::io::Result<()> {
    let lines: Vec<String> = rows.iter().map(Row::line).collect();
    fs::write(TABLE, format!("{COLUMNS}\n{}\n", lines.join("\n")))
}

/// All maps with one rule of the landscapes of one kind.
struct Summary {
    rule: String,
    minima: f64,
    pairs: f64,
    /// Share of the evaluations of all pairs.
    cost: f64,
    merges: usize,
    /// Number of merges that are more than the tolerance higher or lower.
    raised: usize,
    lowered: usize,
    /// Excess of each merge in units of the median height of merges.
    excess: Vec<f64>,
}

impl Summary {
    fn of(rows: &[Row], kind: &str) -> Vec<Self> {
        let of_kind = || rows.iter().filter(|row| row.landscape == kind);
        let mut rules: Vec<String> = Vec::new();
        for row in of_kind() {
            if !rules.contains(&row.rule) {
                rules.push(row.rule.clone());
            }
        }
        let all: usize = of_kind()
            .filter(|row| row.rule == "all")
            .map(|row| row.evaluations)
            .sum();
        let summary = |rule: String| {
            let ours: Vec<&Row> = of_kind().filter(|row| row.rule == rule).collect();
            let count = ours.len().max(1) as f64;
            let mean = |value: fn(&Row) -> usize| {
                ours.iter().map(|row| value(row)).sum::<usize>() as f64 / count
            };
            let counted = |differs: fn(f64, f64) -> bool| {
                let merges = ours
                    .iter()
                    .flat_map(|row| row.excess.iter().map(|excess| (*excess, row.tolerance)));
                merges
                    .filter(|(excess, tolerance)| differs(*excess, *tolerance))
                    .count()
            };
            let mut excess: Vec<f64> = ours
                .iter()
                .flat_map(|row| row.excess.iter().map(|excess| excess / row.height))
                .collect();
            excess.sort_by(f64::total_cmp);
            Self {
                minima: mean(|row| row.minima),
                pairs: mean(|row| row.pairs),
                cost: mean(|row| row.evaluations) * count / all.max(1) as f64,
                merges: excess.len(),
                raised: counted(|excess, tolerance| excess > tolerance),
                lowered: counted(|excess, tolerance| excess < -tolerance),
                excess,
                rule,
            }
        };
        rules.into_iter().map(summary).collect()
    }

    /// Quantile of the excess.
    fn quantile(&self, share: f64) -> f64 {
        let count = self.excess.len();
        let place = (1..=count).position(|k| k as f64 >= share * count as f64);
        place.map_or(0.0, |k| self.excess[k])
    }
}

fn report(rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let kinds = [KINDS[0].0, KINDS[1].0, ON_GRASPS];
    let mut text = format!(
        "# Near pairs against all pairs\n\n\
         Each landscape is mapped with all pairs, none of them skipped; then with pairs of each minimum and its k nearest, the \
         minimum spanning tree of distances, and links between components left apart. A merge of the first map is counted as \
         raised (lowered) when the same two minima are joined higher (lower) by more than the energy below which two minima are \
         one. Lowered: the second map happened on a lower way, for chains of pairs that are tried again are new ones, and \
         pairs that are worth trying again are others. The last columns are quantiles over merges of the height gained, in units \
         of the median height of merges above the higher minimum (∞: not joined). Evaluations are counted, not timed. \
         Random surfaces: {SURFACES} of each kind, sums of waves of so many angles, at most {MINIMA} minima each. Grasps: {GRASPS} \
         minima at random of data/grasps.parquet; `landscape build` takes k = 6.\n"
    );
    for kind in kinds {
        let summaries = Summary::of(rows, kind);
        if summaries.is_empty() {
            continue;
        }
        writeln!(
            text,
            "\n## {kind}\n\n| pairs | minima | pairs tried | evaluations | merges | raised | lowered | 90 % | 95 % | 99 % | most |\n\
             |---|---|---|---|---|---|---|---|---|---|---|"
        )?;
        for summary in &summaries {
            let name = match summary.rule.parse::<usize>() {
                Ok(k) => format!("k = {k}"),
                _ => summary.rule.clone(),
            };
            let share = |count: usize| {
                format!(
                    "{count} ({:.1} %)",
                    100.0 * count as f64 / summary.merges.max(1) as f64
                )
            };
            let quantile = |share: f64| {
                let value = summary.quantile(share);
                if value.is_finite() {
                    format!("{:.3}", value.max(0.0))
                } else {
                    "∞".to_owned()
                }
            };
            writeln!(
                text,
                "| {name} | {:.0} | {:.0} | {:.1} % | {} | {} | {} | {} | {} | {} | {} |",
                summary.minima,
                summary.pairs,
                100.0 * summary.cost,
                summary.merges,
                share(summary.raised),
                share(summary.lowered),
                quantile(0.9),
                quantile(0.95),
                quantile(0.99),
                quantile(1.0)
            )?;
        }
    }
    fs::write("figures/candidate_pairs.md", text)?;
    draw(rows, &kinds)
}

fn draw(rows: &[Row], kinds: &[&str]) -> Result<(), Box<dyn Error>> {
    let mut costs = Vec::new();
    let mut spread = Vec::new();
    for kind in kinds {
        let near: Vec<Summary> = Summary::of(rows, kind)
            .into_iter()
            .filter(|summary| summary.rule.parse::<usize>().is_ok())
            .collect();
        let points: Vec<[f64; 2]> = near
            .iter()
            .map(|summary| {
                let raised = summary.raised as f64 / summary.merges.max(1) as f64;
                [100.0 * summary.cost, 100.0 * raised]
            })
            .collect();
        costs.push(Series::line(points.clone()).named(kind));
        costs.push(Series::points(points.clone()).named(kind));
        costs.extend(
            near.iter()
                .zip(&points)
                .map(|(summary, at)| Series::text([at[0] * 1.06, at[1] + 0.6], &summary.rule)),
        );
        if let Some(six) = near.iter().find(|summary| summary.rule == "6") {
            let count = six.excess.len().max(1) as f64;
            let steps = six.excess.iter().enumerate();
            let points = steps
                .map(|(k, excess)| [excess.max(1e-4), 100.0 * (1.0 - k as f64 / count)])
                .filter(|point| point[0].is_finite());
            spread.push(Series::steps(points.collect()).named(kind));
        }
    }
    let panels = vec![
        Panel {
            legend: Some(Corner::UpperRight),
            ..Panel::new(
                "merges raised, by number of neighbours",
                Axis::logarithmic("evaluations, % of those for all pairs"),
                Axis::linear("merges raised (%)"),
                costs,
            )
        },
        Panel::new(
            "by how much, six neighbours",
            Axis::logarithmic("raised by more than (median heights of merges)"),
            Axis::linear("merges (%)"),
            spread,
        ),
    ];
    let chart = Chart {
        columns: 2,
        panel_size: [760, 620],
        ..Chart::new("", panels)
    };
    chart
        .draw()?
        .save(Path::new("figures/candidate_pairs.png"))?;
    Ok(())
}
