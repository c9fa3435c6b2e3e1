//! Figure 4: what force-closure tests cost → `figures/force_closure_cost.png`, `figures/force_closure_cost.md`
//!
//! `cargo run --release --example force_closure_cost [-- --quick]`, about a minute; nothing else should run meanwhile.

use landscape::grasp::closure::{is_force_closure, least_friction};
use landscape::grasp::object::{Object, Shape, Sphere};
use landscape::grasp::relaxed::{RelaxedForceClosure, Touch};
use landscape::sample::{Task, stream};
use nalgebra::Vector3;
use rand::RngExt;

mod fit;
#[path = "../line.rs"]
mod line;
mod network;
mod picture;
mod report;
mod timing;

use timing::{Clock, Set, Work};

/// Numbers of contacts: those of the paper and two more.
const CONTACTS: [usize; 6] = [3, 5, 10, 20, 100, 1000];
/// Friction of the exact test.
const FRICTION: f64 = 0.5;
const RADIUS_M: f64 = 0.04;
/// Bottles and what kind of field they have.
const BOTTLES: [(&str, &str); 2] = [
    ("bottle_round", "round bottle (field in a plane)"),
    ("bottle_square", "square bottle (field in space)"),
];

/// Seconds, one number for each of [`CONTACTS`].
type Costs = Vec<f64>;

/// What the relaxed test costs on one shape.
struct Relaxed {
    shape: &'static str,
    /// FC alone.
    value: Costs,
    /// FC and its derivative by every contact point.
    forces: Costs,
    /// Of `value`: distances and normals.
    normals: Costs,
    /// Of `forces`: distances, normals and curvature.
    answers: Costs,
}

/// Everything measured.
struct Measured {
    relaxed: Vec<Relaxed>,
    /// On the sphere, with ε so large that the rank condition is active: FC and its derivative.
    lacking_rank: Costs,
    /// On the sphere, of `forces`: the sums over contacts and the rank check.
    sums: Costs,
    force_closure: Costs,
    least_friction: Costs,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A network would use all cores.
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()?;
    let clock = Clock {
        batches: if std::env::args().any(|argument| argument == "--quick") {
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
    let mut relaxed = vec![relaxed_on("sphere", &ball, &test, &on_ball, clock)];
    for (name, description) in BOTTLES {
        let bottle = Object::named(name)?;
        let sets: Vec<_> = CONTACTS
            .iter()
            .map(|&n| contacts_near(&bottle, n))
            .collect();
        let test = RelaxedForceClosure::of_object(&bottle);
        relaxed.push(relaxed_on(description, &*bottle.shape, &test, &sets, clock));
    }
    relaxed.push(relaxed_on_network(&test, &on_ball, clock)?);
    let measured = Measured {
        relaxed,
        ..exact_on_ball(&ball, &test, &on_ball, clock)
    };
    picture::draw(&measured)?.save("figures/force_closure_cost.png".as_ref())?;
    std::fs::write("figures/force_closure_cost.md", report::text(&measured))?;
    Ok(())
}

/// Contacts all over the ball; several sets, so that no cost is that of a lucky one.
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

fn relaxed_on<S: Shape + ?Sized>(
    name: &'static str,
    shape: &S,
    test: &RelaxedForceClosure,
    sets: &[Vec<Set>],
    clock: Clock,
) -> Relaxed {
    let each =
        |work: Work<'_>| -> Costs { sets.iter().map(|sets| clock.over(sets, work)).collect() };
    eprintln!("relaxed test on {name}");
    Relaxed {
        shape: name,
        value: each(&|points, _| test.value(shape, points)),
        forces: each(&|_, touches| test.value_and_forces(shape, touches)),
        normals: each(&|points, _| points.iter().map(|point| shape.gradient(point).1.x).sum()),
        answers: each(&|_, touches| {
            for touch in &mut *touches {
                touch.measure(shape);
            }
            touches[0].distance_m
        }),
    }
}

/// The relaxed test on a neural signed distance of the standard size. Its weights are made up, which changes no cost.
fn relaxed_on_network(
    test: &RelaxedForceClosure,
    sets: &[Vec<Set>],
    clock: Clock,
) -> Result<Relaxed, Box<dyn std::error::Error>> {
    let field = network::field(RADIUS_M)?;
    // All contacts of a set in one batch.
    let measure = |touches: &mut [Touch]| {
        let points: Vec<Vector3<f64>> = touches.iter().map(|touch| touch.point).collect();
        for (touch, answer) in touches.iter_mut().zip(field.answers(&points)) {
            (touch.distance_m, touch.gradient, touch.hessian) = answer;
        }
    };
    let each =
        |work: Work<'_>| -> Costs { sets.iter().map(|sets| clock.over(sets, work)).collect() };
    eprintln!("relaxed test on a network");
    let answers = each(&|_, touches| {
        measure(touches);
        touches[0].distance_m
    });
    Ok(Relaxed {
        shape: "neural SDF (8 × 512, f32)",
        value: each(&|points, _| {
            let answers = field.answers(points).into_iter();
            test.value_of(
                points
                    .iter()
                    .zip(answers)
                    .map(|(point, answer)| (*point, answer.0, answer.1)),
            )
        }),
        forces: each(&|_, touches| {
            measure(touches);
            test.forces(touches)
        }),
        // A network tells gradient and curvature at once.
        normals: answers.clone(),
        answers,
    })
}

/// What is measured on the ball only, with nothing in `relaxed`.
fn exact_on_ball(
    ball: &Sphere,
    test: &RelaxedForceClosure,
    sets: &[Vec<Set>],
    clock: Clock,
) -> Measured {
    let lacking = RelaxedForceClosure {
        rank_epsilon: 1e4,
        ..*test
    };
    let contacts = |points: &[Vector3<f64>]| {
        points
            .iter()
            .map(|point| test.contact(point, &ball.gradient(point).1))
            .collect::<Vec<_>>()
    };
    let each = |name: &str, work: Work<'_>| -> Costs {
        eprintln!("{name}");
        sets.iter().map(|sets| clock.over(sets, work)).collect()
    };
    Measured {
        relaxed: Vec::new(),
        lacking_rank: each("relaxed test, lacking rank", &|_, touches| {
            lacking.value_and_forces(ball, touches)
        }),
        sums: each("sums", &|points, _| {
            // On the ball a point is its own gradient, so that this measures no shape.
            test.value_of(points.iter().map(|&point| (point, 0.0, point)))
        }),
        force_closure: each("exact force closure", &|points, _| {
            f64::from(is_force_closure(&contacts(points), FRICTION))
        }),
        least_friction: each("least friction", &|points, _| {
            least_friction(&contacts(points))
        }),
    }
}
