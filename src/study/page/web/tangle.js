// Two landscapes: their trees face to face, with lines between corresponding minima, and a list of what moved.

import { NONE } from "./data.js";
import { addTools, button, make, tool } from "./dom.js";
import { colourOf, familyColour, look, lookOf } from "./looks.js";
import { Drawing, nearest, OF_ITEMS, rings } from "./pen.js";
import { childrenOf } from "./route.js";
import { change, derived, model, select, state, watch } from "./state.js";
import { plain, shown, sideName, ticks } from "./text.js";

/**
 * @typedef {import("./data.js").Landscape} Landscape
 * @typedef {import("./pen.js").Pen} Pen
 */

// Rows of each list of what moved.
const MOST_MOVED = 40;

export class TanglePanel {
  /** @param {HTMLElement} section */
  constructor(section) {
    const energies = model.landscapes.flatMap(side => Array.from(side.tree.energy));
    const [low, high] = [Math.min(...energies), Math.max(...energies)];
    const margin = 0.05 * (high - low || 1);
    this.low = low - margin;
    this.high = high + margin;
    this.children = model.landscapes.map(side => childrenOf(side.tree));
    this.box = [0, 0];
    this.drawing = new Drawing(
      section,
      "Two trees face to face",
      OF_ITEMS,
      (pen, w, h) => this.paint(pen, w, h),
      pen => this.mark(pen),
      at => this.found(at),
    );
    this.levelSlider(section);
  }

  /** @param {HTMLElement} section */
  levelSlider(section) {
    const slider = make("input", "", {
      type: "range",
      min: this.low,
      max: this.high,
      step: (this.high - this.low) / 400,
      "aria-label": "Level that divides the trees into families",
    });
    slider.addEventListener("input", () => change({ level: Number(slider.value) }));
    const level = tool("Level", "Show or hide the level line, which divides the trees into families", () =>
      change({ level: state.level === null ? (this.low + this.high) / 2 : null }),
    );
    addTools(section, slider, level);
    watch(["level"], () => {
      slider.hidden = state.level === null;
      slider.valueAsNumber = state.level ?? this.high;
      level.setAttribute("aria-pressed", String(state.level !== null));
    });
  }

  /** Trees lie on their sides: energy outward, leaves toward the middle. @param {number} side @param {number} energy */
  x(side, energy) {
    const third = 0.38 * this.box[0];
    const out = third - ((energy - this.low) / (this.high - this.low)) * (third - 14);
    return side === 0 ? out : this.box[0] - out;
  }

  /** @param {number} side @param {number} node */
  y(side, node) {
    const { tree } = model.landscapes[side];
    return 38 + ((this.box[1] - 82) * (tree.x[node] + 0.5)) / (tree.width + 1);
  }

  /** @param {number} item */
  at(item) {
    const side = model.sideOf(item);
    const k = item - model.offsets[side];
    return [this.x(side, model.sides[side].energy[k]), this.y(side, k)];
  }

  /** @param {Pen} pen @param {number} w @param {number} h */
  paint(pen, w, h) {
    this.box = [w, h];
    model.landscapes.forEach((side, number) => {
      const anchor = number ? "end" : "start";
      pen.text([number ? w - 14 : 14, 12], plain(sideName(side), w / 15), { fill: look.ink, size: 12.5, anchor, weight: 600 });
      for (const [value] of ticks(this.low, this.high, 4)) {
        const x = this.x(number, value);
        pen.line(x, 28, x, h - 38, { stroke: look.faint });
      }
      pen.columns(this.low, this.high, 4, value => this.x(number, value), h - 28);
      pen.label([(this.x(number, this.low) + this.x(number, this.high)) / 2, h - 10], side.energy_label, { anchor: "middle" });
      this.tree(pen, side, number, w);
      if (state.level === null) return;
      const x = this.x(number, state.level);
      pen.line(x, 28, x, h - 38, { stroke: look.accent, width: 1.5 });
    });
    this.links(pen, false);
    for (let item = 0; item < model.count; item++) {
      const alpha = derived.passes[item] ? 1 : 0.2;
      pen.symbol(this.at(item), 3.4, lookOf(item), { stroke: look.line, width: 0.8, alpha });
    }
    this.names(pen);
  }

  /** Names beside the leaves, the deepest first, where they do not cover each other. @param {Pen} pen */
  names(pen) {
    model.sides.forEach((side, number) => {
      /** @type {number[][]} */
      const taken = [];
      for (let k = 0; k < side.count; k++) {
        const item = model.offsets[number] + k;
        const [x, y] = this.at(item);
        if (taken.some(([tx, ty]) => Math.abs(ty - y) < 10 && Math.abs(tx - x) < 30)) continue;
        taken.push([x, y]);
        pen.label([x + (number ? -7 : 7), y], model.name(item), { size: 10, anchor: number ? "end" : "start" });
      }
    });
  }

  /** @param {Pen} pen */
  mark(pen) {
    this.links(pen, true);
    rings((item, stroke) => {
      for (const one of [item, model.partner[item]].filter(one => one !== NONE)) {
        const [x, y] = this.at(one);
        pen.circle([x, y], 6.5, { stroke, width: 2 });
        pen.label([x, y - 13], model.name(one), { fill: look.ink, anchor: "middle", weight: 600 });
      }
    });
  }

