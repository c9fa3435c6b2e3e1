//! Settings of a map.

use serde::{Deserialize, Serialize};

use crate::energy::Energy;
use crate::optimize::QuenchSettings;
use crate::space::interpolate;
use crate::topography::adelm::ChainSettings;
use crate::topography::families::FamilySettings;
use crate::topography::minima::MatchTolerance;
use crate::topography::network::Minimum;
use crate::topography::pairs::{BetweenMinima, nearest};
use crate::topography::path::PathSettings;
use crate::topography::scales::{Scales, median};

/// Settings of [`build_landscape`](super::build_landscape). [`MapSettings::for_scales`] sets all that have units from one energy and one length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MapSettings {
    /// Number of nearest minima to connect each minimum with. The minimum spanning tree of the distances is always added.
    pub neighbours: usize,
    /// Least number of pairs connected between two updates of the skipping rule; later batches have a sixteenth of the
    /// pairs before them. It affects the result, so it must not depend on threads.
    pub batch: usize,
    /// Whether to skip pairs that known passes already join at the energy of the higher minimum, the lowest possible.
    pub pruned: bool,
    /// Greatest number of independent searches across each merge of the tree, half of them in each direction; 0 for none. A
    /// merge is searched no more once a lower way across it is unlikely ([`chance_of_lower`](crate::topography::chance_of_lower)),
    /// but for four further searches that begin with a free walk.
    pub searches: usize,
    /// Settings of the chains.
    pub chain: ChainSettings,
    /// Settings of the paths.
    pub path: PathSettings,
    /// Settings of the descents.
    pub quench: QuenchSettings,
    /// Tolerance within which two stationary points are the same.
    pub sameness: MatchTolerance,
    /// Settings of the families.
    pub families: FamilySettings,
    /// Height at which all minima are joined by definition, such as the cost of letting go. Higher connections get this
    /// height, and minima that no path joins are joined at it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ceiling: Option<f64>,
    /// Seed of all chains.
    pub seed: u64,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl MapSettings {
    /// Settings for a surface whose typical barrier is `energy` high and `length` wide.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self {
            neighbours: 8,
            batch: 64,
            pruned: true,
            searches: 10,
            chain: ChainSettings::for_scales(energy, length),
            path: PathSettings::for_scales(energy, length),
            quench: QuenchSettings::for_scales(energy, length),
            sameness: MatchTolerance::for_scales(energy, length),
            families: FamilySettings::default(),
            ceiling: None,
            seed: 0,
        }
    }

    /// Settings measured on the minima. The length is the median distance to the nearest other minimum, and the energy is
    /// the median of the finite barriers along the straight lines to it. If there is no other minimum or no such barrier,
    /// the [`Scales`] of the surface around the minima are used.
    ///
    /// One or two minima are too few to measure, and surfaces with walls (contact) need scales chosen by hand.
    pub fn for_minima(energy: &dyn Energy, minima: &[Minimum]) -> Self {
        let space = energy.space();
        let all = BetweenMinima::new(space, minima);
        let (mut lengths, mut heights) = (Vec::new(), Vec::new());
        let mut gradient = vec![0.0; space.tangents()];
        for i in 0..minima.len() {
            // Distances to copies (0) and to invalid points (not finite) are ignored.
            let apart =
                |_, distance: Option<f64>| distance.is_none_or(|d| d > 0.0 && d.is_finite());
            let Some((distance, j)) = nearest(&all, i, 1, apart).pop() else {
                continue;
            };
            lengths.push(distance);
            let (from, to) = (&minima[i], &minima[j]);
            let top = (1..16)
                .map(|k| {
                    let share = f64::from(k) / 16.0;
                    let x = interpolate(space, &from.coordinates, &to.coordinates, share);
                    energy.evaluate(&x, &mut gradient)
                })
                .fold(f64::NEG_INFINITY, f64::max);
            let height = top - from.energy.max(to.energy);
            if height.is_finite() && height > 0.0 {
                heights.push(height);
            }
        }
        let around = || {
            let points: Vec<_> = minima.iter().map(|m| m.coordinates.clone()).collect();
            Scales::measured(energy, &points)
        };
        Self::for_scales(
            median(heights).unwrap_or_else(|| around().energy),
            median(lengths).unwrap_or_else(|| around().length),
        )
    }
}
