//! Reliability curves: the share of right answers against their probability.

use landscape::figure::{Anchor, Canvas, Stroke, TextFace, theme};

use crate::reliability::Bin;

const SIZE: [u32; 2] = [900, 820];
const FACE: TextFace = TextFace::new(24.0, theme::INK);
/// Left, top and side of the panel.
const PANEL: [f64; 3] = [150.0, 90.0, 620.0];

pub(crate) fn picture(curves: &[(&str, Vec<Bin>)]) -> Canvas {
    let [left, top, side] = PANEL;
    let mut canvas = Canvas::new(SIZE[0], SIZE[1]).with_pixels_per_unit(1);
    let at = |score: f64, right: f64| [left + side * score, top + side * (1.0 - right)];
    canvas.text(
        [theme::MARGIN, 40.0],
        "Share of right answers, against their probability",
        TextFace::new(29.0, theme::INK),
    );
    canvas.line(
        at(0.0, 0.0),
        at(1.0, 1.0),
        Stroke::solid(theme::PALE_LINE, 2.0),
    );
    for end in [[1.0, 0.0], [0.0, 1.0]] {
        canvas.line(
            at(0.0, 0.0),
            at(end[0], end[1]),
            Stroke::solid(theme::LINE, 2.0),
        );
    }
    for tenth in [0_u32, 5, 10] {
        let share = f64::from(tenth) / 10.0;
        let text = format!("{share:.1}");
        let [x, y] = at(share, 0.0);
        canvas.text([x, y + 26.0], &text, FACE.anchored(Anchor::Middle));
        let [x, y] = at(0.0, share);
        canvas.text([x - 14.0, y], &text, FACE.anchored(Anchor::End));
    }
    for (place, (name, bins)) in curves.iter().enumerate() {
        let colour = theme::series(place);
        let kept = || bins.iter().filter(|bin| bin.count > 0);
        let points: Vec<[f64; 2]> = kept().map(|bin| at(bin.score, bin.right)).collect();
        canvas.polyline(&points, Stroke::solid(colour, 3.0));
        for bin in kept() {
            canvas.circle(
                at(bin.score, bin.right),
                3.0 + (bin.count as f64).sqrt() / 2.0,
                colour,
            );
        }
        let y = top + 30.0 + 36.0 * place as f64;
        canvas.circle([left + 40.0, y], 8.0, colour);
        canvas.text([left + 60.0, y], name, FACE);
    }
    canvas
}
