//! Baked fields in the user's cache.

use nalgebra::Vector3;

use super::field::{Ball, Field, FieldReport, FieldSettings, Level};
use super::spline::Spline;
use crate::cache::{Cache, Key, Kind, Reader};
use crate::mesh::{ExactMesh, Mesh};

/// Version of the cache. Raise it whenever baking or the format changes, so that old files are no longer found.
const VERSION: u32 = 4;

impl Field {
    /// The field of `mesh` from the user's cache folder. A field that is not there is baked and kept.
    pub fn cached(mesh: &Mesh, exact: &ExactMesh, settings: &FieldSettings) -> Self {
        load_or_in(&Cache::of_user(), mesh, settings, || {
            Self::bake(mesh, exact, settings)
        })
    }
}

fn load_or_in(
    cache: &Cache,
    mesh: &Mesh,
    settings: &FieldSettings,
    bake: impl FnOnce() -> Field,
) -> Field {
    let key = key(mesh, settings);
    let kept = cache.find(Kind::Field, key);
    if let Some(field) = kept.and_then(|content| decode(&content)) {
        return field;
    }
    let field = bake();
    cache.keep(Kind::Field, key, &encode(&field));
    field
}

/// Hash of everything that the field depends on.
fn key(mesh: &Mesh, settings: &FieldSettings) -> Key {
    let mut key = Key::default();
    key.feed(&VERSION.to_le_bytes());
    key.feed(&settings.cell_m.unwrap_or(0.0).to_le_bytes());
    key.feed(&(settings.most_nodes as u64).to_le_bytes());
    for coordinate in mesh.vertices().iter().flatten() {
        key.feed(&coordinate.to_le_bytes());
    }
    for index in mesh.triangles().iter().flatten() {
        key.feed(&index.to_le_bytes());
    }
    if mesh.overlaps() {
        // Earlier versions baked such fields from distances to the single pieces.
        key.feed(b"union");
    }
    key
}

/// The numbers of a field.
fn encode(field: &Field) -> Vec<u8> {
    let mut bytes = Vec::new();
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
    bytes
}

/// The field of these numbers.
fn decode(content: &[u8]) -> Option<Field> {
    let mut reader = Reader(content);
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

    fn settings() -> FieldSettings {
        FieldSettings {
            cell_m: Some(0.01),
            most_nodes: 5_000,
        }
    }

    #[test]
    fn remembers_by_content_and_bakes_again_after_damage() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache {
            folder: Some(folder.path().to_path_buf()),
            ..Cache::of_user()
        };
        let settings = settings();
        let [mesh, other] = [0.05, 0.06].map(tetrahedron);
        let baked = load_or_in(&cache, &mesh, &settings, || bake(&mesh, &settings));
        let again = load_or_in(&cache, &mesh, &settings, || panic!("baked twice"));
        assert_eq!(baked, again);
        let baked_other = load_or_in(&cache, &other, &settings, || bake(&other, &settings));
        assert_ne!(baked, baked_other);

        // Sound as a file of the cache, but with too few numbers.
        let content = cache.find(Kind::Field, key(&mesh, &settings)).unwrap();
        cache.keep(Kind::Field, key(&mesh, &settings), &content[1..]);
        let mut rebaked = false;
        let repaired = load_or_in(&cache, &mesh, &settings, || {
            rebaked = true;
            bake(&mesh, &settings)
        });
        assert!(rebaked);
        assert_eq!(repaired, baked);
    }

    #[test]
    fn other_numbers_are_no_field() {
        let content = encode(&bake(&tetrahedron(0.05), &settings()));
        assert!(decode(&content).is_some());
        for length in [0, 7, 8, 100, content.len() - 1] {
            assert!(decode(&content[..length]).is_none());
        }
        let longer = [&content[..], &[0]].concat();
        assert!(decode(&longer).is_none());
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
            pool.install(|| encode(&bake(&mesh, &settings)))
        };
        assert!(on(1) == on(3));
    }
}
