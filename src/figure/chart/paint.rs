//! Draws the series of a panel.

use super::super::canvas::Canvas;
use super::super::style::{Anchor, Colour, Stroke, TextFace, text_width};
use super::super::theme::{LINE, TEXT, WHITE};
use super::clip::Frame;
use super::scale::Span;
use super::{BandPoint, Mark, Scale, Series, Violin};

/// Size of texts beside points.
const NOTE: f64 = 0.82 * TEXT;
/// Lengths of dash and gap of dashed lines, in line widths. `LEAST_DASH` are the least lengths in canvas units.
const DASH: [f64; 2] = [4.0, 2.6];
const LEAST_DASH: [f64; 2] = [11.0, 7.0];
/// The corner of a thick line is filled if the cosine of its turn is below this.
const SHARP: f64 = 0.95;

/// Stroke of the lines of a series.
pub(super) fn stroke(series: &Series, colour: Colour) -> Stroke {
    let dash = [0, 1].map(|k| (DASH[k] * series.width).max(LEAST_DASH[k]));
    Stroke {
        colour,
        width: series.width,
        dash: series.dashed.then_some(dash),
    }
}

impl Mark {
    /// Points that must lie within the axes. A coordinate that does not matter is NaN.
    pub(super) fn extent(&self, x_scale: Scale) -> Vec<[f64; 2]> {
        let sides = |at: f64, half_width: f64| {
            [-1.0, 1.0].map(|side| x_scale.invert(x_scale.transform(at) + side * half_width))
        };
        match self {
            Self::Line(points) | Self::Steps(points) | Self::Points { points, .. } => {
                points.clone()
            }
            Self::Band(points) => points
                .iter()
                .flat_map(|point| [[point.x, point.lower], [point.x, point.upper]])
                .collect(),
            Self::Violins(violins) => violins
                .iter()
                .flat_map(|violin| {
                    let sides = sides(violin.at, violin.half_width).map(|x| [x, f64::NAN]);
                    let ends = [violin.density.first(), violin.density.last()];
                    let ends = ends.into_iter().flatten().map(|end| [f64::NAN, end[0]]);
                    ends.chain(sides).collect::<Vec<_>>()
                })
                .collect(),
            Self::Text { at, .. } => vec![*at],
            Self::Horizontal(y) => vec![[f64::NAN, *y]],
            Self::Vertical(x) => vec![[*x, f64::NAN]],
        }
    }
}

/// Draws series on a canvas, inside a frame.
pub(super) struct Painter<'a> {
    pub(super) canvas: &'a mut Canvas,
    pub(super) frame: Frame,
    pub(super) x: Span,
    pub(super) y: Span,
}

