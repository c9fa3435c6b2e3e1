//! The flat torus: angles that wrap.

use std::f64::consts::TAU;

use super::Space;
use super::vector::norm;

/// n independent angles in radians; distances are measured the shorter way around each circle.
///
/// `exp` keeps each angle in [−π, π]. Two angles exactly half a turn apart are joined downwards from the lower to the
/// higher number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Torus {
    angles: usize,
}

impl Torus {
    /// The torus of `angles` angles.
    pub const fn new(angles: usize) -> Self {
        Self { angles }
    }
}

impl Space for Torus {
    fn coordinates(&self) -> usize {
        self.angles
    }

    fn tangents(&self) -> usize {
        self.angles
    }

    fn exp(&self, x: &mut [f64], tangent: &[f64]) {
        assert_eq!((x.len(), tangent.len()), (self.angles, self.angles));
        for (angle, step) in x.iter_mut().zip(tangent) {
            *angle = wrap(*angle + step);
        }
    }

    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        assert_eq!(
            (a.len(), b.len(), tangent.len()),
            (self.angles, self.angles, self.angles)
        );
        for ((step, from), to) in tangent.iter_mut().zip(a).zip(b) {
            *step = wrap(to - from);
        }
        norm(tangent)
    }

    /// The points on the circles.
    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.angles);
        x.iter()
            .flat_map(|angle| [libm::cos(*angle), libm::sin(*angle)])
            .collect()
    }

    fn log_other_way(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> Option<f64> {
        self.log(a, b, tangent);
        let widest = tangent
            .iter_mut()
            .max_by(|one, other| one.abs().total_cmp(&other.abs()))?;
        if *widest == 0.0 {
            return None;
        }
        *widest -= TAU.copysign(*widest);
        Some(norm(tangent))
    }
}

/// The equivalent angle in [−π, π]; odd, so that the differences a − b and b − a are opposite.
pub(crate) fn wrap(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_short_way_crosses_the_seam() {
        let space = Torus::new(2);
        let mut tangent = [0.0; 2];
        let length = space.log(&[3.0, 0.1], &[-3.0, 0.2], &mut tangent);
        approx::assert_abs_diff_eq!(
            tangent.as_slice(),
            [TAU - 6.0, 0.1].as_slice(),
            epsilon = 1e-15
        );
        approx::assert_abs_diff_eq!(length, libm::hypot(TAU - 6.0, 0.1), epsilon = 1e-15);
        let mut x = [3.0, 0.1];
        space.exp(&mut x, &tangent);
        approx::assert_abs_diff_eq!(x.as_slice(), [-3.0, 0.2].as_slice(), epsilon = 1e-15);
    }

    #[test]
    fn the_other_way_passes_the_other_side() {
        let space = Torus::new(2);
        let mut tangent = [0.0; 2];
        let length = space.log_other_way(&[0.0, 0.1], &[3.0, 0.2], &mut tangent);
        approx::assert_abs_diff_eq!(
            tangent.as_slice(),
            [3.0 - TAU, 0.1].as_slice(),
            epsilon = 1e-15
        );
        approx::assert_abs_diff_eq!(
            length.unwrap(),
            libm::hypot(3.0 - TAU, 0.1),
            epsilon = 1e-15
        );
        assert!(
            space
                .log_other_way(&[1.0, 2.0], &[1.0, 2.0], &mut tangent)
                .is_none()
        );
    }
}
