//! Cache of baked fields in the user's cache folder, keyed by content.
//!
//! The cache cannot fail. If a file is missing, damaged, or belongs to another mesh or version, the field is baked again.
//! If the folder cannot be written, nothing is stored.

use std::fs;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::field::{Ball, Field, FieldReport, FieldSettings, Level};
use super::spline::Spline;
use crate::atomic_file;
use crate::mesh::{ExactMesh, Mesh};

/// Version of the cache. Raise it whenever baking or the file format changes, so that old files are no longer found.
const VERSION: u32 = 4;
const MAGIC: [u8; 8] = *b"LSFIELD\n";

impl Field {
    /// The field of `mesh` from the user's cache folder. A field that is not there is baked and stored.
    pub fn cached(mesh: &Mesh, exact: &ExactMesh, settings: &FieldSettings) -> Self {
        load_or_in(folder().as_deref(), mesh, settings, || {
            Self::bake(mesh, exact, settings)
        })
    }
}

fn load_or_in(
    folder: Option<&Path>,
    mesh: &Mesh,
    settings: &FieldSettings,
    bake: impl FnOnce() -> Field,
) -> Field {
    let Some(folder) = folder else {
        return bake();
    };
    let key = key(mesh, settings);
    let path = folder.join(format!("{key:032x}.field"));
    if let Some(field) = read(&path).and_then(|bytes| decode(&bytes, key)) {
        return field;
    }
    let field = bake();
    // Two processes that bake the same field write the same bytes. If the folder cannot be written, nothing is stored.
    let _ =
        fs::create_dir_all(folder).and_then(|()| atomic_file::write(&path, &encode(&field, key)));
    field
}

/// The bytes of a regular file. Other kinds are refused: opening a pipe waits for its writer, and a device may never end.
fn read(path: &Path) -> Option<Vec<u8>> {
    fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
    fs::read(path).ok()
}

/// `landscape/fields` in the system's folder for caches.
fn folder() -> Option<PathBuf> {
    let variable = |name| {
        std::env::var_os(name)
            .map(PathBuf::from)
            .filter(|path| path.is_absolute())
    };
    let base = if cfg!(target_os = "windows") {
        variable("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        variable("HOME").map(|home| home.join("Library/Caches"))
    } else {
        variable("XDG_CACHE_HOME").or_else(|| variable("HOME").map(|home| home.join(".cache")))
    };
    Some(base?.join("landscape").join("fields"))
}

/// 128-bit FNV-1a hash of everything that the field depends on.
fn key(mesh: &Mesh, settings: &FieldSettings) -> u128 {
    let mut hash = 0x6c62272e07bb014262b821756295c58d_u128;
    let mut feed = |bytes: &[u8]| {
        for &byte in bytes {
            hash = (hash ^ u128::from(byte)).wrapping_mul(0x0000000001000000000000000000013b);
        }
    };
    feed(&VERSION.to_le_bytes());
    feed(&settings.cell_m.unwrap_or(0.0).to_le_bytes());
    feed(&(settings.most_nodes as u64).to_le_bytes());
    for coordinate in mesh.vertices().iter().flatten() {
        feed(&coordinate.to_le_bytes());
    }
    for index in mesh.triangles().iter().flatten() {
        feed(&index.to_le_bytes());
    }
    if mesh.overlaps() {
        // Earlier versions baked such fields from distances to the single pieces.
        feed(b"union");
    }
    hash
}

/// 64-bit FNV-1a hash over words, to detect damage.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.chunks(8).fold(0xcbf29ce484222325, |hash, chunk| {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        (hash ^ u64::from_le_bytes(word)).wrapping_mul(0x00000100000001b3)
    })
}

