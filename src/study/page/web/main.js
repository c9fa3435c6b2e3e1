// The start: unpacks the data, makes the panels that the data need, and handles the search field and keys.
"use strict";

const panels = {};

function setQuery(text) {
  byId("query").value = text;
  change({ query: text });
}

function heading() {
  const { sides } = model;
  const [side] = sides;
  const title = sides.length > 1 ? sides.map(one => one.name.replace(/\.landscape$/, "")).join(" and ") : side.title;
  document.title = title;
  byId("title").textContent = title;
  const minima = one =>
    `${one.count} ${one.count === 1 ? "minimum" : "minima"} in ${one.groups} ${one.groups === 1 ? "group" : "groups"}`;
  byId("subtitle").textContent =
    side.item === "grasp" ? "Click a grasp to choose it; Label names their types." : sides.map(minima).join(" · ");
  if (side.space?.kind !== "pose") byId("query").placeholder = "Search: m3, energy < 0, not g0";
  byId("made").replaceChildren(
    `Made by ${model.header.made_by} with `,
    make("code", model.header.command),
    ". This page needs no network.",
  );
}

function theme() {
  let kept = null;
  try {
    kept = localStorage.getItem("landscape theme");
  } catch {
    /* nothing is remembered */
  }
  if (kept) document.documentElement.dataset.theme = kept;
  const again = () => {
    readLook();
    change({ look: {} });
  };
  byId("theme").addEventListener("click", () => {
    const dark = document.documentElement.dataset.theme ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
    const next = dark === "dark" ? "light" : "dark";
    document.documentElement.dataset.theme = next;
    try {
      localStorage.setItem("landscape theme", next);
    } catch {
      /* nothing is remembered */
    }
    again();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  readLook();
}

function makePanels() {
  const [side] = model.sides;
  const show = (name, Panel) => {
    byId(name).hidden = false;
    panels[name] = new Panel(byId(name));
  };
  const two = model.sides.length > 1;
  if (side.tree && !two) {
    show("tree", TreePanel);
    show("graph", GraphPanel);
  }
  if (two) show("tangle", TanglePanel);
  if (["pose", "atoms"].includes(side.space?.kind)) show("scene", ScenePanel);
  else if (side.coordinates && side.space.dimensions > 0) show("flat", FlatPanel);
  if (side.tree) panels.way = new WayPanel(byId("way"));
  if (panels.scene?.views) panels.pins = new PinsPanel(byId("pins"));
  panels.table = new TablePanel(byId("table"));
  if (side.type) show("matrix", MatrixPanel);
  if (two) {
    byId("moved").hidden = false;
    showMoved(byId("moved"));
  } else if (side.rarefaction && side.space?.kind === "pose") show("rarefaction", RarefactionPanel);
  if (side.members?.length && side.label && !two) panels.label = new LabelSheet(byId("labelling"));
  document.body.dataset.panels = Object.keys(panels)
    .filter(name => !byId(name)?.hidden)
    .join(" ");
}

function tools() {
  const colour = byId("colour");
  colour.append(...colourings().map(([name, words]) => make("option", words, { value: name })));
  colour.addEventListener("change", () => change({ colour: colour.value }));
  watch(["colour", "level"], () => {
    colour.value = state.colour;
    colour.disabled = state.level !== null;
  });
  const query = byId("query");
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
  byId("label-start").addEventListener("click", () => panels.label.open());
  document.addEventListener("keydown", event => {
    if (event.target.closest("input, select, dialog, #labelling") || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "/") {
      event.preventDefault();
      query.focus();
    } else if (event.key === "p") pin(looked());
    else if (event.key === "?") openHelp();
    else if (event.key === "Escape") change({ selected: [], hover: null });
  });
}

function openHelp() {
  const dialog = byId("help");
  const entry = (keys, words) => [make("dt", keys), make("dd", words)];
  const grasps = model.sides[0].space?.kind === "pose";
  const examples = grasps
    ? [
        "m17",
        "tripod",
        "energy < 0.2 and members > 3",
        "stable and epsilon > 0.05",
        "evidence = saddle or support >= 95%",
        "not (power or g0)",
      ]
    : ["m3", "energy < -100", "members > 3", "evidence = saddle", "not g0"];
  const examplesList = make(
    "p",
    "",
    { class: "examples" },
    ...examples.map(text =>
      make("button", text, {
        type: "button",
        onclick: () => {
          dialog.close();
          setQuery(text);
        },
      }),
    ),
  );
  dialog.replaceChildren(
    make("h2", "What you can do"),
    make(
      "dl",
      "",
      {},
      ...entry("Move", "over a leaf, a dot or a row: it lights up everywhere, and its grasp is shown."),
      ...entry(
        "Click",
        "to choose; a second click on another one shows the lowest way between the two. Click the same again, or press Escape, to choose none.",
      ),
      ...entry(
        "Level",
        "Drag the handle at the left of the tree: what is joined below the line takes one colour everywhere. Arrow keys move it.",
      ),
      ...entry("p", "pins the grasp that is looked at, up to six."),
      ...entry("/", "goes to the search field. Names, words and comparisons can be joined by and, or, not and parentheses."),
      ...entry("Turn", "Drag a view to turn it, use the wheel to enlarge it, double-click to go back. Arrow keys work as well."),
      ...entry("Link", "What you see stands in the address. Export shows the link and the commands."),
    ),
    make("h3", "Searches to try"),
    examplesList,
    make("form", "", { method: "dialog" }, make("button", "Close", { class: "main" })),
  );
  dialog.showModal();
}

async function start() {
  model = new Model(await unpack(byId("data").textContent));
  byId("data").remove();
  derived.passes = new Uint8Array(model.count).fill(1);
  theme();
  heading();
  showTrust(byId("trust"));
  makePanels();
  tools();
  readAddress();
  change({ labels: true, look: {} });
  refresh();
  document.body.dataset.ready = "1";
  document.dispatchEvent(new Event("ready"));
}

start().catch(error => {
  byId("panels").prepend(make("p", "This page could not be read: " + error.message, { class: "alone", role: "alert" }));
  throw error;
});
