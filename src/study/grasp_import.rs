//! Grasps of other programs: read, completed, and judged on the exact mesh.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;
use serde_json::json;

use super::import_doubt::{Imported, Placed, doubt, doubt_joints};
use super::import_frame::{link_of_poses, root_pose};
use super::{Run, name_of};
use crate::doubt::Doubt;
use crate::grasp::energy::EnergySettingsError;
use crate::grasp::{EnergySettings, Grasp, GraspEnergy, Judgement};
use crate::hand::Hand;
use crate::limits::{Beyond, OBJECT_SCALE};
use crate::space::Pose;
use crate::store::exchange::{LengthUnit, Mapping, Published, files_of, read};
use crate::store::{
    Fault, GraspFile, GraspRow, HandMetadata, Metadata, ObjectMetadata, RebuildError,
    SCHEMA_VERSION, StoreError,
};
use crate::topography::Phase;

/// Relative difference within which scales are the same.
const SAME_SCALE: f64 = 1e-3;

/// Formats that state what the numbers of their rotations are.
const NAMED_ROTATION: [&str; 6] = [
    "DexGraspNet",
    "isaac_grasp",
    "GraspGen",
    "graspqp",
    "MultiDex",
    "DRO-Grasp",
];

/// Settings of [`import_grasps`].
#[derive(Debug, Clone, PartialEq)]
pub struct GraspImportSettings {
    /// The hand of the grasps.
    pub hand: HandMetadata,
    /// The object of the grasps, at scale 1. Of a table that names several objects, only the grasps of this one are read.
    pub object: ObjectMetadata,
    /// Notes on hand and object, which are kept with those on the grasps.
    pub notes: Vec<String>,
    /// Only the grasps at this scale; also the scale of grasps whose file has none, which is 1 by default.
    pub scale: Option<f64>,
    /// Meaning of the columns of a table.
    pub mapping: Mapping,
}

/// Result of [`import_grasps`].
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedGrasps {
    /// The grasps, with contacts, energies and measures. Its metadata lack the command and the hashes of its inputs.
    pub file: GraspFile,
    /// Their judgements, in the order of the rows.
    pub judgements: Vec<Judgement>,
    /// Name of the format.
    pub format: &'static str,
    /// Number of grasps of the object that were found.
    pub found: usize,
    /// Number of grasps that were left out because of a fault.
    pub left_out: usize,
    /// Scales of all grasps of the object that were found.
    pub scales: ScaleCounts,
    /// That the grasps lie beside the object, and the reading of the file that fits, if there is one.
    pub doubt: Option<Doubt>,
    /// Other assumptions, omissions and warnings, one sentence each, sorted.
    pub notes: Vec<String>,
    /// Notes on the object at each scale.
    pub object_notes: Vec<Vec<String>>,
}

/// Scales of an object, smallest first, with their numbers of grasps.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScaleCounts(pub Vec<(f64, usize)>);

impl ScaleCounts {
    /// Counts positive scales.
    pub fn of(scales: impl Iterator<Item = f64>) -> Self {
        // Positive numbers have the same order as their bits.
        let mut counts = BTreeMap::new();
        for scale in scales {
            *counts.entry(scale.to_bits()).or_insert(0) += 1;
        }
        let counts = counts.into_iter();
        Self(
            counts
                .map(|(bits, count)| (f64::from_bits(bits), count))
                .collect(),
        )
    }
}

impl fmt::Display for ScaleCounts {
    /// For instance `0.06 (120), 0.1 (87)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told = self.0.iter();
        let told = told.map(|(scale, count)| format!("{scale} ({count})"));
        f.write_str(&told.collect::<Vec<_>>().join(", "))
    }
}