/// The file of a field. It contains `key`, so that a renamed file is not taken for another field.
fn encode(field: &Field, key: u128) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(key.to_le_bytes());
    let vector = |bytes: &mut Vec<u8>, v: &Vector3<f64>| {
        v.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    };
    let report = &field.report;
    for number in [
        report.cell_m,
        report.max_error_m,
        report.max_error_anywhere_m,
        report.lipschitz,
    ] {
        bytes.extend(number.to_le_bytes());
    }
    vector(&mut bytes, &field.ball.centre);
    bytes.extend(field.ball.radius_m.to_le_bytes());
    bytes.extend((field.levels.len() as u64).to_le_bytes());
    for Level {
        low,
        high,
        shell_m,
        spline,
    } in &field.levels
    {
        vector(&mut bytes, low);
        vector(&mut bytes, high);
        vector(&mut bytes, &spline.origin);
        bytes.extend(shell_m.to_le_bytes());
        bytes.extend(spline.cell_m.to_le_bytes());
        spline
            .nodes
            .iter()
            .for_each(|&count| bytes.extend((count as u64).to_le_bytes()));
        spline
            .coefficients
            .iter()
            .for_each(|c| bytes.extend(c.to_le_bytes()));
    }
    bytes.extend(checksum(&bytes).to_le_bytes());
    bytes
}

/// The field in a complete file with the given key.
fn decode(bytes: &[u8], key: u128) -> Option<Field> {
    let (content, sum) = bytes.split_last_chunk::<8>()?;
    if checksum(content) != u64::from_le_bytes(*sum) {
        return None;
    }
    let mut reader = Reader(
        content
            .strip_prefix(&MAGIC)?
            .strip_prefix(&key.to_le_bytes())?,
    );
    let [cell_m, max_error_m, max_error_anywhere_m, lipschitz] = [
        reader.number()?,
        reader.number()?,
        reader.number()?,
        reader.number()?,
    ];
    let ball = Ball {
        centre: reader.vector()?,
        radius_m: reader.number()?,
    };
    let mut levels = Vec::new();
    for _ in 0..reader.count()? {
        let [low, high, origin] = [reader.vector()?, reader.vector()?, reader.vector()?];
        let [shell_m, cell_m] = [reader.number()?, reader.number()?];
        let nodes = [reader.count()?, reader.count()?, reader.count()?];
        let total = nodes[0].checked_mul(nodes[1])?.checked_mul(nodes[2])?;
        let coefficients = reader.take(total.checked_mul(4)?)?.chunks_exact(4);
        let coefficients = coefficients
            .map(|c| f32::from_le_bytes([c[0], c[1], c[2], c[3]]))
            .collect();
        levels.push(Level {
            low,
            high,
            shell_m,
            spline: Spline {
                origin,
                cell_m,
                nodes,
                coefficients,
            },
        });
    }
    let nodes = levels
        .iter()
        .map(|level| level.spline.coefficients.len())
        .sum();
    let report = FieldReport {
        cell_m,
        nodes,
        max_error_m,
        max_error_anywhere_m,
        lipschitz,
    };
    (reader.0.is_empty() && !levels.is_empty()).then_some(Field {
        levels,
        ball,
        report,
    })
}

