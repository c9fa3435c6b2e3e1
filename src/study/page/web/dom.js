// Small helpers: elements, buttons, what the browser remembers, and the words beside the pointer.

/** @type {(id: string) => any} */
export const byId = id => document.getElementById(id);
// Whether no motion is wanted.
export const still = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

/**
 * An element with a text, attributes and children.
 *
 * @param {string} name
 * @param {string | number} text
 * @param {Record<string, any>} attributes a handler of events is named `on` and the event; `true` sets an attribute without value,
 *   `false` and `null` none
 * @param {(Node | string)[]} children
 * @returns {any} the element
 */
export function make(name, text = "", attributes = {}, ...children) {
  const element = document.createElement(name);
  if (text !== "") element.textContent = String(text);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value !== false && value !== null) element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

export function button(text, onclick, attributes = {}, ...children) {
  return make("button", text, { type: "button", onclick, ...attributes }, ...children);
}

// A button of a panel: a sign or a word, and what it does.
export function tool(text, words, onclick) {
  return button(text, onclick, { title: words, "aria-label": words });
}

// Puts tools behind the heading of a panel.
export function addTools(section, ...tools) {
  section.querySelector("h2").after(make("div", "", { class: "panel-tools" }, ...tools));
}

// Texts that the browser keeps. It may refuse: then nothing is remembered, and the page works without.
export const memory = {
  get(key) {
    try {
      return localStorage.getItem(key);
    } catch {
      return null;
    }
  },
  set(key, text) {
    try {
      localStorage.setItem(key, text);
    } catch {
      /* refused */
    }
  },
};

// Opens a dialog with a heading, these parts and a button that closes it.
export function showDialog(dialog, title, parts) {
  const close = make("form", "", { method: "dialog" }, make("button", "Close", { class: "main" }));
  dialog.replaceChildren(make("h2", title), ...parts, close);
  dialog.showModal();
}

// Shows a few lines beside the pointer; the first one is the heading.
export function tip(lines, x = 0, y = 0) {
  const box = byId("tip");
  box.hidden = !lines;
  if (!lines) return;
  box.replaceChildren(...lines.map((line, k) => make(k ? "div" : "strong", line)));
  const { innerWidth, innerHeight } = window;
  box.style.left = Math.max(4, Math.min(x + 14, innerWidth - box.offsetWidth - 8)) + "px";
  box.style.top = Math.max(4, Math.min(y + 16, innerHeight - box.offsetHeight - 8)) + "px";
}
