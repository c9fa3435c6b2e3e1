// Files to save: panels as SVG or PNG, the table as CSV, a grasp as GLB; and the command line that makes the same.

import { button, byId, headingOf, make, showDialog, the } from "./dom.js";
import { poseLinks, poseSkin } from "./kinematics.js";
import { shownItem } from "./route.js";
import { fragment, model, passing, state } from "./state.js";
import { plural, quoted, word } from "./text.js";

/** @param {string} name @param {string} type @param {BlobPart} content */
export function save(name, type, content) {
  const link = make("a", "", { download: name });
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 2000);
}

/** @param {string} name @param {HTMLCanvasElement} canvas */
function saveCanvas(name, canvas) {
  const letters = atob(canvas.toDataURL("image/png").split(",")[1]);
  save(
    name,
    "image/png",
    Uint8Array.from(letters, letter => letter.charCodeAt(0)),
  );
}

/** The selection as CSV: what passes the filter, or only the chosen items. @param {number[]} items */
function csv(items) {
  const [side] = model.sides;
  const terms = (side.terms?.length && side.term_names) || [];
  const fields = ["energy", "family", "members", "epsilon", "stable", "joins", "support"].filter(field =>
    items.some(item => !Number.isNaN(model.number(field, item))),
  );
  const head = ["name", ...fields, ...terms.map(term => "term_" + term), "label", "evidence", "ids"];
  const number = (value = NaN) => (Number.isNaN(value) ? "" : String(value));
  const rows = items.map(item => {
    const [own, k] = model.at(item);
    return [
      model.name(item),
      ...fields.map(field => number(model.number(field, item))),
      ...terms.map((_, term) => number(own.terms?.[k * terms.length + term])),
      model.text("label", item),
      model.evidence(item),
      own.members[k] ?? "",
    ]
      .map(cell => quoted(cell))
      .join(",");
  });
  return [head.join(","), ...rows].join("\n") + "\n";
}

