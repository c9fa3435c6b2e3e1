//! Whether rates tell other grasps to be near than barriers do → `figures/grasp_rates.md`, `figures/grasp_rates.png`
//!
//! `landscape build data/grasps.parquet && cargo run --release --example grasp_rates`
//!
//! The first argument names another landscape of grasps (a folder).

use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use landscape::agreement::spearman;
use landscape::figure::chart::{Axis, Chart, Panel, Series};
use landscape::store::{LandscapeFiles, write_atomic};
use landscape::study::NetworkOfStates;
use landscape::thermal::{Dynamics, RateNetwork, Superposition};
use landscape::topography::{GroupSettings, MinimumId};

const LANDSCAPE: &str = "data/grasps.landscape";
const REPORT: &str = "figures/grasp_rates.md";
const PICTURE: &str = "figures/grasp_rates.png";
/// Temperatures, in units of the cost of letting go.
const TEMPERATURES: [f64; 3] = [0.005, 0.02, 0.05];

/// How hard it is to get from one family to another.
struct Pair {
    from: usize,
    to: usize,
    /// Height of the lowest pass above the lowest minimum of the first family.
    barrier: f64,
    /// −ln of the rate at each temperature.
    slowness: Vec<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args()
        .nth(1)
        .unwrap_or_else(|| LANDSCAPE.to_owned());
    let folder = Path::new(&folder);
    let files = LandscapeFiles::read(folder)?;
    let settings = GroupSettings {
        barrier: files.manifest.group_barrier,
        ..GroupSettings::default()
    };
    let states = NetworkOfStates::open(folder, &settings)?;
    let networks = TEMPERATURES
        .iter()
        .map(|t| RateNetwork::new(&states.database, *t, Dynamics::TransitionState))
        .collect::<Result<Vec<_>, _>>()?;
    let families: Vec<Vec<usize>> = (states.groups.members.iter())
        .map(|members| members.iter().map(|minimum| minimum.0).collect())
        .collect();
    let mut pairs = Vec::new();
    for (from, sources) in families.iter().enumerate() {
        for (to, targets) in families.iter().enumerate().filter(|(to, _)| *to != from) {
            let ends = [sources[0], targets[0]].map(MinimumId);
            let Some(height) = states.tree.minimax(ends[0], ends[1]) else {
                continue;
            };
            let slowness = networks.iter().map(|network| {
                let rates = network.between(sources, targets).forward?;
                Ok(-rates.first_passage)
            });
            let slowness: Result<Vec<f64>, landscape::thermal::Unreachable> = slowness.collect();
            // Families that only bounds join have no rate.
            if let Ok(slowness) = slowness {
                pairs.push(Pair {
                    from,
                    to,
                    barrier: height - states.tree.nodes[sources[0]].energy,
                    slowness,
                });
            }
        }
    }
    let text = report(folder, &files, &states, &families, &pairs)?;
    write_atomic(REPORT.as_ref(), text.as_bytes())?;
    let canvas = chart(&pairs).draw()?;
    write_atomic(PICTURE.as_ref(), &canvas.encode(PICTURE.as_ref())?)?;
    print!("{text}");
    Ok(())
}

/// Which families have no rate, and why; empty if all have one.
fn without_rate(families: usize, pairs: &[Pair]) -> String {
    let joined: BTreeSet<usize> = pairs.iter().map(|pair| pair.from).collect();
    let alone: Vec<String> = (0..families)
        .filter(|family| !joined.contains(family))
        .map(|family| format!("g{family}"))
        .collect();
    if alone.is_empty() {
        return String::new();
    }
    format!(
        "\nFamilies without a rate: {}. No verified saddle joins them to another family. Their connections are upper bounds, \
         over which a rate would be too low, so they are in no pair of the table.\n",
        alone.join(", ")
    )
}

