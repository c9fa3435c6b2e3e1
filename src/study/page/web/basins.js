// The superbasins of trees: what is joined below an energy.

import { append, NONE } from "./data.js";

// Colours of families. They are lines too, so each stands out from the paper (3:1), and any two differ for all kinds of
// colour blindness; a test computes both. They were found by a search for the greatest least distance.
export const FAMILY = {
  light: ["#3496ef", "#b18e15", "#670463", "#1b490f", "#824aca", "#995f2c", "#3a788b"],
  dark: ["#2b87d9", "#eabf3a", "#f4d5fb", "#aafa99", "#8aa3f3", "#a35e16", "#97996e"],
};

/** @typedef {{ top: Uint32Array, colour: Int8Array, list: number[][] }} Basins */

// The superbasins below an energy: for each item the node on top of its basin (NONE above the level) and the number of its
// colour (−1 for none), and the basins of several minima.
/** @param {import("./data.js").Model} model @param {number | null} level @returns {Basins | null} */
export function basinsAt(model, level) {
  if (level === null) return null;
  const top = new Uint32Array(model.count).fill(NONE);
  const colour = new Int8Array(model.count).fill(-1);
  /** @type {number[][]} */
  const list = [];
  model.landscapes.forEach((side, number) => {
    const { energy, parent } = side.tree;
    const above = new Uint32Array(energy.length);
    for (let node = energy.length - 1; node >= 0; node--) {
      const joined = parent[node] !== NONE && energy[parent[node]] <= level;
      above[node] = joined ? above[parent[node]] : node;
    }
    /** @type {Map<number, number[]>} */
    const basins = new Map();
    for (let k = 0; k < side.count; k++) {
      if (energy[k] > level) continue;
      top[model.offsets[number] + k] = above[k];
      append(basins, above[k], model.offsets[number] + k);
    }
    list.push(...coloured([...basins.values()], model.offsets[number], colour));
  });
  return { top, colour, list };
}

// Gives the basins of several minima colours. Each prefers that of its lowest minimum, so that it keeps it while it grows.
/** @param {number[][]} basins @param {number} offset @param {Int8Array} colour */
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