/// Reason why grasps of another program cannot be imported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GraspImportError {
    /// A file cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The scale of a grasp is out of range.
    #[error("{}, grasp {grasp}: its scale", file.display())]
    Scale {
        /// The file.
        file: PathBuf,
        /// Index of the grasp in the file.
        grasp: usize,
        /// The scale and its limit.
        source: Beyond,
    },
    /// There is nothing to import.
    #[error("{} contains no grasps", .0.display())]
    Empty(PathBuf),
    /// The table has several objects, and none has the given name.
    #[error(
        "the grasps are of {} objects ({}), none of which is called {name}",
        named.len(),
        named.iter().take(4).cloned().collect::<Vec<_>>().join(", ")
    )]
    OtherObjects {
        /// Name of the given object.
        name: String,
        /// The objects of the table.
        named: BTreeSet<String>,
    },
    /// No grasp has the given scale.
    #[error("the grasps are at {0}")]
    OtherScales(ScaleCounts),
    /// The grasps cannot be meant as they were read: they are far from the object, or their joints are beyond all limits.
    #[error("{0}")]
    Implausible(Doubt),
    /// The mapping names a link that the hand does not have.
    #[error("the mapping names link `{link}`, which hand `{hand}` does not have; it has {known}")]
    UnknownLink {
        /// The name in the mapping.
        link: String,
        /// The hand.
        hand: String,
        /// The links of the hand.
        known: String,
    },
    /// Every grasp has a fault.
    #[error("none of the grasps can be used; {source_of_grasp}: {fault}")]
    NoneUsable {
        /// File and index of the first grasp.
        source_of_grasp: String,
        /// Its fault.
        fault: Fault,
    },
    /// The hand or the object cannot be built.
    #[error(transparent)]
    Rebuild(#[from] RebuildError),
    /// The default energy does not suit the hand.
    #[error(transparent)]
    Settings(#[from] EnergySettingsError),
}

/// A grasp with the name of its source.
struct Row {
    /// Index among all grasps read.
    number: u64,
    published: Published,
    source: String,
    scale: f64,
}

/// Reads the grasps at `path`, a file of another program or a folder of `.npy` files, as rows of `grasps.parquet`.
///
/// Grasps that lie implausibly far from the object or in it give a note that names the unit, order, direction or frame that
/// would fit; if they are more than half a metre off, that is an error, unless the mapping states their unit. Grasps that such
/// a file cannot hold are left out: those with joints far beyond their limits, and those with contacts that the hand does not
/// have. Missing contacts are chosen: the best by the default energy. Energies and measures are computed.
///
/// # Errors
/// If a file cannot be read, no grasp is left, or the hand or the object cannot be built.
///
/// # Examples
/// ```no_run
/// use landscape::store::exchange::Mapping;
/// use landscape::study::{GraspImportSettings, Origin, Run, import_grasps};
///
/// let Origin { hand, object, .. } = Origin::named("human", "mug")?;
/// let mapping = Mapping::default();
/// let settings = GraspImportSettings { hand, object, notes: Vec::new(), scale: None, mapping };
/// let imported = import_grasps("mine.csv".as_ref(), &settings, &Run::default())?;
/// println!("{} of {} grasps", imported.file.grasps.len(), imported.found);
/// imported.file.write("mine.parquet".as_ref())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn import_grasps(
    path: &Path,
    settings: &GraspImportSettings,
    run: &Run<'_>,
) -> Result<ImportedGrasps, GraspImportError> {
    let hand = settings.hand.build()?;
    let mut notes: BTreeSet<String> = settings.notes.iter().cloned().collect();
    let files = files_of(path)?;
    let content = rows(&files, settings, &settings.mapping, &hand)?;
    notes.extend(content.notes);
    let format = content.format;
    let rows = content.rows;
    if rows.is_empty() {
        return Err(GraspImportError::Empty(path.to_path_buf()));
    }
    let of_outermost_body = content.of_outermost_body;
    let rows = of_one_object(rows, &settings.object.name)?;
    let found = rows.len();
    let scales = ScaleCounts::of(rows.iter().map(|row| row.scale));
    let rows = at_scale(rows, settings.scale, &scales)?;
    // The doubt is stored, and files record names of files only.
    let subject = name_of(path);
    let imported = Imported {
        subject: subject.clone(),
        hand: &hand,
        object: &settings.object,
        mapping: &settings.mapping,
        named_rotation: NAMED_ROTATION.contains(&format),
        of_outermost_body,
        without_scale: rows.iter().all(|row| row.published.scale.is_none()),
        grasps: placed(&rows),
    };
    let joints = || {
        let poses: Vec<&Pose> = rows.iter().map(|row| &row.published.pose).collect();
        doubt_joints(&subject, &hand, &settings.mapping, &poses)
    };
    let reread = |mapping: &Mapping| {
        let rows = self::rows(&files, settings, mapping, &hand).ok()?.rows;
        let rows = of_one_object(rows, &settings.object.name).ok()?;
        let scales = ScaleCounts::of(rows.iter().map(|row| row.scale));
        Some(placed(&at_scale(rows, settings.scale, &scales).ok()?))
    };
    let mut file = GraspFile {
        metadata: Metadata {
            schema_version: SCHEMA_VERSION,
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            hands: vec![settings.hand.clone()],
            objects: vec![settings.object.clone()],
            energy: super::json(EnergySettings::default()),
            ..Metadata::default()
        },
        grasps: Vec::new(),
    };
    let left_out = fill(&mut file, &rows, &joints, &mut notes)?;
    let doubt = match doubt(&imported, &reread) {
        Some(doubted) if doubted.refused => {
            return Err(GraspImportError::Implausible(doubted.doubt));
        }
        doubted => doubted.map(|doubted| doubted.doubt),
    };
    let mut told = json!({ "format": format });
    let mut kept = notes.clone();
    if let Some(doubt) = &doubt {
        told["doubt"] = json!(doubt.to_string());
        kept.insert(doubt.to_string());
    }
    told["notes"] = json!(kept);
    file.metadata.settings = told;
    let (judgements, object_notes) = complete(&mut file, &hand, run)?;
    notes.extend(file.beyond_limits().map(|warning| warning.to_string()));
    Ok(ImportedGrasps {
        file,
        judgements,
        format,
        found,
        left_out,
        scales,
        doubt,
        notes: notes.into_iter().collect(),
        object_notes,
    })
}