fn report(
    folder: &Path,
    files: &LandscapeFiles,
    states: &NetworkOfStates,
    families: &[Vec<usize>],
    pairs: &[Pair],
) -> Result<String, Box<dyn Error>> {
    let wells = Superposition::new(&states.database)?;
    let mut text = format!(
        "# Barriers and rates between families of grasps\n\n`{}`: {} minima in {} families, {} verified saddles; {} connections \
         are no saddles and left out. The unit of the energy is the cost of letting go, and kT is a temperature in this unit. A \
         rate rests on all saddles between two families, on the curvatures at minima and saddles, and on the equilibrium within \
         the first family. A barrier rests on the lowest saddle alone.\n",
        folder.display(),
        states.database.minima.len(),
        families.len(),
        states.database.transition_states.len(),
        states.left_out
    );
    text.push_str("\n## Do they agree?\n\n| kT | pairs of families | Spearman, barrier and −ln rate | families whose nearest other family changes |\n|---|---|---|---|\n");
    let barriers: Vec<f64> = pairs.iter().map(|pair| pair.barrier).collect();
    for (k, temperature) in TEMPERATURES.iter().enumerate() {
        let slowness: Vec<f64> = pairs.iter().map(|pair| pair.slowness[k]).collect();
        let (mut changed, mut counted) = (0, 0);
        for from in 0..families.len() {
            let nearest = |measure: &dyn Fn(&Pair) -> f64| {
                let own = pairs.iter().filter(|pair| pair.from == from);
                let best = own.min_by(|a, b| measure(a).total_cmp(&measure(b)));
                best.map(|pair| (pair.to, measure(pair)))
            };
            let (by_barrier, by_rate) = (
                nearest(&|pair| pair.barrier),
                nearest(&|pair| pair.slowness[k]),
            );
            if let (Some((_, least)), Some((fastest, _))) = (by_barrier, by_rate) {
                counted += 1;
                // Several families may lie behind the same lowest pass.
                let same = pairs.iter().any(|pair| {
                    (pair.from, pair.to) == (from, fastest) && pair.barrier <= least + 1e-9
                });
                changed += usize::from(!same);
            }
        }
        writeln!(
            text,
            "| {temperature} | {} | {:.2} | {changed} of {counted} |",
            pairs.len(),
            spearman(&barriers, &slowness)
        )?;
    }
    text.push_str(&without_rate(families.len(), pairs));
    text.push_str("\n## Widths of basins\n\nThe width of a minimum is −½ Σ ln λ over its curvatures λ: the logarithm of the volume of its harmonic well, up to a constant. The share of descents is that of the grasps of the population that ended in the minimum.\n\n");
    let members: Vec<f64> = files
        .minima
        .iter()
        .map(|row| row.members.len() as f64)
        .collect();
    let widths: Vec<f64> = (states.database.minima.iter())
        .map(|minimum| -0.5 * minimum.vibrations.map_or(f64::NAN, |v| v.log_product))
        .collect();
    let energies: Vec<f64> = states
        .database
        .minima
        .iter()
        .map(|minimum| minimum.energy)
        .collect();
    writeln!(
        text,
        "- Spearman of width and share of descents over {} minima: {:.2}; of energy and share of descents: {:.2}.",
        members.len(),
        spearman(&widths, &members),
        spearman(&energies, &members)
    )?;
    let mut header = "\n| family | minima | share of descents |".to_owned();
    for temperature in TEMPERATURES {
        write!(header, " occupation at kT = {temperature} |")?;
    }
    writeln!(
        text,
        "{header}\n|---|---|---|{}",
        "---|".repeat(TEMPERATURES.len())
    )?;
    let all: f64 = members.iter().sum();
    let occupations: Vec<Vec<f64>> = TEMPERATURES.iter().map(|t| wells.occupation(*t)).collect();
    for (number, family) in families.iter().enumerate() {
        let share: f64 = family.iter().map(|k| members[*k]).sum::<f64>() / all;
        write!(
            text,
            "| g{number} | {} | {:.1} % |",
            family.len(),
            100.0 * share
        )?;
        for occupation in &occupations {
            let held: f64 = family.iter().map(|k| occupation[*k]).sum();
            write!(text, " {:.1} % |", 100.0 * held)?;
        }
        text.push('\n');
    }
    Ok(text)
}

fn chart(pairs: &[Pair]) -> Chart {
    let series = TEMPERATURES.iter().enumerate().map(|(k, temperature)| {
        let points = pairs.iter();
        // In units of energy, so that a barrier alone would give the diagonal.
        let points = points.map(|pair| [pair.barrier, temperature * pair.slowness[k]]);
        Series::points(points.collect()).named(&format!("kT = {temperature}"))
    });
    let most = pairs.iter().map(|pair| pair.barrier).fold(0.0, f64::max);
    let mut series: Vec<Series> = series.collect();
    series.push(
        Series::line(vec![[0.0, 0.0], [most, most]])
            .named("barrier alone")
            .dashed(),
    );
    let panel = Panel::new(
        "pairs of families of grasps",
        Axis::linear("barrier (cost of letting go)"),
        Axis::linear("−kT ln rate (cost of letting go)"),
        series,
    );
    Chart {
        legend_below: true,
        ..Chart::new("", vec![panel])
    }
}
