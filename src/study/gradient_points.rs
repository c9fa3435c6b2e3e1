//! Points at which the gradient of a given energy is checked before it is searched.

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
