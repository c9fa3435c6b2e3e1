//! The space of a surface by the name of its kind of coordinates.

use serde_json::Value;

use crate::sample::Rng;
use crate::space::{
    Cluster, Copies, Euclidean, FixedFrame, Periodic, Rotation, Space, Symmetries, SymmetryError,
    Torus,
};
use crate::store::Manifest;
use crate::topography::in_box;

/// Kinds of coordinates of a surface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Coordinates {
    /// Numbers in a flat space.
    Flat,
    /// Angles in radians, which are periodic.
    Angles,
    /// Positions x, y, z of equal atoms; moved, rotated, mirrored and renumbered copies are the same.
    Atoms,
    /// Positions of atoms of these elements; as `Atoms`, but only atoms of one element are renumbered.
    Elements(Vec<String>),
    /// Positions of atoms of these elements in a fixed frame; atoms of one element are renumbered, and moved copies differ.
    /// If they are periodic, each coordinate wraps as in `Periodic`.
    FixedFrame {
        /// The element of each atom.
        elements: Vec<String>,
        /// Whether the coordinates wrap.
        periodic: bool,
    },
    /// Numbers or angles of which copies by permutations and changes of sign are the same ([`Symmetries`]).
    Symmetric {
        /// Whether they are angles.
        angles: bool,
        /// Symmetries that make all others, each a signed number for each coordinate.
        generators: Vec<Vec<i64>>,
    },
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
    /// An atom has three coordinates and one element.
    #[error("{coordinates} coordinates for {elements} atoms, and an atom has three")]
    Elements {
        /// The number of coordinates.
        coordinates: usize,
        /// The number of elements that are named.
        elements: usize,
    },
    /// The symmetries do not fit the coordinates.
    #[error(transparent)]
    Symmetry(#[from] SymmetryError),
    /// A quaternion has four coordinates.
    #[error("{0} coordinates, and a quaternion has four")]
    Rotation(usize),
    /// Atoms of one element wrap alike.
    #[error("sides of different length for atoms of one element, which wrap alike")]
    Unlike,
    /// The period of a coordinate is the length of its side of the region.
    #[error("periodic coordinates need a region whose sides are longer than 0")]
    Sides,
}

impl Coordinates {
    const PLAIN: [Self; 6] = [
        Self::Flat,
        Self::Angles,
        Self::Atoms,
        Self::Box,
        Self::Periodic,
        Self::Rotation,
    ];

    /// The name in files and flags. That of atoms with elements names the element of each: `atoms Ar Ar Kr`, or in a fixed
    /// frame `flat Ar Ar` and `periodic Ar Ar`. That of symmetries names what makes them: `flat modulo 2 1 3, -1 2 3`.
    pub fn name(&self) -> String {
        let name = match self {
            Self::Flat => "flat",
            Self::Angles => "angles",
            Self::Atoms => "atoms",
            Self::Elements(elements) => return format!("atoms {}", elements.join(" ")),
            Self::FixedFrame { elements, periodic } => {
                let frame = if *periodic { "periodic" } else { "flat" };
                return format!("{frame} {}", elements.join(" "));
            }
            Self::Symmetric { angles, generators } => {
                let frame = if *angles { "angles" } else { "flat" };
                let numbers = |generator: &Vec<i64>| {
                    let numbers: Vec<String> = generator.iter().map(i64::to_string).collect();
                    numbers.join(" ")
                };
                let generators: Vec<String> = generators.iter().map(numbers).collect();
                return format!("{frame} modulo {}", generators.join(", "));
            }
            Self::Box => "box",
            Self::Periodic => "periodic",
            Self::Rotation => "rotation",
        };
        name.to_owned()
    }

    /// The kind of this name.
    pub fn named(name: &str) -> Option<Self> {
        let plain = Self::PLAIN.into_iter().find(|kind| kind.name() == name);
        plain.or_else(|| {
            let (frame, elements) = name.split_once(' ')?;
            if let Some(symmetries) = elements.strip_prefix("modulo ") {
                let generator = |text: &str| {
                    let numbers = text.split_whitespace().map(|number| number.parse().ok());
                    numbers.collect::<Option<Vec<i64>>>()
                };
                let generators = symmetries
                    .split(',')
                    .map(generator)
                    .collect::<Option<_>>()?;
                let angles = frame == "angles";
                return (angles || frame == "flat")
                    .then_some(Self::Symmetric { angles, generators });
            }
            let elements = elements.split_whitespace().map(str::to_owned);
            let elements: Vec<String> = elements.collect();
            match frame {
                _ if elements.is_empty() => None,
                "atoms" => Some(Self::Elements(elements)),
                "flat" | "periodic" => Some(Self::FixedFrame {
                    elements,
                    periodic: frame == "periodic",
                }),
                _ => None,
            }
        })
    }

