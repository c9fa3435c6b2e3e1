//! Shares of right labels with their intervals, a row for each measure, a colour for each set, beside always the commonest
//! answer; and the reliability curve of people's grasps.

use landscape::figure::{Anchor, Canvas, Stroke, TextFace, theme};

use crate::Set;
use crate::case::{Case, Measure};
use crate::report::{commonest, over_objects, per_grasp, reliability};

const SIZE: [u32; 2] = [1900, 900];
const FACE: TextFace = TextFace::new(24.0, theme::INK);
const TITLE: TextFace = TextFace::new(29.0, theme::INK);
/// Left, right, top and bottom of the panel of shares, and corner and side of the panel of reliability.
const SHARES: [f64; 4] = [330.0, 1120.0, 110.0, 800.0];
const CURVE: [f64; 3] = [1310.0, 160.0, 500.0];
const ROWS: [Measure; 6] = [
    Measure::Category,
    Measure::Opposition,
    Measure::VirtualFingers,
    Measure::Cell,
    Measure::Type,
    Measure::TopThree,
];

pub(crate) fn picture(sets: &[Set]) -> Canvas {
    let mut canvas = Canvas::new(SIZE[0], SIZE[1]).with_pixels_per_unit(1);
    shares(&mut canvas, sets);
    curve(&mut canvas, sets);
    for (place, set) in sets.iter().enumerate() {
        let y = 730.0 + 34.0 * place as f64;
        canvas.circle([1230.0, y], 8.0, theme::series(place));
        canvas.text([1250.0, y], &set.name, FACE);
    }
    canvas.line(
        [1230.0, 821.0],
        [1230.0, 843.0],
        Stroke::solid(theme::INK, 3.0),
    );
    canvas.text([1250.0, 832.0], "always the commonest", FACE);
    canvas
}

fn shares(canvas: &mut Canvas, sets: &[Set]) {
    let [left, right, top, bottom] = SHARES;
    let x = |share: f64| left + (right - left) * share;
    let title = "Share of grasps named right, 95 % interval over objects";
    canvas.text([theme::MARGIN, 40.0], title, TITLE);
    for percent in [0_u32, 25, 50, 75, 100] {
        let at = x(f64::from(percent) / 100.0);
        canvas.line([at, top], [at, bottom], Stroke::solid(theme::FAINT, 2.0));
        let text = format!("{percent} %");
        canvas.text([at, bottom + 24.0], &text, FACE.anchored(Anchor::Middle));
    }
    let step = (bottom - top) / ROWS.len() as f64;
    for (row, measure) in ROWS.iter().enumerate() {
        let middle = top + step * (row as f64 + 0.5);
        canvas.text(
            [left - 14.0, middle],
            measure.name(),
            FACE.anchored(Anchor::End),
        );
        for (place, set) in sets.iter().enumerate() {
            let cases: Vec<&Case> = set.cases.iter().collect();
            let share = over_objects(&cases, &|cases| per_grasp(cases, *measure));
            let y = middle + 26.0 * (place as f64 - 1.0);
            let colour = theme::series(place);
            let [low, high] = share.interval;
            canvas.line([x(low), y], [x(high), y], Stroke::solid(colour, 3.0));
            canvas.circle([x(share.value), y], 8.0, colour);
            if let Some(common) = commonest(&cases, *measure) {
                let at = x(common);
                canvas.line(
                    [at, y - 11.0],
                    [at, y + 11.0],
                    Stroke::solid(theme::INK, 3.0),
                );
            }
        }
    }
}

/// Share of right types against their probability, for people's grasps.
fn curve(canvas: &mut Canvas, sets: &[Set]) {
    let [left, top, side] = CURVE;
    let at = |score: f64, right: f64| [left + side * score, top + side * (1.0 - right)];
    canvas.text(
        [left - 80.0, 40.0],
        "Type right, against its probability",
        TITLE,
    );
    canvas.line(
        at(0.0, 0.0),
        at(1.0, 1.0),
        Stroke::solid(theme::PALE_LINE, 2.0),
    );
    for (from, to) in [([0.0, 0.0], [1.0, 0.0]), ([0.0, 0.0], [0.0, 1.0])] {
        canvas.line(
            at(from[0], from[1]),
            at(to[0], to[1]),
            Stroke::solid(theme::LINE, 2.0),
        );
    }
    for tenth in [0_u32, 5, 10] {
        let share = f64::from(tenth) / 10.0;
        let text = format!("{share:.1}");
        let [x, y] = at(share, 0.0);
        canvas.text([x, y + 24.0], &text, FACE.anchored(Anchor::Middle));
        let [x, y] = at(0.0, share);
        canvas.text([x - 12.0, y], &text, FACE.anchored(Anchor::End));
    }
    for (place, set) in sets
        .iter()
        .enumerate()
        .filter(|(_, set)| set.posed_by_people)
    {
        let cases: Vec<&Case> = set.cases.iter().collect();
        let bins = reliability(&cases);
        let points: Vec<[f64; 2]> = (bins.iter())
            .filter(|bin| bin.count > 0)
            .map(|bin| at(bin.score, bin.right))
            .collect();
        canvas.polyline(&points, Stroke::solid(theme::series(place), 3.0));
        for bin in bins.iter().filter(|bin| bin.count > 0) {
            let radius = 3.0 + (bin.count as f64).sqrt();
            canvas.circle(at(bin.score, bin.right), radius, theme::series(place));
        }
    }
}
