//! A common look of all pictures. Colours suit colour blindness and greyscale print; sizes suit a column of a paper.

use super::style::Colour;

/// Size of ordinary text. A sheet 1200 units wide shows it at 5.9 pt in a column of 8.6 cm and at 12 pt across the page.
pub const TEXT: f64 = 29.0;
/// Size of titles.
pub const TITLE: f64 = 33.0;
/// Margin around everything.
pub const MARGIN: f64 = 22.0;

/// Colour of text and axes.
pub const INK: Colour = Colour::new(0x22, 0x26, 0x2B);
/// Colour of lines that carry data.
pub const LINE: Colour = Colour::new(0x3F, 0x48, 0x54);
/// Colour of grid lines.
pub const FAINT: Colour = Colour::new(0xE6, 0xE9, 0xED);
/// Colour of lines that carry less certain data.
pub const PALE_LINE: Colour = Colour::new(0x9A, 0xA4, 0xB0);
/// Colour of the sheet.
pub const WHITE: Colour = Colour::new(255, 255, 255);
/// Colour of items without a label.
pub const UNLABELLED: Colour = Colour::new(0x7B, 0x8F, 0xA8);

/// Colour of what is of no kind in a list.
pub(super) const UNLISTED: Colour = Colour::new(0xDA, 0xDC, 0xE0);
/// Colour of what a picture does not tell apart.
pub(super) const OTHER: Colour = Colour::new(0x6B, 0x73, 0x80);

/// Shades of the hues green, yellow and red, in the order of [`Hue`](super::look::Hue). The first of each is that of Okabe and
/// Ito (2008). The others were found by a search: shades of one hue differ in lightness by 20 of 100, and any two shades
/// differ by 10 (CIE 1976) for normal sight, protanopia and deuteranopia.
pub(super) const SHADES: [[Colour; 3]; 3] = [
    [
        Colour::new(0x00, 0x9E, 0x73),
        Colour::new(0x1C, 0x55, 0x52),
        Colour::new(0x82, 0xD3, 0xB3),
    ],
    [
        Colour::new(0xF0, 0xE4, 0x42),
        Colour::new(0x6F, 0x52, 0x00),
        Colour::new(0xCC, 0x9A, 0x2E),
    ],
    [
        Colour::new(0xD5, 0x5E, 0x00),
        Colour::new(0x7D, 0x11, 0x28),
        Colour::new(0xFB, 0xB0, 0x8C),
    ],
];

/// Colours of Okabe and Ito (2008), without the three of the grasp categories, then darker mixtures.
pub(super) const PALETTE: [Colour; 9] = [
    Colour::new(0x00, 0x72, 0xB2),
    Colour::new(0xCC, 0x79, 0xA7),
    Colour::new(0x56, 0xB4, 0xE9),
    Colour::new(0xE6, 0x9F, 0x00),
    Colour::new(0x5B, 0x3A, 0x8E),
    Colour::new(0x8C, 0x51, 0x0A),
    Colour::new(0x80, 0xCD, 0xC1),
    Colour::new(0x9E, 0x00, 0x42),
    Colour::new(0x4D, 0x4D, 0x4D),
];

/// Colours of Okabe and Ito (2008) for lines and areas of charts, the darker ones first, then darker mixtures.
const SERIES: [Colour; 9] = [
    Colour::new(0x00, 0x72, 0xB2),
    Colour::new(0xD5, 0x5E, 0x00),
    Colour::new(0x00, 0x9E, 0x73),
    Colour::new(0xCC, 0x79, 0xA7),
    Colour::new(0xE6, 0x9F, 0x00),
    Colour::new(0x56, 0xB4, 0xE9),
    Colour::new(0x5B, 0x3A, 0x8E),
    Colour::new(0x8C, 0x51, 0x0A),
    Colour::new(0x4D, 0x4D, 0x4D),
];

/// Colour of series number `index` of a chart. The colours repeat after nine.
pub const fn series(index: usize) -> Colour {
    SERIES[index % SERIES.len()]
}

/// Colour at `t` in [0, 1] of the colour map viridis (van der Walt and Smith 2015), which is monotone in lightness.
pub fn sequential(t: f64) -> Colour {
    const ANCHORS: [[u8; 3]; 10] = [
        [0x44, 0x01, 0x54],
        [0x48, 0x28, 0x78],
        [0x3E, 0x49, 0x89],
        [0x31, 0x68, 0x8E],
        [0x26, 0x82, 0x8E],
        [0x1F, 0x9E, 0x89],
        [0x35, 0xB7, 0x79],
        [0x6E, 0xCE, 0x58],
        [0xB5, 0xDE, 0x2B],
        [0xFD, 0xE7, 0x25],
    ];
    let place = t.clamp(0.0, 1.0) * (ANCHORS.len() - 1) as f64;
    let below = (0..ANCHORS.len() - 1)
        .rev()
        .find(|&index| index as f64 <= place)
        .unwrap_or(0);
    let part = place - below as f64;
    let mix = |channel: usize| {
        let (a, b) = (
            f64::from(ANCHORS[below][channel]),
            f64::from(ANCHORS[below + 1][channel]),
        );
        byte(a + part * (b - a))
    };
    Colour::new(mix(0), mix(1), mix(2))
}

/// Nearest byte.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..=255 first"
)]
pub(super) fn byte(value: f64) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequential_rises_in_lightness() {
        let lightness = |t: f64| {
            let [red, green, blue] = sequential(t).rgb.map(f64::from);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        assert!(
            (0..50).all(|i| lightness(f64::from(i) / 50.0) < lightness(f64::from(i + 1) / 50.0))
        );
        assert_eq!(sequential(1.0).rgb, [0xFD, 0xE7, 0x25]);
    }
}