/// The grasps of some files.
#[derive(Default)]
struct Content {
    rows: Vec<Row>,
    notes: BTreeSet<String>,
    format: &'static str,
    of_outermost_body: bool,
}

fn rows(
    files: &[PathBuf],
    settings: &GraspImportSettings,
    mapping: &Mapping,
    hand: &Hand,
) -> Result<Content, GraspImportError> {
    let mut content = Content::default();
    for file in files {
        let read = read(file, hand, mapping)?;
        let link = link_of_poses(mapping, &read, hand, &mut content.notes)?;
        content.format = read.format;
        content.notes.extend(read.notes);
        content.of_outermost_body |= read.of_outermost_body;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        for (grasp, mut published) in read.grasps.into_iter().enumerate() {
            let scale = published.scale.map(tidy);
            let scale = scale.or(settings.scale).unwrap_or(1.0);
            OBJECT_SCALE
                .check(scale)
                .map_err(|source| GraspImportError::Scale {
                    file: file.clone(),
                    grasp,
                    source,
                })?;
            if mapping.translation_unit == Some(LengthUnit::Mesh) {
                let translation_m = published.pose.translation_m().to_vec();
                let [x, y, z] = std::array::from_fn(|axis| scale * translation_m[axis]);
                let rotation = published.pose.rotation_wxyz();
                published.pose = Pose::new([x, y, z], rotation, published.pose.joints());
            }
            if let Some(link) = link {
                published.pose = root_pose(hand, link, &published.pose);
            }
            content.rows.push(Row {
                number: content.rows.len() as u64,
                published,
                source: format!("{name} {grasp}"),
                scale,
            });
        }
    }
    Ok(content)
}

fn placed(rows: &[Row]) -> Vec<Placed> {
    let placed = |row: &Row| Placed {
        pose: row.published.pose.clone(),
        scale: row.scale,
    };
    rows.iter().map(placed).collect()
}

/// The shortest decimal near a scale that was stored as a 32-bit number.
fn tidy(scale: f64) -> f64 {
    let rounded = (scale * 1e6).round() / 1e6;
    if (rounded / scale - 1.0).abs() < 1e-6 {
        rounded
    } else {
        scale
    }
}

/// The grasps of the named object, if the file has several.
fn of_one_object(rows: Vec<Row>, name: &str) -> Result<Vec<Row>, GraspImportError> {
    let named: BTreeSet<String> = rows
        .iter()
        .filter_map(|row| row.published.object.clone())
        .collect();
    if named.len() < 2 {
        return Ok(rows);
    }
    if !named.contains(name) {
        return Err(GraspImportError::OtherObjects {
            name: name.to_owned(),
            named,
        });
    }
    Ok(rows
        .into_iter()
        .filter(|row| row.published.object.as_deref() == Some(name))
        .collect())
}

