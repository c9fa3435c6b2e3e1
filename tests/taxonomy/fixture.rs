//! Fixtures of the taxonomy: a hand posed on primitives, and a description of the scene.

use std::collections::BTreeMap;

use landscape::hand::Hand;
use landscape::object::Primitive;
use serde::{Deserialize, Serialize};

/// A posed hand on an object.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Fixture {
    /// Unique id, for instance `14-c`: the type and a letter, or `none-` and a number for poses outside the taxonomy.
    pub(crate) id: String,
    /// Number of the type, 1 to 33; `None` outside the taxonomy.
    #[serde(rename = "type")]
    pub(crate) kind: Option<u8>,
    /// Name of the type; `none` outside the taxonomy.
    pub(crate) name: String,
    /// The scene in one sentence.
    pub(crate) depicts: String,
    /// Solids, object frame, metres; the object is their union.
    pub(crate) object: Vec<Primitive>,
    /// Pose of the hand's root frame.
    pub(crate) object_from_hand: Placement,
    /// Joint angles by name, radians.
    pub(crate) joints: BTreeMap<String, f64>,
    /// Regions (or the starts of their names) that touch according to the description.
    pub(crate) touching: Vec<String>,
}

/// A rigid motion.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Placement {
    /// Translation, metres.
    pub(crate) translation_m: [f64; 3],
    /// Unit quaternion.
    pub(crate) rotation_wxyz: [f64; 4],
}

impl Fixture {
    /// Coordinates `[t, q(wxyz), joints]` of the hand; `None` if a joint is missing or unknown.
    pub(crate) fn coordinates(&self, hand: &Hand) -> Option<Vec<f64>> {
        if self.joints.len() != hand.joints.len() {
            return None;
        }
        let mut x = self.object_from_hand.translation_m.to_vec();
        x.extend(self.object_from_hand.rotation_wxyz);
        for joint in &hand.joints {
            x.push(*self.joints.get(&joint.name)?);
        }
        Some(x)
    }
}
