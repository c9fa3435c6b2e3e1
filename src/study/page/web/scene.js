// The view in three dimensions: a hand on an object, or a cluster of atoms. It draws only when something changed.

import { append } from "./data.js";
import { needed } from "./dom.js";
import { poseLinks, poseSkin } from "./kinematics.js";
import { familyColour } from "./looks.js";
import { model } from "./state.js";
import { THREE } from "./three.js";

/**
 * @typedef {import("./data.js").Pair} Pair
 * @typedef {import("./data.js").Body} Body
 * @typedef {import("three").Vector3} Vector
 * @typedef {import("three").Mesh<import("three").BufferGeometry, import("three").MeshLambertMaterial>} Mesh
 * @typedef {Float32Array | Float64Array} Floats
 */

const SKIN = 0xe8bea2;
const OBJECT = 0x80a4be;
const CONTACT = 0xd52814;
export const GLIDE_MS = 260;
// Normals of faces that turn more than this are not averaged: the cosine of 40°.
const CREASE = 0.77;
// Width of the spots of touched places, and the longest edge of the triangles that carry their colour, metres.
const SPOT_M = 0.006;
const EDGE_M = 0.005;
const MOST_TRIANGLES = 60000;
const MOST_GHOSTS = 12;
// The scene fills the picture up to this margin; hands that reach far may leave it.
const MARGIN = 0.96;
const ATOM_COLOUR = 0x6b93c4;

export function webglWorks() {
  try {
    return Boolean(document.createElement("canvas").getContext("webgl2"));
  } catch {
    return false;
  }
}

/** Vertex normals of a mesh whose vertices move, weighted by area. @param {Floats} positions @param {Uint32Array} triangles @param {Float32Array} normals */
function smoothNormals(positions, triangles, normals) {
  normals.fill(0);
  for (let k = 0; k < triangles.length; k += 3) {
    const [a, b, c] = [3 * triangles[k], 3 * triangles[k + 1], 3 * triangles[k + 2]];
    const [ux, uy, uz] = [positions[b] - positions[a], positions[b + 1] - positions[a + 1], positions[b + 2] - positions[a + 2]];
    const [vx, vy, vz] = [positions[c] - positions[a], positions[c + 1] - positions[a + 1], positions[c + 2] - positions[a + 2]];
    const [nx, ny, nz] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const corner of [a, b, c]) {
      normals[corner] += nx;
      normals[corner + 1] += ny;
      normals[corner + 2] += nz;
    }
  }
  for (let k = 0; k < normals.length; k += 3) {
    const length = Math.hypot(normals[k], normals[k + 1], normals[k + 2]) || 1;
    for (let axis = 0; axis < 3; axis++) normals[k + axis] /= length;
  }
}

/** The triangles of a mesh as corners. @param {Body} body */
function facesOf({ vertices, triangles }) {
  /** @param {number} index */
  const corner = index => new THREE.Vector3().fromArray(vertices, 3 * index);
  return Array.from({ length: triangles.length / 3 }, (_, k) => [0, 1, 2].map(j => corner(triangles[3 * k + j])));
}

/** Splits the longest edge of triangles until all edges are short. @param {Vector[][]} faces */
function split(faces) {
  for (let round = 0; round < 24; round++) {
    const next = [];
    for (const [a, b, c] of faces) {
      const sides = [a.distanceTo(b), b.distanceTo(c), c.distanceTo(a)];
      const longest = sides.indexOf(Math.max(...sides));
      if (sides[longest] <= EDGE_M || faces.length + next.length > 2 * MOST_TRIANGLES) {
        next.push([a, b, c]);
        continue;
      }
      const turned = [
        [a, b, c],
        [b, c, a],
        [c, a, b],
      ];
      const [p, q, r] = turned[longest];
      const middle = p.clone().add(q).multiplyScalar(0.5);
      next.push([p, middle, r], [middle, q, r]);
    }
    if (next.length === faces.length) break;
    faces = next;
  }
  return faces;
}

