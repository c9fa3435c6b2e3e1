// The table: the items that pass the filter, sorted. Only the rows in view are in the document.

import { button, headingOf, make } from "./dom.js";
import { lookOf } from "./looks.js";
import { dotOf } from "./pen.js";
import { change, derived, looked, model, passing, select, state, watch } from "./state.js";
import { percent, shown } from "./text.js";
import { EVIDENCE_WORDS, explain, meaning } from "./words.js";

const ROW = 27;

/**
 * A column of numbers has their values, by which it is sorted; others are sorted by their texts.
 *
 * @typedef {{ name: string, words: string, width: string, text: (item: number) => string, value?: (item: number) => number }} Column
 */

export class TablePanel {
  /** @param {HTMLElement} section */
  constructor(section) {
    const [side] = model.sides;
    /** @type {number[]} */
    this.items = [];
    this.columns = this.chosen(side);
    this.head = make("div", "", { class: "row head", role: "row" });
    this.body = make("div", "", { class: "rows", role: "rowgroup" });
    this.scroll = make("div", "", { class: "scroll", role: "grid", tabindex: 0, "aria-label": "Table" }, this.head, this.body);
    this.count = make("span", "", { class: "count" });
    headingOf(section).append(this.count);
    section.append(this.scroll);
    this.scroll.addEventListener("scroll", () => this.rows());
    this.scroll.addEventListener("keydown", event => this.key(event));
    new ResizeObserver(() => this.rows()).observe(this.scroll);
    watch(["query", "sort", "level", "labels"], () => this.order());
    watch(["selected", "pins", "hover"], () => this.mark());
    watch(["colour", "look"], () => this.rows());
    for (const column of this.columns) this.head.append(this.heading(column));
    // Without a column of words the numbers share the width.
    const widths = this.columns.map(({ width }) => (side.label ? width : `minmax(${width}, 1fr)`));
    this.scroll.style.setProperty("--columns", widths.join(" "));
  }

  /** @param {import("./data.js").Side} side */
  chosen(side) {
    const grasps = side.space?.kind === "pose";
    /** @type {(name: string, words: string, width: string, digits?: number, text?: (value: number) => string) => Column} */
    const number = (name, words, width, digits, text = value => shown(value, digits)) => {
      /** @param {number} item */
      const value = item => model.number(name, item);
      return { name, words, width, value, text: item => text(value(item)) };
    };
    /** @type {(name: string, words: string, width: string, text: (item: number) => string) => Column} */
    const text = (name, words, width, text) => ({ name, words, width, text });
    const all = [
      text("name", side.item === "grasp" ? "grasp" : "minimum", "5em", item => model.name(item)),
      side.label && text("label", "type", "minmax(6.5em, 1fr)", item => model.text("label", item)),
      number("energy", "energy", "4.4em"),
      side.family && number("family", "family", "3.5em", 1),
      side.member_count && number("members", grasps ? "grasps" : "found", "3.8em", 1),
      side.epsilon && number("epsilon", "ε", "3.4em", 3),
      model.knows("stable") && number("stable", "held", "3.4em", 1, held => ["fell", "held"][held] ?? "–"),
      side.tree && number("joins", "joins at", "4.4em"),
      side.tree?.tested && number("support", "support", "4.2em", 2, percent),
      side.tree && text("evidence", "evidence", "5.2em", item => model.evidence(item)),
      side.object && side.object.texts.length > 1 && text("object", "object", "minmax(6em, .6fr)", item => model.text("object", item)),
    ];
    return all.filter(column => !!column);
  }

  /** @param {Column} column */
  heading(column) {
    const sort = () => change({ sort: state.sort === column.name ? "-" + column.name : column.name });
    const attributes = { role: "columnheader", class: column.value ? "number" : false, "data-name": column.name };
    return make("span", "", attributes, explain(button(column.words, sort), meaning(column.name)));
  }

