//! Checks of grasps in [`GraspFile::read`] and [`GraspFile::write`].

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::error::{Fault, StoreError, Warning, list};
use super::grasps::{GraspFile, GraspRow, term_column};
use super::metadata::HandMetadata;
use super::quaternion::norm;
use crate::limits::{GRASP_POSITION, OBJECT_SCALE};

/// Largest accepted excess of a joint beyond its limit, radians. Published grasps exceed limits by up to 0.58 rad
/// (`DexGraspNet`, whose limits are also terms of the energy). Angles in degrees and lengths in millimetres exceed them by
/// more.
pub(crate) const LIMIT_TOLERANCE_RAD: f64 = 1.0;
/// Excess that is explained by rounding to 32 bits and needs no warning, radians.
const ROUNDING_RAD: f64 = 1e-6;
/// Quaternions that are farther than this from unit length are refused. Smaller deviations come from 32-bit or printed
/// numbers.
const UNIT_TOLERANCE: f64 = 1e-3;

impl GraspFile {
    /// Faults of all rows, for instance to drop those rows before writing.
    pub fn faults(&self) -> Vec<(usize, Fault)> {
        let mut first_row = BTreeMap::new();
        let mut faults = Vec::new();
        for (row, grasp) in self.grasps.iter().enumerate() {
            let first = *first_row.entry(grasp.id).or_insert(row);
            let repeated = (first != row).then_some(Fault::RepeatedId {
                id: grasp.id,
                first,
            });
            faults.extend(self.fault(grasp).or(repeated).map(|fault| (row, fault)));
        }
        faults
    }

    pub(super) fn refuse_faults(&self, path: &Path) -> Result<(), StoreError> {
        match self.faults().into_iter().next() {
            Some((row, fault)) => Err(StoreError::Row {
                path: path.to_path_buf(),
                row,
                fault,
            }),
            None => Ok(()),
        }
    }

    /// The fault of a single grasp, without comparison to other rows.
    fn fault(&self, grasp: &GraspRow) -> Option<Fault> {
        let Some(hand) = self.hand(&grasp.hand) else {
            let known = list(self.metadata.hands.iter().map(|hand| hand.name.as_str()));
            return Some(Fault::UnknownHand {
                hand: grasp.hand.clone(),
                known,
            });
        };
        if self.object(&grasp.object).is_none() {
            let known = list(
                self.metadata
                    .objects
                    .iter()
                    .map(|object| object.name.as_str()),
            );
            return Some(Fault::UnknownObject {
                object: grasp.object.clone(),
                known,
            });
        }
        wrong_length(
            "joints",
            grasp.grasp.pose.joints().len(),
            hand.joint_names.len(),
        )
        .or_else(|| {
            let squeezed = grasp.squeeze_joints.as_ref()?;
            wrong_length("squeeze_joints", squeezed.len(), hand.joint_names.len())
        })
        .or_else(|| wrong_length("term_…", grasp.terms.len(), self.metadata.terms.len()))
        .or_else(|| self.not_finite(grasp))
        .or_else(|| {
            let mut far = grasp.grasp.pose.translation_m().iter().copied();
            let value = far.find(|value| !GRASP_POSITION.holds(*value))?;
            Some(Fault::Far(value))
        })
        .or_else(|| {
            let beyond = OBJECT_SCALE.check(grasp.scale).err();
            beyond.map(Fault::Scale)
        })
        .or_else(|| {
            let norm = norm(grasp.grasp.pose.rotation_wxyz());
            ((norm - 1.0).abs() > UNIT_TOLERANCE).then_some(Fault::NotUnit(norm))
        })
        .or_else(|| far_joint(grasp, hand))
        .or_else(|| bad_contact(grasp, hand))
    }

