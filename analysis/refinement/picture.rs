//! The pictures.

use landscape::figure::chart::{Axis, Chart, Corner, Panel, Series as Line};
use landscape::figure::{Anchor, Canvas, Colour, Image, Scene, TextFace, theme};
use nalgebra::Vector3;
use rayon::prelude::*;

use super::{Sample, Score, Series, Truth, area};

const QUANTILES: usize = 5;
const SIDE: u32 = 140;
const GAP: u32 = 10;
const CAPTION: u32 = 22;
const TITLE: u32 = 34;
/// Width of the column with the words "before" and "after".
const LEFT: u32 = 26;

const TRAPPED: Colour = Colour::new(0xB0, 0x3A, 0x00);
const HOLDS: Colour = Colour::new(0x00, 0x6B, 0x4E);

/// Samples of each method, before refinement above after refinement, from the same viewpoint.
pub(crate) fn sheet(all: &[Series]) -> Canvas {
    let columns = u32::try_from(QUANTILES).unwrap_or(u32::MAX);
    let row = SIDE + CAPTION;
    let block = TITLE + 2 * row + CAPTION + GAP;
    let blocks = u32::try_from(all.len()).unwrap_or(u32::MAX);
    let mut canvas = Canvas::new(LEFT + columns * (SIDE + GAP) + GAP, GAP + blocks * block)
        .with_pixels_per_unit(1);
    let mut top = GAP;
    for series in all {
        let title = format!("{}, {}", series.name, series.about);
        let face = TextFace::new(18.0, theme::INK).bold();
        canvas.text([f64::from(LEFT), f64::from(top) + 14.0], &title, face);
        for (words, at) in [("before", top + TITLE), ("after", top + TITLE + row)] {
            let face = TextFace::new(16.0, theme::INK)
                .anchored(Anchor::Middle)
                .upward();
            let middle = f64::from(at) + 0.5 * f64::from(SIDE);
            canvas.text([0.5 * f64::from(LEFT), middle], words, face);
        }
        let samples: Vec<&Sample> = series.quantiles(QUANTILES).collect();
        let images: Vec<[Image; 2]> = samples
            .par_iter()
            .map(|sample| render(series, sample))
            .collect();
        let mut left = LEFT;
        for (sample, [before, after]) in samples.iter().zip(images) {
            let middle = f64::from(left) + 0.5 * f64::from(SIDE);
            let mut below = |at: u32, text: &str, colour: Colour| {
                let face = TextFace::new(14.0, colour).anchored(Anchor::Middle);
                let at = [middle, f64::from(at) + 0.5 * f64::from(CAPTION)];
                canvas.text(at, text, face.fitted(text, f64::from(SIDE)));
            };
            let first = top + TITLE;
            below(first + SIDE, &sample.before.caption(), theme::INK);
            below(first + row + SIDE, &sample.after.caption(), theme::INK);
            let (verdict, colour) = if Truth::NoForceClosure.of(&sample.after) {
                ("no force closure", TRAPPED)
            } else if Truth::NoGrasp.of(&sample.after) {
                ("closure, not touching", TRAPPED)
            } else {
                ("force closure", HOLDS)
            };
            below(first + 2 * row, verdict, colour);
            canvas.image([left, first], before);
            canvas.image([left, first + row], after);
            left += SIDE + GAP;
        }
        top += block;
    }
    canvas
}

fn render(series: &Series, sample: &Sample) -> [Image; 2] {
    let (hand, object) = (series.method.hand(), series.method.object());
    let skin = hand.skin();
    let before = Scene::of_grasp(hand, &skin, object, &sample.before.grasp);
    let after = Scene::of_grasp(hand, &skin, object, &sample.after.grasp);
    let mut both = after.clone();
    both.surfaces.extend(before.surfaces.iter().cloned());
    // The viewpoint that shows the refined contacts best.
    let toward_eye = after.best_camera(Vector3::z()).toward_eye();
    let camera = both.framed(toward_eye, Vector3::z());
    [before, after].map(|scene| scene.render(&camera, SIDE, SIDE))
}

/// Least number of cases in each class for a meaningful curve.
const FEWEST: usize = 3;

/// The curves: share of trapped samples above a threshold against share of other samples above it.
pub(crate) fn curves(all: &[Series]) -> Chart {
    let both = |truth: &Truth| {
        all.iter()
            .map(|series| (series, *truth))
            .collect::<Vec<_>>()
    };
    let pairs = Truth::ALL.iter().flat_map(both);
    let shown = pairs.filter(|(series, truth)| {
        let trapped = series.trapped(*truth);
        trapped.min(series.samples.len() - trapped) >= FEWEST
    });
    Chart {
        columns: 2,
        panel_size: [800, 660],
        ..Chart::new(
            "",
            shown.map(|(series, truth)| panel(series, truth)).collect(),
        )
    }
}

fn panel(series: &Series, truth: Truth) -> Panel {
    let mut lines = vec![
        Line::line(vec![[0.0, 0.0], [1.0, 1.0]])
            .coloured(theme::PALE_LINE)
            .dashed(),
    ];
    for (index, score) in Score::ALL.into_iter().enumerate() {
        let Ok(roc) = series.roc(score, truth) else {
            continue;
        };
        let points = roc.points.iter();
        let places = points.map(|p| [p.false_positive_rate, p.true_positive_rate]);
        let line = Line::line(places.collect()).coloured(theme::series(index));
        lines.push(line.named(&format!("{}: {}", score.name(), area(&roc))));
    }
    let (trapped, count) = (series.trapped(truth), series.samples.len());
    Panel {
        legend: Some(Corner::LowerRight),
        ..Panel::new(
            &format!("{}: {trapped} of {count} {}", series.name, truth.name()),
            Axis::linear("share of the others taken for such").with_range(0.0, 1.0),
            Axis::linear("share of them found").with_range(0.0, 1.0),
            lines,
        )
    }
}
