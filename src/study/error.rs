//! Errors of studies.

use std::fmt;

use crate::figure::FigureError;
use crate::grasp::energy::EnergySettingsError;
use crate::hand::HandError;
use crate::printable::counted;
use crate::store::{RebuildError, StoreError};
use crate::thermal::{Missing, Unreachable};
use crate::topography::JournalError;
use crate::topography::exchange::ExchangeError;

/// Reason why a landscape could not be mapped, described or drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// All grasps lie in one minimum, but a landscape needs two.
    #[error("all {0} grasps lie in one minimum: there is nothing to connect")]
    OneMinimum(usize),
    /// All descents on a surface end at one minimum, but a landscape needs two.
    #[error("{}: there is nothing to connect", one_minimum(*.0))]
    OneMinimumOfSurface(usize),
    /// A search found nothing.
    #[error(
        "{surface}: {searches} searches from random points of the region found no minimum {ends}"
    )]
    NoMinimum {
        /// The surface.
        surface: String,
        /// Number of searches.
        searches: usize,
        /// Description of how they ended.
        ends: String,
    },
    /// The landscape belongs to a surface, which has no hand.
    #[error(
        "{0} is a landscape of a surface: this needs one of grasps, which has a hand and an object"
    )]
    NotOfGrasps(String),
    /// The minima are not poses of the hand.
    #[error("{landscape}: minimum {minimum} has {found} coordinates, but the hand has {expected}")]
    Coordinates {
        /// The landscape.
        landscape: String,
        /// The minimum.
        minimum: u64,
        /// Its number of coordinates.
        found: usize,
        /// The number of coordinates of a pose.
        expected: usize,
    },
    /// The object of a landscape cannot be built.
    #[error("the object of {landscape}")]
    Object {
        /// The landscape.
        landscape: String,
        /// The reason.
        source: Box<RebuildError>,
    },
    /// The energy of a landscape belongs to another program or version.
    #[error("the energy of {landscape} is not supported by this version")]
    Energy {
        /// The landscape.
        landscape: String,
        /// The reason.
        source: serde_json::Error,
    },
    /// The tables contain no points of the path between two minima.
    #[error("the landscape contains no path from m{a} to m{b}")]
    NoPath {
        /// One minimum.
        a: u64,
        /// The other.
        b: u64,
    },
    /// A landscape was made by sequential ADELM.
    #[error(
        "{0} was made by sequential ADELM, whose result depends on the order of the grasps: nothing can be added to it"
    )]
    Sequential(String),
    /// The settings of a landscape belong to another version.
    #[error("the settings of {landscape} are not supported by this version")]
    MapSettings {
        /// The landscape.
        landscape: String,
        /// The reason.
        source: serde_json::Error,
    },
    /// Grasps of another hand, object or scale cannot be added to a landscape.
    #[error(
        "no grasp is of the same hand, object and size as {landscape}, which is of hand `{hand}` on `{object}` at scale {scale}"
    )]
    OtherPopulation {
        /// The landscape.
        landscape: String,
        /// Its hand.
        hand: String,
        /// Its object.
        object: String,
        /// Its scale.
        scale: f64,
    },
    /// Grasps of another energy cannot be added to a landscape.
    #[error(
        "{0} is a landscape of another energy, or of another version of it: build one landscape of all grasps instead"
    )]
    OtherEnergy(String),
    /// A landscape has all grasps already.
    #[error(
        "{0} contains all these grasps already: there is nothing to add (--connect searches between two of its minima)"
    )]
    NothingNew(String),
    /// The manifest of a landscape has no family barrier.
    #[error("the landscape does not record its family barrier")]
    NoFamilyBarrier,
    /// `min.data` or `ts.data` is wrong.
    #[error("{folder}")]
    Exchange {
        /// The folder.
        folder: String,
        /// The reason.
        source: ExchangeError,
    },
    /// Thermodynamics and kinetics need curvatures.
    #[error(
        "{0} contains no curvatures (each row of its min.data has the placeholders: ln-product 0, order 1, moments 0): search \
         the surface with `landscape surface`, or give files of PATHSAMPLE with frequencies. Minima on the faces of a box have \
         no curvatures"
    )]
    NoVibrations(String),
    /// Some minima have no curvatures.
    #[error(
        "{name}: the curvatures of {count} of {} are unknown: {minima}. They lie on faces of a box, where they are not \
         harmonic wells, or their rows of min.data contain placeholders. --without-faces leaves them out, together with the \
         saddles that lead to them",
        counted(*all, "minimum")
    )]
    MinimaWithoutVibrations {
        /// The landscape.
        name: String,
        /// Number of minima without curvatures.
        count: usize,
        /// Number of all minima.
        all: usize,
        /// Names of the minima without curvatures.
        minima: String,
    },
    /// Kinetics needs the curvatures of transition states.
    #[error(
        "none of the {count} transition states of {name} has curvatures: they are bounds or lie on the faces of a box, or the \
         rows of ts.data contain the placeholders (ln-product 0, order 1, moments 0; where an ln-product of 0 is known, write \
         1e-300)"
    )]
    NoStateVibrations {
        /// The landscape.
        name: String,
        /// Number of transition states.
        count: usize,
    },
    /// A temperature leads beyond the range of numbers.
    #[error(
        "a temperature kT of {temperature:e} is too far from the energies of {name}: choose one nearer to their differences"
    )]
    FarTemperature {
        /// The landscape.
        name: String,
        /// The temperature.
        temperature: f64,
    },
    /// A stationary point has no curvatures.
    #[error(transparent)]
    Missing(#[from] Missing),
    /// No path joins two sets of minima.
    #[error(
        "no sequence of transition states leads from m{} to the minima named as its goal (upper bounds are not counted)",
        .0.0
    )]
    Unreachable(Unreachable),
    /// Sets have too few grasps for their diversity.
    #[error(transparent)]
    FewGrasps(FewGrasps),
    /// A built-in hand cannot be read.
    #[error(transparent)]
    Hand(#[from] HandError),
    /// A hand or its energy cannot be built.
    #[error(transparent)]
    Rebuild(#[from] RebuildError),
    /// A wish makes no sense for a hand.
    #[error(transparent)]
    Wish(#[from] super::WishError),
    /// A setting of the energy is out of its range.
    #[error(transparent)]
    Settings(#[from] EnergySettingsError),
    /// A finished task cannot be stored.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// A file cannot be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A picture cannot be laid out.
    #[error(transparent)]
    Figure(#[from] FigureError),
}

fn one_minimum(points: usize) -> String {
    match points {
        1 => "there is one point, and the descent from it ends at one minimum".to_owned(),
        _ => format!("the descents from all {points} points end at one minimum"),
    }
}

/// The message says it all, so that the value is no source of the error: reports would say it twice.
impl From<Unreachable> for StudyError {
    fn from(unreachable: Unreachable) -> Self {
        Self::Unreachable(unreachable)
    }
}

/// Sets that are too small for their diversity to be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct FewGrasps {
    /// Their names and numbers of grasps.
    pub few: Vec<(String, usize)>,
    /// The least number.
    pub needed: usize,
}

impl fmt::Display for FewGrasps {
    /// For instance `mug.parquet has 21 grasps and pen.parquet has 24; at least 30 in each set are needed …`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let needed = self.needed;
        for (place, (name, grasps)) in self.few.iter().enumerate() {
            let before = match place {
                0 => "",
                _ if place + 1 == self.few.len() => " and ",
                _ => ", ",
            };
            let lack = needed.saturating_sub(*grasps);
            write!(
                f,
                "{before}{name} has {} ({lack} too few)",
                counted(*grasps, "grasp")
            )?;
        }
        write!(
            f,
            "; at least {needed} in each set are needed, because a comparison of fewer would be a guess: make more (`landscape \
             synth -n {}` keeps about {needed} if three in four pass), or put several files together (`landscape join`)",
            needed * 4 / 3
        )
    }
}
