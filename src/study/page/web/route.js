// Ways between minima: through the tree, and along the paths of the spanning forest.

import { NONE } from "./data.js";
import { between } from "./kinematics.js";
import { looked, model, state } from "./state.js";
import { percent, plural } from "./text.js";

/**
 * @typedef {[beside: number, way: number, turned: boolean]} Step
 * @typedef {import("./data.js").Ways & { beside?: Step[][] }} Ways
 * @typedef {{ row: number, way: number, along: number, energy: number }} Point
 * @typedef {{ side: import("./data.js").Landscape, paths: Ways, minima: number[], points: Point[], stops: number[], ways: number[],
 *   length: number, pass: number }} Route `stops` are the points at the minima behind the first, `pass` is the highest point
 */

/** @param {{ parent: Uint32Array }} tree */
export function childrenOf({ parent }) {
  /** @type {number[][]} */
  const children = Array.from(parent, () => []);
  parent.forEach((above, node) => {
    if (above !== NONE) children[above].push(node);
  });
  return children;
}

/**
 * The nodes on the way up from each of two leaves to the node where they meet, and that node.
 *
 * @param {{ parent: Uint32Array }} tree
 * @param {number[]} leaves
 * @returns {{ nodes: number[], top: number | null }}
 */
export function routeInTree({ parent }, [a, b]) {
  const nothing = { nodes: [], top: null };
  if (a === undefined || b === undefined) return nothing;
  /** @param {number} node */
  const up = node => {
    const nodes = [node];
    while ((node = parent[node]) !== NONE) nodes.push(node);
    return nodes;
  };
  const [from, to] = [up(a), up(b)];
  const top = from.find(node => to.includes(node)) ?? null;
  return top === null ? nothing : { nodes: [...from.slice(0, from.indexOf(top)), ...to.slice(0, to.indexOf(top))], top };
}

/** @type {{ key: string, route: Route | null }} */
let lastRoute = { key: "", route: null };

/** The way between two chosen items, or null. Ways lead along the edges of the spanning forest. @param {number[]} selected */
export function routeOf(selected) {
  const key = selected.join();
  if (lastRoute.key !== key) lastRoute = { key, route: foundRoute(selected) };
  return lastRoute.route;
}

/** @param {number[]} selected @returns {Route | null} */
function foundRoute([from, to]) {
  if (from === undefined || to === undefined || model.sideOf(from) !== model.sideOf(to)) return null;
  const [side, a] = model.at(from);
  const [, b] = model.at(to);
  if (!side.ways) return null;
  const paths = side.ways;
  const chain = chainOf(paths, side.count, a, b);
  if (!chain) return null;
  const offset = from - a;
  const [minima, stops, ways] = [[from], /** @type {number[]} */ ([]), chain.map(([way]) => way)];
  /** @type {Point[]} */
  const points = [];
  const { starts, along, energy } = paths;
  for (const [way, turned] of chain) {
    const [first, end] = [starts[way], starts[way + 1]];
    for (let k = first; k < end; k++) {
      const last = points.at(-1);
      // Each way begins where the one before ended.
      if (k === first && last) continue;
      const row = turned ? end - 1 - (k - first) : k;
      const step = last ? Math.abs(along[row] - along[turned ? row + 1 : row - 1]) : 0;
      points.push({ row, way, along: (last?.along ?? 0) + step, energy: energy[row] });
    }
    stops.push(points.length - 1);
    minima.push(offset + (turned ? paths.a[way] : paths.b[way]));
  }
  const length = points.at(-1)?.along || 1;
  const pass = points.reduce((top, point, k) => (point.energy > points[top].energy ? k : top), 0);
  return { side, paths, minima, points, stops, ways, length, pass };
}

// The ways from one minimum to another, each with whether it is walked backward; breadth first, in a forest.
/** @param {Ways} ways @param {number} count @param {number} from @param {number} to */
function chainOf(ways, count, from, to) {
  ways.beside ??= besideOf(ways, count);
  /** @type {Map<number, Step | null>} */
  const came = new Map([[from, null]]);
  const waiting = [from];
  for (const at of waiting) {
    if (at === to) break;
    for (const [next, way, turned] of ways.beside[at]) {
      if (came.has(next)) continue;
      came.set(next, [at, way, turned]);
      waiting.push(next);
    }
  }
  /** @type {[way: number, turned: boolean][]} */
  const chain = [];
  for (let step = came.get(to); step; step = came.get(step[0])) chain.unshift([step[1], step[2]]);
  return chain.length ? chain : null;
}

/** @param {Ways} ways @param {number} count */
function besideOf(ways, count) {
  /** @type {Step[][]} */
  const beside = Array.from({ length: count }, () => []);
  ways.a.forEach((a, way) => {
    beside[a].push([ways.b[way], way, false]);
    beside[ways.b[way]].push([a, way, true]);
  });
  return beside;
}

// The coordinates at a place on a way, 0 to 1.
/** @param {Route} route @param {number} step @returns {Float64Array} */
export function onRoute(route, step) {
  const { paths, side } = route;
  const { kind, dimensions } = side.space;
  const along = step * route.length;
  let k = route.points.findIndex(point => point.along >= along);
  if (k < 0) k = route.points.length - 1;
  /** @param {Point} point */
  const at = point => paths.coordinates.subarray(point.row * dimensions, (point.row + 1) * dimensions);
  if (k === 0) return at(route.points[0]);
  const [p, q] = [route.points[k - 1], route.points[k]];
  const part = q.along > p.along ? (along - p.along) / (q.along - p.along) : 1;
  return between(at(p), at(q), part, kind === "pose");
}

// The way that is shown: that of the chosen items, while nothing else is under the pointer.
export function shownRoute() {
  return state.hover === null ? routeOf(state.selected) : null;
}

// The item that the view shows: the one that is looked at, or the start of the way.
export function shownItem() {
  return shownRoute() && state.step < 1 ? state.selected[0] : looked();
}

/** What independent searches say of a merge, without a full stop. @param {import("./data.js").Tree} tree @param {number} node */
export function searchesAcross(tree, node) {
  const searches = tree.searches[node];
  if (!searches) return "not searched: no search looked for a lower way";
  const chance = percent(1 - tree.support[node]);
  const found = `${tree.ended[node]} of ${plural(searches, "independent search", "independent searches")} ended at this height`;
  return `${found}; the chance that a lower way exists is ${chance}`;
}
