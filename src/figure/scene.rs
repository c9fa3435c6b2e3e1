//! Shaded pictures of hands and objects: a small z-buffer renderer.
//!
//! Hand and object interpenetrate where they touch, so triangles cannot be sorted; a z-buffer decides by the pixel.

use nalgebra::{Rotation3, Vector3};

/// Red, green, blue, 0..=255.
pub type Colour = [u8; 3];

/// An RGB picture, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Three bytes a pixel.
    pub rgb: Vec<u8>,
}

/// A triangle mesh in one colour.
#[derive(Debug, Clone)]
struct Surface {
    vertices: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
    colour: Colour,
}

/// Meshes to be drawn together.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    surfaces: Vec<Surface>,
}

/// Samples a pixel along each side.
const OVERSAMPLING: usize = 2;
/// Share of the light that comes from everywhere, and of the light from behind the viewer's left shoulder.
const AMBIENT: f64 = 0.35;
const KEY: f64 = 0.55;
const FILL: f64 = 0.25;

impl Scene {
    /// An empty scene.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a mesh, shaded smoothly.
    pub fn mesh(
        &mut self,
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
        colour: Colour,
    ) -> &mut Self {
        let mut normals = vec![Vector3::zeros(); vertices.len()];
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|index| vertices[index as usize]);
            // The cross product is as long as twice the area: large triangles count more.
            let normal = (b - a).cross(&(c - a));
            for &index in triangle {
                normals[index as usize] += normal;
            }
        }
        for normal in &mut normals {
            *normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
        }
        self.surfaces.push(Surface {
            vertices,
            normals,
            triangles,
            colour,
        });
        self
    }

    /// Adds a small ball, for instance at a contact.
    pub fn ball(&mut self, centre: &Vector3<f64>, radius_m: f64, colour: Colour) -> &mut Self {
        const RINGS: u32 = 8;
        const SECTORS: u32 = 12;
        let mut vertices = Vec::new();
        for ring in 0..=RINGS {
            let polar = std::f64::consts::PI * f64::from(ring) / f64::from(RINGS);
            for sector in 0..SECTORS {
                let azimuth = std::f64::consts::TAU * f64::from(sector) / f64::from(SECTORS);
                let direction = Vector3::new(
                    polar.sin() * azimuth.cos(),
                    polar.sin() * azimuth.sin(),
                    polar.cos(),
                );
                vertices.push(centre + direction * radius_m);
            }
        }
        let mut triangles = Vec::new();
        for ring in 0..RINGS {
            for sector in 0..SECTORS {
                let next = (sector + 1) % SECTORS;
                let (a, b) = (ring * SECTORS + sector, ring * SECTORS + next);
                let (c, d) = (a + SECTORS, b + SECTORS);
                triangles.push([a, c, b]);
                triangles.push([b, c, d]);
            }
        }
        self.mesh(vertices, triangles, colour)
    }

    /// Renders the scene seen against `direction` (from the viewer into the scene) with `up` upward, framed to fit, on
    /// white.
    ///
    /// # Panics
    /// If `direction` and `up` are parallel or the picture has no pixels.
    pub fn render(
        &self,
        direction: &Vector3<f64>,
        up: &Vector3<f64>,
        width: usize,
        height: usize,
    ) -> Image {
        assert!(width > 0 && height > 0, "a picture has pixels");
        let view = view_from_scene(direction, up);
        let buffer = Buffer::fill(self, &view, width * OVERSAMPLING, height * OVERSAMPLING);
        let mut rgb = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            for x in 0..width {
                for channel in 0..3 {
                    let mut sum = 0u32;
                    for dy in 0..OVERSAMPLING {
                        for dx in 0..OVERSAMPLING {
                            let at = (y * OVERSAMPLING + dy) * width * OVERSAMPLING
                                + x * OVERSAMPLING
                                + dx;
                            sum += u32::from(buffer.colours[at][channel]);
                        }
                    }
                    let samples = u32::try_from(OVERSAMPLING * OVERSAMPLING).unwrap_or(1);
                    rgb.push(u8::try_from(sum / samples).unwrap_or(u8::MAX));
                }
            }
        }
        Image { width, height, rgb }
    }

    /// The direction, among 26 around the scene, that shows most of the surfaces with colour `wanted` (contacts, say),
    /// and among those that show equally much, most of the first mesh.
    pub fn best_direction(&self, up: &Vector3<f64>, wanted: Colour) -> Vector3<f64> {
        const SIZE: usize = 96;
        let mut best = (0usize, 0usize, Vector3::x());
        for x in -1..=1 {
            for y in -1..=1 {
                for z in -1..=1 {
                    let direction = Vector3::new(f64::from(x), f64::from(y), f64::from(z));
                    if direction.cross(up).norm() < 1e-9 {
                        continue;
                    }
                    let view = view_from_scene(&direction, up);
                    let buffer = Buffer::fill(self, &view, SIZE, SIZE);
                    let count = |test: &dyn Fn(usize) -> bool| {
                        buffer.surfaces.iter().flatten().filter(|&&s| test(s)).count()
                    };
                    let shown = count(&|s| self.surfaces[s].colour == wanted);
                    let first = count(&|s| s == 0);
                    if (shown, first) > (best.0, best.1) {
                        best = (shown, first, direction);
                    }
                }
            }
        }
        best.2.normalize()
    }
}

