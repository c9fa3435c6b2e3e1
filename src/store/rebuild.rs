//! Conversion between hands, objects and energies and their metadata in files.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;
use serde_json::Value;

use super::error::Warning;
use super::grasps::{GraspFile, GraspRow, term_column};
use super::metadata::{HandMetadata, Metadata, ObjectMetadata, TextFile, content_hash};
use super::population::Population;
use crate::energy::Explain;
use crate::grasp::energy::EnergySettingsError;
use crate::grasp::{EnergySettings, Grasp, GraspEnergy, Judgement, judge};
use crate::hand::{Hand, HandError, HandFiles};
use crate::limits::{Beyond, OBJECT_MASS};
use crate::mesh::Mesh;
use crate::object::{Description, Object, ObjectError, ObjectParts};

/// Reasons why a hand, an object or an energy cannot be built from metadata.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum RebuildError {
    /// The file has only the name of a hand.
    #[error("the file does not describe hand `{0}`: name it with --hand")]
    NoHand(String),
    /// The description of a hand is invalid.
    #[error("hand {file}")]
    Hand { file: String, source: HandError },
    /// The description has other joints than the rows.
    #[error(
        "hand `{hand}` does not match: the file was written for joint `{told}` where its description has `{found}`"
    )]
    OtherJoint {
        hand: String,
        told: String,
        found: String,
    },
    /// The description has another number of joints or surface points than the rows.
    #[error(
        "hand `{hand}` does not match: the file was written for {} joints and {} surface points, but its description \
         gives {} and {}",
        told[0], told[1], found[0], found[1]
    )]
    OtherSize {
        hand: String,
        /// Numbers of joints and surface points in the metadata.
        told: [usize; 2],
        /// Numbers of joints and surface points in the description.
        found: [usize; 2],
    },
    /// The contacts of the rows are numbers of other surface points than those of this version.
    #[error(
        "hand `{0}` does not match: another version of the program wrote the file and placed the surface points of the \
         contacts elsewhere; name the hand with --hand to choose contacts again"
    )]
    OtherPoints(String),
    /// The file has only the name of an object.
    #[error("the file does not contain the mesh of object `{0}`: name it with --object")]
    NoMesh(String),
    /// The description of an object is invalid.
    #[error("the description of object `{object}` in the file")]
    Description {
        object: String,
        source: serde_json::Error,
    },
    /// The mesh of an object is invalid.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// An object is heavier or lighter than the limits allow.
    #[error("the mass of object `{object}`")]
    Mass { object: String, source: Beyond },
    /// The metadata have an energy of another program or version.
    #[error("the energy in the metadata is not supported by this version")]
    Energy(#[source] serde_json::Error),
    /// A setting of the energy is out of range.
    #[error(transparent)]
    Settings(#[from] EnergySettingsError),
}

impl HandMetadata {
    /// The metadata of the hand of `files`.
    ///
    /// # Errors
    /// If the files do not describe a hand.
    pub fn new(name: String, files: &HandFiles) -> Result<Self, RebuildError> {
        let identity = files.identity();
        let texts: Vec<&[u8]> = identity.iter().map(String::as_bytes).collect();
        let description = files.files.iter().map(|file| TextFile {
            name: file.name.clone(),
            text: file.text.clone(),
        });
        let mut metadata = Self {
            name,
            content_hash: content_hash(&texts),
            description: description.collect(),
            ..Self::default()
        };
        let hand = metadata.build()?;
        metadata.joint_names = hand.joints.iter().map(|joint| joint.name.clone()).collect();
        metadata.limits = hand.joints.iter().map(|joint| joint.limits).collect();
        metadata.surface_points = hand.surface.len();
        metadata.surface_hash = surface_hash(&hand);
        metadata.notes.clone_from(&hand.notes);
        Ok(metadata)
    }

    /// Builds the hand, under the name in the metadata.
    ///
    /// # Errors
    /// If the description is missing or invalid.
    pub fn build(&self) -> Result<Arc<Hand>, RebuildError> {
        let Some(main) = self.description.first() else {
            return Err(RebuildError::NoHand(self.name.clone()));
        };
        let texts = self.description.iter();
        let files = HandFiles::of_texts(texts.map(|file| [file.name.as_str(), file.text.as_str()]));
        let mut hand = Hand::from_files(&files).map_err(|source| RebuildError::Hand {
            file: main.name.clone(),
            source,
        })?;
        hand.name.clone_from(&self.name);
        Ok(Arc::new(hand))
    }

    /// Builds the hand and checks that it has the joints and surface points that the rows of the file refer to.
    ///
    /// # Errors
    /// If the description is missing, invalid, or that of another hand.
    pub fn build_matching(&self) -> Result<Arc<Hand>, RebuildError> {
        let hand = self.build()?;
        let joints = || hand.joints.iter().map(|joint| &joint.name);
        if let Some((found, told)) = joints().zip(&self.joint_names).find(|(a, b)| a != b) {
            return Err(RebuildError::OtherJoint {
                hand: self.name.clone(),
                told: told.clone(),
                found: found.clone(),
            });
        }
        let told = [self.joint_names.len(), self.surface_points];
        let found = [hand.joints.len(), hand.surface.len()];
        if told != found {
            let hand = self.name.clone();
            return Err(RebuildError::OtherSize { hand, told, found });
        }
        if self.surface_hash != surface_hash(&hand) {
            return Err(RebuildError::OtherPoints(self.name.clone()));
        }
        Ok(hand)
    }
}

/// [`content_hash`] of the surface points, rounded to micrometres, so that a last bit hardly ever counts.
fn surface_hash(hand: &Hand) -> String {
    let numbers = hand.surface.iter().flat_map(|surface| {
        // Zero is added because −0 has other bits.
        let [x, y, z] = [0, 1, 2].map(|k| (1e6 * surface.point[k]).round() + 0.0);
        [surface.link.0 as f64, x, y, z]
    });
    content_hash(&[&numbers.flat_map(f64::to_le_bytes).collect::<Vec<u8>>()])
}

impl ObjectMetadata {
    /// The metadata of an object.
    ///
    /// # Errors
    /// If the description cannot be stored.
    pub fn new(parts: &ObjectParts) -> Result<Self, RebuildError> {
        let obj = parts.mesh.to_obj();
        let description = serde_json::to_value(&parts.description)
            .map_err(|source| described(&parts.name, source))?;
        Ok(Self {
            name: parts.name.clone(),
            mass_kg: parts.description.mass_of(&parts.mesh),
            content_hash: content_hash(&[obj.as_bytes(), description.to_string().as_bytes()]),
            description,
            mesh_obj: Some(obj),
        })
    }

    /// Builds the object, scaled by `scale`.
    ///
    /// # Errors
    /// If the mesh is missing, or if mesh, description or size is invalid.
    pub fn build(&self, scale: f64) -> Result<Arc<Object>, RebuildError> {
        let (mesh, description) = self.parts(scale)?;
        Ok(Arc::new(Object::from_mesh(&self.name, mesh, &description)?))
    }

    /// Mesh and mass (kg) of the object, scaled by `scale`, without the smooth field.
    ///
    /// # Errors
    /// If the mesh is missing, or if mesh, description, size or mass is invalid.
    pub fn mesh(&self, scale: f64) -> Result<(Mesh, f64), RebuildError> {
        let (mesh, _) = self.parts(scale)?;
        mesh.check_size(&self.name).map_err(ObjectError::from)?;
        let mass_kg = self.mass_kg * scale.powi(3);
        OBJECT_MASS
            .check(mass_kg)
            .map_err(|source| RebuildError::Mass {
                object: self.name.clone(),
                source,
            })?;
        Ok((mesh, mass_kg))
    }

    fn parts(&self, scale: f64) -> Result<(Mesh, Description), RebuildError> {
        let name = &self.name;
        let Some(obj) = &self.mesh_obj else {
            return Err(RebuildError::NoMesh(name.clone()));
        };
        let description: Description = serde_json::from_value(self.description.clone())
            .map_err(|source| described(name, source))?;
        let mesh = description.mesh_of_obj(name, obj)?;
        Ok(if (scale - 1.0).abs() < f64::EPSILON {
            (mesh, description)
        } else {
            let mesh = mesh.scaled(name, scale).map_err(ObjectError::from)?;
            (mesh, description.scaled(scale))
        })
    }
}

fn described(object: &str, source: serde_json::Error) -> RebuildError {
    let object = object.to_owned();
    RebuildError::Description { object, source }
}

impl Metadata {
    /// The settings of the energy; the defaults if the file has none.
    ///
    /// # Errors
    /// If a setting of the file is not of its type.
    pub fn energy_settings(&self) -> Result<EnergySettings, RebuildError> {
        match &self.energy {
            Value::Null => Ok(EnergySettings::default()),
            told => serde_json::from_value(told.clone()).map_err(RebuildError::Energy),
        }
    }
}

impl Population<'_> {
    /// Names of the energy terms of the grasps.
    pub fn terms(&self) -> &[String] {
        &self.metadata.terms
    }

    /// Settings of the energy of the grasps; null if they are not known.
    pub fn energy_settings(&self) -> &serde_json::Value {
        &self.metadata.energy
    }

    /// Builds the hand.
    ///
    /// # Errors
    /// As [`HandMetadata::build_matching`].
    pub fn hand(&self) -> Result<Arc<Hand>, RebuildError> {
        self.hand.build_matching()
    }

    /// Builds the object at its scale.
    ///
    /// # Errors
    /// As [`ObjectMetadata::build`].
    pub fn object(&self) -> Result<Arc<Object>, RebuildError> {
        self.object.build(self.scale)
    }

    /// Mesh and mass (kg) of the object at its scale, without the smooth field.
    ///
    /// # Errors
    /// As [`ObjectMetadata::mesh`].
    pub fn mesh(&self) -> Result<(Mesh, f64), RebuildError> {
        self.object.mesh(self.scale)
    }

    /// Builds the energy that the grasps were made with.
    ///
    /// # Errors
    /// If hand, object or settings are missing or invalid.
    pub fn energy(&self) -> Result<GraspEnergy, RebuildError> {
        let settings = self.metadata.energy_settings()?;
        Ok(GraspEnergy::new(self.hand()?, self.object()?, settings)?)
    }
}

