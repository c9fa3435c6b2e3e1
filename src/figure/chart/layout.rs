//! Layout of the panels, axes, titles and legends of a chart.

use super::super::FigureError;
use super::super::canvas::Canvas;
use super::super::legend::Legend;
use super::super::style::{Anchor, Colour, Stroke, TextFace, text_width};
use super::super::theme::{self, FAINT, INK, MARGIN, TEXT, TITLE, UNLABELLED, WHITE};
use super::clip::Frame;
use super::paint::{Painter, stroke};
use super::scale::{Axis, Span};
use super::{Chart, Corner, Mark, Panel, Series};

/// Size of the texts at ticks.
const TICK_TEXT: f64 = 0.82 * TEXT;
/// Size of the labels of axes.
const LABEL: f64 = 0.92 * TEXT;
/// Length of a tick. `BESIDE` is the distance from its end to its text.
const TICK: f64 = 7.0;
const BESIDE: f64 = 6.0;
/// Distance between panels.
const APART: f64 = 26.0;
/// Distance from the corner of a panel to the legend inside it.
const INSET: f64 = 16.0;

/// Ticks of an axis: values and texts.
type Ticks = Vec<(f64, String)>;

/// A panel with the ranges of its axes and its ticks on y.
struct Settled<'a> {
    panel: &'a Panel,
    x: Span,
    y: Span,
    y_ticks: Ticks,
    /// Whether the given texts of the x axis are too long to stand side by side, so that they run upward.
    upward: bool,
}

impl Chart {
    /// Draws the chart. The sheet is as large as its panels, titles and legends need.
    ///
    /// # Errors
    /// [`FigureError::OffAxis`] for an infinite value, or for a value that is not positive on a logarithmic axis;
    /// [`FigureError::Range`] for an axis whose ends do not ascend.
    pub fn draw(&self) -> Result<Canvas, FigureError> {
        let settled = self
            .panels
            .iter()
            .map(|panel| self.settle(panel))
            .collect::<Result<Vec<_>, _>>()?;
        let columns = self.columns.clamp(1, settled.len().max(1));
        let rows = settled.len().div_ceil(columns);
        let cell = self.panel_size.map(f64::from);
        let across = |count: usize, size: f64| count as f64 * (size + APART) - APART;
        let width = across(columns, cell[0]) + 2.0 * MARGIN;
        let colours = Colours::of(self);
        let below = if self.legend_below {
            colours.legend(self.panels.iter().flat_map(|panel| &panel.series))
        } else {
            Legend::default()
        };
        let top = if self.title.is_empty() {
            MARGIN
        } else {
            MARGIN + 1.6 * TITLE
        };
        let bottom = top + across(rows.max(1), cell[1]);
        let legend_top = bottom + if below.is_empty() { 0.0 } else { 0.5 * MARGIN };
        let height = legend_top + below.height_in_rows(width - 2.0 * MARGIN) + MARGIN;
        let mut canvas = Canvas::new(whole(width), whole(height));
        let face = TextFace::new(TITLE, INK).bold().anchored(Anchor::Middle);
        canvas.text(
            [0.5 * width, MARGIN + 0.5 * TITLE],
            &self.title,
            face.fitted(&self.title, width - 2.0 * MARGIN),
        );
        for (index, one) in settled.iter().enumerate() {
            // Panels in a column share their left margin; panels in a row share their upper and lower margins.
            let (row, column) = (index / columns, index % columns);
            let in_column = settled.iter().skip(column).step_by(columns);
            let left_margin = in_column.map(Settled::left_margin).fold(0.0, f64::max);
            let in_row = || settled.iter().skip(row * columns).take(columns);
            let titled = in_row().any(|one| !one.panel.title.is_empty());
            let labelled = in_row().any(|one| !one.panel.x.label.is_empty());
            let corner = [
                MARGIN + column as f64 * (cell[0] + APART),
                top + row as f64 * (cell[1] + APART),
            ];
            let frame = Frame {
                left: corner[0] + left_margin,
                top: corner[1] + if titled { 1.55 * TEXT } else { 0.6 * TICK_TEXT },
                right: corner[0] + cell[0] - one.right_margin(),
                bottom: corner[1] + cell[1]
                    - (TICK + BESIDE + in_row().map(Settled::x_texts).fold(0.0, f64::max))
                    - if labelled { 1.3 * LABEL } else { 0.0 },
            };
            one.draw(&mut canvas, frame, corner, &colours);
        }
        below.draw_in_rows(&mut canvas, [MARGIN, legend_top], width - 2.0 * MARGIN);
        Ok(canvas)
    }

