// Unpacks the data of the page, which src/study/page/pack.rs wrote: a header (JSON) and arrays of numbers behind it.

/**
 * What src/study/page writes, and what is prepared here: `starts`, `order`, `merge` and `rounding`.
 *
 * @typedef {{ texts: string[], of: ArrayLike<number> }} Texts the text of each item
 * @typedef {"label" | "category" | "cell" | "given"} LabelField
 * @typedef {{ label: Texts, category: Texts, cell: Texts, type: Uint8Array }} Labels
 * @typedef {{ colour: string, corners: number[][], open: boolean }} Look without corners it is a disc
 * @typedef {{ colour: string, symbol: string, open: boolean }} GivenLook
 * @typedef {{ number: number, name: string, aliases: string[], category: string, cell: string, cue: string }} GraspType
 * @typedef {{ kind: string, dimensions: number, contours?: Contours | null }} Space
 * @typedef {{ low: number[], high: number[], columns: number, energy: Float32Array }} Contours
 * @typedef {{ width: number, x: Float32Array, energy: Float64Array, parent: Uint32Array, evidence: Uint8Array, support: Float32Array,
 *   searches: Uint32Array, ended: Uint32Array, order: Uint32Array, tested: boolean }} Tree
 * @typedef {{ of: string, minimum: Uint32Array, x: Float32Array, y: Float32Array, radius: Float32Array, a: Uint32Array, b: Uint32Array,
 *   height: Float64Array, width: Float32Array, evidence: Uint8Array, is_lowest: Uint8Array }} Graph
 * @typedef {{ a: Uint32Array, b: Uint32Array, points: Uint32Array, starts: Uint32Array, height: Float64Array, evidence: Uint8Array,
 *   kind: Texts, term: Texts, coordinates: Float64Array, energy: Float32Array, along: Float32Array, terms: Float64Array | null }} Ways
 * @typedef {{ size: number[], x: Float32Array, y: Float32Array,
 *   parts: { name: string, corner: number[], size: number[], error: number | null }[] }} Likeness
 * @typedef {{ members: number, kinds: number, deviation: number | null }} Rarefied
 * @typedef {import("./kinematics.js").Hand} Hand
 * @typedef {{ name: string, vertices: Float32Array, triangles: Uint32Array }} Body
 * @typedef {{ hand: Hand, object: Body }} Pair
 * @typedef {{ before: number, after: number, distance: number, energies: [number, number] }} Match
 * @typedef {{ notes: string[], within: number, matches: Match[], possible: Match[], only_before: number[], only_after: number[],
 *   merges: { ends: number[], before: number, after: number | null }[] }} Difference
 * @typedef {Partial<Labels> & { name: string, title: string, subject?: string, count: number, energy: Float64Array, energy_label: string,
 *   members: string[], members_label: string, member_count?: Uint32Array, family?: Uint32Array, families?: number,
 *   family_names?: { family: number, name: string }[] | null, space: Space, coordinates?: Float32Array, counterparts?: Float32Array,
 *   scene?: number, scenes?: Uint32Array, object?: Texts, term_names?: string[], terms?: Float32Array,
 *   stable?: Uint8Array, epsilon?: Float32Array, friction?: number, touches?: { count: Uint8Array, touch: Float64Array, starts: Uint32Array },
 *   given?: Texts, by_rule?: Labels, rule?: string[], certainty?: Float32Array, key?: string,
 *   trust?: import("./trust.js").Statement[], rarefaction?: Record<string, { curve?: Rarefied[] }> | null,
 *   merge: Uint32Array, rounding: number }} Items
 * @typedef {Items & { item: "minimum", tree: Tree, graph: Graph, ways?: Ways, family: Uint32Array, likeness?: undefined }} Landscape
 * @typedef {Items & { item: "grasp", tree?: undefined, ways?: undefined, likeness: Likeness }} Grasps
 * @typedef {Landscape | Grasps} Side
 * @typedef {{ made_by: string, command: string, hands: Hand[], objects: Body[], scenes: [number, number][], sides: Side[],
 *   difference: Difference | null, evidence: string[], taxonomy: GraspType[],
 *   looks: { symbols: Record<string, number[][]>, heart: number, known: [string, GivenLook][], greys: [string, GivenLook][],
 *   in_turn: GivenLook[] } }} Header
 */

// Stands for "none" in arrays of numbers of minima and nodes.
export const NONE = 0xffffffff;
const NOTHING = new Float32Array();
/** @type {Record<string, Float64ArrayConstructor | Float32ArrayConstructor | Uint32ArrayConstructor | Uint8ArrayConstructor>} */
const KINDS = { f8: Float64Array, f4: Float32Array, u4: Uint32Array, u1: Uint8Array };

/** @param {string} text @returns {Promise<Header>} */
export async function unpack(text) {
  const letters = atob(text.trim());
  const packed = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) packed[k] = letters.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return revived(header, buffer.slice(4 + length));
}

