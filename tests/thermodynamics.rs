//! `landscape thermodynamics` and `landscape rates` as a user runs them.

use std::fmt::Write as _;
use std::fs;

use serde_json::Value;

use crate::desk::{Desk, assert_says};
use crate::table::rows;

/// The published network of `tests/kinetics.rs` as files of PATHSAMPLE, and its two sets as names and as `min.a` and `min.b`.
fn published(desk: &Desk) -> [String; 2] {
    let reference = include_str!("reference/kinetics_32_states.json");
    let reference: Value = serde_json::from_str(reference).unwrap();
    let list = |name: &str| reference[name].as_array().unwrap().clone();
    let (mut min, mut ts) = (String::new(), String::new());
    for energy in list("minima") {
        writeln!(min, "{energy} 1.0 1 1 1 1").unwrap();
    }
    for state in list("transition_states") {
        let [a, b] = [1, 2].map(|k| state[k].as_u64().unwrap() + 1);
        writeln!(ts, "{} 1.0 1 {a} {b} 1 1 1", state[0]).unwrap();
    }
    let folder = desk.path("published");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("min.data"), min).unwrap();
    fs::write(folder.join("ts.data"), ts).unwrap();
    // Minima are named by energy, as in the tree.
    let energies: Vec<f64> = list("minima").iter().map(|e| e.as_f64().unwrap()).collect();
    let mut order: Vec<usize> = (0..energies.len()).collect();
    order.sort_by(|a, b| energies[*a].total_cmp(&energies[*b]).then(a.cmp(b)));
    ["a", "b"].map(|set| {
        let rows = list(set).into_iter().map(|row| row.as_u64().unwrap());
        let rows: Vec<usize> = rows.map(|row| usize::try_from(row).unwrap()).collect();
        let mut file = format!("{}\n", rows.len());
        for row in &rows {
            writeln!(file, "{}", row + 1).unwrap();
        }
        fs::write(folder.join(format!("min.{set}")), file).unwrap();
        let names = rows.iter().map(|row| {
            let place = order.iter().position(|k| k == row).unwrap();
            format!("m{place}")
        });
        names.collect::<Vec<_>>().join(",")
    })
}

/// The numbers of `min.A` and `min.B` are those of `min.data`, of which an imported landscape keeps the order.
#[test]
fn sets_are_read_from_files_of_pathsample() {
    let desk = Desk::empty();
    let [a, b] = published(&desk);
    desk.succeed("import published --no-report -q");
    let rates = |folder: &str, from: &str, to: &str| {
        let line = format!("rates {folder} --from {from} --to {to} --temperature 1 --json");
        let mut found = desk.document(&line);
        found["landscape"].take();
        found
    };
    let by_name = rates("published", &b, &a);
    for folder in ["published", "published.landscape"] {
        let by_file = rates(folder, "published/min.b", "published/min.a");
        assert_eq!(by_file, by_name, "{folder}");
    }
    // The answer tells both numbers.
    let file = desk.text("published/min.a");
    let number = file.split_whitespace().nth(1).unwrap();
    let numbers = by_name["numbers_in_min_data"].as_array().unwrap();
    let target = numbers.iter().position(|k| format!("{k}") == number);
    let said =
        desk.print("rates published --from published/min.b --to published/min.a --temperature 1");
    assert_says(&said, &[&format!("m{} is {number}", target.unwrap())]);
    desk.write("far", "1\n33\n");
    desk.write("few", "3\n1\n2\n");
    desk.write("one", "2\n1\n");
    desk.write("binary", [0xff, 0xfe, 0x00]);
    for (file, said) in [
        ("far", "minimum 33 does not exist: min.data lists 32 minima"),
        ("few", "says 3 minima, and 2 numbers follow"),
        ("one", "says 2 minima, and 1 number follows"),
        ("binary", "a list of minima such as min.A"),
        ("published/absent", "no such file"),
        ("m32", "there are 32 minima, m0 to m31"),
    ] {
        let line = format!("rates published --from {file} --to m0 --temperature 1");
        assert_says(&desk.mistake(&line), &["--from", file, said]);
    }
}

