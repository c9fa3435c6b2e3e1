//! What takes long and depends only on its inputs, kept in the user's cache folder under a hash of these inputs.
//!
//! The cache cannot fail. A file that is missing, damaged, or of other inputs counts as not there, and the work is done
//! again. If the folder cannot be written, nothing is kept. Beyond a limit, the files that were used longest ago are removed.
//! Several processes may use one folder: files appear when they are complete, and a file that another process has removed is
//! made again.

use std::fs::{self, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use nalgebra::Vector3;

use crate::atomic_file;

/// Largest size of all files, bytes. A field of an object has up to 20 million.
const MOST_BYTES: u64 = 1_000_000_000;
/// Digits of a key in the name of a file.
const KEY_DIGITS: usize = 32;

/// What is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Smooth fields of objects.
    Field,
    /// Objects cut into convex pieces.
    Pieces,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 2] = [Self::Field, Self::Pieces];

    /// The folder of the kind in that of the cache.
    fn folder(self) -> &'static str {
        match self {
            Self::Field => "fields",
            Self::Pieces => "pieces",
        }
    }

    /// The ending of its files.
    fn ending(self) -> &'static str {
        match self {
            Self::Field => ".field",
            Self::Pieces => ".pieces",
        }
    }

    /// The first bytes of its files.
    fn mark(self) -> [u8; 8] {
        match self {
            Self::Field => *b"LSFIELD\n",
            Self::Pieces => *b"LSPIECE\n",
        }
    }
}

/// 128-bit FNV-1a hash of inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key(u128);

impl Default for Key {
    fn default() -> Self {
        Self(0x6c62272e07bb014262b821756295c58d)
    }
}

impl Key {
    /// Adds an input.
    pub fn feed(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u128::from(byte)).wrapping_mul(0x0000000001000000000000000000013b);
        }
    }
}

/// The files of a cache.
#[derive(Debug, Clone, PartialEq)]
pub struct Cache {
    /// The folder; `None` if there is none, so that nothing is kept.
    pub folder: Option<PathBuf>,
    /// Largest size of all files, bytes.
    pub most_bytes: u64,
}

/// A file of a cache.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// What it holds.
    pub kind: Kind,
    /// Its path.
    pub path: PathBuf,
    /// Its size, bytes.
    pub bytes: u64,
    /// When it was used last.
    used: SystemTime,
}

impl Cache {
    /// The cache of the user: `landscape` in the system's folder for caches, of at most 1 GB.
    pub fn of_user() -> Self {
        Self {
            folder: user_folder(),
            most_bytes: MOST_BYTES,
        }
    }

    /// The content that was kept under `key`.
    pub fn find(&self, kind: Kind, key: Key) -> Option<Vec<u8>> {
        let path = self.path(kind, key)?;
        // Other kinds are refused: opening a pipe waits for its writer, and a device may never end.
        fs::metadata(&path).ok().filter(fs::Metadata::is_file)?;
        let mut bytes = fs::read(&path).ok()?;
        let content = unpacked(&bytes, kind, key)?.len();
        // The time of a file is that of its last use. If it cannot be changed, the file counts as old.
        let _ = (OpenOptions::new().append(true).open(&path))
            .and_then(|file| file.set_modified(SystemTime::now()));
        bytes.truncate(HEAD + content);
        bytes.drain(..HEAD);
        Some(bytes)
    }

    /// Keeps `content` under `key`, and removes the files that were used longest ago if the limit is exceeded.
    pub fn keep(&self, kind: Kind, key: Key, content: &[u8]) {
        let Some(path) = self.path(kind, key) else {
            return;
        };
        let folder = atomic_file::folder_of(&path);
        // Two processes that keep the same write the same bytes. If the folder cannot be written, nothing is kept.
        let written = fs::create_dir_all(folder)
            .and_then(|()| atomic_file::write(&path, &packed(content, kind, key)));
        if written.is_ok() {
            self.shrink(&path);
        }
    }

