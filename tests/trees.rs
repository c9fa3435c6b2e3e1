//! Work with finished landscapes: drawing views, comparing two, exchanging min.data and ts.data; trees of any depth and
//! names of any kind.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use crate::folder::names;
use landscape::store::{AtomicFolder, LandscapeFiles, StationaryRow};
use landscape::topography::exchange::{Database, Layout};
use landscape::topography::{Evidence, MinimumId, Tree};
use serde_json::Value;
use tempfile::TempDir;

#[path = "deep/mod.rs"]
mod deep;
#[path = "hostile/mod.rs"]
mod hostile;

struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn run(&self, line: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_landscape"));
        command.args(line.split_whitespace());
        command.current_dir(self.0.path()).output().unwrap()
    }

    /// Runs a command that must succeed and returns its output.
    fn succeed(&self, line: &str) -> String {
        let output = self.run(line);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "landscape {line}: {said}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs a command that must fail with one error message, and returns the message.
    fn mistake(&self, line: &str) -> String {
        let output = self.run(line);
        let said = String::from_utf8(output.stderr).unwrap();
        let usage = said.contains("For more information, try '--help'");
        let code = if usage { 2 } else { 1 };
        assert_eq!(output.status.code(), Some(code), "landscape {line}: {said}");
        assert!(
            said.starts_with("error: ") && !said.contains("panicked"),
            "{said}"
        );
        said
    }

    fn tree(&self, folder: &str) -> Tree {
        serde_json::from_str(&self.text(&format!("{folder}/tree.json"))).unwrap()
    }

    fn write(&self, folder: &str, min: &str, ts: &str) {
        fs::create_dir_all(self.path(folder)).unwrap();
        fs::write(self.path(folder).join("min.data"), min).unwrap();
        fs::write(self.path(folder).join("ts.data"), ts).unwrap();
    }
}

#[test]
fn coordinates_of_others_are_read() {
    let desk = Desk::new();
    let (min, ts) = seven();
    desk.write("seven", &min, &ts);
    // topsearch: texts, a point on each line as numpy writes it.
    let row = |k: u32| vec![f64::from(k) + 0.1, -1e-3 * f64::from(k)];
    let text = |count: u32| {
        let lines = (0..count).map(|k| format!("{:.18e} {:.18e}\n", row(k)[0], row(k)[1]));
        lines.collect::<Vec<_>>().concat()
    };
    fs::write(desk.path("seven/min.coords"), text(4)).unwrap();
    fs::write(desk.path("seven/ts.coords"), text(12)).unwrap();
    desk.succeed("import seven");
    let files = LandscapeFiles::read(&desk.path("seven.landscape")).unwrap();
    for minimum in &files.minima {
        assert_eq!(
            minimum.coordinates,
            row(u32::try_from(minimum.members[0]).unwrap())
        );
    }
    // PATHSAMPLE: what was written is read again.
    desk.succeed("import seven.landscape -o again -q");
    for name in ["points.min", "points.ts"] {
        let [one, other] = ["seven.landscape", "again"]
            .map(|folder| fs::read(desk.path(folder).join(name)).unwrap());
        assert_eq!(one, other);
    }
    let again = LandscapeFiles::read(&desk.path("again")).unwrap();
    assert_eq!(again.minima, files.minima);
    // Points of another file are not taken for these.
    fs::write(desk.path("seven/ts.coords"), text(11)).unwrap();
    let said = desk.succeed("import seven -o other");
    assert!(
        said.contains(
            "coordinates were not read: ts.coords does not contain as many coordinates for each of 12 points"
        ),
        "{said}"
    );
    let other = LandscapeFiles::read(&desk.path("other")).unwrap();
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
    let desk = Desk::new();
    let (min, ts) = seven();
    desk.write("seven", &min, &ts);
    let said = desk.succeed("import seven");
    assert!(
        said.contains("**4 minima** and **12 transition states** in the layout of topsearch"),
        "{said}"
    );
    let found = names(&desk.path("seven.landscape"));
    for name in [
        "barriers.graphml",
        "barriers.png",
        "disconnectivity.svg",
        "edges.parquet",
        "landscape.json",
        "min.data",
        "minima.parquet",
        "tree.dot",
        "tree.json",
        "tree.nwk",
        "ts.data",
    ] {
        assert!(found.iter().any(|file| file == name), "{name} of {found:?}");
    }
    let tree = desk.tree("seven.landscape");
    for (a, b, height) in [(0, 1, -15.444734), (0, 2, -15.319864), (0, 3, -15.283421)] {
        let found = tree.minimax(MinimumId(a), MinimumId(b)).unwrap();
        assert!((found - height).abs() < 1e-5, "{a} {b}: {found}");
    }
    // What it writes is PATHSAMPLE's, and reads as the same.
    desk.succeed("import seven.landscape -o again -q");
    assert_eq!(tree, desk.tree("again"));
    assert_eq!(
        desk.text("seven.landscape/ts.data"),
        desk.text("again/ts.data")
    );
    let files = LandscapeFiles::read(&desk.path("again")).unwrap();
    assert_eq!(files.minima.len(), 4);
    assert!(files.minima[0].coordinates.is_empty());
    let said = desk.mistake("diff again seven.landscape");
    assert!(
        said.contains("does not record the coordinates of its minima"),
        "{said}"
    );
}

