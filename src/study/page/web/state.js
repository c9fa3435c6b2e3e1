// What is chosen on the page. All panels share it, and it stands in the address, so that a link shows the same.
"use strict";

let model = null;

const state = {
  hover: null, // the item under the pointer
  selected: [], // at most two items; two show the way between them
  level: null, // an energy that divides the tree into superbasins
  query: "", // the text of the search field
  chips: [], // filters that stay in sight: texts as in the search field
  branch: null, // the node of the tree of which only what hangs below is shown
  pins: [], // at most six items
  colour: "", // what colours show
  camera: null, // [azimuth, elevation, zoom], degrees
  step: 0, // place on the way, 0 to 1
  sort: "energy", // column of the table, with a minus for the other order
  cones: false, // whether friction cones are shown
};

// Derived from it: which items pass the filter, the superbasins, the first item of the table, and the labels that have no look
// of their own.
const derived = { passes: null, passing: 0, problem: "", basins: null, first: 0, otherLabels: null };

const MOST_PINS = 6;
const watchers = [];
const stale = new Set();
let scheduled = false;

// Calls `paint` after one of these parts of the state changed.
function watch(parts, paint) {
  watchers.push([parts, paint]);
}

function change(changes) {
  for (const [part, value] of Object.entries(changes)) {
    if (part === "hover" && state.hover === value) continue;
    state[part] = value;
    stale.add(part);
  }
  if (stale.has("pins") && /pinned/i.test(state.query)) stale.add("query");
  if (stale.has("level")) {
    derived.basins = basinsAt(state.level);
    // Without a level there are no families to filter by.
    if (!derived.basins && state.chips.some(chip => fieldOf(chip) === "family")) {
      state.chips = state.chips.filter(chip => fieldOf(chip) !== "family");
      stale.add("chips");
    }
  }
  if (stale.has("labels")) derived.otherLabels = null;
  // A change of these changes what passes.
  if (["chips", "labels"].some(part => stale.has(part)) || (stale.has("level") && /family/i.test(state.query + filterText()))) stale.add("query");
  if (stale.has("query") || derived.passes === null) filterItems();
  if (!scheduled && stale.size) {
    scheduled = true;
    requestAnimationFrame(refresh);
  }
}

function refresh() {
  scheduled = false;
  const parts = [...stale];
  stale.clear();
  for (const [watched, paint] of watchers) if (parts.some(part => watched.includes(part))) paint();
  if (parts.some(part => part !== "hover")) keepInAddress();
}

// All filters as one text: the search, and the chips. Chips of one field are alternatives.
function filterText() {
  const fields = new Map();
  for (const chip of state.chips) {
    const field = fieldOf(chip);
    fields.set(field, [...(fields.get(field) ?? []), `(${chip})`]);
  }
  return [...fields.values()].map(chips => `(${chips.join(" or ")})`).join(" ");
}

// What a chip is about: its name of a field, or a word that stands for one.
function fieldOf(chip) {
  const word = chip.match(/[\wε]+/)?.[0] ?? "";
  if (/^(not|stable|unstable|simulated)$/.test(word)) return "stable";
  return /^g\d+$/.test(word) ? "group" : word;
}

function toggleChip(chip) {
  change({ chips: state.chips.includes(chip) ? state.chips.filter(other => other !== chip) : [...state.chips, chip] });
}

function filterItems() {
  const searched = compiled(state.query, model);
  const chosen = compiled(filterText(), model);
  const test = item => searched.test(item) && chosen.test(item);
  const problem = searched.problem || chosen.problem;
  const passes = new Uint8Array(model.count);
  for (let item = 0; item < model.count; item++) passes[item] = test(item) ? 1 : 0;
  Object.assign(derived, { passes, passing: passes.reduce((sum, pass) => sum + pass, 0), problem });
}

function passing() {
  const items = [];
  for (let item = 0; item < model.count; item++) if (derived.passes[item]) items.push(item);
  return items;
}

// A click chooses one item, a second click one more: two items show the way between them. Only the last two stay.
function select(item) {
  if (item === null) return change({ selected: [] });
  const last = state.selected.at(-1);
  const selected = last === undefined ? [item] : last === item ? [] : [last, item];
  change({ selected, step: 0 });
}

function pin(item) {
  if (item === null || item === undefined) return;
  const pins = state.pins.includes(item) ? state.pins.filter(other => other !== item) : [...state.pins, item].slice(-MOST_PINS);
  change({ pins });
}

// The item that is looked at: under the pointer, else chosen last, else the first of the table.
function looked() {
  return state.hover ?? state.selected.at(-1) ?? derived.first;
}

