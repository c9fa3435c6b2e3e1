//! The ways of the merges: paths along the edges of the spanning forest, turned so that one continues the other.
//!
//! A space has a symmetry (that of the object, the numbering of atoms), so the end of one path and the start of the next
//! may be two copies of one minimum. Each minimum is therefore shown as the copy in which the path from its neighbour in
//! the forest ends. The lowest minimum of each component is shown as it is in the file.

use std::collections::{BTreeMap, VecDeque};

use rayon::prelude::*;
use serde_json::{Value, json};

use super::pack::{Pack, Texts};
use super::tree::number;
use crate::energy::Explain;
use crate::grasp::GraspEnergy;
use crate::space::Space;
use crate::store::{LandscapeFiles, PathPoint};
use crate::topography::{Evidence, Network, spanning_forest};

/// Number of minima above which only the ways between families are kept.
const ALL_WAYS: usize = 1000;

/// A way along an edge.
struct Way<'a> {
    ends: [usize; 2],
    /// Row of the edge.
    edge: usize,
    /// Points of the path from the first end to the second, and the same turned.
    rows: Vec<&'a PathPoint>,
    turned: Vec<Vec<f64>>,
}

/// The minima and the ways between them, turned.
pub(super) struct Ways<'a> {
    /// Coordinates of each minimum.
    pub(super) minima: Vec<Vec<f64>>,
    ways: Vec<Way<'a>>,
}

/// The copy of `b` that is nearest to `a`.
pub(super) fn copy(space: &dyn Space, a: &[f64], b: &[f64], near: bool) -> Vec<f64> {
    let mut tangent = vec![0.0; space.tangents()];
    if near {
        space.log_near(a, b, &mut tangent);
    } else {
        space.log(a, b, &mut tangent);
    }
    let mut x = a.to_vec();
    space.exp(&mut x, &tangent);
    x
}

/// Relative error of a length for which a copy of a step is as long as the step.
const SAME_LENGTH: f64 = 1e-3;

/// The copy of a point of a path that continues the way from `last`, which is a copy of the point `before` it.
///
/// It is the near one if that is as far from `last` as the path itself steps. Else `last` has the atoms of a cluster
/// numbered otherwise than the path, and the nearest of all copies continues it.
fn onward(space: &dyn Space, last: &[f64], before: Option<&[f64]>, point: &[f64]) -> Vec<f64> {
    let mut tangent = vec![0.0; space.tangents()];
    let continues = before.is_some_and(|before| {
        let step = space.log_near(before, point, &mut tangent);
        space.log_near(last, point, &mut tangent) <= (1.0 + SAME_LENGTH) * step + 1e-9
    });
    copy(space, last, point, continues)
}

impl<'a> Ways<'a> {
    /// Turns the paths of a landscape. There are none if the landscape does not record coordinates.
    pub(super) fn of(files: &'a LandscapeFiles, network: &Network, space: &dyn Space) -> Self {
        let mut paths: BTreeMap<[u64; 2], Vec<&PathPoint>> = BTreeMap::new();
        for point in &files.paths {
            paths.entry([point.a, point.b]).or_default().push(point);
        }
        for path in paths.values_mut() {
            path.sort_by_key(|point| point.image);
        }
        let mut neighbours = vec![Vec::new(); network.node_count()];
        for edge in spanning_forest(network, Evidence::Chain) {
            if let Some((a, b)) = network.edge_endpoints(edge) {
                neighbours[a.index()].push((b.index(), edge.index()));
                neighbours[b.index()].push((a.index(), edge.index()));
            }
        }
        let mut ways = Self {
            minima: files
                .minima
                .iter()
                .map(|row| row.coordinates.clone())
                .collect(),
            ways: Vec::new(),
        };
        let mut seen = vec![false; network.node_count()];
        for start in 0..network.node_count() {
            let mut waiting = VecDeque::new();
            if !std::mem::replace(&mut seen[start], true) {
                waiting.push_back(start);
            }
            while let Some(from) = waiting.pop_front() {
                for &(to, edge) in &neighbours[from] {
                    if !std::mem::replace(&mut seen[to], true) {
                        ways.add(files, &paths, space, [from, to], edge);
                        waiting.push_back(to);
                    }
                }
            }
        }
        ways
    }