impl GraspFile {
    /// Measures all grasps with the described hands and objects.
    ///
    /// # Errors
    /// If hand, object or settings are missing or invalid.
    pub fn measure(&mut self) -> Result<(), RebuildError> {
        let mut measured = BTreeMap::new();
        let mut terms = Vec::new();
        for population in self.landscapes() {
            let energy = population.energy()?;
            terms = energy.term_names();
            let grasps = population.grasps.par_iter().map(|grasp| {
                let mut grasp = (*grasp).clone();
                grasp.measure(&energy);
                (grasp.id, grasp)
            });
            measured.extend(grasps.collect::<Vec<_>>());
        }
        for grasp in &mut self.grasps {
            if let Some(anew) = measured.remove(&grasp.id) {
                *grasp = anew;
            }
        }
        self.metadata.terms = terms;
        Ok(())
    }
}

/// Largest difference between a measure in a file and the same computed that is taken for rounding, relative to the larger of
/// 1 and the measure. A file of single precision differs by a millionth; a hand moved by 0.1 mm differs by more.
const ROUNDING: f64 = 1e-5;

impl GraspFile {
    /// Notes in the metadata that no checksum vouches for the outcomes of simulations. The note stays in files that are written
    /// from these grasps, until `landscape stability` simulates them again.
    pub(crate) fn mark_unverified(&mut self) {
        if !self.metadata.stability.is_object() {
            self.metadata.stability = serde_json::json!({});
        }
        self.metadata.stability["unverified"] = Value::Bool(true);
    }

