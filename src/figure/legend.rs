//! The legend: a column of samples with texts beside the data, never over it.

use super::canvas::Canvas;
use super::style::{Anchor, Colour, Stroke, TextFace};
use super::theme::{INK, LINE, MARGIN, TEXT, UNLABELLED, WHITE, sequential};
use super::{axis, leaf};

const SIZE: f64 = 0.9 * TEXT;
const ROW: f64 = 1.42 * SIZE;
const SAMPLE_LINE: f64 = 52.0;
const BAR: [f64; 2] = [26.0, 170.0];
const GAP: f64 = 12.0;
/// Longest text; a longer one is set smaller.
const LONGEST: f64 = 270.0;

#[derive(Debug)]
enum Sample {
    Heading,
    Nothing,
    Disc { radius: f64, fill: Colour },
    Line(Stroke),
    Bar { low: f64, high: f64 },
}

/// A column of samples.
#[derive(Debug, Default)]
pub(super) struct Legend {
    rows: Vec<(Sample, String)>,
}

impl Legend {
    pub(super) fn heading(&mut self, text: &str) {
        self.rows.push((Sample::Heading, text.to_owned()));
    }

    pub(super) fn note(&mut self, text: &str) {
        self.rows.push((Sample::Nothing, text.to_owned()));
    }

    pub(super) fn line(&mut self, stroke: Stroke, text: &str) {
        self.rows.push((Sample::Line(stroke), text.to_owned()));
    }

    /// A bar of the sequential colours from `low` to `high`.
    pub(super) fn bar(&mut self, low: f64, high: f64) {
        self.rows.push((Sample::Bar { low, high }, String::new()));
    }

    /// The colours of the labels that occur, if any.
    pub(super) fn labels(&mut self, leaves: &[leaf::Leaf], radius: f64) {
        let colours = leaf::label_colours(leaves);
        if colours.is_empty() {
            return;
        }
        self.heading("label");
        for (label, fill) in colours {
            self.rows
                .push((Sample::Disc { radius, fill }, label.to_owned()));
        }
        if leaves.iter().any(|leaf| leaf.label.is_none()) {
            self.rows.push((
                Sample::Disc {
                    radius,
                    fill: UNLABELLED,
                },
                "none".to_owned(),
            ));
        }
    }

    /// The sizes of circles.
    pub(super) fn sizes(
        &mut self,
        leaves: &[leaf::Leaf],
        scale: leaf::DiscScale,
        heading: &str,
        fill: Colour,
    ) {
        self.heading(heading);
        if leaves.iter().any(|leaf| leaf.members == 0) {
            self.rows.push((
                Sample::Disc {
                    radius: scale.radius(0),
                    fill: WHITE,
                },
                "0".to_owned(),
            ));
        }
        for members in leaf::typical_members(leaves) {
            self.rows.push((
                Sample::Disc {
                    radius: scale.radius(members),
                    fill,
                },
                members.to_string(),
            ));
        }
    }

    fn row_height(sample: &Sample) -> f64 {
        match sample {
            Sample::Heading => 1.2 * ROW,
            Sample::Disc { radius, .. } => ROW.max(2.0 * radius + 8.0),
            Sample::Bar { .. } => BAR[1] + 1.2 * SIZE,
            Sample::Line(_) | Sample::Nothing => ROW,
        }
    }

    fn sample_width(&self) -> f64 {
        let width = |sample: &Sample| match sample {
            Sample::Disc { radius, .. } => 2.0 * radius + 4.0,
            Sample::Line(_) => SAMPLE_LINE,
            Sample::Bar { .. } => BAR[0],
            Sample::Heading | Sample::Nothing => 0.0,
        };
        self.rows
            .iter()
            .map(|(sample, _)| width(sample))
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
    pub(super) fn width(&self) -> f64 {
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
                Sample::Disc { .. } | Sample::Line(_) => samples + length,
            }
        };
        self.rows.iter().map(width).fold(0.0, f64::max)
    }

    /// Draws the column with its upper left corner at `[left, top]`; closer together if it would pass
    /// the bottom margin.
    pub(super) fn draw(&self, canvas: &mut Canvas, [left, top]: [f64; 2]) {
        let bottom = canvas.height() - MARGIN;
        let middle = left + 0.5 * self.sample_width();
        let beside = left + self.sample_width() + GAP;
        let needed: f64 = self
            .rows
            .iter()
            .map(|(sample, _)| Self::row_height(sample))
            .sum();
        let squeeze = ((bottom - top) / needed).min(1.0);
        let mut y = top;
        for (sample, text) in &self.rows {
            let height = Self::row_height(sample) * squeeze;
            let centre = y + 0.5 * height;
            let face = Self::face(sample, text);
            let face = TextFace {
                size: face.size * squeeze,
                ..face
            };
            match sample {
                Sample::Heading => canvas.text([left, y + 0.62 * height], text, face),
                Sample::Nothing => canvas.text([left, centre], text, face),
                Sample::Disc { radius, fill } => {
                    canvas.rimmed_circle([middle, centre], *radius, *fill, LINE, 1.0);
                    canvas.text([beside, centre], text, face);
                }
                Sample::Line(stroke) => {
                    let half = 0.5 * SAMPLE_LINE;
                    canvas.line([middle - half, centre], [middle + half, centre], *stroke);
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
        // Each band reaches up to the top, and the next paints over it: no seams between them.
        canvas.rectangle(
            [left, top],
            [right, level(from)],
            sequential(0.5 * (from + to)),
        );
    }
    let values = axis::ticks(low, high, 4);
    for (value, text) in values.iter().zip(axis::tick_texts(&values)) {
        let t = if high > low {
            (value - low) / (high - low)
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
