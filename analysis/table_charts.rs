//! Charts of tables that other programs wrote → `figures/completeness.png` and eight more
//!
//! `cargo run --release --example table_charts` reads tables of `figures/*.md` and draws each as dots, one row for each row
//! of the table. Intervals are drawn as lines. It measures nothing itself.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::Path;

use landscape::figure::chart::{Axis, Chart, Mark, Panel, Series};

/// What to draw of a table.
struct Drawing {
    /// Name of the file in `figures`, without its ending; also of the picture.
    name: &'static str,
    /// Beginning of the heading above the table.
    under: &'static str,
    /// Columns whose texts name a row.
    labels: &'static [&'static str],
    /// Text that the name of a row must contain.
    rows: &'static str,
    /// The series.
    dots: Dots,
    /// The axis of the values.
    axis: fn() -> Axis,
}

enum Dots {
    /// Each entry is a series: its name in the legend, its columns, of which the greatest number counts, and the column that
    /// is 100 %, if there is one.
    Columns(&'static [(&'static str, &'static [&'static str], Option<&'static str>)]),
    /// The texts of the first column name the series, and the second column has the shares.
    By(&'static str, &'static str),
}

const DRAWINGS: [Drawing; 9] = [
    Drawing {
        name: "completeness",
        under: "# How often",
        labels: &["surface"],
        rows: "",
        dots: Dots::Columns(&[
            ("say that they are 95 % sure", &["say 95 %"], Some("runs")),
            (
                "say so and are complete",
                &["of these complete"],
                Some("runs"),
            ),
        ]),
        axis: || Axis::linear("share of the runs (%)").with_range(-2.0, 102.0),
    },
    Drawing {
        name: "coverage",
        under: "# Coverage",
        labels: &["object"],
        rows: "",
        dots: Dots::Columns(&[("", &["coverage"], None)]),
        axis: || {
            Axis::linear("chance that one more grasp falls into a known minimum (%)")
                .with_range(-2.0, 102.0)
        },
    },
    Drawing {
        name: "sensitivity",
        under: "# What the map",
        labels: &["change"],
        rows: "",
        dots: Dots::Columns(&[("groups", &["groups"], None), ("minima", &["minima"], None)]),
        axis: || Axis::linear("number").with_range(0.0, 30.0),
    },
    Drawing {
        name: "ablation",
        under: "",
        labels: &[""],
        rows: "",
        dots: Dots::Columns(&[("", &["fresh: strict"], None)]),
        axis: || Axis::linear("chains that pass the strict filter (%)").with_range(-2.0, 102.0),
    },
    Drawing {
        name: "human_likeness",
        under: "## closed hands",
        labels: &[""],
        rows: "% of contact",
        dots: Dots::Columns(&[
            ("people", &["people"], None),
            ("closed hands", &["population"], None),
        ]),
        axis: || Axis::linear("share of the contact (%)"),
    },
    Drawing {
        name: "peers",
        under: "# Beside",
        labels: &["surface"],
        rows: "atoms",
        dots: Dots::By("program", "saddles"),
        axis: || Axis::linear("share of the published saddles (%)").with_range(-2.0, 102.0),
    },
    Drawing {
        name: "lennard_jones",
        under: "# Lennard-Jones",
        labels: &["atoms", "run"],
        rows: "",
        dots: Dots::Columns(&[
            ("minima", &["minima"], Some("published minima")),
            ("saddles", &["saddles"], Some("published saddles")),
        ]),
        axis: || Axis::linear("found, in percent of the published number").with_range(-2.0, 105.0),
    },
    Drawing {
        name: "kinetics",
        under: "# Rates",
        labels: &["network", "kT"],
        rows: "",
        dots: Dots::Columns(&[
            (
                "landscape",
                &[
                    "difference of the rate",
                    "of the mean time",
                    "of the steady-state rate",
                    "of the committors",
                ],
                None,
            ),
            (
                "numpy, where it does not fail",
                &["numpy, greatest difference"],
                None,
            ),
        ]),
        axis: || Axis::logarithmic("greatest relative difference to exact values"),
    },
    Drawing {
        name: "external_calls",
        under: "# What a question",
        labels: &["protocol", "runs on"],
        rows: "",
        dots: Dots::Columns(&[("", &["overhead"], None)]),
        axis: || Axis::linear("overhead for each point (µs)").with_range(0.0, 80.0),
    },
];

/// The rows of a table, each with its cells by the names of their columns; of two columns of one name the last counts.
type Table = Vec<BTreeMap<String, String>>;

/// The first table below a heading that begins with `under`.
fn table(text: &str, under: &str) -> Option<Table> {
    let cells = |line: &str| -> Vec<String> {
        let inner = line.trim().trim_matches('|');
        inner
            .split('|')
            .map(|cell| cell.trim().to_owned())
            .collect()
    };
    let mut lines = text
        .lines()
        .skip_while(|line| !line.starts_with(under))
        .skip_while(|line| !line.starts_with('|'))
        .take_while(|line| line.starts_with('|'));
    let columns = cells(lines.next()?);
    let rows = lines.skip(1);
    Some(
        rows.map(|row| columns.iter().cloned().zip(cells(row)).collect())
            .collect(),
    )
}

