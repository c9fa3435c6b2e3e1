//! A data set of five hands on fifteen objects, surveyed as one job.
//!
//! `cargo run --release --example data_set -- FOLDER` synthesizes 64 chains of each built-in hand on each built-in object into
//! FOLDER/grasps (those of the left hand into FOLDER/mirrored), surveys them with `landscape survey`, and copies the summary
//! and the pictures to `figures/data_set*`. A second survey maps the landscapes of the first 30 grasps of each hand on each
//! object, but for the left hand, which is the mirror image of the human one. Everything that is there already is kept, so
//! that an interrupted run goes on. It takes an hour and a half on two cores.

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
        (all.join("summary.md"), "data_set.md"),
        (all.join("types.png"), "data_set_types.png"),
        (all.join("contacts.png"), "data_set_contacts.png"),
        (all.join("rarefaction.png"), "data_set_rarefaction.png"),
        (mapped.join("summary.md"), "data_set_families.md"),
    ] {
        fs::copy(from, figures.join(to))?;
    }
    Ok(())
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
