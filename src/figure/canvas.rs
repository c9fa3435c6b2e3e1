//! A sheet of marks (lines, polygons, circles, texts, images), and its output as SVG or PNG.
//!
//! Pictures put marks on a [`Canvas`] in canvas units, y downward. Nothing is rasterised before [`Canvas::save`], so tests
//! can query the marks of a picture. DejaVu Sans is embedded in the program, so no installed font is needed.

use std::fmt::Write as _;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::backend::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::style::ShapeStyle;

use super::image::{Image, MAKER};
use super::look::Symbol;
use super::style::{
    BASE_LINE, BITMAP, Colour, SVG, Setting, Stroke, TextFace, register_fonts, text_width,
};
use super::{FigureError, dash};
use crate::atomic_file;
use crate::printable::printable;

/// plotters writes whole numbers as SVG coordinates. Drawing ten times as large keeps a tenth of a unit.
const SVG_SCALE: u32 = 10;
/// Factor by which a bitmap is drawn too large in each direction; averaging then smooths the edges.
const SUPERSAMPLING: u32 = 2;

#[derive(Debug, Clone)]
enum Mark {
    Line {
        from: [f64; 2],
        to: [f64; 2],
        stroke: Stroke,
    },
    Polygon {
        points: Vec<[f64; 2]>,
        fill: Colour,
    },
    Circle {
        centre: [f64; 2],
        radius: f64,
        fill: Colour,
    },
    Text {
        at: [f64; 2],
        text: String,
        face: TextFace,
    },
    Image {
        at: [u32; 2],
        /// Pixels of the image per canvas unit.
        density: u32,
        image: Image,
    },
}

/// A white sheet of marks, painted in the order in which they were added.
#[derive(Debug, Clone)]
pub struct Canvas {
    width: u32,
    height: u32,
    pixels_per_unit: u32,
    marks: Vec<Mark>,
    /// What the picture was made of.
    source: Option<String>,
}