    fn add(
        &mut self,
        files: &LandscapeFiles,
        paths: &BTreeMap<[u64; 2], Vec<&'a PathPoint>>,
        space: &dyn Space,
        ends: [usize; 2],
        edge: usize,
    ) {
        let [from, to] = ends.map(|end| end as u64);
        let mut rows = paths.get(&[from, to]).cloned().unwrap_or_default();
        if rows.is_empty() {
            rows = paths.get(&[to, from]).cloned().unwrap_or_default();
            rows.reverse();
        }
        let mut last = self.minima[ends[0]].clone();
        let mut turned: Vec<Vec<f64>> = Vec::with_capacity(rows.len());
        for (place, row) in rows.iter().enumerate() {
            // The ends of a path are minima, whose atoms may be numbered otherwise than those of the points between.
            let between = (2..rows.len() - 1).contains(&place);
            let before = between.then(|| &rows[place - 1].coordinates[..]);
            last = onward(space, &last, before, &row.coordinates);
            turned.push(last.clone());
        }
        self.minima[ends[1]] = copy(space, &last, &self.minima[ends[1]], false);
        let few = files.minima.len() <= ALL_WAYS;
        let joins_families = files.minima[ends[0]].family != files.minima[ends[1]].family;
        if turned.len() > 1 && (few || joins_families) {
            self.ways.push(Way {
                ends,
                edge,
                rows,
                turned,
            });
        }
    }

    /// The arrays. With an `energy`, each point has its terms.
    pub(super) fn packed(
        &self,
        files: &LandscapeFiles,
        space: &dyn Space,
        energy: Option<&GraspEnergy>,
        pack: &mut Pack,
    ) -> Value {
        let ways = || self.ways.iter();
        let points = || ways().flat_map(|way| &way.turned);
        let edges = || ways().map(|way| &files.edges[way.edge]);
        let dimensions = self.minima.first().map_or(0, Vec::len);
        let (energies, terms) = self.energies(energy);
        let count = energy.map_or(0, |energy| energy.term_names().len());
        let heights: Vec<f64> = edges()
            .map(|edge| edge.height.unwrap_or(f64::NAN))
            .collect();
        let along: Vec<f64> = ways().flat_map(|way| lengths(space, &way.turned)).collect();
        let kinds: Texts = edges()
            .map(|edge| edge.way.as_deref().unwrap_or(""))
            .collect();
        let dominating: Texts = edges()
            .map(|edge| edge.term.as_deref().unwrap_or(""))
            .collect();
        let evidence = edges().map(|edge| Evidence::named(&edge.evidence).map_or(u8::MAX, number));
        json!({
            "a": pack.wholes(ways().map(|way| way.ends[0])),
            "b": pack.wholes(ways().map(|way| way.ends[1])),
            "points": pack.wholes(ways().map(|way| way.turned.len())),
            "height": pack.doubles(&heights),
            "evidence": pack.bytes(evidence),
            "kind": kinds.packed(pack),
            "term": dominating.packed(pack),
            "coordinates": pack.table(dimensions, &points().flatten().copied().collect::<Vec<_>>()),
            "energy": pack.floats(&energies),
            "along": pack.floats(&along),
            "terms": if count > 0 { pack.table(count, &terms) } else { Value::Null },
        })
    }

    /// Energy and terms of all points. The terms are those at the points as the file has them.
    fn energies(&self, energy: Option<&GraspEnergy>) -> (Vec<f64>, Vec<f64>) {
        let rows: Vec<&PathPoint> = self
            .ways
            .iter()
            .flat_map(|way| way.rows.iter().copied())
            .collect();
        let Some(energy) = energy else {
            return (rows.iter().map(|row| row.energy).collect(), Vec::new());
        };
        let explained = rows.par_iter().map(|row| {
            let terms = energy.terms(&row.coordinates).into_iter();
            terms.map(|(_, value)| value).collect::<Vec<f64>>()
        });
        let explained: Vec<Vec<f64>> = explained.collect();
        let sums = explained.iter().map(|terms| terms.iter().sum()).collect();
        (sums, explained.concat())
    }
}

/// Length of a path up to each of its points.
fn lengths(space: &dyn Space, points: &[Vec<f64>]) -> Vec<f64> {
    let mut tangent = vec![0.0; space.tangents()];
    let mut along = vec![0.0];
    for pair in points.windows(2) {
        let step = space.log_near(&pair[0], &pair[1], &mut tangent);
        along.push(along[along.len() - 1] + step);
    }
    along
}
