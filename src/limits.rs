//! Limits of the numbers in files: one table for all readers.
//!
//! Geometry multiplies and squares the numbers of a file, so an absurd number ends in an overflow or in minutes of work.
//! Each limit lies far outside real values and far inside what can be computed.

use std::fmt;

/// A range of meaningful numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// The smallest.
    pub least: f64,
    /// The largest.
    pub most: f64,
    /// Their unit; empty if they have none.
    pub unit: &'static str,
    /// Why other numbers make no sense, or a likely error; ends the sentence of [`Beyond`].
    pub reason: &'static str,
}

/// Coordinates of frames, ends and corners of a hand, in the frame in which they are given.
pub const HAND_POSITION: Limit = Limit {
    least: -10.0,
    most: 10.0,
    unit: "m",
    reason: "hands are described in metres",
};

/// Radii and lengths of the parts of a hand.
pub const HAND_LENGTH: Limit = Limit {
    least: 1e-6,
    most: 10.0,
    unit: "m",
    reason: "hands are described in metres",
};

/// Lengths of a hand's metric: how far a unit of a joint, which others may follow, moves the hand.
pub const METRIC_LENGTH: Limit = Limit {
    least: 1e-6,
    most: 1e4,
    unit: "m",
    reason: "hands are described in metres",
};

/// Limits and offsets of hinges: sixteen turns.
pub const HINGE: Limit = Limit {
    least: -100.0,
    most: 100.0,
    unit: "rad",
    reason: "a joint that turns without end is continuous (URDF) or has no range (MJCF)",
};

/// Limits and offsets of slides.
pub const SLIDE: Limit = Limit {
    least: -10.0,
    most: 10.0,
    unit: "m",
    reason: "joints that slide are described in metres",
};

/// Ratio at which a joint follows another, with all couplings between them multiplied.
pub const COUPLING_RATIO: Limit = Limit {
    least: -1000.0,
    most: 1000.0,
    unit: "",
    reason: "no joint moves so much faster than the joint it follows",
};

/// Coordinates of a hand relative to the origin of its object; squares of far larger numbers are infinite.
pub const GRASP_POSITION: Limit = Limit {
    least: -1000.0,
    most: 1000.0,
    unit: "m",
    reason: "lengths are in metres",
};

/// Coordinates of meshes and shapes, in the unit of their file.
pub const MESH_COORDINATE: Limit = Limit {
    least: -1e9,
    most: 1e9,
    unit: "",
    reason: "no hand-held object has such a size in any unit of length",
};

/// Sizes of meshes and shapes, in the unit of their file; volumes of far smaller and larger ones are zero or infinite.
pub const MESH_SIZE: Limit = Limit {
    least: 1e-9,
    most: 1e9,
    unit: "",
    reason: "no hand-held object has such a size in any unit of length",
};

/// Longest side of an object; an object outside this range is surely not in metres.
pub const OBJECT_SIZE: Limit = Limit {
    least: 2e-3,
    most: 2.0,
    unit: "m",
    reason: "hands hold nothing smaller or larger",
};

/// Masses of objects.
pub const OBJECT_MASS: Limit = Limit {
    least: 1e-9,
    most: 1e6,
    unit: "kg",
    reason: "masses are in kilograms",
};

/// Factors on the size of objects.
pub const OBJECT_SCALE: Limit = Limit {
    least: 1e-6,
    most: 1e6,
    unit: "",
    reason: "meshes are made in units from the micrometre to the kilometre",
};

/// Lengths of direction vectors; squares of far smaller and larger ones are zero or infinite.
pub const DIRECTION: Limit = Limit {
    least: 1e-9,
    most: 1e9,
    unit: "",
    reason: "a direction of length one is needed",
};

/// Standard deviations of a joint's coordinate; divisors are their squares.
pub const JOINT_DEVIATION: Limit = Limit {
    least: 1e-6,
    most: 100.0,
    unit: "rad or m",
    reason: "no joint is held so firmly or moves so far",
};

