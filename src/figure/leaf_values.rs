//! Values that place the branches of a disconnectivity graph, or colour them.

use super::axis::{self, Span};
use super::canvas::Canvas;
use super::style::{Anchor, Colour, Stroke, TextFace};
use super::theme::{FAINT, INK, TEXT, sequential};
use super::{FigureError, layout::TreeLayout};
use crate::topography::Tree;

/// A number for each leaf, such as an order parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafValues {
    /// Name and unit of the quantity.
    pub name: String,
    /// Its value for leaf i, for every i.
    pub values: Vec<f64>,
}

/// Room below the branches for an axis and its name.
pub(super) const AXIS_ROOM: f64 = 3.0 * TEXT;

impl LeafValues {
    /// Rejects values that are not finite, or too few or many.
    pub(super) fn check(&self, leaves: usize) -> Result<(), FigureError> {
        if self.values.len() != leaves {
            return Err(FigureError::Leaves {
                described: self.values.len(),
                present: leaves,
            });
        }
        match self.values.iter().position(|value| !value.is_finite()) {
            None => Ok(()),
            Some(leaf) => Err(FigureError::NotFinite {
                node: leaf,
                energy: self.values[leaf],
            }),
        }
    }

    pub(super) fn span(&self) -> Span {
        let values = || self.values.iter().copied();
        let (low, high) = (
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
        );
        if low > high {
            return Span {
                low: 0.0,
                high: 1.0,
            };
        }
        Span { low, high }.widened()
    }

    /// Colour of a leaf.
    pub(super) fn colour(&self, leaf: usize) -> Colour {
        sequential(self.span().part(self.values[leaf]))
    }

    /// Places each leaf at its value, and each merge at the mean of the leaves below it: a metric disconnectivity graph
    /// (L. C. Smeeton, M. T. Oakley and R. L. Johnston, J. Comput. Chem. 35, 1481 (2014)). Branches may cross.
    pub(super) fn place(&self, tree: &Tree) -> TreeLayout {
        let (span, count) = (self.span(), self.values.len());
        let width = count.saturating_sub(1).max(1) as f64;
        // Sum of the places below each node, and number of leaves.
        let sums = tree.fold(|node, branches: &[(f64, usize)]| {
            if branches.is_empty() {
                return (width * span.part(self.values[node.0]), 1);
            }
            let sum = branches.iter().map(|(sum, _)| sum).sum();
            (sum, branches.iter().map(|(_, leaves)| leaves).sum())
        });
        let x: Vec<f64> = sums
            .iter()
            .map(|(sum, leaves)| sum / *leaves as f64)
            .collect();
        let mut leaves: Vec<usize> = (0..count).collect();
        leaves.sort_by(|a, b| x[*a].total_cmp(&x[*b]).then(a.cmp(b)));
        TreeLayout { x, leaves, width }
    }

    /// Draws the axis of the values at the canvas y `top`, between two canvas x.
    pub(super) fn draw_axis(
        &self,
        canvas: &mut Canvas,
        [left, right]: [f64; 2],
        [above, top]: [f64; 2],
    ) {
        let span = self.span();
        let values = axis::ticks(span.low, span.high, 7);
        for (value, text) in values.iter().zip(axis::tick_texts(&values)) {
            let x = left + span.part(*value) * (right - left);
            canvas.line([x, above], [x, top], Stroke::solid(FAINT, 1.5));
            canvas.line([x, top], [x, top + 7.0], Stroke::solid(INK, 2.0));
            let face = TextFace::new(TEXT, INK).anchored(Anchor::Middle);
            canvas.text([x, top + 0.9 * TEXT], &text, face);
        }
        canvas.line([left, top], [right, top], Stroke::solid(INK, 2.0));
        let face = TextFace::new(TEXT, INK).anchored(Anchor::Middle);
        let face = face.fitted(&self.name, right - left);
        canvas.text([0.5 * (left + right), top + 2.2 * TEXT], &self.name, face);
    }
}
