//! Time and memory against the number of minima, beside the exact answer → `figures/many_minima.png`, `.md`
//!
//! `cargo run --release --example many_minima` makes landscapes of wells of different depths ([`wells`]) with the engine
//! that maps grasps, and compares them with the exact tree. Each stage of each size is a process of its own
//! (`many_minima STAGE SIDE`), so that its greatest memory can be told. It takes about a minute on two cores.

mod wells;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use landscape::figure::chart::{Axis, Chart, Corner, Panel, Series};
use landscape::figure::theme;
use landscape::optimize::{Quench, QuenchSettings, StopReason};
use landscape::sample::{Mala, Task, standard_normal, stream};
use landscape::store::{GraspFile, Overrides};
use landscape::study::settings_for_grasps;
use landscape::topography::exchange::{Database, Layout, MinimumEntry, TransitionStateEntry};
use landscape::topography::{
    Ancestors, Landscape, MapSettings, MatchTolerance, Minimum, MinimumId, Run, build_landscape,
    distinct, quench_all,
};
use rand::RngExt;
use wells::{Exact, MARGIN, Wells};

/// Sides of the squares of wells.
const SIDES: [usize; 5] = [20, 32, 50, 71, 100];
/// Sides of larger ones, whose networks are imported only.
const LARGER_SIDES: [usize; 2] = [178, 316];
/// Descents for each well.
const DESCENTS: usize = 10;
/// Number of descents to grasps.
const GRASPS: usize = 100_000;
const SEED: u64 = 28;
const SAMENESS: MatchTolerance = MatchTolerance {
    energy: 1e-7,
    distance: 1e-4,
};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments.as_slice() {
        [] => report(),
        ["merge", side] => merge(side.parse()?),
        ["map", side] => map(side.parse()?),
        ["import", side] => import(side.parse()?),
        ["grasps", path] => grasps(Path::new(path)),
        _ => Err("usage: many_minima [merge SIDE | map SIDE | import SIDE | grasps FILE]".into()),
    }
}

/// What a stage measured.
struct Measured {
    /// Seconds on all cores; of `merge`, those after the descents.
    seconds: f64,
    memory_mb: f64,
    /// What the comparison with the exact answer found.
    counts: Vec<usize>,
}

impl Measured {
    /// Runs a stage as a process of its own.
    fn by(stage: &str, of: &str) -> Result<Self, Box<dyn Error>> {
        let output = Command::new(std::env::current_exe()?)
            .args([stage, of])
            .output()?;
        let text = String::from_utf8(output.stdout)?;
        eprintln!("{stage} {of}: {}", text.trim());
        if !output.status.success() {
            return Err(format!("{stage} {of}: {}", String::from_utf8(output.stderr)?).into());
        }
        let mut words = text.split_whitespace();
        let mut number = || words.next().unwrap_or_default().parse::<f64>();
        let [seconds, memory_mb] = [number()?, number()?];
        Ok(Self {
            seconds,
            memory_mb,
            counts: words.map(str::parse).collect::<Result<_, _>>()?,
        })
    }
}

/// Prints what [`Measured::by`] reads.
fn tell(seconds: f64, counts: &[usize]) {
    let counts: Vec<String> = counts.iter().map(ToString::to_string).collect();
    println!("{seconds} {} {}", peak_memory_mb(), counts.join(" "));
}

/// The greatest memory of this process so far, MB; Linux only.
fn peak_memory_mb() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    number.unwrap_or(f64::NAN) / 1024.0
}

/// Descends from random points about each well, and merges equal ends. Counts: descents, distinct minima, and wells whose
/// descents are not one minimum.
fn merge(side: usize) -> Result<(), Box<dyn Error>> {
    let mut rng = stream(SEED, Task::Start, side as u64);
    let starts: Vec<Vec<f64>> = (0..DESCENTS * side * side)
        .map(|k| {
            let well = k % (side * side);
            [well / side, well % side]
                .map(|place| place as f64 + 0.2 * (rng.random::<f64>() - 0.5))
                .to_vec()
        })
        .collect();
    let energy = Wells::new();
    let descent = QuenchSettings::default().with_gradient_tolerance(1e-9);
    let found = quench_all(&energy, &starts, &descent, &Run::default())?;
    let started = Instant::now();
    let (minima, _) = distinct(&energy, &found, &SAMENESS, 1e-6);
    let seconds = started.elapsed().as_secs_f64();
    let of_one_well = |minimum: &&Minimum| {
        let well = minimum.members[0] % (side * side);
        let of_well = |member: &usize| member % (side * side) == well;
        minimum.members.len() == DESCENTS && minimum.members.iter().all(of_well)
    };
    let right = minima.iter().filter(of_one_well).count();
    tell(seconds, &[found.len(), minima.len(), side * side - right]);
    Ok(())
}

