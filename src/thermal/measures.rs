//! Measures of a whole landscape that are quoted in the literature.

use super::superposition::Superposition;
use crate::topography::{MinimumId, Tree};

/// Frustration of a landscape at a temperature:
///
/// ```text
/// f(T) = Σ_{i ≠ g} pᵢ/(1 − p_g) · (V‡ᵢ − V_g)/(Vᵢ − V_g)
/// ```
///
/// g: the lowest minimum; V‡ᵢ: the highest energy on the lowest path from i to g; p: equilibrium occupation. It is near 1
/// where no barrier keeps the system from the lowest minimum, and large for glassy landscapes. V. K. de Souza, J. D.
/// Stevenson, S. P. Niblett, J. D. Farrell and D. J. Wales, J. Chem. Phys. 146, 124103 (2017). Minima that are not connected
/// to the lowest one, or have its energy, are left out. `None` if no minimum is left.
///
/// # Panics
/// If `wells` and `tree` are not of the same minima, numbered alike.
pub fn frustration(wells: &Superposition, tree: &Tree, temperature: f64) -> Option<f64> {
    let weights = wells.log_partition_functions(temperature);
    let leaves = weights.len();
    let energies: Vec<f64> = tree.nodes[..leaves]
        .iter()
        .map(|node| node.energy)
        .collect();
    let lowest = (0..leaves).min_by(|a, b| energies[*a].total_cmp(&energies[*b]))?;
    let ratios: Vec<(f64, f64)> = (0..leaves)
        .filter_map(|i| {
            let height = tree.minimax(MinimumId(i), MinimumId(lowest))?;
            let above = energies[i] - energies[lowest];
            (above > 0.0).then(|| (weights[i], (height - energies[lowest]) / above))
        })
        .collect();
    let top = ratios.iter().map(|(weight, _)| *weight);
    let top = top.fold(f64::NEG_INFINITY, f64::max);
    let share = |weight: f64| (weight - top).exp();
    let sum: f64 = ratios.iter().map(|(weight, _)| share(*weight)).sum();
    let weighted = ratios.iter().map(|(weight, ratio)| share(*weight) * ratio);
    (sum > 0.0).then(|| weighted.sum::<f64>() / sum)
}

/// Number of superbasins at an energy: sets of minima, below it, that are connected below it.
pub fn superbasins_at(tree: &Tree, energy: f64) -> usize {
    let below = |node: usize| tree.nodes[node].energy <= energy;
    let top = |node: usize| {
        tree.nodes[node]
            .parent
            .is_none_or(|parent| !below(parent.0))
    };
    (0..tree.nodes.len())
        .filter(|node| below(*node) && top(*node))
        .count()
}
