//! Curvatures of the minima and passes of a mapped landscape.

use petgraph::visit::EdgeRef;
use rayon::prelude::*;

use super::{Database, Vibrations};
use crate::energy::Energy;
use crate::topography::eigen::Scaled;
use crate::topography::landscape::Landscape;
use crate::topography::network::Evidence;

/// Eigenvalues of the Hessian of a smooth energy at `x`, ascending, without the free motions of its space. `difference` is the
/// step of finite differences, a length of the space. `None` where the energy or its gradient is not finite within this step.
///
/// # Panics
/// If `x` has the wrong length.
pub fn curvatures(energy: &dyn Energy, x: &[f64], difference: f64) -> Option<Vec<f64>> {
    let modes = Scaled::plain(energy).modes(x, difference)?;
    Some(modes.curvatures)
}

impl Database {
    /// The minima and finite connections of a landscape, with the curvatures of minima and verified saddles.
    ///
    /// `difference` is the step of finite differences, a length of the space. A curvature of smaller size than the accuracy
    /// of its Hessian counts as that accuracy. As many curvatures as vanish everywhere (a symmetry of the object, for example)
    /// are left out everywhere. Passes that are no verified saddles have no vibrational data.
    pub fn from_landscape(energy: &dyn Energy, landscape: &Landscape, difference: f64) -> Self {
        let mut database = Self::from_network(&landscape.network);
        let curvatures = |x: &[f64]| {
            let modes = Scaled::plain(energy).modes(x, difference)?;
            let flat = modes.flat();
            Some((modes.curvatures, flat))
        };
        let minima: Vec<_> = (landscape.network.raw_nodes().par_iter())
            .map(|node| curvatures(&node.weight.coordinates))
            .collect();
        let edges: Vec<_> = (landscape.network.edge_references())
            .filter(|edge| edge.weight().height.is_finite())
            .collect();
        let saddles: Vec<_> = edges
            .par_iter()
            .map(|edge| {
                if edge.weight().evidence != Evidence::Saddle {
                    return None;
                }
                let path = &landscape.connections.get(edge.id().index())?.path;
                let heights = path.energies.iter().enumerate();
                let (top, _) = heights.max_by(|a, b| a.1.total_cmp(b.1))?;
                curvatures(&path.images[top])
            })
            .collect();
        let zero = minima.iter().flatten().map(|(curvatures, flat)| {
            let small = curvatures
                .iter()
                .filter(|curvature| curvature.abs() <= *flat);
            small.count()
        });
        let zero = zero.min().unwrap_or(0);
        let vibrations = |known: &(Vec<f64>, f64), index: usize| {
            let (curvatures, flat) = known;
            let mut sizes: Vec<f64> = curvatures[index.min(curvatures.len())..].to_vec();
            sizes.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
            let counted = sizes.iter().skip(zero);
            Vibrations {
                // The sum of no numbers is −0, which files would show.
                log_product: 0.0
                    + counted
                        .map(|curvature| libm::log(curvature.max(*flat)))
                        .sum::<f64>(),
                negative_curvature: (index > 0).then(|| curvatures.first().copied()).flatten(),
                ..Vibrations::default()
            }
        };
        for (entry, known) in database.minima.iter_mut().zip(&minima) {
            entry.vibrations = known.as_ref().map(|known| vibrations(known, 0));
        }
        for (entry, known) in database.transition_states.iter_mut().zip(&saddles) {
            entry.vibrations = known.as_ref().map(|known| vibrations(known, 1));
        }
        database.vibrational_modes = (minima.iter().flatten())
            .map(|(curvatures, _)| curvatures.len() - zero)
            .next();
        database
    }
}
