//! The legend: samples of lines, circles and colours with texts, in a column or in rows.

use super::axis::{self, Span};
use super::canvas::Canvas;
use super::look::Look;
use super::style::{Anchor, Colour, Stroke, TextFace};
use super::theme::{INK, LINE, TEXT, sequential};

const SIZE: f64 = 0.9 * TEXT;
const ROW: f64 = 1.42 * SIZE;
const SAMPLE_LINE: f64 = 52.0;
const BAR: [f64; 2] = [26.0, 170.0];
const PATCH: [f64; 2] = [34.0, 20.0];
const GAP: f64 = 12.0;
/// Distance between the entries of a row.
const APART: f64 = 40.0;
/// Greatest length of a text; a longer one gets a smaller font.
const LONGEST: f64 = 270.0;

#[derive(Debug, Clone, PartialEq)]
enum Sample {
    Heading,
    Nothing,
    Symbol { radius: f64, look: Look },
    Line(Stroke),
    Patch(Colour),
    Bar { low: f64, high: f64 },
}

impl Sample {
    fn width(&self) -> f64 {
        match self {
            Self::Symbol { radius, look } => 2.0 * radius * look.symbol.reach()[0] + 4.0,
            Self::Line(_) => SAMPLE_LINE,
            Self::Patch(_) => PATCH[0],
            Self::Bar { .. } => BAR[0],
            Self::Heading | Self::Nothing => 0.0,
        }
    }

    /// Whether it is a symbol that is higher than a line of text.
    fn is_large(&self) -> bool {
        matches!(self, Self::Symbol { .. }) && Legend::row_height(self) > ROW
    }

    /// Draws a sample that has its text beside its middle. Bars and headings are drawn elsewhere.
    fn draw(&self, canvas: &mut Canvas, [x, y]: [f64; 2]) {
        match self {
            Self::Symbol { radius, look } => {
                // Triangles reach farther on one side.
                let [_, above, below] = look.symbol.reach();
                look.draw(
                    canvas,
                    [x, y + 0.5 * radius * (above - below)],
                    *radius,
                    1.0,
                );
            }
            Self::Line(stroke) => {
                let half = 0.5 * SAMPLE_LINE;
                canvas.line([x - half, y], [x + half, y], *stroke);
            }
            Self::Patch(fill) => {
                let half = PATCH.map(|side| 0.5 * side);
                canvas.rectangle(
                    [x - half[0], y - half[1]],
                    [x + half[0], y + half[1]],
                    *fill,
                );
            }
            Self::Heading | Self::Nothing | Self::Bar { .. } => {}
        }
    }
}

/// A legend: a list of samples with texts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Legend {
    rows: Vec<(Sample, String)>,
}

impl Legend {
    /// Adds a bold line of text.
    pub fn heading(&mut self, text: &str) {
        self.rows.push((Sample::Heading, text.to_owned()));
    }

    /// Adds a line of text without a sample.
    pub fn note(&mut self, text: &str) {
        self.rows.push((Sample::Nothing, text.to_owned()));
    }

    /// Adds a piece of line.
    pub fn line(&mut self, stroke: Stroke, text: &str) {
        self.rows.push((Sample::Line(stroke), text.to_owned()));
    }

    /// Adds a bar of the sequential colours from `low` to `high`.
    pub fn bar(&mut self, low: f64, high: f64) {
        self.rows.push((Sample::Bar { low, high }, String::new()));
    }

    /// Adds a circle with a thin rim.
    pub fn disc(&mut self, radius: f64, fill: Colour, text: &str) {
        self.symbol(radius, Look::disc(fill), text);
    }

    /// Adds the symbol of a look, with a thin rim.
    pub fn symbol(&mut self, radius: f64, look: Look, text: &str) {
        let sample = Sample::Symbol { radius, look };
        self.rows.push((sample, text.to_owned()));
    }

    /// Adds a small filled area.
    pub fn patch(&mut self, fill: Colour, text: &str) {
        self.rows.push((Sample::Patch(fill), text.to_owned()));
    }

