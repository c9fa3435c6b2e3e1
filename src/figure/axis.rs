//! Round numbers along an axis.

/// Smallest step of ticks, as a share of the larger end of a range. Doubles differ only down to 2⁻⁵³ of their size, and
/// ticks that differ so late would need very long texts.
const FINEST_STEP: f64 = 1e-13;

/// A range of an axis. Its width may overflow to infinity or be as small as an ulp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    /// The lower end.
    pub(super) low: f64,
    /// The upper end, above the lower one.
    pub(super) high: f64,
}

impl Span {
    /// Relative position of `value`: 0 at the lower end, 1 at the upper end.
    pub(super) fn part(self, value: f64) -> f64 {
        let width = self.high - self.low;
        if width.is_finite() {
            (value - self.low) / width
        } else {
            let [low, high, value] = [self.low, self.high, value].map(|value| 0.5 * value);
            (value - low) / (high - low)
        }
    }

    /// The value at a relative position, which may lie beyond either end. The result is always finite.
    #[cfg(any(feature = "topography", test))]
    pub(super) fn at(self, part: f64) -> f64 {
        let width = self.high - self.low;
        let value = if width.is_finite() {
            self.low + part * width
        } else {
            (1.0 - part) * self.low + part * self.high
        };
        value.clamp(f64::MIN, f64::MAX)
    }

    /// The same range. A range too narrow for its ends to differ on an axis is widened around them.
    #[cfg(any(feature = "topography", test))]
    pub(super) fn widened(self) -> Self {
        let Self { low, high } = self;
        if high - low > 1e-12 * high.abs().max(low.abs()) {
            return self;
        }
        let pad = if low.abs() < 1e-300 {
            0.5
        } else {
            0.1 * low.abs()
        };
        Self {
            low: (low - pad).max(f64::MIN),
            high: (high + pad).min(f64::MAX),
        }
    }
}

/// Round values (1, 2 or 5 times a power of ten apart) inside [`low`, `high`], about `wanted` of them. The result is only
/// `low` if the range is empty or too narrow for distinct ticks.
pub fn ticks(low: f64, high: f64, wanted: usize) -> Vec<f64> {
    let wanted = wanted.max(1) as f64;
    let mut raw = (high - low) / wanted;
    if raw.is_infinite() {
        raw = high / wanted - low / wanted;
    }
    let finest = (FINEST_STEP * low.abs().max(high.abs())).max(f64::MIN_POSITIVE);
    if !(raw.is_finite() && raw > finest) {
        return vec![low];
    }
    let magnitude = libm::pow(10f64, libm::log10(raw).floor());
    // Limits are the geometric means of neighbouring steps.
    let step = magnitude
        * match raw / magnitude {
            part if part < 2f64.sqrt() => 1.0,
            part if part < 10f64.sqrt() => 2.0,
            part if part < 50f64.sqrt() => 5.0,
            _ => 10.0,
        };
    if step.is_infinite() {
        return vec![low];
    }
    let mut values = Vec::new();
    let mut index = (low / step - 1e-9).ceil();
    let last = (high + 1e-9 * step).min(f64::MAX);
    while index * step <= last {
        // Adding zero turns −0 into 0.
        values.push(index * step + 0.0);
        index += 1.0;
    }
    values
}

/// Texts of the ticks, all with as many decimals as their spacing needs.
pub fn tick_texts(values: &[f64]) -> Vec<String> {
    let spacing = values
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .fold(f64::INFINITY, f64::min);
    if !spacing.is_finite() {
        return values.iter().map(|&value| number(value)).collect();
    }
    let largest = values
        .iter()
        .fold(0.0_f64, |largest, value| largest.max(value.abs()));
    if largest >= 1e6 || spacing < 1e-4 {
        let digits = digits_between(largest, spacing);
        return values
            .iter()
            .map(|value| minus(&format!("{value:.digits$e}")))
            .collect();
    }
    let decimals = digits_between(1.0, spacing);
    values
        .iter()
        .map(|value| minus(&format!("{value:.decimals$}")))
        .collect()
}

