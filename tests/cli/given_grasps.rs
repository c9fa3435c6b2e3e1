//! Synthesis from given grasps, and maps of them.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::desk::{Desk, assert_says};
use crate::parts::Parts;
use crate::table::rows;
use arrow_array::StringArray;
use landscape::grasp::contact::CONTACTS;
use landscape::grasp::{EnergySettings, GraspEnergy, judge};
use landscape::hand::{Hand, HandFiles};
use landscape::object::Object;
use landscape::space::{PoseSpace, Space, Symmetry};
use landscape::store::{GraspFile, GraspRow, Overrides};

/// By default there is one chain for each given grasp. Its end is near that grasp and does not depend on the number of
/// threads.
#[test]
fn synthesis_from_given_grasps() {
    let desk = Desk::with_grasps();
    let read = |name: &str| desk.grasps(name);
    let given = read("g.parquet");
    let pose = |row: &GraspRow| row.grasp.pose.to_vec();
    let space = PoseSpace::new(Hand::human().pose_metric(), Symmetry::None);
    let apart = |name: &str| -> Vec<f64> {
        let rows = read(name).grasps;
        rows.iter()
            .map(|row| {
                let from = &given.grasps[usize::try_from(row.id).unwrap() % given.grasps.len()];
                assert!(
                    row.source.ends_with(&format!("from {}", from.id)),
                    "{}",
                    row.source
                );
                space.distance(&pose(row), &pose(from))
            })
            .collect()
    };
    let line = "synth --from g.parquet --steps 1 --keep all --seed 3 -q";
    desk.succeed(&format!("{line} -o near.parquet --threads 1"));
    desk.succeed(&format!("{line} -o near2.parquet --threads 2"));
    assert_eq!(desk.bytes("near.parquet"), desk.bytes("near2.parquet"));
    let near = read("near.parquet");
    assert_eq!(near.grasps.len(), given.grasps.len());
    assert_eq!(
        (&near.metadata.hands, &near.metadata.objects),
        (&given.metadata.hands, &given.metadata.objects)
    );
    assert_says(
        &near.metadata.command,
        &["landscape synth --from g.parquet --steps 1 --seed 3 --keep all"],
    );
    // Not worse than what was given.
    let hand = Arc::new(Hand::human());
    let ball = Arc::new(Object::named("ball").unwrap());
    let energy = GraspEnergy::new(hand, ball, EnergySettings::default()).unwrap();
    let strict = |grasp: &GraspRow| judge(&energy, &grasp.grasp).passes_strict();
    for (row, from) in near.grasps.iter().zip(&given.grasps) {
        let (before, after) = (strict(from), strict(row));
        assert!(
            after >= before,
            "row {} is no strict grasp any more",
            row.id
        );
        assert!(
            (after && !before) || row.energy <= from.energy + 1e-12,
            "row {}: {} from {}",
            row.id,
            row.energy,
            from.energy
        );
    }

    let mean = |lengths: Vec<f64>| lengths.iter().sum::<f64>() / lengths.len() as f64;
    let refined_m = mean(apart("near.parquet"));
    assert!(refined_m < 0.02, "refined {refined_m} m away");

    desk.succeed(&format!("{line} --perturb 60 -n 13 -o far.parquet"));
    let far = read("far.parquet").grasps;
    assert_eq!(
        far.iter().map(|row| row.id).collect::<Vec<_>>(),
        (0..13).collect::<Vec<_>>()
    );
    let perturbed_m = mean(apart("far.parquet"));
    assert!(
        perturbed_m > 2.0 * refined_m && perturbed_m < 0.2,
        "{refined_m} {perturbed_m}"
    );
    assert_ne!(
        pose(&far[0]),
        pose(&far[6]),
        "the same grasp, moved differently"
    );
    assert_says(
        &read("far.parquet").metadata.command,
        &["--from g.parquet --perturb 60 -n 13"],
    );
}

