//! Figure 4: the cost of force-closure tests → `figures/force_closure_cost.png`, `figures/force_closure_cost.md`
//!
//! `cargo run --release --example force_closure_cost [-- --quick]` takes a minute or two. Nothing else should run
//! meanwhile.

use landscape::grasp::closure::{is_force_closure, least_friction};
use landscape::object::{Object, Shape, Sphere};
use landscape::sample::{Task, stream};
use nalgebra::Vector3;
use rand::RngExt;
use relaxed::{RelaxedForceClosure, Touch};

mod fit;
#[path = "../line.rs"]
mod line;
mod network;
mod picture;
#[path = "../relaxed.rs"]
mod relaxed;
mod report;
mod timing;

use timing::{Clock, Set, Share, Turns, Work};

/// Numbers of contacts: those of the paper and two more.
const CONTACTS: [usize; 6] = [3, 5, 10, 20, 100, 1000];
/// Friction of the exact test.
const FRICTION: f64 = 0.5;
const RADIUS_M: f64 = 0.04;
/// Bottles and the kinds of their fields.
const BOTTLES: [(&str, &str); 2] = [
    ("bottle_round", "round bottle (field in a plane)"),
    ("bottle_square", "square bottle (field in space)"),
];

/// Seconds, one number for each of [`CONTACTS`].
type Costs = Vec<f64>;

/// Costs of the relaxed test on one shape.
struct Relaxed {
    shape: &'static str,
    /// FC alone.
    value: Costs,
    /// FC and its derivative with respect to all contact points.
    forces: Costs,
    /// Distances, normals and curvature as a share of `forces`.
    answers_share: Vec<Share>,
}

impl Relaxed {
    /// From the turns of these works, for each of [`CONTACTS`]: value, forces, and complete answers of the shape.
    fn of(shape: &'static str, turns: &[Turns]) -> Self {
        Self {
            shape,
            value: costs(turns, 0),
            forces: costs(turns, 1),
            answers_share: turns.iter().map(|turns| turns.share(2, 1)).collect(),
        }
    }
}

/// Costs of one of the works.
fn costs(turns: &[Turns], work: usize) -> Costs {
    turns.iter().map(|turns| turns.least(work)).collect()
}

/// Everything measured.
struct Measured {
    relaxed: Vec<Relaxed>,
    /// FC and its derivative on the sphere, with ε so large that the rank condition is active.
    lacking_rank: Costs,
    force_closure: Costs,
    least_friction: Costs,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A network would otherwise use all cores.
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()?;
    let clock = Clock {
        turns: if std::env::args().any(|argument| argument == "--quick") {
            3
        } else {
            25
        },
    };
    let ball = Sphere {
        centre: Vector3::zeros(),
        radius_m: RADIUS_M,
    };
    let test = RelaxedForceClosure::paper(ball.centre, RADIUS_M);
    let on_ball: Vec<_> = CONTACTS.iter().map(|&n| contacts_on_ball(n)).collect();
    let lacking = RelaxedForceClosure {
        rank_epsilon: 1e4,
        ..test
    };
    let turns = relaxed_on(
        "sphere",
        &ball,
        &test,
        &on_ball,
        clock,
        &[&|_, touches| lacking.value_and_forces(&ball, touches)],
    );
    let lacking_rank = costs(&turns, 3);
    let mut relaxed = vec![Relaxed::of("sphere", &turns)];
    for (name, description) in BOTTLES {
        let bottle = Object::named(name)?;
        let sets: Vec<_> = CONTACTS
            .iter()
            .map(|&n| contacts_near(&bottle, n))
            .collect();
        let test = RelaxedForceClosure::of_object(&bottle);
        let turns = relaxed_on(description, &*bottle.shape, &test, &sets, clock, &[]);
        relaxed.push(Relaxed::of(description, &turns));
    }
    relaxed.push(relaxed_on_network(&test, &on_ball, clock)?);
    let contacts = |points: &[Vector3<f64>]| {
        points
            .iter()
            .map(|point| test.contact(point, &ball.gradient(point).1))
            .collect::<Vec<_>>()
    };
    eprintln!("exact tests");
    let exact = |work: Work<'_>| -> Costs {
        let cost = |sets: &Vec<Set>| clock.over(sets, &[work]).least(0);
        on_ball.iter().map(cost).collect()
    };
    let measured = Measured {
        relaxed,
        lacking_rank,
        force_closure: exact(&|points, _| f64::from(is_force_closure(&contacts(points), FRICTION))),
        least_friction: exact(&|points, _| least_friction(&contacts(points))),
    };
    picture::draw(&measured)?.save("figures/force_closure_cost.png".as_ref())?;
    std::fs::write("figures/force_closure_cost.md", report::text(&measured))?;
    Ok(())
}