impl Canvas {
    /// An empty sheet of the given size. PNG files have two pixels per unit.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            pixels_per_unit: 2,
            marks: Vec::new(),
            source: None,
        }
    }

    /// Says in PNG files what the picture was made of, so that one of something else is not taken for it.
    #[must_use]
    pub fn made_of(self, source: String) -> Self {
        Self {
            source: Some(source),
            ..self
        }
    }

    /// Sets another resolution of PNG files.
    ///
    /// # Panics
    /// If `pixels_per_unit` is zero.
    #[must_use]
    pub fn with_pixels_per_unit(self, pixels_per_unit: u32) -> Self {
        assert!(pixels_per_unit > 0, "a bitmap needs pixels");
        Self {
            pixels_per_unit,
            ..self
        }
    }

    /// The same sheet, extended by `height` units at its lower edge.
    #[must_use]
    pub fn with_room_below(self, height: u32) -> Self {
        Self {
            height: self.height + height,
            ..self
        }
    }

    /// Width in canvas units.
    pub fn width(&self) -> f64 {
        f64::from(self.width)
    }

    /// Height in canvas units.
    pub fn height(&self) -> f64 {
        f64::from(self.height)
    }

    /// A straight line; a dashed one starts and ends with a dash.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], stroke: Stroke) {
        match stroke.dash {
            None => self.solid([[from, to]], stroke),
            Some(pattern) => self.solid(dash::line(from, to, pattern), stroke),
        }
    }

    /// Straight lines from point to point. A dash pattern continues around corners.
    pub fn polyline(&mut self, points: &[[f64; 2]], stroke: Stroke) {
        let pattern = stroke.dash.unwrap_or([f64::INFINITY, 0.0]);
        self.solid(dash::polyline(points, pattern), stroke);
    }

    fn solid(&mut self, pieces: impl IntoIterator<Item = [[f64; 2]; 2]>, stroke: Stroke) {
        let stroke = Stroke {
            dash: None,
            ..stroke
        };
        let lines = pieces.into_iter();
        self.marks
            .extend(lines.map(|[from, to]| Mark::Line { from, to, stroke }));
    }

    /// A filled polygon.
    pub fn polygon(&mut self, points: Vec<[f64; 2]>, fill: Colour) {
        self.marks.push(Mark::Polygon { points, fill });
    }

    /// A filled rectangle between two corners.
    pub fn rectangle(&mut self, [left, top]: [f64; 2], [right, bottom]: [f64; 2], fill: Colour) {
        self.polygon(
            vec![[left, top], [right, top], [right, bottom], [left, bottom]],
            fill,
        );
    }

    /// A filled circle.
    pub fn circle(&mut self, centre: [f64; 2], radius: f64, fill: Colour) {
        self.marks.push(Mark::Circle {
            centre,
            radius,
            fill,
        });
    }

    /// A filled circle with a rim of the given width outside `radius`.
    pub fn rimmed_circle(
        &mut self,
        centre: [f64; 2],
        radius: f64,
        fill: Colour,
        rim: Colour,
        width: f64,
    ) {
        self.circle(centre, radius + width, rim);
        self.circle(centre, radius, fill);
    }

    /// A symbol with the area of a disc of this radius, all its edges moved outward by `grown`.
    pub fn symbol(
        &mut self,
        symbol: Symbol,
        [x, y]: [f64; 2],
        (radius, grown): (f64, f64),
        fill: Colour,
    ) {
        match symbol.corners(radius, grown) {
            None => self.circle([x, y], radius + grown, fill),
            Some(corners) => {
                let points = corners.into_iter().map(|[dx, dy]| [x + dx, y + dy]);
                self.polygon(points.collect(), fill);
            }
        }
    }

    /// A line of text. Characters that would act as commands are replaced by visible ones.
    pub fn text(&mut self, at: [f64; 2], text: &str, face: TextFace) {
        if !text.is_empty() {
            self.marks.push(Mark::Text {
                at,
                text: printable(text, &[]).into_owned(),
                face,
            });
        }
    }

    /// An image with its upper left corner at `at`, one pixel per unit.
    pub fn image(&mut self, at: [u32; 2], image: Image) {
        self.fine_image(at, 1, image);
    }

    /// An image with its upper left corner at `at`, with `density` pixels per unit. In an SVG document, images are embedded
    /// above all other marks.
    ///
    /// # Panics
    /// If `density` does not divide twice the number of pixels per unit of the canvas.
    pub fn fine_image(&mut self, at: [u32; 2], density: u32, image: Image) {
        let finest = self.pixels_per_unit * SUPERSAMPLING;
        assert!(
            density > 0 && finest.is_multiple_of(density),
            "{density} pixels a unit on a canvas of {finest}"
        );
        self.marks.push(Mark::Image { at, density, image });
    }

    /// All texts with the rectangle that each takes (left, top, right, bottom), for tests that look for clipped or
    /// overlapping labels.
    pub fn texts(&self) -> Vec<(&str, [f64; 4])> {
        let mut texts = Vec::new();
        for mark in &self.marks {
            let Mark::Text {
                at: [x, y],
                text,
                face,
            } = mark
            else {
                continue;
            };
            let (length, half) = (text_width(text, face.size, face.bold), 0.5 * face.size);
            let start = face.start(text);
            texts.push((
                text.as_str(),
                if face.upward {
                    [x - half, y - start - length, x + half, y - start]
                } else {
                    [x + start, y - half, x + start + length, y + half]
                },
            ));
        }
        texts
    }

    /// The sheet as an SVG document.
    ///
    /// # Errors
    /// [`FigureError::Draw`] if the drawing library fails.
    pub fn to_svg(&self) -> Result<String, FigureError> {
        let mut document = String::new();
        let size = (self.width * SVG_SCALE, self.height * SVG_SCALE);
        let mut backend = SVGBackend::with_string(&mut document, size);
        let corners = [(0, 0), (size.0, 0), size, (0, size.1)];
        let corners = corners.map(|(x, y)| (x.cast_signed(), y.cast_signed()));
        let white = filled(Colour::new(255, 255, 255));
        backend
            .fill_polygon(corners, &white)
            .map_err(|error| undrawn(&error))?;
        self.paint(&mut backend, SVG_SCALE, SVG)?;
        backend.present().map_err(|error| undrawn(&error))?;
        drop(backend);
        let drawn = format!(r#"width="{}" height="{}""#, size.0, size.1);
        let wanted = format!(r#"width="{}" height="{}""#, self.width, self.height);
        let mut document = document.replacen(&drawn, &wanted, 1);
        if let Some(opened) = document.find('>') {
            document.insert_str(opened + 1, &format!("\n<!-- Made by {MAKER}. -->"));
        }
        let images = self.embedded()?;
        if let Some(end) = document.rfind("</svg>") {
            document.insert_str(end, &images);
        }
        Ok(document)
    }

    /// The images as elements of an SVG document.
    fn embedded(&self) -> Result<String, FigureError> {
        let mut elements = String::new();
        for mark in &self.marks {
            if let Mark::Image {
                at: [x, y],
                density,
                image,
            } = mark
            {
                let [x, y] = [x * SVG_SCALE, y * SVG_SCALE];
                let [width, height] =
                    [image.width, image.height].map(|side| side * SVG_SCALE / density);
                let pixels = STANDARD.encode(image.to_png()?);
                let _ = writeln!(
                    elements,
                    r#"<image x="{x}" y="{y}" width="{width}" height="{height}" href="data:image/png;base64,{pixels}"/>"#
                );
            }
        }
        Ok(elements)
    }

    /// The sheet as pixels.
    ///
    /// # Errors
    /// [`FigureError::Draw`] if the drawing library fails.
    pub fn to_image(&self) -> Result<Image, FigureError> {
        let scale = self.pixels_per_unit * SUPERSAMPLING;
        let mut large = Image::filled(self.width * scale, self.height * scale, [255; 3]);
        let size = (large.width, large.height);
        let mut backend: BitMapBackend<'_> = BitMapBackend::with_buffer(&mut large.rgb, size);
        self.paint(&mut backend, scale, BITMAP)?;
        drop(backend);
        Ok(large.reduced(SUPERSAMPLING))
    }

    /// Writes the sheet as `.svg` or `.png`, according to the ending of `path`. The file appears complete or not at all.
    ///
    /// # Errors
    /// [`FigureError::Format`] for another ending, [`FigureError::Write`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), FigureError> {
        let bytes = self.encode(path)?;
        atomic_file::write(path, &bytes).map_err(|source| FigureError::Write {
            path: path.to_owned(),
            source,
        })
    }

    /// The sheet as the bytes of an `.svg` or `.png` file, according to the ending of `path`.
    ///
    /// # Errors
    /// [`FigureError::Format`] for another ending, [`FigureError::Draw`] if the drawing library fails.
    pub fn encode(&self, path: &Path) -> Result<Vec<u8>, FigureError> {
        let ending = path.extension().and_then(|ending| ending.to_str());
        match ending.map(str::to_ascii_lowercase).as_deref() {
            Some("svg") => Ok(self.to_svg()?.into_bytes()),
            Some("png") => self.to_image()?.to_png_of(self.source.as_deref()),
            _ => Err(FigureError::Format(path.to_owned())),
        }
    }

    fn paint<B: DrawingBackend>(
        &self,
        backend: &mut B,
        scale: u32,
        setting: Setting,
    ) -> Result<(), FigureError> {
        register_fonts();
        for mark in &self.marks {
            mark.paint(backend, scale, setting)?;
        }
        Ok(())
    }
}