/// Hand and object are taken from the file; neither their original files nor a flag is needed.
#[test]
fn given_grasps_bring_their_hand_and_object() {
    let desk = Desk::empty();
    let human = HandFiles::named("human").unwrap().files;
    let [urdf, side] = [&human[0].text, &human[1].text];
    desk.write("own.urdf", urdf);
    desk.write("own.json", side);
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/objects");
    let mesh = fs::read_to_string(data.join("ball.obj")).unwrap();
    desk.write("globe.obj", mesh);
    let description = fs::read_to_string(data.join("ball.json")).unwrap();
    desk.write("globe.json", description.replace("\"ball\"", "\"globe\""));
    let line = "--steps 1 --keep all --seed 3 -q";
    desk.succeed(&format!(
        "synth --hand own.urdf --object globe.obj -n 2 {line} -o g.parquet"
    ));
    for name in ["own.urdf", "own.json", "globe.obj", "globe.json"] {
        fs::remove_file(desk.path(name)).unwrap();
    }
    desk.succeed(&format!("synth --from g.parquet {line} -o refined.parquet"));
    let read = |name: &str| desk.grasps(name);
    let (given, refined) = (read("g.parquet"), read("refined.parquet"));
    let names = |file: &GraspFile| {
        (
            file.metadata.hands[0].name.clone(),
            file.metadata.objects[0].name.clone(),
        )
    };
    assert_eq!(names(&given), ("own".to_owned(), "globe".to_owned()));
    assert_eq!(names(&refined), names(&given));
    assert_eq!(refined.metadata.objects, given.metadata.objects);
    assert!(
        refined
            .grasps
            .iter()
            .all(|row| (&*row.hand, &*row.object) == ("own", "globe"))
    );
}

#[test]
fn mistakes_with_given_grasps() {
    let desk = Desk::with_grasps();
    let mut mixed = desk.grasps("g.parquet");
    mixed.grasps[0].scale = 1.5;
    mixed.write(&desk.path("mixed.parquet")).unwrap();
    desk.write("text.parquet", "no table");
    let cases = "
        synth --from absent.parquet | absent.parquet
        synth --from text.parquet | text.parquet | Parquet
        synth --from mixed.parquet | --from mixed.parquet | 2 pairs of hand and object
        synth --from g.parquet --perturb -1 | --perturb -1 | mm
        synth --from g.parquet --perturb nan | --perturb NaN | mm
        synth --from g.parquet -n 0 | -n 0
        synth --object ball --perturb 3 | --from
        synth | --object
    ";
    for case in rows(cases) {
        assert_says(&desk.early_mistake(case[0]), &case[1..]);
    }
}

/// The file `name` without its metadata, as polars and `DuckDB` write it.
fn without_metadata(desk: &Desk, name: &str) -> Parts {
    let mut parts = Parts::of(&desk.path(name));
    parts.metadata = None;
    parts
}

/// What rows without metadata name is what comes with the program, or what a flag gives in its place.
#[test]
fn names_in_rows_without_metadata() {
    let desk = Desk::with_grasps();
    let energy = |name: &str| {
        let read = GraspFile::read(&desk.path(name), Overrides::default());
        read.unwrap().0.metadata.energy
    };
    let objects = |name: &str| -> Vec<String> {
        let read = GraspFile::read(&desk.path(name), Overrides::default());
        let file = read.unwrap().0;
        file.grasps.into_iter().map(|grasp| grasp.object).collect()
    };
    let lost = || without_metadata(&desk, "g.parquet");
    let named = |names: &[&str]| {
        let names: Vec<&str> = names.iter().copied().cycle().take(6).collect();
        lost().set("object", StringArray::from(names))
    };
    lost().write(&desk.path("lost.parquet"));
    let said = desk.succeed("label lost.parquet -o l.parquet");
    assert_says(
        &said,
        &[
            "hand `human`: what comes with",
            "object `ball`: what comes with",
        ],
    );
    let said = desk.succeed("inspect lost.parquet");
    assert_says(&said, &["the default one is used"]);
    assert!(energy("l.parquet").is_null() && !energy("g.parquet").is_null());

    let nameless = lost().without("hand").without("object");
    nameless.write(&desk.path("nameless.parquet"));
    assert_says(
        &desk.early_mistake("label nameless.parquet"),
        &[
            "nameless.parquet",
            "does not describe its hand and object",
            "--hand",
        ],
    );
    desk.succeed("label nameless.parquet --hand human --object ball -o l.parquet --force");
    assert_eq!(objects("l.parquet")[0], "ball");

    named(&["ball", "box"]).write(&desk.path("two.parquet"));
    desk.succeed("label two.parquet -o l.parquet --force");
    assert_eq!(objects("l.parquet")[..2], ["ball", "box"]);
    desk.succeed("label two.parquet --object box -o l.parquet --force");

    named(&["sem-Ball-1"]).write(&desk.path("own.parquet"));
    assert_says(
        &desk.early_mistake("label own.parquet"),
        &["does not describe its object", "`sem-Ball-1`", "--object"],
    );
    let said = desk.succeed("label own.parquet --object ball -o l.parquet --force");
    assert_says(&said, &["`ball` for `sem-Ball-1`"]);
    assert_eq!(objects("l.parquet")[0], "sem-Ball-1");

    named(&["sem-Ball-1", "sem-Ball-2"]).write(&desk.path("several.parquet"));
    assert_says(
        &desk.early_mistake("label several.parquet --object ball"),
        &["object `sem-Ball-1` is not the one described"],
    );
}

