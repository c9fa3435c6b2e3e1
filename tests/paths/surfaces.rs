//! Surfaces whose paths are known.

use landscape::energy::model::Orientation;
use landscape::energy::{Energy, Explain};
use landscape::sample::{Kernel, Rng, State, TargetDensity};
use landscape::space::{Euclidean, Space};

/// −Σ cᵢ qᵢ⁴ + b w³x³. The minima w and x differ by half a turn about x. The term with b lowers one of the two ways around
/// without moving the minima. With equal weights c its top lies at 45°, at −c/2 − |b|/8; the other top lies at −c/2 +
/// |b|/8.
pub(crate) struct Turn {
    pub(crate) even: Orientation,
    pub(crate) twist: f64,
}

impl Energy for Turn {
    fn space(&self) -> &dyn Space {
        self.even.space()
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let even = self.even.evaluate(x, gradient);
        let norm = x.iter().map(|q| q * q).sum::<f64>().sqrt();
        let [w, i, j, k] = [0, 1, 2, 3].map(|n| x[n] / norm);
        // dq = ½ q ∘ (0, u) for a turn u in the body's frame.
        let slope = [3.0 * w * w * i * i * i, 3.0 * w * w * w * i * i];
        for (g, turn) in gradient.iter_mut().zip([[-i, w], [-j, -k], [-k, j]]) {
            *g += 0.5 * self.twist * (slope[0] * turn[0] + slope[1] * turn[1]);
        }
        even + self.twist * w * w * w * i * i * i
    }
}

/// −Σ exp(−d²/2w²) over some centres. It is equal for all poses that the space identifies.
pub(crate) struct Wells<S> {
    pub(crate) space: S,
    pub(crate) centres: Vec<Vec<f64>>,
    pub(crate) width: f64,
}

impl<S: Space> Energy for Wells<S> {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        let mut toward = vec![0.0; gradient.len()];
        let mut energy = 0.0;
        for centre in &self.centres {
            let distance = self.space.log(x, centre, &mut toward);
            let square = self.width * self.width;
            let depth = libm::exp(-0.5 * distance * distance / square);
            energy -= depth;
            for (g, t) in gradient.iter_mut().zip(&toward) {
                *g -= depth * t / square;
            }
        }
        energy
    }
}

/// (x² − 1)² + 3 y² with a ridge across that is so narrow that it fits between two images.
pub(crate) struct Ridge(pub(crate) Euclidean);

impl Energy for Ridge {
    fn space(&self) -> &dyn Space {
        &self.0
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let (well, off) = (x[0] * x[0] - 1.0, (x[0] - 0.375) / 0.016);
        let ridge = libm::exp(-0.5 * off * off);
        gradient[0] = 4.0 * x[0] * well - ridge * off / 0.016;
        gradient[1] = 6.0 * x[1];
        well * well + 3.0 * x[1] * x[1] + ridge
    }
}

/// 5 (r² − 1)² + (y + 0.3)²: two minima on a ring, with a low path below and a high path above. Below −0.6 it objects.
pub(crate) struct Ring(pub(crate) Euclidean);

impl Ring {
    fn parts(x: &[f64]) -> [f64; 2] {
        let off = x[0] * x[0] + x[1] * x[1] - 1.0;
        [5.0 * off * off, (x[1] + 0.3) * (x[1] + 0.3)]
    }
}

impl Energy for Ring {
    fn space(&self) -> &dyn Space {
        &self.0
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let off = x[0] * x[0] + x[1] * x[1] - 1.0;
        gradient[0] = 20.0 * off * x[0];
        gradient[1] = 20.0 * off * x[1] + 2.0 * (x[1] + 0.3);
        Self::parts(x).iter().sum()
    }

    fn explain(&self) -> Option<&dyn Explain> {
        Some(self)
    }
}

impl Explain for Ring {
    fn terms(&self, x: &[f64]) -> Vec<(String, f64)> {
        let names = ["ring", "height"].map(str::to_owned);
        names.into_iter().zip(Self::parts(x)).collect()
    }

    fn invalid_reason(&self, x: &[f64]) -> Option<String> {
        (x[1] < -0.6).then(|| "through the object".to_owned())
    }
}

/// Pulls every chain over the top of the ring.
pub(crate) struct Guide<'a>(pub(crate) &'a Ring);

impl Kernel for Guide<'_> {
    fn space(&self) -> &dyn Space {
        self.0.space()
    }

    fn start(&self, x: &[f64]) -> State {
        let mut gradient = vec![0.0; 2];
        State {
            coordinates: x.to_vec(),
            energy: self.0.evaluate(x, &mut gradient),
            gradient,
        }
    }

    fn propose(
        &self,
        state: &State,
        law: &TargetDensity<'_>,
        _: f64,
        _: &mut Rng,
        proposal: &mut State,
    ) -> f64 {
        let target = law.attraction.as_ref().unwrap().target;
        let x = &state.coordinates;
        let turn = if target[0] > 0.0 { -0.05 } else { 0.05 };
        let angle = libm::atan2(x[1], x[0]) + turn;
        *proposal = self.start(&[libm::cos(angle), libm::sin(angle)]);
        f64::INFINITY
    }
}
