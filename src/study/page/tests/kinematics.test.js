import assert from "node:assert/strict";
import { test } from "node:test";
import { between, poseLinks, poseSkin } from "../web/kinematics.js";

const UNIT = [1, 0, 0, 0, 1, 0, 0, 0, 1];
const near = (a, b) => assert.ok(a.length === b.length && a.every((value, k) => Math.abs(value - b[k]) < 1e-12), `${a}\n${b}`);

// A finger that turns about z at the origin, and a slide along x one metre further; a vertex at the end of each.
const links = [
  { parent: null, rotation: UNIT, translation: [0, 0, 0], ball: null, motion: { joint: 0, ratio: 1, offset: 0, axis: [0, 0, 1], slides: false } },
  { parent: 0, rotation: UNIT, translation: [1, 0, 0], ball: null, motion: { joint: 1, ratio: 2, offset: 0.1, axis: [1, 0, 0], slides: true } },
];
const hand = {
  links,
  joints: [{}, {}],
  order: links.map((link, index) => [link.parent ?? -1, index, link]),
  skin: { count: [1, 2], starts: [0, 1, 3], link: [0, 0, 1], binding: [1, 0, 0, 1, 1, 0, 0, 0.5, 0, 0, 0, 0.5] },
};
const half = Math.SQRT1_2;

test("links turn and slide with their joints", () => {
  const frames = poseLinks(hand, [0, 0, 5, 1, 0, 0, 0, Math.PI / 2, 0.2]);
  near([...frames.slice(0, 12)], [0, -1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5]);
  near([...frames.slice(21, 24)], [0, 1.5, 5]);
});

test("the wrist turns the whole hand, whatever the length of its quaternion", () => {
  const frames = poseLinks(hand, [0, 0, 0, 3 * half, 3 * half, 0, 0, 0, 0]);
  near([...frames.slice(0, 9)], [1, 0, 0, 0, 0, -1, 0, 1, 0]);
});

test("a vertex of two links stands between them", () => {
  const skin = poseSkin(hand, poseLinks(hand, [0, 0, 0, 1, 0, 0, 0, 0, 0.2]), new Float64Array(6));
  near([...skin], [1, 0, 0, 1.25, 0, 0]);
});

test("ball joints turn by the angles of their map", () => {
  const ball = { ...links[0], motion: null, ball: 0 };
  const bent = { links: [ball], joints: [{}], order: [[-1, 0, ball]], skin: hand.skin, bending: { offset: [0, 0, 0], map: [0, 0, 2] } };
  near([...poseLinks(bent, [0, 0, 0, 1, 0, 0, 0, Math.PI / 4]).slice(0, 3)], [0, -1, 0]);
});

test("between two poses the rotation goes the short way, and all else is straight", () => {
  const [a, b] = [
    [0, 0, 0, 1, 0, 0, 0, 0],
    [2, 0, 0, -half, -half, 0, 0, 1],
  ];
  const [sin, cos] = [Math.sin(Math.PI / 8), Math.cos(Math.PI / 8)];
  near([...between(a, b, 0.5, true)], [1, 0, 0, cos, sin, 0, 0, 0.5]);
  near([...between(a, b, 0.5, false)], [1, 0, 0, (1 - half) / 2, -half / 2, 0, 0, 0.5]);
});
