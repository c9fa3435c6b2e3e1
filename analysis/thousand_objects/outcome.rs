//! Grasps of one hand on one object, labelled and judged by both simulations, kept in files so that an interrupted program
//! goes on.

use std::fs;
use std::path::Path;
use std::time::Instant;

use landscape::cli::{Stop, call};
use landscape::grasp::layer::LoadCompliance;
use landscape::store::{GraspFile, Overrides};
use serde_json::{Value, json};

pub(crate) type Failure = Box<dyn std::error::Error>;

/// A grasp that passed the strict filter.
pub(crate) struct Row {
    /// How much the layer gives under single loads, of 1 for a hand that has let go.
    pub(crate) gives: LoadCompliance,
    /// Whether it holds in the drop test.
    pub(crate) holds: bool,
    /// Whether it holds when the object is pushed in six directions.
    pub(crate) withstands: bool,
    /// Category by the rule of grasp types.
    pub(crate) category: String,
    /// Type, cell or category by the rule, or `unlisted`.
    pub(crate) label: String,
}

/// What the chains gave.
pub(crate) struct Outcome {
    pub(crate) chains: u64,
    /// Time that synthesis took.
    pub(crate) seconds: f64,
    pub(crate) rows: Vec<Row>,
}

/// Runs `landscape synth` with these words, labels and simulates what it gives, and keeps all under `name` in `folder`. What is
/// there already is not made again.
pub(crate) fn outcome(folder: &Path, name: &str, synth: &[&str]) -> Result<Outcome, Failure> {
    fs::create_dir_all(folder)?;
    let at = |end: &str| folder.join(format!("{name}{end}"));
    let done = at(".json");
    if !done.exists() {
        let [made, labelled] = [".parquet", ".labelled.parquet"].map(at);
        let started = Instant::now();
        let told = run(&[
            &["synth"],
            synth,
            &["-o", text(&made)?, "--json", "--force"],
        ]
        .concat());
        let seconds = started.elapsed().as_secs_f64();
        let told: Value = match told {
            Ok(told) => serde_json::from_str(&told)?,
            // Some objects cannot be held.
            Err(error) if error.to_string().contains("none of the") => json!({ "kept": 0 }),
            Err(error) => return Err(error),
        };
        if told["kept"] != 0 {
            let labelled = text(&labelled)?;
            run(&["label", text(&made)?, "-o", labelled, "--force"])?;
            for (protocol, end) in PROTOCOLS {
                let end = at(end);
                run(&[
                    "stability",
                    labelled,
                    "--protocol",
                    protocol,
                    "-o",
                    text(&end)?,
                    "--force",
                ])?;
            }
        }
        let told = json!({ "kept": told["kept"], "seconds": seconds });
        fs::write(&done, told.to_string())?;
    }
    let told: Value = serde_json::from_str(&fs::read_to_string(&done)?)?;
    let place = synth.iter().position(|word| *word == "-n");
    let chains = place
        .and_then(|place| synth.get(place + 1))
        .ok_or("no -n")?;
    let mut found = Outcome {
        chains: chains.parse()?,
        seconds: told["seconds"].as_f64().ok_or("no seconds")?,
        rows: Vec::new(),
    };
    if told["kept"] == 0 {
        return Ok(found);
    }
    let [dropped, pushed] =
        PROTOCOLS.map(|(_, end)| GraspFile::read(&at(end), Overrides::default()));
    let ((dropped, _), (pushed, _)) = (dropped?, pushed?);
    let population = dropped.landscapes().into_iter().next();
    let energy = population.ok_or("the file is empty")?.energy()?;
    for (one, other) in dropped.grasps.iter().zip(pushed.grasps) {
        let gives = energy.load_compliance(&one.grasp.pose);
        found.rows.push(Row {
            gives,
            holds: one.stable.ok_or("not simulated")?,
            withstands: other.stable.ok_or("not simulated")?,
            category: one.label_category.clone().unwrap_or_default(),
            label: one.label_auto.clone().unwrap_or_default(),
        });
    }
    Ok(found)
}

const PROTOCOLS: [(&str, &str); 2] = [
    ("drop", ".dropped.parquet"),
    ("dexgraspbench", ".pushed.parquet"),
];

fn run(words: &[&str]) -> Result<String, Failure> {
    let words = ["landscape"].iter().chain(words).copied();
    Ok(call(words.chain(["--quiet"]), false, &Stop::default())?)
}

pub(crate) fn text(path: &Path) -> Result<&str, Failure> {
    Ok(path.to_str().ok_or("the path is not text")?)
}

/// A share in percent, with one digit.
pub(crate) fn percent(part: usize, of: usize) -> String {
    if of == 0 {
        "–".to_owned()
    } else {
        format!("{:.1}", 100.0 * part as f64 / of as f64)
    }
}
