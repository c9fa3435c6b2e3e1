"""A person explores, and what is seen is compared with the files."""

import json
import xml.etree.ElementTree

import pyarrow.parquet as pq
import pytest

import landscape as ls
import made
from browsing import says

#: Hover, selection, way, level, filter, search and pins, by mouse and keyboard.
EXPLORE = r"""
const told = {};
const tree = panels.tree.drawing.canvas;
const leaf = item => { const [, k] = model.at(item); return [panels.tree.x(k), panels.tree.y(model.energy(item))]; };
const rows = () => [...document.querySelectorAll("#table .rows .row")];

await point(tree, "pointermove", leaf(5));
told.hover = [state.hover, document.querySelector("#table .row.hover")?.dataset.item, byId("tip").textContent.slice(0, 2)];
await wait(500);
told.glided = Math.max(...Array.from(model.coordinates(5), (value, k) => Math.abs(value - panels.scene.views[0].x[k])));
told.caption = document.querySelector("#scene .caption").textContent;
await point(tree, "pointerleave", [0, 0]);

await point(tree, "click", leaf(3));
await point(tree, "click", leaf(17));
told.selected = state.selected;
const route = routeOf(state.selected);
told.minima = route.minima;
told.way = document.querySelector("#way .words").textContent;
const { starts, along } = route.side.ways;
told.length = route.length - route.ways.reduce((sum, way) => sum + along[starts[way + 1] - 1] - along[starts[way]], 0);
told.onward = route.points.every((point, k) => k === 0 || point.along >= route.points[k - 1].along);
const sums = route.points.map(point => { const n = route.side.term_names.length; return Array.from({ length: n }, (_, k) => route.side.ways.terms[point.row * n + k]).reduce((a, b) => a + b, 0); });
told.sums = Math.max(...route.points.map((point, k) => Math.abs(point.energy - sums[k]) / Math.max(1, Math.abs(point.energy))));
await type(document.querySelector("#way input"), "0.5");
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

const query = byId("query");
told.queries = [];
for (const text of ["energy < 0.11 and members > 0", "m17", "power or not tripod", "energy <", '"quoted', "(g0 or g1) evidence = saddle"]) {
  await type(query, text);
  told.queries.push([derived.passing, derived.problem, rows().length]);
}
await type(query, "");
[...document.querySelectorAll("#matrix .chip")].find(chip => !chip.classList.contains("none")).click();
await settled();
told.chip = [state.query, derived.passing, query.value];
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
return told;
"""


def test_a_landscape_is_explored(explored, opened):
    told = opened(explored / "g.report.html").act(EXPLORE)
    landscape = ls.load(explored / "g.landscape")
    assert told["hover"] == [5, "5", "m5"]
    assert told["glided"] < 1e-6 and told["caption"].startswith("m5 ")
    assert told["selected"] == [3, 17]
    assert told["minima"] == list(landscape.path(3, 17, terms=False).minima)
    says(told["way"], "From m3 to m17", "pass")
    # A way over several passes is as long as its parts.
    assert len(told["minima"]) > 2 and told["onward"] and abs(told["length"]) < 1e-6
    # The terms add up to the energies, up to the steps in which they are stored.
    assert told["sums"] < 1e-3
    assert told["step"] == 0.5 and told["played"] < 1e-9
    # The ends of the way are the minima, up to the steps in which paths are stored.
    assert max(told["ends"]) < 2e-3
    levels(told, landscape)
    filters(told, explored / "g.landscape")
    assert told["pins"] == [2, 3, 4, 5, 6, 7] and told["pictures"] == [True] * 6
    assert told["unpinned"] == [3, 4, 5, 6, 7]
    assert len(told["sorted"]) == 5 and told["sorted"] == sorted(told["sorted"])
    assert told["byKeyboard"][0] == told["byKeyboard"][1] and told["graphByKeyboard"]
    says(told["fragment"], "sel=m", "pin=m3%2Cm4", "sort=epsilon")