/// Contacts all over the ball. Several sets are used, so that no cost depends on a single set.
fn contacts_on_ball(count: usize) -> Vec<Set> {
    let mut rng = stream(0, Task::Start, 0);
    let mut point = || loop {
        let point = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        if (0.01..1.0).contains(&point.norm_squared()) {
            return RADIUS_M * point.normalize();
        }
    };
    (0..sets(count))
        .map(|_| (0..count).map(|_| point()).collect())
        .collect()
}

/// Contacts within 2 mm of the object's surface.
fn contacts_near(object: &Object, count: usize) -> Vec<Set> {
    let mut rng = stream(0, Task::Start, 1);
    let mut point = || {
        let sample = &object.surface_samples[rng.random_range(0..object.surface_samples.len())];
        sample.point + sample.normal * rng.random_range(-0.002..0.002)
    };
    (0..sets(count))
        .map(|_| (0..count).map(|_| point()).collect())
        .collect()
}

fn sets(contacts: usize) -> usize {
    (2000 / contacts).clamp(4, 64)
}

/// Turns of the relaxed test: its parts in the order of [`Relaxed::of`], and `others`.
fn relaxed_on<S: Shape + ?Sized>(
    name: &str,
    shape: &S,
    test: &RelaxedForceClosure,
    sets: &[Vec<Set>],
    clock: Clock,
    others: &[Work<'_>],
) -> Vec<Turns> {
    eprintln!("relaxed test on {name}");
    let works: [Work<'_>; 3] = [
        &|points, _| test.value(shape, points),
        &|_, touches| test.value_and_forces(shape, touches),
        &|_, touches| {
            for touch in &mut *touches {
                touch.measure(shape);
            }
            touches[0].distance_m
        },
    ];
    let works = [&works, others].concat();
    sets.iter().map(|sets| clock.over(sets, &works)).collect()
}

/// The relaxed test on a neural signed distance of the standard size. Its weights are random, which does not change the
/// cost.
fn relaxed_on_network(
    test: &RelaxedForceClosure,
    sets: &[Vec<Set>],
    clock: Clock,
) -> Result<Relaxed, Box<dyn std::error::Error>> {
    let field = network::field(RADIUS_M)?;
    // All contacts of a set are evaluated in one batch.
    let measure = |touches: &mut [Touch]| {
        let points: Vec<Vector3<f64>> = touches.iter().map(|touch| touch.point).collect();
        for (touch, answer) in touches.iter_mut().zip(field.answers(&points)) {
            (touch.distance_m, touch.gradient, touch.hessian) = answer;
        }
    };
    eprintln!("relaxed test on a network");
    let works: [Work<'_>; 3] = [
        &|points, _| {
            let answers = field.answers(points).into_iter();
            test.value_of(
                points
                    .iter()
                    .zip(answers)
                    .map(|(point, answer)| (*point, answer.0, answer.1)),
            )
        },
        &|_, touches| {
            measure(touches);
            test.forces(touches)
        },
        &|_, touches| {
            measure(touches);
            touches[0].distance_m
        },
    ];
    let turns: Vec<Turns> = sets
        .iter()
        // The places of the points do not change the cost.
        .map(|sets| clock.over(&sets[..4], &works))
        .collect();
    Ok(Relaxed::of("neural SDF (8 × 512, f32)", &turns))
}
