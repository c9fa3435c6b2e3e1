// The barrier graph: minima near each other are joined by low passes. Places and widths were computed with the picture.

import { headingOf } from "./dom.js";
import { look, lookOf } from "./looks.js";
import { Drawing, nearest, OF_ITEMS, rings } from "./pen.js";
import { routeOf } from "./route.js";
import { derived, model, state } from "./state.js";

/** @typedef {import("./pen.js").Pen} Pen */

export class GraphPanel {
  /** @param {HTMLElement} section @param {import("./data.js").Landscape} side */
  constructor(section, side) {
    this.side = side;
    const { graph } = side;
    this.circles = Array.from(graph.minimum);
    this.ofFamilies = graph.of === "families";
    if (this.ofFamilies) headingOf(section).textContent = "Barrier graph of the families";
    this.circleOf = new Map(this.circles.map((item, circle) => [item, circle]));
    this.order = Array.from(graph.a, (_, line) => line);
    this.order.sort((p, q) => graph.is_lowest[p] - graph.is_lowest[q] || graph.height[q] - graph.height[p]);
    // Circles are shown so many times larger, about their middle at the centre of the panel, or turned by a right angle.
    this.scale = 1;
    this.turned = false;
    this.middle = this.centre = [0, 0];
    this.drawing = new Drawing(
      section,
      "Barrier graph",
      OF_ITEMS,
      (pen, w, h) => this.paint(pen, w, h),
      pen => this.mark(pen),
      at => this.found(at),
    );
    this.drawing.order = this.circles;
  }

  /** The circle that stands for an item: its own, or that of its family. @param {number} item */
  circle(item) {
    if (model.sideOf(item) !== 0) return undefined;
    if (this.circleOf.has(item) || !this.ofFamilies) return this.circleOf.get(item);
    const circle = this.circles.findIndex(other => this.side.family[other] === this.side.family[item]);
    return circle < 0 ? undefined : circle;
  }

  /** Fits the circles into the panel, turned by a right angle if they are then larger. @param {number} w @param {number} h */
  scales(w, h) {
    const { x, y, radius } = this.side.graph;
    /** @param {Float32Array} places */
    const bounds = places => [
      Math.min(...places.map((place, k) => place - radius[k])),
      Math.max(...places.map((place, k) => place + radius[k])),
    ];
    const [[left, right], [top, bottom]] = [bounds(x), bounds(y)];
    /** @param {number} width @param {number} height */
    const fit = (width, height) => Math.min(1.2, (w - 24) / (width || 1), (h - 44) / (height || 1));
    const [upright, turned] = [fit(right - left, bottom - top), fit(bottom - top, right - left)];
    this.turned = turned > 1.12 * upright;
    this.scale = this.turned ? turned : upright;
    this.middle = [(left + right) / 2, (top + bottom) / 2];
    this.centre = [w / 2, h / 2 + 8];
  }

  /** @param {number} circle */
  at(circle) {
    const { x, y } = this.side.graph;
    const [dx, dy] = [this.scale * (x[circle] - this.middle[0]), this.scale * (y[circle] - this.middle[1])];
    return this.turned ? [this.centre[0] - dy, this.centre[1] + dx] : [this.centre[0] + dx, this.centre[1] + dy];
  }

  /** @param {number} circle */
  radius(circle) {
    return Math.max(2.5, this.scale * this.side.graph.radius[circle]);
  }

  /** @param {Pen} pen @param {number} w @param {number} h */
  paint(pen, w, h) {
    this.scales(w, h);
    const route = this.route();
    for (const line of this.order) this.line(pen, line, false);
    for (const line of route) this.line(pen, line, true);
    this.circles.forEach((item, circle) => {
      const alpha = derived.passes[item] ? 1 : 0.18;
      pen.symbol(this.at(circle), this.radius(circle), lookOf(item), { stroke: look.line, alpha });
    });
  }

  /** @param {Pen} pen */
  mark(pen) {
    rings((item, stroke, width, gap) => {
      const circle = this.circle(item);
      if (circle === undefined) return;
      const [x, y] = this.at(circle);
      const reach = this.radius(circle) + gap;
      pen.circle([x, y], reach, { stroke, width });
      const text = this.ofFamilies ? "g" + this.side.family[item] : model.name(item);
      // The name stands above the circle, or below where there is no room.
      const place = [Math.min(2 * this.centre[0] - 14, Math.max(14, x)), y - reach < 20 ? y + reach + 9 : y - reach - 8];
      pen.label(place, text, { fill: look.ink, anchor: "middle", weight: 600 });
    });
  }

  /** @param {Pen} pen @param {number} line @param {boolean} lit */
  line(pen, line, lit) {
    const { graph } = this.side;
    const ends = [graph.a[line], graph.b[line]];
    const bound = model.header.evidence[graph.evidence[line]] === "chain";
    const isLowest = graph.is_lowest[line];
    const faded = ends.every(end => derived.passes[graph.minimum[end]]) ? 1 : 0.2;
    const [[x1, y1], [x2, y2]] = ends.map(end => this.at(end));
    pen.line(x1, y1, x2, y2, {
      stroke: lit ? look.route : isLowest ? look.line : look.pale,
      width: lit ? 4 : Math.max(0.6, this.scale * graph.width[line] * (isLowest ? 1 : 0.8)),
      dash: bound && !lit ? [6, 5] : [],
      alpha: lit ? 1 : (isLowest ? 0.9 : 0.6) * faded,
    });
  }

  // The lines of the way between the chosen minima.
  route() {
    /** @type {Set<number>} */
    const lines = new Set();
    const { a, b } = this.side.graph;
    const minima = routeOf(state.selected)?.minima ?? [];
    for (let k = 1; k < minima.length; k++) {
      const ends = [this.circle(minima[k - 1]), this.circle(minima[k])];
      const line = a.findIndex((end, number) => ends.includes(end) && ends.includes(b[number]) && ends[0] !== ends[1]);
      if (line >= 0) lines.add(line);
    }
    return lines;
  }

  /** @param {number[]} at */
  found([x, y]) {
    const circle = nearest(this.circles.length, 10, circle => {
      const [cx, cy] = this.at(circle);
      return Math.hypot(cx - x, cy - y) - this.radius(circle);
    });
    return circle === null ? null : { item: this.circles[circle] };
  }
}