/// `--object` of a file that describes its own: the poses are judged with the other one, and what is written says so.
#[test]
fn grasps_are_judged_with_another_object() {
    let desk = Desk::with_grasps();
    let judged = |flags: &str| -> (serde_json::Value, String) {
        let output = desk.run(&format!("inspect g.parquet --json {flags}"));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        (serde_json::from_slice(&output.stdout).unwrap(), said)
    };
    let (own, said) = judged("");
    assert_eq!(said, "");
    // The same hand and object are no news.
    assert_eq!(judged("--hand human --object ball"), (own.clone(), said));

    let (other, said) = judged("--object can");
    assert_says(
        &said,
        &["using object `can` instead of `ball`", "computed again"],
    );
    assert_eq!(other["grasps"][0]["object"], "can");
    let energies = |told: &serde_json::Value| -> Vec<f64> {
        let rows = told["grasps"].as_array().unwrap().iter();
        rows.map(|row| row["energy"].as_f64().unwrap()).collect()
    };
    assert!(
        energies(&own)
            .iter()
            .zip(energies(&other))
            .all(|(own, other)| (own - other).abs() > 1e-6)
    );

    // A file that is written is one of the other object, and needs no flag any more.
    desk.succeed("label g.parquet --object can -q -o other.parquet");
    let file = desk.grasps("other.parquet");
    let names = file.metadata.objects.iter().map(|object| &*object.name);
    assert_eq!(names.collect::<Vec<_>>(), ["can"]);
    assert!(file.grasps.iter().all(|row| row.object == "can"));
    let told: Vec<f64> = file.grasps.iter().map(|row| row.energy).collect();
    assert_eq!(told, energies(&other));

    // Another hand must have the same joints, and brings its own points of contact.
    let human = HandFiles::named("human").unwrap().files;
    let [urdf, side] = [&human[0].text, &human[1].text];
    desk.write("own.urdf", urdf);
    desk.write("own.json", format!("{side} "));
    let (other, said) = judged("--hand own.urdf");
    assert_says(
        &said,
        &["using hand `own` instead of `human`", "contacts are chosen"],
    );
    assert_eq!(other["grasps"][0]["hand"], "own");
    let contacts = other["grasps"][0]["contacts"].as_array().unwrap().len();
    assert_eq!(contacts, CONTACTS);
    for line in [
        "inspect g.parquet",
        "label g.parquet",
        "stability g.parquet",
        "build g.parquet",
        "export g.parquet glb",
        "synth --from g.parquet",
    ] {
        let sentence = desk.early_mistake(&format!("{line} --hand gripper_parallel"));
        assert_says(
            &sentence,
            &[
                "g.parquet: its poses do not fit the hand given",
                "hand `human` has joints",
            ],
        );
    }
}
