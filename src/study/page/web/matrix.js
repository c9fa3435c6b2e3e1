// The 33 grasp types as in the paper's table, with counts; the strip about trust; the curve of what is still unseen.
"use strict";

const FINGERS = {
  "2": "index",
  "2-3": "index, middle",
  "2-4": "to the ring",
  "2-5": "all four",
  "3": "middle",
  "3-4": "middle, ring",
  "3-5": "middle to little",
};

class MatrixPanel {
  constructor(section) {
    this.table = make("table", "", { class: "types" });
    this.others = make("p", "", { class: "others" });
    section.append(this.table, this.others);
    this.columns = [...new Set(model.header.taxonomy.map(type => type.cell.split("/").slice(0, 3).join("/")))];
    const rank = column => ["power", "intermediate", "precision"].indexOf(column.split("/")[0]);
    this.columns.sort((a, b) => rank(a) - rank(b));
    watch(["query", "labels", "look"], () => this.show());
    this.show();
  }

  show() {
    const counts = new Map();
    const cells = new Map();
    const others = new Map();
    for (let item = 0; item < model.count; item++) {
      if (!derived.passes[item]) continue;
      const weight = model.number("members", item);
      const type = model.number("type", item);
      const cell = model.text("cell", item);
      if (type) counts.set(type, (counts.get(type) ?? 0) + weight);
      else if (cell) cells.set(cell, (cells.get(cell) ?? 0) + weight);
      else
        others.set(
          model.text("label", item) || "without label",
          (others.get(model.text("label", item) || "without label") ?? 0) + weight,
        );
    }
    this.most = Math.max(1, ...counts.values());
    this.table.replaceChildren(this.head(), ...["abducted", "adducted"].map(thumb => this.row(thumb, counts, cells)));
    const words = [...others].sort((a, b) => b[1] - a[1]).map(([label, count]) => `${count} ${label.replaceAll("_", " ")}`);
    this.others.textContent = words.length ? "Of no type: " + words.join(", ") : "";
  }

  head() {
    const groups = [];
    for (const column of this.columns) {
      const category = column.split("/")[0];
      if (groups.at(-1)?.[0] === category) groups.at(-1)[1]++;
      else groups.push([category, 1]);
    }
    const categories = groups.map(([category, span]) => {
      const head = make("th", category, { colspan: span, scope: "colgroup" });
      head.style.borderBottomColor = CATEGORY[category];
      return head;
    });
    const details = this.columns.map(column => {
      const [, opposition, fingers] = column.split("/");
      return make(
        "th",
        "",
        { scope: "col", title: `${opposition} opposition; virtual finger 2: ${FINGERS[fingers] ?? fingers}` },
        make("span", opposition),
        make("small", fingers),
      );
    });
    return make(
      "thead",
      "",
      {},
      make("tr", "", {}, make("th", "thumb", { rowspan: 2, scope: "col" }), ...categories),
      make("tr", "", {}, ...details),
    );
  }

  row(thumb, counts, cells) {
    const columns = this.columns.map(column => {
      const cell = `${column}/${thumb}`;
      const types = model.header.taxonomy
        .filter(type => type.cell === cell)
        .map(type => this.chip(type, counts.get(type.number) ?? 0));
      const shared = cells.get(cell);
      if (shared)
        types.push(this.button(`? ${shared}`, `${shared} of this cell, but not of one type only`, `cell = "${cell}"`, shared));
      return make("td", "", {}, ...types);
    });
    return make("tr", "", {}, make("th", thumb, { scope: "row" }), ...columns);
  }

  chip(type, count) {
    const title = `${type.number} ${type.name}: ${type.cue}`;
    return this.button(count ? `${type.number}·${count}` : String(type.number), title, `type = ${type.number}`, count);
  }

  button(text, title, query, count) {
    const pressed = state.query === query;
    const onclick = () => setQuery(pressed ? "" : query);
    const button = make("button", text, {
      type: "button",
      class: count ? "chip" : "chip none",
      title,
      "aria-pressed": String(pressed),
      onclick,
    });
    button.style.setProperty("--share", Math.sqrt(count / this.most));
    return button;
  }
}

function showTrust(section) {
  const marks = { good: "●", care: "◐", warning: "▲" };
  const statement = ({ tone, short, long }) =>
    make("details", "", { class: tone, name: "trust" }, make("summary", "", {}, make("i", marks[tone]), short), make("p", long));
  const name = side => (model.sides.length > 1 ? [make("strong", side.name)] : []);
  const rows = model.sides
    .filter(side => side.trust?.length)
    .map(side => make("div", "", {}, ...name(side), ...side.trust.map(statement)));
  section.hidden = rows.length === 0;
  section.replaceChildren(...rows);
}

class RarefactionPanel {
  constructor(section) {
    const [side] = model.sides;
    this.curves = [
      ["groups", PALETTE[0]],
      ["minima", PALETTE[1]],
    ].map(([name, colour]) => ({ name, colour, ...side.rarefaction[name] }));
    this.drawing = new Drawing(section, "Rarefaction: groups and minima found by fewer grasps", (pen, w, h) =>
      this.paint(pen, w, h),
    );
    watch(["look"], () => this.drawing.draw());
  }

  paint(pen, w, h) {
    const curves = this.curves.filter(curve => curve.curve?.length);
    const most = Math.max(1, ...curves.map(curve => curve.curve.at(-1).members));
    const high = 1.1 * Math.max(1, ...curves.flatMap(curve => curve.curve.map(point => point.groups)));
    const x = members => EDGE.left + (w - EDGE.left - 70) * (members / most);
    const y = groups => EDGE.top + (h - EDGE.top - 34) * (1 - groups / high);
    for (const [value, text] of ticks(0, high, 4)) {
      pen.path(
        [
          [EDGE.left - 4, y(value)],
          [w - 70, y(value)],
        ],
        { stroke: look.faint },
      );
      pen.text([EDGE.left - 10, y(value)], text, { fill: look.soft, size: 11.5, anchor: "end" });
    }
    for (const [value, text] of ticks(0, most, 4))
      pen.text([x(value), h - 22], text, { fill: look.soft, size: 11.5, anchor: "middle" });
    pen.text([(x(0) + x(most)) / 2, h - 7], model.sides[0].members_label, { fill: look.soft, size: 11.5, anchor: "middle" });
    for (const { name, colour, curve } of curves) {
      const seen = curve.filter(point => point.deviation !== null);
      const beyond = curve.filter(point => point.deviation === null);
      const at = point => [x(point.members), y(point.groups)];
      const edge = sign => seen.map(point => [x(point.members), y(point.groups + sign * 1.96 * point.deviation)]);
      pen.path([...edge(1), ...edge(-1).reverse()], { fill: colour, alpha: 0.14, close: true });
      pen.path(seen.map(at), { stroke: colour, width: 2 });
      if (beyond.length) pen.path([seen.at(-1), ...beyond].map(at), { stroke: colour, width: 2, dash: [5, 4] });
      const [ex, ey] = at(curve.at(-1));
      pen.text([ex + 6, ey], name, { fill: look.ink, size: 11.5 });
    }
  }
}
