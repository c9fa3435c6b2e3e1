//! Sets of grasps under published tests and measures → `figures/referee.md`, `.csv`, `.png`, `.svg`
//!
//! `LANDSCAPE_TEST_DATA=… cargo run --release --example referee` judges five sets: sixty chains of the default energy on the
//! bottle, ends of the paper's energy on it that pass Eq. 11 as the authors' code has it, eight chains of the default on each
//! built-in object, the examples of `DexGraspNet` (Shadow hand, two objects at scale 0.1), and grasps that people posed
//! (MANO, every third of the YCB objects). The last two are test data, which are not ours to ship. Files are kept below `target/referee`, so
//! that an interrupted run goes on.

mod command;
#[expect(dead_code, reason = "each program uses a part")]
mod method;

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use command::landscape;
use landscape::grasp::paper::PaperSettings;
use landscape::hand::Hand;
use landscape::object::{OBJECT_NAMES, Object};
use method::Method;
use rayon::prelude::*;
use serde_json::{Value, json};

const SEED: u64 = 60;
/// Chains of the paper's energy.
const PAPER_CHAINS: u64 = 1200;
/// Chains of the default on the bottle, and on each object.
const BOTTLE_CHAINS: &str = "60";
const CHAINS: &str = "8";
/// Grasps of each object that measures which grow with the number of grasps see.
const AT: &str = "5";
const BOTTLE: &str = "bottle_round";

type Failure = Box<dyn Error>;

fn main() -> Result<(), Failure> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = root.join("target/referee");
    fs::create_dir_all(&folder)?;
    let data = std::env::var_os("LANDSCAPE_TEST_DATA").ok_or("set LANDSCAPE_TEST_DATA")?;
    let data = PathBuf::from(data);
    let sets = [
        made(&folder.join("default_bottle.parquet"), |path| {
            default_energy(BOTTLE, BOTTLE_CHAINS, path)
        })?,
        made(&folder.join("paper_bottle.parquet"), |path| {
            paper(&folder, path)
        })?,
        made(&folder.join("default_objects.parquet"), |path| {
            default_objects(&folder, path)
        })?,
        made(&folder.join("DexGraspNet.parquet"), |path| {
            dexgraspnet(&data, &folder, path)
        })?,
        made(&folder.join("people.parquet"), |path| {
            people(&data, &folder, path)
        })?,
    ];
    let output = root.join("figures/referee");
    let mut words = vec!["judge"];
    for set in &sets {
        words.push(text(set)?);
    }
    words.extend(["--at", AT, "-q", "-o", text(&output)?]);
    landscape(&words)?;
    // Outcomes of grasps that are not ours stay here.
    fs::rename(
        root.join("figures/referee.grasps.csv"),
        folder.join("grasps.csv"),
    )?;
    fs::remove_file(root.join("figures/referee.json"))?;
    Ok(())
}

/// The file, which is made if it is not there yet.
fn made(path: &Path, make: impl FnOnce(&Path) -> Result<(), Failure>) -> Result<PathBuf, Failure> {
    if !path.exists() {
        make(path)?;
    }
    Ok(path.to_owned())
}

/// Refined ends of the paper's energy, as the authors' code has it, that pass Eq. 11.
fn paper(folder: &Path, path: &Path) -> Result<(), Failure> {
    let hand = Arc::new(Hand::named("human")?);
    let object = Arc::new(Object::named(BOTTLE)?);
    let method = Method::paper(&hand, &object, PaperSettings::released());
    let ends = (0..PAPER_CHAINS).into_par_iter().map(|chain| {
        let end = method.run(SEED, chain, &mut |_, _| ());
        let passes = method.judge(&end.refined).passes_released();
        passes.then_some(end.refined)
    });
    let ends: Vec<_> = ends.collect();
    let rows = ends.iter().flatten().enumerate().map(|(id, grasp)| {
        let mut row = BTreeMap::from([
            ("id".to_owned(), json!(id)),
            (
                "translation_m".to_owned(),
                json!(grasp.pose.translation_m()),
            ),
            (
                "rotation_wxyz".to_owned(),
                json!(grasp.pose.rotation_wxyz()),
            ),
            // Algorithm 1 may draw a point twice.
            (
                "contacts".to_owned(),
                json!(BTreeSet::from_iter(&grasp.contacts)),
            ),
        ]);
        let joints = hand.joints.iter().zip(grasp.pose.joints());
        row.extend(joints.map(|(joint, q)| (joint.name.clone(), json!(q))));
        json!(row)
    });
    let rows: Vec<Value> = rows.collect();
    println!(
        "{} of {PAPER_CHAINS} ends of the paper's energy pass Eq. 11",
        rows.len()
    );
    let table = folder.join("paper_bottle.json");
    fs::write(&table, serde_json::to_vec(&rows)?)?;
    let mapping = folder.join("paper_bottle.toml");
    fs::write(
        &mapping,
        "translation = \"translation_m\"\nrotation = \"rotation_wxyz\"\n",
    )?;
    landscape(&[
        "import",
        text(&table)?,
        "--hand",
        "human",
        "--object",
        BOTTLE,
        "--mapping",
        text(&mapping)?,
        "-q",
        "-o",
        text(path)?,
    ])
}

