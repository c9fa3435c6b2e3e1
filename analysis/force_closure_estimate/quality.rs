//! Precision and recall of the relaxed test with respect to the exact one.

use crate::sets::Verdict;

/// Thresholds of ‖Gc‖: the paper's, and that of the released code, which compares the square.
pub(crate) const THRESHOLDS: [f64; 2] = [0.5, std::f64::consts::FRAC_1_SQRT_2];

/// Counts for one threshold and one friction.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Quality {
    pub(crate) sets: usize,
    /// Number of sets that pass the relaxed test.
    pub(crate) pass: usize,
    /// Number of sets with force closure.
    pub(crate) closed: usize,
    /// Number of sets with both.
    pub(crate) both: usize,
}

impl Quality {
    /// Counts of ‖Gc‖ < `threshold` and of force closure at the friction with index `friction`.
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

    /// Share of force closure among the sets that pass.
    pub(crate) fn precision(&self) -> f64 {
        self.both as f64 / self.pass as f64
    }

    /// Share of passing sets among those with force closure.
    pub(crate) fn recall(&self) -> f64 {
        self.both as f64 / self.closed as f64
    }

    /// Share of sets with force closure.
    pub(crate) fn share_closed(&self) -> f64 {
        self.closed as f64 / self.sets as f64
    }
}
