//! The records of a journal, read without opening it, because a running process may be writing it.

use std::fs;
use std::path::Path;

/// Key and end of each complete record (see `store::Journal` for the format); none if there is no journal yet.
pub(crate) fn records(journal: &Path) -> Vec<(String, usize)> {
    let bytes = fs::read(journal).unwrap_or_default();
    let number = |at: usize| {
        let four = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes(four.try_into().unwrap()) as usize)
    };
    let magic = b"landscape journal 1\n".len();
    let mut keys = Vec::new();
    let mut at = magic + 8 + number(magic).unwrap_or(usize::from(u16::MAX));
    while let (Some(key), Some(payload)) = (number(at), number(at + 4)) {
        let Some(name) = bytes.get(at + 12..at + 12 + key) else {
            break;
        };
        at += 12 + key + payload;
        if at > bytes.len() {
            break;
        }
        keys.push((String::from_utf8(name.to_vec()).unwrap(), at));
    }
    keys
}
