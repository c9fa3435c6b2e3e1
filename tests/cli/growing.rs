//! `landscape build --onto`: grasps are added to a finished landscape, or further searches.

use std::fs;
use std::path::Path;

use landscape::store::{LandscapeFiles, read_attempts};
use landscape::topography::{Attempts, Evidence, MinimumId, Start, Tree};

use crate::contents;
use crate::desk::{Desk, assert_says};
use crate::table::rows;

const GROWN: &str = "build g.parquet --onto old.landscape --no-report -q -o new.landscape";

/// A landscape of the first three of six grasps.
fn desk() -> Desk {
    let desk = Desk::with_grasps();
    desk.add_landscape("old.landscape");
    desk
}

fn members(folder: &Path) -> Vec<u64> {
    let minima = LandscapeFiles::read(folder).unwrap().minima;
    let mut members: Vec<u64> = minima.iter().flat_map(|m| m.members.clone()).collect();
    members.sort_unstable();
    members
}

#[test]
fn a_landscape_grows_and_keeps_what_it_knew() {
    let desk = desk();
    let said = desk.succeed(&format!("{GROWN} --threads 1"));
    assert!(said.is_empty(), "{said}");
    let (old, new) = (desk.path("old.landscape"), desk.path("new.landscape"));
    let all = desk.grasps("g.parquet");
    let held = desk.grasps("new.landscape/grasps.parquet");
    assert_eq!(held.grasps, all.grasps, "the landscape holds its grasps");
    assert_eq!(members(&new), [0, 1, 2, 3, 4, 5]);
    let [before, after] = ["old.landscape", "new.landscape"].map(|name| desk.landscape(name));
    let onto = after.manifest.onto.as_ref().unwrap();
    assert_eq!(onto.name, "old.landscape");
    assert_eq!(
        onto.content_hash,
        LandscapeFiles::content_hash(&old).unwrap()
    );
    assert_eq!(
        after.manifest.settings["chain"],
        before.manifest.settings["chain"]
    );
    assert!(after.manifest.counts.evaluations > before.manifest.counts.evaluations);
    let energies = |files: &LandscapeFiles| -> Vec<u64> {
        files.minima.iter().map(|m| m.energy.to_bits()).collect()
    };
    let known = energies(&after);
    for energy in energies(&before) {
        assert!(known.contains(&energy), "the old minima are in the new map");
    }
    let summary = fs::read_to_string(new.join("summary.md")).unwrap();
    assert_says(
        &summary,
        &[
            "grown from old.landscape (3 grasps in ",
            ": 3 grasps added, ",
            "3 grasps of the file were in the landscape already",
            "build g.parquet --onto old.landscape",
        ],
    );
    // The same bytes on other threads and after a kill.
    let once = promised(&desk, "new.landscape");
    fs::remove_dir_all(&new).unwrap();
    desk.interrupt(GROWN, "new.landscape.partial/journal", 2);
    desk.succeed(&format!("{GROWN} --resume --threads 2"));
    assert_eq!(promised(&desk, "new.landscape"), once);
}

/// The files of a landscape that must not depend on threads and interruptions.
fn promised(desk: &Desk, name: &str) -> Vec<Vec<u8>> {
    let mut files = contents(&desk.path(name));
    files.retain(|path, _| !path.ends_with("timings.json"));
    files.into_values().collect()
}

/// Further searches between two minima, without new grasps.
#[test]
fn two_minima_are_connected_with_more_effort() {
    let desk = desk();
    let connect =
        "build old.landscape/grasps.parquet --onto old.landscape --connect m1 m0 --no-report";
    let said = desk.run(&format!("{connect} -o new.landscape")).stdout;
    assert_says(
        &String::from_utf8(said).unwrap(),
        &["m1 and m0: joined at ", "40 further searches, "],
    );
    let [old, new] = ["old.landscape", "new.landscape"].map(|name| {
        let folder = desk.path(name);
        let files = LandscapeFiles::read(&folder).unwrap();
        let attempts = read_attempts(&folder, &files).unwrap();
        let tree = Tree::from_network(&files.network(&folder).unwrap(), Evidence::Chain);
        (files, attempts, tree)
    });
    assert_eq!(new.0.minima.len(), old.0.minima.len());
    let chains = |attempts: &Attempts| {
        let starts = attempts.list.iter().map(|attempt| attempt.start);
        starts
            .filter(|start| matches!(start, Start::Chain { .. }))
            .count()
    };
    assert_eq!(chains(&new.1), chains(&old.1) + 40);
    let joined = |tree: &Tree| tree.minimax(MinimumId(0), MinimumId(1)).unwrap();
    assert!(joined(&new.2) <= joined(&old.2));
    let summary = desk.text("new.landscape/summary.md");
    assert_says(
        &summary,
        &[
            "- m1 and m0: joined at ",
            ": 0 grasps added, ",
            "--connect m1 m0",
        ],
    );
}

