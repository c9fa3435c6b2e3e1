// Painting: one set of calls for a canvas and for an SVG file, axes, and the canvas of a panel.

import { contextOf, make, tip } from "./dom.js";
import { look } from "./looks.js";
import { change, model, select, state, watch } from "./state.js";
import { escaped, ticks } from "./text.js";
import { described } from "./words.js";

const FONT = 'system-ui, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif';
// Texts have a margin of paper, so that lines behind them do not cross their letters.
const HALO = 3;
export const EDGE = { left: 58, right: 14, top: 16, bottom: 30 };

/**
 * @typedef {{ stroke?: string, width?: number, dash?: number[], fill?: string, alpha?: number, close?: boolean }} Style
 * @typedef {{ fill?: string, size?: number, anchor?: "start" | "middle" | "end", weight?: number }} TextStyle
 * @typedef {import("./data.js").Look} Look
 * @typedef {{ item: number } | { item: null, lines: string[], act: () => void }} Found an item, or what else a place tells and does
 * @typedef {(item: number, colour: string, width: number, gap: number) => void} Ring
 * @typedef {(value: number) => number} Scale
 */

// What both pens share. How they paint a path, lines of two points each, a circle and a text is their own matter.
export class Pen {
  /** @param {number[][]} _points @param {Style} _style */
  path(_points, _style) {}
  /** @param {number[][][]} _pairs @param {Style} _style */
  segments(_pairs, _style) {}
  /** @param {number[]} _middle @param {number} _radius @param {Style} _style */
  circle(_middle, _radius, _style) {}
  /** @param {number[]} _at @param {string} _text @param {TextStyle} _style */
  text(_at, _text, _style) {}

  /** @param {number} x1 @param {number} y1 @param {number} x2 @param {number} y2 @param {Style} style */
  line(x1, y1, x2, y2, style) {
    this.path(
      [
        [x1, y1],
        [x2, y2],
      ],
      style,
    );
  }

  // The symbol of a look with the area of a disc of this radius.
  /** @param {number[]} at @param {number} radius @param {Look} look @param {Style} style */
  symbol([x, y], radius, { colour, corners, open }, style) {
    const filled = { ...style, fill: colour };
    if (corners.length) this.path(corners.map(([dx, dy]) => [x + radius * dx, y + radius * dy]), { ...filled, close: true });
    else this.circle([x, y], radius, filled);
    if (open) this.circle([x, y], model.header.looks.heart * radius, { fill: look.paper, alpha: style.alpha });
  }

  /** @param {number[]} at @param {string} text @param {TextStyle} style */
  label(at, text, style = {}) {
    this.text(at, text, { fill: look.soft, size: 11.5, ...style });
  }

  // Numbers at the left with lines across, `y` places them.
  /** @param {number} low @param {number} high @param {number} count @param {Scale} y @param {number} right @param {(y: number) => boolean} but */
  rows(low, high, count, y, right, but = _ => false) {
    for (const [value, text] of ticks(low, high, count)) {
      this.line(EDGE.left - 6, y(value), right, y(value), { stroke: look.faint });
      if (!but(y(value))) this.label([EDGE.left - 10, y(value)], text, { anchor: "end" });
    }
  }

  /** Numbers in a row, `x` places them. @param {number} low @param {number} high @param {number} count @param {Scale} x @param {number} y */
  columns(low, high, count, x, y) {
    for (const [value, text] of ticks(low, high, count)) this.label([x(value), y], text, { anchor: "middle" });
  }
}

class CanvasPen extends Pen {
  /** @param {CanvasRenderingContext2D} context */
  constructor(context) {
    super();
    this.context = context;
  }

  /** @param {number[][]} points @param {Style} style */
  path(points, style) {
    this.context.beginPath();
    points.forEach(([x, y], k) => (k ? this.context.lineTo(x, y) : this.context.moveTo(x, y)));
    if (style.close) this.context.closePath();
    this.paint(style);
  }

  /** @param {number[][][]} pairs @param {Style} style */
  segments(pairs, style) {
    this.context.beginPath();
    for (const [[x1, y1], [x2, y2]] of pairs) {
      this.context.moveTo(x1, y1);
      this.context.lineTo(x2, y2);
    }
    this.paint(style);
  }

  /** @param {number[]} middle @param {number} radius @param {Style} style */
  circle([x, y], radius, style) {
    this.context.beginPath();
    this.context.arc(x, y, radius, 0, 2 * Math.PI);
    this.paint(style);
  }

