//! Number of grasps that hold if the pose or the size of the object differs from the assumed one. Liu et al. (2021) state
//! perfect knowledge as a limitation. → `figures/pose_error.md`, `.png`
//!
//! Firm grasps that pass a test without error are simulated again. Either the object is moved by d in a random direction
//! and rotated by d over its radius about a random axis through its centroid, or its surface is moved outward (+) or inward
//! (−) by d. `--quick`: few grasps, into `target/`.

#[path = "yields/interval.rs"]
mod interval;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use interval::interval;
use landscape::evaluation::stability::{Build, Drop, Protocol, SixDirections, Solid, simulate};
use landscape::figure::chart::{Axis, BandPoint, Chart, Panel, Series};
use landscape::grasp::closing::preload;
use landscape::grasp::synthesis::{Refinement, SynthesisSettings, synthesize};
use landscape::grasp::{EnergySettings, Grasp, GraspEnergy, judge};
use landscape::hand::Hand;
use landscape::mesh::Mesh;
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use landscape::sample::{Task, stream};
use landscape::space::Pose;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rayon::prelude::*;

const SEED: u64 = 6;
const OBJECTS: [&str; 2] = ["bottle_round", "bottle_flask"];
const ERRORS_MM: [f64; 4] = [0.0, 1.0, 2.0, 5.0];
const SHAPES_MM: [f64; 7] = [-5.0, -2.0, -1.0, 0.0, 1.0, 2.0, 5.0];
/// Number of random errors of each size per grasp.
const DRAWS: u64 = 4;
/// Number of grasps of each object for the six directions, which cost twenty times as much as the drop.
const PUSHED: usize = 8;

/// Numbers of trials and of grasps that held.
#[derive(Clone, Copy, Default)]
struct Share {
    held: f64,
    of: f64,
}

impl Share {
    fn add(&mut self, outcomes: &[bool]) {
        self.of += outcomes.len() as f64;
        self.held += outcomes.iter().filter(|held| **held).count() as f64;
    }

    fn text(self) -> String {
        let [low, high] = interval(self.held, self.of).map(|bound| 100.0 * bound);
        format!(
            "{:.1} % [{low:.1}, {high:.1}] of {}",
            100.0 * self.held / self.of,
            self.of
        )
    }
}

/// Outcomes of one protocol for pose errors and for shape errors.
struct Curves {
    name: &'static str,
    protocol: Protocol,
    /// Largest number of grasps of each object.
    grasps: usize,
    pose: Vec<Share>,
    shape: Vec<Share>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let folder = PathBuf::from(if quick { "target" } else { "figures" });
    let chains = if quick { 4 } else { 60 };
    let curves = |name, protocol, grasps| Curves {
        name,
        protocol,
        grasps,
        pose: vec![Share::default(); ERRORS_MM.len()],
        shape: vec![Share::default(); SHAPES_MM.len()],
    };
    let mut all = [
        curves("drop", Protocol::Drop(Drop::default()), usize::MAX),
        curves(
            "six directions, squeezed",
            Protocol::SixDirections(SixDirections::default()),
            PUSHED,
        ),
    ];
    let hand = Arc::new(Hand::human());
    for name in OBJECTS {
        eprintln!("{name}");
        let object = Arc::new(Object::named(name)?);
        let exact = Solid::new(&object.mesh, Build::Pieces);
        let grasps = grasps(&hand, &object, chains)?;
        let shapes = SHAPES_MM.map(|offset_mm| {
            let mesh = offset(name, &object.mesh, 1e-3 * offset_mm);
            mesh.map(|mesh| Solid::new(&mesh, Build::Pieces))
        });
        for curves in &mut all {
            let protocol = &curves.protocol;
            let holds = |solid: &Solid, grasp: &Grasp| {
                simulate(&hand, grasp, solid, object.mass_kg, protocol).is_stable()
            };
            let known: Vec<&Grasp> = grasps[..grasps.len().min(curves.grasps)]
                .par_iter()
                .filter(|grasp| holds(&exact, grasp))
                .collect();
            for (share, error_mm) in curves.pose.iter_mut().zip(ERRORS_MM) {
                let trials: Vec<bool> = known
                    .par_iter()
                    .enumerate()
                    .flat_map(|(number, grasp)| {
                        let trial = |draw| {
                            let id = number as u64 * DRAWS + draw;
                            let pose = moved(&grasp.pose, &object, 1e-3 * error_mm, id);
                            holds(&exact, &Grasp::new(pose, grasp.contacts.clone()))
                        };
                        (0..DRAWS).map(trial).collect::<Vec<bool>>()
                    })
                    .collect();
                share.add(&trials);
            }
            for (share, solid) in curves.shape.iter_mut().zip(&shapes) {
                let Ok(solid) = solid else { continue };
                let trials: Vec<bool> = known.par_iter().map(|grasp| holds(solid, grasp)).collect();
                share.add(&trials);
            }
        }
    }
    fs::write(folder.join("pose_error.md"), text(&all, chains))?;
    chart(&all).draw()?.save(&folder.join("pose_error.png"))?;
    Ok(())
}

