//! A landscape as a road map: postures, ways between them, and how to drive them.

use serde_json::{Value, json};

use super::super::error::StudyError;
use super::super::replaying::Drives;
use crate::evaluation::stability::Replay;
use crate::figure::MAKER;
use crate::space::{joints_of, object_from_hand};
use crate::store::{EdgeRow, LandscapeFiles, MinimumRow};
use crate::topography::MinimumId;

/// The road map of a landscape of grasps, as [docs/roadmap.md](../../../docs/roadmap.md) describes it. Edges without a path
/// are left out. With `drive`, each edge is driven both ways under [`Replay::conditions`], which takes seconds each.
///
/// # Errors
/// If a path is incomplete.
///
/// # Panics
/// If the drives are those of another landscape.
pub fn roadmap(
    files: &LandscapeFiles,
    drives: &Drives<'_>,
    drive: bool,
) -> Result<Value, StudyError> {
    let hand = drives.energy().hand();
    let names: Vec<&str> = hand
        .joints
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    let nodes: Vec<Value> = files.minima.iter().map(node).collect();
    let pathed = |edge: &&EdgeRow| {
        let of_edge = |row: &crate::store::PathPoint| (row.a, row.b) == (edge.a, edge.b);
        files.paths.iter().any(of_edge)
    };
    let edges: Result<Vec<Value>, StudyError> = (files.edges.iter().filter(pathed))
        .map(|row| edge(row, drives, drive))
        .collect();
    let settings = Replay::default();
    Ok(json!({
        "made_by": MAKER,
        "hand": hand.name,
        "object": drives.energy().object().name,
        "object_mass_kg": drives.mass_kg(),
        "object_centre_m": drives.centre().as_slice(),
        "object_symmetry": drives.energy().pose_space().symmetry(),
        "joint_names": names,
        "letting_go": files.manifest.letting_go,
        "springs": {
            "stiffness_n_m": settings.closing.stiffness_n_m,
            "damping_n_m_s": settings.closing.damping_n_m_s,
            "torque_limit_n_m": settings.closing.torque_limit_n_m,
        },
        "nodes": nodes,
        "edges": edges?,
    }))
}

fn node(row: &MinimumRow) -> Value {
    json!({
        "minimum": row.id,
        "family": row.family,
        "energy": row.energy,
        "hand_from_object": placed(&row.coordinates),
        "joints": joints_of(&row.coordinates),
    })
}

/// Position (metres) and quaternion (w, x, y, z) of the object in the hand.
fn placed(x: &[f64]) -> [f64; 7] {
    let hand_from_object = object_from_hand(x).inverse();
    let (t, q) = (
        hand_from_object.translation.vector,
        hand_from_object.rotation,
    );
    [t.x, t.y, t.z, q.w, q.i, q.j, q.k]
}

fn edge(row: &EdgeRow, drives: &Drives<'_>, drive: bool) -> Result<Value, StudyError> {
    let ends = [row.a, row.b].map(|end| MinimumId(usize::try_from(end).unwrap_or(usize::MAX)));
    let way = drives.path(ends)?;
    let targets = drives.targets(&way, &Replay::default());
    let points = way.iter().zip(targets);
    let trajectory: Vec<Value> = points
        .map(|(grasp, target)| {
            json!({
                "seconds": target.seconds,
                "hand_from_object": placed(&grasp.pose),
                "joints": grasp.pose.joints(),
                "targets": target.joints,
            })
        })
        .collect();
    let [forward, backward] = if drive {
        [
            Some(drives.success(ends)?),
            Some(drives.success([ends[1], ends[0]])?),
        ]
    } else {
        [None, None]
    };
    Ok(json!({
        "ends": [row.a, row.b],
        "height": row.height,
        "barrier": row.relative_barrier,
        "length_m": row.length,
        "way": row.way,
        "forward": forward,
        "backward": backward,
        "trajectory": trajectory,
    }))
}
