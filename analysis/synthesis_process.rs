//! Figure 1 of Liu et al. (2021): from a random start to a grasp → `figures/synthesis_process.png`
//!
//! One chain of the default sampler on the round bottle: the first of seed 1 whose first attempt passes the strict filter.
//! Red cones are the friction cones, μ = 0.5, of its contacts, with their tips at the nearest points of the bottle. Below
//! each picture are the steps so far and the energy with all weights at their full value. (While the chain runs, contact
//! and depth have lower weights.)

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use landscape::energy::{Energy, Piecewise};
use landscape::figure::{Camera, Scene, contact_sheet};
use landscape::grasp::filter::STRICT_FRICTION;
use landscape::grasp::synthesis::{SynthesisSettings, Synthesized, synthesize_observed};
use landscape::grasp::{EnergySettings, Grasp, GraspEnergy, judge};
use landscape::hand::Hand;
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use landscape::sample::State;
use nalgebra::Vector3;

const SEED: u64 = 1;
/// Steps shown between the start and the end of the attempt.
const STEPS: [u32; 5] = [20, 80, 160, 260, 380];
const COLUMNS: usize = 4;
const SIDE: u32 = 330;
const CONE_M: f64 = 0.025;

/// A pose to be drawn.
struct Moment {
    caption: String,
    grasp: Grasp,
}

fn main() -> Result<(), Box<dyn Error>> {
    let object = Arc::new(Object::named("bottle_round")?);
    let energy = GraspEnergy::new(
        Arc::new(Hand::human()),
        object.clone(),
        EnergySettings::default(),
    )?;
    let settings = SynthesisSettings::default();
    let (seen, end) = (0..64)
        .find_map(|chain| follow(&energy, &settings, chain))
        .ok_or("no chain came to a grasp in its first attempt")?;
    eprintln!("chain {}", end.chain);

    let skin = energy.hand().skin();
    let moments = moments(&energy, &seen, &end);
    let scenes: Vec<Scene> = moments
        .iter()
        .map(|moment| {
            Scene::of_grasp(energy.hand(), &skin, &object, &moment.grasp).with_friction_cones(
                &object.exact,
                STRICT_FRICTION,
                CONE_M,
            )
        })
        .collect();
    let camera = camera(&scenes);
    let images: Vec<_> = scenes
        .iter()
        .map(|scene| scene.render(&camera, SIDE, SIDE))
        .collect();
    let captions: Vec<String> = moments.into_iter().map(|moment| moment.caption).collect();
    let path = Path::new("figures/synthesis_process.png");
    contact_sheet(&images, &captions, COLUMNS, path)?;
    Ok(())
}

/// The states of a chain after each number of steps, if its first attempt ends in a grasp.
fn follow(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    chain: u64,
) -> Option<(Vec<State>, Synthesized)> {
    let mut seen: Vec<State> = Vec::new();
    let refine = QuenchSettings::default();
    let end = synthesize_observed(energy, settings, &refine, SEED, chain, &mut |_, state| {
        seen.push(state.clone());
    });
    // Attempts have equal length, and each shows its start and the state after every step.
    let first = seen.len() as u64 == end.steps + 1;
    let passes = judge(energy, &end.refined).passes_strict();
    (first && passes).then_some((seen, end))
}

fn moments(energy: &GraspEnergy, seen: &[State], end: &Synthesized) -> Vec<Moment> {
    let mut unused = vec![0.0; energy.space().tangents()];
    let mut moment = |when: String, grasp: Grasp| Moment {
        caption: format!(
            "{when}:  E = {:.2}",
            energy.evaluate_piece(&grasp.pose, &grasp.contacts, &mut unused)
        ),
        grasp,
    };
    let steps = STEPS.map(|step| step as usize);
    let last = seen.len() - 1;
    let mut moments: Vec<Moment> = [0]
        .into_iter()
        .chain(steps)
        .chain([last])
        .map(|step| {
            let state = &seen[step];
            let grasp = Grasp::new(state.coordinates.clone(), state.discrete.clone());
            moment(format!("step {step}"), grasp)
        })
        .collect();
    moments.push(moment("refined".to_owned(), end.refined.clone()));
    moments
}

/// One viewpoint for all scenes: the best one for the last scene, far enough away to show every scene completely.
fn camera(scenes: &[Scene]) -> Camera {
    let last = scenes.last().expect("there is at least one scene");
    let toward_eye = last.best_camera(Vector3::z()).toward_eye();
    let together = Scene {
        surfaces: scenes
            .iter()
            .flat_map(|scene| scene.surfaces.clone())
            .collect(),
        ..Scene::default()
    };
    together.framed(toward_eye, Vector3::z())
}
