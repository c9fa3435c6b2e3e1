//! Where the files that a description refers to come from.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::mesh;

/// Largest file that is read, bytes.
const LARGEST: u64 = 256 << 20;

/// Finds the files that a description refers to. An error is half a sentence that says what is wrong with the file.
pub(super) trait Files {
    /// The text of an included file.
    fn include(&self, reference: &str) -> Result<String, String>;
    /// A mesh as OBJ text.
    fn mesh(&self, reference: &str) -> Result<String, String>;
}

/// Reads files relative to a folder and remembers those that were asked for.
pub(super) struct Disk {
    /// Canonical path.
    pub(super) folder: PathBuf,
    /// Canonical path; nothing outside it is read.
    pub(super) within: PathBuf,
    /// The texts of the files that were asked for, by reference.
    pub(super) found: RefCell<BTreeMap<String, String>>,
}

impl Disk {
    /// The paths that a reference may mean, best guess first.
    fn places(&self, reference: &str) -> Vec<PathBuf> {
        let Some(rest) = reference.strip_prefix("package://") else {
            let plain = reference.strip_prefix("file://").unwrap_or(reference);
            return vec![self.folder.join(plain)];
        };
        // A reference must not lead out of its package.
        let rest = Path::new(rest);
        if !rest
            .components()
            .all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
        {
            return Vec::new();
        }
        let mut inner = rest.components();
        inner.next();
        let trusted = |folder: &&Path| folder.starts_with(&self.within) || *folder == self.folder;
        (self.folder.ancestors())
            .take_while(trusted)
            .flat_map(|folder| [folder.join(rest), folder.join(inner.as_path())])
            .collect()
    }

    /// The text of a file as `convert` makes it of its bytes and its folder.
    fn remember(
        &self,
        reference: &str,
        convert: impl FnOnce(Vec<u8>, &Path) -> Result<String, String>,
    ) -> Result<String, String> {
        if let Some(text) = self.found.borrow().get(reference) {
            return Ok(text.clone());
        }
        let places = self.places(reference);
        let path = places.iter().find(|path| path.is_file());
        let Some(path) = path.or(places.first()) else {
            return Err("a package:// path must name a file inside its package".to_owned());
        };
        let unreadable = |error: String| format!("cannot read {}: {error}", path.display());
        let path = fs::canonicalize(path).map_err(|error| unreadable(error.to_string()))?;
        if !path.starts_with(&self.within) {
            return Err(format!(
                "it lies outside {}: put it there, or name a folder that contains all files of the hand (--hand-folder)",
                self.within.display()
            ));
        }
        let bytes = bytes(&path).map_err(unreadable)?;
        let text = convert(bytes, path.parent().unwrap_or(&self.folder))?;
        self.found
            .borrow_mut()
            .insert(reference.to_owned(), text.clone());
        Ok(text)
    }
}

impl Files for Disk {
    fn include(&self, reference: &str) -> Result<String, String> {
        self.remember(reference, |bytes, _| text_of(bytes))
    }

    fn mesh(&self, reference: &str) -> Result<String, String> {
        self.remember(reference, |bytes, folder| {
            mesh::to_obj(reference, &bytes, folder)
        })
    }
}

/// Bytes as text.
pub(super) fn text_of(bytes: Vec<u8>) -> Result<String, String> {
    String::from_utf8(bytes).map_err(|error| {
        let place = error.utf8_error().valid_up_to();
        format!("it is not a text file, which URDF and MJCF files are (byte {place} is not UTF-8)")
    })
}

/// The bytes of a file that is not too large. An error is half a sentence.
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>, String> {
    let told = fs::metadata(path).map_err(|error| error.to_string())?;
    if !told.is_file() {
        return Err("it is not a file".to_owned());
    }
    if told.len() > LARGEST {
        return Err(format!("it is larger than {} MB", LARGEST >> 20));
    }
    fs::read(path).map_err(|error| error.to_string())
}
