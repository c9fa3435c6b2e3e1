//! The solids of a fixture, and the places on the hand where they touch by its description.

use landscape::hand::Hand;
use landscape::object::{Primitive, Shape};
use nalgebra::{Matrix3, Vector3};

use super::fixture::Fixture;

impl Fixture {
    /// The object.
    pub(crate) fn shape(&self) -> Union {
        Union(self.object.clone())
    }
}

/// The union of some solids; the distance is that of the nearest.
///
/// The distance is exact outside. Inside it is a bound where solids overlap.
#[derive(Debug, Clone)]
pub(crate) struct Union(pub(crate) Vec<Primitive>);

fn solid(primitive: &Primitive) -> &dyn Shape {
    match primitive {
        Primitive::Sphere(shape) => shape,
        Primitive::Cuboid(shape) => shape,
        Primitive::Cylinder(shape) => shape,
        Primitive::Capsule(shape) => shape,
    }
}

impl Shape for Union {
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.gradient(point).0
    }

    fn gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let (distance, normal, _) = self.hessian(point);
        (distance, normal)
    }

    fn hessian(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
        let all = self
            .0
            .iter()
            .map(|primitive| solid(primitive).hessian(point));
        all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((
            f64::INFINITY,
            Vector3::z(),
            Matrix3::zeros(),
        ))
    }
}

/// Surface points of a region: those whose region's name starts with `region`. For `digit.segment.patch`, the points whose
/// normal points toward the patch are taken, and for `palm` its back is excluded. On the last segment the pad extends
/// toward the tip, as on a finger.
pub(crate) fn points(hand: &Hand, region: &str) -> Vec<usize> {
    let parts: Vec<&str> = region.split('.').collect();
    let (axis, least) = match parts.last() {
        Some(&"pad") => (Vector3::z(), 0.5),
        Some(&"back") => (-Vector3::z(), 0.5),
        Some(&"radial") => (Vector3::x(), 0.6),
        Some(&"ulnar") => (-Vector3::x(), 0.6),
        Some(&"tip") => (Vector3::y(), 0.45),
        _ => (Vector3::zeros(), 0.0),
    };
    let start = if least > 0.0 {
        region.rsplit_once('.').map_or(region, |(link, _)| link)
    } else {
        region
    };
    (0..hand.surface.len())
        .filter(|&i| {
            let (point, name) = (&hand.surface[i], &hand.regions[hand.surface[i].region]);
            name.starts_with(start)
                && point.normal.dot(&axis) >= least
                && !(region == "palm" && name == "palm.dorsum")
        })
        .collect()
}
