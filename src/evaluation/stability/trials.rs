//! Loads on an object in a closed hand.

use nalgebra::{Isometry3, Vector3};

use super::closing::Closed;
use super::driven_hand::add_hand;
use super::hand_parts::{NEAR_M, fix_hand};
use super::judge::{Outcome, Reason, overlaps};
use super::load_test::{Axes, ClosingRule, EndContact, LoadTest, MeasuredFrom};
use super::rest::Watch;
use super::solid::{Solid, motion};
use super::world::World;
use crate::hand::Hand;

/// Closes the hand and applies the loads.
pub(super) fn withstand(
    hand: &Hand,
    closed: &Closed,
    solid: &Solid,
    own_kg: f64,
    test: &LoadTest,
) -> Outcome {
    let mass_kg = test.mass_kg(solid, own_kg);
    let mut world = World::new(solid, mass_kg, [0.0; 3], test.friction, &test.solver);
    world.damp_object(
        test.linear_damping_per_s.unwrap_or(0.0),
        test.angular_damping_per_s.unwrap_or(0.0),
    );
    if closed.rule == ClosingRule::None {
        fix_hand(&mut world, hand, &closed.posed, solid);
    } else {
        let (posed, targets) = (&closed.posed, &closed.targets);
        let near = (solid, NEAR_M);
        add_hand(&mut world, hand, posed, near, targets, &test.closing);
    }
    let mut outcome = Outcome {
        closed_by: closed.rule,
        ..Outcome::START
    };
    if overlaps(&mut outcome, &world) {
        return outcome;
    }
    let judging = Judging { test, solid };
    for _ in 0..test.steps(test.closing.seconds) {
        world.step();
        let counts = test.criterion.measured_from == MeasuredFrom::File;
        if judging.fails(&mut outcome, &world, None, counts) {
            return outcome;
        }
    }
    let forces = test.loads.directions.iter().map(|direction| {
        let [x, y, z] = *direction;
        let direction = match test.loads.frame {
            Axes::Object => Vector3::new(x, y, z),
            Axes::Palm => {
                let [first, second, third] = closed.palm_axes;
                first * x + second * y + third * z
            }
        };
        direction.normalize() * (test.loads.acceleration_m_s2 * mass_kg)
    });
    let forces: Vec<Vector3<f64>> = forces.collect();
    let trials = forces.chunks(test.loads.together);
    let (mut open, mut lacking) = (trials.len(), test.loads.needed.of(trials.len()));
    let (mut held, mut failed) = (outcome, None::<Outcome>);
    for trial in trials {
        let found = judging.trial(&world, outcome, trial);
        open -= 1;
        let kept = if found.is_stable() {
            lacking -= 1;
            &mut held
        } else {
            failed.get_or_insert(found)
        };
        kept.displacement_m = kept.displacement_m.max(found.displacement_m);
        kept.turn_rad = kept.turn_rad.max(found.turn_rad);
        if lacking == 0 {
            return held;
        }
        if open < lacking {
            break;
        }
    }
    let failed = failed.unwrap_or(held);
    Outcome {
        displacement_m: failed.displacement_m.max(held.displacement_m),
        turn_rad: failed.turn_rad.max(held.turn_rad),
        ..failed
    }
}

struct Judging<'a> {
    test: &'a LoadTest,
    solid: &'a Solid,
}

impl Judging<'_> {
    /// One trial, which begins with the closed hand. `before` has the motions until then.
    fn trial(&self, closed: &World, before: Outcome, forces: &[Vector3<f64>]) -> Outcome {
        let Self { test, solid } = self;
        let mut outcome = before;
        let mut world = closed.fork();
        let from = |world: &World, of: MeasuredFrom| match of {
            MeasuredFrom::File => None,
            MeasuredFrom::Closed | MeasuredFrom::Load => Some(world.object_pose()),
        };
        let mut start = from(&world, test.criterion.measured_from);
        for (number, force) in forces.iter().enumerate() {
            if number > 0 {
                world.push_object(&Vector3::zeros());
                for _ in 0..test.steps(test.loads.pause_s) {
                    world.step();
                    if self.fails(&mut outcome, &world, start.as_ref(), true) {
                        return outcome;
                    }
                }
                if test.criterion.measured_from == MeasuredFrom::Load {
                    start = Some(world.object_pose());
                }
            }
            world.push_object(force);
            let mut watch = Watch::new(solid, &test.rest, test.solver.time_step_s);
            for _ in 0..test.steps(test.loads.seconds) {
                world.step();
                if self.fails(&mut outcome, &world, start.as_ref(), true) {
                    return outcome;
                }
                if watch.rests(world.object_pose()) {
                    break;
                }
            }
        }
        if !holds(test.criterion.contact, &world) {
            outcome.reason = Reason::Released;
        }
        outcome
    }

    /// Records the motion of the object from `start`, or from its pose in the file, if it `counts`; returns whether the trial
    /// has failed.
    fn fails(
        &self,
        outcome: &mut Outcome,
        world: &World,
        start: Option<&Isometry3<f64>>,
        counts: bool,
    ) -> bool {
        let (way, turn_rad) = match start {
            None => world.motion(),
            Some(start) => {
                let centre = start * nalgebra::Point3::from(self.solid.centre());
                motion(&(world.object_pose() * start.inverse()), &centre.coords)
            }
        };
        let criterion = &self.test.criterion;
        let beyond = |value: f64, limit: Option<f64>| limit.is_some_and(|limit| value >= limit);
        if !(way.norm().is_finite() && turn_rad.is_finite()) {
            outcome.reason = Reason::Lost;
        } else if counts {
            outcome.displacement_m = outcome.displacement_m.max(way.norm());
            outcome.turn_rad = outcome.turn_rad.max(turn_rad);
            if beyond(outcome.displacement_m, criterion.displacement_m) {
                outcome.reason = Reason::Moved;
            } else if beyond(outcome.turn_rad, criterion.turn_rad) {
                outcome.reason = Reason::Turned;
            }
        }
        outcome.reason != Reason::Held
    }
}

/// Whether what must press at the end presses.
fn holds(contact: EndContact, world: &World) -> bool {
    let parts = || world.pressing_parts();
    match contact {
        EndContact::None => true,
        EndContact::Hand => !parts().is_empty(),
        EndContact::Digits => parts().iter().filter(|&&digit| digit > 0).count() >= 2,
    }
}
