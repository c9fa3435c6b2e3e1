// Unpacks the data of the page, which src/study/page/pack.rs wrote: a header (JSON) and arrays of numbers behind it.

// Stands for "none" in arrays of numbers of minima and nodes.
export const NONE = 0xffffffff;
const LABEL_FIELDS = ["label", "category", "cell", "given"];
const KINDS = { f8: Float64Array, f4: Float32Array, u4: Uint32Array, u1: Uint8Array };

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

// Replaces the descriptions of arrays in a header by the arrays.
function revived(value, buffer) {
  if (Array.isArray(value)) return value.map(part => revived(part, buffer));
  if (value === null || typeof value !== "object") return value;
  if (value.packed === "table") return table(value, buffer);
  if (value.packed) return new KINDS[value.packed](buffer, value.start, value.count);
  return Object.fromEntries(Object.entries(value).map(([key, part]) => [key, revived(part, buffer)]));
}

// Numbers in steps of their column, stored column by column as differences; read row by row.
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

// Start of each entry of a list of lists, whose lengths are `counts`, and the end of the last.
export function startsOf(counts) {
  const starts = new Uint32Array(counts.length + 1);
  for (let k = 0; k < counts.length; k++) starts[k + 1] = starts[k] + counts[k];
  return starts;
}

function prepareHand(hand) {
  hand.skin.starts = startsOf(hand.skin.count);
  hand.order = hand.links.map((link, index) => [link.parent === null ? -1 : link.parent, index, link]);
}

