//! The Metropolis-adjusted Langevin step that all kernels share.

use crate::sample::standard_normal;

use super::{Attraction, Rng, State, TargetDensity};
use crate::space::Space;
use crate::space::vector::{add, norm};

/// Proposes a preconditioned Langevin step from `state` under `law` and returns the logarithm of its exact
/// Metropolis–Hastings ratio (−∞ if the energy is not finite).
///
/// ```text
/// u = −½ ε² P ∇A/T + ε P^½ ξ,   x' = exp(x, u),   A = E + F d(x, x*),   P = diag(scales²),   ξ ~ N(0, I)
/// log r = (A(x) − A(x'))/T + log q(x' → x) − log q(x → x')
/// ```
///
/// P: squares of `scales`; ε: `step`, a length. Near the target d is rounded to √(d² + ε²), whose gradient is not singular.
/// The chain samples the law of the rounded distance, so ε must stay fixed if exact averages are needed.
///
/// The reverse step is −u (see [`Space::exp`]). `evaluate` gives the unaltered energy and gradient at a point. The
/// proposal is written. G. O. Roberts and R. L. Tweedie, Bernoulli 2, 341 (1996).
#[expect(
    clippy::too_many_arguments,
    reason = "one formula, each argument a symbol of it"
)]
pub fn langevin(
    space: &dyn Space,
    scales: &[f64],
    state: &State,
    law: &TargetDensity<'_>,
    step: f64,
    rng: &mut Rng,
    proposal: &mut State,
    evaluate: impl FnOnce(&[f64], &mut [f64]) -> f64,
) -> f64 {
    let temperature = law.temperature;
    let mut drift = state.gradient.clone();
    let here = state.energy + pull(space, law, &state.coordinates, step, &mut drift);
    let mut forward = 0.0;
    let mut tangent = drift;
    for (component, scale) in tangent.iter_mut().zip(scales) {
        let noise = standard_normal(rng);
        forward += noise * noise;
        *component =
            -0.5 * (step * scale).powi(2) * *component / temperature + step * scale * noise;
    }
    proposal.coordinates.clone_from(&state.coordinates);
    space.exp(&mut proposal.coordinates, &tangent);
    proposal.gradient.resize(tangent.len(), 0.0);
    proposal.energy = evaluate(&proposal.coordinates, &mut proposal.gradient);
    if !proposal.energy.is_finite() {
        return f64::NEG_INFINITY;
    }
    let mut slope = proposal.gradient.clone();
    let there = proposal.energy + pull(space, law, &proposal.coordinates, step, &mut slope);
    let mut backward = 0.0;
    for ((u, g), scale) in tangent.iter().zip(&slope).zip(scales) {
        let noise = (-u + 0.5 * (step * scale).powi(2) * g / temperature) / (step * scale);
        backward += noise * noise;
    }
    (here - there) / temperature + 0.5 * (forward - backward)
}

/// F √(d² + rounding²); adds its gradient to `slope`.
pub(super) fn pull(
    space: &dyn Space,
    law: &TargetDensity<'_>,
    x: &[f64],
    rounding: f64,
    slope: &mut [f64],
) -> f64 {
    let Some(Attraction { target, force }) = law.attraction else {
        return 0.0;
    };
    let mut toward = vec![0.0; slope.len()];
    space.log_near(x, target, &mut toward);
    let distance = libm::hypot(norm(&toward), rounding);
    add(slope, -force / distance, &toward);
    force * distance
}
