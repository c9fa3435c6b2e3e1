//! Many rendered images on one sheet.

use std::path::Path;

use super::FigureError;
use super::canvas::Canvas;
use super::image::Image;
use super::style::{Anchor, TextFace};
use super::theme::INK;

/// Writes `images` as a PNG grid of `columns` columns, each image with its caption below. A missing caption is left empty.
///
/// # Errors
/// As [`Canvas::save`].
pub fn contact_sheet(
    images: &[Image],
    captions: &[String],
    columns: usize,
    path: &Path,
) -> Result<(), FigureError> {
    contact_sheet_canvas(images, captions, columns).save(path)
}

/// The grid of [`contact_sheet`] as a canvas.
///
/// # Panics
/// If there are 2³² images or more.
pub fn contact_sheet_canvas(images: &[Image], captions: &[String], columns: usize) -> Canvas {
    let columns = columns.clamp(1, images.len().max(1));
    let whole = |count: usize| u32::try_from(count).expect("a sheet has fewer than 2³² images");
    let cell_width = images.iter().map(|image| image.width).max().unwrap_or(64);
    let cell_height = images.iter().map(|image| image.height).max().unwrap_or(64);
    // Text is in proportion to the images, so that it stays readable when the sheet is shrunk to a page.
    let text = (cell_width / 13).max(11);
    let caption_height = if captions.iter().any(|caption| !caption.is_empty()) {
        text * 3 / 2
    } else {
        0
    };
    let gap = (cell_width / 24).max(4);
    let rows = images.len().div_ceil(columns);
    let size = |count: usize, cell: u32| gap + whole(count) * (cell + gap);
    let mut canvas = Canvas::new(
        size(columns, cell_width),
        size(rows.max(1), cell_height + caption_height),
    )
    .with_pixels_per_unit(1);
    // All captions have the same size, with a gap between neighbours. Only a caption that is far too long is smaller still.
    let width = 0.94 * f64::from(cell_width);
    let largest = TextFace::new(f64::from(text), INK).anchored(Anchor::Middle);
    let fitting = captions
        .iter()
        .fold(largest, |face, caption| face.fitted(caption, width));
    let face = TextFace {
        size: fitting.size.max(0.7 * largest.size),
        ..largest
    };
    for (index, image) in images.iter().enumerate() {
        let [x, y] = [
            gap + whole(index % columns) * (cell_width + gap),
            gap + whole(index / columns) * (cell_height + caption_height + gap),
        ];
        canvas.image(
            [
                x + (cell_width - image.width) / 2,
                y + (cell_height - image.height) / 2,
            ],
            image.clone(),
        );
        if let Some(caption) = captions.get(index) {
            let at = [
                f64::from(x) + 0.5 * f64::from(cell_width),
                f64::from(y + cell_height) + 0.5 * f64::from(caption_height),
            ];
            canvas.text(at, caption, face.fitted(caption, width));
        }
    }
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_arrive_unchanged_and_captions_do_not_touch() {
        let images: Vec<Image> = (0..5u8)
            .map(|shade| Image::filled(80, 60, [40 * shade, 9, 200]))
            .collect();
        let captions: Vec<String> = [
            "a",
            "precision, Δ = 0.12",
            "a caption that is far too long for its image",
            "",
        ]
        .map(String::from)
        .into();
        let canvas = contact_sheet_canvas(&images, &captions, 3);
        let sheet = canvas.to_image().unwrap();
        for (index, image) in images.iter().enumerate() {
            let (column, row) = (index % 3, index / 3);
            let (x, y) = (4 + column * 84, 4 + row * (60 + 16 + 4));
            for dy in 0..60 {
                let first = ((y + dy) * sheet.width as usize + x) * 3;
                assert_eq!(
                    sheet.rgb[first..first + 240],
                    image.rgb[dy * 240..(dy + 1) * 240],
                    "image {index}"
                );
            }
        }
        let texts = canvas.texts();
        assert_eq!(texts.len(), 3);
        assert!(
            texts
                .iter()
                .all(|(_, [left, _, right, _])| right - left <= 80.5 && *left >= 0.0)
        );
    }

    #[test]
    fn an_empty_sheet_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.png");
        contact_sheet(&[], &[], 0, &path).unwrap();
        assert!(path.exists());
    }

    #[test]
    fn an_svg_holds_the_pixels() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.svg");
        let images = [Image::filled(20, 10, [3, 50, 70])];
        contact_sheet(&images, &[], 1, &path).unwrap();
        let document = std::fs::read_to_string(&path).unwrap();
        let start = document.find("base64,").unwrap() + "base64,".len();
        let length = document[start..].find('"').unwrap();
        let bytes = base64::Engine::decode(
            &base64::engine::general_purpose::STANDARD,
            &document[start..start + length],
        );
        assert_eq!(bytes.unwrap(), images[0].to_png().unwrap());
        assert!(document.contains(r#"width="200" height="100" href"#));
    }
}
