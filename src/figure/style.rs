//! Colours, strokes and faces of text, and how plotters is told about them.

use std::sync::Once;

use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color as _, FontDesc, FontFamily, FontStyle, FontTransform, RGBAColor, TextStyle, register_font,
};

use super::glyph;

/// Name under which DejaVu Sans is registered. It is what an SVG file asks for, so it lists the next best fonts too.
const FONT: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";
/// How a backend sets text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    /// What it calls the size of a font whose em is 1.
    pub(super) size_per_em: f64,
    /// Where it puts the base line of vertically centred text, em below the point.
    pub(super) base_line: f64,
    /// Whether it must be told where each glyph goes.
    pub(super) by_glyph: bool,
    /// Whether it paints images; else they are put into the document.
    pub(super) paints_images: bool,
}

/// The rasteriser's size is ascent plus descent of DejaVu Sans. It centres a box of height size / 1.24, then puts the
/// base line half a size below the top of that box.
pub(super) const BITMAP: Setting = Setting {
    size_per_em: 2384.0 / 2048.0,
    base_line: 0.5 * (1.0 - 1.0 / 1.24) * 2384.0 / 2048.0,
    by_glyph: true,
    paints_images: true,
};
/// SVG shifts by half an ex; an ex of DejaVu Sans is 1120 of its 2048 units.
pub(super) const SVG: Setting = Setting {
    size_per_em: 1.24,
    base_line: 0.5 * 1120.0 / 2048.0,
    by_glyph: false,
    paints_images: false,
};
/// Where the base line shall be: capitals and digits (1493 of 2048 units tall) are centred on the point.
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

/// Which end of a text is at its point; vertically the point is always at half height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins at the point.
    Start,
    /// The text is centred on the point.
    Middle,
    /// The text ends at the point.
    End,
}

/// How a text is set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextFace {
    /// Height of an em, canvas units.
    pub size: f64,
    /// Bold instead of regular.
    pub bold: bool,
    /// Its colour.
    pub colour: Colour,
    /// What its point means.
    pub anchor: Anchor,
    /// Set bottom to top instead of left to right.
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

    /// With another anchor.
    #[must_use]
    pub const fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// Bold.
    #[must_use]
    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// Bottom to top.
    #[must_use]
    pub const fn upward(self) -> Self {
        Self {
            upward: true,
            ..self
        }
    }

    /// Smaller if need be, so that `text` takes at most `length`.
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

    /// Where the text begins, relative to its point, along the text.
    pub(super) fn start(&self, text: &str) -> f64 {
        match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * text_width(text, self.size, self.bold),
            Anchor::End => -text_width(text, self.size, self.bold),
        }
    }

    /// The glyphs of `text` with the distance of their ink from the text's point, along the text.
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

/// Width of `text` set at `size` per em, canvas units.
pub fn text_width(text: &str, size: f64, bold: bool) -> f64 {
    size * glyph::width(text, bold)
}

/// Makes the fonts known to plotters; without them it can set no text, not even in SVG.
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
