//! Ways between two grasps, driven by the joints of the hand: does the object follow?

use nalgebra::{Point3, Vector3};

use super::closing::closed;
use super::driven_hand::{DrivenHand, add_hand};
use super::judge::{Outcome, Reason, overlaps};
use super::load_test::{Closing, ClosingRule, LoadTest};
use super::settings::{Solver, count};
use super::solid::Solid;
use super::world::World;
use crate::grasp::Grasp;
use crate::hand::Hand;
use crate::space::{Pose, PoseSpace, Space, Symmetry, object_from_hand, pose_coordinates};

/// An object that nothing has touched for this time has left the hand, seconds: in free fall it drops by 0.3 m, as in the
/// drop test.
const LEFT_S: f64 = 0.25;
const STANDARD_GRAVITY_M_S2: f64 = 9.81;
/// Time between recorded moments, seconds.
const RECORDED_S: f64 = 0.05;

/// How a way is driven. The root of the hand is fixed, springs drive its joints along the way, and the object is free.
///
/// A way is a sequence of poses of the hand in the object's frame. Its joints are targets at a constant speed; the pose of the object
/// in the hand, which the way changes as well, is nobody's target: the object must follow.
///
/// ```text
/// target(s) = θ(s) + Jᵀf(s)/k
/// ```
///
/// θ: joint coordinates of the way at the length s; f: contact forces of [`ClosingRule::Squeeze`] at the contacts of the
/// nearest points, linear between them; k: stiffness. With [`ClosingRule::None`] there is no second part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Replay {
    /// Coefficient of Coulomb friction between hand and object.
    pub friction: f64,
    /// Gravity on the object once the hand has closed, m/s², in the axes of [`Axes::Palm`](super::Axes::Palm). The hand bears
    /// its own weight.
    pub gravity_m_s2: [f64; 3],
    /// Springs, squeeze, and the time before the way begins.
    pub closing: Closing,
    /// Length of the way in the metric of poses ([`PoseSpace`]) per time, m/s: the root-mean-square motion of the hand's
    /// surface over the object.
    pub speed_m_s: f64,
    /// Time at the last posture, seconds.
    pub hold_s: f64,
    /// Largest distance of the object's centre of mass from its place in the hand at the end of the way, metres …
    pub near_m: f64,
    /// … and largest angle from its orientation there, radians.
    pub near_rad: f64,
    /// The engine.
    pub solver: Solver,
}

impl Default for Replay {
    /// Friction 0.6, no gravity, 20 mm/s, a second at the end, 10 mm and 15°; springs, squeeze of 4 N and steps of
    /// `dexgraspbench`.
    fn default() -> Self {
        let test = LoadTest::default();
        Self {
            friction: test.friction,
            gravity_m_s2: [0.0; 3],
            closing: Closing {
                rule: ClosingRule::Squeeze,
                ..test.closing
            },
            speed_m_s: 0.02,
            hold_s: 1.0,
            near_m: 0.01,
            near_rad: 15_f64.to_radians(),
            solver: test.solver,
        }
    }
}

impl Replay {
    /// Four ways to drive: friction 0.6 and 0.25, each without gravity and with the palm facing down.
    pub fn conditions() -> [Self; 4] {
        let (free, down) = ([0.0; 3], [0.0, 0.0, STANDARD_GRAVITY_M_S2]);
        [(0.6, free), (0.25, free), (0.6, down), (0.25, down)].map(|(friction, gravity_m_s2)| {
            Self {
                friction,
                gravity_m_s2,
                ..Self::default()
            }
        })
    }

    /// The springs and the friction as a test of stability.
    fn test(&self) -> LoadTest {
        LoadTest {
            friction: self.friction,
            closing: self.closing,
            ..LoadTest::default()
        }
    }
}

/// What became of a way.
#[derive(Debug, Clone, PartialEq)]
pub struct Replayed {
    /// [`Reason::Held`] if the object was never out of the hand and ends near its pose at the end of the way; [`Reason::Moved`] or
    /// [`Reason::Turned`] if it ends elsewhere, [`Reason::Released`] if it left the hand.
    pub reason: Reason,
    /// Distance of the object's centre of mass from its place in the hand at the end of the way, metres, after the last step.
    pub off_m: f64,
    /// Angle from its orientation there modulo the object's symmetry, radians.
    pub off_rad: f64,
    /// Duration of the way itself, seconds.
    pub way_s: f64,
    /// What was recorded, in order of time.
    pub moments: Vec<Moment>,
}

/// A recorded moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Time since the start, seconds.
    pub seconds: f64,
    /// Pose of the hand in the object's frame, with its real joint coordinates.
    pub pose: Pose,
}

/// To where the joints are driven.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Time since the start, seconds.
    pub seconds: f64,
    /// Targets of the springs, radians or metres.
    pub joints: Vec<f64>,
}

