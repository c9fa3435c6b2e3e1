//! The pages of `landscape report` in a real browser: a person acts on them, and the results are compared with Rust's.

mod finding;
mod hostile;
mod labelling;
mod looks;
mod made;
#[expect(
    dead_code,
    reason = "of the synthetic file of MANO only its bytes are needed here"
)]
#[path = "../mano/model.rs"]
mod mano;
mod person;
mod posing;
mod sizes;

use std::fs;

use landscape::store::{GraspFile, LandscapeFiles, Overrides};
use serde_json::{Value, json};

use crate::browser::{act, browse, browser};
use crate::desk::{Desk, assert_says};

fn succeed(desk: &Desk, line: &str) {
    let output = desk.run(line);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "landscape {line}: {said}");
}

/// A desk with the page of a landscape of 60 minima in 6 groups.
fn desk_with_page() -> Desk {
    let desk = Desk::empty();
    made::landscape(60, 6, &desk.path("g.landscape"));
    succeed(&desk, "report g.landscape -q");
    desk
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|number| number.as_f64().unwrap())
        .collect()
}

/// Hover, selection, way, level, filter, search and pins, by mouse and keyboard.
const EXPLORE: &str = r##"
const told = {};
const tree = panels.tree.drawing.canvas;
const leaf = item => { const [, k] = model.at(item); return [panels.tree.x(k), panels.tree.y(model.energy(item))]; };
const rows = () => [...document.querySelectorAll("#table .rows .row")];

await point(tree, "pointermove", leaf(5));
told.hover = [state.hover, document.querySelector("#table .row.hover")?.dataset.item, document.getElementById("tip").textContent.slice(0, 2)];
await wait(500);
told.glided = Math.max(...Array.from(model.coordinates(5), (value, k) => Math.abs(value - panels.scene.views[0].x[k])));
told.caption = document.querySelector("#scene .caption").textContent;
await point(tree, "pointerleave", [0, 0]);

await point(tree, "click", leaf(3));
await point(tree, "click", leaf(17));
told.selected = state.selected;
const route = routeOf(state.selected);
told.minima = route.minima.map(item => model.name(item));
told.way = document.querySelector("#way .words").textContent;
const { starts, along } = route.side.ways;
told.length = route.length - route.ways.reduce((sum, way) => sum + along[starts[way + 1] - 1] - along[starts[way]], 0);
told.onward = route.points.every((point, k) => k === 0 || point.along >= route.points[k - 1].along);
told.pass = route.points[route.pass].energy;
const sums = route.points.map(point => { const n = route.side.term_names.length; return Array.from({ length: n }, (_, k) => route.side.ways.terms[point.row * n + k]).reduce((a, b) => a + b, 0); });
told.sums = Math.max(...route.points.map((point, k) => Math.abs(point.energy - sums[k]) / Math.max(1, Math.abs(point.energy))));
const slider = document.querySelector("#way input");
await type(slider, "0.5");
told.step = state.step;
told.played = Math.max(...Array.from(onRoute(route, 0.5), (value, k) => Math.abs(value - panels.scene.views[0].x[k])));
told.ends = [0, 1].map(t => { const item = route.minima.at(t ? -1 : 0); return Math.max(...Array.from(onRoute(route, t), (value, k) => Math.abs(value - model.coordinates(item)[k]))); });

const handle = document.querySelector(".level");
const level = (panels.tree.low + panels.tree.high) / 2;
const box = tree.getBoundingClientRect();
const handleBox = handle.getBoundingClientRect();
handle.setPointerCapture = () => {};
await point(handle, "pointerdown", [5, 5]);
await point(handle, "pointermove", [5, box.top + panels.tree.y(level) - handleBox.top]);
await point(handle, "pointerup", [5, 5]);
told.level = [state.level, level];
await press(handle, "ArrowDown");
told.lower = state.level;
told.basins = derived.basins.list.map(basin => basin.length);
told.basin = Array.from({ length: model.count }, (_, item) => (derived.basins.top[item] === NONE ? -1 : derived.basins.top[item]));
told.valuetext = handle.getAttribute("aria-valuetext");
await press(document.body, "Escape");
await point(tree, "pointermove", leaf(derived.basins.list[0][0]));
await wait(400);
told.ghosts = panels.scene.views[0].ghosts.children.length;
const colours = panels.scene.views[0].painted.geometry.attributes.color.array;
told.painted = new Set(Array.from(colours, value => value.toFixed(2))).size;
await point(tree, "pointerleave", [0, 0]);
await press(handle, "Escape");
told.off = state.level;

