//! `landscape surface` as a user runs it: models, interruptions, and mistakes.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use crate::desk::{Desk, assert_says, failure};
use crate::folder::names;
use crate::table::rows;
use landscape::store::{LandscapeFiles, StationaryRow};

#[path = "surface/adelm.rs"]
mod adelm;
#[path = "surface/bounds.rs"]
mod bounds;
#[path = "surface/connect.rs"]
mod connect;
#[path = "surface/extent.rs"]
mod extent;
#[path = "surface/programs.rs"]
mod programs;

impl Desk {
    /// What a search that must succeed prints.
    fn mapped(&self, line: &str) -> String {
        self.print(&format!("surface {line}"))
    }

    /// Runs a command that must fail and returns its standard error.
    fn failure(&self, line: &str) -> String {
        failure(&self.run(line), line)
    }

    /// The message of a mistake that leaves no files.
    fn unmapped(&self, line: &str) -> String {
        let before = names(self.folder.path());
        let said = self.failure(&format!("surface {line}"));
        assert_eq!(names(self.folder.path()), before, "{line}");
        said
    }

    fn stationary(&self, name: &str) -> Vec<StationaryRow> {
        StationaryRow::read(&self.path(name)).unwrap()
    }

    /// Kills a search as soon as its journal in `cut.partial` contains these bytes.
    fn kill_at(&self, line: &str, record: &[u8]) {
        let mut child = self.command(&format!("surface {line}"));
        let mut child = child.stderr(Stdio::null()).spawn().unwrap();
        let journal = self.path("cut.partial/journal");
        let began = |bytes: Vec<u8>| bytes.windows(record.len()).any(|part| part == record);
        while !fs::read(&journal).is_ok_and(began) {
            let ended = child.try_wait().unwrap();
            assert_eq!(ended, None, "ended before it was killed");
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        assert!(!child.wait().unwrap().success());
    }
}

/// The files that must not depend on threads and interruptions.
fn promised(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = names(folder)
        .into_iter()
        .filter(|name| name != "timings.json");
    files
        .map(|name| (name.clone(), fs::read(folder.join(name)).unwrap()))
        .collect()
}

#[test]
fn a_model_is_mapped() {
    let desk = Desk::empty();
    let text = desk.mapped("lj 6 --threads 1");
    assert_says(
        &text,
        &["**2 minima** and **3 saddles**, 2 of which join two copies"],
    );
    assert_eq!(names(desk.folder.path()), ["lj-6.landscape"]);
    let folder = desk.path("lj-6.landscape");
    let written = "barriers.graphml barriers.png barriers.svg disconnectivity.png disconnectivity.svg edges.parquet \
                   landscape.json min.data minima.parquet paths.parquet points.min points.ts rarefaction.png rarefaction.svg \
                   report.html stationary.parquet summary.md timings.json tree.dot tree.json tree.nwk ts.data";
    assert_eq!(names(&folder).join(" "), written);
    let files = LandscapeFiles::read(&folder).unwrap();
    assert_eq!((files.minima.len(), files.edges.len()), (2, 1));
    assert!((files.edges[0].height.unwrap() + 12.079031).abs() < 1e-5);
    assert_eq!(files.edges[0].evidence, "saddle");
    let rows = StationaryRow::read(&folder).unwrap();
    let ends: Vec<_> = rows.iter().map(|row| (row.index, row.ends)).collect();
    assert_eq!(
        ends,
        [
            (0, [0, 0]),
            (0, [1, 1]),
            (1, [0, 1]),
            (1, [1, 1]),
            (1, [1, 1])
        ]
    );
    assert!(
        rows.iter()
            .all(|row| row.curvatures.len() == 12 && row.verdict == "sound")
    );
    // Another number of threads, the same bytes.
    desk.mapped("lj 6 --threads 3 -o again.landscape");
    assert_eq!(promised(&folder), promised(&desk.path("again.landscape")));
}

#[test]
fn a_single_minimum_makes_a_landscape_too() {
    let desk = Desk::empty();
    let text = desk.mapped("lj 4 -q -o four");
    assert!(text.is_empty());
    let summary = desk.text("four/summary.md");
    assert_says(&summary, &["**1 minimum** and **1 saddle**"]);
}

#[test]
fn an_interrupted_search_continues() {
    let desk = Desk::empty();
    let search = "lj 7 -q --threads 1 --patience 60 -o";
    desk.mapped(&format!("{search} whole"));
    let cut = format!("{search} cut");
    desk.kill_at(&cut, b"search/1");
    desk.mapped(&cut);
    assert_eq!(promised(&desk.path("whole")), promised(&desk.path("cut")));
}

#[test]
fn mistakes_are_told() {
    let desk = Desk::empty();
    let cases = "
        ising | no model is called `ising`; the models are muller-brown
        lj seven | write `lj N`
        lj 7 --patience 0 | --patience 0
        lj 7 --region=-1:1 | has 21 coordinates, not 1
        muller-brown --region=-1:1,2 | `2` is not low:high
        muller-brown -o no/where | the folder no does not exist
        --command cat | --region
        --command cat --region=0:1x9 --elements Ar3 | give `--coordinates atoms`
        --command cat --region=0:1x9 --coordinates atoms --elements Ar2 | 9 coordinates for 2 atoms
        lj 7 --elements Ar7 | --command
    ";
    for case in rows(cases) {
        assert_says(&desk.unmapped(case[0]), &case[1..]);
    }
    assert!(desk.unmapped("").contains("MODEL"));
}

#[test]
fn the_help_teaches() {
    let text = Desk::empty().print("surface --help");
    let parts = [
        "muller-brown",
        "lj N",
        "{\"x\": [0.5, -1.25]}",
        "stationary.parquet",
    ];
    assert_says(&text, &parts);
}
