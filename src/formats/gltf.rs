//! Triangles of glTF 2.0 files, `.gltf` or `.glb`. Positions, indices and nodes with their transformations are read;
//! everything else is skipped.
//!
//! The reader uses no glTF library, because every length in such a file must be checked.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::{Component, Path};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector3};
use serde::Deserialize;

use super::{Triangles, bytes_of};

const MAGIC: &[u8] = b"glTF";
const JSON_CHUNK: u32 = 0x4E4F534A;
const BINARY_CHUNK: u32 = 0x004E4942;
/// Largest depth of nested nodes; deeper files are refused.
const DEEPEST: usize = 100;
/// Largest number of visited nodes and primitives. More come from a mistake or malice, since several nodes may name the
/// same node.
const MOST_NODES: usize = 100_000;
/// Largest total number of triangles, and of vertices.
const MOST_TRIANGLES: usize = 20_000_000;
/// Largest total size of the buffers, bytes.
const MOST_BYTES: usize = 256 << 20;
/// Modes of triangle primitives.
const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

#[derive(Deserialize, Default)]
#[serde(default, rename_all = "camelCase")]
struct Document {
    scene: Option<usize>,
    scenes: Vec<Scene>,
    nodes: Vec<Node>,
    meshes: Vec<MeshEntry>,
    accessors: Vec<Accessor>,
    buffer_views: Vec<View>,
    buffers: Vec<Buffer>,
    extensions_required: Vec<String>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Scene {
    nodes: Vec<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Node {
    children: Vec<usize>,
    mesh: Option<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct MeshEntry {
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: Attributes,
    indices: Option<usize>,
    mode: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "UPPERCASE")]
struct Attributes {
    position: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    count: usize,
    r#type: String,
    sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
struct Buffer {
    uri: Option<String>,
}

/// Reads the bytes of a `.gltf` or `.glb` file. `folder` contains the buffers that it names. Errors are half a sentence
/// that states the problem.
pub(crate) fn read(bytes: &[u8], folder: &Path) -> Result<Triangles, String> {
    let (json, binary) = chunks(bytes)?;
    let document: Document = serde_json::from_slice(json).map_err(|error| error.to_string())?;
    if let Some(name) = document.extensions_required.first() {
        return Err(format!(
            "it needs the extension {name}, which is not supported: export it without compression"
        ));
    }
    let mut buffers: Vec<Cow<'_, [u8]>> = Vec::new();
    let mut left = MOST_BYTES;
    for buffer in &document.buffers {
        let bytes = match &buffer.uri {
            Some(uri) => Cow::Owned(external(uri, folder)?),
            None => Cow::Borrowed(binary),
        };
        if let Cow::Owned(bytes) = &bytes {
            left = left
                .checked_sub(bytes.len())
                .ok_or_else(|| format!("its buffers are larger than {} MB", MOST_BYTES >> 20))?;
        }
        buffers.push(bytes);
    }
    let mut reader = Reader {
        document: &document,
        buffers,
        soup: Triangles::default(),
        visited: 0,
    };
    let scene = document.scenes.get(document.scene.unwrap_or(0));
    let roots: Vec<usize> = if let Some(scene) = scene {
        scene.nodes.clone()
    } else {
        let below: BTreeSet<usize> = document
            .nodes
            .iter()
            .flat_map(|n| n.children.clone())
            .collect();
        (0..document.nodes.len())
            .filter(|node| !below.contains(node))
            .collect()
    };
    for root in roots {
        reader.node(root, &Matrix4::identity(), 0)?;
    }
    Ok(reader.soup)
}

/// The JSON chunk and the binary chunk.
fn chunks(bytes: &[u8]) -> Result<(&[u8], &[u8]), String> {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return Ok((bytes, &[]));
    };
    let cut = || "it is cut short".to_owned();
    let mut rest = rest.get(8..).ok_or_else(cut)?;
    let (mut json, mut binary): (Option<&[u8]>, &[u8]) = (None, &[]);
    while let Some((head, body)) = rest.split_at_checked(8) {
        let word =
            |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let length = usize::try_from(word(0)).unwrap_or(usize::MAX);
        let (chunk, others) = body.split_at_checked(length).ok_or_else(cut)?;
        match word(4) {
            JSON_CHUNK => json = json.or(Some(chunk)),
            BINARY_CHUNK if binary.is_empty() => binary = chunk,
            _ => {}
        }
        rest = others;
    }
    Ok((json.ok_or("it contains no JSON")?, binary))
}

/// An external buffer: base64 text in the URI, or a file in the same folder or below.
fn external(uri: &str, folder: &Path) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, data) = data
            .split_once(";base64,")
            .ok_or("a buffer is not base64")?;
        return STANDARD
            .decode(data)
            .map_err(|error| format!("a buffer is not base64: {error}"));
    }
    let name = uri.replace("%20", " ");
    let path = Path::new(&name);
    if !path
        .components()
        .all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
    {
        return Err(format!("its buffer {uri} is not in its folder"));
    }
    let unreadable = |error| format!("its buffer {uri} cannot be read: {error}");
    let whole = |path: &Path| std::fs::canonicalize(path).map_err(unreadable);
    let folder = whole(if folder == Path::new("") {
        Path::new(".")
    } else {
        folder
    })?;
    let path = whole(&folder.join(path))?;
    if !path.starts_with(&folder) {
        return Err(format!("its buffer {uri} is a link out of its folder"));
    }
    bytes_of(&path).map_err(unreadable)
}

