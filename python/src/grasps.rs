//! Grasps as columns.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use landscape::grasp::EnergySettings;
use landscape::grasp::Grasp;
use landscape::space::Pose;
use landscape::store::{GraspFile, GraspRow, Metadata, Overrides, SCHEMA_VERSION};
use landscape::study::{self, JudgedGrasp, judge_all};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays::{column, points, table};
use crate::error::{self, Failure, input};
use crate::hand::Hand;
use crate::object::Object;
use crate::work::{briefly, detached};

/// How far the length of a given quaternion may be from 1.
const UNIT: f64 = 1e-3;

/// Grasps of one or several hands and objects.
#[pyclass(frozen, module = "landscape._native")]
#[derive(Debug)]
pub(crate) struct Grasps {
    pub(crate) file: Arc<GraspFile>,
    warnings: Vec<String>,
    /// A grasp of those from which none was taken, whose columns an empty table has, too.
    pattern: Option<GraspRow>,
}

impl Grasps {
    fn of(file: GraspFile, warnings: Vec<String>) -> Self {
        Self {
            file: Arc::new(file),
            warnings,
            pattern: None,
        }
    }

    fn rows(&self) -> impl Iterator<Item = &GraspRow> {
        self.file.grasps.iter()
    }

    /// Refuses grasps of hands with different numbers of joints where one table of all is wanted.
    fn joints(&self, py: Python<'_>) -> PyResult<usize> {
        let counts: BTreeSet<usize> = self
            .rows()
            .map(|row| row.grasp.pose.joints().len())
            .collect();
        match counts.into_iter().collect::<Vec<_>>().as_slice() {
            [] => Ok((self.pattern.as_ref()).map_or(0, |row| row.grasp.pose.joints().len())),
            [count] => Ok(*count),
            _ => Err(input(
                py,
                "the grasps are of hands with different numbers of joints: take those of one hand first (grasps.hand == name)",
            )),
        }
    }

    pub(crate) fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let joints = self.joints(py)?;
        let flat = self.rows().flat_map(|row| row.grasp.pose.iter().copied());
        table(py, flat.collect(), 7 + joints)
    }

    fn floats<'py>(
        &self,
        py: Python<'py>,
        value: impl Fn(&GraspRow) -> Option<f64>,
    ) -> Bound<'py, PyAny> {
        let values = self.rows().map(|row| value(row).unwrap_or(f64::NAN));
        column(py, values.collect()).into_any()
    }

    fn texts<'py>(
        &self,
        py: Python<'py>,
        value: impl Fn(&GraspRow) -> Option<&str>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let values: Vec<Option<&str>> = self.rows().map(value).collect();
        let numpy = py.import("numpy")?;
        let options = PyDict::new(py);
        options.set_item("dtype", "object")?;
        numpy.call_method("array", (values,), Some(&options))
    }
}

