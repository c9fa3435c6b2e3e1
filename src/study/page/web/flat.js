// What is not a hand: the map of a surface of one or two coordinates, or parallel coordinates of any space.

import { headingOf } from "./dom.js";
import { colourOf, look, lookOf, viridis } from "./looks.js";
import { Drawing, EDGE, nearest, OF_ITEMS, rings } from "./pen.js";
import { onRoute, routeOf } from "./route.js";
import { derived, model, state } from "./state.js";
import { plain, shown, ticks } from "./text.js";

/**
 * @typedef {import("./data.js").Contours} Contours
 * @typedef {import("./pen.js").Pen} Pen
 */

export class FlatPanel {
  /**
   * @param {HTMLElement} section
   * @param {import("./data.js").Side} side
   * @param {import("./data.js").Ways} paths
   */
  constructor(section, side, paths) {
    this.side = side;
    this.paths = paths;
    this.dimensions = side.space.dimensions;
    const paint = [this.line, this.plane][this.dimensions - 1] ?? this.parallel;
    headingOf(section).textContent = this.dimensions > 2 ? "Coordinates" : plain(side.title.split(":")[0]);
    this.map = side.space.contours;
    /** @type {number[][][][] | null} */
    this.contourLines = null;
    const [low, high] = this.bounds();
    this.low = low;
    this.high = high;
    // Where a point is painted, and in parallel coordinates the line of an item.
    /** @type {(x: ArrayLike<number>) => number[]} */
    this.at = () => [NaN, NaN];
    /** @type {((item: number) => number[][]) | null} */
    this.lines = null;
    this.drawing = new Drawing(
      section,
      "The surface with its minima and ways",
      [...OF_ITEMS, "step"],
      (pen, w, h) => paint.call(this, pen, w, h),
      pen => this.mark(pen),
      at => this.found(at),
    );
  }

  /** Range of each coordinate: that of the map, or of everything there is. @returns {[number[], number[]]} */
  bounds() {
    if (this.map) return [this.map.low, this.map.high];
    const n = this.dimensions;
    const [low, high] = [new Array(n).fill(Infinity), new Array(n).fill(-Infinity)];
    for (const list of [this.side.coordinates ?? [], this.paths.coordinates]) {
      list.forEach((value, k) => {
        low[k % n] = Math.min(low[k % n], value);
        high[k % n] = Math.max(high[k % n], value);
      });
    }
    for (let axis = 0; axis < n; axis++) {
      const margin = 0.06 * (high[axis] - low[axis] || 1);
      low[axis] -= margin;
      high[axis] += margin;
    }
    return [low, high];
  }

  // Heights of contour lines: closer together where minima and passes are.
  levels() {
    const passes = Array.from(this.paths.height);
    const low = Math.min(...this.side.energy);
    const high = Math.max(...passes, ...this.side.energy, low + 1e-9);
    return Array.from({ length: 16 }, (_, k) => low + (1.5 * (high - low) * (k + 0.5)) / 15);
  }

  /** @param {Pen} pen @param {number} w @param {number} h */
  plane(pen, w, h) {
    const [dx, dy] = [this.high[0] - this.low[0], this.high[1] - this.low[1]];
    const scale = Math.min((w - EDGE.left - EDGE.right) / dx, (h - 2 * EDGE.top - EDGE.bottom) / dy);
    const left = EDGE.left + (w - EDGE.left - EDGE.right - scale * dx) / 2;
    const bottom = h - EDGE.bottom - (h - EDGE.top - EDGE.bottom - scale * dy) / 2;
    this.at = x => [left + scale * (x[0] - this.low[0]), bottom - scale * (x[1] - this.low[1])];
    if (this.map) this.contours(pen, this.map);
    const [[x0, y0], [x1, y1]] = [this.at(this.low), this.at(this.high)];
    pen.columns(this.low[0], this.high[0], 5, value => this.at([value, 0])[0], y0 + 13);
    for (const [value, text] of ticks(this.low[1], this.high[1], 5))
      pen.label([x0 - 8, this.at([0, value])[1]], text, { anchor: "end" });
    const frame = [
      [x0, y0],
      [x1, y0],
      [x1, y1],
      [x0, y1],
    ];
    pen.path(frame, { stroke: look.pale, close: true });
    this.ways(pen);
    this.dots(pen);
  }