/// Weights of joints in a synergy.
pub const SYNERGY_WEIGHT: Limit = Limit {
    least: -1e6,
    most: 1e6,
    unit: "",
    reason: "weights only compare joints with each other",
};

/// Shares of variance.
pub const VARIANCE_SHARE: Limit = Limit {
    least: 1e-6,
    most: 1.0,
    unit: "",
    reason: "shares of variance are positive and at most 1",
};

/// Weights of MANO's shapes.
pub const HAND_SHAPE: Limit = Limit {
    least: -100.0,
    most: 100.0,
    unit: "",
    reason: "weights of shapes are in standard deviations",
};

/// Entries of MANO's arrays, which are in metres, in radians or shares.
pub const MANO_NUMBER: Limit = Limit {
    least: -1000.0,
    most: 1000.0,
    unit: "",
    reason: "MANO's numbers are metres, radians and shares",
};

/// Weights of neural networks.
pub const NETWORK_WEIGHT: Limit = Limit {
    least: -1e6,
    most: 1e6,
    unit: "",
    reason: "sums with such a weight have no digits left in single precision",
};

/// Weights, roundings and thresholds of energies.
pub const ENERGY_SETTING: Limit = Limit {
    least: 0.0,
    most: 1e6,
    unit: "",
    reason: "terms are of order one, and a larger weight would drown the others",
};

/// Weight of contact distances in a synthesis.
pub const DISTANCE_WEIGHT: Limit = Limit {
    least: 1e-6,
    most: 1e6,
    unit: "",
    reason: "no other term pulls the contacts to the surface",
};

/// Temperatures of synthesis.
pub const TEMPERATURE: Limit = Limit {
    least: 1e-9,
    most: 1e6,
    unit: "",
    reason: "energies are of order one",
};

/// Probabilities, rates and shares of a synthesis that serve as divisors.
pub const SHARE: Limit = Limit {
    least: 1e-6,
    most: 1.0,
    unit: "",
    reason: "a share is above 0 and at most 1",
};

/// Number of steps of a chain.
pub const STEPS: Limit = Limit {
    least: 0.0,
    most: 1e8,
    unit: "",
    reason: "such a chain takes weeks",
};

/// Number of attempts of a chain, and of poses drawn for its start.
pub const ATTEMPTS: Limit = Limit {
    least: 1.0,
    most: 1e6,
    unit: "",
    reason: "each costs at least one evaluation of the energy",
};

/// Number of chains of one run.
pub const CHAINS: Limit = Limit {
    least: 1.0,
    most: 1e6,
    unit: "",
    reason: "the ends of all chains are held in memory; make more in several runs with other seeds",
};

/// Perturbation of given grasps before they are refined.
pub const PERTURBATION: Limit = Limit {
    least: 0.0,
    most: 1e4,
    unit: "mm",
    reason: "a hand farther off meets no object",
};

/// Number of threads.
pub const THREADS: Limit = Limit {
    least: 1.0,
    most: 1024.0,
    unit: "",
    reason: "more threads than cores only cost memory",
};

/// Temperatures and forces of attraction–diffusion, and other numbers in the unit of an energy.
pub const ENERGY_SCALE: Limit = Limit {
    least: 1e-30,
    most: 1e30,
    unit: "",
    reason: "choose another unit of energy",
};

/// Ends of the region from which random starts are drawn.
pub const REGION: Limit = Limit {
    least: -1e9,
    most: 1e9,
    unit: "",
    reason: "squares of larger distances leave no digits for energies: choose another unit",
};

/// Lengths of the sides of that region.
pub const REGION_SIDE: Limit = Limit {
    least: 1e-15,
    most: 2e9,
    unit: "",
    reason: "steps of finite differences are a small share of it: choose another unit",
};

/// Heights and weights of the named models.
pub const MODEL_NUMBER: Limit = Limit {
    least: 1e-6,
    most: 1e6,
    unit: "",
    reason: "the height only scales the model",
};

