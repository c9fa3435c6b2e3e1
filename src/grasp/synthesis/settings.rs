//! Settings of a synthesis chain.

use serde::{Deserialize, Serialize};

use crate::grasp::grip::GripShares;
use crate::grasp::kernel::StepScales;
use crate::limits::{ATTEMPTS, Beyond, SHARE, STEPS, TEMPERATURE};

/// Sampling method of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampler {
    /// Metropolis-adjusted Langevin steps with an adaptive step for each chain, preconditioned by the actual motion of each
    /// joint; geometric cooling; a distance weight that rises during cooling; heat-bath contact moves.
    Annealed,
    /// Each step is an attempt: a descent from a new start. For smooth energies.
    Descent,
    /// The sampler of the code of Liu et al. (2021): temperature and step size depend on the energy, the gradient is
    /// divided by a running mean of its magnitude, acceptance is plain Metropolis, and contact moves are uniform and forced
    /// by two rejections.
    Released,
}

/// Start pose of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// Every natural coordinate (120 mm, radians) is a standard normal, independent of the object: the authors' start.
    Gaussian,
    /// The palm faces a uniformly drawn point of the object's surface.
    Surface,
    /// The palm faces point number `chain` of an even sequence over the object's surface.
    EvenSurface,
}

/// How one contact of the set is replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactMoves {
    /// Drawn from its distribution given the pose and the other contacts.
    HeatBath,
    /// Drawn uniformly from all surface points and accepted by Metropolis.
    Uniform,
}

/// Refinement of the end of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Refinement {
    /// Descent to a local minimum of the envelope.
    Quench,
    /// Descent to a local minimum with a fixed contact set, as in the text of the paper.
    Held,
    /// A thousand noisy steps at temperature 0.001 with a fixed contact set, as in the authors' code.
    Noisy,
    /// Descent to a local minimum of the envelope, after which the hand is closed until it presses
    /// ([`close_hand`](crate::grasp::closing::close_hand)). An attempt then must also be [preloaded](crate::grasp::closing::Preload::is_sufficient)
    /// to count as a grasp.
    Pressed,
    /// No refinement.
    None,
}

/// Settings of a synthesis chain. The default is [`SynthesisSettings::closed`]; values that are missing where settings are
/// read are those of [`SynthesisSettings::four_points`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default = "SynthesisSettings::four_points")]
pub struct SynthesisSettings {
    /// Sampling method.
    pub sampler: Sampler,
    /// Start pose.
    pub start: Start,
    /// Number of poses drawn for the start, all facing the same point of the object. The one with the best
    /// [`GraspEnergy::start_score`](crate::grasp::GraspEnergy::start_score) is used.
    pub start_candidates: u32,
    /// Number of steps of a chain, with one energy evaluation each; for [`Sampler::Descent`] the greatest number
    /// of descents, each of which is an attempt.
    pub steps: u32,
    /// Number of attempts from new starts (with [`Start::EvenSurface`], at the same point of the object) that share the
    /// steps (not of [`Sampler::Descent`]). The first whose refined end passes the strict filter ends the chain; otherwise the end of least energy
    /// counts.
    pub attempts: u32,
    /// Temperature of the first step (annealed sampler).
    pub temperature_start: f64,
    /// First temperature from a given grasp (annealed sampler): enough to leave a shallow minimum, not to lose the grasp.
    pub given_temperature: f64,
    /// Temperature of the last step (annealed sampler).
    pub temperature_end: f64,
    /// Fraction of the distance weight at the first step (annealed sampler): force closure first, contact later.
    pub ramp_start: f64,
    /// Fraction of the steps after which the full weight is reached.
    pub ramp_share: f64,
    /// Whether the weights of depths rise with the distance weight, so that the hand may first pass through the object. It
    /// is ignored for objects that consist mostly of thin walls, in which a hand would stay
    /// ([`Object::thin_share`](crate::object::Object::thin_share)).
    pub ramp_depths: bool,
    /// Probability of a contact move: 1 − ρ.
    pub contact_probability: f64,
    /// Kind of contact moves (annealed sampler).
    pub contact_moves: ContactMoves,
    /// Scaling of the noise of pose moves (annealed sampler).
    pub step_scales: StepScales,
    /// Target acceptance rate of pose moves for the step-size adaptation (annealed sampler).
    pub acceptance: f64,
    /// Frequencies of the parts of the hand that take part (descents with an energy of an elastic layer).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grips: Option<GripShares>,
    /// Refinement of the end.
    pub refinement: Refinement,
}

impl Default for SynthesisSettings {
    fn default() -> Self {
        Self::closed()
    }
}

impl SynthesisSettings {
    /// Annealed chains for the energy of the best set of four points
    /// ([`EnergySettings::four_points`](crate::grasp::EnergySettings::four_points)).
    pub fn four_points() -> Self {
        Self {
            sampler: Sampler::Annealed,
            start: Start::EvenSurface,
            start_candidates: 200,
            steps: 10_000,
            attempts: 20,
            temperature_start: 0.1,
            given_temperature: 0.005,
            temperature_end: 0.002,
            ramp_start: 0.02,
            ramp_share: 0.8,
            ramp_depths: true,
            contact_probability: 0.2,
            contact_moves: ContactMoves::HeatBath,
            step_scales: StepScales::Levers,
            acceptance: 0.57,
            grips: None,
            refinement: Refinement::Quench,
        }
    }

    /// Descents for the energy of an elastic layer ([`EnergySettings::closed`](crate::grasp::EnergySettings::closed)).
    pub fn closed() -> Self {
        Self {
            sampler: Sampler::Descent,
            grips: Some(GripShares::default()),
            start_candidates: 1,
            steps: 24,
            attempts: 1,
            ..Self::four_points()
        }
    }

    /// The paper's Algorithm 1 with ρ = 0.85 and with details that its text leaves out.
    pub fn paper() -> Self {
        Self {
            sampler: Sampler::Released,
            start: Start::Gaussian,
            start_candidates: 1,
            attempts: 1,
            contact_probability: 0.15,
            refinement: Refinement::Held,
            ..Self::four_points()
        }
    }

    /// The authors' code, including refinement.
    pub fn released() -> Self {
        Self {
            refinement: Refinement::Noisy,
            ..Self::paper()
        }
    }

    /// Describes the first invalid value in one sentence.
    ///
    /// # Errors
    /// If a probability, fraction or temperature is out of its range, or there are no attempts.
    pub fn validate(&self) -> Result<(), SynthesisSettingsError> {
        let settings = [
            ("temperature_start", TEMPERATURE, self.temperature_start),
            ("given_temperature", TEMPERATURE, self.given_temperature),
            ("temperature_end", TEMPERATURE, self.temperature_end),
            ("ramp_start", SHARE, self.ramp_start),
            ("ramp_share", SHARE, self.ramp_share),
            ("contact_probability", SHARE, self.contact_probability),
            ("acceptance", SHARE, self.acceptance),
            ("steps", STEPS, self.steps.into()),
            ("attempts", ATTEMPTS, self.attempts.into()),
            ("start_candidates", ATTEMPTS, self.start_candidates.into()),
        ];
        let grips = self.grips.iter().flat_map(GripShares::values);
        let settings = settings.into_iter().chain(grips);
        for (name, limit, value) in settings {
            let told = |beyond| SynthesisSettingsError { name, beyond };
            limit.check(value).map_err(told)?;
        }
        Ok(())
    }
}

/// A synthesis setting is out of its range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} = {beyond}")]
pub struct SynthesisSettingsError {
    name: &'static str,
    beyond: Beyond,
}
