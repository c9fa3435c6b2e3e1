// What is chosen on the page. All panels share it, and it stands in the address, so that a link shows the same.

import { basinsAt } from "./basins.js";
import { append } from "./data.js";
import { compiled } from "./filter.js";

/**
 * The items of the page, once its data are unpacked.
 *
 * @type {import("./data.js").Model}
 */
export let model;

/** @param {import("./data.js").Model} made */
export function setModel(made) {
  model = made;
  derived.passes = new Uint8Array(model.count).fill(1);
}

/**
 * @typedef {{ hover: number | null, selected: number[], level: number | null, query: string, chips: string[], branch: number | null,
 *   pins: number[], colour: string, camera: number[] | null, step: number, sort: string, cones: boolean }} State
 * @typedef {Partial<State> & { labels?: true, look?: {} }} Changes besides: labels were given, the page looks different
 */

/** @type {State} */
export const state = {
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
/**
 * @type {{ passes: Uint8Array, passing: number, problem: string, basins: import("./basins.js").Basins | null, first: number,
 *   otherLabels: string[] | null }}
 */
export const derived = { passes: new Uint8Array(), passing: 0, problem: "", basins: null, first: 0, otherLabels: null };

const MOST_PINS = 6;
/** @type {[string[], () => void][]} */
const watchers = [];
/** @type {Set<string>} */
const stale = new Set();
let scheduled = false;

/** Calls `paint` after one of these parts of the state changed. @param {string[]} parts @param {() => void} paint */
export function watch(parts, paint) {
  watchers.push([parts, paint]);
}

/** @param {Changes} changes */
export function change(changes) {
  for (const part of Object.keys(changes)) if (part !== "hover" || state.hover !== changes.hover) stale.add(part);
  Object.assign(state, changes);
  if (stale.has("pins") && /pinned/i.test(state.query)) stale.add("query");
  if (stale.has("level")) {
    derived.basins = basinsAt(model, state.level);
    // Without a level there are no families to filter by.
    if (!derived.basins && state.chips.some(chip => fieldOf(chip) === "family")) {
      state.chips = state.chips.filter(chip => fieldOf(chip) !== "family");
      stale.add("chips");
    }
  }
  if (stale.has("labels")) derived.otherLabels = null;
  // A change of these changes what passes.
  if (["chips", "labels"].some(part => stale.has(part)) || (stale.has("level") && /family/i.test(state.query + filterText()))) stale.add("query");
  if (stale.has("query")) filterItems();
  if (!scheduled && stale.size) {
    scheduled = true;
    requestAnimationFrame(refresh);
  }
}

export function refresh() {
  scheduled = false;
  const parts = [...stale];
  stale.clear();
  for (const [watched, paint] of watchers) if (parts.some(part => watched.includes(part))) paint();
  if (parts.some(part => part !== "hover")) keepInAddress();
}

// All filters as one text: the search, and the chips. Chips of one field are alternatives.
function filterText() {
  /** @type {Map<string, string[]>} */
  const fields = new Map();
  for (const chip of state.chips) append(fields, fieldOf(chip), `(${chip})`);
  return [...fields.values()].map(chips => `(${chips.join(" or ")})`).join(" ");
}

/** What a chip is about: its name of a field, or a word that stands for one. @param {string} chip */
function fieldOf(chip) {
  const word = chip.match(/[\wε]+/)?.[0] ?? "";
  if (/^(not|stable|unstable|simulated)$/.test(word)) return "stable";
  return /^g\d+$/.test(word) ? "g" : word;
}

/** @param {string} chip */
export function toggleChip(chip) {
  change({ chips: state.chips.includes(chip) ? state.chips.filter(other => other !== chip) : [...state.chips, chip] });
}

// What a search may ask besides the items.
function about() {
  return { basins: derived.basins, pins: state.pins };
}

function filterItems() {
  const searched = compiled(state.query, model, about());
  const chosen = compiled(filterText(), model, about());
  const problem = searched.problem || chosen.problem;
  const passes = new Uint8Array(model.count);
  for (let item = 0; item < model.count; item++) passes[item] = searched.test(item) && chosen.test(item) ? 1 : 0;
  Object.assign(derived, { passes, passing: passes.reduce((sum, pass) => sum + pass, 0), problem });
}

export function passing() {
  const items = [];
  for (let item = 0; item < model.count; item++) if (derived.passes[item]) items.push(item);
  return items;
}

/** A click chooses one item, a second click one more: two items show the way between them. Only the last two stay. @param {number | null} item */
export function select(item) {
  if (item === null) return change({ selected: [] });
  const last = state.selected.at(-1);
  const selected = last === undefined ? [item] : last === item ? [] : [last, item];
  change({ selected, step: 0 });
}

/** @param {number} item */
export function pin(item) {
  const pins = state.pins.includes(item) ? state.pins.filter(other => other !== item) : [...state.pins, item].slice(-MOST_PINS);
  change({ pins });
}

// The item that is looked at: under the pointer, else chosen last, else the first of the table.
export function looked() {
  return state.hover ?? state.selected.at(-1) ?? derived.first;
}

/** @type {string | null} */
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

export function fragment() {
  /** @param {number[]} items */
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
  /** @param {string} name */
  const items = name =>
    (parts.get(name) ?? "")
      .split(",")
      .map(text => model.named(text))
      .filter(item => item !== null);
  /** @param {string} name */
  const number = name => (parts.has(name) && Number.isFinite(Number(parts.get(name))) ? Number(parts.get(name)) : null);
  const level = model.sides[0].tree ? number("level") : null;
  derived.basins = basinsAt(model, level);
  const camera = (parts.get("cam") ?? "").split(",").map(Number);
  const colour = parts.get("colour") ?? "";
  change({
    selected: items("sel").slice(0, 2),
    level,
    query: parts.get("q") ?? "",
    pins: [...new Set(items("pin"))].slice(0, MOST_PINS),
    colour: colourings().some(([name]) => name === colour) ? colour : firstColour(),
    camera: camera.length === 3 && camera.every(Number.isFinite) ? camera : null,
    step: Math.min(1, Math.max(0, number("step") ?? 0)),
    sort: parts.get("sort") ?? "energy",
    cones: parts.get("cones") === "1",
    chips: [...new Set(parts.getAll("chip"))].filter(chip => compiled(chip, model, about()).problem === ""),
    branch: branchNamed(parts.get("branch") ?? ""),
  });
}

/** The merge of the tree with this number, or null. @param {string} text */
function branchNamed(text) {
  const [side] = model.sides;
  const node = /^\d+$/.test(text) ? Number(text) : -1;
  return side.tree && model.sides.length === 1 && node >= side.count && node < side.tree.energy.length ? node : null;
}

// Follows the address from now on.
export function followAddress() {
  readAddress();
  window.addEventListener("hashchange", () => {
    if (location.hash !== written) readAddress();
  });
}

// What colours can show on this page: names and words.
export function colourings() {
  /** @type {[string, string][]} */
  const all = [
    ["category", "category"],
    ["type", "grasp type"],
    ["stable", "stability"],
    ["family", "family"],
    ["epsilon", "ε"],
    ["energy", "energy"],
  ];
  return all.filter(([name]) => name === "energy" || model.knows(name));
}

function firstColour() {
  return colourings()[0][0];
}