/// Every minimum joins the lowest one above all others, so that the tree is as deep as it can be.
#[test]
fn a_deep_tree_of_many_minima_is_finished() {
    let desk = Desk::empty();
    let count = 20_000;
    let (mut min, mut ts) = (String::new(), String::new());
    for k in 0..count {
        let energy = if k == 0 {
            -10.0
        } else {
            f64::from(k * 7919 % count) / f64::from(count)
        };
        writeln!(min, "{energy} 1.0 1 1 1 1").unwrap();
        if k > 0 {
            let height = 2.0 + f64::from(k) / f64::from(count);
            writeln!(ts, "{height} 1.0 1 1 {} 1 1 1", k + 1).unwrap();
        }
    }
    fs::create_dir(desk.path("deep")).unwrap();
    desk.write("deep/min.data", min);
    desk.write("deep/ts.data", ts);
    desk.succeed("thermodynamics deep -q");
    let table = desk.text("deep.thermodynamics/superbasins.csv");
    let last = table.lines().last().unwrap();
    assert!(last.ends_with(",1"), "{last}");
}

#[test]
fn rates_of_a_published_network() {
    let desk = Desk::empty();
    let [a, b] = published(&desk);
    let line = format!("rates published --from {b} --to {a} --temperature 1,0.1 -o there");
    let said = desk.print(&line);
    assert_says(
        &said,
        &[
            "585.7934",
            "664.5827",
            "5.43e12",
            "1.20e13",
            "Fastest pathways at kT = 0.1",
        ],
    );
    let found = desk.json("there.json");
    let time = -found["at"][0]["forward"]["log_inverse_mean_time"]
        .as_f64()
        .unwrap();
    approx::assert_relative_eq!(libm::exp(time), 585.793_406_701_792_8, max_relative = 1e-12);
    for file in ["there.md", "there.svg", "there.png"] {
        assert!(desk.path(file).is_file(), "{file}");
    }
    // Nothing of these files was verified, nor was it by an import.
    desk.succeed("import published --no-report -q");
    for folder in ["published", "published.landscape"] {
        let found = desk.document(&format!("thermodynamics {folder} --json -o {folder}.there"));
        assert_eq!(found["funnels"]["evidence"], "given");
    }
    // Friction slows everything down, but needs curvatures that PATHSAMPLE's files do not hold.
    let said = desk.mistake(&format!(
        "rates published --from {b} --to {a} --temperature 1 --friction 2"
    ));
    assert_says(&said, &["negative curvature", "is unknown"]);
}

#[test]
fn thermodynamics_of_a_surface() {
    let desk = Desk::empty();
    desk.succeed("surface muller-brown --no-report -q");
    let found =
        desk.document("thermodynamics muller-brown.landscape --temperatures 5:60x40 --json");
    assert_eq!(found["vibrational_modes"], 2);
    assert_eq!(found["funnels"]["evidence"], "saddle");
    let curves = found["curves"].as_array().unwrap();
    assert_eq!(curves.len(), 40);
    // Equipartition at the lowest temperature: two modes, and nearly all in one minimum.
    let cold = &curves[0];
    assert!(
        (cold["heat_capacity"].as_f64().unwrap() - 2.0).abs() < 0.1,
        "{cold}"
    );
    let total: f64 = cold["occupation"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| p.as_f64().unwrap())
        .sum();
    assert!((total - 1.0).abs() < 1e-12);
    let folder = desk.path("muller-brown.thermodynamics");
    for file in "thermodynamics.csv thermodynamics.png disconnectivity.svg summary.md".split(' ') {
        assert!(folder.join(file).is_file(), "{file}");
    }
    let tree = fs::read_to_string(folder.join("tree.json")).unwrap();
    assert!(tree.contains("saddle") && !tree.contains("given"), "{tree}");
    let superbasins = fs::read_to_string(folder.join("superbasins.csv")).unwrap();
    let counts: Vec<usize> = (superbasins.lines().skip(1))
        .map(|line| line.split_once(',').unwrap().1.parse().unwrap())
        .collect();
    // One minimum at the bottom, and one superbasin at the highest pass.
    assert_eq!((counts[0], counts.last()), (1, Some(&1)));
    assert!(counts.iter().max() > Some(&1), "{counts:?}");
    let lines = fs::read_to_string(folder.join("thermodynamics.csv")).unwrap();
    assert_eq!(lines.lines().count(), 41);

    let there = "rates muller-brown.landscape --from m1 --to m0 --temperature 10 --json";
    let rate = |line: &str| {
        let found = desk.document(line);
        found["at"][0]["forward"]["log_first_passage_rate"]
            .as_f64()
            .unwrap()
    };
    assert!(rate(&format!("{there} --friction 100")) < rate(there) - 0.5);
}

