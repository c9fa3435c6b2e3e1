//! Start poses that depend on the object.

use crate::sample::standard_normal;
use nalgebra::{Isometry3, Rotation3, Unit, UnitQuaternion, Vector3};
use rand::RngExt;

use crate::hand::Hand;
use crate::mesh::SurfaceSample;
use crate::object::Object;
use crate::sample::Rng;
use crate::space::pose_coordinates;

/// Range of distances between the palm and the surface point it faces, metres.
const GAP_M: std::ops::Range<f64> = 0.002..0.040;
/// Standard deviation of the palm's tilt, radians.
const TILT_RAD: f64 = 0.35;
/// Standard deviation of a joint from its rest angle, relative to its range.
const JOINT_SHARE: f64 = 0.15;

/// A random pose with the palm facing a random point of the object and the fingers near rest, as coordinates of
/// [`PoseSpace`](crate::space::PoseSpace).
///
/// It follows the initialisation of `DexGraspNet` (Wang et al. 2023), without the convex hull: the surface point is one of
/// the object's evenly spread samples.
pub fn start_pose(hand: &Hand, object: &Object, rng: &mut Rng) -> Vec<f64> {
    let samples = &object.surface_samples;
    let faced = |rng: &mut Rng| samples[rng.random_range(0..samples.len())];
    draw(hand, None, rng, faced)
}

/// A random pose with the palm facing `faced` and the fingers near rest.
pub fn start_pose_facing(hand: &Hand, faced: &SurfaceSample, rng: &mut Rng) -> Vec<f64> {
    draw(hand, None, rng, |_| *faced)
}

/// A random pose with the palm facing `faced` and these joints.
pub(super) fn start_pose_with(
    hand: &Hand,
    joints: &[f64],
    faced: &SurfaceSample,
    rng: &mut Rng,
) -> Vec<f64> {
    draw(hand, Some(joints), rng, |_| *faced)
}

fn draw(
    hand: &Hand,
    given: Option<&[f64]>,
    rng: &mut Rng,
    faced: impl FnOnce(&mut Rng) -> SurfaceSample,
) -> Vec<f64> {
    let mut normal = || -> f64 { standard_normal(rng) };
    let tilt = [TILT_RAD * normal(), TILT_RAD * normal()];
    let joints: Vec<f64> = hand
        .joints
        .iter()
        .zip(&hand.prior.rest)
        .map(|(joint, rest)| {
            let [lower, upper] = joint.limits;
            (rest + JOINT_SHARE * (upper - lower) * normal()).clamp(lower, upper)
        })
        .collect();
    let joints = given.map_or(joints, <[f64]>::to_vec);
    let faced = faced(rng);
    let outward = Unit::new_normalize(faced.normal);
    let roll = rng.random_range(0.0..std::f64::consts::TAU);
    let gap_m = rng.random_range(GAP_M);

    // The third axis of one frame is the outward normal; that of the palm's frame is the negative volar direction.
    let object_from_surface =
        frame(&outward) * Rotation3::from_axis_angle(&Vector3::z_axis(), roll);
    let tilted = Rotation3::from_euler_angles(tilt[0], tilt[1], 0.0);
    let palm = hand.palm_at(&joints);
    let volar = Unit::new_normalize(-palm.volar);
    let hand_from_palm = frame(&volar);
    let rotation = UnitQuaternion::from_rotation_matrix(
        &(object_from_surface * tilted * hand_from_palm.inverse()),
    );
    let facing = palm.centre + palm.distal * palm.faced_m;
    let translation = faced.point + outward.into_inner() * gap_m - rotation * facing;
    pose_coordinates(
        &Isometry3::from_parts(translation.into(), rotation),
        &joints,
    )
}

/// A frame whose third axis is `z`.
pub(super) fn frame(z: &Unit<Vector3<f64>>) -> Rotation3<f64> {
    let mut helper = Vector3::zeros();
    helper[z.iamin()] = 1.0;
    let x = helper.cross(z).normalize();
    let y = z.cross(&x);
    Rotation3::from_basis_unchecked(&[x, y, z.into_inner()])
}
