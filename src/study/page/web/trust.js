// The strip about trust, and the curve of what is still unseen.

import { FAMILY } from "./basins.js";
import { make } from "./dom.js";
import { look } from "./looks.js";
import { Drawing, EDGE } from "./pen.js";
import { model } from "./state.js";
import { sideName } from "./text.js";

const TONES = { good: "●", care: "◐", warning: "▲", note: "○" };

export function showTrust(section) {
  const statement = ({ tone, short, long }) =>
    make("details", "", { class: tone, name: "trust" }, make("summary", "", {}, make("i", TONES[tone]), short), make("p", long));
  const name = side => (model.sides.length > 1 ? [make("strong", sideName(side))] : []);
  const rows = model.sides
    .filter(side => side.trust?.length)
    .map(side => make("div", "", {}, ...name(side), ...side.trust.map(statement)));
  section.hidden = rows.length === 0;
  section.replaceChildren(...rows);
}

export class RarefactionPanel {
  constructor(section) {
    const [side] = model.sides;
    this.curves = Object.entries(side.rarefaction)
      .map(([name, found], k) => ({ name, number: k, curve: found.curve ?? [] }))
      .filter(({ curve }) => curve.length);
    if (side.item === "grasp") section.querySelector("h2").textContent = "Kinds among fewer grasps";
    const names = this.curves.map(({ name }) => name);
    this.room = 16 + 6.4 * Math.max(0, ...names.map(name => name.length));
    const label = `Rarefaction: ${names.join(" and ")} found by fewer grasps`;
    this.drawing = new Drawing(section, label, [], (pen, w, h) => this.paint(pen, w, h));
  }

  paint(pen, w, h) {
    const most = Math.max(1, ...this.curves.map(({ curve }) => curve.at(-1).members));
    const high = 1.1 * Math.max(1, ...this.curves.flatMap(({ curve }) => curve.map(point => point.kinds)));
    const right = w - this.room;
    let last = -Infinity;
    const x = members => EDGE.left + (right - EDGE.left) * (members / most);
    const y = kinds => EDGE.top + (h - EDGE.top - 34) * (1 - kinds / high);
    pen.rows(0, high, 4, y, right);
    pen.columns(0, most, 4, x, h - 22);
    pen.label([(x(0) + x(most)) / 2, h - 7], model.sides[0].members_label, { anchor: "middle" });
    for (const { name, number, curve } of this.curves) {
      const colour = FAMILY[look.dark ? "dark" : "light"][number];
      const at = point => [x(point.members), y(point.kinds)];
      const seen = curve.filter(point => point.deviation !== null);
      const beyond = curve.filter(point => point.deviation === null);
      const edge = sign => seen.map(point => [x(point.members), y(point.kinds + sign * 1.96 * point.deviation)]);
      pen.path([...edge(1), ...edge(-1).reverse()], { fill: colour, alpha: 0.16, close: true });
      pen.path(seen.map(at), { stroke: colour, width: 2 });
      if (beyond.length) pen.path([...seen.slice(-1), ...beyond].map(at), { stroke: colour, width: 2, dash: [5, 4] });
      const [ex, ey] = at(curve.at(-1));
      // Names do not cover each other.
      last = Math.abs(ey - last) < 14 ? last + (ey < last ? -14 : 14) : ey;
      pen.label([ex + 6, last], name, { fill: look.ink });
    }
  }
}
