//! The path between two minima of a finished landscape that rises least.

use super::error::StudyError;
use crate::energy::Piecewise;
use crate::grasp::GraspEnergy;
use crate::space::{PoseSpace, Space};
use crate::store::{LandscapeFiles, PathPoint};
use crate::topography::{MinimumId, Network, minimax_path};

/// A minimax path: of all that lead from one minimum to another, one whose highest point is lowest.
#[derive(Debug, Clone, PartialEq)]
pub struct MinimaxPath {
    /// The minima it passes through, both ends included.
    pub minima: Vec<MinimumId>,
    /// Its points, in order.
    pub points: Vec<Waypoint>,
}

/// A point of a [`MinimaxPath`].
#[derive(Debug, Clone, PartialEq)]
pub struct Waypoint {
    /// The point as it is on file, but turned by the object's symmetry so that it lies next to the one before.
    pub point: PathPoint,
    /// Length of the path up to here, metres.
    pub along_m: f64,
}

impl MinimaxPath {
    /// The path between two minima of a landscape of grasps; `None` where no path joins them. `space` is that of the hand
    /// and the object.
    ///
    /// # Errors
    /// [`StudyError::NoPath`] if the tables hold no points of a part of it.
    ///
    /// # Panics
    /// If a minimum is not in the network.
    pub fn between(
        files: &LandscapeFiles,
        network: &Network,
        space: &PoseSpace,
        [from, to]: [MinimumId; 2],
    ) -> Result<Option<Self>, StudyError> {
        let Some(minima) = minimax_path(network, from, to) else {
            return Ok(None);
        };
        let points = points(files, space, &minima)?;
        Ok(Some(Self { minima, points }))
    }
}

impl Waypoint {
    /// With the contact set, if the file does not tell it, and with the energy of all terms for this set.
    #[must_use]
    pub fn explained(&self, energy: &GraspEnergy) -> Self {
        let x = &self.point.coordinates;
        let choice = if self.point.choice.is_empty() {
            energy.active_piece(x)
        } else {
            self.point.choice.clone()
        };
        let terms = energy.terms_of(x, &choice).into_iter();
        let terms: Vec<f64> = terms.map(|(_, value)| value).collect();
        Self {
            point: PathPoint {
                energy: terms.iter().sum(),
                choice,
                terms: Some(terms),
                ..self.point.clone()
            },
            along_m: self.along_m,
        }
    }

    /// Energy by term, in the order of the energy's terms; empty where it is not known.
    pub fn terms(&self) -> &[f64] {
        self.point.terms.as_deref().unwrap_or_default()
    }
}

/// The points of the paths along a route.
fn points(
    files: &LandscapeFiles,
    space: &PoseSpace,
    route: &[MinimumId],
) -> Result<Vec<Waypoint>, StudyError> {
    let mut points: Vec<Waypoint> = Vec::new();
    for pair in route.windows(2) {
        let [a, b] = [pair[0].0 as u64, pair[1].0 as u64];
        let mut rows: Vec<&PathPoint> = (files.paths.iter())
            .filter(|row| (row.a, row.b) == (a, b) || (row.a, row.b) == (b, a))
            .collect();
        if rows.len() < 2 {
            return Err(StudyError::NoPath { a, b });
        }
        rows.sort_by_key(|row| row.image);
        if rows[0].a != a {
            rows.reverse();
        }
        for row in rows {
            let mut point = row.clone();
            let mut along_m = 0.0;
            if let Some(last) = points.last() {
                point.coordinates = space.align(&last.point.coordinates, &row.coordinates);
                along_m =
                    last.along_m + space.distance(&last.point.coordinates, &point.coordinates);
            }
            // Where one path ends the next one begins.
            if (points.last()).is_none_or(|last| along_m - last.along_m > 1e-9) {
                points.push(Waypoint { point, along_m });
            }
        }
    }
    Ok(points)
}
