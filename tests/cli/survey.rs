//! `landscape survey`: a data set as one job.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde_json::Value;

use crate::contents;
use crate::desk::{Desk, assert_says};
use crate::folder::names;

/// A folder of two hands on two objects, in folders of their own, and the settings of quick maps.
fn data_set() -> Desk {
    static MADE: OnceLock<Desk> = OnceLock::new();
    let made = MADE.get_or_init(|| {
        let desk = Desk::empty();
        desk.write("quick.toml", "[map]\nsearches = 2\n");
        for (hand, object, count) in [
            ("human", "ball", 4),
            ("human", "can", 3),
            ("gripper_parallel", "ball", 3),
        ] {
            fs::create_dir_all(desk.path("set").join(hand)).unwrap();
            desk.succeed(&format!(
                "synth --hand {hand} --object {object} -n {count} --steps 1 --keep all -q -o set/{hand}/{object}.parquet"
            ));
        }
        desk
    });
    made.copied()
}

/// The files of a survey that do not depend on threads and interruptions.
fn promised(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for (path, bytes) in contents(folder) {
        if !path.ends_with("timings.json") {
            files.insert(path.strip_prefix(folder).unwrap().to_path_buf(), bytes);
        }
    }
    files
}

const SURVEY: &str = "survey set --first 3 --no-report -q --config quick.toml";

