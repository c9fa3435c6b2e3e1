// Labelling by keyboard: a sheet of pictures, a chooser of types, and the file that `landscape label --from` reads.

import { leastSureFirst, nextAsked, placesAfter } from "./asked.js";
import { button, byId, make, memory, the } from "./dom.js";
import { save } from "./export.js";
import { FIRST_CAMERA, stamps } from "./pins.js";
import { change, model, watch } from "./state.js";
import { plain, plural, quoted } from "./text.js";

// Labels given in this browser, kept under a key that is made from the grasps themselves: files of one name share none.
const given = {
  key: "",
  /** @type {Map<number, string> | null} */
  undone: null,

  start() {
    this.key = "landscape labels " + model.sides[0].key;
    /** @type {[number, string][]} */
    let kept = [];
    try {
      kept = JSON.parse(memory.get(this.key) || "[]");
    } catch {
      /* not written by this page */
    }
    for (const [item, label] of kept) if (item < model.count && this.known(label)) model.own.set(item, label);
    watch(["labels"], () => this.show());
  },

  /** @param {string} label */
  known: label => label === "" || label === "unlisted" || model.types.has(label),

  /** The label that a person gave an item, here or in the file; empty if none did. @param {number} item */
  to: item => model.text("given", item),

  count() {
    let count = 0;
    for (let item = 0; item < model.count; item++) if (this.to(item)) count++;
    return count;
  },

  // Gives an item a label; an empty one takes it away. What the file says itself is not kept.
  /** @param {number} item @param {string} label */
  give(item, label) {
    model.own.delete(item);
    if (this.to(item) !== label) model.own.set(item, label);
    this.keep(null);
  },

  discard() {
    const undone = new Map(model.own);
    model.own.clear();
    this.keep(undone);
  },

  undo() {
    for (const [item, label] of this.undone ?? []) model.own.set(item, label);
    this.keep(null);
  },

  /** @param {Map<number, string> | null} undone */
  keep(undone) {
    this.undone = undone;
    memory.set(this.key, JSON.stringify([...model.own]));
    change({ labels: true });
  },

  // The line that tells of labels that are not in the file.
  show() {
    const line = byId("own");
    const count = model.own.size;
    line.hidden = count === 0 && !this.undone;
    if (count) {
      const words = `${plural(count, "label", "labels")} from this browser, not in the file`;
      const discard = button("discard", () => this.discard(), { class: "link", id: "labels-discard" });
      line.replaceChildren(words + " ", discard);
    } else if (this.undone) {
      line.replaceChildren("labels discarded ", button("undo", () => this.undo(), { class: "link", id: "labels-undo" }));
    }
  },
};

/** @typedef {{ label: string, head: string, detail: string, number: string, words: string }} Choice */

export class LabelSheet {
  /** @param {HTMLElement} section */
  constructor(section) {
    this.section = section;
    this.bar = make("progress");
    this.told = make("span", "", { id: "label-progress", role: "status" });
    this.grid = make("div", "", { class: "cards" });
    // A card for each item once the sheet is open, and the line of its label.
    /** @type {HTMLElement[]} */
    this.cards = [];
    /** @type {HTMLElement[]} */
    this.labels = [];
    this.items = Array.from({ length: model.count }, (_, item) => item);
    given.start();
    this.current = 0;
    // Places of items, first those of which the labeller is least sure; null if it is equally sure of all.
    this.unsure = leastSureFirst(this.items.map(item => model.certainty(item)));
    this.inOrder = this.unsure === null;
    // Places that the person has left without a label.
    /** @type {Set<number>} */
    this.left = new Set();
    this.dialog = the(HTMLDialogElement, "chooser");
    this.search = the(HTMLInputElement, "choice");
    this.choices = this.found = this.types();
    this.marked = 0;
    this.chooser();
    // The sheet follows what is given and discarded.
    watch(["labels"], () => this.cards.length && this.show());
  }

  /** @returns {Choice[]} */
  types() {
    const entries = model.header.taxonomy.map(type => ({
      label: type.name,
      head: `${type.number} ${type.name}`,
      detail: `${type.cell}: ${type.cue}`,
      number: String(type.number),
      words: [type.number, type.name, ...type.aliases, type.cell, type.cue].join(" ").toLowerCase(),
    }));
    return [
      ...entries,
      { label: "unlisted", head: "unlisted", detail: "none of the 33 types", words: "unlisted none 0", number: "0" },
    ];
  }

