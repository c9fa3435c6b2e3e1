//! Boxes for tests.

use nalgebra::Vector3;

use super::Mesh;

/// The triangles of a box. Bit i of a corner's number tells on which side of axis i it lies.
pub(crate) const CUBE: [[u32; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

/// Boxes from one corner to another as one mesh; `true` turns a box inside out.
pub(crate) fn box_mesh(boxes: &[([f64; 3], [f64; 3], bool)]) -> Mesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (first, &(low, high, inside_out)) in (0..).step_by(8).zip(boxes) {
        let side = |corner: u8, axis: usize| {
            if corner >> axis & 1 == 0 {
                low[axis]
            } else {
                high[axis]
            }
        };
        vertices.extend((0..8).map(|corner| Vector3::from_fn(|axis, _| side(corner, axis))));
        let face = |[a, b, c]: [u32; 3]| if inside_out { [a, c, b] } else { [a, b, c] };
        triangles.extend(CUBE.map(|corners| face(corners.map(|corner| corner + first))));
    }
    Mesh::new("boxes", vertices, triangles).unwrap()
}
