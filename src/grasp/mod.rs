//! Grasp synthesis: from a hand and an object to an energy and grasps.
//!
//! [`term`] contains the terms of the energy, [`energy`] is their sum, and [`synthesis`] runs the search. [`contact`] chooses
//! the contact set of a grasp, [`filter`] and [`closure`] judge it, [`depth`] measures penetration, and [`failure`] finds
//! contacts in one concavity. [`kernel`] proposes moves for maps. [`paper`] is the method of Liu et al. (2021).

pub mod between;
pub mod closing;
pub mod closure;
pub mod contact;
pub mod depth;
pub mod energy;
pub mod failure;
pub mod filter;
pub mod grip;
pub mod kernel;
pub mod layer;
pub mod paper;
pub mod spread;
pub mod start;
pub mod synthesis;
pub mod term;

pub use energy::{EnergySettings, GraspEnergy};
pub use filter::{Judgement, MeasuredContact, judge, measure_contacts};
pub use kernel::GraspKernel;

use serde::{Deserialize, Serialize};

use crate::space::Pose;

/// A grasp: hand pose and contact set. Its [`GraspEnergy`] or population determines the hand and the object.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Grasp {
    /// Pose of the hand in the object's frame.
    pub pose: Pose,
    /// Contact set: indices of the hand's surface points.
    pub contacts: Vec<u32>,
}

impl Grasp {
    /// The grasp of a pose and a contact set.
    ///
    /// # Panics
    /// If the coordinates have fewer than 7 numbers.
    pub fn new(pose: impl Into<Pose>, contacts: Vec<u32>) -> Self {
        let pose = pose.into();
        Self { pose, contacts }
    }

    /// The grasp of a pose and its best contact set.
    ///
    /// # Panics
    /// If the pose belongs to another hand.
    pub fn best(energy: &GraspEnergy, pose: impl Into<Pose>) -> Self {
        let pose = pose.into();
        let contacts = energy.contacts(&pose);
        Self { pose, contacts }
    }
}
