//! How often answers are right against their probability: reliability curves and the expected calibration error.

/// Number of bins of a reliability curve.
const BINS: usize = 5;

/// An answer: its probability, and whether it is right.
pub(crate) type Answered = (f64, bool);

/// One bin of a reliability curve: the mean probability, the share that is right, and the number of answers.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Bin {
    pub(crate) score: f64,
    pub(crate) right: f64,
    pub(crate) count: usize,
}

/// Bins of equal width.
pub(crate) fn reliability(answers: impl Iterator<Item = Answered>) -> [Bin; BINS] {
    let mut bins = [Bin::default(); BINS];
    for (score, right) in answers {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a probability is between 0 and 1"
        )]
        let bin = ((score * BINS as f64) as usize).min(BINS - 1);
        bins[bin].count += 1;
        bins[bin].score += score;
        bins[bin].right += f64::from(u8::from(right));
    }
    bins.map(|bin| {
        let count = bin.count.max(1) as f64;
        Bin {
            score: bin.score / count,
            right: bin.right / count,
            count: bin.count,
        }
    })
}

/// Expected calibration error: the mean over answers of |probability − share right| of their bin (Guo et al. 2017).
pub(crate) fn calibration_error(bins: &[Bin]) -> f64 {
    let all: usize = bins.iter().map(|bin| bin.count).sum();
    let missed = bins
        .iter()
        .map(|bin| bin.count as f64 * (bin.score - bin.right).abs());
    missed.sum::<f64>() / all.max(1) as f64
}