struct Reader<'a> {
    document: &'a Document,
    buffers: Vec<Cow<'a, [u8]>>,
    soup: Triangles,
    visited: usize,
}

impl Reader<'_> {
    fn node(&mut self, index: usize, above: &Matrix4<f64>, depth: usize) -> Result<(), String> {
        self.visited += 1;
        if depth > DEEPEST || self.visited > MOST_NODES {
            return Err("its nodes are nested too deeply or used too often".to_owned());
        }
        let document = self.document;
        let node = document
            .nodes
            .get(index)
            .ok_or_else(|| missing("node", index))?;
        let placed = above * placement(node);
        if let Some(mesh) = node.mesh {
            let mesh = document
                .meshes
                .get(mesh)
                .ok_or_else(|| missing("mesh", mesh))?;
            self.visited += mesh.primitives.len();
            for primitive in &mesh.primitives {
                self.primitive(primitive, &placed)?;
            }
        }
        for &child in &node.children {
            self.node(child, &placed, depth + 1)?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, placed: &Matrix4<f64>) -> Result<(), String> {
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        let Some(position) = primitive
            .attributes
            .position
            .filter(|_| (TRIANGLES..=FAN).contains(&mode))
        else {
            return Ok(());
        };
        let first = self.soup.vertices.len();
        for [x, y, z] in self.positions(position)? {
            let point = placed.transform_point(&[x, y, z].into());
            self.soup.vertices.push(point.coords);
        }
        if self.soup.vertices.len() > MOST_TRIANGLES {
            return Err(format!("it has more than {MOST_TRIANGLES} vertices"));
        }
        let count = self.soup.vertices.len() - first;
        let corners: Vec<usize> = match primitive.indices {
            Some(accessor) => self.indices(accessor)?,
            None => (0..count).collect(),
        };
        if let Some(corner) = corners.iter().find(|&&corner| corner >= count) {
            return Err(missing("vertex", *corner));
        }
        let mirrored = placed.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        let triangles: Vec<[usize; 3]> = match mode {
            STRIP => corners
                .windows(3)
                .enumerate()
                .map(|(i, t)| {
                    if i % 2 == 0 {
                        [t[0], t[1], t[2]]
                    } else {
                        [t[1], t[0], t[2]]
                    }
                })
                .collect(),
            FAN => corners
                .get(1..)
                .unwrap_or_default()
                .windows(2)
                .map(|t| [corners[0], t[0], t[1]])
                .collect(),
            _ => corners
                .chunks_exact(3)
                .map(|t| [t[0], t[1], t[2]])
                .collect(),
        };
        if self.soup.triangles.len() + triangles.len() > MOST_TRIANGLES {
            return Err(format!("it has more than {MOST_TRIANGLES} triangles"));
        }
        for [a, b, c] in triangles {
            let [a, b, c] = [a, b, c].map(|v| u32::try_from(first + v).unwrap_or(u32::MAX));
            self.soup
                .triangles
                .push(if mirrored { [a, c, b] } else { [a, b, c] });
        }
        Ok(())
    }

    /// The items of an accessor, each of `size` bytes.
    fn items(&self, index: usize, size: usize) -> Result<impl Iterator<Item = &[u8]>, String> {
        let accessor = self
            .document
            .accessors
            .get(index)
            .ok_or_else(|| missing("accessor", index))?;
        if accessor.sparse.is_some() {
            return Err("it has sparse accessors, which are not supported".to_owned());
        }
        let view = accessor
            .buffer_view
            .and_then(|view| self.document.buffer_views.get(view));
        let view = view.ok_or_else(|| format!("its accessor {index} has no data"))?;
        let stride = view.byte_stride.unwrap_or(size).max(size);
        let bytes = || {
            let buffer = self.buffers.get(view.buffer)?;
            let end = view.byte_offset.checked_add(view.byte_length)?;
            let bytes = buffer
                .get(view.byte_offset..end)?
                .get(accessor.byte_offset..)?;
            let last = accessor
                .count
                .checked_sub(1)?
                .checked_mul(stride)?
                .checked_add(size)?;
            bytes.get(..last)
        };
        let bytes = if accessor.count == 0 {
            Some(&[][..])
        } else {
            bytes()
        };
        let bytes = bytes.ok_or_else(|| format!("its accessor {index} reaches past the data"))?;
        Ok(bytes.chunks(stride).map(move |item| &item[..size]))
    }

    fn positions(&self, index: usize) -> Result<Vec<[f64; 3]>, String> {
        const FLOAT: u32 = 5126;
        let accessor = self
            .document
            .accessors
            .get(index)
            .ok_or_else(|| missing("accessor", index))?;
        if accessor.component_type != FLOAT || accessor.r#type != "VEC3" {
            return Err("its positions are not three 32-bit numbers each".to_owned());
        }
        let number = |item: &[u8], at: usize| {
            f64::from(f32::from_le_bytes([
                item[at],
                item[at + 1],
                item[at + 2],
                item[at + 3],
            ]))
        };
        let items = self.items(index, 12)?;
        Ok(items
            .map(|item| [number(item, 0), number(item, 4), number(item, 8)])
            .collect())
    }

    fn indices(&self, index: usize) -> Result<Vec<usize>, String> {
        let accessor = self
            .document
            .accessors
            .get(index)
            .ok_or_else(|| missing("accessor", index))?;
        let size = match accessor.component_type {
            5121 => 1,
            5123 => 2,
            5125 => 4,
            other => return Err(format!("its indices are of the unknown type {other}")),
        };
        let whole = |item: &[u8]| {
            item.iter()
                .rev()
                .fold(0, |sum, &byte| sum << 8 | usize::from(byte))
        };
        Ok(self.items(index, size)?.map(whole).collect())
    }
}

