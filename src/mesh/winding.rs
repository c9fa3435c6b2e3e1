//! Generalised winding numbers of triangles (Jacobson, Kavan and Sorkine-Hornung 2013), with a tree of dipoles (Barill et
//! al. 2018).
//!
//! For a closed surface this is how many times the surface surrounds a point: 1 inside, 0 outside, 2 where two pieces
//! overlap. Unlike the parity of a ray, it does not depend on which edges the ray meets.
//!
//! The same tree finds the nearest triangle of points far from the surface.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::Triangle;

use super::exact::to_parry;

/// Largest number of triangles in a leaf.
const LEAF: usize = 8;
/// A node farther than this many of its radii is replaced by the first two terms of its expansion. The total error is then
/// a few hundredths, far less than the threshold of one half.
const FAR: f64 = 2.0;

/// A tree over triangles.
#[derive(Debug, Clone)]
pub(super) struct Winding {
    triangles: Vec<[Vector3<f64>; 3]>,
    /// Nodes in depth-first order: the left child of a node follows it directly.
    nodes: Vec<Node>,
    /// The disc about each node, apart from the rest so that a search reads little memory.
    slabs: Vec<Slab>,
}

#[derive(Debug, Clone)]
struct Node {
    centre: Vector3<f64>,
    radius: f64,
    /// Sum of areas times normals.
    dipole: Vector3<f64>,
    /// Sum over triangles of (middle − centre) ⊗ area times normal.
    moment: Matrix3<f64>,
    content: Content,
}

/// A disc of some thickness that holds the triangles of a node.
///
/// It lies in their mean plane, so that it is hardly thicker than they are bent. A box along the axes is as thick as they
/// are wide if they are tilted. Seen from afar, a finely meshed surface then has hundreds of boxes that are nearer than its
/// nearest point.
#[derive(Debug, Clone)]
struct Slab {
    centre: Vector3<f64>,
    /// Unit normal of the disc.
    normal: Vector3<f64>,
    /// Half of its thickness.
    half: f64,
    radius: f64,
}

impl Slab {
    /// The disc about `corners` whose axis passes through `centre`.
    fn about(
        centre: &Vector3<f64>,
        normal: &Vector3<f64>,
        corners: impl Iterator<Item = Vector3<f64>>,
    ) -> Self {
        let normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
        let (mut low, mut high, mut radius) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        for corner in corners {
            let arm = corner - centre;
            let height = arm.dot(&normal);
            low = low.min(height);
            high = high.max(height);
            radius = radius.max((arm - normal * height).norm());
        }
        Self {
            centre: centre + normal * f64::midpoint(low, high),
            normal,
            half: (high - low) / 2.0,
            radius,
        }
    }

    /// Square of the distance of a point.
    #[inline]
    fn squared_distance(&self, point: &Vector3<f64>) -> f64 {
        let arm = point - self.centre;
        let height = arm.dot(&self.normal);
        let over = (height.abs() - self.half).max(0.0);
        let beside = ((arm - self.normal * height).norm() - self.radius).max(0.0);
        over * over + beside * beside
    }
}

/// A search for the nearest triangle.
struct Search<'a> {
    point: &'a Vector3<f64>,
    /// Rounding error of bounds.
    slack: f64,
    /// The least distance so far.
    best: f64,
    /// A node is searched if the square of its bound is below this.
    limit: f64,
}

impl Search<'_> {
    fn shorten(&mut self, best: f64) {
        self.best = best;
        self.limit = (best + self.slack).powi(2);
    }
}

#[derive(Debug, Clone)]
enum Content {
    Leaf { first: usize, end: usize },
    Inner { right: usize },
}

impl Winding {
    pub(super) fn new(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Self {
        let corners = |triangle: &[u32; 3]| triangle.map(|vertex| vertices[vertex as usize]);
        let mut winding = Self {
            triangles: triangles.iter().map(corners).collect(),
            nodes: Vec::with_capacity(triangles.len() / 2 + 1),
            slabs: Vec::with_capacity(triangles.len() / 2 + 1),
        };
        let mut order: Vec<usize> = (0..triangles.len()).collect();
        let middles: Vec<Vector3<f64>> = winding
            .triangles
            .iter()
            .map(|[a, b, c]| (a + b + c) / 3.0)
            .collect();
        if !order.is_empty() {
            winding.split(&mut order, 0, &middles);
        }
        winding.triangles = order
            .iter()
            .map(|&index| corners(&triangles[index]))
            .collect();
        winding
    }

    /// Adds the node of the triangles in `order`, the first of which has number `first`, and all nodes below it.
    fn split(&mut self, order: &mut [usize], first: usize, middles: &[Vector3<f64>]) {
        let here = self.nodes.len();
        let node = self.node(order, first);
        let corners = order.iter().flat_map(|&index| self.triangles[index]);
        self.slabs
            .push(Slab::about(&node.centre, &node.dipole, corners));
        self.nodes.push(node);
        if order.len() <= LEAF {
            return;
        }
        let low = order
            .iter()
            .fold(middles[order[0]], |low, &index| low.inf(&middles[index]));
        let high = order
            .iter()
            .fold(middles[order[0]], |high, &index| high.sup(&middles[index]));
        let axis = (high - low).imax();
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, |&a, &b| {
            middles[a][axis]
                .total_cmp(&middles[b][axis])
                .then(a.cmp(&b))
        });
        let (left, right) = order.split_at_mut(half);
        self.split(left, first, middles);
        let place = self.nodes.len();
        self.nodes[here].content = Content::Inner { right: place };
        self.split(right, first + half, middles);
    }

