//! A set repaired and filled: what `synth --from set --beyond set` makes of it, on one map → `figures/repaired_set.md`, `.png`
//!
//! The file of an imported set of one hand and one object is given, and the number of chains of the search: `--example
//! repaired_set -- set.parquet 32`. What is finished is kept in `set.parquet.repair`, so that a stopped run goes on. The
//! committed figure is of the 68 examples of `DexGraspNet` (Wang et al. 2023) that hold
//! `sem-Bottle-437678d4bc6be981c8724d5673a063a6` at scale 0.1, imported by `landscape import BOTTLE.npy --hand
//! shadow_hand_vis.xml --object BOTTLE.obj --scale 0.1 -o set.parquet`.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use landscape::evaluation::stability::{Drop, Protocol};
use landscape::figure::chart::{Axis, Chart, Panel, Series};
use landscape::figure::theme;
use landscape::grasp::judge;
use landscape::store::{GraspFile, GraspRow, Journal, Overrides};
use landscape::study::{
    Archive, GraspMapSettings, Origin, PopulationSettings, Run, StudyRun, map_population,
    simulate_all, synthesize_beyond,
};

/// Searches for a lower way across each merge of the map.
const SEARCHES: usize = 2;

/// Azimuth and elevation of the hand's centre, seen from the centroid of the object, degrees.
fn direction(row: &GraspRow, centroid: nalgebra::Vector3<f64>) -> [f64; 2] {
    let x = &row.grasp.pose;
    let from = nalgebra::Vector3::new(x[0], x[1], x[2]) - centroid;
    let level = libm::hypot(from.x, from.y);
    [libm::atan2(from.y, from.x), libm::atan2(from.z, level)].map(f64::to_degrees)
}

fn held(file: &GraspFile, run: &Run<'_>) -> Result<usize, Box<dyn Error>> {
    Ok(simulate_all(file, &Protocol::Drop(Drop::default()), run)?.stable())
}

/// Where the hands of some layers of grasps are.
fn places(layers: &[(&str, &[GraspRow])], centroid: nalgebra::Vector3<f64>) -> Chart {
    let points = |rows: &[GraspRow]| rows.iter().map(|row| direction(row, centroid)).collect();
    let series = layers.iter().enumerate().map(|(number, (name, rows))| {
        Series::points(points(rows))
            .named(name)
            .coloured(theme::series(number))
    });
    let panel = Panel::new(
        "where the hand is, seen from the object",
        Axis::linear("azimuth (°)"),
        Axis::linear("elevation (°)"),
        series.collect(),
    );
    Chart {
        legend_below: true,
        ..Chart::new("", vec![panel])
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = PathBuf::from(arguments.next().ok_or("name the file of the set")?);
    let chains: u64 = arguments.next().map_or(Ok(64), |text| text.parse())?;
    let (set, _) = GraspFile::read(&path, Overrides::default())?;
    let populations = set.landscapes();
    let [population] = populations.as_slice() else {
        return Err("the set must have one hand, one object and one scale".into());
    };
    let origin = Origin::of_population(population);
    let settings = PopulationSettings {
        chains,
        ..PopulationSettings::default()
    };
    let energy = origin.energy(&settings)?;
    let archive = Archive::of_population(&energy, population);
    let mut journal = path.clone().into_os_string();
    journal.push(".repair");
    let journal = Journal::open(
        Path::new(&journal),
        &origin.fingerprint(&energy, &settings)?,
        false,
    )?;
    let run = Run {
        journal: &journal,
        ..Run::default()
    };
    let (found, added) = synthesize_beyond(&energy, &origin, &settings, &archive, &run)?;

    eprintln!("{} grasps repaired, {} added", added.repaired, added.new);

    let given = origin.given.iter();
    let strict = given
        .filter(|row| judge(&energy, &row.grasp).passes_strict())
        .count();
    let metadata = origin.metadata(&energy, &settings)?;
    let of = |grasps: &[GraspRow]| GraspFile {
        metadata: metadata.clone(),
        grasps: grasps.to_vec(),
    };
    let (repaired, new) = found.grasps.split_at(added.repaired);
    let layers = [
        ("given", origin.given.as_slice()),
        ("repaired", repaired),
        ("added", new),
    ];
    let chart = places(&layers, energy.object().centroid);
    let picture = Path::new("figures/repaired_set.png");
    fs::write(picture, chart.draw()?.encode(picture)?)?;
    let before = held(&of(&origin.given), &Run::default())?;
    let after = [
        held(&of(repaired), &Run::default())?,
        held(&of(new), &Run::default())?,
    ];
    eprintln!("dropped; now mapped");
    let all = of(&found.grasps);
    let populations = all.landscapes();
    let mut map = GraspMapSettings::new(&energy);
    map.map.searches = SEARCHES;
    let quiet = StudyRun {
        run,
        ..StudyRun::default()
    };
    let landscape = map_population(&populations[0], &energy, &map, &quiet)?.landscape;
    let minima = landscape
        .network
        .node_weights()
        .map(|minimum| &minimum.members);
    let of_set: Vec<bool> = minima
        .map(|members| members.iter().any(|member| *member < added.repaired))
        .collect();
    let families = &landscape.families.members;
    let missing = families
        .iter()
        .filter(|family| !family.iter().any(|m| of_set[m.0]))
        .count();

    let text = format!(
        "# A set repaired\n\nThe {} hand on {}, {} given grasps, of which {strict} pass the strict filter and {before} hold \
         when dropped in simulation.\n\n| | grasps | hold |\n|---|---|---|\n| given | {} | {before} |\n| repaired: minima that \
         pass | {} | {} |\n| added | {} | {} |\n\nOf {} families of all of them, {missing} have no grasp of the set. The search \
         took {} chains; one more end is new with a chance of {:.2}. The picture shows from where the hand comes.\n\n\
         ![given, repaired and added](repaired_set.png)\n",
        origin.hand.name,
        origin.object.name,
        added.given,
        added.given,
        added.repaired,
        after[0],
        added.new,
        after[1],
        families.len(),
        added.chains,
        added.chance.unwrap_or(f64::NAN),
    );
    fs::write("figures/repaired_set.md", text)?;
    Ok(())
}
