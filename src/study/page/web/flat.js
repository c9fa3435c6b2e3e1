// What is not a hand: the map of a surface of one or two coordinates, or parallel coordinates of any space.
"use strict";

class FlatPanel {
  constructor(section) {
    const [side] = model.sides;
    this.side = side;
    this.dimensions = side.space.dimensions;
    const kind = this.dimensions === 1 ? "line" : this.dimensions === 2 ? "map" : "parallel";
    section.querySelector("h2").textContent = kind === "parallel" ? "Coordinates" : side.title.split(":")[0];
    this.map = side.space.contours;
    const painters = { line: this.line, map: this.plane, parallel: this.parallel };
    this.drawing = new Drawing(
      section,
      "The surface with its minima and ways",
      (pen, w, h) => painters[kind].call(this, pen, w, h),
      at => this.found(at),
    );
    this.bounds();
    watch(["hover", "selected", "level", "query", "colour", "step", "look"], () => this.drawing.draw());
  }

  // Range of each coordinate: that of the map, or of everything there is.
  bounds() {
    const n = this.dimensions;
    this.low = this.map ? this.map.low : new Array(n).fill(Infinity);
    this.high = this.map ? this.map.high : new Array(n).fill(-Infinity);
    if (this.map) return;
    for (const list of [this.side.coordinates, this.side.ways.coordinates]) {
      list.forEach((value, k) => {
        this.low[k % n] = Math.min(this.low[k % n], value);
        this.high[k % n] = Math.max(this.high[k % n], value);
      });
    }
    for (let axis = 0; axis < n; axis++) {
      const margin = 0.06 * (this.high[axis] - this.low[axis] || 1);
      this.low[axis] -= margin;
      this.high[axis] += margin;
    }
  }

  // Heights of contour lines: closer together where minima and passes are.
  levels() {
    const passes = Array.from(this.side.ways.height);
    const low = Math.min(...this.side.energy);
    const high = Math.max(...passes, ...this.side.energy, low + 1e-9);
    return Array.from({ length: 16 }, (_, k) => low + (1.5 * (high - low) * (k + 0.5)) / 15);
  }

  plane(pen, w, h) {
    const [dx, dy] = [this.high[0] - this.low[0], this.high[1] - this.low[1]];
    const scale = Math.min((w - EDGE.left - EDGE.right) / dx, (h - 2 * EDGE.top - EDGE.bottom) / dy);
    const left = EDGE.left + (w - EDGE.left - EDGE.right - scale * dx) / 2;
    const bottom = h - EDGE.bottom - (h - EDGE.top - EDGE.bottom - scale * dy) / 2;
    this.at = x => [left + scale * (x[0] - this.low[0]), bottom - scale * (x[1] - this.low[1])];
    if (this.map) this.contours(pen);
    for (const [axis, end] of [
      [0, 1],
      [1, 0],
    ]) {
      for (const [value, text] of ticks(this.low[axis], this.high[axis], 5)) {
        const corner = [this.low[0], this.low[1]];
        corner[axis] = value;
        const [x, y] = this.at(corner);
        pen.text(end ? [x, y + 13] : [x - 8, y], text, { fill: look.soft, size: 11.5, anchor: end ? "middle" : "end" });
      }
    }
    const [a, b] = [this.at(this.low), this.at(this.high)];
    pen.path([a, [b[0], a[1]], b, [a[0], b[1]]], { stroke: look.pale, close: true });
    this.ways(pen);
    this.dots(pen);
  }