/// A number with about three significant digits, for legends.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if !(1e-3..1e5).contains(&size) {
        minus(&format!("{value:.1e}"))
    } else {
        let decimals = digits_between(100.0, size).min(4);
        let text = format!("{value:.decimals$}");
        let text = if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.')
        } else {
            &text
        };
        minus(text)
    }
}

/// Round values inside [`low`, `high`] (both positive) for a logarithmic axis, about `wanted` of them. They are powers of
/// ten. If these are few, 2 and 5 times powers of ten are added; if there are fewer than three within one decade, the
/// values are evenly spaced instead.
pub fn log_ticks(low: f64, high: f64, wanted: usize) -> Vec<f64> {
    let [first, last] = [low, high].map(libm::log10);
    if !(last > first && first.is_finite() && last.is_finite()) {
        return vec![low];
    }
    let span = last - first;
    // The steps between 1, 2, 5 and 10 times a power of ten are about equal.
    let factors: &[f64] = if span < 0.34 * wanted as f64 {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    let inside = |every: f64| {
        let mut values = Vec::new();
        let mut exponent = (first / every).floor() * every;
        while exponent <= last {
            let decade = factors
                .iter()
                .map(|factor| factor * power_of_ten(exponent))
                .filter(|value| (low..=high).contains(value));
            values.extend(decade);
            exponent += every;
        }
        values
    };
    let mut every = (span / wanted.max(1) as f64).ceil().max(1.0);
    let mut values = inside(every);
    while values.len() < 2 && every > 1.0 {
        every -= 1.0;
        values = inside(every);
    }
    if values.len() < 3 && span < 1.0 {
        ticks(low, high, wanted)
    } else {
        values
    }
}

/// Texts of the ticks of a logarithmic axis: plain numbers near one, powers of ten elsewhere.
pub fn log_tick_texts(values: &[f64]) -> Vec<String> {
    let exponents = values.iter().map(|value| libm::log10(*value));
    let near_one = exponents.clone().all(|e| (-3.1..4.1).contains(&e));
    let powers = exponents.clone().all(|e| (e - e.round()).abs() < 1e-9);
    if near_one || !powers {
        return values.iter().map(|&value| number(value)).collect();
    }
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' => '⁰',
        other => char::from_u32('⁰' as u32 + other.to_digit(10).unwrap_or(0)).unwrap_or(other),
    };
    exponents
        .map(|e| {
            let digits = format!("{:.0}", e.round() + 0.0);
            format!("10{}", digits.chars().map(raised).collect::<String>())
        })
        .collect()
}

/// 10^exponent, correctly rounded.
fn power_of_ten(exponent: f64) -> f64 {
    format!("1e{exponent:.0}").parse().unwrap_or(f64::NAN)
}

/// Decimal places from the first digit of `large` to the first digit of `small`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 0 and 17"
)]
fn digits_between(large: f64, small: f64) -> usize {
    let first = |value: f64| (libm::log10(value) + 1e-9).floor();
    (first(large) - first(small)).clamp(0.0, 17.0) as usize
}

