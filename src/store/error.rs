//! What can be wrong with a file, in one sentence each.

use std::io;
use std::path::{Path, PathBuf};

use crate::limits::Beyond;

/// Why a file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// Nothing at that path.
    #[error("no such file: {path}")]
    NotFound {
        /// The file asked for.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error("cannot {action} {path}")]
    Io {
        /// What was tried: `read`, `write`, `create` …
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file where the folder of a landscape is needed.
    #[error(
        "{path} is a file, but a landscape is a folder: `landscape build` makes one of a file of grasps"
    )]
    NoFolder {
        /// The file.
        path: PathBuf,
    },
    /// Not a Parquet file, or a damaged one.
    #[error("{path} is not a Parquet file or is damaged: {reason}")]
    NotParquet {
        /// The file.
        path: PathBuf,
        /// What the reader met.
        reason: String,
    },
    /// A file of ours that is not what was written.
    #[error(
        "{path} is not as landscape wrote it: its content does not fit its checksum, so it was damaged or altered; take a \
         copy that was not, or make it again"
    )]
    Altered {
        /// The file.
        path: PathBuf,
    },
    /// A table that a landscape's manifest does not list, or lists with another hash.
    #[error(
        "{path} does not belong to this landscape: {manifest} tells another checksum of it, or none, so it was altered or \
         comes from elsewhere; put the table of this landscape back, or build the landscape again"
    )]
    NotOfLandscape {
        /// The table, or the manifest itself.
        path: PathBuf,
        /// The manifest.
        manifest: PathBuf,
    },
    /// A compression whose decoder is not built in.
    #[error(
        "{path} is compressed with {codec}, which is not supported: write it with snappy or without compression"
    )]
    Compression {
        /// The file.
        path: PathBuf,
        /// Name of the compression.
        codec: String,
    },
    /// A Parquet file that does not say which hand and object it is about.
    #[error(
        "{path} does not describe its {missing}: it was not written by landscape, or its metadata were lost when another \
         program wrote it anew; give {flags} (columns and units are listed in the documentation of grasps.parquet)"
    )]
    NoMetadata {
        /// The file.
        path: PathBuf,
        /// `hand`, `object` or `hand and object`.
        missing: &'static str,
        /// The flags that supply it.
        flags: &'static str,
    },
    /// Metadata that contradict themselves or are not what this program writes.
    #[error("the `landscape` metadata of {path} cannot be used: {reason}")]
    Metadata {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// Written by a newer program.
    #[error("{path} has schema version {found}, but this program knows version {known} only")]
    SchemaVersion {
        /// The file.
        path: PathBuf,
        /// The version in the file.
        found: u64,
        /// The version this program reads and writes.
        known: u64,
    },
    /// A file of another program that cannot be understood, or does not fit what it is read for.
    #[error("{path}: {problem}")]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A required column is absent.
    #[error("{path} has no column `{column}` ({expected})")]
    MissingColumn {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// What it should hold.
        expected: &'static str,
    },
    /// A column holds something else.
    #[error("column `{column}` of {path} holds {found}, expected {expected}")]
    ColumnType {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// What it should hold.
        expected: &'static str,
        /// What it holds.
        found: String,
    },
    /// A row that cannot be used.
    #[error("{path}, row {row} (the first is 0): {fault}")]
    Row {
        /// The file.
        path: PathBuf,
        /// Row number, counted from 0.
        row: usize,
        /// What is wrong with it.
        fault: Fault,
    },
    /// No rows.
    #[error("{path} holds no grasps")]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Something else already has that name, and it is not ours to replace.
    #[error("{path} exists and was not made by landscape: move it away or choose another name")]
    NotOurs {
        /// The file or folder in the way.
        path: PathBuf,
    },
    /// A folder that takes no new files, as `/proc`.
    #[error("no file can be made in {folder}: choose another place to write to")]
    NoPlace {
        /// The folder.
        folder: PathBuf,
    },
    /// A name that cannot be a file's.
    #[error("`{path}` does not name a file")]
    NoName {
        /// The path given.
        path: PathBuf,
    },
    /// A landscape folder without its manifest.
    #[error("{path} holds no finished landscape: landscape.json is missing or not ours")]
    Unfinished {
        /// The folder.
        path: PathBuf,
    },
    /// A journal of a run with other input or settings.
    #[error(
        "{path} belongs to a run with other input or settings, or of another version of the program: repeat those to \
         resume it, or start over with --fresh"
    )]
    OtherRun {
        /// The journal.
        path: PathBuf,
    },
    /// Not a journal.
    #[error(
        "{path} is not a journal of this program or its head is damaged: start over with --fresh"
    )]
    NotAJournal {
        /// The file.
        path: PathBuf,
    },
    /// Another process writes the journal.
    #[error("{path} is in use by another run")]
    InUse {
        /// The journal.
        path: PathBuf,
    },
}

