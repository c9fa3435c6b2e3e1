//! Figure 1 of Liu et al. (2021): from a random start to a grasp → `figures/synthesis_process.png`
//!
//! One chain of the default sampler on the round bottle: the first of seed 1 whose first attempt passes the strict filter.
//! The pictures show its start, the lowest end after each of its descents, and the minimum of the energy to which the last
//! of them leads. Red cones are the friction cones, μ = 0.5, of the contact set, with their tips at the nearest points of the
//! bottle. Below each picture are the number of descents so far and the energy; 1 is the energy of a
//! hand that has let go. The descents of the chain are on the energy that closes the digits of its grip, so that the energy
//! shown may rise from one to the next.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use landscape::energy::Energy;
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

/// The start of a chain and its states after each descent, if its first attempt ends in a grasp.
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
            "{when}:  E = {:.3}",
            energy.evaluate(&grasp.pose, &mut unused)
        ),
        grasp,
    };
    let mut moments: Vec<Moment> = seen
        .iter()
        .enumerate()
        .map(|(descents, state)| {
            let when = match descents {
                0 => "start".to_owned(),
                1 => "1 descent".to_owned(),
                more => format!("{more} descents"),
            };
            moment(when, Grasp::best(energy, state.coordinates.clone()))
        })
        .collect();
    moments.push(moment("minimum".to_owned(), end.refined.clone()));
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