/** Places and normals of faces: each corner has the normal of its side of creases. @param {Vector[][]} faces */
function creased(faces) {
  /** @type {Map<string, number[]>} */
  const around = new Map();
  /** @param {Vector} v */
  const key = v => `${v.x.toFixed(7)} ${v.y.toFixed(7)} ${v.z.toFixed(7)}`;
  const areas = faces.map(([a, b, c]) => b.clone().sub(a).cross(c.clone().sub(a)));
  const units = areas.map(area => area.clone().normalize());
  faces.forEach((face, number) => face.forEach(vertex => append(around, key(vertex), number)));
  const [positions, normals] = [new Float32Array(9 * faces.length), new Float32Array(9 * faces.length)];
  faces.forEach((face, number) =>
    face.forEach((vertex, k) => {
      const normal = new THREE.Vector3();
      for (const other of around.get(key(vertex)) ?? []) if (units[other].dot(units[number]) > CREASE) normal.add(areas[other]);
      vertex.toArray(positions, 9 * number + 3 * k);
      (normal.lengthSq() > 0 ? normal.normalize() : units[number]).toArray(normals, 9 * number + 3 * k);
    }),
  );
  return { positions, normals };
}

/** @typedef {Map<Body, import("three").BufferAttribute[]>} Meshes */
/** @type {[Meshes, Meshes]} */
const [meshes, fineMeshes] = [new Map(), new Map()];
// Middle and reach of the scenes of objects, so that all views show an object equally large.
/** @type {Map<Body, [Vector, number[]]>} */
const fits = new Map();

// The geometry of an object for one view: as it is, or with triangles that are fine enough to carry colours, which takes
// longer. Views share its places, but each paints it in its own colours.
/** @param {Body} object @param {boolean} fine */
function objectGeometry(object, fine) {
  const known = fine ? fineMeshes : meshes;
  let mesh = known.get(object);
  if (!mesh) {
    const { positions, normals } = creased(fine ? split(facesOf(object)) : facesOf(object));
    mesh = [new THREE.BufferAttribute(positions, 3), new THREE.BufferAttribute(normals, 3)];
    known.set(object, mesh);
  }
  const [position, normal] = mesh;
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", position);
  geometry.setAttribute("normal", normal);
  if (fine) geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(3 * position.count), 3));
  return geometry;
}

/** Colours the object by how many of these places lie near each of its points. @param {import("three").BufferGeometry} geometry @param {number[][]} places */
function paintDensity(geometry, places) {
  const { position, color } = geometry.attributes;
  /** @type {Map<string, number[][]>} */
  const cells = new Map();
  /** @param {number} x @param {number} y @param {number} z */
  const cell = (x, y, z) => `${Math.floor(x / (3 * SPOT_M))} ${Math.floor(y / (3 * SPOT_M))} ${Math.floor(z / (3 * SPOT_M))}`;
  for (const place of places) {
    for (const dx of [-1, 0, 1])
      for (const dy of [-1, 0, 1])
        for (const dz of [-1, 0, 1])
          append(cells, cell(place[0] + dx * 3 * SPOT_M, place[1] + dy * 3 * SPOT_M, place[2] + dz * 3 * SPOT_M), place);
  }
  const density = new Float32Array(position.count);
  for (let k = 0; k < position.count; k++) {
    const [x, y, z] = [position.getX(k), position.getY(k), position.getZ(k)];
    for (const [px, py, pz, load] of cells.get(cell(x, y, z)) ?? []) {
      const square = (x - px) ** 2 + (y - py) ** 2 + (z - pz) ** 2;
      density[k] += load * Math.exp(-square / (2 * SPOT_M * SPOT_M));
    }
  }
  let most = 0;
  for (const value of density) most = Math.max(most, value);
  const [plain, hot] = [new THREE.Color(OBJECT), new THREE.Color(0xff5a08)];
  const mixed = new THREE.Color();
  for (let k = 0; k < position.count; k++) {
    mixed.lerpColors(plain, hot, most ? (density[k] / most) ** 0.6 : 0);
    color.setXYZ(k, mixed.r, mixed.g, mixed.b);
  }
  color.needsUpdate = true;
}

// A hand that can be posed.
class HandMesh {
  /** @param {import("./data.js").Hand} hand @param {import("three").MeshLambertMaterial} material */
  constructor(hand, material) {
    this.hand = hand;
    this.positions = new Float32Array(3 * hand.skin.count.length);
    this.normals = new Float32Array(this.positions.length);
    this.geometry = new THREE.BufferGeometry();
    this.geometry.setAttribute("position", new THREE.BufferAttribute(this.positions, 3));
    this.geometry.setAttribute("normal", new THREE.BufferAttribute(this.normals, 3));
    this.geometry.setIndex(new THREE.BufferAttribute(hand.skin.triangles, 1));
    this.mesh = new THREE.Mesh(this.geometry, material);
    this.mesh.frustumCulled = false;
  }

