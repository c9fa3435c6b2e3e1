// The lowest way between two minima: the energy by term along it, and a scrubber that plays it.
"use strict";

// Terms that never reach this part of the highest energy are not drawn.
const LEAST_SHARE = 0.02;
const SERIES = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5b3a8e", "#8c510a", "#4d4d4d"];

const routes = new Map();

// The way between two chosen items: its minima and points, or null. Ways lead along the edges of the spanning forest.
function routeOf(selected) {
  if (selected.length < 2 || model.sideOf(selected[0]) !== model.sideOf(selected[1])) return null;
  const key = selected.join();
  if (!routes.has(key)) {
    routes.clear();
    routes.set(key, foundRoute(selected));
  }
  return routes.get(key);
}

function foundRoute([from, to]) {
  const [side, a] = model.at(from);
  const [, b] = model.at(to);
  if (!side.ways) return null;
  const offset = from - a;
  const chain = chainOf(side.ways, side.count, a, b);
  if (!chain) return null;
  const route = { side, minima: [from], points: [], stops: [], ways: chain.map(([way]) => way) };
  for (const [way, turned] of chain) {
    const [first, end] = [side.ways.starts[way], side.ways.starts[way + 1]];
    for (let k = first; k < end; k++) {
      const row = turned ? end - 1 - (k - first) : k;
      // Each way begins where the one before ended.
      if (k === first && route.points.length) continue;
      const last = route.points.at(-1);
      const step = last ? Math.abs(side.ways.along[row] - side.ways.along[last.row]) : 0;
      route.points.push({ row, way, along: last ? last.along + (k === first ? 0 : step) : 0, energy: side.ways.energy[row] });
    }
    route.stops.push(route.points.length - 1);
    route.minima.push(offset + (turned ? side.ways.a[way] : side.ways.b[way]));
  }
  route.length = route.points.at(-1).along || 1;
  route.pass = route.points.reduce((top, point, k) => (point.energy > route.points[top].energy ? k : top), 0);
  return route;
}

// The ways from one minimum to another, each with whether it is walked backward; breadth first, in a forest.
function chainOf(ways, count, from, to) {
  ways.beside ??= besideOf(ways, count);
  const came = new Map([[from, null]]);
  const waiting = [from];
  for (const at of waiting) {
    if (at === to) break;
    for (const [next, way, turned] of ways.beside[at]) {
      if (!came.has(next)) {
        came.set(next, [at, way, turned]);
        waiting.push(next);
      }
    }
  }
  if (!came.has(to)) return null;
  const chain = [];
  for (let at = to; came.get(at); at = came.get(at)[0]) chain.unshift(came.get(at).slice(1));
  return chain;
}

function besideOf(ways, count) {
  const beside = Array.from({ length: count }, () => []);
  ways.a.forEach((a, way) => {
    beside[a].push([ways.b[way], way, false]);
    beside[ways.b[way]].push([a, way, true]);
  });
  return beside;
}

// The coordinates at a place on a way, 0 to 1.
function onRoute(route, step) {
  const { ways, space } = route.side;
  const along = step * route.length;
  let k = route.points.findIndex(point => point.along >= along);
  if (k < 0) k = route.points.length - 1;
  const at = row => ways.coordinates.subarray(row * space.dimensions, (row + 1) * space.dimensions);
  if (k === 0) return at(route.points[0].row);
  const [p, q] = [route.points[k - 1], route.points[k]];
  const part = q.along > p.along ? (along - p.along) / (q.along - p.along) : 1;
  return between(at(p.row), at(q.row), part, space.kind === "pose" ? true : undefined);
}

// The item that the view shows: the one that is looked at, or the start of the way.
function shownItem() {
  const route = state.hover === null ? routeOf(state.selected) : null;
  return route && state.step < 1 ? state.selected[0] : looked();
}