    fn settle<'a>(&self, panel: &'a Panel) -> Result<Settled<'a>, FigureError> {
        let points = || {
            panel
                .series
                .iter()
                .flat_map(|series| series.mark.extent(panel.x.scale))
        };
        let [x, y] = [
            panel.x.span(points().map(|point| point[0]))?,
            panel.y.span(points().map(|point| point[1]))?,
        ];
        let room = f64::from(self.panel_size[1]) - 4.0 * TEXT;
        let y_ticks = fitting(&panel.y, &y, room, |_| 1.6 * TICK_TEXT);
        let mut settled = Settled {
            panel,
            x,
            y,
            y_ticks,
            upward: false,
        };
        let width = f64::from(self.panel_size[0]) - settled.left_margin();
        settled.upward = !fit(&panel.x.ticks, &x, width, beside);
        Ok(settled)
    }
}

/// The given ticks of an axis, or as many round ones as fit on its length `room`. Texts must not overlap; `length` is the
/// length that a text needs.
fn fitting(axis: &Axis, span: &Span, room: f64, length: impl Fn(&str) -> f64) -> Ticks {
    if !axis.ticks.is_empty() {
        return axis.ticks.clone();
    }
    let mut wanted = 7;
    loop {
        let ticks = span.ticks(wanted);
        if fit(&ticks, span, room, &length) || wanted == 1 {
            return ticks;
        }
        wanted -= 1;
    }
}

/// Whether the texts of neighbouring ticks do not overlap on an axis of length `room`.
fn fit(ticks: &[(f64, String)], span: &Span, room: f64, length: impl Fn(&str) -> f64) -> bool {
    ticks.windows(2).all(|pair| {
        let apart = (span.part(pair[1].0) - span.part(pair[0].0)).abs() * room;
        apart >= 0.5 * (length(&pair[0].1) + length(&pair[1].1))
    })
}

/// Length that a tick's text needs beside others.
fn beside(text: &str) -> f64 {
    text_width(text, TICK_TEXT, false) + 0.8 * TICK_TEXT
}

impl Settled<'_> {
    fn left_margin(&self) -> f64 {
        let longest = self
            .y_ticks
            .iter()
            .map(|(_, text)| text_width(text, TICK_TEXT, false))
            .fold(0.0, f64::max);
        let label = if self.panel.y.label.is_empty() {
            0.0
        } else {
            1.45 * LABEL
        };
        label + longest + TICK + BESIDE
    }

    /// Height of the texts at the ticks of the x axis.
    fn x_texts(&self) -> f64 {
        let ticks = self.panel.x.ticks.iter().filter(|_| self.upward);
        ticks
            .map(|(_, text)| text_width(text, TICK_TEXT, false))
            .fold(1.1 * TICK_TEXT, f64::max)
    }

    /// The longest overhang of a tick's text beyond the right end of the x axis.
    fn right_margin(&self) -> f64 {
        if self.upward {
            return 4.0;
        }
        let given = &self.panel.x.ticks;
        let ticks = if given.is_empty() {
            self.x.ticks(5)
        } else {
            given.clone()
        };
        let overhang = |(value, text): &(f64, String)| {
            let room = (1.0 - self.x.part(*value)) * 0.7 * MARGIN;
            0.5 * text_width(text, TICK_TEXT, false) - room
        };
        ticks.iter().map(overhang).fold(0.0, f64::max) + 4.0
    }

    fn draw(&self, canvas: &mut Canvas, frame: Frame, corner: [f64; 2], colours: &Colours<'_>) {
        self.draw_axes(canvas, frame, corner[0]);
        let mut painter = Painter {
            canvas,
            frame,
            x: self.x,
            y: self.y,
        };
        for series in &self.panel.series {
            painter.draw(series, colours.of_series(series));
        }
        let axis = Stroke::solid(INK, 2.0);
        canvas.line([frame.left, frame.top], [frame.left, frame.bottom], axis);
        canvas.line(
            [frame.left - 1.0, frame.bottom],
            [frame.right, frame.bottom],
            axis,
        );
        let title = &self.panel.title;
        let face = TextFace::new(TEXT, INK).bold().anchored(Anchor::Middle);
        canvas.text(
            [0.5 * (frame.left + frame.right), corner[1] + 0.55 * TEXT],
            title,
            face.fitted(title, 2.0 * (0.5 * (frame.right - frame.left)).max(1.0)),
        );
        if let Some(place) = self.panel.legend {
            draw_inside(canvas, frame, place, &colours.legend(&self.panel.series));
        }
    }

    /// Draws the grid, the ticks and the labels. `left` is the left edge of the panel's cell.
    fn draw_axes(&self, canvas: &mut Canvas, frame: Frame, left: f64) {
        let Frame {
            right, top, bottom, ..
        } = frame;
        let [width, height] = [right - frame.left, bottom - top];
        let at_x = |value: f64| frame.left + self.x.part(value) * width;
        let at_y = |value: f64| bottom - self.y.part(value) * height;
        let [grid, tick] = [Stroke::solid(FAINT, 1.5), Stroke::solid(INK, 2.0)];
        let face = TextFace::new(TICK_TEXT, INK);
        let x_ticks = fitting(&self.panel.x, &self.x, width, beside);
        for (value, text) in &x_ticks {
            let x = at_x(*value);
            canvas.line([x, bottom], [x, top], grid);
            canvas.line([x, bottom], [x, bottom + TICK], tick);
            let y = bottom + TICK + BESIDE;
            if self.upward {
                canvas.text([x, y], text, face.anchored(Anchor::End).upward());
            } else {
                let middle = [x, y + 0.5 * TICK_TEXT];
                canvas.text(middle, text, face.anchored(Anchor::Middle));
            }
        }
        for (value, text) in &self.y_ticks {
            let y = at_y(*value);
            canvas.line([frame.left, y], [right, y], grid);
            canvas.line([frame.left - TICK, y], [frame.left, y], tick);
            let face = face.anchored(Anchor::End);
            canvas.text([frame.left - TICK - BESIDE, y], text, face);
        }
        let small = Stroke::solid(INK, 1.2);
        for x in self.x.small_ticks().into_iter().map(at_x) {
            canvas.line([x, bottom], [x, bottom + 0.6 * TICK], small);
        }
        for y in self.y.small_ticks().into_iter().map(at_y) {
            canvas.line([frame.left - 0.6 * TICK, y], [frame.left, y], small);
        }
        let face = TextFace::new(LABEL, INK).anchored(Anchor::Middle);
        let label = &self.panel.x.label;
        canvas.text(
            [
                0.5 * (frame.left + right),
                bottom + TICK + BESIDE + self.x_texts() + 0.15 * TICK_TEXT + 0.55 * LABEL,
            ],
            label,
            face.fitted(label, width),
        );
        let label = &self.panel.y.label;
        canvas.text(
            [left + 0.5 * LABEL, 0.5 * (top + bottom)],
            label,
            face.upward().fitted(label, height),
        );
    }
}

