//! Cameras, and the choice of viewpoints.

use nalgebra::{Matrix3, Vector3};

use super::{Scene, Surface};

/// Side of the trial renderings that choose a viewpoint, pixels.
const TRIAL_SIDE: u32 = 120;
/// Weights of the visible areas of markers, the first surface and the other surfaces in the score of a viewpoint.
const WEIGHTS: [f64; 3] = [1.0, 0.5, 1.0];
/// Two viewpoints differ if the cosine between their lines of sight is below this one, that of 60°. Opposite viewpoints do
/// not differ because their outlines are largely the same.
const APART: f64 = 0.51;

/// An orthographic camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Point in the middle of the image, object frame, metres.
    pub target: Vector3<f64>,
    /// Rows are the unit vectors to the right, up and toward the eye.
    pub view_from_object: Matrix3<f64>,
    /// Half the shorter side of the image, metres.
    pub half_extent_m: f64,
}

impl Camera {
    /// Camera at the far end of `toward_eye` that looks at `target`, with `up` upright in the image.
    ///
    /// If `up` is along the line of sight, the coordinate axis farthest from it is used instead.
    ///
    /// # Panics
    /// If `toward_eye` is zero.
    pub fn look_at(
        target: Vector3<f64>,
        toward_eye: Vector3<f64>,
        up: Vector3<f64>,
        half_extent_m: f64,
    ) -> Self {
        let back = toward_eye
            .try_normalize(0.0)
            .expect("a direction to look from is not zero");
        let right = up
            .cross(&back)
            .try_normalize(1e-6 * up.norm().max(f64::MIN_POSITIVE))
            .unwrap_or_else(|| {
                let mut other = Vector3::zeros();
                other[back.iamin()] = 1.0;
                other.cross(&back).normalize()
            });
        let view_from_object = Matrix3::from_rows(&[
            right.transpose(),
            back.cross(&right).transpose(),
            back.transpose(),
        ]);
        Self {
            target,
            view_from_object,
            half_extent_m,
        }
    }

    /// The unit vector from the middle of the image to the eye.
    pub fn toward_eye(&self) -> Vector3<f64> {
        self.view_from_object.row(2).transpose()
    }
}

impl Scene {
    /// Camera that looks along −`toward_eye` and shows everything with a small margin, for square images.
    ///
    /// # Panics
    /// If `toward_eye` is zero.
    pub fn framed(&self, toward_eye: Vector3<f64>, up: Vector3<f64>) -> Camera {
        let camera = Camera::look_at(Vector3::zeros(), toward_eye, up, 1.0);
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = Vector3::repeat(f64::NEG_INFINITY);
        let mut include = |point: &Vector3<f64>, radius: f64| {
            let point = camera.view_from_object * point;
            low = low.inf(&point.add_scalar(-radius));
            high = high.sup(&point.add_scalar(radius));
        };
        self.surfaces
            .iter()
            .flat_map(|surface| &surface.vertices)
            .for_each(|vertex| include(vertex, 0.0));
        self.markers
            .iter()
            .for_each(|marker| include(&marker.centre, marker.radius_m));
        for cone in &self.cones {
            let (middle, radius) = cone.base();
            include(&cone.tip, 0.0);
            include(&middle, radius);
        }
        if low.x > high.x {
            return camera;
        }
        let centre = 0.5 * (low + high);
        let half = 0.5 * (high - low).xy().max();
        Camera {
            target: camera.view_from_object.transpose() * centre,
            half_extent_m: if half > 0.0 { 1.05 * half } else { 1.0 },
            ..camera
        }
    }

    /// The best of the 26 directions toward faces, edges and corners of a cube: the one that shows most of the markers, of
    /// the first surface (the hand) and of the others (the object). Each visible area is divided by the largest one over
    /// all directions. The hand has half the weight because it is visible from everywhere.
    pub fn best_camera(&self, up: Vector3<f64>) -> Camera {
        self.two_cameras(up)[0]
    }

    /// [`Scene::best_camera`], and the best of the directions at least 60° from it and from its opposite.
    pub fn two_cameras(&self, up: Vector3<f64>) -> [Camera; 2] {
        let step = |digit: u32| f64::from(digit % 3) - 1.0;
        let directions = (0..27u32)
            .map(|code| Vector3::new(step(code / 9), step(code / 3), step(code)))
            .filter(|direction| *direction != Vector3::zeros());
        let normals: Vec<Vec<[Vector3<f64>; 3]>> =
            self.surfaces.iter().map(Surface::corner_normals).collect();
        let seen: Vec<(Camera, [f64; 3])> = directions
            .map(|direction| {
                let camera = self.framed(direction, up);
                let shown = self.shown(&camera, &normals);
                (camera, shown)
            })
            .collect();
        let most = [0, 1, 2].map(|kind| {
            let areas = seen.iter().map(|(_, shown)| shown[kind]);
            areas.fold(f64::MIN_POSITIVE, f64::max)
        });
        let score = |shown: &[f64; 3]| -> f64 {
            let shares = shown.iter().zip(most).zip(WEIGHTS);
            shares
                .map(|((area, most), weight)| weight * area / most)
                .sum()
        };
        let best = |allowed: &dyn Fn(&Camera) -> bool| {
            let allowed = seen.iter().filter(|(camera, _)| allowed(camera));
            // Of equal directions, take the first.
            allowed
                .rev()
                .max_by(|a, b| score(&a.1).total_cmp(&score(&b.1)))
                .map_or(seen[0].0, |(camera, _)| *camera)
        };
        let first = best(&|_| true);
        let second = best(&|camera| camera.toward_eye().dot(&first.toward_eye()).abs() < APART);
        [first, second]
    }

