//! Files and folders that take their final name only when they are complete.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use super::error::StoreError;
use crate::atomic_file::{self, PendingFile, folder_of, sync_folder};

/// Name of the journal in an unfinished folder. It is removed when the folder is complete.
pub const JOURNAL: &str = "journal";

/// Marks a folder as made by this program before it has a manifest.
const MARKER: &str = ".unfinished";
const MARKER_TEXT: &[u8] =
    b"landscape is writing this folder; it takes its final name when it is complete.\n";
const MANIFEST: &str = "landscape.json";

/// Writes `bytes` to `path`: under a temporary name in the same folder, flushed to disk, then renamed. At every moment
/// `path` has either its previous content or all of `bytes`. Remains of killed runs for the same file are removed.
///
/// # Errors
/// If the folder does not exist or cannot be written. The temporary file is then removed.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    named(path)?;
    atomic_file::write(path, bytes).map_err(StoreError::io("write", path))
}

/// A set of files that belong together. All are written under temporary names before the first one takes its final name.
/// Without [`FileSet::finish`] all are removed.
///
/// Only a crash between the renames themselves, which take microseconds, can leave a mixture of new and old files.
#[derive(Debug, Default)]
pub struct FileSet {
    files: Vec<PendingFile>,
}

impl FileSet {
    /// Writes one more file of the set under a temporary name.
    ///
    /// # Errors
    /// As [`write_atomic`], or if a folder has this name.
    pub fn add(&mut self, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
        named(path)?;
        if path.is_dir() {
            return Err(StoreError::NotOurs(path.to_path_buf()));
        }
        let file = PendingFile::write(path, bytes).map_err(StoreError::io("write", path))?;
        self.files.push(file);
        Ok(())
    }

    /// Renames all files to their final names.
    ///
    /// # Errors
    /// If a rename fails.
    pub fn finish(self) -> Result<(), StoreError> {
        for file in self.files {
            let path = file.path().to_path_buf();
            file.finish().map_err(StoreError::io("write", &path))?;
        }
        Ok(())
    }
}

/// Refuses paths without a file name, such as `/`.
fn named(path: &Path) -> Result<&OsStr, StoreError> {
    path.file_name()
        .ok_or_else(|| StoreError::NoName(path.to_path_buf()))
}

/// A folder that is written as `X.partial` and becomes `X` when it is complete.
///
/// At every moment, `X` is absent, the previous complete folder, or the new complete folder. Between two renames of
/// [`AtomicFolder::finish`] the previous folder is called `X.old.partial`; the next [`AtomicFolder::open`] restores it. The
/// journal is removed last, so that a run killed at any moment is complete or can be resumed.
#[derive(Debug)]
pub struct AtomicFolder {
    finished: PathBuf,
    partial: PathBuf,
}

