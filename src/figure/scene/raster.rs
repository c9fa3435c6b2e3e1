//! The depth buffer of a scene: one opaque layer of surfaces and two translucent layers of cones and markers.

use nalgebra::Vector3;

use super::{Camera, Marker};

/// The point nearest to the eye at a pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    /// Depth toward the eye in pixels; −∞ if the pixel is empty.
    pub(super) depth: f64,
    pub(super) colour: [f64; 3],
    /// Number of the surface.
    pub(super) owner: usize,
}

/// Layer of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layer {
    Surface,
    Cone,
}

#[derive(Debug)]
pub(super) struct Raster {
    pub(super) width: u32,
    pub(super) height: u32,
    camera: Camera,
    pixels_per_m: f64,
    pub(super) surface: Vec<Nearest>,
    pub(super) cone: Vec<Nearest>,
    pub(super) marker: Vec<Nearest>,
}

impl Raster {
    pub(super) fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let empty = Nearest {
            depth: f64::NEG_INFINITY,
            colour: [255.0; 3],
            owner: 0,
        };
        let count = width as usize * height as usize;
        Self {
            width,
            height,
            camera: *camera,
            pixels_per_m: 0.5 * f64::from(width.min(height)) / camera.half_extent_m,
            surface: vec![empty; count],
            cone: vec![empty; count],
            marker: vec![empty; count],
        }
    }

    /// Column, row (downward) and depth toward the eye, all in pixels.
    pub(super) fn pixel_from_object(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let seen =
            self.pixels_per_m * (self.camera.view_from_object * (point - self.camera.target));
        Vector3::new(
            0.5 * f64::from(self.width) + seen.x,
            0.5 * f64::from(self.height) - seen.y,
            seen.z,
        )
    }

    /// Range of pixels whose centres may lie between `low` and `high`.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the image first"
    )]
    fn range(low: f64, high: f64, size: u32) -> std::ops::Range<u32> {
        let clamp = |value: f64| value.clamp(0.0, f64::from(size)) as u32;
        clamp((low - 0.5).ceil())..clamp((high + 0.5).floor())
    }

    fn index(&self, column: u32, row: u32) -> usize {
        row as usize * self.width as usize + column as usize
    }

    pub(super) fn triangle(
        &mut self,
        layer: Layer,
        corners: &[Vector3<f64>; 3],
        normals: &[Vector3<f64>; 3],
        colour: [f64; 3],
        owner: usize,
    ) {
        let [a, b, c] = corners;
        let area = (b - a).xy().perp(&(c - a).xy());
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let span = |axis: usize| {
            let values = [a[axis], b[axis], c[axis]];
            (
                values.iter().copied().fold(f64::INFINITY, f64::min),
                values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            )
        };
        let ((left, right), (top, bottom)) = (span(0), span(1));
        for row in Self::range(top, bottom, self.height) {
            for column in Self::range(left, right, self.width) {
                let at = nalgebra::Vector2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
                let (weight_b, weight_c) = (
                    (at - a.xy()).perp(&(c - a).xy()) / area,
                    (b - a).xy().perp(&(at - a.xy())) / area,
                );
                let weight_a = 1.0 - weight_b - weight_c;
                if weight_a < 0.0 || weight_b < 0.0 || weight_c < 0.0 {
                    continue;
                }
                let depth = weight_a * a.z + weight_b * b.z + weight_c * c.z;
                let index = self.index(column, row);
                let nearest = match layer {
                    Layer::Surface => &mut self.surface[index],
                    Layer::Cone => &mut self.cone[index],
                };
                if depth > nearest.depth {
                    let normal =
                        weight_a * normals[0] + weight_b * normals[1] + weight_c * normals[2];
                    *nearest = Nearest {
                        depth,
                        colour: shade(colour, &normal),
                        owner,
                    };
                }
            }
        }
    }

    pub(super) fn sphere(&mut self, marker: &Marker) {
        let centre = self.pixel_from_object(&marker.centre);
        let radius = marker.radius_m * self.pixels_per_m;
        let colour = marker.colour.map(f64::from);
        for row in Self::range(centre.y - radius, centre.y + radius, self.height) {
            for column in Self::range(centre.x - radius, centre.x + radius, self.width) {
                let (x, y) = (
                    f64::from(column) + 0.5 - centre.x,
                    centre.y - f64::from(row) - 0.5,
                );
                let square = radius * radius - x * x - y * y;
                if square < 0.0 {
                    continue;
                }
                let normal = Vector3::new(x, y, square.sqrt()) / radius;
                let index = self.index(column, row);
                let depth = centre.z + square.sqrt();
                if depth > self.marker[index].depth {
                    self.marker[index] = Nearest {
                        depth,
                        colour: shade(colour, &normal),
                        owner: 0,
                    };
                }
            }
        }
    }
}

/// Lambert shading in view coordinates: a main light from the upper left, a weaker one from the right, and some ambient
/// light. Back faces are lit like front faces, so that open meshes do not show holes.
fn shade(colour: [f64; 3], normal: &Vector3<f64>) -> [f64; 3] {
    let normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
    let normal = if normal.z < 0.0 { -normal } else { normal };
    let light = |x: f64, y: f64, z: f64| normal.dot(&Vector3::new(x, y, z).normalize()).max(0.0);
    let strength = 0.45 + 0.56 * light(-0.45, 0.6, 0.8) + 0.18 * light(0.8, -0.1, 0.5);
    colour.map(|channel| (channel * strength).min(255.0))
}
