//! A surface in other units of length and energy.

use landscape::energy::Energy;
use landscape::energy::model::{MODELS, Surface, named};
use landscape::space::Space;

/// Factors of lengths and energies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Units {
    pub(crate) length: f64,
    pub(crate) energy: f64,
}

/// The same surface with scaled lengths and energies. Flat coordinates are lengths. Angles and rotations are not; their
/// metric is scaled instead.
pub(crate) struct Scaled<'a> {
    surface: &'a Surface,
    units: Units,
    space: Metric<'a>,
}

/// Factor of the coordinates: flat ones are lengths, angles and quaternions are not.
pub(crate) fn stretch(surface: &Surface, units: Units) -> f64 {
    match surface.coordinates {
        "flat" | "atoms" => units.length,
        _ => 1.0,
    }
}

/// A space with a scaled metric, unless its coordinates are scaled.
struct Metric<'a> {
    space: &'a dyn Space,
    length: f64,
}

impl<'a> Scaled<'a> {
    pub(crate) fn new(surface: &'a Surface, units: Units) -> Self {
        Self {
            surface,
            units,
            space: Metric {
                space: surface.energy.space(),
                length: units.length / stretch(surface, units),
            },
        }
    }

    /// The point in the original units.
    pub(crate) fn unscaled(&self, x: &[f64]) -> Vec<f64> {
        let stretch = stretch(self.surface, self.units);
        x.iter().map(|x| x / stretch).collect()
    }

    /// A point of the original surface, scaled.
    pub(crate) fn scaled(&self, x: &[f64]) -> Vec<f64> {
        let stretch = stretch(self.surface, self.units);
        x.iter().map(|x| x * stretch).collect()
    }
}

impl Energy for Scaled<'_> {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let energy = self.surface.energy.evaluate(&self.unscaled(x), gradient);
        for slope in gradient {
            *slope *= self.units.energy / self.units.length;
        }
        self.units.energy * energy
    }

    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        let known = self.surface.energy.hessian(&self.unscaled(x), hessian);
        for curvature in hessian {
            *curvature *= self.units.energy / (self.units.length * self.units.length);
        }
        known
    }
}

impl Metric<'_> {
    fn multiply(&self, tangent: &mut [f64], length: f64) -> f64 {
        for step in tangent {
            *step *= self.length;
        }
        self.length * length
    }
}

impl Space for Metric<'_> {
    fn coordinates(&self) -> usize {
        self.space.coordinates()
    }

    fn tangents(&self) -> usize {
        self.space.tangents()
    }

    fn exp(&self, x: &mut [f64], tangent: &[f64]) {
        let tangent: Vec<f64> = tangent.iter().map(|step| step / self.length).collect();
        self.space.exp(x, &tangent);
    }

    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        let length = self.space.log(a, b, tangent);
        self.multiply(tangent, length)
    }

    fn log_other_way(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> Option<f64> {
        let length = self.space.log_other_way(a, b, tangent)?;
        Some(self.multiply(tangent, length))
    }

    fn log_near(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        let length = self.space.log_near(a, b, tangent);
        self.multiply(tangent, length)
    }

    fn step_scales(&self) -> Vec<f64> {
        self.space.step_scales()
    }

    fn zero_modes(&self, x: &[f64]) -> Vec<f64> {
        self.space.zero_modes(x)
    }
}

/// One surface of each model.
pub(crate) fn surfaces() -> Vec<Surface> {
    let words = [
        "muller-brown",
        "three-hole",
        "double-well 2 0.5",
        "torsion 1 3 0.5 2",
        "orientation",
        "lj 7",
    ];
    for model in MODELS {
        let listed = words.iter().any(|words| words.starts_with(model.name));
        assert!(listed, "{} is not in the list", model.name);
    }
    let surface = |words: &&str| named(&words.split(' ').collect::<Vec<_>>()).unwrap();
    words.iter().map(surface).collect()
}

/// The corners of lengths × 10⁻³ … 10³ and energies × 10⁻⁶ … 10⁶.
pub(crate) fn decimal() -> Vec<Units> {
    corners(1e3, 1e6)
}

/// The same corners in powers of two, which do not change any rounding.
pub(crate) fn binary() -> Vec<Units> {
    corners(2f64.powi(10), 2f64.powi(20))
}

fn corners(length: f64, energy: f64) -> Vec<Units> {
    let lengths = [length.recip(), length];
    let corner = |length| [energy.recip(), energy].map(|energy| Units { length, energy });
    lengths.into_iter().flat_map(corner).collect()
}
