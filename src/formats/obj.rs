//! OBJ files: vertices and faces; everything else is skipped. Coordinates are read as 32-bit numbers.

use std::fmt::Write as _;
use std::io::BufRead;
use std::path::Path;

use nalgebra::Vector3;

use super::Triangles;

/// Reads the text of an OBJ file. Its objects and groups are combined, and polygons become triangle fans.
pub(crate) fn read(reader: &mut impl BufRead) -> Result<Triangles, String> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) =
        tobj::load_obj_buf(reader, &options, no_materials).map_err(|error| error.to_string())?;
    let mut all = Triangles::default();
    for model in models {
        let first = u32::try_from(all.vertices.len()).unwrap_or(u32::MAX);
        let positions = model.mesh.positions.chunks_exact(3);
        let positions = positions.map(Vector3::from_column_slice);
        all.vertices.extend(positions.map(|v| v.map(f64::from)));
        let corners = model.mesh.indices.chunks_exact(3);
        let triangles = corners.map(|t| [t[0], t[1], t[2]].map(|i| i.saturating_add(first)));
        all.triangles.extend(triangles);
    }
    Ok(all)
}

/// Triangles as OBJ text. `vertex` formats the three coordinates of a vertex.
pub(crate) fn write(
    vertices: &[Vector3<f64>],
    triangles: &[[u32; 3]],
    vertex: impl Fn(&Vector3<f64>) -> String,
) -> String {
    let mut text = String::new();
    for v in vertices {
        writeln!(text, "v {}", vertex(v)).expect("a String takes all text");
    }
    for [a, b, c] in triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("a String takes all text");
    }
    text
}
