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
