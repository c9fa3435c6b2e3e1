//! Convex hulls, which replace meshes, boxes and cylinders as contact geometry, as in `MuJoCo`.

use nalgebra::Vector3;
use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::transformation::try_convex_hull;

use super::LinkId;

/// π (3 − √5), radians.
pub(super) const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Number of directions that reduce a mesh with more vertices: only the outermost vertex in each direction is kept.
/// On a ball of 10 mm this loses 0.02 mm.
const DIRECTIONS: u32 = 1024;

/// A convex solid fixed to a link; link frame, metres.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Hull {
    pub(super) link: LinkId,
    pub(super) vertices: Vec<Vector3<f64>>,
    /// Counter-clockwise seen from outside.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Unit outward normals n and offsets d of the bounding planes n·p = d.
    planes: Vec<(Vector3<f64>, f64)>,
    centre: Vector3<f64>,
    radius_m: f64,
}

impl Hull {
    /// The hull of some points; `None` if they have no volume.
    pub(super) fn of(link: LinkId, points: &[Vector3<f64>]) -> Option<Self> {
        let points = outermost(points);
        let (low, high) = points.iter().fold(
            (
                Vector3::repeat(f64::INFINITY),
                Vector3::repeat(f64::NEG_INFINITY),
            ),
            |(low, high), p| (low.inf(p), high.sup(p)),
        );
        let size = (high - low).norm();
        if !(size.is_finite() && size > 0.0) {
            return None;
        }
        let centre = low.lerp(&high, 0.5);
        // Points scaled to size 1 and centred at the origin.
        let normed: Vec<ParryVector> = points
            .iter()
            .map(|p| (p - centre) / size)
            .map(|p| ParryVector::new(p.x, p.y, p.z))
            .collect();
        let (vertices, triangles) = try_convex_hull(&normed).ok()?;
        let vertices: Vec<Vector3<f64>> = vertices
            .iter()
            .map(|v| centre + Vector3::new(v.x, v.y, v.z) * size)
            .collect();
        let triangles: Vec<[u32; 3]> = triangles
            .into_iter()
            .filter(|corners| corners.iter().all(|&v| (v as usize) < vertices.len()))
            .collect();
        let corners = |t: &[u32; 3]| t.map(|v| vertices[v as usize] - centre);
        let volume: f64 = triangles
            .iter()
            .map(corners)
            .map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0)
            .sum();
        if volume < 1e-6 * size.powi(3) {
            return None;
        }
        let mut planes: Vec<(Vector3<f64>, f64)> = Vec::new();
        for [a, b, c] in triangles.iter().map(corners) {
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-9 * size * size) else {
                continue;
            };
            if planes
                .iter()
                .any(|(known, _)| known.dot(&normal) > 1.0 - 1e-10)
            {
                continue;
            }
            // The plane touches the outermost vertex, since the normal of a sliver may be slightly off.
            let reach = vertices.iter().map(|v| normal.dot(v));
            planes.push((normal, reach.fold(f64::NEG_INFINITY, f64::max)));
        }
        let radius_m = vertices.iter().map(|v| (v - centre).norm());
        Some(Self {
            link,
            radius_m: radius_m.fold(0.0, f64::max),
            vertices,
            triangles,
            planes,
            centre,
        })
    }

    /// Depth of a point (link frame) inside the hull: the distance to the nearest bounding plane, negative outside.
    pub(super) fn depth(&self, point: &Vector3<f64>) -> f64 {
        let outside = (point - self.centre).norm() - self.radius_m;
        if outside > 0.0 {
            return -outside;
        }
        self.planes
            .iter()
            .map(|(normal, offset)| offset - normal.dot(point))
            .fold(f64::INFINITY, f64::min)
    }

    pub(super) fn volume_m3(&self) -> f64 {
        let corners = |t: &[u32; 3]| self.corners(t).map(|corner| corner - self.centre);
        let signed = self.triangles.iter().map(corners);
        signed.map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
    }

    /// Whether another hull lies in this one.
    pub(super) fn holds(&self, other: &Self) -> bool {
        let rounding_m = 1e-9 * self.radius_m;
        (other.vertices.iter()).all(|vertex| self.depth(vertex) >= -rounding_m)
    }

    pub(super) fn area_m2(&self) -> f64 {
        self.triangles
            .iter()
            .map(|t| self.doubled(t).norm())
            .sum::<f64>()
            / 2.0
    }

    pub(super) fn corners(&self, triangle: &[u32; 3]) -> [Vector3<f64>; 3] {
        triangle.map(|v| self.vertices[v as usize])
    }

    /// Outward normal of a triangle, with twice its area as length.
    pub(super) fn doubled(&self, triangle: &[u32; 3]) -> Vector3<f64> {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(&(c - a))
    }

    /// Lower and upper corner of the bounding box along the axes of the link.
    pub(super) fn bounds(&self) -> [Vector3<f64>; 2] {
        let first = self.vertices.first().copied().unwrap_or_default();
        self.vertices
            .iter()
            .fold([first, first], |[low, high], v| [low.inf(v), high.sup(v)])
    }
}

