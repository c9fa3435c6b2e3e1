//! The space of a surface by the name of its kind of coordinates.

use serde_json::Value;

use crate::space::{Cluster, Euclidean, Periodic, Rotation, Space, Torus};
use crate::store::Manifest;

/// Kinds of coordinates of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinates {
    /// Numbers in a flat space.
    Flat,
    /// Angles in radians, which are periodic.
    Angles,
    /// Positions x, y, z of equal atoms; moved, rotated, mirrored and renumbered copies are the same.
    Atoms,
    /// Numbers that never leave the region.
    Box,
    /// Numbers that wrap: each with the length of its side of the region as its period.
    Periodic,
    /// A unit quaternion w, x, y, z.
    Rotation,
}

/// The number of coordinates does not fit their kind.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CoordinatesError {
    /// An atom has three coordinates.
    #[error("{0} coordinates, and an atom has three")]
    Atoms(usize),
    /// A quaternion has four coordinates.
    #[error("{0} coordinates, and a quaternion has four")]
    Rotation(usize),
    /// The period of a coordinate is the length of its side of the region.
    #[error("periodic coordinates need a region whose sides are longer than 0")]
    Sides,
}

impl Coordinates {
    const ALL: [Self; 6] = [
        Self::Flat,
        Self::Angles,
        Self::Atoms,
        Self::Box,
        Self::Periodic,
        Self::Rotation,
    ];

    /// The name in files and flags.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat",
            Self::Angles => "angles",
            Self::Atoms => "atoms",
            Self::Box => "box",
            Self::Periodic => "periodic",
            Self::Rotation => "rotation",
        }
    }

    /// The kind of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The space of these coordinates, as many as the region has sides. The sides are the periods of periodic ones.
    ///
    /// # Errors
    /// If there cannot be so many coordinates, or a periodic one has no period.
    pub fn space(
        self,
        (low, high): (&[f64], &[f64]),
    ) -> Result<Box<dyn Space + Send>, CoordinatesError> {
        let count = low.len();
        Ok(match self {
            Self::Periodic => {
                let sides = low.iter().zip(high).map(|(low, high)| high - low);
                let sides: Vec<f64> = sides.collect();
                if high.len() != count || !sides.iter().all(|side| *side > 0.0) {
                    return Err(CoordinatesError::Sides);
                }
                Box::new(Periodic::new(low, &sides))
            }
            Self::Flat | Self::Box => Box::new(Euclidean::new(count)),
            Self::Angles => Box::new(Torus::new(count)),
            Self::Atoms if count.is_multiple_of(3) => Box::new(Cluster::new(count / 3)),
            Self::Atoms => return Err(CoordinatesError::Atoms(count)),
            Self::Rotation if count == 4 => Box::new(Rotation::new(1.0)),
            Self::Rotation => return Err(CoordinatesError::Rotation(count)),
        })
    }
}

/// The space of the searched surface of a manifest, and its identification; `None` if it is not recorded.
pub fn surface_space(manifest: &Manifest) -> Option<(Box<dyn Space + Send>, String)> {
    let ends = ["low", "high"].map(|end| {
        let numbers = manifest.energy[end].as_array().into_iter().flatten();
        numbers.filter_map(Value::as_f64).collect::<Vec<f64>>()
    });
    let [low, high] = &ends;
    let kind = Coordinates::named(manifest.energy["coordinates"].as_str()?)?;
    let (count, name) = (low.len(), kind.name());
    Some((
        kind.space((low, high)).ok()?,
        if kind == Coordinates::Periodic {
            format!("{count} {name} from {low:?} to {high:?}")
        } else {
            format!("{count} {name}")
        },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The region may come from a file that somebody changed.
    #[test]
    fn a_region_without_sides_has_no_periods() {
        let kind = Coordinates::Periodic;
        assert!(kind.space((&[0.0, 0.0], &[1.0, 2.0])).is_ok());
        for high in [&[1.0, 0.0][..], &[1.0, f64::NAN], &[1.0]] {
            let refused = kind.space((&[0.0, 0.0], high)).err();
            assert_eq!(refused, Some(CoordinatesError::Sides));
        }
    }
}