/// The pixel of a point, if a canvas unit is `factor` pixels.
fn pixel([x, y]: [f64; 2], factor: f64) -> (i32, i32) {
    (whole(x * factor), whole(y * factor))
}

impl Mark {
    fn paint<B: DrawingBackend>(
        &self,
        backend: &mut B,
        scale: u32,
        setting: Setting,
    ) -> Result<(), FigureError> {
        let factor = f64::from(scale);
        let at = |point: [f64; 2]| pixel(point, factor);
        let painted = match self {
            Self::Line { from, to, stroke } => {
                let width = whole(stroke.width * factor).max(1).unsigned_abs();
                let style = ShapeStyle {
                    color: stroke.colour.plotters(),
                    filled: false,
                    stroke_width: width,
                };
                backend.draw_line(at(*from), at(*to), &style)
            }
            Self::Polygon { points, fill } => {
                backend.fill_polygon(points.iter().map(|&point| at(point)), &filled(*fill))
            }
            Self::Circle {
                centre,
                radius,
                fill,
            } => {
                let radius = whole(radius * factor).unsigned_abs();
                backend.draw_circle(at(*centre), radius, &filled(*fill), true)
            }
            Self::Text {
                at: point,
                text,
                face,
            } => return paint_text(backend, *point, text, *face, (factor, setting)),
            Self::Image { .. } if !setting.paints_images => Ok(()),
            Self::Image {
                at: [x, y],
                density,
                image,
            } => {
                let image = image.enlarged(scale / density);
                let corner = at([f64::from(*x), f64::from(*y)]);
                backend.blit_bitmap(corner, (image.width, image.height), &image.rgb)
            }
        };
        painted.map_err(|error| undrawn(&error))
    }
}