#[test]
fn ids_that_are_taken_are_replaced() {
    let desk = desk();
    let mut file = desk.grasps("g.parquet");
    file.grasps.drain(..3);
    for (id, row) in file.grasps.iter_mut().enumerate() {
        row.id = [1, 8, 2][id];
    }
    file.write(&desk.path("more.parquet")).unwrap();
    desk.succeed("build more.parquet --onto old.landscape --no-report -q");
    let new = desk.path("more.landscape");
    assert_eq!(members(&new), [0, 1, 2, 8, 9, 10]);
    let held = desk.grasps("more.landscape/grasps.parquet");
    let pose = |id: u64| {
        let row = held.grasps.iter().find(|row| row.id == id).unwrap();
        row.grasp.pose.clone()
    };
    assert_eq!(pose(9), file.grasps[0].grasp.pose);
    assert_eq!(pose(8), file.grasps[1].grasp.pose);
    let summary = fs::read_to_string(new.join("summary.md")).unwrap();
    assert_says(
        &summary,
        &["2 grasps of the file have new ids in grasps.parquet"],
    );
}

#[test]
fn what_cannot_grow_is_refused_in_one_sentence() {
    let desk = desk();
    desk.add_landscape("bare.landscape");
    fs::remove_file(desk.path("bare.landscape/grasps.parquet")).unwrap();
    desk.succeed("synth --object can -n 2 --steps 1 --keep all -q -o can.parquet");
    desk.write("rough.toml", "[energy.layer]\nfriction = 0.3\n");
    desk.succeed(
        "synth --object ball -n 2 --steps 1 --keep all -q --config rough.toml -o rough.parquet",
    );
    desk.succeed("surface muller-brown --no-report -q -o surface.landscape");
    desk.write("few.toml", "[map.chain]\npatience = 120\n");
    desk.succeed("build g.parquet --first 2 --search adelm --config few.toml --no-report -q -o order.landscape");
    let cases = "
        g.parquet --first 3 --onto old.landscape -o new.landscape | old.landscape contains all these grasps already
        g.parquet --onto old.landscape -o old.landscape | old.landscape
        g.parquet --onto g.parquet | is a file, but a landscape is a folder
        g.parquet --onto nowhere | nowhere
        g.parquet --onto bare.landscape | grasps.parquet
        g.parquet --onto old.landscape --connect m0 m9 | --connect m9: there are | minima, m0 to m
        g.parquet --onto old.landscape --connect m1 1 | --connect m1 1: name two different minima
        g.parquet --onto old.landscape --connect m1 g0 | --connect g0: write minima as the tree names them
        g.parquet --connect m0 m1 | --onto <LANDSCAPE>
        g.parquet --onto old.landscape --connect m0 | 2 values required for '--connect <FROM> <TO>'
        g.parquet --onto old.landscape --neighbours 3 | '--onto <LANDSCAPE>' cannot be used with '--neighbours <K>'
        can.parquet --onto old.landscape | can.parquet | no grasp is of the same hand, object and size as old.landscape | `ball`
        rough.parquet --onto old.landscape | old.landscape is a landscape of another energy
        g.parquet --onto surface.landscape | surface.landscape is a landscape of a surface
        g.parquet --onto order.landscape | order.landscape was made by sequential ADELM
        g.parquet --search adelm --family-barrier 0.1 -o none | --family-barrier: the burn-in of `adelm` makes the families
    ";
    for case in rows(cases) {
        let sentence = desk.early_mistake(&format!("build {}", case[0]));
        assert_says(&sentence, &case[1..]);
    }
}
