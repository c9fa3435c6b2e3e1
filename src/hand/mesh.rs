//! Mesh files of hands: reads them as triangles, and writes OBJ text.
//!
//! Coordinates are used as they are in the file, as programs of ROS do: glTF (whose scenes have y up) and COLLADA (which
//! names its own axis) are not turned.

use std::path::Path;

use crate::formats::{Triangles, collada, ending, gltf, lfs_pointer, msh, obj, ply, stl};

/// Converts a mesh file of the kind that its name says to OBJ text: only vertices and triangles, with every digit kept.
/// `folder` contains the files that it names.
pub(super) fn to_obj(name: &str, bytes: &[u8], folder: &Path) -> Result<String, String> {
    if lfs_pointer(bytes) {
        return Err(
            "it is a Git LFS pointer in place of the mesh: run `git lfs pull` in its repository"
                .to_owned(),
        );
    }
    let mesh = match ending(Path::new(name)).as_str() {
        "obj" => triangles(bytes)?,
        "stl" => {
            checked(stl::read(bytes).map_err(|error| format!("it is not an STL file: {error}"))?)?
        }
        "msh" => checked(msh::read(bytes)?)?,
        "ply" => checked(ply::read(bytes)?)?,
        "gltf" | "glb" => checked(gltf::read(bytes, folder)?)?,
        "dae" => checked(collada::read(bytes)?)?,
        kind => {
            return Err(format!(
                "meshes of the kind \".{kind}\" are not read: convert this one to .obj, .stl, .ply, .glb or .dae"
            ));
        }
    };
    Ok(obj::write(&mesh.vertices, &mesh.triangles, |vertex| {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "meshes have 32-bit numbers: those of nearly all files, and enough for a hand"
        )]
        let [x, y, z] = [vertex.x as f32, vertex.y as f32, vertex.z as f32];
        format!("{x} {y} {z}")
    }))
}

/// The triangles of OBJ text.
pub(super) fn triangles(mut text: &[u8]) -> Result<Triangles, String> {
    checked(obj::read(&mut text).map_err(|error| format!("it is not an OBJ file: {error}"))?)
}

/// Refuses a mesh without triangles or with invalid numbers.
fn checked(mesh: Triangles) -> Result<Triangles, String> {
    let count = u32::try_from(mesh.vertices.len()).map_err(|error| error.to_string())?;
    if mesh.triangles.is_empty() {
        return Err("it has no triangles".to_owned());
    }
    if mesh.triangles.iter().flatten().any(|&index| index >= count) {
        return Err("a triangle refers to a vertex that does not exist".to_owned());
    }
    if mesh
        .vertices
        .iter()
        .any(|v| !v.iter().all(|x| x.is_finite()))
    {
        return Err("a vertex is not finite".to_owned());
    }
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

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
        let to_obj = |name, bytes: &[u8]| to_obj(name, bytes, Path::new(""));
        let text = to_obj("a.msh", &msh).unwrap();
        assert_eq!(to_obj("b.OBJ", text.as_bytes()).unwrap(), text);
        let read = triangles(text.as_bytes()).unwrap();
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
        let read = triangles(to_obj("c.stl", &stl).unwrap().as_bytes()).unwrap();
        assert_eq!((read.vertices.len(), read.triangles.len()), (4, 4));
    }

    const POINTER: &[u8] =
        b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12345\n";

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
            ("a.stl", POINTER),
        ] {
            let refused = to_obj(name, bytes, Path::new("")).is_err();
            assert!(refused, "{name}: {bytes:?}");
        }
        let told = to_obj("a.obj", POINTER, Path::new("")).unwrap_err();
        assert!(told.contains("git lfs pull"), "{told}");
    }
}
