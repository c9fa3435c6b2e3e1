//! Meshes on disk: OBJ, STL, PLY and glTF in, OBJ out.

use std::fmt::Write as _;
use std::io::{BufRead, Cursor};
use std::path::Path;

use nalgebra::Vector3;

use super::{Mesh, ObjectError, Repaired, gltf, ply};

/// Largest file that is read, bytes.
const LARGEST: u64 = 256 << 20;

/// Triangles as a file has them.
#[derive(Debug, Clone, Default)]
pub(super) struct Soup {
    pub(super) vertices: Vec<Vector3<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Soup {
    /// Adds a polygon as a fan.
    pub(super) fn polygon(&mut self, corners: &[u32]) {
        if let [first, rest @ ..] = corners {
            let fan = rest.windows(2).map(|pair| [*first, pair[0], pair[1]]);
            self.triangles.extend(fan);
        }
    }
}

/// The bytes of a file, unless it is too large to be a mesh.
pub(super) fn bytes_of(path: &Path) -> std::io::Result<Vec<u8>> {
    let told = std::fs::metadata(path)?;
    if !told.is_file() {
        return Err(std::io::Error::other("it is no file"));
    }
    if told.len() > LARGEST {
        let problem = format!("it is larger than {} MB", LARGEST >> 20);
        return Err(std::io::Error::other(problem));
    }
    std::fs::read(path)
}

impl Mesh {
    /// Reads an OBJ, STL, PLY or glTF file (`.gltf`, `.glb`), in metres, repaired where that is needed and safe.
    ///
    /// # Errors
    /// Where the file cannot be read, is of another kind, holds no valid mesh (see [`Mesh::repaired`]), or its size cannot
    /// be metres.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ObjectError> {
        let path = path.as_ref();
        let mesh = Self::read(path, 1.0)?.mesh;
        mesh.check_size(&path.display().to_string())?;
        Ok(mesh)
    }

    /// Reads an OBJ, STL, PLY or glTF file (`.gltf`, `.glb`) and multiplies its coordinates by `scale`; tells what was
    /// repaired. Any size is accepted.
    ///
    /// # Errors
    /// Where the file cannot be read, is of another kind, or holds no valid mesh (see [`Mesh::repaired`]).
    pub fn read(path: &Path, scale: f64) -> Result<Repaired, ObjectError> {
        let mut soup = soup(path)?;
        for vertex in &mut soup.vertices {
            *vertex *= scale;
        }
        Self::repaired(&path.display().to_string(), soup.vertices, soup.triangles)
    }

    /// Reads the text of an OBJ file; all its objects and groups make one mesh.
    ///
    /// # Errors
    /// Where the text is no OBJ or holds no valid mesh (see [`Mesh::new`]).
    pub fn from_obj(name: &str, reader: &mut impl BufRead) -> Result<Self, ObjectError> {
        let soup = obj(name, reader)?;
        Self::new(name, soup.vertices, soup.triangles)
    }

    /// The mesh as OBJ text, coordinates to the micrometre, or to a millionth of its size where that is less than a metre
    /// by far.
    pub fn to_obj(&self) -> String {
        let mut text = String::new();
        let mut decimals = 6;
        let mut size = self.size_m();
        while size < 1e-3 && decimals < 30 {
            size *= 10.0;
            decimals += 1;
        }
        for v in self.vertices() {
            writeln!(
                text,
                "v {:.decimals$} {:.decimals$} {:.decimals$}",
                v.x, v.y, v.z
            )
            .expect("a String takes all text");
        }
        for [a, b, c] in self.triangles() {
            writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("a String takes all text");
        }
        text
    }
}

/// The triangles of a file.
fn soup(path: &Path) -> Result<Soup, ObjectError> {
    let name = path.display().to_string();
    let kind = path
        .extension()
        .map(|kind| kind.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    if !["obj", "stl", "ply", "gltf", "glb"].contains(&kind.as_str()) {
        return Err(ObjectError::Kind {
            path: path.to_owned(),
        });
    }
    let cannot = |source| ObjectError::Read {
        path: path.to_owned(),
        source,
    };
    let bytes = bytes_of(path).map_err(cannot)?;
    let format = |format| {
        let name = name.clone();
        move |problem| ObjectError::Format {
            name,
            format,
            problem,
        }
    };
    match kind.as_str() {
        "obj" => obj(&name, &mut bytes.as_slice()),
        "stl" => stl(&bytes).map_err(cannot),
        "ply" => ply::read(&bytes).map_err(format("PLY")),
        _ => {
            let folder = path.parent().unwrap_or(Path::new(""));
            gltf::read(&bytes, folder).map_err(format("glTF"))
        }
    }
}

fn stl(bytes: &[u8]) -> std::io::Result<Soup> {
    let stl = stl_io::read_stl(&mut Cursor::new(bytes))?;
    let index = |vertex: usize| u32::try_from(vertex).unwrap_or(u32::MAX);
    Ok(Soup {
        vertices: stl
            .vertices
            .iter()
            .map(|v| Vector3::new(v[0].into(), v[1].into(), v[2].into()))
            .collect(),
        triangles: stl
            .faces
            .iter()
            .map(|face| face.vertices.map(index))
            .collect(),
    })
}

/// The triangles of the text of an OBJ file.
pub(super) fn obj(name: &str, reader: &mut impl BufRead) -> Result<Soup, ObjectError> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) =
        tobj::load_obj_buf(reader, &options, no_materials).map_err(|source| ObjectError::Obj {
            name: name.to_owned(),
            source,
        })?;
    let mut soup = Soup::default();
    for model in models {
        let first = u32::try_from(soup.vertices.len()).unwrap_or(u32::MAX);
        let positions = model.mesh.positions.chunks_exact(3);
        soup.vertices.extend(
            positions
                .map(Vector3::from_column_slice)
                .map(|v| v.map(f64::from)),
        );
        let corners = model.mesh.indices.chunks_exact(3);
        let triangles = corners.map(|t| [t[0] + first, t[1] + first, t[2] + first]);
        soup.triangles.extend(triangles);
    }
    Ok(soup)
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
        ] {
            let message = Mesh::load(&path).unwrap_err().to_string();
            assert!(message.contains(&path.display().to_string()), "{message}");
        }
    }
}
