//! The mug: a turned body with a handle that grows out of its wall.

use std::f64::consts::{FRAC_PI_2, PI};

use landscape::mesh::Mesh;
use landscape::object::Description;
use landscape::space::Symmetry;
use nalgebra::Vector3;

use super::lathe::{ROUND, Turned};
use super::tube::{Station, border_angles};

const RADIUS_MM: f64 = 41.0;
/// Stoneware: wall 4.5 mm, base 6 mm.
const BODY: Turned = Turned {
    name: "mug",
    mass_kg: 0.33,
    profile: &[
        [RADIUS_MM, 0.0, 5.0],
        [RADIUS_MM, 95.0, 2.2],
        [36.5, 95.0, 2.2],
        [36.5, 6.0, 8.0],
    ],
    section: ROUND,
};
/// Heights of the centres of the handle's roots, lower and upper.
const ROOTS_MM: [f64; 2] = [22.0, 74.0];
/// Numbers of sectors and rings of the wall in a root.
const ROOT: [usize; 2] = [6, 3];
/// Distance from the axis at which the fillets end and the handle's arch begins.
const ARCH_MM: f64 = 47.0;
/// Distance from there to the outermost point of the arch's middle line.
const REACH_MM: f64 = 25.0;
/// Exponent of the arch, between an ellipse (2) and a rectangle.
const ARCH_EXPONENT: f64 = 2.6;
/// Half-widths of the handle's cross-section: across the arch and in its plane.
const HALF_MM: [f64; 2] = [6.5, 4.5];
const STATIONS: u32 = 24;

pub(super) fn mug() -> Result<(&'static str, Mesh, Description), Box<dyn std::error::Error>> {
    let (mut parts, rings) = BODY.surface();
    let [sectors, height] = ROOT;
    // From the bottom's middle outward, then up the outer wall, over the rim and down the inner wall.
    let outer = &rings[..rings.len() / 2];
    let base = outer
        .iter()
        .take_while(|ring| parts.at(ring[0]).x < RADIUS_MM)
        .count();
    let wall = &outer[base..];
    let count = wall[0].len();
    let middle = |first: usize| {
        let z = |ring: usize| parts.at(wall[ring][0]).z;
        f64::midpoint(z(first), z(first + height))
    };
    let holes = ROOTS_MM.map(|wanted_mm| {
        (0..wall.len() - height)
            .min_by(|&a, &b| {
                let off = |first: usize| (middle(first) - wanted_mm).abs();
                off(a).total_cmp(&off(b))
            })
            .expect("the wall has rings")
    });
    let heights_mm = holes.map(middle);
    let [lower, upper] =
        holes.map(|first| parts.open(&wall[first..=first + height], count - sectors / 2, sectors));

    let angles = border_angles(sectors, height);
    let stations: Vec<Station> = (0..=STATIONS)
        .map(|step| station(f64::from(step) / f64::from(STATIONS), heights_mm))
        .collect();
    let outward = Vector3::x();
    let mut tube = vec![upper.clone()];
    tube.extend(parts.fillet(&upper, &outward, &stations[0], &angles));
    for station in &stations[1..stations.len() - 1] {
        tube.push(parts.section(station, &angles));
    }
    // The handle arrives upside down.
    let turned = |index: usize| (2 * sectors + height + lower.len() - index) % lower.len();
    let root: Vec<u32> = (0..lower.len()).map(|index| lower[turned(index)]).collect();
    let mut end = parts.fillet(&root, &outward, &stations[stations.len() - 1], &angles);
    end.reverse();
    tube.extend(end);
    tube.push(root);
    parts.stitch_all(&tube);

    let description = Description {
        symmetry: Symmetry::None,
        ..BODY.description()
    };
    Ok((BODY.name, parts.into_mesh(BODY.name)?, description))
}

/// Cross-section of the handle at `share` of its arch, from the upper root to the lower one.
fn station(share: f64, [low, high]: [f64; 2]) -> Station {
    let arch = |share: f64| {
        let (sin, cos) = libm::sincos(FRAC_PI_2 - PI * share);
        let n = ARCH_EXPONENT;
        let reach = libm::pow(libm::pow(cos.abs(), n) + libm::pow(sin.abs(), n), -1.0 / n);
        Vector3::new(
            ARCH_MM + REACH_MM * reach * cos,
            0.0,
            f64::midpoint(low, high) + 0.5 * (high - low) * reach * sin,
        )
    };
    let onward = (arch(share + 1e-4) - arch(share - 1e-4)).normalize();
    let across = Vector3::y();
    Station {
        centre: arch(share),
        axes: [across, onward.cross(&across)],
        half: HALF_MM,
        exponent: 2.0,
    }
}
