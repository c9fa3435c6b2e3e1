//! Objects.

use std::sync::Arc;

use landscape::limits::{OBJECT_SCALE, WALL_THICKNESS};
use landscape::store::ObjectMetadata;
use landscape::study;
use nalgebra::Vector3;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{column, points, table};
use crate::error::{Failure, input};
use crate::work::{briefly, detached};

/// Points that are measured between two looks for signals.
const CHUNK: usize = 65536;
/// Largest coordinate of a point, metres.
const FARTHEST_M: f64 = 1e6;

/// An object: a closed mesh and a smooth field of distances.
#[pyclass(frozen, module = "landscape._native")]
#[derive(Debug)]
pub(crate) struct Object {
    pub(crate) metadata: ObjectMetadata,
    pub(crate) scale: f64,
    /// What was repaired or left out when it was read.
    notes: Vec<String>,
    pub(crate) object: Arc<landscape::object::Object>,
}

impl Object {
    fn at(
        &self,
        place: impl Fn(&landscape::object::Object, &Vector3<f64>) -> f64 + Sync,
        given: &[Vec<f64>],
    ) -> Vec<f64> {
        let at = |x: &Vec<f64>| place(&self.object, &Vector3::from_column_slice(x));
        given.par_iter().with_min_len(64).map(at).collect()
    }
}

#[pymethods]
impl Object {
    #[new]
    fn new(
        py: Python<'_>,
        name_or_file: String,
        scale: f64,
        name: Option<String>,
        thickness_mm: Option<f64>,
    ) -> PyResult<Self> {
        if let Err(beyond) = OBJECT_SCALE.check(scale) {
            return Err(input(py, format!("scale {beyond}")));
        }
        if let Some(Err(beyond)) = thickness_mm.map(|thickness| WALL_THICKNESS.check(thickness)) {
            return Err(input(py, format!("thickness_mm {beyond}")));
        }
        let thickness_m = thickness_mm.map(|thickness_mm| 1e-3 * thickness_mm);
        let place = name_or_file.clone();
        let read = move || {
            let (mut metadata, notes) = study::object_metadata(&name_or_file, scale, thickness_m)?;
            if let Some(name) = name {
                study::rename_object(&mut metadata, &name)?;
            }
            let object = metadata.build(scale)?;
            Ok((metadata, object, notes))
        };
        let told = move |error: study::InputError| match error {
            study::InputError::NoObject => Failure::Input(format!("object {place}: {error}")),
            error => Failure::of(&error),
        };
        let (metadata, object, mut notes) = detached(py, || (), move || read().map_err(told))?;
        for note in &object.notes {
            if !notes.contains(note) {
                notes.push(note.clone());
            }
        }
        Ok(Self {
            metadata,
            scale,
            notes,
            object,
        })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.metadata.name
    }

    #[getter]
    fn scale(&self) -> f64 {
        self.scale
    }

    #[getter]
    fn mass_kg(&self) -> f64 {
        self.object.mass_kg
    }

    #[getter]
    fn radius_m(&self) -> f64 {
        self.object.radius_m
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let vertices = self.object.mesh.vertices().iter();
        table(py, vertices.flat_map(|v| [v.x, v.y, v.z]).collect(), 3)
    }

    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let triangles = self.object.mesh.triangles().iter();
        table(py, triangles.flat_map(|corners| *corners).collect(), 3)
    }

    fn distance<'py>(
        &self,
        py: Python<'py>,
        given: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let given = points(py, "points", given, 3)?;
        let far = |x: &Vec<f64>| x.iter().any(|x| x.abs() > FARTHEST_M);
        if let Some(row) = given.iter().position(far) {
            return Err(input(
                py,
                format!("points: row {row} is more than {FARTHEST_M:.0} m away"),
            ));
        }
        let mut found = Vec::with_capacity(given.len());
        for given in given.chunks(CHUNK) {
            found.extend(briefly(py, || {
                self.at(|object, x| object.exact.distance(x), given)
            })?);
            py.check_signals()?;
        }
        Ok(column(py, found))
    }
}