    fn node(&self, order: &[usize], first: usize) -> Node {
        let mut centre = Vector3::zeros();
        let (mut dipole, mut moment, mut total) = (Vector3::zeros(), Matrix3::zeros(), 0.0);
        for &index in order {
            let [a, b, c] = self.triangles[index];
            let area: Vector3<f64> = (b - a).cross(&(c - a)) / 2.0;
            let middle = (a + b + c) / 3.0;
            let weight = area.norm().max(f64::MIN_POSITIVE);
            dipole += area;
            moment += middle * area.transpose();
            total += weight;
            centre += middle * weight;
        }
        centre /= total;
        moment -= centre * dipole.transpose();
        let corners = order.iter().flat_map(|&index| self.triangles[index]);
        Node {
            centre,
            radius: corners.map(|v| (v - centre).norm()).fold(0.0, f64::max),
            dipole,
            moment,
            content: Content::Leaf {
                first,
                end: first + order.len(),
            },
        }
    }

    /// The winding number at `point`, with an error of a few hundredths.
    pub(super) fn at(&self, point: &Vector3<f64>) -> f64 {
        if self.nodes.is_empty() {
            return 0.0;
        }
        self.angle(0, point) / (4.0 * PI)
    }

    /// Whether `point` lies inside.
    pub(super) fn surrounds(&self, point: &Vector3<f64>) -> bool {
        self.reaches(point) && self.at(point) > 0.5
    }

    /// Whether `point` lies in the ball around all triangles. A closed surface does not surround a point outside it.
    pub(super) fn reaches(&self, point: &Vector3<f64>) -> bool {
        let near = |all: &Node| (all.centre - point).norm() <= all.radius;
        self.nodes.first().is_some_and(near)
    }

    /// Distance of `point` from the nearest triangle if it is less than `reach`.
    pub(super) fn gap_within(&self, point: &Vector3<f64>, reach: f64) -> Option<f64> {
        /// Rounding error of the distance from a disc, as a share of the numbers that it is computed from.
        const ROUNDING: f64 = 1e-14;
        let all = self.nodes.first()?;
        let scale = point.abs().max() + all.centre.abs().max() + all.radius;
        let mut search = Search {
            point,
            slack: scale * ROUNDING,
            best: reach,
            limit: 0.0,
        };
        search.shorten(reach);
        self.search(0, &mut search);
        (search.best < reach).then_some(search.best)
    }

    /// Looks for a triangle of a node that is nearer than the best.
    fn search(&self, node: usize, search: &mut Search<'_>) {
        match self.nodes[node].content {
            Content::Leaf { first, end } => {
                for triangle @ [a, b, c] in &self.triangles[first..end] {
                    let below = a.inf(b).inf(c) - search.point;
                    let above = search.point - a.sup(b).sup(c);
                    let apart = below.sup(&above).sup(&Vector3::zeros());
                    if apart.norm_squared() >= search.limit {
                        continue;
                    }
                    let distance = distance_to(triangle, search.point);
                    if distance < search.best {
                        search.shorten(distance);
                    }
                }
            }
            Content::Inner { right } => {
                let bound = |node: usize| (self.slabs[node].squared_distance(search.point), node);
                let (mut near, mut far) = (bound(node + 1), bound(right));
                if far.0 < near.0 {
                    std::mem::swap(&mut near, &mut far);
                }
                for (bound, node) in [near, far] {
                    if bound < search.limit {
                        self.search(node, search);
                    }
                }
            }
        }
    }

    /// Lowest and highest corner of a box about that ball.
    pub(super) fn bounds(&self) -> [Vector3<f64>; 2] {
        let ball = self.nodes.first();
        let (centre, radius) = ball.map_or((Vector3::zeros(), 0.0), |all| (all.centre, all.radius));
        [centre.add_scalar(-radius), centre.add_scalar(radius)]
    }