fn missing(what: &str, index: usize) -> String {
    format!("it refers to {what} {index}, which does not exist")
}

/// Transformation of a node.
fn placement(node: &Node) -> Matrix4<f64> {
    if let Some(matrix) = &node.matrix {
        return Matrix4::from_column_slice(matrix);
    }
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Matrix4::new_translation(&Vector3::from(node.translation.unwrap_or_default()))
        * rotation.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&Vector3::from(node.scale.unwrap_or([1.0; 3])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// A tetrahedron of 16-bit indices, placed by two nodes, one of them mirrored.
    fn document(uri: Option<&str>) -> (serde_json::Value, Vec<u8>) {
        let mut data = Vec::new();
        for number in [
            0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0,
        ] {
            data.extend(number.to_le_bytes());
        }
        for index in [0u16, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3] {
            data.extend(index.to_le_bytes());
        }
        let mut buffer = json!({"byteLength": data.len()});
        if let Some(uri) = uri {
            buffer["uri"] = uri.into();
        }
        let value = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [
                {"children": [1, 2], "scale": [0.1, 0.1, 0.1]},
                {"mesh": 0, "translation": [5.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.5f64.sqrt(), 0.5f64.sqrt()]},
                {"mesh": 0, "scale": [-1.0, 1.0, 1.0]}
            ],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 7}, "indices": 1}, {"attributes": {}, "mode": 1}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                {"bufferView": 1, "byteOffset": 0, "componentType": 5123, "count": 12, "type": "SCALAR"}
            ],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": 48},
                {"buffer": 0, "byteOffset": 48, "byteLength": 24}
            ],
            "buffers": [buffer]
        });
        (value, data)
    }

    fn glb(json: &serde_json::Value, data: &[u8]) -> Vec<u8> {
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bytes = MAGIC.to_vec();
        let length = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
        bytes.extend(2u32.to_le_bytes());
        bytes.extend(length(28 + text.len() + data.len()));
        for (kind, chunk) in [(JSON_CHUNK, text.as_slice()), (BINARY_CHUNK, data)] {
            bytes.extend(length(chunk.len()));
            bytes.extend(kind.to_le_bytes());
            bytes.extend(chunk);
        }
        bytes
    }

    #[test]
    fn all_three_forms_are_read() {
        let (value, data) = document(None);
        let soup = read(&glb(&value, &data), Path::new("")).unwrap();
        assert_eq!(soup.vertices.len(), 8);
        // (1, 0, 0) turned by a right angle about z, moved, scaled.
        assert!(
            (soup.vertices[1] - Vector3::new(0.5, 0.1, 0.0)).norm() < 1e-9,
            "{}",
            soup.vertices[1]
        );
        let volume = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| soup.vertices[vertex as usize]);
            a.dot(&b.cross(&c)) / 6.0
        };
        let volume: f64 = soup.triangles.iter().map(volume).sum();
        assert!((volume - 2e-3 / 6.0).abs() < 1e-9, "{volume}");

        let uri = format!(
            "data:application/octet-stream;base64,{}",
            STANDARD.encode(&data)
        );
        let (within, _) = document(Some(&uri));
        let same = read(within.to_string().as_bytes(), Path::new("")).unwrap();
        assert_eq!(same.vertices, soup.vertices);
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("two parts.bin"), &data).unwrap();
        let (beside, _) = document(Some("two%20parts.bin"));
        let same = read(beside.to_string().as_bytes(), folder.path()).unwrap();
        assert_eq!(same.triangles, soup.triangles);
    }
}