fn paint_text<B: DrawingBackend>(
    backend: &mut B,
    [x, y]: [f64; 2],
    text: &str,
    face: TextFace,
    (factor, setting): (f64, Setting),
) -> Result<(), FigureError> {
    let runs = if setting.by_glyph {
        face.glyphs(text)
    } else {
        vec![(0.0, text.to_owned(), face)]
    };
    // For upward text, the direction below the text is to the right.
    let lower = (BASE_LINE - setting.base_line) * face.size;
    let mut runs = runs.iter();
    let painted = runs.try_for_each(|(along, run, face)| {
        let style = face.plotters(factor * setting.size_per_em);
        let shifted = if face.upward {
            [x + lower, y - along]
        } else {
            [x + along, y + lower]
        };
        backend.draw_text(run, &style, pixel(shifted, factor))
    });
    painted.map_err(|error| undrawn(&error))
}

fn filled(colour: Colour) -> ShapeStyle {
    ShapeStyle {
        color: colour.plotters(),
        filled: true,
        stroke_width: 0,
    }
}

fn undrawn(error: &impl ToString) -> FigureError {
    FigureError::Draw(error.to_string())
}

/// Nearest whole pixel, clamped to ±10⁹ so that points far outside stay outside.
#[expect(
    clippy::cast_possible_truncation,
    reason = "clamped to the range of i32 first"
)]
fn whole(value: f64) -> i32 {
    value.round().clamp(-1e9, 1e9) as i32
}

#[cfg(test)]
mod tests {
    use super::super::glyph;
    use super::super::style::Anchor;
    use super::*;

    const BLACK: Colour = Colour::new(0, 0, 0);

    fn inked_columns(image: &Image) -> [u32; 2] {
        let dark = |x: u32| {
            (0..image.height).any(|y| image.rgb[((y * image.width + x) * 3) as usize] < 128)
        };
        let columns: Vec<u32> = (0..image.width).filter(|&x| dark(x)).collect();
        [*columns.first().unwrap(), *columns.last().unwrap()]
    }

    #[test]
    fn ink_lies_where_the_metrics_say() {
        let text = "H tl in λ₁ H";
        for bold in [false, true] {
            let mut canvas = Canvas::new(400, 40).with_pixels_per_unit(1);
            canvas.text(
                [10.0, 20.0],
                text,
                TextFace {
                    bold,
                    ..TextFace::new(24.0, BLACK)
                },
            );
            let drawn = inked_columns(&canvas.to_image().unwrap()).map(f64::from);
            // The white before and after an H is the same.
            let white = 24.0 * glyph::metrics('H', bold).bearing;
            let expected = [
                10.0 + white,
                10.0 + text_width(text, 24.0, bold) - white - 1.0,
            ];
            for (drawn, expected) in drawn.iter().zip(expected) {
                assert!(
                    (drawn - expected).abs() < 1.2,
                    "{drawn} instead of {expected}"
                );
            }
        }
    }

    #[test]
    fn text_is_centred_on_its_point_both_ways() {
        for upward in [false, true] {
            let face = TextFace {
                upward,
                ..TextFace::new(40.0, BLACK).anchored(Anchor::Middle)
            };
            let mut canvas = Canvas::new(60, 60).with_pixels_per_unit(1);
            canvas.text([30.0, 30.0], "H", face);
            let image = canvas.to_image().unwrap();
            let [left, right] = inked_columns(&image);
            let mut turned = image.clone();
            for y in 0..60 {
                for x in 0..60 {
                    turned.rgb[(x * 60 + y) * 3] = image.rgb[(y * 60 + x) * 3];
                }
            }
            let [top, bottom] = inked_columns(&turned);
            let middle = [left + right + 1, top + bottom + 1].map(|sum| 0.5 * f64::from(sum));
            assert!(
                middle.iter().all(|place| (place - 30.0).abs() < 2.0),
                "{upward} {middle:?}"
            );
        }
    }
}
