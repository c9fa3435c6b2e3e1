//! Atoms in a fixed frame, modulo numbering of equal atoms.

use super::assignment::Assignment;
use super::vector::norm;
use super::{Periodic, Space};

/// Positions of atoms among others that stay, such as adatoms on a surface or guests in a crystal. Atoms of one kind have no
/// numbers, and coordinates may wrap. Unlike those of a [`Cluster`](super::Cluster), moved and turned copies differ.
///
/// A point is `[x₁, y₁, z₁, x₂, …]` (3n numbers), and
///
/// ```text
/// d(a, b)² = min over permutations P of Σᵢ ‖b_P(i) − aᵢ‖²,   to the nearest periodic image of each coordinate
/// ```
///
/// The least is found exactly, by linear assignment.
///
/// ```
/// use landscape::space::{FixedFrame, Periodic, Space};
///
/// let cell = Periodic::new(&[0.0; 6], &[4.0; 6]);
/// let space = FixedFrame::new(cell, &[0, 0]);
/// // The atoms have changed places, and one of them has gone through the wall.
/// let a = [0.1, 1.0, 1.0, 2.0, 2.0, 2.0];
/// let b = [2.0, 2.0, 2.0, 3.9, 1.0, 1.0];
/// assert!((space.distance(&a, &b) - 0.2).abs() < 1e-12);
/// ```
#[derive(Debug, Clone)]
pub struct FixedFrame {
    cell: Periodic,
    kinds: Vec<usize>,
}

impl FixedFrame {
    /// Atoms of these kinds, one for every three coordinates of the cell.
    ///
    /// # Panics
    /// If there are not three coordinates for each atom, or atoms of one kind have different periods.
    pub fn new(cell: Periodic, kinds: &[usize]) -> Self {
        assert_eq!(
            cell.coordinates(),
            3 * kinds.len(),
            "an atom has three coordinates"
        );
        for (atom, kind) in kinds.iter().enumerate() {
            let first = kinds.iter().position(|each| each == kind).unwrap_or(atom);
            assert!(
                (0..3).all(|k| {
                    let [one, other] = [atom, first].map(|atom| cell.period(3 * atom + k));
                    one.total_cmp(&other).is_eq() || (one - other).abs() <= 1e-9 * one
                }),
                "atoms of one kind wrap alike"
            );
        }
        Self {
            cell,
            kinds: kinds.to_vec(),
        }
    }

    /// The way of atom `from` of `a` to atom `to` of `b`.
    fn way(&self, a: &[f64], b: &[f64], from: usize, to: usize) -> [f64; 3] {
        let side = |k: usize| (self.cell).wrapped(b[3 * to + k] - a[3 * from + k], 3 * from + k);
        [side(0), side(1), side(2)]
    }
}

impl Space for FixedFrame {
    fn coordinates(&self) -> usize {
        self.cell.coordinates()
    }

    fn tangents(&self) -> usize {
        self.cell.tangents()
    }