class WayPanel {
  constructor(section) {
    this.section = section;
    this.words = make("p", "", { class: "words" });
    section.append(this.words);
    this.drawing = new Drawing(section, "Energy along the way", (pen, w, h) => this.paint(pen, w, h));
    this.play = make("button", "▶", { type: "button", "aria-label": "Play the way", onclick: () => this.toggle() });
    this.slider = make("input", "", { type: "range", min: 0, max: 1, step: 0.001, "aria-label": "Place on the way" });
    this.slider.addEventListener("input", () => change({ step: Number(this.slider.value) }));
    this.legend = make("div", "", { class: "legend" });
    section.append(make("div", "", { class: "scrubber" }, this.play, this.slider), this.legend);
    const drag = event => {
      if (!event.buttons) return;
      const [x] = this.drawing.placeOf(event);
      change({ step: Math.min(1, Math.max(0, (x - EDGE.left) / (this.drawing.canvas.clientWidth - EDGE.left - EDGE.right))) });
    };
    this.drawing.canvas.addEventListener("pointerdown", drag);
    this.drawing.canvas.addEventListener("pointermove", drag);
    watch(["selected"], () => this.choose());
    watch(["step", "look"], () => this.drawing.draw());
  }

  choose() {
    this.stop();
    const [a, b] = state.selected;
    const two = a !== undefined && b !== undefined && model.sideOf(a) === model.sideOf(b) && model.at(a)[0].item === "minimum";
    this.section.hidden = !two;
    const route = two ? routeOf(state.selected) : null;
    const chart = [this.drawing.canvas, this.slider.parentElement, this.legend];
    for (const part of chart) part.hidden = !route;
    if (two) this.words.textContent = route ? this.told(route) : this.missing(a, b);
    if (route) this.explain(route);
    this.drawing.draw();
  }

  missing(a, b) {
    const [side] = model.at(a);
    if (
      routeInTree(
        side.tree,
        state.selected.map(item => model.at(item)[1]),
      ).top === null
    )
      return `No path is known between ${model.name(a)} and ${model.name(b)}.`;
    if (!side.ways) return `The files of this landscape hold no paths, only the heights of passes.`;
    return `This way is not in the page, which holds those between groups only. It is made by: ${pathCommand()}`;
  }

  // The way in words.
  told(route) {
    const { side, points, minima } = route;
    const top = points[route.pass];
    const way = top.way;
    const [a, b] = [minima[0], minima.at(-1)];
    const merge = routeInTree(
      side.tree,
      [a, b].map(item => model.at(item)[1]),
    ).top;
    const share = merge === null ? NaN : side.tree.support[merge];
    const kinds = [...new Set(route.ways.map(number => side.ways.kind.texts[side.ways.kind.of[number]]).filter(kind => kind))];
    const passes = route.ways.length;
    const term = side.ways.term.texts[side.ways.term.of[way]];
    return [
      `From ${model.name(a)} to ${model.name(b)} over ${passes} ${passes === 1 ? "pass" : "passes"}; the highest is at ${shown(side.ways.height[way])},`,
      `${shown(side.ways.height[way] - Math.max(model.energy(a), model.energy(b)), 3)} above the higher end.`,
      `It is ${EVIDENCE_WORDS[model.header.evidence[side.ways.evidence[way]]]}${term ? `, dominated by ${term.replaceAll("_", " ")}` : ""}.`,
      Number.isNaN(share) ? "" : `Its merge is found in ${Math.round(100 * share)} % of the resampled trees.`,
      kinds.length ? `On the way the hand does this: ${kinds.join(", ")}.` : "",
    ]
      .filter(part => part)
      .join(" ");
  }

  // The terms that are drawn, with their colours.
  drawn(route) {
    const names = route.side.term_names ?? [];
    const terms = route.side.ways.terms;
    if (!terms) return [];
    const most = Math.max(...route.points.map(point => Math.abs(point.energy)));
    const value = (point, term) => terms[point.row * names.length + term];
    const used = names.map((name, term) => ({ name, term, value: point => value(point, term) }));
    const kept = used.filter(({ value }) => Math.max(...route.points.map(value)) >= LEAST_SHARE * most);
    return kept.map((part, k) => ({ ...part, colour: SERIES[k % SERIES.length] }));
  }

