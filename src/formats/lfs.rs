//! Files that Git LFS has not fetched.

/// Whether `bytes` are a Git LFS pointer, which stands for the file until `git lfs pull` fetches it.
pub(crate) fn is_lfs_pointer(bytes: &[u8]) -> bool {
    bytes.starts_with(b"version https://git-lfs.github.com/spec/")
}
