//! How a surface is searched, and the result.

use crate::topography::{Exploration, Landscape, LowestReport, LowestSettings, SearchSettings};

/// How a surface is searched.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceSearch<'a> {
    /// Settings of every search.
    pub settings: &'a SearchSettings,
    /// Only the lowest minima and the ways between them are sought, with these settings; `None` seeks everything.
    pub lowest: Option<&'a LowestSettings>,
    /// Points from which the search begins, besides random ones.
    pub known: &'a [Vec<f64>],
}

/// The result of [`search_surface`](super::search_surface).
#[derive(Debug, Clone)]
pub struct Searched {
    /// The minima and saddles; at least one minimum.
    pub found: Exploration,
    /// Their landscape.
    pub landscape: Landscape,
    /// How the search for the lowest minima went, if only these were sought.
    pub lowest: Option<LowestReport>,
}

impl Searched {
    /// Replaces the coordinates of all points by those that `point` returns, such as [`InBox::point`](crate::energy::InBox).
    pub fn shown_as(&mut self, point: &dyn Fn(&[f64]) -> Vec<f64>) {
        let change = |x: &mut Vec<f64>| *x = point(x);
        for minimum in &mut self.found.minima {
            change(&mut minimum.coordinates);
        }
        for saddle in &mut self.found.saddles {
            change(&mut saddle.coordinates);
            saddle.path.images.iter_mut().for_each(change);
        }
        for minimum in self.landscape.network.node_weights_mut() {
            change(&mut minimum.coordinates);
        }
        for connection in &mut self.landscape.connections {
            connection.path.images.iter_mut().for_each(change);
            for crossing in &mut connection.crossings {
                crossing.path.images.iter_mut().for_each(change);
            }
        }
    }
}
