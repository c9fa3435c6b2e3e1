//! FIRE: relaxation by forces where no energy exists (a string).

use crate::space::vector::{dot, norm, scale};

/// Parameters of the published method.
const GROW: f64 = 1.1;
const SHRINK: f64 = 0.5;
const MIXING: f64 = 0.25;
const MIXING_SHRINK: f64 = 0.99;
const DELAY: usize = 5;
/// Length of the first step as a share of the longest step.
const FIRST: f64 = 0.1;

/// The fast inertial relaxation engine, which turns forces into displacements. Each call is one iteration.
///
/// ```text
/// v ← v + f Δt,   v ← (1 − α) v + α |v| f/|f|,   Δx = v Δt (half of it back, and v = 0, when f·v ≤ 0)
/// ```
///
/// E. Bitzek et al., Phys. Rev. Lett. 97, 170201 (2006), in the semi-implicit form of J. Guénolé et al., Comput. Mater.
/// Sci. 175, 109584 (2020). The first time step is such that the displacement is a tenth of the longest one allowed, so no
/// unit of time has to be chosen.
#[derive(Debug, Clone)]
pub struct Fire {
    longest: f64,
    time_step: Option<f64>,
    mixing: f64,
    uphill_free: usize,
    velocity: Vec<f64>,
}

impl Fire {
    /// Starts at rest in `dimensions` dimensions, with displacements of at most `longest` per iteration.
    pub fn new(dimensions: usize, longest: f64) -> Self {
        Self {
            longest,
            time_step: None,
            mixing: MIXING,
            uphill_free: 0,
            velocity: vec![0.0; dimensions],
        }
    }

    /// Writes the displacement for `force`.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn advance(&mut self, force: &[f64], displacement: &mut [f64]) {
        let n = self.velocity.len();
        assert_eq!((force.len(), displacement.len()), (n, n));
        let size = norm(force);
        if size == 0.0 || !size.is_finite() {
            displacement.fill(0.0);
            return;
        }
        let mut time_step = *self
            .time_step
            .get_or_insert_with(|| (FIRST * self.longest / size).sqrt());
        let power = dot(force, &self.velocity);
        let mut back = 0.0;
        if power > 0.0 {
            self.uphill_free += 1;
            if self.uphill_free > DELAY {
                time_step *= GROW;
                self.mixing *= MIXING_SHRINK;
            }
        } else if norm(&self.velocity) > 0.0 {
            back = -0.5 * time_step;
            self.uphill_free = 0;
            time_step *= SHRINK;
            self.mixing = MIXING;
        }
        for (d, v) in displacement.iter_mut().zip(&self.velocity) {
            *d = back * v;
        }
        if back != 0.0 {
            self.velocity.fill(0.0);
        }
        for (v, f) in self.velocity.iter_mut().zip(force) {
            *v += time_step * f;
        }
        let speed = norm(&self.velocity);
        for ((d, v), f) in displacement.iter_mut().zip(&mut self.velocity).zip(force) {
            *v = (1.0 - self.mixing) * *v + self.mixing * speed * f / size;
            *d += time_step * *v;
        }
        let length = norm(displacement);
        if length > self.longest {
            scale(displacement, self.longest / length);
            scale(&mut self.velocity, self.longest / length);
        }
        self.time_step = Some(time_step);
    }

    /// Sets the velocity to zero and shortens the time step, because the last displacement was refused.
    pub fn refuse(&mut self) {
        self.velocity.fill(0.0);
        self.uphill_free = 0;
        self.mixing = MIXING;
        self.time_step = self.time_step.map(|t| t * SHRINK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settles_in_an_anisotropic_bowl() {
        let (mut x, mut fire) = ([3.0, -2.0], Fire::new(2, 0.5));
        let mut step = [0.0; 2];
        for _ in 0..400 {
            fire.advance(&[-x[0], -50.0 * x[1]], &mut step);
            x[0] += step[0];
            x[1] += step[1];
            assert!(norm(&step) <= 0.5 + 1e-12);
        }
        assert!(norm(&x) < 1e-6, "{x:?}");
    }

    #[test]
    fn no_force_no_motion() {
        let mut step = [1.0; 3];
        Fire::new(3, 1.0).advance(&[0.0; 3], &mut step);
        assert!(norm(&step) == 0.0);
    }
}
