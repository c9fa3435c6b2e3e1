//! Work with finished landscapes: drawing views, comparing two, exchanging min.data and ts.data; trees of any depth and
//! names of any kind.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::fs;

use crate::desk::{Desk, assert_says};
use crate::folder::names;
use landscape::store::{AtomicFolder, StationaryRow};
use landscape::topography::exchange::{Database, Layout};
use landscape::topography::{MinimumId, Tree};
use serde_json::Value;

#[path = "deep/mod.rs"]
mod deep;
#[path = "hostile/mod.rs"]
mod hostile;

impl Desk {
    fn tree(&self, folder: &str) -> Tree {
        serde_json::from_value(self.json(&format!("{folder}/tree.json"))).unwrap()
    }

    fn database(&self, folder: &str, min: &str, ts: &str) {
        fs::create_dir_all(self.path(folder)).unwrap();
        fs::write(self.path(folder).join("min.data"), min).unwrap();
        fs::write(self.path(folder).join("ts.data"), ts).unwrap();
    }
}

#[test]
fn coordinates_of_others_are_read() {
    let desk = Desk::empty();
    let (min, ts) = seven();
    desk.database("seven", &min, &ts);
    // topsearch: texts, a point on each line as numpy writes it.
    let row = |k: u32| vec![f64::from(k) + 0.1, -1e-3 * f64::from(k)];
    let text = |count: u32| {
        let lines = (0..count).map(|k| format!("{:.18e} {:.18e}\n", row(k)[0], row(k)[1]));
        lines.collect::<Vec<_>>().concat()
    };
    desk.write("seven/min.coords", text(4));
    desk.write("seven/ts.coords", text(12));
    desk.print("import seven");
    let files = desk.landscape("seven.landscape");
    for minimum in &files.minima {
        assert_eq!(
            minimum.coordinates,
            row(u32::try_from(minimum.members[0]).unwrap())
        );
    }
    // PATHSAMPLE: what was written is read again.
    desk.print("import seven.landscape -o again -q");
    for name in ["points.min", "points.ts"] {
        let [one, other] = ["seven.landscape", "again"]
            .map(|folder| fs::read(desk.path(folder).join(name)).unwrap());
        assert_eq!(one, other);
    }
    let again = desk.landscape("again");
    assert_eq!(again.minima, files.minima);
    // Points of another file are not taken for these.
    desk.write("seven/ts.coords", text(11));
    let said = desk.print("import seven -o other");
    assert_says(
        &said,
        &[
            "coordinates were not read: ts.coords does not contain as many coordinates for each of 12 points",
        ],
    );
    let other = desk.landscape("other");
    assert!(other.minima[0].coordinates.is_empty() && !desk.path("other/points.min").exists());
}

/// Seven Lennard-Jones atoms in topsearch's format, from the reference values.
fn seven() -> (String, String) {
    let reference: Value = serde_json::from_str(include_str!("reference/landscapes.json")).unwrap();
    let known = &reference["LJ7"];
    let minima = known["minima"].as_array().unwrap().iter();
    let minima = minima
        .enumerate()
        .map(|(i, minimum)| format!("{i} {minimum}\n"));
    let states = known["ts"].as_array().unwrap().iter();
    let states = states.map(|state| {
        format!(
            "{} {} {}\n",
            state["connects"][0], state["connects"][1], state["energy"]
        )
    });
    (minima.collect(), states.collect())
}

#[test]
fn files_of_others_become_a_landscape() {
    let desk = Desk::empty();
    let (min, ts) = seven();
    desk.database("seven", &min, &ts);
    let said = desk.print("import seven");
    assert_says(
        &said,
        &["**4 minima** and **12 transition states** in the layout of topsearch"],
    );
    let found = names(&desk.path("seven.landscape"));
    let expected = "barriers.graphml barriers.png disconnectivity.svg edges.parquet landscape.json min.data minima.parquet \
                    tree.dot tree.json tree.nwk ts.data";
    for name in expected.split(' ') {
        assert!(found.iter().any(|file| file == name), "{name} of {found:?}");
    }
    let tree = desk.tree("seven.landscape");
    for (a, b, height) in [(0, 1, -15.444734), (0, 2, -15.319864), (0, 3, -15.283421)] {
        let found = tree.minimax(MinimumId(a), MinimumId(b)).unwrap();
        assert!((found - height).abs() < 1e-5, "{a} {b}: {found}");
    }
    // What it writes is PATHSAMPLE's, and reads as the same.
    desk.print("import seven.landscape -o again -q");
    assert_eq!(tree, desk.tree("again"));
    assert_eq!(
        desk.text("seven.landscape/ts.data"),
        desk.text("again/ts.data")
    );
    let files = desk.landscape("again");
    assert_eq!(files.minima.len(), 4);
    assert!(files.minima[0].coordinates.is_empty());
    let said = desk.mistake("diff again seven.landscape");
    assert_says(&said, &["does not record the coordinates of its minima"]);
}

