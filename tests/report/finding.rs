//! Searches of what is not known, filters by the legend, branches of the tree, and words that explain themselves.

use std::fs;

use landscape::evaluation::taxonomy::{Category, Taxonomy};
use landscape::figure::{Hue, Look};
use serde_json::json;

use super::{desk_with_page, made, succeed};
use crate::browser::{act, browser};
use crate::desk::{Desk, assert_says};

const ASK: &str = r#"
const told = { placeholder: byId("query").placeholder, answers: [] };
for (const text of QUERIES) {
  await type(byId("query"), text);
  told.answers.push([derived.passing, byId("answer").textContent]);
}
finish(told);
"#;

/// A search of something that the file does not hold is refused with the reason; nothing is said to be so for no grasp.
#[test]
fn a_search_of_what_is_unknown_is_refused() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let mut file = made::committed();
    file.grasps.truncate(6);
    for row in &mut file.grasps {
        (row.stable, row.epsilon) = (None, None);
    }
    file.write(&desk.path("bare.parquet")).unwrap();
    for (k, row) in file.grasps.iter_mut().enumerate() {
        (row.stable, row.epsilon) = (Some(k < 2), Some(0.1));
    }
    file.write(&desk.path("full.parquet")).unwrap();
    let queries = json!([
        "stable",
        "not unstable",
        "epsilon > 0.05",
        "members > 3",
        "family = #1",
        "energy < 99",
        "g0"
    ]);
    let ask = |page: &str| {
        let script = ASK.replace("QUERIES", &queries.to_string());
        act(&browser, &desk, page, "", &script)
    };
    let simulated_first = |told: &serde_json::Value, command: &str| {
        for place in [0, 1] {
            let said = told["answers"][place][1].as_str().unwrap();
            assert_says(said, &["nothing was simulated", command]);
        }
        assert!(
            !told["placeholder"].as_str().unwrap().contains("stable"),
            "{told}"
        );
    };
    simulated_first(
        &ask("g.report.html"),
        "landscape report g.landscape --stability FILE",
    );
    succeed(&desk, "report bare.parquet -q");
    let told = ask("bare.grasps.html");
    simulated_first(&told, "landscape stability bare.parquet");
    let said = |place: usize| told["answers"][place][1].as_str().unwrap().to_owned();
    assert_says(
        &said(2),
        &["nothing here has “epsilon”", "known are energy, "],
    );
    assert_says(&said(3), &["nothing here has “members”"]);
    assert_says(&said(4), &["nothing here has “family”"]);
    assert_eq!(said(5), "6 of 6");
    assert_says(&said(6), &["nothing here has “group”"]);
    assert!(!told["placeholder"].as_str().unwrap().contains("epsilon"));
    succeed(&desk, "report full.parquet -q");
    let told = ask("full.grasps.html");
    assert_eq!(told["answers"][0], json!([2, "2 of 6"]));
    assert_eq!(told["answers"][2], json!([6, "6 of 6"]));
    assert_says(
        told["placeholder"].as_str().unwrap(),
        &["stable", "epsilon"],
    );
}

