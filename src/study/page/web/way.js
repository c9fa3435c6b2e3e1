// The lowest way between two minima: the energy by term along it, and a scrubber that plays it.

import { button, make } from "./dom.js";
import { pathCommand } from "./export.js";
import { look } from "./looks.js";
import { Drawing, EDGE } from "./pen.js";
import { routeInTree, routeOf, searchesAcross } from "./route.js";
import { change, model, state, watch } from "./state.js";
import { dictionary, plain, plural, shown } from "./text.js";
import { EVIDENCE_WORDS } from "./words.js";

// Terms that never reach this part of the highest energy are not drawn.
const LEAST_SHARE = 0.02;
const SERIES = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5b3a8e", "#8c510a", "#7a7f87"];
// Least distance of the names below the chart.
const ROOM = 34;

// What the hand does on a way, by the names in the files.
const DOES = dictionary({ sliding: "slides", rolling: "rolls", regrasping: "regrasps", "letting go": "lets go" });

/**
 * @typedef {import("./pen.js").Pen} Pen
 * @typedef {import("./pen.js").Scale} Scale
 * @typedef {import("./route.js").Route} Route
 * @typedef {{ name: string, values: number[], colour: string }} Part
 */

export class WayPanel {
  /** @param {HTMLElement} section */
  constructor(section) {
    this.section = section;
    this.words = make("p", "", { class: "words" });
    section.append(this.words);
    this.drawing = new Drawing(section, "Energy along the way", ["step"], (pen, w, h) => this.paint(pen, w, h));
    this.play = button("▶", () => this.toggle(), { "aria-label": "Play the way" });
    this.slider = make("input", "", { type: "range", min: 0, max: 1, step: 0.001, "aria-label": "Place on the way" });
    this.slider.addEventListener("input", () => {
      this.stop();
      change({ step: Number(this.slider.value) });
    });
    this.legend = make("div", "", { class: "legend" });
    this.scrubber = make("div", "", { class: "scrubber" }, this.play, this.slider);
    section.append(this.scrubber, this.legend);
    this.timer = 0;
    /** @param {PointerEvent} event */
    const drag = event => {
      if (!event.buttons) return;
      this.stop();
      const [x] = this.drawing.placeOf(event);
      change({ step: Math.min(1, Math.max(0, (x - EDGE.left) / (this.drawing.canvas.clientWidth - EDGE.left - EDGE.right))) });
    };
    this.drawing.canvas.addEventListener("pointerdown", drag);
    this.drawing.canvas.addEventListener("pointermove", drag);
    watch(["selected"], () => this.choose());
  }

  choose() {
    this.stop();
    const [a, b] = state.selected;
    const two = b !== undefined && model.sideOf(a) === model.sideOf(b);
    this.section.hidden = !two;
    const route = two ? routeOf(state.selected) : null;
    for (const part of [this.drawing.canvas, this.scrubber, this.legend]) part.hidden = !route;
    if (two) this.words.textContent = route ? this.told(route) : this.missing(a, b);
    if (route) this.explain(route);
    this.drawing.draw();
  }

  /** @param {number} a @param {number} b */
  missing(a, b) {
    const [side] = model.at(a);
    const met = side.tree && routeInTree(side.tree, [model.at(a)[1], model.at(b)[1]]).top;
    if (met === null) return `No path is known between ${model.name(a)} and ${model.name(b)}.`;
    if (!side.ways) return "The files of this landscape contain no paths, only the heights of passes.";
    return `This way is not in the page, which contains only ways between families. This command makes it: ${pathCommand()}`;
  }

  /** The way in words. @param {Route} route */
  told({ side, paths, points, pass, minima, ways }) {
    const { kind, term, height, evidence } = paths;
    const way = points[pass].way;
    const [a, b] = [minima[0], minima[minima.length - 1]];
    const merge = routeInTree(side.tree, [model.at(a)[1], model.at(b)[1]]).top;
    const bound = EVIDENCE_WORDS[model.header.evidence[evidence[way]]];
    const dominating = plain(term.texts[term.of[way]]).replaceAll("_", " ");
    const kinds = [...new Set(ways.map(number => plain(kind.texts[kind.of[number]])).filter(word => word))];
    return [
      `From ${model.name(a)} to ${model.name(b)} over ${plural(ways.length, "pass", "passes")}; the highest is at ${shown(height[way])},`,
      `${shown(height[way] - Math.max(model.energy(a), model.energy(b)), 3)} above the higher end.`,
      `${bound[0].toUpperCase()}${bound.slice(1)}.`,
      dominating ? `Mostly ${dominating} makes it high.` : "",
      merge === null || !side.tree.tested ? "" : `${searchesAcross(side.tree, merge)}.`,
      kinds.length ? `On the way the hand ${kinds.map(name => DOES[name] ?? name).join(", ")}.` : "",
    ]
      .filter(part => part)
      .join(" ");
  }

