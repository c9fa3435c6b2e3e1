//! Symmetric matrices of six rows and their factors.

/// A symmetric matrix, of which only the lower triangle counts.
pub(super) type Lower = [[f64; 6]; 6];

/// A multiple of the identity.
pub(super) fn multiple(value: f64) -> Lower {
    let mut matrix = [[0.0; 6]; 6];
    for (k, row) in matrix.iter_mut().enumerate() {
        row[k] = value;
    }
    matrix
}

/// The factors of a positive definite matrix L D Lᵀ. Six rows are too few for a library to be as fast.
pub(super) struct Factors {
    lower: Lower,
    inverse: [f64; 6],
}

impl Factors {
    /// `None` if the matrix is not positive definite.
    #[inline]
    pub(super) fn of(matrix: &Lower) -> Option<Self> {
        let mut lower = [[0.0; 6]; 6];
        let mut inverse = [0.0; 6];
        for i in 0..6 {
            // Row i of L D.
            let mut scaled = [0.0; 6];
            let mut pivot = matrix[i][i];
            for j in 0..i {
                let mut sum = matrix[i][j];
                for k in 0..j {
                    sum -= scaled[k] * lower[j][k];
                }
                scaled[j] = sum;
                lower[i][j] = sum * inverse[j];
                pivot -= sum * lower[i][j];
            }
            if pivot.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
                return None;
            }
            inverse[i] = 1.0 / pivot;
        }
        Some(Self { lower, inverse })
    }

    #[inline]
    pub(super) fn solve(&self, right: &[f64; 6]) -> [f64; 6] {
        let mut x = *right;
        for i in 1..6 {
            for k in 0..i {
                x[i] -= self.lower[i][k] * x[k];
            }
        }
        for i in (0..6).rev() {
            x[i] *= self.inverse[i];
            for k in i + 1..6 {
                x[i] -= self.lower[k][i] * x[k];
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_solve_and_indefinite_matrices_have_no_factors() {
        let entry = |i: usize, j: usize| match i.cmp(&j) {
            std::cmp::Ordering::Greater => 0.1 * (i as f64 - 0.7 * j as f64),
            std::cmp::Ordering::Equal => 2.0,
            std::cmp::Ordering::Less => 0.0,
        };
        let mut matrix: Lower = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        let right = [1.0, -2.0, 0.5, 3.0, 0.0, -1.0];
        let x = Factors::of(&matrix).unwrap().solve(&right);
        for (i, right) in right.into_iter().enumerate() {
            let row = (0..6).map(|j| entry(i.max(j), i.min(j)) * x[j]);
            assert!((row.sum::<f64>() - right).abs() < 1e-12);
        }
        matrix[3][3] = -1.0;
        assert!(Factors::of(&matrix).is_none());
    }
}
