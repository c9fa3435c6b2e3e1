//! The hand as solid parts, for measuring depths.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use nalgebra::Vector3;

use super::geometry::LinkMesh;
use super::hull::Hull;
use super::{Capsule, Frame, Hand, LinkId, PosedHand};
use crate::mesh::{ExactMesh, Mesh, TriangleTree};

/// A part of the hand, which is a capsule or the meshes of a link: its triangles and its interior.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    /// The link in whose frame it lies; `None` for the skin of a hand that bends, which is in the object's frame.
    pub(super) link: Option<LinkId>,
    /// Its triangles.
    pub(crate) surface: TriangleTree,
    /// Its interior.
    pub(crate) solid: Solid,
    /// Centre of a ball around it.
    pub(crate) centre: Vector3<f64>,
    /// Radius of the ball, metres.
    pub(crate) radius_m: f64,
}

/// The interior of a part.
#[derive(Debug, Clone)]
pub(crate) enum Solid {
    /// The interior of capsule `number` of [`Hand::capsules`].
    Capsule {
        /// Index of the capsule.
        number: usize,
        /// Its radius, metres.
        radius_m: f64,
    },
    /// The interior of a closed mesh.
    Mesh(Box<ExactMesh>),
    /// Triangles without an interior.
    Nothing,
}

/// The parts of a hand of rigid links, computed on first use. They follow from the geometry, so all values are equal.
#[derive(Debug, Clone, Default)]
pub(super) struct Parts(Arc<OnceLock<Vec<Part>>>);

impl PartialEq for Parts {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Part {
    /// The frame in which it lies, relative to the object.
    pub(crate) fn frame(&self, posed: &PosedHand) -> Frame {
        self.link
            .map_or_else(Frame::default, |link| posed.object_from_link[link.0])
    }

    fn new(
        link: Option<LinkId>,
        vertices: &[Vector3<f64>],
        surface: TriangleTree,
        solid: Option<Mesh>,
    ) -> Self {
        let first = vertices.first().copied().unwrap_or_default();
        let (low, high) = vertices
            .iter()
            .fold((first, first), |(low, high), v| (low.inf(v), high.sup(v)));
        let centre = low.lerp(&high, 0.5);
        let reach = vertices.iter().map(|v| (v - centre).norm());
        Self {
            link,
            surface,
            solid: solid.map_or(Solid::Nothing, |solid| {
                Solid::Mesh(Box::new(ExactMesh::new(&solid)))
            }),
            centre,
            radius_m: reach.fold(0.0, f64::max),
        }
    }

    /// The meshes of one link and the union of the solids that they bound. Where two of them touch, a point deep in their
    /// union need not be deep in either.
    fn of_meshes(meshes: &[&LinkMesh]) -> Option<Self> {
        let link = meshes.first()?.link;
        let pieces = meshes
            .iter()
            .map(|mesh| (&mesh.vertices[..], &mesh.triangles[..]));
        let (vertices, triangles) = joined(pieces);
        let surface = TriangleTree::new(&vertices, &triangles)?;
        let solids: Vec<Mesh> = meshes
            .iter()
            .filter_map(|mesh| solid_or_hull(mesh))
            .collect();
        let pieces = solids
            .iter()
            .map(|solid| (solid.vertices(), solid.triangles()));
        let (corners, faces) = joined(pieces);
        let solid = Mesh::new("part", corners, faces).ok()?;
        Some(Self::new(Some(link), &vertices, surface, Some(solid)))
    }

    /// A mesh and the solid that it bounds.
    fn of_mesh(mesh: &LinkMesh) -> Option<Self> {
        let LinkMesh {
            link,
            vertices,
            triangles,
        } = mesh;
        let surface = TriangleTree::new(vertices, triangles)?;
        Some(Self::new(
            Some(*link),
            vertices,
            surface,
            solid_or_hull(mesh),
        ))
    }

    fn of_capsule(number: usize, capsule: &Capsule) -> Option<Self> {
        let mesh = capsule_mesh(capsule);
        Some(Self {
            link: Some(capsule.link),
            surface: TriangleTree::new(&mesh.vertices, &mesh.triangles)?,
            solid: Solid::Capsule {
                number,
                radius_m: capsule.radius_m,
            },
            centre: capsule.a.lerp(&capsule.b, 0.5),
            radius_m: (capsule.b - capsule.a).norm() / 2.0 + capsule.radius_m,
        })
    }
}

/// The solid that triangles bound, repaired if necessary.
fn solid(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Option<Mesh> {
    let repaired = Mesh::repaired("part", vertices.to_vec(), triangles.to_vec());
    repaired.ok().map(|repaired| repaired.mesh)
}

/// The solid that a mesh bounds; if it bounds none even after repair, the solid of its convex hull.
fn solid_or_hull(mesh: &LinkMesh) -> Option<Mesh> {
    let hull = || {
        let hull = Hull::of(mesh.link, &mesh.vertices)?;
        Mesh::new("hull", hull.vertices, hull.triangles).ok()
    };
    solid(&mesh.vertices, &mesh.triangles).or_else(hull)
}

/// Joins the triangles of several meshes into one mesh.
fn joined<'a>(
    meshes: impl Iterator<Item = (&'a [Vector3<f64>], &'a [[u32; 3]])>,
) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (corners, faces) in meshes {
        let first = u32::try_from(vertices.len()).expect("readers bound the size of meshes");
        triangles.extend(faces.iter().map(|face| face.map(|corner| first + corner)));
        vertices.extend_from_slice(corners);
    }
    (vertices, triangles)
}

