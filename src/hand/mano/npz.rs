//! Arrays of numbers from a `NumPy` archive (`.npz`): a ZIP file of `.npy` files.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};

/// Most bytes of all arrays together.
const LARGEST: u64 = 256 << 20;

/// An array, in C order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    pub(super) shape: Vec<usize>,
    pub(super) values: Vec<f64>,
}

/// The arrays of an archive by name, those of other things than numbers left out.
///
/// # Errors
/// Half a sentence: what is wrong with the file.
pub(super) fn read(bytes: &[u8]) -> Result<BTreeMap<String, Array>, String> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes))
        .map_err(|error| format!("it is no .npz archive: {error}"))?;
    let mut arrays = BTreeMap::new();
    let mut left = LARGEST;
    for index in 0..archive.len() {
        let file = archive.by_index(index).map_err(|error| {
            format!(
                "it cannot be unpacked ({error}): write it with numpy.savez or savez_compressed"
            )
        })?;
        let name = file.name().map(Cow::into_owned);
        let name = name.map_err(|error| format!("it names a file badly: {error}"))?;
        let Some(name) = name.strip_suffix(".npy") else {
            continue;
        };
        let mut content = Vec::new();
        file.take(left + 1)
            .read_to_end(&mut content)
            .map_err(|error| format!("its array `{name}` cannot be read: {error}"))?;
        left = left
            .checked_sub(content.len() as u64)
            .ok_or_else(|| format!("it holds more than {} MB", LARGEST >> 20))?;
        if let Some(array) =
            array(&content).map_err(|problem| format!("its array `{name}` {problem}"))?
        {
            arrays.insert(name.to_owned(), array);
        }
    }
    Ok(arrays)
}

/// The text between `before` and `after` in a header.
fn between<'a>(header: &'a str, before: &str, after: char) -> Option<&'a str> {
    let rest = header[header.find(before)? + before.len()..].trim_start();
    Some(rest[..rest.find(after)?].trim())
}

/// An `.npy` file (format 1 to 3, NEP 1); `None` where its elements are no numbers.
fn array(bytes: &[u8]) -> Result<Option<Array>, String> {
    let broken = || "is no .npy file".to_owned();
    let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or_else(broken)?;
    let (length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => {
            let length = u32::from_le_bytes([*a, *b, *c, *d]);
            (usize::try_from(length).unwrap_or(usize::MAX), rest)
        }
        _ => return Err(broken()),
    };
    let (header, data) = rest.split_at_checked(length).ok_or_else(broken)?;
    let header = std::str::from_utf8(header).ok().ok_or_else(broken)?;
    let kind = between(header, "'descr':", ',').ok_or_else(broken)?;
    let fortran = between(header, "'fortran_order':", ',').ok_or_else(broken)? == "True";
    let shape: Option<Vec<usize>> = between(header, "'shape':", ')')
        .and_then(|text| text.strip_prefix('('))
        .ok_or_else(broken)?
        .split(',')
        .map(str::trim)
        .filter(|word| !word.is_empty())
        .map(|word| word.parse().ok())
        .collect();
    let shape = shape.ok_or_else(broken)?;
    let values: Vec<f64> = match kind.trim_matches('\'') {
        "<f8" => words(data).iter().map(|&b| f64::from_le_bytes(b)).collect(),
        "<f4" => words(data)
            .iter()
            .map(|&b| f32::from_le_bytes(b).into())
            .collect(),
        "<u4" => words(data)
            .iter()
            .map(|&b| u32::from_le_bytes(b).into())
            .collect(),
        "<i4" => words(data)
            .iter()
            .map(|&b| i32::from_le_bytes(b).into())
            .collect(),
        "<i8" => words(data)
            .iter()
            .map(|&b| i64::from_le_bytes(b) as f64)
            .collect(),
        "<u8" => words(data)
            .iter()
            .map(|&b| u64::from_le_bytes(b) as f64)
            .collect(),
        _ => return Ok(None),
    };
    let count = shape
        .iter()
        .try_fold(1usize, |count, side| count.checked_mul(*side));
    if count != Some(values.len()) {
        return Err(format!(
            "holds {} numbers, not those of its shape {shape:?}",
            values.len()
        ));
    }
    Ok(Some(if fortran {
        in_c_order(&shape, &values)
    } else {
        Array { shape, values }
    }))
}

fn words<const N: usize>(data: &[u8]) -> &[[u8; N]] {
    data.as_chunks().0
}

/// From first index fastest to last index fastest.
fn in_c_order(shape: &[usize], values: &[f64]) -> Array {
    let mut index = vec![0; shape.len()];
    let ordered = (0..values.len()).map(|_| {
        let (mut place, mut stride) = (0, 1);
        for (i, side) in index.iter().zip(shape) {
            place += i * stride;
            stride *= side;
        }
        for (i, side) in index.iter_mut().zip(shape).rev() {
            *i += 1;
            if *i < *side {
                break;
            }
            *i = 0;
        }
        values[place]
    });
    Array {
        values: ordered.collect(),
        shape: shape.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    #[test]
    fn both_orders_are_read() {
        let data: Vec<u8> = (0..6).flat_map(|i: i32| i.to_le_bytes()).collect();
        let c = npy(
            "{'descr': '<i4', 'fortran_order': False, 'shape': (2, 3), }",
            &data,
        );
        let array = super::array(&c).unwrap().unwrap();
        assert_eq!(
            (array.shape, array.values),
            (vec![2, 3], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
        );
        let fortran = npy(
            "{'descr': '<i4', 'fortran_order': True, 'shape': (2, 3), }",
            &data,
        );
        let array = super::array(&fortran).unwrap().unwrap();
        assert_eq!(array.values, [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
    }

    #[test]
    fn what_is_no_array_is_refused() {
        let short = npy(
            "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }",
            &[0; 8],
        );
        assert!(super::array(&short).unwrap_err().contains("1 numbers"));
        let huge = npy(
            "{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296, 2), }",
            &[],
        );
        assert!(super::array(&huge).is_err());
        let objects = npy(
            "{'descr': '|O', 'fortran_order': False, 'shape': (), }",
            b"anything",
        );
        assert_eq!(super::array(&objects), Ok(None));
        for bytes in [
            &b""[..],
            b"\x93NUMPY",
            b"\x93NUMPY\x01\x00\xff\xff{}",
            b"\x93NUMPY\x01\x00\x02\x00{}",
        ] {
            assert!(super::array(bytes).is_err());
        }
        assert!(read(b"PK no archive").is_err());
    }
}
