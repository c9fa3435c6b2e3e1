//! The link of the hand whose poses a file of another program holds.

use std::collections::BTreeSet;

use super::grasp_import::GraspImportError;
use super::import_doubt::of_frame;
use crate::hand::{Hand, LinkId, PosedHand};
use crate::space::Pose;
use crate::store::exchange::{Mapping, Read};

/// The link whose poses a file holds; `None` if it is the root of the hand.
///
/// A mapping that names a link is believed. Otherwise the file may name one, of which only the part after the last slash
/// counts (`/World/panda_hand`), or its format may be one of poses of the outermost body. If the hand has no link of the name
/// in the file, a note says so.
///
/// # Errors
/// If the mapping names a link that the hand does not have.
pub(super) fn link_of_poses(
    mapping: &Mapping,
    read: &Read,
    hand: &Hand,
    notes: &mut BTreeSet<String>,
) -> Result<Option<LinkId>, GraspImportError> {
    let known = || -> Vec<&str> { hand.links.iter().map(|link| link.name.as_str()).collect() };
    let link = if let Some(name) = &mapping.link {
        let link = hand.link(name);
        Some(link.ok_or_else(|| GraspImportError::UnknownLink {
            link: name.clone(),
            hand: hand.name.clone(),
            known: known().join(", "),
        })?)
    } else if let Some(name) = &read.link {
        let last = name.rsplit('/').next().unwrap_or(name);
        let link = hand.link(last);
        if link.is_none() {
            notes.insert(format!(
                "the poses of the file are those of `{name}`, which is not a link of hand `{}`: they are taken for those of its \
                 root `{}`; `link` in a mapping names another one",
                hand.name, hand.links[0].name
            ));
        }
        link
    } else if read.of_outermost_body {
        hand.root_offset().map(|_| LinkId(1))
    } else {
        None
    };
    Ok(link.filter(|link| link.0 != 0))
}

/// The pose of the hand's root if `pose` is that of `link` at the joints of the pose:
///
/// ```text
/// object_from_root = object_from_link · root_from_link(joints)⁻¹
/// ```
pub(super) fn root_pose(hand: &Hand, link: LinkId, pose: &Pose) -> Pose {
    let mut posed = PosedHand::default();
    hand.pose_links(&Pose::at_origin(pose.joints()), &mut posed);
    of_frame(pose, &posed.object_from_link[link.0])
}