    /// The files, those used longest ago first. Temporary files of killed processes count.
    pub fn files(&self) -> Vec<Kept> {
        let mut files = Vec::new();
        for (kind, folder) in Kind::ALL.into_iter().zip(self.folders()) {
            for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
                let Ok(about) = entry.metadata() else {
                    continue;
                };
                if about.is_file() && is_name(kind, &entry.file_name().to_string_lossy()) {
                    files.push(Kept {
                        kind,
                        path: entry.path(),
                        bytes: about.len(),
                        used: about.modified().unwrap_or(SystemTime::UNIX_EPOCH),
                    });
                }
            }
        }
        files.sort_by(|a, b| a.used.cmp(&b.used).then_with(|| a.path.cmp(&b.path)));
        files
    }

    /// Removes all files, and returns those that were there.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn clear(&self) -> io::Result<Vec<Kept>> {
        let files = self.files();
        for file in &files {
            match fs::remove_file(&file.path) {
                // Another process has removed it.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                removed => removed?,
            }
        }
        for folder in self.folders() {
            // Files of others stay, and so does a folder that is not empty.
            let _ = fs::remove_dir(folder);
        }
        Ok(files)
    }

    /// Removes the files used longest ago, but not `newest`, until the limit is kept.
    fn shrink(&self, newest: &Path) {
        let files = self.files();
        let mut total: u64 = files.iter().map(|file| file.bytes).sum();
        for file in files.iter().filter(|file| file.path != newest) {
            if total <= self.most_bytes {
                break;
            }
            // Another process may have removed it, or hold it open on Windows.
            let _ = fs::remove_file(&file.path);
            total = total.saturating_sub(file.bytes);
        }
    }

    fn folders(&self) -> Vec<PathBuf> {
        let of_kind = |kind: Kind| Some(self.folder.as_ref()?.join(kind.folder()));
        Kind::ALL.into_iter().filter_map(of_kind).collect()
    }

    fn path(&self, kind: Kind, key: Key) -> Option<PathBuf> {
        let name = format!("{:0KEY_DIGITS$x}{}", key.0, kind.ending());
        Some(self.folder.as_ref()?.join(kind.folder()).join(name))
    }
}

/// Whether the name of a file begins as those of a kind do. Temporary names go on after that.
fn is_name(kind: Kind, name: &str) -> bool {
    let rest = name.get(KEY_DIGITS..).unwrap_or_default();
    let digits = name.bytes().take(KEY_DIGITS);
    rest.starts_with(kind.ending())
        && digits
            .filter(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
            .count()
            == KEY_DIGITS
}

/// `landscape` in the system's folder for caches.
fn user_folder() -> Option<PathBuf> {
    let variable = |name| {
        std::env::var_os(name)
            .map(PathBuf::from)
            .filter(|path| path.is_absolute())
    };
    let base = if cfg!(target_os = "windows") {
        variable("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        variable("HOME").map(|home| home.join("Library/Caches"))
    } else {
        variable("XDG_CACHE_HOME").or_else(|| variable("HOME").map(|home| home.join(".cache")))
    };
    Some(base?.join("landscape"))
}

/// Number of bytes before the content: mark and key.
const HEAD: usize = 24;

/// The bytes of a file: mark, key, content, checksum. The key is in it, so that a renamed file is not taken for another.
fn packed(content: &[u8], kind: Kind, key: Key) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD + content.len() + 8);
    bytes.extend(kind.mark());
    bytes.extend(key.0.to_le_bytes());
    bytes.extend(content);
    bytes.extend(checksum(&bytes).to_le_bytes());
    bytes
}

/// The content of a complete file with the given key.
fn unpacked(bytes: &[u8], kind: Kind, key: Key) -> Option<&[u8]> {
    let (rest, sum) = bytes.split_last_chunk::<8>()?;
    if checksum(rest) != u64::from_le_bytes(*sum) {
        return None;
    }
    rest.strip_prefix(&kind.mark())?
        .strip_prefix(&key.0.to_le_bytes())
}

/// 64-bit FNV-1a hash over words, to detect damage.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.chunks(8).fold(0xcbf29ce484222325, |hash, chunk| {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        (hash ^ u64::from_le_bytes(word)).wrapping_mul(0x00000100000001b3)
    })
}

/// Little-endian numbers from the front of a content.
#[derive(Debug)]
pub(crate) struct Reader<'a>(pub(crate) &'a [u8]);