/// Little-endian numbers from the front of a slice.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, tail) = self.0.split_at_checked(count)?;
        self.0 = tail;
        Some(head)
    }

    fn number(&mut self) -> Option<f64> {
        Some(f64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    fn count(&mut self) -> Option<usize> {
        usize::try_from(u64::from_le_bytes(self.take(8)?.try_into().ok()?)).ok()
    }

    fn vector(&mut self) -> Option<Vector3<f64>> {
        Some(Vector3::new(self.number()?, self.number()?, self.number()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::ExactMesh;

    fn tetrahedron(size_m: f64) -> Mesh {
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ];
        let vertices = corners
            .map(|corner| Vector3::from(corner) * size_m)
            .to_vec();
        Mesh::new(
            "tetrahedron",
            vertices,
            vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        )
        .unwrap()
    }

    fn bake(mesh: &Mesh, settings: &FieldSettings) -> Field {
        Field::bake(mesh, &ExactMesh::new(mesh), settings)
    }

    #[test]
    fn remembers_by_content_and_survives_damage() {
        let folder = tempfile::tempdir().unwrap();
        let within = Some(folder.path());
        let settings = FieldSettings {
            cell_m: Some(0.01),
            most_nodes: 5_000,
        };
        let mesh = tetrahedron(0.05);
        let baked = load_or_in(within, &mesh, &settings, || bake(&mesh, &settings));
        let again = load_or_in(within, &mesh, &settings, || panic!("baked twice"));
        assert_eq!(baked, again);

        let other = tetrahedron(0.06);
        let baked_other = load_or_in(within, &other, &settings, || bake(&other, &settings));
        assert_ne!(baked, baked_other);
        let files: Vec<_> = fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        assert_eq!(files.len(), 2, "no partial files are left: {files:?}");

        for file in &files {
            let mut bytes = fs::read(file).unwrap();
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
            fs::write(file, &bytes).unwrap();
        }
        let mut rebaked = false;
        let repaired = load_or_in(within, &mesh, &settings, || {
            rebaked = true;
            bake(&mesh, &settings)
        });
        assert!(rebaked);
        assert_eq!(repaired, baked);
    }

    #[test]
    fn the_field_of_another_mesh_is_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let within = Some(folder.path());
        let settings = FieldSettings {
            cell_m: Some(0.01),
            most_nodes: 5_000,
        };
        let [mesh, other] = [0.05, 0.06].map(tetrahedron);
        let baked = load_or_in(within, &mesh, &settings, || bake(&mesh, &settings));
        load_or_in(within, &other, &settings, || bake(&other, &settings));
        let file = |mesh: &Mesh| {
            folder
                .path()
                .join(format!("{:032x}.field", key(mesh, &settings)))
        };
        fs::copy(file(&other), file(&mesh)).unwrap();
        let found = load_or_in(within, &mesh, &settings, || bake(&mesh, &settings));
        assert_eq!(found, baked);
    }

    /// Opening a pipe waits for its other end; this test would never end.
    #[cfg(unix)]
    #[test]
    fn a_pipe_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let settings = FieldSettings {
            cell_m: Some(0.01),
            most_nodes: 5_000,
        };
        let mesh = tetrahedron(0.05);
        let name = folder
            .path()
            .join(format!("{:032x}.field", key(&mesh, &settings)));
        let made = std::process::Command::new("mkfifo").arg(&name).status();
        assert!(made.unwrap().success());
        let baked = bake(&mesh, &settings);
        let found = load_or_in(Some(folder.path()), &mesh, &settings, || baked.clone());
        assert_eq!(found, baked);
        // The file has taken its place.
        load_or_in(Some(folder.path()), &mesh, &settings, || {
            panic!("not remembered")
        });
    }

    #[test]
    fn works_without_a_folder() {
        let settings = FieldSettings {
            cell_m: Some(0.01),
            most_nodes: 5_000,
        };
        let mesh = tetrahedron(0.05);
        let file = tempfile::NamedTempFile::new().unwrap();
        let not_a_folder = file.path().join("fields");
        let baked = load_or_in(Some(&not_a_folder), &mesh, &settings, || {
            bake(&mesh, &settings)
        });
        assert_eq!(
            baked,
            load_or_in(None, &mesh, &settings, || bake(&mesh, &settings))
        );
    }

    #[test]
    fn truncated_files_are_refused() {
        let mesh = tetrahedron(0.05);
        let settings = FieldSettings {
            cell_m: Some(0.01),
            most_nodes: 5_000,
        };
        let bytes = encode(&bake(&mesh, &settings), 7);
        assert!(decode(&bytes, 7).is_some());
        assert!(decode(&bytes, 8).is_none());
        for length in [0, 7, 8, 100, bytes.len() - 1] {
            assert!(decode(&bytes[..length], 7).is_none());
        }
    }

    #[test]
    fn baking_gives_the_same_bytes_on_any_number_of_threads() {
        let mesh = tetrahedron(0.05);
        let settings = FieldSettings {
            cell_m: Some(0.004),
            most_nodes: 30_000,
        };
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| encode(&bake(&mesh, &settings), 0))
        };
        assert!(on(1) == on(3));
    }
}
