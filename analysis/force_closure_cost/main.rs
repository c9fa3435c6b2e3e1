//! Figure 4: the cost of force-closure tests → `figures/force_closure_cost.png`, `figures/force_closure_cost.md`
//!
//! `cargo run --release --example force_closure_cost [-- --quick]` takes a minute or two. Nothing else should run
//! meanwhile.

mod network;
#[path = "../relaxed.rs"]
mod relaxed;

use std::fmt::Write;
use std::hint::black_box;
use std::time::{Duration, Instant};

use landscape::figure::chart::{Axis, Chart, Panel, Series};
use landscape::figure::theme;
use landscape::grasp::closure::{is_force_closure, least_friction};
use landscape::object::{Object, Shape, Sphere};
use landscape::sample::{Task, stream};
use nalgebra::Vector3;
use rand::RngExt;
use relaxed::{RelaxedForceClosure, Touch};

/// Numbers of contacts: those of the paper and two more.
const CONTACTS: [usize; 6] = [3, 5, 10, 20, 100, 1000];
/// Friction of the exact test.
const FRICTION: f64 = 0.5;
const BALL: Sphere = Sphere {
    centre: Vector3::new(0.0, 0.0, 0.0),
    radius_m: 0.04,
};
/// Bottles and the kinds of their fields.
const BOTTLES: [(&str, &str); 2] = [
    ("bottle_round", "round bottle (field in a plane)"),
    ("bottle_square", "square bottle (field in space)"),
];
/// The authors' code in torch on one CPU thread, changed only for device and eigenvalue solver: value and derivative on the
/// analytic sphere, one grasp at a time, and each of a batch of 1024. CPU microseconds, measured by us on another day.
const OFFICIAL: Costs = [537.0, 545.0, 551.0, 550.0, 587.0, 902.0];
const OFFICIAL_BATCH: Costs = [6.94, 7.36, 8.77, 12.3, 33.2, 441.0];
/// Least duration of a batch, long compared with the cost of the clock.
const BATCH: Duration = Duration::from_millis(4);
/// After this time, turns of a slow work end early.
const PATIENCE: Duration = Duration::from_secs(4);

/// Microseconds, one number for each of [`CONTACTS`].
type Costs = [f64; CONTACTS.len()];
/// Contact points.
type Set = Vec<Vector3<f64>>;
/// What is timed on a set: its arguments are the points, alone and with room for answers.
type Work<'a> = dyn Fn(&[Vector3<f64>], &mut [Touch]) -> f64 + 'a;

/// A row of the table.
struct Row {
    name: String,
    costs: Costs,
    /// Name in the picture; empty where the row is not drawn.
    drawn: String,
}

impl Row {
    fn new(name: &str, drawn: &str, costs: Costs) -> Self {
        Self {
            name: name.to_owned(),
            costs,
            drawn: drawn.to_owned(),
        }
    }

    /// The relaxed test on a shape: value alone, and value and derivative.
    fn relaxed(shape: &str, value: Costs, forces: Costs) -> [Self; 2] {
        let drawn = format!("relaxed with derivative, {shape}");
        [
            Self::new(&format!("relaxed, {shape}: value"), "", value),
            Self::new(
                &format!("relaxed, {shape}: value and derivative"),
                &drawn,
                forces,
            ),
        ]
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A network would otherwise use all cores.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1);
    one.build_global()?;
    let quick = std::env::args().any(|argument| argument == "--quick");
    let turns = if quick { 3 } else { 25 };
    let on_ball = CONTACTS.map(contacts_on_ball);
    let test = RelaxedForceClosure::paper(BALL.centre, BALL.radius_m);
    let mut rows = Vec::from(relaxed_on("sphere", &BALL, &test, &on_ball, turns));
    for (name, description) in BOTTLES {
        let bottle = Object::named(name)?;
        let sets = CONTACTS.map(|count| contacts_near(&bottle, count));
        let test = RelaxedForceClosure::of_object(&bottle);
        rows.extend(relaxed_on(description, &*bottle.shape, &test, &sets, turns));
    }
    // A network of the standard size with random weights, which do not change the cost, nor do the places of the points.
    // It answers for all contacts of a set in one batch.
    let field = network::field(BALL.radius_m)?;
    let few = CONTACTS.map(|count| contacts_on_ball(count)[..4].to_vec());
    let value = timed(&few, turns, &|points, _| {
        let answers = points.iter().zip(field.answers(points));
        test.value_of(answers.map(|(point, answer)| (*point, answer.0, answer.1)))
    });
    let forces = timed(&few, turns, &|points, touches| {
        for (touch, answer) in touches.iter_mut().zip(field.answers(points)) {
            (touch.distance_m, touch.gradient, touch.hessian) = answer;
        }
        test.forces(touches)
    });
    rows.extend(Row::relaxed("neural SDF (8 × 512, f32)", value, forces));
    // With ε so large that the rank condition is active.
    let lacking = RelaxedForceClosure {
        rank_epsilon: 1e4,
        ..test
    };
    let lacking = timed(&on_ball, turns, &|_, touches| {
        lacking.value_and_forces(&BALL, touches)
    });
    let contact = |point: &Vector3<f64>| test.contact(point, &BALL.gradient(point).1);
    let closure = timed(&on_ball, turns, &|points, _| {
        let contacts: Vec<_> = points.iter().map(contact).collect();
        f64::from(is_force_closure(&contacts, FRICTION))
    });
    let friction = timed(&on_ball, turns, &|points, _| {
        least_friction(&points.iter().map(contact).collect::<Vec<_>>())
    });
    // The line through the published costs on an RTX 3090, Liu et al. (2021), Fig. 4.
    let published = CONTACTS.map(|n| 1e3 * (0.107 * libm::log10(n as f64) + 1.502));
    let name = "relaxed, sphere, rank condition active: value and derivative";
    rows.push(Row::new(name, "", lacking));
    for (name, drawn, costs) in [
        (
            "exact: force closure at μ = 0.5",
            "exact: force closure at 0.5",
            closure,
        ),
        (
            "exact: least friction μ₀",
            "exact: least friction",
            friction,
        ),
        (
            "paper (RTX 3090): 0.107 log₁₀ n + 1.502 ms",
            "paper, RTX 3090",
            published,
        ),
        (
            "official code, CPU: value and derivative",
            "official code, CPU",
            OFFICIAL,
        ),
        (
            "official code, CPU, each of a batch of 1024: value and derivative",
            "official code, CPU, one of a batch of 1024",
            OFFICIAL_BATCH,
        ),
    ] {
        rows.push(Row::new(name, drawn, costs));
    }
    let chart = Chart {
        legend_below: true,
        ..Chart::new("", vec![panel(&rows)])
    };
    (chart.draw()?).save("figures/force_closure_cost.png".as_ref())?;
    std::fs::write("figures/force_closure_cost.md", text(&rows))?;
    Ok(())
}