def levels(told, landscape):
    """The superbasins of the page are those of the tree."""
    level, wanted = told["level"]
    lower = told["lower"]
    assert abs(level - wanted) < 0.01 * abs(wanted) + 0.02 and lower < level
    energy, basin = list(landscape.minima["energy"]), told["basin"]
    for a, own in enumerate(basin):
        assert (own < 0) == (energy[a] > lower)
        for b in range(a):
            joined = landscape.tree.merge_height(a, b) <= lower
            assert (own >= 0 and own == basin[b]) == joined, (a, b)
    says(told["valuetext"], "families")
    assert told["ghosts"] == min(told["basins"][0], 12)
    assert told["painted"] > 10, "the touched places are painted"
    assert told["off"] is None


def filters(told, folder):
    energy = pq.read_table(folder / "minima.parquet")["energy"].to_pylist()
    low, queries = sum(value < 0.11 for value in energy), told["queries"]
    assert queries[0][0] == low and queries[0][2] == min(low, 25), "the rows that pass are listed"
    assert queries[1][0] == queries[1][2] == 1
    assert 1 <= queries[2][0] <= len(energy)
    assert queries[3][0] == len(energy), "what cannot be read hides nothing"
    says(queries[3][1], "compares with nothing")
    assert queries[4][:2] == [0, ""]
    assert queries[5][0] < len(energy) and queries[5][1] == ""
    text, passing, field = told["chip"]
    assert text.startswith(("type = ", "cell = ")) and field == text and 1 <= passing < len(energy)


def test_the_state_stands_in_the_address(explored, opened):
    """A link shows what was chosen, and what makes no sense in it is left out."""
    chosen = "sel=m3,m17&level=0.2&q=energy+%3C+1&pin=m1,m4&colour=energy&cam=10,20,2&step=0.25&sort=-energy&cones=1"
    told = opened(explored / "g.report.html", chosen).act("""
await settled();
const text = () => JSON.stringify({ ...state, hover: null, look: 0, labels: 0 });
const first = text();
change({ step: state.step });
await wait(400);
const address = location.hash;
change({ selected: [], level: null, query: "", pins: [], camera: null, step: 0, sort: "energy", cones: false, colour: "family" });
await wait(300);
location.hash = address;
await wait(300);
return { first, again: text(), address, state, cones: panels.scene.views[0].marks.children.length };
""")
    assert told["first"] == told["again"]
    state = told["state"]
    assert (state["selected"], state["pins"], state["camera"]) == ([3, 17], [1, 4], [10, 20, 2])
    assert (state["level"], state["query"], state["step"]) == (0.2, "energy < 1", 0.25)
    nonsense = "sel=m999,xx&level=abc&pin=m2,m2,m2&colour=nothing&cam=1,2&step=7&sort=%3Cscript%3E"
    state = opened(explored / "g.report.html", nonsense).act("await settled(); return state;")
    assert (state["selected"], state["pins"], state["level"], state["camera"], state["step"]) == ([], [2], None, None, 1)


def test_what_is_seen_is_saved(explored, opened, tmp_path):
    tab = opened(explored / "g.report.html", "sel=m3,m17")
    tab.act("byId('export-open').click(); await settled();")
    for name in ("tree", "graph", "way"):
        svg, file = tab.saved(f"save-{name}-svg")
        assert file == f"{name}.svg" and b"m17" in svg
        assert xml.etree.ElementTree.fromstring(svg).tag.endswith("svg")
        assert tab.saved(f"save-{name}-png")[0].startswith(b"\x89PNG")
    assert tab.saved("save-scene-png")[0].startswith(b"\x89PNG")
    lines = tab.saved("save-csv")[0].decode().splitlines()
    assert [line.split(",")[0] for line in lines[:3]] == ["name", "m3", "m17"] and lines[0].startswith("name,energy,")
    says(tab.value("byId('commands').textContent"), "landscape report g.landscape", "landscape inspect g.landscape --path m3 m17", "--pick m3,m17")
    says(tab.value("byId('link').value"), "#sel=m3%2Cm17")
    scene, file = tab.saved("save-scene-glb")
    assert file == "grasp-m3.glb"
    trimesh = pytest.importorskip("trimesh")
    (tmp_path / file).write_bytes(scene)
    assert sum(len(part.faces) for part in trimesh.load(tmp_path / file).geometry.values()) > 10_000