  explain(route) {
    const entry = (colour, text) => {
      const box = make("i");
      box.style.background = colour;
      return make("span", "", {}, box, text);
    };
    const parts = this.drawn(route).map(({ name, colour }) => entry(colour, name.replaceAll("_", " ")));
    this.legend.replaceChildren(...parts, entry(look.ink, "energy"));
  }

  paint(pen, w, h) {
    const route = routeOf(state.selected);
    if (!route) return;
    const energies = route.points.map(point => point.energy);
    const parts = this.drawn(route);
    const [least, most] = [Math.min(...energies), Math.max(...energies)];
    const low = parts.length ? Math.min(0, least) : least - 0.08 * (most - least);
    const high = most + 0.16 * (most - low || 1);
    const x = along => EDGE.left + (w - EDGE.left - EDGE.right) * (along / route.length);
    const y = energy => EDGE.top + (h - EDGE.top - EDGE.bottom) * ((high - energy) / (high - low));
    for (const [value, text] of ticks(low, high, h / 45)) {
      pen.path(
        [
          [EDGE.left - 6, y(value)],
          [w - EDGE.right, y(value)],
        ],
        { stroke: look.faint },
      );
      pen.text([EDGE.left - 10, y(value)], text, { fill: look.soft, size: 11.5, anchor: "end" });
    }
    this.stack(pen, route, parts, x, y);
    pen.path(
      route.points.map(point => [x(point.along), y(point.energy)]),
      { stroke: look.ink, width: 2 },
    );
    this.marks(pen, route, x, y, h);
    const here = x(state.step * route.length);
    pen.path(
      [
        [here, EDGE.top - 6],
        [here, h - EDGE.bottom],
      ],
      { stroke: look.route, width: 1.5 },
    );
    this.slider.value = state.step;
    this.slider.setAttribute("aria-valuetext", `${Math.round(100 * state.step)} % of the way`);
  }

  stack(pen, route, parts, x, y) {
    let floor = route.points.map(() => 0);
    for (const { colour, value } of parts) {
      const top = route.points.map((point, k) => floor[k] + Math.max(0, value(point)));
      const edge = route.points.map((point, k) => [x(point.along), y(top[k])]);
      const back = route.points.map((point, k) => [x(point.along), y(floor[k])]).reverse();
      pen.path([...edge, ...back], { fill: colour, alpha: 0.55, close: true });
      floor = top;
    }
  }

  marks(pen, route, x, y, h) {
    const stops = [0, ...route.stops];
    const room = 34;
    let last = -Infinity;
    stops.forEach((stop, k) => {
      const at = x(route.points[stop].along);
      pen.path(
        [
          [at, h - EDGE.bottom],
          [at, h - EDGE.bottom + 5],
        ],
        { stroke: look.line },
      );
      const end = k === stops.length - 1;
      if (at - last < room || (!end && x(route.length) - at < room)) return;
      pen.text([at, h - EDGE.bottom + 15], model.name(route.minima[k]), { fill: look.soft, size: 11.5, anchor: "middle" });
      last = at;
    });
    const top = route.points[route.pass];
    const at = [x(top.along), y(top.energy)];
    pen.circle(at, 4.5, { fill: look.route, stroke: look.paper, width: 1.5 });
    const side = at[0] > 0.8 * x(route.length) ? "end" : at[0] < EDGE.left + 60 ? "start" : "middle";
    pen.text([at[0], at[1] - 13], `pass ${shown(top.energy, 3)}`, { fill: look.ink, size: 11.5, anchor: side, weight: 600 });
  }

  toggle() {
    if (this.timer) return this.stop();
    const route = routeOf(state.selected);
    if (!route) return;
    this.play.textContent = "❚❚";
    let [before, step] = [performance.now(), state.step >= 1 ? 0 : state.step];
    const seconds = Math.max(4, route.points.length / 12);
    const frame = now => {
      step = Math.min(1, step + (now - before) / 1000 / seconds);
      before = now;
      change({ step });
      if (step < 1) this.timer = requestAnimationFrame(frame);
      else this.stop();
    };
    this.timer = requestAnimationFrame(frame);
  }

  stop() {
    cancelAnimationFrame(this.timer);
    this.timer = 0;
    this.play.textContent = "▶";
  }
}
