//! Triangles of COLLADA files (`.dae`): the meshes that the scene shows, with the transformations of its nodes.
//!
//! Lengths are converted to metres by the `unit` of the file. Its `up_axis` is ignored, as in the programs of ROS: it says
//! how a viewer should turn the scene, and descriptions of robots refer to the coordinates as they are in the file.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::str::FromStr;

use nalgebra::{Matrix4, Rotation3, Unit, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

use super::Triangles;

/// Largest depth of nested nodes.
const DEEPEST: usize = 100;
/// Largest number of visited nodes, since several nodes may show the same node.
const MOST_NODES: usize = 100_000;
/// Largest total number of triangles, and of vertices.
const MOST_TRIANGLES: usize = 20_000_000;

/// Reads the bytes of a COLLADA file. Errors are half a sentence that states the problem.
pub(crate) fn read(bytes: &[u8]) -> Result<Triangles, String> {
    let text = std::str::from_utf8(bytes).map_err(|error| error.to_string())?;
    let options = ParsingOptions {
        nodes_limit: 10_000_000,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options)
        .map_err(|error| format!("it is not XML: {error}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(format!(
            "its root element is <{}>, not <COLLADA>",
            root.tag_name().name()
        ));
    }
    let mut reader = Reader {
        ids: (root.descendants().rev())
            .filter_map(|node| Some((node.attribute("id")?, node)))
            .collect(),
        meshes: BTreeMap::new(),
        soup: Triangles::default(),
        visited: 0,
    };
    let metre = unit(root)?;
    let to_metres = Matrix4::new_scaling(metre);
    let shown = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    let scene = match shown {
        Some(shown) => Some(reader.target(shown, "url")?),
        None => root
            .descendants()
            .find(|node| node.has_tag_name_of("visual_scene")),
    };
    match scene {
        Some(scene) => {
            for node in named(scene, "node") {
                reader.node(node, &to_metres, 0)?;
            }
        }
        // A library of shapes alone.
        None => {
            for geometry in root.descendants().filter(|n| n.has_tag_name_of("geometry")) {
                reader.show(geometry, &to_metres)?;
            }
        }
    }
    Ok(reader.soup)
}

/// Metres in a unit of length of the file.
fn unit(root: Node<'_, '_>) -> Result<f64, String> {
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let Some((unit, told)) = unit.and_then(|unit| Some((unit, unit.attribute("meter")?))) else {
        return Ok(1.0);
    };
    let metre: Option<f64> = told.trim().parse().ok();
    metre
        .filter(|metre| metre.is_finite() && *metre > 0.0)
        .ok_or_else(|| at(unit, &format!("meter=\"{told}\" is not a positive number")))
}

/// Names of elements without their namespace, of which COLLADA has one for each version.
trait Named {
    fn has_tag_name_of(&self, name: &str) -> bool;
}

impl Named for Node<'_, '_> {
    fn has_tag_name_of(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }
}

fn named<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children()
        .filter(move |child| child.has_tag_name_of(name))
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> Option<Node<'a, 'i>> {
    named(node, name).next()
}

/// `its <polylist> (line 12): …`.
fn at(node: Node<'_, '_>, problem: &str) -> String {
    let line = node.document().text_pos_at(node.range().start).row;
    format!("its <{}> (line {line}): {problem}", node.tag_name().name())
}

/// The numbers in the text of an element.
fn numbers<T: FromStr>(node: Node<'_, '_>) -> Result<Vec<T>, String> {
    let words = node.text().unwrap_or_default().split_whitespace();
    words
        .map(|word| {
            word.parse()
                .ok()
                .ok_or_else(|| at(node, &format!("\"{word}\" is not a number")))
        })
        .collect()
}

/// Exactly `N` numbers.
fn exactly<const N: usize>(node: Node<'_, '_>) -> Result<[f64; N], String> {
    let numbers: Vec<f64> = numbers(node)?;
    let count = numbers.len();
    <[f64; N]>::try_from(numbers).ok().ok_or_else(|| {
        at(
            node,
            &format!("it has {count} numbers where {N} are needed"),
        )
    })
}

/// A whole number in an attribute.
fn whole(node: Node<'_, '_>, name: &str, default: usize) -> Result<usize, String> {
    node.attribute(name).map_or(Ok(default), |told| {
        told.trim()
            .parse()
            .ok()
            .ok_or_else(|| at(node, &format!("{name}=\"{told}\" is not a whole number")))
    })
}