impl Hand {
    /// The parts whose union is the hand ([`Hand::solid_skin`]). Parts of rigid links are made at the first call, which may
    /// take a second; the skin of a hand that bends is made at each call.
    pub(crate) fn parts(&self, posed: &PosedHand) -> Cow<'_, [Part]> {
        let Some(blend) = &self.blend else {
            return Cow::Borrowed(self.rigid_parts());
        };
        let Some(surface) = TriangleTree::new(&posed.points, &blend.triangles) else {
            return Cow::Borrowed(self.rigid_parts());
        };
        let solid = solid(&posed.points, &blend.triangles);
        let others = if solid.is_none() {
            self.rigid_parts()
        } else {
            &[]
        };
        let skin = Part::new(None, &posed.points, surface, solid);
        let parts = std::iter::once(skin)
            .chain(others.iter().cloned())
            .collect();
        Cow::Owned(parts)
    }

    /// The parts of the hand in the frames of its links.
    pub(super) fn rigid_parts(&self) -> &[Part] {
        self.parts.0.get_or_init(|| {
            let capsules = (self.capsules.iter().zip(&self.exact).enumerate())
                // The capsules are the only interior of a hand that bends if its skin bounds no solid.
                .filter(|(_, (_, exact))| **exact || self.bends())
                .filter_map(|(number, (capsule, _))| Part::of_capsule(number, capsule));
            let mut of_links: BTreeMap<usize, Vec<&LinkMesh>> = BTreeMap::new();
            for mesh in &self.meshes {
                of_links.entry(mesh.link.0).or_default().push(mesh);
            }
            let meshes = of_links.into_values().flat_map(|meshes| {
                let union = (meshes.len() > 1).then(|| Part::of_meshes(&meshes));
                match union.flatten() {
                    Some(part) => vec![part],
                    None => meshes.into_iter().filter_map(Part::of_mesh).collect(),
                }
            });
            meshes.chain(capsules).collect()
        })
    }
}

/// Corners around a capsule and rings on each of its half spheres.
const AROUND: u32 = 24;
const RINGS: u32 = 6;

pub(super) fn capsule_mesh(capsule: &Capsule) -> LinkMesh {
    let along = (capsule.b - capsule.a)
        .try_normalize(1e-12)
        .unwrap_or_else(Vector3::z);
    let across = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
    let third = along.cross(&across);
    let mut vertices = vec![capsule.a - along * capsule.radius_m];
    let latitudes = (1..=RINGS).map(|ring| (capsule.a, f64::from(ring) / f64::from(RINGS) - 1.0));
    let upper = (0..RINGS).map(|ring| (capsule.b, f64::from(ring) / f64::from(RINGS)));
    for (centre, latitude) in latitudes.chain(upper) {
        let (sin, cos) = libm::sincos(latitude * std::f64::consts::FRAC_PI_2);
        for corner in 0..AROUND {
            let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(AROUND);
            let out = across * libm::cos(angle) + third * libm::sin(angle);
            vertices.push(centre + (along * sin + out * cos) * capsule.radius_m);
        }
    }
    vertices.push(capsule.b + along * capsule.radius_m);
    let last = 1 + 2 * RINGS * AROUND;
    let at = |ring: u32, corner: u32| 1 + ring * AROUND + corner % AROUND;
    let mut triangles = Vec::new();
    for corner in 0..AROUND {
        triangles.push([0, at(0, corner + 1), at(0, corner)]);
        triangles.push([
            last,
            at(2 * RINGS - 1, corner),
            at(2 * RINGS - 1, corner + 1),
        ]);
        for ring in 0..2 * RINGS - 1 {
            let [a, b] = [at(ring, corner), at(ring, corner + 1)];
            let [c, d] = [at(ring + 1, corner), at(ring + 1, corner + 1)];
            triangles.push([a, b, d]);
            triangles.push([a, d, c]);
        }
    }
    LinkMesh {
        link: capsule.link,
        vertices,
        triangles,
    }
}
