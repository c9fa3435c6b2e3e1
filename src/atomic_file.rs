//! Files that appear under their name only when they are complete. Temporary names are known only here.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// End of every temporary name.
const ENDING: &str = ".partial";
/// Number of files that this process has begun.
static WRITTEN: AtomicU64 = AtomicU64::new(0);

/// Writes `bytes` to `path`. After any failure, `path` has either its old content or all of `bytes`.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    PendingFile::write(path, bytes)?.finish()
}

/// A complete file on disk under a temporary name in the folder of its final name. It is removed unless
/// [`PendingFile::finish`] is called.
#[derive(Debug)]
pub(crate) struct PendingFile {
    path: PathBuf,
    temporary: PathBuf,
    /// The locked file, which shows other runs that it is in use.
    lock: Option<File>,
}

impl PendingFile {
    /// Writes and syncs `bytes` under a temporary name, and removes temporary files of the same name that killed runs left.
    pub(crate) fn write(path: &Path, bytes: &[u8]) -> io::Result<Self> {
        let name = path
            .file_name()
            .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "this names no file"))?;
        remove_leftovers(path);
        // The process id separates two runs; the number separates two files of one name within a run.
        let number = WRITTEN.fetch_add(1, Ordering::Relaxed);
        let mut temporary = name.to_os_string();
        temporary.push(format!(".{}-{number}{ENDING}", std::process::id()));
        let temporary = path.with_file_name(temporary);
        let mut file = create_locked(&temporary)?;
        let written = file.write_all(bytes).and_then(|()| file.sync_all());
        let pending = Self {
            path: path.to_path_buf(),
            temporary,
            lock: Some(file),
        };
        written.map(|()| pending)
    }

    /// The final name of the file.
    #[cfg(feature = "cli")]
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its final name and replaces the file that had it.
    pub(crate) fn finish(mut self) -> io::Result<()> {
        if cfg!(windows) {
            // Windows cannot rename an open file.
            self.lock = None;
        }
        fs::rename(&self.temporary, &self.path)?;
        self.temporary = PathBuf::new();
        sync_folder(folder_of(&self.path))
    }
}

impl Drop for PendingFile {
    fn drop(&mut self) {
        if self.temporary != Path::new("") {
            self.lock = None;
            // If this fails, the next run removes the file.
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

/// Creates a file and locks it. Another run may take the file for a leftover and remove it before it is locked; then it is
/// created again.
fn create_locked(path: &Path) -> io::Result<File> {
    loop {
        let file = OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(true)
            .open(path)?;
        // A file system without locks cannot distinguish leftovers from files in use, and keeps both.
        let _ = file.lock();
        if path.exists() {
            return Ok(file);
        }
    }
}

/// Removes temporary files of `path` that no running process holds, if permitted.
fn remove_leftovers(path: &Path) {
    let mut start = path.file_name().unwrap_or_default().to_os_string();
    start.push(".");
    for entry in fs::read_dir(folder_of(path))
        .into_iter()
        .flatten()
        .flatten()
    {
        let name = entry.file_name();
        let middle = name
            .as_encoded_bytes()
            .strip_prefix(start.as_encoded_bytes());
        let process = middle.and_then(|middle| middle.strip_suffix(ENDING.as_bytes()));
        let ours = |id: &[u8]| {
            id.first().is_some_and(u8::is_ascii_digit)
                && id.iter().all(|&byte| byte.is_ascii_digit() || byte == b'-')
        };
        if process.is_some_and(ours) {
            let left = path.with_file_name(name);
            let idle = File::open(&left).is_ok_and(|file| file.try_lock().is_ok());
            if idle {
                // Another run may have removed it already.
                let _ = fs::remove_file(&left);
            }
        }
    }
}

/// The folder in which `path` lies.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// Syncs a folder; a rename is on disk only after this.
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    // Other systems cannot open a folder as a file; their file systems journal renames.
    if cfg!(unix) {
        File::open(folder)?.sync_all()
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn what_killed_runs_left_is_removed_and_what_others_write_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let others = ["a.csv.partial", "a.csv.x1.partial", "b.csv.12.partial"];
        for name in others
            .iter()
            .chain(&["a.csv.12.partial", "a.csv.12-3.partial"])
        {
            fs::write(folder.path().join(name), "left").unwrap();
        }
        let held = PendingFile::write(&path, b"held by another").unwrap();
        write(&path, b"whole").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        held.finish().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"held by another");
        let mut expected = vec!["a.csv".to_owned()];
        expected.extend(others.map(str::to_owned));
        assert_eq!(names(folder.path()), expected);
    }

    #[test]
    fn what_is_not_finished_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        drop(PendingFile::write(&folder.path().join("a.csv"), b"x").unwrap());
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
}
