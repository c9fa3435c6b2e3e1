// Painting: one set of calls for a canvas and for an SVG file, and the canvas of a panel.
"use strict";

const FONT = 'system-ui, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif';
const look = {};

// Reads the colours of the present look, dark or light.
function readLook() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["ink", "soft", "line", "pale", "faint", "paper", "accent", "route"]) {
    look[name] = style.getPropertyValue("--" + name).trim();
  }
}

class CanvasPen {
  constructor(context) {
    this.context = context;
  }

  path(points, { stroke, width = 1, dash = [], fill, alpha = 1, close = false }) {
    const c = this.context;
    c.globalAlpha = alpha;
    c.beginPath();
    points.forEach(([x, y], k) => (k ? c.lineTo(x, y) : c.moveTo(x, y)));
    if (close) c.closePath();
    if (fill) {
      c.fillStyle = fill;
      c.fill();
    }
    if (stroke) {
      c.strokeStyle = stroke;
      c.lineWidth = width;
      c.setLineDash(dash);
      c.lineJoin = "round";
      c.stroke();
    }
  }

  circle([x, y], radius, { stroke, width = 1, fill, alpha = 1 }) {
    const c = this.context;
    c.globalAlpha = alpha;
    c.setLineDash([]);
    c.beginPath();
    c.arc(x, y, radius, 0, 2 * Math.PI);
    if (fill) {
      c.fillStyle = fill;
      c.fill();
    }
    if (stroke) {
      c.strokeStyle = stroke;
      c.lineWidth = width;
      c.stroke();
    }
  }

  text([x, y], text, { fill, size = 12, anchor = "start", turn = 0, weight = 400, alpha = 1 }) {
    const c = this.context;
    c.globalAlpha = alpha;
    c.font = `${weight} ${size}px ${FONT}`;
    c.fillStyle = fill;
    c.textAlign = { start: "left", middle: "center", end: "right" }[anchor];
    c.textBaseline = "middle";
    c.save();
    c.translate(x, y);
    c.rotate(turn);
    c.fillText(text, 0, 0);
    c.restore();
  }
}

class SvgPen {
  constructor() {
    this.parts = [];
  }

  paint({ stroke, width = 1, dash = [], fill, alpha = 1 }) {
    const parts = [`fill="${fill ?? "none"}"`];
    if (stroke) parts.push(`stroke="${stroke}" stroke-width="${width}" stroke-linejoin="round"`);
    if (stroke && dash.length) parts.push(`stroke-dasharray="${dash.join(" ")}"`);
    if (alpha < 1) parts.push(`opacity="${alpha}"`);
    return parts.join(" ");
  }

  path(points, style) {
    if (!points.length) return;
    const way = points.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join("L");
    this.parts.push(`<path d="M${way}${style.close ? "Z" : ""}" ${this.paint(style)}/>`);
  }

  circle([x, y], radius, style) {
    this.parts.push(`<circle cx="${x.toFixed(2)}" cy="${y.toFixed(2)}" r="${radius.toFixed(2)}" ${this.paint(style)}/>`);
  }

  text([x, y], text, { fill, size = 12, anchor = "start", turn = 0, weight = 400, alpha = 1 }) {
    const turned = turn ? ` transform="rotate(${(180 * turn) / Math.PI} ${x.toFixed(2)} ${y.toFixed(2)})"` : "";
    const place = `x="${x.toFixed(2)}" y="${(y + 0.36 * size).toFixed(2)}" text-anchor="${anchor}"${turned}`;
    const face = `font-size="${size}" font-weight="${weight}" fill="${fill}"${alpha < 1 ? ` opacity="${alpha}"` : ""}`;
    this.parts.push(`<text ${place} ${face}>${escaped(text)}</text>`);
  }

  file(width, height) {
    const font = FONT.replaceAll('"', "'");
    return (
      `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" ` +
      `font-family="${font}"><!-- Made by landscape. --><rect width="100%" height="100%" fill="${look.paper}"/>\n` +
      this.parts.join("\n") +
      "\n</svg>\n"
    );
  }
}

function escaped(text) {
  return String(text).replace(/[&<>"\u0000-\u001f]/g, letter => `&#${letter.charCodeAt(0) < 32 ? 65533 : letter.charCodeAt(0)};`);
}

// Round numbers between two bounds, about `count` of them.
function ticks(low, high, count) {
  const rough = (high - low) / count || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find(factor => factor * power >= rough) * power;
  const values = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) values.push(k * step);
  const places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return values.map(value => [value, (value === 0 ? 0 : value).toFixed(places).replace("-", "−")]);
}

// A canvas in a panel. `paint(pen, width, height)` paints it; `found([x, y])` names the item at a place.
class Drawing {
  constructor(section, label, paint, found) {
    Object.assign(this, { section, paint, found });
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", label);
    section.append(this.canvas);
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    if (!found) return;
    this.canvas.addEventListener("pointermove", event => this.point(event));
    this.canvas.addEventListener("pointerleave", () => {
      tip(null);
      change({ hover: null });
    });
    this.canvas.addEventListener("click", event => {
      const item = this.found(this.placeOf(event))?.item ?? null;
      if (!this.dragged) select(item);
    });
  }

  placeOf(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  point(event) {
    if (event.buttons && this.dragged) return;
    const found = this.found(this.placeOf(event));
    tip(found ? (found.lines ?? described(found.item)) : null, event.clientX, event.clientY);
    change({ hover: found?.item ?? null });
  }

  draw() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (!width || !height) return;
    const scale = Math.min(3, window.devicePixelRatio || 1);
    this.canvas.width = Math.round(width * scale);
    this.canvas.height = Math.round(height * scale);
    const context = this.canvas.getContext("2d");
    context.scale(scale, scale);
    context.clearRect(0, 0, width, height);
    this.paint(new CanvasPen(context), width, height);
  }

  svg() {
    const [width, height] = [this.canvas.clientWidth || 800, this.canvas.clientHeight || 500];
    const pen = new SvgPen();
    this.paint(pen, width, height);
    return pen.file(width, height);
  }
}

// Shows a few lines beside the pointer; the first one is the heading.
function tip(lines, x = 0, y = 0) {
  const box = document.getElementById("tip");
  box.hidden = !lines;
  if (!lines) return;
  box.replaceChildren(...lines.map((line, k) => make(k ? "div" : "strong", line)));
  const { innerWidth, innerHeight } = window;
  box.style.left = Math.max(4, Math.min(x + 14, innerWidth - box.offsetWidth - 8)) + "px";
  box.style.top = Math.max(4, Math.min(y + 16, innerHeight - box.offsetHeight - 8)) + "px";
}

// What is said of an item beside the pointer.
function described(item) {
  const number = (field, words) =>
    Number.isFinite(model.number(field, item)) ? `${words} ${shown(model.number(field, item))}` : null;
  const label = model.text("label", item);
  const members = model.number("members", item);
  const [side] = model.at(item);
  return [
    model.name(item) + (label ? ` · ${label}` : ""),
    number("energy", "energy"),
    number("epsilon", "ε"),
    Number.isFinite(model.number("stable", item))
      ? model.number("stable", item)
        ? "held in simulation"
        : "fell in simulation"
      : null,
    side.item === "minimum" && side.space?.kind === "pose"
      ? `${members} ${members === 1 ? "grasp" : "grasps"}, group g${model.number("group", item)}`
      : null,
    number("joins", "joins others at"),
  ].filter(line => line);
}

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

const byId = id => document.getElementById(id);
const still = matchMedia("(prefers-reduced-motion: reduce)");
