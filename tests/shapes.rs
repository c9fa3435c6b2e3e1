//! Every shape: its gradient and Hessian are the derivatives of its distance everywhere.
#![cfg(feature = "grasp")]

use std::sync::LazyLock;

use landscape::mesh::{ExactMesh, Mesh};
use landscape::object::{
    Capsule, Cuboid, Cylinder, Field, FieldSettings, Object, Revolved, Shape, Sphere,
};
use nalgebra::{Matrix3, Unit, Vector3};
use proptest::prelude::*;

/// The tested shapes. A new shape needs one line here.
fn shapes() -> Vec<(&'static str, &'static dyn Shape)> {
    vec![
        ("sphere", &*SPHERE),
        ("capsule", &*CAPSULE),
        ("cuboid", &*CUBOID),
        ("cylinder", &*CYLINDER),
        ("field", &*FIELD),
        ("revolved", &*REVOLVED),
    ]
}

static SPHERE: LazyLock<Sphere> = LazyLock::new(|| Sphere {
    centre: Vector3::new(0.01, -0.02, 0.03),
    radius_m: 0.035,
});
static CAPSULE: LazyLock<Capsule> = LazyLock::new(|| Capsule {
    a: Vector3::new(0.0, 0.01, -0.02),
    b: Vector3::new(0.02, 0.0, 0.05),
    radius_m: 0.02,
});
static CUBOID: LazyLock<Cuboid> = LazyLock::new(|| Cuboid {
    centre: Vector3::new(0.0, 0.01, 0.0),
    half_extents: Vector3::new(0.03, 0.02, 0.05),
    edge_radius_m: 0.005,
});
static CYLINDER: LazyLock<Cylinder> = LazyLock::new(|| Cylinder {
    centre: Vector3::new(0.0, 0.01, 0.0),
    axis: Unit::new_normalize(Vector3::new(0.2, 0.1, 1.0)),
    radius_m: 0.03,
    half_height_m: 0.05,
    edge_radius_m: 0.004,
});
static FIELD: LazyLock<Field> = LazyLock::new(|| {
    let mesh = Mesh::load(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/data/objects/bottle_medicine.obj"
    ))
    .expect("the bottle comes with the crate");
    let settings = FieldSettings {
        cell_m: Some(3e-3),
        ..FieldSettings::default()
    };
    Field::bake(&mesh, &ExactMesh::new(&mesh), &settings)
});
static REVOLVED: LazyLock<Revolved> = LazyLock::new(|| {
    let object = Object::named("bottle_round").expect("the bottle comes with the crate");
    // An axis that is none of the frame's, as a user's mesh may have it: the middle of the bottle will do for derivatives.
    let tilted = Vector3::new(0.02, -0.01, 1.0);
    Revolved::bake(&object.mesh, &object.exact, &Vector3::zeros(), &tilted)
});

/// Points near an object, around it, and far away.
fn points() -> impl Strategy<Value = Vector3<f64>> {
    let within = |reach: f64| prop::array::uniform3(-reach..reach).prop_map(Vector3::from);
    prop_oneof![4 => within(0.1), 2 => within(0.4), 1 => within(4.0)]
}

fn central_gradient(shape: &dyn Shape, point: &Vector3<f64>, step: f64) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| {
        let shift = Vector3::ith(axis, step);
        (shape.distance(&(point + shift)) - shape.distance(&(point - shift))) / (2.0 * step)
    })
}

fn central_hessian(shape: &dyn Shape, point: &Vector3<f64>, step: f64) -> Matrix3<f64> {
    let columns = [0, 1, 2].map(|axis| {
        let shift = Vector3::ith(axis, step);
        (shape.gradient(&(point + shift)).1 - shape.gradient(&(point - shift)).1) / (2.0 * step)
    });
    Matrix3::from_columns(&columns)
}

