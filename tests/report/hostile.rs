//! Names, labels and notes that look like markup, or turn the direction of writing, stay text wherever the page shows them.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::made::changed;
use super::{made, succeed};
use crate::browser::{act, browser};
use crate::desk::Desk;

/// Ends a script and begins one, hides what follows, holds quotes and marks that turn the direction of writing; then long.
fn hostile(what: &str) -> String {
    let attack = "</script><script>window.hurt=1</script><img src=x onerror=\"window.hurt=1\"><!-- ]]> '&amp;";
    format!(
        "{what} {attack} \u{202e}ekil\u{2067} {}",
        "long".repeat(200)
    )
}

/// What the page of a landscape or of a file of grasps shows; nothing of it was run.
fn looked_at(browser: &Path, desk: &Desk, shown: &Path) -> Value {
    let output = desk
        .command("report -q -o hostile.html")
        .arg(shown)
        .output();
    let output = output.unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let told = act(browser, desk, "hostile.html", "", LOOK);
    harmless(&told);
    told
}

/// Shows everything, and tells what came of it.
const LOOK: &str = r##"
await settled();
const [a, b] = [0, 1].map(item => model.name(item));
location.hash = `sel=${encodeURIComponent(a)},${encodeURIComponent(b)}&pin=${encodeURIComponent(a)}&level=0.2`;
await wait(300);
change({ hover: 0 });
await settled();
if (panels.tree) await point(panels.tree.drawing.canvas, "pointermove", panels.tree.at(0));
const caption = document.querySelector("#scene .caption")?.textContent ?? "";
const tipped = byId("tip").textContent;
for (const details of document.querySelectorAll("#trust details")) details.open = true;
const drawings = Object.values(panels).filter(panel => panel.drawing).map(panel => panel.drawing.svg());
const parsed = drawings.every(svg => !new DOMParser().parseFromString(svg, "image/svg+xml").querySelector("parsererror"));
panels.label?.open();
openExport();
await settled();
finish({
  title: byId("title").textContent,
  tab: document.title,
  trust: byId("trust").textContent,
  made: byId("made").textContent,
  cells: [...document.querySelectorAll("#table [role=gridcell]")].map(cell => cell.textContent),
  caption, tipped, parsed,
  cards: byId("labelling").textContent,
  commands: byId("commands").textContent,
  hurt: window.hurt ?? null,
  images: document.images.length,
  // The data are taken away at the start, and the harness adds two scripts.
  scripts: document.scripts.length,
  wide: document.documentElement.scrollWidth <= innerWidth,
  high: byId("title").getBoundingClientRect().height,
});
"##;

fn harmless(told: &Value) {
    assert_eq!((&told["hurt"], &told["images"]), (&Value::Null, &json!(0)));
    assert_eq!(
        told["scripts"], 3,
        "the page's own and those of the test: no other"
    );
    assert_eq!(told["parsed"], true, "saved pictures are proper XML");
    assert_eq!(told["wide"], true, "a long name does not widen the page");
    assert!(
        told["high"].as_f64().unwrap() < 120.0,
        "a long title takes a few lines: {}",
        told["high"]
    );
    // What is told in one sentence with other words must not turn these.
    for told in [&told["caption"], &told["tipped"], &told["cards"]] {
        let told = told.as_str().unwrap();
        assert!(!told.contains(['\u{202e}', '\u{2067}']), "{told:?}");
    }
}

#[test]
fn hostile_names_of_a_landscape_stay_text() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    let folder = desk.path("<b>&quot;'.landscape");
    made::landscape(12, 3, &folder);
    changed(&folder, |files| {
        let manifest = &mut files.manifest;
        manifest.object.as_mut().unwrap().name = hostile("object");
        manifest.hand.as_mut().unwrap().name = hostile("hand");
        manifest.command = hostile("command");
        manifest.warnings = vec![hostile("note")];
        for edge in &mut files.edges {
            edge.term = Some(hostile("term"));
            edge.way = Some(hostile("way"));
        }
        for row in &mut files.minima {
            row.labels = [(hostile("label"), 1)].into();
        }
    });
    let told = looked_at(&browser, &desk, &folder);
    assert!(told["title"].as_str().unwrap().contains(&hostile("object")));
    assert_says(&told["trust"], &hostile("ote"));
    let commands = told["commands"].as_str().unwrap();
    assert!(
        commands.contains("landscape inspect '<b>&quot;'\\''.landscape' --path m0 m1"),
        "{commands}"
    );
}

fn assert_says(told: &Value, text: &str) {
    assert!(told.as_str().unwrap().contains(text), "{text:?} in {told}");
}

#[test]
fn hostile_names_of_a_population_stay_text() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    let mut file = made::committed();
    file.grasps.truncate(4);
    for name in &mut file.metadata.objects {
        name.name = hostile("object");
    }
    for name in &mut file.metadata.hands {
        name.name = hostile("hand");
    }
    file.metadata.command = hostile("command");
    for row in &mut file.grasps {
        row.object = hostile("object");
        row.hand = hostile("hand");
        row.label = Some(hostile("label"));
    }
    let name = "<script>window.hurt=1<!--\u{202e}.parquet";
    file.write(&desk.path(name)).unwrap();
    let told = looked_at(&browser, &desk, name.as_ref());
    let cells = told["cells"].as_array().unwrap();
    assert!(cells.contains(&json!(hostile("label"))), "{cells:?}");
    assert!(told["title"].as_str().unwrap().contains("<script>"));
}

#[test]
fn hostile_names_of_a_surface_stay_text() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    succeed(&desk, "surface muller-brown -q --no-report");
    changed(&desk.path("muller-brown.landscape"), |files| {
        files.manifest.source.name = hostile("surface");
        files.manifest.command = hostile("command");
        files.manifest.warnings = vec![hostile("note")];
    });
    succeed(
        &desk,
        "report muller-brown.landscape -q --force -o hostile.html",
    );
    let told = act(&browser, &desk, "hostile.html", "", LOOK);
    harmless(&told);
    assert_says(&told["title"], &hostile("surface"));
    assert_says(&told["trust"], &hostile("ote"));
    let text = fs::read_to_string(desk.path("hostile.html")).unwrap();
    assert_eq!(
        text.matches("<script").count(),
        2,
        "names stand in the packed data only"
    );
}
