// The strip about trust, and the curve of what is still unseen.

import { FAMILY } from "./basins.js";
import { headingOf, make } from "./dom.js";
import { look } from "./looks.js";
import { Drawing, EDGE } from "./pen.js";
import { model } from "./state.js";
import { sideName } from "./text.js";

/** @typedef {{ tone: "good" | "care" | "warning" | "note", short: string, long: string }} Statement */

const TONES = { good: "●", care: "◐", warning: "▲", note: "○" };

/** @param {HTMLElement} section */
export function showTrust(section) {
  /** @param {Statement} told */
  const statement = ({ tone, short, long }) =>
    make("details", "", { class: tone, name: "trust" }, make("summary", "", {}, make("i", TONES[tone]), short), make("p", long));
  const rows = model.sides.flatMap(side => {
    const name = model.sides.length > 1 ? [make("strong", sideName(side))] : [];
    return side.trust?.length ? make("div", "", {}, ...name, ...side.trust.map(statement)) : [];
  });
  section.hidden = rows.length === 0;
  section.replaceChildren(...rows);
}

export class RarefactionPanel {
  /** @param {HTMLElement} section @param {Record<string, { curve?: import("./data.js").Rarefied[] }>} rarefaction */
  constructor(section, rarefaction) {
    this.curves = Object.entries(rarefaction)
      .map(([name, found], k) => ({ name, number: k, curve: found.curve ?? [] }))
      .filter(({ curve }) => curve.length);
    if (model.sides[0].item === "grasp") headingOf(section).textContent = "Kinds among fewer grasps";
    const names = this.curves.map(({ name }) => name);
    this.room = 16 + 6.4 * Math.max(0, ...names.map(name => name.length));
    const label = `Rarefaction: ${names.join(" and ")} found by fewer grasps`;
    this.drawing = new Drawing(section, label, [], (pen, w, h) => this.paint(pen, w, h));
  }

  /** @param {import("./pen.js").Pen} pen @param {number} w @param {number} h */
  paint(pen, w, h) {
    const all = this.curves.flatMap(({ curve }) => curve);
    const most = Math.max(1, ...all.map(point => point.members));
    const high = 1.1 * Math.max(1, ...all.map(point => point.kinds));
    const right = w - this.room;
    let last = -Infinity;
    /** @param {number} members */
    const x = members => EDGE.left + (right - EDGE.left) * (members / most);
    /** @param {number} kinds */
    const y = kinds => EDGE.top + (h - EDGE.top - 34) * (1 - kinds / high);
    pen.rows(0, high, 4, y, right);
    pen.columns(0, most, 4, x, h - 22);
    pen.label([(x(0) + x(most)) / 2, h - 7], model.sides[0].members_label, { anchor: "middle" });
    for (const { name, number, curve } of this.curves) {
      const colour = FAMILY[look.dark ? "dark" : "light"][number];
      /** @param {import("./data.js").Rarefied} point */
      const at = point => [x(point.members), y(point.kinds)];
      const seen = curve.filter(point => point.deviation !== null);
      const beyond = curve.filter(point => point.deviation === null);
      /** @param {number} sign */
      const edge = sign => seen.map(point => [x(point.members), y(point.kinds + sign * 1.96 * (point.deviation ?? 0))]);
      pen.path([...edge(1), ...edge(-1).reverse()], { fill: colour, alpha: 0.16, close: true });
      pen.path(seen.map(at), { stroke: colour, width: 2 });
      if (beyond.length) pen.path([...seen.slice(-1), ...beyond].map(at), { stroke: colour, width: 2, dash: [5, 4] });
      const [[ex, ey]] = curve.slice(-1).map(at);
      // Names do not cover each other.
      last = Math.abs(ey - last) < 14 ? last + (ey < last ? -14 : 14) : ey;
      pen.label([ex + 6, last], name, { fill: look.ink });
    }
  }
}
