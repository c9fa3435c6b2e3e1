//! Numbers or angles, modulo permutations and changes of sign that leave an energy as it is.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use super::{Euclidean, Space, Torus};

/// Permutations and changes of sign of coordinates: a group, made from generators.
///
/// A symmetry is written as one signed number for each coordinate, counted from 1: coordinate i of the copy is that of the
/// point with the number at place i, negated if the number is negative. `2 1 -3` exchanges the first two coordinates and
/// negates the third.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symmetries {
    /// The place and sign of each coordinate, for each member of the group; the identity comes first.
    members: Vec<Vec<(usize, bool)>>,
}

/// Numbers that are no symmetries.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SymmetryError {
    /// A symmetry has too many numbers or too few.
    #[error("symmetry {number} has {found} numbers, and {wanted} coordinates need as many")]
    Length {
        /// The symmetry, counted from 1.
        number: usize,
        /// How many numbers it has.
        found: usize,
        /// How many coordinates there are.
        wanted: usize,
    },
    /// A coordinate is missing, so that another is named twice or does not exist.
    #[error("symmetry {number} does not name coordinate {coordinate}; each must stand there once")]
    Coordinate {
        /// The symmetry, counted from 1.
        number: usize,
        /// The coordinate, counted from 1.
        coordinate: usize,
    },
    /// The group is too large.
    #[error(
        "together the symmetries make more than {} copies of a point, too many to measure distances",
        Symmetries::MOST
    )]
    Many,
}

impl Symmetries {
    /// Greatest number of copies of a point. Each distance measures all of them.
    pub const MOST: usize = 50_000;

    /// All that the `generators` make together.
    ///
    /// # Errors
    /// If a generator is no permutation with signs of the coordinates, or if there are more than [`Symmetries::MOST`] copies.
    pub fn new(coordinates: usize, generators: &[Vec<i64>]) -> Result<Self, SymmetryError> {
        let mut read = Vec::with_capacity(generators.len());
        for (row, numbers) in generators.iter().enumerate() {
            let (number, found, wanted) = (row + 1, numbers.len(), coordinates);
            if found != wanted {
                return Err(SymmetryError::Length {
                    number,
                    found,
                    wanted,
                });
            }
            let place = |n: i64| usize::try_from(n.unsigned_abs()).unwrap_or(usize::MAX);
            if let Some(coordinate) = (1..=wanted).find(|k| numbers.iter().all(|n| place(*n) != *k))
            {
                return Err(SymmetryError::Coordinate { number, coordinate });
            }
            let places = numbers.iter().map(|n| (place(*n) - 1, *n < 0));
            read.push(places.collect::<Vec<_>>());
        }
        let identity: Vec<(usize, bool)> = (0..coordinates).map(|k| (k, false)).collect();
        let mut known = BTreeSet::from([identity.clone()]);
        let mut members = vec![identity];
        let mut next = 0;
        while let Some(member) = members.get(next).cloned() {
            next += 1;
            for generator in &read {
                let product = generator.iter().map(|(place, negated)| {
                    let (first, sign) = member[*place];
                    (first, sign != *negated)
                });
                let product: Vec<_> = product.collect();
                if known.insert(product.clone()) {
                    members.push(product);
                }
            }
            if members.len() > Self::MOST {
                return Err(SymmetryError::Many);
            }
        }
        Ok(Self { members })
    }

    /// Number of copies of a point in general position, itself included.
    pub fn count(&self) -> usize {
        self.members.len()
    }

    /// All copies of a point; the first is the point.
    ///
    /// # Panics
    /// If the point has too few coordinates.
    pub fn copies<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = Vec<f64>> + 'a {
        let member = |member: &'a Vec<(usize, bool)>| signed(member, x).collect();
        self.members.iter().map(member)
    }
}

fn signed<'a>(member: &'a [(usize, bool)], x: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    (member.iter()).map(|(place, negated)| if *negated { -x[*place] } else { x[*place] })
}

/// Numbers or angles modulo [`Symmetries`]: the distance of two points is that of the nearest copies.
///
/// ```
/// use landscape::space::{Copies, Space, Symmetries};
///
/// // Two equal neurons of one weight each, whose outputs are odd.
/// let symmetries = Symmetries::new(2, &[vec![2, 1], vec![-1, 2]])?;
/// assert_eq!(symmetries.count(), 8);
/// let space = Copies::of_numbers(2, symmetries);
/// assert!(space.distance(&[1.0, 2.0], &[-2.0, 1.0]) < 1e-12);
/// # Ok::<(), landscape::space::SymmetryError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Copies {
    coordinates: usize,
    angles: bool,
    symmetries: Symmetries,
}

impl Copies {
    /// Numbers modulo symmetries.
    pub fn of_numbers(coordinates: usize, symmetries: Symmetries) -> Self {
        Self {
            coordinates,
            angles: false,
            symmetries,
        }
    }

    /// Angles in radians modulo symmetries.
    pub fn of_angles(coordinates: usize, symmetries: Symmetries) -> Self {
        Self {
            angles: true,
            ..Self::of_numbers(coordinates, symmetries)
        }
    }

    /// Number of symmetries that leave the point where it is, to within `reach`: the identity and others.
    ///
    /// # Panics
    /// If `x` has the wrong length.
    pub fn stabiliser(&self, x: &[f64], reach: f64) -> usize {
        let fixed = |member: &&Vec<(usize, bool)>| self.squared(x, x, member, reach * reach);
        self.symmetries
            .members
            .iter()
            .filter(|member| fixed(member).is_some())
            .count()
    }

