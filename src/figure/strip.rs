//! A row of rendered pictures below a graph.

use super::canvas::Canvas;
use super::image::Image;
use super::look::Look;
use super::style::{Anchor, Stroke, TextFace};
use super::theme::{INK, MARGIN, PALE_LINE, TEXT};

/// Pixels of a picture per canvas unit.
pub const PICTURE_DENSITY: u32 = 2;
const GAP: f64 = 12.0;
/// Thickness of the line in the colour of a picture.
const BAR: f64 = 8.0;
/// Radius of the symbol on this line.
const SYMBOL: f64 = 10.0;
/// Height between the graph and the pictures, where lines turn toward their pictures.
const FAN: f64 = 70.0;

/// A rendered picture and its place in the graph.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Its pixels, [`PICTURE_DENSITY`] per canvas unit.
    pub image: Image,
    /// Lines of text below it.
    pub texts: Vec<String>,
    /// Look of the symbol and line above it.
    pub look: Option<Look>,
    /// Point of the graph above that a line connects it to.
    pub of: Option<[f64; 2]>,
}

/// Side of each of `count` square pictures in a row on a sheet of the given width, canvas units.
pub fn side_in_row(width: u32, count: usize) -> u32 {
    let count = u32::try_from(count.max(1)).unwrap_or(u32::MAX);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive constants"
    )]
    let (gap, margin) = (GAP as u32, MARGIN as u32);
    (width.saturating_sub(2 * margin + gap * (count - 1)) / count).max(16)
}

/// Height of a row of pictures of this side below a graph, with `lines` lines of text.
pub fn row_height(side: u32, lines: usize) -> f64 {
    FAN + BAR + f64::from(side) + 1.3 * TEXT * lines as f64 + MARGIN
}

/// Draws square pictures in a row, the first at the left margin, below `top`.
pub fn draw_row(canvas: &mut Canvas, top: f64, pictures: &[Picture]) {
    let side = pictures
        .iter()
        .map(|picture| picture.image.width / PICTURE_DENSITY)
        .max()
        .unwrap_or(0);
    // All texts have the same size.
    let texts = pictures.iter().flat_map(|picture| &picture.texts);
    let face = texts.fold(
        TextFace::new(TEXT, INK).anchored(Anchor::Middle),
        |face, text| face.fitted(text, f64::from(side)),
    );
    let (mut left, above) = (MARGIN, top + FAN);
    for picture in pictures {
        let middle = left + 0.5 * f64::from(side);
        if let Some([x, y]) = picture.of {
            let stroke = Stroke::dashed(PALE_LINE, 2.0, 3.0, 4.0);
            canvas.line([x, y], [x, top], stroke);
            canvas.line([x, top], [middle, above], stroke);
        }
        if let Some(look) = picture.look {
            let corner = [left + f64::from(side), above + BAR];
            canvas.rectangle([left, above], corner, look.colour);
            look.draw(canvas, [middle, above - 0.5 * BAR], SYMBOL, 1.0);
        }
        let below = above + BAR;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "places on a sheet"
        )]
        let corner = [left.round() as u32, below.round() as u32];
        canvas.fine_image(corner, PICTURE_DENSITY, picture.image.clone());
        for (line, text) in picture.texts.iter().enumerate() {
            let y = below + f64::from(side) + (0.7 + 1.2 * line as f64) * TEXT;
            canvas.text([middle, y], text, face);
        }
        left += f64::from(side) + GAP;
    }
}