    /// Whether the legend has no entries.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    fn row_height(sample: &Sample) -> f64 {
        match sample {
            Sample::Heading => 1.2 * ROW,
            Sample::Symbol { radius, .. } => ROW.max(2.0 * radius + 8.0),
            Sample::Bar { .. } => BAR[1] + 1.2 * SIZE,
            Sample::Line(_) | Sample::Patch(_) | Sample::Nothing => ROW,
        }
    }

    fn sample_width(&self) -> f64 {
        self.rows
            .iter()
            .map(|(sample, _)| sample.width())
            .fold(0.0, f64::max)
    }

    fn face(sample: &Sample, text: &str) -> TextFace {
        let face = TextFace::new(SIZE, INK);
        if matches!(sample, Sample::Heading) {
            face.bold()
        } else {
            face
        }
        .fitted(text, LONGEST)
    }

    /// Width of the column.
    pub fn width(&self) -> f64 {
        let samples = self.sample_width() + GAP;
        let width = |(sample, text): &(Sample, String)| {
            let face = Self::face(sample, text);
            let length = super::text_width(text, face.size, face.bold);
            match sample {
                Sample::Heading | Sample::Nothing => length,
                Sample::Bar { low, high } => {
                    let texts = axis::tick_texts(&axis::ticks(*low, *high, 4));
                    samples
                        + texts
                            .iter()
                            .map(|text| super::text_width(text, SIZE, false))
                            .fold(0.0, f64::max)
                }
                Sample::Symbol { .. } | Sample::Line(_) | Sample::Patch(_) => samples + length,
            }
        };
        self.rows.iter().map(width).fold(0.0, f64::max)
    }

    /// Height of the column.
    pub fn height(&self) -> f64 {
        self.rows
            .iter()
            .map(|(sample, _)| Self::row_height(sample))
            .sum()
    }

    /// Draws the column with its upper left corner at `[left, top]`. It is squeezed if it would pass `bottom`, except for
    /// large symbols, whose size means something.
    pub fn draw(&self, canvas: &mut Canvas, [left, top]: [f64; 2], bottom: f64) {
        let middle = left + 0.5 * self.sample_width();
        let beside = left + self.sample_width() + GAP;
        let large = self.rows.iter().filter(|(sample, _)| sample.is_large());
        let fixed: f64 = large.map(|(sample, _)| Self::row_height(sample)).sum();
        let squeeze = ((bottom - top - fixed) / (self.height() - fixed)).clamp(0.0, 1.0);
        let mut y = top;
        for (sample, text) in &self.rows {
            let part = if sample.is_large() { 1.0 } else { squeeze };
            let height = Self::row_height(sample) * part;
            let centre = y + 0.5 * height;
            let face = Self::face(sample, text);
            let face = TextFace {
                size: face.size * squeeze,
                ..face
            };
            match sample {
                Sample::Heading => canvas.text([left, y + 0.62 * height], text, face),
                Sample::Nothing => canvas.text([left, centre], text, face),
                Sample::Symbol { .. } | Sample::Line(_) | Sample::Patch(_) => {
                    sample.draw(canvas, [middle, centre]);
                    canvas.text([beside, centre], text, face);
                }
                Sample::Bar { low, high } => {
                    let (x, head, tail) = (
                        middle - 0.5 * BAR[0],
                        y + 0.6 * SIZE,
                        y + height - 0.6 * SIZE,
                    );
                    draw_bar(canvas, [x, head], [x + BAR[0], tail], [*low, *high], beside);
                }
            }
            y += height;
        }
    }

    /// Place of each entry relative to the upper left corner, in rows at most `width` long. Headings and bars of colours
    /// are not meant for rows.
    fn flow(&self, width: f64) -> Vec<([f64; 2], &Sample, &str, TextFace)> {
        let mut entries = Vec::new();
        let [mut x, mut y] = [0.0, 0.0];
        for (sample, text) in &self.rows {
            let beside = sample.width() + GAP;
            let face = TextFace::new(SIZE, INK).fitted(text, width - beside);
            let length = beside + super::text_width(text, face.size, face.bold);
            if x > 0.0 && x + length > width {
                [x, y] = [0.0, y + ROW];
            }
            entries.push(([x, y], sample, text.as_str(), face));
            x += length + APART;
        }
        entries
    }

    /// Height of the entries in rows at most `width` long.
    pub fn height_in_rows(&self, width: f64) -> f64 {
        self.flow(width).last().map_or(0.0, |([_, y], ..)| y + ROW)
    }

    /// Draws the entries in rows at most `width` long below `[left, top]`.
    pub fn draw_in_rows(&self, canvas: &mut Canvas, [left, top]: [f64; 2], width: f64) {
        for ([x, y], sample, text, face) in self.flow(width) {
            let [x, centre] = [left + x, top + y + 0.5 * ROW];
            sample.draw(canvas, [x + 0.5 * sample.width(), centre]);
            let beside = x + sample.width() + GAP;
            canvas.text([beside, centre], text, face);
        }
    }
}

fn draw_bar(
    canvas: &mut Canvas,
    [left, top]: [f64; 2],
    [right, bottom]: [f64; 2],
    [low, high]: [f64; 2],
    beside: f64,
) {
    const BANDS: u32 = 60;
    let level = |t: f64| bottom + t * (top - bottom);
    for band in 0..BANDS {
        let [from, to] = [band, band + 1].map(|edge| f64::from(edge) / f64::from(BANDS));
        // Each band reaches up to the top and the next paints over it, so that no seams show.
        canvas.rectangle(
            [left, top],
            [right, level(from)],
            sequential(0.5 * (from + to)),
        );
    }
    let values = axis::ticks(low, high, 4);
    for (value, text) in values.iter().zip(axis::tick_texts(&values)) {
        let t = if high > low {
            Span { low, high }.part(*value)
        } else {
            0.5
        };
        canvas.line(
            [right, level(t)],
            [right + 6.0, level(t)],
            Stroke::solid(LINE, 1.5),
        );
        canvas.text(
            [beside, level(t)],
            &text,
            TextFace::new(SIZE, INK).anchored(Anchor::Start),
        );
    }
}
