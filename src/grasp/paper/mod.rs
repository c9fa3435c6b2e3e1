//! The method of Liu et al. (2021), for comparison with it: energy (Eqs. 7 to 10), sampler (Algorithm 1) and refinement.
//!
//! The paper and the authors' code differ. [`Reading`] names which of the two is followed. The programs of `analysis` that
//! remake Figures 5, 6 and 11 use this module, and no other module does. It is plain and about as fast as the authors' code.
//! Eq. 11 is in [`Judgement`](super::Judgement). Surface points that depend on several links are not supported.

mod chain;
mod energy;
mod term;

pub use chain::{Sample, State, sample};
pub use energy::{Held, PaperEnergy};
use serde::{Deserialize, Serialize};

/// Which description of the method is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Reading {
    /// The formulae of the text, with their weights of 1. Lengths are in units of the object's radius, and the refinement is
    /// a descent with the contact set held.
    Printed,
    /// The authors' code: squared norms, ten times the penetration, the rank condition over all eigenvalues, and an alignment
    /// of normals that is not in the text. Lengths are in units of 120 mm, and the refinement is a thousand noisy steps at
    /// temperature 0.001.
    Released,
}

/// Settings of energy and sampler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct PaperSettings {
    /// Text or code.
    pub reading: Reading,
    /// Number of contacts n.
    pub contacts: usize,
    /// Whether only points on the tips and pads of the last links of the digits may be contacts.
    pub fingertips_only: bool,
    /// Number of steps of a chain.
    pub steps: u32,
}

impl PaperSettings {
    /// The text, with three contacts and 10,000 steps.
    pub fn printed() -> Self {
        Self {
            reading: Reading::Printed,
            contacts: 3,
            fingertips_only: false,
            steps: 10_000,
        }
    }

    /// The authors' code, with five contacts and 10,000 steps.
    pub fn released() -> Self {
        Self {
            reading: Reading::Released,
            contacts: 5,
            ..Self::printed()
        }
    }
}
