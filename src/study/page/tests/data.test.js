import assert from "node:assert/strict";
import { test } from "node:test";
import { deflateSync } from "node:zlib";
import { NONE, startsOf, unpack } from "../web/data.js";
import { model } from "./made.js";

const packed = (header, ...arrays) => {
  const text = Buffer.from(JSON.stringify(header));
  const length = Buffer.alloc(4);
  length.writeUInt32LE(text.length);
  return deflateSync(Buffer.concat([length, text, ...arrays.map(array => Buffer.from(array.buffer))])).toString("base64");
};

test("arrays and tables come out as they were put in", async () => {
  // Two columns in steps; the second has a difference that passes the end of 16 bits.
  const steps = Uint16Array.of(1, 1, 1, 65535, 2, 0);
  const header = {
    doubles: { packed: "f8", start: 0, count: 2 },
    nested: [{ table: { packed: "table", start: 16, count: 3, low: [10, -1], step: [0.5, 1] } }],
    text: "é</script>",
    nothing: null,
  };
  const data = await unpack(`\n${packed(header, Float64Array.of(0.5, -2), steps)}\n`);
  assert.deepEqual(data.doubles, Float64Array.of(0.5, -2));
  assert.deepEqual([...data.nested[0].table], [10.5, 65534, 11, 0, 11.5, 0]);
  assert.deepEqual([data.text, data.nothing], ["é</script>", null]);
});

test("starts of lists", () => assert.deepEqual([...startsOf([2, 0, 3])], [0, 2, 2, 5]));

test("items have names, numbers and labels", () => {
  const four = model();
  assert.deepEqual([0, 3].map(item => four.name(item)), ["m0", "m3"]);
  assert.deepEqual(["m2", " 2 ", "m9", "m1′", "x"].map(text => four.named(text)), [2, 2, null, null, null]);
  assert.deepEqual([four.number("joins", 2), four.number("barrier", 1), four.number("support", 3)], [2, 0.5, 0.9]);
  assert.ok(Number.isNaN(four.number("stable", 2)) && Number.isNaN(four.number("nothing", 0)));
  assert.deepEqual([four.evidence(2), four.evidence(0)], ["chain", "saddle"]);
  assert.equal(model({ name: "" }).sides[0].name, "x.landscape");
});

test("a label given on the page counts before that of the file", () => {
  const four = model({ by_rule: { label: { texts: ["Ring"], of: [0, 0, 0, 0] } } });
  four.own.set(3, "Tripod");
  four.own.set(0, "");
  assert.deepEqual([four.text("label", 3), four.number("type", 3), four.text("category", 3)], ["Tripod", 14, "precision"]);
  assert.deepEqual([four.text("label", 0), four.text("given", 0), four.byRule(1)], ["Ring", "", "Ring"]);
});

test("energies that differ from zero by rounding are zero", () => {
  const four = model({ energy: Float64Array.of(1e-15, 0.5, -1e-16, 0.3) });
  assert.deepEqual([...four.sides[0].energy], [0, 0.5, 0, 0.3]);
  assert.equal(NONE, 2 ** 32 - 1);
});
