//! Published tests and measures of sets whose answers are known.

use serde_json::Value;

use crate::desk::{Desk, assert_says};
use landscape::space::Pose;
use landscape::store::{GraspFile, Overrides};

/// Six real grasps, and the same with the hand a metre farther along x, where it holds nothing.
fn sets() -> Desk {
    let desk = Desk::empty();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/data/grasps.parquet");
    let (mut file, _) = GraspFile::read(data.as_ref(), Overrides::default()).unwrap();
    file.grasps.truncate(6);
    file.write(&desk.path("held.parquet")).unwrap();
    for row in &mut file.grasps {
        let pose = &row.grasp.pose;
        let [x, y, z] = *pose.translation_m() else {
            unreachable!("a place")
        };
        row.grasp.pose = Pose::new([x + 1.0, y, z], pose.rotation_wxyz(), pose.joints());
    }
    file.write(&desk.path("far.parquet")).unwrap();
    desk
}

const LINE: &str = "judge held.parquet far.parquet --tests drop,dexgraspbench,graspqp-all --measures distinct,digits,vendi -o two";

#[test]
fn a_set_that_holds_and_one_that_is_far_away() {
    let desk = sets();
    let found: Value = serde_json::from_str(&desk.print(&format!("{LINE} --json"))).unwrap();
    assert_eq!(found["deciding"], "dexgraspbench");
    for test in 0..3 {
        let held = &found["sets"][0]["tests"][test];
        assert_eq!(held["holds"], 1.0, "{held}");
        // Six of six grasps are no proof that all would hold.
        let low = held["interval"][0].as_f64().unwrap();
        assert!((0.5..0.7).contains(&low), "{low}");
        assert_eq!(found["sets"][1]["tests"][test]["holds"], 0.0);
    }
    assert_eq!(found["agreement"][0][2], 1.0);
    let value = |set: usize, measure: usize| &found["sets"][set]["measures"][measure];
    assert!(value(0, 0)["value"].as_f64().unwrap() >= 2.0);
    assert_eq!(value(1, 0)["value"], 0.0, "no distinct grasp holds");
    assert!(value(0, 1)["value"].as_f64().unwrap() > value(1, 1)["value"].as_f64().unwrap());
    assert_eq!(value(1, 2)["value"], Value::Null);
    let table = desk.text("two.csv");
    assert!(
        table.starts_with("set,kind,name,value,low,high,unit,grasps\n"),
        "{table}"
    );
    assert_eq!(table.lines().count(), 1 + 2 * 6);
    let grasps = desk.text("two.grasps.csv");
    assert!(
        grasps.contains("held,held,held") && grasps.contains("fell,moved,moved"),
        "{grasps}"
    );
    assert_says(
        &desk.text("two.md"),
        &[
            "## Share of the grasps that hold",
            "squeezed joints of 6 of 6 grasps",
            "arXiv:2104.09194",
        ],
    );
}

#[test]
fn names_of_tests_and_measures_are_listed() {
    let desk = Desk::with_grasps();
    assert_says(
        &desk.early_mistake("judge g.parquet --tests fall"),
        &["--tests fall", "drop, dexgraspbench"],
    );
    assert_says(
        &desk.early_mistake("judge g.parquet --measures beauty"),
        &["--measures beauty", "epsilon, q1"],
    );
    assert_says(
        &desk.early_mistake("judge g.parquet --tests none --measures none"),
        &["nothing is left to do"],
    );
}
