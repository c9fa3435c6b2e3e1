// What the colours mean, with counts, and the filters that stay in sight. A click on an entry filters by it.

import { append } from "./data.js";
import { button, make } from "./dom.js";
import { unquoted } from "./filter.js";
import { disc, lookOf, otherLabels, range, viridis } from "./looks.js";
import { dotOf } from "./pen.js";
import { derived, model, state, toggleChip, watch } from "./state.js";
import { plain } from "./text.js";
import { familyName } from "./words.js";

// Entries of the legend of things without end: families.
const MOST_ENTRIES = 9;
// Ranges into which the legend of a number is divided.
const RANGES = 5;

/**
 * @typedef {import("./filter.js").Test} Test
 * @typedef {{ words: string, chip: string, count: number, dot: import("./data.js").Look }} Entry words, filter, number and look of items
 */

export class Legend {
  /** @param {HTMLElement} section */
  constructor(section) {
    this.section = section;
    watch(["colour", "level", "chips", "query", "labels", "look"], () => this.show());
  }

  /** @returns {Entry[]} */
  entries() {
    const items = Array.from({ length: model.count }, (_, item) => item);
    /** @param {string} words @param {string} chip @param {Test} test */
    const entry = (words, chip, test) => ({ words, chip, count: items.filter(test).length, dot: lookOf(items.find(test) ?? 0) });
    if (derived.basins) {
      return derived.basins.list.map(basin => {
        const name = model.name(basin[0]);
        return { words: `family of ${name}`, chip: `family = ${name}`, count: basin.length, dot: lookOf(basin[0]) };
      });
    }
    switch (state.colour) {
      case "category":
        return ["power", "intermediate", "precision", ""].map(name =>
          entry(name || "no category", `category = ${name || '""'}`, item => model.text("category", item) === name),
        );
      case "type": {
        const { known, greys } = model.header.looks;
        const [own, grey] = [known, greys].map(looks => looks.map(([label]) => label));
        return [...own, ...otherLabels(), ...grey, ""].map(label => {
          const chip = `label = "${label.replace(/["\\]/g, "\\$&")}"`;
          return entry(plain(label).replaceAll("_", " ") || "no label", chip, item => model.text("label", item) === label);
        });
      }
      case "stable": {
        /** @type {(value: number) => Test} */
        const is = value => item => Object.is(model.number("stable", item), value);
        return [entry("held", "stable", is(1)), entry("fell", "unstable", is(0)), entry("not simulated", "not simulated", is(NaN))];
      }
      case "family": {
        /** @type {Map<number, number[]>} */
        const families = new Map();
        for (const item of items) append(families, model.number("family", item), item);
        return [...families].map(([family, members]) => {
          const name = "g" + family;
          return { words: familyName(model.at(members[0])[0], family), chip: name, count: members.length, dot: lookOf(members[0]) };
        });
      }
      default:
        return this.ranges(state.colour, items);
    }
  }

  /** @param {string} field @param {number[]} items */
  ranges(field, items) {
    return rangesOf(field, range(field)).map(({ words, chip, above, below }, k) => {
      /** @type {Test} */
      const inside = item => model.number(field, item) >= above && model.number(field, item) < below;
      return { words, chip, count: items.filter(inside).length, dot: disc(viridis((k + 0.5) / RANGES)) };
    });
  }

  show() {
    const entries = this.entries().filter(({ count }) => count > 0);
    const endless = state.colour === "family" || derived.basins;
    if (endless) entries.sort((a, b) => b.count - a.count);
    /** @type {HTMLElement[]} */
    const buttons = entries.slice(0, endless ? MOST_ENTRIES : entries.length).map(({ words, chip, count, dot }) => {
      const attributes = { "aria-pressed": String(state.chips.includes(chip)), title: `Show only these: ${chip}` };
      return button("", () => toggleChip(chip), attributes, dotOf(dot), `${words} `, make("small", count));
    });
    const rest = entries.length - buttons.length;
    if (rest > 0) buttons.push(make("span", `and ${rest} more`, { class: "count" }));
    const chips = state.chips.map(chip =>
      button("", () => toggleChip(chip), { class: "filter", "aria-label": `Take the filter ${chip} away` }, chipWords(chip), make("b", "×")),
    );
    const all = chips.length ? [make("span", "only"), ...chips, make("output", `${derived.passing} of ${model.count}`)] : [];
    // The focus stays on the entry that was pressed.
    const focused = this.section.contains(document.activeElement) && document.activeElement?.textContent;
    this.section.replaceChildren(make("div", "", {}, ...buttons), make("div", "", {}, ...all));
    if (focused) [...this.section.querySelectorAll("button")].find(one => one.textContent === focused)?.focus();
  }
}

/** A filter in a few words. @param {string} chip */
function chipWords(chip) {
  if (chip === 'category = ""') return "no category";
  if (chip === 'label = ""') return "no label";
  if (/^label = "/.test(chip)) return plain(unquoted(chip.slice("label = ".length))).replaceAll("_", " ");
  return chip.replace(/^category = /, "").replace(/^family = /, "family of ").replace(/^stable$/, "held").replace(/^unstable$/, "fell");
}

/** The parts of the range of a number: words, filter and bounds of each. @param {string} field @param {[number, number]} range */
export function rangesOf(field, [low, high]) {
  if (!(high > low)) return [];
  // An edge is written to a hundredth to a tenth of a part, so that no two edges are the same number.
  const places = Math.min(100, Math.max(0, 1 + Math.ceil(-Math.log10((high - low) / RANGES))));
  /** @param {number} value */
  const written = value => value.toFixed(places).replace(/^-(?=[0.]*$)/, "");
  const edges = Array.from({ length: RANGES + 1 }, (_, k) => written(low + ((high - low) * k) / RANGES));
  return edges.slice(1).map((edge, k) => {
    const [first, last] = [k === 0, k === RANGES - 1];
    const bounds = [!first && `${field} ≥ ${edges[k]}`, !last && `${field} < ${edge}`].filter(bound => bound);
    const [from, to] = [edges[k], edge].map(number => number.replace("-", "−"));
    const words = first ? `below ${to}` : last ? `from ${from}` : `${from} to ${to}`;
    return { words, chip: bounds.join(" and "), above: first ? -Infinity : Number(edges[k]), below: last ? Infinity : Number(edge) };
  });
}
