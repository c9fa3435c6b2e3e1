//! Labels given on the page belong to the grasps of one file, and everything on the page tells the same label.

use std::fs;

use serde_json::{Value, json};

use super::{desk_with_page, made, succeed};
use crate::browser::{Kind, Remote, act, browser};
use crate::desk::Desk;

/// All pages that are opened as files share what a browser keeps. Files that `synth` writes have one name and the ids 0, 1, 2.
#[test]
fn labels_of_a_file_stay_out_of_another_of_the_same_name() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    for (folder, first) in [("one", 0), ("other", 3)] {
        let mut file = made::committed();
        file.grasps = file.grasps[first..first + 3].to_vec();
        for (id, row) in file.grasps.iter_mut().enumerate() {
            row.id = id as u64;
        }
        fs::create_dir(desk.path(folder)).unwrap();
        file.write(&desk.path(&format!("{folder}/grasps.parquet")))
            .unwrap();
        succeed(&desk, &format!("report {folder}/grasps.parquet -q"));
    }
    let mut remote = Remote::start(Kind::Chromium, &browser, &desk, &[], "");
    remote.open(&desk, "one/grasps.grasps.html", "");
    remote.evaluate(
        "(panels.label.open(), [0, 1, 2].forEach(k => { panels.label.go(k); panels.label.give('Tripod'); }), panels.label.close(), 0)",
    );
    remote.open(&desk, "other/grasps.grasps.html", "");
    assert_eq!(remote.evaluate("panels.label.csv()"), "id,label\n");
    let table = remote.evaluate("document.querySelector('#table .rows').textContent");
    assert!(!table.as_str().unwrap().contains("Tripod"), "{table}");
    assert_eq!(remote.evaluate("byId('own').checkVisibility()"), false);

    // The page of the labelled grasps has them again, says so, and can forget them.
    remote.open(&desk, "one/grasps.grasps.html", "");
    let told = |remote: &mut Remote| {
        remote.evaluate(
            "[byId('own').textContent, panels.label.csv().trim().split('\\n').length - 1]",
        )
    };
    let kept = told(&mut remote);
    assert_eq!(
        kept,
        json!(["3 labels from this browser, not in the file discard", 3])
    );
    remote.evaluate("(byId('labels-discard').click(), 0)");
    remote.wait_until("byId('own').textContent.startsWith('labels discarded')");
    assert_eq!(told(&mut remote)[1], 0);
    remote.evaluate("(byId('labels-undo').click(), 0)");
    remote.wait_until("byId('labels-discard')");
    remote.evaluate("(byId('labels-discard').click(), 0)");
    remote.reload();
    assert_eq!(told(&mut remote)[1], 0);
    assert_eq!(remote.mishaps(), Vec::<String>::new());
}

/// Gives one item a label that nobody else has, and reads what each part of the page says of it.
const GIVE: &str = r##"
await settled();
const item = ITEM;
const wanted = model.header.taxonomy.find(type => !Array.from({ length: model.count }, (_, k) => model.number("type", k)).includes(type.number));
const chart = () => [...document.querySelectorAll("#matrix .chip")].find(chip => chip.title.startsWith(wanted.number + " ")).textContent;
const read = async () => {
  change({ hover: item, colour: "category", level: null });
  await settled();
  const row = document.querySelector(`#table [data-item="${item}"]`);
  const told = {
    table: row.textContent.includes(wanted.name),
    caption: document.querySelector("#scene .caption").textContent.includes(wanted.name),
    dot: colourOf(item) === model.key.get(wanted.category).colour && row.querySelector(".dot > *").getAttribute("fill") === colourOf(item),
    chart: chart(),
    legend: document.getElementById("legend").textContent,
  };
  await type(byId("query"), `label = "${wanted.name}" and type = ${wanted.number} and cell = "${wanted.cell}" and category = ${wanted.category}`);
  told.found = derived.passing;
  await type(byId("query"), wanted.name.split(" ")[0].toLowerCase() + ` label = "${wanted.name}"`);
  told.word = derived.passing;
  await type(byId("query"), "");
  told.csv = csv([item]).includes(wanted.name);
  return told;
};
const before = await read();
panels.label.open();
panels.label.go(item);
panels.label.give(wanted.name);
panels.label.close();
const after = await read();
panels.label.open();
panels.label.go(item);
panels.label.give("");
panels.label.close();
const again = await read();
finish({ before, after, again, number: wanted.number, members: model.number("members", item) });
"##;

