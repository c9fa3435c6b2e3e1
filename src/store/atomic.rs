//! Files and folders that appear under their name only when they are complete.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::error::StoreError;

/// Name of the journal in an unfinished folder; removed when the folder is complete.
pub const JOURNAL: &str = "journal";

/// Tells a folder of ours apart before it has a manifest.
const MARKER: &str = ".unfinished";
const MARKER_TEXT: &[u8] =
    b"landscape is writing this folder; it takes its final name when it is complete.\n";
const MANIFEST: &str = "landscape.json";

/// Writes `bytes` to `path`: under a temporary name in the same folder, flushed to disk, then renamed. Whatever happens
/// on the way, `path` holds either what it held before or all of `bytes`.
///
/// # Errors
/// If the folder does not exist or cannot be written; the temporary file is removed.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    // The process id keeps two runs apart; within a run nobody writes one file twice at a time.
    let temporary = sibling(path, &format!(".{}.partial", std::process::id()))?;
    let written = File::create(&temporary)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&temporary, path))
        .and_then(|()| sync_folder(folder_of(path)));
    written.map_err(|source| {
        let _ = fs::remove_file(&temporary);
        StoreError::Io {
            action: "write",
            path: path.to_path_buf(),
            source,
        }
    })
}

/// A folder that grows as `X.partial` and becomes `X` when it is complete.
///
/// At every moment, `X` is absent, or the previous complete folder, or the new complete folder (between two renames of
/// [`AtomicFolder::finish`] the previous one is called `X.old.partial`; the next [`AtomicFolder::open`] sets that right).
#[derive(Debug)]
pub struct AtomicFolder {
    finished: PathBuf,
    partial: PathBuf,
}

impl AtomicFolder {
    /// Starts the folder that will be called `finished`, or resumes it if an earlier run was interrupted: of the
    /// unfinished folder only its [`JOURNAL`] is kept, and with `fresh` not even that.
    ///
    /// # Errors
    /// If something that landscape did not make has one of the names, or the place cannot be written.
    pub fn open(finished: &Path, fresh: bool) -> Result<Self, StoreError> {
        let folder = Self {
            finished: finished.to_path_buf(),
            partial: sibling(finished, ".partial")?,
        };
        refuse_foreign(&folder.finished)?;
        refuse_foreign(&folder.partial)?;
        let old = folder.old()?;
        refuse_foreign(&old)?;
        if old.exists() {
            if folder.finished.exists() {
                fs::remove_dir_all(&old).map_err(StoreError::io("remove", &old))?;
            } else {
                fs::rename(&old, &folder.finished).map_err(StoreError::io("rename", &old))?;
            }
        }
        if folder.partial.exists() {
            for name in names_in(&folder.partial)? {
                if name != MARKER && (fresh || name != JOURNAL) {
                    remove(&folder.partial.join(name))?;
                }
            }
        } else {
            fs::create_dir(&folder.partial).map_err(StoreError::io("create", &folder.partial))?;
        }
        folder.write(MARKER, MARKER_TEXT)?;
        Ok(folder)
    }

    /// Where the folder grows.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Where its journal is.
    pub fn journal(&self) -> PathBuf {
        self.partial.join(JOURNAL)
    }

    /// Writes one file of the folder, complete or not at all.
    ///
    /// # Errors
    /// See [`write_atomic`].
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
        write_atomic(&self.partial.join(name), bytes)
    }

    /// Removes the unfinished folder: there will be nothing to finish.
    ///
    /// # Errors
    /// If it cannot be removed.
    pub fn discard(self) -> Result<(), StoreError> {
        fs::remove_dir_all(&self.partial).map_err(StoreError::io("remove", &self.partial))
    }

    /// Gives the folder its final name and returns it; a previous folder of that name is replaced.
    ///
    /// # Errors
    /// If the folder has no manifest, or a rename is refused (a previous folder is then put back).
    pub fn finish(self) -> Result<PathBuf, StoreError> {
        if !has_manifest(&self.partial) {
            return Err(StoreError::Unfinished { path: self.partial });
        }
        refuse_foreign(&self.finished)?;
        sync_folder(&self.partial).map_err(StoreError::io("write", &self.partial))?;
        let old = self.old()?;
        let replaces = self.finished.exists();
        if replaces {
            fs::rename(&self.finished, &old).map_err(StoreError::io("rename", &self.finished))?;
        }
        if let Err(source) = fs::rename(&self.partial, &self.finished) {
            if replaces {
                fs::rename(&old, &self.finished).map_err(StoreError::io("rename", &old))?;
            }
            return Err(StoreError::Io {
                action: "rename",
                path: self.partial,
                source,
            });
        }
        let parent = folder_of(&self.finished);
        sync_folder(parent).map_err(StoreError::io("write", parent))?;
        // Only now is the journal dispensable, and the previous folder too.
        for name in [JOURNAL, MARKER] {
            remove(&self.finished.join(name))?;
        }
        remove(&old)?;
        Ok(self.finished)
    }

    fn old(&self) -> Result<PathBuf, StoreError> {
        sibling(&self.finished, ".old.partial")
    }
}

/// `path` with `suffix` added to its name.
fn sibling(path: &Path, suffix: &str) -> Result<PathBuf, StoreError> {
    let mut name = path
        .file_name()
        .ok_or_else(|| StoreError::NoName {
            path: path.to_path_buf(),
        })?
        .to_os_string();
    name.push(suffix);
    Ok(path.with_file_name(name))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// A rename is on disk only when its folder is.
fn sync_folder(folder: &Path) -> std::io::Result<()> {
    // Elsewhere a folder cannot be opened as a file, and renames are journalled by the file system.
    if cfg!(unix) {
        File::open(folder)?.sync_all()
    } else {
        Ok(())
    }
}

fn names_in(folder: &Path) -> Result<Vec<OsString>, StoreError> {
    let entries = fs::read_dir(folder).map_err(StoreError::io("read", folder))?;
    let names = entries.map(|entry| Ok(entry?.file_name()));
    names
        .collect::<std::io::Result<_>>()
        .map_err(StoreError::io("read", folder))
}

fn remove(path: &Path) -> Result<(), StoreError> {
    let removed = match fs::symlink_metadata(path) {
        Ok(metadata) if metadata.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
        Err(_) => return Ok(()),
    };
    removed.map_err(StoreError::io("remove", path))
}

/// Refuses anything that exists and is neither an empty folder nor one of ours.
fn refuse_foreign(path: &Path) -> Result<(), StoreError> {
    let foreign = match fs::symlink_metadata(path) {
        Err(_) => false,
        Ok(metadata) if metadata.is_dir() => {
            !(has_manifest(path) || path.join(MARKER).is_file() || names_in(path)?.is_empty())
        }
        Ok(_) => true,
    };
    if foreign {
        Err(StoreError::NotOurs {
            path: path.to_path_buf(),
        })
    } else {
        Ok(())
    }
}

fn has_manifest(folder: &Path) -> bool {
    fs::read(folder.join(MANIFEST))
        .ok()
        .and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok())
        .is_some_and(|manifest| manifest["format"] == "landscape")
}
