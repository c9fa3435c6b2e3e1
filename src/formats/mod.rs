//! Readers and writers of file formats for numbers, triangles and tables.
//!
//! Each format has one reader, which returns plain data. The modules that use the data decide what it means: for example,
//! the mesh of an object must be closed, but that of a hand need not be. Errors are half a sentence that states the
//! problem, unless their type says otherwise.

use std::path::Path;

use nalgebra::Vector3;

#[cfg_attr(
    not(feature = "cli"),
    expect(dead_code, reason = "the part that only pickles and tables need")
)]
pub(crate) mod array;
pub(crate) mod collada;
#[cfg(feature = "cli")]
pub(crate) mod csv_text;
pub(crate) mod gltf;
pub(crate) mod msh;
#[cfg_attr(
    not(feature = "cli"),
    expect(dead_code, reason = "files of numpy are written by `store` only")
)]
pub(crate) mod npy;
pub(crate) mod npz;
pub(crate) mod obj;
#[cfg(feature = "cli")]
pub(crate) mod pickle;
#[cfg(feature = "cli")]
pub(crate) mod pickle_writer;
pub(crate) mod ply;
pub(crate) mod stl;
pub mod toml_text;
#[cfg(feature = "cli")]
pub(crate) mod torch;
#[cfg(feature = "cli")]
pub(crate) mod yaml_text;

/// Largest size of a file of triangles, bytes.
const LARGEST: u64 = 256 << 20;

/// Unchecked triangles of a file. They may be open or inside out, and indices may be invalid.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Triangles {
    pub(crate) vertices: Vec<Vector3<f64>>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Triangles {
    /// Adds a polygon as a triangle fan.
    fn polygon(&mut self, corners: &[u32]) {
        if let [first, rest @ ..] = corners {
            let fan = rest.windows(2).map(|pair| [*first, pair[0], pair[1]]);
            self.triangles.extend(fan);
        }
    }
}

/// The ending of a file's name in lower case, without its dot; empty if there is none.
pub(crate) fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default();
    ending.to_string_lossy().to_lowercase()
}

/// Whether these bytes are a pointer of Git LFS, which stands for a file until `git lfs pull` has fetched it.
pub(crate) fn lfs_pointer(bytes: &[u8]) -> bool {
    bytes.starts_with(b"version https://git-lfs.github.com/spec/")
}

/// The bytes of a file of triangles.
///
/// # Errors
/// If the file cannot be read, is not a regular file, or is larger than 256 MB.
pub(crate) fn bytes_of(path: &Path) -> std::io::Result<Vec<u8>> {
    let told = std::fs::metadata(path)?;
    if !told.is_file() {
        return Err(std::io::Error::other("it is not a file"));
    }
    if told.len() > LARGEST {
        let problem = format!("it is larger than {} MB", LARGEST >> 20);
        return Err(std::io::Error::other(problem));
    }
    std::fs::read(path)
}
