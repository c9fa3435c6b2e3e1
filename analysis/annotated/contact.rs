//! Which parts of a hand touch, and whether a type agrees with that.

use std::collections::BTreeSet;

use landscape::evaluation::taxonomy::GraspType;

/// The palm's number; the thumb is 1, the little finger 5.
pub(crate) const PALM: usize = 0;
const THUMB: usize = 1;
/// The names of the parts, in the order of their numbers.
pub(crate) const PARTS: [&str; 6] = ["palm", "thumb", "index", "middle", "ring", "little"];
/// What is nearer touches, mm. The test data draw the same line.
pub(crate) const NEAR_MM: f64 = 5.0;

/// Least distance of each part to the object, mm, negative inside.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Contact {
    /// The palm, the thumb … the little finger; infinite where it is not known how far a part is that does not touch.
    pub(crate) parts_mm: [f64; PARTS.len()],
    /// The palm and each bone, where they were measured, always in the same order.
    pub(crate) bones_mm: Vec<f64>,
}

impl Contact {
    /// The parts that touch, where the palm touches from `palm_mm` on.
    pub(crate) fn touching(&self, palm_mm: f64) -> BTreeSet<usize> {
        let touches = |part: &usize| {
            let near = if *part == PALM { palm_mm } else { NEAR_MM };
            self.parts_mm[*part] < near
        };
        (0..self.parts_mm.len()).filter(touches).collect()
    }
}

/// Whether a type agrees with what touches: all of both its virtual fingers, the palm only where it is one of these, and no
/// finger but the helping ones of the type. The thumb may always touch.
pub(crate) fn agrees(entry: &GraspType, touching: &BTreeSet<usize>) -> bool {
    let needed = || entry.vf1.iter().chain(&entry.vf2);
    let may = |part: &usize| *part == THUMB || needed().chain(&entry.vf3).any(|one| one == part);
    needed().all(|part| touching.contains(part)) && touching.iter().all(may)
}

/// Whether a type would agree if the palm alone were read differently.
pub(crate) fn agrees_but_for_the_palm(entry: &GraspType, touching: &BTreeSet<usize>) -> bool {
    let mut other = touching.clone();
    if !other.remove(&PALM) {
        other.insert(PALM);
    }
    agrees(entry, &other)
}
