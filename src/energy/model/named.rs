//! The reference surfaces by name, with the region where their searches start.

use super::{DoubleWell, LennardJones, MullerBrown, Orientation, ThreeHole, Torsion};
use crate::energy::Energy;
use crate::limits::MODEL_NUMBER;

/// A surface and a box of coordinates that contains its minima.
pub struct Surface {
    /// Its name with its arguments.
    pub name: String,
    /// The surface.
    pub energy: Box<dyn Energy + Send>,
    /// Kind of its coordinates: `flat`, `angles`, `atoms` or `rotation`.
    pub coordinates: &'static str,
    /// The least value of each coordinate of a random start.
    pub low: Vec<f64>,
    /// The greatest value of each coordinate of a random start.
    pub high: Vec<f64>,
}

impl std::fmt::Debug for Surface {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Surface")
            .field("name", &self.name)
            .field("low", &self.low)
            .field("high", &self.high)
            .finish_non_exhaustive()
    }
}

/// A kind of surface that has a name.
#[derive(Debug, Clone, Copy)]
pub struct Model {
    /// Its name.
    pub name: &'static str,
    /// Its arguments in the notation of a manual.
    pub arguments: &'static str,
    /// Its description, in half a sentence.
    pub about: &'static str,
    build: fn(&[f64]) -> Option<Surface>,
}

/// All models; a new one is an entry here.
pub const MODELS: &[Model] = &[
    Model {
        name: "muller-brown",
        arguments: "",
        about: "three minima and two saddles in the plane, the customary test of path searches",
        build: |words| match words {
            [] => Some(surface(MullerBrown::new(), &[-1.5, -0.3], &[1.0, 1.8])),
            _ => None,
        },
    },
    Model {
        name: "three-hole",
        arguments: "",
        about: "two deep holes and a shallow one between them, through which the lowest way leads",
        build: |words| match words {
            [] => Some(surface(ThreeHole::new(), &[-2.0, -1.5], &[2.0, 2.5])),
            _ => None,
        },
    },
    Model {
        name: "double-well",
        arguments: "D [TILT]",
        about: "D independent double wells: 2^D minima, D 2^(D-1) saddles; unequal minima with a tilt below 1.5",
        build: |words| {
            let (count, tilt) = match words {
                [count] => (*count, 0.0),
                [count, tilt] if tilt.abs() < 1.5 => (*count, *tilt),
                _ => return None,
            };
            let d = whole(count, 1..=10)?;
            Some(surface(
                DoubleWell::new(d).with_tilt(tilt),
                &vec![-1.6; d],
                &vec![1.6; d],
            ))
        },
    },
    Model {
        name: "torsion",
        arguments: "HEIGHT FOLD [HEIGHT FOLD ...]",
        about: "independent angles on a torus, each with FOLD minima and barriers twice HEIGHT",
        build: |words| {
            if words.is_empty() || words.len() % 2 == 1 {
                return None;
            }
            let angles: Option<Vec<(f64, u8)>> = words
                .chunks_exact(2)
                .map(|pair| {
                    let fold = u8::try_from(whole(pair[1], 1..=12)?).ok()?;
                    MODEL_NUMBER.holds(pair[0]).then_some((pair[0], fold))
                })
                .collect();
            let n = words.len() / 2;
            let half = std::f64::consts::PI;
            Some(Surface {
                coordinates: "angles",
                ..surface(Torsion::new(&angles?), &vec![-half; n], &vec![half; n])
            })
        },
    },
    Model {
        name: "orientation",
        arguments: "[C C C C]",
        about: "a quartic of the unit quaternion: four minima and twelve saddles among the rotations",
        build: |words| {
            let weights = match words {
                [] => [1.0, 1.5, 2.0, 3.0],
                _ => <[f64; 4]>::try_from(words).ok()?,
            };
            let sensible = weights.iter().all(|c| MODEL_NUMBER.holds(*c));
            sensible.then(|| Surface {
                coordinates: "rotation",
                ..surface(Orientation::new(weights), &[-1.0; 4], &[1.0; 4])
            })
        },
    },
    Model {
        name: "lj",
        arguments: "N",
        about: "N Lennard-Jones atoms, modulo moving, turning, mirroring and renumbering (2 <= N <= 100)",
        build: |words| {
            let [count] = words else { return None };
            let atoms = whole(*count, 2..=100)?;
            // Half the side of a box in which compact clusters are common.
            let half = 0.62 * libm::cbrt(atoms as f64);
            Some(Surface {
                coordinates: "atoms",
                ..surface(
                    LennardJones::new(atoms),
                    &vec![-half; 3 * atoms],
                    &vec![half; 3 * atoms],
                )
            })
        },
    },
];

