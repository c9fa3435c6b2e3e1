//! The least friction at which contacts balance.

use super::cone_programme::{BALANCE_TOLERANCE, widest_margin};
use super::triangle::Triangle;
use super::{PointContact, RANK_EPSILON, grasp_matrix_rank_margin, with_moderate_arms};

/// Friction coefficients above this are reported as infinite.
pub const LARGEST_FRICTION: f64 = 1e3;

/// Resolution of friction coefficients in closed forms, relative to their size above one.
const CLOSED_FORM_RESOLUTION: f64 = 1e-12;

/// The same for cone programmes.
const PROGRAMME_RESOLUTION: f64 = 5e-8;

/// Up to this number of contacts, the closed forms of all triples cost less than one cone programme.
const FEW_CONTACTS: usize = 10;

/// Exact force closure with point contacts and Coulomb friction `friction`: forces inside the friction cones balance
/// (Σ fₙ = 1, fₙ ≥ 0, Gf = 0) *and* the contacts span all wrenches (`GGᵀ` ≻ εI). Arms above 10⁶ are first scaled down
/// together to order one; contacts that are not finite are never in force closure.
///
/// Liu et al. (2021), Eqs. 1–3. It takes about a microsecond for three contacts, and about 0.15 ms for four.
///
/// # Panics
/// If `friction` is negative or not finite.
pub fn is_force_closure(contacts: &[PointContact], friction: f64) -> bool {
    assert!(friction >= 0.0 && friction.is_finite());
    let contacts = &*with_moderate_arms(contacts);
    if contacts.iter().any(|contact| !contact.is_finite()) {
        return false;
    }
    if grasp_matrix_rank_margin(contacts) <= RANK_EPSILON {
        return false;
    }
    let closed_form = match contacts {
        [a, b, c] => least_friction_of_three(&[*a, *b, *c]),
        _ => None,
    };
    if let Some(least) = closed_form {
        least <= friction + BALANCE_TOLERANCE
    } else {
        widest_margin(contacts, libm::atan(friction))
            .is_some_and(|widest| widest.margin >= -BALANCE_TOLERANCE)
    }
}

/// The least friction coefficient μ₀ for which contact forces in the cones balance; `f64::INFINITY` if it exceeds
/// [`LARGEST_FRICTION`] or a contact is not finite. The rank condition is not tested.
///
/// ```text
/// μ₀ = inf { μ : ∃ f, ‖fₜ,i‖ ≤ μ fₙ,i, fₙ,i ≥ 0, Σ fₙ,i = 1, Gf = 0 }
/// ```
///
/// * Two contacts: the forces lie on the connecting line, μ₀ = max tan ∠(normal, line).
/// * Three: the least of the three pairs, or all three together in the plane of their triangle. For a given μ, balance in
///   the plane is decided in closed form. The μ₀ of all three has a closed form too if it is decided by one contact that
///   can barely push in the plane (μ₀ = max |s|/r; on a sphere it is always this or a pair). Otherwise three edges of cones
///   meet in a point, an equation without a useful closed solution, and μ₀ is found by bisection to 10⁻¹².
/// * More, or three on one line: a root search over second-order cone programmes, to 10⁻⁸.
pub fn least_friction(contacts: &[PointContact]) -> f64 {
    let contacts = &*with_moderate_arms(contacts);
    if contacts.iter().any(|contact| !contact.is_finite()) {
        return f64::INFINITY;
    }
    let closed_form = match contacts {
        [] | [_] => Some(f64::INFINITY),
        [a, b] => Some(least_friction_of_pair(a, b)),
        [a, b, c] => least_friction_of_three(&[*a, *b, *c]),
        _ => None,
    };
    let friction = closed_form.unwrap_or_else(|| {
        let known = if contacts.len() <= FEW_CONTACTS {
            least_friction_of_threes(contacts)
        } else {
            f64::INFINITY
        };
        least_friction_by_programmes(contacts, known)
    });
    if friction <= LARGEST_FRICTION {
        friction
    } else {
        f64::INFINITY
    }
}

