//! A data set of five hands on fifteen objects, surveyed as one job.
//!
//! `cargo run --release --example data_set -- FOLDER` synthesizes 24 chains of each built-in hand on each built-in object into
//! FOLDER/grasps (those of the left hand into FOLDER/mirrored), surveys them with `landscape survey`, and copies the summary
//! and the pictures to `figures/data_set*`; the objects of the survey become a CSV. A second survey maps the landscapes of the
//! first 16 grasps of the human hand on each object. (Maps of the other hands take hours.) Everything that is there already is
//! kept, so that an interrupted run goes on. It takes some two hours of processor time, forty minutes of them for
//! the maps.

use std::fs;
use std::path::{Path, PathBuf};

use landscape::cli::{Stop, call};
use landscape::hand::HAND_NAMES;
use landscape::object::OBJECT_NAMES;
use serde_json::Value;

const CHAINS: &str = "24";
/// Grasps of the human hand on each object that are mapped.
const FIRST: &str = "16";

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let folder = std::env::args().nth(1).map(PathBuf::from);
    let folder = folder.ok_or("name the folder for the grasps")?;
    let [grasps, mirrored] = ["grasps", "mirrored"].map(|name| folder.join(name));
    for hand in HAND_NAMES {
        let kept = if hand == "human_left" {
            &mirrored
        } else {
            &grasps
        };
        let of_hand = kept.join(hand);
        fs::create_dir_all(&of_hand)?;
        for object in OBJECT_NAMES {
            let output = of_hand.join(format!("{object}.parquet"));
            if !output.exists() {
                let words = [
                    "synth", "--hand", hand, "--object", object, "-n", CHAINS, "-o",
                ];
                match run(&words, &output) {
                    // A parallel gripper cannot hold the widest objects.
                    Err(error)
                        if error
                            .to_string()
                            .contains(&format!("none of the {CHAINS} chains")) =>
                    {
                        println!("{hand} on {object}: {error}");
                    }
                    ended => ended?,
                }
            }
        }
    }
    let all = folder.join("all.survey");
    let both = [text(&grasps)?, text(&mirrored)?];
    run(&["survey", both[0], both[1], "--no-map", "-o"], &all)?;
    let figures = Path::new(env!("CARGO_MANIFEST_DIR")).join("figures");
    for picture in ["types", "contacts", "rarefaction"] {
        let to = figures.join(format!("data_set_{picture}.png"));
        fs::copy(all.join(format!("{picture}.png")), to)?;
    }
    report(&all, &figures, "data_set")?;
    let mapped = folder.join("mapped.survey");
    let human = grasps.join("human");
    let words = [
        "survey",
        text(&human)?,
        "--first",
        FIRST,
        "--no-report",
        "-o",
    ];
    run(&words, &mapped)?;
    report(&mapped, &figures, "data_set_families")
}

/// Writes the summary of a survey without its objects, and these as a table.
fn report(survey: &Path, figures: &Path, name: &str) -> Result<(), Failure> {
    let summary = fs::read_to_string(survey.join("summary.md"))?;
    let told = format!("The objects of each hand: [{name}.csv]({name}.csv).");
    let mut parts: Vec<&str> = summary.split("\n\n").collect();
    parts.retain(|part| !part.starts_with("| object |"));
    parts.insert(1, &told);
    fs::write(figures.join(format!("{name}.md")), parts.join("\n\n"))?;
    let numbers = serde_json::from_slice(&fs::read(survey.join("survey.json"))?)?;
    fs::write(figures.join(format!("{name}.csv")), objects(&numbers))?;
    Ok(())
}

/// One row for each hand and object of a survey. Unknown values are empty.
fn objects(survey: &Value) -> String {
    let mut table = "hand,object,grasps,minima,families,families unseen,next known,types,cells,sets of contact regions,\
                     effective types,effective families,usual types that lack\n"
        .to_owned();
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    for hand in list(&survey["hands"]) {
        let own = list(&survey["populations"]).into_iter();
        for one in own.filter(|one| one["hand"] == hand["hand"]) {
            let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
            let whole = |value: &Value| value.as_u64().map_or(String::new(), |n| n.to_string());
            let kinds = |value: &Value| {
                let kinds = value.as_object();
                kinds.map_or(String::new(), |kinds| kinds.len().to_string())
            };
            let rounded = |value: &Value| value.as_f64().map(|number| format!("{number:.1}"));
            let (map, complete) = (&one["map"], &one["completeness"]);
            let families = map["families"].as_array();
            let unseen = complete["unseen"].as_f64().map_or(String::new(), |unseen| {
                let [low, high] = [0, 1].map(|end| complete["unseen_interval"][end].as_f64());
                let [low, high] = [low, high].map(Option::unwrap_or_default);
                format!("{unseen:.0} ({low:.0} to {high:.0})")
            });
            let known = complete["coverage"].as_f64();
            let missing = list(&hand["missing_types"][text(&one["name"])]);
            let mut missing = missing.iter().map(text).collect::<Vec<_>>().join(", ");
            if missing.contains(',') {
                missing = format!("\"{missing}\"");
            }
            let cells = [
                text(&one["hand"]),
                text(&one["object"]),
                whole(&one["grasps"]),
                whole(&map["minima"]),
                families.map_or(String::new(), |families| families.len().to_string()),
                unseen,
                known.map_or(String::new(), |known| format!("{:.0} %", 100.0 * known)),
                kinds(&one["types"]),
                kinds(&one["cells"]),
                kinds(&one["contacts"]),
                rounded(&one["effective"]["types"][1]).unwrap_or_default(),
                rounded(&one["effective"]["families"][1]).unwrap_or_default(),
                missing,
            ];
            table += &(cells.join(",") + "\n");
        }
    }
    table
}

/// Runs a command of the program that writes `output`, with its progress on standard error.
fn run(words: &[&str], output: &Path) -> Result<(), Failure> {
    let words = ["landscape"].iter().chain(words).copied();
    call(words.chain([text(output)?]), true, &Stop::default())?;
    Ok(())
}

fn text(path: &Path) -> Result<&str, Failure> {
    Ok(path.to_str().ok_or("the path is not text")?)
}
