//! `MuJoCo`'s mesh format (`.msh`): four counts (vertices, normals, texture coordinates, triangles), then these data. All
//! numbers have four bytes, little-endian.

use nalgebra::Vector3;

use super::Triangles;

/// Reads the bytes of an MSH file.
pub(crate) fn read(bytes: &[u8]) -> Result<Triangles, String> {
    triangles(bytes).ok_or_else(|| "it is not an MSH file of MuJoCo".to_owned())
}

fn triangles(bytes: &[u8]) -> Option<Triangles> {
    let (words, []) = bytes.as_chunks::<4>() else {
        return None;
    };
    let (counts, words) = words.split_first_chunk::<4>()?;
    let count = |i: usize| usize::try_from(i32::from_le_bytes(counts[i])).ok();
    let mut rest = words;
    let mut take = |count: usize, each: usize| {
        let (head, tail) = rest.split_at_checked(count.checked_mul(each)?)?;
        rest = tail;
        Some(head)
    };
    let points = take(count(0)?, 3)?.as_chunks::<3>().0;
    take(count(1)?, 3)?;
    take(count(2)?, 2)?;
    let corners = take(count(3)?, 3)?.as_chunks::<3>().0;
    rest.is_empty().then(|| Triangles {
        vertices: points
            .iter()
            .map(|v| Vector3::from(v.map(|word| f64::from(f32::from_le_bytes(word)))))
            .collect(),
        triangles: corners.iter().map(|t| t.map(u32::from_le_bytes)).collect(),
    })
}
