//! The largest ball around the origin inside a convex body in ℝ⁶, by an expanding polytope.
//!
//! The body is given only by its support points, the farthest points in given directions. A simplex of support points is
//! extended by the support point beyond its nearest facet until that facet lies on the body. All other facets are inside
//! the body and farther away, so the ball is exact without examining most of the body (van den Bergen 2001, in ℝ³).

use nalgebra::{Matrix6, Vector6};

/// Points closer than this to a facet, relative to the body, lie on it; far above rounding, so that no facet degenerates.
const THICKNESS: f64 = 1e-11;

/// If rounding breaks a polytope, it is rebuilt with facets a hundred times thicker, up to this thickness.
const THICKEST: f64 = 1e-7;

/// A body thinner than this, relative to its size, counts as flat.
const FLATNESS: f64 = 1e-9;

/// A facet of the body, for which `normal · w ≤ offset` holds on the whole body.
#[derive(Debug, Clone, Copy)]
pub(super) struct NearestFacet {
    pub(super) normal: Vector6<f64>,
    pub(super) offset: f64,
}

/// The facet with the least signed distance from the origin (negative if it is beyond) for this support function.
///
/// A positive distance is the radius of the largest ball around the origin inside the body. If it is negative, the origin
/// is outside and beyond this facet. A flat body is its own facet, at a distance of zero or less.
pub(super) fn nearest_facet(support: impl Fn(&Vector6<f64>) -> Vector6<f64>) -> NearestFacet {
    let mut thickness = THICKNESS;
    loop {
        match expand(&support, thickness) {
            Ok(nearest) => return nearest,
            Err(bound) if thickness >= THICKEST => return bound,
            Err(_) => thickness *= 100.0,
        }
    }
}

/// Like [`nearest_facet`], for a given thickness; if rounding breaks the polytope, the error is the best bound so far.
fn expand(
    support: impl Fn(&Vector6<f64>) -> Vector6<f64>,
    thickness: f64,
) -> Result<NearestFacet, NearestFacet> {
    let mut polytope = match Polytope::simplex(&support, thickness) {
        Ok(polytope) => polytope,
        Err(flat) => return Ok(flat),
    };
    let mut bound = NearestFacet {
        normal: Vector6::x(),
        offset: f64::INFINITY,
    };
    loop {
        let nearest = polytope.nearest();
        let facet = &polytope.facets[nearest];
        let point = support(&facet.normal);
        let found = NearestFacet {
            normal: facet.normal,
            offset: facet.normal.dot(&point),
        };
        if found.offset <= facet.offset + polytope.thickness {
            return Ok(found);
        }
        if found.offset < bound.offset {
            bound = found;
        }
        polytope.grow(nearest, point).ok_or(bound)?;
    }
}

struct Facet {
    corners: [usize; 6],
    /// The facet across the ridge opposite to each corner.
    neighbours: [usize; 6],
    normal: Vector6<f64>,
    offset: f64,
    alive: bool,
}

struct Polytope {
    points: Vec<Vector6<f64>>,
    facets: Vec<Facet>,
    inside: Vector6<f64>,
    thickness: f64,
}

impl Polytope {
    /// Seven support points that span ℝ⁶, or the flat body as a facet.
    fn simplex(
        support: impl Fn(&Vector6<f64>) -> Vector6<f64>,
        thickness: f64,
    ) -> Result<Self, NearestFacet> {
        let mut points = vec![support(&Vector6::x())];
        // The columns are the directions of the simplex so far.
        let mut directions = Matrix6::zeros();
        let mut size = points[0].norm();
        for found in 0..6 {
            let basis = directions.qr().q();
            let mut farthest = (0.0, points[0]);
            for k in found..6 {
                let axis: Vector6<f64> = basis.column(k).into();
                for direction in [axis, -axis] {
                    let point = support(&direction);
                    let extent = direction.dot(&(point - points[0]));
                    size = size.max(point.norm());
                    if extent > farthest.0 {
                        farthest = (extent, point);
                    }
                }
            }
            if farthest.0 <= FLATNESS * size {
                let across: Vector6<f64> = basis.column(found).into();
                let distance = across.dot(&points[0]);
                return Err(NearestFacet {
                    normal: across * -distance.signum(),
                    offset: -distance.abs(),
                });
            }
            directions.set_column(found, &(farthest.1 - points[0]).normalize());
            points.push(farthest.1);
        }
        let mut polytope = Self {
            inside: points.iter().sum::<Vector6<f64>>() / 7.0,
            points,
            facets: Vec::new(),
            thickness: thickness * size,
        };
        for left_out in 0..7 {
            let others = |own: usize| std::array::from_fn(|k| if k < own { k } else { k + 1 });
            let corners: [usize; 6] = others(left_out);
            // Facet k lies opposite to corner k, which it omits.
            polytope.add(corners, corners);
        }
        Ok(polytope)
    }

