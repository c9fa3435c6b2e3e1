//! Rendered grasps: triangle meshes and contact markers, drawn with a depth buffer.
//!
//! Hand and object touch and penetrate each other, so triangles cannot be sorted. Every pixel keeps its nearest surface.

use nalgebra::Vector3;

use super::image::Image;
use super::theme::byte;

mod camera;
mod cone;
mod glb;
mod grasp;
mod raster;
mod usda;

pub use camera::Camera;
pub use cone::Cone;
use raster::{Layer, Raster};

/// Factor by which pixels are finer in each direction before averaging.
const SUPERSAMPLING: u32 = 2;
/// Faces that meet at a sharper angle than this keep their edge (cosine of 40°).
const CREASE: f64 = 0.766;
/// Share of a marker's colour that shows through a surface that covers it.
const SHINE_THROUGH: f64 = 0.45;
/// A triangle mesh in one colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Vertices, object frame, metres.
    pub vertices: Vec<Vector3<f64>>,
    /// Corners of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Red, green, blue.
    pub colour: [u8; 3],
}

/// A small sphere at a contact. It shines through surfaces that cover it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marker {
    /// Centre, object frame, metres.
    pub centre: Vector3<f64>,
    /// Radius, metres.
    pub radius_m: f64,
    /// Red, green, blue.
    pub colour: [u8; 3],
}

/// Objects to render.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// Meshes, the hand first. Viewpoints are chosen to show much of it.
    pub surfaces: Vec<Surface>,
    /// Contacts.
    pub markers: Vec<Marker>,
    /// Friction cones, see [`Scene::with_friction_cones`].
    pub cones: Vec<Cone>,
}

impl Scene {
    /// Renders an image of `width` × `height` pixels on white.
    pub fn render(&self, camera: &Camera, width: u32, height: u32) -> Image {
        let normals: Vec<Vec<[Vector3<f64>; 3]>> =
            self.surfaces.iter().map(Surface::corner_normals).collect();
        let raster = self.raster(
            camera,
            width * SUPERSAMPLING,
            height * SUPERSAMPLING,
            &normals,
        );
        let mut rgb = Vec::with_capacity(raster.surface.len() * 3);
        let layers = raster.surface.iter().zip(&raster.cone).zip(&raster.marker);
        for ((surface, cone), marker) in layers {
            let veil = if cone.depth >= surface.depth {
                cone::COVERING
            } else {
                cone::SHINING
            };
            let shine = if marker.depth >= surface.depth {
                1.0
            } else {
                SHINE_THROUGH
            };
            for channel in 0..3 {
                let mut colour = surface.colour[channel];
                for (layer, share) in [(cone, veil), (marker, shine)] {
                    if layer.depth > f64::NEG_INFINITY {
                        colour += share * (layer.colour[channel] - colour);
                    }
                }
                rgb.push(byte(colour));
            }
        }
        Image {
            width: raster.width,
            height: raster.height,
            rgb,
        }
        .reduced(SUPERSAMPLING)
    }

    fn raster(
        &self,
        camera: &Camera,
        width: u32,
        height: u32,
        normals: &[Vec<[Vector3<f64>; 3]>],
    ) -> Raster {
        let mut raster = Raster::new(camera, width, height);
        for (owner, (surface, normals)) in self.surfaces.iter().zip(normals).enumerate() {
            let colour = surface.colour.map(f64::from);
            let vertices: Vec<Vector3<f64>> = surface
                .vertices
                .iter()
                .map(|vertex| raster.pixel_from_object(vertex))
                .collect();
            for (triangle, normals) in surface.triangles.iter().zip(normals) {
                let corners = triangle.map(|corner| vertices[corner as usize]);
                let normals = normals.map(|normal| camera.view_from_object * normal);
                raster.triangle(Layer::Surface, &corners, &normals, colour, owner);
            }
        }
        for cone in &self.cones {
            let colour = cone.colour.map(f64::from);
            for [corners, normals] in cone.triangles() {
                let corners = corners.map(|corner| raster.pixel_from_object(&corner));
                let normals = normals.map(|normal| camera.view_from_object * normal);
                raster.triangle(Layer::Cone, &corners, &normals, colour, 0);
            }
        }
        for marker in &self.markers {
            raster.sphere(marker);
        }
        raster
    }
}

