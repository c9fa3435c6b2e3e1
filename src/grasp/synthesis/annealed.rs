//! The annealed sampler.

use rand::RngExt;

use super::{ContactMoves, Observe, SynthesisSettings, accept};
use crate::grasp::energy::{GraspEnergy, Ramp};
use crate::grasp::kernel::GraspKernel;
use crate::sample::{Rng, State, TargetDensity};

/// Steps between two changes of the weights. Each change costs one more evaluation.
const RAMP_EVERY: u32 = 50;

/// Length of the first step. It adapts within 100 to 200 steps.
const FIRST_STEP_M: f64 = 0.003;

/// Temperature and weights along a chain.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schedule {
    pub(super) steps: u32,
    pub(super) temperature_start: f64,
    pub(super) temperature_end: f64,
    pub(super) ramp_start: f64,
    pub(super) ramp_share: f64,
    pub(super) ramp_depths: bool,
}

impl Schedule {
    pub(super) fn new(settings: &SynthesisSettings, steps: u32) -> Self {
        Self {
            steps,
            temperature_start: settings.temperature_start,
            temperature_end: settings.temperature_end,
            ramp_start: settings.ramp_start,
            ramp_share: settings.ramp_share,
            ramp_depths: settings.ramp_depths,
        }
    }

    /// The schedule of a chain that starts from a given grasp: limited temperature, full weights.
    pub(super) fn from_given(settings: &SynthesisSettings, steps: u32) -> Self {
        Self {
            temperature_start: settings.given_temperature,
            ramp_start: 1.0,
            ..Self::new(settings, steps)
        }
    }

    fn progress(&self, step: u32) -> f64 {
        f64::from(step) / f64::from(self.steps)
    }

    fn temperature(&self, step: u32) -> f64 {
        let ratio = self.temperature_end / self.temperature_start;
        self.temperature_start * libm::pow(ratio, self.progress(step))
    }

    pub(super) fn ramp(&self, step: u32) -> Ramp {
        let done = (self.progress(step) / self.ramp_share).min(1.0);
        let factor = libm::pow(self.ramp_start, 1.0 - done);
        Ramp {
            distance: factor,
            depth: if self.ramp_depths { factor } else { 1.0 },
        }
    }
}

/// Cools `state` along `schedule`.
pub(super) fn anneal(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    schedule: &Schedule,
    mut state: State,
    rng: &mut Rng,
    observe: Observe<'_>,
) -> State {
    let mut kernel = GraspKernel::new(energy).with_step_scales(settings.step_scales);
    let mut proposal = State::default();
    let mut log_step = libm::log(FIRST_STEP_M);
    for n in 0..schedule.steps {
        let temperature = schedule.temperature(n);
        if n % RAMP_EVERY == 0 {
            kernel.ramp = schedule.ramp(n);
            kernel.evaluate(&mut state);
            if n == 0 {
                observe(0, &state);
            }
        }
        let law = TargetDensity {
            temperature,
            attraction: None,
        };
        if rng.random::<f64>() < settings.contact_probability {
            let log_ratio = match settings.contact_moves {
                ContactMoves::HeatBath => {
                    kernel.move_contact(&state, temperature, rng, &mut proposal)
                }
                ContactMoves::Uniform => {
                    kernel.move_contact_uniformly(&state, temperature, rng, &mut proposal)
                }
            };
            accept(&mut state, &mut proposal, log_ratio, rng);
        } else {
            let log_ratio = kernel.move_pose(&state, &law, libm::exp(log_step), rng, &mut proposal);
            let accepted = accept(&mut state, &mut proposal, log_ratio, rng);
            // Robbins–Monro adaptation, slow enough to follow the cooling without following noise.
            let error = f64::from(u8::from(accepted)) - settings.acceptance;
            log_step += 0.05 * error;
        }
        observe(n + 1, &state);
    }
    state
}