// A scene as binary glTF 2.0: hand and object as meshes in metres, z up turned into y up.
/** @param {number} item @param {import("./data.js").Pair} pair */
function glb(item, { hand, object }) {
  const skin = poseSkin(hand, poseLinks(hand, model.coordinates(item)), new Float32Array(3 * hand.skin.count.length));
  const parts = [
    { name: "hand", positions: skin, indices: hand.skin.triangles, colour: [0.81, 0.51, 0.36] },
    { name: "object", positions: object.vertices, indices: object.triangles, colour: [0.22, 0.38, 0.52] },
  ];
  const json = {
    asset: { version: "2.0", generator: model.header.made_by },
    scene: 0,
    scenes: [{ nodes: [0] }],
    /** @type {object[]} */
    nodes: [{ name: "grasp " + model.name(item), rotation: [-Math.SQRT1_2, 0, 0, Math.SQRT1_2], children: [1, 2] }],
    /** @type {object[]} */
    meshes: [],
    /** @type {object[]} */
    materials: [],
    /** @type {object[]} */
    accessors: [],
    /** @type {object[]} */
    bufferViews: [],
    buffers: [{ byteLength: 0 }],
  };
  /** @type {Uint8Array[]} */
  const arrays = [];
  /** @param {Float32Array | Uint32Array} array @param {number} target */
  const view = (array, target) => {
    const { byteLength } = json.buffers[0];
    json.bufferViews.push({ buffer: 0, byteOffset: byteLength, byteLength: array.byteLength, target });
    json.buffers[0].byteLength += array.byteLength;
    arrays.push(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    return json.bufferViews.length - 1;
  };
  parts.forEach(({ name, positions, indices, colour }, k) => {
    const [min, max] = [new Array(3).fill(Infinity), new Array(3).fill(-Infinity)];
    positions.forEach((value, j) => {
      min[j % 3] = Math.min(min[j % 3], value);
      max[j % 3] = Math.max(max[j % 3], value);
    });
    json.accessors.push({
      bufferView: view(positions, 34962),
      componentType: 5126,
      count: positions.length / 3,
      type: "VEC3",
      min,
      max,
    });
    json.accessors.push({ bufferView: view(indices, 34963), componentType: 5125, count: indices.length, type: "SCALAR" });
    json.materials.push({
      doubleSided: true,
      pbrMetallicRoughness: { baseColorFactor: [...colour, 1], metallicFactor: 0, roughnessFactor: 0.8 },
    });
    json.meshes.push({ primitives: [{ attributes: { POSITION: 2 * k }, indices: 2 * k + 1, material: k }] });
    json.nodes.push({ name, mesh: k });
  });
  // The file: a head, the JSON filled up with spaces, and the arrays.
  const text = new TextEncoder().encode(JSON.stringify(json));
  const length = Math.ceil(text.length / 4) * 4;
  const bytes = new Uint8Array(28 + length + json.buffers[0].byteLength);
  /** @param {number} at @param {number[]} values */
  const numbers = (at, ...values) => new Uint32Array(bytes.buffer, at, values.length).set(values);
  numbers(0, 0x46546c67, 2, bytes.length, length, 0x4e4f534a);
  bytes.fill(32, 20, 20 + length);
  bytes.set(text, 20);
  numbers(20 + length, json.buffers[0].byteLength, 0x004e4942);
  let at = 28 + length;
  for (const array of arrays) {
    bytes.set(array, at);
    at += array.length;
  }
  return bytes;
}

export function pathCommand() {
  return `landscape inspect ${word(model.sides[0].name)} --path ${state.selected.map(item => model.name(item)).join(" ")}`;
}

// Command lines that make what is seen.
function commands() {
  const [side] = model.sides;
  if (side.item === "grasp") {
    const chosen = state.selected.map(item => ` --grasp ${side.members[model.at(item)[1]]}`).join("");
    return [model.header.command, ...(chosen ? [`landscape export ${word(side.name)} glb${chosen}`] : [])];
  }
  const picked = state.query ? passing() : state.selected;
  const names = picked.filter(item => model.sideOf(item) === 0).map(item => model.name(item));
  const draw = `landscape draw ${word(side.name)}${names.length && names.length < side.count ? " --pick " + names.join(",") : ""}`;
  const two = state.selected.length === 2 && side.space.kind === "pose" && model.sides.length === 1;
  return [model.header.command, draw, ...(two ? [pathCommand()] : [])];
}

/** @param {import("./main.js").Panels} panels */
export function openExport(panels) {
  const dialog = the(HTMLDialogElement, "export");
  /** @param {string} title @param {Node[]} buttons */
  const line = (title, ...buttons) => make("div", "", { class: "line" }, make("span", title), ...buttons);
  /** @param {string} text @param {string} id @param {() => void} onclick */
  const to = (text, id, onclick) => button(text, onclick, { id: "save-" + id });
  const pictures = /** @type {const} */ (["tree", "graph", "tangle", "likeness", "way", "flat", "rarefaction"]);
  const lines = pictures.flatMap(name => {
    const drawing = panels[name]?.drawing;
    const section = byId(name);
    if (!drawing || section.hidden) return [];
    return line(
      headingOf(section).textContent,
      to("SVG", name + "-svg", () => save(name + ".svg", "image/svg+xml", drawing.svg())),
      to("PNG", name + "-png", () => saveCanvas(name + ".png", drawing.canvas)),
    );
  });
  const views = panels.scene?.views;
  if (views) {
    const item = shownItem();
    const pair = model.scene(item);
    const file = `grasp-${model.name(item).replace("#", "")}.glb`;
    const glTF = pair ? [to("GLB", "scene-glb", () => save(file, "model/gltf-binary", glb(item, pair)))] : [];
    const png = to("PNG", "scene-png", () => saveCanvas("grasp.png", views[model.sideOf(item)].canvas));
    lines.push(line("View of " + model.name(item), png, ...glTF));
  }
  const chosen = state.selected.length ? state.selected : passing();
  const words = state.selected.length ? "The chosen rows" : plural(chosen.length, "row", "rows") + " of the table";
  lines.push(
    line(
      words,
      to("CSV", "csv", () => save("selection.csv", "text/csv", csv(chosen))),
    ),
  );
  const link = make("input", "", { readonly: true, "aria-label": "Link to this state", id: "link" });
  link.addEventListener("focus", () => link.select());
  link.value = location.href.split("#")[0] + "#" + fragment();
  showDialog(dialog, "Export", [
    ...lines,
    make("h3", "Link to this state"),
    link,
    make("h3", "Command lines that make this"),
    make("pre", commands().join("\n"), { id: "commands", tabindex: 0 }),
  ]);
}
