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
