// The disconnectivity graph: energy upward, a leaf for each minimum, a bar where branches meet.
"use strict";

const EDGE = { left: 58, right: 14, top: 16, bottom: 30 };

class TreePanel {
  constructor(section) {
    this.side = model.sides[0];
    this.zoom = { from: 0, to: 1 };
    this.whole = false;
    this.drawing = new Drawing(
      section,
      "Disconnectivity graph",
      (pen, w, h) => this.paint(pen, w, h),
      at => this.found(at),
    );
    this.byPlace = Array.from(this.side.tree.order);
    this.measure();
    this.tools(section);
    this.levelHandle(section);
    this.keys();
    this.children = childrenOf(this.side.tree);
    watch(["hover", "selected", "level", "query", "colour", "pins", "look"], () => this.drawing.draw());
  }

  // The energies that are shown. A few high merges may squash the others: then those are cut off.
  measure() {
    const { energy } = this.side.tree;
    const merges = Array.from(energy.subarray(this.side.count)).sort((a, b) => a - b);
    this.low = this.side.energy.length ? this.side.energy.reduce((a, b) => Math.min(a, b)) : 0;
    this.high = merges.at(-1) ?? Math.max(...this.side.energy, this.low + 1);
    const usual = merges[Math.floor((merges.length * 19) / 20)] ?? this.high;
    this.cut = !this.whole && this.high - this.low >= 2 * (usual - this.low) && usual < this.high;
    this.hidden = this.cut ? merges.filter(height => height > usual).length : 0;
    this.top = this.cut ? usual : this.high;
    const margin = 0.06 * (this.top - this.low || 1);
    [this.bottom, this.top] = [this.low - margin, this.top + margin];
  }

  scales(w, h) {
    const { from, to } = this.zoom;
    const width = Math.max(1e-9, this.side.tree.width);
    const inner = w - EDGE.left - EDGE.right;
    this.box = [w, h];
    this.unit = inner / ((to - from) * (width + 1));
    this.x = node => EDGE.left + inner * (((this.side.tree.x[node] + 0.5) / (width + 1) - from) / (to - from));
    this.y = energy =>
      EDGE.top + (h - EDGE.top - EDGE.bottom) * ((this.top - Math.min(energy, this.top)) / (this.top - this.bottom));
    this.energyAt = y => this.top - ((y - EDGE.top) / (h - EDGE.top - EDGE.bottom)) * (this.top - this.bottom);
  }

  paint(pen, w, h) {
    this.scales(w, h);
    this.axis(pen, w, h);
    this.branches(pen);
    this.route(pen);
    this.leaves(pen);
    this.levelLine(pen, w);
    if (this.hidden) {
      const words = `${this.hidden} ${this.hidden === 1 ? "merge" : "merges"} above ${shown(this.top, 3)} not drawn`;
      pen.text([w - EDGE.right, 8], words, { fill: look.soft, size: 11, anchor: "end" });
    }
    this.placeHandle();
  }

  axis(pen, w, h) {
    for (const [value, text] of ticks(this.bottom, this.top, Math.max(3, h / 90))) {
      const y = this.y(value);
      pen.path(
        [
          [EDGE.left - 6, y],
          [w - EDGE.right, y],
        ],
        { stroke: look.faint },
      );
      pen.text([EDGE.left - 10, y], text, { fill: look.soft, size: 11.5, anchor: "end" });
    }
    pen.text([2, h - 8], this.side.energy_label, { fill: look.soft, size: 11.5 });
  }

  // Colour and strength of the branch below a node.
  branchStyle(node) {
    const { tree, count } = this.side;
    const basin = derived.basins && node < tree.energy.length ? this.basinColour(node) : null;
    const bound = node >= count && this.header(tree.evidence[node]) === "chain";
    return {
      stroke: basin ?? (bound ? look.pale : look.line),
      width: Math.min(basin ? 2.6 : 2, Math.max(0.7, 0.25 * this.unit)),
      dash: bound ? [6, 4] : [],
    };
  }

  header(kind) {
    return model.header.evidence[kind];
  }