    /// Solid angle of the triangles of a node. From afar it is d·r/r³ + (tr M − 3 r·M r/r²)/r³, where d is their dipole, M
    /// their moment about the centre, and r the vector from the point to the centre.
    fn angle(&self, node: usize, point: &Vector3<f64>) -> f64 {
        let Node {
            centre,
            radius,
            dipole,
            moment,
            content,
            ..
        } = &self.nodes[node];
        let offset = centre - point;
        let squared = offset.norm_squared();
        if squared > (FAR * radius).powi(2) {
            let across = 3.0 * offset.dot(&(moment * offset)) / squared;
            return (dipole.dot(&offset) + moment.trace() - across) / (squared * squared.sqrt());
        }
        match *content {
            Content::Leaf { first, end } => self.triangles[first..end]
                .iter()
                .map(|triangle| solid_angle(triangle, point))
                .sum(),
            Content::Inner { right } => self.angle(node + 1, point) + self.angle(right, point),
        }
    }
}

/// Distance of a point from a triangle.
fn distance_to(triangle: &[Vector3<f64>; 3], point: &Vector3<f64>) -> f64 {
    let [a, b, c] = triangle.map(|corner| to_parry(&corner));
    let query = to_parry(point);
    let projection = Triangle::new(a, b, c).project_local_point(query, false);
    (projection.point - query).length()
}

/// Solid angle of a triangle, positive seen from behind (van Oosterom and Strackee 1983).
fn solid_angle(triangle: &[Vector3<f64>; 3], point: &Vector3<f64>) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner - point);
    let [la, lb, lc] = [a.norm(), b.norm(), c.norm()];
    let volume = a.dot(&b.cross(&c));
    let scale = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * libm::atan2(volume, scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::ExactMesh;
    use crate::object::Object;
    use crate::sample::{Task, stream};
    use rand::RngExt;

    #[test]
    fn counts_how_often_a_surface_surrounds_a_point() {
        let (mesh, _) = Object::parts_of_named("mug").unwrap();
        // Twice the same mug, one of them moved.
        let mut vertices = mesh.vertices().to_vec();
        let count = u32::try_from(vertices.len()).unwrap();
        vertices.extend(mesh.vertices().iter().map(|v| v + Vector3::x() * 0.01));
        let mut triangles = mesh.triangles().to_vec();
        triangles.extend(mesh.triangles().iter().map(|t| t.map(|i| i + count)));
        let tree = Winding::new(&vertices, &triangles);
        let directly = |p: &Vector3<f64>| {
            let corners = triangles.iter().map(|t| t.map(|i| vertices[i as usize]));
            let angle: f64 = corners.map(|corners| solid_angle(&corners, p)).sum();
            angle / (4.0 * PI)
        };
        let mut rng = stream(3, Task::Start, 0);
        let mut seen = [0; 3];
        let mut off = Vec::new();
        for _ in 0..2_000 {
            let p = Vector3::new(
                rng.random_range(-0.06..0.11),
                rng.random_range(-0.06..0.06),
                rng.random_range(-0.01..0.11),
            );
            let turns = directly(&p);
            let times = (0_u32..3)
                .find(|&times| (turns - f64::from(times)).abs() < 1e-9)
                .unwrap_or_else(|| panic!("{p}: {turns}"));
            seen[times as usize] += 1;
            off.push((tree.at(&p) - f64::from(times)).abs());
        }
        off.sort_by(f64::total_cmp);
        // Half a turn decides.
        let [middle, most] = [off[1_000], off[1_999]];
        assert!(
            middle < 0.02 && most < 0.1,
            "off by {middle}, at most {most}"
        );
        assert!(seen.iter().all(|&count| count > 20), "{seen:?}");
    }

    #[test]
    fn the_nearest_triangle_is_that_of_a_search_of_all() {
        let (mug, _) = Object::parts_of_named("mug").unwrap();
        let tree = Winding::new(mug.vertices(), mug.triangles());
        let exact = ExactMesh::new(&mug);
        let mut rng = stream(4, Task::Start, 0);
        for round in 0..600 {
            // On the surface, near it, inside, and metres away.
            let width = [0.0, 0.02, 0.3, 4.0][round % 4];
            let vertex = mug.vertices()[round % mug.vertices().len()];
            let point = vertex + Vector3::from_fn(|_, _| width * rng.random_range(-0.5..0.5));
            let all = tree
                .triangles
                .iter()
                .map(|triangle| distance_to(triangle, &point));
            let least = all.fold(f64::INFINITY, f64::min);
            let found = tree.gap_within(&point, f64::MAX).unwrap();
            assert_eq!(found.to_bits(), least.to_bits(), "{point}");
            assert_eq!(found.to_bits(), exact.gap(&point).to_bits(), "{point}");
            assert_eq!(tree.gap_within(&point, least), None);
            let just = tree.gap_within(&point, least * (1.0 + 1e-9) + 1e-12);
            assert_eq!(just, Some(found));
        }
    }
}
