// Small helpers: elements, buttons, what the browser remembers, and the words beside the pointer.
"use strict";

const byId = id => document.getElementById(id);
const still = matchMedia("(prefers-reduced-motion: reduce)");

// An element with a text, attributes and children.
function make(name, text = "", attributes = {}, ...children) {
  const element = document.createElement(name);
  if (text !== "") element.textContent = text;
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value !== false && value !== null) element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

// The symbol of a look, for lists.
function dotOf({ colour, corners, open }) {
  const part = (name, attributes) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    return element;
  };
  const outline = corners.length ? part("polygon", { points: corners.join(" ") }) : part("circle", { r: 1 });
  outline.setAttribute("fill", colour);
  const dot = part("svg", { class: "dot", viewBox: "-1.6 -1.6 3.2 3.2", "aria-hidden": "true" });
  dot.append(outline);
  if (open) dot.append(part("circle", { class: "heart", r: model.header.looks.heart }));
  return dot;
}

function button(text, onclick, attributes = {}, ...children) {
  return make("button", text, { type: "button", onclick, ...attributes }, ...children);
}

// A button of a panel: a sign or a word, and what it does.
function tool(text, words, onclick) {
  return button(text, onclick, { title: words, "aria-label": words });
}

// Puts tools behind the heading of a panel.
function addTools(section, ...tools) {
  section.querySelector("h2").after(make("div", "", { class: "panel-tools" }, ...tools));
}

// Texts that the browser keeps. It may refuse: then nothing is remembered, and the page works without.
const memory = {
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
function showDialog(dialog, title, parts) {
  const close = make("form", "", { method: "dialog" }, make("button", "Close", { class: "main" }));
  dialog.replaceChildren(make("h2", title), ...parts, close);
  dialog.showModal();
}

function plural(count, one, many) {
  return `${count} ${count === 1 ? one : many}`;
}

// A foreign text among other words: without the marks that turn the direction of writing, and not too long.
function plain(text, letters = 60) {
  const all = Array.from(text.replace(/[\u200e\u200f\u061c\u202a-\u202e\u2066-\u2069]/g, ""));
  return all.length <= letters ? all.join("") : all.slice(0, letters - 1).join("") + "…";
}

// A landscape of two: hand, object and file.
function sideName(side) {
  return side.subject ? `${side.subject} (${side.name})` : side.name;
}

// Shows a few lines beside the pointer; the first one is the heading.
function tip(lines, x = 0, y = 0) {
  const box = byId("tip");
  box.hidden = !lines;
  if (!lines) return;
  box.replaceChildren(...lines.map((line, k) => make(k ? "div" : "strong", line)));
  const { innerWidth, innerHeight } = window;
  box.style.left = Math.max(4, Math.min(x + 14, innerWidth - box.offsetWidth - 8)) + "px";
  box.style.top = Math.max(4, Math.min(y + 16, innerHeight - box.offsetHeight - 8)) + "px";
}

// A group with the name that a person would give it, if the landscape has one.
function groupName(side, group) {
  const name = side.group_names?.find(one => one.group === group)?.name;
  return name ? `g${group}: ${name}` : `g${group}`;
}

// What is said of an item beside the pointer.
function described(item) {
  const [side] = model.at(item);
  const label = plain(model.text("label", item));
  const stable = model.number("stable", item);
  const number = (field, words) => {
    const value = model.number(field, item);
    return Number.isNaN(value) ? null : `${words} ${shown(value)}`;
  };
  const grasps = side.item === "minimum" && side.space?.kind === "pose";
  return [
    model.name(item) + (label ? ` · ${label}` : ""),
    number("energy", "energy"),
    number("epsilon", "ε"),
    Number.isNaN(stable) ? null : stable ? "held in simulation" : "fell in simulation",
    grasps ? `${plural(model.number("members", item), "grasp", "grasps")}, group ${groupName(side, model.number("group", item))}` : null,
    number("joins", "joins others at"),
  ].filter(line => line);
}