let written = null;
let waiting = 0;

function keepInAddress() {
  // A frame whose page is given as text (srcdoc) has no address: a new one would load the page around it into the frame.
  if (location.protocol === "about:") return;
  clearTimeout(waiting);
  waiting = setTimeout(() => {
    written = "#" + fragment();
    try {
      history.replaceState(null, "", written === "#" ? location.pathname : written);
    } catch {
      location.replace(written);
    }
  }, 120);
}

function fragment() {
  const names = items => items.map(item => model.name(item)).join(",");
  const parts = {
    sel: names(state.selected),
    level: state.level === null ? "" : String(Number(state.level.toPrecision(8))),
    q: state.query,
    pin: names(state.pins),
    colour: state.colour === firstColour() ? "" : state.colour,
    cam: state.camera ? state.camera.map(value => Number(value.toFixed(3))).join(",") : "",
    step: state.step ? String(Number(state.step.toFixed(4))) : "",
    sort: state.sort === "energy" ? "" : state.sort,
    cones: state.cones ? "1" : "",
    branch: state.branch === null ? "" : String(state.branch),
  };
  const all = Object.entries(parts).filter(([, value]) => value !== "");
  return new URLSearchParams([...all, ...state.chips.map(chip => ["chip", chip])]).toString();
}

// Reads the address. What it does not name is as at the start; what makes no sense is left out.
function readAddress() {
  const parts = new URLSearchParams(location.hash.slice(1));
  const items = name =>
    (parts.get(name) ?? "")
      .split(",")
      .map(text => model.named(text))
      .filter(item => item !== null);
  const number = name => (parts.has(name) && Number.isFinite(Number(parts.get(name))) ? Number(parts.get(name)) : null);
  const level = model.sides[0].tree ? number("level") : null;
  derived.basins = basinsAt(level);
  const camera = (parts.get("cam") ?? "").split(",").map(Number);
  change({
    selected: items("sel").slice(0, 2),
    level,
    query: parts.get("q") ?? "",
    pins: [...new Set(items("pin"))].slice(0, MOST_PINS),
    colour: colourings().some(([name]) => name === parts.get("colour")) ? parts.get("colour") : firstColour(),
    camera: camera.length === 3 && camera.every(Number.isFinite) ? camera : null,
    step: Math.min(1, Math.max(0, number("step") ?? 0)),
    sort: parts.get("sort") ?? "energy",
    cones: parts.get("cones") === "1",
    chips: [...new Set(parts.getAll("chip"))].filter(chip => compiled(chip, model).problem === ""),
    branch: branchNamed(parts.get("branch")),
  });
}

// The merge of the tree with this number, or null.
function branchNamed(text) {
  const [side] = model.sides;
  const node = /^\d+$/.test(text ?? "") ? Number(text) : -1;
  return side.tree && model.sides.length === 1 && node >= side.count && node < side.tree.energy.length ? node : null;
}

window.addEventListener("hashchange", () => {
  if (location.hash !== written) readAddress();
});