  /** @param {Style} style */
  paint({ stroke, width = 1, dash = [], fill, alpha = 1 }) {
    const c = this.context;
    c.globalAlpha = alpha;
    if (fill) {
      c.fillStyle = fill;
      c.fill();
    }
    if (stroke) {
      Object.assign(c, { strokeStyle: stroke, lineWidth: width, lineJoin: "round" });
      c.setLineDash(dash);
      c.stroke();
    }
  }

  /** @param {number[]} at @param {string} text @param {TextStyle} style */
  text([x, y], text, { fill, size = 12, anchor = "start", weight = 400 }) {
    const c = this.context;
    const textAlign = { start: "left", middle: "center", end: "right" }[anchor];
    const font = `${weight} ${size}px ${FONT}`;
    Object.assign(c, { globalAlpha: 1, font, fillStyle: fill, textAlign, textBaseline: "middle" });
    Object.assign(c, { strokeStyle: look.paper, lineWidth: HALO, lineJoin: "round" });
    c.setLineDash([]);
    c.strokeText(text, x, y);
    c.fillText(text, x, y);
  }
}

class SvgPen extends Pen {
  /** @type {string[]} */
  parts = [];

  /** @param {number[][]} points @param {Style} style */
  path(points, style) {
    if (points.length) this.parts.push(`<path d="${this.way(points)}${style.close ? "Z" : ""}" ${this.paint(style)}/>`);
  }

  /** @param {number[][][]} pairs @param {Style} style */
  segments(pairs, style) {
    this.parts.push(`<path d="${pairs.map(pair => this.way(pair)).join("")}" ${this.paint(style)}/>`);
  }

  /** @param {number[][]} points */
  way(points) {
    return "M" + points.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join("L");
  }

  /** @param {number[]} middle @param {number} radius @param {Style} style */
  circle([x, y], radius, style) {
    this.parts.push(`<circle cx="${x.toFixed(2)}" cy="${y.toFixed(2)}" r="${radius.toFixed(2)}" ${this.paint(style)}/>`);
  }

  /** @param {Style} style */
  paint({ stroke, width = 1, dash = [], fill, alpha = 1 }) {
    const parts = [`fill="${fill ?? "none"}"`];
    if (stroke) parts.push(`stroke="${stroke}" stroke-width="${width}" stroke-linejoin="round"`);
    if (stroke && dash.length) parts.push(`stroke-dasharray="${dash.join(" ")}"`);
    if (alpha < 1) parts.push(`opacity="${alpha}"`);
    return parts.join(" ");
  }

  /** @param {number[]} at @param {string} text @param {TextStyle} style */
  text([x, y], text, { fill, size = 12, anchor = "start", weight = 400 }) {
    const place = `x="${x.toFixed(2)}" y="${(y + 0.36 * size).toFixed(2)}" text-anchor="${anchor}"`;
    const face = `font-size="${size}" font-weight="${weight}" fill="${fill}"`;
    const halo = `stroke="${look.paper}" stroke-width="${HALO}" stroke-linejoin="round" paint-order="stroke"`;
    this.parts.push(`<text ${place} ${face} ${halo}>${escaped(text)}</text>`);
  }

  /** @param {number} width @param {number} height */
  file(width, height) {
    const font = FONT.replaceAll('"', "'");
    return (
      `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" ` +
      `font-family="${font}"><!-- Made by landscape. --><rect width="100%" height="100%" fill="${look.paper}"/>\n` +
      this.parts.join("\n") +
      "\n</svg>\n"
    );
  }
}

// The number from 0 to `count` − 1 with the least `distance` below `reach`, or null.
/** @param {number} count @param {number} reach @param {(k: number) => number} distance */
export function nearest(count, reach, distance) {
  let [best, found] = [reach, NaN];
  for (let k = 0; k < count; k++) {
    const d = distance(k);
    if (d < best) [best, found] = [d, k];
  }
  return Number.isNaN(found) ? null : found;
}

// Parts of the state on which pictures of all items depend.
export const OF_ITEMS = ["selected", "level", "query", "colour", "pins", "labels"];