#[test]
fn the_legend_filters_and_the_filter_stays_in_sight() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let script = r##"
await settled();
const entries = () => [...document.querySelectorAll("#legend button:not(.filter)")];
const chips = () => [...document.querySelectorAll("#legend .filter")];
const told = { entries: entries().map(entry => entry.textContent) };
const of = entry => Number(entry.textContent.match(/(\d+)$/)[1]);
const [first, second] = entries().map(of);
entries()[0].click();
await settled();
told.one = [derived.passing === first, chips().length, entries()[0].getAttribute("aria-pressed"), document.querySelectorAll("#table .rows .row").length > 0];
await type(byId("query"), "energy < 99");
await type(byId("query"), "");
told.stays = chips().length;
entries()[1].click();
await settled();
told.both = derived.passing === first + second;              // alternatives of one field
change({ colour: "group" });
await settled();
told.other = chips().length;                                 // another colour: the filters stay
entries()[0].click();
await settled();
told.narrower = derived.passing <= first + second && chips().length === 3;
await wait(300);
told.address = location.hash;
change({ chips: [] });
await wait(300);
location.hash = told.address;
await wait(300);
told.again = chips().length;
for (let k = 0; k < 3; k++) { chips()[0].click(); await settled(); }
told.gone = [chips().length, derived.passing === model.count];
change({ level: (panels.tree.low + panels.tree.high) / 2 });
await settled();
told.colour = [byId("colour").disabled, byId("colour").value];
const family = derived.basins.list.reduce((a, b) => (b.length > a.length ? b : a));
entries()[0].click();
await settled();
told.family = derived.passing === family.length;
byId("colour").value = "energy";
byId("colour").dispatchEvent(new Event("change"));
await settled();
told.back = [state.level, state.colour, chips().length, derived.passing === model.count];
const parts = entries();
told.ranges = parts.map(of).reduce((a, b) => a + b, 0) === model.count;
parts.at(-1).click();
await settled();
told.range = derived.passing === of(parts.at(-1));
// Energies that differ little: no two edges are the same number, and words and filter have the same.
ranges.energy = [-1034.21, -1033.9];
told.edges = Legend.prototype.ranges("energy", []).slice(0, 2).map(({ words, chip }) => [words, chip]);
finish(told);
"##;
    let told = act(&browser, &desk, "g.report.html", "", script);
    assert!(told["entries"].as_array().unwrap().len() > 1, "{told}");
    assert_eq!(told["one"], json!([true, 1, "true", true]));
    assert_eq!((&told["stays"], &told["both"]), (&json!(1), &json!(true)));
    assert_eq!(
        (&told["other"], &told["narrower"]),
        (&json!(2), &json!(true))
    );
    assert_says(told["address"].as_str().unwrap(), &["chip=category"]);
    assert_eq!(
        (&told["again"], &told["gone"]),
        (&json!(3), &json!([0, true]))
    );
    assert_eq!(
        told["colour"],
        json!([false, "family"]),
        "the reason of the colours is told"
    );
    assert_eq!(told["family"], true);
    assert_eq!(told["back"], json!([null, "energy", 0, true]));
    assert_eq!(
        (&told["ranges"], &told["range"]),
        (&json!(true), &json!(true))
    );
    assert_eq!(
        told["edges"],
        json!([
            ["below −1034.148", "energy < -1034.148"],
            [
                "−1034.148 to −1034.086",
                "energy ≥ -1034.148 and energy < -1034.086"
            ]
        ])
    );
}

/// With a look for each grasp type, the legend names the labels that occur and no others, each in its own look.
#[test]
fn types_are_told_apart() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let script = r##"
await settled();
// Types of one word within another, a label with quotes, and none.
["Tripod", "Writing Tripod", 'mine "1"', "unlisted", "power/palm/2-5/abducted"].forEach((label, item) => model.own.set(item, label));
change({ colour: "type", labels: null });
await settled();
const entries = () => [...document.querySelectorAll("#legend button:not(.filter)")];
const labels = Array.from({ length: model.count }, (_, item) => model.text("label", item));
const looks = new Set(labels.map(label => JSON.stringify(lookOfLabel(label))));
const told = {
  words: entries().map(entry => entry.textContent.replace(/ \d+$/, "")),
  labels: [...new Set(labels)],
  apart: looks.size === new Set(labels).size,
  dots: entries().map(entry => entry.querySelector(".dot > *").outerHTML),
  tree: panels.tree.drawing.svg(),
};
told.exact = [];
for (const label of ["Tripod", 'mine "1"', "power/palm/2-5/abducted"]) {
  const entry = entries()[told.words.indexOf(label)];
  entry.click();
  await settled();
  told.exact.push(derived.passing === labels.filter(other => other === label).length);
  told.chip = document.querySelector("#legend .filter").textContent;
  change({ chips: [] });
  await settled();
}
finish(told);
"##;
    let told = act(&browser, &desk, "g.report.html", "", script);
    let sorted = |list: &str| {
        let texts = told[list].as_array().unwrap().iter();
        let mut texts: Vec<&str> = texts.map(|text| text.as_str().unwrap()).collect();
        texts.sort_unstable();
        texts
    };
    assert_eq!(sorted("words"), sorted("labels"));
    assert_eq!(told["apart"], true);
    let mut dots = sorted("dots");
    dots.dedup();
    assert_eq!(dots.len(), sorted("words").len(), "{dots:?}");
    assert_eq!(told["exact"], json!([true, true, true]));
    assert_eq!(told["chip"], "power/palm/2-5/abducted×");
    // One of the precision types, and the first label that the taxonomy does not know.
    let feix = Taxonomy::feix();
    let mut precision = (feix.types.iter()).filter(|entry| entry.category == Category::Precision);
    let place = precision.position(|entry| entry.name == "Tripod").unwrap();
    for look in [Look::of_hue(Hue::Green, 1 + place), Look::in_turn(0)] {
        let [red, green, blue] = look.colour.rgb;
        let fill = format!("fill=\"#{red:02x}{green:02x}{blue:02x}\"");
        assert_says(told["tree"].as_str().unwrap(), &[&fill]);
    }
}

