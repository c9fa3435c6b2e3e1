// Takes the pictures of this folder and the frames of the loop from pages, with Chromium (used by screenshots.sh):
//   node camera.mjs FOLDER-OF-PAGES FOLDER-OF-PICTURES FOLDER-OF-FRAMES
// The page runs on a clock that this script turns, so a slow machine makes the same film.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [pages, pictures, frames] = process.argv.slice(2);
const FRAME_MS = 80;

const CLOCK = `{
  let now = 0;
  let last = 0;
  const waiting = new Map();
  performance.now = () => now;
  requestAnimationFrame = paint => (waiting.set(++last, paint), last);
  cancelAnimationFrame = number => waiting.delete(number);
  window.tick = ms => {
    now += ms;
    const due = [...waiting.values()];
    waiting.clear();
    for (const paint of due) paint(now);
  };
}`;

// An arrow where the mouse is: pictures of a page without a window have none.
const ARROW = `
  const arrow = Object.assign(document.createElement("div"), { id: "arrow" });
  Object.assign(arrow.style, {
    position: "absolute", left: 0, top: 0, width: "17px", height: "24px", zIndex: 99, pointerEvents: "none",
    background: "#111", filter: "drop-shadow(0 0 1px #fff) drop-shadow(0 1px 2px #0008)",
    clipPath: "polygon(0 0, 0 78%, 24% 60%, 42% 100%, 58% 93%, 41% 55%, 72% 55%)",
  });
  document.body.append(arrow);`;

const profile = mkdtempSync(join(tmpdir(), "camera-"));
const browser = spawn(
  "chromium",
  [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--remote-debugging-pipe",
    `--user-data-dir=${profile}`,
    "about:blank",
  ],
  { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] },
);
const answers = new Map();
let number = 0;
let session;
let rest = "";
browser.stdio[4].setEncoding("utf8").on("data", text => {
  const messages = (rest + text).split("\0");
  rest = messages.pop();
  for (const message of messages.map(one => JSON.parse(one))) {
    answers.get(message.id)?.(message);
    answers.delete(message.id);
  }
});

function call(method, params = {}) {
  return new Promise((done, failed) => {
    answers.set(++number, ({ result, error }) => (error ? failed(new Error(`${method}: ${error.message}`)) : done(result)));
    browser.stdio[3].write(JSON.stringify({ id: number, method, params, sessionId: session }) + "\0");
  });
}

