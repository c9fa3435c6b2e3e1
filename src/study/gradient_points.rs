//! Points at which the gradient and the declared symmetries of a given energy are checked before it is searched.

use std::fmt;

use crate::energy::Energy;
use crate::optimize::{QuenchSettings, quench};
use crate::sample::{Task, stream};
use crate::study::in_region;

/// Step of the finite differences of energies, relative to the shortest side of the region.
const DIFFERENCE: f64 = 1e-5;
/// Number of random points at which the gradient is checked, and of points along descents from them.
const CHECKED: u64 = 3;
/// Evaluations of such a descent, which need not converge.
const DESCENT: usize = 20;

/// Step of the finite differences with which [`check_gradient`](crate::energy::check_gradient) checks an energy in a region.
pub fn difference_step((low, high): (&[f64], &[f64])) -> f64 {
    let sides = low.iter().zip(high).map(|(low, high)| high - low);
    DIFFERENCE * sides.fold(f64::INFINITY, f64::min)
}

/// Random points of the region and points on descents from them, at which the gradient of `energy` is to be checked. After
/// the evaluation at each random point `proceed` tells whether to go on, so that an energy without a gradient is not asked
/// for a descent.
///
/// # Errors
/// Those of `proceed`.
pub fn gradient_points<E>(
    energy: &dyn Energy,
    (low, high): (&[f64], &[f64]),
    step: f64,
    seed: u64,
    mut proceed: impl FnMut() -> Result<bool, E>,
) -> Result<Vec<Vec<f64>>, E> {
    let draw = in_region(energy.space(), (low, high));
    let descent = QuenchSettings::default()
        .with_max_step(1e3 * step)
        .with_max_evaluations(DESCENT);
    let mut points = Vec::new();
    for id in 0..CHECKED {
        let x = draw(&mut stream(seed, Task::Start, u64::MAX / 2 + id));
        energy.evaluate(&x, &mut vec![0.0; energy.space().tangents()]);
        if !proceed()? {
            return Ok(Vec::new());
        }
        points.push(quench(energy, &x, &descent).x);
        points.push(x);
    }
    Ok(points)
}

/// A declared symmetry that changes the energy.
#[derive(Debug, Clone, PartialEq)]
pub struct BrokenSymmetry {
    /// Index of the generator.
    pub generator: usize,
    /// A point.
    pub x: Vec<f64>,
    /// The energies of the point and of its copy.
    pub energies: [f64; 2],
}

impl fmt::Display for BrokenSymmetry {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([here, there], x) = (self.energies, &self.x);
        write!(
            formatter,
            "symmetry {} changes the energy from {here} to {there} at {x:?}, so it is not a symmetry of the energy",
            self.generator + 1
        )
    }
}

impl std::error::Error for BrokenSymmetry {}

/// Relative difference between the energies of a point and its copy that rounding explains.
const ROUNDING: f64 = 1e-6;

/// Compares the energies of `points` with those of their copies by each of the `generators`, each of which has a number for
/// every coordinate as in [`Coordinates::Symmetric`](super::Coordinates::Symmetric). After each copy `proceed` tells whether the
/// energy could be computed.
///
/// # Errors
/// Those of `proceed`. The first symmetry that changes the energy is returned.
///
/// # Panics
/// If a generator has a zero, or a number beyond the coordinates.
pub fn broken_symmetry<E>(
    generators: &[Vec<i64>],
    energy: &dyn Energy,
    points: &[Vec<f64>],
    mut proceed: impl FnMut() -> Result<(), E>,
) -> Result<Option<BrokenSymmetry>, E> {
    let mut gradient = vec![0.0; energy.space().tangents()];
    let mut of = |x: &[f64]| energy.evaluate(x, &mut gradient);
    let energies: Vec<f64> = points.iter().map(|x| of(x)).collect();
    let largest = energies.iter().filter(|energy| energy.is_finite());
    let largest = largest.fold(0.0, |most: f64, energy| most.max(energy.abs()));
    for (generator, numbers) in generators.iter().enumerate() {
        for (x, here) in points.iter().zip(&energies) {
            let place = |n: &i64| usize::try_from(n.unsigned_abs()).unwrap_or(0) - 1;
            let value = |n: &i64| if *n < 0 { -x[place(n)] } else { x[place(n)] };
            let copy: Vec<f64> = numbers.iter().map(value).collect();
            let there = of(&copy);
            proceed()?;
            let equal = (there - here).abs() <= ROUNDING * largest;
            if !equal && there.total_cmp(here).is_ne() {
                return Ok(Some(BrokenSymmetry {
                    generator,
                    x: x.clone(),
                    energies: [*here, there],
                }));
            }
        }
    }
    Ok(None)
}
