// The language of the search field: words, names, comparisons, `and`, `or`, `not` and parentheses.

import { NONE } from "./data.js";
import { plain, word } from "./text.js";

// These tables have no prototype, so that a word such as `constructor` is a word like any other.
const FIELDS = {
  __proto__: null,
  energy: "energy",
  e: "energy",
  epsilon: "epsilon",
  eps: "epsilon",
  "ε": "epsilon",
  support: "support",
  members: "members",
  grasps: "members",
  family: "family",
  type: "type",
  joins: "joins",
  barrier: "barrier",
};
const TEXT_FIELDS = ["label", "category", "cell", "object", "evidence"];
const COMPARISONS = {
  __proto__: null,
  "<": (a, b) => a < b,
  "≤": (a, b) => a <= b,
  ">": (a, b) => a > b,
  "≥": (a, b) => a >= b,
  "=": (a, b) => a === b,
  "≠": (a, b) => a !== b,
};
// Other ways to write signs.
const SAME = {
  __proto__: null,
  "<=": "≤",
  ">=": "≥",
  "==": "=",
  ":": "=",
  "!=": "≠",
  "&&": "and",
  "&": "and",
  "||": "or",
  "|": "or",
  "!": "not",
};
const TOKEN = /\s*("(?:[^"\\]|\\.)*"?|[()]|<=|>=|==|!=|&&|\|\||[<>=:≤≥≠&|!]|[^\s()<>=:≤≥≠&|!"]+)/gy;

/**
 * A test of items for a text, and what is wrong with the text.
 *
 * @param {string} text
 * @param {Pick<import("./data.js").Model, "at" | "count" | "evidence" | "knows" | "named" | "number" | "sideOf" | "sides" | "text">} model
 * @param {{ basins: { top: Uint32Array } | null, pins: number[] }} about the superbasins of the present level, and the pinned items
 * @returns {{ test: (item: number) => boolean, problem: string }}
 */
export function compiled(text, model, about) {
  const parser = new FilterParser(text, model, about);
  try {
    const test = parser.done() ? () => true : parser.or();
    if (!parser.done()) throw new Error(`“${parser.next()}” was not expected`);
    return { test, problem: "" };
  } catch (error) {
    return { test: () => true, problem: String(error.message) };
  }
}

class FilterParser {
  constructor(text, model, about) {
    this.model = model;
    this.about = about;
    this.tokens = Array.from(text.matchAll(TOKEN), ([, token]) => SAME[token] ?? token);
    this.place = 0;
  }

  done() {
    return this.place >= this.tokens.length;
  }
  next() {
    return this.tokens[this.place];
  }
  is(word) {
    return !this.done() && this.next().toLowerCase() === word;
  }
  take() {
    return this.tokens[this.place++];
  }

  or() {
    const tests = [this.and()];
    while (this.is("or")) {
      this.take();
      tests.push(this.and());
    }
    return tests.length === 1 ? tests[0] : item => tests.some(test => test(item));
  }

  and() {
    const tests = [this.not()];
    while (!this.done() && !this.is("or") && !this.is(")")) {
      if (this.is("and")) this.take();
      tests.push(this.not());
    }
    return tests.length === 1 ? tests[0] : item => tests.every(test => test(item));
  }

  not() {
    if (!this.is("not")) return this.one();
    this.take();
    const test = this.not();
    return item => !test(item);
  }

  one() {
    if (this.done()) throw new Error("something is missing at the end");
    if (this.is("(")) {
      this.take();
      const test = this.or();
      if (!this.is(")")) throw new Error("a closing parenthesis is missing");
      this.take();
      return test;
    }
    const word = this.take();
    if (COMPARISONS[word] || word === ")") throw new Error(`“${word}” was not expected`);
    return !this.done() && COMPARISONS[this.next()] ? this.comparison(word.toLowerCase()) : this.word(word);
  }

