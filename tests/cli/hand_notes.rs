//! What is noted when a hand is read: every command that uses the hand says it, once.

use std::fs;

use serde_json::Value;

use crate::desk::Desk;

/// Two jaws; one turns endlessly although it has limits.
const JAWS: &str = r#"<robot name="jaws">
<link name="palm"><collision><geometry><box size="0.08 0.03 0.02"/></geometry></collision></link>
<link name="left"><collision><origin xyz="0 0 0.03"/><geometry><box size="0.01 0.02 0.06"/></geometry></collision></link>
<link name="right"><collision><origin xyz="0 0 0.03"/><geometry><box size="0.01 0.02 0.06"/></geometry></collision></link>
<joint name="l" type="revolute"><parent link="palm"/><child link="left"/><origin xyz="-0.04 0 0.015"/><axis xyz="0 1 0"/>
  <limit lower="-0.3" upper="0.8" effort="1" velocity="1"/></joint>
<joint name="r" type="continuous"><parent link="palm"/><child link="right"/><origin xyz="0.04 0 0.015"/><axis xyz="0 -1 0"/>
  <limit lower="-0.3" upper="0.8" effort="1" velocity="1"/></joint></robot>"#;
const NOTE: &str = "warning: hand jaws: joint \"r\": it is continuous and turns endlessly";

#[test]
fn every_command_tells_the_notes_of_its_hand_once() {
    let desk = Desk::empty();
    desk.write("jaws.urdf", JAWS);
    fs::create_dir(desk.path("set")).unwrap();
    let synth = "synth --hand jaws.urdf --object ball -n 2 --steps 1 --keep all --drop 0 -o";
    for line in [
        format!("{synth} set/one.parquet"),
        format!("{synth} set/two.parquet --seed 2"),
        "synth --from set/one.parquet -n 1 --steps 1 --keep all --drop 0 -o more.parquet"
            .to_owned(),
        "inspect set/one.parquet".to_owned(),
        "label set/one.parquet -o l.parquet".to_owned(),
        "export set/one.parquet csv -o one.csv".to_owned(),
        "import one.csv --hand jaws.urdf --object ball -o again.parquet".to_owned(),
        "survey set --no-map".to_owned(),
        "diversity set/one.parquet set/two.parquet".to_owned(),
    ] {
        let said = String::from_utf8(desk.run(&line).stderr).unwrap();
        assert_eq!(said.matches(NOTE).count(), 1, "landscape {line}: {said}");
    }
    let imported =
        desk.run("import one.csv --hand jaws.urdf --object ball -o again.parquet --json --quiet");
    assert!(imported.stderr.is_empty(), "quiet");
    let value: Value = serde_json::from_slice(&imported.stdout).unwrap();
    let note = value["notes"][0].as_str().unwrap();
    assert!(
        NOTE.ends_with("endlessly") && note.starts_with("hand jaws: joint \"r\""),
        "{note}"
    );
}

/// The landscape keeps the notes, so that its page tells them.
#[test]
fn a_landscape_keeps_the_notes_of_its_hand() {
    let desk = Desk::empty();
    desk.write("jaws.urdf", JAWS);
    desk.run(
        "synth --hand jaws.urdf --object ball -n 3 --steps 1 --keep all --drop 0 -q -o g.parquet",
    );
    let built = desk.run("build g.parquet --first 2 --no-report -o g.landscape");
    let said = String::from_utf8(built.stderr).unwrap();
    assert_eq!(said.matches(NOTE).count(), 1, "{said}");
    let text = desk.text("g.landscape/landscape.json");
    let manifest: Value = serde_json::from_str(&text).unwrap();
    let kept = manifest["warnings"].as_array().unwrap().iter();
    let of_hand = kept.filter(|warning| warning.as_str().unwrap().starts_with("hand jaws: joint"));
    assert_eq!(of_hand.count(), 1, "{text}");
}