impl StoreError {
    /// Wraps what the operating system said about `path`.
    pub(super) fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| {
            let missing = source.kind() == io::ErrorKind::NotFound;
            // A file that is to be made is not missing: the folder does not take it.
            let folder = path.parent().filter(|folder| folder.is_dir());
            match (action, folder) {
                ("read", _) if missing => Self::NotFound { path },
                ("open" | "create" | "write", Some(folder)) if missing => Self::NoPlace {
                    folder: folder.to_path_buf(),
                },
                _ => Self::Io {
                    action,
                    path,
                    source,
                },
            }
        }
    }
}

/// What is wrong with one row.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// A required value is null.
    #[error("column `{column}` is empty")]
    Missing {
        /// The column.
        column: String,
    },
    /// NaN or infinite.
    #[error("column `{column}` holds {value}, which is not a finite number")]
    NotFinite {
        /// The column.
        column: String,
        /// The value.
        value: f64,
    },
    /// Negative where a number or index is asked for.
    #[error("column `{column}` holds {value}, expected a whole number from 0 to {largest}")]
    NotWhole {
        /// The column.
        column: String,
        /// The value.
        value: i128,
        /// Largest value the column can hold.
        largest: u64,
    },
    /// A list of the wrong length.
    #[error("column `{column}` holds {found} numbers, expected {expected}")]
    Length {
        /// The column.
        column: String,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A hand farther from the object than any lengths in metres mean.
    #[error(
        "translation_m has {value}: more than a kilometre from the object; lengths are in metres"
    )]
    Far {
        /// The first such coordinate.
        value: f64,
    },
    /// A scale of no object that can be held.
    #[error("scale {0}")]
    Scale(Beyond),
    /// A quaternion that is no rotation.
    #[error("the quaternion `rotation_wxyz` has length {norm}, expected 1")]
    NotUnit {
        /// Its length.
        norm: f64,
    },
    /// A joint so far beyond its limit that its angle must be something else.
    #[error(
        "joint `{joint}` at {angle_rad} rad lies more than 1 rad beyond its limits {lower_rad} to {upper_rad}: are these \
         degrees, or angles of other joints?"
    )]
    BeyondLimit {
        /// The joint.
        joint: String,
        /// Its angle.
        angle_rad: f64,
        /// Its lower limit.
        lower_rad: f64,
        /// Its upper limit.
        upper_rad: f64,
    },
    /// A contact that the hand does not have.
    #[error(
        "contact {contact} does not exist: hand `{hand}` has {points} surface points, counted from 0"
    )]
    ContactRange {
        /// The contact.
        contact: u32,
        /// The hand.
        hand: String,
        /// How many surface points it has.
        points: usize,
    },
    /// The same contact twice in one grasp.
    #[error("contact {contact} occurs twice")]
    RepeatedContact {
        /// The contact.
        contact: u32,
    },
    /// A hand the metadata do not describe.
    #[error("hand `{hand}` is not the one described: {known}")]
    UnknownHand {
        /// The hand of the row.
        hand: String,
        /// The hands described.
        known: String,
    },
    /// An object the metadata do not describe.
    #[error("object `{object}` is not the one described: {known}")]
    UnknownObject {
        /// The object of the row.
        object: String,
        /// The objects described.
        known: String,
    },
    /// A value that refers to nothing, or has no meaning.
    #[error("column `{column}` holds `{value}`, expected {expected}")]
    Unexpected {
        /// The column.
        column: String,
        /// The value.
        value: String,
        /// What it should be.
        expected: String,
    },
    /// Two grasps with one id.
    #[error("id {id} is taken by row {first} already")]
    RepeatedId {
        /// The id.
        id: u64,
        /// The first row that has it.
        first: usize,
    },
}

/// Something a user should know about a file that was read all the same.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// Joints beyond their limits; kept as they are. The joint-limit term of the energy brings them back.
    #[error(
        "{count} of {grasps} grasps have joints beyond their limits; farthest is `{joint}` in row {row}, by {excess_rad:.4} \
         rad; they are kept as they are"
    )]
    BeyondLimit {
        /// Grasps with such joints.
        count: usize,
        /// All grasps.
        grasps: usize,
        /// Row of the farthest, counted from 0.
        row: usize,
        /// Its joint.
        joint: String,
        /// How far beyond.
        excess_rad: f64,
    },
    /// The hand given is not the one that the file describes.
    #[error(
        "hand `{given}` takes the place of hand `{told}` as the file describes it: contacts, labels and outcomes of \
         simulations are dropped, and measures are those of the latter"
    )]
    OtherHand {
        /// The name of the hand in the file.
        told: String,
        /// The name of the hand given.
        given: String,
    },
    /// A landscape written before checksums were kept.
    #[error(
        "{path} keeps no checksums of its tables, as folders of older versions do not: whether they belong together is not \
         checked"
    )]
    NoChecksums {
        /// The manifest.
        path: PathBuf,
    },
    /// The object given is not the one that the file describes.
    #[error(
        "object `{given}` takes the place of object `{told}` as the file describes it: labels and outcomes of simulations \
         are dropped, and measures are those of the latter"
    )]
    OtherObject {
        /// The name of the object in the file.
        told: String,
        /// The name of the object given.
        given: String,
    },
}
