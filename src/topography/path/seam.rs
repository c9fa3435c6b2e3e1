//! The lowest point of a seam, where two smooth pieces of an energy are equal.
//!
//! An energy E = min over pieces has concave kinks only. At a pass the sublevel set is locally disconnected. Where pieces
//! with gradients g₁, g₂, … meet, that set is the union of the half-spaces gᵢ·u < 0, which is connected unless there are
//! exactly two and they are opposite. So a pass is either a saddle of one piece, or a point where two pieces are equal and
//! a convex combination of their gradients vanishes: the minimum of max(E₁, E₂) along the seam.

use nalgebra::{DMatrix, DVector};

use crate::space::vector::{add, dot, norm, scale};
use crate::topography::eigen::Piece;

pub(super) struct Crossing {
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    /// Norm of the least convex combination of both gradients, energy per length.
    pub(super) residual: f64,
    /// Scaled unit tangent from the first piece's side to the second's.
    pub(super) normal: Vec<f64>,
}

/// The surface on which a descent stays.
pub(super) enum Sheet<'p> {
    /// The seam where two pieces are equal.
    Seam([&'p Piece<'p>; 2]),
    /// The hyperplane across a path through one piece, whose scaled tangent is given.
    Across(&'p Piece<'p>, &'p [f64]),
}

impl<'p> Sheet<'p> {
    fn first(&self) -> &'p Piece<'p> {
        match self {
            Self::Seam([piece, _]) | Self::Across(piece, _) => piece,
        }
    }
}

/// Energies and gradients of both pieces at a point.
struct Pair {
    x: Vec<f64>,
    energies: [f64; 2],
    gradients: [Vec<f64>; 2],
}

impl Pair {
    fn at(sheet: &Sheet<'_>, x: Vec<f64>) -> Self {
        let n = sheet.first().space().tangents();
        let mut gradients = [vec![0.0; n], vec![0.0; n]];
        let [first, second] = &mut gradients;
        let energy = sheet.first().evaluate(&x, first);
        let energies = match sheet {
            Sheet::Seam([_, piece]) => [energy, piece.evaluate(&x, second)],
            Sheet::Across(_, tangent) => {
                second.clone_from(first);
                add(second, -1.0, tangent);
                [energy, energy]
            }
        };
        Self {
            x,
            energies,
            gradients,
        }
    }

    fn height(&self) -> f64 {
        self.energies[0].max(self.energies[1])
    }

    fn gap(&self) -> f64 {
        self.energies[0] - self.energies[1]
    }

    /// g₁ − g₂, normal to the seam.
    fn across(&self) -> Vec<f64> {
        let mut across = self.gradients[0].clone();
        add(&mut across, -1.0, &self.gradients[1]);
        across
    }

    /// The gradient along the seam.
    fn along(&self) -> Vec<f64> {
        let across = self.across();
        let mut along = self.gradients[0].clone();
        let share = dot(&along, &across) / dot(&across, &across);
        add(&mut along, -share, &across);
        along
    }
}

pub(super) fn least_combination(a: &[f64], b: &[f64]) -> f64 {
    norm(&shortest_combination(a, b))
}

pub(super) fn shortest_combination(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut across = a.to_vec();
    add(&mut across, -1.0, b);
    let square = dot(&across, &across);
    let share = if square > 0.0 {
        (dot(a, &across) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mut least = a.to_vec();
    add(&mut least, -share, &across);
    least
}

/// Result of a descent along a seam.
pub(super) struct Slide {
    pub(super) x: Vec<f64>,
    /// The lowest point of the seam, if the descent converged to it.
    pub(super) crossing: Option<Crossing>,
}

/// Descends along the seam of two pieces from a point near it, for at most `steps` steps or until `leave(point, energy)`.
///
/// Each step is a Newton step onto the seam plus a BFGS step along it, as in J. N. Harvey et al., Theor. Chem. Acc. 99, 95
/// (1998). There is no crossing if it does not converge or if both pieces fall on one side.
pub(super) fn slide(
    sheet: &Sheet<'_>,
    start: &[f64],
    (tolerance, tie): (f64, f64),
    longest: f64,
    steps: usize,
    leave: &mut dyn FnMut(&[f64], f64) -> bool,
) -> Slide {
    let piece = sheet.first();
    let n = piece.space().tangents();
    let mut here = Pair::at(sheet, start.to_vec());
    let mut inverse: Option<DMatrix<f64>> = None;
    for _ in 0..steps {
        let (across, along) = (here.across(), here.along());
        let square = dot(&across, &across);
        if !here.height().is_finite() || square.is_nan() || square == 0.0 {
            break;
        }
        if here.gap().abs() <= tie && piece.size(&along) <= tolerance {
            let opposite =
                dot(&here.gradients[0], &across) > 0.0 && dot(&here.gradients[1], &across) < 0.0;
            let mut normal = across;
            scale(&mut normal, square.sqrt().recip());
            let crossing = (opposite && matches!(sheet, Sheet::Seam(_))).then(|| Crossing {
                energy: here.energies[0].min(here.energies[1]),
                residual: piece.size(&along),
                x: here.x.clone(),
                normal,
            });
            return Slide {
                x: here.x,
                crossing,
            };
        }
        let along_vector = DVector::from_column_slice(&along);
        let mut slide: Vec<f64> = match &inverse {
            Some(inverse) => (-(inverse * &along_vector)).as_slice().to_vec(),
            None => along
                .iter()
                .map(|g| -g * 0.1 * longest / norm(&along).max(f64::MIN_POSITIVE))
                .collect(),
        };
        let share = dot(&slide, &across) / square;
        add(&mut slide, -share, &across);
        add(&mut slide, -here.gap() / square, &across);
        let length = norm(&slide);
        if length > longest {
            scale(&mut slide, longest / length);
        }
        let mut found = None;
        for _ in 0..10 {
            let next = Pair::at(sheet, piece.moved(&here.x, &slide));
            if next.height() < here.height() + tie {
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
        if leave(&here.x, here.energies[0].min(here.energies[1])) {
            break;
        }
    }
    Slide {
        x: here.x,
        crossing: None,
    }
}