const query = document.getElementById("query");
for (const text of ["energy < 0.11 and members > 0", "m17", "power or not tripod", "energy <", "\"quoted", "(g0 or g1) evidence = saddle"]) {
  await type(query, text);
  (told.queries ??= []).push([derived.passing, derived.problem, rows().length]);
}
await type(query, "");
const chip = [...document.querySelectorAll("#matrix .chip")].find(chip => !chip.classList.contains("none"));
const query_of_chip = chip.title;
chip.click();
await settled();
told.chip = [state.query, derived.passing, query_of_chip];
await type(query, "");
for (const item of [1, 2, 3, 4, 5, 6, 7]) {
  await point(tree, "pointermove", leaf(item));
  await press(document.body, "p");
}
await point(tree, "pointerleave", [0, 0]);
told.pins = state.pins;
told.pictures = [...document.querySelectorAll("#pins canvas")].map(canvas => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some(value => value > 0));
document.querySelector("#pins figcaption button:last-child").click();
await settled();
told.unpinned = state.pins;
document.querySelector("#table .head [data-name=epsilon] button").click();
await settled();
told.sorted = rows().slice(0, 5).map(row => model.number("epsilon", Number(row.dataset.item)));
await press(document.querySelector("#table .scroll"), "Home");
await press(document.querySelector("#table .scroll"), "ArrowDown");
await press(document.querySelector("#table .scroll"), "Enter");
await press(panels.graph.drawing.canvas, "End");
told.graphByKeyboard = state.hover === panels.graph.drawing.order.at(-1);
told.byKeyboard = [state.selected.at(-1), Number(rows()[1].dataset.item)];
await wait(400);
told.fragment = location.hash;
finish(told);
"##;

#[test]
fn a_landscape_is_explored() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let files = LandscapeFiles::read(&desk.path("g.landscape")).unwrap();
    let network = files.network("g".as_ref()).unwrap();
    let told = act(&browser, &desk, "g.report.html", "", EXPLORE);
    assert_eq!(told["hover"], json!([5, "5", "m5"]));
    assert!(told["glided"].as_f64().unwrap() < 1e-6);
    assert!(told["caption"].as_str().unwrap().starts_with("m5 "));
    assert_eq!(told["selected"], json!([3, 17]));
    let ends = [3, 17].map(landscape::topography::MinimumId);
    let minima = landscape::topography::minimax_path(&network, ends[0], ends[1]).unwrap();
    let names: Vec<String> = minima
        .iter()
        .map(|minimum| format!("m{}", minimum.0))
        .collect();
    assert_eq!(told["minima"], json!(names));
    assert_says(told["way"].as_str().unwrap(), &["From m3 to m17", "pass"]);
    // A way over several passes is as long as its parts.
    assert!(names.len() > 2 && told["onward"] == true);
    assert!(told["length"].as_f64().unwrap().abs() < 1e-6);
    // The energies and terms are those of Rust's explained path, up to the steps in which terms are stored.
    assert!(told["sums"].as_f64().unwrap() < 1e-3, "{}", told["sums"]);
    assert_eq!(told["step"], 0.5);
    assert!(told["played"].as_f64().unwrap() < 1e-9);
    // The ends of the way are the minima, up to the steps in which paths are stored.
    assert!(
        numbers(&told["ends"]).iter().all(|gap| *gap < 2e-3),
        "{}",
        told["ends"]
    );
    levels(&told, &network);
    filters(&told, &files);
    assert_eq!(told["pins"], json!([2, 3, 4, 5, 6, 7]));
    assert_eq!(told["pictures"], json!(vec![true; 6]));
    assert_eq!(told["unpinned"], json!([3, 4, 5, 6, 7]));
    let sorted = numbers(&told["sorted"]);
    assert!(sorted.len() == 5 && sorted.is_sorted(), "{sorted:?}");
    assert_eq!(told["byKeyboard"][0], told["byKeyboard"][1]);
    assert_eq!(told["graphByKeyboard"], true);
    let fragment = told["fragment"].as_str().unwrap();
    assert_says(fragment, &["sel=m", "pin=m3%2Cm4", "sort=epsilon"]);
}

