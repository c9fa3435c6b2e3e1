//! Number formats of reports for any unit.

/// Format of related numbers: six decimals if their differences are of usual size, otherwise powers of ten.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Digits {
    /// Decimals of the mantissa, if powers of ten are used.
    powers: Option<usize>,
    /// Smaller values are shown as zero.
    zero: f64,
}

impl Digits {
    const DECIMALS: usize = 6;
    /// Differences that six decimals show well.
    const USUAL: std::ops::Range<f64> = 1e-2..1e9;
    /// Values are equal if they differ by less than this fraction of the largest.
    const SAME: f64 = 1e-12;
    /// The same of values that were measured by finite differences.
    const ROUGHLY_SAME: f64 = 1e-6;

    /// The format that shows the range of the values with six digits.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Self {
        Self::known(values, |largest| Self::SAME * largest)
    }

    /// The same for values that are equal if they differ by less than `tolerance`: finer digits mean nothing.
    pub(crate) fn within(tolerance: f64, values: impl IntoIterator<Item = f64>) -> Self {
        let digits = Self::known(values, |largest| tolerance.max(Self::SAME * largest));
        Self {
            zero: tolerance.max(digits.zero),
            ..digits
        }
    }

    /// The same for values that were measured by finite differences.
    pub(crate) fn measured(values: impl IntoIterator<Item = f64>) -> Self {
        Self::known(values, |largest| Self::ROUGHLY_SAME * largest)
    }

    /// The format of values that are known to within what `noise` makes of the largest one.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and 12"
    )]
    fn known(values: impl IntoIterator<Item = f64>, noise: impl Fn(f64) -> f64) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.into_iter().filter(|value| value.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        let largest = low.abs().max(high.abs());
        let noise = noise(largest);
        // Values that differ by their rounding only are one value, and such a value may be zero.
        let sizes = [high - low, largest];
        let range = sizes.into_iter().find(|size| *size > noise).unwrap_or(0.0);
        // Where six decimals show all that is known, nothing is gained by powers.
        let shown = noise >= 0.1_f64.powi(6) && largest < Self::USUAL.end;
        let usual = range == 0.0 || !range.is_finite() || Self::USUAL.contains(&range) || shown;
        let beyond = libm::log10(largest / range).clamp(0.0, 10.0) as usize;
        let known = libm::log10(largest / noise).clamp(1.0, 12.0) as usize;
        Self {
            powers: (!usual).then_some((Self::DECIMALS + beyond).min(known)),
            zero: Self::SAME * if largest.is_finite() { largest } else { 0.0 },
        }
    }

    pub(crate) fn show(self, value: f64) -> String {
        let value = if value.abs() < self.zero { 0.0 } else { value };
        match self.powers {
            None => unsigned_zero(format!("{value:.*}", Self::DECIMALS)),
            Some(digits) => format!("{value:.digits$e}"),
        }
    }
}

/// The same number, without the sign of a zero.
fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(size) if size.bytes().all(|byte| matches!(byte, b'0' | b'.')) => size.to_owned(),
        _ => text,
    }
}

/// A positive number in any unit, with five significant digits.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 0 and 7"
)]
pub(crate) fn significant(value: f64) -> String {
    if (1e-3..1e6).contains(&value) {
        let decimals = (4.0 - libm::log10(value).floor()).clamp(0.0, 7.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.4e}")
    }
}

/// A positive number as it was given, in powers of ten if it would be long.
pub(crate) fn as_given(value: f64) -> String {
    if (1e-4..1e7).contains(&value) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_in_any_unit() {
        for (value, short) in [
            (0.28, "0.28000"),
            (10.3846, "10.385"),
            (123456.7, "123457"),
            (0.001, "0.0010000"),
            (1.38e-21, "1.3800e-21"),
            (2.5e8, "2.5000e8"),
        ] {
            assert_eq!(significant(value), short);
        }
        for (value, short) in [
            (0.1, "0.1"),
            (300.0, "300"),
            (1e-300, "1e-300"),
            (1e22, "1e22"),
        ] {
            assert_eq!(as_given(value), short);
        }
    }

    #[test]
    fn rounding_is_not_shown() {
        let equal = Digits::of([2.0, 2.0_f64.next_down()]);
        assert_eq!(equal.show(2.0_f64.next_down()), "2.000000");
        assert_eq!(Digits::of([-1e-20, -1e-20]).show(-1e-20), "-1.000000e-20");
    }

    /// Minima of one energy and curvatures by finite differences, as two equal wells have them.
    #[test]
    fn what_is_not_known_is_not_shown() {
        let energies = Digits::within(1e-6, [5e-21, -7.9e-18]);
        assert_eq!(energies.show(-7.9e-18), "0.000000");
        let barriers = Digits::within(1e-6, [-7.9e-18, 1.0]);
        assert_eq!(barriers.show(-7.9e-18), "0.000000");
        assert_eq!(Digits::of([-1.0, 1.0]).show(-1e-9), "0.000000");
        let curvatures = Digits::measured([8.00000000300374, 7.99999996988109]);
        assert_eq!(curvatures.show(7.99999996988109), "8.000000");
        // A small unit has small tolerances.
        let joules = Digits::within(1e-26, [-3.2e-20, 1e-30]);
        assert_eq!(joules.show(-3.2e-20), "-3.200000e-20");
        assert_eq!(joules.show(-1e-30), "0.000000e0");
        let close = Digits::within(1e-9, [1.0, 1.0 + 1e-4]);
        assert_eq!(close.show(1.00001234), "1.000012340e0");
    }

    #[test]
    fn six_digits_of_the_range_are_shown_in_any_unit() {
        let usual = Digits::of([-146.7, -40.65]);
        assert_eq!(usual.show(-40.6504), "-40.650400");
        let joules = Digits::of([-3.2e-20, -1.1e-20]);
        assert_eq!(joules.show(-1.123456789e-20), "-1.123457e-20");
        // Far from zero the digits of the differences matter.
        let far = Digits::of([1.0, 1.0 + 1e-4]);
        assert_eq!(far.show(1.00001234), "1.0000123400e0");
        for values in [vec![], vec![0.0], vec![f64::NAN], vec![2.5]] {
            assert_eq!(Digits::of(values).show(2.5), "2.500000");
        }
        assert_eq!(Digits::of([4e-9]).show(4e-9), "4.000000e-9");
    }
}
