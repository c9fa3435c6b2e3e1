//! The joints of the hand whose grasps are read.

use super::listed;
use crate::hand::Hand;

/// The joints of a hand: what a reader needs to know of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HandJoints {
    /// Their names, in the order of the joint coordinates.
    pub names: Vec<String>,
    /// Names of the joints that follow others. They are no coordinates, but a file may hold them.
    pub following: Vec<String>,
    /// The coordinates of the rest pose, radians or metres, for files without joints; `None` if such files are to be refused.
    pub rest: Option<Vec<f64>>,
}

impl HandJoints {
    /// The coordinates of a grasp whose file has none, and a note on them.
    pub(super) fn at_rest(&self) -> Result<(Vec<f64>, String), String> {
        let Some(rest) = &self.rest else {
            return Err("it has no joints of the hand".to_owned());
        };
        let values: Vec<String> = (self.names.iter().zip(rest))
            .map(|(name, value)| format!("{name} {value:.4}"))
            .collect();
        let values = listed(values.iter().map(String::as_str));
        let note = format!(
            "the file has no joints of the hand: they are those of its rest pose ({values}), with which the hand need not touch"
        );
        Ok((rest.clone(), note))
    }
}

impl From<&Hand> for HandJoints {
    fn from(hand: &Hand) -> Self {
        let names: Vec<String> = hand.joints.iter().map(|joint| joint.name.clone()).collect();
        let moved = hand.links.iter().map(|link| &link.joint_name);
        let following = moved.filter(|name| !name.is_empty() && !names.contains(name));
        Self {
            following: following.cloned().collect(),
            rest: Some(hand.prior.rest.clone()),
            names,
        }
    }
}

impl From<&[String]> for HandJoints {
    /// Joints of which only the names are known.
    fn from(names: &[String]) -> Self {
        Self {
            names: names.to_vec(),
            ..Self::default()
        }
    }
}

impl From<&Vec<String>> for HandJoints {
    fn from(names: &Vec<String>) -> Self {
        names.as_slice().into()
    }
}

impl<const N: usize> From<&[String; N]> for HandJoints {
    fn from(names: &[String; N]) -> Self {
        names.as_slice().into()
    }
}
