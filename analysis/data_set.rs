//! A data set of five hands on fifteen objects, surveyed as one job.
//!
//! `cargo run --release --example data_set -- FOLDER` synthesizes 64 chains of each built-in hand on each built-in object into
//! FOLDER/grasps (those of the left hand into FOLDER/mirrored), surveys them with `landscape survey`, and copies the summary
//! and the pictures to `figures/data_set*`; the summary's tables of objects become a CSV. A second survey maps the landscapes of the first 30 grasps of each hand on each
//! object, but for the left hand, which is the mirror image of the human one. Everything that is there already is kept, so
//! that an interrupted run goes on. It takes an hour and a half on two cores.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use landscape::cli::{Stop, call};
use landscape::hand::HAND_NAMES;
use landscape::object::OBJECT_NAMES;

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
                    "synth", "--hand", hand, "--object", object, "-n", "64", "-o",
                ];
                match run(&words, &output) {
                    // A parallel gripper cannot hold the widest objects.
                    Err(error) if error.to_string().contains("none of the 64 chains") => {
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
    let mapped = folder.join("mapped.survey");
    let words = ["survey", both[0], "--first", "30", "--no-report", "-o"];
    run(&words, &mapped)?;

    let figures = Path::new(env!("CARGO_MANIFEST_DIR")).join("figures");
    for (from, to) in [
        (all.join("types.png"), "data_set_types.png"),
        (all.join("contacts.png"), "data_set_contacts.png"),
        (all.join("rarefaction.png"), "data_set_rarefaction.png"),
    ] {
        fs::copy(from, figures.join(to))?;
    }
    for (survey, name) in [(all, "data_set"), (mapped, "data_set_families")] {
        let summary = fs::read_to_string(survey.join("summary.md"))?;
        let [text, table] = divided(&summary, name);
        fs::write(figures.join(format!("{name}.md")), text)?;
        fs::write(figures.join(format!("{name}.csv")), table)?;
    }
    Ok(())
}

/// Columns of the tables of objects; those of some hands lack some of them.
const COLUMNS: [&str; 12] = [
    "object",
    "grasps",
    "minima",
    "families",
    "families unseen",
    "next known",
    "types",
    "cells",
    "sets of contact regions",
    "effective types",
    "effective families",
    "usual types that lack",
];

/// A summary without its tables of objects, and these as one CSV.
fn divided(summary: &str, name: &str) -> [String; 2] {
    let mut text = String::new();
    let mut table = format!("hand,{}\n", COLUMNS.join(","));
    let (mut hand, mut columns) = ("", Vec::new());
    for line in summary.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            hand = title.split(':').next().unwrap_or(title);
        }
        let cells = line.trim_matches('|').split('|').map(str::trim);
        let cells: Vec<&str> = cells.collect();
        if line.starts_with("| object |") {
            columns = cells;
        } else if !line.starts_with('|') {
            columns.clear();
            // The blank line after a table goes with it.
            if !(line.is_empty() && text.ends_with("\n\n")) {
                text += line;
                text.push('\n');
            }
            if line.starts_with("# ") {
                let _ = writeln!(
                    text,
                    "\nThe objects of each hand: [{name}.csv]({name}.csv)."
                );
            }
        } else if columns.is_empty() {
            text += line;
            text.push('\n');
        } else if !line.starts_with("| ---") {
            let of = |column: &&str| {
                let place = columns.iter().position(|own| own == column);
                let cell = place.and_then(|place| cells.get(place)).copied();
                let cell = cell.unwrap_or_default();
                if cell.contains(',') {
                    format!("\"{cell}\"")
                } else {
                    cell.to_owned()
                }
            };
            let row: Vec<String> = COLUMNS.iter().map(of).collect();
            let _ = writeln!(table, "{hand},{}", row.join(","));
        }
    }
    [text, table]
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
