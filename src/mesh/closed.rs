//! Closed triangle meshes and their geometric properties.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::limits::{GRASP_POSITION, Limit, MESH_COORDINATE, MESH_SIZE, OBJECT_SIZE};

use super::MeshError;
use super::box_tree::BoxTree;
use super::mesh_union::{Entangled, SignedDistance, united};
use super::winding::Winding;
use crate::formats::Triangles;

/// Volume of the flattest solid, as a share of the cube of its longest side.
const LEAST_VOLUME: f64 = 1e-9;

/// A closed surface of triangles that are counter-clockwise seen from outside.
///
/// It may consist of several closed pieces. If they overlap or touch, the solid is their union, and volume, centroid, area
/// and samples are those of the union.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
    /// The surface of the union, if it differs from the triangles.
    union: Option<Arc<Triangles>>,
}

impl Mesh {
    /// A mesh in metres. `name` is the name of the file or object in errors.
    ///
    /// A surface that is inside out as a whole is turned. Vertices that no triangle uses and triangles with two equal
    /// corners are dropped. Coincident vertices stay separate if the surface is closed as indexed; otherwise they are
    /// merged. [`Mesh::repaired`] does more.
    ///
    /// # Errors
    /// If there are no triangles, an index or coordinate is invalid, the surface is not closed, its triangles disagree on
    /// which side is outside, it has no volume, or its closed pieces meet in more than 20 million places.
    pub fn new(
        name: &str,
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, MeshError> {
        Self::of_pieces(name, vertices, triangles, None)
    }

    /// As [`Mesh::new`], for pieces that may be meshes of convex solids with the signed distances `solids`.
    ///
    /// # Errors
    /// As [`Mesh::new`].
    pub(crate) fn of_pieces(
        name: &str,
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
        solids: Option<&[SignedDistance<'_>]>,
    ) -> Result<Self, MeshError> {
        let mut mesh = Self::solid(name, vertices, triangles)?;
        let entangled = |Entangled| MeshError::Entangled(name.to_owned());
        mesh.union = united(&mesh, solids).map_err(entangled)?.map(Arc::new);
        Ok(mesh)
    }

    /// A closed mesh whose triangles face outward, before its pieces are united.
    ///
    /// # Errors
    /// As [`Mesh::new`].
    fn solid(
        name: &str,
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, MeshError> {
        let mut mesh = Self::closed(name, vertices, triangles)?;
        let size_m = mesh.size_m();
        MESH_SIZE
            .check(size_m)
            .map_err(|beyond| MeshError::Longest {
                name: name.to_owned(),
                beyond,
            })?;
        let volume = mesh.volume();
        if volume.abs() < LEAST_VOLUME * size_m.powi(3) {
            return Err(MeshError::NoVolume(name.to_owned()));
        }
        if volume < 0.0 {
            for triangle in &mut mesh.triangles {
                triangle.swap(1, 2);
            }
        }
        Ok(mesh)
    }

    /// A closed and consistently oriented mesh. Its pieces may be inside out.
    ///
    /// # Errors
    /// As [`Mesh::new`], except for the volume.
    pub(crate) fn closed(
        name: &str,
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, MeshError> {
        let name = || name.to_owned();
        let count = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
        if let Some(&index) = triangles.iter().flatten().find(|&&index| index >= count) {
            return Err(MeshError::Index {
                name: name(),
                index,
                count,
            });
        }
        check_vertices(&name(), &vertices, MESH_COORDINATE)?;
        let mut mesh = Self {
            vertices,
            triangles,
            union: None,
        };
        mesh.drop_degenerate();
        let mut seams = mesh.seams();
        if !seams.close() {
            mesh.merge_coincident();
            seams = mesh.seams();
        }
        if mesh.triangles.is_empty() {
            return Err(MeshError::NoTriangles(name()));
        }
        if seams.open > 0 {
            return Err(MeshError::Open {
                name: name(),
                edges: seams.open,
                missing: String::new(),
            });
        }
        if seams.flipped > 0 {
            return Err(MeshError::Orientation {
                name: name(),
                edges: seams.flipped,
            });
        }
        mesh.drop_unused();
        Ok(mesh)
    }

    /// Refuses a size that cannot be metres.
    ///
    /// # Errors
    /// If the longest side of the bounding box is below 2 mm or above 2 m.
    pub fn check_size(&self, name: &str) -> Result<(), MeshError> {
        let size_m = self.size_m();
        if OBJECT_SIZE.holds(size_m) {
            return check_vertices(name, &self.vertices, GRASP_POSITION);
        }
        let (unit, factor) = if size_m > OBJECT_SIZE.most {
            ("millimetres", 1e-3)
        } else {
            ("kilometres", 1e3)
        };
        Err(MeshError::Size {
            name: name.to_owned(),
            size_m,
            unit,
            factor,
        })
    }

    /// Longest side of the bounding box, metres.
    pub fn size_m(&self) -> f64 {
        let [low, high] = self.bounds();
        (high - low).max()
    }

    /// Vertices and triangles that bound the solid: those of the union of the pieces if these overlap, otherwise the mesh's
    /// own.
    pub(crate) fn boundary(&self) -> (&[Vector3<f64>], &[[u32; 3]]) {
        match &self.union {
            Some(union) => (&union.vertices, &union.triangles),
            None => (&self.vertices, &self.triangles),
        }
    }

    /// Whether pieces of the mesh overlap or touch, so that some faces are not part of the surface.
    pub fn overlaps(&self) -> bool {
        self.union.is_some()
    }

    /// Share of the surface that lies inside the solid. It is positive if a single piece intersects itself.
    pub fn buried_share(&self) -> f64 {
        /// Distance of the test point outside a triangle, as a share of the mesh's size.
        const OUTSIDE: f64 = 1e-4;
        let (vertices, triangles) = self.boundary();
        let winding = Winding::new(vertices, triangles);
        let reach = OUTSIDE * self.size_m();
        // Area of a triangle and whether it is buried.
        let judged = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
            let cross = (b - a).cross(&(c - a));
            let normal = cross.try_normalize(f64::MIN_POSITIVE)?;
            let outside = (a + b + c) / 3.0 + normal * reach;
            Some((cross.norm() / 2.0, winding.surrounds(&outside)))
        };
        let judged: Vec<Option<(f64, bool)>> = triangles.par_iter().map(judged).collect();
        let (mut buried, mut all) = (0.0, 0.0);
        for (area, is_buried) in judged.into_iter().flatten() {
            all += area;
            if is_buried {
                buried += area;
            }
        }
        if all > 0.0 { buried / all } else { 0.0 }
    }

    /// Number of pieces that share no vertex.
    pub fn piece_count(&self) -> usize {
        self.pieces().len()
    }

    /// Vertices, metres, object frame.
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.vertices
    }

    /// Triangles as indices into [`Mesh::vertices`], counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The same mesh with all lengths multiplied by `factor` about the origin.
    ///
    /// # Errors
    /// If the scaled mesh has no volume.
    pub fn scaled(&self, name: &str, factor: f64) -> Result<Self, MeshError> {
        let scaled = |vertices: &[Vector3<f64>]| vertices.iter().map(|v| v * factor).collect();
        let mut mesh = Self::solid(name, scaled(&self.vertices), self.triangles.clone())?;
        mesh.union = self.union.as_ref().map(|union| {
            Arc::new(Triangles {
                vertices: scaled(&union.vertices),
                triangles: union.triangles.clone(),
            })
        });
        Ok(mesh)
    }

    /// Corners of triangle number `index`.
    pub fn corners(&self, index: usize) -> [Vector3<f64>; 3] {
        self.triangles[index].map(|vertex| self.vertices[vertex as usize])
    }

    /// Lowest and highest corner of the bounding box along the axes, metres.
    pub fn bounds(&self) -> [Vector3<f64>; 2] {
        let first = self.vertices[0];
        self.vertices
            .iter()
            .fold([first, first], |[low, high], v| [low.inf(v), high.sup(v)])
    }

    /// Volume Σ a·(b × c)/6 over the triangles, m³.
    pub fn volume(&self) -> f64 {
        self.volume_and_first_moment().0
    }

    /// Centroid of the volume, metres.
    pub fn centroid(&self) -> Vector3<f64> {
        let (volume, moment) = self.volume_and_first_moment();
        self.middle() + moment / volume
    }

    /// Largest distance of a vertex from the centroid of the volume, metres.
    pub fn radius_m(&self) -> f64 {
        let centroid = self.centroid();
        self.vertices
            .iter()
            .map(|v| (v - centroid).norm())
            .fold(0.0, f64::max)
    }

    /// Area of the surface, m².
    pub fn area_m2(&self) -> f64 {
        self.areas().sum()
    }

    /// Pieces that share no vertex, each as a list of triangles over the common vertices.
    pub(crate) fn pieces(&self) -> Vec<Vec<[u32; 3]>> {
        let mut parent: Vec<u32> = (0..).take(self.vertices.len()).collect();
        for triangle in &self.triangles {
            let root = find_root(&mut parent, triangle[0]);
            for &vertex in &triangle[1..] {
                let other = find_root(&mut parent, vertex);
                parent[other as usize] = root;
            }
        }
        let mut pieces: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
        for triangle in &self.triangles {
            pieces
                .entry(find_root(&mut parent, triangle[0]))
                .or_default()
                .push(*triangle);
        }
        pieces.into_values().collect()
    }

    pub(super) fn areas(&self) -> impl Iterator<Item = f64> + '_ {
        let (vertices, triangles) = self.boundary();
        triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
            (b - a).cross(&(c - a)).norm() / 2.0
        })
    }

    fn middle(&self) -> Vector3<f64> {
        let [low, high] = self.bounds();
        (low + high) / 2.0
    }

    /// Volume and its first moment about the middle of the bounding box. About a distant origin the sums would cancel.
    fn volume_and_first_moment(&self) -> (f64, Vector3<f64>) {
        let middle = self.middle();
        let (vertices, triangles) = self.boundary();
        let zero = (0.0, Vector3::zeros());
        triangles.iter().fold(zero, |(volume, moment), triangle| {
            let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize] - middle);
            let part = a.dot(&b.cross(&c)) / 6.0;
            (volume + part, moment + (a + b + c) * (part / 4.0))
        })
    }

    fn seams(&self) -> Seams {
        // Uses of undirected edges; `true` is upward.
        let uses = |&[a, b, c]: &[u32; 3]| {
            [[a, b], [b, c], [c, a]].map(|[from, to]| ([from.min(to), from.max(to)], from < to))
        };
        let mut uses: Vec<([u32; 2], bool)> = self.triangles.iter().flat_map(uses).collect();
        uses.par_sort_unstable();
        let mut seams = Seams::default();
        for uses in uses.chunk_by(|(one, _), (two, _)| one == two) {
            let upward = uses.iter().filter(|(_, up)| *up).count();
            seams.open += uses.len() % 2;
            seams.flipped += usize::from(uses.len() % 2 == 0 && 2 * upward != uses.len());
            seams.crowded += usize::from(uses.len() > 2);
        }
        seams
    }

    /// Whether the surface bounds a solid without doubt: no more than two triangles meet at an edge, each piece encloses a
    /// volume, and no two pieces lie in the same place, as the two sides of a double surface do.
    pub(super) fn is_plain(&self) -> bool {
        /// Boxes that differ by less than this share of the mesh's size are the same.
        const SAME: f64 = 1e-5;
        if self.seams().crowded > 0 {
            return false;
        }
        let mut boxes = Vec::new();
        for piece in self.pieces() {
            let first = self.vertices[piece[0][0] as usize];
            let corners = piece.iter().flatten().map(|&v| self.vertices[v as usize]);
            let [low, high] =
                corners.fold([first, first], |[low, high], v| [low.inf(&v), high.sup(&v)]);
            let volume = super::exact::signed_volume(self, &piece) / 6.0;
            if volume.abs() < LEAST_VOLUME * (high - low).max().powi(3) {
                return false;
            }
            boxes.push([low, high]);
        }
        let same = SAME * self.size_m();
        let lowest = BoxTree::new(boxes.iter().map(|[low, _]| [*low, *low]));
        boxes.iter().enumerate().all(|(place, [low, high])| {
            let near = lowest.near(low, low, same).into_iter();
            let mut others = near
                .filter(|other| *other != place)
                .map(|other| &boxes[other]);
            others.all(|[other_low, other_high]| {
                (other_low - low).amax() > same || (other_high - high).amax() > same
            })
        })
    }

    fn merge_coincident(&mut self) {
        let mut order: Vec<u32> = (0..).take(self.vertices.len()).collect();
        let key = |index: u32| self.vertices[index as usize];
        order.sort_by(|&a, &b| {
            let (a, b) = (key(a), key(b));
            a.x.total_cmp(&b.x)
                .then(a.y.total_cmp(&b.y))
                .then(a.z.total_cmp(&b.z))
        });
        let mut first_of: Vec<u32> = (0..).take(self.vertices.len()).collect();
        for pair in 1..order.len() {
            let (before, here) = (order[pair - 1], order[pair]);
            if key(before) == key(here) {
                first_of[here as usize] = first_of[before as usize];
            }
        }
        for triangle in &mut self.triangles {
            *triangle = triangle.map(|index| first_of[index as usize]);
        }
        self.drop_degenerate();
    }

    fn drop_degenerate(&mut self) {
        self.triangles
            .retain(|&[a, b, c]| a != b && b != c && c != a);
    }

    fn drop_unused(&mut self) {
        let mut new_index = vec![u32::MAX; self.vertices.len()];
        for &index in self.triangles.iter().flatten() {
            new_index[index as usize] = 0;
        }
        let mut kept = 0;
        let mut vertices = Vec::with_capacity(self.vertices.len());
        for (vertex, index) in self.vertices.iter().zip(&mut new_index) {
            if *index == 0 {
                *index = kept;
                kept += 1;
                vertices.push(*vertex);
            }
        }
        for triangle in &mut self.triangles {
            *triangle = triangle.map(|index| new_index[index as usize]);
        }
        self.vertices = vertices;
    }
}

