//! Charts: one or several panels of lines, points, bands and violins over linear or logarithmic axes.
//!
//! A [`Chart`] is plain data. [`Chart::draw`] lays it out and puts it on a [`Canvas`](super::Canvas).
//!
//! ```
//! use landscape::figure::chart::{Axis, Chart, Corner, Mark, Panel, Series};
//!
//! let cost = [[3.0, 1.2], [10.0, 3.9], [100.0, 41.0], [1000.0, 402.0]];
//! let panel = Panel {
//!     legend: Some(Corner::UpperLeft),
//!     ..Panel::new(
//!         "cost of a test",
//!         Axis::logarithmic("contacts"),
//!         Axis::logarithmic("time (µs)"),
//!         vec![
//!             Series::line(cost.to_vec()).named("measured"),
//!             Series::points(cost.to_vec()).named("measured"),
//!             Series::new(Mark::Horizontal(1500.0)).named("published").dashed(),
//!         ],
//!     )
//! };
//! let canvas = Chart::new("", vec![panel]).draw()?;
//! assert!(canvas.texts().iter().any(|(text, _)| *text == "published"));
//! # Ok::<(), landscape::figure::FigureError>(())
//! ```

mod clip;
mod layout;
mod paint;
mod scale;

use super::style::{Anchor, Colour};

pub use scale::{Axis, Scale};

/// Panels on a sheet, in row-major order.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Title above all panels; empty for none.
    pub title: String,
    /// The panels.
    pub panels: Vec<Panel>,
    /// Number of panels in a row.
    pub columns: usize,
    /// Width and height of a panel with its axes and title, canvas units. The text size [`theme::TEXT`](super::theme::TEXT)
    /// suits widths of 600 or more.
    pub panel_size: [u32; 2],
    /// Whether one legend of all named series stands below the panels.
    pub legend_below: bool,
}

/// A pair of axes and the series between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Title; empty for none.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The series in the order of drawing: later ones cover earlier ones.
    pub series: Vec<Series>,
    /// Corner for a legend of this panel's named series; `None` for no legend inside.
    pub legend: Option<Corner>,
}

/// A corner of a panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Corner {
    UpperLeft,
    UpperRight,
    LowerRight,
}

/// Something drawn in a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in legends; empty for none. Series of the same name share a colour in all panels and one line of the legend.
    pub name: String,
    /// Colour. With `None`, a named series takes the next colour of the palette and a nameless one takes ink or grey.
    pub colour: Option<Colour>,
    /// Opacity from 0 (invisible) to 1 (opaque), multiplied by that of the colour.
    pub opacity: f64,
    /// Width of lines, canvas units.
    pub width: f64,
    /// Whether lines are dashed.
    pub dashed: bool,
    /// Shape and data.
    pub mark: Mark,
}

/// Shape and data of a series. Coordinates are [x, y]. NaN leaves a gap. Parts outside the range of the axes are not drawn.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Mark {
    /// Straight lines from point to point.
    Line(Vec<[f64; 2]>),
    /// Each y holds from its x to the x of the next point.
    Steps(Vec<[f64; 2]>),
    /// Circles.
    Points {
        /// Their centres.
        points: Vec<[f64; 2]>,
        /// Their radius, canvas units.
        radius: f64,
    },
    /// The area between two lines.
    Band(Vec<BandPoint>),
    /// Densities, mirrored.
    Violins(Vec<Violin>),
    /// A text beside a point.
    Text {
        /// The point.
        at: [f64; 2],
        /// The text.
        text: String,
        /// Which end of the text is at the point. The text is shifted if it would leave the panel.
        anchor: Anchor,
    },
    /// A horizontal line across the panel at this y.
    Horizontal(f64),
    /// A vertical line across the panel at this x.
    Vertical(f64),
}

/// A point of a band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandPoint {
    /// Its place on the x axis.
    pub x: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

/// A density drawn on both sides of a vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Violin {
    /// Its place on the x axis.
    pub at: f64,
    /// Half of its width at the largest density, in units of the x axis (decades on a logarithmic axis).
    pub half_width: f64,
    /// Pairs of y and density, in ascending order of y. Only ratios of densities matter.
    pub density: Vec<[f64; 2]>,
    /// Lower quartile, median and upper quartile, drawn inside if given.
    pub quartiles: Option<[f64; 3]>,
}

impl Chart {
    /// A chart with at most three panels in a row and no common legend.
    pub fn new(title: &str, panels: Vec<Panel>) -> Self {
        Self {
            title: title.to_owned(),
            columns: panels.len().clamp(1, 3),
            panel_size: if panels.len() > 1 {
                [720, 600]
            } else {
                [1100, 760]
            },
            panels,
            legend_below: false,
        }
    }
}

impl Panel {
    /// A panel without a legend.
    pub fn new(title: &str, x: Axis, y: Axis, series: Vec<Series>) -> Self {
        Self {
            title: title.to_owned(),
            x,
            y,
            series,
            legend: None,
        }
    }
}

impl Series {
    /// A nameless, opaque, solid series. Bands are translucent.
    pub fn new(mark: Mark) -> Self {
        let (opacity, width) = match mark {
            Mark::Band(_) => (0.25, 3.5),
            Mark::Horizontal(_) | Mark::Vertical(_) => (1.0, 2.0),
            _ => (1.0, 3.5),
        };
        Self {
            name: String::new(),
            colour: None,
            opacity,
            width,
            dashed: false,
            mark,
        }
    }

    /// A line.
    pub fn line(points: Vec<[f64; 2]>) -> Self {
        Self::new(Mark::Line(points))
    }

    /// A step line.
    pub fn steps(points: Vec<[f64; 2]>) -> Self {
        Self::new(Mark::Steps(points))
    }

    /// Circles of the usual size.
    pub fn points(points: Vec<[f64; 2]>) -> Self {
        Self::new(Mark::Points {
            points,
            radius: 7.0,
        })
    }

    /// A band.
    pub fn band(points: Vec<BandPoint>) -> Self {
        Self::new(Mark::Band(points))
    }

    /// A text that begins at a point.
    pub fn text(at: [f64; 2], text: &str) -> Self {
        Self::new(Mark::Text {
            at,
            text: text.to_owned(),
            anchor: Anchor::Start,
        })
    }

    /// Sets the name for the legend.
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..self
        }
    }

    /// Sets the colour.
    #[must_use]
    pub fn coloured(self, colour: Colour) -> Self {
        Self {
            colour: Some(colour),
            ..self
        }
    }

    /// Makes the lines dashed.
    #[must_use]
    pub fn dashed(self) -> Self {
        Self {
            dashed: true,
            ..self
        }
    }
}

#[cfg(test)]
mod tests;