#[test]
fn curvatures_are_exchanged() {
    let desk = Desk::empty();
    desk.print("surface lj 7 -q -o seven");
    let (database, layout) =
        Database::parse(&desk.text("seven/min.data"), &desk.text("seven/ts.data")).unwrap();
    assert_eq!(layout, Layout::Pathsample);
    let rows = StationaryRow::read(&desk.path("seven")).unwrap();
    let minima = database
        .minima
        .iter()
        .map(|m| (m.energy, m.vibrations.unwrap()));
    let states = database
        .transition_states
        .iter()
        .map(|s| (s.energy, s.vibrations.unwrap()));
    assert_eq!(rows.len(), 16);
    for (row, (energy, vibrations)) in rows.iter().zip(minima.chain(states)) {
        assert_eq!(energy.to_bits(), row.energy.to_bits());
        let index = usize::try_from(row.index).unwrap();
        let product: f64 = row.curvatures[index..].iter().map(|c| libm::log(*c)).sum();
        assert!((vibrations.log_product - product).abs() < 1e-9);
        let [a, b, c] = vibrations.moments_of_inertia;
        assert!(0.0 < a && a <= b && b <= c && c <= a + b);
    }
    // D5h, C3v, C2, C3v: the published point groups of the four minima (energies by rising value).
    let orders: Vec<u32> = database
        .minima
        .iter()
        .map(|m| m.vibrations.unwrap().point_group_order)
        .collect();
    assert_eq!(orders, [20, 6, 6, 2]);
    desk.print("import seven -o again -q");
    let [here, there] = ["seven", "again"].map(|folder| desk.tree(folder));
    assert_eq!(here.nodes.len(), there.nodes.len());
    for i in 0..4 {
        for j in 0..4 {
            assert_eq!(
                here.minimax(MinimumId(i), MinimumId(j)),
                there.minimax(MinimumId(i), MinimumId(j))
            );
        }
    }
}

#[test]
fn files_that_do_not_fit_are_refused() {
    let desk = Desk::empty();
    desk.database("bad", "0 -1.0\n1 -2.0\n", "0 1 0.5\n0 2 0.5\n");
    let said = desk.mistake("import bad");
    assert_says(
        &said,
        &["bad: ts.data, line 2, field 2: minimum 2 is not in min.data"],
    );
    assert!(!desk.path("bad.landscape").exists() && !desk.path("bad.landscape.partial").exists());
    assert!(
        desk.mistake("import nowhere")
            .contains("no such file or folder")
    );
    fs::remove_file(desk.path("bad/min.data")).unwrap();
    assert!(
        desk.mistake("import bad")
            .contains("contains neither .npy files of grasps nor min.data and ts.data")
    );
}

/// A search that has found no transition state yet leaves `min.data` alone.
#[test]
fn minima_alone_are_roots() {
    let desk = Desk::empty();
    for (name, minima, count) in [
        ("one", "-10.0 5.0 1 1.0 2.0 3.0\n", 1),
        ("two", "0 -1.0\n1 -2.0\n", 2),
    ] {
        desk.database(name, minima, "");
        fs::remove_file(desk.path(&format!("{name}/ts.data"))).unwrap();
        desk.print(&format!("import {name}"));
        let files = desk.landscape(&format!("{name}.landscape"));
        let counts = &files.manifest.counts;
        assert_eq!(
            [counts.minima, counts.components, counts.pairs],
            [count, count, 0]
        );
        let [note] = &files.manifest.warnings[..] else {
            panic!("{:?}", files.manifest.warnings)
        };
        assert!(note.starts_with("ts.data is missing"), "{note}");
    }
}

#[test]
fn views_are_drawn() {
    let desk = Desk::empty();
    // Nine minima at energy 0; merges at 2 and at 6.
    desk.print("surface torsion 1 3 3 3 -q -o t.landscape");
    desk.print("draw t.landscape --lowest 4 --levels 2 --seed 3");
    let mut found = names(&desk.path("t.view"));
    found.retain(|name| !name.starts_with('.'));
    assert_eq!(found.len(), 12, "{found:?}");
    let svg = desk.text("t.view/disconnectivity.svg");
    assert_says(&svg, &["4 of 9 minima (the 4 lowest, 2 levels)"]);
    assert_eq!(
        desk.tree("t.view")
            .nodes
            .iter()
            .filter(|node| node.minimum.is_some())
            .count(),
        4
    );

    desk.print("draw t.landscape --pick m8,m0 -o two");
    let whole = desk.tree("t.landscape");
    let two = desk.tree("two");
    assert_eq!(
        two.minimax(MinimumId(0), MinimumId(1)),
        whole.minimax(MinimumId(0), MinimumId(8))
    );
    assert!(desk.text("two/tree.nwk").contains("'m8'"));
    assert!(desk.text("two/barriers.graphml").contains("<edge "));
    // All are bottoms: nothing is lower than anything.
    desk.print("draw t.landscape --monotonic -o bottoms");
    assert!(!desk.tree("bottoms").nodes.is_empty());
    desk.print("draw t.landscape --min-members 1000000 -o none");
    assert_eq!(desk.tree("none"), Tree::default());

    for (line, said) in [
        ("draw t.landscape --pick m9", "m0 to m8"),
        ("draw t.landscape --pick first", "m0 or m17"),
        ("draw t.landscape --lowest 0", "--lowest 0"),
        ("draw nowhere", "no such file"),
        (
            "draw t.landscape -o no/where",
            "the folder no does not exist",
        ),
    ] {
        let sentence = desk.mistake(line);
        assert!(sentence.contains(said), "{line}: {sentence}");
    }
}

