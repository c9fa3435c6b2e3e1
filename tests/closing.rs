//! Hands that close until they press.

use std::sync::Arc;

use landscape::evaluation::stability::{Build, Drop, Protocol, Solid, simulate};
use landscape::grasp::closing::{ClosingSettings, capsule_touches, close_hand, preload};
use landscape::grasp::synthesis::{Refinement, SynthesisSettings, synthesize};
use landscape::grasp::{EnergySettings, GraspEnergy, judge};
use landscape::hand::Hand;
use landscape::object::Object;
use landscape::optimize::QuenchSettings;

/// A few chains on a ball: firm grasps touch the object, are no deeper than requested, and hold in simulation.
#[test]
fn firm_grasps_touch_and_stay() {
    let hand = Arc::new(Hand::human());
    let object = Arc::new(Object::named("ball").unwrap());
    let energy =
        GraspEnergy::new(hand.clone(), object.clone(), EnergySettings::four_points()).unwrap();
    let solid = Solid::new(&object.mesh, Build::Pieces);
    let settings = SynthesisSettings {
        refinement: Refinement::Pressed,
        ..SynthesisSettings::four_points()
    };
    let mut firm = 0;
    for chain in 0..3 {
        let end = synthesize(&energy, &settings, &QuenchSettings::default(), 0, chain);
        let measured = preload(&energy, &end.refined.pose);
        if !measured.is_sufficient() {
            continue;
        }
        firm += 1;
        assert!(judge(&energy, &end.refined).passes_strict());
        assert!(measured.touches >= 3, "{measured:?}");
        let drop = Protocol::Drop(Drop::default());
        let outcome = simulate(&hand, &end.refined, &solid, object.mass_kg, &drop);
        assert!(outcome.is_stable(), "{outcome:?} {measured:?}");
        // Closing a closed hand again drives nothing deep into the object.
        let again = close_hand(&energy, &end.refined, &ClosingSettings::default());
        let mut posed = landscape::hand::PosedHand::default();
        hand.pose(&again, &mut posed);
        let deepest = capsule_touches(&object.exact, &hand, &posed, 0.0);
        assert!(deepest.iter().all(|touch| touch.gap_m > -1e-3));
    }
    assert!(firm > 0, "none of the chains came to a firm grasp");
}