// The items of a page (minima or grasps of all its landscapes) under one numbering.
export class Model {
  constructor(header, folder) {
    this.header = header;
    this.sides = header.sides;
    // The page in the folder of a landscape takes the name of this folder.
    for (const side of this.sides) side.name ||= folder;
    this.offsets = startsOf(this.sides.map(side => side.count));
    this.count = this.offsets[this.sides.length];
    for (const hand of header.hands) prepareHand(hand);
    for (const side of this.sides) this.prepare(side);
    this.partner = this.partners();
    // Labels that were given on the page, by item; an empty text takes the label of the file away.
    this.own = new Map();
    this.types = new Map(header.taxonomy.map(type => [type.name, type]));
    // Looks of labels, in the order of legends: known ones, and the grey ones. Others take looks in turn.
    const { symbols, known, greys, in_turn } = header.looks;
    const withCorners = given => ({ ...given, corners: symbols[given.symbol] });
    this.key = new Map([...known, ...greys].map(([label, given]) => [label, withCorners(given)]));
    this.inTurn = in_turn.map(withCorners);
  }

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
    this.matchOf = new Map();
    (this.header.difference?.matches ?? []).forEach(({ before, after }, match) => {
      partner[before] = this.offsets[1] + after;
      partner[this.offsets[1] + after] = before;
      this.matchOf.set(this.offsets[1] + after, match);
    });
    return partner;
  }

  // An item of the second landscape, turned to stand like its counterpart in the first; null if it has none.
  besidePartner(item) {
    const [side] = this.at(item);
    const match = this.matchOf.get(item);
    if (match === undefined || !side.counterparts) return null;
    return side.counterparts.subarray(match * side.space.dimensions, (match + 1) * side.space.dimensions);
  }

  sideOf(item) {
    return this.sides.length > 1 && item >= this.offsets[1] ? 1 : 0;
  }

  // Landscape and number in it.
  at(item) {
    const side = this.sideOf(item);
    return [this.sides[side], item - this.offsets[side]];
  }

  name(item) {
    const [side, k] = this.at(item);
    return side.item === "grasp" ? "#" + side.members[k] : "m" + k + (this.sideOf(item) ? "′" : "");
  }

  // The item with this name, or null.
  named(text) {
    const parts = /^(m|#)?(\d+)(['′]?)$/.exec(text.trim());
    if (!parts) return null;
    const [, , number, prime] = parts;
    const side = this.sides[prime ? 1 : 0];
    if (!side) return null;
    const k = side.item === "grasp" ? side.members.indexOf(number) : Number(number);
    return k >= 0 && k < side.count ? this.offsets[prime ? 1 : 0] + k : null;
  }

  energy(item) {
    const [side, k] = this.at(item);
    return side.energy[k];
  }

  coordinates(item) {
    const [side, k] = this.at(item);
    const n = side.space?.dimensions ?? 0;
    return side.coordinates ? side.coordinates.subarray(k * n, (k + 1) * n) : null;
  }

  // The label of an item in one of the fields `label`, `type`, `category`, `cell` and `given`: the one given on the page, else
  // that of a person in the file, else that by the rule. All panels take it from here.
  labelled(field, item) {
    const [side, k] = this.at(item);
    const own = this.own.get(item);
    if (own) {
      const type = this.types.get(own);
      return { label: own, given: own, type: type?.number, category: type?.category, cell: type?.cell }[field] ?? "";
    }
    if (own === "" && field === "given") return "";
    const column = (own === "" ? side.by_rule : null)?.[field] ?? side[field];
    return column?.texts ? column.texts[column.of[k]] : (column?.[k] ?? "");
  }

  // The label by the rule alone.
  byRule(item) {
    const [side, k] = this.at(item);
    const column = (side.by_rule ?? side).label;
    return column ? column.texts[column.of[k]] : "";
  }

  // The text of a field such as `label`, `category` or `object`; empty if there is none.
  text(field, item) {
    if (LABEL_FIELDS.includes(field)) return this.labelled(field, item);
    const [side, k] = this.at(item);
    return side[field] ? side[field].texts[side[field].of[k]] : "";
  }

  // The types that fit best by the rule, with their scores.
  rule(item) {
    const [side, k] = this.at(item);
    return side.rule?.[k] ?? "";
  }

  // The probability of the labeller's answer, 0 to 1; 0 if it has none.
  certainty(item) {
    const [side, k] = this.at(item);
    return side.certainty?.[k] ?? 0;
  }

  // A number of the item; NaN if unknown.
  number(field, item) {
    const [side, k] = this.at(item);
    const above = side.merge[k];
    switch (field) {
      case "members":
        return side.member_count?.[k] ?? 1;
      case "type":
        return this.labelled("type", item) || NaN;
      case "stable":
        return side.stable?.[k] < 2 ? side.stable[k] : NaN;
      case "joins":
        return above === NONE ? NaN : side.tree.energy[above];
      case "barrier":
        return above === NONE ? NaN : side.tree.energy[above] - side.energy[k];
      case "support":
        return above === NONE ? NaN : side.tree.support[above];
      case "energy":
      case "epsilon":
      case "family":
        return side[field]?.[k] ?? NaN;
      default:
        return NaN;
    }
  }

  // Evidence of the merge in which the branch of an item ends.
  evidence(item) {
    const [side, k] = this.at(item);
    return side.merge[k] === NONE ? "" : this.header.evidence[side.tree.evidence[side.merge[k]]];
  }

  // Hand and object of an item.
  scene(item) {
    const [side, k] = this.at(item);
    const pair = this.header.scenes[side.scenes ? side.scenes[k] : side.scene];
    return pair ? { hand: this.header.hands[pair[0]], object: this.header.objects[pair[1]] } : null;
  }

  // Whether any item of the page has this field.
  knows(field) {
    const has = {
      stable: side => side.stable?.some(held => held < 2),
      epsilon: side => side.epsilon?.some(value => !Number.isNaN(value)),
      members: side => side.member_count,
      support: side => side.tree?.tested,
      joins: side => side.tree,
      barrier: side => side.tree,
      evidence: side => side.tree,
      type: side => side.label,
    }[field];
    return this.sides.some(side => Boolean(has ? has(side) : side[field]));
  }
}

// Energies that differ by less than this share of the height of the tree differ by rounding.
const ROUNDING = 1e-9;

// The greatest difference of finite numbers.
function differenceIn(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
  return high > low ? high - low : 0;
}