#[test]
fn a_branch_is_zoomed_into() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let script = r##"
await settled();
const tree = panels.tree;
const below = node => (node < model.count ? [node] : tree.children[node].flatMap(below));
// A merge whose bar is under the pointer, of a branch of several minima, and not the top.
const merges = Array.from({ length: tree.side.tree.energy.length - model.count }, (_, k) => k + model.count);
const bar = node => { const ends = tree.children[node].map(child => tree.x(child)); return [(Math.min(...ends) + Math.max(...ends)) / 2 + 3, tree.y(tree.side.tree.energy[node])]; };
const branch = merges.find(node => below(node).length > 4 && below(node).length < model.count / 2 && tree.found(bar(node))?.act);
const told = { tip: tree.found(bar(branch)).lines.join("; ") };
await point(tree.drawing.canvas, "click", bar(branch));
told.branch = [state.branch !== null, state.selected.length];
const inside = below(state.branch);
told.heading = document.querySelector("#tree h2").textContent === `A branch: ${inside.length} of ${model.count} minima`;
const places = inside.map(item => tree.at(item));
const [w, h] = tree.box;
told.seen = places.every(([x, y]) => x > 0 && x < w && y > 0 && y < h);
told.wide = Math.max(...places.map(([x]) => x)) - Math.min(...places.map(([x]) => x)) > 0.6 * w;
const outside = Array.from({ length: model.count }, (_, item) => item).filter(item => !inside.includes(item));
told.hidden = outside.every(item => { const found = tree.found(tree.at(item)); return found?.item !== item; });
await wait(300);
told.address = location.hash === `#branch=${state.branch}`;
const address = location.hash;
byId("tree-branch").click();
await wait(300);
told.whole = [state.branch, document.querySelector("#tree h2").textContent];
location.hash = address;
await wait(300);
told.again = state.branch !== null;
location.hash = "#branch=3";
await wait(300);
told.nonsense = state.branch;
change({ branch: null, level: tree.low + 0.6 * (tree.high - tree.low) });
await settled();
const family = derived.basins.list[0];
change({ selected: [family[0]] });
await settled();
told.button = byId("tree-branch").getAttribute("aria-label").includes("family");
byId("tree-branch").click();
await settled();
told.family = tree.drawing.order.slice().sort((a, b) => a - b).join() === family.slice().sort((a, b) => a - b).join();
// A merge far above the others is hidden, and its tool is there from then on.
change({ branch: null, level: null });
await settled();
told.squashed = [tree.all.hidden];
const { energy, parent } = tree.side.tree;
energy[parent.indexOf(NONE)] = 1000;
change({ branch: branch });
await settled();
change({ branch: null });
await settled();
told.squashed.push(tree.all.hidden, tree.hidden > 0);
tree.all.click();
told.squashed.push(tree.all.hidden, tree.hidden > 0);
finish(told);
"##;
    let told = act(&browser, &desk, "g.report.html", "", script);
    assert_says(
        told["tip"].as_str().unwrap(),
        &["merge at", "what hangs below"],
    );
    assert_eq!(told["branch"], json!([true, 0]));
    for what in [
        "heading", "seen", "wide", "hidden", "address", "again", "button", "family",
    ] {
        assert_eq!(told[what], true, "{what}: {told}");
    }
    assert_eq!(told["whole"], json!([null, "Disconnectivity graph"]));
    assert!(told["nonsense"].is_null(), "a leaf is no branch");
    assert_eq!(told["squashed"], json!([true, false, true, false, false]));
}

