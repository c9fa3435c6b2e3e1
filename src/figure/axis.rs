//! Round numbers along an axis.

/// Round values (1, 2 or 5 times a power of ten apart) inside [`low`, `high`], about `wanted` of them.
pub fn ticks(low: f64, high: f64, wanted: usize) -> Vec<f64> {
    let raw = (high - low) / wanted.max(1) as f64;
    if !raw.is_finite() || raw <= 0.0 {
        return vec![low];
    }
    let magnitude = 10f64.powf(raw.log10().floor());
    // Limits are the geometric means of neighbouring steps.
    let step = magnitude
        * match raw / magnitude {
            part if part < 2f64.sqrt() => 1.0,
            part if part < 10f64.sqrt() => 2.0,
            part if part < 50f64.sqrt() => 5.0,
            _ => 10.0,
        };
    let mut values = Vec::new();
    let mut index = (low / step - 1e-9).ceil();
    while index * step <= high + 1e-9 * step {
        // Adding zero turns −0 into 0.
        values.push(index * step + 0.0);
        index += 1.0;
    }
    values
}

/// The ticks as texts, all with as many decimals as their spacing needs.
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

/// Decimal places from the first digit of `large` to the first digit of `small`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 0 and 17"
)]
fn digits_between(large: f64, small: f64) -> usize {
    let first = |value: f64| (value.log10() + 1e-9).floor();
    (first(large) - first(small)).clamp(0.0, 17.0) as usize
}

/// With a typographic minus sign.
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
    fn numbers_are_short() {
        assert_eq!(
            [0.0, 1.0, 0.25, -12.34, 371.0, 0.01234].map(number),
            ["0", "1", "0.25", "−12.3", "371", "0.0123"]
        );
        assert_eq!(number(2.5e-7), "2.5e−7");
    }
}
