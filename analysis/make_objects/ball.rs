//! The ball.

use landscape::mesh::Mesh;
use landscape::object::{Description, Primitive, Sphere};
use landscape::space::Symmetry;
use nalgebra::Vector3;

/// A ball: an icosahedron subdivided four times.
pub(super) fn ball() -> Result<(&'static str, Mesh, Description), Box<dyn std::error::Error>> {
    const RADIUS_M: f64 = 0.035;
    let centre = Vector3::z() * RADIUS_M;
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut vertices: Vec<Vector3<f64>> = Vec::new();
    for [a, b] in [
        [-1.0, -golden],
        [1.0, -golden],
        [-1.0, golden],
        [1.0, golden],
    ] {
        vertices.extend([
            Vector3::new(a, b, 0.0),
            Vector3::new(0.0, a, b),
            Vector3::new(b, 0.0, a),
        ]);
    }
    // Faces are the triples of mutual neighbours, which have distance two.
    let near = |i: usize, j: usize| (vertices[i] - vertices[j]).norm() < 2.1;
    let mut faces: Vec<[Vector3<f64>; 3]> = Vec::new();
    for (i, j, k) in
        (0..12).flat_map(|i| (i + 1..12).flat_map(move |j| (j + 1..12).map(move |k| (i, j, k))))
    {
        if near(i, j) && near(j, k) && near(k, i) {
            let [a, b, c] = [i, j, k].map(|index| vertices[index].normalize());
            faces.push(if a.dot(&b.cross(&c)) > 0.0 {
                [a, b, c]
            } else {
                [a, c, b]
            });
        }
    }
    for _ in 0..4 {
        let divide = |[a, b, c]: [Vector3<f64>; 3]| {
            let [ab, bc, ca] = [
                (a + b).normalize(),
                (b + c).normalize(),
                (c + a).normalize(),
            ];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(divide).collect();
    }
    // Corners of neighbouring faces coincide to the last bit and are merged by `Mesh::new`.
    let corners: Vec<Vector3<f64>> = faces
        .into_iter()
        .flatten()
        .map(|unit| centre + unit * RADIUS_M)
        .collect();
    let triangles = (0..u32::try_from(corners.len())?)
        .step_by(3)
        .map(|i| [i, i + 1, i + 2])
        .collect();
    let description = Description {
        name: Some("ball".into()),
        mass_kg: Some(0.06),
        symmetry: Symmetry::Sphere { centre },
        primitive: Some(Primitive::Sphere(Sphere {
            centre,
            radius_m: RADIUS_M,
        })),
        ..Description::default()
    };
    Ok(("ball", Mesh::new("ball", corners, triangles)?, description))
}
