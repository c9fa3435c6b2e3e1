//! Widened fixtures: the scenes of the authored ones with objects of other sizes and forms, and with other hands.

use std::path::Path;
use std::sync::Arc;

use landscape::evaluation::taxonomy::{Form, Taxonomy};
use landscape::hand::{Hand, HandFiles};
use landscape::object::{Capsule, Cuboid, Cylinder, Primitive};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::fixture::Fixture;

/// A hand of the widened fixtures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum HandName {
    /// The human hand of the project.
    Human,
    /// The same bones 12 % smaller, without the side file that names digits and regions.
    SmallHuman,
    /// The Shadow hand of the test data (`hands/dex_urdf`, Apache 2.0).
    Shadow,
    /// The hand of the test data with MANO's bones and joints (`hands/mano`, CC BY-NC 4.0).
    Mano,
}

/// Size of the small human hand.
const SMALL: f64 = 0.88;

impl HandName {
    pub(crate) const ALL: [Self; 4] = [Self::Human, Self::SmallHuman, Self::Shadow, Self::Mano];

    /// The hand; `None` for one of the test data, if `LANDSCAPE_TEST_DATA` does not name them.
    pub(crate) fn hand(self) -> Option<Arc<Hand>> {
        let hand = match self {
            Self::Human => Hand::human(),
            Self::SmallHuman => {
                let human = HandFiles::named("human").ok()?;
                let urdf = scaled_urdf(&human.files.first()?.text, SMALL);
                Hand::from_files(&HandFiles::of_texts([["hand", &urdf]])).ok()?
            }
            Self::Shadow => of_test_data("hands/dex_urdf/shadow_hand/shadow_hand_right.urdf")?,
            Self::Mano => of_test_data("hands/mano/mano_right.xml")?,
        };
        Some(Arc::new(hand))
    }
}

fn of_test_data(path: &str) -> Option<Hand> {
    let data = std::env::var_os("LANDSCAPE_TEST_DATA")?;
    let files = HandFiles::load(&Path::new(&data).join(path)).ok()?;
    Hand::from_files(&files).ok()
}

/// The description with all its lengths multiplied.
fn scaled_urdf(text: &str, factor: f64) -> String {
    let mut scaled = String::with_capacity(text.len());
    let mut rest = text;
    let lengths = ["origin xyz=\"", "radius=\"", "length=\""];
    loop {
        let next = lengths
            .iter()
            .filter_map(|key| Some((rest.find(key)?, key.len())));
        let Some((start, length)) = next.min() else {
            return scaled + rest;
        };
        let (before, after) = rest.split_at(start + length);
        let end = after.find('"').unwrap_or(after.len());
        let (numbers, after) = after.split_at(end);
        scaled += before;
        let numbers = numbers
            .split_whitespace()
            .map(|number| match number.parse::<f64>() {
                Ok(length) => format!("{}", factor * length),
                Err(_) => number.to_owned(),
            });
        scaled += &numbers.collect::<Vec<_>>().join(" ");
        rest = after;
    }
}

/// A widened fixture. Object and type are those of the fixture `of`, see [`object`].
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Widened {
    /// Id of the authored fixture.
    pub(crate) of: String,
    pub(crate) hand: HandName,
    /// Factor on the size of the object.
    pub(crate) scale: f64,
    /// Whether the form is another one: a round rod has become square or a square one round, a ball has become longer.
    pub(crate) reshaped: bool,
    /// Pose `[t, q(wxyz), joints]` of the hand, object frame.
    pub(crate) x: Vec<f64>,
}

/// Length of an egg beyond that of the ball, as a share of the radius.
const EGG: f64 = 0.3;
/// A rod is longer than this many diameters.
const ROD: f64 = 1.2;
/// A square rod's sides differ by less than this factor.
const SQUARE: f64 = 1.4;

/// The object of a fixture with another size and, if possible, another form.
pub(crate) fn object(base: &Fixture, scale: f64, reshaped: bool) -> Vec<Primitive> {
    let scaled = base.object.iter().map(|solid| sized(solid, scale));
    let mut solids: Vec<Primitive> = scaled.collect();
    if reshaped && let Some(other) = reshape(base.kind, &solids) {
        solids = vec![other];
    }
    solids
}

fn sized(solid: &Primitive, scale: f64) -> Primitive {
    let mut solid = *solid;
    match &mut solid {
        Primitive::Sphere(sphere) => {
            sphere.centre *= scale;
            sphere.radius_m *= scale;
        }
        Primitive::Cuboid(cuboid) => {
            cuboid.centre *= scale;
            cuboid.half_extents *= scale;
            cuboid.edge_radius_m *= scale;
        }
        Primitive::Cylinder(cylinder) => {
            cylinder.centre *= scale;
            cylinder.radius_m *= scale;
            cylinder.half_height_m *= scale;
            cylinder.edge_radius_m *= scale;
        }
        Primitive::Capsule(capsule) => {
            capsule.a *= scale;
            capsule.b *= scale;
            capsule.radius_m *= scale;
        }
    }
    solid
}

fn reshape(kind: Option<u8>, solids: &[Primitive]) -> Option<Primitive> {
    let [solid] = solids else { return None };
    let entry = Taxonomy::feix().numbered(kind?)?;
    let holds = |form: Form| entry.forms.contains(&form);
    match solid {
        Primitive::Sphere(ball) => Some(Primitive::Capsule(Capsule {
            a: ball.centre - Vector3::z() * (0.5 * EGG * ball.radius_m),
            b: ball.centre + Vector3::z() * (0.5 * EGG * ball.radius_m),
            radius_m: ball.radius_m,
        })),
        Primitive::Cylinder(rod)
            if rod.axis.z.abs() > 0.99
                && rod.half_height_m > ROD * rod.radius_m
                && holds(Form::Box) =>
        {
            Some(Primitive::Cuboid(Cuboid {
                centre: rod.centre,
                half_extents: Vector3::new(rod.radius_m, rod.radius_m, rod.half_height_m),
                edge_radius_m: (0.2 * rod.radius_m).min(0.003),
            }))
        }
        Primitive::Cuboid(square) => {
            let [a, b, long] = square.half_extents.into();
            let rod = a.max(b) < SQUARE * a.min(b) && long > ROD * a.max(b);
            (rod && holds(Form::Rod)).then(|| {
                Primitive::Cylinder(Cylinder {
                    centre: square.centre,
                    axis: Vector3::z_axis(),
                    radius_m: 0.5 * (a + b),
                    half_height_m: long,
                    edge_radius_m: (0.1 * (a + b)).min(0.001),
                })
            })
        }
        _ => None,
    }
}
