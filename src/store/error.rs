//! Errors and warnings about files, in one sentence each.

use std::io;
use std::path::{Path, PathBuf};

use crate::limits::Beyond;
use crate::printable::counted;

/// Reasons why a file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum StoreError {
    /// There is no file at the path.
    #[error("no such file: {0}")]
    NotFound(PathBuf),
    /// The operating system reported an error.
    #[error("cannot {action} {path}")]
    Io {
        /// The attempted action: `read`, `write`, `create` ….
        action: &'static str,
        path: PathBuf,
        source: io::Error,
    },
    /// A folder was given instead of a file.
    #[error("{0} is a folder, but a file is needed")]
    Folder(PathBuf),
    /// A file was given instead of the folder of a landscape.
    #[error(
        "{0} is a file, but a landscape is a folder: `landscape build` makes one from a file of grasps"
    )]
    NoFolder(PathBuf),
    /// The file is not Parquet or is damaged.
    #[error("{path} is not a Parquet file or is damaged: {reason}")]
    NotParquet { path: PathBuf, reason: String },
    /// A file of this program was damaged or altered.
    #[error(
        "{0} is not as landscape wrote it: its content does not match its checksum, so it was damaged or altered; use \
         an intact copy, or make it again"
    )]
    Altered(PathBuf),
    /// Another program wrote a file of which only the outcomes of simulations are to be read.
    #[error(
        "{0} was written by another program, so its outcomes of simulations may not belong to its poses: run `landscape \
         stability` on it"
    )]
    Unsealed(PathBuf),
    /// The manifest of the landscape does not list this table, or lists it with another hash.
    #[error(
        "{path} does not belong to this landscape: {manifest} lists another checksum for it, or none, so it was altered \
         or comes from elsewhere; put the original table back, or build the landscape again"
    )]
    NotOfLandscape { path: PathBuf, manifest: PathBuf },
    /// The decoder of this compression is not built in.
    #[error(
        "{path} is compressed with {codec}, which is not supported: write it with snappy, zstd, gzip, lz4, brotli or without compression"
    )]
    Compression { path: PathBuf, codec: String },
    /// A Parquet file does not describe its hand or object.
    #[error(
        "{path} does not describe its {missing}: another program wrote it, or rewrote it without the landscape metadata, as \
         polars and DuckDB do. Pass {flags}{named} (the documentation of grasps.parquet lists columns and units)"
    )]
    NoMetadata {
        path: PathBuf,
        /// `hand`, `object` or `hand and object`.
        missing: &'static str,
        flags: &'static str,
        /// The names in its rows, in brackets after a space; empty if the rows name nothing.
        named: String,
    },
    /// The metadata are contradictory or were not written by this program.
    #[error("the `landscape` metadata of {path} cannot be used: {reason}")]
    Metadata { path: PathBuf, reason: String },
    /// A newer version of the program wrote the file.
    #[error("{path} has schema version {found}, but only version {known} is supported")]
    SchemaVersion {
        path: PathBuf,
        found: u64,
        known: u64,
    },
    /// A file of another program is invalid or unsuitable.
    #[error("{path}: {problem}")]
    Foreign { path: PathBuf, problem: String },
    /// A required column is missing.
    #[error("{path} has no column `{column}` ({expected})")]
    MissingColumn {
        path: PathBuf,
        column: String,
        expected: &'static str,
    },
    /// A column has the wrong type.
    #[error(
        "column `{column}` of {path} contains {found}; {} needed",
        are(expected)
    )]
    ColumnType {
        path: PathBuf,
        column: String,
        expected: &'static str,
        found: String,
    },
    /// A row cannot be used.
    #[error("{path}, row {row} (the first is 0): {fault}")]
    Row {
        path: PathBuf,
        /// Row number, counted from 0.
        row: usize,
        fault: Fault,
    },
    /// The file has no rows.
    #[error("{0} contains no grasps")]
    Empty(PathBuf),
    /// A file or folder of another program has that name, so it is not replaced.
    #[error("{0} exists and was not made by landscape: move it away or choose another name")]
    NotOurs(PathBuf),
    /// No files can be created in the folder, such as `/proc`.
    #[error("no file can be made in {0}: choose another place to write to")]
    NoPlace(PathBuf),
    /// The path has no file name.
    #[error("`{0}` does not name a file")]
    NoName(PathBuf),
    /// The folder of a landscape has no manifest.
    #[error(
        "{0} contains no finished landscape: landscape.json is missing or comes from another program"
    )]
    Unfinished(PathBuf),
    /// The journal belongs to a run with other input or settings.
    #[error(
        "{0} belongs to a run with other input or settings, or of another version of the program: repeat those to \
         resume it, or start over with --fresh"
    )]
    OtherRun(PathBuf),
    /// The file is not a journal.
    #[error("{0} is not a journal of this program or its head is damaged: start over with --fresh")]
    NotAJournal(PathBuf),
    /// Another process is writing the journal.
    #[error(
        "another process is writing {}: wait until it ends, or name another output",
        written(.0).display()
    )]
    InUse(PathBuf),
}