impl Painter<'_> {
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Frame {
            left,
            top,
            right,
            bottom,
        } = self.frame;
        [
            left + self.x.part(x) * (right - left),
            bottom - self.y.part(y) * (bottom - top),
        ]
    }

    /// Canvas x of the point at distance `shift` (in transformed units) from `x`.
    fn beside(&self, x: f64, shift: f64) -> f64 {
        let place = self.x.scale.transform(x) + shift;
        self.frame.left + self.x.part_of_place(place) * (self.frame.right - self.frame.left)
    }

    pub(super) fn draw(&mut self, series: &Series, colour: Colour) {
        let stroke = stroke(series, colour);
        match &series.mark {
            Mark::Line(points) => self.line(points, stroke),
            Mark::Steps(points) => self.line(&corners(points), stroke),
            Mark::Points { points, radius } => {
                for point in points {
                    let centre = self.at(*point);
                    if self.frame.contains(centre) {
                        self.canvas.circle(centre, *radius, colour);
                    }
                }
            }
            Mark::Band(points) => self.band(points, colour),
            Mark::Violins(violins) => {
                for violin in violins {
                    self.violin(violin, colour, series.width);
                }
            }
            Mark::Text { at, text, anchor } => self.note(*at, text, *anchor, colour),
            Mark::Horizontal(y) => {
                let [_, y] = self.at([f64::NAN, *y]);
                self.lines(&[[self.frame.left, y], [self.frame.right, y]], stroke);
            }
            Mark::Vertical(x) => {
                let [x, _] = self.at([*x, f64::NAN]);
                self.lines(&[[x, self.frame.bottom], [x, self.frame.top]], stroke);
            }
        }
    }

    fn line(&mut self, points: &[[f64; 2]], stroke: Stroke) {
        let points: Vec<[f64; 2]> = points.iter().map(|&point| self.at(point)).collect();
        self.lines(&points, stroke);
    }

    /// Draws a polyline given in canvas units.
    fn lines(&mut self, points: &[[f64; 2]], stroke: Stroke) {
        for piece in self.frame.polyline(points) {
            self.canvas.polyline(&piece, stroke);
            if stroke.dash.is_some() || stroke.colour.opacity < 1.0 {
                continue;
            }
            for corner in piece.windows(3) {
                let [from, to] = [[0, 1], [1, 2]].map(|[a, b]| {
                    let [dx, dy] = [0, 1].map(|k| corner[b][k] - corner[a][k]);
                    let length = libm::hypot(dx, dy);
                    [dx / length, dy / length]
                });
                if from[0] * to[0] + from[1] * to[1] < SHARP {
                    self.canvas
                        .circle(corner[1], 0.5 * stroke.width, stroke.colour);
                }
            }
        }
    }

    fn fill(&mut self, outline: &[[f64; 2]], colour: Colour) {
        let inside = self.frame.polygon(outline);
        if inside.len() > 2 {
            self.canvas.polygon(inside, colour);
        }
    }

    fn band(&mut self, points: &[BandPoint], colour: Colour) {
        let missing = |point: &BandPoint| (point.x + point.lower + point.upper).is_nan();
        for piece in points.split(missing) {
            let upper = piece.iter().map(|point| [point.x, point.upper]);
            let lower = piece.iter().rev().map(|point| [point.x, point.lower]);
            let outline: Vec<[f64; 2]> = upper.chain(lower).map(|point| self.at(point)).collect();
            self.fill(&outline, colour);
        }
    }

    fn violin(&mut self, violin: &Violin, colour: Colour, width: f64) {
        let largest = violin
            .density
            .iter()
            .map(|[_, density]| *density)
            .fold(0.0, f64::max);
        let side = |[y, density]: [f64; 2], sign: f64| {
            let shift = sign * violin.half_width * density / largest;
            [self.beside(violin.at, shift), self.at([f64::NAN, y])[1]]
        };
        match violin.density[..] {
            [] => return,
            [only] => {
                let ends = [side(only, -1.0), side(only, 1.0)];
                self.lines(&ends, Stroke::solid(colour, width));
            }
            _ => {
                let right = violin.density.iter().map(|&place| side(place, 1.0));
                let left = violin.density.iter().rev().map(|&place| side(place, -1.0));
                let outline: Vec<[f64; 2]> = right.chain(left).collect();
                self.fill(&outline, colour);
            }
        }
        if let Some([lower, median, upper]) = violin.quartiles {
            self.line(
                &[[violin.at, lower], [violin.at, upper]],
                Stroke::solid(LINE, 1.6 * width),
            );
            let centre = self.at([violin.at, median]);
            if self.frame.contains(centre) {
                self.canvas
                    .rimmed_circle(centre, 1.2 * width, WHITE, LINE, 1.5);
            }
        }
    }

    /// Draws a text, shifted so that it stays in the panel.
    fn note(&mut self, at: [f64; 2], text: &str, anchor: Anchor, colour: Colour) {
        let [x, y] = self.at(at);
        let room = self.frame.right - self.frame.left;
        let face = TextFace::new(NOTE, colour).fitted(text, room);
        let length = text_width(text, face.size, false);
        let start = x + face.anchored(anchor).start(text);
        let start = start.min(self.frame.right - length).max(self.frame.left);
        let half = 0.5 * face.size;
        let y = y.min(self.frame.bottom - half).max(self.frame.top + half);
        self.canvas.text([start, y], text, face);
    }
}

/// The corners of a step line.
fn corners(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut corners: Vec<[f64; 2]> = points
        .windows(2)
        .flat_map(|pair| [pair[0], [pair[1][0], pair[0][1]]])
        .collect();
    corners.extend(points.last());
    corners
}