impl AtomicFolder {
    /// Starts the folder that will be called `finished`, or resumes it if an earlier run was interrupted. Only the
    /// [`JOURNAL`] of the unfinished folder is kept; with `fresh` nothing is kept.
    ///
    /// # Errors
    /// If a file or folder that landscape did not make has one of the names, another process holds the lock of the journal,
    /// or the place cannot be written.
    pub fn open(finished: &Path, fresh: bool) -> Result<Self, StoreError> {
        let folder = Self {
            finished: finished.to_path_buf(),
            partial: sibling(finished, ".partial")?,
        };
        refuse_foreign(&folder.finished)?;
        refuse_foreign(&folder.partial)?;
        let old = folder.old()?;
        refuse_foreign(&old)?;
        let journals = folder.journals();
        for journal in &journals {
            refuse_in_use(journal)?;
        }
        if old.exists() {
            if folder.finished.exists() {
                remove_ours(&old)?;
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
        if let Err(error) = folder.write(MARKER, MARKER_TEXT) {
            // On a full disk. What is not empty stays.
            let _ = fs::remove_dir(&folder.partial);
            return Err(error);
        }
        // The run was killed after the renaming, before the journal was removed. The journal lets the same command finish
        // at once.
        let [kept, left] = &journals;
        if left.exists() && !kept.exists() && !fresh {
            fs::rename(left, kept).map_err(StoreError::io("rename", left))?;
        } else {
            remove(left)?;
        }
        Ok(folder)
    }

    /// The journal of an interrupted run of the folder called `finished`, if there is one.
    pub fn left_journal(finished: &Path) -> Option<PathBuf> {
        let folder = Self {
            finished: finished.to_path_buf(),
            partial: sibling(finished, ".partial").ok()?,
        };
        let journals = folder.journals();
        journals.into_iter().find(|journal| journal.is_file())
    }

    /// Possible places of a journal: in the unfinished folder, and briefly in the finished one.
    fn journals(&self) -> [PathBuf; 2] {
        [self.partial.join(JOURNAL), self.finished.join(JOURNAL)]
    }

    /// Path of the unfinished folder.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Path of its journal.
    pub fn journal(&self) -> PathBuf {
        self.partial.join(JOURNAL)
    }

    /// Writes one file of the folder atomically.
    ///
    /// # Errors
    /// See [`write_atomic`].
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
        write_atomic(&self.partial.join(name), bytes)
    }

    /// Removes the unfinished folder.
    ///
    /// # Errors
    /// If it cannot be removed.
    pub fn discard(self) -> Result<(), StoreError> {
        remove_ours(&self.partial)
    }

    /// Renames the folder to its final name, replacing a previous folder of that name, and returns the path. The journal is
    /// removed afterwards, because until then the run can be resumed from it.
    ///
    /// # Errors
    /// If the folder has no manifest, or if a rename fails. A previous folder is then restored.
    pub fn finish(self) -> Result<PathBuf, StoreError> {
        if !has_manifest(&self.partial) {
            return Err(StoreError::Unfinished(self.partial));
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
        // Now the previous folder can be removed, and then the journal.
        remove_ours(&old)?;
        for name in [MARKER, JOURNAL] {
            remove(&self.finished.join(name))?;
        }
        Ok(self.finished)
    }

    fn old(&self) -> Result<PathBuf, StoreError> {
        sibling(&self.finished, ".old.partial")
    }
}

/// `path` with `suffix` added to its name.
fn sibling(path: &Path, suffix: &str) -> Result<PathBuf, StoreError> {
    let mut name = named(path)?.to_os_string();
    name.push(suffix);
    Ok(path.with_file_name(name))
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

/// Removes a folder of this program. Its marker and manifest go last, so that a run killed here does not block the next.
fn remove_ours(folder: &Path) -> Result<(), StoreError> {
    if !folder.exists() {
        return Ok(());
    }
    for name in names_in(folder)? {
        if name != MANIFEST && name != MARKER {
            remove(&folder.join(name))?;
        }
    }
    for name in [MANIFEST, MARKER] {
        remove(&folder.join(name))?;
    }
    fs::remove_dir(folder).map_err(StoreError::io("remove", folder))
}

/// Refuses a journal that is locked by a running process.
fn refuse_in_use(journal: &Path) -> Result<(), StoreError> {
    match File::open(journal).map(|file| file.try_lock()) {
        Ok(Err(TryLockError::WouldBlock)) => Err(StoreError::InUse(journal.to_path_buf())),
        // Other errors are reported when the journal is read.
        _ => Ok(()),
    }
}

/// Refuses anything that exists, unless it is an empty folder or one of this program.
fn refuse_foreign(path: &Path) -> Result<(), StoreError> {
    let foreign = match fs::symlink_metadata(path) {
        Err(_) => false,
        Ok(metadata) if metadata.is_dir() => {
            // A run that was killed while it wrote the marker leaves it under its temporary name.
            let marker = |name: &OsString| name.as_encoded_bytes().starts_with(MARKER.as_bytes());
            !(has_manifest(path) || names_in(path)?.iter().all(marker) || has_marker(path))
        }
        Ok(_) => true,
    };
    if foreign {
        Err(StoreError::NotOurs(path.to_path_buf()))
    } else {
        Ok(())
    }
}

fn has_marker(folder: &Path) -> bool {
    folder.join(MARKER).is_file()
}

fn has_manifest(folder: &Path) -> bool {
    fs::read(folder.join(MANIFEST))
        .ok()
        .and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok())
        .is_some_and(|manifest| manifest["format"] == "landscape")
}
