// The disconnectivity graph: energy upward, a leaf for each minimum, a bar where branches meet.

import { NONE } from "./data.js";
import { addTools, button, headingOf, make, tool } from "./dom.js";
import { familyColour, look, lookOf, range } from "./looks.js";
import { Drawing, EDGE, nearest, OF_ITEMS, rings } from "./pen.js";
import { childrenOf, routeInTree, searchesAcross } from "./route.js";
import { change, derived, looked, model, state, watch } from "./state.js";
import { plural, shown } from "./text.js";
import { EVIDENCE_WORDS } from "./words.js";

// Above the tree there is room for the handle of the level line while it is off.
const CROWN = 30;
const CHIP = { height: 22, parked: 13 };

/**
 * @typedef {import("./pen.js").Pen} Pen
 * @typedef {import("./pen.js").Ring} Ring
 */

export class TreePanel {
  /** @param {HTMLElement} section @param {import("./data.js").Landscape} side */
  constructor(section, side) {
    this.side = side;
    this.zoom = { from: 0, to: 1 };
    this.whole = false;
    this.children = childrenOf(side.tree);
    this.heading = headingOf(section);
    // What is shown: nodes, columns of leaves, energies, and the size of the picture.
    this.inside = new Uint8Array();
    this.first = this.columns = this.unit = this.hidden = 0;
    this.low = this.high = this.bottom = this.top = 0;
    this.box = [0, 0];
    this.drawing = new Drawing(
      section,
      "Disconnectivity graph",
      OF_ITEMS,
      (pen, w, h) => this.paint(pen, w, h),
      pen => this.mark(pen),
      at => this.found(at),
    );
    this.all = tool("All", "Show or hide the highest merges", () => {
      this.whole = !this.whole;
      this.measure();
      this.drawing.draw();
    });
    this.enter();
    this.tools(section);
    watch(["branch"], () => {
      this.enter();
      this.drawing.draw();
    });
    this.moves();
    this.handle = this.levelHandle(section);
  }

  // Shows what hangs below the chosen branch, or the whole tree: which nodes that are, and the places of its leaves.
  enter() {
    const { tree, count } = this.side;
    const { branch } = state;
    this.inside = new Uint8Array(tree.energy.length).fill(branch === null ? 1 : 0);
    const waiting = branch === null ? [] : [branch];
    for (const node of waiting) {
      this.inside[node] = 1;
      waiting.push(...this.children[node]);
    }
    const leaves = Array.from(tree.order).filter(leaf => this.inside[leaf]);
    const places = leaves.map(leaf => tree.x[leaf]);
    this.drawing.order = leaves;
    this.first = branch === null ? 0 : Math.min(...places);
    this.columns = branch === null ? tree.width + 1 : Math.max(...places) - this.first + 1;
    this.zoom = { from: 0, to: 1 };
    this.heading.textContent = branch === null ? "Disconnectivity graph" : `A branch: ${leaves.length} of ${count} minima`;
    this.measure();
  }

  // The energies that are shown. A few high merges may squash the others: then those are cut off.
  measure() {
    const { side, inside } = this;
    const energies = side.energy.filter((_, item) => inside[item]);
    const merges = Array.from(side.tree.energy).filter((_, node) => node >= side.count && inside[node]);
    merges.sort((a, b) => a - b);
    this.low = energies.length ? energies.reduce((a, b) => Math.min(a, b)) : 0;
    this.high = merges.at(-1) ?? Math.max(...energies, this.low + 1);
    const usual = merges[Math.floor((merges.length * 19) / 20)] ?? this.high;
    const squashed = this.high - this.low >= 2 * (usual - this.low) && usual < this.high;
    const cut = squashed && !this.whole;
    this.all.hidden = !squashed;
    this.hidden = cut ? merges.filter(height => height > usual).length : 0;
    const top = cut ? usual : this.high;
    const margin = 0.06 * (top - this.low || 1);
    this.bottom = this.low - margin;
    this.top = top + margin;
  }

  /** @param {number} node */
  x(node) {
    const place = (this.side.tree.x[node] - this.first + 0.5) / this.columns - this.zoom.from;
    return EDGE.left + place * this.columns * this.unit;
  }

  /** @param {number} energy */
  y(energy) {
    const height = this.box[1] - CROWN - EDGE.bottom;
    return CROWN + (height * (this.top - Math.min(energy, this.top))) / (this.top - this.bottom);
  }