#[test]
fn branches_stand_at_an_order_parameter() {
    let desk = Desk::empty();
    let (min, ts) = seven();
    desk.database("seven", &min, &ts);
    desk.print("import seven -o seven.landscape --no-report");
    desk.write("q.csv", "minimum,q4\nm0,0.5\nm1,0.1\nm2,0.9\nm3,0.3\n");
    desk.print("draw seven.landscape --values q.csv --place-by q4 --colour-by energy -o placed");
    let picture = desk.text("placed/disconnectivity.svg");
    for text in ["q4", "energy", "0.8"] {
        assert!(picture.lines().any(|line| line == text), "{text}");
    }
    // The same tree, drawn otherwise.
    assert_eq!(
        desk.text("placed/tree.json"),
        desk.text("seven.landscape/tree.json")
    );
    for (flags, said) in [
        (
            "--place-by q4",
            "no quantity is called `q4`; the quantities are energy, members",
        ),
        ("--values nowhere.csv --place-by q4", "nowhere.csv"),
        (
            "--values q.csv --colour-by energy --colour category",
            "cannot be used with",
        ),
    ] {
        let told = desk.run(&format!("draw seven.landscape -o other {flags}"));
        let told = String::from_utf8(told.stderr).unwrap();
        assert!(told.contains(said), "{told}");
    }
}

#[test]
fn differences_are_told() {
    let desk = Desk::empty();
    desk.print("surface double-well 2 0.1 -q -o even.landscape");
    desk.print("surface double-well 2 0.3 -q -o tilted.landscape");
    let text = desk.print("diff even.landscape even.landscape");
    assert_says(&text, &["minima in both                4"]);
    assert!(!text.contains("moved most"), "{text}");
    let text = desk.print("diff even.landscape tilted.landscape --within 0.2");
    assert_says(
        &text,
        &["energies that moved most", "merges that moved most"],
    );
    let value = desk.document("diff even.landscape tilted.landscape --within 0.2 --json");
    assert_eq!(value["matches"].as_array().unwrap().len(), 4);
    assert_eq!(value["merges"].as_array().unwrap().len(), 3);
    // m1 at the other end of a flat valley, farther off than two minima that are one.
    let mut valley = desk.landscape("even.landscape");
    let distance = valley.manifest.settings["sameness"]["distance"]
        .as_f64()
        .unwrap();
    valley.minima[1].coordinates[0] += 3.0 * distance;
    let folder = AtomicFolder::open(&desk.path("valley.landscape"), true).unwrap();
    valley.write(&folder).unwrap();
    folder.finish().unwrap();
    let text = desk.print("diff even.landscape valley.landscape");
    let words = ["minima in both", "may be the same", "m1 may be m1′"];
    assert_says(&text, &words);
    let value = desk.document("diff even.landscape valley.landscape --json");
    let [pair] = &value["possible"].as_array().unwrap()[..] else {
        panic!("{value}");
    };
    assert_eq!((&pair["before"], &pair["after"]), (&1.into(), &1.into()));
    assert!((pair["distance"].as_f64().unwrap() - 3.0 * distance).abs() < 1e-9);
    assert_eq!(value["only_before"].as_array().unwrap().len(), 0);
    let text = desk.print("diff even.landscape valley.landscape --within 0");
    assert_says(
        &text,
        &["only in even.landscape", "only in valley.landscape"],
    );

    desk.print("surface double-well 3 -q -o cube.landscape");
    for (line, said) in [
        (
            "diff even.landscape cube.landscape",
            "of different spaces (2 flat, 3 flat)",
        ),
        ("diff even.landscape nowhere", "no such file"),
        (
            "diff even.landscape tilted.landscape --within -1",
            "--within -1",
        ),
    ] {
        let sentence = desk.mistake(line);
        assert!(sentence.contains(said), "{line}: {sentence}");
    }
}
