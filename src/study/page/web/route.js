// Ways between minima: through the tree, and along the paths of the spanning forest.

import { NONE } from "./data.js";
import { between } from "./kinematics.js";
import { looked, model, state } from "./state.js";
import { percent, plural } from "./text.js";

export function childrenOf({ parent }) {
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
 */
export function routeInTree({ parent }, [a, b]) {
  const nothing = { nodes: [], top: null };
  if (a === undefined || b === undefined) return nothing;
  const up = node => {
    const nodes = [node];
    while (parent[nodes.at(-1)] !== NONE) nodes.push(parent[nodes.at(-1)]);
    return nodes;
  };
  const [from, to] = [up(a), up(b)];
  const top = from.find(node => to.includes(node)) ?? null;
  return top === null ? nothing : { nodes: [...from.slice(0, from.indexOf(top)), ...to.slice(0, to.indexOf(top))], top };
}

let lastRoute = { key: "", route: null };

// The way between two chosen items: its minima and points, or null. Ways lead along the edges of the spanning forest.
export function routeOf(selected) {
  const key = selected.join();
  if (lastRoute.key !== key) lastRoute = { key, route: foundRoute(selected) };
  return lastRoute.route;
}

function foundRoute([from, to]) {
  if (from === undefined || to === undefined || model.sideOf(from) !== model.sideOf(to)) return null;
  const [side, a] = model.at(from);
  const [, b] = model.at(to);
  const chain = side.ways && chainOf(side.ways, side.count, a, b);
  if (!chain) return null;
  const offset = from - a;
  const route = { side, minima: [from], points: [], stops: [], ways: chain.map(([way]) => way) };
  const { starts, along, energy } = side.ways;
  for (const [way, turned] of chain) {
    const [first, end] = [starts[way], starts[way + 1]];
    for (let k = first; k < end; k++) {
      const last = route.points.at(-1);
      // Each way begins where the one before ended.
      if (k === first && last) continue;
      const row = turned ? end - 1 - (k - first) : k;
      const step = last ? Math.abs(along[row] - along[turned ? row + 1 : row - 1]) : 0;
      route.points.push({ row, way, along: (last?.along ?? 0) + step, energy: energy[row] });
    }
    route.stops.push(route.points.length - 1);
    route.minima.push(offset + (turned ? side.ways.a[way] : side.ways.b[way]));
  }
  route.length = route.points.at(-1).along || 1;
  route.pass = route.points.reduce((top, point, k) => (point.energy > route.points[top].energy ? k : top), 0);
  return route;
}

// The ways from one minimum to another, each with whether it is walked backward; breadth first, in a forest.
function chainOf(ways, count, from, to) {
  ways.beside ??= besideOf(ways, count);
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
  if (from === to || !came.has(to)) return null;
  const chain = [];
  for (let at = to; came.get(at); at = came.get(at)[0]) chain.unshift(came.get(at).slice(1));
  return chain;
}

function besideOf(ways, count) {
  const beside = Array.from({ length: count }, () => []);
  ways.a.forEach((a, way) => {
    beside[a].push([ways.b[way], way, false]);
    beside[ways.b[way]].push([a, way, true]);
  });
  return beside;
}

// The coordinates at a place on a way, 0 to 1.
export function onRoute(route, step) {
  const { ways, space } = route.side;
  const along = step * route.length;
  let k = route.points.findIndex(point => point.along >= along);
  if (k < 0) k = route.points.length - 1;
  const at = point => ways.coordinates.subarray(point.row * space.dimensions, (point.row + 1) * space.dimensions);
  if (k === 0) return at(route.points[0]);
  const [p, q] = [route.points[k - 1], route.points[k]];
  const part = q.along > p.along ? (along - p.along) / (q.along - p.along) : 1;
  return between(at(p), at(q), part, space.kind === "pose");
}

// The way that is shown: that of the chosen items, while nothing else is under the pointer.
export function shownRoute() {
  return state.hover === null ? routeOf(state.selected) : null;
}

// The item that the view shows: the one that is looked at, or the start of the way.
export function shownItem() {
  return shownRoute() && state.step < 1 ? state.selected[0] : looked();
}

// What independent searches say of a merge, without a full stop.
export function searchesAcross(tree, node) {
  const searches = tree.searches[node];
  if (!searches) return "not searched: no search looked for a lower way";
  const chance = percent(1 - tree.support[node]);
  const found = `${tree.ended[node]} of ${plural(searches, "independent search", "independent searches")} ended at this height`;
  return `${found}; the chance that a lower way exists is ${chance}`;
}
