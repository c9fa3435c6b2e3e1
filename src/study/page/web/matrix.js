// The 33 grasp types as in the paper's table, with counts; a click on a type filters.

import { button, make } from "./dom.js";
import { change, derived, model, state, watch } from "./state.js";
import { dictionary, plain } from "./text.js";

/**
 * Numbers of grasps by type, and by cell of the table.
 *
 * @typedef {Map<number, number>} Counts
 * @typedef {Map<string, number>} Cells
 */

const FINGERS = dictionary({
  "2": "index",
  "2-3": "index, middle",
  "2-4": "to the ring",
  "2-5": "all four",
  "3": "middle",
  "3-4": "middle, ring",
  "3-5": "middle to little",
});

export class MatrixPanel {
  /** @param {HTMLElement} section */
  constructor(section) {
    this.most = 1;
    this.table = make("table", "", { class: "types" });
    this.others = make("p", "", { class: "others" });
    section.append(make("div", "", { class: "wide", tabindex: -1 }, this.table), this.others);
    this.columns = [...new Set(model.header.taxonomy.map(type => type.cell.split("/").slice(0, 3).join("/")))];
    /** @param {string} column */
    const rank = column => ["power", "intermediate", "precision"].indexOf(column.split("/")[0]);
    this.columns.sort((a, b) => rank(a) - rank(b));
    watch(["query", "labels"], () => this.show());
  }

  show() {
    /** @type {[Counts, Cells, Cells]} */
    const [counts, cells, others] = [new Map(), new Map(), new Map()];
    for (let item = 0; item < model.count; item++) {
      if (!derived.passes[item]) continue;
      /** @template Key @param {Map<Key, number>} map @param {Key} key */
      const add = (map, key) => map.set(key, (map.get(key) ?? 0) + model.number("members", item));
      const [type, cell] = [model.number("type", item), model.text("cell", item)];
      if (type) add(counts, type);
      else if (cell) add(cells, cell);
      else add(others, model.text("label", item) || "without label");
    }
    this.most = Math.max(1, ...counts.values(), ...cells.values());
    this.table.replaceChildren(this.head(), ...["abducted", "adducted"].map(thumb => this.row(thumb, counts, cells)));
    const words = [...others]
      .sort((a, b) => b[1] - a[1])
      .map(([label, count]) => `${count} ${plain(label).replaceAll("_", " ")}`);
    this.others.textContent = words.length ? "Of no type: " + words.join(", ") : "";
  }

  head() {
    /** @type {Cells} */
    const spans = new Map();
    for (const column of this.columns) {
      const category = column.split("/")[0];
      spans.set(category, (spans.get(category) ?? 0) + 1);
    }
    const categories = [...spans].map(([category, span]) => {
      const head = make("th", category, { colspan: span, scope: "colgroup" });
      head.style.borderBottomColor = model.key.get(category)?.colour ?? "";
      return head;
    });
    const details = this.columns.map(column => {
      const [, opposition, fingers] = column.split("/");
      const title = `${opposition} opposition; virtual finger 2: ${FINGERS[fingers] ?? fingers}`;
      return make("th", "", { scope: "col", title }, make("span", opposition), make("small", fingers));
    });
    const thumb = make("th", "thumb", { rowspan: 2, scope: "col" });
    return make("thead", "", {}, make("tr", "", {}, thumb, ...categories), make("tr", "", {}, ...details));
  }

  /** @param {string} thumb @param {Counts} counts @param {Cells} cells */
  row(thumb, counts, cells) {
    const columns = this.columns.map(column => {
      const cell = `${column}/${thumb}`;
      const types = model.header.taxonomy
        .filter(type => type.cell === cell)
        .map(({ number, name, cue }) => {
          const count = counts.get(number) ?? 0;
          return this.chip(count ? `${number}·${count}` : String(number), `${number} ${name}: ${cue}`, `type = ${number}`, count);
        });
      const shared = cells.get(cell) ?? 0;
      const words = `${shared} of this cell, but not of one type only`;
      return make("td", "", {}, ...types, ...(shared ? [this.chip(`? ${shared}`, words, `cell = "${cell}"`, shared)] : []));
    });
    return make("tr", "", {}, make("th", thumb, { scope: "row" }), ...columns);
  }

  /** @param {string} text @param {string} title @param {string} query @param {number} count */
  chip(text, title, query, count) {
    const pressed = state.query === query;
    const chip = button(text, () => change({ query: pressed ? "" : query }), {
      class: count ? "chip" : "chip none",
      title,
      "aria-pressed": String(pressed),
    });
    chip.style.setProperty("--share", String(Math.sqrt(count / this.most)));
    return chip;
  }
}