// What has no value or kind.
const NOTHING = disc("#b4bac4");
const VIRIDIS = ["#440154", "#482878", "#3e4989", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"];
// What has no label.
const UNLABELLED = disc("#7b8fa8");
// Colours of families. They are lines too, so each stands out from the paper (3:1), and any two differ for all kinds of
// colour blindness; a test computes both. They were found by a search for the greatest least distance.
const FAMILY = {
  light: ["#3496ef", "#b18e15", "#670463", "#1b490f", "#824aca", "#995f2c", "#3a788b"],
  dark: ["#2b87d9", "#eabf3a", "#f4d5fb", "#aafa99", "#8aa3f3", "#a35e16", "#97996e"],
};

function disc(colour) {
  return { colour, corners: [], open: false };
}

function viridis(t) {
  const place = Math.min(0.9999, Math.max(0, t)) * (VIRIDIS.length - 1);
  const channels = text => [1, 3, 5].map(k => parseInt(text.slice(k, k + 2), 16));
  const [a, b] = [VIRIDIS[Math.floor(place)], VIRIDIS[Math.floor(place) + 1]].map(channels);
  return `rgb(${a.map((value, k) => Math.round(value + (place % 1) * (b[k] - value))).join(" ")})`;
}

// What colours can show on this page: names and words.
function colourings() {
  const all = [
    ["category", "category"],
    ["type", "grasp type"],
    ["stable", "stability"],
    ["group", "group"],
    ["epsilon", "ε"],
    ["energy", "energy"],
  ];
  return all.filter(([name]) => name === "energy" || model.knows(name));
}

function firstColour() {
  return colourings()[0][0];
}

const ranges = {};

function range(field) {
  if (!ranges[field]) {
    let [low, high] = [Infinity, -Infinity];
    for (let item = 0; item < model.count; item++) {
      const value = model.number(field, item);
      if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
    }
    // What differs by rounding has one colour.
    const rounding = ["energy", "joins", "barrier"].includes(field) ? Math.max(...model.sides.map(side => side.rounding)) : 0;
    ranges[field] = high - low > rounding ? [low, high] : [low, low];
  }
  return ranges[field];
}

// The look of an item: the colour of its superbasin while there is a level, else what is chosen.
function lookOf(item) {
  if (derived.basins) return derived.basins.colour[item] < 0 ? NOTHING : disc(familyColour(item));
  switch (state.colour) {
    case "category":
      return model.key.get(model.text("category", item)) ?? NOTHING;
    case "type":
      return lookOfLabel(model.text("label", item));
    case "stable":
      return { 0: model.key.get("power"), 1: model.key.get("precision") }[model.number("stable", item)] ?? NOTHING;
    case "group":
      return model.inTurn[model.number("group", item) % model.inTurn.length];
    default: {
      const [low, high] = range(state.colour);
      const value = model.number(state.colour, item);
      return Number.isFinite(value) ? disc(viridis((value - low) / (high - low || 1))) : NOTHING;
    }
  }
}

// The look of a label: its own, or as those without one take looks in turn, in alphabetical order.
function lookOfLabel(label) {
  if (label === "") return UNLABELLED;
  const known = model.key.get(label);
  if (known) return known;
  return model.inTurn[otherLabels().indexOf(label) % model.inTurn.length];
}

// The labels on the page that have no look of their own, in alphabetical order.
function otherLabels() {
  if (!derived.otherLabels) {
    const labels = new Set();
    for (let item = 0; item < model.count; item++) labels.add(model.text("label", item));
    derived.otherLabels = [...labels].filter(label => label !== "" && !model.key.has(label)).sort();
  }
  return derived.otherLabels;
}

// The colour of an item, for lines.
function colourOf(item) {
  return lookOf(item).colour;
}

// The superbasins below an energy: for each item the node on top of its basin (NONE above the level) and the number of its
// colour (−1 for none), and the basins of several minima.
function basinsAt(level) {
  if (level === null) return null;
  const top = new Uint32Array(model.count).fill(NONE);
  const colour = new Int8Array(model.count).fill(-1);
  const list = [];
  model.sides.forEach((side, number) => {
    const { energy, parent } = side.tree;
    const above = new Uint32Array(energy.length);
    for (let node = energy.length - 1; node >= 0; node--) {
      const joined = parent[node] !== NONE && energy[parent[node]] <= level;
      above[node] = joined ? above[parent[node]] : node;
    }
    const basins = new Map();
    for (let k = 0; k < side.count; k++) {
      if (energy[k] > level) continue;
      top[model.offsets[number] + k] = above[k];
      if (!basins.has(above[k])) basins.set(above[k], []);
      basins.get(above[k]).push(model.offsets[number] + k);
    }
    list.push(...coloured([...basins.values()], model.offsets[number], colour));
  });
  return { top, colour, list };
}

// Gives the basins of several minima colours. Each prefers that of its lowest minimum, so that it keeps it while it grows.
function coloured(basins, offset, colour) {
  const several = basins.filter(basin => basin.length > 1).sort((a, b) => b.length - a.length || a[0] - b[0]);
  const count = FAMILY.light.length;
  const used = new Set();
  for (const basin of several) {
    let choice = (basin[0] - offset) % count;
    while (used.has(choice)) choice = (choice + 1) % count;
    used.add(choice);
    for (const item of basin) colour[item] = choice;
    if (used.size === count) used.clear();
  }
  return several;
}

// The colour of the family of an item, or null if it is alone or above the level.
function familyColour(item) {
  const number = derived.basins.colour[item];
  return number < 0 ? null : FAMILY[look.dark ? "dark" : "light"][number];
}

// The items in the superbasin of an item, or null.
function family(item) {
  if (!derived.basins || derived.basins.top[item] === NONE) return null;
  const side = model.sideOf(item);
  const items = [];
  for (let other = model.offsets[side]; other < model.offsets[side + 1]; other++) {
    if (derived.basins.top[other] === derived.basins.top[item]) items.push(other);
  }
  return items;
}
