//! Pictures of landscapes, charts and grasps. Layout is pure geometry; plotters paints.
//!
//! A picture ([`DisconnectivityPicture`], [`BarrierPicture`], a [`Chart`](chart::Chart) or, with feature `grasp`, a
//! rendered [`Scene`]) is plain data. Drawing it gives a [`Canvas`], and [`Canvas::save`] writes SVG or PNG. Only `canvas`
//! and `style` use plotters. Programs that need another kind of picture put lines and texts on a [`Canvas`] themselves,
//! with [`ticks`] for axes, a [`Legend`], and the colours and sizes of [`theme`].
//!
//! # Examples
//! The disconnectivity graph of two minima and the saddle between them, from the texts of `min.data` and `ts.data`.
//!
//! ```
//! # #[cfg(feature = "topography")] {
//! use landscape::figure::DisconnectivityPicture;
//! use landscape::topography::exchange::Database;
//! use landscape::topography::{Evidence, Tree};
//!
//! let minima = "-2.0 0.0 1 1.0 1.0 1.0\n-1.0 0.0 1 1.0 1.0 1.0\n";
//! let (database, _) = Database::parse(minima, "0.5 0.0 1 1 2 1.0 1.0 1.0\n")?;
//! let network = database.network();
//! let tree = Tree::from_network(&network, Evidence::Chain);
//! let svg = DisconnectivityPicture::new(tree, &network).draw()?.to_svg()?;
//! assert!(svg.starts_with("<svg") && svg.contains("energy"));
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::path::PathBuf;

mod axis;
mod canvas;
pub mod chart;
mod dash;
mod glyph;
mod image;
mod legend;
mod look;
mod style;
pub mod theme;

#[cfg(feature = "topography")]
mod barriers;
#[cfg(feature = "topography")]
#[cfg(feature = "topography")]
mod disconnectivity;
#[cfg(feature = "topography")]
mod heights;
#[cfg(feature = "topography")]
pub mod layout;
#[cfg(feature = "topography")]
mod leaf;
#[cfg(feature = "topography")]
mod leaf_values;
#[cfg(feature = "topography")]
mod notes;
#[cfg(feature = "topography")]
mod rarefaction;
#[cfg(feature = "grasp")]
mod scene;
#[cfg(feature = "grasp")]
mod sheet;
mod strip;
#[cfg(test)]
pub(crate) mod testing;

pub use axis::{log_tick_texts, log_ticks, number, tick_texts, ticks};
pub use canvas::Canvas;
pub use image::{Image, MAKER};
pub use legend::Legend;
pub use look::{HEART, Hue, Key, Look, Symbol};
pub use strip::{PICTURE_DENSITY, Picture, draw_row, row_height, side_in_row};
pub use style::{Anchor, Colour, Stroke, TextFace, text_width};

#[cfg(feature = "topography")]
pub use barriers::{BarrierPicture, Link, PlacedGraph, PlacedLink};
#[cfg(feature = "topography")]
#[cfg(feature = "topography")]
pub use disconnectivity::DisconnectivityPicture;
#[cfg(feature = "topography")]
pub use leaf::{Leaf, leaves_of, leaves_of_families};
#[cfg(feature = "topography")]
pub use leaf_values::LeafValues;
#[cfg(feature = "topography")]
pub use rarefaction::{rarefaction_chart, rarefaction_panel};
#[cfg(feature = "grasp")]
pub use scene::{Camera, Cone, Marker, Scene, Surface};
#[cfg(feature = "grasp")]
pub use sheet::{contact_sheet, contact_sheet_canvas};

/// Reasons why a picture cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum FigureError {
    /// The ending of the file name is neither `.svg` nor `.png`.
    #[error("the format of figure {} is unknown: give a name that ends in .svg or .png", .0.display())]
    Format(PathBuf),
    /// The number of descriptions is not the number of minima.
    #[error("{described} leaves are described, but the landscape has {present}")]
    Leaves { described: usize, present: usize },
    /// An energy or height is not finite.
    #[error("node {node} has energy {energy}, which cannot be drawn")]
    NotFinite { node: usize, energy: f64 },
    /// A value has no place on an axis of a chart.
    #[error("{value} cannot be drawn on the axis \"{axis}\"")]
    OffAxis {
        /// The value: infinite, or not positive on a logarithmic axis.
        value: f64,
        axis: String,
    },
    /// The ends of an axis of a chart do not ascend.
    #[error("the axis \"{axis}\" cannot go from {low} to {high}")]
    Range { axis: String, low: f64, high: f64 },
    /// There are more minima than are legible.
    #[error(
        "{present} minima do not fit on a picture, which shows {most} at most: draw a view of them"
    )]
    TooMany {
        present: usize,
        /// Largest number of minima that can be drawn.
        most: usize,
    },
    /// A link refers to a minimum that does not exist.
    #[error("a link names minimum {node}, but there are only {present}")]
    NoSuchNode { node: usize, present: usize },
    /// The drawing library failed.
    #[error("the figure could not be drawn: {0}")]
    Draw(String),
    /// The file could not be written.
    #[error("cannot write figure {}", path.display())]
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
}

#[cfg(feature = "topography")]
impl FigureError {
    /// Refuses pictures that would be illegible.
    fn check_count(present: usize, most: usize) -> Result<(), Self> {
        if present > most {
            return Err(Self::TooMany { present, most });
        }
        Ok(())
    }
}
