//! The files that describe a hand: the description, its side file and the files they refer to.

use std::cell::RefCell;
use std::fs;
use std::path::{Path, PathBuf};

use super::geometry::Geometry;
use super::model::Model;
use super::side_file::SideFile;
use super::sources::{Disk, Files, bytes, text_of};
use super::{HandError, loops, mano, mjcf, plausibility, side_file, urdf};
use crate::formats::{ending, lfs_pointer};

/// A file, under the name by which the description refers to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HandFile {
    /// Name. The description and the side file have no folder in their names; other files are named as in the reference.
    pub name: String,
    /// Its text; meshes are converted to OBJ.
    pub text: String,
}

/// All files of a hand: first the description, then the side file (`.json`) if there is one, then included files and
/// meshes.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HandFiles {
    /// The files.
    pub files: Vec<HandFile>,
}

impl HandFiles {
    /// As [`HandFiles::load_within`], where all files must lie in the folder of `path`.
    ///
    /// # Errors
    /// As [`HandFiles::load_within`].
    pub fn load(path: &Path) -> Result<Self, HandError> {
        Self::load_within(path, &folder_of(path))
    }

    /// Reads the URDF or MJCF file at `path`, the JSON side file of the same stem if there is one, and every file
    /// these refer to: meshes (OBJ, STL, PLY, glTF, COLLADA, MSH) and included files. References are relative to the folder of `path`.
    /// `package://name/…` is looked for in that folder and in those above it up to `within`, with and without the
    /// folder `name`.
    ///
    /// Files outside the folder `within` are refused, also if a link leads to them: a description of unknown origin
    /// must not read any file of the disk.
    ///
    /// # Errors
    /// If a file cannot be read or does not describe a hand; the message names the file, the element and what to do.
    pub fn load_within(path: &Path, within: &Path) -> Result<Self, HandError> {
        refuse_other(path)?;
        let text = if mano::is_archive(path) {
            mano::description(
                path,
                &bytes(path).map_err(|problem| HandError::File {
                    path: path.to_owned(),
                    problem,
                })?,
            )?
        } else {
            read(path)?
        };
        let name = |path: &Path| {
            let name = path.file_name().unwrap_or_default();
            name.to_string_lossy().into_owned()
        };
        let mut files = vec![HandFile {
            name: name(path),
            text,
        }];
        let beside = path.with_extension("json");
        if beside.exists() && beside != path {
            files.push(HandFile {
                name: name(&beside),
                text: read(&beside)?,
            });
        }
        let whole = |folder: &Path| {
            fs::canonicalize(folder).map_err(|error| HandError::File {
                path: folder.to_owned(),
                problem: error.to_string(),
            })
        };
        let disk = Disk {
            folder: whole(&folder_of(path))?,
            within: whole(within)?,
            found: RefCell::default(),
        };
        let given = Self {
            files: files.clone(),
        };
        if given.mano().is_some() {
            return Ok(given);
        }
        Geometry::check_meshes(&given.model(&disk)?, &given.side()?)?;
        let found = disk.found.into_inner().into_iter();
        files.extend(found.map(|(name, text)| HandFile { name, text }));
        Ok(Self { files })
    }

