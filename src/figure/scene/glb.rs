//! A scene as a binary glTF 2.0 file, for viewers of three-dimensional models.

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::{Marker, Scene, Surface};

/// Number of subdivisions of an octahedron that give the ball of a marker.
const FINENESS: u32 = 3;
/// Constants of glTF for component types and buffer targets.
const FLOAT: u32 = 5126;
const UNSIGNED: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

impl Scene {
    /// The scene as a `.glb` file in metres. Each surface and each marker is a node under one node that turns z up into
    /// glTF's y up. Friction cones are omitted.
    pub fn to_glb(&self) -> Vec<u8> {
        self.written(&[], &[])
    }

    /// The scene with a moving first surface. Its vertices are at `frames[i]` at time `times_s[i]`, with linear
    /// interpolation between frames. Every frame is a morph target.
    ///
    /// # Panics
    /// If there is not one time per frame, or if a frame has another number of vertices than the surface.
    pub fn to_animated_glb(&self, times_s: &[f64], frames: &[Vec<Vector3<f64>>]) -> Vec<u8> {
        assert_eq!(times_s.len(), frames.len(), "one time a frame");
        self.written(times_s, frames)
    }

    fn written(&self, times_s: &[f64], frames: &[Vec<Vector3<f64>>]) -> Vec<u8> {
        let mut writer = Writer::default();
        let mut children = Vec::new();
        let names = ["hand", "object"];
        for (place, surface) in self.surfaces.iter().enumerate() {
            let name = names
                .get(place)
                .map_or_else(|| format!("surface {place}"), ToString::to_string);
            let mesh = writer.mesh(&name, surface);
            children.push(writer.node(json!({ "name": name, "mesh": mesh })));
            if place == 0 && !frames.is_empty() {
                writer.morph(mesh, &surface.vertices, frames);
                writer.animate(children[0], times_s);
            }
        }
        let mut balls: Vec<([u8; 3], usize)> = Vec::new();
        for (place, marker) in self.markers.iter().enumerate() {
            let Marker {
                centre,
                radius_m,
                colour,
            } = marker;
            let known = balls
                .iter()
                .find(|(other, _)| other == colour)
                .map(|(_, mesh)| *mesh);
            let mesh = known.unwrap_or_else(|| {
                let mesh = writer.mesh("contact", &ball(*colour));
                balls.push((*colour, mesh));
                mesh
            });
            children.push(writer.node(json!({
                "name": format!("contact {place}"),
                "mesh": mesh,
                "translation": centre.as_slice(),
                "scale": [radius_m, radius_m, radius_m],
            })));
        }
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let root = writer.node(
            json!({ "name": "grasp", "rotation": [-half, 0.0, 0.0, half], "children": children }),
        );
        writer.finish(root)
    }
}

