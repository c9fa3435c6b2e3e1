//! The journal of the finished tasks of a long run, on disk.
//!
//! Records are only appended, so a killed run leaves at most one torn record at the end. It is dropped when the journal is
//! opened again, and its task is done once more. Records may be in any order, because the result of a run depends only on
//! the set of finished tasks.

mod record;

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use super::error::StoreError;
use crate::topography;
use record::{Head, head, record, records, split_head};

/// The journal is flushed to disk after this many bytes or this much time, which bounds the loss in a power cut. A killed
/// process loses no record.
const SYNC_BYTES: u64 = 1 << 20;
const SYNC_TIME: Duration = Duration::from_secs(5);

/// An append-only file of (key, payload) records for one input with one set of settings. Threads can share it.
pub struct Journal {
    path: PathBuf,
    dropped_bytes: u64,
    inner: Mutex<Inner>,
}

struct Inner {
    file: File,
    records: BTreeMap<String, Vec<u8>>,
    /// Length of the file up to the end of the last complete record.
    length: u64,
    synced_length: u64,
    synced_at: Instant,
    /// Whether a failed write may have left bytes beyond `length`.
    torn: bool,
}

impl Journal {
    /// Opens the journal at `path`, or creates it. `fingerprint` identifies everything that the payloads depend on (a
    /// [`content_hash`](super::content_hash) of input and settings). With `fresh`, existing content is discarded.
    ///
    /// # Errors
    /// If the journal was made with another fingerprint, is not a journal, is in use on this machine, or cannot be written.
    /// File systems without locks do not show that it is in use.
    pub fn open(path: &Path, fingerprint: &str, fresh: bool) -> Result<Self, StoreError> {
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(StoreError::io("open", path))?;
        // Without a lock the journal is as good.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(StoreError::InUse(path.to_path_buf()));
        }
        let mut bytes = Vec::new();
        if !fresh {
            file.read_to_end(&mut bytes)
                .map_err(StoreError::io("read", path))?;
        }
        let (records, length) = match split_head(&bytes, fingerprint) {
            Head::Whole {
                fingerprint: found, ..
            } if found != fingerprint.as_bytes() => {
                return Err(StoreError::OtherRun(path.to_path_buf()));
            }
            Head::Whole { length, .. } => scan(&bytes, length),
            Head::Torn => (BTreeMap::new(), 0),
            Head::Foreign => {
                return Err(StoreError::NotAJournal(path.to_path_buf()));
            }
        };
        let mut inner = Inner {
            file,
            records,
            length: length as u64,
            synced_length: 0,
            synced_at: Instant::now(),
            torn: true,
        };
        let head = if length == 0 {
            head(fingerprint)
        } else {
            Vec::new()
        };
        if let Err(error) = inner.append(&head).and_then(|()| inner.sync()) {
            if bytes.is_empty() {
                // On a full disk, a file without a head would be of no use.
                let _ = std::fs::remove_file(path);
            }
            return Err(StoreError::io("write", path)(error));
        }
        let dropped_bytes = (bytes.len() - length) as u64;
        Ok(Self {
            path: path.to_path_buf(),
            dropped_bytes,
            inner: Mutex::new(inner),
        })
    }

    /// Payload of a finished task.
    pub fn get(&self, key: &str) -> Option<Vec<u8>> {
        self.lock().records.get(key).cloned()
    }

    /// Records a finished task. A second payload under the same key replaces the first.
    ///
    /// # Errors
    /// If the disk is full or absent. Earlier records stay valid.
    ///
    /// # Panics
    /// If the key or the payload has 4 GiB or more.
    pub fn put(&self, key: &str, payload: &[u8]) -> Result<(), StoreError> {
        let record = record(key, payload);
        let mut inner = self.lock();
        inner
            .append(&record)
            .map_err(StoreError::io("write", &self.path))?;
        inner.records.insert(key.to_owned(), payload.to_vec());
        if inner.length - inner.synced_length >= SYNC_BYTES
            || inner.synced_at.elapsed() >= SYNC_TIME
        {
            inner.sync().map_err(StoreError::io("write", &self.path))?;
        }
        Ok(())
    }

    /// Number of recorded tasks.
    pub fn len(&self) -> usize {
        self.lock().records.len()
    }

    /// Whether no task is recorded.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of bytes of a torn record that were dropped when the journal was opened.
    pub fn dropped_bytes(&self) -> u64 {
        self.dropped_bytes
    }

    /// Flushes everything to disk.
    ///
    /// # Errors
    /// If the disk reports an error.
    pub fn sync(&self) -> Result<(), StoreError> {
        let mut inner = self.lock();
        if inner.synced_length == inner.length {
            return Ok(());
        }
        inner.sync().map_err(StoreError::io("write", &self.path))
    }

    /// Removes the journal from disk, when the results of its run are complete and stored elsewhere.
    ///
    /// # Errors
    /// If the file cannot be removed.
    pub fn remove(self) -> Result<(), StoreError> {
        std::fs::remove_file(&self.path).map_err(StoreError::io("remove", &self.path))
    }

    /// Locks the journal even after a panic in another thread, which leaves either `torn` set or everything consistent.
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl topography::Journal for Journal {
    fn get(&self, key: &str) -> Option<Vec<u8>> {
        self.get(key)
    }

    fn put(&self, key: &str, record: &[u8]) -> Result<(), topography::JournalError> {
        self.put(key, record)
            .map_err(|error| Box::<dyn Error + Send + Sync>::from(error).into())
    }
}

impl fmt::Debug for Journal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Journal")
            .field("path", &self.path)
            .field("records", &self.len())
            .finish_non_exhaustive()
    }
}

impl Inner {
    /// Appends all of `bytes` or nothing.
    fn append(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.cut_tail()?;
        self.torn = true;
        self.file.write_all(bytes)?;
        self.torn = false;
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Cuts off the remains of a failed or killed write after the last complete record.
    fn cut_tail(&mut self) -> std::io::Result<()> {
        if self.torn {
            self.file.set_len(self.length)?;
            self.file.seek(SeekFrom::Start(self.length))?;
            self.torn = false;
        }
        Ok(())
    }

    fn sync(&mut self) -> std::io::Result<()> {
        self.file.sync_data()?;
        self.synced_length = self.length;
        self.synced_at = Instant::now();
        Ok(())
    }
}

/// All complete records from `start` on, and the end of the last one.
fn scan(bytes: &[u8], start: usize) -> (BTreeMap<String, Vec<u8>>, usize) {
    let (mut tasks, mut end) = (BTreeMap::new(), start);
    for found in records(bytes, start) {
        end = found.end;
        tasks.insert(found.key.to_owned(), found.payload.to_vec());
    }
    (tasks, end)
}
