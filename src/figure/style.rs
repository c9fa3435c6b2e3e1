//! Colours, strokes and text faces, and their conversion for plotters.

use std::sync::Once;

use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color as _, FontDesc, FontFamily, FontStyle, FontTransform, RGBAColor, TextStyle, register_font,
};

use super::glyph;

/// Name under which DejaVu Sans is registered. SVG files request this name, so it lists fallback fonts too.
const FONT: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";
/// Conventions of a backend for text and images.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    /// Font size, in the backend's sense, of a font whose em is 1.
    pub(super) size_per_em: f64,
    /// Base line of vertically centred text, in em below the point.
    pub(super) base_line: f64,
    /// Whether each glyph must be placed separately.
    pub(super) by_glyph: bool,
    /// Whether the backend paints images. Otherwise they are embedded in the document.
    pub(super) paints_images: bool,
}

/// The rasteriser's font size is ascent plus descent of DejaVu Sans. It centres a box of height size / 1.24 and puts the
/// base line half a size below the top of that box.
pub(super) const BITMAP: Setting = Setting {
    size_per_em: 2384.0 / 2048.0,
    base_line: 0.5 * (1.0 - 1.0 / 1.24) * 2384.0 / 2048.0,
    by_glyph: true,
    paints_images: true,
};
/// SVG shifts text by half an ex; an ex of DejaVu Sans is 1120 of its 2048 units.
pub(super) const SVG: Setting = Setting {
    size_per_em: 1.24,
    base_line: 0.5 * 1120.0 / 2048.0,
    by_glyph: false,
    paints_images: false,
};
/// The wanted base line: capitals and digits (1493 of 2048 units tall) are centred on the point.
pub(super) const BASE_LINE: f64 = 0.5 * 1493.0 / 2048.0;
/// A colour with its opacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    /// Red, green, blue.
    pub rgb: [u8; 3],
    /// 0 (invisible) to 1 (opaque).
    pub opacity: f64,
}

impl Colour {
    /// Opaque colour from red, green and blue.
    pub const fn new(red: u8, green: u8, blue: u8) -> Self {
        Self {
            rgb: [red, green, blue],
            opacity: 1.0,
        }
    }

    /// The same colour with another opacity.
    #[must_use]
    pub const fn with_opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    pub(super) fn plotters(self) -> RGBAColor {
        RGBAColor(self.rgb[0], self.rgb[1], self.rgb[2], self.opacity)
    }
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub colour: Colour,
    /// Its width, canvas units.
    pub width: f64,
    /// Lengths of dash and gap, canvas units; `None` for a solid line.
    pub dash: Option<[f64; 2]>,
}

impl Stroke {
    /// A solid line.
    pub const fn solid(colour: Colour, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: None,
        }
    }

    /// A dashed line.
    pub const fn dashed(colour: Colour, width: f64, dash: f64, gap: f64) -> Self {
        Self {
            colour,
            width,
            dash: Some([dash, gap]),
        }
    }
}

/// Which end of a text is at its point. Vertically the point is always at half height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins at the point.
    Start,
    /// The text is centred on the point.
    Middle,
    /// The text ends at the point.
    End,
}

/// Font size, weight, colour and placement of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextFace {
    /// Height of an em, canvas units.
    pub size: f64,
    /// Bold instead of regular.
    pub bold: bool,
    /// Its colour.
    pub colour: Colour,
    /// Which end of the text is at its point.
    pub anchor: Anchor,
    /// Whether the text runs from bottom to top instead of left to right.
    pub upward: bool,
}

impl TextFace {
    /// Regular text, left to right, starting at its point.
    pub const fn new(size: f64, colour: Colour) -> Self {
        Self {
            size,
            bold: false,
            colour,
            anchor: Anchor::Start,
            upward: false,
        }
    }

    /// Sets another anchor.
    #[must_use]
    pub const fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// Makes the text bold.
    #[must_use]
    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// Makes the text run from bottom to top.
    #[must_use]
    pub const fn upward(self) -> Self {
        Self {
            upward: true,
            ..self
        }
    }

    /// Reduces the size if needed, so that `text` takes at most `length`.
    #[must_use]
    pub fn fitted(self, text: &str, length: f64) -> Self {
        let needed = text_width(text, self.size, self.bold);
        if needed > length {
            Self {
                size: self.size * length.max(1.0) / needed,
                ..self
            }
        } else {
            self
        }
    }

    /// Start of the text relative to its point, along the text.
    pub(super) fn start(&self, text: &str) -> f64 {
        match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * text_width(text, self.size, self.bold),
            Anchor::End => -text_width(text, self.size, self.bold),
        }
    }

    /// The glyphs of `text` and the distances of their ink from the text's point, along the text.
    pub(super) fn glyphs(&self, text: &str) -> Vec<(f64, String, Self)> {
        let mut pen = self.start(text);
        let mut glyphs = Vec::new();
        for character in text.chars() {
            let metrics = glyph::metrics(character, self.bold);
            if !character.is_whitespace() {
                glyphs.push((
                    pen + metrics.bearing * self.size,
                    character.to_string(),
                    self.anchored(Anchor::Start),
                ));
            }
            pen += metrics.advance * self.size;
        }
        glyphs
    }

    pub(super) fn plotters(&self, scale: f64) -> TextStyle<'static> {
        let style = if self.bold {
            FontStyle::Bold
        } else {
            FontStyle::Normal
        };
        let font = FontDesc::new(FontFamily::Name(FONT), self.size * scale, style);
        let font = if self.upward {
            font.transform(FontTransform::Rotate270)
        } else {
            font
        };
        let horizontal = match self.anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        TextStyle {
            font,
            color: self.colour.plotters().to_backend_color(),
            pos: Pos::new(horizontal, VPos::Center),
        }
    }
}

/// Width of `text` set at `size` canvas units per em, canvas units.
pub fn text_width(text: &str, size: f64, bold: bool) -> f64 {
    size * glyph::width(text, bold)
}

/// Registers the fonts with plotters. It cannot set text without them, not even in SVG.
pub(super) fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for (style, bytes) in [
            (FontStyle::Normal, glyph::font(false)),
            (FontStyle::Bold, glyph::font(true)),
        ] {
            assert!(
                register_font(FONT, style, bytes).is_ok(),
                "DejaVu Sans is a valid font"
            );
        }
    });
}
