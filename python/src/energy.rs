//! The energy of a hand on an object, for many poses at once.

use std::sync::Arc;

use landscape::energy::Energy as _;
use landscape::grasp::{EnergySettings, GraspEnergy};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{column, points, poses as poses_of, table};
use crate::error;
use crate::grasps::Grasps;
use crate::hand::{self, Hand};
use crate::object::Object;
use crate::work::{briefly, detached};

/// Poses that are evaluated between two looks for signals.
const CHUNK: usize = 4096;

/// The energy of a hand on an object.
#[pyclass(frozen, module = "landscape._native")]
#[derive(Debug)]
pub(crate) struct Energy {
    pub(crate) energy: Arc<GraspEnergy>,
    hand: landscape::store::HandMetadata,
    object_hash: String,
}

/// Energies and gradients, row by row.
type Evaluated<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

#[pymethods]
impl Energy {
    #[new]
    fn new(py: Python<'_>, hand: &Hand, object: &Object) -> PyResult<Self> {
        let settings = EnergySettings::default();
        let parts = (hand.hand.clone(), object.object.clone());
        let energy = detached(
            py,
            || (),
            move || {
                GraspEnergy::new(parts.0, parts.1, settings)
                    .map_err(|wrong| error::Failure::of(&wrong))
            },
        )?;
        Ok(Self {
            energy: Arc::new(energy),
            hand: hand.metadata.clone(),
            object_hash: object.metadata.content_hash.clone(),
        })
    }

    #[getter]
    fn term_names(&self) -> Vec<String> {
        self.energy.term_names()
    }

    #[getter]
    fn coordinates(&self) -> usize {
        self.energy.space().coordinates()
    }

    #[getter]
    fn tangents(&self) -> usize {
        self.energy.space().tangents()
    }

    #[getter]
    fn settings(&self) -> PyResult<String> {
        serde_json::to_string(self.energy.settings())
            .map_err(|wrong| pyo3::exceptions::PyValueError::new_err(wrong.to_string()))
    }

    fn poses<'py>(&self, py: Python<'py>, grasps: &Grasps) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = || grasps.file.grasps.iter();
        let hands = grasps.file.metadata.hands.iter();
        for told in hands.filter(|told| rows().any(|row| row.hand == told.name)) {
            hand::same(py, &self.hand, told)?;
        }
        let objects = grasps.file.metadata.objects.iter();
        for told in objects.filter(|told| rows().any(|row| row.object == told.name)) {
            if told.content_hash != self.object_hash {
                return Err(error::input(
                    py,
                    format!("the grasps are of another object `{}`", told.name),
                ));
            }
        }
        grasps.poses(py)
    }

    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
    ) -> PyResult<Evaluated<'py>> {
        let poses = poses_of(py, "poses", poses, self.energy.space().coordinates())?;
        let tangents = self.energy.space().tangents();
        let mut energies = vec![0.0; poses.len()];
        let mut gradients = vec![0.0; poses.len() * tangents];
        let chunks = (poses.chunks(CHUNK).zip(energies.chunks_mut(CHUNK)))
            .zip(gradients.chunks_mut(CHUNK * tangents));
        for ((poses, energies), gradients) in chunks {
            briefly(py, || {
                (poses.par_iter())
                    .zip(energies.par_iter_mut())
                    .zip(gradients.par_chunks_mut(tangents))
                    .for_each(|((x, energy), gradient)| {
                        *energy = self.energy.evaluate(x, gradient);
                    });
            })?;
            py.check_signals()?;
        }
        Ok((column(py, energies), table(py, gradients, tangents)?))
    }

    fn terms<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let poses = poses_of(py, "poses", poses, self.energy.space().coordinates())?;
        let count = self.energy.term_names().len();
        let mut values = Vec::with_capacity(poses.len() * count);
        for poses in poses.chunks(CHUNK) {
            let energy: &dyn landscape::energy::Energy = &*self.energy;
            let found: Vec<Vec<f64>> = briefly(py, || {
                let terms = |x: &Vec<f64>| {
                    let terms = energy.terms(x).into_iter();
                    terms.map(|(_, value)| value).collect::<Vec<f64>>()
                };
                poses.par_iter().map(terms).collect()
            })?;
            values.extend(found.into_iter().flatten());
            py.check_signals()?;
        }
        table(py, values, count)
    }

    fn moved<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
        tangents: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let space = self.energy.space();
        let mut poses = poses_of(py, "poses", poses, space.coordinates())?;
        let tangents = points(py, "tangents", tangents, space.tangents())?;
        if poses.len() != tangents.len() {
            return Err(error::input(
                py,
                format!(
                    "there are {} poses and {} tangents",
                    poses.len(),
                    tangents.len()
                ),
            ));
        }
        for (x, tangent) in poses.iter_mut().zip(&tangents) {
            space.exp(x, tangent);
        }
        table(py, poses.concat(), space.coordinates())
    }
}