fn least_friction_of_pair(first: &PointContact, second: &PointContact) -> f64 {
    let line = second.arm - first.arm;
    let needed = |contact: &PointContact, sign: f64| {
        let along = sign * contact.inward_normal.dot(&line);
        if along > 0.0 {
            contact.inward_normal.cross(&line).norm() / along
        } else {
            f64::INFINITY
        }
    };
    if line.norm_squared() > 0.0 {
        let squeeze = needed(first, 1.0).max(needed(second, -1.0));
        let spread = needed(first, -1.0).max(needed(second, 1.0));
        squeeze.min(spread)
    } else if first.inward_normal.dot(&second.inward_normal) < 0.0 {
        // At a common point any two opposite forces balance. The best is halfway between one normal and the negative other.
        let between = first.inward_normal - second.inward_normal;
        first.inward_normal.cross(&between).norm() / first.inward_normal.dot(&between)
    } else {
        f64::INFINITY
    }
}

/// The least friction of three contacts; `None` if they lie on a line, since the forces then need not be coplanar.
fn least_friction_of_three(contacts: &[PointContact; 3]) -> Option<f64> {
    let triangle = Triangle::of(contacts)?;
    let by_pair = least_friction_of_pairs(contacts);
    let to_push = triangle.friction_to_push();
    let mut high = by_pair.min(LARGEST_FRICTION);
    if to_push >= high {
        return Some(by_pair);
    }
    let above = |friction: f64, distance: f64| friction + distance * friction.max(1.0);
    // Just above `to_push` the wedges are so narrow that rounding can fake a balance, so larger frictions must balance too.
    let lower = [1e-4, 1e-8, CLOSED_FORM_RESOLUTION]
        .map(|distance| above(to_push, distance))
        .into_iter()
        .filter(|friction| *friction < high)
        .map(|friction| (friction, triangle.imbalance(friction)))
        .find(|(_, imbalance)| *imbalance > 0.0);
    let Some((mut low, mut lack)) = lower else {
        return Some(to_push);
    };
    let mut excess = -triangle.imbalance(above(high, -CLOSED_FORM_RESOLUTION));
    if excess < 0.0 {
        return Some(by_pair);
    }
    // Regula falsi with the Illinois modification; every third step bisects.
    for step in 1.. {
        if high <= above(low, CLOSED_FORM_RESOLUTION) {
            break;
        }
        let share = if step % 3 == 0 {
            0.5
        } else {
            lack / (lack + excess)
        };
        let trial = low + (high - low) * share.clamp(1e-3, 1.0 - 1e-3);
        let imbalance = triangle.imbalance(trial);
        if imbalance > 0.0 {
            (low, lack, excess) = (trial, imbalance, 0.5 * excess);
        } else {
            (high, excess, lack) = (trial, -imbalance, 0.5 * lack);
        }
    }
    Some(high)
}

fn least_friction_of_pairs(contacts: &[PointContact]) -> f64 {
    let mut least = f64::INFINITY;
    for (i, one) in contacts.iter().enumerate() {
        for other in &contacts[..i] {
            least = least.min(least_friction_of_pair(one, other));
        }
    }
    least
}

/// The least friction of all triples; other contacts may stay idle.
fn least_friction_of_threes(contacts: &[PointContact]) -> f64 {
    let mut least = least_friction_of_pairs(contacts);
    for (i, a) in contacts.iter().enumerate() {
        for (j, b) in contacts[..i].iter().enumerate() {
            for c in &contacts[..j] {
                least = least.min(least_friction_of_three(&[*a, *b, *c]).unwrap_or(f64::INFINITY));
            }
        }
    }
    least
}

