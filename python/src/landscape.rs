//! A landscape folder, as columns.

use std::path::PathBuf;
use std::sync::Arc;

use ::landscape::object::Description;
use ::landscape::space::{PoseSpace, Space, Symmetry};
use ::landscape::store::{LandscapeFiles, StationaryRow};
use ::landscape::study::{MinimaxPath, surface_space};
use ::landscape::topography::{Ancestors, Evidence, MinimumId, Network, Tree};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{column, table};
use crate::error::{self, Failure, input};
use crate::work::{briefly, detached};

/// The files of a landscape, and its tree.
#[pyclass(frozen, module = "landscape._native")]
#[derive(Debug)]
pub(crate) struct Folder {
    files: Arc<LandscapeFiles>,
    stationary: Vec<StationaryRow>,
    network: Network,
    tree: Tree,
}

/// What a node or an edge of no value is in an array of whole numbers.
const NONE: i64 = -1;

fn number(value: usize) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

impl Folder {
    fn minimum(&self, py: Python<'_>, given: usize) -> PyResult<MinimumId> {
        if given < self.files.minima.len() {
            return Ok(MinimumId(given));
        }
        Err(input(
            py,
            format!(
                "minimum {given} does not exist: the landscape has {}, numbered from 0",
                self.files.minima.len()
            ),
        ))
    }

    fn path_between(&self, ends: [MinimumId; 2], terms: bool) -> Result<Option<Found>, Failure> {
        let manifest = &self.files.manifest;
        let told = |wrong: &(dyn std::error::Error + 'static)| Failure::of(wrong);
        let (Some(hand), Some(object)) = (&manifest.hand, &manifest.object) else {
            let Some((space, _)) = surface_space(manifest) else {
                return Err(Failure::Input(
                    "the landscape does not record its space, so it has no paths".to_owned(),
                ));
            };
            let space: Box<dyn Space> = space;
            let path = MinimaxPath::on_surface(&self.files, &self.network, &*space, ends);
            let path = path.map_err(|wrong| told(&wrong))?;
            return Ok(path.map(|path| Found {
                path,
                terms: Vec::new(),
            }));
        };
        let built = hand.build().map_err(|wrong| told(&wrong))?;
        let description: Description =
            serde_json::from_value(object.description.clone()).map_err(|wrong| told(&wrong))?;
        let symmetry: Symmetry = description.scaled(manifest.scale).symmetry;
        let space = PoseSpace::new(built.pose_metric().clone(), symmetry);
        let path = MinimaxPath::between(&self.files, &self.network, &space, ends);
        let Some(path) = path.map_err(|wrong| told(&wrong))? else {
            return Ok(None);
        };
        if !terms {
            return Ok(Some(Found {
                path,
                terms: Vec::new(),
            }));
        }
        let settings =
            serde_json::from_value(manifest.energy.clone()).map_err(|wrong| told(&wrong))?;
        let object = object.build(manifest.scale).map_err(|wrong| told(&wrong))?;
        let energy = landscape::grasp::GraspEnergy::new(built, object, settings)
            .map_err(|wrong| told(&wrong))?;
        Ok(Some(Found {
            path: path.explained(&energy),
            terms: energy.term_names(),
        }))
    }
}

struct Found {
    path: MinimaxPath,
    terms: Vec<String>,
}

#[pymethods]
impl Folder {
    #[new]
    fn new(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let read = move || {
            let told = |wrong: landscape::store::StoreError| Failure::of(&wrong);
            let files = LandscapeFiles::read(&folder).map_err(told)?;
            let network = files.network(&folder).map_err(told)?;
            let stationary = if folder.join("stationary.parquet").is_file() {
                StationaryRow::read(&folder).map_err(told)?
            } else {
                Vec::new()
            };
            Ok(Self {
                tree: Tree::from_network(&network, Evidence::Chain),
                files: Arc::new(files),
                stationary,
                network,
            })
        };
        detached(py, || (), read)
    }

    fn manifest(&self, py: Python<'_>) -> PyResult<String> {
        serde_json::to_string(&self.files.manifest).map_err(|wrong| error::of(py, &wrong))
    }

