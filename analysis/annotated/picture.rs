//! Shares of right labels with their intervals, a row for each measure, a colour for each set, beside always the commonest
//! answer; and the reliability curve.

use landscape::figure::{Anchor, Canvas, Stroke, TextFace, theme};

use crate::Measure;
use crate::report::{Set, commonest, reliability, right};

const SIZE: [u32; 2] = [1900, 900];
const FACE: TextFace = TextFace::new(24.0, theme::INK);
const TITLE: TextFace = TextFace::new(29.0, theme::INK);
/// Left, right, top and bottom of the panel of shares, and corner and side of the panel of reliability.
const SHARES: [f64; 4] = [330.0, 1120.0, 110.0, 800.0];
const CURVE: [f64; 3] = [1310.0, 160.0, 500.0];
/// The measures that are shown: all but whether no type is given.
const ROWS: usize = Measure::ALL.len() - 1;

pub(crate) fn picture(sets: &[Set<'_>]) -> Canvas {
    let mut canvas = Canvas::new(SIZE[0], SIZE[1]).with_pixels_per_unit(1);
    shares(&mut canvas, sets);
    curve(&mut canvas, sets);
    for (place, set) in sets.iter().enumerate() {
        let y = 730.0 + 34.0 * place as f64;
        canvas.circle([1230.0, y], 8.0, theme::series(place));
        canvas.text([1250.0, y], &set.title(), FACE);
    }
    let y = 730.0 + 34.0 * sets.len() as f64;
    let tick = Stroke::solid(theme::INK, 3.0);
    canvas.line([1230.0, y - 11.0], [1230.0, y + 11.0], tick);
    canvas.text([1250.0, y], "always the commonest", FACE);
    canvas
}

fn shares(canvas: &mut Canvas, sets: &[Set<'_>]) {
    let [left, end, top, bottom] = SHARES;
    let x = |share: f64| left + (end - left) * share;
    let title = "Share of grasps named right, 95 % interval over objects";
    canvas.text([theme::MARGIN, 40.0], title, TITLE);
    for percent in [0_u32, 25, 50, 75, 100] {
        let at = x(f64::from(percent) / 100.0);
        canvas.line([at, top], [at, bottom], Stroke::solid(theme::FAINT, 2.0));
        let text = format!("{percent} %");
        canvas.text([at, bottom + 24.0], &text, FACE.anchored(Anchor::Middle));
    }
    let step = (bottom - top) / ROWS as f64;
    for (row, (measure, name)) in Measure::ALL.into_iter().take(ROWS).enumerate() {
        let middle = top + step * (row as f64 + 0.5);
        canvas.text([left - 14.0, middle], name, FACE.anchored(Anchor::End));
        for (place, set) in sets.iter().enumerate() {
            let share = right(&set.cases, measure);
            let y = middle + 26.0 * (place as f64 - 0.5 * (sets.len() - 1) as f64);
            let colour = theme::series(place);
            let [low, high] = share.interval;
            canvas.line([x(low), y], [x(high), y], Stroke::solid(colour, 3.0));
            canvas.circle([x(share.value), y], 8.0, colour);
            if let Some(common) = commonest(&set.cases, measure) {
                let at = x(common);
                let tick = Stroke::solid(theme::INK, 3.0);
                canvas.line([at, y - 11.0], [at, y + 11.0], tick);
            }
        }
    }
}

/// Share of right types against their probability.
fn curve(canvas: &mut Canvas, sets: &[Set<'_>]) {
    let [left, top, side] = CURVE;
    let at = |score: f64, right: f64| [left + side * score, top + side * (1.0 - right)];
    let title = "Type right, against its probability";
    canvas.text([left - 80.0, 40.0], title, TITLE);
    for (to, colour) in [
        ([1.0, 1.0], theme::PALE_LINE),
        ([1.0, 0.0], theme::LINE),
        ([0.0, 1.0], theme::LINE),
    ] {
        canvas.line(at(0.0, 0.0), at(to[0], to[1]), Stroke::solid(colour, 2.0));
    }
    for share in [0.0, 0.5, 1.0] {
        let text = format!("{share:.1}");
        let [x, y] = at(share, 0.0);
        canvas.text([x, y + 24.0], &text, FACE.anchored(Anchor::Middle));
        let [x, y] = at(0.0, share);
        canvas.text([x - 12.0, y], &text, FACE.anchored(Anchor::End));
    }
    for (place, set) in sets.iter().enumerate() {
        let mut bins = reliability(&set.cases).to_vec();
        bins.retain(|bin| bin.count > 0);
        let points: Vec<[f64; 2]> = bins.iter().map(|bin| at(bin.score, bin.right)).collect();
        let colour = theme::series(place);
        canvas.polyline(&points, Stroke::solid(colour, 3.0));
        for (bin, point) in bins.iter().zip(points) {
            canvas.circle(point, 3.0 + (bin.count as f64).sqrt(), colour);
        }
    }
}