fn default_energy(object: &str, chains: &str, path: &Path) -> Result<(), Failure> {
    let (seed, path) = (SEED.to_string(), text(path)?);
    landscape(&[
        "synth", "--object", object, "-n", chains, "--seed", &seed, "-q", "-o", path,
    ])
}

fn default_objects(folder: &Path, path: &Path) -> Result<(), Failure> {
    let mut files = Vec::new();
    for object in OBJECT_NAMES {
        let file = folder.join(format!("default_on_{object}.parquet"));
        files.push(made(&file, |path| default_energy(object, CHAINS, path))?);
    }
    joined(&files, path)
}

fn dexgraspnet(data: &Path, folder: &Path, path: &Path) -> Result<(), Failure> {
    let of = data.join("dexgraspnet");
    let hand = data.join("hands/shadow_dexgraspnet/shadow_hand_vis.xml");
    let mesh = |name: &str| vec![of.join(format!("meshes/{name}.obj"))];
    let files = sorted(&of.join("original_npy"))?;
    imported(&files, &hand, mesh, &["--scale", "0.1"], (folder, path))
}

fn people(data: &Path, folder: &Path, path: &Path) -> Result<(), Failure> {
    let of = data.join("ycb_affordance");
    let hand = of.join("hand/mano_ycba.xml");
    let file = |name: &str, ending| of.join(format!("objects/{name}.{ending}"));
    let meshes = |name: &str| ["obj", "stl"].map(|ending| file(name, ending)).into();
    let files: Vec<PathBuf> = sorted(&of.join("csv_mano"))?
        .into_iter()
        .step_by(3)
        .collect();
    imported(&files, &hand, meshes, &[], (folder, path))
}

/// Imports each file, whose object is the first of some meshes that exists, into a folder, and joins them into a file.
fn imported(
    files: &[PathBuf],
    hand: &Path,
    meshes: impl Fn(&str) -> Vec<PathBuf>,
    more: &[&str],
    (folder, path): (&Path, &Path),
) -> Result<(), Failure> {
    let mut sets = Vec::new();
    for file in files {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let mesh = meshes(&name).into_iter().find(|mesh| mesh.exists());
        let mesh = mesh.ok_or_else(|| format!("{name} has no mesh"))?;
        let words = ["import", text(file)?, "--hand", text(hand)?];
        let words = [&words[..], &["--object", text(&mesh)?], more].concat();
        sets.push(made(&folder.join(format!("set_{name}.parquet")), |path| {
            landscape(&[&words[..], &["-q", "-o", text(path)?]].concat())
        })?);
    }
    joined(&sets, path)
}

fn joined(files: &[PathBuf], path: &Path) -> Result<(), Failure> {
    let mut words = vec!["join"];
    for file in files {
        words.push(text(file)?);
    }
    words.extend(["-q", "-o", text(path)?]);
    landscape(&words)
}

fn sorted(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let files = fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let mut files: Vec<PathBuf> = files.collect::<Result<_, Failure>>()?;
    files.sort();
    Ok(files)
}

fn text(path: &Path) -> Result<&str, Failure> {
    Ok(path.to_str().ok_or("a path that is no text")?)
}
