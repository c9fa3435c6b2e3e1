//! A closed skin over the capsules, for drawing: built once, then bent with the joints.

use nalgebra::Vector3;

use super::blend::BlendVertex;
use super::geometry::LinkMesh;
use super::solid::capsule_mesh;
use super::{Capsule, Frame, Hand, LinkId, PosedHand, axis_distance};

/// Cells of the grid along the longest side of the hand; a cell is 2 mm on a human hand.
const CELLS: f64 = 100.0;
/// Rounding of creases within a digit, within the palm, and where a digit leaves the palm, metres. It is small on digits,
/// where the drawn skin should stay within a millimetre of the contact geometry.
const DIGIT_CREASE_M: f64 = 3e-3;
const PALM_CREASE_M: f64 = 10e-3;
const ROOT_CREASE_M: f64 = 10e-3;
/// A link has no weight on a vertex if it is farther away than the nearest link by more than this, metres.
const BLEND_M: f64 = 9e-3;
/// The same for links that are not neighbours in the tree, such as the two fingers at a web.
const WEB_BLEND_M: f64 = 4e-3;

/// A vertex of the skin.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinVertex {
    /// Links that carry it: position in each link's frame (metres) and weight. The weights sum to 1.
    pub bindings: Vec<(LinkId, Vector3<f64>, f64)>,
}

/// A closed triangle mesh that bends with the hand (linear blend skinning).
#[derive(Debug, Clone, PartialEq)]
pub struct Skin {
    /// Vertices.
    pub vertices: Vec<SkinVertex>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Whether the vertices are the hand's surface points, which pose corrections move as well: the skin of MANO.
    is_surface: bool,
}

impl Skin {
    /// Positions of the vertices on a posed hand, object frame, metres.
    ///
    /// # Panics
    /// If `posed` is not the hand this is the skin of, posed by [`Hand::pose`].
    pub fn pose(&self, posed: &PosedHand) -> Vec<Vector3<f64>> {
        if self.is_surface {
            assert_eq!(
                posed.points.len(),
                self.vertices.len(),
                "all points are posed"
            );
            return posed.points.clone();
        }
        let place = |vertex: &SkinVertex| {
            let parts = vertex.bindings.iter();
            parts
                .map(|(link, point, weight)| posed.object_from_link[link.0].point(point) * *weight)
                .sum()
        };
        self.vertices.iter().map(place).collect()
    }
}

impl Hand {
    /// The skin: the zero level set of a rounded union of the capsules with the fingers apart, extracted from a grid by
    /// surface nets (Gibson 1998). It takes a fraction of a second, so keep the result. A hand with meshes, boxes or
    /// cylinders, or of MANO, gives [`Hand::solid_skin`].
    pub fn skin(&self) -> Skin {
        if self.bends() || !self.meshes.is_empty() {
            return self.solid_skin();
        }
        let mut cast = PosedHand::default();
        self.pose(&crate::space::Pose::at_origin(&self.cast), &mut cast);
        let form = Form::new(self, &cast);
        let grid = Grid::sample(&form);
        let (points, triangles) = grid.surface_nets(&form);
        let neighbours = neighbours(self);
        let bind = |point: &Vector3<f64>| bind(self, &cast, &neighbours, point);
        Skin {
            vertices: points.iter().map(bind).collect(),
            triangles,
            is_surface: false,
        }
    }
}

impl Hand {
    /// The exact surface of the hand, used for measuring depths and for export: its parts (meshes, hulls of boxes and
    /// cylinders, capsules), each fixed to its link, or the mesh of MANO.
    pub fn solid_skin(&self) -> Skin {
        if let Some(blend) = &self.blend {
            let vertex = |vertex: &BlendVertex| SkinVertex {
                bindings: vertex.bindings.clone(),
            };
            return Skin {
                vertices: blend.vertices.iter().map(vertex).collect(),
                triangles: blend.triangles.clone(),
                is_surface: true,
            };
        }
        let capsules = self.capsules.iter().zip(&self.exact);
        let round = capsules.filter(|(_, exact)| **exact);
        let round = round.map(|(capsule, _)| capsule_mesh(capsule));
        Self::stiff(self.meshes.iter().cloned().chain(round))
    }

    /// The meshes of links and the hulls of their boxes and cylinders, in link frames (metres): [`Hand::solid_skin`] without
    /// the [exact capsules](Hand::exact_capsules).
    pub fn link_meshes(&self) -> impl Iterator<Item = (LinkId, &[Vector3<f64>], &[[u32; 3]])> {
        let meshes = self.meshes.iter();
        meshes.map(|mesh| (mesh.link, &mesh.vertices[..], &mesh.triangles[..]))
    }

    /// The capsules and balls that the description has; the others fill its meshes, boxes and cylinders.
    pub fn exact_capsules(&self) -> impl Iterator<Item = &Capsule> {
        let capsules = self.capsules.iter().zip(&self.exact);
        capsules.filter_map(|(capsule, exact)| exact.then_some(capsule))
    }

