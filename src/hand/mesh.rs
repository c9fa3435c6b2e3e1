//! Mesh files of hands: OBJ and STL into triangles, and back into OBJ text.

use std::fmt::Write as _;
use std::io::Cursor;
use std::path::Path;

use nalgebra::Vector3;

use super::model::Triangles;

/// The mesh file `bytes` of the kind its name says, as OBJ text: vertices and triangles only, every digit kept.
pub(super) fn to_obj(name: &str, bytes: &[u8]) -> Result<String, String> {
    let kind = Path::new(name)
        .extension()
        .map(|kind| kind.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    let (vertices, triangles) = match kind.as_str() {
        "obj" => obj(bytes)?,
        "stl" => stl(bytes)?,
        "msh" => msh(bytes)?,
        _ => {
            return Err(format!(
                "meshes of the kind \".{kind}\" are not read, convert it to .obj or .stl"
            ));
        }
    };
    let mut text = String::new();
    for [x, y, z] in vertices {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [a, b, c] in triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    Ok(text)
}

/// The triangles of OBJ text.
pub(super) fn triangles(text: &str) -> Result<Triangles, String> {
    let (vertices, triangles) = obj(text.as_bytes())?;
    Ok(Triangles {
        vertices: vertices
            .into_iter()
            .map(|v| Vector3::from(v.map(f64::from)))
            .collect(),
        triangles,
    })
}

type Parts = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// Refuses what is no mesh.
fn checked((vertices, triangles): Parts) -> Result<Parts, String> {
    let count = u32::try_from(vertices.len()).map_err(|error| error.to_string())?;
    if triangles.is_empty() {
        return Err("it has no triangles".to_owned());
    }
    if triangles.iter().flatten().any(|&index| index >= count) {
        return Err("a triangle names a vertex that it does not have".to_owned());
    }
    if vertices.iter().flatten().any(|x| !x.is_finite()) {
        return Err("a vertex is not finite".to_owned());
    }
    Ok((vertices, triangles))
}

fn obj(bytes: &[u8]) -> Result<Parts, String> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials)
        .map_err(|error| format!("it is no OBJ file: {error}"))?;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for model in models {
        let first = u32::try_from(vertices.len()).map_err(|error| error.to_string())?;
        let points = model.mesh.positions.chunks_exact(3);
        vertices.extend(points.map(|v| [v[0], v[1], v[2]]));
        let corners = model.mesh.indices.chunks_exact(3);
        triangles.extend(corners.map(|t| [t[0], t[1], t[2]].map(|i| i.saturating_add(first))));
    }
    checked((vertices, triangles))
}

fn stl(bytes: &[u8]) -> Result<Parts, String> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes))
        .map_err(|error| format!("it is no STL file: {error}"))?;
    let index = |vertex: usize| u32::try_from(vertex).unwrap_or(u32::MAX);
    checked((
        mesh.vertices.iter().map(|v| [v[0], v[1], v[2]]).collect(),
        mesh.faces
            .iter()
            .map(|face| face.vertices.map(index))
            .collect(),
    ))
}

/// `MuJoCo`'s own format: four counts (vertices, normals, texture coordinates, triangles), then these, all of four bytes.
fn msh(bytes: &[u8]) -> Result<Parts, String> {
    let broken = || "it is no MSH file of MuJoCo".to_owned();
    let word = |i: usize| -> Option<[u8; 4]> { bytes.get(4 * i..4 * i + 4)?.try_into().ok() };
    let count = |i: usize| -> Option<usize> { usize::try_from(i32::from_le_bytes(word(i)?)).ok() };
    let mut counts = [0; 4];
    for (i, slot) in counts.iter_mut().enumerate() {
        *slot = count(i).ok_or_else(broken)?;
    }
    let [vertices, normals, coordinates, triangles] = counts;
    let words = |count: usize, each: usize| count.checked_mul(each);
    let first_triangle = words(vertices, 3)
        .zip(words(normals, 3))
        .and_then(|(a, b)| a.checked_add(b))
        .zip(words(coordinates, 2))
        .and_then(|(a, b)| a.checked_add(b)?.checked_add(4))
        .ok_or_else(broken)?;
    let all = words(triangles, 3)
        .and_then(|count| count.checked_add(first_triangle)?.checked_mul(4))
        .ok_or_else(broken)?;
    if all != bytes.len() {
        return Err(broken());
    }
    let number = |i: usize| word(i).map(f32::from_le_bytes).ok_or_else(broken);
    let index = |i: usize| word(i).map(u32::from_le_bytes).ok_or_else(broken);
    let points = (0..vertices).map(|v| {
        let first = 4 + 3 * v;
        Ok([number(first)?, number(first + 1)?, number(first + 2)?])
    });
    let corners = (0..triangles).map(|t| {
        let first = first_triangle + 3 * t;
        Ok([index(first)?, index(first + 1)?, index(first + 2)?])
    });
    checked((
        points.collect::<Result<_, String>>()?,
        corners.collect::<Result<_, String>>()?,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron in each format gives the same text, to the last digit.
    #[test]
    fn formats_agree() {
        let corners = [
            [0.1f32, 0.0, 0.0],
            [0.0, 0.3, 0.0],
            [0.0, 0.0, 1e-7],
            [0.0; 3],
        ];
        let faces = [[0u32, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
        let mut msh: Vec<u8> = [4i32, 0, 0, 4]
            .iter()
            .flat_map(|n| n.to_le_bytes())
            .collect();
        msh.extend(corners.iter().flatten().flat_map(|x| x.to_le_bytes()));
        msh.extend(faces.iter().flatten().flat_map(|x| x.to_le_bytes()));
        let text = to_obj("a.msh", &msh).unwrap();
        assert_eq!(to_obj("b.OBJ", text.as_bytes()).unwrap(), text);
        let read = triangles(&text).unwrap();
        assert_eq!(read.triangles, faces);
        for (vertex, corner) in read.vertices.iter().zip(corners) {
            assert_eq!(*vertex, Vector3::from(corner.map(f64::from)));
        }
        let mut stl = vec![0u8; 80];
        stl.extend(4u32.to_le_bytes());
        for face in faces {
            stl.extend([0u8; 12]);
            let points = face.iter().flat_map(|&v| corners[v as usize]);
            stl.extend(points.flat_map(f32::to_le_bytes));
            stl.extend([0u8; 2]);
        }
        let read = triangles(&to_obj("c.stl", &stl).unwrap()).unwrap();
        assert_eq!((read.vertices.len(), read.triangles.len()), (4, 4));
    }

    #[test]
    fn what_is_no_mesh_is_refused() {
        for (name, bytes) in [
            ("a.dae", &b"x"[..]),
            ("a", b""),
            ("a.obj", b"v 0 0 0\nf 1 2 3\n"),
            ("a.obj", b"v 0 0 0\n"),
            ("a.obj", b"v nan 0 0\nv 0 0 0\nv 1 0 0\nf 1 2 3\n"),
            ("a.stl", b"solid"),
            (
                "a.msh",
                b"\xff\xff\xff\x7f\xff\xff\xff\x7f\xff\xff\xff\x7f\xff\xff\xff\x7f",
            ),
            ("a.msh", b""),
        ] {
            assert!(to_obj(name, bytes).is_err(), "{name}: {bytes:?}");
        }
    }
}
