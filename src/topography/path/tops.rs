//! The rough tops of the straight way between two points, from which climbs to saddles begin.

use super::images::Images;
use super::settings::PathSettings;
use crate::energy::Energy;

/// A local maximum of a roughly relaxed path.
pub(in crate::topography) struct Top {
    pub(in crate::topography) x: Vec<f64>,
    pub(in crate::topography) energy: f64,
    /// Plain unit tangent of the path.
    pub(in crate::topography) tangent: Vec<f64>,
}

/// Relaxes the geodesic from `from` along `tangent` roughly and returns its local maxima, highest first.
pub(in crate::topography) fn tops(
    energy: &dyn Energy,
    from: &[f64],
    tangent: &[f64],
    settings: &PathSettings,
) -> Vec<Top> {
    let mut to = from.to_vec();
    energy.space().exp(&mut to, tangent);
    let points = [from.to_vec(), to];
    let mut images = Images::new(energy, &points, settings.segments, settings.max_step);
    images.relax(settings.coarse_iterations, settings.force_tolerance);
    let energies = &images.path.energies;
    let tops = (1..settings.segments).filter(|i| {
        energies[*i].is_finite()
            && energies[*i] > energies[i - 1]
            && energies[*i] >= energies[i + 1]
    });
    let mut tops: Vec<Top> = tops
        .map(|i| Top {
            x: images.path.images[i].clone(),
            energy: energies[i],
            tangent: images.tangent(i),
        })
        .collect();
    tops.sort_by(|a, b| b.energy.total_cmp(&a.energy));
    tops
}
