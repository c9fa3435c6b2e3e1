//! The hands that come with the program.

use std::sync::OnceLock;

use super::{Hand, HandError, HandFiles};

/// Names of the hands that come with the program; see `data/hands`.
pub const HAND_NAMES: [&str; 5] = [
    "human",
    "human_left",
    "human_thumbless",
    "gripper_three_finger",
    "gripper_parallel",
];

const HUMAN: [&str; 2] = [
    include_str!("../../data/hands/human/human.urdf"),
    include_str!("../../data/hands/human/human.json"),
];

impl HandFiles {
    /// The files of a hand that comes with the program.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn named(name: &str) -> Result<Self, HandError> {
        let [urdf, json] = HUMAN;
        let human = || Self::of_texts([["human.urdf", urdf], ["human.json", json]]);
        match name {
            "human" => Ok(human()),
            "human_left" => human().mirrored(),
            "human_thumbless" => Ok(Self::of_texts([
                ["human.urdf", urdf],
                [
                    "human_thumbless.json",
                    include_str!("../../data/hands/human_thumbless/human_thumbless.json"),
                ],
            ])),
            "gripper_three_finger" => Ok(Self::of_texts([[
                "gripper_three_finger.urdf",
                include_str!("../../data/hands/gripper_three_finger/gripper_three_finger.urdf"),
            ]])),
            "gripper_parallel" => Ok(Self::of_texts([[
                "gripper_parallel.urdf",
                include_str!("../../data/hands/gripper_parallel/gripper_parallel.urdf"),
            ]])),
            _ => Err(HandError::NoSuchHand {
                name: name.to_owned(),
            }),
        }
    }
}

impl Hand {
    /// A hand that comes with the program, see [`HAND_NAMES`].
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn named(name: &str) -> Result<Self, HandError> {
        Self::from_files(&HandFiles::named(name)?)
    }

    /// The human right hand that comes with this crate: 22 joints, 50th percentile (`data/hands/human`).
    ///
    /// # Panics
    /// Never: the description is part of the program, and the tests read it.
    pub fn human() -> Self {
        static HAND: OnceLock<Hand> = OnceLock::new();
        HAND.get_or_init(|| Self::named("human").expect("the tests read this very description"))
            .clone()
    }
}
