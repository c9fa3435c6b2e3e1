//! Minima: descents and removal of duplicates.

use serde::{Deserialize, Serialize};

use super::Phase;
use super::journal::{JournalError, Run, bits};
use super::linkage::linkage;
use super::network::Minimum;
use crate::energy::Energy;
use crate::optimize::{Quench, QuenchSettings, StopReason, quench};
use crate::space::Space;

/// Tolerance within which two stationary points are the same. Both values have units. The defaults suit a surface whose
/// energies and lengths are of order 1; for any other surface measure them ([`Scales`](super::Scales)) or choose them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MatchTolerance {
    /// Greatest difference in energy.
    pub energy: f64,
    /// Greatest distance, modulo the symmetry of the space.
    pub distance: f64,
}

impl MatchTolerance {
    /// Tolerances for a surface whose typical barrier is `energy` high and `length` wide.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self {
            energy: 1e-6 * energy,
            distance: 0.01 * length,
        }
    }
}

impl Default for MatchTolerance {
    fn default() -> Self {
        Self {
            energy: 1e-6,
            distance: 1e-3,
        }
    }
}

impl MatchTolerance {
    /// Whether the point `x` with this energy is `minimum`.
    pub fn holds(&self, space: &dyn Space, x: &[f64], energy: f64, minimum: &Minimum) -> bool {
        (energy - minimum.energy).abs() <= self.energy
            && space.within(x, &minimum.coordinates, self.distance)
    }
}

/// A start that led to no minimum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rejected {
    /// Row number of the start.
    pub row: usize,
    /// Norm of the gradient where the descent ended, energy per length.
    pub gradient_norm: f64,
    /// Why it ended there.
    pub stop: StopReason,
}

/// Descends from every start in parallel. Row i of the result belongs to start i.
///
/// # Errors
/// If the journal of `run` cannot store a record.
pub fn quench_all(
    energy: &dyn Energy,
    starts: &[Vec<f64>],
    settings: &QuenchSettings,
    run: &Run<'_>,
) -> Result<Vec<Quench>, JournalError> {
    let tally = run.tally(Phase::Quench, starts.len());
    let rows: Vec<(usize, &Vec<f64>)> = starts.iter().enumerate().collect();
    let found = run.each(
        &tally,
        &rows,
        |(row, _)| format!("quench/{row}"),
        |(_, start)| QuenchRecord(quench(energy, start, settings)),
    )?;
    Ok(found.into_iter().map(|found| found.0).collect())
}

/// Returns the distinct minima among `found`, lowest first, and the rejected rows, with gradients above `max_gradient`.
///
/// Sameness is transitive here: two points belong together if a sequence of pairs that match joins them. A minimum is
/// represented by its lowest member. The order of the input affects only the row numbers.
pub fn distinct(
    energy: &dyn Energy,
    found: &[Quench],
    sameness: &MatchTolerance,
    max_gradient: f64,
) -> (Vec<Minimum>, Vec<Rejected>) {
    let space = energy.space();
    let (mut sorted, mut rejected) = (Vec::new(), Vec::new());
    for (row, quench) in found.iter().enumerate() {
        // A NaN gradient must be rejected.
        if quench.energy.is_finite() && quench.gradient_norm <= max_gradient {
            sorted.push(row);
        } else {
            rejected.push(Rejected {
                row,
                gradient_norm: quench.gradient_norm,
                stop: quench.stop,
            });
        }
    }
    sorted.sort_by(|a, b| order(&found[*a], &found[*b]).then(a.cmp(b)));
    let ends: Vec<&Quench> = sorted.iter().map(|row| &found[*row]).collect();
    let sets = linkage(space, &ends, sameness);
    let mut minima: Vec<Minimum> = Vec::new();
    let mut number = vec![None; sorted.len()];
    for (i, row) in sorted.iter().enumerate() {
        // Rows are sorted by energy, so the first row of a set is its lowest.
        let place = *number[sets.find(i)].get_or_insert_with(|| {
            minima.push(Minimum::bare(found[*row].x.clone(), found[*row].energy));
            minima.len() - 1
        });
        minima[place].members.push(*row);
    }
    for minimum in &mut minima {
        minimum.members.sort_unstable();
    }
    (minima, rejected)
}

/// Orders by energy and then by coordinates, independently of row numbers.
fn order(a: &Quench, b: &Quench) -> std::cmp::Ordering {
    a.energy.total_cmp(&b.energy).then_with(|| {
        let pairs = a.x.iter().zip(&b.x);
        pairs
            .map(|(a, b)| a.total_cmp(b))
            .find(|o| o.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal)
    })
}

/// A [`Quench`] that is stored bit for bit.
#[derive(Serialize, Deserialize)]
pub(super) struct QuenchRecord(#[serde(with = "Bits")] pub(super) Quench);

#[derive(Serialize, Deserialize)]
#[serde(remote = "Quench")]
struct Bits {
    #[serde(with = "bits::list")]
    x: Vec<f64>,
    #[serde(with = "bits::number")]
    energy: f64,
    #[serde(with = "bits::number")]
    gradient_norm: f64,
    evaluations: usize,
    stop: StopReason,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::model::MullerBrown;
    use crate::sample::{Task, stream};
    use rand::RngExt;

    fn starts(count: u64) -> Vec<Vec<f64>> {
        (0..count)
            .map(|id| {
                let mut rng = stream(5, Task::Start, id);
                vec![rng.random_range(-1.5..1.0), rng.random_range(-0.3..1.8)]
            })
            .collect()
    }

    #[test]
    fn order_of_the_input_does_not_matter() {
        let energy = MullerBrown::new();
        let mut found = quench_all(
            &energy,
            &starts(40),
            &QuenchSettings::default(),
            &Run::default(),
        )
        .unwrap();
        let sameness = MatchTolerance::default();
        let (minima, rejected) = distinct(&energy, &found, &sameness, 1e-6);
        assert_eq!(minima.len(), 3);
        assert!(rejected.is_empty());
        assert_eq!(minima.iter().map(|m| m.members.len()).sum::<usize>(), 40);
        found.reverse();
        let (reversed, _) = distinct(&energy, &found, &sameness, 1e-6);
        for (one, other) in minima.iter().zip(&reversed) {
            assert_eq!(one.coordinates, other.coordinates);
            let mut members: Vec<_> = other.members.iter().map(|row| 39 - row).collect();
            members.sort_unstable();
            assert_eq!(one.members, members);
        }
    }

    #[test]
    fn unfinished_descents_are_rejected_and_named() {
        let energy = MullerBrown::new();
        let settings = QuenchSettings::default().with_max_evaluations(3);
        let found = quench_all(&energy, &starts(5), &settings, &Run::default()).unwrap();
        let (minima, rejected) = distinct(&energy, &found, &MatchTolerance::default(), 1e-6);
        assert!(minima.is_empty());
        assert_eq!(rejected.len(), 5);
        assert_eq!(rejected[3].row, 3);
        assert_eq!(rejected[3].stop, StopReason::Budget);
    }
}
