//! A descent across a path.

use nalgebra::{DMatrix, DVector};

use crate::space::vector::{add, dot, norm, scale};
use crate::topography::eigen::Scaled;

/// Energy, gradient and normal of the hyperplane at a point.
struct Place {
    x: Vec<f64>,
    energy: f64,
    gradient: Vec<f64>,
    across: Vec<f64>,
}

impl Place {
    fn at(surface: &Scaled<'_>, tangent: &[f64], x: Vec<f64>) -> Self {
        let mut gradient = vec![0.0; tangent.len()];
        let energy = surface.evaluate(&x, &mut gradient);
        // The tangent, as the difference of two gradients rounds it.
        let mut tilted = gradient.clone();
        add(&mut tilted, -1.0, tangent);
        let mut across = gradient.clone();
        add(&mut across, -1.0, &tilted);
        Self {
            x,
            energy,
            gradient,
            across,
        }
    }

    /// The gradient within the hyperplane.
    fn along(&self) -> Vec<f64> {
        let mut along = self.gradient.clone();
        let share = dot(&along, &self.across) / dot(&self.across, &self.across);
        add(&mut along, -share, &self.across);
        along
    }
}

/// Descends from a point within the hyperplane perpendicular to the scaled `tangent`, for at most `steps` steps or until
/// `leave(point)`. Returns the last point.
///
/// Each step is a BFGS step. It is no longer than `longest`, and the energy rises by less than `tie`. The descent ends where
/// the gradient within the hyperplane is at most `tolerance`.
pub(super) fn descend_across(
    surface: &Scaled<'_>,
    tangent: &[f64],
    start: &[f64],
    (tolerance, tie): (f64, f64),
    longest: f64,
    steps: usize,
    leave: &mut dyn FnMut(&[f64]) -> bool,
) -> Vec<f64> {
    let n = tangent.len();
    let mut here = Place::at(surface, tangent, start.to_vec());
    let mut inverse: Option<DMatrix<f64>> = None;
    for _ in 0..steps {
        let along = here.along();
        let square = dot(&here.across, &here.across);
        if !here.energy.is_finite()
            || square.is_nan()
            || square == 0.0
            || surface.size(&along) <= tolerance
        {
            break;
        }
        let along_vector = DVector::from_column_slice(&along);
        let mut slide: Vec<f64> = match &inverse {
            Some(inverse) => (-(inverse * &along_vector)).as_slice().to_vec(),
            None => along
                .iter()
                .map(|g| -g * 0.1 * longest / norm(&along).max(f64::MIN_POSITIVE))
                .collect(),
        };
        let share = dot(&slide, &here.across) / square;
        add(&mut slide, -share, &here.across);
        let length = norm(&slide);
        if length > longest {
            scale(&mut slide, longest / length);
        }
        let mut found = None;
        for _ in 0..10 {
            let next = Place::at(surface, tangent, surface.moved(&here.x, &slide));
            if next.energy < here.energy + tie {
                found = Some(next);
                break;
            }
            scale(&mut slide, 0.3);
        }
        let Some(next) = found else { break };
        let step = DVector::from_column_slice(&slide);
        let change = DVector::from_column_slice(&next.along()) - &along_vector;
        let curvature = step.dot(&change);
        if curvature > 1e-10 * step.norm() * change.norm() {
            let before = inverse
                .take()
                .unwrap_or_else(|| DMatrix::identity(n, n) * (curvature / change.norm_squared()));
            let moved = &before * &change;
            let factor = (curvature + change.dot(&moved)) / (curvature * curvature);
            inverse = Some(
                before + &step * step.transpose() * factor
                    - (&moved * step.transpose() + &step * moved.transpose()) / curvature,
            );
        } else if inverse.is_some() {
            inverse = None;
        }
        here = next;
        if leave(&here.x) {
            break;
        }
    }
    here.x
}