/** Replaces the descriptions of arrays in a part of a header by the arrays. @param {any} value @param {ArrayBuffer} buffer @returns {any} */
function revived(value, buffer) {
  if (Array.isArray(value)) return value.map(part => revived(part, buffer));
  if (value === null || typeof value !== "object") return value;
  if (value.packed === "table") return table(value, buffer);
  if (value.packed) return new KINDS[value.packed](buffer, value.start, value.count);
  return Object.fromEntries(Object.entries(value).map(([key, part]) => [key, revived(part, buffer)]));
}

/**
 * Numbers in steps of their column, stored column by column as differences; read row by row.
 *
 * @param {{ start: number, count: number, low: number[], step: number[] }} description
 * @param {ArrayBuffer} buffer
 */
function table({ start, count, low, step }, buffer) {
  const columns = low.length;
  const steps = new Uint16Array(buffer, start, count * columns);
  const values = new Float64Array(count * columns);
  for (let column = 0; column < columns; column++) {
    let sum = 0;
    for (let row = 0; row < count; row++) {
      sum = (sum + steps[column * count + row]) & 0xffff;
      values[row * columns + column] = low[column] + sum * step[column];
    }
  }
  return values;
}

/** Start of each entry of a list of lists, whose lengths are `counts`, and the end of the last. @param {ArrayLike<number>} counts */
export function startsOf(counts) {
  const starts = new Uint32Array(counts.length + 1);
  for (let k = 0; k < counts.length; k++) starts[k + 1] = starts[k] + counts[k];
  return starts;
}

/** Puts a value behind others of its key. @template Key, Value @param {Map<Key, Value[]>} lists @param {Key} key @param {Value} value */
export function append(lists, key, value) {
  const list = lists.get(key);
  if (list) list.push(value);
  else lists.set(key, [value]);
}

/** @param {Hand} hand */
function prepareHand(hand) {
  hand.skin.starts = startsOf(hand.skin.count);
  hand.order = hand.links.map((link, index) => [link.parent === null ? -1 : link.parent, index, link]);
}

// The items of a page (minima or grasps of all its landscapes) under one numbering.
export class Model {
  /** @param {Header} header @param {string} folder */
  constructor(header, folder) {
    this.header = header;
    this.sides = header.sides;
    this.landscapes = this.sides.filter(side => side.item === "minimum");
    // The page in the folder of a landscape takes the name of this folder.
    for (const side of this.sides) side.name ||= folder;
    this.offsets = startsOf(this.sides.map(side => side.count));
    this.count = this.offsets[this.sides.length];
    for (const hand of header.hands) prepareHand(hand);
    for (const side of this.sides) this.prepare(side);
    // For each minimum of the second landscape, the number of its match.
    /** @type {Map<number, number>} */
    this.matchOf = new Map();
    this.partner = this.partners();
    // Labels that were given on the page, by item; an empty text takes the label of the file away.
    /** @type {Map<number, string>} */
    this.own = new Map();
    this.types = new Map(header.taxonomy.map(type => [type.name, type]));
    // Looks of labels, in the order of legends: known ones, and the grey ones. Others take looks in turn.
    const { symbols, known, greys, in_turn } = header.looks;
    /** @type {(given: GivenLook) => Look} */
    const withCorners = given => ({ ...given, corners: symbols[given.symbol] });
    this.key = new Map([...known, ...greys].map(([label, given]) => [label, withCorners(given)]));
    this.inTurn = in_turn.map(withCorners);
  }

  /** @param {Side} side */
  prepare(side) {
    if (side.touches) side.touches.starts = startsOf(side.touches.count);
    if (side.ways) side.ways.starts = startsOf(side.ways.points);
    // For each item the merge in which its branch ends.
    side.merge = side.tree ? side.tree.parent.subarray(0, side.count) : new Uint32Array(side.count).fill(NONE);
    // Energies that differ from zero by rounding are zero.
    side.rounding = side.tree ? ROUNDING * differenceIn([...side.energy, ...side.tree.energy]) : 0;
    if (side.rounding > 0) side.energy = side.energy.map(energy => (Math.abs(energy) < side.rounding ? 0 : energy));
  }

  // For each minimum, the corresponding one of the other landscape, if there are two.
  partners() {
    const partner = new Uint32Array(this.count).fill(NONE);
    (this.header.difference?.matches ?? []).forEach(({ before, after }, match) => {
      partner[before] = this.offsets[1] + after;
      partner[this.offsets[1] + after] = before;
      this.matchOf.set(this.offsets[1] + after, match);
    });
    return partner;
  }

  /** An item of the second landscape, turned to stand like its counterpart in the first; null if it has none. @param {number} item */
  besidePartner(item) {
    const [side] = this.at(item);
    const match = this.matchOf.get(item);
    if (match === undefined || !side.counterparts) return null;
    return side.counterparts.subarray(match * side.space.dimensions, (match + 1) * side.space.dimensions);
  }

  /** @param {number} item */
  sideOf(item) {
    return this.sides.length > 1 && item >= this.offsets[1] ? 1 : 0;
  }

  /** Landscape and number in it. @param {number} item @returns {[Side, number]} */
  at(item) {
    const side = this.sideOf(item);
    return [this.sides[side], item - this.offsets[side]];
  }

