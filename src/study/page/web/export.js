// Files to save: panels as SVG or PNG, the table as CSV, a grasp as GLB; and the command line that makes the same.
"use strict";

function save(name, type, content) {
  const link = make("a", "", { download: name });
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 2000);
}

function saveCanvas(name, canvas) {
  const letters = atob(canvas.toDataURL("image/png").split(",")[1]);
  save(
    name,
    "image/png",
    Uint8Array.from(letters, letter => letter.charCodeAt(0)),
  );
}

// The selection as CSV: what passes the filter, or only the chosen items.
function csv(items) {
  const [side] = model.sides;
  const terms = side.terms?.length ? side.term_names : [];
  const fields = ["energy", "group", "members", "epsilon", "stable", "joins", "support"].filter(field =>
    items.some(item => !Number.isNaN(model.number(field, item))),
  );
  const head = ["name", ...fields, ...terms.map(term => "term_" + term), "label", "evidence", "ids"];
  const number = value => (Number.isNaN(value) ? "" : String(value));
  const rows = items.map(item => {
    const [own, k] = model.at(item);
    return [
      model.name(item),
      ...fields.map(field => number(model.number(field, item))),
      ...terms.map((_, term) => number(own.terms[k * terms.length + term])),
      model.text("label", item),
      model.evidence(item),
      own.members[k] ?? "",
    ]
      .map(cell => quoted(cell))
      .join(",");
  });
  return [head.join(","), ...rows].join("\n") + "\n";
}

function passing() {
  const items = [];
  for (let item = 0; item < model.count; item++) if (derived.passes[item]) items.push(item);
  return items;
}

// A scene as binary glTF 2.0: hand and object as meshes in metres, z up turned into y up.
function glb(item) {
  const pair = model.scene(item);
  const skin = poseSkin(
    pair.hand,
    poseLinks(pair.hand, model.coordinates(item)),
    new Float32Array(3 * pair.hand.skin.count.length),
  );
  const parts = [
    { name: "hand", positions: skin, indices: pair.hand.skin.triangles, colour: [0.81, 0.51, 0.36] },
    { name: "object", positions: pair.object.vertices, indices: pair.object.triangles, colour: [0.22, 0.38, 0.52] },
  ];
  const json = {
    asset: { version: "2.0", generator: model.header.made_by },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ name: "grasp " + model.name(item), rotation: [-Math.SQRT1_2, 0, 0, Math.SQRT1_2], children: [1, 2] }],
    meshes: [],
    materials: [],
    accessors: [],
    bufferViews: [],
    buffers: [{ byteLength: 0 }],
  };
  const arrays = [];
  const view = (array, target) => {
    const { byteLength } = json.buffers[0];
    json.bufferViews.push({ buffer: 0, byteOffset: byteLength, byteLength: array.byteLength, target });
    json.buffers[0].byteLength += array.byteLength;
    arrays.push(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    return json.bufferViews.length - 1;
  };
  parts.forEach(({ name, positions, indices, colour }, k) => {
    const bound = pick =>
      [0, 1, 2].map(axis =>
        positions.reduce(
          (best, value, j) => (j % 3 === axis ? pick(best, value) : best),
          pick(Infinity, -Infinity) === Infinity ? -Infinity : Infinity,
        ),
      );
    json.accessors.push({
      bufferView: view(positions, 34962),
      componentType: 5126,
      count: positions.length / 3,
      type: "VEC3",
      min: bound(Math.min),
      max: bound(Math.max),
    });
    json.accessors.push({ bufferView: view(indices, 34963), componentType: 5125, count: indices.length, type: "SCALAR" });
    json.materials.push({
      doubleSided: true,
      pbrMetallicRoughness: { baseColorFactor: [...colour, 1], metallicFactor: 0, roughnessFactor: 0.8 },
    });
    json.meshes.push({ primitives: [{ attributes: { POSITION: 2 * k }, indices: 2 * k + 1, material: k }] });
    json.nodes.push({ name, mesh: k });
  });
  const text = new TextEncoder().encode(JSON.stringify(json));
  const padded = (4 - (text.length % 4)) % 4;
  const size = 28 + text.length + padded + json.buffers[0].byteLength;
  const file = new DataView(new ArrayBuffer(size));
  const bytes = new Uint8Array(file.buffer);
  [0x46546c67, 2, size, text.length + padded, 0x4e4f534a].forEach((word, k) => file.setUint32(4 * k, word, true));
  bytes.fill(32, 20, 20 + text.length + padded);
  bytes.set(text, 20);
  let at = 20 + text.length + padded;
  file.setUint32(at, json.buffers[0].byteLength, true);
  file.setUint32(at + 4, 0x004e4942, true);
  at += 8;
  for (const array of arrays) {
    bytes.set(array, at);
    at += array.length;
  }
  return bytes;
}