    /// A number for each atom of a cluster, equal for equal elements. Empty if all atoms are equal; `None` if these are no
    /// positions of the atoms of a cluster.
    pub fn kinds(&self) -> Option<Vec<usize>> {
        match self {
            Self::Atoms => Some(Vec::new()),
            Self::Elements(elements) => Some(kinds(elements)),
            _ => None,
        }
    }

    /// The space of coordinates with declared symmetries; `None` for others, or if they do not fit.
    pub fn copies(&self, count: usize) -> Option<Copies> {
        match self {
            Self::Symmetric { angles, generators } => copies(count, *angles, generators).ok(),
            _ => None,
        }
    }

    /// Whether the coordinates wrap with the sides of the region.
    pub fn is_periodic(&self) -> bool {
        matches!(
            self,
            Self::Periodic | Self::FixedFrame { periodic: true, .. }
        )
    }

    /// The space of these coordinates, as many as the region has sides. The sides are the periods of periodic ones.
    ///
    /// # Errors
    /// If there cannot be so many coordinates, or a periodic one has no period.
    pub fn space(
        &self,
        (low, high): (&[f64], &[f64]),
    ) -> Result<Box<dyn Space + Send>, CoordinatesError> {
        let count = low.len();
        let sides: Vec<f64> = if self.is_periodic() {
            let sides = low.iter().zip(high).map(|(low, high)| high - low);
            sides.collect()
        } else {
            vec![f64::INFINITY; count]
        };
        if high.len() != count || !sides.iter().all(|side| *side > 0.0) {
            return Err(CoordinatesError::Sides);
        }
        let cell = Periodic::new(low, &sides);
        Ok(match self {
            Self::Periodic => Box::new(cell),
            Self::FixedFrame { elements, .. } if count == 3 * elements.len() => {
                let kinds = kinds(elements);
                let unlike = |k: usize| unlike(sides[k], sides[3 * kinds[k / 3] + k % 3]);
                if (0..count).any(unlike) {
                    return Err(CoordinatesError::Unlike);
                }
                Box::new(FixedFrame::new(cell, &kinds))
            }
            Self::Symmetric { angles, generators } => Box::new(copies(count, *angles, generators)?),
            Self::Flat | Self::Box => Box::new(Euclidean::new(count)),
            Self::Angles => Box::new(Torus::new(count)),
            Self::Atoms if count.is_multiple_of(3) => Box::new(Cluster::new(count / 3)),
            Self::Atoms => return Err(CoordinatesError::Atoms(count)),
            Self::Elements(elements) if count == 3 * elements.len() => {
                Box::new(Cluster::of_kinds(&self.kinds().unwrap_or_default()))
            }
            Self::Elements(elements) | Self::FixedFrame { elements, .. } => {
                return Err(CoordinatesError::Elements {
                    coordinates: count,
                    elements: elements.len(),
                });
            }
            Self::Rotation if count == 4 => Box::new(Rotation::new(1.0)),
            Self::Rotation => return Err(CoordinatesError::Rotation(count)),
        })
    }
}

fn copies(count: usize, angles: bool, generators: &[Vec<i64>]) -> Result<Copies, SymmetryError> {
    let symmetries = Symmetries::new(count, generators)?;
    Ok(if angles {
        Copies::of_angles(count, symmetries)
    } else {
        Copies::of_numbers(count, symmetries)
    })
}

/// Whether two periods differ by more than rounding.
fn unlike(one: f64, other: f64) -> bool {
    (one - other).abs() > 1e-9 * one
}

/// A number for each element, equal for equal ones.
fn kinds(elements: &[String]) -> Vec<usize> {
    let first = |element| elements.iter().position(|each| each == element);
    elements.iter().filter_map(first).collect()
}