    /// The surface of a capsule as triangles, in the frame of its link.
    pub fn capsule_triangles(capsule: &Capsule) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
        let mesh = capsule_mesh(capsule);
        (mesh.vertices, mesh.triangles)
    }

    /// All capsules, each fixed to its link: the collision geometry.
    pub fn capsule_skin(&self) -> Skin {
        Self::stiff(self.capsules.iter().map(capsule_mesh))
    }

    fn stiff(meshes: impl Iterator<Item = LinkMesh>) -> Skin {
        let mut skin = Skin {
            vertices: Vec::new(),
            triangles: Vec::new(),
            is_surface: false,
        };
        for mesh in meshes {
            let first = u32::try_from(skin.vertices.len()).unwrap_or(u32::MAX);
            let vertex = |point: &Vector3<f64>| SkinVertex {
                bindings: vec![(mesh.link, *point, 1.0)],
            };
            skin.vertices.extend(mesh.vertices.iter().map(vertex));
            let corners = mesh.triangles.iter();
            skin.triangles
                .extend(corners.map(|t| t.map(|corner| corner.saturating_add(first))));
        }
        skin
    }
}

/// The posed capsules by digit, palm first.
struct Form {
    digits: Vec<Vec<([Vector3<f64>; 2], f64)>>,
}

impl Form {
    fn new(hand: &Hand, posed: &PosedHand) -> Self {
        let mut digits = vec![Vec::new(); hand.digits.len()];
        for (capsule, ends) in hand.capsules.iter().zip(&posed.capsules) {
            digits[hand.links[capsule.link.0].digit].push((*ends, capsule.radius_m));
        }
        Self { digits }
    }

    /// Signed distance, rounded where parts meet.
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        let union = |parts: &[([Vector3<f64>; 2], f64)], crease| {
            parts.iter().fold(f64::INFINITY, |union, (ends, radius)| {
                rounded_min(union, axis_distance(point, ends) - radius, crease)
            })
        };
        let palm = union(&self.digits[0], PALM_CREASE_M);
        self.digits[1..].iter().fold(palm, |hand, digit| {
            let digit = rounded_min(palm, union(digit, DIGIT_CREASE_M), ROOT_CREASE_M);
            hand.min(digit)
        })
    }

    fn gradient(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let step = 1e-5;
        Vector3::from_fn(|axis, _| {
            let offset = Vector3::ith(axis, step);
            (self.distance(&(point + offset)) - self.distance(&(point - offset))) / (2.0 * step)
        })
    }

    fn bounds(&self) -> [Vector3<f64>; 2] {
        let mut bounds = [
            Vector3::repeat(f64::INFINITY),
            Vector3::repeat(f64::NEG_INFINITY),
        ];
        for (ends, radius) in self.digits.iter().flatten() {
            for end in ends {
                bounds[0] = bounds[0].inf(&end.add_scalar(-radius));
                bounds[1] = bounds[1].sup(&end.add_scalar(*radius));
            }
        }
        bounds
    }
}

/// Minimum of two distances, lower by up to a quarter of `width` where they are equal, C¹ (Quilez's quadratic form).
fn rounded_min(a: f64, b: f64, width: f64) -> f64 {
    if (a - b).abs() >= width {
        return a.min(b);
    }
    let overlap = 1.0 - (a - b).abs() / width;
    a.min(b) - overlap * overlap * width / 4.0
}

struct Grid {
    origin: Vector3<f64>,
    cell_m: f64,
    size: [usize; 3],
    values: Vec<f64>,
}

impl Grid {
    /// Samples the signed distance with a positive margin, so that the skin closes.
    fn sample(form: &Form) -> Self {
        let [low, high] = form.bounds();
        let cell_m = (high - low).max() / CELLS;
        // Rounding adds at most a few quarters of a crease.
        let margin = (PALM_CREASE_M + ROOT_CREASE_M).min((high - low).max()) + 2.0 * cell_m;
        let origin = low.add_scalar(-margin);
        let mut size = [0; 3];
        for axis in 0..3 {
            let extent = high[axis] + margin - origin[axis];
            size[axis] = (2..1000)
                .find(|&n| (n - 1) as f64 * cell_m >= extent)
                .expect("extent and margins are at most 304 cells");
        }
        let mut grid = Self {
            origin,
            cell_m,
            size,
            values: Vec::with_capacity(size.iter().product()),
        };
        for k in 0..size[2] {
            for j in 0..size[1] {
                for i in 0..size[0] {
                    grid.values.push(form.distance(&grid.corner([i, j, k])));
                }
            }
        }
        grid
    }

    fn index(&self, at: [usize; 3]) -> usize {
        (at[2] * self.size[1] + at[1]) * self.size[0] + at[0]
    }

    fn corner(&self, at: [usize; 3]) -> Vector3<f64> {
        self.origin + Vector3::new(at[0] as f64, at[1] as f64, at[2] as f64) * self.cell_m
    }