/// The saddle of a surface with one coordinate has no positive curvature: its ln-product is 0, and known.
#[test]
fn min_data_and_ts_data_alone_give_the_rates_of_one_coordinate() {
    let desk = Desk::empty();
    desk.succeed("surface double-well 1 0.4 --no-report -q -o line.landscape");
    let folder = desk.path("copied");
    fs::create_dir(&folder).unwrap();
    for name in ["min.data", "ts.data"] {
        fs::copy(desk.path("line.landscape").join(name), folder.join(name)).unwrap();
    }
    let rate = |folder: &str| {
        let line = format!("rates {folder} --from m1 --to m0 --temperature 0.1 --json");
        let found = desk.document(&line);
        found["at"][0]["forward"]["log_first_passage_rate"]
            .as_f64()
            .unwrap()
    };
    approx::assert_relative_eq!(rate("line.landscape"), rate("copied"), max_relative = 1e-12);
    // Transition states with placeholders are none.
    let states = fs::read_to_string(folder.join("ts.data")).unwrap();
    fs::write(folder.join("ts.data"), states.replace("1e-300", "0.0")).unwrap();
    let said = desk.mistake("rates copied --from m1 --to m0 --temperature 0.1");
    assert_says(
        &said,
        &["of copied has curvatures", "placeholders", "1e-300"],
    );
}

/// PATHSAMPLE writes a ninth column, and numbers of finite length.
#[test]
fn what_was_changed_in_files_is_told() {
    let desk = Desk::empty();
    let folder = desk.path("rounded");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("min.data"), "-1 3 1 0 0 0\n0 2 1 0 0 0\n").unwrap();
    fs::write(folder.join("ts.data"), "-1e-11 2 1 1 2 0 0 0 7.5\n").unwrap();
    for line in [
        "import rounded --no-report",
        "rates rounded --from m1 --to m0 --temperature 0.1",
        "thermodynamics rounded",
    ] {
        let said = desk.print(line);
        assert_says(&said, &["ts.data has more columns", "were raised to it"]);
    }
}

/// The minima differ by the rounding of their descents.
#[test]
fn equal_minima_give_usual_temperatures_and_no_frustration() {
    let desk = Desk::empty();
    desk.succeed("surface double-well 2 --no-report -q -o two.landscape");
    let found = desk.document("thermodynamics two.landscape --json");
    for at in found["curves"].as_array().unwrap() {
        assert!(at["temperature"].as_f64().unwrap() > 1e-4, "{at}");
        let frustration = at["frustration"].as_f64().unwrap_or(1.0);
        assert!((0.0..1e3).contains(&frustration), "{at}");
    }
}

#[test]
fn mistakes_are_told() {
    let desk = Desk::empty();
    let [a, b] = published(&desk);
    let cases = "
        rates nowhere --from m0 --to m1 --temperature 1 | nowhere
        rates published --from {a} --to m99 --temperature 1 | m0 to m31
        rates published --from {a} --to g99 --temperature 1 | g0 to
        rates published --from {a} --to x --temperature 1 | m0,m3,g1
        rates published --from {a} --to {a} --temperature 1 | both in --from and in --to
        rates published --from {a} --to {b} --temperature 0 | above 0
        rates published --from {a} --to {b} --temperature 1 --friction=-1 | 0 or more
        thermodynamics published --temperatures 1:2 | LOW:HIGHxN
        thermodynamics published --free-energy-at 0 | above 0
        thermodynamics published/min.data | is a file
    ";
    for case in rows(cases) {
        let line = case[0].replace("{a}", &a).replace("{b}", &b);
        assert_says(&desk.mistake(&line), &case[1..]);
    }
    // Files without curvatures, and islands.
    let folder = desk.path("bare");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("min.data"), "0 -1.0\n1 0.0\n").unwrap();
    fs::write(folder.join("ts.data"), "0 1 2.0\n").unwrap();
    assert_says(
        &desk.mistake("thermodynamics bare"),
        &["no curvatures", "landscape surface"],
    );
    fs::write(
        folder.join("min.data"),
        "-1.0 3.0 1 0 0 0\n0.0 2.0 1 0 0 0\n",
    )
    .unwrap();
    fs::write(folder.join("ts.data"), "").unwrap();
    let said = desk.mistake("rates bare --from m1 --to m0 --temperature 1");
    assert_says(&said, &["no sequence of transition states leads from m1"]);
    assert_eq!(said.matches("no sequence").count(), 1, "{said}");
    desk.succeed("thermodynamics bare");
}