/// Firm grasps.
fn grasps(
    hand: &Arc<Hand>,
    object: &Arc<Object>,
    chains: u64,
) -> Result<Vec<Grasp>, Box<dyn Error>> {
    let energy = GraspEnergy::new(hand.clone(), object.clone(), EnergySettings::four_points())?;
    let grasp = |chain| {
        let refine = QuenchSettings::default();
        let synthesis = SynthesisSettings {
            refinement: Refinement::Pressed,
            ..SynthesisSettings::four_points()
        };
        let end = synthesize(&energy, &synthesis, &refine, SEED, chain);
        let passes = judge(&energy, &end.refined).passes_strict()
            && preload(&energy, &end.refined.pose).is_sufficient();
        passes.then_some(end.refined)
    };
    Ok((0..chains).into_par_iter().filter_map(grasp).collect())
}

/// The hand's pose relative to an object that is moved by `error_m` and rotated by `error_m` over its radius.
fn moved(pose: &Pose, object: &Object, error_m: f64, id: u64) -> Pose {
    let mut rng = stream(SEED, Task::Start, id);
    let mut direction = || {
        // Uniform directions: draw from a cube until the point is inside the ball.
        loop {
            let v = Vector3::from_fn(|_, _| 2.0 * rng.random::<f64>() - 1.0);
            if (0.01..=1.0).contains(&v.norm()) {
                break v.normalize();
            }
        }
    };
    let way = direction() * error_m;
    let turn = UnitQuaternion::from_scaled_axis(direction() * (error_m / object.radius_m));
    let to_centre = Translation3::from(object.centroid);
    let object_from_moved = to_centre * Translation3::from(way) * turn * to_centre.inverse();
    let [w, i, j, k] = pose.rotation_wxyz();
    let hand = Isometry3::from_parts(
        Vector3::from_column_slice(pose.translation_m()).into(),
        UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)),
    );
    let placed = object_from_moved.inverse() * hand;
    let q = placed.rotation;
    let translation_m = placed.translation.vector.into();
    Pose::new(translation_m, [q.w, q.i, q.j, q.k], pose.joints())
}

/// The mesh with every vertex moved along its area-weighted normal.
fn offset(name: &str, mesh: &Mesh, by_m: f64) -> Result<Mesh, landscape::mesh::MeshError> {
    let mut normals = vec![Vector3::zeros(); mesh.vertices().len()];
    for (index, triangle) in mesh.triangles().iter().enumerate() {
        let [a, b, c] = mesh.corners(index);
        for &vertex in triangle {
            normals[vertex as usize] += (b - a).cross(&(c - a));
        }
    }
    let moved = mesh
        .vertices()
        .iter()
        .zip(&normals)
        .map(|(vertex, normal)| vertex + normal.try_normalize(0.0).unwrap_or_default() * by_m);
    Mesh::new(name, moved.collect(), mesh.triangles().to_vec())
}

fn text(all: &[Curves], chains: u64) -> String {
    let mut text = format!(
        "# Success against errors of pose and shape\n\n{chains} chains (seed {SEED}) on each of {}; firm grasps (`landscape \
         synth --keep firm`) that hold without error, of each object {PUSHED} at most in the six directions. Pose error d: the object moved by d in a random direction and \
         turned by d over its radius, {DRAWS} draws a grasp. Shape error: its surface moved outward or inward. In brackets: \
         95 % intervals (Wilson), as if draws of one grasp were independent.\n",
        OBJECTS.join(" and ")
    );
    for curves in all {
        let _ = write!(
            text,
            "\n## {}\n\n| pose error, mm | held |\n|---|---|\n",
            curves.name
        );
        for (error, share) in ERRORS_MM.iter().zip(&curves.pose) {
            let _ = writeln!(text, "| {error} | {} |", share.text());
        }
        text.push_str("\n| surface moved, mm | held |\n|---|---|\n");
        for (error, share) in SHAPES_MM.iter().zip(&curves.shape) {
            let _ = writeln!(text, "| {error:+} | {} |", share.text());
        }
    }
    text
}

fn chart(all: &[Curves]) -> Chart {
    let series = |name: &str, errors: &[f64], shares: &[Share]| {
        let mut points = Vec::new();
        let mut band = Vec::new();
        for (&x, share) in errors.iter().zip(shares) {
            let [lower, upper] = interval(share.held, share.of).map(|bound| 100.0 * bound);
            points.push([x, 100.0 * share.held / share.of]);
            band.push(BandPoint { x, lower, upper });
        }
        [Series::band(band), Series::line(points).named(name)]
    };
    let panel = |title: &str, label: &str, lines: Vec<Series>| {
        let share = Axis::linear("grasps that hold (%)").with_range(0.0, 104.0);
        Panel::new(title, Axis::linear(label), share, lines)
    };
    let pose = all
        .iter()
        .flat_map(|curves| series(curves.name, &ERRORS_MM, &curves.pose));
    let shape = all
        .iter()
        .flat_map(|curves| series(curves.name, &SHAPES_MM, &curves.shape));
    let panels = vec![
        panel("pose error", "object moved by (mm)", pose.collect()),
        panel(
            "shape error",
            "surface moved outward by (mm)",
            shape.collect(),
        ),
    ];
    Chart {
        legend_below: true,
        ..Chart::new(
            "Grasps that hold when the object is not as believed",
            panels,
        )
    }
}