  basinColour(node) {
    if (this.side.tree.energy[node] > state.level) return null;
    let leaf = node;
    while (leaf >= this.side.count) leaf = this.children[leaf][0];
    const colour = derived.basins.colour[leaf];
    return colour === CATEGORY[""] ? null : colour;
  }

  branches(pen) {
    const { tree, count } = this.side;
    const { parent, energy } = tree;
    for (let node = 0; node < energy.length; node++) {
      const x = this.x(node);
      const above = parent[node];
      const style = this.branchStyle(above === NONE ? node : above);
      const own = this.branchStyle(node);
      const end = above === NONE ? this.y(this.top) - 4 : this.y(energy[above]);
      if (x > -50 && x < this.box[0] + 50) {
        pen.path(
          [
            [x, this.y(energy[node])],
            [x, end],
          ],
          { ...style, stroke: own.stroke === look.line ? style.stroke : own.stroke },
        );
      }
      if (node < count || energy[node] > this.top) continue;
      const ends = this.children[node].map(child => this.x(child));
      const [from, to] = [Math.min(...ends), Math.max(...ends)];
      pen.path(
        [
          [from - own.width / 2, this.y(energy[node])],
          [to + own.width / 2, this.y(energy[node])],
        ],
        own,
      );
    }
    this.supports(pen);
  }

  supports(pen) {
    const { tree, count } = this.side;
    if (!tree.resamplings) return;
    for (let node = count; node < tree.energy.length; node++) {
      const share = tree.support[node];
      if (Number.isNaN(share) || tree.energy[node] > this.top) continue;
      const fill = share >= 0.95 ? look.ink : share >= 0.7 ? look.pale : look.paper;
      pen.circle([this.x(node), this.y(tree.energy[node])], Math.min(3.6, Math.max(1.6, 0.2 * this.unit)), {
        fill,
        stroke: look.line,
      });
    }
  }

  // The way between the two chosen minima: up to the pass, and down.
  route(pen) {
    const route = routeInTree(
      this.side.tree,
      state.selected.map(item => item),
    );
    const style = { stroke: look.route, width: 3 };
    for (const node of route.nodes) {
      const above = this.side.tree.parent[node];
      const [x, y] = [this.x(node), this.y(this.side.tree.energy[above])];
      pen.path(
        [
          [x, this.y(this.side.tree.energy[node])],
          [x, y],
          [this.x(above), y],
        ],
        style,
      );
    }
    if (route.top !== null)
      pen.circle([this.x(route.top), this.y(this.side.tree.energy[route.top])], 5, {
        fill: look.route,
        stroke: look.paper,
        width: 1.5,
      });
  }

  radius(item) {
    const [, most] = range("members");
    const one = Math.min(14, Math.max(2.4, 0.55 * this.unit)) / Math.sqrt(most || 1);
    return Math.max(Math.min(4.5, Math.max(2, 0.4 * this.unit)), one * Math.sqrt(model.number("members", item)));
  }

  leaves(pen) {
    const order = this.byPlace.slice().sort((a, b) => model.number("members", b) - model.number("members", a));
    for (const item of order) {
      const at = [this.x(item), this.y(this.side.energy[item])];
      if (at[0] < EDGE.left - 20 || at[0] > this.box[0] + 20) continue;
      const passes = derived.passes[item];
      const alpha = passes ? 1 : 0.18;
      pen.circle(at, this.radius(item), { fill: colourOf(item), stroke: look.line, width: this.unit > 5 ? 1 : 0.4, alpha });
    }
    for (const item of state.pins) this.ring(pen, item, look.soft, 1.5, 3);
    for (const item of state.selected) this.ring(pen, item, look.route, 2.5, 3);
    if (state.hover !== null) this.ring(pen, state.hover, look.ink, 2, 4);
    this.captions(pen, order);
  }

  ring(pen, item, stroke, width, gap) {
    if (model.sideOf(item) !== 0) return;
    pen.circle([this.x(item), this.y(this.side.energy[item])], this.radius(item) + gap, { stroke, width });
  }

