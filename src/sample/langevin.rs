//! The Metropolis-adjusted Langevin step that every kernel shares.

use rand_distr::{Distribution, StandardNormal};

use super::{Law, Rng, State};
use crate::space::Space;

/// Distances to the target of an attraction are rounded off within this length, so that the pull has a direction (none)
/// at the target itself.
const ROUNDING: f64 = 1e-6;

impl Law<'_> {
    /// Altered energy E + F·d(x, x*) at `x` with energy `energy`; adds the pull to `gradient`.
    pub fn alter(&self, space: &dyn Space, x: &[f64], energy: f64, gradient: &mut [f64]) -> f64 {
        let Some(attraction) = &self.attraction else {
            return energy;
        };
        let mut tangent = vec![0.0; space.tangents()];
        let distance = space.toward(x, attraction.target, &mut tangent);
        let rounded = distance.hypot(ROUNDING);
        for (g, t) in gradient.iter_mut().zip(&tangent) {
            *g -= attraction.force * t / rounded;
        }
        energy + attraction.force * rounded
    }
}

/// Proposes a preconditioned Langevin step from `state` under `law` and returns the logarithm of its exact
/// Metropolis–Hastings ratio (−∞ where the energy is not finite).
///
/// ```text
/// u = −½ ε² P ∇A/T + ε P^½ ξ,   x' = shift(x, u),   A = E + F d(x, x*),   P = diag(scales²),   ξ ~ N(0, I)
/// log r = (A(x) − A(x'))/T + log q(x' → x) − log q(x → x')
/// ```
///
/// The reverse move is −u (see [`Space::shift`]). `evaluate` gives the unaltered energy and gradient at a point; the
/// proposal's coordinates, energy and gradient are written, its discrete part is left alone. G. O. Roberts and
/// R. L. Tweedie, Bernoulli 2, 341 (1996).
#[expect(
    clippy::too_many_arguments,
    reason = "one formula, each argument a symbol of it"
)]
pub fn langevin(
    space: &dyn Space,
    scales: &[f64],
    state: &State,
    law: &Law<'_>,
    step: f64,
    rng: &mut Rng,
    proposal: &mut State,
    evaluate: impl FnOnce(&[f64], &mut [f64]) -> f64,
) -> f64 {
    let temperature = law.temperature;
    let mut drift = state.gradient.clone();
    let here = law.alter(space, &state.coordinates, state.energy, &mut drift);
    let mut forward = 0.0;
    let mut tangent = drift;
    for (component, scale) in tangent.iter_mut().zip(scales) {
        let noise: f64 = StandardNormal.sample(rng);
        forward += noise * noise;
        *component =
            -0.5 * (step * scale).powi(2) * *component / temperature + step * scale * noise;
    }
    proposal.coordinates.clone_from(&state.coordinates);
    space.shift(&mut proposal.coordinates, &tangent);
    proposal.gradient.resize(tangent.len(), 0.0);
    proposal.energy = evaluate(&proposal.coordinates, &mut proposal.gradient);
    if !proposal.energy.is_finite() {
        return f64::NEG_INFINITY;
    }
    let mut pull = proposal.gradient.clone();
    let there = law.alter(space, &proposal.coordinates, proposal.energy, &mut pull);
    let mut backward = 0.0;
    for ((u, g), scale) in tangent.iter().zip(&pull).zip(scales) {
        let noise = (-u + 0.5 * (step * scale).powi(2) * g / temperature) / (step * scale);
        backward += noise * noise;
    }
    (here - there) / temperature + 0.5 * (forward - backward)
}
