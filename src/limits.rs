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

/// The table: what is limited, its name, the smallest and the largest value, their unit, and the reason.
macro_rules! limits {
    ($($(#[$what:meta])+ $name:ident: $least:expr, $most:expr, $unit:literal, $reason:literal;)+) => {$(
        $(#[$what])+
        pub const $name: Limit = Limit {
            least: $least,
            most: $most,
            unit: $unit,
            reason: $reason,
        };
    )+};
}

limits! {
    /// Coordinates of frames, ends and corners of a hand, in the frame in which they are given.
    HAND_POSITION: -10.0, 10.0, "m",
        "hands are described in metres";

    /// Radii and lengths of the parts of a hand.
    HAND_LENGTH: 1e-6, 10.0, "m",
        "hands are described in metres";

    /// Lengths of a hand's metric: how far a unit of a joint, which others may follow, moves the hand.
    METRIC_LENGTH: 1e-6, 1e4, "m",
        "hands are described in metres";

    /// Limits and offsets of hinges: sixteen turns.
    HINGE: -100.0, 100.0, "rad",
        "a joint that turns without end is continuous (URDF) or has no range (MJCF)";

    /// Limits and offsets of slides.
    SLIDE: -10.0, 10.0, "m",
        "joints that slide are described in metres";

    /// Ratio at which a joint follows another, with all couplings between them multiplied.
    COUPLING_RATIO: -1000.0, 1000.0, "",
        "no joint moves so much faster than the joint it follows";

    /// Coordinates of a hand relative to the origin of its object; squares of far larger numbers are infinite.
    GRASP_POSITION: -1000.0, 1000.0, "m",
        "lengths are in metres";

    /// Coordinates of meshes and shapes, in the unit of their file.
    MESH_COORDINATE: -1e9, 1e9, "",
        "no hand-held object has such a size in any unit of length";

    /// Sizes of meshes and shapes, in the unit of their file; volumes of far smaller and larger ones are zero or infinite.
    MESH_SIZE: 1e-9, 1e9, "",
        "no hand-held object has such a size in any unit of length";

    /// Longest side of an object; an object outside this range is surely not in metres.
    OBJECT_SIZE: 2e-3, 2.0, "m",
        "hands hold nothing smaller or larger";

    /// Masses of objects.
    OBJECT_MASS: 1e-9, 1e6, "kg",
        "masses are in kilograms";

    /// Factors on the size of objects.
    OBJECT_SCALE: 1e-6, 1e6, "",
        "meshes are made in units from the micrometre to the kilometre";

    /// Thickness of the walls that open surfaces become.
    WALL_THICKNESS: 0.1, 100.0, "mm",
        "walls of objects that hands hold are millimetres thick";

    /// Lengths of direction vectors; squares of far smaller and larger ones are zero or infinite.
    DIRECTION: 1e-9, 1e9, "",
        "a direction of length one is needed";

    /// Standard deviations of a joint's coordinate; divisors are their squares.
    JOINT_DEVIATION: 1e-6, 100.0, "rad or m",
        "no joint is held so firmly or moves so far";

    /// Weights of joints in a synergy.
    SYNERGY_WEIGHT: -1e6, 1e6, "",
        "weights only compare joints with each other";

    /// Shares of variance.
    VARIANCE_SHARE: 1e-6, 1.0, "",
        "shares of variance are positive and at most 1";

    /// Weights of MANO's shapes.
    HAND_SHAPE: -100.0, 100.0, "",
        "weights of shapes are in standard deviations";

    /// Entries of MANO's arrays, which are in metres, in radians or shares.
    MANO_NUMBER: -1000.0, 1000.0, "",
        "MANO's numbers are metres, radians and shares";

    /// Weights of neural networks.
    NETWORK_WEIGHT: -1e6, 1e6, "",
        "sums with such a weight have no digits left in single precision";

    /// Coefficients of a labeller that was taught, and means and ends of what it has seen.
    LABELLER_NUMBER: -1e9, 1e9, "",
        "features of grasps are of order one";

    /// Deviations of what a labeller has seen.
    LABELLER_DEVIATION: 1e-3, 1e9, "",
        "features are divided by their deviations";

    /// Exponents of a labeller's scores, and of the rule's probabilities.
    LABELLER_EXPONENT: 0.0, 10.0, "",
        "larger powers of probabilities are zero";

    /// Weights, roundings and thresholds of energies.
    ENERGY_SETTING: 0.0, 1e6, "",
        "terms are of order one, and a larger weight would drown the others";

    /// Distances between the patches of an elastic layer.
    PATCH_SPACING: 1e-3, 1.0, "m",
        "patches lie millimetres to centimetres apart";

    /// Probabilities, rates and shares of a synthesis that serve as divisors.
    SHARE: 1e-6, 1.0, "",
        "a share is above 0 and at most 1";

    /// Number of steps of a chain.
    STEPS: 0.0, 1e8, "",
        "such a chain takes weeks";

    /// Number of chains of one run.
    CHAINS: 1.0, 1e6, "",
        "the ends of all chains are held in memory; make more in several runs with other seeds";

    /// Perturbation of given grasps before they are refined.
    PERTURBATION: 0.0, 1e4, "mm",
        "a hand farther off meets no object";

    /// Numbers of an elastic layer that something is divided by.
    LAYER_SETTING: 1e-9, 1e6, "",
        "0 would divide by zero";
    /// Gaps and depths at which an elastic layer carries.
    SKIN: -0.1, 0.1, "m",
        "skin is millimetres thick";
    /// Number of threads.
    THREADS: 1.0, 1024.0, "",
        "more threads than cores only cost memory";

    /// Temperatures and forces of attraction–diffusion, and other numbers in the unit of an energy.
    ENERGY_SCALE: 1e-30, 1e30, "",
        "choose another unit of energy";

    /// Ends of the region from which random starts are drawn.
    REGION: -1e9, 1e9, "",
        "squares of larger distances leave no digits for energies: choose another unit";

    /// Lengths of the sides of that region.
    REGION_SIDE: 1e-15, 2e9, "",
        "steps of finite differences are a small share of it: choose another unit";

    /// Heights and weights of the named models.
    MODEL_NUMBER: 1e-6, 1e6, "",
        "the height only scales the model";

    /// Time limit for an answer of a program.
    ANSWER_TIME: 1e-3, 1e6, "s",
        "no program answers faster, and nobody waits longer";

    /// Number of pictures along a path.
    PICTURES: 2.0, 1000.0, "",
        "the path has two ends, and more pictures in a strip are too small to see";

    /// Time after which a search stops, seconds.
    BUDGET: 1e-3, 1e8, "s",
        "a search takes up to three years";

    /// Number of the lowest minima that are joined.
    LOWEST: 2.0, 1e6, "",
        "a tree needs two minima";

    /// Number of searches of a surface, and of searches without a new result that end it.
    SEARCHES: 1.0, 1e9, "",
        "all results are held in memory";

    /// Masses, lengths, forces and rates of a simulation.
    SIMULATION: 1e-9, 1e9, "",
        "check the unit";

    /// Numbers of a simulation that may be zero: friction, gravity along an axis, settling time.
    SIMULATION_OR_ZERO: 0.0, 1e3, "",
        "check the unit";

    /// Steps of a simulation, multiplied by substeps and sweeps.
    SIMULATION_STEPS: 1.0, 1e8, "",
        "such a simulation takes hours for each grasp";

    /// Lengths, energies, forces and factors among the settings of maps and searches.
    POSITIVE_SETTING: 1e-15, 1e12, "",
        "check the unit";

    /// Such settings that may be zero.
    SETTING: 0.0, 1e12, "",
        "check the unit";

    /// Numbers of steps, chains, rounds and levels in the settings of maps and searches.
    COUNT_SETTING: 1.0, 1e6, "",
        "nothing is gained by more";

    /// Such numbers that may be zero.
    COUNT_SETTING_OR_ZERO: 0.0, 1e6, "",
        "nothing is gained by more";

    /// Evaluations, searches and steps of a whole run.
    EFFORT_SETTING: 1.0, 1e12, "",
        "no run ends after so many";

    /// Neighbours of a minimum, segments of a path.
    NEIGHBOURS_SETTING: 1.0, 10_000.0, "",
        "more would fill the memory";

    /// Seeds in files of settings, which hold no larger whole numbers.
    SEED_SETTING: 0.0, 9.3e18, "",
        "a seed is a whole number";
}

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
            WALL_THICKNESS,
            DIRECTION,
            JOINT_DEVIATION,
            SYNERGY_WEIGHT,
            VARIANCE_SHARE,
            HAND_SHAPE,
            MANO_NUMBER,
            NETWORK_WEIGHT,
            LABELLER_NUMBER,
            LABELLER_DEVIATION,
            LABELLER_EXPONENT,
            ENERGY_SETTING,
            SHARE,
            STEPS,
            CHAINS,
            PERTURBATION,
            LAYER_SETTING,
            PATCH_SPACING,
            SKIN,
            THREADS,
            ENERGY_SCALE,
            REGION,
            REGION_SIDE,
            MODEL_NUMBER,
            ANSWER_TIME,
            PICTURES,
            BUDGET,
            LOWEST,
            SEARCHES,
            SIMULATION,
            SIMULATION_OR_ZERO,
            SIMULATION_STEPS,
            POSITIVE_SETTING,
            SETTING,
            COUNT_SETTING,
            COUNT_SETTING_OR_ZERO,
            EFFORT_SETTING,
            NEIGHBOURS_SETTING,
            SEED_SETTING,
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