fn agrees(told: &Value) {
    let count = format!("{}·{}", told["number"], told["members"]);
    let after = &told["after"];
    for panel in ["table", "caption", "dot", "csv"] {
        assert_eq!(after[panel], true, "{panel}: {after}");
    }
    assert_eq!((&after["found"], &after["word"]), (&json!(1), &json!(1)));
    assert_eq!(after["chart"], count, "the chart counts it");
    assert_ne!(told["before"]["chart"], count);
    assert_eq!(
        told["again"], told["before"],
        "without the label all is as it was"
    );
}

#[test]
fn a_label_is_the_same_in_all_panels() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    agrees(&act(
        &browser,
        &desk,
        "g.report.html",
        "",
        &GIVE.replace("ITEM", "2"),
    ));
    let mut file = made::committed();
    file.grasps.truncate(8);
    file.write(&desk.path("p.parquet")).unwrap();
    succeed(&desk, "report p.parquet -q");
    agrees(&act(
        &browser,
        &desk,
        "p.grasps.html",
        "",
        &GIVE.replace("ITEM", "0"),
    ));
}

/// The label of a minimum in the files is that of most of its grasps, so only labels that were given on the page are saved.
#[test]
fn labels_of_minima_are_saved_only_if_they_were_given_here() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let script = "panels.label.open();
    model.sides[0].given = { texts: ['Ring'], of: new Uint8Array(model.count) };
    const before = panels.label.csv();
    panels.label.go(1); panels.label.give('Tripod'); panels.label.close();
    finish({ before, after: panels.label.csv(), members: model.sides[0].members[1] });";
    let told = act(&browser, &desk, "g.report.html", "", script);
    assert_eq!(told["before"], "id,label\n");
    let ids = told["members"].as_str().unwrap().split(' ');
    let rows: Vec<String> = ids.map(|id| format!("{id},Tripod\n")).collect();
    assert_eq!(told["after"], format!("id,label\n{}", rows.concat()));
}

/// A label in the file counts until it is taken away on the page; then the rule's does.
#[test]
fn the_rule_speaks_where_a_label_of_the_file_is_taken_away() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    let mut file = made::committed();
    file.grasps.truncate(2);
    file.write(&desk.path("plain.parquet")).unwrap();
    file.grasps[0].label = Some("Ring".to_owned());
    file.write(&desk.path("given.parquet")).unwrap();
    let label = "const told = [model.text('label', 0), model.number('type', 0), model.text('category', 0)];";
    let mut told = ["plain", "given"].map(|name| {
        succeed(&desk, &format!("report {name}.parquet -q"));
        let script = format!(
            "{label} panels.label.open(); panels.label.go(0); panels.label.give(''); panels.label.close();
            const away = [model.text('label', 0), model.number('type', 0), model.text('category', 0)];
            finish({{ told, away, csv: panels.label.csv(), key: given.key }});"
        );
        act(&browser, &desk, &format!("{name}.grasps.html"), "", &script)
    });
    assert_eq!(told[1]["told"][0], "Ring");
    // What is taken away is written, so that `label --from` takes it away, too.
    let id = file.grasps[0].id;
    assert_eq!(told[0]["csv"], "id,label\n");
    assert_eq!(told[1]["csv"], format!("id,label\n{id},\n"));
    assert_eq!(
        told[0]["key"], told[1]["key"],
        "a label in the file changes nothing of whose labels these are"
    );
    assert_eq!(told[1]["away"].take(), told[0]["told"].take());
}
