//! The files of a data set, and the populations in them.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use walkdir::{DirEntry, WalkDir};

use super::Survey;
use crate::cli::printing::sentence;
use crate::cli::{input, progress};
use crate::store::{GraspFile, HandMetadata, Population, content_hash};
use crate::study::SurveyFailure;

/// A file of grasps.
#[derive(Debug, Clone)]
pub(super) struct DataFile {
    pub(super) path: PathBuf,
    /// Its path within the folder that was given, or its name.
    pub(super) name: String,
}

/// One population of a file.
#[derive(Debug, Clone)]
pub(super) struct Task {
    /// Its number in the survey.
    pub(super) number: usize,
    /// Index of the file.
    pub(super) file: usize,
    /// Its place among the populations of the file.
    pub(super) place: usize,
    /// Name of the population, unique in the survey.
    pub(super) name: String,
    /// Hash of its hand, object and poses.
    pub(super) grasps: String,
}

/// What is to be surveyed.
#[derive(Debug, Default)]
pub(super) struct Plan {
    pub(super) files: Vec<DataFile>,
    /// Hashes of the contents of the files.
    pub(super) hashes: Vec<String>,
    pub(super) tasks: Vec<Task>,
    pub(super) failures: Vec<SurveyFailure>,
    /// Populations that are left out because another file holds the same grasps.
    pub(super) repeated: Vec<String>,
    /// What was noted when the files and the descriptions of their hands were read.
    pub(super) noted: Vec<String>,
}

/// All files of grasps that the arguments name. Folders are searched for files with the ending `.parquet`.
pub(super) fn data_files(given: &[PathBuf]) -> anyhow::Result<Vec<DataFile>> {
    let mut files = Vec::new();
    for path in given {
        if !path.is_dir() {
            ensure!(path.is_file(), "no such file or folder: {}", path.display());
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            files.push(DataFile {
                path: path.clone(),
                name: name.into_owned(),
            });
            continue;
        }
        let before = files.len();
        let walk = WalkDir::new(path).follow_links(true).sort_by_file_name();
        let walk = walk
            .into_iter()
            .filter_entry(|entry| entry.depth() == 0 || !made_of_grasps(entry));
        for entry in walk {
            let entry =
                entry.with_context(|| format!("cannot read the folder {}", path.display()))?;
            if entry.file_type().is_file()
                && entry.path().extension() == Some(OsStr::new("parquet"))
            {
                let within = entry.path().strip_prefix(path).unwrap_or(entry.path());
                files.push(DataFile {
                    path: entry.path().to_path_buf(),
                    name: slashes(within),
                });
            }
        }
        ensure!(
            files.len() > before,
            "{}: the folder contains no file with the ending .parquet: `landscape import` makes such files of grasps of other \
             programs",
            path.display()
        );
    }
    Ok(files)
}

/// Whether this is a folder that the program made of grasps: a landscape, a survey, or what a run has left.
fn made_of_grasps(entry: &DirEntry) -> bool {
    let path = entry.path();
    entry.file_type().is_dir()
        && (path.extension() == Some(OsStr::new("partial"))
            || path.join("landscape.json").is_file()
            || path.join("survey.json").is_file()
            || path.join(super::LANDSCAPES).is_dir())
}

fn slashes(path: &Path) -> String {
    let parts = path.iter().map(|part| part.to_string_lossy());
    parts.collect::<Vec<_>>().join("/")
}

impl Plan {
    /// Reads all files. Those that cannot be read are failures.
    pub(super) fn of(command: &Survey, quiet: bool) -> anyhow::Result<Self> {
        let mut plan = Self {
            files: data_files(&command.sets)?,
            ..Self::default()
        };
        let mut seen: BTreeMap<String, String> = BTreeMap::new();
        let mut names: BTreeMap<String, PathBuf> = BTreeMap::new();
        let bar = progress::bar("reading files", plan.files.len() as u64, quiet);
        for index in 0..plan.files.len() {
            bar.inc(1);
            let data = plan.files[index].clone();
            let (file, hash, warnings) = match read(&data, command) {
                Ok(read) => read,
                Err(reason) => {
                    plan.hashes.push(String::new());
                    plan.failures.push(SurveyFailure {
                        file: data.name,
                        reason: sentence(&reason),
                    });
                    continue;
                }
            };
            plan.hashes.push(hash);
            let of_hands: Vec<String> =
                (file.metadata.hands.iter().flat_map(HandMetadata::warnings)).collect();
            // What is noted of a hand is the same for all of its files.
            plan.noted.extend(warnings.into_iter().map(|warning| {
                if of_hands.contains(&warning) {
                    warning
                } else {
                    format!("{}: {warning}", data.name)
                }
            }));
            let populations = file.landscapes();
            for (place, population) in populations.iter().enumerate() {
                let name = name(&data, population, populations.len() > 1);
                let grasps = hash_of(population)?;
                if let Some(other) = seen.get(&grasps) {
                    plan.repeated.push(format!(
                        "{name} contains the same grasps as {other} and is left out"
                    ));
                    continue;
                }
                if let Some(other) = names.insert(name.clone(), data.path.clone()) {
                    anyhow::bail!(
                        "{} and {} have the same name: give the folder that contains both instead",
                        other.display(),
                        data.path.display()
                    );
                }
                seen.insert(grasps.clone(), name.clone());
                plan.tasks.push(Task {
                    number: plan.tasks.len(),
                    file: index,
                    place,
                    name,
                    grasps,
                });
            }
        }
        bar.finish_and_clear();
        Ok(plan)
    }
}

/// A file as the flags change it, the hash of its bytes, and warnings.
pub(super) fn read(
    data: &DataFile,
    command: &Survey,
) -> anyhow::Result<(GraspFile, String, Vec<String>)> {
    let (hand, object) = (command.of.hand.as_deref(), command.of.object.as_deref());
    let (mut file, warnings) = input::read(&data.path, hand, object)?;
    if command.only_stable {
        super::keep_stable(&mut file, &data.path)?;
    }
    let bytes = std::fs::read(&data.path)
        .with_context(|| format!("cannot read {}", data.path.display()))?;
    Ok((file, content_hash(&[&bytes]), warnings))
}

fn name(data: &DataFile, population: &Population<'_>, several: bool) -> String {
    let stem = data.name.strip_suffix(".parquet").unwrap_or(&data.name);
    if several {
        format!(
            "{stem}.{}.{}.{}",
            population.hand.name, population.object.name, population.scale
        )
    } else {
        stem.to_owned()
    }
}

/// Hash of the hand, the object and the poses of a population, whatever else is known of them.
fn hash_of(population: &Population<'_>) -> anyhow::Result<String> {
    let mut bytes = serde_json::to_vec(&(population.hand, population.object, population.scale))?;
    for row in &population.grasps {
        let pose = row.grasp.pose.to_vec();
        bytes.extend(pose.iter().flat_map(|number| number.to_le_bytes()));
    }
    Ok(content_hash(&[&bytes]))
}
