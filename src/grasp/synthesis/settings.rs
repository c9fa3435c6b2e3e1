//! Settings of a synthesis chain.

use serde::{Deserialize, Serialize};

use crate::grasp::kernel::StepScales;
use crate::limits::{ATTEMPTS, Beyond, SHARE, STEPS, TEMPERATURE};

/// How a chain moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampler {
    /// Metropolis-adjusted Langevin steps with an adaptive step per chain, preconditioned by what each joint really
    /// moves; geometric cooling; the distance weight rises while the chain cools; heat-bath contact moves.
    Annealed,
    /// The sampler of the authors of Liu et al. (2021) as their code has it: temperature and step size are functions of
    /// the energy, the gradient is divided by a running mean of its magnitude, plain Metropolis acceptance, uniform
    /// contact moves, and two rejections in a row force a contact move.
    Released,
}

/// Where a chain starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// Every natural coordinate (120 mm, radians) a standard normal, whatever the object: the authors' start.
    Gaussian,
    /// The palm faces a point drawn uniformly from the object's surface.
    Surface,
    /// The palm faces point number `chain` of a sequence that fills the object's surface evenly.
    EvenSurface,
}

/// How one contact of the set is replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactMoves {
    /// Drawn from its law given the pose and the other contacts.
    HeatBath,
    /// Any surface point with equal probability, accepted by Metropolis.
    Uniform,
}

/// What follows a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Refinement {
    /// Descent to a local minimum of the envelope.
    Quench,
    /// Descent to a local minimum with the contact set held: what the text of the paper says.
    Held,
    /// A thousand noisy steps of the chain at temperature 0.001 with the contact set held, as the authors' code has it
    /// (their text says gradient descent).
    Noisy,
    /// Descent to a local minimum of the envelope, then the hand is closed until it presses
    /// ([`press`](crate::grasp::press::press)). An attempt then counts as a grasp where it is
    /// [firm](crate::grasp::press::Firmness::is_firm), too.
    Pressed,
    /// Nothing.
    None,
}

/// Settings of a synthesis chain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SynthesisSettings {
    /// How a chain moves.
    pub sampler: Sampler,
    /// Where it starts.
    pub start: Start,
    /// So many poses are drawn for the start, all facing the same point of the object; the most promising one is taken
    /// ([`GraspEnergy::start_score`](crate::grasp::GraspEnergy::start_score)).
    pub start_candidates: u32,
    /// Steps of a chain; one energy evaluation each.
    pub steps: u32,
    /// The steps are divided among so many attempts from new starts (with [`Start::EvenSurface`], at the same point of the
    /// object). The first whose refined end passes the strict filter ends the chain; if none does, the end of least energy counts.
    pub attempts: u32,
    /// Temperature of the first step (annealed sampler).
    pub temperature_start: f64,
    /// Temperature of the first step of a chain that starts from a given grasp: enough to leave a shallow minimum, not to
    /// forget the grasp (annealed sampler).
    pub given_temperature: f64,
    /// Temperature of the last step (annealed sampler).
    pub temperature_end: f64,
    /// Share of the distance weight at the first step (annealed sampler): force closure first, contact later.
    pub ramp_start: f64,
    /// Share of the steps after which the full weight is reached.
    pub ramp_share: f64,
    /// Whether the weights of depths rise with the distance weight, so that the hand may first pass through the object. Not
    /// on objects most of whose surface is that of a thin wall, in which a hand would stay
    /// ([`Object::thin_share`](crate::object::Object::thin_share)).
    pub ramp_depths: bool,
    /// Probability of a contact move: 1 − ρ.
    pub contact_probability: f64,
    /// How contacts move (annealed sampler).
    pub contact_moves: ContactMoves,
    /// What the noise of pose moves is scaled with (annealed sampler).
    pub step_scales: StepScales,
    /// Acceptance rate of pose moves that the step size is adapted to (annealed sampler).
    pub acceptance: f64,
    /// What follows.
    pub refinement: Refinement,
}

impl Default for SynthesisSettings {
    fn default() -> Self {
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
            refinement: Refinement::Quench,
        }
    }
}

impl SynthesisSettings {
    /// The paper's Algorithm 1 with ρ = 0.85 and what its text leaves out.
    pub fn paper() -> Self {
        Self {
            sampler: Sampler::Released,
            start: Start::Gaussian,
            start_candidates: 1,
            attempts: 1,
            contact_probability: 0.15,
            refinement: Refinement::Held,
            ..Self::default()
        }
    }

    /// What the authors' code does, refinement included.
    pub fn released() -> Self {
        Self {
            refinement: Refinement::Noisy,
            ..Self::paper()
        }
    }

    /// One clear sentence on the first value that makes no sense.
    ///
    /// # Errors
    /// If a probability, share or temperature is out of its range, or there is no attempt.
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
        for (name, limit, value) in settings {
            let told = |beyond| SynthesisSettingsError { name, beyond };
            limit.check(value).map_err(told)?;
        }
        Ok(())
    }
}

/// A synthesis setting out of its range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} = {beyond}")]
pub struct SynthesisSettingsError {
    name: &'static str,
    beyond: Beyond,
}
