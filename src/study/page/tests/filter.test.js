import assert from "node:assert/strict";
import { test } from "node:test";
import { basinsAt } from "../web/basins.js";
import { compiled, examples, known } from "../web/filter.js";
import { model } from "./made.js";

const items = [0, 1, 2, 3];
function found(text, { of = model(), level = null, pins = [] } = {}) {
  const { test, problem } = compiled(text, of, { basins: basinsAt(of, level), pins });
  return problem || items.filter(test).join(" ");
}

test("words, comparisons and their combinations", () => {
  const expected = {
    "": "0 1 2 3",
    tripod: "0 1",
    'label = "Tripod"': "0",
    "label = tripod": "0 1",
    'label = ""': "2",
    "energy < 0.25": "0 2",
    "energy >= 0,3": "1 3",
    "e != 0.5 and not power": "0 2",
    "stable or g1": "0 2 3",
    "(stable or g1) !power": "0 2",
    "evidence = chain": "2",
    "support ≥ 95%": "0 1",
    "members > 1": "0",
    "m3 or m1": "1 3",
    pinned: "2",
    "category : precision": "0 1",
    constructor: "",
  };
  for (const [text, answer] of Object.entries(expected)) {
    assert.equal(found(text, { pins: [2] }), answer, text);
  }
});

test("what makes no sense is refused with the reason", () => {
  for (const [text, reason] of [
    ["energy <", /compares with nothing/],
    ["energy < low", /“low” is not a number/],
    ["(stable", /closing parenthesis/],
    ["stable )", /“\)” was not expected/],
    ["not", /something is missing/],
    ["label < 3", /is a text/],
    ["epsilon > 0", /nothing here has “epsilon”; known are energy, /],
    ["colour = red", /“colour” is none of energy, /],
    ["family = m0", /only below a level/],
    ["family < m0", /compared with a minimum/],
  ])
    assert.match(found(text), reason, text);
  const bare = model({ stable: null });
  assert.match(found("stable", { of: bare }), /landscape report four.landscape --stability FILE/);
  assert.match(found("stable", { of: model({ stable: null, name: "a b", item: "grasp", members: [] }) }), /stability 'a b'/);
});

test("a family is what is joined below the level", () => {
  assert.equal(found("family = m1", { level: 1.5 }), "0 1");
  assert.equal(found("family != m1", { level: 2.5 }), "3");
  assert.equal(found("family = m1", { level: 0.4 }), "");
});

test("a family of the landscape is named by its number", () => {
  assert.equal(found("family = g0"), "0 1");
  assert.equal(found("family > 0", { level: 2.5 }), "2 3");
});

test("only what is known is offered", () => {
  assert.ok(known(model()).includes("support") && !known(model()).includes("epsilon"));
  assert.deepEqual(examples(model()), ["m3", "tripod", "stable", "energy < 0, not g0", "members > 3", "evidence = saddle or support >= 95%", "not power"]);
});
