// How items look: the colours of the page, dark or light, and the look of each item by what colours show.

import { FAMILY } from "./basins.js";
import { NONE } from "./data.js";
import { derived, model, state } from "./state.js";

/** @typedef {import("./data.js").Look} Look */

const INKS = /** @type {const} */ (["ink", "soft", "line", "pale", "faint", "paper", "accent", "route"]);
export const look = { dark: false, ink: "", soft: "", line: "", pale: "", faint: "", paper: "", accent: "", route: "" };

// Reads the colours of the present look, dark or light.
export function readLook() {
  const style = getComputedStyle(document.documentElement);
  for (const name of INKS) {
    look[name] = style.getPropertyValue("--" + name).trim();
  }
  look.dark = style.colorScheme === "dark";
}

// What has no value or kind.
const NOTHING = disc("#b4bac4");

const VIRIDIS = ["#440154", "#482878", "#3e4989", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"];

// What has no label.
const UNLABELLED = disc("#7b8fa8");

/** @param {string} colour @returns {Look} */
export function disc(colour) {
  return { colour, corners: [], open: false };
}

/** @param {number} t */
export function viridis(t) {
  const place = Math.min(0.9999, Math.max(0, t)) * (VIRIDIS.length - 1);
  /** @param {string} text */
  const channels = text => [1, 3, 5].map(k => parseInt(text.slice(k, k + 2), 16));
  const [a, b] = [VIRIDIS[Math.floor(place)], VIRIDIS[Math.floor(place) + 1]].map(channels);
  return `rgb(${a.map((value, k) => Math.round(value + (place % 1) * (b[k] - value))).join(" ")})`;
}

/** @type {Map<string, [number, number]>} */
const ranges = new Map();

/** @param {string} field */
export function range(field) {
  let known = ranges.get(field);
  if (!known) {
    let [low, high] = [Infinity, -Infinity];
    for (let item = 0; item < model.count; item++) {
      const value = model.number(field, item);
      if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
    }
    // What differs by rounding has one colour.
    const rounding = ["energy", "joins", "barrier"].includes(field) ? Math.max(...model.sides.map(side => side.rounding)) : 0;
    known = [low, high - low > rounding ? high : low];
    ranges.set(field, known);
  }
  return known;
}

/** The look of an item: the colour of its superbasin while there is a level, else what is chosen. @param {number} item @returns {Look} */
export function lookOf(item) {
  if (derived.basins) {
    const colour = familyColour(item);
    return colour ? disc(colour) : NOTHING;
  }
  switch (state.colour) {
    case "category":
      return model.key.get(model.text("category", item)) ?? NOTHING;
    case "type":
      return lookOfLabel(model.text("label", item));
    case "stable":
      return model.key.get(["power", "precision"][model.number("stable", item)]) ?? NOTHING;
    case "family":
      return model.inTurn[model.number("family", item) % model.inTurn.length];
    default: {
      const [low, high] = range(state.colour);
      const value = model.number(state.colour, item);
      return Number.isFinite(value) ? disc(viridis((value - low) / (high - low || 1))) : NOTHING;
    }
  }
}

/** The look of a label: its own, or as those without one take looks in turn, in alphabetical order. @param {string} label */
export function lookOfLabel(label) {
  if (label === "") return UNLABELLED;
  const known = model.key.get(label);
  if (known) return known;
  return model.inTurn[otherLabels().indexOf(label) % model.inTurn.length];
}

// The labels on the page that have no look of their own, in alphabetical order.
export function otherLabels() {
  if (!derived.otherLabels) {
    /** @type {Set<string>} */
    const labels = new Set();
    for (let item = 0; item < model.count; item++) labels.add(model.text("label", item));
    derived.otherLabels = [...labels].filter(label => label !== "" && !model.key.has(label)).sort();
  }
  return derived.otherLabels;
}

/** The colour of an item, for lines. @param {number} item */
export function colourOf(item) {
  return lookOf(item).colour;
}

/** The colour of the family of an item, or null if it is alone or above the level, or there is none. @param {number} item */
export function familyColour(item) {
  const number = derived.basins?.colour[item] ?? -1;
  return number < 0 ? null : FAMILY[look.dark ? "dark" : "light"][number];
}

/** The items in the superbasin of an item, or null. @param {number | null} item */
export function family(item) {
  if (!derived.basins || item === null || derived.basins.top[item] === NONE) return null;
  const side = model.sideOf(item);
  const items = [];
  for (let other = model.offsets[side]; other < model.offsets[side + 1]; other++) {
    if (derived.basins.top[other] === derived.basins.top[item]) items.push(other);
  }
  return items;
}
