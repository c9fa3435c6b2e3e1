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

/// What the checksum of a file says of its content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Seal {
    /// The bytes are those that this program wrote.
    Whole,
    /// The bytes have changed since this program wrote them.
    Broken,
    /// Another program wrote the file, or a version of this one without checksums.
    Absent,
}

/// What the checksum in `footer` says of `bytes`, whose footer it is. Another program may have copied the metadata and with
/// them the checksum, but then `created_by` names that program.
pub(super) fn seal(bytes: &[u8], footer: &FileMetaData) -> Seal {
    let ours = footer
        .created_by()
        .is_some_and(|writer| writer.starts_with(WRITER));
    let mut pairs = footer.key_value_metadata().into_iter().flatten();
    let Some(told) = pairs.find(|pair| pair.key == KEY).filter(|_| ours) else {
        return Seal::Absent;
    };
    let told = told.value.as_deref().unwrap_or_default();
    let fits = told.len() == PLACE.len()
        && last(bytes, told.as_bytes()).is_some_and(|start| sum(bytes, start) == told);
    if fits { Seal::Whole } else { Seal::Broken }
}

/// The checksum of all bytes except those of the checksum itself, at `start`.
fn sum(bytes: &[u8], start: usize) -> String {
    content_hash(&[&bytes[..start], &bytes[start + PLACE.len()..]])
}

/// Last occurrence of `text`. The footer is at the end, and the metadata of this program come before the checksum.
fn last(bytes: &[u8], text: &[u8]) -> Option<usize> {
    bytes.windows(text.len()).rposition(|window| window == text)
}
