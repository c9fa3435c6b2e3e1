import assert from "node:assert/strict";
import { test } from "node:test";
import { leastSureFirst, nextAsked, placesAfter } from "../web/asked.js";

test("first comes what the labeller is least sure of", () => {
  assert.deepEqual(leastSureFirst([0.9, 0.2, 0.5, 0.2, 1]), [1, 3, 2, 0, 4]);
  assert.deepEqual(leastSureFirst([0, 1, 0.5, 0]), [2, 1, 0, 3], "what has no answer comes last");
  for (const equal of [[], [0.4], [0, 0, 0], [0.3, 0.3]]) assert.equal(leastSureFirst(equal), null);
});

test("labelled items are passed over, and those that a person left come again at the end", () => {
  const labels = new Set([1]);
  const left = new Set();
  const next = () => nextAsked([1, 3, 2, 0], left, place => labels.has(place));
  assert.equal(next(), 3);
  left.add(3);
  assert.equal(next(), 2);
  labels.add(2);
  left.add(0);
  assert.equal(next(), 3);
  labels.add(3);
  assert.equal(next(), 0);
  labels.add(0);
  assert.equal(next(), undefined);
});

test("the order of items goes round", () => {
  assert.deepEqual(placesAfter(1, 4), [2, 3, 0, 1]);
  assert.equal(nextAsked(placesAfter(2, 3), new Set(), place => place === 0), 1);
});