    /// [`Scene::best_camera`], moved closer so that the first surface and the markers fill the image.
    pub fn closer_camera(&self, up: Vector3<f64>) -> Camera {
        let toward_eye = self.best_camera(up).toward_eye();
        let nearer = Self {
            surfaces: self.surfaces.first().cloned().into_iter().collect(),
            markers: self.markers.clone(),
            cones: Vec::new(),
        };
        nearer.framed(toward_eye, up)
    }

    /// Visible areas of the markers, the first surface and the other surfaces, m².
    fn shown(&self, camera: &Camera, normals: &[Vec<[Vector3<f64>; 3]>]) -> [f64; 3] {
        let raster = self.raster(camera, TRIAL_SIDE, TRIAL_SIDE, normals);
        let pixel_m2 = (2.0 * camera.half_extent_m / f64::from(TRIAL_SIDE)).powi(2);
        let mut areas = [0.0; 3];
        for (surface, marker) in raster.surface.iter().zip(&raster.marker) {
            if marker.depth > surface.depth {
                areas[0] += pixel_m2;
            }
            if surface.depth > f64::NEG_INFINITY {
                areas[1 + surface.owner.min(1)] += pixel_m2;
            }
        }
        areas
    }
}

#[cfg(test)]
mod tests {
    use super::super::Marker;
    use super::super::tests::{ball, cuboid, pixel};
    use super::*;

    #[test]
    fn framing_shows_everything_and_up_is_up() {
        let scene = Scene {
            surfaces: vec![cuboid(Vector3::new(0.1, 0.2, 0.3), [50; 3])],
            markers: vec![Marker {
                centre: Vector3::new(0.0, 0.0, 0.4),
                radius_m: 0.05,
                colour: [255, 0, 0],
            }],
            ..Scene::default()
        };
        for direction in [Vector3::x(), Vector3::new(1.0, -1.0, 0.5), Vector3::z()] {
            let image = scene.render(&scene.framed(direction, Vector3::z()), 64, 64);
            let border = (0..64).flat_map(|i| [(i, 0), (i, 63), (0, i), (63, i)]);
            assert!(
                border
                    .into_iter()
                    .all(|(column, row)| pixel(&image, column, row) == [255; 3])
            );
        }
        let image = scene.render(&scene.framed(Vector3::x(), Vector3::z()), 64, 64);
        let red_row = (0..64)
            .find(|&row| {
                let [r, g, _] = pixel(&image, 32, row);
                r > 100 && g < 60
            })
            .unwrap();
        assert!(red_row < 12, "marker at row {red_row}");
        assert_eq!(
            Scene::default()
                .render(&Scene::default().best_camera(Vector3::z()), 4, 4)
                .rgb,
            vec![255; 48]
        );
    }

    #[test]
    fn the_viewpoint_faces_the_contacts() {
        let mut scene = Scene {
            surfaces: vec![
                ball(Vector3::new(0.0, 0.1, 0.0), 0.05, [230, 190, 160], 24),
                cuboid(Vector3::new(0.06, 0.06, 0.06), [120, 150, 190]),
            ],
            ..Scene::default()
        };
        for side in [-1.0, 1.0] {
            let centre = Vector3::new(0.062 * side, 0.0, 0.0);
            scene.markers = vec![Marker {
                centre,
                radius_m: 0.006,
                colour: [220, 30, 30],
            }];
            let camera = scene.best_camera(Vector3::z());
            assert!(camera.view_from_object[(2, 0)] * side > 0.3, "{camera:?}");
            assert!(
                camera.view_from_object[(2, 1)] >= 0.0,
                "the hand is hidden: {camera:?}"
            );
            assert_eq!(camera, scene.best_camera(Vector3::z()));
        }
    }

    /// Seen from behind, a hand shows most of itself and hides what it holds.
    #[test]
    fn the_viewpoint_shows_what_is_held_and_the_second_another_side() {
        let mut back = cuboid(Vector3::new(0.1, 0.1, 0.01), [230, 190, 160]);
        for vertex in &mut back.vertices {
            vertex.z += 0.06;
        }
        let scene = Scene {
            surfaces: vec![back, ball(Vector3::zeros(), 0.04, [120, 150, 190], 24)],
            ..Scene::default()
        };
        let [first, second] = scene.two_cameras(Vector3::z());
        assert_eq!(first, scene.best_camera(Vector3::z()));
        assert!(first.toward_eye().z < 0.3, "{first:?}");
        let [one, two] = [first, second].map(|camera| camera.toward_eye());
        assert!(one.angle(&two) > 1.0, "{one:?} {two:?}");
        // Of an object alone, seen from above or not, there are two sides as well.
        let alone = Scene {
            surfaces: vec![cuboid(Vector3::new(0.1, 0.1, 0.01), [9; 3])],
            ..Scene::default()
        };
        let [first, second] = alone.two_cameras(Vector3::z());
        let images = [first, second].map(|camera| alone.render(&camera, 60, 60));
        assert_ne!(images[0], images[1]);
    }
}
