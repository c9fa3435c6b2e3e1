// Words and numbers as texts: nothing here needs a browser.

/** A number with as many digits as are of interest; NaN if there is none. @param {number} value */
export function shown(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  if (value !== 0 && (Math.abs(value) >= 1e6 || Math.abs(value) < 1e-4)) return value.toExponential(2).replace("-", "−");
  const places = Math.max(0, digits - 1 - Math.max(0, Math.floor(Math.log10(Math.abs(value) || 1))));
  return value.toFixed(Math.min(places, digits - 1)).replace("-", "−");
}

/** @param {number} share */
export function percent(share) {
  return Number.isNaN(share) ? "–" : Math.round(100 * share) + " %";
}

/** @param {number} count @param {string} one @param {string} many */
export function plural(count, one, many) {
  return `${count} ${count === 1 ? one : many}`;
}

/** A foreign text among other words: without the marks that turn the direction of writing, and not too long. @param {string} text */
export function plain(text, letters = 60) {
  const all = Array.from(text.replace(/[\u200e\u200f\u061c\u202a-\u202e\u2066-\u2069]/g, ""));
  return all.length <= letters ? all.join("") : all.slice(0, letters - 1).join("") + "…";
}

/** A landscape of two: hand, object and file. @param {import("./data.js").Side} side */
export function sideName(side) {
  return side.subject ? `${side.subject} (${side.name})` : side.name;
}

/** A word for the shell. @param {string} text */
export function word(text) {
  return /^[\w./:=,+@%-]+$/.test(text) && !text.startsWith("-") ? text : "'" + text.replaceAll("'", "'\\''") + "'";
}

/** @param {string} text */
export function quoted(text) {
  return /[",\r\n]/.test(text) ? '"' + text.replaceAll('"', '""') + '"' : text;
}

/** Control letters are not allowed in XML: they become the sign for an unknown letter. @param {string} text */
export function escaped(text) {
  return text.replace(/[&<>"\u0000-\u001f]/g, letter => `&#${letter < " " ? 65533 : letter.charCodeAt(0)};`);
}

/**
 * Round numbers between two bounds, about `count` of them, and their texts.
 *
 * @param {number} low
 * @param {number} high
 * @param {number} count
 * @returns {[number, string][]}
 */
export function ticks(low, high, count) {
  const rough = (high - low) / count || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = ([1, 2, 5].find(factor => factor * power >= rough) ?? 10) * power;
  const values = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) values.push(k * step);
  const places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return values.map(value => [value, (value === 0 ? 0 : value).toFixed(places).replace("-", "−")]);
}

/**
 * A table without a prototype, so that a word such as `constructor` is a word like any other.
 *
 * @template Entry
 * @param {Record<string, Entry>} entries
 * @returns {Record<string, Entry | undefined>}
 */
export const dictionary = entries => Object.assign(Object.create(null), entries);

/** What an error says. @param {unknown} error */
export const messageOf = error => (error instanceof Error ? error.message : String(error));
