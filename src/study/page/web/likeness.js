// The grasps of a file in the plane: alike ones are near each other. Places were computed in src/study/page/likeness.rs.

import { look, lookOf } from "./looks.js";
import { Drawing, nearest, OF_ITEMS, rings } from "./pen.js";
import { derived, looked, model, state } from "./state.js";
import { percent, plain, shown, ticks } from "./text.js";
import { meaning } from "./words.js";

const FOOT = 24;

/** @typedef {import("./data.js").Likeness} Likeness */
/** @typedef {import("./pen.js").Pen} Pen */

export class LikenessPanel {
  /** @param {HTMLElement} section @param {Likeness} likeness */
  constructor(section, likeness) {
    this.likeness = likeness;
    this.scale = this.left = this.top = this.radius = 0;
    const errors = likeness.parts.map(part => part.error).filter(error => error !== null);
    const error = errors.length ? ` In the plane they are right to within ${percent(Math.max(...errors))} on average.` : "";
    this.meaning = meaning("likeness") + error;
    this.drawing = new Drawing(
      section,
      "Grasps placed by likeness",
      [...OF_ITEMS, "sort"],
      (pen, w, h) => this.paint(pen, w, h),
      pen => this.mark(pen),
      at => this.found(at),
    );
  }

  /** @param {number} item */
  at(item) {
    const { x, y } = this.likeness;
    return [this.left + this.scale * x[item], this.top + this.scale * y[item]];
  }

  /** @param {Pen} pen @param {number} w @param {number} h */
  paint(pen, w, h) {
    const { size, parts } = this.likeness;
    this.scale = Math.min((w - 16) / size[0], (h - FOOT - 16) / size[1]);
    this.left = (w - this.scale * size[0]) / 2;
    this.top = 8 + (h - FOOT - 16 - this.scale * size[1]) / 2;
    this.radius = Math.max(2, Math.min(6, 90 / Math.sqrt(model.count)));
    if (parts.length > 1) this.frames(pen, parts);
    for (let item = 0; item < model.count; item++) {
      const alpha = derived.passes[item] ? 1 : 0.15;
      pen.symbol(this.at(item), this.radius, lookOf(item), { stroke: look.line, width: 0.8, alpha });
    }
    this.ruler(pen, w, h);
  }

  /** Pictures of several populations, with their names where there is room. @param {Pen} pen @param {Likeness["parts"]} parts */
  frames(pen, parts) {
    for (const { name, corner, size } of parts) {
      const [x, y] = [this.left + this.scale * corner[0], this.top + this.scale * corner[1]];
      const [width, height] = size.map(side => this.scale * side);
      const frame = [
        [x, y],
        [x + width, y],
        [x + width, y + height],
        [x, y + height],
      ];
      pen.path(frame, { stroke: look.faint, close: true });
      if (width > 40) pen.label([x + 4, y + 9], plain(name, Math.floor(width / 7)));
    }
  }

  /** A length for comparison. @param {Pen} pen @param {number} w @param {number} h */
  ruler(pen, w, h) {
    const [[value]] = ticks(0, 120 / this.scale, 2).slice(-1);
    const y = h - 10;
    pen.line(10, y, 10 + this.scale * value, y, { stroke: look.line, width: 2 });
    pen.label([18 + this.scale * value, y], `${shown(1e3 * value, 3)} mm`);
  }

  /** @param {Pen} pen */
  mark(pen) {
    /** @type {import("./pen.js").Ring} */
    const ring = (item, stroke, width, gap) => pen.circle(this.at(item), this.radius + gap, { stroke, width });
    if (state.hover === null && state.selected.length === 0) ring(looked(), look.ink, 1.5, 3);
    rings(ring);
    rings(item => {
      const [x, y] = this.at(item);
      pen.label([x, y - this.radius - 11], model.name(item), { fill: look.ink, anchor: "middle", weight: 600 });
    });
  }

  /** @param {number[]} at */
  found([x, y]) {
    const item = nearest(model.count, 12, item => {
      const [px, py] = this.at(item);
      return Math.hypot(px - x, py - y);
    });
    return item === null ? null : { item };
  }
}