  /** @param {number} y */
  energyAt(y) {
    return this.top - ((y - CROWN) / (this.box[1] - CROWN - EDGE.bottom)) * (this.top - this.bottom);
  }

  /** @param {Pen} pen @param {number} w @param {number} h */
  paint(pen, w, h) {
    this.box = [w, h];
    this.unit = (w - EDGE.left - EDGE.right) / ((this.zoom.to - this.zoom.from) * this.columns);
    const chip = this.chip();
    /** @param {number} y */
    const behindChip = y => Math.abs(y - chip) < CHIP.height / 2 + 6;
    pen.rows(this.bottom, this.top, Math.max(3, h / 90), energy => this.y(energy), w - EDGE.right, behindChip);
    pen.label([2, h - 8], this.side.energy_label);
    this.branches(pen);
    this.route(pen);
    this.leaves(pen);
    if (state.level !== null) pen.line(EDGE.left - 6, chip, w - EDGE.right, chip, { stroke: look.accent, width: 1.5 });
    if (this.hidden) {
      const words = `${plural(this.hidden, "merge", "merges")} above ${shown(this.top, 3)} not drawn`;
      pen.label([w - EDGE.right, CHIP.parked], words, { anchor: "end" });
    }
    this.placeHandle();
  }

  /** Colour and strength of what hangs below a node. @param {number} node */
  branchStyle(node) {
    const { tree, count } = this.side;
    const family = state.level === null || tree.energy[node] > state.level ? null : this.familyBelow(node);
    const bound = node >= count && model.header.evidence[tree.evidence[node]] === "chain";
    return {
      stroke: family ?? (bound ? look.pale : look.line),
      width: Math.min(family ? 2.6 : 2, Math.max(0.7, 0.25 * this.unit)),
      dash: bound ? [6, 4] : [],
    };
  }

  /** @param {number} node */
  familyBelow(node) {
    while (node >= this.side.count) node = this.children[node][0];
    return familyColour(node);
  }

  /** @param {Pen} pen */
  branches(pen) {
    const { tree, count } = this.side;
    const { parent, energy } = tree;
    for (let node = 0; node < energy.length; node++) {
      if (!this.inside[node]) continue;
      const [x, y] = [this.x(node), this.y(energy[node])];
      const above = node === state.branch ? NONE : parent[node];
      const own = this.branchStyle(node);
      const style = above === NONE ? own : this.branchStyle(above);
      const end = above === NONE ? this.y(this.top) - 4 : this.y(energy[above]);
      if (x > -50 && x < this.box[0] + 50)
        pen.line(x, y, x, end, { ...style, stroke: own.stroke === look.line ? style.stroke : own.stroke });
      if (node < count || energy[node] > this.top) continue;
      const ends = this.children[node].map(child => this.x(child));
      pen.line(Math.min(...ends) - own.width / 2, y, Math.max(...ends) + own.width / 2, y, own);
      this.support(pen, node, [x, y]);
    }
  }

  // A dot on a merge: filled if a lower way is unlikely, hollow if it is likely or the merge was not searched.
  /** @param {Pen} pen @param {number} node @param {number[]} at */
  support(pen, node, at) {
    if (!this.side.tree.tested) return;
    const share = this.side.tree.support[node];
    const fill = share >= 0.95 ? look.ink : share >= 0.7 ? look.pale : look.paper;
    pen.circle(at, Math.min(3.6, Math.max(1.6, 0.2 * this.unit)), { fill, stroke: look.line });
  }

  /** The way between the two chosen minima: up to the pass, and down. @param {Pen} pen */
  route(pen) {
    const { parent, energy } = this.side.tree;
    const { nodes, top } = routeInTree(this.side.tree, state.selected);
    for (const node of nodes) {
      const above = parent[node];
      if (!this.inside[node] || !this.inside[above]) continue;
      const [x, y] = [this.x(node), this.y(energy[above])];
      const corners = [
        [x, this.y(energy[node])],
        [x, y],
        [this.x(above), y],
      ];
      pen.path(corners, { stroke: look.route, width: 3 });
    }
    if (top !== null && this.inside[top]) pen.circle([this.x(top), this.y(energy[top])], 5, { fill: look.route, stroke: look.paper, width: 1.5 });
  }

  /** @param {number} item */
  at(item) {
    return [this.x(item), this.y(this.side.energy[item])];
  }

  /** @param {number} item */
  radius(item) {
    const [, most] = range("members");
    const one = Math.min(14, Math.max(2.4, 0.55 * this.unit)) / Math.sqrt(most || 1);
    return Math.max(Math.min(4.5, Math.max(2, 0.4 * this.unit)), one * Math.sqrt(model.number("members", item)));
  }