/// Merges as many ends of descents as a large data set has: copies of the grasps of a file, displaced by less than the
/// tolerance. Counts: descents, distinct minima, and minima without displacement.
fn grasps(path: &Path) -> Result<(), Box<dyn Error>> {
    let (file, _) = GraspFile::read(path, Overrides::default())?;
    let population = file.landscapes().into_iter().next();
    let energy = population.as_ref().ok_or("the file is empty")?.energy()?;
    let settings = settings_for_grasps(&energy);
    let poses = file.grasps.iter().map(|grasp| grasp.grasp.pose.to_vec());
    let starts: Vec<Vec<f64>> = poses.collect();
    let ends = quench_all(&energy, &starts, &settings.quench, &Run::default())?;
    let (alone, _) = distinct(&energy, &ends, &settings.sameness, f64::INFINITY);
    let space = landscape::energy::Energy::space(&energy);
    let mut rng = stream(SEED, Task::Start, 0);
    let many: Vec<Quench> = (0..GRASPS)
        .map(|k| {
            let end = &ends[k % ends.len()];
            let length = 0.1 * settings.sameness.distance / (space.tangents() as f64).sqrt();
            let tangent = (0..space.tangents()).map(|_| length * standard_normal(&mut rng));
            let mut x = end.x.clone();
            space.exp(&mut x, &tangent.collect::<Vec<f64>>());
            Quench {
                x,
                energy: end.energy + 0.1 * settings.sameness.energy * rng.random::<f64>(),
                stop: StopReason::Converged,
                ..end.clone()
            }
        })
        .collect();
    let started = Instant::now();
    let (minima, _) = distinct(&energy, &many, &settings.sameness, f64::INFINITY);
    let seconds = started.elapsed().as_secs_f64();
    tell(seconds, &[many.len(), minima.len(), alone.len()]);
    Ok(())
}

/// Maps the wells. Counts: minima, connections, pairs of neighbours, those whose height is too high, and those whose height
/// is too low.
fn map(side: usize) -> Result<(), Box<dyn Error>> {
    let energy = Wells::new();
    let starts: Vec<Vec<f64>> = (0..side * side)
        .map(|k| vec![(k / side) as f64, (k % side) as f64])
        .collect();
    let (started, run) = (Instant::now(), Run::default());
    let descent = QuenchSettings::default().with_gradient_tolerance(1e-9);
    let found = quench_all(&energy, &starts, &descent, &run)?;
    let (minima, _) = distinct(&energy, &found, &SAMENESS, 1e-6);
    let settings = MapSettings {
        sameness: SAMENESS,
        searches: 0,
        neighbours: 4,
        ..MapSettings::for_scales(1.0, 1.0)
    };
    let landscape = build_landscape(&energy, &Mala::new(&energy), minima, &settings, &run)?;
    let seconds = started.elapsed().as_secs_f64();
    let [pairs, high, low] = compare(&landscape, side);
    let minima = landscape.network.node_count();
    tell(
        seconds,
        &[minima, landscape.connections.len(), pairs, high, low],
    );
    Ok(())
}

/// The number of pairs of neighbours in the grid, whose heights determine all others, and of those whose height is too high
/// and too low. Ways may lead through wells that are not mapped; ways that do not are known to lead over the passes inside.
fn compare(landscape: &Landscape, side: usize) -> [usize; 3] {
    let mut numbers = vec![0; side * side];
    for (number, minimum) in landscape.network.node_weights().enumerate() {
        for member in &minimum.members {
            numbers[*member] = number;
        }
    }
    let ancestors = Ancestors::of(&landscape.tree);
    let (inside, around) = (Exact::new(side, 0), Exact::new(side, MARGIN));
    let right = (0..side * side)
        .filter(|k| k % side + 1 < side)
        .map(|k| (k, k + 1));
    let below = (0..side * (side - 1)).map(|k| (k, k + side));
    let mut counts = [0; 3];
    for (a, b) in right.chain(below) {
        let [one, other] = [a, b].map(|k| MinimumId(numbers[k]));
        let found = ancestors
            .joint(one, other)
            .map_or(f64::INFINITY, |node| landscape.tree.nodes[node.0].energy);
        counts[0] += 1;
        counts[1] += usize::from(found - inside.minimax(a, b) > 1e-6);
        counts[2] += usize::from(around.minimax(a, b) - found > 1e-6);
    }
    counts
}

/// Imports the network of the wells, with tables, tree, layout, pictures and page. Counts: minima and passes.
fn import(side: usize) -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(format!("target/many_minima_{side}"));
    fs::create_dir_all(&folder)?;
    let (wells, passes) = wells::network(side);
    let database = Database {
        minima: wells
            .into_iter()
            .map(|energy| MinimumEntry {
                energy,
                vibrations: None,
            })
            .collect(),
        transition_states: passes
            .into_iter()
            .map(|(energy, ends)| TransitionStateEntry {
                energy,
                ends,
                vibrations: None,
            })
            .collect(),
        vibrational_modes: None,
    };
    let counts = [database.minima.len(), database.transition_states.len()];
    fs::write(
        folder.join("min.data"),
        database.min_data(Layout::Topsearch),
    )?;
    fs::write(folder.join("ts.data"), database.ts_data(Layout::Topsearch))?;
    drop(database);
    let started = Instant::now();
    let words = ["landscape", "import", "--quiet", "--force", "-o"].map(std::ffi::OsString::from);
    let paths = [folder.join("many.landscape").into(), folder.clone().into()];
    let code = landscape::cli::run_with(words.into_iter().chain(paths));
    if code != std::process::ExitCode::SUCCESS {
        return Err("landscape import failed".into());
    }
    tell(started.elapsed().as_secs_f64(), &counts);
    fs::remove_dir_all(folder)?;
    Ok(())
}

