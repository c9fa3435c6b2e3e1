//! Objects that are too large or too small for a hand.

use landscape::hand::Hand;
use landscape::object::{Assembly, Cuboid, Object, Primitive, Sphere};
use landscape::study::doubted_size;
use nalgebra::Vector3;

use crate::desk::{Desk, assert_says};

fn object(part: Primitive) -> Object {
    let assembly = Assembly {
        parts: vec![part],
        ..Assembly::default()
    };
    let (mesh, description) = assembly.object("thing").unwrap();
    Object::from_mesh("thing", mesh, &description).unwrap()
}

fn ball(radius_m: f64) -> Object {
    let centre = Vector3::zeros();
    object(Primitive::Sphere(Sphere { centre, radius_m }))
}

fn cuboid(sides_m: [f64; 3]) -> Object {
    object(Primitive::Cuboid(Cuboid {
        centre: Vector3::zeros(),
        half_extents: Vector3::from(sides_m) / 2.0,
        edge_radius_m: 0.001,
    }))
}

#[test]
fn only_what_is_wide_everywhere_is_too_large() {
    let hand = Hand::human();
    let found = doubted_size(&hand, &ball(0.15), 1.0).unwrap();
    let said = found.doubt.to_string();
    assert!(found.sure, "{said}");
    for words in [
        "mm wide where it is narrowest",
        "human hand spans at most",
        "--scale 0.1 makes it 30 mm",
    ] {
        assert!(said.contains(words), "{said}");
    }
    let cube = doubted_size(&hand, &cuboid([0.4; 3]), 0.01).unwrap();
    assert!(cube.sure && cube.doubt.remedy.contains("--scale 0.001"));
    // A plate is held at its edge.
    assert_eq!(doubted_size(&hand, &cuboid([0.3, 0.3, 0.02]), 1.0), None);
    for name in ["mug", "bottle_round", "ball"] {
        assert_eq!(
            doubted_size(&hand, &Object::named(name).unwrap(), 1.0),
            None
        );
    }
}

#[test]
fn what_is_thinner_than_a_finger_all_around_is_doubted() {
    let found = doubted_size(&Hand::human(), &ball(0.0015), 1.0).unwrap();
    let said = found.doubt.to_string();
    assert!(
        !found.sure && said.contains("3.0 mm") && said.contains("--scale 10"),
        "{said}"
    );
    assert_eq!(doubted_size(&Hand::human(), &ball(0.015), 1.0), None);
}

/// The search is not begun, unless all its ends are wanted.
#[test]
fn what_no_hand_can_span_is_refused_before_the_search() {
    let desk = Desk::empty();
    let shape = "[[parts]]\nsphere = { centre = [0, 0, 0], radius_m = 0.15 }\n";
    desk.write("large.toml", shape);
    assert_says(
        &desk.mistake("synth --object large.toml -o large.parquet"),
        &[
            "mm wide where it is narrowest",
            "human hand spans",
            "--scale 0.1",
        ],
    );
    let output = desk.run("synth --object large.toml -n 1 --steps 1 --keep all -o large.parquet");
    assert!(output.status.success());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_says(&said, &["warning: large: it is ", "mm wide"]);
}
