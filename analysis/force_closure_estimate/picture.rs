//! The picture of the comparison.

use landscape::figure::chart::{Axis, Chart, Corner, Mark, Panel, Series};
use landscape::figure::{Canvas, FigureError, theme};

use super::density::violin;
use super::descent::Descents;
use super::fit::Fit;
use super::quality::{Quality, THRESHOLDS};
use super::sets::{FRICTIONS, Set};

/// Slope in Fig. 2 of Liu et al. (2021).
pub(crate) const PUBLISHED_SLOPE: f64 = 4.035;
/// Width of the bins of μ₀. `BINS` is their number.
const BIN: f64 = 0.1;
const BINS: u32 = 15;
/// Largest μ₀ at which the line with an offset is fitted and drawn.
const AFFINE_LIMIT: f64 = 0.5;

/// Least ‖Gc‖ on the sphere at this μ₀: that of the equilateral triangle.
fn least_net_wrench(friction: f64) -> f64 {
    3.0 * friction / libm::hypot(1.0_f64, friction)
}

pub(crate) fn draw(sets: &[Set], limit: f64, descents: &Descents) -> Result<Canvas, FigureError> {
    let chart = Chart {
        columns: 3,
        panel_size: [800, 680],
        ..Chart::new("", vec![violins(sets), slopes(sets, limit), kept(descents)])
    };
    // 350 pixels per inch across a page.
    Ok(chart.draw()?.with_pixels_per_unit(1))
}

fn violins(sets: &[Set]) -> Panel {
    let edges = (0..BINS).map(|bin| f64::from(bin) * BIN);
    let above = |from: f64| {
        let start = sets.partition_point(|set| set.least_friction < from);
        let end = sets.partition_point(|set| set.least_friction < from + BIN);
        let samples: Vec<f64> = sets[start..end]
            .iter()
            .map(|set| set.verdict.net_wrench)
            .collect();
        violin(from + 0.5 * BIN, 0.45 * BIN, &samples)
    };
    let end = BIN * f64::from(BINS);
    let curve = |value: &dyn Fn(f64) -> f64, to: f64| -> Vec<[f64; 2]> {
        (0..=100)
            .map(|step| to * f64::from(step) / 100.0)
            .map(|friction| [friction, value(friction)])
            .collect()
    };
    let affine = Fit::up_to(sets, AFFINE_LIMIT).line;
    let published = format!("paper: {PUBLISHED_SLOPE} μ₀");
    let with_offset = format!("{:.2} μ₀ + {:.2}", affine.slope, affine.offset);
    let violins = Mark::Violins(edges.map(above).collect());
    let [orange, violet, green] = [1, 6, 2].map(theme::series);
    Panel::new(
        "500,000 random sets of three contacts",
        Axis::linear("least friction μ₀").with_range(0.0, end),
        Axis::linear("‖Gc‖").with_range(0.0, 3.0),
        vec![
            Series::new(violins).coloured(theme::series(5)),
            Series::line(curve(&|friction| PUBLISHED_SLOPE * friction, end))
                .coloured(orange)
                .dashed(),
            Series::line(curve(&|friction| affine.at(friction), AFFINE_LIMIT)).coloured(violet),
            Series::line(curve(&least_net_wrench, end)).coloured(green),
            Series::new(Mark::Horizontal(THRESHOLDS[0])).dashed(),
            Series::text([0.77, 2.88], &published).coloured(orange),
            Series::text([0.06, 2.1], &with_offset).coloured(violet),
            Series::text([0.06, 1.93], "(fits μ₀ ≤ 0.5)").coloured(violet),
            Series::text([0.66, 1.2], "least: 3μ₀/√(1+μ₀²)").coloured(green),
            Series::text([0.66, THRESHOLDS[0] - 0.12], "relaxed test: ‖Gc‖ < 0.5"),
        ],
    )
}

fn slopes(sets: &[Set], limit: f64) -> Panel {
    let fits: Vec<(f64, Fit)> = (4..=80)
        .map(|step| f64::from(step) * 0.025)
        .map(|limit| (limit, Fit::up_to(sets, limit)))
        .collect();
    let curve = |value: fn(&Fit) -> f64| -> Vec<[f64; 2]> {
        fits.iter()
            .map(|(limit, fit)| [*limit, value(fit)])
            .collect()
    };
    let published = format!("paper: {PUBLISHED_SLOPE}");
    let reached = format!("μ₀ ≤ {limit:.4}");
    Panel {
        legend: Some(Corner::UpperRight),
        ..Panel::new(
            "the slope depends on the range",
            Axis::linear("sets with μ₀ up to").with_range(0.0, 2.0),
            Axis::linear("slope a, correlation r").with_range(0.0, 12.0),
            vec![
                Series::line(curve(|fit| fit.through_origin))
                    .named("‖Gc‖ ≈ a μ₀")
                    .coloured(theme::series(1)),
                Series::line(curve(|fit| fit.line.slope))
                    .named("‖Gc‖ ≈ a μ₀ + b")
                    .coloured(theme::series(6)),
                Series::line(curve(|fit| fit.correlation))
                    .named("correlation r")
                    .coloured(theme::series(0)),
                Series::new(Mark::Horizontal(PUBLISHED_SLOPE)).dashed(),
                Series::new(Mark::Vertical(limit)).dashed(),
                Series::points(vec![[limit, PUBLISHED_SLOPE]]),
                Series::text([1.5, PUBLISHED_SLOPE + 0.4], &published),
                Series::text([limit + 0.03, 5.6], &reached),
            ],
        )
    }
}

fn kept(descents: &Descents) -> Panel {
    let curve = |value: &dyn Fn(&[_]) -> f64| -> Vec<[f64; 2]> {
        let steps = descents.steps.iter().zip(&descents.verdicts);
        steps
            .map(|(&step, verdicts)| [step as f64, 100.0 * value(verdicts)])
            .collect()
    };
    let mut series = Vec::new();
    for friction in 0..FRICTIONS.len() {
        // Both frictions have the same name; the second is dashed.
        let line = |points, name: &str, colour: usize| {
            let line = Series::line(points).coloured(theme::series(colour));
            if friction == 0 {
                line.named(name)
            } else {
                line.dashed()
            }
        };
        for (threshold, name, colour) in [
            (THRESHOLDS[0], "kept by ‖Gc‖ < 0.5", 0),
            (THRESHOLDS[1], "kept by ‖Gc‖ < 0.707", 1),
        ] {
            let recall = curve(&|sets| Quality::of(sets, threshold, friction).recall());
            series.push(line(recall, name, colour));
        }
        let closed = curve(&|sets| Quality::of(sets, THRESHOLDS[0], friction).share_closed());
        series.push(line(closed, "force-closed", 8));
    }
    let [solid, dashed] = FRICTIONS;
    let frictions = format!("solid: μ = {solid}, dashed: μ = {dashed}");
    series.push(Series::text([19.0, 33.0], &frictions));
    Panel {
        legend: Some(Corner::LowerRight),
        ..Panel::new(
            "from random to optimised sets",
            Axis::linear("steps down Eq. 7, each at most 0.1 radii"),
            Axis::linear("force-closed, and kept of these (%)").with_range(0.0, 100.0),
            series,
        )
    }
}
