//! Film strips of a drive, seen from the hand, which stands still.

use landscape::figure::{Image, Scene};
use landscape::grasp::Grasp;
use landscape::space::{Space, object_from_hand};
use nalgebra::{Point3, Vector3};

use super::Failure;
use super::design::Drive;
use super::runs::Driven;

const SIDE: u32 = 360;

/// `count` pictures of a drive under the main condition, evenly in time, with captions.
pub(crate) fn strip(
    driven: &Driven<'_>,
    drive: Drive,
    count: usize,
) -> Result<Vec<(Image, String)>, Failure> {
    let found = driven.replayed(drive, 0)?;
    let energy = driven.ways.energy();
    let (hand, object) = (energy.hand(), energy.object());
    let skin = hand.skin();
    let last = found.moments.len() - 1;
    let shown = (0..count).map(|k| &found.moments[k * last / (count - 1)]);
    let scene = |pose: &[f64]| {
        let hand_from_object = object_from_hand(pose).inverse();
        let mut scene =
            Scene::of_grasp(hand, &skin, object, &Grasp::new(pose.to_vec(), Vec::new()));
        for vertex in scene
            .surfaces
            .iter_mut()
            .flat_map(|surface| &mut surface.vertices)
        {
            *vertex = (hand_from_object * Point3::from(*vertex)).coords;
        }
        scene
    };
    let first = scene(&found.moments[0].pose);
    // Close to the start and the end of the way even if the object is lost.
    let camera = first.best_camera(Vector3::z());
    let pictures = shown.map(|moment| {
        let image = scene(&moment.pose).render(&camera, SIDE, SIDE);
        let way_mm = 1e3
            * energy
                .pose_space()
                .distance(&found.moments[0].pose, &moment.pose);
        (image, format!("{:.1} s, {way_mm:.0} mm", moment.seconds))
    });
    Ok(pictures.collect())
}