  open() {
    if (!this.cards.length) this.build();
    this.section.hidden = false;
    document.body.classList.add("labelling");
    this.show();
    this.go(this.inOrder ? this.current : (this.asked() ?? this.current));
  }

  close() {
    this.section.hidden = true;
    document.body.classList.remove("labelling");
  }

  build() {
    /** @param {string} text */
    const key = text => make("kbd", text);
    const rules = make("input", "", {
      type: "checkbox",
      id: "label-rules",
      onchange: () => void this.section.classList.toggle("rules", rules.checked),
    });
    const saved = () => save("labels.csv", "text/csv", this.csv());
    /** @type {(HTMLElement | string)[]} */
    const keys = [key("←"), key("→"), " move, ", key("Enter"), " or a letter: choose a type, ", key("0"), " unlisted, "];
    keys.push(key("Delete"), " no label, ", key("Space"), " next without label. ");
    const order = make(
      "select",
      "",
      { id: "label-order", onchange: () => void this.ask(order.value === "items") },
      make("option", "least sure first", { value: "unsure" }),
      make("option", "in order", { value: "items" }),
    );
    const header = make(
      "header",
      "",
      {},
      make("h2", "Label the " + plain(model.sides[0].title)),
      make("span", "", { class: "progress" }, this.bar, this.told),
      ...(this.unsure ? [make("label", "Next: ", {}, order)] : []),
      button("Next without label", () => this.next()),
      make("label", "", {}, rules, " show what the rule says"),
      button("Save labels.csv", saved, { id: "label-save", class: "main" }),
      button("Back", () => this.close(), { id: "label-end" }),
      make("span", "", { class: "keys" }, ...keys, "Labels stay in this browser; the file is what counts."),
    );
    this.cards = this.items.map((item, place) => this.card(item, place));
    this.grid.append(...this.cards);
    this.section.replaceChildren(header, this.grid);
    const seen = new IntersectionObserver(
      entries => entries.filter(entry => entry.isIntersecting).forEach(entry => this.picture(entry.target)),
      { rootMargin: "300px" },
    );
    setTimeout(() => this.cards.slice(0, 9).forEach(card => this.picture(card)));
    this.cards.forEach(card => seen.observe(card));
    this.section.addEventListener("keydown", event => this.press(event));
  }

  /** @param {number} item @param {number} place */
  card(item, place) {
    const views = [0, 1].map(() => make("canvas", "", { role: "img", "aria-hidden": "true" }));
    const object = model.text("object", item);
    const name = make("span", model.name(item) + (object ? " on " + plain(object) : ""));
    this.labels[place] = make("strong", "", { class: "label" });
    const line = make("p", "", {}, name, this.labels[place]);
    const said = model.rule(item) ? ` (${model.rule(item)})` : "";
    const rule = make("div", `rule: ${plain(model.byRule(item))}${said}`, { class: "rule" });
    const card = make("div", "", { class: "card", tabindex: 0, role: "button", "data-item": item }, ...views, line, rule);
    card.addEventListener("focus", () => {
      this.current = place;
    });
    card.addEventListener("click", () => {
      card.focus();
      this.choose();
    });
    return card;
  }

  /** Two pictures, from sides 90° apart. @param {Element} card */
  picture(card) {
    if (card.hasAttribute("data-drawn")) return;
    card.setAttribute("data-drawn", "1");
    const item = Number(card.getAttribute("data-item"));
    const [a, e, z] = FIRST_CAMERA;
    [...card.querySelectorAll("canvas")].forEach((canvas, k) => stamps.draw(canvas, item, [a + 95 * k, e + 10 * k, z]));
  }

  show() {
    this.items.forEach((item, place) => {
      const label = given.to(item);
      this.cards[place].classList.toggle("labelled", label !== "");
      this.labels[place].textContent = plain(label);
      this.cards[place].setAttribute("aria-label", `${model.name(item)} ${plain(label) || "without label"}`);
    });
    this.bar.max = this.items.length;
    const count = given.count();
    this.bar.value = count;
    this.tell();
  }

  // How many have labels, and which grasp is next, if that is not simply the one behind.
  tell() {
    const words = `${this.bar.value} of ${this.items.length} labelled`;
    const place = this.inOrder ? undefined : this.asked();
    if (place === undefined) return (this.told.textContent = words);
    const item = this.items[place];
    const reason = this.left.has(place)
      ? "left without a label before"
      : model.certainty(item) > 0
        ? "the labeller is least sure of it"
        : "the labeller has no answer for it";
    this.told.textContent = `${words}; next: ${model.name(item)}, ${reason}`;
  }

