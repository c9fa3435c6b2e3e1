//! Figure 2: the relaxed force-closure test compared with the exact one → `figures/force_closure_estimate.png`,
//! `figures/force_closure_estimate.md`
//!
//! `cargo run --release --example force_closure_estimate` takes well under a minute on two cores.

mod sets;

use std::fmt::Write;

use landscape::figure::chart::{Axis, Chart, Corner, Mark, Panel, Series, Violin};
use landscape::figure::theme;
use sets::{FRICTIONS, Fit, Set, limit_with_slope, threes};

/// Number of random sets of three contacts, as in the paper.
const SETS: u64 = 500_000;
/// Slope in Fig. 2 of Liu et al. (2021).
const PUBLISHED_SLOPE: f64 = 4.035;
/// Thresholds of ‖Gc‖: the paper's, and that of the released code, which compares the square.
const THRESHOLDS: [f64; 2] = [0.5, std::f64::consts::FRAC_1_SQRT_2];
/// Width of the bins of μ₀. `BINS` is their number.
const BIN: f64 = 0.1;
const BINS: u32 = 15;
/// Number of equal parts of the range of ‖Gc‖, 0 to 3, in a violin.
const PARTS: u32 = 100;
/// Largest μ₀ at which the line with an offset is fitted and drawn.
const AFFINE_LIMIT: f64 = 0.5;
/// Upper limits of μ₀ for the fits.
const LIMITS: [f64; 11] = [
    0.1,
    0.2,
    0.3,
    0.4,
    0.5,
    0.6,
    0.8,
    1.0,
    1.5,
    2.0,
    f64::INFINITY,
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sets = threes(SETS);
    let limit = limit_with_slope(&sets, PUBLISHED_SLOPE, [0.1, 3.0]);
    let chart = Chart {
        columns: 2,
        panel_size: [800, 680],
        ..Chart::new("", vec![violins(&sets), slopes(&sets, limit)])
    };
    // 350 pixels per inch across a page.
    let canvas = chart.draw()?.with_pixels_per_unit(1);
    canvas.save("figures/force_closure_estimate.png".as_ref())?;
    std::fs::write("figures/force_closure_estimate.md", text(&sets, limit))?;
    Ok(())
}

/// The distribution of ‖Gc‖ above a bin of μ₀ that begins at `from`.
fn violin(sets: &[Set], from: f64) -> Violin {
    let start = sets.partition_point(|set| set.least_friction < from);
    let end = sets.partition_point(|set| set.least_friction < from + BIN);
    let mut norms: Vec<f64> = sets[start..end].iter().map(|set| set.net_wrench).collect();
    norms.sort_by(f64::total_cmp);
    let place = |part: u32| 3.0 * f64::from(part) / f64::from(PARTS);
    let below = |norm: f64| norms.partition_point(|one| *one < norm);
    let density = (0..PARTS).map(|part| {
        let count = below(place(part + 1)) - below(place(part));
        [0.5 * (place(part) + place(part + 1)), count as f64]
    });
    Violin {
        at: from + 0.5 * BIN,
        half_width: 0.45 * BIN,
        density: density.filter(|[_, count]| *count > 0.0).collect(),
        quartiles: Some([1, 2, 3].map(|quarter| norms[norms.len() * quarter / 4])),
    }
}

fn violins(sets: &[Set]) -> Panel {
    let edges = (0..BINS).map(|bin| f64::from(bin) * BIN);
    let violins = Mark::Violins(edges.map(|from| violin(sets, from)).collect());
    let end = BIN * f64::from(BINS);
    let curve = |value: &dyn Fn(f64) -> f64, to: f64| -> Series {
        let frictions = (0..=100).map(|step| to * f64::from(step) / 100.0);
        Series::line(
            frictions
                .map(|friction| [friction, value(friction)])
                .collect(),
        )
    };
    // Least ‖Gc‖ on the sphere at this μ₀: that of the equilateral triangle.
    let least = |friction: f64| 3.0 * friction / libm::hypot(1.0_f64, friction);
    let affine = Fit::up_to(sets, AFFINE_LIMIT);
    let published = format!("paper: {PUBLISHED_SLOPE} μ₀");
    let with_offset = format!("{:.2} μ₀ + {:.2}", affine.slope, affine.offset);
    let line = |friction: f64| affine.slope * friction + affine.offset;
    let [orange, violet, green] = [1, 6, 2].map(theme::series);
    Panel::new(
        "500,000 random sets of three contacts",
        Axis::linear("least friction μ₀").with_range(0.0, end),
        Axis::linear("‖Gc‖").with_range(0.0, 3.0),
        vec![
            Series::new(violins).coloured(theme::series(5)),
            curve(&|friction| PUBLISHED_SLOPE * friction, end)
                .coloured(orange)
                .dashed(),
            curve(&line, AFFINE_LIMIT).coloured(violet),
            curve(&least, end).coloured(green),
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
    let limits = (4..=80).map(|step| f64::from(step) * 0.025);
    let fits: Vec<(f64, Fit)> = limits
        .map(|limit| (limit, Fit::up_to(sets, limit)))
        .collect();
    let curve = |name: &str, colour, value: fn(&Fit) -> f64| {
        let points = fits.iter().map(|(limit, fit)| [*limit, value(fit)]);
        let line = Series::line(points.collect()).named(name);
        line.coloured(theme::series(colour))
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
                curve("‖Gc‖ ≈ a μ₀", 1, |fit| fit.through_origin),
                curve("‖Gc‖ ≈ a μ₀ + b", 6, |fit| fit.slope),
                curve("correlation r", 0, |fit| fit.correlation),
                Series::new(Mark::Horizontal(PUBLISHED_SLOPE)).dashed(),
                Series::new(Mark::Vertical(limit)).dashed(),
                Series::points(vec![[limit, PUBLISHED_SLOPE]]),
                Series::text([1.5, PUBLISHED_SLOPE + 0.4], &published),
                Series::text([limit + 0.03, 5.6], &reached),
            ],
        )
    }
}