fn draw_inside(canvas: &mut Canvas, frame: Frame, corner: Corner, legend: &Legend) {
    if legend.is_empty() {
        return;
    }
    let [width, height] = [legend.width(), legend.height()];
    let left = match corner {
        Corner::UpperLeft => frame.left + INSET,
        Corner::UpperRight | Corner::LowerRight => frame.right - INSET - width,
    };
    let top = match corner {
        Corner::UpperLeft | Corner::UpperRight => frame.top + 0.6 * INSET,
        Corner::LowerRight => frame.bottom - 0.8 * INSET - height,
    };
    let pad = 0.5 * INSET;
    canvas.rectangle(
        [left - pad, top],
        [left + width + pad, top + height],
        WHITE.with_opacity(0.85),
    );
    legend.draw(canvas, [left, top], frame.bottom);
}

/// The colour of each name.
struct Colours<'a> {
    named: Vec<(&'a str, Colour)>,
}

impl<'a> Colours<'a> {
    fn of(chart: &'a Chart) -> Self {
        let all = || chart.panels.iter().flat_map(|panel| &panel.series);
        let mut named: Vec<(&str, Colour)> = Vec::new();
        let mut taken = 0;
        for series in all().filter(|series| !series.name.is_empty()) {
            if named.iter().any(|(name, _)| *name == series.name) {
                continue;
            }
            let given = all()
                .filter(|other| other.name == series.name)
                .find_map(|other| other.colour);
            let colour = given.unwrap_or_else(|| {
                taken += 1;
                theme::series(taken - 1)
            });
            named.push((&series.name, colour));
        }
        Self { named }
    }

    fn of_series(&self, series: &Series) -> Colour {
        let named = || self.named.iter().find(|(name, _)| *name == series.name);
        let colour = series
            .colour
            .or_else(|| named().map(|(_, colour)| *colour))
            .unwrap_or(match series.mark {
                Mark::Band(_) | Mark::Violins(_) => UNLABELLED,
                _ => INK,
            });
        colour.with_opacity(colour.opacity * series.opacity)
    }

    /// The legend of the named series among `all`. Each name occurs once, with the look of its first series.
    fn legend<'b>(&self, all: impl IntoIterator<Item = &'b Series>) -> Legend {
        let mut legend = Legend::default();
        let mut seen: Vec<&str> = Vec::new();
        for series in all {
            if series.name.is_empty() || seen.contains(&series.name.as_str()) {
                continue;
            }
            seen.push(&series.name);
            let colour = self.of_series(series);
            match &series.mark {
                Mark::Line(_) | Mark::Steps(_) | Mark::Horizontal(_) | Mark::Vertical(_) => {
                    legend.line(stroke(series, colour), &series.name);
                }
                // A single faint dot would be invisible in the legend.
                Mark::Points { radius, .. } => legend.disc(
                    radius.clamp(6.0, 10.0),
                    colour.with_opacity(colour.opacity.max(0.7)),
                    &series.name,
                ),
                Mark::Band(_) | Mark::Violins(_) => {
                    legend.patch(colour, &series.name);
                }
                Mark::Text { .. } => {}
            }
        }
        legend
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a sheet of u32 panels"
)]
fn whole(length: f64) -> u32 {
    length.ceil() as u32
}
