//! Settings of a synthesis chain.

use serde::{Deserialize, Serialize};

use crate::grasp::grip::GripShares;
use crate::limits::{Beyond, STEPS};

/// Settings of a synthesis chain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SynthesisSettings {
    /// Greatest number of descents, each of which is an attempt from a new start. All start with the palm at the same point
    /// of the object. The first whose end passes the strict filter ends the chain; otherwise the end of least energy counts.
    pub steps: u32,
    /// Frequencies of the parts of the hand that take part.
    pub grips: GripShares,
}

impl Default for SynthesisSettings {
    fn default() -> Self {
        Self {
            steps: 24,
            grips: GripShares::default(),
        }
    }
}

impl SynthesisSettings {
    /// Describes the first invalid value in one sentence.
    ///
    /// # Errors
    /// If a value is out of its range.
    pub fn validate(&self) -> Result<(), SynthesisSettingsError> {
        let steps = [("steps", STEPS, f64::from(self.steps))];
        for (name, limit, value) in steps.into_iter().chain(self.grips.values()) {
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