/// The superbasins of the page are those of the tree.
fn levels(told: &Value, network: &landscape::topography::Network) {
    let [level, wanted] = [0, 1].map(|k| told["level"][k].as_f64().unwrap());
    let lower = told["lower"].as_f64().unwrap();
    assert!(
        (level - wanted).abs() < 0.01 * wanted.abs() + 0.02 && lower < level,
        "{level} {wanted} {lower}"
    );
    let tree =
        landscape::topography::Tree::from_network(network, landscape::topography::Evidence::Chain);
    let basin = numbers(&told["basin"]);
    for a in 0..basin.len() {
        assert_eq!(basin[a] < 0.0, tree.nodes[a].energy > lower);
        for b in 0..a {
            let joined = tree
                .minimax(
                    landscape::topography::MinimumId(a),
                    landscape::topography::MinimumId(b),
                )
                .is_some_and(|height| height <= lower);
            let below = basin[a] >= 0.0 && basin[b] >= 0.0;
            assert_eq!(
                below && basin[a].to_bits() == basin[b].to_bits(),
                joined,
                "m{a}, m{b}"
            );
        }
    }
    assert_says(told["valuetext"].as_str().unwrap(), &["families"]);
    let first = told["basins"][0].as_u64().unwrap();
    assert_eq!(told["ghosts"].as_u64().unwrap(), first.min(12));
    assert!(
        told["painted"].as_u64().unwrap() > 10,
        "the touched places are painted"
    );
    assert!(told["off"].is_null());
}

fn filters(told: &Value, files: &LandscapeFiles) {
    let count = files.minima.len();
    let low = files.minima.iter().filter(|row| row.energy < 0.11).count();
    let queries = &told["queries"];
    assert_eq!(queries[0][0], low);
    assert_eq!(
        queries[0][2],
        low.min(25),
        "the rows that pass are listed: {}",
        queries[0]
    );
    assert_eq!((&queries[1][0], &queries[1][2]), (&json!(1), &json!(1)));
    assert!((1..=count as u64).contains(&queries[2][0].as_u64().unwrap()));
    assert_eq!(queries[3][0], count, "what cannot be read hides nothing");
    assert_says(queries[3][1].as_str().unwrap(), &["compares with nothing"]);
    assert_eq!(
        (queries[4][0].as_u64(), queries[4][1].as_str()),
        (Some(0), Some(""))
    );
    assert!(queries[5][0].as_u64().unwrap() < count as u64 && queries[5][1] == "");
    let chip = told["chip"][0].as_str().unwrap();
    assert!(
        chip.starts_with("type = ") || chip.starts_with("cell = "),
        "{chip}"
    );
    assert!((1..count as u64).contains(&told["chip"][1].as_u64().unwrap()));
}

/// A link shows what was chosen, and what makes no sense in it is left out.
#[test]
fn the_state_stands_in_the_address() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let chosen = "sel=m3,m17&level=0.2&q=energy+%3C+1&pin=m1,m4&colour=energy&cam=10,20,2&step=0.25&sort=-energy&cones=1";
    let script = r#"
