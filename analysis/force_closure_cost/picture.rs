//! The picture of the costs.

use landscape::figure::chart::{Axis, BandPoint, Chart, Mark, Panel, Series};
use landscape::figure::{Canvas, Colour, FigureError, theme};

use super::report::{OFFICIAL_BATCH_S, OFFICIAL_S, paper_s};
use super::{CONTACTS, Measured, Relaxed, fit};

const MICROSECOND: f64 = 1e-6;

fn micro(costs: &[f64]) -> Vec<[f64; 2]> {
    CONTACTS
        .iter()
        .zip(costs)
        .map(|(&n, t)| [n as f64, t / MICROSECOND])
        .collect()
}

fn relaxed_name(relaxed: &Relaxed) -> String {
    format!("relaxed with derivative, {}", relaxed.shape)
}

/// A line and its points under one name.
fn drawn(name: &str, points: Vec<[f64; 2]>, colour: Colour) -> [Series; 2] {
    [Series::line(points.clone()), Series::points(points)]
        .map(|series| series.named(name).coloured(colour))
}

pub(crate) fn draw(measured: &Measured) -> Result<Canvas, FigureError> {
    let chart = Chart {
        columns: 3,
        panel_size: [760, 640],
        legend_below: true,
        ..Chart::new("", vec![costs(measured), fits(measured), normals(measured)])
    };
    chart.draw()
}

fn costs(measured: &Measured) -> Panel {
    let mut series = Vec::new();
    for (index, relaxed) in measured.relaxed.iter().enumerate() {
        let name = relaxed_name(relaxed);
        series.extend(drawn(&name, micro(&relaxed.forces), theme::series(index)));
    }
    let exact = [
        ("exact: force closure at 0.5", &measured.force_closure, 5),
        ("exact: least friction", &measured.least_friction, 6),
    ];
    for (name, costs, colour) in exact {
        series.extend(drawn(name, micro(costs), theme::series(colour)));
    }
    let published: Vec<[f64; 2]> = CONTACTS
        .iter()
        .map(|&n| [n as f64, paper_s(n) / MICROSECOND])
        .collect();
    let grey = theme::series(8);
    let reference = |name: &str, points| Series::line(points).named(name).dashed();
    series.extend([
        reference("paper, RTX 3090", published).coloured(grey),
        reference("official code, CPU", micro(&OFFICIAL_S)).coloured(theme::series(4)),
        reference(
            "official code, CPU, one of a batch of 1024",
            micro(&OFFICIAL_BATCH_S),
        )
        .coloured(theme::series(7)),
    ]);
    Panel::new(
        "cost of one test",
        Axis::logarithmic("contacts n"),
        Axis::logarithmic("time (µs)"),
        series,
    )
}

fn fits(measured: &Measured) -> Panel {
    let Some(sphere) = measured.relaxed.first() else {
        return Panel::new("", Axis::linear(""), Axis::linear(""), Vec::new());
    };
    let log = fit::logarithm(&CONTACTS, &sphere.forces);
    let straight = fit::proportion(&CONTACTS, &sphere.forces);
    let curve = |t: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
        (0..=100)
            .map(|step| {
                let n = 3.0 * libm::pow(1000.0_f64 / 3.0, f64::from(step) / 100.0);
                [n, t(n) / MICROSECOND]
            })
            .collect()
    };
    let name = relaxed_name(sphere);
    let points = Series::points(micro(&sphere.forces))
        .named(&name)
        .coloured(theme::series(0));
    let by_log = format!("a log n + b, R² {:.3}", log.r_squared);
    let by_line = format!("a n + b, R² {:.5}", straight.r_squared);
    let mut panel = Panel::new(
        "which law? (sphere)",
        Axis::logarithmic("contacts n"),
        Axis::linear("time (µs)"),
        vec![
            Series::line(curve(&|n| log.at(libm::log10(n))))
                .coloured(theme::series(1))
                .dashed(),
            Series::line(curve(&|n| straight.at(n))).coloured(theme::series(2)),
            points,
        ],
    );
    let top = sphere.forces.iter().fold(0.0, |top: f64, &t| top.max(t)) / MICROSECOND;
    panel.series.extend([
        Series::text([3.3, 0.95 * top], &by_line).coloured(theme::series(2)),
        Series::text([3.3, 0.87 * top], &by_log).coloured(theme::series(1)),
    ]);
    panel
}

fn normals(measured: &Measured) -> Panel {
    let mut series = Vec::new();
    for (index, relaxed) in measured.relaxed.iter().enumerate() {
        let shares = || CONTACTS.iter().zip(&relaxed.answers_share);
        let colour = theme::series(index);
        let spread = shares()
            .map(|(&n, share)| BandPoint {
                x: n as f64,
                lower: 100.0 * share.lower,
                upper: 100.0 * share.upper,
            })
            .collect();
        series.push(Series::band(spread).coloured(colour));
        let medians = shares()
            .map(|(&n, share)| [n as f64, 100.0 * share.median])
            .collect();
        series.extend(drawn(&relaxed_name(relaxed), medians, colour));
    }
    series.push(Series::new(Mark::Horizontal(80.0)).dashed());
    series.push(Series::text([3.3, 86.0], "80 %: the paper, for normals"));
    Panel::new(
        "share of asking the shape (median, quartiles)",
        Axis::logarithmic("contacts n"),
        Axis::linear("distances, normals, curvature (%)").with_range(0.0, 110.0),
        series,
    )
}
