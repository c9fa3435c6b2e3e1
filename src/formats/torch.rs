//! Files of `torch.save`: a ZIP file with a pickle and the raw numbers of its tensors.
//!
//! ```text
//! NAME/data.pkl     the values; tensors refer to storages by key
//! NAME/data/KEY     the numbers of a storage
//! NAME/byteorder    "little" or "big"; little if it is missing
//! ```
//!
//! The pickle is that of [`pickle`](super::pickle): nothing is executed.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use super::pickle::{Heap, Id, Storages, load_with};

/// Largest total size of all members, bytes.
const LARGEST: u64 = 1 << 30;

/// Reads the values of a file. Returns them and the number of the result. Errors are half a sentence that states the problem.
pub(crate) fn read(bytes: &[u8]) -> Result<(Heap, Id), String> {
    if !bytes.starts_with(b"PK") {
        return Err(
            "it is not a ZIP file, as torch.save has written since version 1.6: load it with torch and save it again".to_owned(),
        );
    }
    let members = members(bytes)?;
    let mut pickles = members
        .keys()
        .filter_map(|name| name.strip_suffix("data.pkl"));
    let folder = pickles
        .next()
        .ok_or("it has no data.pkl, so torch.save did not write it")?
        .to_owned();
    let member = |name: &str| members.get(&format!("{folder}{name}")).map(Vec::as_slice);
    let below = format!("{folder}data/");
    let numbers = members.iter().filter_map(|(name, bytes)| {
        let key = name.strip_prefix(&below)?;
        Some((key.to_owned(), bytes.as_slice()))
    });
    let storages = Storages {
        numbers: numbers.collect(),
        big: member("byteorder") == Some(b"big"),
    };
    load_with(member("data.pkl").unwrap_or_default(), &storages)
        .map_err(|problem| format!("its pickle cannot be read: {problem}"))
}

fn members(bytes: &[u8]) -> Result<BTreeMap<String, Vec<u8>>, String> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes))
        .map_err(|error| format!("its ZIP archive cannot be read: {error}"))?;
    let mut members = BTreeMap::new();
    let mut left = LARGEST;
    for index in 0..archive.len() {
        let file = archive
            .by_index(index)
            .map_err(|error| format!("its ZIP archive cannot be unpacked: {error}"))?;
        let name = file.name().map(Cow::into_owned);
        let name = name.map_err(|error| format!("it contains an invalid file name: {error}"))?;
        let mut content = Vec::new();
        file.take(left + 1)
            .read_to_end(&mut content)
            .map_err(|error| format!("its member `{name}` cannot be read: {error}"))?;
        left = left
            .checked_sub(content.len() as u64)
            .ok_or_else(|| format!("it unpacks to more than {} MB", LARGEST >> 20))?;
        members.insert(name, content);
    }
    Ok(members)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// A file with this pickle and the storage 0 of 32-bit numbers.
    fn saved(pickle: &[u8], numbers: &[f32]) -> Vec<u8> {
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        let options = zip::write::SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Stored);
        let raw: Vec<u8> = numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect();
        for (name, content) in [("a/data.pkl", pickle), ("a/data/0", &raw)] {
            archive.start_file(name, options).unwrap();
            archive.write_all(content).unwrap();
        }
        archive.finish().unwrap().into_inner()
    }

    /// `torch._utils._rebuild_tensor_v2` with an offset, two sides and two strides.
    fn tensor([offset, rows, columns, down, right]: [u8; 5]) -> Vec<u8> {
        let storage = b"((X\x07\x00\x00\x00storagectorch\nFloatStorage\nX\x01\x00\x00\x000X\x03\x00\x00\x00cpuK\x06tQ";
        let view = [
            b'K', offset, b'K', rows, b'K', columns, 0x86, b'K', down, b'K', right, 0x86,
        ];
        [
            &b"\x80\x02ctorch._utils\n_rebuild_tensor_v2\n"[..],
            storage,
            &view,
            b"\x89ccollections\nOrderedDict\n)RtR.",
        ]
        .concat()
    }

    #[test]
    fn views_of_a_storage_are_arrays() {
        let numbers = [0.0, 1.0, 2.0, 3.0, 4.0, 5.5];
        let read = |view| {
            let (heap, whole) = read(&saved(&tensor(view), &numbers))?;
            Ok::<_, String>(heap.numbers(whole).unwrap())
        };
        let whole = read([0, 2, 3, 3, 1]).unwrap();
        assert_eq!(
            (whole.shape, whole.values),
            (vec![2, 3], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.5])
        );
        // A transposed part, and one number that stands for all.
        assert_eq!(read([1, 2, 2, 1, 3]).unwrap().values, [1.0, 4.0, 2.0, 5.5]);
        assert_eq!(read([2, 3, 1, 0, 0]).unwrap().values, [2.0; 3]);
        assert_eq!(read([9, 0, 3, 3, 1]).unwrap().values, [0.0; 0]);
        assert!(read([1, 2, 3, 3, 1]).unwrap_err().contains("beyond"));
    }

    #[test]
    fn nothing_is_executed_and_little_stays_little() {
        let said = |pickle: &[u8]| read(&saved(pickle, &[1.0])).unwrap_err();
        assert!(said(b"\x80\x02cos\nsystem\nX\x02\x00\x00\x00ls\x85R.").contains("os.system"));
        assert!(said(b"\x80\x02K\x01Q.").contains("storage"));
        assert!(said(&tensor([0, 255, 255, 0, 0])).contains("far more values"));
        assert!(super::read(b"\x80\x02}.").unwrap_err().contains("ZIP"));
    }
}
