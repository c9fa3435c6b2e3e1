// The panels that show views in three dimensions: the grasp that is looked at, and the pinned ones with the same camera.

import { NONE } from "./data.js";
import { addTools, button, contextOf, headingOf, make, still, tool } from "./dom.js";
import { between } from "./kinematics.js";
import { family } from "./looks.js";
import { onRoute, shownItem, shownRoute } from "./route.js";
import { GLIDE_MS, View, webglWorks } from "./scene.js";
import { change, looked, model, pin, select, state, watch } from "./state.js";
import { plain, shown } from "./text.js";
import { described } from "./words.js";

export const FIRST_CAMERA = [-58, 18, 1];
const ZOOM = [0.4, 12];

/**
 * What a view shows: the scene of an item at some coordinates, and the item whose contacts and family are shown, if any.
 *
 * @typedef {{ scene: number, x: Float32Array | Float64Array, item: number | null, touched: number | null, onWay: boolean }} Target
 */

const camera = () => state.camera ?? FIRST_CAMERA;

/** Turns the camera of all views by degrees and enlarges. @param {number} azimuth @param {number} elevation @param {number} factor */
function turn(azimuth, elevation, factor) {
  const [a, e, zoom] = camera();
  /** @param {number} low @param {number} value @param {number} high */
  const within = (low, value, high) => Math.max(low, Math.min(high, value));
  change({
    camera: [(((a + azimuth) % 360) + 360) % 360, within(-89.9, e + elevation, 89.9), within(ZOOM[0], zoom * factor, ZOOM[1])],
  });
}

/** Lets a canvas turn the camera: by dragging, the wheel and keys. @param {HTMLCanvasElement} canvas */
function turnable(canvas) {
  /** @type {[number, number] | null} */
  let last = null;
  canvas.addEventListener("pointerdown", event => {
    last = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointerup", () => {
    last = null;
  });
  canvas.addEventListener("pointermove", event => {
    if (!last) return;
    turn(-0.5 * (event.clientX - last[0]), 0.5 * (event.clientY - last[1]), 1);
    last = [event.clientX, event.clientY];
  });
  /** @param {WheelEvent} event */
  const wheel = event => {
    event.preventDefault();
    turn(0, 0, event.deltaY > 0 ? 1 / 1.1 : 1.1);
  };
  canvas.addEventListener("wheel", wheel, { passive: false });
  canvas.addEventListener("keydown", event => {
    /** @type {Record<string, [number, number, number]>} */
    const moves = {
      ArrowLeft: [-6, 0, 1],
      ArrowRight: [6, 0, 1],
      ArrowUp: [0, 6, 1],
      ArrowDown: [0, -6, 1],
      "+": [0, 0, 1.15],
      "-": [0, 0, 1 / 1.15],
    };
    if (!(event.key in moves)) return;
    event.preventDefault();
    turn(...moves[event.key]);
  });
  canvas.addEventListener("dblclick", () => change({ camera: null }));
}

// The grasp under the pointer (or chosen last, or on the way). With two landscapes there are two views side by side.
export class ScenePanel {
  /** @param {HTMLElement} section */
  constructor(section) {
    this.atoms = model.sides[0].space.kind === "atoms";
    if (this.atoms) headingOf(section).textContent = "Atoms";
    this.box = make("div", "", { class: "views" });
    this.caption = make("p", "", { class: "caption", "aria-live": "polite" });
    this.cones = tool("Cones", "Show the friction cones of the contacts", () => change({ cones: !state.cones }));
    section.append(this.box, this.caption);
    /** @type {View[] | undefined} */
    this.views = undefined;
    if (!webglWorks()) {
      const words =
        "This browser cannot draw in three dimensions (WebGL is missing or switched off). Tree, graph and table work without it.";
      this.box.append(make("p", words, { class: "alone" }));
      watch(["hover", "selected", "step", "level", "query", "sort", "labels"], () => this.say());
      return;
    }
    this.views = model.sides.map((_, number) => this.view(number));
    this.tools(section);
    watch(["hover", "selected", "step", "level", "query", "sort", "labels", "cones", "camera", "look"], () => this.show());
  }

  /** @param {number} number */
  view(number) {
    const words = this.atoms ? "The atoms in three dimensions" : "The grasp in three dimensions";
    const canvas = make("canvas", "", { tabindex: 0, role: "img", "aria-label": words });
    this.box.append(canvas);
    turnable(canvas);
    const view = new View(canvas, number);
    new ResizeObserver(() => this.draw(view)).observe(canvas);
    return view;
  }

  /** @param {HTMLElement} section */
  tools(section) {
    addTools(
      section,
      ...(this.atoms ? [] : [this.cones]),
      tool("Reset", "The camera of the start", () => change({ camera: null })),
      tool("−", "Smaller", () => turn(0, 0, 1 / 1.2)),
      tool("+", "Larger", () => turn(0, 0, 1.2)),
      tool("Pin", `Pin ${this.atoms ? "these atoms" : "this grasp"}, or take the pin away (p)`, () => pin(looked())),
    );
  }

  // What a view shows: a place on the way if there is one and nothing is under the pointer, else an item, if there is one.
  /** @param {View} view @returns {Target | null} */
  target(view) {
    const item = looked();
    if (model.sides.length > 1 && model.sideOf(item) !== view.side) {
      const partner = model.partner[item];
      return partner === NONE ? null : this.standing(partner);
    }
    const route = shownRoute();
    if (!route) return this.standing(item);
    const [from, to] = state.selected;
    if (state.step <= 0) return this.standing(from);
    const end = state.step >= 1 ? to : null;
    return { scene: from, x: onRoute(route, state.step), item: end, touched: end, onWay: true };
  }

