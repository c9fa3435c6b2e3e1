//! Rarefaction curves: number of kinds found against number of members used.

use super::chart::{Axis, BandPoint, Chart, Corner, Mark, Panel, Series};
use super::style::Colour;
use super::theme::series;
use crate::topography::{Rarefaction, Rarefied};

/// Half-width of a 95 % band in standard deviations.
const BAND: f64 = 1.96;

/// Named curves of several ways to divide the same members, with 95 % bands. A vertical line marks the number of members at
/// hand; the curves are dashed beyond it. `members` is the plural noun for the members.
pub fn rarefaction_chart(title: &str, members: &str, curves: &[(&str, &Rarefaction)]) -> Chart {
    let coloured: Vec<(&str, &Rarefaction, Colour)> = (curves.iter().enumerate())
        .map(|(number, (name, found))| (*name, *found, series(number)))
        .collect();
    let mut panel = Panel {
        legend: Some(Corner::UpperLeft),
        ..rarefaction_panel(title, members, &coloured)
    };
    if let Some((_, first)) = curves.first() {
        let at_hand = Series::new(Mark::Vertical(first.members as f64));
        panel.series.insert(0, at_hand);
    }
    Chart::new("", vec![panel])
}

/// Named curves, of the same or of different members, with 95 % bands and without a legend. Each is dashed beyond the number
/// of its members at hand. `members` is the plural noun for the members.
pub fn rarefaction_panel(
    title: &str,
    members: &str,
    curves: &[(&str, &Rarefaction, Colour)],
) -> Panel {
    let mut marks = Vec::new();
    for &(name, found, colour) in curves {
        let (inside, mut beyond): (Vec<&Rarefied>, Vec<&Rarefied>) =
            (found.curve.iter()).partition(|point| point.deviation.is_some());
        beyond.splice(0..0, inside.last().copied());
        let line = |points: &[&Rarefied]| {
            let places = points.iter();
            places
                .map(|point| [point.members as f64, point.kinds])
                .collect::<Vec<_>>()
        };
        let band = inside.iter().map(|point| {
            let half = BAND * point.deviation.unwrap_or(0.0);
            BandPoint {
                x: point.members as f64,
                lower: (point.kinds - half).max(0.0),
                upper: (point.kinds + half).min(point.members as f64),
            }
        });
        marks.push(Series::band(band.collect()).coloured(colour));
        marks.push(Series::line(line(&inside)).named(name).coloured(colour));
        marks.push(Series::line(line(&beyond)).coloured(colour).dashed());
    }
    Panel::new(
        title,
        Axis::linear(&format!("{members} used")),
        Axis::linear("expected number found"),
        marks,
    )
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_legible, gallery};
    use super::*;

    #[test]
    fn two_curves() {
        let sizes: Vec<usize> = (1..60).map(|k| 90 / (k * k) + 1).collect();
        let families = Rarefaction::new(&sizes, 60);
        let minima = Rarefaction::new(&vec![1; families.members], 60);
        let curves = [("families", &families), ("minima", &minima)];
        let canvas = rarefaction_chart("200 grasps", "grasps", &curves)
            .draw()
            .unwrap();
        assert_legible(&canvas);
        gallery(&canvas, "rarefaction");
        let texts = canvas.texts();
        for expected in ["families", "minima", "grasps used"] {
            assert!(texts.iter().any(|(text, _)| *text == expected));
        }
        // Nothing to show is no mistake.
        let empty = Rarefaction::new(&[], 60);
        let canvas = rarefaction_chart("", "grasps", &[("families", &empty)]).draw();
        assert!(canvas.is_ok());
    }
}
