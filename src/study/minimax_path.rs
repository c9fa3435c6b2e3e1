//! The minimax path between two minima of a finished landscape.

use rayon::prelude::*;

use super::error::StudyError;
use crate::energy::Explain;
use crate::grasp::GraspEnergy;
use crate::space::{PoseSpace, Space};
use crate::store::{LandscapeFiles, PathPoint};
use crate::topography::{MinimumId, Network, minimax_path};

/// A space, and the copy of the second point that is nearest to the first.
type Aligned<'a> = (&'a dyn Space, &'a dyn Fn(&[f64], &[f64]) -> Vec<f64>);

/// A minimax path, which has the lowest highest point of all paths between two minima.
#[derive(Debug, Clone, PartialEq)]
pub struct MinimaxPath {
    /// The minima along the path, including both ends.
    pub minima: Vec<MinimumId>,
    /// Its points, in order.
    pub points: Vec<Waypoint>,
}

/// A point of a [`MinimaxPath`].
#[derive(Debug, Clone, PartialEq)]
pub struct Waypoint {
    /// The point in the file, turned by the object's symmetry so that it lies next to the previous one.
    pub point: PathPoint,
    /// Its contact set; empty if the path is not [explained](MinimaxPath::explained).
    pub contacts: Vec<u32>,
    /// Length of the path to this point, metres.
    pub along_m: f64,
}

impl MinimaxPath {
    /// The path between two minima of a landscape of grasps in the `space` of hand and object; `None` if none joins them.
    ///
    /// # Errors
    /// [`StudyError::NoPath`] if the tables have no points of a part of the path.
    ///
    /// # Panics
    /// If a minimum is not in the network.
    pub fn between(
        files: &LandscapeFiles,
        network: &Network,
        space: &PoseSpace,
        [from, to]: [MinimumId; 2],
    ) -> Result<Option<Self>, StudyError> {
        let align = |a: &[f64], b: &[f64]| space.align(a, b);
        Self::aligned(files, network, (space, &align), [from, to])
    }

    /// The path between two minima of the landscape of a surface on `space`; `None` if none joins them. Lengths are those of
    /// the space.
    ///
    /// # Errors
    /// [`StudyError::NoPath`] if the tables have no points of a part of the path.
    ///
    /// # Panics
    /// If a minimum is not in the network.
    pub fn on_surface(
        files: &LandscapeFiles,
        network: &Network,
        space: &dyn Space,
        ends: [MinimumId; 2],
    ) -> Result<Option<Self>, StudyError> {
        let align = |a: &[f64], b: &[f64]| {
            let mut tangent = vec![0.0; space.tangents()];
            space.log(a, b, &mut tangent);
            let mut aligned = a.to_vec();
            space.exp(&mut aligned, &tangent);
            aligned
        };
        Self::aligned(files, network, (space, &align), ends)
    }

    fn aligned(
        files: &LandscapeFiles,
        network: &Network,
        space: Aligned<'_>,
        [from, to]: [MinimumId; 2],
    ) -> Result<Option<Self>, StudyError> {
        let Some(minima) = minimax_path(network, from, to) else {
            return Ok(None);
        };
        let points = points(files, space, &minima)?;
        Ok(Some(Self { minima, points }))
    }

    /// Adds contact sets and the energy of all terms.
    #[must_use]
    pub fn explained(&self, energy: &GraspEnergy) -> Self {
        let points = self.points.par_iter();
        Self {
            minima: self.minima.clone(),
            points: points.map(|point| point.explained(energy)).collect(),
        }
    }

    /// Index of the highest point.
    pub fn top(&self) -> usize {
        let energy = |place: usize| self.points[place].point.energy;
        let places = 0..self.points.len();
        let highest = places.max_by(|a, b| energy(*a).total_cmp(&energy(*b)));
        highest.unwrap_or(0)
    }
}

impl Waypoint {
    /// Adds the contact set and the energy by term.
    fn explained(&self, energy: &GraspEnergy) -> Self {
        let x = &self.point.coordinates;
        let terms = energy.terms(x).into_iter();
        let terms: Vec<f64> = terms.map(|(_, value)| value).collect();
        Self {
            point: PathPoint {
                energy: terms.iter().sum(),
                terms: Some(terms),
                ..self.point.clone()
            },
            contacts: energy.contacts(x),
            along_m: self.along_m,
        }
    }

    /// Energy by term, in the order of the energy's terms; empty if the path is not [explained](MinimaxPath::explained).
    pub fn terms(&self) -> &[f64] {
        self.point.terms.as_deref().unwrap_or_default()
    }
}

fn points(
    files: &LandscapeFiles,
    (space, align): Aligned<'_>,
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
                point.coordinates = align(&last.point.coordinates, &row.coordinates);
                along_m =
                    last.along_m + space.distance(&last.point.coordinates, &point.coordinates);
            }
            // Each path begins where the previous one ends.
            if (points.last()).is_none_or(|last| along_m - last.along_m > 1e-9) {
                points.push(Waypoint {
                    point,
                    contacts: Vec::new(),
                    along_m,
                });
            }
        }
    }
    Ok(points)
}
