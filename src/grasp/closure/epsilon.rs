//! The Ferrari–Canny ε: how well a grasp resists the wrench that it resists least.

use std::f64::consts::TAU;

use nalgebra::{Vector3, Vector6};
use serde::{Deserialize, Serialize};

use super::cone_programme::shortest_in_hull;
use super::expanding::nearest_facet;
use super::{PointContact, excess, tangents_of};

/// Settings of the Ferrari–Canny ε.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EpsilonSettings {
    /// Friction coefficient μ.
    pub friction: f64,
    /// Number of edges of the pyramid inscribed in each friction cone; at least three.
    pub cone_edges: usize,
    /// Factor on torques, in addition to the length by which the arms were divided.
    pub torque_scale: f64,
}

impl Default for EpsilonSettings {
    fn default() -> Self {
        Self {
            friction: 0.5,
            cone_edges: 8,
            torque_scale: 1.0,
        }
    }
}

/// The Ferrari–Canny ε and the wrench that attains it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epsilon {
    /// ε. It is positive if every wrench can be resisted, zero if the contacts balance but some wrench cannot be resisted
    /// at all, and negative if the contacts cannot balance.
    pub value: f64,
    /// The unit wrench (force, torque) in whose direction the contacts exert only ε.
    pub weakest: Vector6<f64>,
}

/// The Ferrari–Canny ε: the radius of the largest ball about the origin inside the wrenches that the contacts can exert.
///
/// ```text
/// ε = min over ‖u‖ = 1 of max over w ∈ W of u·w
/// W = conv ⋃ᵢ Wᵢ
/// Wᵢ = { (f, σ xᵢ × f) : f = cᵢ + μ (cos(2πk/m) t₁ + sin(2πk/m) t₂), k = 0 … m−1 }
/// ```
///
/// xᵢ: arms, cᵢ: inward unit normals, m: `cone_edges`, σ: `torque_scale`. The sum of all *normal* forces is one (the L₁ limit
/// of Ferrari and Canny), and the distance is L₂ over (force, torque), dimensionless. The first edge points to the contact
/// farthest off the normal, so that ε does not depend on the frame. If the origin is outside W, the formula gives minus its
/// distance from W. If W is flat and contains the origin, or without contacts, ε is zero.
///
/// For the pyramids the result is exact to about 10⁻¹⁰ of the largest wrench; bodies thinner than 10⁻⁹ of it count as flat.
/// The pyramids are inscribed, so ε is at most that of the round cones. It takes about 1 ms for four contacts with eight
/// edges. Ferrari and Canny (1992), "Planning optimal grasps".
///
/// # Panics
/// If there are fewer than three edges, if a setting is negative or not finite, or if a wrench along an edge is not finite.
pub fn epsilon(contacts: &[PointContact], settings: &EpsilonSettings) -> Epsilon {
    let (friction, torque_scale) = (settings.friction, settings.torque_scale);
    assert!(
        settings.cone_edges >= 3,
        "a pyramid has at least three edges"
    );
    assert!(friction >= 0.0 && friction.is_finite());
    assert!(torque_scale >= 0.0 && torque_scale.is_finite());
    epsilon_of_wrenches(&pyramids(contacts, settings))
}

/// The wrenches along the edges of all cones.
fn pyramids(contacts: &[PointContact], settings: &EpsilonSettings) -> Vec<Vector6<f64>> {
    contacts
        .iter()
        .flat_map(|contact| {
            let normal = contact.inward_normal;
            let [first, second] = tangents_toward_others(contact, contacts);
            (0..settings.cone_edges).map(move |edge| {
                let angle = TAU * edge as f64 / settings.cone_edges as f64;
                let sideways = first * libm::cos(angle) + second * libm::sin(angle);
                let mut wrench = contact.wrench_of(&(normal + sideways * settings.friction));
                wrench
                    .fixed_rows_mut::<3>(3)
                    .scale_mut(settings.torque_scale);
                wrench
            })
        })
        .collect()
}

