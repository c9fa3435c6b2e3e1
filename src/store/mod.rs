//! Files on disk: Parquet tables, the manifest, the journal. Only this module uses arrow and parquet.
//!
//! * [`GraspFile`]: `grasps.parquet`, one row per grasp. Its columns are listed in [`grasps`].
//! * [`Overrides`]: hand and object that replace those of such a file.
//! * [`LandscapeFiles`]: the tables and the manifest of an `X.landscape/` folder.
//! * [`GraspFile::join`]: several such files as one.
//! * [`exchange`]: reading and writing of grasps in the formats of other programs.
//! * [`AtomicFolder`], [`write_atomic`]: a file or folder takes its final name only when it is complete.
//! * [`Journal`]: the finished tasks of a long run. It survives a kill at any moment.
//!
//! Equal content gives equal bytes: apart from [`Timings`] and the journals, which are removed at the end, this module
//! writes no time, host name or thread count. Callers
//! decide what a run means and which files it needs.

mod atomic;
mod attempts;
mod check;
mod columns;
mod error;
pub mod exchange;
pub mod grasps;
mod join;
mod journal;
mod landscape;
mod machine;
mod metadata;
mod network;
mod overrides;
mod population;
mod quaternion;
mod rebuild;
mod row;
mod stationary;
mod sum;
mod table;

pub use atomic::{AtomicFolder, FileSet, JOURNAL, write_atomic};
pub use attempts::{read_attempts, write_attempts};
pub(crate) use check::LIMIT_TOLERANCE_RAD;
pub use error::{Fault, StoreError, Warning};
pub use grasps::{GraspFile, GraspRow};
pub use join::{JoinError, JoinedFile};
pub use journal::Journal;
pub use landscape::{
    Counts, EdgeRow, LandscapeFiles, Manifest, MinimumRow, PathPoint, Phase, Timings,
};
pub use machine::Machine;
pub use metadata::{
    HandMetadata, Metadata, ObjectMetadata, SCHEMA_VERSION, Source, Step, TextFile, content_hash,
};
pub use overrides::Overrides;
pub use population::Population;
pub use rebuild::RebuildError;
pub use stationary::StationaryRow;
