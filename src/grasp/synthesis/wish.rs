//! What a chain can be asked for.

use crate::grasp::GraspEnergy;
use crate::grasp::grip::Parts;
use crate::sample::Rng;

/// What a chain is to find. It chooses starts and the parts that close first, and judges ends; the energy of the landscape
/// stays what it is.
pub trait Wish: Sync {
    /// The first pose of attempt number `attempt` of chain number `chain`, and the parts of the hand that close from there.
    fn begin(
        &self,
        energy: &GraspEnergy,
        chain: u64,
        attempt: u32,
        rng: &mut Rng,
    ) -> (Vec<f64>, Parts);

    /// Whether a pose is what was asked for.
    fn grants(&self, energy: &GraspEnergy, pose: &[f64]) -> bool;
}