impl StoreError {
    /// Wraps an error of the operating system about `path`.
    pub(super) fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| {
            let missing = source.kind() == io::ErrorKind::NotFound;
            // If the file was to be created, the error is not a missing file: the folder accepts no files.
            let folder = path.parent().filter(|folder| folder.is_dir());
            match (action, folder) {
                ("read", _) if missing => Self::NotFound(path),
                ("read", _) if source.kind() == io::ErrorKind::IsADirectory => Self::Folder(path),
                ("open" | "create" | "write", Some(folder)) if missing => {
                    Self::NoPlace(folder.to_path_buf())
                }
                _ => Self::Io {
                    action,
                    path,
                    source,
                },
            }
        }
    }
}

/// Problems of a single row.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum Fault {
    /// A required value is null.
    #[error("column `{column}` is empty")]
    Missing { column: String },
    /// A value is NaN or infinite.
    #[error("column `{column}` contains {value}, which is not a finite number")]
    NotFinite { column: String, value: f64 },
    /// A value is negative or too large for a count or an index.
    #[error("column `{column}` contains {value}, expected a whole number from 0 to {largest}")]
    NotWhole {
        column: String,
        value: i128,
        largest: u64,
    },
    /// A list has the wrong length.
    #[error("column `{column}` contains {}, expected {expected}", counted(*found, "number"))]
    Length {
        column: String,
        found: usize,
        expected: usize,
    },
    /// The hand is farther from the object than is plausible in metres.
    #[error("translation_m has {0}: more than a kilometre from the object; lengths are in metres")]
    Far(f64),
    /// The scale is impossible for an object in a hand.
    #[error("scale {0}")]
    Scale(Beyond),
    /// A quaternion does not have unit length.
    #[error("the quaternion `rotation_wxyz` has length {0}, expected 1")]
    NotUnit(f64),
    /// A joint is so far beyond its limit that its value is probably not an angle in radians.
    #[error(
        "joint `{joint}` at {value} rad lies more than 1 rad beyond its limits {lower} to {upper}: are these \
         degrees, or angles of other joints?"
    )]
    BeyondLimit {
        joint: String,
        value: f64,
        lower: f64,
        upper: f64,
    },
    /// A contact does not exist on the hand.
    #[error(
        "contact {contact} does not exist: hand `{hand}` has {points} surface points, counted from 0"
    )]
    ContactRange {
        contact: u32,
        hand: String,
        points: usize,
    },
    /// A contact occurs twice in one grasp.
    #[error("contact {0} occurs twice")]
    RepeatedContact(u32),
    /// The metadata do not describe the hand.
    #[error("hand `{hand}` is not the one described: {known}")]
    UnknownHand { hand: String, known: String },
    /// The metadata do not describe the object.
    #[error("object `{object}` is not the one described: {known}")]
    UnknownObject { object: String, known: String },
    /// A value is invalid.
    #[error("column `{column}` contains `{value}`, expected {expected}")]
    Unexpected {
        column: String,
        value: String,
        expected: String,
    },
    /// Two grasps have the same id.
    #[error("id {id} is taken by row {first} already")]
    RepeatedId {
        id: u64,
        /// The first row with this id.
        first: usize,
    },
}