def test_other_landscapes_have_their_own_panels(desk, opened):
    """Surfaces have maps, atoms and coordinates in place of hands, and two landscapes stand face to face."""
    desk.succeed("surface", "muller-brown", "-q")
    for atoms in (5, 7):
        desk.succeed("surface", "lj", atoms, "-q")
    told = opened(desk.folder / "muller-brown.landscape/report.html", "sel=m0,m1").act("""
await settled();
const { energy, columns } = panels.flat.map;
return { map: columns * columns === energy.length, at: panels.flat.found(panels.flat.at(model.coordinates(1))),
         passes: document.querySelector("#way .words").textContent };
""")
    assert told["map"] and told["at"]["item"] == 1
    says(told["passes"], "over 2 passes", "−40.66", "The lowest pass found; its slope is zero (verified).")
    told = opened(desk.folder / "lj-5.landscape/report.html").act(
        "await settled(); const { children } = panels.scene.views[0].marks; return [children[0].count, children.length - 1];"
    )
    assert told == [5, 9], "a triangular bipyramid: nine of the ten pairs touch"
    # Atoms never jump along a way, though the files number them in any order: no step is nearly as long as the way.
    longest = opened(desk.folder / "lj-7.landscape/report.html").act("""
const { starts, along, a } = model.sides[0].ways;
return Math.max(...Array.from(a, (_, way) => {
  const all = Array.from(along.subarray(starts[way], starts[way + 1]));
  return Math.max(...all.slice(1).map((value, k) => value - all[k])) / all.at(-1);
}));
""")
    assert longest < 0.5
    made.landscape(desk.folder / "one.landscape", 20, 4)
    made.landscape(desk.folder / "two.landscape", 30, 4)
    desk.succeed("report", "one.landscape", "two.landscape", "-q")
    told = opened(desk.folder / "one.report.html", "sel=m3").act("""
await settled();
await point(panels.tangle.drawing.canvas, "pointermove", panels.tangle.at(model.offsets[1] + 4));
document.querySelector("#tangle .panel-tools button").click();
await settled();
return { families: derived.basins.list.length, off: document.querySelector("#tangle input").hidden, hover: model.name(state.hover),
         partners: model.partner.filter(partner => partner !== NONE).length / 2, views: panels.scene.views.length,
         moved: byId("moved").textContent };
""")
    assert (told["hover"], told["views"], told["off"]) == ("m4′", 2, False)
    assert told["families"] > 1
    apart = [landscape - told["partners"] for landscape in (20, 30)]
    says(
        told["moved"],
        f"{told['partners']:g} minima are the same in both (of 20 and of 30; at most 1 mm apart)",
        f"{apart[0]:g} only in the first",
    )