/// How far apart two poses of a hand are for the object in it: the distance of its centre of mass in the hand, metres, and the
/// least angle between its orientations, radians, modulo its symmetry (whose motions leave the centre where it is).
///
/// # Panics
/// If a pose has fewer than 7 numbers.
pub fn moved_in_hand(symmetry: &Symmetry, centre: &Vector3<f64>, poses: [&[f64]; 2]) -> [f64; 2] {
    let [from, to] = poses.map(|pose| object_from_hand(pose).inverse());
    let centre = Point3::from(*centre);
    let turn = from.rotation.inverse() * to.rotation;
    let angle_rad = match symmetry {
        Symmetry::None => turn.angle(),
        Symmetry::Sphere { .. } => 0.0,
        Symmetry::Axis { direction, .. } => {
            let turned = turn * direction;
            libm::atan2(direction.cross(&turned).norm(), direction.dot(&turned))
        }
        Symmetry::Finite(group) => {
            let copies = group.iter().map(|motion| turn * motion.rotation);
            copies.fold(turn.angle(), |least, copy| least.min(copy.angle()))
        }
    };
    [(to * centre - from * centre).norm(), angle_rad]
}

/// The targets of the joints at the points of a way, and when they are reached.
///
/// # Panics
/// As [`replay`].
pub fn targets(
    hand: &Hand,
    space: &PoseSpace,
    way: &[Grasp],
    solid: &Solid,
    settings: &Replay,
) -> Vec<Target> {
    let plan = Plan::new(hand, space, way, solid, &settings.test());
    let start = way[0].pose.joints();
    let target = |stop: &Stop| {
        let joints = start.iter().zip(&stop.targets);
        Target {
            seconds: settings.closing.seconds + stop.along_m / settings.speed_m_s,
            joints: joints.map(|(start, moved)| start + moved).collect(),
        }
    };
    plan.stops.iter().map(target).collect()
}

/// Drives the hand along a way of at least one grasp.
///
/// # Panics
/// If the way is empty, or a grasp is not one of `hand` and `space`.
pub fn replay(
    hand: &Hand,
    space: &PoseSpace,
    way: &[Grasp],
    solid: &Solid,
    mass_kg: f64,
    settings: &Replay,
) -> Replayed {
    let test = settings.test();
    let start = closed(hand, &way[0], None, solid, &test);
    let plan = Plan::new(hand, space, way, solid, &test);
    let friction = settings.friction;
    let mut world = World::new(solid, mass_kg, [0.0; 3], friction, &settings.solver);
    let driven = add_hand(
        &mut world,
        hand,
        &start.posed,
        (solid, f64::INFINITY),
        &plan.stops[0].targets,
        &settings.closing,
    );
    let steps = |seconds: f64| count(seconds, settings.solver.time_step_s);
    let mut run = Run {
        world,
        driven,
        first: &way[0].pose,
        settings,
        steps: 0,
        apart: 0,
        moments: Vec::new(),
    };
    let way_s = plan.length_m() / settings.speed_m_s;
    let mut outcome = Outcome::START;
    let mut reason = Reason::Held;
    if overlaps(&mut outcome, &run.world) {
        reason = outcome.reason;
    } else {
        run.record();
        reason = reason.then(|| run.wait(steps(settings.closing.seconds)));
        let [x, y, z] = settings.gravity_m_s2;
        let [first, second, third] = start.palm_axes;
        let gravity = first * x + second * y + third * z;
        run.world.push_object(&(gravity * mass_kg));
        let driving = steps(way_s);
        for step in 1..=driving {
            if reason != Reason::Held {
                break;
            }
            let along_m = plan.length_m() * step as f64 / driving as f64;
            let targets = plan.targets(along_m);
            run.driven.aim(&mut run.world, &targets, &settings.closing);
            reason = run.wait(1);
        }
        reason = reason.then(|| run.wait(steps(settings.hold_s)));
    }
    let end = run.pose();
    let symmetry = space.symmetry();
    let [off_m, off_rad] =
        moved_in_hand(symmetry, &solid.centre(), [&way[way.len() - 1].pose, &end]);
    let reason = reason.then(|| {
        if off_m > settings.near_m {
            Reason::Moved
        } else if off_rad > settings.near_rad {
            Reason::Turned
        } else {
            Reason::Held
        }
    });
    Replayed {
        reason,
        off_m,
        off_rad,
        way_s,
        moments: run.moments,
    }
}

impl Reason {
    /// What comes next, unless something failed already.
    fn then(self, next: impl FnOnce() -> Self) -> Self {
        if self == Self::Held { next() } else { self }
    }
}

/// The simulation of a way.
struct Run<'a> {
    world: World,
    driven: DrivenHand,
    first: &'a Pose,
    settings: &'a Replay,
    steps: usize,
    /// Steps in which nothing has touched the object, up to now.
    apart: usize,
    moments: Vec<Moment>,
}

