//! The box: a carton with rounded edges.

use std::f64::consts::{FRAC_PI_4, PI};

use landscape::mesh::Mesh;
use landscape::object::Description;
use landscape::space::Symmetry;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

const NAME: &str = "box";
const MASS_KG: f64 = 0.12;
const HALF_MM: [f64; 3] = [31.0, 19.0, 48.0];
const ROUNDING_MM: f64 = 2.5;
/// Number of quadrangles across half of a rounded edge. `STEP_MM` is the longest side of those on the flat part.
const ARC_STEPS: u32 = 3;
const STEP_MM: f64 = 6.0;

pub(super) fn carton() -> Result<(&'static str, Mesh, Description), Box<dyn std::error::Error>> {
    let half = Vector3::from(HALF_MM);
    let core = half.add_scalar(-ROUNDING_MM);
    // Points of the box are moved onto the rounded box. Edges of neighbouring faces coincide to the last bit and are merged
    // by `Mesh::new`.
    let rounded = |point: Vector3<f64>| {
        let inner = point.zip_map(&core, |x, limit| x.clamp(-limit, limit));
        inner + (point - inner).normalize() * ROUNDING_MM + Vector3::z() * half.z
    };
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let (across, up) = (places(half[u]), places(half[v]));
            for (a, b) in pairs(&across) {
                for (c, d) in pairs(&up) {
                    let at = |x: f64, y: f64| {
                        let mut point = Vector3::zeros();
                        (point[axis], point[u], point[v]) = (side * half[axis], x, y);
                        rounded(point) * 1e-3
                    };
                    let first = u32::try_from(corners.len())?;
                    corners.extend([at(a, c), at(b, c), at(b, d), at(a, d)]);
                    for [p, q, r] in [[0, 1, 2], [0, 2, 3]] {
                        let [q, r] = if side > 0.0 { [q, r] } else { [r, q] };
                        triangles.push([first + p, first + q, first + r]);
                    }
                }
            }
        }
    }
    let half_turn = |axis: Vector3<f64>| {
        let rotation = UnitQuaternion::from_scaled_axis(axis * PI);
        let middle = Vector3::z() * (half.z * 1e-3);
        Isometry3::from_parts(Translation3::from(middle - rotation * middle), rotation)
    };
    let description = Description {
        name: Some(NAME.into()),
        mass_kg: Some(MASS_KG),
        symmetry: Symmetry::Finite(
            [Vector3::x(), Vector3::y(), Vector3::z()]
                .map(half_turn)
                .to_vec(),
        ),
        ..Description::default()
    };
    Ok((NAME, Mesh::new(NAME, corners, triangles)?, description))
}

/// Grid lines along an edge of length 2 · `half`: dense over the rounding, even over the flat part.
fn places(half: f64) -> Vec<f64> {
    let flat = half - ROUNDING_MM;
    let arc = |step: u32| {
        let share = f64::from(step) / f64::from(ARC_STEPS);
        flat + ROUNDING_MM * libm::tan(FRAC_PI_4 * share)
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small positive count"
    )]
    let count = (2.0 * flat / STEP_MM).ceil() as u32;
    let end = |step: u32| if step == ARC_STEPS { half } else { arc(step) };
    let mut places: Vec<f64> = (1..=ARC_STEPS).rev().map(|step| -end(step)).collect();
    places.extend((0..=count).map(|i| flat * (2.0 * f64::from(i) / f64::from(count) - 1.0)));
    places.extend((1..=ARC_STEPS).map(end));
    places
}

fn pairs(places: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    places.windows(2).map(|pair| (pair[0], pair[1]))
}
