//! Hands of texts that refer to no other files.

use landscape::hand::{Hand, HandError, HandFiles};

/// The hand of a URDF or MJCF text and an optional side file.
pub(crate) fn described(text: &str, side_file: Option<&str>) -> Result<Hand, HandError> {
    let side = side_file.map(|side| ["hand.json", side]);
    let files = HandFiles::of_texts([["hand", text]].into_iter().chain(side));
    Hand::from_files(&files)
}
