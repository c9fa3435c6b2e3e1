//! `landscape join`: files of grasps put together.

use std::fs;

use landscape::store::GraspRow;

use crate::desk::{Desk, assert_says};
use crate::table::rows;

const FEW: &str = "--steps 1 --keep all -q";

/// Two hands on two objects: every value of a row but its id and source stays, and the other commands read the result.
#[test]
fn joined_files_are_one() {
    let desk = Desk::with_grasps();
    desk.succeed(&format!(
        "synth --hand gripper_parallel --object ball -n 3 {FEW} -o ball.parquet"
    ));
    desk.succeed(&format!("synth --object can -n 2 {FEW} -o can.parquet"));
    let said = desk.print("join g.parquet ball.parquet can.parquet -o all.parquet");
    assert_says(
        &said,
        &["g.parquet", "ball.parquet", "human, gripper_parallel"],
    );
    let parts = ["g", "ball", "can"].map(|name| desk.grasps(&format!("{name}.parquet")));
    let all = desk.grasps("all.parquet");
    let sources = ["g.parquet", "ball.parquet", "can.parquet"];
    let expected: Vec<GraspRow> = (parts.iter().zip(sources))
        .flat_map(|(part, name)| part.grasps.iter().map(move |row| (row, name)))
        .zip(0..)
        .map(|((row, name), id)| GraspRow {
            id,
            source: match row.source.as_str() {
                "" => format!("{name} {}", row.id),
                before => format!("{name} {}: {before}", row.id),
            },
            ..row.clone()
        })
        .collect();
    assert_eq!(all.grasps, expected);
    assert_eq!(all.landscapes().len(), 3);
    let metadata = &all.metadata;
    assert_eq!(
        metadata.command,
        "landscape join g.parquet ball.parquet can.parquet"
    );
    assert_eq!(metadata.inputs.len(), 3);
    assert_eq!(metadata.earlier.len(), 3);
    assert!(
        metadata.earlier[1]
            .command
            .contains("--hand gripper_parallel")
    );
    // The checksum is right, and the next command reads all of it.
    desk.succeed("label all.parquet -q -o labelled.parquet");
    assert_eq!(
        desk.grasps("labelled.parquet").grasps.len(),
        all.grasps.len()
    );
    desk.succeed("survey all.parquet --no-map -q -o all.survey");
    let summary = desk.text("all.survey/summary.md");
    assert_says(&summary, &["2 hands on 2 objects"]);
}

#[test]
fn repeated_grasps_are_told() {
    let desk = Desk::with_grasps();
    fs::copy(desk.path("g.parquet"), desk.path("copy.parquet")).unwrap();
    let said = desk.succeed("join g.parquet copy.parquet");
    assert_says(
        &said,
        &[
            "6 grasps repeat another one bit for bit",
            "copy.parquet 0",
            "is g.parquet 0",
            "another --seed",
            "wrote g.joined.parquet",
        ],
    );
    assert_eq!(desk.grasps("g.joined.parquet").grasps.len(), 12);
}

#[test]
fn what_cannot_be_one_file_is_refused() {
    let desk = Desk::with_grasps();
    desk.write("mine.parquet", "mine");
    // Another energy, and another object of the same name.
    desk.write("rough.toml", "[energy.layer]\nfriction = 0.3\n");
    desk.succeed(&format!(
        "synth --object ball -n 1 --config rough.toml {FEW} -o rough.parquet"
    ));
    let object = &desk.grasps("g.parquet").metadata.objects[0].name;
    desk.succeed(&format!(
        "synth --object can --name {object} -n 1 {FEW} -o other.parquet"
    ));
    let cases = "
        join g.parquet | g.parquet is one file | two or more
        join g.parquet absent.parquet | absent.parquet
        join g.parquet g.parquet -o g.parquet | g.parquet is an input
        join g.parquet g.parquet -o mine.parquet | mine.parquet exists | --force
        join g.parquet rough.parquet | g.parquet and rough.parquet are of different energies | one --config
        join g.parquet other.parquet | g.parquet and other.parquet both have an object | ball | --name
    ";
    for case in rows(cases) {
        assert_says(&desk.early_mistake(case[0]), &case[1..]);
    }
}