    fn minima<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let rows = || self.files.minima.iter();
        let columns = PyDict::new(py);
        let width = rows().next().map_or(0, |row| row.coordinates.len());
        columns.set_item("energy", column(py, rows().map(|row| row.energy).collect()))?;
        columns.set_item(
            "family",
            column(
                py,
                rows().map(|row| row.family as i64).collect::<Vec<i64>>(),
            ),
        )?;
        let flat = rows().flat_map(|row| row.coordinates.iter().copied());
        columns.set_item("coordinates", table(py, flat.collect(), width)?)?;
        let members: Vec<_> = rows().map(|row| column(py, row.members.clone())).collect();
        columns.set_item("members", members)?;
        let labels: Vec<Option<&str>> = rows().map(|row| row.label()).collect();
        columns.set_item("label", labels)?;
        Ok(columns)
    }

    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let rows = || self.files.edges.iter();
        let columns = PyDict::new(py);
        for (name, value) in [
            ("a", (|row| row.a) as fn(&landscape::store::EdgeRow) -> u64),
            ("b", |row| row.b),
            ("chain_runs", |row| row.chain_runs),
            ("evaluations", |row| row.evaluations),
        ] {
            columns.set_item(name, column(py, rows().map(value).collect::<Vec<u64>>()))?;
        }
        for (name, value) in [
            (
                "height",
                (|row| row.height) as fn(&landscape::store::EdgeRow) -> Option<f64>,
            ),
            ("relative_barrier", |row| row.relative_barrier),
            ("length", |row| row.length),
        ] {
            let values = rows().map(|row| value(row).unwrap_or(f64::NAN));
            columns.set_item(name, column(py, values.collect::<Vec<f64>>()))?;
        }
        let evidence: Vec<&str> = rows().map(|row| row.evidence.as_str()).collect();
        columns.set_item("evidence", evidence)?;
        let terms: Vec<Option<&str>> = rows().map(|row| row.term.as_deref()).collect();
        columns.set_item("term", terms)?;
        let ways: Vec<Option<&str>> = rows().map(|row| row.way.as_deref()).collect();
        columns.set_item("way", ways)?;
        Ok(columns)
    }

    /// All minima and saddles of a searched surface; empty for other landscapes.
    fn stationary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let rows = || self.stationary.iter();
        let columns = PyDict::new(py);
        let widths = |value: fn(&StationaryRow) -> usize| rows().map(value).min().unwrap_or(0);
        for (name, value) in [
            ("index", (|row| row.index) as fn(&StationaryRow) -> u64),
            ("id", |row| row.id),
            ("a", |row| row.ends[0]),
            ("b", |row| row.ends[1]),
            ("searches", |row| row.searches),
        ] {
            columns.set_item(name, column(py, rows().map(value).collect::<Vec<u64>>()))?;
        }
        let energies = rows().map(|row| row.energy);
        columns.set_item("energy", column(py, energies.collect::<Vec<f64>>()))?;
        let norms = rows().map(|row| row.gradient_norm);
        columns.set_item("gradient_norm", column(py, norms.collect::<Vec<f64>>()))?;
        let flat = rows().flat_map(|row| row.coordinates.iter().copied());
        let width = widths(|row| row.coordinates.len());
        columns.set_item("coordinates", table(py, flat.collect(), width)?)?;
        let curvatures: Vec<_> = rows()
            .map(|row| column(py, row.curvatures.clone()))
            .collect();
        columns.set_item("curvatures", curvatures)?;
        let verdicts: Vec<&str> = rows().map(|row| row.verdict.as_str()).collect();
        columns.set_item("verdict", verdicts)?;
        Ok(columns)
    }

    /// The lowest height at which two minima are connected.
    fn minimax(&self, py: Python<'_>, a: usize, b: usize) -> PyResult<Option<f64>> {
        let (a, b) = (self.minimum(py, a)?, self.minimum(py, b)?);
        Ok(self.tree.minimax(a, b))
    }

    /// These heights for all pairs.
    fn heights<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let count = self.files.minima.len();
        let flat = briefly(py, || {
            let ancestors = Ancestors::of(&self.tree);
            let pairs = (0..count).flat_map(|a| (0..count).map(move |b| (a, b)));
            let height = |(a, b)| {
                let node = ancestors.joint(MinimumId(a), MinimumId(b));
                node.map_or(f64::INFINITY, |node| self.tree.nodes[node.0].energy)
            };
            pairs.map(height).collect::<Vec<f64>>()
        })?;
        table(py, flat, count)
    }

    /// The nodes of the tree: energies, parents, and what a merge rests on.
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let nodes = || self.tree.nodes.iter();
        let columns = PyDict::new(py);
        let energies = nodes().map(|node| node.energy);
        columns.set_item("energy", column(py, energies.collect::<Vec<f64>>()))?;
        let parents = nodes().map(|node| node.parent.map_or(NONE, |parent| number(parent.0)));
        columns.set_item("parent", column(py, parents.collect::<Vec<i64>>()))?;
        let minima = nodes().map(|node| node.minimum.map_or(NONE, |id| number(id.0)));
        columns.set_item("minimum", column(py, minima.collect::<Vec<i64>>()))?;
        let evidence: Vec<&str> = nodes().map(|node| node.evidence.name()).collect();
        columns.set_item("evidence", evidence)?;
        Ok(columns)
    }

    /// The minimax path between two minima; `None` if none joins them.
    fn path<'py>(
        slf: &Bound<'py, Self>,
        py: Python<'py>,
        a: usize,
        b: usize,
        terms: bool,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let this = slf.get();
        let ends = [this.minimum(py, a)?, this.minimum(py, b)?];
        let kept = slf.clone().unbind();
        let found = detached(py, || (), move || kept.get().path_between(ends, terms))?;
        let Some(Found { path, terms }) = found else {
            return Ok(None);
        };
        let points = || path.points.iter();
        let columns = PyDict::new(py);
        let minima = path.minima.iter().map(|id| number(id.0));
        columns.set_item("minima", column(py, minima.collect::<Vec<i64>>()))?;
        let width = points().next().map_or(0, |at| at.point.coordinates.len());
        let flat = points().flat_map(|at| at.point.coordinates.iter().copied());
        columns.set_item("coordinates", table(py, flat.collect(), width)?)?;
        let energies = points().map(|at| at.point.energy);
        columns.set_item("energy", column(py, energies.collect::<Vec<f64>>()))?;
        let along = points().map(|at| at.along_m);
        columns.set_item("length", column(py, along.collect::<Vec<f64>>()))?;
        let by_term = PyDict::new(py);
        for (place, name) in terms.iter().enumerate() {
            let values = points().map(|at| at.terms()[place]);
            let values: Bound<'_, PyArray1<f64>> = column(py, values.collect());
            by_term.set_item(name, values)?;
        }
        columns.set_item("terms", by_term)?;
        Ok(Some(columns))
    }
}