impl Run<'_> {
    /// Makes some steps, until the object leaves the hand.
    fn wait(&mut self, steps: usize) -> Reason {
        let step_s = self.settings.solver.time_step_s;
        for _ in 0..steps {
            self.world.step();
            self.steps += 1;
            let placed = self.world.object_pose();
            if !placed.to_homogeneous().iter().all(|part| part.is_finite()) {
                return Reason::Lost;
            }
            if self.steps.is_multiple_of(count(RECORDED_S, step_s).max(1)) {
                self.record();
            }
            let touched = !self.world.pressing_parts().is_empty();
            self.apart = if touched { 0 } else { self.apart + 1 };
            if self.apart > count(LEFT_S, step_s) {
                return Reason::Released;
            }
        }
        Reason::Held
    }

    /// Pose of the hand in the frame of the object.
    fn pose(&self) -> Pose {
        let now = self.world.object_pose().inverse() * object_from_hand(self.first);
        let joints = self.driven.joints(&self.world, self.first.joints());
        pose_coordinates(&now, &joints).into()
    }

    fn record(&mut self) {
        let moment = Moment {
            seconds: self.steps as f64 * self.settings.solver.time_step_s,
            pose: self.pose(),
        };
        self.moments.push(moment);
    }
}

/// Targets along a way.
struct Plan {
    stops: Vec<Stop>,
}

struct Stop {
    /// Length of the way to here, metres.
    along_m: f64,
    /// Targets relative to the joint coordinates at the start, radians or metres.
    targets: Vec<f64>,
}

impl Plan {
    fn new(hand: &Hand, space: &PoseSpace, way: &[Grasp], solid: &Solid, test: &LoadTest) -> Self {
        let levers_m = &space.metric().joint_levers_m;
        let mut last = way[0].pose.to_vec();
        let (mut along_m, mut moved) = (0.0, vec![0.0; levers_m.len()]);
        let mut stops = Vec::with_capacity(way.len());
        for grasp in way {
            let mut tangent = vec![0.0; space.tangents()];
            along_m += space.log(&last, &grasp.pose, &mut tangent);
            let steps = tangent[6..].iter().zip(levers_m);
            for (moved, (step_m, lever_m)) in moved.iter_mut().zip(steps) {
                *moved += step_m / lever_m;
            }
            last = space.align(&last, &grasp.pose);
            let squeezed = closed(hand, grasp, None, solid, test).targets;
            let targets = moved.iter().zip(squeezed);
            stops.push(Stop {
                along_m,
                targets: targets.map(|(moved, further)| moved + further).collect(),
            });
        }
        Self { stops }
    }

    fn length_m(&self) -> f64 {
        self.stops.last().map_or(0.0, |stop| stop.along_m)
    }

    /// Targets at a length, linear between stops.
    fn targets(&self, along_m: f64) -> Vec<f64> {
        let after = self.stops.partition_point(|stop| stop.along_m < along_m);
        let after = &self.stops[after.min(self.stops.len() - 1)];
        let before = self.stops.iter().rfind(|stop| stop.along_m < along_m);
        let before = before.unwrap_or(after);
        let between_m = after.along_m - before.along_m;
        let share = if between_m > 0.0 {
            ((along_m - before.along_m) / between_m).min(1.0)
        } else {
            1.0
        };
        let pairs = before.targets.iter().zip(&after.targets);
        pairs.map(|(from, to)| from + share * (to - from)).collect()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Translation3, UnitQuaternion};

    use super::*;

    /// A turn of the object about its axis, or of a ball about any axis, changes nothing; another turn does.
    #[test]
    fn an_object_is_where_its_copies_are() {
        let here = pose_coordinates(&Isometry3::identity(), &[]);
        let centre = Vector3::new(0.0, 0.0, 0.05);
        let (about_z, about_x) = (Vector3::z() * 0.7, Vector3::x() * 0.2);
        let moved = |symmetry: &Symmetry, turn: Vector3<f64>| {
            // The object turns about its centre in the hand.
            let turn = UnitQuaternion::from_scaled_axis(turn);
            let hand_from_object =
                Isometry3::from_parts(Translation3::from(centre - turn * centre), turn);
            let there = pose_coordinates(&hand_from_object.inverse(), &[]);
            let [way_m, turn_rad] = moved_in_hand(symmetry, &centre, [&here, &there]);
            assert!(way_m < 1e-12);
            turn_rad
        };
        let axis = Symmetry::Axis {
            point: centre,
            direction: Vector3::z(),
        };
        let half = Symmetry::Finite(vec![Isometry3::rotation(
            Vector3::z() * std::f64::consts::PI,
        )]);
        let near = |turn: f64, expected: f64| (turn - expected).abs() < 1e-9;
        assert!(near(moved(&Symmetry::None, about_z), 0.7));
        assert!(near(moved(&axis, about_z), 0.0) && near(moved(&axis, about_x), 0.2));
        assert!(near(moved(&Symmetry::Sphere { centre }, about_x), 0.0));
        let most = Vector3::z() * (std::f64::consts::PI - 0.1);
        assert!(near(moved(&half, most), 0.1) && near(moved(&half, about_x), 0.2));
    }
}
