import assert from "node:assert/strict";
import { test } from "node:test";
import { basinsAt } from "../web/basins.js";
import { NONE } from "../web/data.js";
import { rangesOf } from "../web/legend.js";
import { childrenOf, routeInTree, routeOf, searchesAcross } from "../web/route.js";
import { setModel } from "../web/state.js";
import { apart } from "../web/tangle.js";
import { model, tree } from "./made.js";

test("leaves meet at their lowest common node", () => {
  assert.deepEqual(childrenOf(tree).slice(4), [[0, 1], [2, 4], [3, 5]]);
  assert.deepEqual(routeInTree(tree, [1, 2]), { nodes: [1, 4, 2], top: 5 });
  assert.deepEqual(routeInTree(tree, [1]), { nodes: [], top: null });
});

test("a way leads over all the minima between its ends", () => {
  setModel(model());
  const route = routeOf([3, 2]);
  assert.deepEqual(route.minima, [3, 0, 1, 2]);
  assert.deepEqual(route.points.map(({ along }) => along), [0, 1, 2, 3, 4]);
  assert.deepEqual([route.length, route.points[route.pass].energy, route.stops], [4, 2, [1, 2, 4]]);
  assert.equal(routeOf([0]), null);
});

test("superbasins are those below the level, and keep their colours", () => {
  const at = level => basinsAt(model(), level);
  assert.deepEqual(at(1.5).list, [[0, 1]]);
  assert.deepEqual([...at(2.5).top], [5, 5, 5, 3]);
  assert.deepEqual([...at(0.4).top], [0, NONE, 2, 3]);
  assert.equal(at(1.5).colour[0], at(2.5).colour[0]);
  assert.equal(at(null), null);
});

test("a merge says what the searches found", () => {
  const searched = { searches: [8, 0], ended: [6, 0], support: [0.5, NaN] };
  assert.equal(searchesAcross(searched, 0), "6 of 8 independent searches ended at this height; the chance that a lower way exists is 50 %");
  assert.match(searchesAcross(searched, 1), /^not searched/);
});

test("no two edges of ranges are the same number", () => {
  const [first, second] = rangesOf("energy", [-1034.21, -1033.9]);
  assert.deepEqual([first.words, first.chip], ["below −1034.148", "energy < -1034.148"]);
  assert.deepEqual([second.words, second.chip], ["−1034.148 to −1034.086", "energy ≥ -1034.148 and energy < -1034.086"]);
  assert.deepEqual(rangesOf("energy", [1, 1]), []);
});

test("distances of poses are lengths", () => {
  assert.deepEqual([apart(0.005012, { kind: "pose" }), apart(0.25, { kind: "points" })], ["5.01 mm", "0.250"]);
});