/// The numbers in a cell; `12 of 48` counts as 25, in percent.
fn numbers(cell: &str) -> Vec<f64> {
    let split = |c: char| !(c.is_ascii_digit() || matches!(c, '.' | 'e' | '-'));
    let found: Vec<f64> = cell
        .split(split)
        .filter_map(|word| word.parse().ok())
        .collect();
    match found.as_slice() {
        [part, whole] if cell.contains(" of ") => vec![100.0 * part / whole],
        _ => found,
    }
}

/// Name, place, and lower and upper end where they are known.
type Dot = (String, f64, Option<[f64; 2]>);

fn dots(row: &BTreeMap<String, String>, drawing: &Drawing) -> Result<Vec<Dot>, String> {
    let cell = |column: &str| {
        let cell = row.get(column);
        cell.ok_or_else(|| format!("{}.md has no column {column}", drawing.name))
    };
    let mut found = Vec::new();
    match drawing.dots {
        Dots::Columns(series) => {
            for &(name, columns, whole) in series {
                let percent = match whole {
                    None => Some(1.0),
                    Some(whole) => numbers(cell(whole)?).first().map(|whole| 100.0 / whole),
                };
                let mut greatest: Option<(f64, Option<[f64; 2]>)> = None;
                for column in columns {
                    let numbers = numbers(cell(column)?);
                    if let [value, ends @ ..] = numbers.as_slice()
                        && greatest.is_none_or(|(known, _)| known < *value)
                    {
                        greatest = Some((*value, <[f64; 2]>::try_from(ends).ok()));
                    }
                }
                if let (Some((value, ends)), Some(percent)) = (greatest, percent) {
                    found.push((name.to_owned(), value * percent, ends));
                }
            }
        }
        Dots::By(series, column) => {
            let value = cell(column)?;
            // Rows of published numbers have nothing to be compared with.
            if value.contains(" of ") {
                let value = numbers(value).first().copied().unwrap_or(f64::NAN);
                found.push((cell(series)?.clone(), value, None));
            }
        }
    }
    Ok(found)
}

/// The name of a row.
fn label(row: &BTreeMap<String, String>, drawing: &Drawing) -> Result<String, String> {
    let words = drawing.labels.iter().map(|column| {
        let word = row.get(*column).map(|word| word.replace('`', ""));
        word.ok_or_else(|| format!("{}.md has no column {column}", drawing.name))
    });
    Ok(words.collect::<Result<Vec<_>, _>>()?.join(", "))
}

fn draw(drawing: &Drawing) -> Result<(), Box<dyn Error>> {
    let path = Path::new("figures").join(drawing.name);
    let text = fs::read_to_string(path.with_extension("md"))?;
    let rows = table(&text, drawing.under).ok_or("there is no table")?;
    let mut labels: Vec<String> = Vec::new();
    let mut series: Vec<(String, Vec<[f64; 2]>)> = Vec::new();
    let mut lines = Vec::new();
    for row in &rows {
        let label = label(row, drawing)?;
        let dots = dots(row, drawing)?;
        if !label.contains(drawing.rows) || dots.is_empty() {
            continue;
        }
        // The first row is drawn at the top. Rows of one name lie on one line.
        if !labels.contains(&label) {
            labels.push(label.clone());
        }
        let place = labels.iter().position(|known| *known == label);
        let y = -(place.unwrap_or_default() as f64);
        for (name, x, ends) in dots {
            if let Some([low, high]) = ends {
                lines.push(Series {
                    opacity: 0.5,
                    ..Series::line(vec![[low, y], [high, y]]).named(&name)
                });
            }
            match series.iter_mut().find(|(known, _)| *known == name) {
                Some((_, points)) => points.push([x, y]),
                None => series.push((name, vec![[x, y]])),
            }
        }
    }
    if labels.is_empty() {
        return Err("no row of the table fits".into());
    }
    let named = series.iter().any(|(name, _)| !name.is_empty());
    // Dots of later series are smaller, so that those below them are seen.
    let radii = (0..).map(|place| 11.0 - 3.0 * f64::from(place));
    lines.extend(
        series
            .into_iter()
            .zip(radii)
            .map(|((name, points), radius)| {
                Series::new(Mark::Points { points, radius }).named(&name)
            }),
    );
    let ticks = labels.iter().enumerate();
    let rows = Axis::linear("")
        .with_range(0.6 - labels.len() as f64, 0.6)
        .with_ticks(ticks.map(|(place, label)| (-(place as f64), label.clone())));
    let height = 150 + 42 * u32::try_from(labels.len())?;
    let chart = Chart {
        panel_size: [1100, height],
        legend_below: named,
        ..Chart::new("", vec![Panel::new("", (drawing.axis)(), rows, lines)])
    };
    chart.draw()?.save(&path.with_extension("png"))?;
    println!("{}", path.with_extension("png").display());
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    for drawing in &DRAWINGS {
        draw(drawing).map_err(|error| format!("{}: {error}", drawing.name))?;
    }
    Ok(())
}