async function run(expression) {
  const { result, exceptionDetails } = await call("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
  if (exceptionDetails) throw new Error(`${expression}: ${exceptionDetails.exception?.description}`);
  return result.value;
}

const sleep = ms => new Promise(done => setTimeout(done, ms));

async function open(page, fragment, [width, height], dark = false) {
  await call("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: false });
  await call("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }] });
  await call("Page.navigate", { url: "about:blank" });
  await call("Page.navigate", { url: `file://${pages}/${page}#${fragment}` });
  while (!(await run("document.body?.dataset.ready === '1'"))) await sleep(50);
  await run("Object.assign(window, landscape, { byId: id => document.getElementById(id) }); 0");
  await settle();
}

// Time passes in which nothing is pictured: sizes are observed, hands glide.
async function settle() {
  for (let k = 0; k < 10; k++) {
    await run(`tick(${FRAME_MS})`);
    await sleep(30);
  }
}

async function picture(file, [width, height], format = "webp") {
  const clip = { x: 0, y: 0, width, height, scale: 1 };
  const quality = format === "webp" ? { quality: 90 } : {};
  const { data } = await call("Page.captureScreenshot", { format, ...quality, clip, captureBeyondViewport: true });
  writeFileSync(file, Buffer.from(data, "base64"));
}

// A picture of a state: after opening, some lines may run in the page.
async function still(name, page, fragment, size, { dark, script, height } = {}) {
  await open(page, fragment, size, dark);
  if (script) await run(script);
  await settle();
  await picture(join(pictures, name + ".webp"), [size[0], height ?? size[1]]);
}

// The loop.
const FILM = [1200, 880];
let place = [700, 560];
let taken = 0;

async function frame(count = 1) {
  for (let k = 0; k < count; k++) {
    await run(`tick(${FRAME_MS})`);
    await picture(join(frames, String(taken++).padStart(4, "0") + ".png"), FILM, "png");
  }
}

async function mouse(type, held = false) {
  const [x, y] = place;
  const button = type === "mouseMoved" && !held ? "none" : "left";
  await call("Input.dispatchMouseEvent", { type, x, y, button, buttons: held ? 1 : 0, clickCount: 1 });
  await run(`arrow.style.transform = "translate(${x}px, ${y}px)"`);
}

async function move([x, y], steps, held = false) {
  const [x0, y0] = place;
  for (let k = 1; k <= steps; k++) {
    const t = k / steps;
    const eased = t * t * (3 - 2 * t);
    place = [x0 + eased * (x - x0), y0 + eased * (y - y0)];
    await mouse("mouseMoved", held);
    await frame();
  }
}

async function click() {
  await mouse("mousePressed", true);
  await mouse("mouseReleased");
}

const centre = selector =>
  run(`(() => { const box = document.querySelector(${JSON.stringify(selector)}).getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]; })()`);
const leaf = item =>
  run(`(() => { const box = panels.tree.drawing.canvas.getBoundingClientRect(); const [x, y] = panels.tree.at(${item}); return [box.left + x, box.top + y]; })()`);

async function film() {
  await open("grasps.html", "", FILM);
  // The panels are a little lower than in a window of this size, so that the way fits below.
  await run(`${ARROW}; window.arrow = arrow; for (const id of ["tree", "graph", "scene"]) byId(id).style.height = "390px"; 0`);
  await settle();
  // A way of moderate length on which the hand turns much.
  const [from, to] = await run(`(() => {
    let best = { gap: -1 };
    for (let a = 0; a < Math.min(12, model.count); a++) for (let b = 0; b < Math.min(24, model.count); b++) {
      const route = a === b ? null : routeOf([a, b]);
      if (!route || route.points.length < 40 || route.points.length > 70) continue;
      const gap = Math.hypot(...model.coordinates(a).slice(0, 7).map((value, k) => value - model.coordinates(b)[k]));
      if (gap > best.gap) best = { gap, ends: [a, b] };
    }
    return best.ends;
  })()`);
  await mouse("mouseMoved");
  await frame(4);
  const [low, high] = await run("[panels.tree.low, panels.tree.top]");
  const others = await run(`Array.from(panels.tree.side.tree.order).filter((_, k, all) => k % Math.ceil(all.length / 4) === 1)`);
  for (const item of others.slice(1, 3)) {
    await move(await leaf(item), 6);
    await frame(6);
  }
  const handle = await centre(".level");
  await move(handle, 6);
  await mouse("mousePressed", true);
  const at = energy => run(`panels.tree.drawing.canvas.getBoundingClientRect().top + panels.tree.y(${energy})`);
  await move([handle[0], await at(low + 0.05 * (high - low))], 16, true);
  await move([handle[0], await at(low + 0.28 * (high - low))], 8, true);
  await mouse("mouseReleased");
  await frame(2);
  const member = await run("derived.basins.list[0][0]");
  await move(await leaf(member), 5);
  await frame(12);
  await move(await centre("#tree .panel-tools [aria-pressed]"), 5);
  await click();
  await frame(2);
  for (const item of [from, to]) {
    await move(await leaf(item), 5);
    await click();
    await frame(4);
  }
  await move(await centre("#way .scrubber button"), 6);
  await click();
  for (let k = 0; k < 90 && (await run("state.step < 1")); k++) await frame();
  await frame(8);
  await run("change({ selected: [], hover: null, step: 0 })");
  await move([700, 560], 4);
  console.log(`${taken} frames of ${FRAME_MS} ms; the way from m${from} to m${to}`);
}

try {
  const { targetInfos } = await call("Target.getTargets");
  const { targetId } = targetInfos.find(target => target.type === "page");
  session = (await call("Target.attachToTarget", { targetId, flatten: true })).sessionId;
  await call("Page.enable");
  await call("Runtime.enable");
  await call("Page.addScriptToEvaluateOnNewDocument", { source: CLOCK });
  const large = [1440, 1000];
  await still("way", "grasps.html", "sel=m3,m17&step=0.62", large, { height: 1030 });
  await still("families", "grasps.html", "sel=m3&level=0.25&pin=m3,m8,m17", [1440, 900]);
  await still("dark", "grasps.html", "sel=m3,m17&level=0.25&step=0.3", large, { dark: true, height: 1030 });
  await still("search", "grasps.html", "q=epsilon+%3E+0.04&chip=category+%3D+power&colour=epsilon", large);
  await still("narrow", "grasps.html", "sel=m3,m17", [390, 844], { height: 1680 });
  await still("projector", "grasps.html", "sel=m3,m17&step=0.4", [1024, 768], { height: 1500 });
  // The link names the folder of these pages, which is a temporary one.
  const exported = 'byId("export-open").click(); const link = byId("link"); link.value = link.value.replace(/^.*[/]/, "file:///home/me/")';
  await still("export", "grasps.html", "sel=m3,m17", [1440, 760], { script: exported });
  await still("labels", "grasps.html", "", [1440, 760], { script: "panels.label.open(); panels.label.go(0); panels.label.give('Medium Wrap')" });
  await still("population", "population.html", "", [1440, 900], { height: 1130 });
  await still("two", "two.html", "sel=m3", [1440, 900]);
  await still("surface", "muller-brown.html", "sel=m0,m1&step=0.3", [1440, 900]);
  await still("line", "double-well.html", "sel=m0,m1&step=0.4", [1440, 640]);
  await still("atoms", "lj-7.html", "sel=m0,m1&step=0.4", [1440, 760]);
  await still("coordinates", "torsion.html", "sel=m0,m4", [1440, 640]);
  await film();
} finally {
  browser.kill();
  await new Promise(done => browser.once("exit", done));
  rmSync(profile, { recursive: true, force: true });
}