  /** @param {Floats} x */
  pose(x) {
    poseSkin(this.hand, poseLinks(this.hand, x), this.positions);
    smoothNormals(this.positions, this.hand.skin.triangles, this.normals);
    this.geometry.attributes.position.needsUpdate = true;
    this.geometry.attributes.normal.needsUpdate = true;
  }
}

// A camera that turns about the middle, a scene and its parts. `show` puts an item or a pose into it.
export class View {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas, side = 0) {
    this.canvas = canvas;
    // The landscape whose items it shows, of two.
    this.side = side;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setClearColor(0, 0);
    this.scene = new THREE.Scene();
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.01, 20);
    this.camera.up.set(0, 0, 1);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 2.1));
    this.lamp = new THREE.DirectionalLight(0xffffff, 1.7);
    this.scene.add(this.lamp);
    this.parts = new THREE.Group();
    this.scene.add(this.parts);
    this.ghosts = new THREE.Group();
    this.scene.add(this.ghosts);
    this.marks = new THREE.Group();
    this.scene.add(this.marks);
    this.middle = new THREE.Vector3();
    // How far the scene reaches from its middle: sideways and upward.
    this.reach = [0.15, 0.15];
    // Half the shorter side of the picture, and the size of the picture that was drawn last.
    this.extent = 0;
    this.size = "";
    // Hand and object that are shown, the copy of the object with colours, and the family whose colours these are.
    /** @type {{ pair: Pair, plain: Mesh, hand: HandMesh } | null} */
    this.shown = null;
    /** @type {Mesh | null} */
    this.painted = null;
    this.familyName = "";
    // The pose, that to which the hand moves or has moved, and the frame of the movement.
    this.x = new Float64Array();
    /** @type {Floats | null} */
    this.target = null;
    this.gliding = 0;
  }

  // The same, once there is a scene.
  get stage() {
    return needed(this.shown, "scene");
  }

  // Shows hand and object of an item.
  /** @param {number} item */
  setScene(item) {
    const pair = model.scene(item);
    if (!pair || (pair.hand === this.shown?.pair.hand && pair.object === this.shown.pair.object)) return;
    this.clear(this.parts);
    this.clear(this.ghosts);
    const plain = new THREE.Mesh(objectGeometry(pair.object, false), new THREE.MeshLambertMaterial({ color: OBJECT }));
    const hand = new HandMesh(pair.hand, new THREE.MeshLambertMaterial({ color: SKIN, side: THREE.DoubleSide }));
    this.shown = { pair, plain, hand };
    this.painted = null;
    this.familyName = "";
    this.parts.add(plain, hand.mesh);
    this.frame(item);
  }

  /** Frames the object with the hands of some items on it, or with that of one item alone. @param {number} item */
  frame(item, alone = false) {
    const { object } = this.stage.pair;
    let fit = alone ? this.fit([item]) : fits.get(object);
    if (!fit) {
      const [side] = model.at(item);
      const first = model.offsets[model.sideOf(item)];
      fit = this.fit(Array.from({ length: 9 }, (_, k) => first + Math.floor((k * side.count) / 9)));
      fits.set(object, fit);
    }
    [this.middle, this.reach] = fit;
  }

  /** The middle of the object, and how far it and the hands of items reach from there. @param {number[]} items @returns {[Vector, number[]]} */
  fit(items) {
    const [low, high] = [new THREE.Vector3(Infinity, Infinity, Infinity), new THREE.Vector3(-Infinity, -Infinity, -Infinity)];
    const { pair, hand } = this.stage;
    const { vertices } = pair.object;
    const point = new THREE.Vector3();
    for (let k = 0; k < vertices.length; k += 3) {
      point.fromArray(vertices, k);
      low.min(point);
      high.max(point);
    }
    const middle = low.clone().add(high).multiplyScalar(0.5);
    let [sideways, upward] = [0, (high.z - low.z) / 2];
    for (const item of items) {
      const own = model.scene(item);
      if (own?.hand !== pair.hand || own.object !== pair.object) continue;
      const { positions } = hand;
      poseSkin(pair.hand, poseLinks(pair.hand, model.coordinates(item)), positions);
      for (let k = 0; k < positions.length; k += 21) {
        point.fromArray(positions, k).sub(middle);
        [sideways, upward] = [Math.max(sideways, Math.hypot(point.x, point.y)), Math.max(upward, Math.abs(point.z))];
      }
    }
    return [middle, [sideways, upward]];
  }

  /** @param {Floats} x */
  pose(x) {
    this.x = Float64Array.from(x);
    this.stage.hand.pose(this.x);
  }

  // Ends the movement of the hand.
  stop() {
    cancelAnimationFrame(this.gliding);
    this.gliding = 0;
  }

  /** Marks at the places where an item touches, with friction cones if they are wanted. @param {number | null} item */
  touch(item, cones = false) {
    this.clear(this.marks);
    if (item === null) return;
    const places = touchesOf(item);
    const ball = new THREE.SphereGeometry(0.0028, 14, 10);
    const balls = new THREE.InstancedMesh(ball, new THREE.MeshLambertMaterial({ color: CONTACT }), places.length);
    places.forEach(([x, y, z, , , , load], k) => {
      const size = 0.55 + 0.45 * load;
      balls.setMatrixAt(k, new THREE.Matrix4().makeScale(size, size, size).setPosition(x, y, z));
    });
    balls.frustumCulled = false;
    this.marks.add(balls);
    const friction = model.at(item)[0].friction ?? 0.5;
    if (cones) places.filter(place => place[6] >= 0.3).forEach(place => this.marks.add(frictionCone(place, friction)));
  }

  // Translucent hands of the family of an item, and the density of its touched places on the object.
  /** @param {number[] | null} items @param {number | null} item */
  family(items, item) {
    const { pair, plain, hand } = this.stage;
    const colour = (items && item !== null && familyColour(item)) || "#888888";
    const name = items ? items.join() + colour : "";
    if (name !== this.familyName) {
      this.familyName = name;
      this.clear(this.ghosts);
      if (items) this.paint(items);
      if (this.painted) this.painted.visible = Boolean(items);
      plain.visible = !items;
      const shown = spread(items ?? [], MOST_GHOSTS);
      const material = new THREE.MeshLambertMaterial({
        color: colour,
        transparent: true,
        opacity: Math.min(0.2, 0.06 + 0.4 / shown.length),
        depthWrite: false,
      });
      for (const other of shown) {
        const ghost = new HandMesh(pair.hand, material);
        ghost.mesh.userData.item = other;
        ghost.pose(model.coordinates(other));
        this.ghosts.add(ghost.mesh);
      }
    }
    for (const mesh of this.ghosts.children) mesh.visible = mesh.userData.item !== item;
    // The own hand lets the touched places show through.
    Object.assign(hand.mesh.material, { transparent: Boolean(items), opacity: items ? 0.5 : 1 });
  }

  /** Paints where these items touch on a finer copy of the object. @param {number[]} items */
  paint(items) {
    if (!this.painted) {
      const geometry = objectGeometry(this.stage.pair.object, true);
      this.painted = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ vertexColors: true }));
      this.parts.add(this.painted);
    }
    /** @param {number} item */
    const weighted = item => touchesOf(item).map(([x, y, z, , , , load]) => [x, y, z, load * model.number("members", item)]);
    paintDensity(this.painted.geometry, items.flatMap(weighted));
  }

  /** @param {import("three").Group} group */
  clear(group) {
    for (const part of [...group.children]) {
      if (part instanceof THREE.Mesh) part.geometry.dispose();
      group.remove(part);
    }
  }

  /** Balls at the places of atoms, and bonds between near ones. @param {Floats} x */
  atoms(x) {
    this.clear(this.marks);
    /** @type {Vector[]} */
    const places = [];
    for (let k = 0; k + 2 < x.length; k += 3) places.push(new THREE.Vector3(x[k], x[k + 1], x[k + 2]));
    const middle = places.reduce((sum, place) => sum.add(place), new THREE.Vector3()).multiplyScalar(1 / (places.length || 1));
    places.forEach(place => place.sub(middle));
    let nearest = Infinity;
    places.forEach((a, i) =>
      places.slice(0, i).forEach(b => {
        nearest = Math.min(nearest, a.distanceTo(b));
      }),
    );
    const balls = new THREE.InstancedMesh(
      new THREE.SphereGeometry(0.3 * nearest, 32, 20),
      new THREE.MeshLambertMaterial({ color: ATOM_COLOUR }),
      places.length,
    );
    places.forEach((place, k) => balls.setMatrixAt(k, new THREE.Matrix4().setPosition(place)));
    balls.frustumCulled = false;
    this.marks.add(balls);
    const material = new THREE.MeshLambertMaterial({ color: 0xb8bec8 });
    places.forEach((a, i) =>
      places.slice(0, i).forEach(b => {
        if (a.distanceTo(b) < 1.25 * nearest) this.marks.add(stick(a, b, 0.06 * nearest, material));
      }),
    );
    const reach = Math.max(...this.reach, ...places.map(place => place.length() + 0.4 * nearest));
    this.reach = [reach, reach];
    this.middle = new THREE.Vector3();
  }

  /** Looks from an azimuth and elevation (degrees) so that the scene fills a picture, enlarged. @param {number[]} camera */
  lookFrom([azimuth, elevation, zoom], width = this.canvas.clientWidth, height = this.canvas.clientHeight) {
    const [a, e] = [(azimuth * Math.PI) / 180, (elevation * Math.PI) / 180];
    const back = new THREE.Vector3(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e));
    const [sideways, upward] = [this.reach[0], this.reach[1] * Math.cos(e) + this.reach[0] * Math.abs(Math.sin(e))];
    const shorter = Math.min(width, height);
    this.aim(this.middle, back, (MARGIN * Math.max((sideways * shorter) / width, (upward * shorter) / height)) / zoom);
  }

  // Looks along −`back` at a point, with half the shorter side of the picture `half` wide.
  /** @param {Vector} target @param {Vector} back @param {number} half */
  aim(target, back, half) {
    this.camera.position.copy(target).addScaledVector(back, 5 + 10 * half);
    this.camera.far = 20 + 40 * half;
    this.camera.lookAt(target);
    this.extent = half;
    this.lamp.position.copy(back).addScaledVector(new THREE.Vector3(0, 0, 1), 0.6);
  }

  render(width = this.canvas.clientWidth, height = this.canvas.clientHeight, scale = Math.min(2, devicePixelRatio || 1)) {
    if (!width || !height) return;
    if (this.size !== `${width} ${height} ${scale}`) {
      this.size = `${width} ${height} ${scale}`;
      this.renderer.setPixelRatio(scale);
      this.renderer.setSize(width, height, false);
    }
    const shorter = Math.min(width, height);
    const [x, y] = [(this.extent * width) / shorter, (this.extent * height) / shorter];
    Object.assign(this.camera, { left: -x, right: x, top: y, bottom: -y });
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
  }
}