await settled();
const text = () => JSON.stringify({ ...state, hover: null, look: 0, labels: 0 });
const first = text();
change({ step: state.step });
await wait(400);
const address = location.hash;
change({ selected: [], level: null, query: "", pins: [], camera: null, step: 0, sort: "energy", cones: false, colour: "group" });
await wait(300);
location.hash = address;
await wait(300);
finish({ first, again: text(), address, state, cones: panels.scene.views[0].marks.children.length });
"#;
    let told = act(&browser, &desk, "g.report.html", chosen, script);
    assert_eq!(told["first"], told["again"]);
    let state = &told["state"];
    assert_eq!(
        (&state["selected"], &state["pins"]),
        (&json!([3, 17]), &json!([1, 4]))
    );
    assert_eq!(
        (&state["camera"], &state["level"]),
        (&json!([10, 20, 2]), &json!(0.2))
    );
    assert_eq!(
        (&state["query"], &state["step"]),
        (&json!("energy < 1"), &json!(0.25))
    );
    let nonsense =
        "sel=m999,xx&level=abc&pin=m2,m2,m2&colour=nothing&cam=1,2&step=7&sort=%3Cscript%3E";
    let told = act(
        &browser,
        &desk,
        "g.report.html",
        nonsense,
        "await settled(); finish({ state });",
    );
    let state = &told["state"];
    assert_eq!(
        (&state["selected"], &state["pins"]),
        (&json!([]), &json!([2]))
    );
    assert!(state["level"].is_null() && state["camera"].is_null());
    assert_eq!(state["step"], 1);
}

/// The files that the page saves, and the page as it is, with its strict policy.
#[test]
fn what_is_seen_is_saved() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let script = r##"
const files = {};
const write = save;
save = (name, type, content) => {
  files[name] = byteText(typeof content === "string" ? new TextEncoder().encode(content) : content);
  write(name, type, content);
};
HTMLAnchorElement.prototype.click = () => {};
document.getElementById("export-open").click();
await settled();
for (const button of document.querySelectorAll("#export button[id]")) button.click();
finish({ files, commands: document.getElementById("commands").textContent, link: document.getElementById("link").value });
"##;
    let told = act(&browser, &desk, "g.report.html", "sel=m3,m17", script);
    let file = |name: &str| {
        use base64::Engine;
        let text = told["files"][name]
            .as_str()
            .unwrap_or_else(|| panic!("{name} was not saved"));
        base64::engine::general_purpose::STANDARD
            .decode(text)
            .unwrap()
    };
    for name in ["tree", "graph", "way"] {
        let svg = String::from_utf8(file(&format!("{name}.svg"))).unwrap();
        assert!(
            svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>") && svg.contains("m17")
        );
        roxmltree::Document::parse(&svg).unwrap();
        assert!(file(&format!("{name}.png")).starts_with(b"\x89PNG"));
    }
    assert!(file("grasp.png").starts_with(b"\x89PNG"));
    let csv = String::from_utf8(file("selection.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert!(
        lines[0].starts_with("name,energy,")
            && lines[1].starts_with("m3,")
            && lines[2].starts_with("m17,")
    );
    fs::write(desk.path("grasp.glb"), file("grasp-m3.glb")).unwrap();
    let scene = landscape::mesh::Mesh::read(&desk.path("grasp.glb"), 1.0).unwrap();
    assert!(scene.mesh.triangles().len() > 10_000);
    let commands = told["commands"].as_str().unwrap();
    assert_says(
        commands,
        &[
            "landscape report g.landscape",
            "landscape inspect g.landscape --path m3 m17",
            "--pick m3,m17",
        ],
    );
    assert_says(told["link"].as_str().unwrap(), &["#sel=m3%2Cm17"]);
    let whole = browse(&browser, &desk, "g.report.html", "", &["--dump-dom"]);
    assert!(
        whole.contains("data-ready=\"1\""),
        "it starts under its own policy"
    );
    let flat = ["--dump-dom", "--disable-3d-apis"];
    let flat = browse(&browser, &desk, "g.report.html", "", &flat);
    let sentence = "<p class=\"alone\">This browser cannot draw in three dimensions";
    assert!(flat.contains("data-ready=\"1\"") && flat.contains(sentence));
}

