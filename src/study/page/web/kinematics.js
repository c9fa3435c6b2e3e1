// Forward kinematics and skinning of hands, with the formulas of src/hand/kinematics.rs, skin.rs and blend.rs.

/**
 * @typedef {{ parent: number | null, rotation: number[], translation: Three, ball: number | null,
 *   motion: { joint: number, ratio: number, offset: number, axis: Three, slides: boolean } | null }} Link
 * @typedef {{ links: Link[], joints: object[], order: [number, number, Link][], bending?: Bending | null,
 *   skin: { count: ArrayLike<number>, link: ArrayLike<number>, binding: ArrayLike<number>, starts: ArrayLike<number>, triangles: Uint32Array } }} Hand
 * @typedef {{ offset: ArrayLike<number>, map: ArrayLike<number> }} Bending
 * @typedef {[number, number, number]} Three
 * @typedef {ArrayLike<number>} List
 */

// A frame is 12 numbers: the rotation row by row, then the translation.
const FRAME = 12;

// out = a · b for rotations, row by row, at these places.
/** @param {List} a @param {number} from @param {List} b @param {Float64Array} out @param {number} to */
function turnBy(a, from, b, out, to) {
  for (let row = 0; row < 3; row++) {
    const [x, y, z] = [a[from + 3 * row], a[from + 3 * row + 1], a[from + 3 * row + 2]];
    for (let column = 0; column < 3; column++) {
      out[to + 3 * row + column] = x * b[column] + y * b[3 + column] + z * b[6 + column];
    }
  }
}

/** The rotation by the vector `angle` · `axis`, row by row. @param {Three} axis @param {number} angle */
function rotationAbout([x, y, z], angle) {
  const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
  const rest = 1 - cos;
  return [
    cos + x * x * rest,
    x * y * rest - z * sin,
    x * z * rest + y * sin,
    y * x * rest + z * sin,
    cos + y * y * rest,
    y * z * rest - x * sin,
    z * x * rest - y * sin,
    z * y * rest + x * sin,
    cos + z * z * rest,
  ];
}

/** @param {number} w @param {number} x @param {number} y @param {number} z */
function rotationOf(w, x, y, z) {
  const norm = Math.hypot(w, x, y, z) || 1;
  [w, x, y, z] = [w / norm, x / norm, y / norm, z / norm];
  return [
    1 - 2 * (y * y + z * z),
    2 * (x * y - w * z),
    2 * (x * z + w * y),
    2 * (x * y + w * z),
    1 - 2 * (x * x + z * z),
    2 * (y * z - w * x),
    2 * (x * z - w * y),
    2 * (y * z + w * x),
    1 - 2 * (x * x + y * y),
  ];
}

/** Rotations of the ball joints of MANO at the joint coordinates `q`. @param {Bending} bending @param {List} q */
function ballRotations(bending, q) {
  const angles = Float64Array.from(bending.offset);
  for (let joint = 0; joint < q.length; joint++) {
    for (let k = 0; k < angles.length; k++) angles[k] += bending.map[joint * angles.length + k] * q[joint];
  }
  const rotations = [];
  for (let k = 0; k < angles.length; k += 3) {
    const [x, y, z] = angles.subarray(k, k + 3);
    const angle = Math.hypot(x, y, z);
    rotations.push(rotationAbout(angle > 0 ? [x / angle, y / angle, z / angle] : [1, 0, 0], angle));
  }
  return rotations;
}


/**
 * Frames of all links in the object's frame at x = [t, q(wxyz), joints].
 *
 * @param {Hand} hand
 * @param {ArrayLike<number>} x
 */
export function poseLinks(hand, x) {
  const frames = new Float64Array(FRAME * hand.links.length);
  const joints = Array.from(x).slice(7, 7 + hand.joints.length);
  const balls = hand.bending ? ballRotations(hand.bending, joints) : [];
  const base = [...rotationOf(x[3], x[4], x[5], x[6]), x[0], x[1], x[2]];
  for (const [parent, index, link] of hand.order) {
    const [carrier, from, to] = [parent < 0 ? base : frames, parent < 0 ? 0 : FRAME * parent, FRAME * index];
    turnBy(carrier, from, link.rotation, frames, to);
    moveBy(carrier, from, link.translation, carrier, from + 9, frames, to + 9);
    const motion = link.motion;
    if (motion) {
      const way = motion.ratio * joints[motion.joint] + motion.offset;
      if (motion.slides)
        moveBy(
          frames,
          to,
          [way * motion.axis[0], way * motion.axis[1], way * motion.axis[2]],
          frames,
          to + 9,
          frames,
          to + 9,
        );
      else turnBy(frames.slice(to, to + 9), 0, rotationAbout(motion.axis, way), frames, to);
    }
    if (link.ball !== null) turnBy(frames.slice(to, to + 9), 0, balls[link.ball], frames, to);
  }
  return frames;
}

// out = rotation · vector + offset.
/** @param {List} rotation @param {number} from @param {Three} vector @param {List} offset @param {number} at @param {Float64Array} out @param {number} to */
function moveBy(rotation, from, [x, y, z], offset, at, out, to) {
  for (let row = 0; row < 3; row++) {
    const k = from + 3 * row;
    out[to + row] = rotation[k] * x + rotation[k + 1] * y + rotation[k + 2] * z + offset[at + row];
  }
}

/**
 * Vertices of the skin, written into `out` (three numbers each).
 *
 * @template {Float32Array | Float64Array} Numbers
 * @param {Hand} hand
 * @param {Float64Array} frames
 * @param {Numbers} out
 */
export function poseSkin(hand, frames, out) {
  const { count, link, binding, starts } = hand.skin;
  for (let vertex = 0; vertex < count.length; vertex++) {
    let [sx, sy, sz] = [0, 0, 0];
    for (let k = starts[vertex]; k < starts[vertex + 1]; k++) {
      const [f, b] = [FRAME * link[k], 4 * k];
      const [x, y, z] = [binding[b], binding[b + 1], binding[b + 2]];
      const w = binding[b + 3];
      sx += w * (frames[f] * x + frames[f + 1] * y + frames[f + 2] * z + frames[f + 9]);
      sy += w * (frames[f + 3] * x + frames[f + 4] * y + frames[f + 5] * z + frames[f + 10]);
      sz += w * (frames[f + 6] * x + frames[f + 7] * y + frames[f + 8] * z + frames[f + 11]);
    }
    out[3 * vertex] = sx;
    out[3 * vertex + 1] = sy;
    out[3 * vertex + 2] = sz;
  }
  return out;
}

// A point between two: straight, but if they are poses, the rotation goes the short way.
/** @param {List} a @param {List} b @param {number} t @param {boolean} poses */
export function between(a, b, t, poses) {
  const x = Float64Array.from(a, (value, k) => value + t * (b[k] - value));
  if (!poses) return x;
  let dot = 0;
  for (let k = 3; k < 7; k++) dot += a[k] * b[k];
  const sign = dot < 0 ? -1 : 1;
  const angle = Math.acos(Math.min(1, Math.abs(dot)));
  const [u, v] = angle < 1e-6 ? [1 - t, t] : [Math.sin((1 - t) * angle) / Math.sin(angle), Math.sin(t * angle) / Math.sin(angle)];
  for (let k = 3; k < 7; k++) x[k] = u * a[k] + sign * v * b[k];
  return x;
}