  /** The terms that are drawn, with their values at the points of a way and their colours. @param {Route} route @returns {Part[]} */
  drawn({ side, paths, points }) {
    const { terms } = paths;
    const names = side.term_names;
    if (!terms || !names) return [];
    const most = Math.max(...points.map(point => Math.abs(point.energy)));
    return names
      .map((name, term) => ({ name, values: points.map(point => terms[point.row * names.length + term]) }))
      .filter(({ values }) => Math.max(...values) >= LEAST_SHARE * most)
      .map((part, k) => ({ ...part, colour: SERIES[k % SERIES.length] }));
  }

  /** @param {Route} route */
  explain(route) {
    /** @param {string} colour @param {string} text */
    const entry = (colour, text) => {
      const box = make("i");
      box.style.background = colour;
      return make("span", "", {}, box, text);
    };
    const parts = this.drawn(route).map(({ name, colour }) => entry(colour, name.replaceAll("_", " ")));
    this.legend.replaceChildren(...parts, entry("var(--ink)", "energy"));
  }

  /** @param {Pen} pen @param {number} w @param {number} h */
  paint(pen, w, h) {
    const route = routeOf(state.selected);
    if (!route) return;
    const energies = route.points.map(point => point.energy);
    const parts = this.drawn(route);
    const [least, most] = [Math.min(...energies), Math.max(...energies)];
    const low = parts.length ? Math.min(0, least) : least - 0.08 * (most - least || 1);
    const high = most + 0.16 * (most - low || 1);
    /** @type {Scale} */
    const x = along => EDGE.left + (w - EDGE.left - EDGE.right) * (along / route.length);
    /** @type {Scale} */
    const y = energy => EDGE.top + (h - EDGE.top - EDGE.bottom) * ((high - energy) / (high - low));
    pen.rows(low, high, h / 45, y, w - EDGE.right);
    this.stack(pen, route, parts, x, y);
    const line = route.points.map(point => [x(point.along), y(point.energy)]);
    pen.path(line, { stroke: look.ink, width: 2 });
    this.marks(pen, route, x, y, h);
    const here = x(state.step * route.length);
    pen.line(here, EDGE.top - 6, here, h - EDGE.bottom, { stroke: look.route, width: 1.5 });
    this.slider.valueAsNumber = state.step;
    this.slider.setAttribute("aria-valuetext", `${Math.round(100 * state.step)} % of the way`);
  }

  // The terms on top of each other, with a line of paper between two.
  /** @param {Pen} pen @param {Route} route @param {Part[]} parts @param {Scale} x @param {Scale} y */
  stack(pen, { points }, parts, x, y) {
    let floor = points.map(() => 0);
    for (const { colour, values } of parts) {
      const top = points.map((_, k) => floor[k] + Math.max(0, values[k]));
      /** @param {number[]} heights */
      const edge = heights => points.map((point, k) => [x(point.along), y(heights[k])]);
      pen.path([...edge(top), ...edge(floor).reverse()], { fill: colour, alpha: 0.75, close: true });
      pen.path(edge(top), { stroke: look.paper, width: 1 });
      floor = top;
    }
  }

  /** The minima below the chart, and the pass. @param {Pen} pen @param {Route} route @param {Scale} x @param {Scale} y @param {number} h */
  marks(pen, { points, stops, minima, length, pass }, x, y, h) {
    let last = -Infinity;
    [0, ...stops].forEach((stop, k) => {
      const at = x(points[stop].along);
      pen.line(at, h - EDGE.bottom, at, h - EDGE.bottom + 5, { stroke: look.line });
      if (at - last < ROOM || (k < stops.length && x(length) - at < ROOM)) return;
      pen.label([at, h - EDGE.bottom + 15], model.name(minima[k]), { anchor: "middle" });
      last = at;
    });
    const at = [x(points[pass].along), y(points[pass].energy)];
    pen.circle(at, 4.5, { fill: look.route, stroke: look.paper, width: 1.5 });
    const anchor = at[0] > 0.8 * x(length) ? "end" : at[0] < EDGE.left + 60 ? "start" : "middle";
    pen.label([at[0], at[1] - 13], `pass ${shown(points[pass].energy, 3)}`, { fill: look.ink, anchor, weight: 600 });
  }

  toggle() {
    const route = routeOf(state.selected);
    if (this.timer) return this.stop();
    if (!route) return;
    this.showPlaying(true);
    let [before, step] = [performance.now(), state.step >= 1 ? 0 : state.step];
    const seconds = Math.max(4, route.points.length / 12);
    /** @param {number} now */
    const frame = now => {
      step = Math.min(1, step + Math.max(0, now - before) / 1000 / seconds);
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
    this.showPlaying(false);
  }

  /** @param {boolean} playing */
  showPlaying(playing) {
    this.play.textContent = playing ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", playing ? "Pause" : "Play the way");
  }
}