/// A person labels by mouse and keyboard, and the file that the page saves is read back. Texts and numbers of any kind stay
/// what they are.
#[test]
fn grasps_are_labelled_on_the_page() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    let mut file = made::committed();
    file.grasps.truncate(6);
    let hostile = [
        "</script><script>window.hurt = 1</script>",
        "<img src=x onerror=\"window.hurt = 1\">",
        "\u{202e}ekil\u{2066}",
        "--!>\u{2028}\u{0}",
    ];
    let ids = [(1 << 53) + 1, u64::MAX, (1 << 53) + 2, 7, 8, 9];
    for (grasp, id) in file.grasps.iter_mut().zip(ids) {
        grasp.id = id;
    }
    for (grasp, label) in file.grasps[2..].iter_mut().zip(hostile) {
        grasp.label = Some(label.to_owned());
    }
    file.write(&desk.path("g.parquet")).unwrap();
    succeed(&desk, "report g.parquet -q");
    let script = r##"
const shown = [...document.querySelectorAll("#table .row [role=gridcell]")].map(cell => cell.textContent);
document.getElementById("label-start").click();
await settled();
const cards = [...document.querySelectorAll(".card")];
const choice = document.getElementById("choice");
const progress = () => document.getElementById("label-progress").textContent;
const told = [progress()];
cards[1].click();                                          // the second card, by mouse
await type(choice, "medium");
document.querySelector("#choices li").click();
await settled();
cards[0].focus();
await press(document.activeElement, "Enter");              // the first by keyboard: number 14
await type(choice, "14");
await press(choice, "Enter");
cards[3].focus();
await press(document.activeElement, "0");                  // unlisted
cards[4].focus();
await press(document.activeElement, "Delete");             // no label
told.push(progress());
await wait(1500);
const pictures = [...document.querySelectorAll(".card canvas")].filter(canvas => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some(value => value > 0)).length;
let csv = null;
const write = save;
save = (name, type, content) => { csv = content; write(name, type, content); };
HTMLAnchorElement.prototype.click = () => {};
document.getElementById("label-save").click();
finish({ shown, told, pictures, csv, hurt: window.hurt ?? null, images: document.images.length });
"##;
    let told = act(&browser, &desk, "g.grasps.html", "", script);
    assert_eq!((&told["hurt"], &told["images"]), (&Value::Null, &json!(0)));
    let shown: Vec<&str> = told["shown"]
        .as_array()
        .unwrap()
        .iter()
        .map(|cell| cell.as_str().unwrap())
        .collect();
    for text in hostile {
        assert!(shown.contains(&text), "{text:?} in {shown:?}");
    }
    assert!(shown.contains(&format!("#{}", u64::MAX).as_str()));
    assert_eq!(told["told"], json!(["4 of 6 labelled", "5 of 6 labelled"]));
    assert_eq!(told["pictures"], 12);
    let csv = told["csv"].as_str().unwrap();
    let expected = format!("id,label\n{},Tripod\n{},Medium Wrap\n", ids[0], ids[1]);
    assert!(csv.starts_with(&expected), "{csv}");
    assert!(
        csv.contains(&format!("\n{},unlisted\n", ids[3]))
            && csv.contains(&format!("\n{},\n", ids[4]))
    );
    let ours = |line: &&str| !line.contains(['<', '\u{202e}', '!']);
    let ours: Vec<&str> = csv.lines().filter(ours).collect();
    fs::write(desk.path("labels.csv"), ours.join("\n") + "\n").unwrap();
    succeed(&desk, "label g.parquet --from labels.csv -q");
    let (labelled, _) =
        GraspFile::read(&desk.path("g.labelled.parquet"), Overrides::default()).unwrap();
    let labels: Vec<Option<&str>> = labelled.grasps[..2]
        .iter()
        .map(|grasp| grasp.label.as_deref())
        .collect();
    assert_eq!(labels, [Some("Tripod"), Some("Medium Wrap")]);
    assert!(file.grasps[4].label.is_some() && labelled.grasps[4].label.is_none());
}

