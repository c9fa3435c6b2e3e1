//! The energy axis of a disconnectivity graph.

use super::axis::{self, Span};
use super::canvas::Canvas;
use super::style::{Anchor, Stroke, TextFace};
use super::text_width;
use super::theme::{FAINT, INK, MARGIN, TEXT};

/// Mapping of energies to the canvas.
#[derive(Clone, Copy)]
pub(super) struct Heights {
    /// Range from the lowest to the highest node.
    pub(super) energies: Span,
    /// Canvas y of the ends of this range.
    pub(super) y: [f64; 2],
}

impl Heights {
    /// Canvas y of an energy.
    pub(super) fn of(self, energy: f64) -> f64 {
        let [bottom, top] = self.y;
        bottom + self.energies.part(energy) * (top - bottom)
    }

    /// The energy at a canvas y.
    fn energy_at(self, y: f64) -> f64 {
        let [bottom, top] = self.y;
        self.energies.at((y - bottom) / (top - bottom))
    }

    /// Draws the axis between the canvas y `top` and `bottom`, with lines to the canvas x `right`; returns its canvas x.
    pub(super) fn draw_axis(
        self,
        [top, bottom, right]: [f64; 3],
        label: &str,
        canvas: &mut Canvas,
    ) -> f64 {
        let values = axis::ticks(self.energy_at(bottom), self.energy_at(top), 6);
        let texts = axis::tick_texts(&values);
        let longest = texts
            .iter()
            .map(|text| text_width(text, TEXT, false))
            .fold(0.0, f64::max);
        let left = MARGIN + 1.5 * TEXT + longest + 12.0;
        for (&value, text) in values.iter().zip(&texts) {
            let y = self.of(value);
            canvas.line([left, y], [right, y], Stroke::solid(FAINT, 1.5));
            canvas.line([left - 7.0, y], [left, y], Stroke::solid(INK, 2.0));
            // The number of a tick at the very end of the axis stays on the sheet.
            let beside = y.min(bottom + MARGIN - 0.5 * TEXT - 4.0);
            canvas.text(
                [left - 12.0, beside],
                text,
                TextFace::new(TEXT, INK).anchored(Anchor::End),
            );
        }
        canvas.line([left, top], [left, bottom], Stroke::solid(INK, 2.0));
        let face = TextFace::new(TEXT, INK).anchored(Anchor::Middle).upward();
        canvas.text(
            [MARGIN + 0.5 * TEXT, 0.5 * (top + bottom)],
            label,
            face.fitted(label, bottom - top),
        );
        left
    }
}
