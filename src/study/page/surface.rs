//! What a page shows of an energy that is none of grasps: its space, and the contours of a model of one or two coordinates.

use serde_json::{Value, json};

use super::pack::Pack;
use crate::energy::model;
use crate::space::Space;
use crate::store::Manifest;
use crate::study::surface_space;

/// Points of the contour map along each coordinate.
const GRID: usize = 121;
/// How far the map reaches beyond the region of random starts, as a fraction of it.
const BEYOND: f64 = 0.08;

/// The space of a searched surface: the kind of its coordinates and their number; `None` if the manifest does not tell.
pub(super) fn space(manifest: &Manifest) -> Option<(String, Box<dyn Space + Send>)> {
    let (space, _) = surface_space(manifest)?;
    // Of the name of atoms of several elements, the page needs the first word.
    let kind = manifest.energy["coordinates"].as_str()?;
    Some((kind.split_whitespace().next()?.to_owned(), space))
}

fn bounds(manifest: &Manifest, name: &str) -> Vec<f64> {
    let numbers = manifest.energy[name].as_array().into_iter().flatten();
    numbers.filter_map(Value::as_f64).collect()
}

/// Energies of a model on a grid, row by row from the lowest second coordinate; null for an energy of another program,
/// which may be slow, and for more than two coordinates.
pub(super) fn contours(manifest: &Manifest, pack: &mut Pack) -> Value {
    let words: Vec<&str> = (manifest.energy["surface"].as_str().unwrap_or_default())
        .split_whitespace()
        .collect();
    let Ok(surface) = model::named(&words) else {
        return Value::Null;
    };
    let (low, high) = (bounds(manifest, "low"), bounds(manifest, "high"));
    let dimensions = low.len();
    if !(1..=2).contains(&dimensions)
        || high.len() != dimensions
        || surface.energy.space().coordinates() != dimensions
    {
        return Value::Null;
    }
    let margin = |axis: usize| BEYOND * (high[axis] - low[axis]);
    let from: Vec<f64> = (0..dimensions)
        .map(|axis| low[axis] - margin(axis))
        .collect();
    let to: Vec<f64> = (0..dimensions)
        .map(|axis| high[axis] + margin(axis))
        .collect();
    let at = |axis: usize, step: usize| {
        from[axis] + (to[axis] - from[axis]) * step as f64 / (GRID - 1) as f64
    };
    let mut gradient = vec![0.0; surface.energy.space().tangents()];
    let mut energies = Vec::new();
    for row in 0..if dimensions == 2 { GRID } else { 1 } {
        for column in 0..GRID {
            let x: Vec<f64> = [at(0, column)]
                .into_iter()
                .chain((dimensions == 2).then(|| at(1, row)))
                .collect();
            energies.push(surface.energy.evaluate(&x, &mut gradient));
        }
    }
    json!({ "low": from, "high": to, "columns": GRID, "energy": pack.floats(&energies) })
}
