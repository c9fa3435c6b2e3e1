//! STL files, text or binary. Equal corners become one vertex.

use std::io::Cursor;

use nalgebra::Vector3;

use super::Triangles;

/// Reads the bytes of an STL file.
///
/// # Errors
/// The error of the library.
pub(crate) fn read(bytes: &[u8]) -> std::io::Result<Triangles> {
    let stl = stl_io::read_stl(&mut Cursor::new(bytes))?;
    let index = |vertex: usize| u32::try_from(vertex).unwrap_or(u32::MAX);
    let vertices = stl.vertices.iter();
    let faces = stl.faces.iter();
    Ok(Triangles {
        vertices: vertices
            .map(|v| Vector3::new(v[0].into(), v[1].into(), v[2].into()))
            .collect(),
        triangles: faces.map(|face| face.vertices.map(index)).collect(),
    })
}