/// Root search over the half-angle of the cones, from a friction that is known to suffice.
///
/// The margin is negative below the root. Above it the margin is zero if a contact is not needed, which gives no slope. So
/// Newton's method leads up from below, and growing steps lead down from above; each narrows the bracket.
fn least_friction_by_programmes(contacts: &[PointContact], known: f64) -> f64 {
    let widest_angle = libm::atan(LARGEST_FRICTION);
    let (mut low, mut high) = (0.0, libm::atan(known));
    let mut least = known;
    let mut angle = libm::atan(0.5f64);
    // The step is in units of the resolution.
    let mut step_down = f64::INFINITY;
    if known <= LARGEST_FRICTION {
        step_down = 0.9;
        angle = high - step_down * PROGRAMME_RESOLUTION * libm::cos(high);
    }
    loop {
        let Some(widest) = widest_margin(contacts, angle) else {
            // No forces balance in any cones.
            return f64::INFINITY;
        };
        let balances = widest.balances();
        if balances {
            (high, least) = (angle, libm::tan(angle));
        } else {
            low = angle;
        }
        let resolution = PROGRAMME_RESOLUTION * libm::cos(angle);
        if high - low <= resolution || low >= widest_angle {
            return if low > 0.0 { least } else { 0.0 };
        }
        let newton = angle - widest.margin / widest.slope;
        angle = if !balances {
            step_down = 0.9;
            (newton + 0.5 * resolution)
                .min(0.1 * low + 0.9 * high)
                .min(widest_angle)
        } else if widest.is_open() && newton > low {
            newton
        } else {
            step_down *= 16.0;
            high - (step_down * resolution).min(0.5 * (high - low))
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::closure::contact_forces;
    use crate::sample::{Rng, Task, stream};
    use nalgebra::Vector3;
    use rand::RngExt;

    fn on_sphere(points: &[[f64; 3]]) -> Vec<PointContact> {
        points
            .iter()
            .map(|p| {
                let arm = Vector3::from(*p).normalize();
                PointContact {
                    arm,
                    inward_normal: -arm,
                }
            })
            .collect()
    }

    fn direction(rng: &mut Rng) -> Vector3<f64> {
        loop {
            let v = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
            if (0.01..1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }

    /// A nonzero vector of −1, 0, 1. Sets of these are often symmetric, collinear or coincident.
    fn lattice(rng: &mut Rng) -> Vector3<f64> {
        loop {
            let v = Vector3::from_fn(|_, _| f64::from(rng.random_range(-1..=1)));
            if v.norm() > 0.0 {
                return v;
            }
        }
    }

    /// Three contacts: random, on a sphere, with normals in the plane, in a flat triangle, or on a lattice.
    fn three(kind: u64, rng: &mut Rng) -> [PointContact; 3] {
        let flat = Vector3::new(0.02, 1.0, 1.0);
        std::array::from_fn(|_| {
            let (arm, normal) = match kind {
                0 => (direction(rng) * 2.0, direction(rng)),
                1 => {
                    let arm = direction(rng);
                    (arm, -arm)
                }
                2 => (direction(rng), direction(rng).component_mul(&flat)),
                3 => (
                    direction(rng).component_mul(&Vector3::new(1.0, 1e-2, 1e-2)),
                    direction(rng),
                ),
                _ => (lattice(rng), lattice(rng)),
            };
            PointContact {
                arm,
                inward_normal: normal.normalize(),
            }
        })
    }

    /// The programmes determine balance to about 10⁻¹⁰ of the forces. If two ways to balance end at almost the same
    /// friction, the violation is quadratic in the missing friction, which is then known only to the root of 10⁻¹⁰.
    #[test]
    fn closed_forms_agree_with_programmes() {
        for kind in 0..5 {
            let sets = 200;
            let (mut finite, mut close) = (0, 0);
            for set in 0..sets {
                let contacts = three(kind, &mut stream(kind, Task::Start, set));
                let closed = least_friction(&contacts);
                let solved = least_friction_by_programmes(&contacts, f64::INFINITY);
                assert_eq!(
                    closed.is_finite(),
                    solved.is_finite(),
                    "kind {kind}, set {set}"
                );
                if closed.is_infinite() {
                    close += 1;
                    continue;
                }
                finite += 1;
                let difference = (closed - solved).abs() / closed.max(1.0);
                let limit = if kind < 4 { 2e-5 } else { 1e-3 };
                assert!(
                    difference < limit,
                    "kind {kind}, set {set}: {closed}, solved {solved}"
                );
                close += u64::from(difference < 1e-6);
            }
            assert!(10 * finite > 8 * sets, "kind {kind}: {finite} finite");
            assert!(100 * close > 96 * sets, "kind {kind}: {close} within 1e-6");
        }
    }

    /// Programmes without a start value agree with those that start from the closed forms of all triples.
    #[test]
    fn idle_contacts_change_nothing() {
        for set in 0..100 {
            let mut rng = stream(set, Task::Start, 9);
            let contacts: Vec<PointContact> = (0..4)
                .map(|_| PointContact {
                    arm: direction(&mut rng),
                    inward_normal: direction(&mut rng),
                })
                .collect();
            let known = least_friction_of_threes(&contacts);
            let friction = least_friction(&contacts);
            assert!(friction <= known);
            let solved = least_friction_by_programmes(&contacts, f64::INFINITY);
            assert!(
                (friction - solved).abs() < 1e-5 * friction.max(1.0),
                "set {set}"
            );
        }
    }

    /// Balance does not depend on the unit of arms.
    #[test]
    fn arms_of_any_length() {
        let corners = on_sphere(&[
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.2, 1.0],
        ]);
        let sized = |count: usize, size: f64| -> Vec<PointContact> {
            let arm = |contact: &PointContact| contact.arm * size;
            corners[..count]
                .iter()
                .map(|contact| PointContact {
                    arm: arm(contact),
                    ..*contact
                })
                .collect()
        };
        for count in 2..=4 {
            let least = least_friction(&sized(count, 1.0));
            for size in [1e20, 1e200, 1e307] {
                let contacts = sized(count, size);
                let found = least_friction(&contacts);
                assert!(
                    (found - least).abs() < 1e-6,
                    "{count}, {size}: {found} for {least}"
                );
                let closes = is_force_closure(&contacts, 1.2 * least);
                assert_eq!(closes, is_force_closure(&sized(count, 1.0), 1.2 * least));
                let forces = contact_forces(&contacts, 1.2 * least).unwrap();
                assert!(forces.residual < 1e-9 && forces.violation < 1e-8);
            }
            let endless = sized(count, f64::INFINITY);
            assert!(least_friction(&endless).is_infinite());
            assert!(!is_force_closure(&endless, 0.5));
            assert!(contact_forces(&endless, 0.5).is_none());
        }
    }

    #[test]
    fn three_contacts_at_120_degrees_balance_without_friction() {
        let s = 0.75f64.sqrt();
        let contacts = on_sphere(&[[1.0, 0.0, 0.0], [-0.5, s, 0.0], [-0.5, -s, 0.0]]);
        assert!(least_friction(&contacts) < 1e-12);
        assert!(is_force_closure(&contacts, 0.1));
    }

    #[test]
    fn two_contacts_balance_but_never_close() {
        let contacts = on_sphere(&[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]);
        assert!(least_friction(&contacts) < 1e-12);
        assert!(!is_force_closure(&contacts, 1.0));
    }

    #[test]
    fn two_contacts_at_one_point_balance_halfway() {
        let contact = |angle: f64| PointContact {
            arm: Vector3::new(0.1, 0.2, 0.3),
            inward_normal: Vector3::new(libm::cos(angle), libm::sin(angle), 0.0),
        };
        let pair = [contact(0.0), contact(2.0)];
        let missing = (std::f64::consts::PI - 2.0) / 2.0;
        assert!((least_friction(&pair) - libm::tan(missing)).abs() < 1e-12);
        let apart = [contact(0.0), contact(1.5)];
        assert!(least_friction(&apart).is_infinite());
        // The third contact cannot help: its force would have to act along the line to the other two.
        let far = PointContact {
            arm: Vector3::new(1.0, 0.2, 0.3),
            inward_normal: Vector3::y(),
        };
        let three = least_friction(&[pair[0], pair[1], far]);
        assert!((three - libm::tan(missing)).abs() < 1e-6, "{three}");
    }

    /// A beam on three supports in a row, where sideways forces need not be coplanar.
    #[test]
    fn three_contacts_on_a_line() {
        let at = |x: f64, normal: Vector3<f64>| PointContact {
            arm: Vector3::new(x, 0.0, 0.0),
            inward_normal: normal,
        };
        let bent = [
            at(-1.0, Vector3::z()),
            at(0.5, -Vector3::z()),
            at(1.0, Vector3::z()),
        ];
        assert!(least_friction(&bent) < 1e-7);
        let turned = at(0.5, Vector3::new(0.6, 0.0, -0.8));
        let twisted = [bent[0], turned, bent[2]];
        // The ends push up with 1/3 and 2/3 of the force in the middle, and all three forces lean by the same tangent.
        let friction = least_friction(&twisted);
        let lean = libm::atan(friction);
        assert!(
            (2.0 * lean - libm::atan(0.75f64)).abs() < 1e-6,
            "{friction}"
        );
    }

    #[test]
    fn contacts_on_one_side_never_balance() {
        let contacts = on_sphere(&[[1.0, 0.0, 0.0], [1.0, 0.2, 0.0], [1.0, 0.0, 0.2]]);
        assert!(!is_force_closure(&contacts, 0.5));
        let parallel = [0.0, 1.0, 2.0, 5.0].map(|x: f64| PointContact {
            arm: Vector3::new(x, x * x, 0.0),
            inward_normal: Vector3::z(),
        });
        assert!(least_friction(&parallel[..3]).is_infinite());
        assert!(least_friction(&parallel).is_infinite());
    }
}