    /// Whether the outcomes of simulations are those of another program or of changed poses ([`StoreError::Unsealed`]).
    ///
    /// [`StoreError::Unsealed`]: super::StoreError::Unsealed
    pub fn has_unverified_outcomes(&self) -> bool {
        self.metadata.stability["unverified"] == true
    }

    /// Computes the energies and measures anew and compares them with those of the file, which no checksum vouches for.
    ///
    /// Rows that agree stay as they are. In the others the computed values are used, and outcomes of simulations and labels of
    /// the rule, which were those of another pose, are removed. Values that the file leaves out are added.
    ///
    /// # Errors
    /// If hand, object or settings are missing or invalid.
    pub fn verify(&mut self) -> Result<Option<Warning>, RebuildError> {
        let told = self.grasps.clone();
        let terms = self.metadata.terms.clone();
        self.measure()?;
        let same_terms = self.metadata.terms == terms;
        let mut first = None;
        let (mut count, mut outcomes, mut labels) = (0, 0, 0);
        for (row, (computed, mut told)) in self.grasps.iter_mut().zip(told).enumerate() {
            let misfit = misfit(&terms, &self.metadata.terms, &told, computed);
            let Some(misfit) = misfit else {
                if same_terms {
                    told.friction = told.friction.or(computed.friction);
                    told.epsilon = told.epsilon.or(computed.epsilon);
                    *computed = told;
                }
                continue;
            };
            count += 1;
            outcomes += usize::from(computed.stable.is_some());
            labels += usize::from(computed.label_auto.is_some());
            computed.forget_outcome();
            computed.forget_label_of_rule();
            first.get_or_insert((row, misfit));
        }
        self.forget_protocols();
        let grasps = self.grasps.len();
        Ok(
            first.map(|(row, (column, told, computed))| Warning::OtherMeasures {
                count,
                grasps,
                row,
                column,
                told,
                computed,
                outcomes,
                labels,
            }),
        )
    }
}