    /// Places one vertex, moved onto the surface, in each cell that the surface crosses, and one quadrilateral around each
    /// crossed edge.
    fn surface_nets(&self, form: &Form) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
        let mut points = Vec::new();
        let mut vertex_of_cell = vec![u32::MAX; self.values.len()];
        for k in 0..self.size[2] - 1 {
            for j in 0..self.size[1] - 1 {
                for i in 0..self.size[0] - 1 {
                    if let Some(point) = self.cell_vertex([i, j, k]) {
                        vertex_of_cell[self.index([i, j, k])] = u32::try_from(points.len())
                            .expect("a skin has far fewer than 2³² vertices");
                        points.push(onto(form, point, self.cell_m / 2.0));
                    }
                }
            }
        }
        let mut triangles = Vec::new();
        for k in 1..self.size[2] - 1 {
            for j in 1..self.size[1] - 1 {
                for i in 1..self.size[0] - 1 {
                    for axis in 0..3 {
                        let at = [i, j, k];
                        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                        let mut next = at;
                        next[axis] += 1;
                        let inside = self.values[self.index(at)] < 0.0;
                        if inside == (self.values[self.index(next)] < 0.0) {
                            continue;
                        }
                        let cell = |db: usize, dc: usize| {
                            let mut cell = at;
                            cell[b] -= db;
                            cell[c] -= dc;
                            vertex_of_cell[self.index(cell)]
                        };
                        let mut quad = [cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)];
                        if !inside {
                            quad.reverse();
                        }
                        triangles.push([quad[0], quad[1], quad[2]]);
                        triangles.push([quad[0], quad[2], quad[3]]);
                    }
                }
            }
        }
        (points, triangles)
    }

    /// Mean of the points where the surface crosses the edges of a cell.
    fn cell_vertex(&self, cell: [usize; 3]) -> Option<Vector3<f64>> {
        let corner = |bits: usize| {
            [
                cell[0] + (bits & 1),
                cell[1] + (bits >> 1 & 1),
                cell[2] + (bits >> 2 & 1),
            ]
        };
        let value = |bits: usize| self.values[self.index(corner(bits))];
        let (mut sum, mut count) = (Vector3::zeros(), 0.0);
        for low in 0..8 {
            for high in [low | 1, low | 2, low | 4] {
                if high != low && (value(low) < 0.0) != (value(high) < 0.0) {
                    let t = value(low) / (value(low) - value(high));
                    sum += self.corner(corner(low)).lerp(&self.corner(corner(high)), t);
                    count += 1.0;
                }
            }
        }
        (count > 0.0).then(|| sum / count)
    }
}

/// Moves a point onto the surface, by at most `reach_m`.
fn onto(form: &Form, start: Vector3<f64>, reach_m: f64) -> Vector3<f64> {
    let mut point = start;
    for _ in 0..3 {
        let gradient = form.gradient(&point);
        let step = gradient * (form.distance(&point) / gradient.norm_squared().max(0.25));
        point -= step;
    }
    let way = point - start;
    start + way * (reach_m / way.norm().max(1e-12)).min(1.0)
}

/// For each link with geometry: itself and the links with geometry next to it in the tree.
fn neighbours(hand: &Hand) -> Vec<Vec<usize>> {
    let solid = |l: usize| hand.capsules.iter().any(|capsule| capsule.link.0 == l);
    let mut neighbours: Vec<Vec<usize>> = (0..hand.links.len()).map(|l| vec![l]).collect();
    for l in (0..hand.links.len()).filter(|&l| solid(l)) {
        let mut above = hand.links[l].parent;
        while let Some(parent) = above.filter(|parent| !solid(parent.0)) {
            above = hand.links[parent.0].parent;
        }
        if let Some(parent) = above {
            neighbours[l].push(parent.0);
            neighbours[parent.0].push(l);
        }
    }
    neighbours
}

/// Binds a point to links; weights fall smoothly with the distance beyond the nearest link.
fn bind(
    hand: &Hand,
    cast: &PosedHand,
    neighbours: &[Vec<usize>],
    point: &Vector3<f64>,
) -> SkinVertex {
    let mut distances = vec![f64::INFINITY; hand.links.len()];
    for (Capsule { link, radius_m, .. }, ends) in hand.capsules.iter().zip(&cast.capsules) {
        let distance = axis_distance(point, ends) - radius_m;
        distances[link.0] = distances[link.0].min(distance);
    }
    let nearest = (0..distances.len())
        .min_by(|&a, &b| distances[a].total_cmp(&distances[b]))
        .expect("a hand has links");
    let weight = |l: usize| {
        let reach = if neighbours[nearest].contains(&l) {
            BLEND_M
        } else {
            WEB_BLEND_M
        };
        (1.0 - (distances[l] - distances[nearest]) / reach)
            .max(0.0)
            .powi(2)
    };
    let carriers: Vec<usize> = (0..distances.len()).filter(|&l| weight(l) > 0.0).collect();
    let total: f64 = carriers.iter().map(|&l| weight(l)).sum();
    let local = |l: usize| -> Vector3<f64> {
        let frame: &Frame = &cast.object_from_link[l];
        frame.inverse_point(point)
    };
    SkinVertex {
        bindings: carriers
            .iter()
            .map(|&l| (LinkId(l), local(l), weight(l) / total))
            .collect(),
    }
}