  order() {
    const name = state.sort.replace(/^-/, "");
    const column = this.columns.find(column => column.name === name) ?? this.columns[1];
    const sign = state.sort.startsWith("-") ? -1 : 1;
    const value = column.name === "name" ? (/** @type {number} */ item) => item : column.value;
    const rows = passing().map(item => ({ item, number: value ? value(item) : 0, text: value ? "" : column.text(item) }));
    rows.sort((a, b) => {
      const unknown = Number(Number.isNaN(a.number)) - Number(Number.isNaN(b.number));
      return unknown || sign * (a.number - b.number || a.text.localeCompare(b.text)) || a.item - b.item;
    });
    this.items = rows.map(({ item }) => item);
    for (const cell of this.head.children) {
      const own = cell.getAttribute("data-name") === column.name;
      cell.setAttribute("aria-sort", own ? (sign > 0 ? "ascending" : "descending") : "none");
    }
    derived.first = this.items[0] ?? 0;
    const [shown, all] = [this.items.length, model.count];
    this.count.textContent = shown === all ? ` ${all}` : ` ${shown} of ${all}`;
    this.scroll.setAttribute("aria-rowcount", String(this.items.length));
    this.rows();
  }

  rows() {
    this.body.style.height = ROW * this.items.length + "px";
    const first = Math.max(0, Math.floor(this.scroll.scrollTop / ROW) - 4);
    const last = Math.min(this.items.length, first + Math.ceil(this.scroll.clientHeight / ROW) + 9);
    this.body.replaceChildren(...this.items.slice(first, last).map((item, k) => this.row(item, first + k)));
    this.mark();
  }

  // Which rows are under the pointer, chosen, pinned, or shown while none of them is chosen.
  mark() {
    for (const row of this.body.children) {
      const item = Number(row.getAttribute("data-item"));
      row.classList.toggle("hover", item === looked());
      row.classList.toggle("selected", state.selected.includes(item));
      row.classList.toggle("pinned", state.pins.includes(item));
      row.setAttribute("aria-selected", String(state.selected.includes(item)));
    }
  }

  /** @param {number} item @param {number} place */
  row(item, place) {
    const cells = this.columns.map(column => {
      const cell = make("span", column.text(item), { role: "gridcell", class: column.value ? "number" : false });
      if (column.name === "name") cell.prepend(dotOf(lookOf(item)));
      if (column.name === "label") cell.title = this.aboutLabel(item);
      if (column.name === "evidence" && model.evidence(item)) cell.title = EVIDENCE_WORDS[model.evidence(item)];
      return cell;
    });
    const attributes = {
      class: "row",
      role: "row",
      "data-item": item,
      "aria-rowindex": place + 1,
      onclick: () => select(item),
      onpointerenter: () => change({ hover: item }),
      onpointerleave: () => change({ hover: null }),
    };
    const row = make("div", "", attributes, ...cells);
    row.style.top = place * ROW + "px";
    return row;
  }

  /** Where a label comes from, and the types that fit best by the rule. @param {number} item */
  aboutLabel(item) {
    const from = model.own.has(item) ? "given in this browser" : model.text("given", item) ? "given by a person, in the file" : "by the rule";
    const rule = model.rule(item);
    const words = `${model.text("label", item)}, ${from}`;
    return rule ? `${words}; best by the rule: ${rule}` : words;
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const place = this.items.indexOf(state.hover ?? state.selected.at(-1) ?? -1);
    const page = Math.floor(this.scroll.clientHeight / ROW) - 2;
    /** @type {Record<string, number>} */
    const moves = {
      ArrowDown: place + 1,
      ArrowUp: place - 1,
      PageDown: place + page,
      PageUp: place - page,
      Home: 0,
      End: Infinity,
    };
    if (event.key in moves) {
      const to = Math.max(0, Math.min(this.items.length - 1, moves[event.key]));
      change({ hover: this.items[to] ?? null });
      const top = to * ROW;
      if (top < this.scroll.scrollTop) this.scroll.scrollTop = top;
      else if (top > this.scroll.scrollTop + this.scroll.clientHeight - 3 * ROW)
        this.scroll.scrollTop = top - this.scroll.clientHeight + 3 * ROW;
    } else if ((event.key === "Enter" || event.key === " ") && state.hover !== null) select(state.hover);
    else return;
    event.preventDefault();
  }
}