/// Warnings about a file that was nevertheless read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum Warning {
    /// Some joints are beyond their limits. They are kept, and the joint-limit term of the energy moves them back.
    #[error(
        "{count} of {grasps} grasps have joints beyond their limits; farthest is `{joint}` in row {row}, by {excess:.4} \
         rad, or m if it slides; they are kept as they are"
    )]
    BeyondLimit {
        count: usize,
        grasps: usize,
        /// Row with the largest excess, counted from 0.
        row: usize,
        joint: String,
        /// The largest excess, radians; metres for sliding joints.
        excess: f64,
    },
    /// The given hand is not the one that the file describes.
    #[error(
        "using hand `{given}` instead of `{told}`: contacts, labels and outcomes of simulations are dropped; measures are \
         still those of the hand in the file"
    )]
    OtherHand {
        /// The name of the hand in the file.
        told: String,
        given: String,
    },
    /// No checksum of this program vouches for the content of a file of grasps, so its measures are those of its poses only
    /// if [`GraspFile::verify`](super::GraspFile::verify) finds them so.
    #[error(
        "{0} was written by another program, so its energies, measures and outcomes of simulations may not belong to its poses"
    )]
    Unsealed(PathBuf),
    /// Measures in a file are not those of its poses.
    #[error(
        "the measures of {count} of {grasps} grasps in the file are not those of their poses (row {row}: `{column}` is {told}, \
         computed {computed}): computed ones are used{}",
        left_out(*outcomes, *labels)
    )]
    OtherMeasures {
        count: usize,
        grasps: usize,
        /// First row with such measures, counted from 0.
        row: usize,
        /// Its first column that differs.
        column: String,
        told: String,
        /// The value computed, or `nothing`.
        computed: String,
        /// Number of these grasps whose outcomes of simulations were dropped.
        outcomes: usize,
        /// Number of these grasps whose labels of the rule were dropped.
        labels: usize,
    },
    /// Outcomes of simulations belong to the poses as far as the measures tell, but another program wrote the file.
    #[error(
        "the outcomes of simulations ({outcomes} of {grasps} grasps) are not verified, because another program wrote the file; \
         `landscape stability` simulates the grasps again"
    )]
    UnverifiedOutcomes { outcomes: usize, grasps: usize },
    /// The file describes nothing, and the rows name a hand or an object otherwise than the user.
    #[error("using {kind} `{given}` for `{told}`, the only {kind} that the rows name")]
    TakenFor {
        /// `hand` or `object`.
        kind: &'static str,
        told: String,
        given: String,
    },
    /// The file describes nothing, and its rows name hands or objects that come with the program.
    #[error(
        "the file does not describe {kind} {}: what comes with this version of the program under that name is used \
         (--{kind} gives another)",
        list(names.iter().map(String::as_str))
    )]
    BuiltIn {
        /// `hand` or `object`.
        kind: &'static str,
        names: Vec<String>,
    },
    /// The given object is not the one that the file describes.
    #[error(
        "using object `{given}` instead of `{told}`: labels and outcomes of simulations are dropped; measures are still those \
         of the object in the file"
    )]
    OtherObject {
        /// The name of the object in the file.
        told: String,
        given: String,
    },
}

/// The content of a column with its verb: `text is`, `numbers are`.
fn are(content: &str) -> String {
    let verb = if matches!(content, "text" | "true or false") {
        "is"
    } else {
        "are"
    };
    format!("{content} {verb}")
}

/// The file or folder that a run with this journal writes: the journal is `X.partial`, or lies in it.
fn written(journal: &Path) -> PathBuf {
    let places = [Some(journal), journal.parent()].into_iter().flatten();
    let stem = |place: &Path| {
        let name = place.file_name()?.to_str()?;
        let stem = name.strip_suffix(".partial")?;
        Some(place.with_file_name(stem))
    };
    let mut written = places.filter_map(stem);
    written.next().unwrap_or_else(|| journal.to_path_buf())
}

/// What is left out of grasps whose measures are not those of their poses.
fn left_out(outcomes: usize, labels: usize) -> String {
    let parts = [
        (outcomes, "outcome", " of a simulation", " of simulations"),
        (labels, "label", " by the rule", " by the rule"),
    ];
    let told: Vec<String> = (parts.iter())
        .filter(|(count, ..)| *count > 0)
        .map(|(count, noun, one, several)| {
            let of = if *count == 1 { one } else { several };
            counted(*count, noun) + of
        })
        .collect();
    match (told.as_slice(), outcomes + labels) {
        ([], _) => String::new(),
        (told, 1) => format!("; {} is left out", told.join(" and ")),
        (told, _) => format!("; {} are left out", told.join(" and ")),
    }
}

/// The names, for a sentence.
pub(super) fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<_> = names.map(|name| format!("`{name}`")).collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}
