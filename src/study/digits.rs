//! Number formats of reports for any unit.

/// Format of related numbers: six decimals if their differences are of usual size, otherwise powers of ten.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Digits {
    /// Decimals of the mantissa, if powers of ten are used.
    powers: Option<usize>,
}

impl Digits {
    const DECIMALS: usize = 6;
    /// Differences that six decimals show well.
    const USUAL: std::ops::Range<f64> = 1e-2..1e9;

    /// The format that shows the range of the values with six digits.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and 10"
    )]
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.into_iter().filter(|value| value.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        let largest = low.abs().max(high.abs());
        let range = if high > low { high - low } else { largest };
        let usual = range == 0.0 || !range.is_finite() || Self::USUAL.contains(&range);
        let beyond = libm::log10(largest / range).clamp(0.0, 10.0) as usize;
        Self {
            powers: (!usual).then_some(Self::DECIMALS + beyond),
        }
    }

    pub(crate) fn show(self, value: f64) -> String {
        match self.powers {
            None => format!("{value:.*}", Self::DECIMALS),
            Some(digits) => format!("{value:.digits$e}"),
        }
    }

    /// A change with its sign; zero has a plus sign.
    pub(crate) fn change(self, change: f64) -> String {
        let decimals = Self::DECIMALS;
        if self.powers.is_some() {
            return format!("{:+.decimals$e}", change + 0.0);
        }
        let text = format!("{change:+.decimals$}");
        match text.strip_prefix('-') {
            Some(size) if size.bytes().all(|byte| matches!(byte, b'0' | b'.')) => {
                format!("+{size}")
            }
            _ => text,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_digits_of_the_range_are_shown_in_any_unit() {
        let usual = Digits::of([-146.7, -40.65]);
        assert_eq!(usual.show(-40.6504), "-40.650400");
        assert_eq!(usual.change(-1e-9), "+0.000000");
        assert_eq!(usual.change(-0.25), "-0.250000");
        let joules = Digits::of([-3.2e-20, -1.1e-20]);
        assert_eq!(joules.show(-1.123456789e-20), "-1.123457e-20");
        assert_eq!(joules.change(1e-21), "+1.000000e-21");
        // Far from zero the digits of the differences matter.
        let far = Digits::of([1.0, 1.0 + 1e-4]);
        assert_eq!(far.show(1.00001234), "1.0000123400e0");
        for values in [vec![], vec![0.0], vec![f64::NAN], vec![2.5]] {
            assert_eq!(Digits::of(values).show(2.5), "2.500000");
        }
        assert_eq!(Digits::of([4e-9]).show(4e-9), "4.000000e-9");
    }
}
