"""Searches of what is not known, filters by the legend, branches of the tree, and words that explain themselves."""

import json

import pyarrow.parquet as pq

import made
from browsing import says

QUERIES = ["stable", "not unstable", "epsilon > 0.05", "members > 3", "family = #1", "energy < 99", "g0"]
ASK = """
const told = { placeholder: byId("query").placeholder, answers: [] };
for (const text of given) {
  await type(byId("query"), text);
  told.answers.push([derived.passing, byId("answer").textContent]);
}
return told;
"""


def test_a_search_of_what_is_unknown_is_refused(desk, explored, opened):
    """A search of something that the file does not hold is refused with the reason; nothing is said to be so for no grasp."""

    def simulated_first(told, command):
        for place in (0, 1):
            says(told["answers"][place][1], "nothing was simulated", command)
        assert "stable" not in told["placeholder"]

    simulated_first(opened(explored / "g.report.html").act(ASK, QUERIES), "landscape report g.landscape --stability FILE")
    for name, stable in (("bare", [None] * 6), ("full", [k < 2 for k in range(6)])):
        table = made.with_column(made.grasps(6), "stable", stable)
        pq.write_table(table, desk.folder / f"{name}.parquet")
        desk.succeed("report", f"{name}.parquet", "-q")
    told = opened(desk.folder / "bare.grasps.html").act(ASK, QUERIES)
    simulated_first(told, "landscape stability bare.parquet")
    answers = [answer for _, answer in told["answers"]]
    says(answers[3], "nothing here has “members”", "known are energy, ")
    says(answers[4], "nothing here has “family”")
    assert answers[5] == "6 of 6"
    says(answers[6], "nothing here has “family”")
    told = opened(desk.folder / "full.grasps.html").act(ASK, QUERIES)
    firm = sum(epsilon > 0.05 for epsilon in table["epsilon"].to_pylist())
    assert told["answers"][0] == [2, "2 of 6"] and told["answers"][2] == [firm, f"{firm} of 6"]
    says(told["placeholder"], "stable", "epsilon")


LEGEND = r"""
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
change({ colour: "family" });
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
return told;
"""


def test_the_legend_filters_and_the_filter_stays_in_sight(explored, opened):
    told = opened(explored / "g.report.html").act(LEGEND)
    assert len(told["entries"]) > 1
    assert told["one"] == [True, 1, "true", True]
    assert (told["stays"], told["both"], told["other"], told["narrower"]) == (1, True, 2, True)
    says(told["address"], "chip=category")
    assert (told["again"], told["gone"]) == (3, [0, True])
    assert told["colour"] == [False, "level"], "the reason of the colours is shown"
    assert told["family"] and told["back"] == [None, "energy", 0, True]
    assert told["ranges"] and told["range"]


TYPES = r"""
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
  colours: ['Tripod', 'mine "1"'].map(label => lookOfLabel(label).colour),
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
return told;
"""


def test_types_look_different(explored, opened):
    """With a look for each grasp type, the legend names the labels that occur and no others, each in its own look."""
    told = opened(explored / "g.report.html").act(TYPES)
    assert sorted(told["words"]) == sorted(told["labels"])
    assert told["apart"] and len(set(told["dots"])) == len(told["words"])
    assert told["exact"] == [True, True, True]
    assert told["chip"] == "power/palm/2-5/abducted×"
    # A label that the taxonomy knows, and the first that it does not know.
    says(told["tree"], *(f'fill="{colour}"' for colour in told["colours"]))


BRANCH = r"""
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
return told;
"""


def test_a_branch_is_zoomed_into(explored, opened):
    told = opened(explored / "g.report.html").act(BRANCH)
    says(told["tip"], "merge at", "what hangs below")
    assert told["branch"] == [True, 0]
    for what in ("heading", "seen", "wide", "hidden", "address", "again", "button", "family"):
        assert told[what], what
    assert told["whole"] == [None, "Disconnectivity graph"]
    assert told["nonsense"] is None, "a leaf is not a branch"
    assert told["squashed"] == [True, False, True, False, False]


WORDS = r"""
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
return told;
"""


def test_words_explain_themselves(explored, opened):
    """Each heading and head of a column says what it means, under the pointer and at the focus."""
    told = opened(explored / "g.report.html").act(WORDS)
    assert told["silent"] == [] and told["focus"] == []
    assert told["count"] > 10
    says(told["tip"], "Ferrari and Canny", "friction 0.5")
    assert told["evidence"]


def test_the_table_fills_its_place(desk, opened):
    """The table fills its place beside the two other panels, and its columns fit at usual widths."""
    points = [{"members": k, "kinds": value, "deviation": "\x010.5"} for k, value in ((1, "\x011.0"), (20, "\x014.0"), (60, "\x015.5"))]
    curve = {"members": 60, "kinds": 3, "once": 0, "twice": 0, "curve": points}
    made.landscape(desk.folder / "g.landscape", 60, 6, findings={"rarefaction": {"families": curve, "minima": curve}})
    desk.succeed("report", "g.landscape", "-q")
    told = opened(desk.folder / "g.report.html").act("""
await settled();
const bottom = name => byId(name).getBoundingClientRect().bottom;
const scroll = document.querySelector("#table .scroll");
return { gap: bottom("rarefaction") - bottom("table"), wider: scroll.scrollWidth - scroll.clientWidth,
         first: [...document.querySelectorAll("#table .head span")].slice(0, 2).map(head => head.dataset.name) };
""")
    assert abs(told["gap"]) < 2 and told["wider"] < 2
    assert told["first"] == ["name", "label"]