/// A ball of radius 1.
fn ball(colour: [u8; 3]) -> Surface {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let mut vertices = vec![x, y, z, -x, -y, -z];
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    for _ in 0..FINENESS {
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let mut between = |a: u32, b: u32| {
                let middle: Vector3<f64> = vertices[a as usize] + vertices[b as usize];
                vertices.push(middle.normalize());
                u32::try_from(vertices.len() - 1).unwrap_or(u32::MAX)
            };
            let [ab, bc, ca] = [between(a, b), between(b, c), between(c, a)];
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    Surface {
        vertices,
        triangles,
        colour,
    }
}

#[derive(Default)]
struct Writer {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    animations: Vec<Value>,
}

#[expect(clippy::cast_possible_truncation, reason = "glTF has 32-bit numbers")]
fn narrow(x: f64) -> f32 {
    x as f32
}

impl Writer {
    fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// Adds a view of new bytes to the buffer. `target` is the buffer target; `None` for the numbers of an animation.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({
            "buffer": 0,
            "byteOffset": self.binary.len(),
            "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        self.binary.extend(bytes);
        self.views.len() - 1
    }

    /// Adds an accessor of points or directions.
    fn vectors(&mut self, vectors: impl Iterator<Item = Vector3<f64>>) -> usize {
        let points: Vec<[f32; 3]> = vectors.map(|v| [v.x, v.y, v.z].map(narrow)).collect();
        let bytes: Vec<u8> = points
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let view = self.view(&bytes, Some(VERTICES));
        let bound = |pick: fn(f32, f32) -> f32| {
            let first = points.first().copied().unwrap_or_default();
            points.iter().fold(first, |bound, p| {
                [0, 1, 2].map(|axis| pick(bound[axis], p[axis]))
            })
        };
        self.accessors.push(json!({
            "bufferView": view,
            "componentType": FLOAT,
            "count": points.len(),
            "type": "VEC3",
            "min": bound(f32::min),
            "max": bound(f32::max),
        }));
        self.accessors.len() - 1
    }

    /// Adds an accessor of numbers with their minimum and maximum.
    fn scalars(&mut self, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, None);
        let bound = |pick: fn(f32, f32) -> f32| values.iter().copied().reduce(pick);
        self.accessors.push(json!({
            "bufferView": view,
            "componentType": FLOAT,
            "count": values.len(),
            "type": "SCALAR",
            "min": [bound(f32::min)],
            "max": [bound(f32::max)],
        }));
        self.accessors.len() - 1
    }

    /// Adds the frames as morph targets of a mesh.
    fn morph(&mut self, mesh: usize, rest: &[Vector3<f64>], frames: &[Vec<Vector3<f64>>]) {
        let targets: Vec<Value> = frames
            .iter()
            .map(|frame| {
                assert_eq!(frame.len(), rest.len(), "vertices of a frame");
                let moves = frame.iter().zip(rest).map(|(to, from)| to - from);
                json!({ "POSITION": self.vectors(moves) })
            })
            .collect();
        let mut weights = vec![0.0; frames.len()];
        weights[0] = 1.0;
        self.meshes[mesh]["weights"] = json!(weights);
        self.meshes[mesh]["primitives"][0]["targets"] = json!(targets);
    }

    /// Adds an animation that goes through the morph targets of a node's mesh.
    fn animate(&mut self, node: usize, times_s: &[f64]) {
        let count = times_s.len();
        let times: Vec<f32> = times_s.iter().copied().map(narrow).collect();
        let input = self.scalars(&times);
        let mut weights = vec![0.0; count * count];
        for frame in 0..count {
            weights[frame * count + frame] = 1.0;
        }
        let output = self.scalars(&weights);
        self.animations.push(json!({
            "name": "path",
            "channels": [{ "sampler": 0, "target": { "node": node, "path": "weights" } }],
            "samplers": [{ "input": input, "output": output, "interpolation": "LINEAR" }],
        }));
    }

    fn mesh(&mut self, name: &str, surface: &Surface) -> usize {
        self.vectors(surface.vertices.iter().copied());
        let bytes: Vec<u8> = surface
            .triangles
            .iter()
            .flatten()
            .flat_map(|i| i.to_le_bytes())
            .collect();
        let view = self.view(&bytes, Some(INDICES));
        self.accessors.push(json!({
            "bufferView": view,
            "componentType": UNSIGNED,
            "count": 3 * surface.triangles.len(),
            "type": "SCALAR",
        }));
        // Colours of surfaces are sRGB; glTF needs linear ones.
        let [red, green, blue] = surface
            .colour
            .map(|byte| libm::pow(f64::from(byte) / 255.0, 2.2));
        self.materials.push(json!({
            "doubleSided": true,
            "pbrMetallicRoughness": {
                "baseColorFactor": [red, green, blue, 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": 0.8,
            },
        }));
        let last = self.accessors.len() - 1;
        self.meshes.push(json!({ "name": name, "primitives": [{
            "attributes": { "POSITION": last - 1 },
            "indices": last,
            "material": self.materials.len() - 1,
        }]}));
        self.meshes.len() - 1
    }

    fn finish(self, root: usize) -> Vec<u8> {
        let mut json = json!({
            "asset": { "version": "2.0", "generator": concat!("landscape ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": [root] }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.binary.len() }],
        });
        if !self.animations.is_empty() {
            json["animations"] = json!(self.animations);
        }
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = |bytes: usize| u32::try_from(bytes).unwrap_or(u32::MAX).to_le_bytes();
        let mut file = b"glTF\x02\x00\x00\x00".to_vec();
        file.extend(length(28 + text.len() + self.binary.len()));
        file.extend(length(text.len()));
        file.extend(b"JSON");
        file.extend(text);
        file.extend(length(self.binary.len()));
        file.extend(b"BIN\0");
        file.extend(self.binary);
        file
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn what_is_written_is_read_again() {
        let scene = Scene {
            surfaces: vec![Surface {
                colour: [1, 2, 3],
                ..ball([0; 3])
            }],
            markers: vec![
                Marker {
                    centre: Vector3::new(3.0, 0.0, 0.0),
                    radius_m: 0.5,
                    colour: [9; 3],
                },
                Marker {
                    centre: Vector3::new(0.0, 0.0, 4.0),
                    radius_m: 0.5,
                    colour: [9; 3],
                },
            ],
            cones: Vec::new(),
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.glb");
        std::fs::write(&path, scene.to_glb()).unwrap();
        let read = Mesh::read(&path, 1.0).unwrap();
        assert_eq!(read.repairs, []);
        let unit = 4.0 / 3.0 * std::f64::consts::PI;
        assert!(
            (read.mesh.volume() / (1.25 * unit) - 1.0).abs() < 0.03,
            "{}",
            read.mesh.volume()
        );
        // The direction up was z and is now y.
        let [low, high] = read.mesh.bounds();
        assert!(
            (high - Vector3::new(3.5, 4.5, 1.0)).norm() < 1e-6 && (low.z + 1.0).abs() < 1e-6,
            "{high}"
        );
    }
}