/// Whether the shape is smooth around `point`. Formulae have creases (at the medial axis, or between a sphere and a side),
/// where no derivative exists.
fn is_smooth(shape: &dyn Shape, point: &Vector3<f64>, step: f64) -> bool {
    let (_, slope, here) = shape.hessian(point);
    let scale = here.norm().max(1.0);
    (0..27).all(|corner: u8| {
        let offset = [corner / 9, corner / 3 % 3, corner % 3].map(|k| f64::from(k) - 1.0);
        let (_, slope_there, there) =
            shape.hessian(&(point + Vector3::from(offset) * (2.0 * step)));
        (there - here).norm() < 0.05 * scale && (slope_there - slope).norm() < 0.05
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn derivatives_are_those_of_the_distance(point in points()) {
        const STEP_M: f64 = 1e-6;
        for (name, shape) in shapes() {
            let (value, gradient) = shape.gradient(&point);
            let (value_again, gradient_again, hessian) = shape.hessian(&point);
            prop_assert_eq!(value.to_bits(), shape.distance(&point).to_bits(), "{}", name);
            prop_assert_eq!(value.to_bits(), value_again.to_bits(), "{}", name);
            prop_assert!((gradient - gradient_again).norm() < 1e-12, "{name}");
            prop_assert!(value < 0.0 || gradient.norm() <= shape.lipschitz() + 1e-12, "{name}: {} too steep", gradient.norm());
            if !is_smooth(shape, &point, STEP_M) {
                continue;
            }
            let difference = (central_gradient(shape, &point, STEP_M) - gradient).norm();
            prop_assert!(difference < 1e-6, "{name} at {point}: gradient off by {difference:e}");
            let difference = (central_hessian(shape, &point, STEP_M) - hessian).norm();
            let scale = hessian.norm().max(1.0);
            prop_assert!(difference < 1e-4 * scale, "{name} at {point}: Hessian off by {difference:e} of {scale}");
        }
    }

    #[test]
    fn a_field_is_smooth_across_the_seams_of_its_grids(at in 0.0..1.0_f64, side in 0_usize..3) {
        const STEP_M: f64 = 1e-7;
        // Along each axis from the middle to far away: no jump in the value, gradient or Hessian.
        let start = Vector3::new(0.003, 0.004, 0.036);
        let direction = Vector3::ith(side, 1.0) + Vector3::repeat(0.01);
        let point = start + direction * (0.03 * libm::pow(100.0_f64, at));
        let next = point + direction * STEP_M;
        let ((a, slope_a, bend_a), (b, slope_b, bend_b)) = (FIELD.hessian(&point), FIELD.hessian(&next));
        prop_assert!((a - b).abs() < 2.0 * STEP_M);
        prop_assert!((slope_a - slope_b).norm() < 1e3 * STEP_M);
        prop_assert!((bend_a - bend_b).norm() < 1e6 * STEP_M);
    }
}

#[test]
fn distances_of_formulas_are_known() {
    let point = Vector3::new(0.01, -0.02, 0.1);
    assert!((SPHERE.distance(&point) - 0.035).abs() < 1e-15);
    // Straight above the box, and off one of its edges.
    assert!((CUBOID.distance(&Vector3::new(0.01, 0.0, 0.08)) - 0.03).abs() < 1e-15);
    let corner = Vector3::new(0.03, 0.03, 0.05) + Vector3::new(0.03, 0.04, 0.0);
    let off_edge = Vector3::new(0.035_f64, 0.045, 0.0).norm() - 0.005;
    assert!((CUBOID.distance(&(corner - Vector3::z() * 0.02)) - off_edge).abs() < 1e-15);
    assert!((CUBOID.distance(&CUBOID.centre) + 0.02).abs() < 1e-15);
    // On the axis: half of the height below the cap; half-way up: the radius.
    let up = CYLINDER.axis.into_inner();
    assert!((CYLINDER.distance(&(CYLINDER.centre + up * 0.07)) - 0.02).abs() < 1e-15);
    assert!((CYLINDER.distance(&CYLINDER.centre) + 0.03).abs() < 1e-15);
    let beside = up.cross(&Vector3::x()).normalize();
    assert!((CYLINDER.distance(&(CYLINDER.centre + beside * 0.05)) - 0.02).abs() < 1e-15);
    // The rim: 4 mm from the circle on which the rounding rolls.
    let rim = CYLINDER.centre + up * 0.046 + beside * 0.026;
    assert!((CYLINDER.distance(&(rim + (up * 0.6 + beside * 0.8) * 0.004))).abs() < 1e-15);
    assert!((CAPSULE.distance(&(CAPSULE.a * 0.5 + CAPSULE.b * 0.5)) + 0.02).abs() < 1e-15);
}
