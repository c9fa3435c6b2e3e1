//! Files of settings for `build` and `surface`, and what `config` prints for them.

use std::fs;

use serde_json::Value;

use crate::desk::{Desk, assert_says};
use crate::table::rows;
use crate::{BUILD, built, landscape, promised};

/// The settings that a landscape records.
fn recorded(desk: &Desk, folder: &str) -> Value {
    let text = fs::read_to_string(desk.path(folder).join("landscape.json")).unwrap();
    serde_json::from_str::<Value>(&text).unwrap()["settings"].clone()
}

/// The printed file changes nothing but the recorded command, and the files that name it.
#[test]
fn a_printed_file_gives_the_same_landscape() {
    let desk = Desk::with_grasps();
    desk.write("mine.toml", desk.print("config build"));
    desk.succeed(&format!(
        "{BUILD} --config mine.toml --no-report -o g.landscape"
    ));
    let (found, usual) = (
        promised(&desk.path("g.landscape")),
        promised(&landscape().path("g.landscape")),
    );
    for name in "minima.parquet edges.parquet paths.parquet tree.nwk barriers.graphml".split(' ') {
        assert!(found[name] == usual[name], "{name}");
    }
    assert_eq!(
        recorded(&desk, "g.landscape")["map"],
        recorded(landscape(), "g.landscape")["map"]
    );
}

/// Settings reach the map, and flags override them.
#[test]
fn settings_of_a_file_are_used() {
    let desk = Desk::with_grasps();
    desk.write("mine.toml", "temperature = 0.03\nforce = 90.0\n[map]\nneighbours = 2\nseed = 7\n[map.path]\nsegments = 9\n");
    desk.succeed(&format!(
        "{BUILD} --config mine.toml --neighbours 1 --no-report -o a.landscape"
    ));
    let text = recorded(&desk, "a.landscape").to_string();
    for part in [
        "\"neighbours\":1",
        "\"segments\":9",
        "\"seed\":7",
        "0.03",
        "90.0",
    ] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
    let plain = "surface muller-brown -q --no-report";
    desk.succeed(&format!("{plain} -o usual.landscape"));
    desk.write("printed.toml", desk.print("config surface"));
    desk.succeed(&format!("{plain} --config printed.toml -o same.landscape"));
    assert_eq!(
        desk.bytes("usual.landscape/stationary.parquet"),
        desk.bytes("same.landscape/stationary.parquet")
    );
    desk.write(
        "few.toml",
        "[search]\npatience = 2\nmax_searches = 32\nseed = 5\n",
    );
    desk.succeed(&format!(
        "{plain} --config few.toml --searches 64 -o few.landscape"
    ));
    let text = recorded(&desk, "few.landscape").to_string();
    for part in ["\"patience\":2", "\"max_searches\":64", "\"seed\":5"] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
}

#[test]
fn mistakes_in_files_of_settings() {
    let desk = Desk::with_grasps();
    desk.write("typo.toml", "[map]\nneigbours = 3\n");
    desk.write("huge.toml", "[map]\nsearches = 4000000000\n");
    desk.write("few.toml", "[search]\nsteps = 0\n");
    let cases = "
        build g.parquet --config typo.toml | typo.toml | line 2 | neigbours
        build g.parquet --config huge.toml | huge.toml | map.searches = 4e9 | is not from
        build g.parquet --config absent.toml | cannot read | absent.toml
        surface muller-brown --config typo.toml | typo.toml | line 1 | landscape config surface
        surface muller-brown --config few.toml | few.toml | search.steps = 0 | is not from 1
        config surface --protocol drop | --protocol | stability
    ";
    for case in rows(cases) {
        let sentence = desk.early_mistake(case[0]);
        assert_says(&sentence, &case[1..]);
        // The mistake is not one of the grasps.
        assert!(!sentence.contains("g.parquet"), "{sentence}");
    }
}

/// `--verbose` tells what is done and why on standard error, and nothing else changes.
#[test]
fn verbose_runs_tell_what_they_do() {
    let desk = Desk::with_grasps();
    let (told, said) = desk.both(&format!("{BUILD} -v"));
    assert!(
        built().1.starts_with(told.lines().next().unwrap()),
        "{told}"
    );
    assert_says(&told, &["raw chains"]);
    assert_says(
        &said,
        &[
            "files will record this command: landscape build g.parquet --first 3",
            "read 6 grasps from g.parquet",
            "settings of the map: ",
            "finished tasks are kept in g.landscape.partial/journal",
            "stage connect ended after",
            "temperature and force of the chains:",
        ],
    );
    assert_eq!(
        promised(&desk.path("g.landscape")),
        promised(&landscape().path("g.landscape"))
    );
    let said = desk.succeed("surface muller-brown -v --no-report");
    assert_says(
        &said,
        &["settings of the search: ", "the whole is searched for"],
    );
    assert_says(
        &desk.early_mistake("surface muller-brown -v -q"),
        &["--verbose", "--quiet"],
    );
}