  captions(pen, order) {
    const named =
      this.unit >= 26 ? order : [...new Set([...state.selected, ...state.pins, ...(state.hover === null ? [] : [state.hover])])];
    for (const item of named) {
      const strong = state.selected.includes(item) || item === state.hover;
      const at = [this.x(item), this.y(this.side.energy[item]) + this.radius(item) + 11];
      pen.text(at, model.name(item), {
        fill: strong ? look.ink : look.soft,
        size: 11,
        anchor: "middle",
        weight: strong ? 600 : 400,
      });
    }
  }

  levelLine(pen, w) {
    if (state.level === null) return;
    const y = this.y(state.level);
    pen.path(
      [
        [EDGE.left - 6, y],
        [w - EDGE.right, y],
      ],
      { stroke: look.accent, width: 1.5 },
    );
  }

  found([x, y]) {
    const { tree, count } = this.side;
    let best = { reach: 14, item: null };
    for (let item = 0; item < count; item++) {
      const reach = Math.hypot(this.x(item) - x, this.y(this.side.energy[item]) - y);
      if (reach < best.reach) best = { reach, item };
    }
    for (let item = 0; item < count && best.item === null; item++) {
      const top = tree.parent[item] === NONE ? this.top : tree.energy[tree.parent[item]];
      const along = y <= this.y(this.side.energy[item]) && y >= this.y(top);
      if (along && Math.abs(this.x(item) - x) < 5) return { item };
    }
    if (best.item !== null) return { item: best.item };
    for (let node = count; node < tree.energy.length; node++) {
      const ends = this.children[node].map(child => this.x(child));
      if (Math.abs(this.y(tree.energy[node]) - y) < 5 && x > Math.min(...ends) - 4 && x < Math.max(...ends) + 4)
        return this.merge(node);
    }
    return null;
  }

  merge(node) {
    const { tree } = this.side;
    const share = tree.support[node];
    return {
      item: null,
      lines: [
        `merge at ${shown(tree.energy[node])}`,
        EVIDENCE_WORDS[this.header(tree.evidence[node])],
        Number.isNaN(share) ? null : `found in ${Math.round(100 * share)} % of ${tree.resamplings} resampled trees`,
      ].filter(line => line),
    };
  }

  tools(section) {
    const zoom = factor => {
      const [middle, half] = [(this.zoom.from + this.zoom.to) / 2, ((this.zoom.to - this.zoom.from) / 2) * factor];
      const width = Math.min(0.5, Math.max(half, 2 / (this.side.count + 2)));
      const from = Math.min(1 - 2 * width, Math.max(0, middle - width));
      this.zoom = { from, to: from + 2 * width };
      this.drawing.draw();
    };
    const button = (text, label, onclick) => make("button", text, { type: "button", "aria-label": label, title: label, onclick });
    const tools = make(
      "div",
      "",
      { class: "panel-tools" },
      button("Level", "Show or hide the level line, which divides the tree into families", () =>
        this.setLevel(state.level === null ? (this.top + this.low) / 2 : null),
      ),
      button("−", "Show more of the tree", () => zoom(1.6)),
      button("+", "Enlarge the tree", () => zoom(1 / 1.6)),
    );
    if (this.hidden) {
      tools.prepend(
        button("All", "Show or hide the highest merges", () => {
          this.whole = !this.whole;
          this.measure();
          this.drawing.draw();
        }),
      );
    }
    section.querySelector("h2").after(tools);
    const canvas = this.drawing.canvas;
    canvas.addEventListener(
      "wheel",
      event => {
        if (!event.ctrlKey && !event.metaKey) return;
        event.preventDefault();
        zoom(event.deltaY > 0 ? 1.15 : 1 / 1.15);
      },
      { passive: false },
    );
    let last = null;
    canvas.addEventListener("pointerdown", event => {
      last = event.clientX;
      this.drawing.dragged = false;
    });
    canvas.addEventListener("pointermove", event => {
      if (!event.buttons || last === null || Math.abs(event.clientX - last) < 3) return;
      const width = this.zoom.to - this.zoom.from;
      const from = Math.min(1 - width, Math.max(0, this.zoom.from - ((event.clientX - last) / this.box[0]) * width));
      [this.zoom, last, this.drawing.dragged] = [{ from, to: from + width }, event.clientX, width < 1];
      this.drawing.draw();
    });
  }