/// Draws points uniformly from a region, as [`in_box`] does. A point that holds a quaternion is then scaled to be one of
/// `space`: a function is defined on unit quaternions only.
///
/// # Panics
/// The returned function panics if a lower bound is not below its upper bound.
pub fn in_region<'a>(
    space: &'a dyn Space,
    (low, high): (&'a [f64], &'a [f64]),
) -> impl Fn(&mut Rng) -> Vec<f64> + Sync + 'a {
    let draw = in_box(low, high);
    move |rng: &mut Rng| {
        let mut x = draw(rng);
        onto(space, &mut x);
        x
    }
}

/// Moves a point onto its space: scales quaternions to length 1.
pub fn onto(space: &dyn Space, x: &mut [f64]) {
    if space.coordinates() != space.tangents() {
        space.exp(x, &vec![0.0; space.tangents()]);
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
        if kind.is_periodic() {
            format!("{count} {name} from {low:?} to {high:?}")
        } else {
            format!("{count} {name}")
        },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Task, stream};

    #[test]
    fn random_rotations_are_unit_quaternions() {
        let space = Rotation::new(1.0);
        let (low, high) = ([-1.0; 4], [1.0; 4]);
        let draw = in_region(&space, (&low, &high));
        for id in 0..20 {
            let x = draw(&mut stream(0, Task::Start, id));
            let norm = x.iter().map(|k| k * k).sum::<f64>().sqrt();
            assert!((norm - 1.0).abs() < 1e-12 && x[0] >= 0.0, "{x:?}");
        }
        let flat = Euclidean::new(4);
        let drawn = in_region(&flat, (&low, &high))(&mut stream(0, Task::Start, 0));
        assert_eq!(drawn, in_box(&low, &high)(&mut stream(0, Task::Start, 0)));
    }

    #[test]
    fn atoms_of_elements_have_a_name_that_tells_them() {
        let kind = Coordinates::named("atoms Ar Kr Ar").unwrap();
        assert_eq!(kind.name(), "atoms Ar Kr Ar");
        assert_eq!(kind.kinds(), Some(vec![0, 1, 0]));
        let region = |count| (vec![0.0; count], vec![1.0; count]);
        let (low, high) = region(9);
        assert_eq!(kind.space((&low, &high)).unwrap().coordinates(), 9);
        let (low, high) = region(6);
        assert!(kind.space((&low, &high)).is_err());
        assert_eq!(Coordinates::named("atoms"), Some(Coordinates::Atoms));
        assert_eq!(Coordinates::named("angles Ar"), None);
    }

    #[test]
    fn atoms_in_a_fixed_frame_have_a_name_that_tells_them() {
        for (name, wraps) in [("flat Ar Ar", false), ("periodic Ar Ar", true)] {
            let kind = Coordinates::named(name).unwrap();
            assert_eq!(kind.name(), name);
            assert_eq!((kind.kinds(), kind.is_periodic()), (None, wraps));
            let space = kind.space((&[0.0; 6], &[4.0; 6])).unwrap();
            let (a, b) = (
                [0.5, 0.0, 0.0, 3.0, 2.0, 2.0],
                [3.0, 2.0, 2.0, 3.9, 0.0, 0.0],
            );
            let along = if wraps { 0.6 } else { 3.4 };
            assert!((space.distance(&a, &b) - along).abs() < 1e-12, "{name}");
            assert!(kind.space((&[0.0; 9], &[4.0; 9])).is_err());
            let unlike = kind.space((&[0.0; 6], &[4.0, 4.0, 4.0, 5.0, 4.0, 4.0]));
            assert_eq!(unlike.err(), wraps.then_some(CoordinatesError::Unlike));
        }
    }

    #[test]
    fn symmetries_have_a_name_that_tells_them() {
        let name = "angles modulo 2 1 3, 1 2 -3";
        let kind = Coordinates::named(name).unwrap();
        assert_eq!(kind.name(), name);
        let space = kind.space((&[0.0; 3], &[1.0; 3])).unwrap();
        assert!(space.distance(&[0.1, 0.2, 0.3], &[0.2, 0.1, -0.3]) < 1e-12);
        assert!(kind.space((&[0.0; 2], &[1.0; 2])).is_err());
        assert_eq!(Coordinates::named("flat modulo 2 x"), None);
    }

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