/** @param {number} item */
function touchesOf(item) {
  const [side, k] = model.at(item);
  /** @type {Float64Array[]} */
  const places = [];
  if (!side.touches) return places;
  const { starts, touch } = side.touches;
  for (let row = starts[k]; row < starts[k + 1]; row++) places.push(touch.subarray(7 * row, 7 * row + 7));
  return places;
}

/** At most `most` of the items, evenly chosen. @param {number[]} items @param {number} most */
function spread(items, most) {
  return items.length <= most ? items : Array.from({ length: most }, (_, k) => items[Math.floor((k * items.length) / most)]);
}

/** @param {ArrayLike<number> & Iterable<number>} place @param {number} friction */
function frictionCone([x, y, z, nx, ny, nz], friction) {
  const side = 0.022;
  const [sin, cos] = [Math.sin(Math.atan(friction)), Math.cos(Math.atan(friction))];
  const geometry = new THREE.ConeGeometry(side * sin, side * cos, 28, 1, true);
  geometry.translate(0, (-side * cos) / 2, 0);
  const material = new THREE.MeshLambertMaterial({
    color: 0xf0a030,
    transparent: true,
    opacity: 0.5,
    side: THREE.DoubleSide,
    depthWrite: false,
  });
  const cone = new THREE.Mesh(geometry, material);
  // The tip is the upper end, so the axis into the object is the cone's −y.
  cone.quaternion.setFromUnitVectors(new THREE.Vector3(0, -1, 0), new THREE.Vector3(nx, ny, nz).normalize());
  cone.position.set(x, y, z);
  return cone;
}

/** @param {Vector} a @param {Vector} b @param {number} radius @param {import("three").Material} material */
function stick(a, b, radius, material) {
  const bond = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, a.distanceTo(b), 12), material);
  bond.position.addVectors(a, b).multiplyScalar(0.5);
  bond.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), b.clone().sub(a).normalize());
  return bond;
}
