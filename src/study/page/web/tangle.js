// Two landscapes: their trees face to face, with lines between corresponding minima, and a list of what moved.
"use strict";

class TanglePanel {
  constructor(section) {
    this.drawing = new Drawing(
      section,
      "Two trees face to face",
      (pen, w, h) => this.paint(pen, w, h),
      at => this.found(at),
    );
    const energies = model.sides.flatMap(side => Array.from(side.tree.energy));
    this.low = Math.min(...energies);
    this.high = Math.max(...energies);
    const margin = 0.05 * (this.high - this.low || 1);
    [this.low, this.high] = [this.low - margin, this.high + margin];
    this.children = model.sides.map(side => childrenOf(side.tree));
    watch(["hover", "selected", "level", "query", "colour", "pins", "look"], () => this.drawing.draw());
  }

  // Trees lie on their sides: energy outward, leaves toward the middle.
  scales(w, h) {
    const third = 0.38 * w;
    const part = energy => (energy - this.low) / (this.high - this.low);
    this.x = (side, energy) => (side === 0 ? third - part(energy) * (third - 14) : w - third + part(energy) * (third - 14));
    this.y = (side, node) => 30 + ((h - 60) * (model.sides[side].tree.x[node] + 0.5)) / (model.sides[side].tree.width + 1);
  }

  at(item) {
    const side = model.sideOf(item);
    const k = item - model.offsets[side];
    return [this.x(side, model.sides[side].energy[k]), this.y(side, k)];
  }

  paint(pen, w, h) {
    this.scales(w, h);
    model.sides.forEach((side, number) => {
      pen.text([number ? w - 14 : 14, 14], side.name, {
        fill: look.ink,
        size: 12.5,
        anchor: number ? "end" : "start",
        weight: 600,
      });
      for (const [value, text] of ticks(this.low, this.high, 4)) {
        const x = this.x(number, value);
        pen.path(
          [
            [x, 26],
            [x, h - 22],
          ],
          { stroke: look.faint },
        );
        pen.text([x, h - 11], text, { fill: look.soft, size: 11, anchor: "middle" });
      }
      this.tree(pen, side, number);
    });
    this.links(pen);
    for (let item = 0; item < model.count; item++) {
      pen.circle(this.at(item), 3.4, {
        fill: colourOf(item),
        stroke: look.line,
        width: 0.8,
        alpha: derived.passes[item] ? 1 : 0.2,
      });
    }
    const both = item => [item, model.partner[item]].filter(one => one !== NONE);
    const ring = (item, stroke) =>
      both(item).forEach(one => {
        const [x, y] = this.at(one);
        pen.circle([x, y], 6.5, { stroke, width: 2 });
        pen.text([x, y - 13], model.name(one), { fill: look.ink, size: 11.5, anchor: "middle", weight: 600 });
      });
    state.selected.forEach(item => ring(item, look.route));
    if (state.hover !== null) ring(state.hover, look.ink);
  }

  tree(pen, side, number) {
    const { parent, energy } = side.tree;
    const edge = number === 0 ? 6 : this.drawing.canvas.clientWidth - 6;
    for (let node = 0; node < energy.length; node++) {
      const end = parent[node] === NONE ? edge : this.x(number, energy[parent[node]]);
      pen.path(
        [
          [this.x(number, energy[node]), this.y(number, node)],
          [end, this.y(number, node)],
        ],
        { stroke: look.line, width: 1.2 },
      );
      if (node < side.count) continue;
      const ends = this.children[number][node].map(child => this.y(number, child));
      const x = this.x(number, energy[node]);
      pen.path(
        [
          [x, Math.min(...ends)],
          [x, Math.max(...ends)],
        ],
        { stroke: look.line, width: 1.2 },
      );
    }
  }

  links(pen) {
    const chosen = new Set([...state.selected, state.hover].flatMap(item => (item === null ? [] : [item, model.partner[item]])));
    for (let item = 0; item < model.offsets[1]; item++) {
      const partner = model.partner[item];
      if (partner === NONE) continue;
      const lit = chosen.has(item);
      const alpha = derived.passes[item] || derived.passes[partner] ? (lit ? 1 : 0.55) : 0.1;
      pen.path([this.at(item), this.at(partner)], { stroke: lit ? look.route : colourOf(item), width: lit ? 3 : 1.4, alpha });
    }
  }

  found([x, y]) {
    if (!this.x) return null;
    let best = { reach: 12, item: null };
    for (let item = 0; item < model.count; item++) {
      const [px, py] = this.at(item);
      const reach = Math.hypot(px - x, py - y);
      if (reach < best.reach) best = { reach, item };
    }
    return best.item === null ? null : { item: best.item };
  }
}

// What moved, vanished and appeared, the largest changes first.
function showMoved(section) {
  const { matches, vanished, appeared, merges, within } = model.header.difference;
  const [, offset] = model.offsets;
  const change = value => (value > 0 ? "+" : "") + shown(value, 3);
  const link = item =>
    make("button", model.name(item), {
      type: "button",
      class: "link",
      onclick: () => select(item),
      onpointerenter: () => window.change({ hover: item }),
    });
  const row = (...cells) =>
    make("tr", "", {}, ...cells.map(cell => (cell instanceof Node ? make("td", "", {}, cell) : make("td", cell))));
  const list = (title, head, rows) =>
    rows.length === 0
      ? []
      : [
          make("h3", title),
          make(
            "table",
            "",
            {},
            make("thead", "", {}, make("tr", "", {}, ...head.map(words => make("th", words)))),
            make("tbody", "", {}, ...rows),
          ),
        ];
  const counts = ([, by]) => Math.abs(by) > 1e-9;
  const moved = matches
    .map(match => [match, match.energies[1] - match.energies[0]])
    .filter(counts)
    .sort((a, b) => Math.abs(b[1]) - Math.abs(a[1]));
  const heights = merges
    .map(merge => [merge, merge.after === null ? Infinity : merge.after - merge.before])
    .filter(counts)
    .sort((a, b) => Math.abs(b[1]) - Math.abs(a[1]));
  const MOST = 40;
  section.append(
    make(
      "p",
      `${matches.length} minima correspond (within ${shown(within, 3)}); ${vanished.length} vanished, ${appeared.length} appeared.`,
    ),
    ...list(
      "Energies that moved most",
      ["before", "after", "energy", "change"],
      moved.slice(0, MOST).map(([m, by]) => row(link(m.before), link(offset + m.after), shown(m.energies[1]), change(by))),
    ),
    ...list(
      "Merges that moved most",
      ["between", "before", "after", "change"],
      heights
        .slice(0, MOST)
        .map(([m, by]) =>
          row(
            m.ends.map(end => "m" + end).join(", "),
            shown(m.before),
            m.after === null ? "apart" : shown(m.after),
            by === Infinity ? "" : change(by),
          ),
        ),
    ),
    ...list(
      "Vanished",
      ["minimum", "energy"],
      vanished.slice(0, MOST).map(item => row(link(item), shown(model.energy(item)))),
    ),
    ...list(
      "Appeared",
      ["minimum", "energy"],
      appeared.slice(0, MOST).map(item => row(link(offset + item), shown(model.energy(offset + item)))),
    ),
  );
}
