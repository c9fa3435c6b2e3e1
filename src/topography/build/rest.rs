//! Which of the given points are minima.

use rayon::prelude::*;

use crate::energy::Energy;
use crate::space::vector::norm;
use crate::topography::landscape::NoMinimum;
use crate::topography::minima::MatchTolerance;
use crate::topography::network::Minimum;

/// The distinct points of `minima` that are minima, sorted by energy, and the rejected points.
pub(super) fn at_rest(
    energy: &dyn Energy,
    minima: Vec<Minimum>,
    sameness: &MatchTolerance,
) -> (Vec<Minimum>, Vec<NoMinimum>) {
    let space = energy.space();
    let examined: Vec<Result<Minimum, NoMinimum>> = minima
        .into_par_iter()
        .enumerate()
        .map(|(row, minimum)| moving(energy, &minimum, row, sameness).map_or(Ok(minimum), Err))
        .collect();
    let (mut sorted, mut rejected) = (Vec::new(), Vec::new());
    for minimum in examined {
        match minimum {
            Ok(minimum) => sorted.push(minimum),
            Err(refused) => rejected.push(refused),
        }
    }
    sorted.sort_by(by_energy);
    let mut distinct: Vec<Minimum> = Vec::with_capacity(sorted.len());
    for minimum in sorted {
        let first = distinct.partition_point(|m| m.energy < minimum.energy - sameness.energy);
        let (x, height) = (&minimum.coordinates, minimum.energy);
        let mut near = distinct[first..].iter_mut();
        if let Some(known) = near.find(|known| sameness.holds(space, x, height, known)) {
            known.members.extend(minimum.members);
            known.members.sort_unstable();
            known.members.dedup();
        } else {
            distinct.push(minimum);
        }
    }
    (distinct, rejected)
}

/// The rejection of the point in `row`, if it is not a minimum.
fn moving(
    energy: &dyn Energy,
    minimum: &Minimum,
    row: usize,
    sameness: &MatchTolerance,
) -> Option<NoMinimum> {
    let (space, x) = (energy.space(), &minimum.coordinates);
    let finite = x.len() == space.coordinates() && x.iter().all(|c| c.is_finite());
    if !finite {
        let gradient_norm = f64::NAN;
        return Some(NoMinimum { row, gradient_norm });
    }
    let mut gradient = vec![0.0; space.tangents()];
    let height = energy.evaluate(x, &mut gradient);
    let gradient_norm = norm(&gradient);
    // NaN values fail these comparisons too.
    let rests = (height - minimum.energy).abs() <= sameness.energy
        && gradient_norm * sameness.distance <= sameness.energy;
    (!rests).then_some(NoMinimum { row, gradient_norm })
}

pub(in crate::topography) fn by_energy(a: &Minimum, b: &Minimum) -> std::cmp::Ordering {
    a.energy.total_cmp(&b.energy).then_with(|| {
        let coordinates = a.coordinates.iter().zip(&b.coordinates);
        let orders = coordinates.map(|(a, b)| a.total_cmp(b));
        orders.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    })
}