  // Contour lines by marching squares: for each height, pairs of points of the plane. They are computed once.
  /** @param {Contours} map */
  cuts({ columns, energy, low, high }) {
    /** @param {number} column @param {number} row */
    const place = (column, row) => [
      low[0] + ((high[0] - low[0]) * column) / (columns - 1),
      low[1] + ((high[1] - low[1]) * row) / (columns - 1),
    ];
    return this.levels().map(level => {
      const pairs = [];
      for (let row = 0; row + 1 < columns; row++) {
        for (let column = 0; column + 1 < columns; column++) {
          const corners = [
            [column, row],
            [column + 1, row],
            [column + 1, row + 1],
            [column, row + 1],
          ];
          const values = corners.map(([c, r]) => energy[r * columns + c] - level);
          const cuts = [];
          for (let k = 0; k < 4; k++) {
            const [p, q] = [values[k], values[(k + 1) % 4]];
            if (p < 0 === q < 0 || !Number.isFinite(p) || !Number.isFinite(q)) continue;
            const t = p / (p - q);
            const [[c0, r0], [c1, r1]] = [corners[k], corners[(k + 1) % 4]];
            cuts.push(place(c0 + t * (c1 - c0), r0 + t * (r1 - r0)));
          }
          for (let k = 0; k + 1 < cuts.length; k += 2) pairs.push([cuts[k], cuts[k + 1]]);
        }
      }
      return pairs;
    });
  }

  /** @param {Pen} pen @param {Contours} map */
  contours(pen, map) {
    const lines = (this.contourLines ??= this.cuts(map));
    lines.forEach((pairs, number) =>
      pen.segments(
        pairs.map(pair => pair.map(x => this.at(x))),
        { stroke: viridis(number / (lines.length - 1)), width: 1.2, alpha: 0.85 },
      ),
    );
  }

  /** The points of a way. @param {number} way @returns {ArrayLike<number>[]} */
  rows(way) {
    const { starts, coordinates } = this.paths;
    /** @type {ArrayLike<number>[]} */
    const rows = [];
    for (let row = starts[way]; row < starts[way + 1]; row++)
      rows.push(coordinates.subarray(row * this.dimensions, (row + 1) * this.dimensions));
    if (this.dimensions > 1) return rows;
    // On a line the way follows the curve, also between its points.
    return rows.flatMap((row, k) =>
      k ? [0.2, 0.4, 0.6, 0.8, 1].map(t => [rows[k - 1][0] + t * (row[0] - rows[k - 1][0])]) : [row],
    );
  }

  /** @param {Pen} pen */
  ways(pen) {
    const route = routeOf(state.selected);
    const chosen = new Set(route?.ways);
    this.paths.a.forEach((_, way) => {
      const style = chosen.has(way) ? { stroke: look.route, width: 3.5 } : { stroke: look.line, width: 1.4 };
      pen.path(
        this.rows(way).map(x => this.at(x)),
        style,
      );
    });
    if (route) pen.circle(this.at(onRoute(route, state.step)), 6, { fill: look.route, stroke: look.paper, width: 2 });
  }

  /** @param {Pen} pen */
  dots(pen) {
    // Names stand beside the dots while these are few.
    const few = this.side.count <= 40;
    for (let item = 0; item < this.side.count; item++) {
      const alpha = derived.passes[item] ? 1 : 0.2;
      pen.symbol(this.at(model.coordinates(item)), 6, lookOf(item), { stroke: look.ink, alpha });
      if (few) this.name(pen, item, 500);
    }
  }

  /** @param {Pen} pen @param {number} item @param {number} weight */
  name(pen, item, weight) {
    const [x, y] = this.at(model.coordinates(item));
    const below = this.dimensions > 1 ? -17 : 19;
    pen.text([x, y + below], model.name(item), { fill: look.ink, size: 12, anchor: "middle", weight });
  }

