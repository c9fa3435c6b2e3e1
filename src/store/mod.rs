//! Files on disk: Parquet tables, the manifest, the journal. The only place that names arrow and parquet.
//!
//! * [`GraspFile`]: `grasps.parquet`, one row a grasp; its columns are listed in [`grasps`].
//! * [`LandscapeFiles`]: the tables and the manifest of an `X.landscape/` folder.
//! * [`exchange`]: grasps of other programs, read and written.
//! * [`AtomicFolder`], [`write_atomic`]: a file or folder appears under its name only when it is complete.
//! * [`Journal`]: finished tasks of a long run, safe against being killed at any moment.
//!
//! Same content, same bytes: nothing here writes a time, a host name or a thread count, except [`Timings`], whose
//! purpose that is. What a run means and which files it wants belongs to the caller.

mod atomic;
mod check;
mod columns;
mod error;
pub mod exchange;
pub mod grasps;
mod journal;
mod landscape;
mod metadata;
mod network;
mod rebuild;
mod resampled;
mod row;
mod stationary;
mod sum;
mod table;

pub use atomic::{AtomicFolder, FileSet, JOURNAL, write_atomic};
pub use error::{Fault, StoreError, Warning};
pub use grasps::{GraspFile, GraspRow, Overrides, Population};
pub use journal::Journal;
pub use landscape::{
    Counts, EdgeRow, LandscapeFiles, Manifest, MinimumRow, PathRow, Phase, Source, Timings,
};
pub use metadata::{
    HandMetadata, Metadata, ObjectMetadata, SCHEMA_VERSION, Step, TextFile, content_hash,
};
pub use rebuild::RebuildError;
pub use resampled::{read_resampled, write_resampled};
pub use stationary::StationaryRow;
