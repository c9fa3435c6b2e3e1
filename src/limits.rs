//! What numbers of files may be: one table for all readers.
//!
//! Geometry multiplies and squares what a file says, so a number that nobody means ends in an overflow or in minutes of
//! work. Each limit lies far outside what is real and far inside what can be computed with.

/// A range of numbers that make sense.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// The smallest.
    pub least: f64,
    /// The largest.
    pub most: f64,
    /// Their unit; empty where they have none.
    pub unit: &'static str,
    /// Why no other makes sense, or what is perhaps meant; ends the sentence of [`Beyond`].
    pub reason: &'static str,
}

/// Where a frame, an end or a corner of a hand may lie along an axis of the frame it is told in.
pub const HAND_POSITION: Limit = Limit {
    least: -10.0,
    most: 10.0,
    unit: "m",
    reason: "hands are described in metres",
};

/// Radii and lengths of a hand's parts.
pub const HAND_LENGTH: Limit = Limit {
    least: 1e-6,
    most: 10.0,
    unit: "m",
    reason: "hands are described in metres",
};

/// Limits and offsets of joints that turn: sixteen turns.
pub const HINGE: Limit = Limit {
    least: -100.0,
    most: 100.0,
    unit: "rad",
    reason: "a joint that turns without end is continuous (URDF) or has no range (MJCF)",
};

/// Limits and offsets of joints that slide.
pub const SLIDE: Limit = Limit {
    least: -10.0,
    most: 10.0,
    unit: "m",
    reason: "joints that slide are described in metres",
};

/// How fast a joint follows another, all couplings between them multiplied.
pub const COUPLING_RATIO: Limit = Limit {
    least: -1000.0,
    most: 1000.0,
    unit: "",
    reason: "no joint follows another so fast",
};

/// Where a hand may lie from the origin of its object along an axis: squares of far larger numbers are infinite.
pub const GRASP_POSITION: Limit = Limit {
    least: -1000.0,
    most: 1000.0,
    unit: "m",
    reason: "lengths are in metres",
};

/// Factors on the size of objects; far smaller and larger ones have no volume, or an infinite one.
pub const OBJECT_SCALE: Limit = Limit {
    least: 1e-3,
    most: 1e3,
    unit: "",
    reason: "such an object has no volume, or an infinite one",
};

/// Weights, roundings and thresholds of energies.
pub const ENERGY_SETTING: Limit = Limit {
    least: 0.0,
    most: 1e6,
    unit: "",
    reason: "terms are of order one, and a larger one leaves nothing of the others",
};

/// Most bare contacts of one file: the time to judge them grows faster than their number.
pub const MOST_CONTACTS: usize = 1000;

impl Limit {
    /// Whether `value` makes sense; no number that is not finite does.
    pub fn holds(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }

    /// The unit as it follows a number.
    fn spaced_unit(&self) -> String {
        if self.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", self.unit)
        }
    }

    /// Refuses a value that makes no sense.
    ///
    /// # Errors
    /// If `value` is outside the limits or not a number.
    pub fn check(self, value: f64) -> Result<(), Beyond> {
        if self.holds(value) {
            Ok(())
        } else {
            Err(Beyond { value, limit: self })
        }
    }
}

/// A number outside its limit.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{value:?} is not from {} to {}{}: {}", limit.least, limit.most, limit.spaced_unit(), limit.reason)]
pub struct Beyond {
    /// The number.
    pub value: f64,
    /// Its limit.
    pub limit: Limit,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_or_beyond_is_refused_with_its_reason() {
        for limit in [
            HAND_POSITION,
            HAND_LENGTH,
            HINGE,
            SLIDE,
            COUPLING_RATIO,
            GRASP_POSITION,
            OBJECT_SCALE,
            ENERGY_SETTING,
        ] {
            assert!(limit.holds(limit.least) && limit.holds(limit.most));
            for value in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e155, -1e308] {
                assert!(limit.check(value).is_err(), "{limit:?} {value}");
            }
        }
        assert_eq!(
            HAND_POSITION.check(1e155).unwrap_err().to_string(),
            "1e155 is not from -10 to 10 m: hands are described in metres"
        );
    }
}
