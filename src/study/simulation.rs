//! The grasps of a file in a physics engine.

use std::collections::BTreeMap;
use std::time::Instant;

use serde::Serialize;
use serde_json::json;

use super::{Run, StudyError, tally};
use crate::evaluation::stability::{Build, ClosingRule, Fit, Outcome, Protocol, Solid, simulate};
use crate::mesh::Mesh;
use crate::store::{GraspFile, content_hash};
use crate::topography::{Observer, Phase, Progress};

/// Version of the engine, for the file: results are the same bits only for the same one.
const ENGINE: &str = "rapier3d-f64 0.36";

/// How well the convex pieces of an object fit its mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectFit {
    /// Name of the object.
    pub object: String,
    /// Factor on its size.
    pub scale: f64,
    /// The fit.
    #[serde(flatten)]
    pub fit: Fit,
}

/// What [`simulate_all`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Outcomes by id, rising.
    pub outcomes: Vec<(u64, Outcome)>,
    /// How well the objects were cut into pieces, in the order of the populations.
    pub fits: Vec<ObjectFit>,
    /// Time spent simulating, seconds.
    pub seconds: f64,
    /// Time spent before on hands and objects, such as cutting objects into convex pieces, seconds.
    pub preparation_seconds: f64,
}

/// The solid of a mesh in convex pieces. The observer is told if it must be cut.
pub(super) fn solid_in_pieces(mesh: &Mesh, observer: &Observer<'_>) -> Solid {
    let cutting = || {
        observer(Progress {
            phase: Phase::Cut,
            done: 0,
            total: 0,
            round: None,
        });
    };
    Solid::announced(mesh, Build::Pieces, &cutting)
}

/// A hash of all that outcomes depend on, for the journal.
///
/// # Errors
/// If the metadata cannot be stored.
pub fn simulation_fingerprint(
    file: &GraspFile,
    protocol: &Protocol,
) -> Result<String, serde_json::Error> {
    let told = serde_json::to_string(&(protocol, &file.metadata, ENGINE))?;
    let rows = format!("{:?}", file.grasps);
    Ok(content_hash(&[told.as_bytes(), rows.as_bytes()]))
}

/// Simulates all grasps of a file. Finished grasps are kept in the journal of the run.
///
/// # Errors
/// If a hand or an object cannot be built, or the journal takes no record.
pub fn simulate_all(
    file: &GraspFile,
    protocol: &Protocol,
    run: &Run<'_>,
) -> Result<Simulation, StudyError> {
    let tally = run.tally(Phase::Simulate, file.grasps.len());
    let mut found = Simulation {
        outcomes: Vec::with_capacity(file.grasps.len()),
        fits: Vec::new(),
        seconds: 0.0,
        preparation_seconds: 0.0,
    };
    for population in file.landscapes() {
        let started = Instant::now();
        let hand = population.hand()?;
        let (mesh, mass_kg) = population.mesh()?;
        let solid = solid_in_pieces(&mesh, run.observer);
        found.fits.push(ObjectFit {
            object: population.object.name.clone(),
            scale: population.scale,
            fit: *solid.fit(),
        });
        found.preparation_seconds += started.elapsed().as_secs_f64();
        let started = Instant::now();
        let outcomes = run.each(
            &tally,
            &population.grasps,
            |row| format!("grasp {}", row.id),
            |row| {
                let squeezed = row.squeeze_joints.as_deref();
                simulate(&hand, &row.grasp, squeezed, &solid, mass_kg, protocol)
            },
        )?;
        let ids = population.grasps.iter().map(|row| row.id);
        let outcomes: Vec<_> = ids.zip(outcomes).collect();
        found.seconds += started.elapsed().as_secs_f64();
        found.outcomes.extend(outcomes);
    }
    found.outcomes.sort_by_key(|(id, _)| *id);
    Ok(found)
}

/// Simulates at most `most` grasps of a file, evenly chosen from its rows.
///
/// # Errors
/// As [`simulate_all`].
pub fn simulate_sample(
    file: &GraspFile,
    protocol: &Protocol,
    most: usize,
    run: &Run<'_>,
) -> Result<Simulation, StudyError> {
    let total = file.grasps.len();
    let count = most.min(total);
    let sample = GraspFile {
        metadata: file.metadata.clone(),
        grasps: (0..count)
            .map(|k| file.grasps[k * total / count].clone())
            .collect(),
    };
    simulate_all(&sample, protocol, run)
}

impl Simulation {
    /// Number of grasps that keep the object.
    pub fn stable(&self) -> usize {
        let outcomes = self.outcomes.iter();
        outcomes.filter(|(_, outcome)| outcome.is_stable()).count()
    }

    /// Number of grasps that closed by each rule, by the names of the rules.
    pub fn closed_by(&self) -> BTreeMap<String, usize> {
        let rules = self.outcomes.iter().map(|(_, outcome)| outcome.closed_by);
        tally(rules.map(ClosingRule::name)).into_iter().collect()
    }

    /// Writes outcomes into the rows of the file, and the protocol into its metadata.
    pub fn record(&self, file: &mut GraspFile, protocol: &Protocol) {
        let finite = |value: f64| value.is_finite().then_some(value);
        for row in &mut file.grasps {
            if let Ok(place) = self.outcomes.binary_search_by_key(&row.id, |(id, _)| *id) {
                let outcome = &self.outcomes[place].1;
                row.stable = Some(outcome.is_stable());
                row.stable_reason = Some(outcome.reason.name().to_owned());
                row.stable_displacement_m = finite(outcome.displacement_m);
                row.stable_turn_rad = finite(outcome.turn_rad);
            }
        }
        file.metadata.stability = json!({
            "protocol": protocol,
            "closed_by": self.closed_by(),
            "engine": ENGINE,
            "program_version": env!("CARGO_PKG_VERSION"),
            "objects": self.fits,
        });
    }
}