  // The touched places are those of the grasp as it stands in its own landscape.
  /** @param {number} item @returns {Target} */
  standing(item) {
    const beside = model.besidePartner(item);
    return { scene: item, x: beside ?? model.coordinates(item), item, touched: beside ? null : item, onWay: false };
  }

  show() {
    for (const view of this.views ?? []) {
      const target = this.target(view);
      view.canvas.classList.toggle("missing", !target);
      if (target) this.put(view, target);
      this.draw(view);
    }
    this.cones.setAttribute("aria-pressed", String(state.cones));
    this.say();
  }

  /** @param {View} view @param {Target} target */
  put(view, target) {
    const { scene, x, item, touched, onWay } = target;
    if (this.atoms) return view.atoms(x);
    view.setScene(scene);
    if (this.glides(view, target)) this.glide(view, x, touched);
    else {
      view.stop();
      view.pose(x);
      view.touch(touched, state.cones);
    }
    view.target = x;
    const kin = onWay ? null : family(item);
    view.family(kin && kin.length > 1 ? kin : null, item);
  }

  /** Whether the hand is to move to a pose, or to be there at once. @param {View} view @param {Target} target */
  glides({ target, gliding, x: from }, { x, onWay }) {
    if (target && x.every((value, k) => value === target[k])) return gliding !== 0;
    return from.length === x.length && !onWay && !still();
  }

  /** Moves the hand from where it is to a pose. @param {View} view @param {Target["x"]} to @param {number | null} item */
  glide(view, to, item) {
    if (view.gliding && view.target === to) return;
    view.stop();
    const from = view.x;
    const started = performance.now();
    view.touch(null);
    /** @param {number} now */
    const step = now => {
      const t = Math.min(1, (now - started) / GLIDE_MS);
      const eased = t * t * (3 - 2 * t);
      view.pose(t < 1 ? between(from, to, eased, true) : to);
      view.gliding = t < 1 ? requestAnimationFrame(step) : 0;
      if (t >= 1) view.touch(item, state.cones);
      this.draw(view);
    };
    view.gliding = requestAnimationFrame(step);
  }

  /** @param {View} view */
  draw(view) {
    view.lookFrom(camera());
    view.render();
  }

  say() {
    const item = shownItem();
    if (shownRoute() && state.step > 0 && state.step < 1) {
      const [from, to] = state.selected.map(end => model.name(end));
      this.caption.textContent = `${Math.round(100 * state.step)} % of the way from ${from} to ${to}`;
      return;
    }
    const kin = family(item);
    const words = described(item);
    if (kin && kin.length > 1 && state.level !== null)
      words.push(`the pale hands are the other ${kin.length - 1} of this family (level ${shown(state.level, 3)}); orange: where they touch`);
    if (model.sides.length > 1 && model.partner[item] === NONE) words.push("has no counterpart in the other landscape");
    this.caption.textContent = words.join(" · ");
  }
}

// Pictures of items, drawn by one hidden view: with the camera of all views, or from a side of their own and then as large
// as they fit.
export const stamps = {
  /** @type {View | null | undefined} */
  view: undefined,
  /** @param {HTMLCanvasElement} canvas @param {number} item @param {number[] | null} from */
  draw(canvas, item, from = null) {
    if (this.view === undefined) this.view = webglWorks() ? new View(make("canvas")) : null;
    if (!this.view) return;
    const scale = Math.min(2, devicePixelRatio || 1);
    const [width, height] = [canvas.clientWidth || 200, canvas.clientHeight || 170];
    if (model.at(item)[0].space.kind === "atoms") this.view.atoms(model.coordinates(item));
    else {
      this.view.setScene(item);
      this.view.touch(item, state.cones);
      this.view.frame(item, from !== null);
      this.view.pose(model.coordinates(item));
    }
    this.view.lookFrom(from ?? camera(), width, height);
    this.view.render(width, height, scale);
    [canvas.width, canvas.height] = [Math.round(width * scale), Math.round(height * scale)];
    contextOf(canvas).drawImage(this.view.canvas, 0, 0);
  },
};

export class PinsPanel {
  /** @param {HTMLElement} section */
  constructor(section) {
    this.section = section;
    this.row = make("div", "", { class: "pins" });
    section.append(this.row);
    watch(["pins", "labels"], () => this.show());
    watch(["camera", "cones", "look"], () => this.draw());
  }

  show() {
    this.section.hidden = state.pins.length === 0;
    this.row.replaceChildren(...state.pins.map(item => this.figure(item)));
    this.draw();
  }

  /** @param {number} item */
  figure(item) {
    const [name, label] = [model.name(item), plain(model.text("label", item))];
    const canvas = make("canvas", "", { tabindex: 0, role: "img", "aria-label": "Pinned " + name, "data-item": item });
    turnable(canvas);
    const caption = make(
      "figcaption",
      "",
      {},
      button(label ? `${name} · ${label}` : name, () => select(item)),
      make("small", "energy " + shown(model.energy(item))),
      button("×", () => pin(item), { "aria-label": `Take the pin of ${name} away` }),
    );
    const hovers = { onpointerenter: () => change({ hover: item }), onpointerleave: () => change({ hover: null }) };
    return make("figure", "", hovers, canvas, caption);
  }

  draw() {
    for (const canvas of this.row.querySelectorAll("canvas")) stamps.draw(canvas, Number(canvas.dataset.item));
  }
}