impl<'a> Reader<'a> {
    pub(crate) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, tail) = self.0.split_at_checked(count)?;
        self.0 = tail;
        Some(head)
    }

    pub(crate) fn number(&mut self) -> Option<f64> {
        Some(f64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    #[cfg(feature = "simulation")]
    pub(crate) fn index(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }

    pub(crate) fn count(&mut self) -> Option<usize> {
        usize::try_from(u64::from_le_bytes(self.take(8)?.try_into().ok()?)).ok()
    }

    pub(crate) fn vector(&mut self) -> Option<Vector3<f64>> {
        Some(Vector3::new(self.number()?, self.number()?, self.number()?))
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn key(text: &str) -> Key {
        let mut key = Key::default();
        key.feed(text.as_bytes());
        key
    }

    fn cache(folder: &tempfile::TempDir, most_bytes: u64) -> Cache {
        Cache {
            folder: Some(folder.path().join("cache")),
            most_bytes,
        }
    }

    #[test]
    fn content_comes_back_under_its_key_and_kind_only() {
        let folder = tempfile::tempdir().unwrap();
        let cache = cache(&folder, MOST_BYTES);
        cache.keep(Kind::Field, key("a"), b"one");
        cache.keep(Kind::Field, key("b"), b"");
        assert_eq!(cache.find(Kind::Field, key("a")).unwrap(), b"one");
        assert_eq!(cache.find(Kind::Field, key("b")).unwrap(), b"");
        assert_eq!(cache.find(Kind::Pieces, key("a")), None);
        assert_eq!(cache.find(Kind::Field, key("c")), None);
        cache.keep(Kind::Field, key("a"), b"two");
        assert_eq!(cache.find(Kind::Field, key("a")).unwrap(), b"two");
        assert_eq!(cache.files().len(), 2, "no temporary files are left");
    }

    #[test]
    fn damaged_cut_and_renamed_files_are_not_there() {
        let folder = tempfile::tempdir().unwrap();
        let cache = cache(&folder, MOST_BYTES);
        cache.keep(Kind::Pieces, key("a"), b"content");
        let path = cache.path(Kind::Pieces, key("a")).unwrap();
        let whole = fs::read(&path).unwrap();
        for place in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[place] ^= 1;
            fs::write(&path, &bytes).unwrap();
            assert_eq!(cache.find(Kind::Pieces, key("a")), None, "byte {place}");
            fs::write(&path, &whole[..place]).unwrap();
            assert_eq!(cache.find(Kind::Pieces, key("a")), None, "{place} bytes");
        }
        fs::write(&path, &whole).unwrap();
        assert!(cache.find(Kind::Pieces, key("a")).is_some());
        fs::rename(&path, cache.path(Kind::Pieces, key("b")).unwrap()).unwrap();
        assert_eq!(cache.find(Kind::Pieces, key("b")), None);
    }

    /// Opening a pipe waits for its other end; this test would never end.
    #[cfg(unix)]
    #[test]
    fn a_pipe_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let cache = cache(&folder, MOST_BYTES);
        let path = cache.path(Kind::Field, key("a")).unwrap();
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.unwrap().success());
        assert_eq!(cache.find(Kind::Field, key("a")), None);
        assert!(cache.files().is_empty());
        cache.keep(Kind::Field, key("a"), b"content");
        assert!(
            cache.find(Kind::Field, key("a")).is_some(),
            "the file has taken the place of the pipe"
        );
    }

    #[test]
    fn without_a_folder_nothing_is_kept_and_nothing_fails() {
        let file = tempfile::NamedTempFile::new().unwrap();
        for folder in [None, Some(file.path().join("cache"))] {
            let cache = Cache {
                folder,
                most_bytes: MOST_BYTES,
            };
            cache.keep(Kind::Field, key("a"), b"content");
            assert_eq!(cache.find(Kind::Field, key("a")), None);
            assert!(cache.clear().unwrap().is_empty());
        }
    }

    /// Sets the last use of a content to some minutes ago.
    fn age(cache: &Cache, kind: Kind, key: Key, minutes: u64) {
        let file = OpenOptions::new()
            .append(true)
            .open(cache.path(kind, key).unwrap())
            .unwrap();
        file.set_modified(SystemTime::now() - Duration::from_secs(60 * minutes))
            .unwrap();
    }

    #[test]
    fn beyond_the_limit_what_was_used_longest_ago_goes() {
        let folder = tempfile::tempdir().unwrap();
        // Each file has 100 bytes.
        let cache = cache(&folder, 300);
        let content = [7; 100 - HEAD - 8];
        for (minutes, name) in [(40, "a"), (30, "b"), (20, "c")] {
            let kind = if name == "b" {
                Kind::Pieces
            } else {
                Kind::Field
            };
            cache.keep(kind, key(name), &content);
            age(&cache, kind, key(name), minutes);
        }
        assert_eq!(cache.files().len(), 3);
        // A use makes the oldest the newest.
        assert!(cache.find(Kind::Field, key("a")).is_some());
        cache.keep(Kind::Field, key("d"), &content);
        assert_eq!(
            cache.find(Kind::Pieces, key("b")),
            None,
            "used longest ago, of whatever kind"
        );
        for name in ["a", "c", "d"] {
            assert!(cache.find(Kind::Field, key(name)).is_some(), "{name}");
        }
        // What is kept last stays even if it is too large by itself.
        cache.keep(Kind::Pieces, key("e"), &[7; 1_000]);
        assert!(cache.find(Kind::Pieces, key("e")).is_some());
        assert_eq!(cache.files().len(), 1);
    }

    #[test]
    fn clearing_removes_all_that_was_kept_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let cache = cache(&folder, MOST_BYTES);
        cache.keep(Kind::Field, key("a"), b"content");
        cache.keep(Kind::Pieces, key("b"), b"content");
        let fields = cache.folder.as_ref().unwrap().join("fields");
        fs::write(fields.join("notes.txt"), "of somebody else").unwrap();
        let begun = format!("{:032x}.field.17-0.partial", 5);
        fs::write(fields.join(begun), "left by a killed process").unwrap();
        assert_eq!(cache.clear().unwrap().len(), 3);
        assert!(cache.files().is_empty());
        assert!(fields.join("notes.txt").exists());
        assert!(cache.clear().unwrap().is_empty());
        cache.keep(Kind::Field, key("a"), b"content");
        assert!(cache.find(Kind::Field, key("a")).is_some());
    }
}