#[test]
fn curvatures_are_exchanged() {
    let desk = Desk::new();
    desk.succeed("surface lj 7 -q -o seven");
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
    desk.succeed("import seven -o again -q");
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
    let desk = Desk::new();
    desk.write("bad", "0 -1.0\n1 -2.0\n", "0 1 0.5\n0 2 0.5\n");
    let said = desk.mistake("import bad");
    assert!(
        said.contains("bad: ts.data, line 2, field 2: minimum 2 is not in min.data"),
        "{said}"
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
    let desk = Desk::new();
    for (name, minima, count) in [
        ("one", "-10.0 5.0 1 1.0 2.0 3.0\n", 1),
        ("two", "0 -1.0\n1 -2.0\n", 2),
    ] {
        desk.write(name, minima, "");
        fs::remove_file(desk.path(&format!("{name}/ts.data"))).unwrap();
        desk.succeed(&format!("import {name}"));
        let files = LandscapeFiles::read(&desk.path(&format!("{name}.landscape"))).unwrap();
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

/// Several transition states between two minima, and one that joins a minimum to itself.
#[test]
fn the_lowest_of_parallel_transition_states_counts() {
    let desk = Desk::new();
    let minima = "-10.0 5.0 1 1.0 2.0 3.0\n-9.0 5.0 1 1.0 2.0 3.0\n";
    let states =
        "-6.5 4.0 1 1 2 1.0 2.0 3.0\n-7.0 4.0 1 2 1 1.0 2.0 3.0\n-5.0 4.0 1 1 1 1.0 2.0 3.0\n";
    desk.write("parallel", minima, states);
    desk.succeed("import parallel");
    let files = LandscapeFiles::read(&desk.path("parallel.landscape")).unwrap();
    let heights: Vec<Option<f64>> = files.edges.iter().map(|edge| edge.height).collect();
    assert_eq!(heights, [Some(-7.0)]);
    assert!(
        desk.text("parallel.landscape/summary.md")
            .contains("1 of which joins two copies")
    );
}

#[test]
fn views_are_drawn() {
    let desk = Desk::new();
    // Nine minima at energy 0; merges at 2 and at 6.
    desk.succeed("surface torsion 1 3 3 3 -q -o t.landscape");
    desk.succeed("draw t.landscape --lowest 4 --levels 2 --seed 3");
    let mut found = names(&desk.path("t.view"));
    found.retain(|name| !name.starts_with('.'));
    assert_eq!(found.len(), 12, "{found:?}");
    let svg = desk.text("t.view/disconnectivity.svg");
    assert!(
        svg.contains("4 of 9 minima (the 4 lowest, 2 levels)"),
        "{svg}"
    );
    assert_eq!(
        desk.tree("t.view")
            .nodes
            .iter()
            .filter(|node| node.minimum.is_some())
            .count(),
        4
    );

    desk.succeed("draw t.landscape --pick m8,m0 -o two");
    let whole = desk.tree("t.landscape");
    let two = desk.tree("two");
    assert_eq!(
        two.minimax(MinimumId(0), MinimumId(1)),
        whole.minimax(MinimumId(0), MinimumId(8))
    );
    assert!(desk.text("two/tree.nwk").contains("'m8'"));
    assert!(desk.text("two/barriers.graphml").contains("<edge "));
    // All are bottoms: nothing is lower than anything.
    desk.succeed("draw t.landscape --monotonic -o bottoms");
    assert!(!desk.tree("bottoms").nodes.is_empty());
    desk.succeed("draw t.landscape --min-members 1000000 -o none");
    assert_eq!(desk.tree("none"), Tree::default());

    // Tables of another landscape.
    desk.succeed("surface double-well 2 0.1 -q -o other.landscape");
    let tables = ["t", "other"].map(|name| desk.path(name).with_extension("landscape"));
    let [own, other] = tables.map(|folder| folder.join("edges.parquet"));
    let edges = fs::read(&own).unwrap();
    fs::copy(other, &own).unwrap();
    for line in [
        "draw t.landscape -o mixed",
        "diff other.landscape t.landscape",
    ] {
        let said = desk.mistake(line);
        assert!(said.contains("edges.parquet does not belong"), "{said}");
    }
    assert!(!desk.path("mixed").exists());
    fs::write(&own, edges).unwrap();

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

/// Share of the pixels of a picture that are darker than half.
fn ink(png: &[u8]) -> f64 {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .unwrap();
    let mut pixels = vec![0; reader.output_buffer_size()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let dark = |pixel: &&[u8]| pixel.iter().map(|part| usize::from(*part)).sum::<usize>() < 384;
    let channels = info.color_type.samples();
    let count = pixels.chunks_exact(channels).filter(dark).count();
    count as f64 / (pixels.len() / channels) as f64
}

/// A funnel of 1,000 minima was one black triangle of bars.
#[test]
fn a_thousand_minima_are_no_black_area() {
    let desk = Desk::new();
    let energy = |minimum: usize| 10.0 * libm::pow(minimum as f64 / 1000.0, 0.35);
    let (mut minima, mut states) = (String::new(), String::new());
    for minimum in 0..1000 {
        writeln!(minima, "{} 10 1 1 1 1", energy(minimum)).unwrap();
    }
    for minimum in 1..1000 {
        let height = energy(minimum) + 0.1 + 0.003 * ((minimum * 733) % 1000) as f64;
        let lower = (minimum * 389) % minimum.div_ceil(2);
        writeln!(states, "{height} 9 1 {} {} 1 1 1", minimum + 1, lower + 1).unwrap();
    }
    desk.write("funnel", &minima, &states);
    desk.succeed("import funnel -q");
    let picture = "funnel.landscape/disconnectivity";
    let dark = ink(&fs::read(desk.path(&format!("{picture}.png"))).unwrap());
    assert!((0.005..0.08).contains(&dark), "{dark}");
    let svg = desk.text(&format!("{picture}.svg"));
    assert!(svg.contains("merges raised to 40 levels"));
}

#[test]
fn branches_stand_at_an_order_parameter() {
    let desk = Desk::new();
    let (min, ts) = seven();
    desk.write("seven", &min, &ts);
    desk.succeed("import seven -o seven.landscape --no-report");
    fs::write(
        desk.path("q.csv"),
        "minimum,q4\nm0,0.5\nm1,0.1\nm2,0.9\nm3,0.3\n",
    )
    .unwrap();
    desk.succeed("draw seven.landscape --values q.csv --place-by q4 --colour-by energy -o placed");
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
    let desk = Desk::new();
    desk.succeed("surface double-well 2 0.1 -q -o even.landscape");
    desk.succeed("surface double-well 2 0.3 -q -o tilted.landscape");
    let text = desk.succeed("diff even.landscape even.landscape");
    assert!(
        text.contains("minima in both") && text.contains("4, 4"),
        "{text}"
    );
    assert!(!text.contains("moved most"), "{text}");
    let text = desk.succeed("diff even.landscape tilted.landscape --within 0.2");
    assert!(
        text.contains("energies that moved most") && text.contains("merges that moved most"),
        "{text}"
    );
    let json = desk.succeed("diff even.landscape tilted.landscape --within 0.2 --json");
    let value: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["matches"].as_array().unwrap().len(), 4);
    assert_eq!(value["merges"].as_array().unwrap().len(), 3);
    // The deepest minimum has both coordinates in the deeper well, whose energy falls with the tilt.
    let files = ["even", "tilted"]
        .map(|name| LandscapeFiles::read(&desk.path(&format!("{name}.landscape"))).unwrap());
    let told = value["matches"][0]["energies"][1].as_f64().unwrap();
    assert!((told - files[1].minima[0].energy).abs() < 1e-12 && told < files[0].minima[0].energy);
    let network = files[1].network(&desk.path("tilted.landscape")).unwrap();
    let tree = Tree::from_network(&network, Evidence::Chain);
    let merge = &value["merges"][0];
    let ends =
        [0, 1].map(|k| MinimumId(usize::try_from(merge["ends"][k].as_u64().unwrap()).unwrap()));
    let partner = |id: MinimumId| {
        let matches = value["matches"].as_array().unwrap();
        let matched = matches.iter().find(|m| m["before"] == id.0).unwrap();
        MinimumId(usize::try_from(matched["after"].as_u64().unwrap()).unwrap())
    };
    assert_eq!(
        merge["after"].as_f64(),
        tree.minimax(partner(ends[0]), partner(ends[1]))
    );

    // m1 at the other end of a flat valley, farther off than two minima that are one.
    let mut valley = LandscapeFiles::read(&desk.path("even.landscape")).unwrap();
    let distance = valley.manifest.settings["sameness"]["distance"]
        .as_f64()
        .unwrap();
    valley.minima[1].coordinates[0] += 3.0 * distance;
    let folder = AtomicFolder::open(&desk.path("valley.landscape"), true).unwrap();
    valley.write(&folder).unwrap();
    folder.finish().unwrap();
    let text = desk.succeed("diff even.landscape valley.landscape");
    for words in ["minima in both", "may be the same", "m1 may be m1′"] {
        assert!(text.contains(words), "{words} is missing in {text}");
    }
    let json = desk.succeed("diff even.landscape valley.landscape --json");
    let value: Value = serde_json::from_str(&json).unwrap();
    let [pair] = &value["possible"].as_array().unwrap()[..] else {
        panic!("{json}");
    };
    assert_eq!((&pair["before"], &pair["after"]), (&1.into(), &1.into()));
    assert!((pair["distance"].as_f64().unwrap() - 3.0 * distance).abs() < 1e-9);
    assert_eq!(value["only_before"].as_array().unwrap().len(), 0);
    let text = desk.succeed("diff even.landscape valley.landscape --within 0");
    assert!(
        text.contains("only in even.landscape") && text.contains("only in valley.landscape"),
        "{text}"
    );

    let json = desk.succeed("diff even.landscape tilted.landscape --within 0 --json");
    let value: Value = serde_json::from_str(&json).unwrap();
    assert!(value["matches"].as_array().unwrap().is_empty());
    assert!(value["merges"].as_array().unwrap().is_empty());

    desk.succeed("surface double-well 3 -q -o cube.landscape");
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
