//! The checksum of a Parquet file, stored in its own footer.
//!
//! The parquet crate writes no checksums of pages, and those would not cover the footer, which describes the pages. Each
//! file of this program therefore has, under [`KEY`], the [`content_hash`] of all its bytes before and after that hash.

use parquet::file::metadata::FileMetaData;

use super::metadata::content_hash;

/// Parquet metadata key of the checksum.
pub(super) const KEY: &str = "landscape_checksum";
/// Placeholder until the file is complete. It is as long as a [`content_hash`].
pub(super) const PLACE: &str = "here the checksum is to be put.|";
/// Start of `created_by` in files of this program.
pub(super) const WRITER: &str = "landscape version ";

/// Writes the checksum into a complete file that contains [`PLACE`].
///
/// # Panics
/// If the file does not contain it.
pub(super) fn fill(bytes: &mut [u8]) {
    let start = last(bytes, PLACE.as_bytes()).expect("the footer holds what was given for it");
    let sum = sum(bytes, start);
    bytes[start..start + PLACE.len()].copy_from_slice(sum.as_bytes());
}

/// Whether `bytes`, whose footer is `footer`, are unchanged. Files without a checksum are accepted, and so are files that
/// another program wrote: it may have copied the metadata, but `created_by` names that program.
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

/// The checksum of all bytes except those of the checksum itself, at `start`.
fn sum(bytes: &[u8], start: usize) -> String {
    content_hash(&[&bytes[..start], &bytes[start + PLACE.len()..]])
}

/// Last occurrence of `text`. The footer is at the end, and the metadata of this program come before the checksum.
fn last(bytes: &[u8], text: &[u8]) -> Option<usize> {
    bytes.windows(text.len()).rposition(|window| window == text)
}