#[pymethods]
impl Grasps {
    #[staticmethod]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        hand: Option<&Hand>,
        object: Option<&Object>,
    ) -> PyResult<Self> {
        let overrides = Overrides {
            hand: hand.map(|hand| hand.metadata.clone()),
            object: object.map(|object| object.metadata.clone()),
        };
        let read =
            move || study::read_grasps(&path, overrides).map_err(|wrong| Failure::of(&wrong));
        let (file, warnings) = detached(py, || (), read)?;
        Ok(Self::of(file, warnings))
    }

    /// Grasps of given poses, measured.
    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "one for each column")]
    fn from_arrays(
        py: Python<'_>,
        hand: &Hand,
        object: &Object,
        translation: &Bound<'_, PyAny>,
        rotation_wxyz: &Bound<'_, PyAny>,
        joints: &Bound<'_, PyAny>,
        contacts: Option<Vec<Vec<u32>>>,
        source: &str,
    ) -> PyResult<Self> {
        let translation = points(py, "translation", translation, 3)?;
        let rotation = points(py, "rotation", rotation_wxyz, 4)?;
        let joints = points(py, "joints", joints, hand.hand.joints.len())?;
        let count = translation.len();
        let lengths = [
            ("rotation", rotation.len()),
            ("joints", joints.len()),
            ("contacts", contacts.as_ref().map_or(count, Vec::len)),
        ];
        for (name, length) in lengths {
            if length != count {
                return Err(input(
                    py,
                    format!("{name} has {length} rows, but translation has {count}"),
                ));
            }
        }
        if count == 0 {
            return Err(input(
                py,
                "translation has no rows: at least one grasp is needed",
            ));
        }
        let energy = EnergySettings::default();
        let mut file = GraspFile {
            metadata: Metadata {
                schema_version: SCHEMA_VERSION,
                program_version: env!("CARGO_PKG_VERSION").to_owned(),
                hands: vec![hand.metadata.clone()],
                objects: vec![object.metadata.clone()],
                energy: serde_json::to_value(energy).map_err(|wrong| error::of(py, &wrong))?,
                ..Metadata::default()
            },
            grasps: Vec::with_capacity(count),
        };
        for row in 0..count {
            let q = &rotation[row];
            let norm = q.iter().map(|part| part * part).sum::<f64>().sqrt();
            if (norm - 1.0).abs() > UNIT {
                return Err(input(
                    py,
                    format!("rotation: the quaternion of row {row} has the length {norm}, not 1"),
                ));
            }
            // Both signs are one rotation, of which files have the one with w ≥ 0.
            let sign = if q[0] < 0.0 { -norm } else { norm };
            let t = &translation[row];
            let pose = Pose::new(
                [t[0], t[1], t[2]],
                [q[0], q[1], q[2], q[3]].map(|part| part / sign),
                &joints[row],
            );
            let chosen = contacts.as_ref().map(|sets| sets[row].clone());
            file.grasps.push(GraspRow {
                id: row as u64,
                object: object.metadata.name.clone(),
                scale: object.scale,
                hand: hand.metadata.name.clone(),
                grasp: Grasp::new(pose, chosen.unwrap_or_default()),
                source: source.to_owned(),
                ..GraspRow::default()
            });
        }
        if let Some((row, fault)) = file.faults().into_iter().next() {
            return Err(input(py, format!("row {row}: {fault}")));
        }
        let measured = detached(
            py,
            || (),
            move || {
                file.measure().map_err(|wrong| Failure::of(&wrong))?;
                Ok(file)
            },
        )?;
        Ok(Self::of(measured, Vec::new()))
    }

    fn __len__(&self) -> usize {
        self.file.grasps.len()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// The metadata of the file, as JSON.
    fn metadata(&self, py: Python<'_>) -> PyResult<String> {
        serde_json::to_string(&self.file.metadata).map_err(|wrong| error::of(py, &wrong))
    }

    #[getter]
    fn term_names(&self) -> Vec<String> {
        self.file.metadata.terms.clone()
    }

    /// Hand, object, scale and number of the grasps of each population.
    fn populations(&self) -> Vec<(String, String, f64, usize)> {
        let populations = self.file.landscapes().into_iter();
        populations
            .map(|population| {
                (
                    population.hand.name.clone(),
                    population.object.name.clone(),
                    population.scale,
                    population.grasps.len(),
                )
            })
            .collect()
    }

    /// The grasps of these rows, in this order.
    fn take(&self, py: Python<'_>, rows: Vec<usize>) -> PyResult<Self> {
        let mut taken = Vec::with_capacity(rows.len());
        for row in rows {
            let Some(grasp) = self.file.grasps.get(row) else {
                return Err(pyo3::exceptions::PyIndexError::new_err(format!(
                    "row {row} of {} grasps",
                    self.file.grasps.len()
                )));
            };
            taken.push(grasp.clone());
        }
        let ids: BTreeSet<u64> = taken.iter().map(|grasp| grasp.id).collect();
        if ids.len() < taken.len() {
            return Err(input(py, "a grasp is chosen twice, but ids must be unique"));
        }
        let pattern = self.rows().next().or(self.pattern.as_ref());
        let pattern = pattern.filter(|_| taken.is_empty()).cloned();
        Ok(Self {
            file: Arc::new(GraspFile {
                metadata: self.file.metadata.clone(),
                grasps: taken,
            }),
            warnings: Vec::new(),
            pattern,
        })
    }

    /// The bytes of the file. Without grasps, they hold a pattern: one grasp of those from which none was taken.
    fn encode<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let pattern = self.pattern.as_ref().map(|row| GraspFile {
            metadata: self.file.metadata.clone(),
            grasps: vec![row.clone()],
        });
        let file = pattern.as_ref().unwrap_or(&self.file);
        let bytes = briefly(py, || file.encode(Path::new("grasps.parquet")))?;
        bytes
            .map(|bytes| PyBytes::new(py, &bytes))
            .map_err(|wrong| error::of(py, &wrong))
    }

    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        briefly(py, || self.file.write(&path))?.map_err(|wrong| error::of(py, &wrong))
    }

    #[getter(poses)]
    fn all_poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.poses(py)
    }

    fn terms<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let flat = self.rows().flat_map(|row| row.terms.iter().copied());
        table(py, flat.collect(), self.file.metadata.terms.len())
    }

    fn contacts<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray1<u32>>> {
        let sets = self.rows().map(|row| row.grasp.contacts.clone());
        sets.map(|set| column(py, set)).collect()
    }

    /// A column of numbers, flags (1, 0, missing: NaN) or texts (missing: None).
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let whole = |value: fn(&GraspRow) -> u64| {
            column(py, self.rows().map(value).collect::<Vec<u64>>()).into_any()
        };
        Ok(match name {
            "id" => whole(|row| row.id),
            "chain_seed" => whole(|row| row.chain_seed),
            "chain_step" => whole(|row| row.chain_step),
            "scale" => self.floats(py, |row| Some(row.scale)),
            "energy" => self.floats(py, |row| Some(row.energy)),
            "net_wrench" => self.floats(py, |row| Some(row.net_wrench)),
            "distance_squared" => self.floats(py, |row| Some(row.distance_squared)),
            "penetration" => self.floats(py, |row| Some(row.penetration)),
            "friction" => self.floats(py, |row| row.friction),
            "epsilon" => self.floats(py, |row| row.epsilon),
            "stable" => self.floats(py, |row| row.stable.map(f64::from)),
            "stable_displacement_m" => self.floats(py, |row| row.stable_displacement_m),
            "stable_turn_rad" => self.floats(py, |row| row.stable_turn_rad),
            "label_score" => self.floats(py, |row| row.label_score),
            "hand" => self.texts(py, |row| Some(&row.hand))?,
            "object" => self.texts(py, |row| Some(&row.object))?,
            "source" => self.texts(py, |row| Some(&row.source))?,
            "stable_reason" => self.texts(py, |row| row.stable_reason.as_deref())?,
            "label" => self.texts(py, |row| row.label.as_deref())?,
            "label_auto" => self.texts(py, |row| row.label_auto.as_deref())?,
            "label_best" => self.texts(py, |row| row.label_best.as_deref())?,
            "label_category" => self.texts(py, |row| row.label_category.as_deref())?,
            "label_source" => self.texts(py, |row| row.label_source.as_deref())?,
            _ => return Err(input(py, format!("no column is called `{name}`"))),
        })
    }

    /// Judges all grasps on the exact mesh, row by row.
    fn judge<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let file = self.file.clone();
        let judged = detached(
            py,
            || (),
            move || {
                let mut judged: Vec<JudgedGrasp> = Vec::new();
                for population in file.landscapes() {
                    let energy = population.energy().map_err(|wrong| Failure::of(&wrong))?;
                    judged.extend(judge_all(&energy, &population, &population.grasps, || ()));
                }
                let place: std::collections::BTreeMap<u64, usize> =
                    (file.grasps.iter().enumerate())
                        .map(|(row, grasp)| (grasp.id, row))
                        .collect();
                judged.sort_by_key(|grasp| place[&grasp.id]);
                Ok(judged)
            },
        )?;
        columns_of(py, &judged)
    }
}