impl Surface {
    /// Unit normal at each corner of each triangle. It is the sum of the area vectors of those faces around the vertex that
    /// turn less than [`CREASE`] away from the triangle. Vertices in the same place count as one, so that a file that lists
    /// the corners of every triangle separately is smooth as well.
    fn corner_normals(&self) -> Vec<[Vector3<f64>; 3]> {
        let key = |vertex: &Vector3<f64>| {
            [vertex.x, vertex.y, vertex.z].map(|value| (value + 0.0).to_bits())
        };
        let mut order: Vec<usize> = (0..self.vertices.len()).collect();
        order.sort_by_key(|&vertex| (key(&self.vertices[vertex]), vertex));
        let mut same = vec![0; self.vertices.len()];
        for pair in 0..order.len() {
            let vertex = order[pair];
            let before = order[pair.saturating_sub(1)];
            same[vertex] = if pair > 0 && key(&self.vertices[vertex]) == key(&self.vertices[before])
            {
                same[before]
            } else {
                vertex
            };
        }
        let areas: Vec<Vector3<f64>> = self
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|corner| self.vertices[corner as usize]);
                (b - a).cross(&(c - a))
            })
            .collect();
        let mut around = vec![Vec::new(); self.vertices.len()];
        for (face, triangle) in self.triangles.iter().enumerate() {
            for &corner in triangle {
                around[same[corner as usize]].push(face);
            }
        }
        let units: Vec<Vector3<f64>> = areas
            .iter()
            .map(|area| area.try_normalize(0.0).unwrap_or_else(Vector3::zeros))
            .collect();
        self.triangles
            .iter()
            .enumerate()
            .map(|(face, triangle)| {
                triangle.map(|corner| {
                    around[same[corner as usize]]
                        .iter()
                        .filter(|&&other| units[other].dot(&units[face]) > CREASE)
                        .map(|&other| areas[other])
                        .sum::<Vector3<f64>>()
                        .try_normalize(0.0)
                        .unwrap_or(units[face])
                })
            })
            .collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::mesh::testing::CUBE;

    /// A sphere of 2 · rings · rings triangles.
    pub(super) fn ball(centre: Vector3<f64>, radius: f64, colour: [u8; 3], rings: u32) -> Surface {
        let mut vertices = Vec::new();
        for ring in 0..=rings {
            for step in 0..=rings {
                let (polar, around) = (
                    std::f64::consts::PI * f64::from(ring) / f64::from(rings),
                    std::f64::consts::TAU * f64::from(step % rings) / f64::from(rings),
                );
                let normal = Vector3::new(
                    libm::sin(polar) * libm::cos(around),
                    libm::sin(polar) * libm::sin(around),
                    libm::cos(polar),
                );
                vertices.push(centre + radius * normal);
            }
        }
        let at = |ring: u32, step: u32| ring * (rings + 1) + step;
        let triangles = (0..rings)
            .flat_map(|ring| {
                (0..rings).flat_map(move |step| {
                    let (a, b) = (at(ring, step), at(ring, step + 1));
                    let (c, d) = (at(ring + 1, step), at(ring + 1, step + 1));
                    [[a, c, d], [a, d, b]]
                })
            })
            .collect();
        Surface {
            vertices,
            triangles,
            colour,
        }
    }

    pub(super) fn cuboid(half: Vector3<f64>, colour: [u8; 3]) -> Surface {
        let vertices = (0..8)
            .map(|corner| {
                Vector3::from_fn(|axis, _| {
                    if corner >> axis & 1 == 1 {
                        half[axis]
                    } else {
                        -half[axis]
                    }
                })
            })
            .collect();
        Surface {
            vertices,
            triangles: CUBE.to_vec(),
            colour,
        }
    }

    pub(super) fn pixel(image: &Image, column: u32, row: u32) -> [u8; 3] {
        let first = ((row * image.width + column) * 3) as usize;
        [image.rgb[first], image.rgb[first + 1], image.rgb[first + 2]]
    }

    #[test]
    fn the_nearer_part_of_interpenetrating_balls_is_seen() {
        let scene = Scene {
            surfaces: vec![
                ball(Vector3::new(0.0, 0.0, 0.0), 1.0, [200, 0, 0], 48),
                ball(Vector3::new(0.9, 0.0, 0.3), 1.0, [0, 0, 200], 48),
            ],
            ..Scene::default()
        };
        let camera = Camera::look_at(Vector3::zeros(), Vector3::z(), Vector3::y(), 2.0);
        let image = scene.render(&camera, 200, 200);
        for (column, row) in [
            (60, 100),
            (95, 100),
            (130, 100),
            (150, 60),
            (100, 195),
            (100, 100),
            (128, 100),
        ] {
            let (x, y) = (
                (f64::from(column) + 0.5 - 100.0) / 50.0,
                (99.5 - f64::from(row)) / 50.0,
            );
            let height = |centre_x: f64, centre_z: f64| {
                let square = 1.0 - (x - centre_x).powi(2) - y * y;
                if square < 0.0 {
                    f64::NEG_INFINITY
                } else {
                    centre_z + square.sqrt()
                }
            };
            let (red, blue) = (height(0.0, 0.0), height(0.9, 0.3));
            let seen = pixel(&image, column, row);
            if red.max(blue) == f64::NEG_INFINITY {
                assert_eq!(seen, [255; 3]);
            } else {
                assert_eq!(
                    seen[0] > seen[2],
                    red > blue,
                    "at {column}, {row}: {seen:?}"
                );
            }
        }
    }

    #[test]
    fn normals_are_smooth_on_a_ball_and_sharp_on_a_box() {
        let ball = ball(Vector3::zeros(), 1.0, [9; 3], 40);
        for (triangle, normals) in ball.triangles.iter().zip(ball.corner_normals()) {
            for (&corner, normal) in triangle.iter().zip(normals) {
                let exact = ball.vertices[corner as usize];
                assert!(
                    normal == Vector3::zeros() || normal.dot(&exact) > 0.998,
                    "{normal:?} at {exact:?}"
                );
            }
        }
        for normals in cuboid(Vector3::new(1.0, 2.0, 3.0), [9; 3]).corner_normals() {
            assert!(normals.iter().all(|normal| normal.amax() > 0.9999));
        }
    }

    #[test]
    fn a_covered_marker_shines_through() {
        let mut scene = Scene {
            surfaces: vec![cuboid(Vector3::repeat(1.0), [100, 100, 100])],
            ..Scene::default()
        };
        let camera = Camera::look_at(Vector3::zeros(), Vector3::z(), Vector3::y(), 1.5);
        let plain = pixel(&scene.render(&camera, 40, 40), 20, 20);
        scene.markers.push(Marker {
            centre: Vector3::zeros(),
            radius_m: 0.3,
            colour: [250, 0, 0],
        });
        let covered = pixel(&scene.render(&camera, 40, 40), 20, 20);
        scene.markers[0].centre.z = 1.0;
        let open = pixel(&scene.render(&camera, 40, 40), 20, 20);
        assert!(
            plain[1] > covered[1] && covered[1] > open[1] && open[1] == 0,
            "{plain:?} {covered:?} {open:?}"
        );
    }

    #[test]
    fn friction_cones_open_inward_and_are_seen_through_the_object() {
        let ball = crate::object::Object::named("ball").unwrap();
        let mut scene = Scene {
            surfaces: vec![Surface {
                colour: [120; 3],
                ..Surface::of_mesh(&ball.mesh)
            }],
            ..Scene::default()
        };
        let centre = ball.centroid;
        let camera = Camera::look_at(centre, Vector3::z(), Vector3::y(), 0.05);
        let plain = scene.render(&camera, 100, 100);
        scene.markers.push(Marker {
            centre: centre + Vector3::x() * 0.036,
            radius_m: 0.001,
            colour: [250, 0, 0],
        });
        let (friction, side_m) = (0.5, 0.02);
        let scene = scene.with_friction_cones(&ball.exact, friction, side_m);
        let [cone] = scene.cones[..] else {
            panic!("one marker, one cone")
        };
        assert!((cone.tip - centre - Vector3::x() * 0.035).norm() < 1e-4);
        assert!((cone.axis + Vector3::x()).norm() < 0.05 && (cone.axis.norm() - 1.0).abs() < 1e-9);
        let image = scene.render(&camera, 100, 100);
        // A pixel is a millimetre; one and a half inside and outside the side of the cone, at three depths.
        for depth in [6, 10, 14] {
            for (row, inside) in [(51 - depth / 2, true), (48 - depth / 2, false)] {
                let [before, after] =
                    [&plain, &image].map(|image| pixel(image, 84 - depth, row)[0]);
                assert_eq!(after > before, inside, "{before} {after} at {depth} mm");
            }
        }
        // Triangles close the cone and face outward.
        let middle = cone.tip + cone.axis * 0.01;
        for [corners, normals] in cone.triangles() {
            let centroid = corners.iter().sum::<Vector3<f64>>() / 3.0;
            assert!(normals.iter().all(|n| n.dot(&(centroid - middle)) > 0.0));
            assert!(normals.iter().all(|n| (n.norm() - 1.0).abs() < 1e-9));
        }
    }
}