/// Rotation into the viewer's frame: x right, y up, z toward the viewer.
fn view_from_scene(direction: &Vector3<f64>, up: &Vector3<f64>) -> Rotation3<f64> {
    let z = -direction.normalize();
    let x = up.cross(&z).normalize();
    let y = z.cross(&x);
    Rotation3::from_basis_unchecked(&[x, y, z]).inverse()
}

struct Buffer {
    colours: Vec<Colour>,
    surfaces: Vec<Option<usize>>,
}

impl Buffer {
    fn fill(scene: &Scene, view: &Rotation3<f64>, width: usize, height: usize) -> Self {
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = Vector3::repeat(f64::NEG_INFINITY);
        for vertex in scene.surfaces.iter().flat_map(|s| &s.vertices) {
            let seen = view * vertex;
            low = low.inf(&seen);
            high = high.sup(&seen);
        }
        let mut buffer = Self {
            colours: vec![[255; 3]; width * height],
            surfaces: vec![None; width * height],
        };
        if low.x > high.x {
            return buffer;
        }
        let extent = high - low;
        let scale = 0.94 * (width as f64 / extent.x.max(1e-9)).min(height as f64 / extent.y.max(1e-9));
        let middle = (low + high) * 0.5;
        let mut depths = vec![f64::NEG_INFINITY; width * height];
        for (number, surface) in scene.surfaces.iter().enumerate() {
            let pixels: Vec<Vector3<f64>> = surface
                .vertices
                .iter()
                .map(|vertex| {
                    let seen = view * vertex - middle;
                    Vector3::new(
                        0.5 * width as f64 + scale * seen.x,
                        0.5 * height as f64 - scale * seen.y,
                        seen.z,
                    )
                })
                .collect();
            let light: Vec<f64> = surface.normals.iter().map(|n| brightness(&(view * n))).collect();
            for triangle in &surface.triangles {
                let corners = triangle.map(|index| pixels[index as usize]);
                let lights = triangle.map(|index| light[index as usize]);
                for_each_pixel(&corners, width, height, |at, weights| {
                    let depth: f64 = weights.iter().zip(&corners).map(|(w, c)| w * c.z).sum();
                    if depth > depths[at] {
                        depths[at] = depth;
                        let bright: f64 = weights.iter().zip(&lights).map(|(w, l)| w * l).sum();
                        buffer.colours[at] = surface.colour.map(|c| shade(c, bright));
                        buffer.surfaces[at] = Some(number);
                    }
                });
            }
        }
        buffer
    }
}

/// Two-light Lambert shading of a normal in the viewer's frame.
fn brightness(normal: &Vector3<f64>) -> f64 {
    let key = Vector3::new(-0.4, 0.5, 0.77).dot(normal).max(0.0);
    let fill = Vector3::new(0.7, -0.1, 0.7).dot(normal).max(0.0);
    AMBIENT + KEY * key + FILL * fill
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to a byte first"
)]
fn shade(colour: u8, bright: f64) -> u8 {
    (f64::from(colour) * bright).clamp(0.0, 255.0) as u8
}

/// Calls `visit` with each pixel whose centre lies in the triangle and its barycentric weights.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "pixel numbers are clamped to the picture first"
)]
fn for_each_pixel(
    corners: &[Vector3<f64>; 3],
    width: usize,
    height: usize,
    mut visit: impl FnMut(usize, [f64; 3]),
) {
    let [a, b, c] = corners;
    let area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if area.abs() < 1e-12 {
        return;
    }
    let range = |values: [f64; 3], limit: usize| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let clamp = |v: f64| v.clamp(0.0, limit as f64) as usize;
        clamp(low.floor())..clamp(high.ceil())
    };
    for y in range([a.y, b.y, c.y], height) {
        for x in range([a.x, b.x, c.x], width) {
            let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
            let weight = |p: &Vector3<f64>, q: &Vector3<f64>| {
                ((p.x - px) * (q.y - py) - (q.x - px) * (p.y - py)) / area
            };
            let weights = [weight(b, c), weight(c, a), weight(a, b)];
            if weights.iter().all(|w| *w >= 0.0) {
                visit(y * width + x, weights);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearer_surfaces_hide_farther_ones() {
        let red = [200, 0, 0];
        let blue = [0, 0, 200];
        let mut scene = Scene::new();
        scene.ball(&Vector3::zeros(), 1.0, red);
        scene.ball(&Vector3::new(0.0, -1.2, 0.0), 0.5, blue);
        let from_front = scene.render(&Vector3::y(), &Vector3::z(), 40, 40);
        let middle = &from_front.rgb[3 * (20 * 40 + 20)..][..3];
        assert!(middle[2] > middle[0], "{middle:?}");
        let from_behind = scene.render(&-Vector3::y(), &Vector3::z(), 40, 40);
        let middle = &from_behind.rgb[3 * (20 * 40 + 20)..][..3];
        assert!(middle[0] > middle[2], "{middle:?}");
        let seen = scene.best_direction(&Vector3::z(), blue);
        assert!(seen.y > 0.0, "{seen:?}");
    }

    #[test]
    fn an_empty_scene_is_white() {
        let image = Scene::new().render(&Vector3::y(), &Vector3::z(), 3, 2);
        assert_eq!(image.rgb, vec![255; 18]);
    }
}
