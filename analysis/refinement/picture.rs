//! The picture of samples before and after refinement.

use landscape::figure::{Anchor, Canvas, Colour, Image, Scene, TextFace, theme};
use nalgebra::Vector3;
use rayon::prelude::*;

use super::{Sample, Series, State};

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
        // At quantiles of ‖Gc‖ after refinement, evenly spaced from the least to the largest.
        let last = series.samples.len() - 1;
        let samples: Vec<&Sample> = (0..QUANTILES)
            .map(|k| &series.samples[(k * last + (QUANTILES - 1) / 2) / (QUANTILES - 1)])
            .collect();
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
            let caption = |state: &State| {
                let norm = state.judgement.net_wrench;
                format!("‖Gc‖ {norm:.2}   {:.1} mm", 1e3 * state.mean_distance_m)
            };
            below(first + SIDE, &caption(&sample.before), theme::INK);
            below(first + row + SIDE, &caption(&sample.after), theme::INK);
            let (verdict, colour) = match sample.after.holds() {
                [false, _] => ("no force closure", TRAPPED),
                [true, false] => ("closure, not touching", TRAPPED),
                [true, true] => ("force closure", HOLDS),
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
