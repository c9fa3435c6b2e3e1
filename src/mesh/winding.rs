//! Generalised winding numbers of triangles (Jacobson, Kavan and Sorkine-Hornung 2013), with a tree of dipoles (Barill et
//! al. 2018).
//!
//! For a closed surface this is how many times the surface surrounds a point: 1 inside, 0 outside, 2 where two pieces
//! overlap. Unlike the parity of a ray, it does not depend on which edges the ray meets.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

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
        self.nodes.push(self.node(order, first));
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
}
