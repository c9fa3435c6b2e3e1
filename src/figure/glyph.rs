//! Horizontal metrics of DejaVu Sans, read from the font file.
//!
//! The rasteriser of plotters sets every glyph without its left side bearing (the white before the ink), so "tl" would
//! touch and "in" would gape. The metrics correct this. They come from the OpenType tables `cmap` (format 12), `hhea` and
//! `hmtx`.

/// Metrics of a glyph, as parts of an em.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Metrics {
    /// Distance from one glyph to the next.
    pub(super) advance: f64,
    /// White before the ink; negative if the ink begins before the origin.
    pub(super) bearing: f64,
}

/// Font units in an em of DejaVu Sans.
const UNITS: f64 = 2048.0;

/// The font file.
pub(super) fn font(bold: bool) -> &'static [u8] {
    if bold {
        dejavu::sans::bold()
    } else {
        dejavu::sans::regular()
    }
}

/// Metrics of a character. If the font lacks it, these are the metrics of the box for a missing glyph.
pub(super) fn metrics(character: char, bold: bool) -> Metrics {
    let font = font(bold);
    let (cmap, hhea, hmtx) = (
        table(font, *b"cmap"),
        table(font, *b"hhea"),
        table(font, *b"hmtx"),
    );
    let glyph = glyph(font, cmap, u32::from(character));
    let full = u32::from(u16_at(font, hhea + 34));
    // Glyphs beyond the full records share the last advance and have bearings only.
    let advance = u16_at(font, hmtx + 4 * index(glyph.min(full - 1)));
    let bearing = if glyph < full {
        u16_at(font, hmtx + 4 * index(glyph) + 2)
    } else {
        u16_at(font, hmtx + 4 * index(full) + 2 * index(glyph - full))
    };
    Metrics {
        advance: f64::from(advance) / UNITS,
        bearing: f64::from(bearing.cast_signed()) / UNITS,
    }
}

/// Width of a text at one unit per em.
pub(super) fn width(text: &str, bold: bool) -> f64 {
    text.chars()
        .map(|character| metrics(character, bold).advance)
        .sum()
}

fn glyph(font: &[u8], cmap: usize, character: u32) -> u32 {
    let subtables = (0..usize::from(u16_at(font, cmap + 2)))
        .map(|record| cmap + index(u32_at(font, cmap + 8 + 8 * record)));
    let Some(map) = subtables.into_iter().find(|&map| u16_at(font, map) == 12) else {
        return 0;
    };
    (0..index(u32_at(font, map + 12)))
        .map(|group| [0, 4, 8].map(|field| u32_at(font, map + 16 + 12 * group + field)))
        .find(|&[first, last, _]| (first..=last).contains(&character))
        .map_or(0, |[first, _, glyph]| glyph + character - first)
}

fn table(font: &[u8], tag: [u8; 4]) -> usize {
    (0..usize::from(u16_at(font, 4)))
        .map(|record| 12 + 16 * record)
        .find(|&record| font[record..record + 4] == tag)
        .map(|record| index(u32_at(font, record + 8)))
        .expect("DejaVu Sans has this table")
}

fn u16_at(font: &[u8], at: usize) -> u16 {
    u16::from_be_bytes([font[at], font[at + 1]])
}

fn u32_at(font: &[u8], at: usize) -> u32 {
    u32::from_be_bytes([font[at], font[at + 1], font[at + 2], font[at + 3]])
}

fn index(value: u32) -> usize {
    usize::try_from(value).expect("offsets in a font fit in memory")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_are_those_of_the_published_font() {
        // DejaVu Sans 2.37: advances of digits 1303, space 651, m 1995 units; H begins after 201 units.
        for (character, advance) in [('0', 1303.0), ('7', 1303.0), (' ', 651.0), ('m', 1995.0)] {
            let units = metrics(character, false).advance * UNITS;
            assert!((units - advance).abs() < 0.5, "{character}: {units}");
        }
        assert!((metrics('H', false).bearing * UNITS - 201.0).abs() < 0.5);
        assert!(
            metrics('T', false).bearing < 0.0
                && metrics('m', true).advance > metrics('m', false).advance
        );
    }

    #[test]
    fn formulae_have_glyphs() {
        let missing = metrics('\u{10FFFF}', false);
        for character in "αλμΔ₀₁₂−≤×·°√Σ²".chars() {
            assert_ne!(metrics(character, false), missing, "{character}");
        }
    }
}
