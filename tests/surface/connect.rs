//! `landscape surface --connect`: further searches between two minima.

use std::fs;

use landscape::store::LandscapeFiles;
use landscape::topography::{Evidence, MinimumId, Tree};

use super::promised;
use crate::desk::Desk;

/// A search of nine atoms that is stopped long before it has found most of 21 minima and 165 saddles.
const SHORT: [&str; 8] = [
    "lj",
    "9",
    "--search",
    "all",
    "--searches",
    "64",
    "--no-report",
    "-q",
];

/// Height at which two minima of a folder merge.
fn joined(desk: &Desk, folder: &str, [a, b]: [usize; 2]) -> Option<f64> {
    let folder = desk.path(folder);
    let files = LandscapeFiles::read(&folder).unwrap();
    let network = files.network(&folder).unwrap();
    let tree = Tree::from_network(&network, Evidence::Chain);
    tree.minimax(MinimumId(a), MinimumId(b))
}

/// The line of a summary that tells of the further searches.
fn told(desk: &Desk, folder: &str) -> String {
    let text = fs::read_to_string(desk.path(folder).join("summary.md")).unwrap();
    let line = text.lines().find(|line| line.contains("further search"));
    line.expect("the searches are told").to_owned()
}

#[test]
fn a_lower_way_is_found() {
    let desk = Desk::empty();
    desk.mapped(&[&SHORT[..], &["-o", "plain"]].concat());
    let connect = [&SHORT[..], &["--connect", "m0", "m5"]].concat();
    desk.mapped(&[&connect[..], &["--threads", "1", "-o", "more"]].concat());
    let [before, now] = ["plain", "more"].map(|folder| joined(&desk, folder, [0, 5]).unwrap());
    assert!(now < before - 0.1, "{before} {now}");
    let line = told(&desk, "more");
    let expected =
        format!("- m0 and m5: joined at {now:.6} (before {before:.6}); 40 further searches, ");
    assert!(line.starts_with(&expected), "{line}");
    assert!(line.contains("the chance of a lower way is"), "{line}");
    // Other threads, and an interruption among the further searches.
    let cut = [&connect[..], &["--threads", "2", "-o", "cut"]].concat();
    desk.kill_at(&cut, b"connect/0-5/chains/search/9");
    desk.mapped(&[&cut[..], &["--resume"]].concat());
    assert_eq!(promised(&desk.path("more")), promised(&desk.path("cut")));
}

#[test]
fn two_components_are_joined() {
    let desk = Desk::empty();
    let run = |more: &[&str]| {
        let mut arguments = SHORT;
        arguments[1] = "10";
        desk.mapped(&[&arguments[..], more].concat());
    };
    run(&["-o", "plain"]);
    run(&["--connect", "m7", "m2", "-o", "more"]);
    assert_eq!(joined(&desk, "plain", [2, 7]), None);
    let line = told(&desk, "more");
    assert!(line.starts_with("- m7 and m2"), "{line}");
    assert!(
        line.contains(" (not joined before); 40 further searches"),
        "{line}"
    );
}

/// The first part of the search is kept when a name turns out to be none.
#[test]
fn names_and_searches_that_cannot_be_connected_are_told() {
    let desk = Desk::empty();
    let said = |arguments: &[&str]| {
        let output = desk.surface(arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let connect = |from, to| ["muller-brown", "--no-report", "--connect", from, to];
    let text = said(&connect("m1", "m3"));
    assert!(
        text.contains("--connect m3: there are 3 minima, m0 to m2; the same command with other names goes on from here"),
        "{text}"
    );
    let output = desk.surface(&connect("m0", "m2"));
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.contains("continuing an interrupted run"), "{text}");
    let line = told(&desk, "muller-brown.landscape");
    assert!(
        line.contains(", as before; 40 further searches, 40 of which ended there"),
        "{line}"
    );
    for (names, more, part) in [
        (
            ["m0", "m0"],
            &[][..],
            "--connect m0 m0: name two different minima",
        ),
        (
            ["m0", "g1"],
            &[],
            "--connect g1: write minima as the tree names them",
        ),
        (
            ["m0", "m1"],
            &["--budget", "1m"],
            "--connect m0 m1: with --budget, the names of minima depend",
        ),
        (
            ["m0", "m1"],
            &["--search", "lowest"],
            "--connect m0 m1: only the lowest part",
        ),
        (
            ["m0", "m1"],
            &["--search", "adelm"],
            "--connect has no effect on attraction–diffusion alone",
        ),
    ] {
        let [from, to] = names;
        let text = desk.unmapped(&[&connect(from, to)[..], more, &["-o", "none"]].concat());
        assert!(text.contains(part), "`{part}` is missing in: {text}");
    }
}
