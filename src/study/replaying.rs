//! Ways of a landscape of grasps, driven in simulation.

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::error::StudyError;
use super::names::GraspSetting;
use super::simulation::solid_in_pieces;
use super::ways::slip_m;
use crate::energy::Explain;
use crate::evaluation::stability::{
    Reason, Replay, Replayed, Solid, Target, moved_in_hand, replay, targets,
};
use crate::grasp::{Grasp, GraspEnergy};
use crate::space::{Space, interpolate};
use crate::store::{LandscapeFiles, PathPoint};
use crate::topography::MinimumId;

/// Longest distance between points of a straight line, metres.
const STRAIGHT_M: f64 = 0.002;

/// How often an edge was driven to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Success {
    /// Number of conditions under which both ends hold at rest, of those of [`Replay::conditions`].
    pub of: usize,
    /// Number of these under which the object followed.
    pub succeeded: usize,
}

/// The ways of a landscape, and the hand and the object with which they are driven.
#[derive(Debug)]
pub struct Drives<'a> {
    files: &'a LandscapeFiles,
    energy: GraspEnergy,
    solid: Solid,
    mass_kg: f64,
}

impl<'a> Drives<'a> {
    /// The ways of a landscape of grasps; `name` is its name in errors.
    ///
    /// # Errors
    /// If it is not a landscape of grasps, or hand, object or energy cannot be built.
    pub fn of(files: &'a LandscapeFiles, name: &str) -> Result<Self, StudyError> {
        let setting = GraspSetting::of(files, name)?;
        let own_kg = files.manifest.object.as_ref().map_or(0.0, |of| of.mass_kg);
        Ok(Self {
            files,
            energy: setting.energy(files, name)?,
            solid: solid_in_pieces(&setting.object.mesh, &|_| ()),
            mass_kg: own_kg * files.manifest.scale.powi(3),
        })
    }

    /// The energy of the landscape.
    pub fn energy(&self) -> &GraspEnergy {
        &self.energy
    }

    /// Mass of the object, kilograms.
    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    /// Its centre of mass in its frame, metres.
    pub fn centre(&self) -> Vector3<f64> {
        self.solid.centre()
    }

    /// The posture of a minimum.
    ///
    /// # Panics
    /// As [`Drives::path`].
    pub fn rest(&self, minimum: MinimumId) -> Vec<Grasp> {
        self.pressing(vec![self.coordinates(minimum).to_vec()])
    }

    /// The path of an edge, each point with the contacts at which the hand presses there.
    ///
    /// # Errors
    /// [`StudyError::NoPath`] if the landscape has none.
    ///
    /// # Panics
    /// If a minimum is not one of the landscape.
    pub fn path(&self, [from, to]: [MinimumId; 2]) -> Result<Vec<Grasp>, StudyError> {
        let [a, b] = [from.0 as u64, to.0 as u64];
        let rows = self.files.paths.iter();
        let mut rows: Vec<&PathPoint> = rows
            .filter(|row| [(a, b), (b, a)].contains(&(row.a, row.b)))
            .collect();
        rows.sort_by_key(|row| row.image);
        if rows.first().is_some_and(|row| row.a != a) {
            rows.reverse();
        }
        if rows.len() < 2 {
            return Err(StudyError::NoPath { a, b });
        }
        let points = rows.into_iter().map(|row| row.coordinates.clone());
        Ok(self.pressing(points.collect()))
    }

    /// The straight line between two minima in joints and pose, to the nearest copy of the second.
    ///
    /// # Panics
    /// As [`Drives::path`].
    pub fn straight(&self, ends: [MinimumId; 2]) -> Vec<Grasp> {
        let space = self.energy.pose_space();
        let [from, to] = ends.map(|end| self.coordinates(end));
        let parts = (space.distance(from, to) / STRAIGHT_M).ceil().max(1.0);
        let parts_done = std::iter::successors(Some(0.0), |done| Some(done + 1.0));
        let points = parts_done
            .take_while(|done| *done <= parts)
            .map(|done| interpolate(space, from, to, done / parts));
        self.pressing(points.collect())
    }

    fn pressing(&self, points: Vec<Vec<f64>>) -> Vec<Grasp> {
        let points = points.into_par_iter();
        points.map(|x| Grasp::best(&self.energy, x)).collect()
    }

    /// How far the hand's surface slips over the object at contacts that carry along a way, summed over the palm and the digits,
    /// metres, and the largest compliance on it.
    pub fn slip_and_compliance(&self, way: &[Grasp]) -> [f64; 2] {
        let points: Vec<&[f64]> = way.iter().map(|grasp| &grasp.pose[..]).collect();
        let compliance = |x: &&[f64]| {
            let terms = self.energy.terms(x).into_iter();
            let of = terms.filter(|(name, _)| name == "compliance");
            of.map(|(_, value)| value).sum()
        };
        let largest = points.iter().map(compliance).fold(0.0, f64::max);
        [slip_m(&self.energy, &points), largest]
    }

    /// Drives a way.
    ///
    /// # Panics
    /// As [`replay`].
    pub fn replay(&self, way: &[Grasp], settings: &Replay) -> Replayed {
        let (hand, space) = (self.energy.hand(), self.energy.pose_space());
        replay(hand, space, way, &self.solid, self.mass_kg, settings)
    }

    /// The targets of the joints along a way.
    ///
    /// # Panics
    /// As [`replay`].
    pub fn targets(&self, way: &[Grasp], settings: &Replay) -> Vec<Target> {
        let (hand, space) = (self.energy.hand(), self.energy.pose_space());
        targets(hand, space, way, &self.solid, settings)
    }

    /// Drives the path of an edge, and both ends at rest, under [`Replay::conditions`].
    ///
    /// # Errors
    /// As [`Drives::path`].
    ///
    /// # Panics
    /// As [`Drives::path`].
    pub fn success(&self, ends: [MinimumId; 2]) -> Result<Success, StudyError> {
        let (way, rests) = (self.path(ends)?, ends.map(|end| self.rest(end)));
        let conditions = Replay::conditions();
        let held =
            |way: &[Grasp], settings: &Replay| self.replay(way, settings).reason == Reason::Held;
        let each = conditions.par_iter().map(|settings| {
            let holds = rests.iter().all(|rest| held(rest, settings));
            (holds, holds && held(&way, settings))
        });
        let each: Vec<(bool, bool)> = each.collect();
        Ok(Success {
            of: each.iter().filter(|(holds, _)| *holds).count(),
            succeeded: each.iter().filter(|(_, succeeds)| *succeeds).count(),
        })
    }

    /// Distance (metres) and angle (radians) by which the object must move in the hand between two minima.
    ///
    /// # Panics
    /// As [`Drives::path`].
    pub fn asked(&self, ends: [MinimumId; 2]) -> [f64; 2] {
        let symmetry = self.energy.pose_space().symmetry();
        let ends = ends.map(|end| self.coordinates(end));
        moved_in_hand(symmetry, &self.solid.centre(), ends)
    }

    /// Distance of two minima, metres.
    ///
    /// # Panics
    /// As [`Drives::path`].
    pub fn distance_m(&self, [from, to]: [MinimumId; 2]) -> f64 {
        let [from, to] = [from, to].map(|end| self.coordinates(end));
        self.energy.pose_space().distance(from, to)
    }

    fn coordinates(&self, minimum: MinimumId) -> &[f64] {
        &self.files.minima[minimum.0].coordinates
    }
}
