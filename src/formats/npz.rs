//! Arrays of numbers from a `NumPy` archive (`.npz`): a ZIP file of `.npy` files.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use super::array::Numbers;
use super::npy;

/// Largest total size of all arrays, bytes.
const LARGEST: u64 = 256 << 20;

/// The arrays of an archive by name. Arrays of other items than numbers are left out.
pub(crate) fn read(bytes: &[u8]) -> Result<BTreeMap<String, Numbers>, String> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes))
        .map_err(|error| format!("is not a .npz archive: {error}"))?;
    let mut arrays = BTreeMap::new();
    let mut left = LARGEST;
    for index in 0..archive.len() {
        let file = archive.by_index(index).map_err(|error| {
            format!("cannot be unpacked ({error}): write it with numpy.savez or savez_compressed")
        })?;
        let name = file.name().map(Cow::into_owned);
        let name = name.map_err(|error| format!("contains an invalid file name: {error}"))?;
        let Some(name) = name.strip_suffix(".npy") else {
            continue;
        };
        let mut content = Vec::new();
        file.take(left + 1)
            .read_to_end(&mut content)
            .map_err(|error| format!("has an array `{name}` that cannot be read: {error}"))?;
        left = left
            .checked_sub(content.len() as u64)
            .ok_or_else(|| format!("unpacks to more than {} MB", LARGEST >> 20))?;
        let numbers = npy::numbers(&content);
        if let Some(numbers) = numbers
            .map_err(|problem| format!("has an array `{name}` that cannot be used: {problem}"))?
        {
            arrays.insert(name.to_owned(), numbers);
        }
    }
    Ok(arrays)
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_no_archive_is_refused() {
        assert!(super::read(b"PK no archive").is_err());
    }
}