  /** @param {Pen} pen */
  mark(pen) {
    const { lines } = this;
    if (lines) {
      rings((item, stroke, width) => pen.path(lines(item), { stroke, width }));
      rings(item => pen.label(lines(item)[0], model.name(item), { fill: look.ink, anchor: "middle", weight: 600 }));
    } else {
      rings((item, stroke, width) => pen.circle(this.at(model.coordinates(item)), 9.5, { stroke, width }));
      rings(item => this.name(pen, item, 700));
    }
  }

  /** @param {Pen} pen @param {number} w @param {number} h */
  line(pen, w, h) {
    const [low, high] = [Math.min(...this.side.energy), Math.max(...this.levels())];
    const margin = 0.08 * (high - low);
    /** @type {import("./pen.js").Scale} */
    const x = value => EDGE.left + ((w - EDGE.left - EDGE.right) * (value - this.low[0])) / (this.high[0] - this.low[0]);
    /** @type {import("./pen.js").Scale} */
    const y = energy => EDGE.top + ((h - EDGE.top - EDGE.bottom) * (high - Math.min(energy, high))) / (high - low + margin);
    this.at = point => [x(point[0]), y(this.height(point[0]))];
    pen.rows(low - margin, high, Math.max(3, h / 90), y, w - EDGE.right);
    pen.columns(this.low[0], this.high[0], 6, x, h - 12);
    pen.label([2, h - 12], this.side.energy_label);
    const energies = this.map ? Array.from(this.map.energy) : [];
    /** @param {number} k */
    const across = k => this.low[0] + ((this.high[0] - this.low[0]) * k) / (energies.length - 1);
    // The curve leaves the picture at the top.
    const inside = energies.map((energy, k) => [energy, k]).filter(([energy]) => energy <= high);
    pen.path(
      inside.map(([energy, k]) => [x(across(k)), y(energy)]),
      { stroke: look.line, width: 1.8 },
    );
    this.ways(pen);
    this.dots(pen);
  }

  /** The energy of a surface of one coordinate, from its map or the nearest minimum. @param {number} value */
  height(value) {
    if (!this.map) return this.side.energy[0];
    const place = ((value - this.low[0]) / (this.high[0] - this.low[0])) * (this.map.columns - 1);
    const k = Math.max(0, Math.min(this.map.columns - 2, Math.floor(place)));
    return this.map.energy[k] + (place - k) * (this.map.energy[k + 1] - this.map.energy[k]);
  }

  /** @param {Pen} pen @param {number} w @param {number} h */
  parallel(pen, w, h) {
    const n = this.dimensions;
    /** @param {number} axis */
    const x = axis => 30 + ((w - 60) * axis) / Math.max(1, n - 1);
    /** @param {number} value @param {number} axis */
    const y = (value, axis) =>
      EDGE.top + ((h - EDGE.top - EDGE.bottom) * (this.high[axis] - value)) / (this.high[axis] - this.low[axis]);
    this.at = point => [x(0), y(point[0], 0)];
    /** @param {number} item */
    const lines = item => Array.from(model.coordinates(item), (value, axis) => [x(axis), y(value, axis)]);
    this.lines = lines;
    for (let axis = 0; axis < n; axis++) {
      pen.line(x(axis), EDGE.top, x(axis), h - EDGE.bottom, { stroke: look.faint });
      if (n <= 40) pen.label([x(axis), h - 10], String(axis + 1), { anchor: "middle" });
      if (n > 12) continue;
      pen.label([x(axis), EDGE.top - 8], shown(this.high[axis], 3), { anchor: "middle" });
      pen.label([x(axis), h - EDGE.bottom + 6], shown(this.low[axis], 3), { anchor: "middle" });
    }
    for (let item = 0; item < this.side.count; item++)
      pen.path(lines(item), { stroke: colourOf(item), width: 1.2, alpha: derived.passes[item] ? 0.75 : 0.1 });
  }

  /** @param {number[]} at */
  found([x, y]) {
    const item = nearest(this.side.count, 14, item => {
      const places = this.lines ? this.lines(item) : [this.at(model.coordinates(item))];
      return Math.min(...places.map(([px, py]) => Math.hypot(px - x, py - y)));
    });
    return item === null ? null : { item };
  }
}