    fn exp(&self, x: &mut [f64], tangent: &[f64]) {
        self.cell.exp(x, tangent);
    }

    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        let n = self.kinds.len();
        let straight = self.cell.log(a, b, tangent);
        if !straight.is_finite() {
            return straight;
        }
        let squared = |from: usize, to: usize| {
            let way = self.way(a, b, from, to);
            way.iter().map(|k| k * k).sum::<f64>()
        };
        let mut cost: Vec<f64> = (0..n * n).map(|k| squared(k / n, k % n)).collect();
        // More than all atoms together can cost.
        let forbidden = 1.0 + cost.iter().sum::<f64>();
        for (k, cost) in cost.iter_mut().enumerate() {
            if self.kinds[k / n] != self.kinds[k % n] {
                *cost = forbidden;
            }
        }
        let mut partners = Assignment::new(n);
        partners.solve(&cost);
        for (from, to) in partners.column.iter().enumerate() {
            tangent[3 * from..3 * from + 3].copy_from_slice(&self.way(a, b, from, *to));
        }
        norm(tangent)
    }

    /// The logarithm that keeps the numbers of the atoms.
    fn log_near(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        self.cell.log(a, b, tangent)
    }

    /// Those of the cell, each sorted over the atoms of one kind: sorting brings no two lists farther apart.
    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        let atoms = self.kinds.len();
        let of = |atom: usize| self.cell.landmarks_of(x, 3 * atom..3 * atom + 3);
        let rows: Vec<Vec<f64>> = (0..atoms).map(of).collect();
        let mut kinds = self.kinds.clone();
        kinds.sort_unstable();
        kinds.dedup();
        let mut landmarks = Vec::new();
        for kind in kinds {
            let members = (rows.iter().zip(&self.kinds)).filter(|(_, each)| **each == kind);
            let members: Vec<&Vec<f64>> = members.map(|(row, _)| row).collect();
            let count = members.first().map_or(0, |row| row.len());
            landmarks.extend((0..count).flat_map(|k| {
                let mut values: Vec<f64> = members.iter().map(|row| row[k]).collect();
                values.sort_by(f64::total_cmp);
                values
            }));
        }
        landmarks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Rng, Task, stream};
    use rand::RngExt;

    const LOW: [f64; 12] = [0.0; 12];
    const PERIODS: [f64; 3] = [3.0, 2.0, f64::INFINITY];

    fn space() -> FixedFrame {
        FixedFrame::new(Periodic::new(&LOW, &PERIODS.repeat(4)), &[0, 1, 0, 0])
    }

    fn point(rng: &mut Rng) -> Vec<f64> {
        (0..12).map(|_| rng.random_range(0.0..2.0)).collect()
    }

    fn renumbered(x: &[f64], order: [usize; 4]) -> Vec<f64> {
        let atom = |k: usize| x[3 * k..3 * k + 3].iter().copied();
        order.into_iter().flat_map(atom).collect()
    }

    /// All ways to renumber atoms 0, 2 and 3.
    const ORDERS: [[usize; 4]; 6] = [
        [0, 1, 2, 3],
        [0, 1, 3, 2],
        [2, 1, 0, 3],
        [2, 1, 3, 0],
        [3, 1, 0, 2],
        [3, 1, 2, 0],
    ];

    #[test]
    fn the_distance_is_the_least_over_all_numberings() {
        let (space, mut rng) = (space(), stream(3, Task::Start, 0));
        for _ in 0..50 {
            let (a, b) = (point(&mut rng), point(&mut rng));
            let copies = ORDERS.map(|order| renumbered(&b, order));
            let distances = copies.clone().map(|copy| space.cell.distance(&a, &copy));
            let least = distances.into_iter().fold(f64::INFINITY, f64::min);
            let mut tangent = [0.0; 12];
            assert!((space.log(&a, &b, &mut tangent) - least).abs() < 1e-12);
            let mut reached = a.clone();
            space.exp(&mut reached, &tangent);
            assert!(space.distance(&reached, &b) < 1e-12);
            for copy in &copies {
                assert!((space.distance(&a, copy) - least).abs() < 1e-12);
                assert!(space.distance(&b, copy) < 1e-12);
            }
            // Atoms of different kinds keep their places.
            assert!(space.distance(&b, &renumbered(&b, [1, 0, 2, 3])) > 1e-3);
        }
    }

    #[test]
    fn landmarks_bound_distances_and_are_those_of_every_copy() {
        let (space, mut rng) = (space(), stream(4, Task::Start, 0));
        let apart = |a: &[f64], b: &[f64]| {
            let sides = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
            sides.sum::<f64>().sqrt()
        };
        for _ in 0..200 {
            let (a, b) = (point(&mut rng), point(&mut rng));
            let (of_a, of_b) = (space.landmarks(&a), space.landmarks(&b));
            assert!(apart(&of_a, &of_b) <= space.distance(&a, &b) + 1e-12);
            let mut copy = renumbered(&b, [3, 1, 0, 2]);
            copy[0] += PERIODS[0];
            assert!(apart(&of_b, &space.landmarks(&copy)) < 1e-12);
        }
    }
}
