//! Tubes along a path through stations with superelliptic cross-sections, and fillets between a tube and a wall.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::parts::Parts;

/// Cross-section of a tube: |u/a|ⁿ + |v/b|ⁿ = 1 about a centre; u, v and the direction of growth are right-handed.
#[derive(Clone, Copy)]
pub(super) struct Station {
    pub(super) centre: Vector3<f64>,
    /// Unit vectors u and v.
    pub(super) axes: [Vector3<f64>; 2],
    /// Half-widths a and b.
    pub(super) half: [f64; 2],
    pub(super) exponent: f64,
}

impl Station {
    pub(super) fn point(&self, angle: f64) -> Vector3<f64> {
        let (sin, cos) = libm::sincos(angle);
        let n = self.exponent;
        let reach = libm::pow(libm::pow(cos.abs(), n) + libm::pow(sin.abs(), n), -1.0 / n);
        self.centre
            + self.axes[0] * (self.half[0] * reach * cos)
            + self.axes[1] * (self.half[1] * reach * sin)
    }
}

/// Number of rings of a fillet between a wall and a tube.
const FILLET_RINGS: u32 = 4;

/// The angle of each point of a hole's border in the cross-section of a tube that covers the hole, for a hole `sectors`
/// wide and `rings` high (see [`Parts::open`]).
pub(super) fn border_angles(sectors: usize, rings: usize) -> Vec<f64> {
    let (w, h) = (sectors, rings);
    (0..2 * (w + h))
        .map(|index| {
            let (across, up) = match index {
                i if i < w => (i, 0),
                i if i < w + h => (w, i - w),
                i if i < 2 * w + h => (2 * w + h - i, h),
                i => (0, 2 * (w + h) - i),
            };
            let centred = |step: usize, of: usize| 2.0 * step as f64 / of as f64 - 1.0;
            libm::atan2(centred(up, h), centred(across, w))
        })
        .collect()
}

impl Parts {
    /// Adds the ring of points of `station` at `angles`.
    pub(super) fn section(&mut self, station: &Station, angles: &[f64]) -> Vec<u32> {
        self.ring(angles.iter().map(|&angle| station.point(angle)))
    }

    /// Adds rings of a fillet from the border of a hole to a tube: along the wall at first, then along `outward`. The last
    /// one is the section of `station`.
    pub(super) fn fillet(
        &mut self,
        border: &[u32],
        outward: &Vector3<f64>,
        station: &Station,
        angles: &[f64],
    ) -> Vec<Vec<u32>> {
        let roots: Vec<Vector3<f64>> = border.iter().map(|&vertex| self.at(vertex)).collect();
        (1..=FILLET_RINGS)
            .map(|step| {
                let turn = FRAC_PI_2 * f64::from(step) / f64::from(FILLET_RINGS);
                let points = roots.iter().zip(angles).map(|(root, &angle)| {
                    let way = station.point(angle) - root;
                    let out = outward * outward.dot(&way);
                    root + (way - out) * libm::sin(turn) + out * (1.0 - libm::cos(turn))
                });
                self.ring(points)
            })
            .collect()
    }

    /// Stitches each ring to the next.
    pub(super) fn stitch_all(&mut self, rings: &[Vec<u32>]) {
        for pair in rings.windows(2) {
            self.stitch(&pair[0], &pair[1]);
        }
    }
}
