// What the scripts of the tests use besides the page's own names: elements, waiting and events.
const { model, state, derived, panels, look, FAMILY, change, routeOf, onRoute, lookOf, lookOfLabel, poseLinks } = landscape;
const NONE = 0xffffffff;
const byId = id => document.getElementById(id);
const wait = ms => new Promise(done => setTimeout(done, ms));
const settled = async () => {
  for (let k = 0; k < 3; k++) await new Promise(done => requestAnimationFrame(done));
  await wait(20);
};
const press = async (target, key, more = {}) => {
  target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
  await settled();
};
const point = async (target, kind, [x, y], more = {}) => {
  const box = target.getBoundingClientRect();
  const place = { clientX: box.left + x, clientY: box.top + y, bubbles: true, cancelable: true, pointerId: 1, ...more };
  target.dispatchEvent(kind === "click" ? new MouseEvent(kind, place) : new PointerEvent(kind, place));
  await settled();
};
const type = async (field, text) => {
  field.value = text;
  field.dispatchEvent(new Event("input", { bubbles: true }));
  await settled();
};
