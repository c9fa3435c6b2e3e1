// Small helpers: elements, buttons, what the browser remembers, and the words beside the pointer.

/** What must be there. @template Thing @param {Thing | null} thing @param {string} what @returns {Thing} */
export function needed(thing, what) {
  if (!thing) throw new Error("missing: " + what);
  return thing;
}

/** @param {string} id */
export const byId = id => needed(document.getElementById(id), id);

/** The element with this id, of this kind. @template {HTMLElement} Kind @param {new () => Kind} kind @param {string} id */
export function the(kind, id) {
  const element = byId(id);
  return needed(element instanceof kind ? element : null, kind.name);
}

/** The heading of a panel. @param {Element} section */
export const headingOf = section => needed(section.querySelector("h2"), "heading");

/** What paints on a canvas. @param {HTMLCanvasElement} canvas */
export const contextOf = canvas => needed(canvas.getContext("2d"), "2d");

// Whether no motion is wanted.
export const still = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

/** @typedef {Record<string, string | number | boolean | (() => void) | ((event: Event) => void)>} Attributes */

/**
 * An element with a text, attributes and children.
 *
 * @template {keyof HTMLElementTagNameMap} Name
 * @param {Name} name
 * @param {string | number} text
 * @param {Attributes} attributes a handler of events is named `on` and the event; `true` sets an attribute without value, `false` none
 * @param {(Node | string)[]} children
 */
export function make(name, text = "", attributes = {}, ...children) {
  const element = document.createElement(name);
  if (text !== "") element.textContent = String(text);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(key.slice(2), value);
    else if (value !== false) element.setAttribute(key, value === true ? "" : String(value));
  }
  element.append(...children);
  return element;
}

/** @param {string} text @param {() => void} onclick @param {Attributes} attributes @param {(Node | string)[]} children */
export function button(text, onclick, attributes = {}, ...children) {
  return make("button", text, { type: "button", onclick, ...attributes }, ...children);
}

/** A button of a panel: a sign or a word, and what it does. @param {string} text @param {string} words @param {() => void} onclick */
export function tool(text, words, onclick) {
  return button(text, onclick, { title: words, "aria-label": words });
}

/** Puts tools behind the heading of a panel. @param {Element} section @param {Node[]} tools */
export function addTools(section, ...tools) {
  headingOf(section).after(make("div", "", { class: "panel-tools" }, ...tools));
}

// Texts that the browser keeps. It may refuse: then nothing is remembered, and the page works without.
export const memory = {
  /** @param {string} key */
  get(key) {
    try {
      return localStorage.getItem(key);
    } catch {
      return null;
    }
  },
  /** @param {string} key @param {string} text */
  set(key, text) {
    try {
      localStorage.setItem(key, text);
    } catch {
      /* refused */
    }
  },
};

// Opens a dialog with a heading, these parts and a button that closes it.
/** @param {HTMLDialogElement} dialog @param {string} title @param {Node[]} parts */
export function showDialog(dialog, title, parts) {
  const close = make("form", "", { method: "dialog" }, make("button", "Close", { class: "main" }));
  dialog.replaceChildren(make("h2", title), ...parts, close);
  dialog.showModal();
}

/** Shows a few lines beside the pointer; the first one is the heading. @param {string[] | null} lines */
export function tip(lines, x = 0, y = 0) {
  const box = byId("tip");
  box.hidden = !lines;
  if (!lines) return;
  box.replaceChildren(...lines.map((line, k) => make(k ? "div" : "strong", line)));
  const { innerWidth, innerHeight } = window;
  box.style.left = Math.max(4, Math.min(x + 14, innerWidth - box.offsetWidth - 8)) + "px";
  box.style.top = Math.max(4, Math.min(y + 16, innerHeight - box.offsetHeight - 8)) + "px";
}
