//! A box whose faces are mirrors.

use std::f64::consts::PI;

use super::Space;

/// A box in ℝⁿ, unrolled: a path that passes through a face returns into the box, mirrored.
///
/// ```text
/// x_i = m_i − h_i cos(u_i / h_i),   m = (low + high) / 2,   h = (high − low) / 2
/// ```
///
/// Coordinates are u, any real numbers. u and −u are copies of one point, and so are u and u + 2π h. In the middle of the
/// box a step in u is a step in x; at a face x is stationary in u. So a smooth function on the box becomes a smooth
/// function without constraints, and its minima are exactly the constrained minima, including those on faces, edges and
/// corners.
#[derive(Debug, Clone, PartialEq)]
pub struct Mirrored {
    middles: Vec<f64>,
    halves: Vec<f64>,
}

impl Mirrored {
    /// The box from `low` to `high`.
    ///
    /// # Panics
    /// If their lengths differ, or a side is not positive and finite.
    pub fn new(low: &[f64], high: &[f64]) -> Self {
        assert_eq!(
            low.len(),
            high.len(),
            "a box has as many low ends as high ends"
        );
        let halves: Vec<f64> = low.iter().zip(high).map(|(a, b)| 0.5 * (b - a)).collect();
        let proper = |half: &f64| *half > 0.0 && half.is_finite();
        assert!(halves.iter().all(proper), "the sides of a box are positive");
        Self {
            middles: low
                .iter()
                .zip(high)
                .map(|(a, b)| f64::midpoint(*a, *b))
                .collect(),
            halves,
        }
    }

    /// The point x of the box.
    ///
    /// # Panics
    /// If `u` has the wrong length.
    pub fn point(&self, u: &[f64]) -> Vec<f64> {
        assert_eq!(u.len(), self.halves.len());
        let sides = self.middles.iter().zip(&self.halves).zip(u);
        sides
            .map(|((middle, half), u)| middle - half * libm::cos(u / half))
            .collect()
    }

    /// Coordinates u of the point x, in the copy of [`Mirrored::copy`]. A point outside the box is first moved to its nearest
    /// face.
    ///
    /// # Panics
    /// If `x` has the wrong length.
    pub fn unrolled(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.halves.len());
        let sides = self.middles.iter().zip(&self.halves).zip(x);
        sides
            .map(|((middle, half), x)| half * libm::acos(((middle - x) / half).clamp(-1.0, 1.0)))
            .collect()
    }

    /// Derivatives of x with respect to u.
    ///
    /// # Panics
    /// If `u` has the wrong length.
    pub fn slopes(&self, u: &[f64]) -> Vec<f64> {
        assert_eq!(u.len(), self.halves.len());
        let sides = self.halves.iter().zip(u);
        sides.map(|(half, u)| libm::sin(u / half)).collect()
    }

    /// The least and the greatest u of one copy of the box.
    pub fn copy(&self) -> (Vec<f64>, Vec<f64>) {
        let high = self.halves.iter().map(|half| PI * half);
        (vec![0.0; self.halves.len()], high.collect())
    }
}

/// The equivalent coordinate in [−π h, π h]; odd.
fn wrap(u: f64, half: f64) -> f64 {
    let period = 2.0 * PI * half;
    u - period * (u / period).round()
}

impl Space for Mirrored {
    fn coordinates(&self) -> usize {
        self.halves.len()
    }

    fn tangents(&self) -> usize {
        self.halves.len()
    }

    fn exp(&self, x: &mut [f64], tangent: &[f64]) {
        let sides = self.halves.len();
        assert_eq!((x.len(), tangent.len()), (sides, sides));
        for ((u, step), half) in x.iter_mut().zip(tangent).zip(&self.halves) {
            *u = wrap(*u + step, *half);
        }
    }

    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        let sides = self.halves.len();
        assert_eq!((a.len(), b.len(), tangent.len()), (sides, sides, sides));
        for (k, half) in self.halves.iter().enumerate() {
            let [same, mirrored] = [b[k], -b[k]].map(|b| wrap(b - a[k], *half));
            tangent[k] = if mirrored.abs() < same.abs() {
                mirrored
            } else {
                same
            };
        }
        tangent.iter().map(|step| step * step).sum::<f64>().sqrt()
    }

    /// The point of the box.
    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        self.point(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_unrolled() {
        let space = Mirrored::new(&[-1.0, 2.0], &[3.0, 3.0]);
        for x in [[0.3, 2.9], [-1.0, 3.0], [1.0, 2.0]] {
            let u = space.unrolled(&x);
            approx::assert_abs_diff_eq!(space.point(&u).as_slice(), x.as_slice(), epsilon = 1e-14);
            let (low, high) = space.copy();
            assert!((0..2).all(|k| (low[k]..=high[k]).contains(&u[k])));
        }
        approx::assert_abs_diff_eq!(
            space.point(&space.unrolled(&[-7.0, 2.5])).as_slice(),
            [-1.0, 2.5].as_slice(),
            epsilon = 1e-14
        );
    }

    #[test]
    fn copies_are_one_point() {
        let space = Mirrored::new(&[-1.0, 2.0], &[3.0, 3.0]);
        let (a, b) = ([0.3, 0.2], [-0.3, 0.2 + PI]);
        approx::assert_abs_diff_eq!(
            space.point(&a).as_slice(),
            space.point(&b).as_slice(),
            epsilon = 1e-14
        );
        assert!(space.distance(&a, &b) < 1e-14);
        // Across the mirror at 0 to the copy of 0.7, on the near side.
        let mut tangent = [0.0; 2];
        space.log(&[0.3, 0.2], &[-0.7, 0.2], &mut tangent);
        approx::assert_abs_diff_eq!(tangent.as_slice(), [0.4, 0.0].as_slice(), epsilon = 1e-14);
        let (low, high) = space.copy();
        assert_eq!(space.point(&low), [-1.0, 2.0]);
        approx::assert_abs_diff_eq!(space.point(&high).as_slice(), [3.0, 3.0].as_slice());
    }
}
