// The barrier graph: minima near each other are joined by low passes. Places and widths were computed with the picture.
"use strict";

class GraphPanel {
  constructor(section) {
    this.side = model.sides[0];
    const { graph } = this.side;
    if (graph.of === "groups") section.querySelector("h2").textContent = "Barrier graph of the groups";
    this.circleOf = new Map(Array.from(graph.minimum, (item, circle) => [item, circle]));
    this.drawing = new Drawing(
      section,
      "Barrier graph",
      (pen, w, h) => this.paint(pen, w, h),
      at => this.found(at),
    );
    watch(["hover", "selected", "level", "query", "colour", "pins", "look"], () => this.drawing.draw());
  }

  // The circle that stands for an item: its own, or that of its group.
  circle(item) {
    const own = this.circleOf.get(item);
    if (own !== undefined || this.side.graph.of === "minima" || model.sideOf(item) !== 0) return own;
    const group = this.side.group[item];
    return Array.from(this.side.graph.minimum).findIndex(other => this.side.group[other] === group);
  }

  // Fits the circles into the panel, turned by a right angle if they are then larger.
  scales(w, h) {
    const { x, y, radius } = this.side.graph;
    const bounds = places => [
      Math.min(...places.map((place, k) => place - radius[k])),
      Math.max(...places.map((place, k) => place + radius[k])),
    ];
    const [[left, right], [top, bottom]] = [bounds(x), bounds(y)];
    const fit = (width, height) => Math.min(1.2, (w - 24) / (width || 1), (h - 44) / (height || 1));
    const [upright, turned] = [fit(right - left, bottom - top), fit(bottom - top, right - left)];
    this.turned = turned > 1.12 * upright;
    this.scale = this.turned ? turned : upright;
    this.middle = [(left + right) / 2, (top + bottom) / 2];
    this.centre = [w / 2, h / 2 + 8];
  }

  at(circle) {
    const { x, y } = this.side.graph;
    const [dx, dy] = [this.scale * (x[circle] - this.middle[0]), this.scale * (y[circle] - this.middle[1])];
    return this.turned ? [this.centre[0] - dy, this.centre[1] + dx] : [this.centre[0] + dx, this.centre[1] + dy];
  }

  radius(circle) {
    return Math.max(2.5, this.scale * this.side.graph.radius[circle]);
  }

  paint(pen, w, h) {
    this.scales(w, h);
    const { graph } = this.side;
    const route = this.route();
    const order = Array.from(graph.a, (_, line) => line).sort(
      (p, q) => graph.in_tree[p] - graph.in_tree[q] || graph.height[q] - graph.height[p],
    );
    for (const line of order) this.line(pen, line, route.has(line));
    for (const line of route) this.line(pen, line, true);
    graph.minimum.forEach((item, circle) => {
      const alpha = derived.passes[item] ? 1 : 0.18;
      pen.circle(this.at(circle), this.radius(circle), { fill: colourOf(item), stroke: look.line, alpha });
    });
    const ring = (item, stroke, width, gap) => {
      const circle = this.circle(item);
      if (circle === undefined || circle < 0) return;
      pen.circle(this.at(circle), this.radius(circle) + gap, { stroke, width });
      const [x, y] = this.at(circle);
      const text = graph.of === "groups" ? "g" + this.side.group[item] : model.name(item);
      pen.text([x, y - this.radius(circle) - gap - 8], text, { fill: look.ink, size: 11.5, anchor: "middle", weight: 600 });
    };
    for (const item of state.pins) ring(item, look.soft, 1.5, 3);
    for (const item of state.selected) ring(item, look.route, 2.5, 3);
    if (state.hover !== null) ring(state.hover, look.ink, 2, 4);
  }

  line(pen, line, lit) {
    const { graph } = this.side;
    const bound = model.header.evidence[graph.evidence[line]] === "chain";
    const inTree = graph.in_tree[line];
    const faded = derived.passes[graph.minimum[graph.a[line]]] && derived.passes[graph.minimum[graph.b[line]]] ? 1 : 0.2;
    pen.path([this.at(graph.a[line]), this.at(graph.b[line])], {
      stroke: lit ? look.route : inTree ? look.line : look.pale,
      width: lit ? 4 : Math.max(0.6, this.scale * graph.width[line] * (inTree ? 1 : 0.8)),
      dash: bound && !lit ? [6, 5] : [],
      alpha: lit ? 1 : (inTree ? 0.9 : 0.4) * faded,
    });
  }

  // The lines of the way between the chosen minima.
  route() {
    const lines = new Set();
    const { graph } = this.side;
    const minima = routeOf(state.selected)?.minima ?? [];
    for (let k = 1; k < minima.length; k++) {
      const ends = [this.circle(minima[k - 1]), this.circle(minima[k])];
      const line = graph.a.findIndex((a, number) => ends.includes(a) && ends.includes(graph.b[number]) && ends[0] !== ends[1]);
      if (line >= 0) lines.add(line);
    }
    return lines;
  }

  found([x, y]) {
    if (!this.centre) return null;
    let best = { reach: 10, circle: -1 };
    this.side.graph.minimum.forEach((_, circle) => {
      const [cx, cy] = this.at(circle);
      const reach = Math.hypot(cx - x, cy - y) - this.radius(circle);
      if (reach < best.reach) best = { reach, circle };
    });
    return best.circle < 0 ? null : { item: this.side.graph.minimum[best.circle] };
  }
}