    /// Files with these names and texts, the description first.
    pub fn of_texts<'a>(files: impl IntoIterator<Item = [&'a str; 2]>) -> Self {
        let file = |[name, text]: [&str; 2]| HandFile {
            name: name.to_owned(),
            text: text.to_owned(),
        };
        Self {
            files: files.into_iter().map(file).collect(),
        }
    }

    /// The files of the mirror image, which differ in the entry `mirror` of the side file.
    ///
    /// # Errors
    /// If the side file cannot be read.
    pub fn mirrored(&self) -> Result<Self, HandError> {
        let mut files = self.clone();
        let side = self.side_place();
        let text = side.map_or("{}", |place| self.files[place].text.as_str());
        let mut value: serde_json::Value = serde_json::from_str(text)?;
        let already = self.side()?.mirror;
        if let Some(entries) = value.as_object_mut() {
            entries.insert("mirror".to_owned(), (!already).into());
        }
        let text = serde_json::to_string_pretty(&value)?;
        if let Some(place) = side {
            files.files[place].text = text;
        } else {
            let name = Path::new(self.files.first().map_or("hand", |main| main.name.as_str()));
            let name = name.with_extension("json").to_string_lossy().into_owned();
            let place = files.files.len().min(1);
            files.files.insert(place, HandFile { name, text });
        }
        Ok(files)
    }

    /// The texts that identify these files. For a MANO hand the hash of its file replaces the path to the user's copy.
    pub fn identity(&self) -> Vec<String> {
        let texts = self.files.iter().map(|file| file.text.clone());
        let mut texts: Vec<String> = texts.collect();
        if let (Some(main), Some(mano)) = (texts.first_mut(), self.mano()) {
            mano.hash().clone_into(main);
        }
        texts
    }

    fn side_place(&self) -> Option<usize> {
        let place = self.files.iter().skip(1).position(|file| {
            let kind = Path::new(&file.name).extension();
            kind.is_some_and(|kind| kind.eq_ignore_ascii_case("json"))
        })?;
        Some(place + 1)
    }

    pub(super) fn side(&self) -> Result<SideFile, HandError> {
        side_file::parse(
            self.side_place()
                .map(|place| self.files[place].text.as_str()),
        )
    }

    /// The reference to a MANO file, if the description is one.
    pub(super) fn mano(&self) -> Option<mano::Reference> {
        mano::reference(&self.files.first()?.text)
    }

    pub(super) fn model(&self, files: &dyn Files) -> Result<Model, HandError> {
        let main = self.files.first().ok_or(HandError::NoDescription)?;
        let mut model = if mjcf::is_mjcf(&main.text) {
            mjcf::read(&main.name, &main.text, files)?
        } else {
            urdf::read(&main.name, &main.text, files)?
        };
        model.remove(&self.side()?.without)?;
        model.fold_virtual_wrist();
        plausibility::judge_joints(&mut model)?;
        model.check_limits()?;
        loops::close(&mut model)?;
        Ok(model)
    }
}

impl Files for HandFiles {
    fn include(&self, reference: &str) -> Result<String, String> {
        let file = self.files.iter().find(|file| file.name == reference);
        file.map(|file| file.text.clone())
            .ok_or_else(|| "it is not among the files of the hand".to_owned())
    }

    fn mesh(&self, reference: &str) -> Result<String, String> {
        self.include(reference)
    }
}

fn folder_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    folder.unwrap_or(Path::new(".")).to_owned()
}

/// Refuses formats of robots and scenes that are not read, by the ending of the file.
fn refuse_other(path: &Path) -> Result<(), HandError> {
    let (format, remedy) = match ending(path).as_str() {
        "usd" | "usda" | "usdc" | "usdz" => ("USD", "export the hand as URDF or MJCF"),
        "sdf" => ("SDF", "give the URDF or MJCF of the hand"),
        "mjb" => (
            "MuJoCo's binary format",
            "save the model as MJCF (mj_saveLastXML)",
        ),
        _ => return Ok(()),
    };
    Err(HandError::OtherFormat {
        file: path.display().to_string(),
        format,
        remedy: remedy.to_owned(),
    })
}

fn read(path: &Path) -> Result<String, HandError> {
    let problem = |problem: String| HandError::File {
        path: path.to_owned(),
        problem,
    };
    let bytes = bytes(path).map_err(problem)?;
    if lfs_pointer(&bytes) {
        let told =
            "it is a Git LFS pointer in place of the file: run `git lfs pull` in its repository";
        return Err(problem(told.to_owned()));
    }
    text_of(bytes).map_err(problem)
}
