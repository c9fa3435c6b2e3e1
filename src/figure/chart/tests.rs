use super::super::FigureError;
use super::super::testing::{assert_legible, gallery};
use super::super::theme;
use super::*;
use crate::sample::{Task, stream};
use rand::RngExt;

/// A noisy wave.
fn wave(phase: f64) -> Vec<[f64; 2]> {
    let mut rng = stream(0, Task::Start, 0);
    (0..60)
        .map(|i| {
            let x = 0.1 * f64::from(i);
            [x, libm::sin(x + phase) + 0.1 * rng.random::<f64>()]
        })
        .collect()
}

fn lines() -> Panel {
    let band = wave(0.0)
        .iter()
        .map(|&[x, y]| BandPoint {
            x,
            lower: y - 0.3,
            upper: y + 0.2 + 0.05 * x,
        })
        .collect();
    Panel {
        legend: Some(Corner::UpperRight),
        ..Panel::new(
            "lines and bands",
            Axis::linear("time t (s)"),
            Axis::linear("height h (m)").with_range(-1.6, 2.4),
            vec![
                Series::band(band).named("measured"),
                Series::line(wave(0.0)).named("measured"),
                Series::line(wave(1.0)).named("predicted").dashed(),
                Series::steps(wave(2.0).into_iter().step_by(5).collect()).named("rounded"),
                Series::new(Mark::Horizontal(-1.2))
                    .named("published")
                    .dashed(),
                Series::text([2.0, -1.35], "a limit from elsewhere"),
            ],
        )
    }
}

fn powers() -> Panel {
    let law: Vec<[f64; 2]> = [3, 5, 10, 20, 100, 1000]
        .map(|n| [f64::from(n), 0.21 * libm::pow(f64::from(n), 0.93)])
        .into();
    Panel {
        legend: Some(Corner::UpperLeft),
        ..Panel::new(
            "powers",
            Axis::logarithmic("contacts n"),
            Axis::logarithmic("time (µs)"),
            vec![
                Series::line(law.clone()).named("sphere"),
                Series::points(law).named("sphere"),
                Series::new(Mark::Vertical(100.0)).dashed(),
                Series::new(Mark::Horizontal(1600.0))
                    .named("published")
                    .dashed(),
            ],
        )
    }
}

fn violins() -> Panel {
    let violin = |k: u32| Violin {
        at: 0.1 * f64::from(k),
        half_width: 0.045,
        density: (0..50)
            .map(|step| 0.1 * f64::from(step))
            .map(|y| [y, libm::exp(-y / f64::from(k))])
            .collect(),
        quartiles: Some([0.25, 0.5, 0.75].map(|part| part * f64::from(k))),
    };
    let violins = Series::new(Mark::Violins((1..8).map(violin).collect()));
    Panel::new(
        "violins",
        Axis::linear("least friction μ₀"),
        Axis::linear("‖Gc‖"),
        vec![violins.coloured(theme::series(5))],
    )
}

fn cloud() -> Panel {
    let mut rng = stream(0, Task::Start, 2);
    let cloud: Vec<[f64; 2]> = (0..20_000)
        .map(|_| {
            let x: f64 = rng.random();
            [x, x * rng.random::<f64>().sqrt()]
        })
        .collect();
    Panel {
        legend: Some(Corner::UpperLeft),
        ..Panel::new(
            "a cloud",
            Axis::linear("x"),
            Axis::linear("y"),
            vec![
                Series {
                    opacity: 0.15,
                    ..Series::points(cloud).named("draws")
                },
                Series::line(vec![[0.0, 0.0], [1.0, 1.0]]).named("limit"),
            ],
        )
    }
}

fn decades() -> Panel {
    let error = (0..14).map(|k| {
        let h = 10f64.powi(-k);
        [h, h * h + 1e-16 / h]
    });
    Panel::new(
        "many decades",
        Axis::logarithmic("step h"),
        Axis::logarithmic("error"),
        vec![Series::line(error.collect())],
    )
}

/// Every mark, on every kind of axis.
fn sampler() -> Chart {
    let panels = vec![lines(), powers(), violins(), cloud(), decades()];
    Chart {
        legend_below: true,
        ..Chart::new("Everything a chart can show", panels)
    }
}