    fn way(&self, from: f64, to: f64) -> f64 {
        let way = to - from;
        if self.angles {
            way - TAU * (way / TAU).round()
        } else {
            way
        }
    }

    /// Squared distance of `a` from a copy of `b`, unless it is more than `most`.
    fn squared(&self, a: &[f64], b: &[f64], member: &[(usize, bool)], most: f64) -> Option<f64> {
        let mut sum = 0.0;
        for (a, b) in a.iter().zip(signed(member, b)) {
            let way = self.way(*a, b);
            sum += way * way;
            if sum > most {
                return None;
            }
        }
        Some(sum)
    }
}

impl Space for Copies {
    fn coordinates(&self) -> usize {
        self.coordinates
    }

    fn tangents(&self) -> usize {
        self.coordinates
    }

    fn exp(&self, x: &mut [f64], tangent: &[f64]) {
        if self.angles {
            Torus::new(self.coordinates).exp(x, tangent);
        } else {
            Euclidean::new(self.coordinates).exp(x, tangent);
        }
    }

    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        assert_eq!((a.len(), b.len()), (self.coordinates, self.coordinates));
        let (mut nearest, mut least) = (0, f64::INFINITY);
        for (number, member) in self.symmetries.members.iter().enumerate() {
            match self.squared(a, b, member, least) {
                Some(squared) if squared < least => (nearest, least) = (number, squared),
                _ => {}
            }
        }
        let copy = signed(&self.symmetries.members[nearest], b);
        for ((step, a), b) in tangent.iter_mut().zip(a).zip(copy) {
            *step = self.way(*a, b);
        }
        super::vector::norm(tangent)
    }

    /// The logarithm that leads to the point itself.
    fn log_near(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        for ((step, a), b) in tangent.iter_mut().zip(a).zip(b) {
            *step = self.way(*a, *b);
        }
        super::vector::norm(tangent)
    }

    fn within(&self, a: &[f64], b: &[f64], reach: f64) -> bool {
        let mut members = self.symmetries.members.iter();
        members.any(|member| self.squared(a, b, member, reach * reach).is_some())
    }

    /// The sizes of the numbers, sorted: sorting brings no two lists farther apart.
    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        if self.angles {
            return Vec::new();
        }
        let mut sizes: Vec<f64> = x.iter().map(|x| x.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        sizes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Task, stream};
    use rand::RngExt;

    #[test]
    fn groups_are_made_from_generators() {
        let none = Symmetries::new(3, &[]).unwrap();
        assert_eq!(none.count(), 1);
        let turns = Symmetries::new(3, &[vec![2, 3, 1]]).unwrap();
        assert_eq!(turns.count(), 3);
        let all = Symmetries::new(3, &[vec![2, 3, 1], vec![2, 1, 3], vec![-1, 2, 3]]).unwrap();
        assert_eq!(all.count(), 48);
        let wrong = |numbers: &[i64]| Symmetries::new(3, &[numbers.to_vec()]).unwrap_err();
        assert!(wrong(&[1, 2]).to_string().contains("has 2 numbers"));
        for numbers in [[1, 2, 2], [1, 2, 4], [1, 2, 0], [1, 2, i64::MIN]] {
            assert!(wrong(&numbers).to_string().contains("coordinate 3"));
        }
        let cycle: Vec<i64> = (0..10).map(|k| 1 + (k + 1) % 10).collect();
        let mut swap: Vec<i64> = (1..=10).collect();
        swap.swap(0, 1);
        let many = Symmetries::new(10, &[cycle, swap]);
        assert_eq!(many, Err(SymmetryError::Many));
    }

    #[test]
    fn the_nearest_copy_counts() {
        let symmetries = Symmetries::new(4, &[vec![2, 1, 4, 3], vec![-1, 2, 3, 4]]).unwrap();
        for space in [
            Copies::of_numbers(4, symmetries.clone()),
            Copies::of_angles(4, symmetries.clone()),
        ] {
            let mut rng = stream(7, Task::Start, 0);
            let mut point =
                || -> Vec<f64> { (0..4).map(|_| rng.random_range(-3.0..3.0)).collect() };
            for _ in 0..40 {
                let (a, b) = (point(), point());
                let mut tangent = vec![0.0; 4];
                let distance = space.log(&a, &b, &mut tangent);
                let plain: Vec<f64> = (symmetries.copies(&b))
                    .map(|copy| space.log_near(&a, &copy, &mut [0.0; 4]))
                    .collect();
                let least = plain.iter().copied().fold(f64::INFINITY, f64::min);
                assert!((distance - least).abs() < 1e-12);
                let mut reached = a.clone();
                space.exp(&mut reached, &tangent);
                assert!(space.within(&reached, &b, 1e-9) && !space.within(&a, &b, 0.9 * least));
                let [one, other] = [&a, &b].map(|x| space.landmarks(x));
                let apart = Euclidean::new(one.len()).distance(&one, &other);
                assert!(apart <= distance + 1e-12);
            }
        }
        let space = Copies::of_numbers(4, symmetries);
        assert_eq!(space.stabiliser(&[0.0, 1.0, 2.0, 3.0], 1e-9), 2);
        assert_eq!(space.stabiliser(&[1.0, 1.0, 2.0, 2.0], 1e-9), 2);
        assert_eq!(space.stabiliser(&[0.0, 0.0, 2.0, 2.0], 1e-9), 8);
    }
}