/// Surfaces have maps, atoms and coordinates in place of hands, and two landscapes stand face to face.
#[test]
fn other_landscapes_have_their_own_panels() {
    let Some(browser) = browser() else { return };
    let desk = Desk::empty();
    succeed(&desk, "surface muller-brown -q");
    succeed(&desk, "surface lj 5 -q");
    made::landscape(20, 4, &desk.path("one.landscape"));
    made::landscape(30, 4, &desk.path("two.landscape"));
    succeed(&desk, "report one.landscape two.landscape -q");
    let told = act(
        &browser,
        &desk,
        "muller-brown.landscape/report.html",
        "sel=m0,m1",
        r##"await settled(); const { energy, columns } = panels.flat.map;
        const passes = document.querySelector("#way .words").textContent;
        const { tree } = model.sides[0];
        const joins_told = pair => panels.way.told(routeOf(pair));
        const unsearched = joins_told([1, 2]);
        Object.assign(tree, { tested: true, support: tree.support.map(() => 0.5), searches: tree.searches.map(() => 8), ended: tree.ended.map(() => 6) });
        const joins = [unsearched, joins_told([1, 2])];
        finish({ map: columns * columns === energy.length, at: panels.flat.found(panels.flat.at(model.coordinates(1))), passes, joins });"##,
    );
    assert_eq!(
        (&told["map"], &told["at"]["item"]),
        (&json!(true), &json!(1))
    );
    assert_says(
        told["passes"].as_str().unwrap(),
        &[
            "over 2 passes",
            "−40.66",
            "The lowest pass found; its slope is zero (verified).",
        ],
    );
    let of_join = "6 of 8 independent searches ended at this height; the chance that a lower way exists is 50 %";
    assert!(!told["joins"][0].as_str().unwrap().contains("search"));
    assert_says(told["joins"][1].as_str().unwrap(), &[of_join]);
    let told = act(
        &browser,
        &desk,
        "lj-5.landscape/report.html",
        "",
        "await settled(); finish({ atoms: panels.scene.views[0].marks.children[0].count, bonds: panels.scene.views[0].marks.children.length - 1 });",
    );
    // A triangular bipyramid: nine of the ten pairs touch.
    assert_eq!((&told["atoms"], &told["bonds"]), (&json!(5), &json!(9)));
    // Atoms never jump along a way, though the files number them in any order: no step is nearly as long as the way.
    succeed(&desk, "surface lj 7 -q");
    let told = act(
        &browser,
        &desk,
        "lj-7.landscape/report.html",
        "",
        "const { starts, along, a } = model.sides[0].ways;
        const shares = Array.from(a, (_, way) => { const all = Array.from(along.subarray(starts[way], starts[way + 1])); return Math.max(...all.slice(1).map((value, k) => value - all[k])) / all.at(-1); });
        finish({ longest: Math.max(...shares) });",
    );
    assert!(told["longest"].as_f64().unwrap() < 0.5, "{told}");
    let told = act(
        &browser,
        &desk,
        "one.report.html",
        "sel=m3",
        r##"await settled(); await point(panels.tangle.drawing.canvas, "pointermove", panels.tangle.at(model.offsets[1] + 4));
        document.querySelector("#tangle .panel-tools button").click(); await settled();
        const families = derived.basins.list.length; const off = document.querySelector("#tangle input").hidden;
        finish({ families, off, hover: model.name(state.hover), partner: model.partner[state.hover], views: panels.scene.views.length, moved: document.getElementById("moved").textContent });"##,
    );
    assert_eq!((&told["hover"], &told["views"]), (&json!("m4′"), &json!(2)));
    assert!(told["partner"].as_u64().is_some());
    assert!(told["families"].as_u64().unwrap() > 1 && told["off"] == false);
    assert_says(
        told["moved"].as_str().unwrap(),
        &[
            "20 minima are the same in both (of 20 and of 30; at most 1 mm apart)",
            "0 only in the first, 8 only in the second",
        ],
    );
}