/// The grasps at the requested scale, or all of them.
fn at_scale(
    rows: Vec<Row>,
    scale: Option<f64>,
    all: &ScaleCounts,
) -> Result<Vec<Row>, GraspImportError> {
    let Some(scale) = scale else {
        return Ok(rows);
    };
    let near = |other: f64| (other / scale - 1.0).abs() < SAME_SCALE;
    if !all.0.iter().any(|(other, _)| near(*other)) {
        return Err(GraspImportError::OtherScales(all.clone()));
    }
    Ok(rows.into_iter().filter(|row| near(row.scale)).collect())
}

/// Fills the file with those rows that it can hold, with their poses and contacts only; returns how many are left out.
/// `doubt` is asked if joints are the reason.
fn fill(
    file: &mut GraspFile,
    rows: &[Row],
    doubt: &dyn Fn() -> Option<Doubt>,
    notes: &mut BTreeSet<String>,
) -> Result<usize, GraspImportError> {
    let ids: Option<Vec<u64>> = rows.iter().map(|row| row.published.id).collect();
    let ids = ids.filter(|ids| ids.iter().collect::<BTreeSet<_>>().len() == ids.len());
    let grasp = |(place, row): (usize, &Row)| GraspRow {
        id: ids.as_ref().map_or(row.number, |ids| ids[place]),
        object: file.metadata.objects[0].name.clone(),
        scale: row.scale,
        hand: file.metadata.hands[0].name.clone(),
        grasp: Grasp {
            pose: row.published.pose.clone(),
            contacts: row.published.contacts.clone().unwrap_or_default(),
        },
        squeeze_joints: row.published.squeeze_joints.clone(),
        label: row.published.label.clone(),
        source: row.source.clone(),
        ..GraspRow::default()
    };
    file.grasps = rows.iter().enumerate().map(grasp).collect();
    let faults = file.faults();
    let bad: BTreeSet<usize> = faults.iter().map(|(row, _)| *row).collect();
    if let Some((row, fault)) = faults.into_iter().next() {
        let source = &rows[row].source;
        let doubt = if matches!(fault, Fault::BeyondLimit { .. }) {
            doubt()
        } else {
            None
        };
        if bad.len() == rows.len() {
            if let Some(doubt) = doubt {
                return Err(GraspImportError::Implausible(doubt));
            }
            return Err(GraspImportError::NoneUsable {
                source_of_grasp: source.clone(),
                fault,
            });
        }
        notes.insert(format!(
            "{} of {} grasps are left out, the first ({source}) because {fault}",
            bad.len(),
            rows.len(),
        ));
        notes.extend(doubt.map(|doubt| doubt.to_string()));
    }
    let mut place = 0;
    file.grasps.retain(|_| {
        place += 1;
        !bad.contains(&(place - 1))
    });
    Ok(bad.len())
}

/// Chooses missing contacts, and fills in energies and measures. Returns the judgements of the rows, and the notes on the
/// object at each scale.
fn complete(
    file: &mut GraspFile,
    hand: &Arc<Hand>,
    run: &Run<'_>,
) -> Result<(Vec<Judgement>, Vec<Vec<String>>), GraspImportError> {
    let tally = run.tally(Phase::Judge, file.grasps.len());
    let mut judgements: Vec<Option<Judgement>> = vec![None; file.grasps.len()];
    let mut notes = Vec::new();
    let ScaleCounts(scales) = ScaleCounts::of(file.grasps.iter().map(|grasp| grasp.scale));
    for (scale, _) in scales {
        let object = file.metadata.objects[0].build(scale)?;
        notes.push(object.notes.clone());
        let energy = GraspEnergy::new(hand.clone(), object, EnergySettings::default())?;
        file.metadata.terms = energy.term_names();
        file.grasps
            .par_iter_mut()
            .zip(&mut judgements)
            .filter(|(grasp, _)| grasp.scale.to_bits() == scale.to_bits())
            .for_each(|(grasp, judgement)| {
                *judgement = Some(grasp.measure(&energy));
                tally.tick();
            });
    }
    Ok((judgements.into_iter().flatten().collect(), notes))
}
