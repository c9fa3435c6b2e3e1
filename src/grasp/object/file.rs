//! Meshes on disk: OBJ and STL in, OBJ out.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use nalgebra::Vector3;

use super::{Mesh, ObjectError};

impl Mesh {
    /// Reads an OBJ or STL file, in metres.
    ///
    /// # Errors
    /// Where the file cannot be read, is of another kind, or holds no valid mesh (see [`Mesh::new`]).
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ObjectError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let kind = path
            .extension()
            .map(|kind| kind.to_string_lossy().to_lowercase())
            .unwrap_or_default();
        if kind != "obj" && kind != "stl" {
            return Err(ObjectError::Kind {
                path: path.to_owned(),
            });
        }
        let open = |source| ObjectError::Read {
            path: path.to_owned(),
            source,
        };
        let mut reader = BufReader::new(File::open(path).map_err(open)?);
        if kind == "obj" {
            return Self::from_obj(&name, &mut reader);
        }
        let stl = stl_io::read_stl(&mut reader).map_err(open)?;
        let vertices = stl
            .vertices
            .iter()
            .map(|v| Vector3::new(v[0].into(), v[1].into(), v[2].into()))
            .collect();
        let index = |vertex: usize| u32::try_from(vertex).unwrap_or(u32::MAX);
        let triangles = stl
            .faces
            .iter()
            .map(|face| face.vertices.map(index))
            .collect();
        Self::new(&name, vertices, triangles)
    }

    /// Reads the text of an OBJ file, in metres; all its objects and groups make one mesh.
    ///
    /// # Errors
    /// Where the text is no OBJ or holds no valid mesh (see [`Mesh::new`]).
    pub fn from_obj(name: &str, reader: &mut impl BufRead) -> Result<Self, ObjectError> {
        let options = tobj::LoadOptions {
            triangulate: true,
            ignore_points: true,
            ignore_lines: true,
            ..tobj::LoadOptions::default()
        };
        let no_materials = |_: &Path| Ok(Default::default());
        let (models, _) = tobj::load_obj_buf(reader, &options, no_materials).map_err(|source| {
            ObjectError::Obj {
                name: name.to_owned(),
                source,
            }
        })?;
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for model in models {
            let first = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
            vertices.extend(
                model
                    .mesh
                    .positions
                    .chunks_exact(3)
                    .map(Vector3::from_column_slice)
                    .map(|v| v.map(f64::from)),
            );
            let corners = model.mesh.indices.chunks_exact(3);
            triangles.extend(corners.map(|t| [t[0] + first, t[1] + first, t[2] + first]));
        }
        Self::new(name, vertices, triangles)
    }

    /// The mesh as OBJ text, coordinates to the micrometre.
    pub fn to_obj(&self) -> String {
        let mut text = String::new();
        for v in self.vertices() {
            writeln!(text, "v {:.6} {:.6} {:.6}", v.x, v.y, v.z).expect("a String takes all text");
        }
        for [a, b, c] in self.triangles() {
            writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("a String takes all text");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: &str = "\
        o one\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\n\
        g rest\nusemtl none\nf 1 4 3\nf 2 3 4\n";

    #[test]
    fn groups_of_one_surface_are_joined() {
        let mesh = Mesh::from_obj("tetrahedron", &mut TETRAHEDRON.as_bytes()).unwrap();
        assert_eq!((mesh.vertices().len(), mesh.triangles().len()), (4, 4));
        assert!((mesh.volume() - 1e-3 / 6.0).abs() < 1e-10);
        let again = Mesh::from_obj("again", &mut mesh.to_obj().as_bytes()).unwrap();
        assert_eq!(again, mesh);
    }

    #[test]
    fn stl_files_are_read() {
        let text = "solid thing
            facet normal 0 0 -1 outer loop vertex 0 0 0 vertex 0 0.1 0 vertex 0.1 0 0 endloop endfacet
            facet normal 0 -1 0 outer loop vertex 0 0 0 vertex 0.1 0 0 vertex 0 0 0.1 endloop endfacet
            facet normal -1 0 0 outer loop vertex 0 0 0 vertex 0 0 0.1 vertex 0 0.1 0 endloop endfacet
            facet normal 1 1 1 outer loop vertex 0.1 0 0 vertex 0 0.1 0 vertex 0 0 0.1 endloop endfacet
            endsolid thing\n";
        let lines = text
            .replace(" outer", "\nouter")
            .replace(" vertex", "\nvertex")
            .replace(" end", "\nend");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("thing.STL");
        std::fs::write(&path, lines).unwrap();
        let mesh = Mesh::load(&path).unwrap();
        assert_eq!(mesh.vertices().len(), 4);
        assert!((mesh.volume() - 1e-3 / 6.0).abs() < 1e-10);
    }

    #[test]
    fn errors_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        for path in [
            folder.path().join("missing.obj"),
            write("thing.ply", "ply"),
            write("words.obj", "v one two three\nf 1 2 3\n"),
            write("range.obj", "v 0 0 0\nf 1 2 3\n"),
            write("empty.obj", ""),
            write("words.stl", "words"),
            write("points.obj", "v 0 0 0\nv 1 0 0\n"),
            write("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"),
        ] {
            let message = Mesh::load(&path).unwrap_err().to_string();
            assert!(message.contains(&path.display().to_string()), "{message}");
        }
    }
}