/// Time limit for an answer of a program.
pub const ANSWER_TIME: Limit = Limit {
    least: 1e-3,
    most: 1e6,
    unit: "s",
    reason: "no program answers faster, and nobody waits longer",
};

/// Number of pictures along a path.
pub const PICTURES: Limit = Limit {
    least: 2.0,
    most: 1000.0,
    unit: "",
    reason: "the path has two ends, and more pictures in a strip are too small to see",
};

/// Number of searches of a surface, and of searches without a new result that end it.
pub const SEARCHES: Limit = Limit {
    least: 1.0,
    most: 1e9,
    unit: "",
    reason: "all results are held in memory",
};

/// Masses, lengths, forces and rates of a simulation.
pub const SIMULATION: Limit = Limit {
    least: 1e-9,
    most: 1e9,
    unit: "",
    reason: "check the unit",
};

/// Numbers of a simulation that may be zero: friction, gravity along an axis, settling time.
pub const SIMULATION_OR_ZERO: Limit = Limit {
    least: 0.0,
    most: 1e3,
    unit: "",
    reason: "check the unit",
};

/// Steps of a simulation, multiplied by substeps and sweeps.
pub const SIMULATION_STEPS: Limit = Limit {
    least: 1.0,
    most: 1e8,
    unit: "",
    reason: "such a simulation takes hours for each grasp",
};

/// Largest number of motions that map an object onto itself; each is tried on every corner of its mesh.
pub const MOST_MOTIONS: usize = 1000;

/// Largest width of a layer of a neural network; matrices between two layers must fit into memory.
pub const MOST_NETWORK_WIDTH: usize = 1 << 16;

/// Largest number of coordinates of a surface; the size of a Hessian is its square.
pub const MOST_COORDINATES: usize = 10_000;

/// Largest number of bare contacts in one file; the time to judge them grows faster than their number.
pub const MOST_CONTACTS: usize = 400;

impl Limit {
    /// Whether `value` is within the limits; NaN is not.
    pub fn holds(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }

    /// The unit with a space before it.
    fn spaced_unit(&self) -> String {
        if self.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", self.unit)
        }
    }

    /// Refuses a value outside the limits.
    ///
    /// # Errors
    /// If `value` is outside the limits or NaN.
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
#[error("{} is not from {} to {}{}: {}", Short(*value), Short(limit.least), Short(limit.most), limit.spaced_unit(), limit.reason)]
pub struct Beyond {
    /// The number.
    pub value: f64,
    /// Its limit.
    pub limit: Limit,
}

/// A number in a short notation.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value) = self;
        if *value != 0.0 && value.is_finite() && !(1e-4..1e7).contains(&value.abs()) {
            write!(formatter, "{value:e}")
        } else {
            write!(formatter, "{value}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_or_beyond_is_refused_with_its_reason() {
        for limit in [
            HAND_POSITION,
            HAND_LENGTH,
            METRIC_LENGTH,
            HINGE,
            SLIDE,
            COUPLING_RATIO,
            GRASP_POSITION,
            MESH_COORDINATE,
            MESH_SIZE,
            OBJECT_SIZE,
            OBJECT_MASS,
            OBJECT_SCALE,
            DIRECTION,
            JOINT_DEVIATION,
            SYNERGY_WEIGHT,
            VARIANCE_SHARE,
            HAND_SHAPE,
            MANO_NUMBER,
            NETWORK_WEIGHT,
            ENERGY_SETTING,
            DISTANCE_WEIGHT,
            TEMPERATURE,
            SHARE,
            STEPS,
            ATTEMPTS,
            CHAINS,
            PERTURBATION,
            THREADS,
            ENERGY_SCALE,
            REGION,
            REGION_SIDE,
            MODEL_NUMBER,
            ANSWER_TIME,
            PICTURES,
            SEARCHES,
            SIMULATION,
            SIMULATION_OR_ZERO,
            SIMULATION_STEPS,
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