// A word for the shell.
function word(text) {
  return /^[\w./:=,+@%-]+$/.test(text) && !text.startsWith("-") ? text : "'" + text.replaceAll("'", "'\\''") + "'";
}

function pathCommand() {
  return `landscape inspect ${word(model.sides[0].name)} --path ${state.selected.map(item => model.name(item)).join(" ")}`;
}

// Command lines that make what is seen.
function commands() {
  const [side] = model.sides;
  if (side.item === "grasp") {
    const chosen = state.selected.map(item => ` --grasp ${side.members[model.at(item)[1]]}`).join("");
    return [model.header.command, ...(chosen ? [`landscape export ${word(side.name)} glb${chosen}`] : [])];
  }
  const picked = state.query ? passing() : state.selected.length ? state.selected : [];
  const names = picked.filter(item => model.sideOf(item) === 0).map(item => model.name(item));
  const draw = `landscape draw ${word(side.name)}${names.length && names.length < side.count ? " --pick " + names.join(",") : ""}`;
  const two = state.selected.length === 2 && side.space.kind === "pose" && model.sides.length === 1;
  return [model.header.command, draw, ...(two ? [pathCommand()] : [])];
}

function openExport(panels) {
  const dialog = byId("export");
  const line = (title, ...buttons) => make("div", "", { class: "line" }, make("span", title), ...buttons);
  const button = (text, id, onclick) => make("button", text, { type: "button", id: "save-" + id, onclick });
  const lines = [];
  for (const [name, title] of [
    ["tree", "Disconnectivity graph"],
    ["graph", "Barrier graph"],
    ["tangle", "Two trees"],
    ["way", "Lowest way"],
    ["flat", "Surface"],
    ["rarefaction", "Rarefaction"],
  ]) {
    const panel = panels[name];
    if (!panel || byId(name).hidden) continue;
    lines.push(
      line(
        title,
        button("SVG", name + "-svg", () => save(name + ".svg", "image/svg+xml", panel.drawing.svg())),
        button("PNG", name + "-png", () => saveCanvas(name + ".png", panel.drawing.canvas)),
      ),
    );
  }
  if (panels.scene?.views) {
    const item = shownItem();
    const buttons = [button("PNG", "scene-png", () => saveCanvas("grasp.png", panels.scene.views[0].canvas))];
    if (model.scene(item))
      buttons.push(
        button("GLB", "scene-glb", () => save(`grasp-${model.name(item).replace("#", "")}.glb`, "model/gltf-binary", glb(item))),
      );
    lines.push(line(`View of ${model.name(item)}`, ...buttons));
  }
  const chosen = state.selected.length ? state.selected : passing();
  lines.push(
    line(
      state.selected.length ? "The chosen rows" : `${chosen.length} rows that pass the filter`,
      button("CSV", "csv", () => save("selection.csv", "text/csv", csv(chosen))),
    ),
  );
  const link = make("input", "", {
    readonly: true,
    "aria-label": "Link to this state",
    id: "link",
    onfocus: event => event.target.select(),
  });
  link.value = location.href.split("#")[0] + "#" + fragment();
  const code = make("pre", commands().join("\n"), { id: "commands", tabindex: 0 });
  dialog.replaceChildren(
    make("h2", "Export"),
    ...lines,
    make("h3", "Link to this state"),
    link,
    make("h3", "Command lines that make this"),
    code,
    make("form", "", { method: "dialog" }, make("button", "Close", { class: "main" })),
  );
  dialog.showModal();
}