  /** @param {Pen} pen */
  leaves(pen) {
    const order = this.drawing.order.slice().sort((a, b) => model.number("members", b) - model.number("members", a));
    for (const item of order) {
      const at = this.at(item);
      if (at[0] < EDGE.left - 20 || at[0] > this.box[0] + 20) continue;
      const alpha = derived.passes[item] ? 1 : 0.18;
      pen.symbol(at, this.radius(item), lookOf(item), { stroke: look.line, width: this.unit > 5 ? 1 : 0.6, alpha });
    }
    if (this.unit >= 26) for (const item of order) this.name(pen, item, { fill: look.soft });
  }

  /** @param {Pen} pen @param {number} item @param {import("./pen.js").TextStyle} style */
  name(pen, item, style) {
    const [x, y] = this.at(item);
    pen.text([x, y + this.radius(item) + 11], model.name(item), { size: 11, anchor: "middle", ...style });
  }

  /** @param {Pen} pen */
  mark(pen) {
    /** @param {Ring} ring */
    const inside = ring => rings((item, stroke, width, gap) => this.inside[item] && ring(item, stroke, width, gap));
    inside((item, stroke, width, gap) => pen.circle(this.at(item), this.radius(item) + gap, { stroke, width }));
    inside(item => this.name(pen, item, { fill: look.ink, weight: 600 }));
  }

  /** @param {number[]} at @returns {import("./pen.js").Found | null} */
  found([x, y]) {
    const { tree, count } = this.side;
    /** @type {(distance: (node: number) => number) => (node: number) => number} */
    const only = distance => node => (this.inside[node] ? distance(node) : Infinity);
    // The line upward from a node, to the bar in which it ends.
    const stem = only(node => {
      const top = tree.parent[node] === NONE ? this.top : tree.energy[tree.parent[node]];
      const along = y <= this.y(tree.energy[node]) && y >= this.y(top);
      return along ? Math.abs(this.x(node) - x) : Infinity;
    });
    const leaf = only(item => Math.hypot(this.x(item) - x, this.y(this.side.energy[item]) - y));
    const item = nearest(count, 14, leaf) ?? nearest(count, 5, stem);
    if (item !== null) return { item };
    const bar = only(node => {
      const off = Math.abs(this.y(tree.energy[node]) - y);
      if (off >= 5) return Infinity;
      const ends = this.children[node].map(child => this.x(child));
      const along = x > Math.min(...ends) - 4 && x < Math.max(...ends) + 4;
      return along ? off : Infinity;
    });
    const merges = tree.energy.length - count;
    const merge = nearest(merges, 5, k => bar(count + k)) ?? nearest(merges, 4, k => stem(count + k));
    if (merge === null) return null;
    const click = count + merge === state.branch ? [] : ["click to see only what hangs below"];
    return { item: null, lines: [...this.told(count + merge), ...click], act: () => change({ branch: count + merge, hover: null }) };
  }

  /** What is said of a merge. @param {number} node */
  told(node) {
    const { tree } = this.side;
    return [
      `merge at ${shown(tree.energy[node])}`,
      EVIDENCE_WORDS[model.header.evidence[tree.evidence[node]]],
      tree.tested ? searchesAcross(tree, node) : "",
    ].filter(line => line);
  }

  /** @param {HTMLElement} section */
  tools(section) {
    const level = tool("Level", "Show or hide the level line, which divides the tree into families", () =>
      this.setLevel(state.level === null ? (this.top + this.low) / 2 : null),
    );
    watch(["level"], () => level.setAttribute("aria-pressed", String(state.level !== null)));
    const zoom = button("", () => change({ branch: state.branch === null ? this.branchOfLooked() : null }), { id: "tree-branch" });
    watch(["branch", "level", "hover", "selected", "query", "sort"], () => {
      const whole = state.branch === null;
      const family = whole && this.familyOf(looked()) !== null;
      const words = family
        ? `Zoom into this family: that of ${model.name(looked())}`
        : whole
          ? `Zoom into the branch of ${model.name(looked())}`
          : "Show the whole tree";
      zoom.textContent = whole ? "Zoom in" : "Whole tree";
      zoom.title = words;
      zoom.setAttribute("aria-label", words);
      zoom.disabled = whole && this.branchOfLooked() === null;
    });
    addTools(
      section,
      this.all,
      zoom,
      level,
      tool("−", "Show more of the tree", () => this.enlarge(1.6)),
      tool("+", "Enlarge the tree", () => this.enlarge(1 / 1.6)),
    );
  }