/// Why a named surface cannot be made.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// No model has this name.
    #[error("no model is called `{}`; the models are {}", .0, names())]
    Unknown(String),
    /// The arguments do not fit.
    #[error("`{given}` does not fit the model: write `{name} {arguments}`, {about}")]
    Arguments {
        /// The given words.
        given: String,
        /// The model.
        name: &'static str,
        /// Its arguments.
        arguments: &'static str,
        /// Its description.
        about: &'static str,
    },
}

fn names() -> String {
    let names: Vec<&str> = MODELS.iter().map(|model| model.name).collect();
    names.join(", ")
}

/// The surface given by words such as `lj 7`.
///
/// # Errors
/// If there is no such model, or its arguments do not fit.
pub fn named<S: AsRef<str>>(words: &[S]) -> Result<Surface, ModelError> {
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    let (name, arguments) = words.split_first().unwrap_or((&"", &[]));
    let Some(model) = MODELS.iter().find(|model| model.name == *name) else {
        return Err(ModelError::Unknown((*name).to_owned()));
    };
    let numbers: Option<Vec<f64>> = arguments
        .iter()
        .map(|word| word.parse().ok().filter(|number: &f64| number.is_finite()))
        .collect();
    let built = numbers.and_then(|numbers| (model.build)(&numbers));
    let Some(mut surface) = built else {
        return Err(ModelError::Arguments {
            given: words.join(" "),
            name: model.name,
            arguments: model.arguments,
            about: model.about,
        });
    };
    surface.name = words.join(" ");
    Ok(surface)
}

fn surface(energy: impl Energy + Send + 'static, low: &[f64], high: &[f64]) -> Surface {
    debug_assert_eq!(energy.space().coordinates(), low.len());
    Surface {
        name: String::new(),
        energy: Box::new(energy),
        coordinates: "flat",
        low: low.to_vec(),
        high: high.to_vec(),
    }
}

/// The number if it is an integer in this range.
fn whole(number: f64, range: std::ops::RangeInclusive<usize>) -> Option<usize> {
    range
        .into_iter()
        .find(|n| (number - *n as f64).abs() < f64::EPSILON)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_can_be_had() {
        for words in [
            "muller-brown",
            "three-hole",
            "double-well 3",
            "double-well 2 0.3",
            "torsion 1 2 3 2",
            "orientation",
            "orientation 1 2 3 4",
            "lj 7",
        ] {
            let words: Vec<&str> = words.split(' ').collect();
            let surface = named(&words).unwrap();
            let n = surface.energy.space().coordinates();
            assert_eq!((surface.low.len(), surface.high.len()), (n, n));
            assert_eq!(surface.name, words.join(" "));
        }
        for model in MODELS {
            assert!(named(&[model.name]).is_ok() || !model.arguments.is_empty());
        }
    }

    #[test]
    fn what_does_not_fit_is_told() {
        for words in [
            "lj",
            "lj 1",
            "lj 7.5",
            "lj seven",
            "lj 7 8",
            "torsion 1",
            "torsion 1 0",
            "torsion -1 2",
            "double-well 3 2",
            "orientation 1 2 3",
            "orientation 1 2 3 0",
            "muller-brown 1",
            "lj nan",
        ] {
            let words: Vec<&str> = words.split(' ').collect();
            assert!(
                matches!(named(&words), Err(ModelError::Arguments { .. })),
                "{words:?}"
            );
        }
        let error = named(&["ising"]).unwrap_err().to_string();
        assert!(error.contains("muller-brown, three-hole"), "{error}");
    }
}