  /** @param {number} item */
  name(item) {
    const [side, k] = this.at(item);
    return side.item === "grasp" ? "#" + side.members[k] : "m" + k + (this.sideOf(item) ? "′" : "");
  }

  /** The item with this name, or null. @param {string} text */
  named(text) {
    const parts = /^(m|#)?(\d+)(['′]?)$/.exec(text.trim());
    if (!parts) return null;
    const [, , number, prime] = parts;
    const side = this.sides[prime ? 1 : 0];
    if (!side) return null;
    const k = side.item === "grasp" ? side.members.indexOf(number) : Number(number);
    return k >= 0 && k < side.count ? this.offsets[prime ? 1 : 0] + k : null;
  }

  /** @param {number} item */
  energy(item) {
    const [side, k] = this.at(item);
    return side.energy[k];
  }

  /** @param {number} item */
  coordinates(item) {
    const [side, k] = this.at(item);
    const n = side.space?.dimensions ?? 0;
    return (side.coordinates ?? NOTHING).subarray(k * n, (k + 1) * n);
  }

  // The text of a field, empty if there is none. A label is the one given on the page, else that of a person in the file, else
  // that by the rule. All panels take it from here.
  /** @param {LabelField | "object"} field @param {number} item @returns {string} */
  text(field, item) {
    const [side, k] = this.at(item);
    if (field === "object") return textOf(side.object, k);
    const own = this.own.get(item);
    if (own) return { ...this.types.get(own), label: own, given: own }[field] ?? "";
    if (own === "") return field === "given" ? "" : textOf(side.by_rule?.[field] ?? side[field], k);
    return textOf(side[field], k);
  }

  /** The number of the type by the same label; 0 if it has none. @param {number} item */
  type(item) {
    const [side, k] = this.at(item);
    const own = this.own.get(item);
    if (own) return this.types.get(own)?.number ?? 0;
    return ((own === "" && side.by_rule?.type) || side.type)?.[k] ?? 0;
  }

  /** The label by the rule alone. @param {number} item */
  byRule(item) {
    const [side, k] = this.at(item);
    return textOf((side.by_rule ?? side).label, k);
  }

  /** The types that fit best by the rule, with their scores. @param {number} item */
  rule(item) {
    const [side, k] = this.at(item);
    return side.rule?.[k] ?? "";
  }

  /** The probability of the labeller's answer, 0 to 1; 0 if it has none. @param {number} item */
  certainty(item) {
    const [side, k] = this.at(item);
    return side.certainty?.[k] ?? 0;
  }

  /** A number of the item; NaN if unknown. @param {string} field @param {number} item @returns {number} */
  number(field, item) {
    const [side, k] = this.at(item);
    const above = side.merge[k];
    switch (field) {
      case "members":
        return side.member_count?.[k] ?? 1;
      case "type":
        return this.type(item) || NaN;
      case "stable":
        return side.stable && side.stable[k] < 2 ? side.stable[k] : NaN;
      case "joins":
        return side.tree?.energy[above] ?? NaN;
      case "barrier":
        return this.number("joins", item) - side.energy[k];
      case "support":
        return side.tree?.support[above] ?? NaN;
      case "energy":
      case "epsilon":
      case "family":
        return side[field]?.[k] ?? NaN;
      default:
        return NaN;
    }
  }

  /** Evidence of the merge in which the branch of an item ends. @param {number} item */
  evidence(item) {
    const [side, k] = this.at(item);
    return side.tree && side.merge[k] !== NONE ? this.header.evidence[side.tree.evidence[side.merge[k]]] : "";
  }

  /** Hand and object of an item. @param {number} item @returns {Pair | null} */
  scene(item) {
    const [side, k] = this.at(item);
    const pair = this.header.scenes[side.scenes?.[k] ?? side.scene ?? NONE];
    return pair ? { hand: this.header.hands[pair[0]], object: this.header.objects[pair[1]] } : null;
  }

  /** Whether any item of the page has this field. @param {string} field */
  knows(field) {
    const has = HAS[field] ?? (side => Reflect.get(side, field));
    return this.sides.some(side => Boolean(has(side)));
  }
}

/** How to see that there is a field, if not by its own name. @type {Record<string, (side: Side) => unknown>} */
const HAS = {
  stable: side => side.stable?.some(held => held < 2),
  epsilon: side => side.epsilon?.some(value => !Number.isNaN(value)),
  members: side => side.member_count,
  support: side => side.tree?.tested,
  joins: side => side.tree,
  barrier: side => side.tree,
  evidence: side => side.tree,
  type: side => side.label,
};

/** @param {Texts | undefined} column @param {number} k */
function textOf(column, k) {
  return column ? column.texts[column.of[k]] : "";
}

// Energies that differ by less than this share of the height of the tree differ by rounding.
const ROUNDING = 1e-9;

/** The greatest difference of finite numbers. @param {Iterable<number>} values */
function differenceIn(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
  return high > low ? high - low : 0;
}