    fn add(&mut self, corners: [usize; 6], neighbours: [usize; 6]) {
        let first = self.points[corners[0]];
        let mut edges = Matrix6::zeros();
        for (k, corner) in corners[1..].iter().enumerate() {
            edges.set_column(k, &(self.points[*corner] - first));
        }
        // Householder's Q is orthogonal even for a flat facet; its last column is perpendicular to the five edges.
        let mut normal: Vector6<f64> = edges.qr().q().column(5).into();
        if normal.dot(&(first - self.inside)) < 0.0 {
            normal = -normal;
        }
        let offset = corners
            .iter()
            .map(|corner| normal.dot(&self.points[*corner]))
            .fold(f64::NEG_INFINITY, f64::max);
        self.facets.push(Facet {
            corners,
            neighbours,
            normal,
            offset,
            alive: true,
        });
    }

    fn nearest(&self) -> usize {
        let alive = self
            .facets
            .iter()
            .enumerate()
            .filter(|(_, facet)| facet.alive);
        alive
            .min_by(|(_, a), (_, b)| a.offset.total_cmp(&b.offset))
            .map(|(index, _)| index)
            .expect("a polytope has facets")
    }

    /// Replaces the facets visible from a point beyond `seen_from` by a cone; `None` if rounding makes them inconsistent.
    fn grow(&mut self, seen_from: usize, point: Vector6<f64>) -> Option<()> {
        if self.points.contains(&point) {
            return None;
        }
        let apex = self.points.len();
        self.points.push(point);
        let mut seen = vec![seen_from];
        self.facets[seen_from].alive = false;
        let mut rim = Vec::new();
        let mut next = 0;
        while let Some(&facet) = seen.get(next) {
            next += 1;
            for k in 0..6 {
                let across = self.facets[facet].neighbours[k];
                let neighbour = &mut self.facets[across];
                if neighbour.alive {
                    if neighbour.normal.dot(&point) > neighbour.offset + self.thickness {
                        neighbour.alive = false;
                        seen.push(across);
                    } else {
                        rim.push((facet, k, across));
                    }
                }
            }
        }
        // Two new facets meet along the four corners that two ridges of the rim share.
        let mut meetings = Vec::with_capacity(5 * rim.len());
        let first_new = self.facets.len();
        for (index, &(facet, k, across)) in rim.iter().enumerate() {
            let mut corners = self.facets[facet].corners;
            corners[k] = apex;
            let new = first_new + index;
            let mut neighbours = [usize::MAX; 6];
            neighbours[k] = across;
            self.add(corners, neighbours);
            let back = self.facets[across]
                .neighbours
                .iter()
                .position(|&other| other == facet)?;
            self.facets[across].neighbours[back] = new;
            for slot in (0..6).filter(|&slot| slot != k) {
                let mut shared = corners;
                shared[slot] = apex;
                shared.sort_unstable();
                meetings.push((shared, new, slot));
            }
        }
        meetings.sort_unstable();
        for pair in meetings.chunks(2) {
            let [(shared, a, slot_a), (other, b, slot_b)] = pair else {
                return None;
            };
            if shared != other {
                return None;
            }
            self.facets[*a].neighbours[*slot_a] = *b;
            self.facets[*b].neighbours[*slot_b] = *a;
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The facets of the product of three 24-gons, without any thickness; each is shared by hundreds of corners.
    #[test]
    fn round_off_ends_in_a_bound() {
        let support = |u: &Vector6<f64>| {
            let mut point = Vector6::zeros();
            for plane in 0..3 {
                let corner = (0..24)
                    .map(|k| libm::sincos(f64::from(k) * std::f64::consts::TAU / 24.0))
                    .max_by(|a, b| {
                        let along = |c: &(f64, f64)| c.0 * u[2 * plane] + c.1 * u[2 * plane + 1];
                        along(a).total_cmp(&along(b))
                    })
                    .unwrap();
                (point[2 * plane], point[2 * plane + 1]) = corner;
            }
            point
        };
        let inner = libm::cos(std::f64::consts::PI / 24.0);
        assert!((nearest_facet(support).offset - inner).abs() < 1e-10);
        let thin = expand(support, 0.0);
        let found = thin.unwrap_or_else(|bound| bound);
        assert!(found.offset > inner - 1e-10, "{found:?}");
    }
}