/// Each heading and head of a column says what it means, under the pointer and at the focus.
#[test]
fn words_explain_themselves() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let script = r##"
await settled();
const told = { silent: [], focus: [] };
const elements = [...document.querySelectorAll("#table .head button, .panel > h2")].filter(element => element.checkVisibility());
for (const element of elements) {
  await point(element, "pointerenter", [1, 1]);
  if (byId("tip").hidden || byId("tip").textContent.length < 30) told.silent.push(element.textContent);
  await point(element, "pointerleave", [1, 1]);
  if (!byId("tip").hidden) told.silent.push("stays: " + element.textContent);
  if (element.tabIndex !== 0 || !element.getAttribute("aria-description")) told.focus.push(element.textContent);
}
told.count = elements.length;
const epsilon = document.querySelector("#table [data-name=epsilon] button");
await press(document.body, "Tab");
epsilon.focus({ focusVisible: true });
await settled();
told.tip = byId("tip").textContent;
epsilon.blur();
told.evidence = [...document.querySelectorAll("#table .row [role=gridcell][title]")].some(cell => cell.title.includes("upper bound"));
finish(told);
"##;
    let told = act(&browser, &desk, "g.report.html", "", script);
    assert_eq!((&told["silent"], &told["focus"]), (&json!([]), &json!([])));
    assert!(told["count"].as_u64().unwrap() > 10, "{told}");
    assert_says(
        told["tip"].as_str().unwrap(),
        &["Ferrari and Canny", "friction 0.5"],
    );
    assert_eq!(told["evidence"], true);
}

/// The table fills its place beside the two other panels, and its columns fit at usual widths.
#[test]
fn the_table_fills_its_place() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    made::landscape(60, 6, &desk.path("g.landscape"));
    made::changed(&desk.path("g.landscape"), |files| {
        let curve = landscape::topography::Rarefaction::new(&[30, 20, 10], 20);
        let found = json!({ "groups": curve, "minima": curve });
        files
            .manifest
            .findings
            .insert("rarefaction".to_owned(), found);
    });
    succeed(&desk, "report g.landscape -q");
    let script = r##"
await settled();
const bottom = name => byId(name).getBoundingClientRect().bottom;
const scroll = document.querySelector("#table .scroll");
finish({ gap: bottom("rarefaction") - bottom("table"), wider: scroll.scrollWidth - scroll.clientWidth, first: [...document.querySelectorAll("#table .head span")].slice(0, 2).map(head => head.dataset.name) });
"##;
    let told = act(&browser, &desk, "g.report.html", "", script);
    assert!(told["gap"].as_f64().unwrap().abs() < 2.0, "{told}");
    assert!(told["wider"].as_f64().unwrap() < 2.0, "{told}");
    assert_eq!(told["first"], json!(["name", "label"]));
}

/// The page of grasps without a map: what they are, how far to trust them, and how they differ.
#[test]
fn a_population_tells_what_is_known_of_it() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    let mut file = made::committed();
    file.grasps.truncate(40);
    for (k, row) in file.grasps.iter_mut().enumerate() {
        row.stable = (k < 30).then_some(k < 28);
    }
    file.write(&desk.path("g.parquet")).unwrap();
    succeed(&desk, "report g.parquet -q");
    let script = r##"
