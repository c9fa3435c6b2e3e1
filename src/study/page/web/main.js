// The start: unpacks the data, makes the panels that the data need, and handles the search field and keys.

import { FAMILY } from "./basins.js";
import { Model, unpack } from "./data.js";
import { button, byId, make, memory, showDialog, the, tip } from "./dom.js";
import { openExport } from "./export.js";
import { examples } from "./filter.js";
import { FlatPanel } from "./flat.js";
import { GraphPanel } from "./graph.js";
import { poseLinks } from "./kinematics.js";
import { LabelSheet } from "./label.js";
import { Legend } from "./legend.js";
import { LikenessPanel } from "./likeness.js";
import { look, lookOf, lookOfLabel, readLook } from "./looks.js";
import { MatrixPanel } from "./matrix.js";
import { PinsPanel, ScenePanel } from "./pins.js";
import { onRoute, routeOf } from "./route.js";
import { change, colourings, derived, followAddress, looked, model, pin, refresh, setModel, state, watch } from "./state.js";
import { TablePanel } from "./table.js";
import { showMoved, TanglePanel } from "./tangle.js";
import { messageOf, plain, plural, sideName } from "./text.js";
import { TreePanel } from "./tree.js";
import { RarefactionPanel, showTrust } from "./trust.js";
import { WayPanel } from "./way.js";
import { explainHeadings } from "./words.js";

/**
 * The parts of this page.
 *
 * @typedef {{ table?: TablePanel, tree?: TreePanel, graph?: GraphPanel, tangle?: TanglePanel, scene?: ScenePanel, flat?: FlatPanel,
 *   way?: WayPanel, pins?: PinsPanel, likeness?: LikenessPanel, matrix?: MatrixPanel, rarefaction?: RarefactionPanel,
 *   label?: LabelSheet }} Panels
 */

/** @type {Panels} */
const panels = {};

function heading() {
  const { sides } = model;
  const [side] = sides;
  const same = sides.length > 1 && sides[0].subject && sides[0].subject === sides[1].subject;
  const title =
    sides.length === 1 ? side.title : same ? `${side.subject}: ${sides.map(one => one.name).join(" and ")}` : sides.map(sideName).join(" and ");
  document.title = title;
  byId("title").textContent = title;
  /** @param {import("./data.js").Side} one */
  const minima = one => `${plural(one.count, "minimum", "minima")} in ${plural(one.families ?? 0, "family", "families")}`;
  byId("subtitle").textContent =
    side.item === "grasp"
      ? `${plain(side.name)}. Click a grasp to choose it; Label names the types.`
      : [...sides.map(minima), ...(model.header.difference?.notes ?? []).filter(note => /objects/.test(note))].join(" · ");
  the(HTMLInputElement, "query").placeholder = "Search: " + examples(model).slice(0, 4).join(", ");
  const command = make("code", model.header.command);
  byId("made").replaceChildren(`Made by ${model.header.made_by} with `, command, ". This page needs no network.");
}

// Dark or light: as the system says, until the button is pressed.
function theme() {
  const root = document.documentElement;
  const system = matchMedia("(prefers-color-scheme: dark)");
  const show = () => {
    readLook();
    change({ look: {} });
  };
  const kept = memory.get("landscape theme");
  if (kept) root.dataset.theme = kept;
  byId("theme").addEventListener("click", () => {
    root.dataset.theme = look.dark ? "light" : "dark";
    memory.set("landscape theme", root.dataset.theme);
    show();
  });
  system.addEventListener("change", show);
  readLook();
}

function makePanels() {
  const [side] = model.sides;
  /** @param {string} name */
  const shown = name => {
    const section = byId(name);
    section.hidden = false;
    return section;
  };
  const two = model.sides.length > 1;
  // The first row of the table is what is shown at the start, so the table is made before the others.
  panels.table = new TablePanel(byId("table"));
  if (side.tree && !two) {
    panels.tree = new TreePanel(shown("tree"), side);
    panels.graph = new GraphPanel(shown("graph"), side);
  }
  if (two) panels.tangle = new TanglePanel(shown("tangle"));
  if (["pose", "atoms"].includes(side.space?.kind)) panels.scene = new ScenePanel(shown("scene"));
  else if (side.ways && side.space.dimensions > 0) panels.flat = new FlatPanel(shown("flat"), side, side.ways);
  if (side.tree) panels.way = new WayPanel(byId("way"));
  if (panels.scene?.views) panels.pins = new PinsPanel(byId("pins"));
  if (side.likeness) panels.likeness = new LikenessPanel(shown("likeness"), side.likeness);
  if (side.type) panels.matrix = new MatrixPanel(shown("matrix"));
  if (model.header.difference) showMoved(shown("moved"), model.header.difference);
  else if (side.rarefaction && side.space?.kind === "pose")
    panels.rarefaction = new RarefactionPanel(shown("rarefaction"), side.rarefaction);
  if (side.members?.length && side.label && !two) panels.label = new LabelSheet(byId("labelling"));
  new Legend(byId("legend"));
  explainHeadings(panels.likeness?.meaning);
  document.body.dataset.panels = Object.keys(panels)
    .filter(name => !document.getElementById(name)?.hidden)
    .join(" ");
}