/// Numbers of edges that prevent a closed, oriented surface, or make one doubtful.
#[derive(Debug, Default, PartialEq)]
struct Seams {
    open: usize,
    flipped: usize,
    /// Edges of more than two triangles, which bound a solid all the same if the surface is closed.
    crowded: usize,
}

impl Seams {
    fn close(&self) -> bool {
        self.open == 0 && self.flipped == 0
    }
}

/// Refuses coordinates beyond their limit.
fn check_vertices(name: &str, vertices: &[Vector3<f64>], limit: Limit) -> Result<(), MeshError> {
    for (vertex, corner) in vertices.iter().enumerate() {
        for coordinate in corner {
            if !coordinate.is_finite() {
                return Err(MeshError::NotANumber {
                    name: name.to_owned(),
                    vertex,
                    value: *coordinate,
                });
            }
            limit
                .check(*coordinate)
                .map_err(|beyond| MeshError::Coordinate {
                    name: name.to_owned(),
                    vertex,
                    beyond,
                })?;
        }
    }
    Ok(())
}

fn find_root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        parent[node as usize] = parent[parent[node as usize] as usize];
        node = parent[node as usize];
    }
    node
}

#[cfg(test)]
mod tests {
    use super::super::testing::CUBE;
    use super::*;

    fn corners(size_m: f64) -> Vec<Vector3<f64>> {
        (0..8_u8)
            .map(|i| {
                Vector3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * size_m
            })
            .collect()
    }