fn report() -> Result<(), Box<dyn Error>> {
    let mut text = String::from(
        "# Time and memory against the number of minima\n\n\
         Made by `cargo run --release --example many_minima` on two cores. The surface has wells of different depths in a \
         square, and its exact tree is known. Each stage is a process of its own; its greatest memory is that of the whole \
         process.\n\n\
         ## Equal minima are merged\n\n\
         Ten descents for each well, from random points about it. A well is wrong if its ten descents are not one minimum.\n\n\
         | descents | minima | wells that are wrong | seconds after the descents | memory, MB |\n|---|---|---|---|---|\n",
    );
    let mut curves: [Vec<[f64; 3]>; 3] = Default::default();
    for side in SIDES {
        let run = Measured::by("merge", &side.to_string())?;
        let [descents, minima, wrong] = run.counts[..] else {
            return Err("merge told other counts".into());
        };
        writeln!(
            text,
            "| {descents} | {minima} | {wrong} | {:.2} | {:.0} |",
            run.seconds, run.memory_mb
        )?;
        curves[0].push([minima as f64, run.seconds, run.memory_mb]);
    }
    let run = Measured::by("grasps", "data/grasps.parquet")?;
    let [descents, minima, alone] = run.counts[..] else {
        return Err("grasps told other counts".into());
    };
    writeln!(
        text,
        "\nThe {descents} ends of descents that are copies of those of `data/grasps.parquet`, displaced by a tenth of the \
         tolerance, are merged into {minima} minima in {:.1} s and {:.0} MB. Without copies there are {alone}: displacements \
         may join two minima that are hardly apart.\n\n\
         ## Minima are connected\n\n\
         `build_landscape` with four neighbours for each minimum. Heights are those of all neighbouring wells. A height is too \
         low if it lies more than 10⁻⁶ below the lowest way through the wells around.\n\n\
         | minima | connections | heights too high | heights too low | seconds | memory, MB |\n|---|---|---|---|---|---|",
        run.seconds, run.memory_mb
    )?;
    for side in SIDES {
        let run = Measured::by("map", &side.to_string())?;
        let [minima, connections, pairs, high, low] = run.counts[..] else {
            return Err("map told other counts".into());
        };
        writeln!(
            text,
            "| {minima} | {connections} | {high} of {pairs} | {low} of {pairs} | {:.1} | {:.0} |",
            run.seconds, run.memory_mb
        )?;
        curves[1].push([minima as f64, run.seconds, run.memory_mb]);
    }
    writeln!(
        text,
        "\n## Tables, tree, layout, pictures and page\n\n\
         `landscape import` of the exact wells and passes.\n\n\
         | minima | passes | seconds | memory, MB |\n|---|---|---|---|"
    )?;
    for side in SIDES.into_iter().chain(LARGER_SIDES) {
        let run = Measured::by("import", &side.to_string())?;
        let [minima, passes] = run.counts[..] else {
            return Err("import told other counts".into());
        };
        writeln!(
            text,
            "| {minima} | {passes} | {:.1} | {:.0} |",
            run.seconds, run.memory_mb
        )?;
        curves[2].push([minima as f64, run.seconds, run.memory_mb]);
    }
    fs::write("figures/many_minima.md", text)?;
    draw(&curves)
}

fn draw(curves: &[Vec<[f64; 3]>; 3]) -> Result<(), Box<dyn Error>> {
    let names = ["merging descents", "connecting minima", "writing all files"];
    let panel = |title: &str, axis: &str, column: usize| {
        let series = curves.iter().zip(names).enumerate();
        let series = series.flat_map(|(index, (curve, name))| {
            let points: Vec<[f64; 2]> = curve.iter().map(|row| [row[0], row[column]]).collect();
            [
                Series::line(points.clone()),
                Series::points(points).named(name),
            ]
            .map(|series| series.coloured(theme::series(index)))
        });
        Panel {
            legend: (column == 1).then_some(Corner::LowerRight),
            ..Panel::new(
                title,
                Axis::logarithmic("minima"),
                Axis::logarithmic(axis),
                series.collect(),
            )
        }
    };
    let panels = vec![
        panel("Time", "seconds on two cores", 1),
        panel("Greatest memory", "MB", 2),
    ];
    let chart = Chart::new("", panels);
    chart.draw()?.save(Path::new("figures/many_minima.png"))?;
    Ok(())
}
