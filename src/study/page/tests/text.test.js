import assert from "node:assert/strict";
import { test } from "node:test";
import { escaped, percent, plain, plural, quoted, shown, ticks, word } from "../web/text.js";

test("numbers have the digits that are of interest", () => {
  assert.deepEqual([0, 1234.5, 0.12345, -3.14159, 1e-5, NaN].map(value => shown(value)), ["0.000", "1235", "0.123", "−3.142", "1.00e−5", "–"]);
  assert.deepEqual([percent(0.956), percent(NaN), plural(1, "pass", "passes"), plural(0, "pass", "passes")], ["96 %", "–", "1 pass", "0 passes"]);
});

test("ticks are round numbers within the bounds", () => {
  assert.deepEqual(ticks(-0.1, 1, 5), [[-0, "0.0"], [0.5, "0.5"], [1, "1.0"]]);
  assert.deepEqual(ticks(-40, 0, 2).map(([, text]) => text), ["−40", "−20", "0"]);
});

test("foreign texts do no harm", () => {
  assert.equal(plain("\u202ea\u2066b"), "ab");
  assert.equal(plain("abcdef", 4), "abc…");
  assert.equal(escaped('<a b="c">&\u0000'), "&#60;a b=&#34;c&#34;&#62;&#38;&#65533;");
  assert.deepEqual([word("a.b"), word("it's"), word("-q")], ["a.b", "'it'\\''s'", "'-q'"]);
  assert.deepEqual([quoted("a"), quoted('a,"b"')], ["a", '"a,""b"""']);
});