  setLevel(level) {
    const clamped = level === null ? null : Math.min(this.top, Math.max(this.low, level));
    change({ level: clamped });
  }

  // The handle of the level line: dragged, or moved by the arrow keys.
  levelHandle(section) {
    this.handle = make("div", "", {
      class: "level",
      role: "slider",
      tabindex: 0,
      "aria-label": "Level that divides the tree into families",
      "aria-orientation": "vertical",
    });
    section.append(this.handle);
    const move = event => {
      const box = this.drawing.canvas.getBoundingClientRect();
      this.setLevel(this.energyAt(event.clientY - box.top));
    };
    this.handle.addEventListener("pointerdown", event => {
      this.handle.setPointerCapture(event.pointerId);
      this.handle.onpointermove = move;
      event.preventDefault();
      this.handle.focus();
    });
    this.handle.addEventListener("pointerup", () => {
      this.handle.onpointermove = null;
    });
    this.handle.addEventListener("keydown", event => {
      const step = (this.top - this.low) / (event.shiftKey ? 20 : 100);
      const from = state.level ?? this.top;
      const moves = { ArrowUp: from + step, ArrowDown: from - step, Home: this.low, End: this.top, Escape: null, Delete: null };
      if (!(event.key in moves)) return;
      event.preventDefault();
      event.stopPropagation();
      this.setLevel(moves[event.key]);
    });
  }

  placeHandle() {
    const level = state.level ?? this.top;
    this.handle.style.top = this.drawing.canvas.offsetTop + this.y(level) - 11 + "px";
    this.handle.classList.toggle("off", state.level === null);
    this.handle.textContent = state.level === null ? "level" : shown(level, 3);
    this.handle.setAttribute("aria-valuemin", this.low);
    this.handle.setAttribute("aria-valuemax", this.top);
    this.handle.setAttribute("aria-valuenow", level);
    const several = derived.basins?.list.length;
    this.handle.setAttribute(
      "aria-valuetext",
      state.level === null ? "off" : `${shown(level, 3)}, ${several} families of several minima`,
    );
  }

  keys() {
    this.drawing.canvas.addEventListener("keydown", event => {
      const place = this.byPlace.indexOf(state.hover ?? state.selected.at(-1) ?? -1);
      const moves = {
        ArrowLeft: Math.max(0, place - 1),
        ArrowRight: Math.min(this.side.count - 1, place + 1),
        Home: 0,
        End: this.side.count - 1,
      };
      if (event.key in moves) change({ hover: this.byPlace[moves[event.key]] });
      else if ((event.key === "Enter" || event.key === " ") && state.hover !== null) select(state.hover);
      else return;
      event.preventDefault();
    });
  }
}

const EVIDENCE_WORDS = {
  saddle: "a verified saddle: the true pass",
  seam: "the verified lowest point of a seam",
  path: "the top of a relaxed path",
  chain: "an upper bound: the pass may lie lower",
  none: "no path",
};

function childrenOf({ parent }) {
  const children = Array.from(parent, () => []);
  parent.forEach((above, node) => {
    if (above !== NONE) children[above].push(node);
  });
  return children;
}

// The nodes on the way up from each of two leaves to the node where they meet, and that node.
function routeInTree({ parent }, [a, b]) {
  if (a === undefined || b === undefined || a >= parent.length || b >= parent.length) return { nodes: [], top: null };
  const up = node => {
    const nodes = [node];
    while (parent[nodes.at(-1)] !== NONE) nodes.push(parent[nodes.at(-1)]);
    return nodes;
  };
  const [from, to] = [up(a), up(b)];
  const top = from.find(node => to.includes(node)) ?? null;
  if (top === null) return { nodes: [], top };
  return { nodes: [...from.slice(0, from.indexOf(top)), ...to.slice(0, to.indexOf(top))], top };
}