    fn cube() -> Mesh {
        Mesh::new("cube", corners(0.1), CUBE.to_vec()).unwrap()
    }

    #[test]
    fn a_cube_measures_as_a_cube() {
        let cube = cube();
        assert!((cube.volume() - 1e-3).abs() < 1e-15);
        assert!((cube.centroid() - Vector3::repeat(0.05)).norm() < 1e-15);
        assert!((cube.radius_m() - 0.05 * 3.0_f64.sqrt()).abs() < 1e-15);
        assert!((cube.area_m2() - 0.06).abs() < 1e-15);
    }

    #[test]
    fn a_cube_turned_inside_out_is_turned_back() {
        let inside_out = CUBE.map(|[a, b, c]| [a, c, b]).to_vec();
        let mesh = Mesh::new("cube", corners(0.1), inside_out).unwrap();
        assert_eq!(mesh, cube());
    }

    #[test]
    fn separate_corners_are_merged_and_unused_ones_dropped() {
        let corners = corners(0.1);
        let mut apart: Vec<_> = CUBE
            .iter()
            .flatten()
            .map(|&index| corners[index as usize])
            .collect();
        apart.push(Vector3::repeat(9.0));
        let mesh = Mesh::new(
            "cube",
            apart,
            (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        )
        .unwrap();
        assert_eq!(mesh.vertices().len(), 8);
        assert!((mesh.volume() - 1e-3).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_solid_is_refused() {
        let refuse = |vertices, triangles| Mesh::new("thing", vertices, triangles).unwrap_err();
        let error = refuse(corners(0.1), CUBE[1..].to_vec());
        assert!(matches!(error, MeshError::Open { edges: 3, .. }), "{error}");
        let mut flipped = CUBE.to_vec();
        flipped[4].swap(0, 1);
        let error = refuse(corners(0.1), flipped);
        assert!(
            matches!(error, MeshError::Orientation { edges: 3, .. }),
            "{error}"
        );
        let error = refuse(corners(0.1), vec![]);
        assert!(matches!(error, MeshError::NoTriangles { .. }), "{error}");
        let error = refuse(corners(0.1), vec![[0, 1, 8]]);
        assert!(
            matches!(
                error,
                MeshError::Index {
                    index: 8,
                    count: 8,
                    ..
                }
            ),
            "{error}"
        );
        let mut infinite = corners(0.1);
        infinite[2].y = f64::NAN;
        let error = refuse(infinite, CUBE.to_vec());
        assert!(
            matches!(error, MeshError::NotANumber { vertex: 2, .. }),
            "{error}"
        );
        // A square sheet with two sides.
        let sheet = vec![[0, 1, 2], [1, 3, 2], [0, 2, 1], [1, 2, 3]];
        let error = refuse(corners(0.1), sheet);
        assert!(matches!(error, MeshError::NoVolume { .. }), "{error}");
    }

    #[test]
    fn millimetres_are_noticed() {
        let of_size = |size_m: f64| Mesh::new("thing", corners(size_m), CUBE.to_vec()).unwrap();
        let error = of_size(100.0).check_size("thing").unwrap_err();
        assert!(
            error
                .to_string()
                .contains("millimetres, scale it by 0.001 (--scale 0.001"),
            "{error}"
        );
        let error = of_size(1e-4).check_size("thing").unwrap_err();
        assert!(error.to_string().contains("--scale 1000"), "{error}");
        assert!((cube().scaled("cube", 0.5).unwrap().volume() - 1.25e-4).abs() < 1e-15);
    }
}
