// A landscape of four minima, as `pack.rs` describes one, for the tests.
import { Model, NONE } from "../web/data.js";

// m0 and m1 join at 1 (node 4), m2 joins them at 2 (node 5), m3 at 3 (node 6).
export const tree = {
  energy: [0, 0.5, 0.2, 0.3, 1, 2, 3],
  parent: Uint32Array.of(4, 4, 5, 6, 5, 6, NONE),
  evidence: [0, 0, 0, 0, 0, 1, 0],
  tested: true,
  support: [NaN, NaN, NaN, NaN, 0.99, 0.5, 0.9],
};

const column = texts => ({ texts, of: texts.map((_, k) => k) });

export const side = () => ({
  name: "four.landscape",
  item: "minimum",
  count: 4,
  energy: Float64Array.of(0, 0.5, 0.2, 0.3),
  family: [0, 0, 1, 2],
  stable: [1, 0, 2, 1],
  member_count: [3, 1, 1, 1],
  label: column(["Tripod", "Writing Tripod", "", "Medium Wrap"]),
  category: column(["precision", "precision", "", "power"]),
  tree,
  ways: { a: [0, 1, 0], b: [1, 2, 3], points: [2, 3, 2], energy: [0, 0.5, 0.5, 2, 0.2, 0, 0.3], along: [0, 1, 0, 1, 2, 0, 1] },
});

const header = sides => ({
  sides,
  hands: [],
  taxonomy: [{ name: "Tripod", number: 14, category: "precision", cell: "precision/pad/2-3/abducted" }],
  looks: { symbols: { disc: [] }, known: [], greys: [], in_turn: [] },
  evidence: ["saddle", "chain"],
});

export const model = (more = {}) => new Model(header([{ ...side(), ...more }]), "x.landscape");