  // Contour lines by marching squares, coloured by height.
  contours(pen) {
    const { columns, energy, low, high } = this.map;
    const levels = this.levels();
    const place = (column, row) =>
      this.at([low[0] + ((high[0] - low[0]) * column) / (columns - 1), low[1] + ((high[1] - low[1]) * row) / (columns - 1)]);
    levels.forEach((level, number) => {
      const colour = viridis(number / (levels.length - 1));
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
          for (let k = 0; k + 1 < cuts.length; k += 2)
            pen.path([cuts[k], cuts[k + 1]], { stroke: colour, width: 1.2, alpha: 0.85 });
        }
      }
    });
  }

  rows(way) {
    const { starts, coordinates } = this.side.ways;
    const rows = [];
    for (let row = starts[way]; row < starts[way + 1]; row++)
      rows.push(coordinates.subarray(row * this.dimensions, (row + 1) * this.dimensions));
    return rows;
  }

  ways(pen) {
    const chosen = new Set(routeOf(state.selected)?.ways ?? []);
    this.side.ways.a.forEach((_, way) => {
      const lit = chosen.has(way);
      pen.path(
        this.rows(way).map(x => this.at(x)),
        { stroke: lit ? look.route : look.line, width: lit ? 3.5 : 1.4 },
      );
    });
    const route = routeOf(state.selected);
    if (route) pen.circle(this.at(onRoute(route, state.step)), 6, { fill: look.route, stroke: look.paper, width: 2 });
  }

  dots(pen) {
    for (let item = 0; item < this.side.count; item++) {
      const at = this.at(model.coordinates(item));
      pen.circle(at, 6, { fill: colourOf(item), stroke: look.ink, alpha: derived.passes[item] ? 1 : 0.2 });
      const strong = state.selected.includes(item) || state.hover === item;
      if (strong) pen.circle(at, 9.5, { stroke: state.hover === item ? look.ink : look.route, width: 2.5 });
      pen.text([at[0], at[1] - 15], model.name(item), { fill: look.ink, size: 12, anchor: "middle", weight: strong ? 700 : 500 });
    }
  }

  line(pen, w, h) {
    const energies = this.map ? Array.from(this.map.energy) : [];
    const levels = this.levels();
    const [low, high] = [Math.min(...this.side.energy), levels.at(-1)];
    const margin = 0.08 * (high - low);
    const x = value => EDGE.left + ((w - EDGE.left - EDGE.right) * (value - this.low[0])) / (this.high[0] - this.low[0]);
    const y = energy => EDGE.top + ((h - EDGE.top - EDGE.bottom) * (high - Math.min(energy, high))) / (high - low + margin);
    this.at = point => [x(point[0]), y(this.height(point[0]))];
    for (const [value, text] of ticks(this.low[0], this.high[0], 6))
      pen.text([x(value), h - 12], text, { fill: look.soft, size: 11.5, anchor: "middle" });
    const curve = energies.map((energy, k) => [
      x(this.low[0] + ((this.high[0] - this.low[0]) * k) / (energies.length - 1)),
      y(energy),
    ]);
    pen.path(curve, { stroke: look.line, width: 1.8 });
    this.ways(pen);
    this.dots(pen);
  }

  // The energy of a surface of one coordinate, from its map or the nearest minimum.
  height(value) {
    if (!this.map) return this.side.energy[0];
    const place = ((value - this.low[0]) / (this.high[0] - this.low[0])) * (this.map.columns - 1);
    const k = Math.max(0, Math.min(this.map.columns - 2, Math.floor(place)));
    return this.map.energy[k] + (place - k) * (this.map.energy[k + 1] - this.map.energy[k]);
  }

  parallel(pen, w, h) {
    const n = this.dimensions;
    const x = axis => 24 + ((w - 48) * axis) / Math.max(1, n - 1);
    const y = (value, axis) =>
      EDGE.top + ((h - EDGE.top - EDGE.bottom) * (this.high[axis] - value)) / (this.high[axis] - this.low[axis]);
    this.at = point => [x(0), y(point[0], 0)];
    this.lines = item => Array.from(model.coordinates(item), (value, axis) => [x(axis), y(value, axis)]);
    for (let axis = 0; axis < n; axis++) {
      pen.path(
        [
          [x(axis), EDGE.top],
          [x(axis), h - EDGE.bottom],
        ],
        { stroke: look.faint },
      );
      if (n <= 40) pen.text([x(axis), h - 12], String(axis + 1), { fill: look.soft, size: 11, anchor: "middle" });
    }
    for (let item = 0; item < this.side.count; item++)
      pen.path(this.lines(item), { stroke: colourOf(item), width: 1.2, alpha: derived.passes[item] ? 0.75 : 0.1 });
    for (const item of new Set([...state.selected, ...(state.hover === null ? [] : [state.hover])])) {
      pen.path(this.lines(item), { stroke: item === state.hover ? look.ink : look.route, width: 2.5 });
    }
  }

  found([x, y]) {
    if (!this.at) return null;
    let best = { reach: 14, item: null };
    for (let item = 0; item < this.side.count; item++) {
      const places = this.lines ? this.lines(item) : [this.at(model.coordinates(item))];
      for (const [px, py] of places) {
        const reach = Math.hypot(px - x, py - y);
        if (reach < best.reach) best = { reach, item };
      }
    }
    return best.item === null ? null : { item: best.item };
  }
}
