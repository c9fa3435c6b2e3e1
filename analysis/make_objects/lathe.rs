//! Turned objects: a profile (radius over height, corners rounded) is swept about the z axis. A profile that comes down
//! again inside gives a vessel. Below the shoulder the cross-section may be an oval or a rounded square.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use landscape::mesh::{Mesh, MeshError};
use landscape::object::Description;
use landscape::space::Symmetry;
use nalgebra::{Isometry3, Vector2, Vector3};

use super::parts::Parts;

/// Corner of a profile in millimetres: distance from the axis, height, radius of the rounding.
pub(super) type Corner = [f64; 3];

pub(super) struct Turned {
    pub(super) name: &'static str,
    pub(super) mass_kg: f64,
    pub(super) profile: &'static [Corner],
    pub(super) section: Section,
}

/// Cross-section |x/a|ⁿ + |y/b|ⁿ = rⁿ below the shoulder, and a circle above it.
pub(super) struct Section {
    pub(super) depth: f64,
    pub(super) exponent: f64,
    pub(super) shoulder_mm: [f64; 2],
}

pub(super) const ROUND: Section = Section {
    depth: 1.0,
    exponent: 2.0,
    shoulder_mm: [0.0, 1.0],
};

impl Turned {
    /// The whole surface and its rings from the bottom up (for a vessel: up the outer wall and down the inner one).
    pub(super) fn surface(&self) -> (Parts, Vec<Vec<u32>>) {
        let profile = rounded(self.profile);
        let mut parts = Parts::default();
        let mut rings: Vec<Vec<u32>> = Vec::new();
        let bottom = parts.point(Vector3::zeros());
        for point in &profile {
            // Numbers of vertices of neighbouring rings differ by a factor of two at most.
            let wanted = segments(point.x);
            let count = match rings.last() {
                None => wanted,
                Some(below) => wanted.clamp(below.len() / 2, below.len() * 2),
            };
            let turn = |step: usize| TAU * step as f64 / count as f64;
            let ring = parts.ring((0..count).map(|step| self.section.point(point, turn(step))));
            match rings.last() {
                None => parts.close_below(bottom, &ring),
                Some(below) => parts.stitch(below, &ring),
            }
            rings.push(ring);
        }
        let height = profile.last().expect("a profile has points").y;
        let top = parts.point(Vector3::z() * height);
        parts.close_above(top, rings.last().expect("a profile has points"));
        (parts, rings)
    }

    pub(super) fn mesh(&self) -> Result<Mesh, MeshError> {
        self.surface().0.into_mesh(self.name)
    }

    pub(super) fn description(&self) -> Description {
        let turn = |angle: f64| Isometry3::rotation(Vector3::z() * angle);
        let symmetry = if self.section.depth < 1.0 {
            Symmetry::Finite(vec![turn(PI)])
        } else if self.section.exponent > 2.0 {
            Symmetry::Finite(vec![turn(FRAC_PI_2), turn(PI), turn(-FRAC_PI_2)])
        } else {
            Symmetry::Axis {
                point: Vector3::zeros(),
                direction: Vector3::z(),
            }
        };
        Description {
            name: Some(self.name.into()),
            mass_kg: Some(self.mass_kg),
            symmetry,
            ..Description::default()
        }
    }
}

impl Section {
    fn point(&self, profile: &Vector2<f64>, angle: f64) -> Vector3<f64> {
        let [from, to] = self.shoulder_mm;
        let t = ((profile.y - from) / (to - from)).clamp(0.0, 1.0);
        let circle = t * t * (3.0 - 2.0 * t);
        let depth = self.depth + (1.0 - self.depth) * circle;
        let exponent = self.exponent + (2.0 - self.exponent) * circle;
        let (sin, cos) = libm::sincos(angle);
        let reach = profile.x
            * libm::pow(
                libm::pow(cos.abs(), exponent) + libm::pow(sin.abs(), exponent),
                -1.0 / exponent,
            );
        Vector3::new(reach * cos, depth * reach * sin, profile.y)
    }
}

/// Least number of segments with which a ring stays within 0.05 mm of the circle. It is even, so that rings can be
/// stitched.
fn segments(radius_mm: f64) -> usize {
    let sagitta = |count: usize| radius_mm * (1.0 - libm::cos(PI / count as f64));
    [9, 18, 36]
        .into_iter()
        .find(|&count| sagitta(count) <= 0.05)
        .unwrap_or(72)
}

/// The profile from the axis at the bottom to the axis at the top, evenly divided, with arcs at the corners.
fn rounded(corners: &[Corner]) -> Vec<Vector2<f64>> {
    const STEP_MM: f64 = 8.0;
    const ARC_STEP: f64 = PI / 10.0;
    let point = |corner: &Corner| Vector2::new(corner[0], corner[1]);
    let (bottom, top) = (corners[0][1], corners[corners.len() - 1][1]);
    let mut ends = vec![Vector2::new(0.0, bottom)];
    ends.extend(corners.iter().map(point));
    ends.push(Vector2::new(0.0, top));

    let mut curve = vec![ends[0]];
    for (index, corner) in corners.iter().enumerate() {
        let [before, here, after] = [ends[index], ends[index + 1], ends[index + 2]];
        let (inward, onward) = ((here - before).normalize(), (after - here).normalize());
        let turn = libm::atan2(inward.perp(&onward), inward.dot(&onward));
        let half = libm::tan(turn / 2.0).abs();
        // An arc may use up half of an edge.
        let room = 0.49 * (here - before).norm().min((after - here).norm());
        let radius = corner[2].min(room / half);
        let start = here - inward * (radius * half);
        line_to(&mut curve, start, STEP_MM);
        let side = Vector2::new(-inward.y, inward.x) * turn.signum();
        let centre = start + side * radius;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small positive count"
        )]
        let steps = (turn.abs() / ARC_STEP)
            .max(turn.abs() * radius / STEP_MM)
            .ceil() as u32;
        for step in 1..=steps {
            let (sin, cos) = libm::sincos(turn * f64::from(step) / f64::from(steps));
            let spoke = -side * radius;
            curve.push(
                centre + Vector2::new(cos * spoke.x - sin * spoke.y, sin * spoke.x + cos * spoke.y),
            );
        }
    }
    line_to(&mut curve, Vector2::new(0.0, top), STEP_MM);
    // The points on the axis are the poles.
    curve.pop();
    curve.remove(0);
    curve
}

fn line_to(curve: &mut Vec<Vector2<f64>>, end: Vector2<f64>, step: f64) {
    let start = curve[curve.len() - 1];
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small positive count"
    )]
    let count = ((end - start).norm() / step).ceil().max(1.0) as u32;
    curve.extend((1..=count).map(|i| start.lerp(&end, f64::from(i) / f64::from(count))));
}
