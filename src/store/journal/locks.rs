//! Locks of journals, and file systems that have none.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;

/// `ENOLCK`: what the network file system answers without a lock daemon. The standard library has no name for it.
const NO_LOCKS_AVAILABLE: i32 = if cfg!(target_os = "linux") { 37 } else { 77 };

/// Who holds the lock of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lock {
    /// No process, or this one since it asked.
    Free,
    /// A running process.
    Held,
    /// The file system has no locks.
    Unknown,
}

/// Tries to lock a file for this process.
pub(super) fn take(file: &File) -> io::Result<Lock> {
    answer(file.try_lock())
}

/// Whether a running process holds the lock of the file at `path`; free if there is no such file.
pub(super) fn of(path: &Path) -> Lock {
    let Ok(file) = File::open(path) else {
        return Lock::Free;
    };
    answer(file.try_lock_shared()).unwrap_or(Lock::Free)
}

/// Whether files in a folder can be locked, by a temporary file of this process.
pub(super) fn are_in(folder: &Path) -> io::Result<bool> {
    let path = folder.join(format!("locks-{}", std::process::id()));
    let file = File::create(&path)?;
    let lock = take(&file);
    // Processes on other machines, or in other containers, may have the same number and have removed it.
    match std::fs::remove_file(&path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    Ok(lock? != Lock::Unknown)
}

fn answer(locked: Result<(), TryLockError>) -> io::Result<Lock> {
    match locked {
        Ok(()) => Ok(Lock::Free),
        Err(TryLockError::WouldBlock) => Ok(Lock::Held),
        Err(TryLockError::Error(error)) if is_without_locks(&error) => Ok(Lock::Unknown),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

fn is_without_locks(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::Unsupported
        || (cfg!(unix) && error.raw_os_error() == Some(NO_LOCKS_AVAILABLE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_is_held_by_one() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("journal");
        assert_eq!(of(&path), Lock::Free, "there is no file");
        let file = File::create(&path).unwrap();
        assert_eq!(take(&file).unwrap(), Lock::Free);
        assert_eq!(of(&path), Lock::Held);
        assert_eq!(take(&File::open(&path).unwrap()).unwrap(), Lock::Held);
        drop(file);
        assert_eq!(of(&path), Lock::Free);
        assert!(are_in(place.path()).unwrap());
        assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 1);
    }

    /// Containers often give their first process the number 1, so that workers on many machines have the same.
    #[test]
    fn processes_of_one_number_may_ask_at_once() {
        let place = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| (0..200).for_each(|_| assert!(are_in(place.path()).unwrap())));
            }
        });
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_system_without_locks_is_recognised() {
        // EOPNOTSUPP and ENOLCK; EIO is an error.
        for code in [95, 37] {
            let error = TryLockError::Error(io::Error::from_raw_os_error(code));
            assert_eq!(answer(Err(error)).unwrap(), Lock::Unknown);
        }
        let broken = TryLockError::Error(io::Error::from_raw_os_error(5));
        assert!(answer(Err(broken)).is_err());
    }
}
