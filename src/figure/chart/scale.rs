//! Axes of charts: labels, ranges and the mapping of values to positions.

use super::super::{FigureError, axis};

/// Mapping of values to positions along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Linear.
    Linear,
    /// Logarithmic.
    Logarithmic,
}

impl Scale {
    /// Position of `value` before shift and stretch: the value itself or its decadic logarithm.
    pub(super) fn transform(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => libm::log10(value),
        }
    }

    /// The value at the position `place`.
    pub(super) fn invert(self, place: f64) -> f64 {
        match self {
            Self::Linear => place,
            Self::Logarithmic => libm::pow(10f64, place),
        }
    }
}

/// One axis of a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name and unit of the quantity.
    pub label: String,
    /// Mapping of values to positions.
    pub scale: Scale,
    /// Its ends, ascending. `None` takes them from the data.
    pub range: Option<[f64; 2]>,
    /// Values to be marked, with their texts. Without any, round numbers are marked.
    pub ticks: Vec<(f64, String)>,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            scale: Scale::Linear,
            range: None,
            ticks: Vec::new(),
        }
    }

    /// A logarithmic axis.
    pub fn logarithmic(label: &str) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..Self::linear(label)
        }
    }

    /// Sets the range.
    #[must_use]
    pub fn with_range(self, low: f64, high: f64) -> Self {
        Self {
            range: Some([low, high]),
            ..self
        }
    }

    /// Sets the values that are marked, with their texts.
    #[must_use]
    pub fn with_ticks(self, ticks: impl IntoIterator<Item = (f64, String)>) -> Self {
        Self {
            ticks: ticks.into_iter().collect(),
            ..self
        }
    }

    /// The range of the axis, given the values that must lie on it. NaN is ignored.
    pub(super) fn span(&self, values: impl Iterator<Item = f64>) -> Result<Span, FigureError> {
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for value in values.filter(|value| !value.is_nan()) {
            let place = self.scale.transform(value);
            if !place.is_finite() {
                return Err(FigureError::OffAxis {
                    value,
                    axis: self.label.clone(),
                });
            }
            ends = [ends[0].min(place), ends[1].max(place)];
        }
        let [low, high] = match self.range {
            Some([low, high]) => {
                let ends = [low, high].map(|end| self.scale.transform(end));
                if !(ends[0] < ends[1] && ends[0].is_finite() && ends[1].is_finite()) {
                    return Err(FigureError::Range {
                        axis: self.label.clone(),
                        low,
                        high,
                    });
                }
                ends
            }
            None => self.padded(ends),
        };
        Ok(Span {
            scale: self.scale,
            low,
            high,
        })
    }

    /// The range with a little room at both ends. It does not go below zero if no value is negative.
    fn padded(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        if low > high {
            return [0.0, 1.0];
        }
        let pad = if high - low > 1e-12 * high.abs().max(low.abs()) {
            0.05 * (high - low)
        } else if self.scale == Scale::Linear && low != 0.0 {
            0.1 * low.abs()
        } else {
            0.5
        };
        let floor = if self.scale == Scale::Linear && low >= 0.0 {
            0.0
        } else {
            f64::NEG_INFINITY
        };
        [(low - pad).max(floor), high + pad]
    }
}

/// The range of an axis, in transformed values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    pub(super) scale: Scale,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Span {
    /// Relative position of `value`: 0 at the lower end, 1 at the upper end.
    pub(super) fn part(&self, value: f64) -> f64 {
        self.part_of_place(self.scale.transform(value))
    }

    /// Relative position of a transformed value.
    pub(super) fn part_of_place(&self, place: f64) -> f64 {
        (place - self.low) / (self.high - self.low)
    }

    /// Values with texts, about `wanted` of them.
    pub(super) fn ticks(&self, wanted: usize) -> Vec<(f64, String)> {
        let [low, high] = [self.low, self.high].map(|end| self.scale.invert(end));
        let (values, texts) = match self.scale {
            Scale::Linear => {
                let values = axis::ticks(low, high, wanted);
                let texts = axis::tick_texts(&values);
                (values, texts)
            }
            Scale::Logarithmic => {
                let values = axis::log_ticks(low, high, wanted);
                let texts = axis::log_tick_texts(&values);
                (values, texts)
            }
        };
        values.into_iter().zip(texts).collect()
    }

    /// Values for small ticks without texts: 2, 3, … 9 times powers of ten, on a logarithmic axis of at most six decades.
    pub(super) fn small_ticks(&self) -> Vec<f64> {
        if self.scale == Scale::Linear || self.high - self.low > 6.0 {
            return Vec::new();
        }
        let mut values = Vec::new();
        let mut exponent = self.low.floor();
        while exponent <= self.high {
            values.extend((2..10).map(|factor| f64::from(factor) * libm::pow(10f64, exponent)));
            exponent += 1.0;
        }
        values.retain(|&value| (0.0..=1.0).contains(&self.part(value)));
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_follow_the_data() {
        let ends = |axis: &Axis, values: &[f64]| {
            let span = axis.span(values.iter().copied()).unwrap();
            vec![span.scale.invert(span.low), span.scale.invert(span.high)]
        };
        let linear = Axis::linear("x");
        assert_eq!(ends(&linear, &[0.0, 100.0, f64::NAN]), [0.0, 105.0]);
        assert_eq!(ends(&linear, &[-10.0, 10.0]), [-11.0, 11.0]);
        assert_eq!(ends(&linear, &[10.0]), [9.0, 11.0]);
        assert_eq!(ends(&linear, &[]), [0.0, 1.0]);
        let log = Axis::logarithmic("x");
        let logs: Vec<f64> = ends(&log, &[1.0, 100.0])
            .iter()
            .map(|end| libm::log10(*end))
            .collect();
        assert!((logs[0] + 0.1).abs() < 1e-12 && (logs[1] - 2.1).abs() < 1e-12);
        assert_eq!(ends(&linear.with_range(2.0, 3.0), &[-5.0]), [2.0, 3.0]);
    }

    #[test]
    fn what_has_no_place_is_refused() {
        let off = |axis: Axis, value: f64| axis.span([1.0, value].into_iter()).unwrap_err();
        assert!(matches!(
            off(Axis::logarithmic("time"), 0.0),
            FigureError::OffAxis { value: 0.0, axis } if axis == "time"
        ));
        let message = off(Axis::linear("μ₀"), f64::INFINITY).to_string();
        assert_eq!(message, "inf cannot be drawn on the axis \"μ₀\"");
        for (low, high) in [(2.0, 2.0), (3.0, 1.0), (0.0, f64::NAN)] {
            assert!(matches!(
                off(Axis::linear("x").with_range(low, high), 1.0),
                FigureError::Range { .. }
            ));
        }
        assert!(matches!(
            off(Axis::logarithmic("x").with_range(0.0, 1.0), 1.0),
            FigureError::Range { .. }
        ));
    }
}