/// Like [`epsilon()`], for given extreme wrenches of any finite size; infinite if ε exceeds `f64`.
///
/// # Panics
/// If a wrench is not finite.
pub fn epsilon_of_wrenches(wrenches: &[Vector6<f64>]) -> Epsilon {
    assert!(
        wrenches
            .iter()
            .all(|wrench| wrench.iter().all(|w| w.is_finite()))
    );
    // Scaling prevents squares from overflowing or underflowing.
    let excess = excess(wrenches.iter().flat_map(|wrench| wrench.iter().copied()));
    let moderate: Vec<Vector6<f64>> = wrenches.iter().map(|wrench| wrench / excess).collect();
    let found = epsilon_of_moderate(&moderate);
    Epsilon {
        value: found.value * excess,
        ..found
    }
}

/// Like [`epsilon_of_wrenches`], for wrenches whose largest is of order one.
fn epsilon_of_moderate(all: &[Vector6<f64>]) -> Epsilon {
    let size = all.iter().map(Vector6::norm).fold(0.0, f64::max);
    if size == 0.0 {
        return Epsilon {
            value: 0.0,
            weakest: Vector6::x(),
        };
    }
    let nearest = nearest_facet(|u| farthest(all, u));
    if nearest.offset <= 0.0 {
        // If the solver fails, the supporting plane gives a lower bound of the distance.
        let shortest = shortest_in_hull(all).unwrap_or_else(|| nearest.normal * nearest.offset);
        let distance = shortest.norm();
        if distance > OUTSIDE * size {
            return Epsilon {
                value: -distance,
                weakest: shortest / -distance,
            };
        }
    }
    Epsilon {
        value: nearest.offset.max(0.0),
        weakest: nearest.normal,
    }
}

/// Distance, relative to the largest wrench, below which the conic solver returns zero.
const OUTSIDE: f64 = 1e-8;

fn farthest(wrenches: &[Vector6<f64>], direction: &Vector6<f64>) -> Vector6<f64> {
    wrenches
        .iter()
        .max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))
        .copied()
        .unwrap_or_default()
}