function tools() {
  const colour = the(HTMLSelectElement, "colour");
  // While there is a level, colours show the families below it. To choose another colour takes the level away.
  const families = make("option", "families below the level", { value: "level" });
  colour.append(...colourings().map(([name, words]) => make("option", words, { value: name })), families);
  colour.addEventListener("change", () => change({ colour: colour.value, level: null }));
  watch(["colour", "level"], () => {
    families.hidden = families.disabled = state.level === null;
    colour.value = state.level === null ? state.colour : "level";
    colour.title = state.level === null ? "" : "Colours show the families below the level line; choose another colour to take the line away.";
  });
  const query = the(HTMLInputElement, "query");
  query.addEventListener("input", () => change({ query: query.value }));
  watch(["query"], () => {
    if (query.value !== state.query) query.value = state.query;
    const words = derived.problem || (state.query ? `${derived.passing} of ${model.count}` : "");
    byId("answer").textContent = words;
    byId("answer").classList.toggle("problem", derived.problem !== "");
    query.setAttribute("aria-invalid", String(derived.problem !== ""));
  });
  byId("export-open").addEventListener("click", () => openExport(panels));
  byId("help-open").addEventListener("click", openHelp);
  byId("label-start").hidden = !panels.label;
  byId("label-start").addEventListener("click", () => panels.label?.open());
  document.addEventListener("keydown", event => {
    const { target } = event;
    if (!(target instanceof Element) || target.closest("input, select, dialog, #labelling") || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "/") {
      event.preventDefault();
      query.focus();
    } else if (event.key === "p" && panels.pins) pin(looked());
    else if (event.key === "?") openHelp();
    else if (event.key === "Escape") {
      tip(null);
      change({ selected: [], hover: null });
    }
  });
}

function openHelp() {
  const dialog = the(HTMLDialogElement, "help");
  const [side] = model.sides;
  const grasps = side.space?.kind === "pose";
  // Each with what must be there.
  /** @type {[string, string, unknown][]} */
  const all = [
    ["Move", `over a leaf, a dot or a row: it lights up everywhere${grasps ? ", and its grasp is shown" : ""}.`, true],
    [
      "Click",
      side.tree
        ? "to choose; a second click on another one shows the lowest way between the two. Click the same again, or press Escape, to choose none."
        : "to choose. Click the same again, or press Escape, to choose none.",
      true,
    ],
    [
      "Level",
      "Drag the handle at the left of the tree: what is joined below the line takes one colour everywhere. Arrow keys move it.",
      panels.tree,
    ],
    ["Branch", "Click a join of the tree, or Zoom in, to see only what hangs below it; Whole tree goes back.", panels.tree],
    ["Colours", "The legend says what they mean. Click an entry to see only those; the filter stays in sight until you click it away.", true],
    [
      "Label",
      "opens a sheet of pictures on which types are given by keyboard. It goes first to the grasps of which the labeller is least " +
        "sure. Save a few dozen labels, make a labeller of your own from them with landscape label --learn, and the page of " +
        "landscape report --by asks for what that one is least sure of.",
      panels.label,
    ],
    ["p", "pins the grasp that is looked at, up to six.", panels.pins],
    ["/", "goes to the search field. Names, words and comparisons can be joined by and, or, not and parentheses.", true],
    [
      "Turn",
      "Drag a view to turn it, use the wheel to enlarge it, double-click to go back. Arrow keys work as well.",
      panels.scene?.views,
    ],
    ["Link", "What you see stands in the address. Export shows the link and the commands.", true],
  ];
  const entries = all.filter(([, , there]) => there);
  const tries = examples(model).map(text =>
    button(text, () => {
      dialog.close();
      change({ query: text });
    }),
  );
  showDialog(dialog, "What you can do", [
    make("dl", "", {}, ...entries.flatMap(([keys, words]) => [make("dt", keys), make("dd", words)])),
    make("h3", "Searches to try"),
    make("p", "", { class: "examples" }, ...tries),
  ]);
}

async function start() {
  const folder = decodeURIComponent(location.pathname.split("/").at(-2) ?? "") || "x.landscape";
  setModel(new Model(await unpack(byId("data").textContent), folder));
  byId("data").remove();
  theme();
  heading();
  showTrust(byId("trust"));
  makePanels();
  tools();
  followAddress();
  change({ labels: true, look: {} });
  refresh();
  // The page from outside, for notebooks (python/python/landscape/widget.py) and the tests in python/tests/page.
  const page = { model, state, derived, panels, look, FAMILY, change, routeOf, onRoute, lookOf, lookOfLabel, poseLinks };
  Object.assign(globalThis, { landscape: page });
  document.body.dataset.ready = "1";
  document.dispatchEvent(new Event("ready"));
}

start().catch(error => {
  byId("panels").prepend(make("p", "This page could not be read: " + messageOf(error), { class: "alone", role: "alert" }));
  throw error;
});
