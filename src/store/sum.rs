//! The checksum of a Parquet file, kept in its own footer.
//!
//! The parquet crate writes no checksums of pages, and those would not cover the footer, which says what the pages mean.
//! So each file of ours holds, under [`KEY`], the [`content_hash`] of all its bytes before and after that hash.

use parquet::file::metadata::FileMetaData;

use super::metadata::content_hash;

/// Parquet metadata key of the checksum.
pub(super) const KEY: &str = "landscape_checksum";
/// What stands there until the file is complete; as long as a [`content_hash`].
pub(super) const PLACE: &str = "here the checksum is to be put.|";
/// Start of `created_by` in files of ours.
pub(super) const WRITER: &str = "landscape version ";

/// Puts the checksum into a complete file that holds [`PLACE`].
///
/// # Panics
/// If the file does not hold it.
pub(super) fn fill(bytes: &mut [u8]) {
    let start = last(bytes, PLACE.as_bytes()).expect("the footer holds what was given for it");
    let sum = sum(bytes, start);
    bytes[start..start + PLACE.len()].copy_from_slice(sum.as_bytes());
}

/// Whether `bytes`, whose footer is `footer`, are as they were written. A file without a checksum is, and so is what
/// another program wrote from ours: it may have kept our metadata, but has signed the file itself.
pub(super) fn fits(bytes: &[u8], footer: &FileMetaData) -> bool {
    let ours = footer
        .created_by()
        .is_some_and(|writer| writer.starts_with(WRITER));
    let mut pairs = footer.key_value_metadata().into_iter().flatten();
    let told = pairs.find(|pair| pair.key == KEY);
    match told.filter(|_| ours) {
        Some(told) => {
            let told = told.value.as_deref().unwrap_or_default();
            told.len() == PLACE.len()
                && last(bytes, told.as_bytes()).is_some_and(|start| sum(bytes, start) == told)
        }
        None => true,
    }
}

/// The checksum of all bytes but those at `start`, where it stands.
fn sum(bytes: &[u8], start: usize) -> String {
    content_hash(&[&bytes[..start], &bytes[start + PLACE.len()..]])
}

/// Where `text` occurs last: the footer is at the end, and our metadata stand before the checksum.
fn last(bytes: &[u8], text: &[u8]) -> Option<usize> {
    bytes.windows(text.len()).rposition(|window| window == text)
}
