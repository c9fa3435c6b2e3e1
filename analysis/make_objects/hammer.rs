//! The hammer: a steel head with a round face and a wedge-shaped peen, and a wooden handle that grows out of its underside.

use std::f64::consts::TAU;

use landscape::mesh::Mesh;
use landscape::object::Description;
use landscape::space::Symmetry;
use nalgebra::Vector3;

use super::parts::Parts;
use super::tube::{Station, border_angles};

const NAME: &str = "hammer";
const MASS_KG: f64 = 0.42;
/// Height of the middle line of the head above the end of the handle.
const HEAD_MM: f64 = 272.0;
/// The head from peen to face: position along it, half-width, half-height, exponent of the cross-section.
const HEAD: [[f64; 4]; 12] = [
    [-54.0, 9.5, 1.2, 3.0],
    [-53.0, 10.5, 2.0, 3.0],
    [-51.0, 11.0, 2.8, 3.0],
    [-20.0, 12.0, 11.5, 4.0],
    [-15.0, 12.5, 13.0, 4.0],
    [15.0, 12.5, 13.0, 4.0],
    [20.0, 11.0, 11.0, 3.0],
    [32.0, 11.0, 11.0, 2.0],
    [38.0, 14.0, 14.0, 2.0],
    [48.0, 14.0, 14.0, 2.0],
    [50.0, 13.4, 13.4, 2.0],
    [50.6, 11.8, 11.8, 2.0],
];
/// Length of the steps into which the intervals between these positions are divided.
const STEP_MM: f64 = 3.0;
const SECTORS: usize = 36;
/// Number of sectors of the underside from which the handle grows. `ROOT_MM` are the ends of this root along the head.
const ROOT_SECTORS: usize = 8;
const ROOT_MM: [f64; 2] = [-12.0, 12.0];
/// The handle from the end of its fillet down: height, half-widths across and along the head.
const HANDLE: [[f64; 3]; 9] = [
    [253.0, 7.0, 9.0],
    [236.0, 7.0, 9.0],
    [205.0, 8.0, 11.0],
    [120.0, 9.5, 13.5],
    [60.0, 10.5, 14.5],
    [14.0, 11.0, 15.5],
    [4.0, 10.8, 15.3],
    [1.2, 9.8, 14.3],
    [0.0, 7.5, 12.0],
];
const HANDLE_STEP_MM: f64 = 7.0;

pub(super) fn hammer() -> Result<(&'static str, Mesh, Description), Box<dyn std::error::Error>> {
    let mut parts = Parts::default();
    let head: Vec<Station> = divided(&HEAD, STEP_MM)
        .iter()
        .map(|&[along, half_width, half_height, exponent]| Station {
            centre: Vector3::new(along, 0.0, HEAD_MM),
            axes: [Vector3::y(), Vector3::z()],
            half: [half_width, half_height],
            exponent,
        })
        .collect();
    let around: Vec<f64> = (0..SECTORS)
        .map(|sector| TAU * sector as f64 / SECTORS as f64)
        .collect();
    let rings: Vec<Vec<u32>> = head
        .iter()
        .map(|station| parts.section(station, &around))
        .collect();
    parts.stitch_all(&rings);
    let (peen, face) = (
        parts.point(head[0].centre),
        parts.point(head[head.len() - 1].centre),
    );
    parts.close_below(peen, &rings[0]);
    parts.close_above(face, &rings[rings.len() - 1]);

    let under: Vec<usize> = (0..rings.len())
        .filter(|&ring| (ROOT_MM[0]..=ROOT_MM[1]).contains(&head[ring].centre.x))
        .collect();
    let (first, last) = (under[0], under[under.len() - 1]);
    let down = SECTORS * 3 / 4;
    let border = parts.open(&rings[first..=last], down - ROOT_SECTORS / 2, ROOT_SECTORS);
    let angles = border_angles(ROOT_SECTORS, last - first);
    let handle: Vec<Station> = divided(&HANDLE, HANDLE_STEP_MM)
        .iter()
        .map(|&[height, across, along]| Station {
            centre: Vector3::z() * height,
            axes: [Vector3::y(), Vector3::x()],
            half: [across, along],
            exponent: 2.3,
        })
        .collect();
    let mut tube = vec![border.clone()];
    tube.extend(parts.fillet(&border, &-Vector3::z(), &handle[0], &angles));
    for station in &handle[1..] {
        tube.push(parts.section(station, &angles));
    }
    parts.stitch_all(&tube);
    let end = parts.point(handle[handle.len() - 1].centre);
    parts.close_above(end, &tube[tube.len() - 1]);

    let description = Description {
        name: Some(NAME.into()),
        mass_kg: Some(MASS_KG),
        symmetry: Symmetry::None,
        ..Description::default()
    };
    Ok((NAME, parts.into_mesh(NAME)?, description))
}

/// The rows, with linear interpolations wherever the first entry changes by more than `step`.
fn divided<const N: usize>(rows: &[[f64; N]], step: f64) -> Vec<[f64; N]> {
    let mut all = vec![rows[0]];
    for pair in rows.windows(2) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small positive count"
        )]
        let count = ((pair[1][0] - pair[0][0]).abs() / step).ceil().max(1.0) as u32;
        all.extend((1..=count).map(|i| {
            let t = f64::from(i) / f64::from(count);
            std::array::from_fn(|k| pair[0][k] + t * (pair[1][k] - pair[0][k]))
        }));
    }
    all
}