/// Tangents that rotate with the contacts: the first points to the contact farthest off the normal.
fn tangents_toward_others(contact: &PointContact, others: &[PointContact]) -> [Vector3<f64>; 2] {
    let normal = contact.inward_normal;
    let excess = excess(others.iter().flat_map(|other| other.arm.iter().copied()));
    let mut first: Vector3<f64> = Vector3::zeros();
    for other in others {
        let line = other.arm / excess - contact.arm / excess;
        let sideways = line - normal * normal.dot(&line);
        // Ties go to the earlier contact, despite rounding.
        if sideways.norm() > (first.norm() * (1.0 + 1e-9)).max(1e-9 * line.norm()) {
            first = sideways;
        }
    }
    match first.try_normalize(0.0) {
        Some(first) => [first, normal.cross(&first)],
        None => tangents_of(&normal),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Rng, Task, stream};
    use nalgebra::{Matrix6, Vector3};
    use rand::RngExt;

    fn gauge(points: &[Vector6<f64>]) -> f64 {
        epsilon_of_wrenches(points).value
    }

    fn support(points: &[Vector6<f64>], u: &Vector6<f64>) -> f64 {
        farthest(points, u).dot(u)
    }

    fn unit(rng: &mut Rng) -> Vector6<f64> {
        loop {
            let v = Vector6::from_fn(|_, _| rng.random_range(-1.0..1.0));
            if (0.01..1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }

    #[test]
    fn regular_bodies() {
        let axes: Vec<Vector6<f64>> = (0..6).map(|k| Vector6::ith(k, 1.0)).collect();
        let cross: Vec<_> = axes.iter().flat_map(|a| [*a, -a]).collect();
        assert!((gauge(&cross) - 6f64.sqrt().recip()).abs() < 1e-12);
        // The cube has 64 corners, 32 of them on each of its twelve facets.
        let cube: Vec<_> = (0..64u32)
            .map(|bits| Vector6::from_fn(|k, _| f64::from(bits >> k & 1) * 2.0 - 1.0))
            .collect();
        assert!((gauge(&cube) - 1.0).abs() < 1e-12);
        // The cube is moved off centre and beyond the origin.
        let moved = |by: f64| -> Vec<_> { cube.iter().map(|p| p + Vector6::x() * by).collect() };
        assert!((gauge(&moved(0.75)) - 0.25).abs() < 1e-12);
        assert!(gauge(&moved(1.0)).abs() < 1e-12);
        assert!((gauge(&moved(3.0)) + 2.0).abs() < 1e-8);
        // A flat body, with and without the origin.
        let flat: Vec<_> = cube.iter().map(|p| p - Vector6::x() * p.x).collect();
        assert!(gauge(&flat).abs() < 1e-12);
        let apart: Vec<_> = flat.iter().map(|p| p + Vector6::x() * 0.5).collect();
        assert!((gauge(&apart) + 0.5).abs() < 1e-8);
    }

    /// ε is proportional to the wrenches, from the smallest to the largest numbers.
    #[test]
    fn wrenches_of_any_size() {
        let axes: Vec<Vector6<f64>> = (0..6).map(|k| Vector6::ith(k, 1.0)).collect();
        let around: Vec<_> = axes.iter().flat_map(|a| [*a, -a]).collect();
        let apart: Vec<_> = around.iter().map(|w| w + Vector6::x() * 3.0).collect();
        let flat: Vec<_> = apart[2..].to_vec();
        for wrenches in [&around, &apart, &flat] {
            let of = |size: f64| {
                let sized: Vec<_> = wrenches.iter().map(|w| w * size).collect();
                epsilon_of_wrenches(&sized)
            };
            let one = of(1.0);
            for size in [1e-300, 1e-200, 1e-20, 1e20, 1e200, 1e307] {
                let found = of(size);
                let difference = (found.value / size - one.value).abs();
                assert!(difference < 1e-7, "{size}: {found:?} for {one:?}");
                assert!((found.weakest.norm() - 1.0).abs() < 1e-9, "{found:?}");
            }
        }
        // With both huge and tiny wrenches, ε only has to be finite.
        let mixed: Vec<_> = apart
            .iter()
            .enumerate()
            .map(|(k, w)| w * [1e200, 1.0, 1e-200][k % 3])
            .collect();
        assert!(gauge(&mixed).is_finite());
        assert!(gauge(&[Vector6::zeros()]).abs() < 1e-12);
    }

    /// A large torque scale is equivalent to long arms.
    #[test]
    fn arms_of_any_length() {
        for set in 0..10 {
            let contacts = grasp(set, 4, set % 2 == 1);
            let sized = |size: f64| -> Vec<PointContact> {
                let arm = |contact: &PointContact| contact.arm * size;
                contacts
                    .iter()
                    .map(|contact| PointContact {
                        arm: arm(contact),
                        ..*contact
                    })
                    .collect()
            };
            let size = 2f64.powi(660);
            let settings = EpsilonSettings {
                torque_scale: size,
                ..EpsilonSettings::default()
            };
            let long = epsilon(&sized(size), &EpsilonSettings::default());
            assert!(long.value.is_finite());
            assert_eq!(long, epsilon(&contacts, &settings));
        }
    }

    /// Random contacts; with `lattice` their components are −1, 0, 1, so that many are symmetric, flat or coincident.
    fn grasp(set: u64, n: usize, lattice: bool) -> Vec<PointContact> {
        let mut rng = stream(set, Task::Start, 1);
        let mut vector = || loop {
            let v: Vector3<f64> = if lattice {
                Vector3::from_fn(|_, _| f64::from(rng.random_range(-1..=1)))
            } else {
                Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0))
            };
            if v.norm() > 0.1 {
                return v;
            }
        };
        (0..n)
            .map(|_| PointContact {
                arm: vector(),
                inward_normal: vector().normalize(),
            })
            .collect()
    }

    /// The least distance of the hull's facets, by trying all sets of six points; negative if the origin is outside.
    fn by_every_facet(points: &[Vector6<f64>]) -> f64 {
        let mut least = f64::INFINITY;
        let mut chosen: Vec<usize> = (0..6).collect();
        loop {
            let rows = Matrix6::from_fn(|r, c| points[chosen[r]][c]);
            // The plane u·w = 1 through six points is a facet if all other points lie on one side.
            if rows.determinant().abs() > 1e-9
                && let Some(inverse) = rows.try_inverse()
            {
                let u = inverse * Vector6::repeat(1.0);
                let (normal, offset) = (u.normalize(), u.norm().recip());
                if support(points, &normal) <= offset + 1e-9 {
                    least = least.min(offset);
                } else if -support(points, &-normal) >= offset - 1e-9 {
                    return f64::NEG_INFINITY;
                }
            }
            let Some(slot) = (0..6).rev().find(|&k| chosen[k] < points.len() - 6 + k) else {
                return least;
            };
            chosen[slot] += 1;
            for k in slot + 1..6 {
                chosen[k] = chosen[k - 1] + 1;
            }
        }
    }

    #[test]
    fn as_by_every_facet() {
        for (lattice, sets) in [(false, 60), (true, 60)] {
            let mut positive = 0;
            for set in 0..sets {
                let settings = EpsilonSettings {
                    cone_edges: 4,
                    friction: 1.5,
                    ..EpsilonSettings::default()
                };
                let points = pyramids(&grasp(set, 3, lattice), &settings);
                let found = gauge(&points);
                let least = by_every_facet(&points);
                if found > 1e-9 {
                    positive += 1;
                    let difference = (found - least).abs();
                    assert!(difference < 1e-10, "{lattice}, {set}: {found} for {least}");
                } else if found < -1e-8 {
                    // Infinite means flat, without facets.
                    assert!(
                        least < 0.0 || least.is_infinite(),
                        "{lattice}, {set}: {found} for {least}"
                    );
                }
            }
            assert!(positive > 10, "{positive} positive");
        }
    }

    /// Bounds from both sides for many wrenches: by a cone programme every wrench of length ε can be resisted, and slightly
    /// longer ones in the weakest direction cannot.
    #[test]
    fn wrenches_up_to_epsilon_can_be_resisted() {
        let mut rng = stream(0, Task::Start, 2);
        let mut positive = 0;
        for set in 0..40 {
            let contacts = grasp(set, 5, set % 2 == 1);
            let settings = EpsilonSettings::default();
            let found = epsilon(&contacts, &settings);
            let points = pyramids(&contacts, &settings);
            if found.value < 1e-6 {
                continue;
            }
            positive += 1;
            let missing = |wrench: Vector6<f64>| {
                let moved: Vec<_> = points.iter().map(|point| point - wrench).collect();
                shortest_in_hull(&moved).unwrap().norm()
            };
            assert!(missing(found.weakest * found.value) < 1e-7);
            let longer = missing(found.weakest * found.value * 1.01);
            assert!((longer - 0.01 * found.value).abs() < 1e-7);
            for _ in 0..10 {
                let direction = unit(&mut rng);
                assert!(missing(direction * found.value) < 1e-7);
                assert!(support(&points, &direction) >= found.value);
            }
        }
        assert!(positive > 10, "{positive} positive");
    }

    /// Twelve contacts without friction push along ±x with arms ±d along y, and so on for the other axes. In each of the
    /// three (force, torque) planes they span a rectangle with half sides 1 and σd.
    #[test]
    fn pushes_along_three_axes() {
        let arm = 0.7;
        let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let contacts: Vec<PointContact> = (0..3)
            .flat_map(|axis| {
                signs.map(|(push, side)| PointContact {
                    arm: Vector3::ith((axis + 1) % 3, side * arm),
                    inward_normal: Vector3::ith(axis, push),
                })
            })
            .collect();
        for torque_scale in [0.3, 1.0, 5.0] {
            let settings = EpsilonSettings {
                friction: 0.0,
                cone_edges: 3,
                torque_scale,
            };
            let d = torque_scale * arm;
            // The force is shared equally between the planes, each by its shorter half side.
            let found = epsilon(&contacts, &settings).value;
            assert!((found - d.min(1.0) / 3f64.sqrt()).abs() < 1e-12, "{found}");
        }
    }
}