  /** @param {Pen} pen @param {Landscape} side @param {number} number @param {number} w */
  tree(pen, side, number, w) {
    const { parent, energy } = side.tree;
    const outside = number === 0 ? 6 : w - 6;
    for (let node = 0; node < energy.length; node++) {
      const [x, y] = [this.x(number, energy[node]), this.y(number, node)];
      const end = parent[node] === NONE ? outside : this.x(number, energy[parent[node]]);
      const style = { stroke: familyStroke(this.children[number], node, side, model.offsets[number]), width: 1.2 };
      pen.line(x, y, end, y, style);
      if (node < side.count) continue;
      const ends = this.children[number][node].map(child => this.y(number, child));
      pen.line(x, Math.min(...ends), x, Math.max(...ends), style);
    }
  }

  /** Lines between corresponding minima: all, or those of the marked ones, which are lit. @param {Pen} pen @param {boolean} lit */
  links(pen, lit) {
    const chosen = new Set([...state.selected, state.hover].flatMap(item => (item === null ? [] : [item, model.partner[item]])));
    for (let item = 0; item < model.offsets[1]; item++) {
      const partner = model.partner[item];
      if (partner === NONE || (lit && !chosen.has(item))) continue;
      const alpha = derived.passes[item] || derived.passes[partner] ? (lit ? 1 : 0.55) : 0.1;
      pen.path([this.at(item), this.at(partner)], { stroke: lit ? look.route : colourOf(item), width: lit ? 3 : 1.4, alpha });
    }
  }

  /** @param {number[]} at */
  found([x, y]) {
    const item = nearest(model.count, 12, item => {
      const [px, py] = this.at(item);
      return Math.hypot(px - x, py - y);
    });
    return item === null ? null : { item };
  }
}

// The colour of the line of a node: that of its family while there is a level.
/** @param {number[][]} children @param {number} node @param {Landscape} side @param {number} offset */
function familyStroke(children, node, side, offset) {
  if (state.level === null || side.tree.energy[node] > state.level) return look.line;
  while (node >= side.count) node = children[node][0];
  return familyColour(offset + node) ?? look.line;
}

/** A distance of two minima: that of poses is a length in metres. @param {number} distance @param {{ kind: string }} space */
export function apart(distance, space) {
  return space?.kind === "pose" ? `${Number((1e3 * distance).toPrecision(3))} mm` : shown(distance);
}

/** How many minima are in both landscapes, and what counts as the same. @param {number} count @param {number} within */
function alike(count, within) {
  const [one, other] = model.sides.map(side => side.count);
  const are = count === 1 ? "minimum is" : "minima are";
  return `${count} ${are} the same in both (of ${one} and of ${other}; at most ${apart(within, model.sides[0].space)} apart)`;
}

/** What moved, and what is in one of the two only, the largest changes first. @param {HTMLElement} section @param {import("./data.js").Difference} found */
export function showMoved(section, { matches, possible, only_before, only_after, merges, within, notes }) {
  const [, offset] = model.offsets;
  /** @param {number} item */
  const link = item =>
    button(model.name(item), () => select(item), { class: "link", onpointerenter: () => change({ hover: item }) });
  /** @param {string} title @param {string[]} head @param {(string | Node)[][]} rows */
  const list = (title, head, rows) => {
    if (rows.length === 0) return [];
    const body = rows.slice(0, MOST_MOVED).map(row => make("tr", "", {}, ...row.map(cell => make("td", "", {}, cell))));
    const heads = make("tr", "", {}, ...head.map(words => make("th", words, { scope: "col" })));
    const rest = rows.length - body.length;
    return [
      make("h3", title),
      make("table", "", {}, make("thead", "", {}, heads), make("tbody", "", {}, ...body)),
      ...(rest > 0 ? [make("p", `and ${rest} more`, { class: "count" })] : []),
    ];
  };
  /** Things and their changes, the largest change first. @template Thing @param {Thing[]} things @param {(thing: Thing) => number} change */
  const changed = (things, change) =>
    things
      .map(thing => ({ thing, by: change(thing) }))
      .filter(({ by }) => Math.abs(by) > 1e-9)
      .sort((a, b) => Math.abs(b.by) - Math.abs(a.by));
  /** @param {number} value */
  const signed = value => (value > 0 ? "+" : "") + String(Number(value.toPrecision(2))).replace("-", "−");
  const moved = changed(matches, match => match.energies[1] - match.energies[0]);
  const heights = changed(merges, merge => (merge.after ?? Infinity) - merge.before);
  /** @param {number[]} items */
  const energies = items => items.map(item => [link(item), shown(model.energy(item))]);
  section.append(
    ...notes.map(note => make("p", `${note[0].toUpperCase()}${note.slice(1)}.`, { class: "differs" })),
    make("p", `${alike(matches.length, within)}; ${only_before.length} only in the first, ${only_after.length} only in the second.`),
    ...list(
      "Energies that moved most",
      ["before", "after", "energy", "change"],
      moved.map(({ thing: match, by }) => [link(match.before), link(offset + match.after), shown(match.energies[1]), signed(by)]),
    ),
    ...list(
      "Merges that moved most",
      ["between", "before", "after", "change"],
      heights.map(({ thing: { ends, before, after }, by }) => [
        ends.map(end => "m" + end).join(", "),
        shown(before),
        after === null ? "apart" : shown(after),
        after === null ? "" : signed(by),
      ]),
    ),
    ...list(
      "May be the same, at equal energy",
      ["before", "after", "energy", "difference", "distance"],
      possible.map(({ before, after, energies, distance }) => [
        link(before),
        link(offset + after),
        shown(energies[0]),
        signed(energies[1] - energies[0]),
        apart(distance, model.sides[0].space),
      ]),
    ),
    ...list("Only in the first", ["minimum", "energy"], energies(only_before)),
    ...list("Only in the second", ["minimum", "energy"], energies(only_after.map(item => offset + item))),
  );
}
