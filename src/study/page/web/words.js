// What the words of the page mean: shown beside headings and heads of columns, under the pointer and at the focus.

import { headingOf, tip } from "./dom.js";
import { model } from "./state.js";
import { dictionary, plain, plural, shown } from "./text.js";

const MEANINGS = dictionary({
  tree:
    "Each end of a branch is a minimum, and its height is the energy. Two branches join at the height of the lowest pass that " +
    "was found between them. Sideways positions mean nothing. Click a join or a branch to see only what hangs below it.",
  graph:
    "Circles are minima; near each other means that the barrier between them is low. A line is a way that was found: thick lines " +
    "are low barriers, pale ones are never part of a lowest way, dashed ones are upper bounds.",
  tangle:
    "Each tree lies on its side, with the energy growing outward. A line joins a minimum with the same one of the other " +
    "landscape. Crossings mean only that the trees are drawn in another order.",
  scene: "The item under the pointer, else the one chosen last, else the first of the table. Drag to turn it.",
  likeness:
    "Each dot is a grasp, and near each other means alike: distances follow the mean movement of the parts of the hand from one " +
    "grasp to the other.",
  way: "The way between two chosen minima with the lowest highest point that was found, and the parts that add up to its energy.",
  pins: "Items that are kept in sight; they share one camera.",
  table: "All items that pass the filters. Click a head to sort, a row to choose.",
  matrix:
    "The 33 grasp types of Feix et al. (2016). A column is a way to oppose the thumb or palm and the fingers that do; a row is " +
    "the place of the thumb. 14·3 means three grasps of type 14. Click one to see only those.",
  moved: "How the second landscape differs from the first.",
  rarefaction:
    "How many kinds a smaller sample of these grasps would have shown, with a 95 % band; dashed beyond the grasps at hand. A curve " +
    "that still rises at its end says that more grasps would show more kinds.",
  name: "A minimum is a pose that no small movement improves. m0 is the deepest.",
  energy: "The height in the tree. Low is good.",
  family:
    "Minima that are joined by low barriers, by the level at which this landscape was built: g0, g1 and so on. They stay when the " +
    "level line moves; the families below the line do not.",
  members: "How many searches ended at this minimum.",
  epsilon:
    "Ferrari and Canny's quality of a grasp: the least load, of all directions, that the contacts cannot resist if their forces " +
    "add up to 1, with friction 0.5. Above 0 any small load is resisted; more is better.",
  stable: "Whether the object stayed in the hand in the simulation.",
  joins: "Energy of the lowest pass that was found from this minimum to the rest: where its branch joins the tree.",
  support:
    "How sure it is that this branch joins the rest no lower: 1 minus the chance that a lower way exists. The chance follows from how " +
    "many independent searches across the join ended here, at its height: the more, the less likely a lower way. –: not searched.",
  evidence:
    "On what the height of the join rests. saddle: verified, the slope is zero there. path: the top of a relaxed path. " +
    "chain: an upper bound. given: taken from another program.",
  label:
    "Grasp type: the label of a person if there is one, else that of the rule. A text such as power/pad/2-5/abducted is a cell of the " +
    "table of types: category, opposition, fingers that oppose the thumb (2 is the index, 5 the little finger), place of the thumb.",
  object: "The object that is held.",
});

const GRASPS = dictionary({
  name: "The number of the grasp in its file.",
  members: "How many grasps descended to this minimum.",
});

/** @type {Record<string, string>} */
export const EVIDENCE_WORDS = {
  saddle: "the lowest pass found; its slope is zero (verified)",
  given: "a transition state of another program, not verified here",
  path: "the lowest pass found; it is the top of a relaxed path",
  chain: "an upper bound: the pass may lie lower",
  none: "no path",
};

// Lets an element explain itself, under the pointer and at the focus of the keyboard.
/** @param {HTMLElement} element @param {string | undefined} words */
export function explain(element, words) {
  if (!words) return element;
  if (!element.matches("button")) element.tabIndex = 0;
  element.classList.add("explained");
  element.setAttribute("aria-description", words);
  const show = () => {
    const box = element.getBoundingClientRect();
    tip([element.textContent.trim(), words], box.left - 14, box.bottom - 10);
  };
  element.addEventListener("pointerenter", show);
  element.addEventListener("pointerleave", () => tip(null));
  element.addEventListener("focus", () => element.matches(":focus-visible") && show());
  element.addEventListener("blur", () => tip(null));
  return element;
}

/** The meaning of a name on this page. @param {string} name */
export function meaning(name) {
  return (model.sides[0].space?.kind === "pose" && (model.sides[0].item === "grasp" || name !== "name") && GRASPS[name]) || MEANINGS[name];
}

/** @param {string | undefined} likeness the meaning of that panel, which says how right it is */
export function explainHeadings(likeness) {
  for (const panel of document.querySelectorAll(".panel:not([hidden]), #way, #pins"))
    explain(headingOf(panel), (panel.id === "likeness" && likeness) || meaning(panel.id));
}

/** A family with the name that a person would give it, if the landscape has one. @param {import("./data.js").Side} side @param {number} family */
export function familyName(side, family) {
  const name = side.family_names?.find(one => one.family === family)?.name;
  return name ? `g${family}: ${name}` : `g${family}`;
}

/** What is said of an item beside the pointer. @param {number} item */
export function described(item) {
  const [side] = model.at(item);
  const label = plain(model.text("label", item));
  const stable = model.number("stable", item);
  /** @param {string} field @param {string} words */
  const number = (field, words) => {
    const value = model.number(field, item);
    return Number.isNaN(value) ? "" : `${words} ${shown(value)}`;
  };
  const grasps = side.item === "minimum" && side.space?.kind === "pose";
  return [
    model.name(item) + (label ? ` · ${label}` : ""),
    number("energy", "energy"),
    number("epsilon", "ε"),
    Number.isNaN(stable) ? "" : stable ? "held in simulation" : "fell in simulation",
    grasps ? `${plural(model.number("members", item), "grasp", "grasps")}, family ${familyName(side, model.number("family", item))}` : "",
    number("joins", "joins others at"),
  ].filter(line => line);
}
