//! Markov chains on a [`Space`]: the trait of kernels and reproducible random streams.

mod mala;

pub use mala::Mala;
use rand::SeedableRng;

use crate::space::Space;

mod langevin;
mod normal;

pub use langevin::langevin;
pub use normal::standard_normal;

/// The random generator of every chain. It is counter-based, so that streams are cheap and independent.
pub type Rng = rand_chacha::ChaCha8Rng;

/// Purpose of a random stream. The stream is named by the purpose, the seed and the number of the task, so adding a task of
/// one kind never changes the draws of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
#[non_exhaustive]
pub enum Task {
    /// Random starting points.
    Start = 1,
    /// One synthesis chain.
    Synthesis = 2,
    /// One attraction–diffusion chain.
    AttractionDiffusion = 3,
    /// Basin hopping.
    BasinHopping = 4,
    /// Saddle searches.
    Saddle = 5,
    /// Placing surface points.
    Surface = 6,
    /// Layout of a picture.
    Layout = 7,
    /// Resampling of a network.
    Resampling = 9,
    /// One chain of sequential ADELM.
    Sequential = 10,
    /// One chain that chooses temperature and force.
    Tuning = 12,
    /// Choosing the ends and the temperature of a search across a merge.
    Search = 13,
    /// Permuted labels and resampled cases.
    Permutation = 20,
    /// Resampled members of a sample whose diversity is measured.
    Diversity = 21,
}

/// Random stream of task number `id` of kind `task` under `seed`.
pub fn stream(seed: u64, task: Task, id: u64) -> Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8] = task as u8;
    key[16..24].copy_from_slice(&id.to_le_bytes());
    Rng::from_seed(key)
}

/// A state of a chain: a point and its energy.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct State {
    /// The point of the space.
    pub coordinates: Vec<f64>,
    /// *Unaltered* energy.
    pub energy: f64,
    /// Derivative of `energy` along each tangent at `coordinates`.
    pub gradient: Vec<f64>,
}

/// A constant force (energy per length) toward `target`: F = αT of attraction–diffusion.
#[derive(Debug, Clone, Copy)]
pub struct Attraction<'a> {
    /// Coordinates of the target: the copy that the chain set out for ([`Space::log_near`] leads to it).
    pub target: &'a [f64],
    /// Magnitude of the force, energy per length of the space.
    pub force: f64,
}

/// The distribution that a chain samples: density ∝ exp(−(E + F·d(x, x*))/T).
#[derive(Debug, Clone, Copy)]
pub struct TargetDensity<'a> {
    /// Temperature T, in units of the energy.
    pub temperature: f64,
    /// The attraction F·d(x, x*), if any.
    pub attraction: Option<Attraction<'a>>,
}

/// A Markov kernel. Distances between states use the coordinates only.
pub trait Kernel: Sync {
    /// The space of the coordinates.
    fn space(&self) -> &dyn Space;

    /// The state at coordinates `x`.
    fn start(&self, x: &[f64]) -> State;

    /// Writes a proposal from `state` into `proposal` and returns the logarithm of its Metropolis–Hastings acceptance ratio
    /// under `law` (−∞ refuses it), so that different kinds of steps mix correctly. `step` scales continuous steps.
    fn propose(
        &self,
        state: &State,
        law: &TargetDensity<'_>,
        step: f64,
        rng: &mut Rng,
        proposal: &mut State,
    ) -> f64;
}
