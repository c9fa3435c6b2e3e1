//! Lines of text below a picture that say what the names in it mean.

use super::canvas::Canvas;
use super::style::TextFace;
use super::text_width;
use super::theme::{INK, MARGIN, TEXT};

const SIZE: f64 = 0.9 * TEXT;
const ROW: f64 = 1.42 * SIZE;
const GAP: f64 = 12.0;

/// Height of `count` lines with the margin below them, canvas units; 0 for none.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a length on a sheet"
)]
pub(super) fn notes_height(count: usize) -> u32 {
    if count == 0 {
        return 0;
    }
    (ROW * count as f64 + MARGIN).ceil() as u32
}

/// Draws the lines at the bottom of the sheet: each name in bold, then what it means.
pub(super) fn draw_notes(canvas: &mut Canvas, notes: &[(String, String)]) {
    let bold = TextFace::new(SIZE, INK).bold();
    let widths = notes.iter().map(|(name, _)| text_width(name, SIZE, true));
    let left = MARGIN + widths.fold(0.0, f64::max) + GAP;
    let room = canvas.width() - MARGIN - left;
    let top = canvas.height() - f64::from(notes_height(notes.len()));
    for (row, (name, text)) in notes.iter().enumerate() {
        let y = top + (row as f64 + 0.5) * ROW;
        canvas.text([MARGIN, y], name, bold);
        let face = TextFace::new(SIZE, INK).fitted(text, room);
        canvas.text([left, y], text, face);
    }
}