fn columns_of<'py>(py: Python<'py>, judged: &[JudgedGrasp]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    let rows = || judged.iter();
    columns.set_item(
        "id",
        column(py, rows().map(|row| row.id).collect::<Vec<u64>>()),
    )?;
    let flags: [(&str, fn(&JudgedGrasp) -> bool); 6] = [
        ("strict", |row| row.objection.is_none()),
        ("published", |row| row.passes_published),
        ("released", |row| row.passes_released),
        ("force_closure", |row| row.judgement.force_closure),
        ("one_concavity", |row| row.judgement.one_concavity),
        ("human_like_hand", |row| row.hand_use.is_some()),
    ];
    for (name, value) in flags {
        columns.set_item(name, column(py, rows().map(value).collect::<Vec<bool>>()))?;
    }
    let floats: [(&str, fn(&JudgedGrasp) -> f64); 10] = [
        ("net_wrench", |row| row.judgement.net_wrench),
        ("distance_squared", |row| row.judgement.distance_squared),
        ("penetration", |row| row.judgement.penetration),
        ("gap_m", |row| row.judgement.gap_m),
        ("deepest_m", |row| row.judgement.deepest_m),
        ("self_penetration_m", |row| row.judgement.self_penetration_m),
        ("joint_excess", |row| row.judgement.joint_excess),
        ("least_friction", |row| {
            row.judgement.least_friction.unwrap_or(f64::NAN)
        }),
        ("epsilon", |row| row.judgement.epsilon),
        ("compliance", |row| {
            row.judgement.compliance.unwrap_or(f64::NAN)
        }),
    ];
    for (name, value) in floats {
        columns.set_item(name, column(py, rows().map(value).collect::<Vec<f64>>()))?;
    }
    columns.set_item(
        "digits",
        column(
            py,
            rows()
                .map(|row| row.judgement.digits as i64)
                .collect::<Vec<i64>>(),
        ),
    )?;
    columns.set_item(
        "objection",
        rows().map(|row| row.objection).collect::<Vec<_>>(),
    )?;
    let contacts = rows().map(|row| {
        let contacts = row.contacts.iter();
        contacts
            .map(|contact| {
                (
                    contact.surface_point,
                    contact.link.clone(),
                    contact.distance_m,
                )
            })
            .collect::<Vec<_>>()
    });
    columns.set_item("contacts", contacts.collect::<Vec<_>>())?;
    Ok(columns)
}