// A canvas in a panel that is painted again when some `parts` of the state change. `paint(pen, width, height)` paints it;
// `mark(pen)` adds what shows the item under the pointer, over a copy of what was painted, so that moving the pointer is
// quick however many items there are; `found([x, y])` says what is at a place.
export class Drawing {
  /**
   * @param {Element} section
   * @param {string} label
   * @param {string[]} parts
   * @param {(pen: Pen, width: number, height: number) => void} paint
   * @param {(pen: Pen) => void} [mark]
   * @param {(at: number[]) => Found | null} [found]
   */
  constructor(section, label, parts, paint, mark, found) {
    this.paint = paint;
    this.mark = mark;
    this.scale = 0;
    // Whether the pointer has moved since it was pressed: then its release is no click.
    this.dragged = false;
    this.canvas = make("canvas", "", { tabindex: 0, role: "img", "aria-label": label });
    this.base = make("canvas");
    section.append(this.canvas);
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    watch([...parts, "look"], () => this.draw());
    if (mark) watch(["hover"], () => this.show());
    // The arrow keys go through the items in this order, Enter chooses.
    this.order = Array.from({ length: model.count }, (_, item) => item);
    if (!found) return;
    this.canvas.addEventListener("keydown", event => this.key(event));
    this.canvas.addEventListener("pointermove", event => this.point(event, found));
    this.canvas.addEventListener("pointerleave", () => {
      tip(null);
      change({ hover: null });
    });
    this.canvas.addEventListener("click", event => {
      if (this.dragged) return;
      const there = found(this.placeOf(event));
      if (there && there.item === null) there.act();
      else select(there?.item ?? null);
    });
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const last = this.order.length - 1;
    const place = this.order.indexOf(state.hover ?? state.selected.at(-1) ?? -1);
    /** @type {Record<string, number>} */
    const moves = { ArrowLeft: Math.max(0, place - 1), ArrowRight: Math.min(last, place + 1), Home: 0, End: last };
    if (event.key in moves) change({ hover: this.order[moves[event.key]] ?? null });
    else if ((event.key === "Enter" || event.key === " ") && state.hover !== null) select(state.hover);
    else return;
    event.preventDefault();
  }

  /** @param {MouseEvent} event */
  placeOf(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  /** @param {MouseEvent} event @param {(at: number[]) => Found | null} found */
  point(event, found) {
    if (event.buttons && this.dragged) return;
    const there = found(this.placeOf(event));
    tip(there && (there.item === null ? there.lines : described(there.item)), event.clientX, event.clientY);
    change({ hover: there?.item ?? null });
  }

  draw() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (!width || !height) return;
    this.scale = Math.min(3, window.devicePixelRatio || 1);
    for (const canvas of [this.canvas, this.base]) {
      canvas.width = Math.round(width * this.scale);
      canvas.height = Math.round(height * this.scale);
      contextOf(canvas).scale(this.scale, this.scale);
    }
    this.paint(new CanvasPen(contextOf(this.base)), width, height);
    this.show();
  }

  // What was painted, with marks.
  show() {
    if (!this.scale) return;
    const context = contextOf(this.canvas);
    const [width, height] = [this.canvas.width / this.scale, this.canvas.height / this.scale];
    context.globalAlpha = 1;
    context.clearRect(0, 0, width, height);
    context.drawImage(this.base, 0, 0, width, height);
    this.mark?.(new CanvasPen(context));
  }

  svg() {
    const [width, height] = [this.canvas.clientWidth || 800, this.canvas.clientHeight || 500];
    const pen = new SvgPen();
    this.paint(pen, width, height);
    this.mark?.(pen);
    return pen.file(width, height);
  }
}

/** Rings the items that are marked: pinned, chosen, under the pointer. @param {Ring} ring */
export function rings(ring) {
  for (const item of state.pins) ring(item, look.soft, 1.5, 3);
  for (const item of state.selected) ring(item, look.route, 2.5, 3);
  if (state.hover !== null) ring(state.hover, look.ink, 2, 4);
}

/** The symbol of a look, for lists. @param {Look} look */
export function dotOf({ colour, corners, open }) {
  /** @param {string} name @param {Record<string, string | number>} attributes */
  const part = (name, attributes) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
    return element;
  };
  const outline = corners.length ? part("polygon", { points: corners.join(" ") }) : part("circle", { r: 1 });
  outline.setAttribute("fill", colour);
  const dot = part("svg", { class: "dot", viewBox: "-1.6 -1.6 3.2 3.2", "aria-hidden": "true" });
  dot.append(outline);
  if (open) dot.append(part("circle", { class: "heart", r: model.header.looks.heart }));
  return dot;
}