/// Costs of a work on one set: the fastest of some turns over all sets, because other load on the machine only adds time.
fn timed(sets: &[Vec<Set>; CONTACTS.len()], turns: usize, work: &Work<'_>) -> Costs {
    sets.each_ref().map(|sets| {
        let touches = |points: &Set| points.iter().copied().map(Touch::at).collect();
        let mut touches: Vec<Vec<Touch>> = sets.iter().map(touches).collect();
        let begin = Instant::now();
        let mut least_s = f64::INFINITY;
        for turn in 0..turns {
            if turn > 0 && begin.elapsed() > PATIENCE {
                break;
            }
            let (begin, mut rounds) = (Instant::now(), 0);
            while rounds == 0 || begin.elapsed() < BATCH {
                for (points, touches) in sets.iter().zip(&mut touches) {
                    black_box(work(black_box(points), black_box(touches)));
                }
                rounds += 1;
            }
            least_s = least_s.min(begin.elapsed().as_secs_f64() / f64::from(rounds));
        }
        1e6 * least_s / sets.len() as f64
    })
}

fn relaxed_on<S: Shape + ?Sized>(
    name: &str,
    shape: &S,
    test: &RelaxedForceClosure,
    sets: &[Vec<Set>; CONTACTS.len()],
    turns: usize,
) -> [Row; 2] {
    eprintln!("relaxed test on {name}");
    let value = timed(sets, turns, &|points, _| test.value(shape, points));
    let forces = timed(sets, turns, &|_, touches| {
        test.value_and_forces(shape, touches)
    });
    Row::relaxed(name, value, forces)
}

/// Several sets of contacts, so that no cost depends on a single set.
fn sets(count: usize, mut point: impl FnMut() -> Vector3<f64>) -> Vec<Set> {
    let sets = (2000 / count).clamp(4, 64);
    (0..sets)
        .map(|_| (0..count).map(|_| point()).collect())
        .collect()
}

/// Contacts all over the ball.
fn contacts_on_ball(count: usize) -> Vec<Set> {
    let mut rng = stream(0, Task::Start, 0);
    sets(count, || {
        loop {
            let point = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
            if (0.01..1.0).contains(&point.norm_squared()) {
                return BALL.radius_m * point.normalize();
            }
        }
    })
}

/// Contacts within 2 mm of the object's surface.
fn contacts_near(object: &Object, count: usize) -> Vec<Set> {
    let mut rng = stream(0, Task::Start, 1);
    sets(count, || {
        let sample = &object.surface_samples[rng.random_range(0..object.surface_samples.len())];
        sample.point + sample.normal * rng.random_range(-0.002..0.002)
    })
}

fn panel(rows: &[Row]) -> Panel {
    let mut series = Vec::new();
    let drawn = rows.iter().filter(|row| !row.drawn.is_empty());
    for (place, row) in drawn.enumerate() {
        let costs = CONTACTS.iter().zip(row.costs);
        let points: Vec<[f64; 2]> = costs.map(|(&n, cost)| [n as f64, cost]).collect();
        let colour = theme::series(place);
        let line = Series::line(points.clone()).named(&row.drawn);
        if row.name.starts_with("paper") || row.name.starts_with("official") {
            series.push(line.coloured(colour).dashed());
        } else {
            let points = Series::points(points).named(&row.drawn);
            series.extend([line, points].map(|series| series.coloured(colour)));
        }
    }
    Panel::new(
        "cost of one test",
        Axis::logarithmic("contacts n"),
        Axis::logarithmic("time (µs)"),
        series,
    )
}

fn text(rows: &[Row]) -> String {
    let mut text = format!(
        "# What force-closure tests cost\n\nWritten by `cargo run --release --example force_closure_cost`; \
         timings differ from run to run. One core. Contacts are spread at random over the sphere, or within 2 mm of \
         a bottle; each number is the mean over many sets in the fastest of up to 25 turns.\n\n\
         ## Costs (µs)\n\n| test | {} |\n|---|{}\n",
        CONTACTS.map(|n| format!("n = {n}")).join(" | "),
        "---:|".repeat(CONTACTS.len())
    );
    for row in rows {
        let cells = row.costs.map(|cost| match cost {
            cost if cost < 10.0 => format!("{cost:.3}"),
            cost if cost < 1000.0 => format!("{cost:.1}"),
            cost => format!("{cost:.0}"),
        });
        let _ = writeln!(text, "| {} | {} |", row.name, cells.join(" | "));
    }
    text
}
