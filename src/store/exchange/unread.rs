//! Files of grasps that are not read: what they are, and what is read instead.

use std::io::Read as _;
use std::path::Path;

use crate::formats::ending;

/// What is read, for the end of a sentence.
pub(super) const INSTEAD: &str = "grasps come as .npy, .pt, .yaml, .csv, .json or .parquet; write its poses and joints as a table, \
    one row for each grasp (docs/import_export.md, Mapping)";

const HDF5: &str =
    "an HDF5 file (those of ACRONYM are read by `landscape.import_grasps` in Python, with h5py)";

/// How many bytes tell what a file is.
const HEAD: u64 = 4096;

/// What the file is, if its first bytes or its ending tell, and what is read instead.
pub(super) fn sentence(path: &Path) -> String {
    let ending = ending(path);
    match kind(&head(path), &ending) {
        Some(kind) => format!("it is {kind}, which is not read here: {INSTEAD}"),
        None if ending.is_empty() => {
            format!("its name has no ending, so its kind is unknown: {INSTEAD}")
        }
        None => format!(".{ending} is not read here: {INSTEAD}"),
    }
}

/// The kind of a file by its first bytes, or else by the ending of its name.
fn kind(head: &[u8], ending: &str) -> Option<&'static str> {
    let holds = |text: &str| {
        let mut windows = head.windows(text.len());
        windows.any(|window| window == text.as_bytes())
    };
    let zip = head.starts_with(b"PK\x03\x04");
    if head.starts_with(b"\x89HDF\r\n\x1a\n") {
        return Some(HDF5);
    }
    if zip && (holds("/data.pkl") || holds("/byteorder")) {
        return Some("a file of PyTorch (torch.save), which is read if its name ends in .pt");
    }
    if zip && holds(".npy") {
        return Some("an archive of numpy arrays (numpy.savez)");
    }
    Some(match ending {
        "npz" => "an archive of numpy arrays (numpy.savez)",
        "h5" | "hdf5" => HDF5,
        "pkl" | "pickle" => "a pickle of Python",
        "usd" | "usda" | "usdc" | "usdz" => "a scene of USD",
        "mat" => "a file of MATLAB",
        "xlsx" | "ods" => "a spreadsheet",
        _ => return None,
    })
}

/// The first bytes of a file; none if it cannot be read.
fn head(path: &Path) -> Vec<u8> {
    let mut head = Vec::new();
    let read = std::fs::File::open(path).map(|file| file.take(HEAD).read_to_end(&mut head));
    // A file that cannot be read is told by its ending.
    let _ = read;
    head
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_counts_before_the_ending() {
        assert_eq!(kind(b"\x89HDF\r\n\x1a\n....", "npz"), Some(HDF5));
        let torch = b"PK\x03\x04........archive/data.pkl";
        assert!(kind(torch, "bin").is_some_and(|kind| kind.contains("ends in .pt")));
        assert_eq!(kind(b"", "npz"), kind(b"PK\x03\x04....a.npy", "zip"));
        assert_eq!(kind(b"words", "dat"), None);
    }
}
