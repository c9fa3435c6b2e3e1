//! `landscape surface --connect`: further searches between two minima.

use std::fs;

use landscape::store::LandscapeFiles;
use landscape::topography::{Evidence, MinimumId, Tree};

use super::promised;
use crate::desk::{Desk, assert_says};
use crate::table::rows;

/// A search of nine atoms that is stopped long before it has found most of 21 minima and 165 saddles.
const SHORT: &str = "lj 9 --search all --searches 64 --no-report -q";

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
    desk.mapped(&format!("{SHORT} -o plain"));
    let connect = format!("{SHORT} --connect m0 m5");
    desk.mapped(&format!("{connect} --threads 1 -o more"));
    let [before, now] = ["plain", "more"].map(|folder| joined(&desk, folder, [0, 5]).unwrap());
    assert!(now < before - 0.1, "{before} {now}");
    let line = told(&desk, "more");
    let expected =
        format!("- m0 and m5: joined at {now:.6} (before {before:.6}); 40 further searches, ");
    assert!(line.starts_with(&expected), "{line}");
    assert!(line.contains("the chance of a lower way is"), "{line}");
    // Other threads, and an interruption among the further searches.
    let cut = format!("{connect} --threads 2 -o cut");
    desk.kill_at(&cut, b"connect/0-5/chains/search/9");
    desk.mapped(&format!("{cut} --resume"));
    assert_eq!(promised(&desk.path("more")), promised(&desk.path("cut")));
}

#[test]
fn two_components_are_joined() {
    let desk = Desk::empty();
    let short = SHORT.replace("lj 9", "lj 10");
    desk.mapped(&format!("{short} -o plain"));
    desk.mapped(&format!("{short} --connect m7 m2 -o more"));
    assert_eq!(joined(&desk, "plain", [2, 7]), None);
    let line = told(&desk, "more");
    assert!(line.starts_with("- m7 and m2"), "{line}");
    assert_says(&line, &[" (not joined before); 40 further searches"]);
}

/// The first part of the search is kept when a name turns out to be none.
#[test]
fn names_and_searches_that_cannot_be_connected_are_told() {
    let desk = Desk::empty();
    let connect = "surface muller-brown --no-report --connect";
    let text = desk.failure(&format!("{connect} m1 m3"));
    assert_says(
        &text,
        &[
            "--connect m3: there are 3 minima, m0 to m2; the same command with other names goes on from here",
        ],
    );
    let text = desk.succeed(&format!("{connect} m0 m2"));
    assert!(text.contains("continuing an interrupted run"), "{text}");
    let line = told(&desk, "muller-brown.landscape");
    assert_says(
        &line,
        &[", as before; 40 further searches, 40 of which ended there"],
    );
    let cases = "
        m0 m0 | --connect m0 m0: name two different minima
        m0 g1 | --connect g1: write minima as the tree names them
        m0 m1 --budget 1m | --connect m0 m1: with --budget, the names of minima depend
        m0 m1 --search lowest | --connect m0 m1: only the lowest part
        m0 m1 --search adelm | --connect has no effect on attraction–diffusion alone
    ";
    for case in rows(cases) {
        let text = desk.unmapped(&format!(
            "muller-brown --no-report --connect {} -o none",
            case[0]
        ));
        assert_says(&text, &case[1..]);
    }
}
