//! A tiny experiment from synthesis to pictures.

use std::collections::BTreeSet;
use std::fs;

use crate::desk::{Desk, assert_says};
use crate::{built, has_ending, held_grasps, landscape, names};
use landscape::store::LandscapeFiles;
use serde_json::Value;

#[test]
fn a_tiny_experiment() {
    let folder = landscape().path("g.landscape");
    let found = names(&folder);
    let expected = "barriers.graphml barriers.png barriers.svg disconnectivity.png disconnectivity.svg edges.parquet \
                    landscape.json minima.parquet paths.parquet rarefaction.svg summary.md timings.json tree.nwk";
    for name in expected.split(' ') {
        assert!(found.iter().any(|file| file == name), "{name} of {found:?}");
    }
    assert!(
        !found
            .iter()
            .any(|name| name.ends_with(".partial") || name == "journal")
    );
    let text = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    for name in found.iter().filter(|name| has_ending(name, "svg")) {
        assert_says(
            &text(name),
            &["<svg", "<text", "3 grasps, human hand on ball"],
        );
    }

    let manifest: Value = serde_json::from_str(&text("landscape.json")).unwrap();
    assert_eq!(manifest["format"], "landscape");
    let files = LandscapeFiles::read(&folder).unwrap();
    let counts = &files.manifest.counts;
    assert_eq!(manifest["counts"]["minima"], counts.minima);
    assert_eq!(counts.grasps, 3);
    assert_eq!(counts.minima, files.minima.len() as u64);
    assert_eq!(counts.pairs, files.edges.len() as u64);
    assert!((2..=counts.grasps).contains(&counts.minima));
    assert!((1..=counts.minima).contains(&counts.families));
    assert!((1..=counts.families).contains(&counts.components));
    assert!(
        counts.pairs >= counts.minima - 1,
        "a spanning tree at least"
    );
    assert_eq!(files.manifest.evidence.values().sum::<u64>(), counts.pairs);
    let members: BTreeSet<u64> = files
        .minima
        .iter()
        .flat_map(|row| row.members.clone())
        .collect();
    assert_eq!(members.into_iter().collect::<Vec<_>>(), [0, 1, 2]);
    let tree = text("tree.nwk");
    for minimum in &files.minima {
        assert!(tree.contains(&format!("m{}", minimum.id)), "{tree}");
    }
    assert!(tree.trim_end().ends_with(';'));
    assert_says(
        &text("summary.md"),
        &["# 3 grasps of the human hand on ball", "minima"],
    );
}

/// Families are made at what it costs to put one phalanx on the object. Three grasps are too few to estimate unseen families.
/// Pictures name families as `inspect --path` does.
#[test]
fn families_of_grasps() {
    let folder = landscape().path("g.landscape");
    let text = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let manifest: Value = serde_json::from_str(&text("landscape.json")).unwrap();
    let barrier = manifest["family_barrier"].as_f64().unwrap();
    assert!(
        barrier < manifest["letting_go"].as_f64().unwrap(),
        "{barrier}"
    );
    let summary = text("summary.md");
    assert_says(
        &summary,
        &[
            "what it costs to put one resting phalanx on the object",
            "3 grasps are too few to estimate it",
        ],
    );
    assert!(!summary.contains("Chao1"));
    let named: String = text("barriers.svg").split_whitespace().collect();
    assert!(named.contains(">g0<"));
}

/// Every command that makes families accepts a family barrier.
#[test]
fn families_at_a_given_barrier() {
    let desk = landscape();
    let out = Desk::empty();
    let folder = desk.path("g.landscape");
    let g = folder.display();
    let files = LandscapeFiles::read(&folder).unwrap();
    let family_of = |files: &LandscapeFiles| -> Vec<u64> {
        files.minima.iter().map(|row| row.family).collect()
    };
    let apart: Vec<u64> = (0..files.minima.len() as u64).collect();
    let grasps = desk.path("g.parquet");
    out.succeed(&format!(
        "build {} --first 3 --family-barrier 1e9 --no-report -q -o one.landscape",
        grasps.display()
    ));
    let built = out.landscape("one.landscape");
    assert!(family_of(&built).iter().all(|family| *family == 0));
    assert_eq!(built.manifest.family_barrier, Some(1e9));
    assert_says(&built.manifest.command, &["--family-barrier 1"]);
    // Drawn again at another barrier, as it would have been drawn at once, but for the names of the families, which are those of
    // the map.
    out.succeed(&format!("draw {g} --family-barrier 1e9 -q -o view"));
    out.succeed("draw one.landscape --family-barrier 1e9 -q -o again");
    let text = |name: &str| out.text(name);
    let picture = text("one.landscape/disconnectivity.svg");
    assert_eq!(text("again/disconnectivity.svg"), picture);
    let graph = |text: &str| -> Vec<String> {
        let lines = text
            .lines()
            .filter(|line| line.starts_with("<line") || line.starts_with("<circle"));
        lines.map(str::to_owned).collect()
    };
    assert!(!graph(&picture).is_empty());
    assert_eq!(graph(&text("view/disconnectivity.svg")), graph(&picture));
    out.add_database("data");
    out.succeed("import data --family-barrier 0 --no-report");
    let read = out.landscape("data.landscape");
    assert_eq!(family_of(&read), apart);
    out.succeed("surface double-well 1 --family-barrier 1e9 --no-report -q -o wells.landscape");
    let wells = out.landscape("wells.landscape");
    assert_eq!((wells.minima.len(), wells.manifest.counts.families), (2, 1));
    for line in [
        format!("draw {g} -o x"),
        format!("compare {g} -o x"),
        format!("build {} -o x", grasps.display()),
    ] {
        let sentence = out.mistake(&format!("{line} --family-barrier -1"));
        assert_says(&sentence, &["--family-barrier -1", "0 or more"]);
    }
}