  comparison(name) {
    const sign = this.take();
    if (this.done()) throw new Error(`“${name} ${sign}” compares with nothing`);
    const given = this.take();
    const value = unquoted(given);
    const model = this.model;
    const field = FIELDS[name];
    if (!field && !TEXT_FIELDS.includes(name)) throw new Error(`“${name}” is none of ${known(model).join(", ")}`);
    if (!model.knows(field ?? name)) throw new Error(`${unknown(name, model)}; known are ${known(model).join(", ")}`);
    if (name === "family") return this.family(sign, value);
    if (TEXT_FIELDS.includes(name)) {
      const text = item => (name === "evidence" ? model.evidence(item) : model.text(name, item)).toLowerCase();
      const wanted = value.toLowerCase();
      // Nothing but an empty text equals an empty one, and a text in quotes that some item has means this text: "Tripod" is no
      // "Writing Tripod".
      const occurs = () => Array.from({ length: model.count }, (_, item) => text(item)).includes(wanted);
      const whole = name === "cell" || wanted === "" || (given !== value && occurs());
      const equal = whole ? item => text(item) === wanted : item => text(item).includes(wanted);
      if (sign === "=") return equal;
      if (sign === "≠") return item => !equal(item);
      throw new Error(`“${name}” is a text: compare it with = or !=`);
    }
    const percent = value.endsWith("%");
    const wanted = Number(value.replace("%", "").replace("−", "-").replace(",", ".")) / (percent ? 100 : 1);
    if (value === "" || Number.isNaN(wanted)) throw new Error(`“${value}” is not a number`);
    return item => !Number.isNaN(model.number(field, item)) && COMPARISONS[sign](model.number(field, item), wanted);
  }

  // A family of the landscape by its number, or what is joined to a minimum at the present level.
  family(sign, value) {
    const model = this.model;
    const number = /^g?(\d+)$/.exec(value);
    if (number) return item => COMPARISONS[sign](model.number("family", item), Number(number[1]));
    const minimum = model.named(value);
    if (minimum === null || (sign !== "=" && sign !== "≠")) throw new Error("“family” is compared with a minimum or a family: family = m3, family = g0");
    if (!this.about.basins) throw new Error("there are families only below a level: drag the level line of the tree");
    const { top } = this.about.basins;
    const same = item => top[item] !== NONE && top[item] === top[minimum] && model.sideOf(item) === model.sideOf(minimum);
    return sign === "=" ? same : item => !same(item);
  }

  word(token) {
    const model = this.model;
    const text = unquoted(token).toLowerCase();
    if (["stable", "unstable", "simulated"].includes(text) && !model.knows("stable")) throw new Error(unknown(text, model));
    if (text === "stable") return item => model.number("stable", item) === 1;
    if (text === "unstable") return item => model.number("stable", item) === 0;
    if (text === "simulated") return item => !Number.isNaN(model.number("stable", item));
    if (text === "pinned") return item => this.about.pins.includes(item);
    if (token === text && /^[m#]\d+['′]?$/.test(text)) {
      const wanted = model.named(text);
      return item => item === wanted;
    }
    if (token === text && /^g\d+$/.test(text)) {
      if (!model.knows("family")) throw new Error(`${unknown("family", model)}; known are ${known(model).join(", ")}`);
      const family = Number(text.slice(1));
      return item => model.number("family", item) === family;
    }
    const fields = ["label", "category", "cell", "object", "given"].filter(field => model.sides.some(side => side[field]));
    if (fields.length === 0) throw new Error(`nothing here has a name such as “${text}”; known are ${known(model).join(", ")}`);
    return item => fields.some(field => model.text(field, item).toLowerCase().includes(text));
  }
}

// What a search can compare on this page, without other names of the same.
export function known(model) {
  return [...new Set([...Object.values(FIELDS), ...TEXT_FIELDS])].filter(name => model.knows(name));
}

// Why a field is not known.
function unknown(name, model) {
  if (["stable", "unstable", "simulated"].includes(name)) {
    const [side] = model.sides;
    const file = word(plain(side.name));
    return side.item === "grasp"
      ? `nothing was simulated: \`landscape stability ${file}\` first`
      : `nothing was simulated: \`landscape stability\` on the grasps first, then \`landscape report ${file} --stability FILE\``;
  }
  return `nothing here has “${name}”`;
}

// Searches that make sense on this page, with a name and a label that occur.
export function examples(model) {
  const [side] = model.sides;
  const first = Math.min(model.count - 1, 3);
  const label = Array.from({ length: model.count }, (_, item) => model.text("label", item)).find(text => model.types.has(text));
  return [
    first >= 0 && model.name(first),
    label?.split(" ")[0].toLowerCase(),
    model.knows("stable") && "stable",
    model.knows("epsilon") && "energy < 0.2 and epsilon > 0.05",
    !model.knows("epsilon") && side.family && "energy < 0, not g0",
    model.knows("members") && "members > 3",
    model.knows("support") ? "evidence = saddle or support >= 95%" : side.tree && "evidence = saddle",
    model.knows("category") && "not power",
  ].filter(text => text);
}

export function unquoted(token) {
  return token.startsWith('"') ? token.slice(1).replace(/"$/, "").replace(/\\(.)/g, "$1") : token;
}
