//! How well the relaxed test tells what the exact one says.

use crate::sets::Verdict;

/// Thresholds of ‖Gc‖: the paper's, and that of the released code, which compares the square.
pub(crate) const THRESHOLDS: [f64; 2] = [0.5, std::f64::consts::FRAC_1_SQRT_2];

/// Counts of one threshold at one friction.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Quality {
    pub(crate) sets: usize,
    /// Pass the relaxed test.
    pub(crate) pass: usize,
    /// Are force-closed.
    pub(crate) closed: usize,
    /// Both.
    pub(crate) both: usize,
}

impl Quality {
    /// Of ‖Gc‖ < `threshold` for force closure at the friction number `friction`.
    pub(crate) fn of<'a>(
        verdicts: impl IntoIterator<Item = &'a Verdict>,
        threshold: f64,
        friction: usize,
    ) -> Self {
        let mut quality = Self::default();
        for verdict in verdicts {
            let passes = verdict.net_wrench < threshold;
            let closed = verdict.closed[friction];
            quality.sets += 1;
            quality.pass += usize::from(passes);
            quality.closed += usize::from(closed);
            quality.both += usize::from(passes && closed);
        }
        quality
    }

    /// Share of those that pass that are force-closed.
    pub(crate) fn precision(&self) -> f64 {
        self.both as f64 / self.pass as f64
    }

    /// Share of the force-closed that pass.
    pub(crate) fn recall(&self) -> f64 {
        self.both as f64 / self.closed as f64
    }

    /// Share that is force-closed.
    pub(crate) fn share_closed(&self) -> f64 {
        self.closed as f64 / self.sets as f64
    }
}
