// The language of the search field: words, names, comparisons, `and`, `or`, `not` and parentheses.

import { NONE } from "./data.js";
import { dictionary, messageOf, plain, word } from "./text.js";

/**
 * @typedef {Pick<import("./data.js").Model, "at" | "count" | "evidence" | "knows" | "named" | "number" | "sideOf" | "sides" | "text">} Items
 * @typedef {{ basins: { top: Uint32Array } | null, pins: number[] }} About the superbasins of the present level, and the pinned items
 * @typedef {(item: number) => boolean} Test
 * @typedef {(a: number, b: number) => boolean} Comparison
 */

const FIELDS = dictionary({
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
});
/** @type {(import("./data.js").LabelField | "object")[]} */
const NAMED = ["label", "category", "cell", "object"];
/** @type {Record<string, Comparison | undefined>} */
const COMPARISONS = dictionary({
  "<": (a, b) => a < b,
  "≤": (a, b) => a <= b,
  ">": (a, b) => a > b,
  "≥": (a, b) => a >= b,
  "=": (a, b) => a === b,
  "≠": (a, b) => a !== b,
});
// Other ways to write signs.
const SAME = dictionary({
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
});
const TOKEN = /\s*("(?:[^"\\]|\\.)*"?|[()]|<=|>=|==|!=|&&|\|\||[<>=:≤≥≠&|!]|[^\s()<>=:≤≥≠&|!"]+)/gy;

/**
 * A test of items for a text, and what is wrong with the text.
 *
 * @param {string} text
 * @param {Items} model
 * @param {About} about
 * @returns {{ test: Test, problem: string }}
 */
export function compiled(text, model, about) {
  const parser = new FilterParser(text, model, about);
  try {
    const test = parser.done() ? () => true : parser.or();
    if (!parser.done()) throw new Error(`“${parser.next()}” was not expected`);
    return { test, problem: "" };
  } catch (error) {
    return { test: () => true, problem: messageOf(error) };
  }
}

class FilterParser {
  /** @param {string} text @param {Items} model @param {About} about */
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
  /** @param {string} word */
  is(word) {
    return !this.done() && this.next().toLowerCase() === word;
  }
  take() {
    return this.tokens[this.place++];
  }

  /** @returns {Test} */
  or() {
    const tests = [this.and()];
    while (this.is("or")) {
      this.take();
      tests.push(this.and());
    }
    return tests.length === 1 ? tests[0] : item => tests.some(test => test(item));
  }

  /** @returns {Test} */
  and() {
    const tests = [this.not()];
    while (!this.done() && !this.is("or") && !this.is(")")) {
      if (this.is("and")) this.take();
      tests.push(this.not());
    }
    return tests.length === 1 ? tests[0] : item => tests.every(test => test(item));
  }

  /** @returns {Test} */
  not() {
    if (!this.is("not")) return this.one();
    this.take();
    const test = this.not();
    return item => !test(item);
  }

  /** @returns {Test} */
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
    const compare = this.done() ? undefined : COMPARISONS[this.next()];
    return compare ? this.comparison(word.toLowerCase(), compare) : this.word(word);
  }

  /** @param {string} name @param {Comparison} compare @returns {Test} */
  comparison(name, compare) {
    const sign = this.take();
    if (this.done()) throw new Error(`“${name} ${sign}” compares with nothing`);
    const given = this.take();
    const value = unquoted(given);
    const model = this.model;
    const field = FIELDS[name];
    const named = NAMED.find(other => other === name);
    if (!field && !named && name !== "evidence") throw new Error(`“${name}” is none of ${known(model).join(", ")}`);
    if (!model.knows(field ?? name)) throw new Error(`${unknown(name, model)}; known are ${known(model).join(", ")}`);
    if (name === "family") return this.family(sign, value, compare);
    if (!field) {
      /** @type {(item: number) => string} */
      const text = item => (named ? model.text(named, item) : model.evidence(item)).toLowerCase();
      const wanted = value.toLowerCase();
      // Nothing but an empty text equals an empty one, and a text in quotes that some item has means this text: "Tripod" is no
      // "Writing Tripod".
      const occurs = () => Array.from({ length: model.count }, (_, item) => text(item)).includes(wanted);
      const whole = name === "cell" || wanted === "" || (given !== value && occurs());
      /** @type {Test} */
      const equal = whole ? item => text(item) === wanted : item => text(item).includes(wanted);
      if (sign === "=") return equal;
      if (sign === "≠") return item => !equal(item);
      throw new Error(`“${name}” is a text: compare it with = or !=`);
    }
    const percent = value.endsWith("%");
    const wanted = Number(value.replace("%", "").replace("−", "-").replace(",", ".")) / (percent ? 100 : 1);
    if (value === "" || Number.isNaN(wanted)) throw new Error(`“${value}” is not a number`);
    return item => !Number.isNaN(model.number(field, item)) && compare(model.number(field, item), wanted);
  }

  // A family of the landscape by its number, or what is joined to a minimum at the present level.
  /** @param {string} sign @param {string} value @param {Comparison} compare @returns {Test} */
  family(sign, value, compare) {
    const model = this.model;
    const number = /^g?(\d+)$/.exec(value);
    if (number) return item => compare(model.number("family", item), Number(number[1]));
    const minimum = model.named(value);
    if (minimum === null || (sign !== "=" && sign !== "≠")) throw new Error("“family” is compared with a minimum or a family: family = m3, family = g0");
    if (!this.about.basins) throw new Error("there are families only below a level: drag the level line of the tree");
    const { top } = this.about.basins;
    /** @type {Test} */
    const same = item => top[item] !== NONE && top[item] === top[minimum] && model.sideOf(item) === model.sideOf(minimum);
    return sign === "=" ? same : item => !same(item);
  }

  /** @param {string} token @returns {Test} */
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
    const fields = [...NAMED, /** @type {const} */ ("given")].filter(field => model.sides.some(side => side[field]));
    if (fields.length === 0) throw new Error(`nothing here has a name such as “${text}”; known are ${known(model).join(", ")}`);
    return item => fields.some(field => model.text(field, item).toLowerCase().includes(text));
  }
}

/** What a search can compare on this page, without other names of the same. @param {Items} model */
export function known(model) {
  return [...new Set([...Object.values(FIELDS), ...NAMED, "evidence"])].filter(name => name && model.knows(name));
}

/** Why a field is not known. @param {string} name @param {Items} model */
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

/** Searches that make sense on this page, with a name and a label that occur. @param {import("./data.js").Model} model */
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
  ].flatMap(text => text || []);
}

/** @param {string} token */
export function unquoted(token) {
  return token.startsWith('"') ? token.slice(1).replace(/"$/, "").replace(/\\(.)/g, "$1") : token;
}
