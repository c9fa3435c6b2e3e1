//! The known failures of Liu et al. (2021), Fig. 11: they occur with the paper's method but not with the default.
#![cfg(feature = "grasp")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::sync::{Arc, LazyLock};

use landscape::grasp::depth::object_inside_hand_m;
use landscape::grasp::failure::{in_one_concavity, sees};
use landscape::grasp::paper::{PaperEnergy, PaperSettings, sample};
use landscape::grasp::synthesis::{SynthesisSettings, synthesize};
use landscape::grasp::{EnergySettings, GraspEnergy, Judgement, judge};
use landscape::hand::{Hand, PosedHand};
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use nalgebra::Vector3;

use crate::between_points::{passes_between_points, points_inside_object_m};

static HAND: LazyLock<Arc<Hand>> = LazyLock::new(|| Arc::new(Hand::human()));
static PEN: LazyLock<Arc<Object>> = LazyLock::new(|| Arc::new(Object::named("pen").unwrap()));
static BOWL: LazyLock<Arc<Object>> = LazyLock::new(|| Arc::new(Object::named("bowl").unwrap()));

/// The seed of `analysis/failures.rs`.
const SEED: u64 = 11;

fn posed(x: &[f64]) -> PosedHand {
    let mut posed = PosedHand::default();
    HAND.pose(x, &mut posed);
    posed
}

fn on_surface(object: &Object, toward: [f64; 3]) -> Vector3<f64> {
    object.exact.nearest(&Vector3::from(toward)).point
}

/// Points of the inner wall of a bowl see each other. Points of its outer wall and points of a ball do not.
#[test]
fn the_inside_of_a_bowl_is_one_concavity() {
    let around = |radius: f64, height: f64| {
        [0.3, 2.3, 4.4].map(|angle: f64| {
            on_surface(
                &BOWL,
                [radius * libm::cos(angle), radius * libm::sin(angle), height],
            )
        })
    };
    let (inside, outside) = (around(0.05, 0.045), around(0.09, 0.045));
    assert!(in_one_concavity(&BOWL.exact, &inside));
    assert!(!in_one_concavity(&BOWL.exact, &outside));
    let [a, b, _] = inside;
    let [_, _, c] = outside;
    assert!(sees(&BOWL.exact, &a, &b) && !sees(&BOWL.exact, &a, &c));
    assert!(!in_one_concavity(&BOWL.exact, &[a, b, c]));

    let ball = Object::named("ball").unwrap();
    let samples = &ball.surface_samples;
    for (one, other) in samples.iter().zip(&samples[1..200]) {
        let apart = (one.point - other.point).norm();
        assert!(apart < 0.01 || !sees(&ball.exact, &one.point, &other.point));
    }
}

/// The paper's method lets a pen pass through a finger between its surface points, and force closure and penetration as
/// Eq. 11 has them find nothing wrong with it. None of the grasps of the default does the same.
#[test]
fn a_pen_no_longer_passes_through_a_finger() {
    let paper = PaperEnergy::new(HAND.clone(), PEN.clone(), PaperSettings::printed());
    let mut failures = 0;
    for chain in 0..12 {
        let end = sample(&paper, SEED, chain, &mut |_, _| ());
        let posed = posed(&end.refined.pose);
        let judgement = paper.judge(&end.refined);
        let blind = judgement.net_wrench < 0.5 && judgement.penetration < 0.02;
        if !passes_between_points(&PEN.exact, &HAND, &posed) || !blind {
            continue;
        }
        failures += 1;
        assert!(points_inside_object_m(&PEN.exact, &posed) < 0.002);
        assert!(judgement.deepest_m > 0.002 && !judgement.passes_strict());
    }
    assert!(failures > 0);

    let ours = GraspEnergy::new(HAND.clone(), PEN.clone(), EnergySettings::default()).unwrap();
    let refine = QuenchSettings::default().with_gradient_tolerance(1e-3);
    let mut grasps = 0;
    for chain in 0..4 {
        let settings = SynthesisSettings::default();
        let end = synthesize(&ours, &settings, &refine, SEED, chain);
        let judgement = judge(&ours, &end.refined);
        if judgement.passes_strict() {
            grasps += 1;
            let depth = object_inside_hand_m(&PEN.exact, &HAND, &posed(&end.refined.pose));
            assert!(depth < 0.002, "{depth}");
            assert!(judgement.digits > 1 && !judgement.one_concavity);
            let wedged = Judgement {
                one_concavity: true,
                ..judgement
            };
            let invalid_reason = wedged.strict_objection();
            assert_eq!(invalid_reason, Some("contacts in one concavity"));
        }
    }
    assert!(grasps >= 2, "{grasps}");
}