#[test]
fn a_folder_is_one_job() {
    let desk = data_set();
    desk.succeed(&format!("{SURVEY} --threads 1"));
    let survey = desk.json("set.survey/survey.json");
    let names: Vec<&str> = (survey["populations"].as_array().unwrap().iter())
        .map(|one| one["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["gripper_parallel/ball", "human/ball", "human/can"]);
    assert_eq!(survey["populations"][1]["grasps"], 3, "--first 3 of 4");
    assert_eq!(survey["populations"][0]["types"], Value::Null);
    assert_eq!(survey["hands"][1]["grasps"], 6);
    let families = |one: &Value| {
        let families = one["map"]["families"].as_array().unwrap().iter();
        families
            .map(|family| family["grasps"].as_u64().unwrap())
            .sum::<u64>()
    };
    assert_eq!(
        families(&survey["populations"][2]),
        3,
        "every grasp is in a family"
    );
    // What is counted is what `label` and `build` say.
    let folder = desk.path("set.survey/landscapes/human/can.landscape");
    let manifest: Value =
        serde_json::from_slice(&fs::read(folder.join("landscape.json")).unwrap()).unwrap();
    assert_eq!(
        survey["populations"][2]["map"]["minima"],
        manifest["counts"]["minima"]
    );
    let table = desk.text("set.survey/populations.csv");
    assert_eq!(table.lines().count(), 4);
    let summary = desk.text("set.survey/summary.md");
    assert_says(
        &summary,
        &[
            "9 grasps: 2 hands on 2 objects",
            "## human: 6 grasps on 2 objects",
        ],
    );

    // A killed run goes on and gives the same bytes, whatever the number of threads.
    desk.interrupt(
        &format!("{SURVEY} -o killed.survey --threads 1"),
        "killed.survey.partial",
        1,
    );
    // Other grasps are another survey.
    let other = desk.mistake(&format!("{SURVEY} -o killed.survey --object can"));
    assert_says(&other, &["killed.survey.partial"]);
    desk.succeed(&format!("{SURVEY} -o killed.survey"));
    let [whole, killed] = ["set.survey", "killed.survey"].map(|name| promised(&desk.path(name)));
    assert!(whole == killed, "the same bytes");

    let folder = "killed.survey/landscapes/human/can.landscape/timings.json";
    let before = desk.bytes(folder);
    let modified = fs::metadata(desk.path(folder)).unwrap().modified().unwrap();
    desk.succeed("synth --object pen -n 3 --steps 1 --keep all -q -o set/human/pen.parquet");
    desk.succeed(&format!("{SURVEY} -o killed.survey"));
    assert_eq!(
        desk.json("killed.survey/survey.json")["populations"][3]["name"],
        "human/pen"
    );
    assert_eq!(desk.bytes(folder), before);
    let now = fs::metadata(desk.path(folder)).unwrap().modified().unwrap();
    assert_eq!(now, modified, "what was there is not mapped again");
    // Other settings map it again.
    desk.succeed(&format!("{SURVEY} -o killed.survey --seed 1"));
    let now = fs::metadata(desk.path(folder)).unwrap().modified().unwrap();
    assert_ne!(now, modified);
}

/// Two objects: `ball`, then `can`.
const OF_ONE_HAND: &str = "survey set/human --first 3 --no-report -q --config quick.toml";

#[test]
fn tasks_share_a_survey() {
    let desk = data_set();
    desk.succeed(&format!("{OF_ONE_HAND} -o plain.survey"));
    let tasks: Vec<_> = (1..=2)
        .map(|number| desk.start(&format!("{OF_ONE_HAND} -o shared.survey --task {number}/2")))
        .collect();
    for mut task in tasks {
        assert!(task.wait().unwrap().success());
    }
    assert_eq!(
        names(&desk.path("shared.survey")),
        ["landscapes"],
        "tasks write landscapes only"
    );
    let landscapes = || contents(&desk.path("shared.survey/landscapes"));
    let mapped = landscapes();
    desk.succeed(&format!("{OF_ONE_HAND} -o shared.survey"));
    assert!(landscapes() == mapped, "the join maps nothing again");
    let [plain, shared] = ["plain.survey", "shared.survey"].map(|name| promised(&desk.path(name)));
    assert!(plain == shared, "the same bytes");
    assert!(!desk.path("shared.survey.partial").exists());
}

#[test]
fn no_task_is_beyond_the_last() {
    let desk = Desk::empty();
    for task in ["5/4", "0/3", "x"] {
        assert_eq!(
            desk.early_mistake(&format!("survey set --task {task}")),
            format!(
                "invalid --task `{task}`: expected NUMBER/COUNT with 1 ≤ NUMBER ≤ COUNT, such as 3/64"
            )
        );
    }
}

#[test]
fn what_cannot_be_surveyed_is_told() {
    let desk = data_set();
    desk.write("set/broken.parquet", "no table");
    fs::copy(
        desk.path("set/human/ball.parquet"),
        desk.path("set/human/copy.parquet"),
    )
    .unwrap();
    let output = desk.run("survey set --no-map");
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert_says(
        &said,
        &[
            "human/copy contains the same grasps as human/ball and is left out",
            "1 of the files or populations could not be surveyed",
            "broken.parquet",
        ],
    );
    assert!(
        !said.contains("broken.parquet: set/broken.parquet"),
        "{said}"
    );
    let survey = desk.json("set.survey/survey.json");
    assert_eq!(survey["failures"][0]["file"], "broken.parquet");
    assert_eq!(survey["populations"].as_array().unwrap().len(), 3);

    fs::create_dir(desk.path("empty")).unwrap();
    assert_says(
        &desk.early_mistake("survey empty"),
        &["no file with the ending .parquet", "import"],
    );
    assert_says(
        &desk.early_mistake("survey nowhere.parquet"),
        &["no such file or folder: nowhere.parquet"],
    );
    assert_says(
        &desk.early_mistake("survey set/broken.parquet"),
        &["none of the 1 files could be read", "broken.parquet"],
    );
    fs::create_dir(desk.path("mine.survey")).unwrap();
    desk.write("mine.survey/thesis.md", "mine");
    assert_says(
        &desk.early_mistake("survey set -o mine.survey"),
        &["thesis.md", "this command would not write"],
    );
    assert_says(
        &desk.early_mistake("survey set/human/ball.parquet set/gripper_parallel/ball.parquet --no-map -o two.survey"),
        &["have the same name", "give the folder that contains both"],
    );
}
