//! Mesh files: reading of OBJ, STL, PLY and glTF, writing of OBJ.

use std::io::BufRead;
use std::path::Path;

use super::{Mesh, MeshError, Repaired};
use crate::formats::{Triangles, bytes_of, ending, gltf, lfs_pointer, obj, ply, stl};

impl Mesh {
    /// Reads an OBJ, STL, PLY or glTF file (`.gltf`, `.glb`) in metres. The mesh is repaired if that is needed and safe.
    ///
    /// # Errors
    /// If the file cannot be read, is of another kind, holds no valid mesh (see [`Mesh::repaired`]), or if its size cannot
    /// be metres.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        let path = path.as_ref();
        let mesh = Self::read(path, 1.0)?.mesh;
        mesh.check_size(&path.display().to_string())?;
        Ok(mesh)
    }

    /// Reads an OBJ, STL, PLY or glTF file (`.gltf`, `.glb`), multiplies its coordinates by `scale`, and reports repairs.
    /// Any size is accepted.
    ///
    /// # Errors
    /// If the file cannot be read, is of another kind, or holds no valid mesh (see [`Mesh::repaired`]).
    pub fn read(path: &Path, scale: f64) -> Result<Repaired, MeshError> {
        let mut read = triangles_of(path)?;
        for vertex in &mut read.vertices {
            *vertex *= scale;
        }
        Self::repaired(&path.display().to_string(), read.vertices, read.triangles)
    }

    /// Reads a file as [`Mesh::read`] does, in its own unit, but its open surfaces become walls `thickness` thick in that unit
    /// ([`Mesh::thickened`]).
    ///
    /// # Errors
    /// As [`Mesh::read`], or if no surface is open.
    pub fn read_thickened(path: &Path, thickness: f64) -> Result<Repaired, MeshError> {
        let read = triangles_of(path)?;
        let name = path.display().to_string();
        Self::thickened(&name, read.vertices, read.triangles, thickness)
    }

    /// Reads the text of an OBJ file. All its objects and groups form one mesh.
    ///
    /// # Errors
    /// If the text is not OBJ or holds no valid mesh (see [`Mesh::new`]).
    pub fn from_obj(name: &str, reader: &mut impl BufRead) -> Result<Self, MeshError> {
        let soup = of_obj(name, reader)?;
        Self::new(name, soup.vertices, soup.triangles)
    }

    /// The mesh as OBJ text. Coordinates have a resolution of a micrometre, or of a millionth of its size if it is much
    /// smaller than a metre.
    pub fn to_obj(&self) -> String {
        let mut decimals = 6;
        let mut size = self.size_m();
        while size < 1e-3 && decimals < 30 {
            size *= 10.0;
            decimals += 1;
        }
        obj::write(self.vertices(), self.triangles(), |v| {
            format!("{:.decimals$} {:.decimals$} {:.decimals$}", v.x, v.y, v.z)
        })
    }
}

/// The triangles of a file.
fn triangles_of(path: &Path) -> Result<Triangles, MeshError> {
    let name = path.display().to_string();
    let kind = ending(path);
    if !["obj", "stl", "ply", "gltf", "glb"].contains(&kind.as_str()) {
        return Err(MeshError::Kind(path.to_owned()));
    }
    let cannot = |source| MeshError::Read {
        path: path.to_owned(),
        source,
    };
    let bytes = bytes_of(path).map_err(cannot)?;
    if lfs_pointer(&bytes) {
        return Err(MeshError::Pointer(name));
    }
    match kind.as_str() {
        "obj" => of_obj(&name, &mut bytes.as_slice()),
        "stl" => stl::read(&bytes).map_err(cannot),
        "ply" => ply::read(&bytes).map_err(invalid(&name, "PLY")),
        _ => {
            let folder = path.parent().unwrap_or(Path::new(""));
            gltf::read(&bytes, folder).map_err(invalid(&name, "glTF"))
        }
    }
}

/// The triangles of the text of an OBJ file; `name` is what errors call it.
pub(crate) fn of_obj(name: &str, reader: &mut impl BufRead) -> Result<Triangles, MeshError> {
    obj::read(reader).map_err(invalid(name, "OBJ"))
}

fn invalid(name: &str, format: &'static str) -> impl FnOnce(String) -> MeshError {
    let name = name.to_owned();
    move |problem| MeshError::Format {
        name,
        format,
        problem,
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
            write("thing.off", "OFF"),
            write("thing.ply", "ply"),
            write("thing.glb", "glTF"),
            write("thing.gltf", "{}"),
            write("thing.gltf", "[1"),
            write("words.obj", "v one two three\nf 1 2 3\n"),
            write("range.obj", "v 0 0 0\nf 1 2 3\n"),
            write("empty.obj", ""),
            write("words.stl", "words"),
            write("points.obj", "v 0 0 0\nv 1 0 0\n"),
            write("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"),
            write("nan.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n"),
            write(
                "pointer.obj",
                "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 9\n",
            ),
        ] {
            let message = Mesh::load(&path).unwrap_err().to_string();
            assert!(message.contains(&path.display().to_string()), "{message}");
            if path.ends_with("pointer.obj") {
                assert!(message.contains("git lfs pull"), "{message}");
            }
            if path.ends_with("nan.obj") {
                assert!(
                    message.contains("vertex 1 ") && message.contains("coordinate NaN"),
                    "{message}"
                );
            }
        }
    }
}
