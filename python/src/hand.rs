//! Hands.

use std::path::PathBuf;
use std::sync::Arc;

use landscape::hand::PosedHand;
use landscape::store::HandMetadata;
use landscape::study;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{column, onto_poses, table, vector};
use crate::error::{Failure, input};
use crate::work::detached;

/// A hand: links, joints, capsules and surface points.
#[pyclass(frozen, module = "landscape._native")]
#[derive(Debug)]
pub(crate) struct Hand {
    pub(crate) metadata: HandMetadata,
    pub(crate) hand: Arc<landscape::hand::Hand>,
}

impl Hand {
    fn posed<'py>(&self, py: Python<'py>, pose: &Bound<'py, PyAny>) -> PyResult<PosedHand> {
        let mut x = vector(py, "pose", pose, self.hand.joints.len() + 7)?;
        onto_poses(&mut x).map_err(|wrong| input(py, format!("pose {wrong}")))?;
        let mut posed = PosedHand::default();
        self.hand.pose(&x, &mut posed);
        Ok(posed)
    }
}

#[pymethods]
impl Hand {
    #[new]
    fn new(
        py: Python<'_>,
        name_or_file: String,
        folder: Option<PathBuf>,
        mirror: bool,
    ) -> PyResult<Self> {
        let name = name_or_file.clone();
        let read = move || {
            let files = study::hand_files(&name_or_file, folder.as_deref(), mirror)?;
            let metadata = study::hand_metadata(&name_or_file, &files, mirror)?;
            let hand = metadata.build()?;
            Ok((metadata, hand))
        };
        let told = move |error: study::InputError| match Failure::of(&error) {
            Failure::Input(sentence) => Failure::Input(format!("hand {name}: {sentence}")),
            other => other,
        };
        let (metadata, hand) = detached(py, || (), move || read().map_err(told))?;
        Ok(Self { metadata, hand })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.metadata.name
    }

    #[getter]
    fn joint_names(&self) -> Vec<String> {
        let joints = self.hand.joints.iter();
        joints.map(|joint| joint.name.clone()).collect()
    }

    #[getter]
    fn link_names(&self) -> Vec<String> {
        let links = self.hand.links.iter();
        links.map(|link| link.name.clone()).collect()
    }

    #[getter]
    fn digits(&self) -> Vec<String> {
        self.hand.digits.clone()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.hand.notes.clone()
    }

    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let limits = self.hand.joints.iter().flat_map(|joint| joint.limits);
        table(py, limits.collect(), 2)
    }

    #[getter]
    fn rest_pose<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        column(py, self.hand.rest_coordinates())
    }

    fn link_frames<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let posed = self.posed(py, pose)?;
        let mut flat = Vec::with_capacity(16 * posed.object_from_link.len());
        for frame in &posed.object_from_link {
            for row in 0..3 {
                flat.extend((0..3).map(|column| frame.rotation[(row, column)]));
                flat.push(frame.translation[row]);
            }
            flat.extend([0.0, 0.0, 0.0, 1.0]);
        }
        column(py, flat).reshape([posed.object_from_link.len(), 4, 4])
    }

    fn surface_points<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let posed = self.posed(py, pose)?;
        let points = posed
            .points
            .iter()
            .flat_map(|point| [point.x, point.y, point.z]);
        table(py, points.collect(), 3)
    }

    fn surface_links<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let links = self.hand.surface.iter();
        column(py, links.map(|point| point.link.0 as i64).collect())
    }
}

/// Refuses two hands that differ where one is needed.
pub(crate) fn same(py: Python<'_>, one: &HandMetadata, other: &HandMetadata) -> PyResult<()> {
    if one.is_same_hand(other) {
        return Ok(());
    }
    Err(input(
        py,
        format!(
            "the grasps are of the hand `{}`, not of `{}`",
            other.name, one.name
        ),
    ))
}
