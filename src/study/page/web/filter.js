// The language of the search field: words, names, comparisons, `and`, `or`, `not` and parentheses.
"use strict";

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
  group: "group",
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

// A test of items for a text, and what is wrong with the text.
function compiled(text, model) {
  const parser = new FilterParser(text, model);
  try {
    const test = parser.done() ? () => true : parser.or();
    if (!parser.done()) throw new Error(`“${parser.next()}” was not expected`);
    return { test, problem: "" };
  } catch (error) {
    return { test: () => true, problem: error.message };
  }
}

class FilterParser {
  constructor(text, model) {
    this.model = model;
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
    const value = unquoted(this.take());
    const model = this.model;
    if (TEXT_FIELDS.includes(name)) {
      const text = item => (name === "evidence" ? model.evidence(item) : model.text(name, item)).toLowerCase();
      const wanted = value.toLowerCase();
      const equal = name === "cell" ? item => text(item) === wanted : item => text(item).includes(wanted);
      if (sign === "=") return equal;
      if (sign === "≠") return item => !equal(item);
      throw new Error(`“${name}” is a text: compare it with = or !=`);
    }
    const field = FIELDS[name];
    if (!field) throw new Error(`“${name}” is none of ${[...Object.keys(FIELDS), ...TEXT_FIELDS].join(", ")}`);
    const percent = value.endsWith("%");
    const wanted = Number(value.replace("%", "").replace("−", "-").replace(",", ".")) / (percent ? 100 : 1);
    if (value === "" || Number.isNaN(wanted)) throw new Error(`“${value}” is no number`);
    return item => !Number.isNaN(model.number(field, item)) && COMPARISONS[sign](model.number(field, item), wanted);
  }

  word(token) {
    const model = this.model;
    const text = unquoted(token).toLowerCase();
    if (text === "stable") return item => model.number("stable", item) === 1;
    if (text === "unstable") return item => model.number("stable", item) === 0;
    if (text === "simulated") return item => !Number.isNaN(model.number("stable", item));
    if (text === "pinned") return item => state.pins.includes(item);
    if (token === text && /^[m#]\d+['′]?$/.test(text)) {
      const wanted = model.named(text);
      return item => item === wanted;
    }
    if (token === text && /^g\d+$/.test(text)) {
      const group = Number(text.slice(1));
      return item => model.number("group", item) === group;
    }
    const fields = ["label", "category", "cell", "object", "given"];
    return item => fields.some(field => model.text(field, item).toLowerCase().includes(text));
  }
}

function unquoted(token) {
  return token.startsWith('"') ? token.slice(1).replace(/"$/, "").replace(/\\(.)/g, "$1") : token;
}