/// The first column of a row that differs from what was computed, with both values.
fn misfit(
    terms: &[String],
    computed_terms: &[String],
    told: &GraspRow,
    computed: &GraspRow,
) -> Option<(String, String, String)> {
    let measures = |row: &GraspRow, names: &[String]| {
        let terms = names.iter().map(|name| term_column(name));
        let terms = terms.zip(row.terms.iter().copied().map(Some));
        let mut all = vec![("energy".to_owned(), Some(row.energy))];
        all.extend(terms);
        let others = [
            ("net_wrench", Some(row.net_wrench)),
            ("distance_squared", Some(row.distance_squared)),
            ("penetration", Some(row.penetration)),
            ("friction", row.friction),
            ("epsilon", row.epsilon),
        ];
        all.extend(others.map(|(name, value)| (name.to_owned(), value)));
        all
    };
    let found: BTreeMap<String, Option<f64>> =
        measures(computed, computed_terms).into_iter().collect();
    let told = measures(told, terms).into_iter();
    let mut differing = told.filter_map(|(column, told)| {
        let told = told?;
        let found = found.get(&column).copied().flatten();
        let agrees =
            found.is_some_and(|found| (told - found).abs() <= ROUNDING * found.abs().max(1.0));
        (!agrees).then_some((column, told, found))
    });
    let (column, told, found) = differing.next()?;
    let found = found.map_or("nothing".to_owned(), spelled);
    Some((column, spelled(told), found))
}

/// A measure for a message, with five significant digits.
fn spelled(value: f64) -> String {
    match value.abs() {
        size if size != 0.0 && !(1e-3..1e5).contains(&size) => format!("{value:.3e}"),
        _ => format!("{value:.4}"),
    }
}

impl GraspRow {
    /// Computes the energy and the measures. If there are no contacts, the best ones are chosen.
    ///
    /// # Panics
    /// If the pose belongs to another hand than that of the energy.
    pub fn measure(&mut self, energy: &GraspEnergy) -> Judgement {
        let mut grasp = self.grasp.clone();
        // The quaternion is stored as read but measured at unit length.
        let rotation = grasp.pose.rotation_wxyz();
        let norm = rotation.iter().map(|q| q * q).sum::<f64>().sqrt();
        grasp.pose.set_rotation_wxyz(rotation.map(|q| q / norm));
        if grasp.contacts.is_empty() {
            grasp = Grasp::best(energy, grasp.pose);
        }
        let judgement = judge(energy, &grasp);
        self.set_measures(energy, &grasp, &judgement);
        self.grasp.contacts = grasp.contacts;
        judgement
    }

    /// Sets the energy and the measures of a judged grasp.
    pub(crate) fn set_measures(
        &mut self,
        energy: &GraspEnergy,
        grasp: &Grasp,
        judgement: &Judgement,
    ) {
        let terms = energy.terms(&grasp.pose);
        self.terms = terms.into_iter().map(|(_, value)| value).collect();
        self.energy = self.terms.iter().sum();
        self.net_wrench = judgement.net_wrench;
        self.distance_squared = judgement.distance_squared;
        self.penetration = judgement.penetration;
        self.friction = judgement.least_friction;
        self.epsilon = Some(judgement.epsilon);
    }
}