struct Reader<'a, 'i> {
    /// Elements by their `id`; the first one counts.
    ids: BTreeMap<&'a str, Node<'a, 'i>>,
    /// The meshes of geometries that were shown before, by the number of their element.
    meshes: BTreeMap<u32, Triangles>,
    soup: Triangles,
    visited: usize,
}

impl<'a, 'i> Reader<'a, 'i> {
    /// The element that an attribute refers to, `#id`.
    fn target(&self, from: Node<'a, 'i>, attribute: &str) -> Result<Node<'a, 'i>, String> {
        let Some(told) = from.attribute(attribute) else {
            return Err(at(from, &format!("{attribute} is missing")));
        };
        let Some(id) = told.strip_prefix('#') else {
            return Err(at(
                from,
                &format!("{attribute}=\"{told}\" refers to another file: put all into one file"),
            ));
        };
        let found = self.ids.get(id).copied();
        found.ok_or_else(|| at(from, &format!("no element has the id \"{id}\"")))
    }

    /// Adds what a node shows, and the nodes in it.
    fn node(
        &mut self,
        node: Node<'a, 'i>,
        above: &Matrix4<f64>,
        depth: usize,
    ) -> Result<(), String> {
        self.visited += 1;
        if depth > DEEPEST || self.visited > MOST_NODES {
            return Err(at(node, "nodes are nested too deeply or used too often"));
        }
        let mut placed = *above;
        // All transformations come before what they move, each in the frame of those before it.
        for part in node.children() {
            if let Some(moved) = transformation(part)? {
                placed *= moved;
            }
        }
        for part in node.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "node" => self.node(part, &placed, depth + 1)?,
                "instance_node" => {
                    let target = self.target(part, "url")?;
                    self.node(target, &placed, depth + 1)?;
                }
                "instance_geometry" => {
                    let target = self.target(part, "url")?;
                    self.show(target, &placed)?;
                }
                "instance_controller" => {
                    return Err(at(
                        part,
                        "a mesh that bends with a skeleton is not read: export it without its armature",
                    ));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Adds the mesh of a geometry.
    fn show(&mut self, geometry: Node<'a, 'i>, placed: &Matrix4<f64>) -> Result<(), String> {
        self.visited += 1;
        let mesh = match self.meshes.remove(&geometry.id().get()) {
            Some(known) => known,
            None => self.mesh(geometry)?,
        };
        let soup = &mut self.soup;
        let first = soup.vertices.len();
        if self.visited > MOST_NODES
            || first + mesh.vertices.len() > MOST_TRIANGLES
            || soup.triangles.len() + mesh.triangles.len() > MOST_TRIANGLES
        {
            return Err(format!(
                "it has more than {MOST_TRIANGLES} vertices or triangles"
            ));
        }
        let points = mesh.vertices.iter();
        soup.vertices
            .extend(points.map(|v| placed.transform_point(&(*v).into()).coords));
        let first = u32::try_from(first).unwrap_or(u32::MAX);
        let mirrored = placed.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        soup.triangles.extend(mesh.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| corner.saturating_add(first));
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
        self.meshes.insert(geometry.id().get(), mesh);
        Ok(())
    }

    /// The triangles of a geometry, in its own frame; lines are skipped.
    fn mesh(&self, geometry: Node<'a, 'i>) -> Result<Triangles, String> {
        let mut mesh = Triangles::default();
        let Some(part) = child(geometry, "mesh") else {
            return Ok(mesh);
        };
        // Of each source of positions, the points and their numbers in the mesh.
        let mut positions: BTreeMap<u32, Numbered> = BTreeMap::new();
        for faces in part.children().filter(Node::is_element) {
            let kind = faces.tag_name().name();
            if !["triangles", "polylist", "polygons", "tristrips", "trifans"].contains(&kind) {
                continue;
            }
            let Some(layout) = self.layout(faces)? else {
                continue;
            };
            let (points, numbers) = match positions.entry(layout.source.id().get()) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => {
                    let points = self.points(layout.source)?;
                    let numbers = vec![None; points.len()];
                    new.insert((points, numbers))
                }
            };
            for polygon in polygons(faces, kind, &layout)? {
                let corners = polygon.iter().map(|&corner| {
                    let (Some(number), Some(point)) = (numbers.get_mut(corner), points.get(corner))
                    else {
                        return Err(at(faces, &format!("vertex {corner} does not exist")));
                    };
                    Ok(*number.get_or_insert_with(|| {
                        mesh.vertices.push(*point);
                        u32::try_from(mesh.vertices.len() - 1).unwrap_or(u32::MAX)
                    }))
                });
                let corners: Vec<u32> = corners.collect::<Result<_, String>>()?;
                mesh.polygon(&corners);
            }
        }
        Ok(mesh)
    }

    /// Where the corners of faces are in their lists of numbers; `None` without positions.
    fn layout(&self, faces: Node<'a, 'i>) -> Result<Option<Layout<'a, 'i>>, String> {
        let (mut stride, mut found) = (1, None);
        for input in named(faces, "input") {
            let offset = whole(input, "offset", 0)?;
            if offset > 1000 {
                return Err(at(input, "its offset is too large"));
            }
            stride = stride.max(offset + 1);
            if input.attribute("semantic") == Some("VERTEX") {
                found = Some((offset, self.target(input, "source")?));
            }
        }
        let Some((offset, vertices)) = found else {
            return Ok(None);
        };
        let position = named(vertices, "input")
            .find(|input| input.attribute("semantic") == Some("POSITION"))
            .ok_or_else(|| at(vertices, "it has no <input> of positions"))?;
        Ok(Some(Layout {
            stride,
            offset,
            source: self.target(position, "source")?,
        }))
    }

    /// The points of a source.
    fn points(&self, source: Node<'a, 'i>) -> Result<Vec<Vector3<f64>>, String> {
        let accessor = child(source, "technique_common").and_then(|part| child(part, "accessor"));
        let accessor = accessor.ok_or_else(|| at(source, "it has no <accessor>"))?;
        let array = self.target(accessor, "source")?;
        let values: Vec<f64> = numbers(array)?;
        let stride = whole(accessor, "stride", 1)?;
        if stride < 3 {
            return Err(at(accessor, "positions need three numbers each"));
        }
        let first = whole(accessor, "offset", 0)?;
        let rest = values.get(first..).unwrap_or_default();
        let points = rest.chunks(stride).filter_map(|numbers| numbers.get(..3));
        Ok(points.map(Vector3::from_column_slice).collect())
    }
}

/// Points of a source, and the number of each in the mesh, once a face has used it.
type Numbered = (Vec<Vector3<f64>>, Vec<Option<u32>>);

/// Which numbers of a list are corners: of each group of `stride`, that at `offset`.
struct Layout<'a, 'i> {
    stride: usize,
    offset: usize,
    /// The source of the positions.
    source: Node<'a, 'i>,
}

/// The corners of all faces of an element.
fn polygons(
    faces: Node<'_, '_>,
    kind: &str,
    layout: &Layout<'_, '_>,
) -> Result<Vec<Vec<usize>>, String> {
    if let Some(holes) = child(faces, "ph") {
        return Err(at(
            holes,
            "polygons with holes are not read: export triangles",
        ));
    }
    let mut polygons = Vec::new();
    for list in named(faces, "p") {
        let numbers: Vec<usize> = numbers(list)?;
        if !numbers.len().is_multiple_of(layout.stride) {
            let problem = format!(
                "{} numbers do not divide into groups of {}",
                numbers.len(),
                layout.stride
            );
            return Err(at(list, &problem));
        }
        let corners: Vec<usize> = numbers
            .chunks_exact(layout.stride)
            .map(|group| group[layout.offset])
            .collect();
        match kind {
            "triangles" => polygons.extend(corners.chunks_exact(3).map(<[_]>::to_vec)),
            "tristrips" => polygons.extend(corners.windows(3).enumerate().map(|(i, t)| {
                if i % 2 == 0 {
                    t.to_vec()
                } else {
                    vec![t[1], t[0], t[2]]
                }
            })),
            "polylist" => {
                let counts =
                    child(faces, "vcount").ok_or_else(|| at(faces, "it has no <vcount>"))?;
                let mut rest = corners.as_slice();
                for count in self::numbers::<usize>(counts)? {
                    let (polygon, others) = rest
                        .split_at_checked(count)
                        .ok_or_else(|| at(list, "it has fewer corners than <vcount> says"))?;
                    polygons.push(polygon.to_vec());
                    rest = others;
                }
            }
            // Polygons, and fans, which are what a polygon becomes.
            _ => polygons.push(corners),
        }
    }
    Ok(polygons)
}

/// The matrix of an element that moves a node; `None` for others.
fn transformation(part: Node<'_, '_>) -> Result<Option<Matrix4<f64>>, String> {
    if !part.is_element() {
        return Ok(None);
    }
    Ok(Some(match part.tag_name().name() {
        "matrix" => Matrix4::from_row_slice(&exactly::<16>(part)?),
        "translate" => Matrix4::new_translation(&exactly::<3>(part)?.into()),
        "scale" => Matrix4::new_nonuniform_scaling(&exactly::<3>(part)?.into()),
        "rotate" => {
            let [x, y, z, degrees] = exactly::<4>(part)?;
            let axis = Unit::try_new(Vector3::new(x, y, z), 1e-12)
                .ok_or_else(|| at(part, "its axis has no direction"))?;
            Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous()
        }
        "lookat" | "skew" => {
            return Err(at(
                part,
                "it is not read: bake the transformations into the mesh",
            ));
        }
        _ => return Ok(None),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron in centimetres, shown through a library node and nested nodes.
    fn file(faces: &str, nodes: &str) -> String {
        format!(
            r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="15">0 0 0 10 0 0 0 20 0 0 0 30 900 900 900</float_array>
<technique_common><accessor source="#a" count="5" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
{faces}</mesh></geometry></library_geometries>
<library_nodes><node id="n"><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="w">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"##
        )
    }

    const TRIANGLES: &str = r##"<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="NORMAL" source="#none" offset="1"/><p>0 0 2 0 1 0 0 0 1 0 3 0 0 0 3 0 2 0 1 0 2 0 3 0</p></triangles>"##;

    fn read_text(text: &str) -> Result<Triangles, String> {
        read(text.as_bytes())
    }

    /// Volume inside the faces, cubic metres.
    fn volume(mesh: &Triangles) -> f64 {
        let corner = |index: u32| mesh.vertices[index as usize];
        let of = |&[a, b, c]: &[u32; 3]| corner(a).dot(&corner(b).cross(&corner(c))) / 6.0;
        mesh.triangles.iter().map(of).sum()
    }

    /// All kinds of faces give the same tetrahedron, in metres, without the vertex that no face uses.
    #[test]
    fn faces_of_all_kinds_agree() {
        let input = r##"<input semantic="VERTEX" source="#v" offset="0"/>"##;
        let instance = r##"<node><instance_geometry url="#g"/></node>"##;
        let kinds = [
            TRIANGLES.to_owned(),
            format!(
                "<polylist count=\"4\">{input}<vcount>3 3 3 3</vcount><p>0 2 1 0 1 3 0 3 2 1 2 3</p></polylist>"
            ),
            format!(
                "<polygons count=\"4\">{input}<p>0 2 1</p><p>0 1 3</p><p>0 3 2</p><p>1 2 3</p></polygons>"
            ),
            format!("<tristrips count=\"1\">{input}<p>0 2 1 3 0 2</p></tristrips>"),
            format!("<trifans count=\"2\">{input}<p>0 2 1 3 2</p><p>1 2 3</p></trifans>"),
        ];
        for faces in kinds {
            let mesh = read_text(&file(&faces, instance)).unwrap();
            assert_eq!(
                (mesh.vertices.len(), mesh.triangles.len()),
                (4, 4),
                "{faces}"
            );
            assert!(
                (volume(&mesh) - 1e-3).abs() < 1e-15,
                "{faces}: {}",
                volume(&mesh)
            );
        }
    }

    /// Transformations act in their order, those of outer nodes last; a mirrored mesh keeps its outside.
    #[test]
    fn nodes_move_their_meshes() {
        let nodes = r##"<node><translate>1 2 3</translate><rotate>0 0 1 90</rotate>
            <node><scale>-2 1 1</scale><instance_node url="#n"/></node></node>"##;
        let mesh = read_text(&file(TRIANGLES, nodes)).unwrap();
        assert!((volume(&mesh) - 2e-3).abs() < 1e-12, "{}", volume(&mesh));
        // Scaled to (−20, 0, 0), turned to (0, −20, 0), moved, in centimetres.
        let moved = Vector3::new(0.01, -0.18, 0.03);
        assert!(
            mesh.vertices.iter().any(|v| (v - moved).norm() < 1e-12),
            "{:?}",
            mesh.vertices
        );
        let matrix = "<node><matrix>0 -1 0 1 1 0 0 2 0 0 1 3 0 0 0 1</matrix><node><scale>-2 1 1</scale>\
                      <instance_node url=\"#n\"/></node></node>";
        let same = read_text(&file(TRIANGLES, matrix)).unwrap();
        for (one, other) in mesh.vertices.iter().zip(&same.vertices) {
            assert!((one - other).norm() < 1e-12);
        }
    }

    /// What turns the view does not turn the mesh.
    #[test]
    fn the_up_axis_is_ignored() {
        let text = file(TRIANGLES, r##"<node><instance_geometry url="#g"/></node>"##);
        let turned = text.replace("Z_UP", "Y_UP");
        assert_ne!(turned, text);
        assert_eq!(read_text(&turned), read_text(&text));
    }
}
