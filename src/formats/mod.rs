//! The ground floor of files: bytes in, numbers, triangles and tables out.
//!
//! There is one reader for each format, and what it returns is plain data. What the data means is decided where it is used:
//! a mesh of an object must be closed, one of a hand need not be. Errors are half a sentence that says what is wrong with
//! the file, unless their type says otherwise.

use std::path::Path;

use nalgebra::Vector3;

#[cfg_attr(
    not(feature = "cli"),
    expect(dead_code, reason = "the part that only pickles and tables need")
)]
pub(crate) mod array;
#[cfg(feature = "cli")]
pub(crate) mod csv;
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

/// Largest file of triangles that is read, bytes.
const LARGEST: u64 = 256 << 20;

/// Triangles as a file has them: perhaps open, perhaps inside out, their indices unchecked.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Triangles {
    pub(crate) vertices: Vec<Vector3<f64>>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Triangles {
    /// Adds a polygon as a fan.
    fn polygon(&mut self, corners: &[u32]) {
        if let [first, rest @ ..] = corners {
            let fan = rest.windows(2).map(|pair| [*first, pair[0], pair[1]]);
            self.triangles.extend(fan);
        }
    }
}

/// The ending of a file's name in small letters, without its dot; empty where there is none.
pub(crate) fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default();
    ending.to_string_lossy().to_lowercase()
}

/// The bytes of a file, unless it is too large to be a mesh.
///
/// # Errors
/// Where it cannot be read, is no file, or is larger than 256 MB.
pub(crate) fn bytes_of(path: &Path) -> std::io::Result<Vec<u8>> {
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