#[test]
fn every_text_is_on_the_sheet_and_touches_no_other() {
    let chart = sampler();
    let canvas = chart.draw().unwrap();
    assert_legible(&canvas);
    let texts = canvas.texts();
    for wanted in ["time t (s)", "predicted", "10⁻¹²", "100"] {
        assert!(texts.iter().any(|(text, _)| *text == wanted), "{wanted}");
    }
    gallery(&canvas, "chart");
    for panel in chart.panels {
        assert_legible(&Chart::new("", vec![panel]).draw().unwrap());
    }
}

#[test]
fn the_same_chart_gives_the_same_bytes() {
    let [a, b] = [(), ()].map(|()| sampler().draw().unwrap());
    assert_eq!(a.to_svg().unwrap(), b.to_svg().unwrap());
}

#[test]
fn series_of_one_name_share_colour_and_legend() {
    let canvas = sampler().draw().unwrap();
    let count = |wanted: &str| {
        let texts = canvas.texts();
        texts.iter().filter(|(text, _)| *text == wanted).count()
    };
    // Inside its panel and below.
    assert_eq!(count("measured"), 2);
    // Inside two panels and below.
    assert_eq!(count("published"), 3);
    let line = |colour| Series {
        colour,
        ..Series::line(vec![[0.0, 0.0], [1.0, 1.0]])
    };
    let panel = |series| Panel::new("", Axis::linear(""), Axis::linear(""), series);
    let drawn = |panels| Chart::new("", panels).draw().unwrap().to_svg().unwrap();
    let red = Colour::new(1, 2, 3);
    let svg = drawn(vec![
        panel(vec![line(None).named("a")]),
        panel(vec![line(Some(red)).named("a")]),
    ]);
    assert_eq!(svg.matches("#010203").count(), 2, "{svg}");
}

#[test]
fn nothing_is_drawn_outside_its_panel() {
    let points = vec![
        [-100.0, 0.5],
        [0.5, 0.5],
        [0.6, 100.0],
        [0.7, 0.5],
        [9.0, -9.0],
    ];
    let panel = Panel::new(
        "",
        Axis::linear("").with_range(0.0, 1.0),
        Axis::linear("").with_range(0.0, 1.0),
        vec![
            Series::line(points.clone()),
            Series::points(points.clone()),
            Series::band(
                points
                    .iter()
                    .map(|&[x, y]| BandPoint {
                        x,
                        lower: y - 2.0,
                        upper: y + 2.0,
                    })
                    .collect(),
            ),
            Series::new(Mark::Horizontal(4.0)),
        ],
    );
    let canvas = Chart::new("", vec![panel]).draw().unwrap();
    let image = canvas.to_image().unwrap();
    let margin = 2 * 20;
    for (index, pixel) in image.rgb.chunks(3).enumerate() {
        let (x, y) = (index % image.width as usize, index / image.width as usize);
        let outside = y < margin || x + 2 * 20 > image.width as usize;
        assert!(!outside || pixel == [255; 3], "ink at {x}, {y}");
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_and_emptiness_is_not() {
    let chart = |x: Axis, series: Vec<Series>| {
        Chart::new("", vec![Panel::new("", x, Axis::linear("y"), series)]).draw()
    };
    let points = |x: f64| vec![Series::points(vec![[x, 1.0]])];
    assert!(matches!(
        chart(Axis::logarithmic("x"), points(-1.0)),
        Err(FigureError::OffAxis { .. })
    ));
    assert!(matches!(
        chart(Axis::linear("x").with_range(1.0, 0.0), points(1.0)),
        Err(FigureError::Range { .. })
    ));
    let nothing = vec![
        Series::line(Vec::new()),
        Series::steps(Vec::new()),
        Series::points(vec![[f64::NAN, 1.0]]),
        Series::band(Vec::new()),
        Series::new(Mark::Violins(vec![Violin {
            at: 1.0,
            half_width: 0.2,
            density: Vec::new(),
            quartiles: None,
        }])),
    ];
    assert_legible(&chart(Axis::linear("x"), nothing).unwrap());
    assert!(Chart::new("empty", Vec::new()).draw().is_ok());
}
