//! The potential of an elastic contact whose force stays in its friction cone.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined uses the vector instructions chosen at run time"
)]

/// The potential ψ of a contact whose layer is displaced by u = a n + T t (unit tangent t) against the object, and its
/// derivatives. Its gradient is the contact force, which lies in the friction cone, but for a rounding.
///
/// ```text
/// ψ(u) = (h_δ(a + μ T) + h_μδ(μ a − T)) / (1 + μ²) − ψ(0),    h_δ'' = 0 below −δ, 1 above δ, a smooth step between
/// ```
///
/// Without rounding, h(s) = ½ max(0, s)² and ψ is half the squared norm of the projection of u on Coulomb's cone. This is the
/// conjugate of ½ |f|² over forces f in that cone (Moreau 1965, *Bulletin de la Société Mathématique de France* 93, 273). The
/// rounding is ours: in the proportion μ for the two parts it keeps ψ convex and its derivative by T zero at T = 0.
#[derive(Clone, Copy)]
pub(super) struct Potential {
    pub(super) value: f64,
    /// n·u.
    pub(super) normal: f64,
    /// |u − n (n·u)|, not below the smallest number.
    pub(super) tangential: f64,
    /// The force `along` n + `across` t.
    pub(super) along: f64,
    pub(super) across: f64,
    /// The second derivative is p I + q nnᵀ + r (ntᵀ + tnᵀ) + z ttᵀ.
    pub(super) p: f64,
    pub(super) q: f64,
    pub(super) r: f64,
    pub(super) z: f64,
}

/// h of [`Potential`] with its first and second derivative.
#[inline(always)]
fn hinge(s: f64, rounding: f64, half_inverse: f64) -> [f64; 3] {
    let t = ((s + rounding) * half_inverse).clamp(0.0, 1.0);
    let beyond = (s - rounding).max(0.0);
    let width = 2.0 * rounding;
    let square = t * t;
    // Integrals of t² (3 − 2 t).
    let bend = square * (3.0 - 2.0 * t);
    let slope = square * t * (1.0 - 0.5 * t);
    let value = square * square * (0.25 - 0.1 * t);
    [
        width * width * value + beyond * (rounding + 0.5 * beyond),
        width * slope + beyond,
        bend,
    ]
}

/// Constants of [`Potential`].
#[derive(Clone, Copy)]
pub(super) struct Cone {
    mu: f64,
    /// 1 / (1 + μ²).
    share: f64,
    rounding: f64,
    half_inverse: f64,
    inner_rounding: f64,
    inner_half_inverse: f64,
    at_rest: f64,
}

impl Cone {
    pub(super) fn new(mu: f64, rounding: f64) -> Self {
        // A cone without friction has no inner part.
        let inner_rounding = mu.max(f64::EPSILON) * rounding;
        let mut cone = Self {
            mu,
            share: 1.0 / (1.0 + mu * mu),
            rounding,
            half_inverse: 0.5 / rounding,
            inner_rounding,
            inner_half_inverse: 0.5 / inner_rounding,
            at_rest: 0.0,
        };
        cone.at_rest = Potential::of(0.0, 0.0, &cone).value;
        cone
    }
}

impl Potential {
    #[inline(always)]
    pub(super) fn of(normal: f64, tangential_squared: f64, cone: &Cone) -> Self {
        let (mu, c) = (cone.mu, cone.share);
        let tangential = tangential_squared.max(f64::MIN_POSITIVE).sqrt();
        let [h, h1, h2] = hinge(normal + mu * tangential, cone.rounding, cone.half_inverse);
        let [k, k1, k2] = hinge(
            mu * normal - tangential,
            cone.inner_rounding,
            cone.inner_half_inverse,
        );
        let across = c * (mu * h1 - k1);
        let tt = c * (mu * mu * h2 + k2);
        // Both terms of `across` cancel at T = 0, where the quotient is its derivative.
        let p = if tangential > 1e-6 * cone.inner_rounding {
            across / tangential
        } else {
            tt
        };
        Self {
            value: c * (h + k) - cone.at_rest,
            normal,
            tangential,
            along: c * (h1 + mu * k1),
            across,
            p,
            q: c * (h2 + mu * mu * k2) - p,
            r: c * mu * (h2 - k2),
            z: tt - p,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Task, stream};
    use rand::RngExt;

    /// The rounded potential tends to half the squared norm of the projection on the cone; its force and second derivative
    /// are its derivatives, also within the rounding.
    #[test]
    fn the_potential_is_a_rounded_projection() {
        let mut rng = stream(3, Task::Start, 0);
        for _ in 0..200 {
            let (normal, tangential) = (
                rng.random_range(-0.1..0.1_f64),
                rng.random_range(0.001..0.1_f64),
            );
            let at = |rounding: f64, normal: f64, tangential: f64| {
                Potential::of(normal, tangential * tangential, &Cone::new(0.3, rounding))
            };
            let sharp = at(1e-9, normal, tangential);
            let projected = if tangential <= 0.3 * normal {
                libm::hypot(normal, tangential)
            } else {
                (normal + 0.3 * tangential).max(0.0) / 1.09_f64.sqrt()
            };
            assert!((sharp.value - 0.5 * projected * projected).abs() < 1e-9);

            let (here, step) = (at(0.05, normal, tangential), 1e-6);
            let [right, left] = [step, -step].map(|h| at(0.05, normal + h, tangential));
            let [out, inward] = [step, -step].map(|h| at(0.05, normal, tangential + h));
            let slope = |ahead: f64, behind: f64| (ahead - behind) / (2.0 * step);
            let checks = [
                (here.along, slope(right.value, left.value)),
                (here.across, slope(out.value, inward.value)),
                (here.p + here.q, slope(right.along, left.along)),
                (here.r, slope(right.across, left.across)),
                (here.p + here.z, slope(out.across, inward.across)),
                (here.p * tangential, here.across),
            ];
            for (analytic, estimate) in checks {
                assert!((analytic - estimate).abs() < 1e-7, "{analytic} {estimate}");
            }
        }
    }
}