/// Point number `k` of an evenly spread sequence in a triangle: Roberts' sequence in the unit square, folded.
pub(super) fn in_triangle([a, b, c]: [Vector3<f64>; 3], k: f64) -> Vector3<f64> {
    let (mut u, mut v) = (
        (k * 0.754_877_666_246_692_8_f64).fract(),
        (k * 0.569_840_290_998_053_2_f64).fract(),
    );
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    a + (b - a) * u + (c - a) * v
}

/// Unit vectors spread evenly over the sphere.
pub(super) fn directions(count: u32) -> impl Iterator<Item = Vector3<f64>> {
    (0..count).map(move |k| {
        let height = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
        let (sin, cos) = libm::sincos(f64::from(k) * GOLDEN_ANGLE);
        let across = (1.0 - height * height).sqrt();
        Vector3::new(across * cos, across * sin, height)
    })
}

fn outermost(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    if points.len() <= DIRECTIONS as usize {
        return points.to_vec();
    }
    let axes: [Vec<f64>; 3] = [0, 1, 2].map(|axis| points.iter().map(|p| p[axis]).collect());
    let mut heights = vec![0.0; points.len()];
    let mut chosen: Vec<usize> = directions(DIRECTIONS)
        .filter_map(|direction| {
            let [x, y, z] = &axes;
            for (((height, x), y), z) in heights.iter_mut().zip(x).zip(y).zip(z) {
                *height = direction.x * x + direction.y * y + direction.z * z;
            }
            let highest = highest(&heights);
            heights.iter().rposition(|&height| height >= highest)
        })
        .collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().map(|index| points[index]).collect()
}

/// The largest of some numbers, computed eight at a time.
fn highest(numbers: &[f64]) -> f64 {
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let (eights, rest) = numbers.as_chunks::<8>();
    let mut lanes = [f64::NEG_INFINITY; 8];
    for eight in eights {
        for (lane, &number) in lanes.iter_mut().zip(eight) {
            *lane = larger(*lane, number);
        }
    }
    lanes
        .iter()
        .chain(rest)
        .fold(f64::NEG_INFINITY, |a, &b| larger(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_of_points_is_a_box() {
        let points: Vec<_> = (0..27u32)
            .map(|k| Vector3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)) * 0.01)
            .collect();
        let hull = Hull::of(LinkId(0), &points).unwrap();
        assert_eq!(hull.planes.len(), 6);
        assert!((hull.area_m2() - 6.0 * 0.02f64.powi(2)).abs() < 1e-12);
        let depth = |x: f64, y: f64, z: f64| hull.depth(&Vector3::new(x, y, z));
        assert!((depth(0.01, 0.01, 0.003) - 0.003).abs() < 1e-12);
        assert!((depth(0.01, 0.01, 0.021) + 0.001).abs() < 1e-9);
        assert!(depth(1.0, 0.0, 0.0) < -0.5);
    }

    #[test]
    fn many_points_lose_little_and_flat_ones_are_nothing() {
        let ball: Vec<_> = directions(50_000).map(|d| d * 0.01).collect();
        let hull = Hull::of(LinkId(0), &ball).unwrap();
        assert!(hull.vertices.len() <= DIRECTIONS as usize);
        let worst = directions(500)
            .map(|d| hull.depth(&(d * 0.01)).abs())
            .fold(0.0, f64::max);
        assert!(worst < 4e-5, "{worst} m");
        let flat: Vec<_> = ball.iter().map(|p| Vector3::new(p.x, p.y, 0.0)).collect();
        assert!(Hull::of(LinkId(0), &flat).is_none());
    }
}