def test_a_population_says_what_is_known_of_it(desk, opened):
    """The page of grasps without a map: what they are, how far to trust them, and how they differ."""
    table = made.with_column(made.grasps(40), "stable", [k < 28 if k < 30 else None for k in range(40)])
    pq.write_table(table, desk.folder / "g.parquet")
    desk.succeed("report", "g.parquet", "-q")
    told = opened(desk.folder / "g.grasps.html").act("""
await settled();
const row = document.querySelector("#table .rows .row");
const told = {
  title: byId("title").textContent,
  subtitle: byId("subtitle").textContent,
  trust: [...document.querySelectorAll("#trust summary")].map(line => line.textContent).join("; "),
  long: byId("trust").textContent,
  first: [row.classList.contains("hover"), document.querySelector("#scene .caption").textContent.split(" ")[0] === model.name(Number(row.dataset.item))],
  least: model.energy(Number(row.dataset.item)) === Math.min(...model.sides[0].energy),
  curve: model.sides[0].rarefaction["sets of contact regions"],
};
const map = panels.likeness;
told.places = model.sides[0].likeness.x.length;
const apart = Array.from({ length: model.count }, (_, item) => item).filter(item => map.found(map.at(item))?.item === item);
told.dots = apart.length;
// The grasp that is farthest from all others: a click may be half a pixel off.
const room = item => Math.min(...apart.filter(other => other !== item).map(other => Math.hypot(map.at(item)[0] - map.at(other)[0], map.at(item)[1] - map.at(other)[1])));
const item = apart.reduce((best, other) => (room(other) > room(best) ? other : best));
await point(map.drawing.canvas, "pointermove", map.at(item));
told.hover = state.hover === item && document.querySelector("#scene .caption").textContent.startsWith(model.name(item) + " ");
await point(map.drawing.canvas, "click", map.at(item));
told.selected = state.selected[0] === item;
told.svg = map.drawing.svg().includes(" mm</text>");
return told;
""")
    assert told["title"] == "40 grasps, human hand on bottle_round"
    says(told["subtitle"], "g.parquet")
    says(told["trust"], "of 40 pass the strict filter", "28 of 30 held in simulation", "sets of contact regions", "no map yet")
    says(told["long"], "10 were not simulated", "landscape build")
    assert told["first"] == [True, True] and told["least"]
    assert told["places"] == 40 and told["dots"] > 10
    assert told["hover"] and told["selected"] and told["svg"]
    assert told["curve"]["members"] == 40 and 2 <= told["curve"]["kinds"] < 40


def test_two_landscapes_say_what_they_are(desk, opened):
    """Two landscapes of different objects are told apart in the terminal and on the page, and their leaves have names."""
    desk.succeed("synth", "--hand", "human", "--object", "ball", "-n", "1", "--keep", "all", "-o", "ball.parquet", "-q")
    ball = json.loads(pq.read_metadata(desk.folder / "ball.parquet").metadata[b"landscape"], parse_float=made.marked)
    made.landscape(desk.folder / "one.landscape", 12, 3)
    made.landscape(desk.folder / "two.landscape", 14, 3, object=ball["objects"][0])
    said = desk.succeed("report", "one.landscape", "two.landscape", "--within", "0.005")
    says(said, "note: the objects differ (bottle_round, ball)")
    told = opened(desk.folder / "one.report.html").act("""
await settled();
return { title: byId("title").textContent, subtitle: byId("subtitle").textContent, moved: byId("moved").textContent, svg: panels.tangle.drawing.svg() };
""")
    assert told["title"] == "human on bottle_round (one.landscape) and human on ball (two.landscape)"
    says(told["subtitle"], "the objects differ (bottle_round, ball)")
    says(told["moved"], "The objects differ", "the same in both (of 12 and of 14; at most 5 mm apart)")
    says(told["svg"], ">m0</text>", ">m0′</text>", ">m5</text>")
    # Of one object, the title says so once.
    made.landscape(desk.folder / "three.landscape", 14, 3)
    assert "differ" not in desk.succeed("report", "one.landscape", "three.landscape")
    title = "byId('title').textContent"
    assert opened(desk.folder / "one.report.html").value(title) == "human on bottle_round: one.landscape and three.landscape"
    # Folders of one name are told apart by their paths.
    made.landscape(desk.folder / "again/one.landscape", 14, 3)
    desk.succeed("report", "one.landscape", "again/one.landscape", "-q")
    assert opened(desk.folder / "one.report.html").value(title) == "human on bottle_round: one.landscape and again/one.landscape"
