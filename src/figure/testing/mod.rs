//! Shared by the tests of pictures: synthetic landscapes, checks of every picture, and a gallery to look at.

use super::canvas::Canvas;

#[cfg(feature = "topography")]
mod networks;

#[cfg(feature = "topography")]
pub(super) use networks::{forest, random_links, random_network, random_tree};

/// Asserts that every text lies on the sheet and that no two texts touch.
pub(crate) fn assert_legible(canvas: &Canvas) {
    let texts = canvas.texts();
    for (index, (text, [left, top, right, bottom])) in texts.iter().enumerate() {
        assert!(
            *left >= 0.0 && *top >= 0.0 && *right <= canvas.width() && *bottom <= canvas.height(),
            "{text:?} is cut off: {left} {top} {right} {bottom}"
        );
        for (other, rectangle) in &texts[..index] {
            let overlap = *left < rectangle[2]
                && rectangle[0] < *right
                && *top < rectangle[3]
                && rectangle[1] < *bottom;
            assert!(!overlap, "{text:?} touches {other:?}");
        }
    }
}

/// Writes the picture as SVG and PNG into the folder named by `LANDSCAPE_GALLERY`, to be looked at. If it is unset, only an
/// SVG is written, into a temporary folder.
pub(crate) fn gallery(canvas: &Canvas, name: &str) {
    let vanishing = tempfile::tempdir().expect("a folder");
    let wanted = std::env::var_os("LANDSCAPE_GALLERY").map(std::path::PathBuf::from);
    let folder = wanted.as_deref().unwrap_or(vanishing.path());
    canvas
        .save(&folder.join(format!("{name}.svg")))
        .expect("an SVG");
    if wanted.is_some() {
        canvas
            .save(&folder.join(format!("{name}.png")))
            .expect("a PNG");
    }
}