await settled();
const row = document.querySelector("#table .rows .row");
const { likeness, rarefaction } = model.sides[0];
const told = {
  title: byId("title").textContent,
  subtitle: byId("subtitle").textContent,
  trust: [...document.querySelectorAll("#trust summary")].map(line => line.textContent).join("; "),
  long: byId("trust").textContent,
  first: [row.classList.contains("hover"), document.querySelector("#scene .caption").textContent.split(" ")[0] === model.name(Number(row.dataset.item))],
  least: model.energy(Number(row.dataset.item)) === Math.min(...model.sides[0].energy),
  curves: Object.fromEntries(Object.entries(rarefaction).map(([name, found]) => [name, [found.members, found.groups]])),
};
const map = panels.likeness;
told.places = likeness.x.length;
const canvas = map.drawing.canvas;
const apart = Array.from({ length: model.count }, (_, item) => item).filter(item => map.found(map.at(item))?.item === item);
told.dots = apart.length;
// The grasp that is farthest from all others: a click may be half a pixel off.
const room = item => Math.min(...apart.filter(other => other !== item).map(other => Math.hypot(map.at(item)[0] - map.at(other)[0], map.at(item)[1] - map.at(other)[1])));
const item = apart.reduce((best, other) => (room(other) > room(best) ? other : best));
await point(canvas, "pointermove", map.at(item));
told.hover = state.hover === item && document.querySelector("#scene .caption").textContent.startsWith(model.name(item) + " ");
await point(canvas, "click", map.at(item));
told.selected = state.selected[0] === item;
told.svg = map.drawing.svg().includes(" mm</text>");
finish(told);
"##;
    let told = act(&browser, &desk, "g.grasps.html", "", script);
    assert_eq!(told["title"], "40 grasps, human hand on bottle_round");
    assert_says(told["subtitle"].as_str().unwrap(), &["g.parquet"]);
    assert_says(
        told["trust"].as_str().unwrap(),
        &[
            "of 40 pass the strict filter",
            "28 of 30 held in simulation",
            "sets of contact regions",
            "no map yet",
        ],
    );
    assert_says(
        told["long"].as_str().unwrap(),
        &["10 were not simulated", "landscape build"],
    );
    assert_eq!(
        (&told["first"], &told["least"]),
        (&json!([true, true]), &json!(true))
    );
    assert_eq!(told["places"], 40);
    assert!(told["dots"].as_u64().unwrap() > 10, "{told}");
    for what in ["hover", "selected", "svg"] {
        assert_eq!(told[what], true, "{what}");
    }
    let [members, kinds] = [0, 1].map(|k| {
        told["curves"]["sets of contact regions"][k]
            .as_u64()
            .unwrap()
    });
    assert_eq!(members, 40);
    assert!((2..40).contains(&kinds), "{kinds}");
}

/// Two landscapes of different objects are told apart in the terminal and on the page, and their leaves have names.
#[test]
fn two_landscapes_say_what_they_are() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    made::landscape(12, 3, &desk.path("one.landscape"));
    made::landscape(14, 3, &desk.path("two.landscape"));
    let ball = landscape::study::Origin::named("human", "ball")
        .unwrap()
        .object;
    made::changed(&desk.path("two.landscape"), |files| {
        files.manifest.object = Some(ball);
    });
    let output = desk.run("report one.landscape two.landscape --within 0.005");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    assert_says(&said, &["note: the objects differ (bottle_round, ball)"]);
    let script = r#"
await settled();
const told = { title: byId("title").textContent, subtitle: byId("subtitle").textContent, moved: byId("moved").textContent, svg: panels.tangle.drawing.svg() };
// Two minima that may be the same, a little farther apart than the threshold.
model.header.difference.possible = [{ before: 0, after: 1, energies: [1, 1.25], distance: 0.005012 }];
const list = make("section");
showMoved(list);
told.possible = [...list.querySelectorAll("h3")].find(head => head.textContent.startsWith("May be")).nextSibling.textContent;
finish(told);
"#;
    let told = act(&browser, &desk, "one.report.html", "", script);
    assert_eq!(
        told["title"],
        "human on bottle_round (one.landscape) and human on ball (two.landscape)"
    );
    assert_says(
        told["subtitle"].as_str().unwrap(),
        &["the objects differ (bottle_round, ball)"],
    );
    assert_says(
        told["moved"].as_str().unwrap(),
        &[
            "The objects differ",
            "the same in both (of 12 and of 14; at most 5 mm apart)",
        ],
    );
    assert_says(
        told["svg"].as_str().unwrap(),
        &[">m0</text>", ">m0′</text>", ">m5</text>"],
    );
    assert_says(
        told["possible"].as_str().unwrap(),
        &["difference", "+0.25", "5.01 mm"],
    );
    // Of one object, the title says so once.
    made::landscape(14, 3, &desk.path("three.landscape"));
    let output = desk.run("report one.landscape three.landscape");
    assert!(!String::from_utf8(output.stderr).unwrap().contains("differ"));
    let told = act(
        &browser,
        &desk,
        "one.report.html",
        "",
        "finish({ title: byId('title').textContent });",
    );
    assert_eq!(
        told["title"],
        "human on bottle_round: one.landscape and three.landscape"
    );
    // Folders of one name are told apart by their paths.
    fs::create_dir(desk.path("again")).unwrap();
    made::landscape(14, 3, &desk.path("again/one.landscape"));
    succeed(&desk, "report one.landscape again/one.landscape -q");
    let told = act(
        &browser,
        &desk,
        "one.report.html",
        "",
        "finish({ title: byId('title').textContent });",
    );
    assert_eq!(
        told["title"],
        "human on bottle_round: one.landscape and again/one.landscape"
    );
}