  /** @param {boolean} inOrder */
  ask(inOrder) {
    this.inOrder = inOrder;
    this.tell();
  }

  /** @param {number} place */
  labelled(place) {
    return given.to(this.items[place]) !== "";
  }

  // The place of the next item without a label, if there is one.
  asked() {
    /** @param {number} place */
    const labelled = place => this.labelled(place);
    return this.inOrder || !this.unsure
      ? nextAsked(placesAfter(this.current, this.items.length), new Set(), labelled)
      : nextAsked(this.unsure, this.left, labelled);
  }

  /** @param {string} label */
  give(label) {
    given.give(this.items[this.current], label);
    this.show();
  }

  /** @param {number} place */
  go(place) {
    this.current = Math.max(0, Math.min(this.items.length - 1, place));
    this.cards[this.current]?.focus();
  }

  next() {
    this.left.delete(this.current);
    if (!this.inOrder && !this.labelled(this.current)) this.left.add(this.current);
    const place = this.asked();
    this.tell();
    if (place !== undefined) this.go(place);
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    const { target } = event;
    if (!(target instanceof Element) || event.ctrlKey || event.metaKey || event.altKey) return;
    // In a list of choices, Escape closes the list.
    if (event.key === "Escape" && !target.closest("select")) this.close();
    if (!target.closest(".card")) return;
    const columns = getComputedStyle(this.grid).gridTemplateColumns.split(" ").length;
    /** @type {Record<string, number>} */
    const moves = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -columns, ArrowDown: columns };
    if (event.key in moves) this.go(this.current + moves[event.key]);
    else if (event.key === "Enter") this.choose();
    else if (event.key === " ") this.next();
    else if (event.key === "Delete" || event.key === "Backspace") this.give("");
    else if (event.key === "0") {
      this.give("unlisted");
      this.next();
    } else if (/^[a-z1-9]$/i.test(event.key)) this.choose(event.key);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  chooser() {
    this.search.addEventListener("input", () => this.list());
    this.dialog.addEventListener("keydown", event => {
      if (event.key === "ArrowDown") this.marked = Math.min(this.found.length - 1, this.marked + 1);
      else if (event.key === "ArrowUp") this.marked = Math.max(0, this.marked - 1);
      else if (event.key === "Enter") {
        event.preventDefault();
        return this.take(this.marked);
      } else return;
      event.preventDefault();
      this.mark();
    });
    this.dialog.addEventListener("close", () => this.cards[this.current]?.focus());
  }

  choose(text = "") {
    this.search.value = text;
    this.list();
    this.dialog.showModal();
    this.search.focus();
  }

  list() {
    const words = this.search.value
      .trim()
      .toLowerCase()
      .split(/\s+/)
      .filter(word => word);
    this.found = this.choices.filter(choice => words.every(word => choice.words.includes(word)));
    // A number means the type with that number first.
    this.found.sort((a, b) => Number(b.number === words[0]) - Number(a.number === words[0]));
    this.marked = 0;
    byId("choices").replaceChildren(
      ...this.found.map((choice, place) =>
        make("li", choice.head, { role: "option", onclick: () => this.take(place) }, make("small", choice.detail)),
      ),
    );
    this.mark();
  }

  mark() {
    [...byId("choices").children].forEach((entry, place) => {
      entry.setAttribute("aria-selected", String(place === this.marked));
      if (place === this.marked) entry.scrollIntoView({ block: "nearest" });
    });
  }

  /** @param {number} place */
  take(place) {
    if (!this.found[place]) return;
    this.dialog.close();
    this.give(this.found[place].label);
    this.next();
  }

  // A line for each grasp with a label, and one without a label where that of the file was taken away. A label that is given to
  // a minimum here is that of all its grasps; the one it has in the files is only that of most of them.
  csv() {
    const rows = this.items
      .filter(item => model.own.has(item) || (model.at(item)[0].item === "grasp" && given.to(item)))
      .flatMap(item => {
        const [side, k] = model.at(item);
        return side.members[k].split(" ").map(id => id + "," + quoted(given.to(item)));
      });
    return ["id,label", ...rows].join("\n") + "\n";
  }
}