    fn not_finite(&self, grasp: &GraspRow) -> Option<Fault> {
        let fault = |column: &str, value: f64| Fault::NotFinite {
            column: column.to_owned(),
            value,
        };
        let pose = &grasp.grasp.pose;
        let lists = [
            ("translation_m", pose.translation_m()),
            ("rotation_wxyz", &pose.rotation_wxyz()),
            ("joints", pose.joints()),
            (
                "squeeze_joints",
                grasp.squeeze_joints.as_deref().unwrap_or_default(),
            ),
        ];
        let scalars = [
            ("scale", Some(grasp.scale)),
            ("energy", Some(grasp.energy)),
            ("net_wrench", Some(grasp.net_wrench)),
            ("distance_squared", Some(grasp.distance_squared)),
            ("penetration", Some(grasp.penetration)),
            ("friction", grasp.friction),
            ("epsilon", grasp.epsilon),
            ("label_score", grasp.label_score),
        ];
        let terms = self.metadata.terms.iter().zip(&grasp.terms);
        let in_lists = lists
            .into_iter()
            .flat_map(|(column, values)| values.iter().map(move |value| (column, *value)));
        let in_scalars = scalars
            .into_iter()
            .filter_map(|(column, value)| Some((column, value?)));
        let first = in_lists
            .chain(in_scalars)
            .find(|(_, value)| !value.is_finite());
        first
            .map(|(column, value)| fault(column, value))
            .or_else(|| {
                let (name, value) = terms.into_iter().find(|(_, value)| !value.is_finite())?;
                Some(fault(&term_column(name), *value))
            })
    }

    /// A warning about joints beyond their limits.
    pub fn beyond_limits(&self) -> Option<Warning> {
        let (mut count, mut worst) = (0, (ROUNDING_RAD, 0, ""));
        for (row, grasp) in self.grasps.iter().enumerate() {
            let hand = self.hand(&grasp.hand);
            let farthest = hand
                .into_iter()
                .flat_map(|hand| excesses(grasp, hand))
                .max_by(|(_, a), (_, b)| a.total_cmp(b));
            let Some((joint, excess)) = farthest.filter(|(_, excess)| *excess > ROUNDING_RAD)
            else {
                continue;
            };
            count += 1;
            if excess > worst.0 {
                worst = (excess, row, joint);
            }
        }
        let (excess, row, joint) = worst;
        (count > 0).then(|| Warning::BeyondLimit {
            count,
            grasps: self.grasps.len(),
            row,
            joint: joint.to_owned(),
            excess,
        })
    }
}

fn wrong_length(column: &str, found: usize, expected: usize) -> Option<Fault> {
    (found != expected).then(|| Fault::Length {
        column: column.to_owned(),
        found,
        expected,
    })
}

/// Joints beyond a limit, and their excess.
fn excesses<'a>(
    grasp: &'a GraspRow,
    hand: &'a HandMetadata,
) -> impl Iterator<Item = (&'a str, f64)> {
    let joints = hand
        .joint_names
        .iter()
        .zip(&hand.limits)
        .zip(grasp.grasp.pose.joints());
    joints.filter_map(|((name, [lower, upper]), angle)| {
        let excess = (lower - angle).max(angle - upper);
        (excess > 0.0).then_some((name.as_str(), excess))
    })
}

fn far_joint(grasp: &GraspRow, hand: &HandMetadata) -> Option<Fault> {
    let (name, _) = excesses(grasp, hand).find(|(_, excess)| *excess > LIMIT_TOLERANCE_RAD)?;
    let joint = hand.joint_names.iter().position(|joint| joint == name)?;
    let [lower, upper] = hand.limits[joint];
    Some(Fault::BeyondLimit {
        joint: name.to_owned(),
        value: grasp.grasp.pose.joints()[joint],
        lower,
        upper,
    })
}

fn bad_contact(grasp: &GraspRow, hand: &HandMetadata) -> Option<Fault> {
    let points = hand.surface_points;
    let mut seen = BTreeSet::new();
    grasp.grasp.contacts.iter().find_map(|&contact| {
        if usize::try_from(contact).is_ok_and(|index| index < points) {
            (!seen.insert(contact)).then_some(Fault::RepeatedContact(contact))
        } else {
            Some(Fault::ContactRange {
                contact,
                hand: hand.name.clone(),
                points,
            })
        }
    })
}