#[test]
fn what_held_in_simulation_is_mapped_and_marked() {
    let desk = Desk::with_grasps();
    let sentence = desk.early_mistake("build g.parquet --only-stable");
    assert_says(&sentence, &["--only-stable", "landscape stability"]);
    desk.write("held.parquet", held_grasps());
    let judged = desk.grasps("held.parquet");
    let ids = |stable: bool| -> BTreeSet<u64> {
        let grasps = judged.grasps.iter();
        grasps
            .filter(|grasp| grasp.stable == Some(stable))
            .map(|grasp| grasp.id)
            .collect()
    };
    let (stable, unstable) = (ids(true), ids(false));
    assert!(
        stable.len() > 1 && !unstable.is_empty(),
        "{stable:?} {unstable:?}"
    );

    desk.succeed("build held.parquet --only-stable --no-report -q -o held.landscape");
    let files = desk.landscape("held.landscape");
    let members = files.minima.iter().flat_map(|row| row.members.clone());
    assert_eq!(members.collect::<BTreeSet<u64>>(), stable);

    desk.succeed("build g.parquet --no-report -q -o all.landscape");
    let sentence = desk.mistake("draw all.landscape --stability g.parquet");
    assert_says(
        &sentence,
        &["--stability g.parquet", "no grasp was simulated"],
    );
    desk.succeed("draw all.landscape --stability held.parquet -q -o marked");
    desk.succeed("draw all.landscape -q -o plain");
    let files = desk.landscape("all.landscape");
    let held: Vec<bool> = files
        .minima
        .iter()
        .map(|row| {
            let held = row.members.iter().filter(|id| stable.contains(id)).count();
            2 * held >= row.members.len()
        })
        .collect();
    for name in ["barriers_minima.svg", "disconnectivity_minima.svg"] {
        let [marked, plain] = ["marked", "plain"]
            .map(|folder| fs::read_to_string(desk.path(folder).join(name)).unwrap());
        for (word, expected) in [
            (">stable", held.contains(&true)),
            (">unstable", held.contains(&false)),
        ] {
            let squeezed: String = marked.split_whitespace().collect();
            assert_eq!(squeezed.contains(word), expected, "{word} in {name}");
            let squeezed: String = plain.split_whitespace().collect();
            assert!(!squeezed.contains(word), "{word} in the plain {name}");
        }
    }
}

/// The first lines answer the question, and statistics follow for those who ask.
#[test]
fn first_lines_answer_the_question() {
    let desk = Desk::empty();
    let printed = |line: &str| desk.print(line);
    let synth = "synth --object ball -n 3 --steps 1 --keep all --drop 2";
    let brief = printed(&format!("{synth} -o s.parquet"));
    let lines: Vec<&str> = brief.lines().collect();
    assert_eq!(
        lines[0],
        "wrote 3 grasps of the human hand on ball from 3 chains to s.parquet"
    );
    assert!(
        lines.len() == 2 && lines[1].ends_with("(2 of 3 grasps were dropped)"),
        "{brief}"
    );
    let full = printed("synth --object ball -n 1 --steps 1 --keep all --drop 0 -v -o v.parquet");
    assert_says(&full, &["as printed", "evaluations", "wrote 1 grasp"]);

    let (desk, brief) = built();
    let files = desk.landscape("g.landscape");
    let counts = files.manifest.counts;
    let families = if counts.families == 1 {
        "family"
    } else {
        "families"
    };
    let headline = format!(
        "3 grasps of the human hand on ball are {} different ones in {} {families}; to estimate how many families are missing, \
         30 grasps are needed.",
        counts.minima, counts.families
    );
    let first = brief.lines().next().unwrap();
    assert_eq!(first, format!("{headline} Open g.landscape/report.html"));
    assert!(
        !brief.contains("raw chains") && brief.contains("g.landscape/summary.md"),
        "{brief}"
    );
    let summary = desk.text("g.landscape/summary.md");
    assert_says(
        &summary,
        &[
            &headline,
            "**different grasps** are the minima",
            "Each is the lowest pass found",
            "but a lower one may exist",
            "## Largest families",
        ],
    );
}