  /** The node on top of the family of an item, if it has more than one member. @param {number} item */
  familyOf(item) {
    const top = model.count && derived.basins ? derived.basins.top[item] : NONE;
    return top !== NONE && top >= this.side.count ? top : null;
  }

  // The branch that the button shows: the family of the item that is looked at, else what its next merge joins.
  branchOfLooked() {
    const next = this.side.merge[looked()] ?? NONE;
    return this.familyOf(looked()) ?? (next === NONE ? null : next);
  }

  /** @param {number} factor */
  enlarge(factor) {
    const { from, to } = this.zoom;
    const half = Math.min(0.5, Math.max(((to - from) / 2) * factor, 2 / (this.columns + 2)));
    this.show((from + to) / 2 - half, 2 * half);
  }

  /** Shows a part of the width, each from 0 to 1. @param {number} from @param {number} width */
  show(from, width) {
    from = Math.min(1 - width, Math.max(0, from));
    this.zoom = { from, to: from + width };
    this.drawing.draw();
  }

  // The wheel enlarges, and dragging moves the part that is shown.
  moves() {
    const { canvas } = this.drawing;
    /** @param {WheelEvent} event */
    const wheel = event => {
      if (!event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      this.enlarge(event.deltaY > 0 ? 1.15 : 1 / 1.15);
    };
    canvas.addEventListener("wheel", wheel, { passive: false });
    /** @type {number | null} */
    let last = null;
    canvas.addEventListener("pointerdown", event => {
      last = event.clientX;
      this.drawing.dragged = false;
    });
    canvas.addEventListener("pointermove", event => {
      if (!event.buttons || last === null || Math.abs(event.clientX - last) < 3) return;
      const width = this.zoom.to - this.zoom.from;
      this.drawing.dragged = width < 1;
      this.show(this.zoom.from - ((event.clientX - last) / this.box[0]) * width, width);
      last = event.clientX;
    });
  }

  /** @param {number | null} level */
  setLevel(level) {
    change({ level: level === null ? null : Math.min(this.top, Math.max(this.low, level)) });
  }

  /** The handle of the level line: dragged, or moved by the arrow keys. @param {HTMLElement} section */
  levelHandle(section) {
    const handle = make("div", "", {
      class: "level",
      role: "slider",
      tabindex: 0,
      title: "Drag to divide the tree into families",
      "aria-label": "Level that divides the tree into families",
      "aria-orientation": "vertical",
    });
    section.append(handle);
    /** @param {PointerEvent} event */
    const move = event => {
      const box = this.drawing.canvas.getBoundingClientRect();
      this.setLevel(this.energyAt(event.clientY - box.top));
    };
    handle.addEventListener("pointerdown", event => {
      handle.setPointerCapture(event.pointerId);
      handle.onpointermove = move;
      event.preventDefault();
      handle.focus();
    });
    handle.addEventListener("pointerup", () => {
      handle.onpointermove = null;
    });
    handle.addEventListener("keydown", event => {
      const step = (this.top - this.low) / (event.shiftKey ? 20 : 100);
      const from = state.level ?? this.top;
      /** @type {Record<string, number | null>} */
      const moves = { ArrowUp: from + step, ArrowDown: from - step, Home: this.low, End: this.top, Escape: null, Delete: null };
      if (!(event.key in moves)) return;
      event.preventDefault();
      event.stopPropagation();
      this.setLevel(moves[event.key]);
    });
    return handle;
  }

  // Height of the middle of the handle: at the level, or above the tree.
  chip() {
    return state.level === null ? CHIP.parked : Math.min(this.y(state.level), this.box[1] - EDGE.bottom);
  }

  placeHandle() {
    const level = state.level ?? this.top;
    const off = state.level === null;
    this.handle.style.top = this.drawing.canvas.offsetTop + this.chip() - CHIP.height / 2 + "px";
    this.handle.classList.toggle("off", off);
    this.handle.textContent = off ? "level" : shown(level, 3);
    const families = off ? "off" : `${shown(level, 3)}, ${derived.basins?.list.length} families of several minima`;
    for (const [name, value] of [
      ["min", this.low],
      ["max", this.top],
      ["now", level],
      ["text", families],
    ])
      this.handle.setAttribute("aria-value" + name, String(value));
  }
}