fn text(sets: &[Set], limit: f64) -> String {
    let mut text = format!(
        "# What the relaxed force-closure test tells about the exact one\n\nWritten by `cargo run --release --example \
         force_closure_estimate`. Contacts on the unit sphere, inward normals, torques about its centre (where they vanish). \
         μ₀: least friction at which forces balance, in closed form; force closure at μ: they balance at μ and `GGᵀ` ≻ 10⁻⁴ I. \
         The relaxed test is ‖Gc‖ < 0.5; the released code compares the square, that is ‖Gc‖ < 0.707.\n\n\
         ## ‖Gc‖ against μ₀\n\n{} random sets of three. Least squares over the sets with μ₀ up to a limit:\n\n\
         | μ₀ ≤ | sets | a of a μ₀ | a μ₀ + b | Pearson's r |\n|---:|---:|---:|---|---:|\n",
        sets.len()
    );
    let mut limits = LIMITS.to_vec();
    limits.push(limit);
    limits.sort_by(f64::total_cmp);
    for at in limits {
        let fit = Fit::up_to(sets, at);
        let name = match at {
            at if at.is_infinite() => "all".to_owned(),
            at if (at - limit).abs() < 1e-9 => format!("**{at:.4}**"),
            at => format!("{at}"),
        };
        let _ = writeln!(
            text,
            "| {name} | {} | {:.3} | {:.3} μ₀ + {:.3} | {:.3} |",
            fit.sets, fit.through_origin, fit.slope, fit.offset, fit.correlation
        );
    }
    let _ = writeln!(
        text,
        "\nThe paper's slope, {PUBLISHED_SLOPE}, comes out for μ₀ ≤ {limit:.4} and for no other range that begins at zero: the \
         slope through the origin falls all the way, because the sets do not lie on a line through the origin. Three contacts \
         that need no friction at all can still have ‖Gc‖ up to 1 (an antipodal pair and a third contact). A line with an \
         offset hardly depends on the range from μ₀ ≤ 0.2 to μ₀ ≤ 0.6. Beyond μ₀ = {:.4} the published line exceeds 3, the largest ‖Gc‖ \
         there is.\n",
        3.0 / PUBLISHED_SLOPE
    );
    text + &recall(sets)
}

/// What the relaxed test keeps of what the exact one accepts.
fn recall(sets: &[Set]) -> String {
    let mut text = "## Random sets of three\n\nRecall: share of the force-closed sets that pass the relaxed test with ‖Gc‖ below \
         0.5 or 0.707.\n\n\
         | sets | closed at μ = 0.5 | recall, 0.5 | recall, 0.707 | closed at μ = 1 | recall, 0.5 | recall, 0.707 |\n\
         |---|---:|---:|---:|---:|---:|---:|\n"
        .to_owned();
    let passing = |threshold: f64| sets.iter().filter(move |set| set.net_wrench < threshold);
    let _ = write!(text, "| {} |", sets.len());
    for friction in 0..FRICTIONS.len() {
        let closed = sets.iter().filter(|set| set.closed[friction]).count() as f64;
        let _ = write!(text, " {:.1} % |", 100.0 * closed / sets.len() as f64);
        for threshold in THRESHOLDS {
            let both = passing(threshold)
                .filter(|set| set.closed[friction])
                .count();
            let _ = write!(text, " {:.1} % |", 100.0 * both as f64 / closed);
        }
    }
    let precision = THRESHOLDS.map(|threshold| {
        let closed = passing(threshold).filter(|set| set.closed[0]).count();
        100.0 * closed as f64 / passing(threshold).count() as f64
    });
    let most = THRESHOLDS.map(|threshold| {
        let frictions = passing(threshold).map(|set| set.least_friction);
        frictions.fold(0.0, f64::max)
    });
    let bound = THRESHOLDS.map(|threshold| threshold / (9.0 - threshold * threshold).sqrt());
    let _ = writeln!(
        text,
        "\n\nOf the sets that pass, {:.1} and {:.1} % are force-closed at μ = {}. What passes needs little friction: ‖Gc‖ ≥ 3 μ₀/√(1 + μ₀²) for three contacts on the sphere (the \
         equilateral triangle has the least), so ‖Gc‖ < 0.5 means μ₀ < {:.3} (largest found: {:.3}), and ‖Gc‖ < 0.707 means \
         μ₀ < {:.3} ({:.3}). The test asks for balance by equal, nearly frictionless forces, and drops nearly all sets that friction \
         holds.",
        precision[0], precision[1], FRICTIONS[0], bound[0], most[0], bound[1], most[1]
    );
    text
}