/// Replaces hyphens by typographic minus signs.
fn minus(text: &str) -> String {
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(
            ticks(-0.1, 1.05, 5),
            [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]
        );
        assert_eq!(
            tick_texts(&ticks(-0.1, 1.05, 5)),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(
            tick_texts(&ticks(-146.7, -40.6, 5)),
            ["−140", "−120", "−100", "−80", "−60"]
        );
        assert_eq!(ticks(3.0, 3.0, 5), [3.0]);
    }

    #[test]
    fn any_range_has_few_ticks_inside_and_ends() {
        let ulps = |value: f64, count: u64| f64::from_bits(value.to_bits() + count);
        let (tiny, huge) = (f64::from_bits(1), f64::MAX);
        let mut ranges = vec![
            [1.0, ulps(1.0, 1)],
            [1.0, ulps(1.0, 2)],
            [-ulps(1.0, 1), -1.0],
            [146.0, ulps(146.0, 40)],
            [1e300, ulps(1e300, 3)],
            [0.0, tiny],
            [tiny, ulps(tiny, 1)],
            [-tiny, tiny],
            [0.0, f64::MIN_POSITIVE],
            [-huge, huge],
            [0.0, huge],
            [huge / 2.0, huge],
            [-huge, tiny],
            [3.0, 3.0],
            [0.0, 0.0],
            [huge, huge],
        ];
        for exponent in -320..309 {
            let end = 10f64.powi(exponent);
            ranges.extend([[0.0, end], [-end, end], [end, 1.5 * end], [1.0, 1.0 + end]]);
        }
        for [low, high] in ranges {
            for wanted in [1, 4, 6, 1000] {
                let values = ticks(low, high, wanted);
                let largest = low.abs().max(high.abs());
                let rounding = 4e-9 * (high / 2.0 - low / 2.0) + 4.0 * f64::EPSILON * largest;
                assert!(
                    values
                        .iter()
                        .all(|value| (low - rounding..=high + rounding).contains(value)),
                    "{low:e} {high:e} {wanted}: {values:?}"
                );
                assert!(
                    (1..=3 * wanted + 3).contains(&values.len())
                        && values.windows(2).all(|pair| pair[0] < pair[1]),
                    "{low:e} {high:e} {wanted}: {values:?}"
                );
                assert_eq!(tick_texts(&values).len(), values.len());
            }
            if low < high {
                let span = Span { low, high };
                let ends = [low, high].map(|end| span.part(end).to_bits());
                assert_eq!(ends, [0.0, 1.0].map(f64::to_bits));
                assert!(span.at(-0.1).is_finite() && span.at(1.1).is_finite());
            }
            let Span { low, high } = Span { low, high }.widened();
            assert!(low < high && low.is_finite() && high.is_finite());
        }
    }

    #[test]
    fn large_and_tiny_ticks_differ_from_each_other() {
        for (low, high) in [(1e7, 1.001e7), (0.0, 3e-6), (-2e-9, 5e-9)] {
            let texts = tick_texts(&ticks(low, high, 6));
            assert!(
                texts.len() > 3 && texts.windows(2).all(|pair| pair[0] != pair[1]),
                "{texts:?}"
            );
        }
    }

    #[test]
    fn logarithmic_ticks_are_round() {
        let texts = |low, high, wanted| log_tick_texts(&log_ticks(low, high, wanted));
        assert_eq!(texts(0.9, 1100.0, 6), ["1", "10", "100", "1000"]);
        assert_eq!(texts(2.0, 30.0, 5), ["2", "5", "10", "20"]);
        assert_eq!(texts(3.1, 3.9, 4), ["3.2", "3.4", "3.6", "3.8"]);
        assert_eq!(
            texts(1e-12, 1.0, 5),
            ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰"]
        );
        assert_eq!(log_ticks(2.0, 2.0, 5), [2.0]);
        assert_eq!(log_ticks(0.0, 2.0, 5), [0.0]);
        for (low, high) in [(1e-4, 1e-1), (3e-9, 8e7), (0.5, 2e3), (7.0, 9.0)] {
            for wanted in 2..9 {
                let values = log_ticks(low, high, wanted);
                assert!(
                    values.len() > 1
                        && values.iter().all(|value| (low..=high).contains(value))
                        && values.windows(2).all(|pair| pair[0] < pair[1]),
                    "{low} {high} {wanted}: {values:?}"
                );
            }
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [0.0, 1.0, 0.25, -12.34, 371.0, 0.01234].map(number),
            ["0", "1", "0.25", "−12.3", "371", "0.0123"]
        );
        assert_eq!(number(2.5e-7), "2.5e−7");
    }
}
